"""Blocks that are not closed, closed twice or closed by the wrong word: IF, FOR, CASE, VAR, STRUCT, PROGRAM, ...

The parser stands at END_IF, ELSE, the end of the file or the like, and what is open does not match. Each explanation -
the innermost blocks lack their end, this word is one too many, it stands for another - is tried on the rest of the
text; the one under which most of it reads is told. Indentation then says which of several blocks lacks its end.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from stcore.lexer import KIND, NAME, TERMINALS, Tokens
from stcore.words import CLOSER_OF, CLOSERS, CLOSING, UNIT_STARTERS, distance, opener_of, text_for

if TYPE_CHECKING:
    from stcore.repair import Repairs

_FAR = 3000  # tokens of the rest that an explanation is tried on
_POUS = frozenset(KIND[n] for n in ("PROGRAM", "FUNCTION", "FUNCTION_BLOCK"))
_ELSE, _ELSIF, _UNTIL, _VAR, _IF = (KIND[n] for n in ("ELSE", "ELSIF", "UNTIL", "VAR", "IF"))


def repair(r: Repairs, at: int) -> int | None:
    """Handle a block that does not match at token `at`; the token to go on from, or None when that is not the case."""
    kind = r.tokens.kinds[at]
    if kind == _VAR and r.machine.states[-1] in r.anchors.statement:
        return _late_section(r, at)
    if kind not in CLOSING and kind not in UNIT_STARTERS and kind != 0:
        return None
    blocks = r.open_blocks()
    closers = _closers(r, at, blocks)
    between = r.machine.states[-1] in r.anchors.any or r.reads(len(r.machine.values), (_IF,), at, at) == at
    if not between and not closers:
        return None
    r.settled = -1  # blocks don't go wrong because of a slip shortly before
    if r.lost.get(kind) or (kind in (_ELSE, _ELSIF) and r.lost.get(KIND["END_IF"])):
        return _end_of_lost(r, at)
    if blocks and (after := _misspelt_end(r, at, blocks[-1])) is not None:
        return after
    stray_end = _stray_end(r, at)
    choices = []
    lost_opener = _lost_opener(r, at)
    if lost_opener:
        choices.append((r.reads(*lost_opener[:3], at + _FAR), 1, "open"))
    if closers:
        choices.append((_reach(r, closers, at, at), 2, "close"))
    if kind in CLOSING:
        choices.append((_reach(r, [], stray_end, at), 1, "drop"))
        if blocks and kind not in (_ELSE, _ELSIF, _UNTIL):
            ends = [CLOSER_OF[r.tokens.kinds[blocks[-1][1]]]]
            choices.append((_reach(r, ends, at + 1, at), 0, "swap"))
    if not choices:
        return None
    match max(choices)[2]:
        case "close":
            return _close(r, at, blocks, closers)
        case "open":
            return _open(r, at, *lost_opener)
        case "drop":
            return _drop(r, at, stray_end)
    return _swap(r, at, blocks[-1][1])


def _reach(r: Repairs, edit: list[int], upto: int, at: int) -> int:
    return r.reads(len(r.machine.values), tuple(edit), upto, at + _FAR)


def _closers(r: Repairs, at: int, blocks: list[tuple[int, int]]) -> list[int]:
    """What is missing before `at` so that it fits: the ends of the blocks inside the one it belongs to."""
    closers: list[int] = []
    for _, opener in reversed(blocks):
        kind = r.tokens.kinds[opener]
        if kind == KIND["REPEAT"]:
            closers += [_UNTIL, KIND["BOOLEAN"]]
        closers.append(CLOSER_OF[kind])
        if _reach(r, closers, at, at) > at:
            return closers
    return []


# ----------------------------------------------------------------------------------------------- explanations


def _close(r: Repairs, at: int, blocks: list[tuple[int, int]], closers: list[int]) -> int:
    """Put the missing ends in, and say for each block that it has none."""
    tokens = r.tokens
    entry, opener = blocks[-1]
    if (token := _else_if(r, opener, at)) is not None:
        r.report("E0125", token, token + 2)
        tokens.replace(token, token + 2, _ELSIF, "ELSIF")
        r.cut(entry)
        return opener
    for _, opener in reversed(blocks[len(blocks) - sum(c != _UNTIL and c != KIND["BOOLEAN"] for c in closers) :]):
        _tell_unclosed(r, at, opener)
    for closer in reversed(closers):
        tokens.insert(at, closer, text_for(closer))
    r.settled = at + len(closers)
    return at


def _tell_unclosed(r: Repairs, at: int, opener: int) -> None:
    tokens = r.tokens
    if tokens.kinds[opener] not in _POUS:
        blamed = _unclosed(r, at, opener)
        r.report("E0103", blamed, blamed + 1, **r.block_fields(blamed))
    elif not r.reads_program:
        closer = CLOSERS[TERMINALS[tokens.kinds[opener]]]
        if r.machine.mend:
            r.report_gap("W0107", at, closer=closer)
        else:
            r.report("E0103", opener, opener + 1, **r.block_fields(opener))


def _unclosed(r: Repairs, at: int, opener: int) -> int:
    """Of the blocks of one kind, the one that lacks its end: an end less indented than its block was another's."""
    tokens, kinds = r.tokens, r.tokens.kinds
    kind = kinds[opener]
    inside: list[tuple[int, int]] = []
    for token in range(opener, at):
        if kinds[token] in CLOSER_OF:
            column = _column(tokens, token) if tokens.starts_line(token) else 0
            inside.append((token, column))
        elif inside and kinds[token] == CLOSER_OF[kinds[inside[-1][0]]]:
            block, column = inside.pop()
            if column and kinds[block] == kind and tokens.starts_line(token):
                if _column(tokens, token) < column:
                    return block
    return opener


def _else_if(r: Repairs, opener: int, at: int) -> int | None:
    """The ELSE of an ELSE IF, in the IF that lacks its end, that ELSIF was meant by: one END_IF ends both."""
    tokens, kinds = r.tokens, r.tokens.kinds
    end_if = KIND["END_IF"]
    if kinds[opener] != _IF:
        return None
    inside: list[int] = []
    for token in range(opener, at):
        if kinds[token] == _IF:
            inside.append(token)
        elif kinds[token] == end_if and inside:
            nested = inside.pop()
            if len(inside) == 1 and _is_else_if(tokens, nested):
                apart = tokens.starts_line(token) and _column(tokens, token) > _column(tokens, opener)
                if not apart:
                    return nested - 1
    nested = inside[-1] if len(inside) > 1 else opener
    return nested - 1 if nested > opener and _is_else_if(tokens, nested) else None


def _is_else_if(tokens: Tokens, token: int) -> bool:
    return tokens.kinds[token - 1] == _ELSE and not tokens.starts_line(token)


def _column(tokens: Tokens, token: int) -> int:
    return tokens.source.position(tokens.starts[token])[1]


def _misspelt_end(r: Repairs, at: int, block: tuple[int, int]) -> int | None:
    """END_FI; reads like the call of a block named END_FI, until the END_IF is missed."""
    tokens, kinds = r.tokens, r.tokens.kinds
    entry, opener = block
    closer = TERMINALS[CLOSER_OF[kinds[opener]]]
    for token in range(at - 1, opener, -1):
        if kinds[token] != NAME or tokens.texts[token][0] not in "Ee":
            continue
        alone = kinds[token + 1] == KIND["SEMI"] or tokens.starts_line(token + 1) or token + 1 == at
        if alone and tokens.starts_line(token) | (kinds[token - 1] == KIND["SEMI"]):
            if distance(tokens.texts[token].upper(), closer, 2) <= 2:
                r.report("E0115", token, token + 1, found=tokens.texts[token], keyword=closer)
                kinds[token], tokens.texts[token] = KIND[closer], closer
                r.cut(entry)
                return opener
    return None


def _stray_end(r: Repairs, at: int) -> int:
    """Where a closing word with what belongs to it ends: ELSIF condition THEN, UNTIL condition END_REPEAT."""
    kinds = r.tokens.kinds
    until = {_ELSIF: KIND["THEN"], _UNTIL: KIND["END_REPEAT"]}.get(kinds[at])
    if until is not None:
        for token in range(at + 1, min(at + 60, len(kinds))):
            if kinds[token] == until:
                return token + 1
            if kinds[token] == KIND["SEMI"]:
                break
    return at + 1


def _lost_opener(r: Repairs, at: int) -> tuple[int, tuple[int, ...], int] | None:
    """Declarations read as labels up to END_VAR: where their VAR was lost, as (entries kept, edit, token)."""
    depth = len(r.machine.values) - 1
    if r.tokens.kinds[at] != KIND["END_VAR"] or depth < 0:
        return None
    first = r.machine.firsts[depth]
    depth = r.depth_of(first)
    return (depth, (_VAR,), first) if depth is not None else None


def _open(r: Repairs, at: int, depth: int, edit: tuple[int, ...], token: int) -> int:
    r.report_gap("E0102", token, what="VAR", where=f"before {r.tokens.texts[token]}")
    r.tokens.insert(token, _VAR, "VAR")
    r.cut(depth)
    r.settled = at + 1
    return token


def _drop(r: Repairs, at: int, upto: int) -> int:
    tokens = r.tokens
    word = tokens.texts[at].upper()
    r.report("E0104", at, at + 1, closer=word, opener=opener_of(tokens.kinds[at]))
    tokens.delete(at, upto)
    r.settled = at
    return at


def _swap(r: Repairs, at: int, opener: int) -> int:
    """FOR ... END_IF: the wrong end."""
    tokens = r.tokens
    closer = CLOSERS[TERMINALS[tokens.kinds[opener]]]
    r.report("E0115", at, at + 1, found=tokens.texts[at], keyword=closer)
    tokens.kinds[at], tokens.texts[at] = KIND[closer], closer
    return at


def _end_of_lost(r: Repairs, at: int) -> int:
    """The end of a block whose beginning was skipped with an error: nothing more to say."""
    kind = r.tokens.kinds[at]
    if kind not in (_ELSE, _ELSIF):
        r.lost[kind] -= 1
    r.tokens.delete(at, _stray_end(r, at))
    return at


def _late_section(r: Repairs, at: int) -> int | None:
    """VAR ... END_VAR after the first statement."""
    kinds = r.tokens.kinds
    end = at
    while kinds[end] not in (KIND["END_VAR"], 0):
        end += 1
    if kinds[end] == 0:
        return None
    r.report("E0126", at, at + 1, what=r.tokens.texts[at].upper())
    r.tokens.delete(at, end + 1)
    return at

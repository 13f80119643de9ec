"""What printed listings have and ST has not, read as it was meant, with a warning for each.

Manual listings were typeset, scanned and copied. Quotes and full-width signs are mended by the lexer, `=` and `:` for
`:=` in a statement by the grammar; here are the rules that act where the parser stands at a token that cannot follow.
Each rule looks at the tokens around, makes one change that can mean one thing only, and gives the token to go on from;
None when it does not apply. What is ambiguous is left to stcore/repair.py and is an error.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from stcore import syntax as s
from stcore.lexer import END_KINDS, KIND, NAME, WORDS, Tokens
from stcore.repair_search import Change, Search
from stcore.words import CLOSER_OF, CLOSING, UNIT_STARTERS, near_keywords

if TYPE_CHECKING:
    from stcore.repair import Repairs

_SEMI, _COLON, _COMMA, _DOT, _LPAR = (KIND[n] for n in ("SEMI", "COLON", "COMMA", "DOT", "LPAR"))
_ASSIGN, _ARROW, _EQ, _AT, _VAR = (KIND[n] for n in ("ASSIGN", "ARROW", "EQ", "AT", "VAR"))
_STATEMENT_STARTERS = frozenset(
    KIND[n] for n in ("NAME", "ADDRESS", "VAR", "IF", "CASE", "FOR", "WHILE", "REPEAT", "RETURN", "EXIT", "JMP")
)
_TYPE_STARTERS = frozenset(KIND[n] for n in ("NAME", "STRING", "ARRAY", "POINTER", "REFERENCE", "STRUCT", "LPAR"))
_PREFIXES = ("GT", "MC", "SMC")  # their underscore is often lost in print
_PAGE = re.compile(r"\s*(?:\d{1,4}|[-–—][ \t]*\d{1,4}[ \t]*[-–—]|\d{1,4}[ \t]*/[ \t]*\d{1,4})\s*")
_TRUSTED = 5  # tokens that must read on after a mend


def split(tokens: Tokens, token: int, keyword: str) -> None:
    """Make two tokens of one that `words.glued` recognised."""
    rest = tokens.texts[token][len(keyword) :]
    end = tokens.ends[token]
    offset = end - len(rest)
    tokens.kinds[token], tokens.texts[token], tokens.ends[token] = WORDS[keyword], keyword, offset
    tokens.insert(token + 1, WORDS.get(rest.upper(), NAME), rest, offset)
    tokens.ends[token + 1] = end


def lost_semicolon(r: Repairs, at: int) -> int | None:
    """`AXIS:INT:=1` at the end of a line."""
    tokens = r.tokens
    if at == 0 or not (tokens.kinds[at] == 0 or tokens.starts_line(at)):
        return None
    if r.machine.states[-1] in r.anchors.any or tokens.kinds[at - 1] in END_KINDS:
        return None  # nothing there that it could end
    if tokens.kinds[at - 1] == NAME and tokens.starts_line(at - 1) and near_keywords(tokens.texts[at - 1]):
        return None  # VAR_INPT alone on its line is no call
    # where a block ends, it may end wrongly for reasons of its own
    kind = tokens.kinds[at]
    enough = at if kind == 0 or kind in CLOSING or kind in UNIT_STARTERS else min(at + _TRUSTED, len(tokens.kinds))
    if r.reads(len(r.machine.values), (_SEMI,), at, at + _TRUSTED) < enough:
        return None
    if not r.prompt:
        r.report_gap("W0104", at)
    tokens.insert(at, _SEMI, ";")
    return at


def equals_sign(r: Repairs, at: int) -> int | None:
    """`FOR i = 0 TO 9`, `x : INT = 5`: `=` where only := can stand."""
    tokens = r.tokens
    if tokens.kinds[at] != _EQ or r.reads(len(r.machine.values), (_ASSIGN,), at + 1, at + 4) < at + 4:
        return None
    r.report("W0102", at, at + 1)
    tokens.kinds[at], tokens.texts[at] = _ASSIGN, ":="
    return at


def colon_for_assign(r: Repairs, at: int) -> int | None:
    """`x : 5;` in a body was read as a label so far."""
    tokens, values = r.tokens, r.machine.values
    if at < 2 or tokens.kinds[at - 1] != _COLON or not values or not isinstance(values[-1], list):
        return None
    statements = values[-1]
    if not statements or type(statements[-1]) is not s.Label or statements[-1].end != tokens.ends[at - 1]:
        return None
    if r.reads(len(values), (NAME, _ASSIGN), at, at + 2) < at + 2:
        return None
    statements.pop()
    r.report("W0103", at - 1, at, name=tokens.texts[at - 2])
    tokens.kinds[at - 1], tokens.texts[at - 1] = _ASSIGN, ":="
    return at - 2


def lost_comma(r: Repairs, at: int) -> int | None:
    """`Axis:=` or `Axis:= a` at the end of a line, `PersistentData:= ,` on the next."""
    tokens, kinds = r.tokens, r.tokens.kinds
    name = at if kinds[at] == NAME else at - 1  # an empty argument took the next one's name for its value
    if name < 2 or kinds[name] != NAME or kinds[name + 1] not in (_ASSIGN, _ARROW) or not tokens.starts_line(name):
        return None
    depth = len(r.machine.values) if name == at else r.depth_of(name)
    if depth is None or r.reads(depth, (_COMMA,), name, name + 2) < name + 2:
        return None
    r.report_gap("W0114", name)
    tokens.insert(name, _COMMA, ",")
    r.cut(depth)
    return name


def blank_in_name(r: Repairs, at: int) -> int | None:
    """`FOLLOW_SEGMENT_ CONTINUE`, `GT LnXY`, `END TYPE`."""
    tokens, kinds = r.tokens, r.tokens.kinds
    for left in (at - 1, at, at - 2):
        if left < 0 or left + 1 >= len(kinds) - 1:
            continue
        between = tokens.source.text[tokens.ends[left] : tokens.starts[left + 1]]
        plain = _joined(tokens.texts[left], tokens.texts[left + 1], tokens.texts)
        if not plain or not between or between.strip(" \t\xa0\u200b\u3000\u2009"):
            continue
        kind = WORDS.get(plain.upper(), NAME)
        depth = r.depth_of(left) if left < at else len(r.machine.values)
        if depth is not None and r.reads(depth, (kind,), left + 2, at + 4) >= min(at + 4, len(kinds)):
            text = tokens.source.text[tokens.starts[left] : tokens.ends[left + 1]]
            r.report("W0109", left, left + 2, text=text, plain=plain)
            tokens.replace(left, left + 2, kind, plain)
            r.cut(depth)
            return left
    return None


def _joined(left: str, right: str, texts: list[str]) -> str:
    """The name that two words were, or ''. texts: of all tokens; a name that stands elsewhere is known."""
    if not re.match(r"[^\W\d]", left) or not re.match(r"\w", right):
        return ""
    if left.endswith("_"):
        return left + right
    if left.upper() in _PREFIXES or f"{left}_{right}".upper() in WORDS:
        return f"{left}_{right}"
    return left + right if left + right in texts and texts.count(left) == 1 else ""


def bare_program(r: Repairs, at: int) -> int | None:
    """Declarations and statements with no PROGRAM around them become PROGRAM PLC_PRG, once a file."""
    tokens, kinds = r.tokens, r.tokens.kinds
    if r.machine.states[-1] not in r.anchors.unit or kinds[at] not in _STATEMENT_STARTERS:
        return None
    units = r.machine.values[-1] if r.machine.values else []
    if r.reads_program or any(isinstance(u, s.Pou) and u.kind == "PROGRAM" for u in units):
        return None
    change = Search(r, at).best()
    if change is not None and change.score > 12 and _only_head_missing(change, kinds, at):
        return None
    r.reads_program = True
    r.report("W0108", at, at + 1)
    declared = at if kinds[at] == _VAR else _declarations_end(tokens, at)
    if declared > at:
        tokens.insert(declared, KIND["END_VAR"], "END_VAR")
        tokens.insert(at, _VAR, "VAR")
    tokens.insert(at, NAME, "PLC_PRG")
    tokens.insert(at, KIND["PROGRAM"], "PROGRAM", tokens.ends[at - 1] if at else 0)
    return at


def _only_head_missing(change: Change, kinds: list[int], at: int) -> bool:
    """PROGRM x, or `x VAR ... END_PROGRAM` without its first word: a slip, no fragment."""
    if change.action == "keyword":
        return True
    if change.action != "insert" or kinds[at] != NAME or change.at != at:
        return False
    opener = change.kinds[0]
    for kind in kinds[at:]:
        if kind == CLOSER_OF.get(opener):
            return True
        if kind == opener:
            return False
    return False


def _declarations_end(tokens: Tokens, at: int) -> int:
    """The first token after `a, b : INT; c : BOOL := TRUE;` that begins no such declaration."""
    kinds = tokens.kinds
    while True:
        token = at
        while kinds[token] == NAME and kinds[token + 1] in (_COMMA, _DOT):
            token += 2  # a dot is wrong there, but still no statement
        if kinds[token] != NAME:
            return at
        token += 3 if kinds[token + 1] == _AT else 1
        if kinds[token] != _COLON or kinds[token + 1] not in _TYPE_STARTERS:
            return at
        if kinds[token + 1] == NAME and kinds[token + 2] == _LPAR:
            return at  # rtn:GT_Reset(); has lost the = of its :=
        while kinds[token] not in (_SEMI, 0):
            token += 1
        while kinds[token] == _SEMI:
            token += 1
        at = token


def page_number(r: Repairs, at: int) -> int | None:
    """`128` or `- 34 -` alone on a line, from the foot of a page."""
    tokens = r.tokens
    near = [at, at - 1, at - 2]  # it may have been read as a number in what follows
    number = next((n for n in (tokens.line(i) for i in near if i >= 0) if _PAGE.fullmatch(tokens.source.line(n))), 0)
    if not number:
        return None
    first = at
    while first and tokens.line(first - 1) >= number:
        first -= 1
    last = first
    while tokens.kinds[last] and tokens.line(last) == number:
        last += 1
    depth = len(r.machine.values) if first == at else r.depth_of(first)
    if depth is None or r.reads(depth, (), last, at + 2) < min(at + 2, len(tokens.kinds)):
        return None
    text = tokens.source.line(number).strip()
    r.report("W0105", first, last, text=text)
    r.cut(depth)
    tokens.delete(first, last)
    return first


RULES = (page_number, bare_program, lost_comma, blank_in_name, equals_sign, colon_for_assign, lost_semicolon)

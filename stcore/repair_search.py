"""The smallest change of one token that lets the parser go on.

The stack of states is a notebook here: on copies of it, without making nodes, every change is tried - put a token in,
take one out, read one as another - at the token that cannot follow and at the tokens that began what is still
unfinished. The change that leads furthest at the lowest cost wins.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from stcore.lexer import END_KINDS, KIND, NAME, WORDS
from stcore.words import CLOSER_OF, CLOSING, UNIT_STARTERS, glued, keyword_kind, near_keywords

if TYPE_CHECKING:
    from stcore.repair import Repairs

LOOK = 14  # tokens that a change has to lead over to be trusted fully
_ENOUGH = 3  # tokens that it has to lead over at least
_REST = 8_000  # tokens in which the other half of a block is looked for

# what putting a token in costs; the likelier a slip, the cheaper
_INSERT = {
    "THEN": 0.8, "DO": 0.8, "OF": 0.8, "TO": 0.8, "SEMI": 1.2, "RPAR": 1.0, "RBRACKET": 1.0, "COLON": 1.2,
    "ASSIGN": 1.2, "UNTIL": 1.4, "LPAR": 1.5, "LBRACKET": 1.5, "COMMA": 1.15, "NUMBER": 1.6, "NAME": 1.7,
    "BINOP": 1.8, "DOTDOT": 1.4, "ARRAY": 1.4, "DOT": 2.0, "ELSIF": 2.2, "ELSE": 2.2, "POINTER": 2.0, "BY": 2.0,
    "ON": 1.5, "TASK": 1.8,
    # the beginnings of blocks, only where an end waits for one
    "IF": 0.5, "FOR": 0.6, "WHILE": 0.7, "CASE": 0.6, "REPEAT": 0.9, "VAR": 0.5, "STRUCT": 0.7, "TYPE": 0.7,
    "PROGRAM": 0.6, "FUNCTION": 0.8, "FUNCTION_BLOCK": 0.8, "VAR_GLOBAL": 0.8, "UNION": 0.9, "ACTION": 0.9,
    "METHOD": 0.9, "PROPERTY": 0.9, "INTERFACE": 0.9, "GET": 0.9, "SET": 0.9,
    "RESOURCE": 1.0, "CONFIGURATION": 1.0,
}  # fmt: skip
_INSERT_COSTS = {KIND[n]: cost for n, cost in _INSERT.items() if n in KIND}
_INSERT_COSTS |= dict.fromkeys(CLOSER_OF.values(), 0.6)
_BLOCK_WORDS = CLOSER_OF.keys() | set(CLOSER_OF.values())

_SIGNS = frozenset(
    KIND[n] for n in (
        "ASSIGN", "SETOP", "ARROW", "EQ", "SIGN", "BINOP", "COLON", "SEMI", "COMMA", "DOT", "DOTDOT", "CARET", "HASH",
        "LPAR", "RPAR", "LBRACKET", "RBRACKET",
    )
)  # fmt: skip
_DELETE = dict.fromkeys(_SIGNS, 1.8) | {KIND["RPAR"]: 1.4, KIND["RBRACKET"]: 1.4}
_LINKS = frozenset(KIND[n] for n in ("THEN", "DO", "OF", "TO", "BY"))
_WORD_KINDS = frozenset(WORDS.values())
_POU_ENDS = [KIND[n] for n in ("END_PROGRAM", "END_FUNCTION", "END_FUNCTION_BLOCK", "$END")]
_OUTER = frozenset(
    KIND[n] for n in (
        "PROGRAM", "FUNCTION", "FUNCTION_BLOCK", "TYPE", "VAR_GLOBAL", "RESOURCE", "CONFIGURATION", "INTERFACE",
    )
)
_ENDINGS = CLOSING | UNIT_STARTERS | {0}
_SECTION_STARTERS = frozenset(KIND[n] for n in ("VAR", "VAR_GLOBAL", "TYPE", "STRUCT"))


class Change(NamedTuple):
    """A repair: before entry `depth` of the stack, tokens at..upto-1 are read as `kinds`."""

    score: float
    action: str  # insert, delete, keyword, replace, reserved, split
    depth: int
    at: int
    upto: int
    kinds: tuple[int, ...]
    keyword: str = ""


class Search:
    """The search for one error, at token `at`."""

    def __init__(self, repairs: Repairs, at: int) -> None:
        self.repairs = repairs
        self.tokens = repairs.tokens
        self.at = at
        self._spare: dict[int, int] = {}  # ends without a block, by kind

    def best(self) -> Change | None:
        """The best change of one token, or None when none leads over the next few tokens."""
        best = None
        for depth, token, penalty in self._places():
            for change in self._changes(depth, token, penalty):
                if change is not None and (best is None or change.score > best.score):
                    best = change
        return best

    def _places(self) -> list[tuple[int, int, float]]:
        """Where a change may help: (entries kept, token, penalty). First the error itself, then what is unfinished."""
        at, firsts = self.at, self.repairs.machine.firsts
        top = len(firsts)
        places = [(top, at, 0.0)]
        lowest: dict[int, int] = {}
        anchor = self.repairs.anchor()
        for entry in range(top - 1, anchor, -1):
            lowest[firsts[entry]] = entry
        if anchor >= 0 and at - firsts[anchor] < 300:
            lowest[firsts[anchor]] = anchor
            while lowest[firsts[anchor]] and firsts[lowest[firsts[anchor]] - 1] == firsts[anchor]:
                lowest[firsts[anchor]] -= 1
        nearest = list(lowest.items())
        for number, (token, entry) in enumerate(nearest):
            if number < 6 or number >= len(nearest) - 2:
                places.append((entry, token, 0.3 * min(number + 1, 6) if token != at else 0.1))
        return places

    def _changes(self, depth: int, token: int, penalty: float) -> Iterator[Change | None]:
        """The changes at a token, scored; None for one that does not lead far enough."""
        at, tokens, kinds = self.at, self.tokens, self.tokens.kinds
        kind, row = kinds[token], self.repairs.row(depth)
        far = at - token > 30

        def scored(action: str, edit: tuple[int, ...], upto: int, cost: float, keyword: str = ""):
            reached = self.repairs.reads(depth, edit, upto, at + LOOK)
            if reached >= len(kinds) or reached >= at + LOOK:
                score = LOOK - cost - penalty
            elif reached > at and kinds[reached] in _ENDINGS:
                score = LOOK - cost - penalty - 0.5  # that a block ends wrongly there is another matter
            elif reached - at >= _ENOUGH:
                score = reached - at - cost - penalty - 3
            else:
                return None
            return Change(score, action, depth, token, upto, edit, keyword)

        for inserted in row:
            cost = _INSERT_COSTS.get(inserted)
            if cost is not None and (inserted in _SECTION_STARTERS or not far):
                change = scored("insert", (inserted,), token, cost + self._unlikely(inserted, token))
                yield change if change and self._lacks_half(inserted) else None
        if far or kind == 0:
            return
        again = token and kinds[token - 1] == kind and tokens.texts[token - 1].upper() == tokens.texts[token].upper()
        yield scored("delete", (), token + 1, 0.3 if again else _DELETE.get(kind, 1.9))
        if kind == NAME:
            for keyword, away in near_keywords(tokens.texts[token])[:6]:
                wanted = keyword_kind(keyword)
                cost = 0.4 * away + (0.6 if len(keyword) < 4 else 0.0)
                change = scored("keyword", (wanted,), token + 1, cost, keyword)
                if change and wanted in _BLOCK_WORDS:  # what has lost its other half is what was meant
                    change = change._replace(score=change.score + (0.8 if self._lacks_half(wanted) else -0.5))
                yield change
            if split := glued(tokens.texts[token]):
                yield scored("split", (keyword_kind(split), NAME), token + 1, 0.5, split)
        elif kind in _SIGNS or kind in _LINKS:
            for other in row.keys() & (_SIGNS if kind in _SIGNS else _LINKS):
                yield scored("replace", (other,), token + 1, 1.7)
        if kind in _WORD_KINDS and NAME in row:
            yield scored("reserved", (NAME,), token + 1, 1.5)

    def _lacks_half(self, word: int) -> bool:
        """Whether a word that begins or ends a block would find its other half alone; True for any other word."""
        if word not in _BLOCK_WORDS:
            return True
        opens = word in CLOSER_OF
        closer = CLOSER_OF[word] if opens else word
        if closer not in self._spare:
            self._spare[closer] = self._count_spare(closer)
        return self._spare[closer] > 0 if opens else self._spare[closer] < 0

    def _count_spare(self, closer: int) -> int:
        """How many more ends of a kind than blocks that need one: what is open now and what the rest of the POU has."""
        kinds = self.tokens.kinds
        openers = [k for k, c in CLOSER_OF.items() if c == closer]
        rest = kinds[self.at : self.at + _REST]
        if not _OUTER & {*openers}:
            stop = min((rest.index(k) for k in _POU_ENDS if k in rest), default=len(rest))
            rest = rest[:stop]
        open_now = sum(CLOSER_OF[kinds[t]] == closer for _, t in self.repairs.open_blocks())
        return rest.count(closer) - sum(rest.count(k) for k in openers) - open_now

    def _unlikely(self, kind: int, token: int) -> float:
        """A semicolon is forgotten at the end of a line rather than within one, an operator the other way round; after
        a complete statement it is no repair."""
        starts_line = self.tokens.starts_line(token)
        if self.repairs.after_junk(token):  # most likely it stands for a sign
            return -1.2 if kind == KIND["BINOP"] else 0.0
        if kind == KIND["SEMI"]:
            if token and self.tokens.kinds[token - 1] in END_KINDS | {kind}:
                return LOOK
            return 0.0 if starts_line else 0.7
        if kind == KIND["COMMA"] and self._lost_its_assign(token):
            return 0.2
        return 0.6 if kind == KIND["BINOP"] and starts_line else 0.0

    def _lost_its_assign(self, token: int) -> bool:
        """f(Axis drive, Enable := TRUE): a name begins an argument and the others there are named."""
        kinds, begins = self.tokens.kinds, (KIND["LPAR"], KIND["COMMA"])
        if token < 2 or kinds[token - 1] != NAME or kinds[token - 2] not in begins:
            return False
        near = range(max(token - 12, 2), min(token + 12, len(kinds)))
        named = [i for i in near if kinds[i] == KIND["ASSIGN"] and kinds[i - 1] == NAME and kinds[i - 2] in begins]
        return bool(named)

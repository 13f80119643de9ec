"""Syntax errors: the smallest change that lets the parser go on, said in the user's words.

The parser stands at a token that cannot follow. Here the stack of states is a notebook: on copies of it, without
making nodes, every change of one token is tried - put one in, take one out, read one as another - at the token itself
and at the tokens that began what is still unfinished. The change that leads furthest at the lowest cost wins, is
reported once and made in the list of tokens. Blocks that are not closed, or closed twice, are judged by how far the
rest of the file then reads (stcore/blocks.py). What nothing repairs is skipped up to the next statement.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from stcore import blocks, mend, tables
from stcore.lexer import END_KINDS, KIND, NAME, TERMINALS, WORDS
from stcore.words import CLOSER_OF, CLOSERS, CLOSING, UNIT_STARTERS, keyword_kind, near_keywords, text_for, word

if TYPE_CHECKING:
    from stcore.parser import Machine

LOOK = 14  # tokens that a repair has to lead over to be trusted fully
ENOUGH = 3  # tokens that it has to lead over at least
MAX_REPAIRS = 200  # of one file; after that it is something else than ST
_REST = 8_000  # tokens in which the other half of a block is looked for
_SETTLED = 3  # tokens read since the last error, before the next one is its own

# a state before one of these lists, or in it, is where reading can begin again
_LISTS = ("statement", "declaration", "unit", "section", "type_declaration", "config_item", "case")

# what putting a token in costs; the likelier a slip, the cheaper
_INSERT = {
    "THEN": 0.8, "DO": 0.8, "OF": 0.8, "TO": 0.8, "SEMI": 1.2, "RPAR": 1.0, "RBRACKET": 1.0, "COLON": 1.2, "ASSIGN": 1.2,
    "UNTIL": 1.4, "LPAR": 1.3, "LBRACKET": 1.3,
    "COMMA": 1.15, "NUMBER": 1.6, "NAME": 1.7, "BINOP": 1.8, "DOTDOT": 1.4, "ARRAY": 1.4, "DOT": 2.0, "ELSIF": 2.2,
    "ELSE": 2.2, "POINTER": 2.0, "BY": 2.0, "ON": 1.5, "TASK": 1.8,
    # the beginnings of blocks, only where an end waits for one
    "IF": 0.5, "FOR": 0.6, "WHILE": 0.7, "CASE": 0.6, "REPEAT": 0.9, "VAR": 0.5, "STRUCT": 0.7, "TYPE": 0.7,
    "PROGRAM": 0.6, "FUNCTION": 0.8, "FUNCTION_BLOCK": 0.8, "VAR_GLOBAL": 0.8, "UNION": 0.9, "ACTION": 0.9,
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
_LINKS = frozenset(KIND[n] for n in ("THEN", "DO", "OF", "TO", "BY"))
_WORD_KINDS = frozenset(WORDS.values())
_POU_ENDS = [KIND[n] for n in ("END_PROGRAM", "END_FUNCTION", "END_FUNCTION_BLOCK", "$END")]
_OUTER = frozenset(
    KIND[n] for n in ("PROGRAM", "FUNCTION", "FUNCTION_BLOCK", "TYPE", "VAR_GLOBAL", "RESOURCE", "CONFIGURATION")
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


class Repairs:
    """The repairs of one parse."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.tokens = machine.tokens
        self.table = machine.table
        self.count = 0
        self.settled = -1  # an error before this token only follows from the last one
        self.panics: set[int] = set()
        self._spare: dict[int, int] = {}
        self.lost: dict[int, int] = {}  # closers whose opener was skipped
        self.reads_program = False  # statements stood alone: their END_PROGRAM is not missed
        self.prompt = machine.prompt  # what was typed at a prompt needs no semicolon at its end
        names = self.table.nonterminals
        numbers = {i for i, name in enumerate(names) if name.removesuffix("s") in _LISTS}
        self.anchors = {i for i, row in enumerate(self.table.gotos) if numbers & row.keys()}
        statement = names.index("statement")
        self.statement_anchors = {i for i, row in enumerate(self.table.gotos) if statement in row}
        units = {names.index("unit"), names.index("units")}
        self.unit_anchors = {i for i, row in enumerate(self.table.gotos) if units & row.keys()}

    # -------------------------------------------------------------------------------------------------- entry

    def repair(self, at: int) -> int:
        """Mend or repair; the token to go on from, or -1 when it is hopeless."""
        self.count += 1
        if self.count > MAX_REPAIRS:
            self.report("E0127", at, at + 1)
            return -1
        if self.machine.mend:
            for rule in mend.RULES:
                if (after := rule(self, at)) is not None:
                    return after
        if (after := blocks.repair(self, at)) is not None:
            return after
        change = self.search(at)
        if change is None:
            return self.panic(at)
        return self.apply(change, at)

    def too_deep(self, at: int) -> int:
        """Brackets or blocks in each other beyond what the rest of the compiler follows."""
        at = min(at, len(self.tokens.kinds) - 1)
        self.report("E0113", at, at + 1)
        return -1

    def report(self, code: str, first: int, last: int, **fields) -> None:
        """An error or warning at the tokens first..last-1."""
        tokens = self.tokens
        if code[0] == "E" and (first < self.settled or self._junk_line(first)) and code != "E0127":
            return
        start = tokens.starts[first]
        end = max(tokens.ends[last - 1], start + 1)
        if tokens.kinds[first] == 0 and first:  # the end of the file has no text: point at what stands last
            start, end = tokens.starts[first - 1], tokens.ends[first - 1]
        self.machine.context.report(code, start, end, **fields)

    def found(self, token: int) -> str:
        """A token as a message shows it."""
        text = self.tokens.texts[token] or word(0)
        return text if len(text) <= 40 else f"{text[:37]}..."

    def report_gap(self, code: str, at: int, **fields) -> None:
        """An error or warning between the token before `at` and `at`."""
        if code[0] == "E" and (at < self.settled or self._junk_line(at)):
            return
        offset = self.tokens.ends[at - 1] if at else 0
        self.machine.context.report(code, offset, offset + 1, **fields)

    # ---------------------------------------------------------------------------------------------- the stack

    def cut(self, depth: int) -> None:
        """Forget what was read from entry `depth` of the stack on."""
        machine = self.machine
        del machine.states[depth + 1 :], machine.values[depth:], machine.firsts[depth:]

    def depth_of(self, token: int) -> int | None:
        """The lowest entry that begins with a token, if one does."""
        depth = None
        for entry in range(len(self.machine.firsts) - 1, -1, -1):
            first = self.machine.firsts[entry]
            if first == token:
                depth = entry
            elif first < token:
                break
        return depth

    def anchor(self) -> int:
        """The innermost entry that is a list of statements, declarations, ...; -1 for the bottom of the stack."""
        states = self.machine.states
        for entry in range(len(states) - 2, -1, -1):
            if states[entry + 1] in self.anchors:
                return entry
        return -1

    def open_blocks(self) -> list[tuple[int, int]]:
        """(entry, token) of every block begun and not closed, the innermost last."""
        kinds = self.tokens.kinds
        blocks: list[tuple[int, int]] = []
        for entry, value in enumerate(self.machine.values):
            if type(value) is int:
                if kinds[value] in CLOSER_OF:
                    blocks.append((entry, value))
                elif blocks and kinds[value] == CLOSER_OF[kinds[blocks[-1][1]]]:
                    blocks.pop()  # read to its end, only not yet made into a node
        return blocks

    def reads(self, depth: int, edit: tuple[int, ...], at: int, limit: int) -> int:
        """How far it reads from a stack cut to `depth`, with `edit` put before token `at`: the first token that does
        not fit, `limit` at most. -1 when not even the edit fits."""
        rows, gotos, lengths, origins = self.table.rows, self.table.gotos, self.table.lengths, self.table.origins
        states = self.machine.states[: depth + 1]
        kinds = self.tokens.kinds
        pending = len(edit)
        end = min(limit, len(kinds))
        position = at - pending
        while position < end:
            kind = kinds[position] if position >= at else edit[position - at]
            action = rows[states[-1]].get(kind)
            if action is None:
                return position if position >= at else -1
            if action >= 0:
                states.append(action)
                position += 1
                continue
            if action <= -tables.SHIFT_REDUCE:
                states.append(-1)
                position += 1
                rule = -action - tables.SHIFT_REDUCE
            else:
                rule = ~action
            while True:
                if lengths[rule]:
                    del states[-lengths[rule] :]
                state = gotos[states[-1]][origins[rule]]
                states.append(state)
                if state >= 0:
                    break
                rule = ~state
        return limit

    # ------------------------------------------------------------------------------------------------- search

    def search(self, at: int) -> Change | None:
        """The best change of one token, or None when none leads over the next few tokens."""
        best = None
        self._spare.clear()
        for depth, token, penalty in self._places(at):
            for change in self._changes(depth, token, at, penalty):
                if change is not None and (best is None or change.score > best.score):
                    best = change
        return best

    def _places(self, at: int) -> list[tuple[int, int, float]]:
        """Where a change may help: (entries kept, token, penalty). First the error itself, then what is unfinished."""
        firsts = self.machine.firsts
        top = len(firsts)
        places = [(top, at, 0.0)]
        lowest: dict[int, int] = {}
        anchor = self.anchor()
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

    def _changes(self, depth: int, token: int, at: int, penalty: float):
        """The changes at a token, scored; None for one that does not lead far enough."""
        tokens, kinds = self.tokens, self.tokens.kinds
        kind, row = kinds[token], self.table.rows[self.machine.states[depth]]
        far = at - token > 30

        def scored(action: str, edit: tuple[int, ...], upto: int, cost: float, keyword: str = ""):
            reached = self.reads(depth, edit, upto, at + LOOK)
            if reached >= len(kinds) or reached >= at + LOOK:
                score = LOOK - cost - penalty
            elif reached > at and kinds[reached] in _ENDINGS:
                score = LOOK - cost - penalty - 0.5  # that a block ends wrongly there is another matter
            elif reached - at >= ENOUGH:
                score = reached - at - cost - penalty - 3
            else:
                return None
            return Change(score, action, depth, token, upto, edit, keyword)

        for inserted in row:
            cost = _INSERT_COSTS.get(inserted)
            if cost is not None and (inserted in _SECTION_STARTERS or not far):
                change = scored("insert", (inserted,), token, cost + self._unlikely(inserted, token))
                yield change if change and self._lacks_half(inserted, at) else None
        if far or kind == 0:
            return
        again = token and kinds[token - 1] == kind and tokens.texts[token - 1].upper() == tokens.texts[token].upper()
        yield scored("delete", (), token + 1, 0.3 if again else 1.8 if kind in _SIGNS else 1.9)
        if kind == NAME:
            for keyword, away in near_keywords(tokens.texts[token])[:6]:
                wanted = keyword_kind(keyword)
                cost = 0.4 * away + (0.6 if len(keyword) < 4 else 0.0)
                change = scored("keyword", (wanted,), token + 1, cost, keyword)
                if change and wanted in _BLOCK_WORDS:  # what has lost its other half is what was meant
                    change = change._replace(score=change.score + (0.8 if self._lacks_half(wanted, at) else -0.5))
                yield change
            if split := mend.glued(tokens.texts[token]):
                yield scored("split", (keyword_kind(split), NAME), token + 1, 0.5, split)
        elif kind in _SIGNS or kind in _LINKS:
            for other in row.keys() & (_SIGNS if kind in _SIGNS else _LINKS):
                yield scored("replace", (other,), token + 1, 1.7)
        if kind in _WORD_KINDS and NAME in row:
            yield scored("reserved", (NAME,), token + 1, 1.5)

    def _lacks_half(self, word: int, at: int) -> bool:
        """Whether a word that begins or ends a block would find its other half alone; True for any other word."""
        if word not in _BLOCK_WORDS:
            return True
        opens = word in CLOSER_OF
        closer = CLOSER_OF[word] if opens else word
        if closer not in self._spare:
            self._spare[closer] = self._count_spare(closer, at)
        return self._spare[closer] > 0 if opens else self._spare[closer] < 0

    def _count_spare(self, closer: int, at: int) -> int:
        """How many more ends of a kind than blocks that need one: what is open now and what the rest of the POU has."""
        kinds = self.tokens.kinds
        openers = [k for k, c in CLOSER_OF.items() if c == closer]
        rest = kinds[at : at + _REST]
        if not _OUTER & {*openers}:
            stop = min((rest.index(k) for k in _POU_ENDS if k in rest), default=len(rest))
            rest = rest[:stop]
        open_now = sum(CLOSER_OF[kinds[t]] == closer for _, t in self.open_blocks())
        return rest.count(closer) - sum(rest.count(k) for k in openers) - open_now

    def after_junk(self, token: int) -> bool:
        """Whether a character that is no token, reported already, stands before a token."""
        if not self.tokens.junk:
            return False
        start = self.tokens.ends[token - 1] if token else 0
        return any(start <= offset < self.tokens.starts[token] for offset in self.tokens.junk)

    def _junk_line(self, token: int) -> bool:
        """Whether such a character stands earlier on the line of a token: what is wrong there follows from it."""
        if not self.tokens.junk:
            return False
        start = self.tokens.starts[token]
        line = self.tokens.source.text.rfind("\n", 0, start)
        return any(line < offset <= start for offset in self.tokens.junk)

    def _unlikely(self, kind: int, token: int) -> float:
        """A semicolon is forgotten at the end of a line rather than within one, an operator the other way round; after
        a complete statement it is no repair."""
        starts_line = self.tokens.starts_line(token)
        if self.after_junk(token):  # most likely it stands for a sign
            return -1.2 if kind == KIND["BINOP"] else 0.0
        if kind == KIND["SEMI"]:
            if token and self.tokens.kinds[token - 1] in END_KINDS | {kind}:
                return LOOK
            return 0.0 if starts_line else 0.7
        return 0.6 if kind == KIND["BINOP"] and starts_line else 0.0

    # ------------------------------------------------------------------------------------------------- change

    def apply(self, change: Change, at: int) -> int:
        """Report a change and make it; the token to go on from."""
        tokens, token = self.tokens, change.at
        texts = tokens.texts
        found = self.found(token)
        match change.action:
            case "insert":
                self._report_missing(change.kinds[0], change.depth, token)
                tokens.insert(token, change.kinds[0], text_for(change.kinds[0]))
            case "delete":
                twice = token and texts[token - 1].upper() == found.upper()
                hint = "" if twice else self._expected(change.depth)
                self.report("E0116" if twice else "E0101", token, token + 1, found=found, hint=hint)
                tokens.delete(token, token + 1)
            case "keyword":
                self.report("E0115", token, token + 1, found=found, keyword=change.keyword)
                tokens.replace(token, token + 1, change.kinds[0], change.keyword)
            case "split":
                self.report("E0102", token, token + 1, what="a blank", where=f"after {change.keyword}")
                mend.split(tokens, token, change.keyword)
            case "reserved":
                self.report("E0128", token, token + 1, name=found)
                tokens.kinds[token] = NAME
            case _:
                hint = f"did you mean {word(change.kinds[0])}?"
                self.report("E0101", token, token + 1, found=found, hint=hint)
                tokens.replace(token, token + 1, change.kinds[0], text_for(change.kinds[0]))
        self.cut(change.depth)
        shift = len(change.kinds) - (change.upto - token)
        self.settled = max(at, token) + shift + _SETTLED
        return token

    def _report_missing(self, kind: int, depth: int, token: int) -> None:
        """`;` is missing after ..., THEN is missing after the condition of IF."""
        closing = [(e, t) for e, t in self.open_blocks() if e < depth and CLOSER_OF[self.tokens.kinds[t]] == kind]
        if closing:
            opener = closing[-1][1]
            self.report("E0103", opener, opener + 1, **self.block_fields(opener))
            return
        row = self.table.rows[self.machine.states[depth]]
        what = "a type" if kind == NAME and KIND["ARRAY"] in row else word(kind)
        self.report_gap("E0102", token, what=what, where=self._where(kind, depth, token))

    def block_fields(self, opener: int) -> dict:
        """What E0103 says of a block."""
        tokens = self.tokens
        name = TERMINALS[tokens.kinds[opener]]
        return {"closer": CLOSERS[name], "opener": tokens.texts[opener].upper(), "line": tokens.line(opener)}

    def _where(self, kind: int, depth: int, token: int) -> str:
        tokens, name = self.tokens, TERMINALS[kind]
        heads = {"THEN": ("IF", "ELSIF"), "DO": ("FOR", "WHILE"), "OF": ("CASE", "ARRAY"), "TO": ("FOR", "POINTER")}
        for entry in range(depth - 1, -1, -1):
            value = self.machine.values[entry]
            head = TERMINALS[tokens.kinds[value]] if type(value) is int else ""
            if name in heads and head in heads[name]:
                part = {"FOR": "the head", "CASE": "the value", "ARRAY": "the bounds", "POINTER": "the word"}
                return f"after {part.get(head, 'the condition')} of {head}".replace("the word of ", "")
            if (name, head) in (("RPAR", "LPAR"), ("RBRACKET", "LBRACKET")):
                line, column = tokens.source.position(tokens.starts[value])
                return f"for the {tokens.texts[value]} at line {line}, column {column}"
        if name in ("NUMBER", "NAME", "IF", "FOR", "WHILE", "CASE", "PROGRAM", "VAR", "TYPE") or not token:
            return f"before {self.found(token)}"
        return f"after {self.found(token - 1)}"

    def _expected(self, depth: int) -> str:
        """A hint of what could stand here, where that is one thing or two."""
        row = self.table.rows[self.machine.states[depth]]
        signs = sorted({word(k) for k in row if word(k) != word(KIND["BINOP"])} - {word(0)})
        return f"expected {' or '.join(signs)}" if 0 < len(signs) <= 2 else ""

    # -------------------------------------------------------------------------------------------------- panic

    def panic(self, at: int) -> int:
        """Nothing small helps: skip to where a statement, declaration or unit begins that reads on."""
        tokens, kinds, machine = self.tokens, self.tokens.kinds, self.machine
        found = self.found(at)
        self.report("E0101", at, at + 1, found=found, hint=self._expected(len(machine.values)))
        entries = [e for e in range(len(machine.states) - 1) if machine.states[e + 1] in self.anchors]
        semi = KIND["SEMI"]
        first = at + (at in self.panics)
        self.panics.add(at)
        for token in range(first, len(kinds)):
            begins = kinds[token - 1] == semi or kinds[token] in CLOSING or kinds[token] in UNIT_STARTERS
            if not begins and token != at and not tokens.starts_line(token):
                continue
            for entry in reversed(entries):
                if self.reads(entry + 1, (), token, token + 5) >= min(token + 5, len(kinds)):
                    return self._skip(entry + 1, at, token)
        return -1

    def _skip(self, depth: int, at: int, token: int) -> int:
        """Go on from `token` with the stack cut; the closers of blocks whose beginning was skipped are not missed."""
        kinds = self.tokens.kinds
        begun = [kinds[t] for e, t in self.open_blocks() if e >= depth]
        balance: dict[int, int] = {}
        for kind in (*begun, *kinds[at:token]):
            if kind in CLOSER_OF:
                balance[CLOSER_OF[kind]] = balance.get(CLOSER_OF[kind], 0) + 1
            elif balance.get(kind):
                balance[kind] -= 1
        for closer, count in balance.items():
            self.lost[closer] = self.lost.get(closer, 0) + count
        self.cut(depth)
        self.tokens.delete(at, token)
        self.settled = at + _SETTLED
        return at

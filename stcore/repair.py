"""Syntax errors: the smallest change that lets the parser go on, said in the user's words.

The parser stands at a token that cannot follow. The best change of one token (stcore/repair_search.py) is reported once
and made in the list of tokens; the parser goes on with it. Blocks that are not closed, or closed twice, are judged by
how far the rest of the file then reads (stcore/blocks.py). What nothing repairs is skipped up to the next statement.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from stcore import blocks, mend, tables
from stcore.lexer import KIND, NAME, TERMINALS
from stcore.repair_search import Change, Search
from stcore.words import CLOSER_OF, CLOSERS, CLOSING, UNIT_STARTERS, text_for, word

if TYPE_CHECKING:
    from stcore.parser import Machine

MAX_REPAIRS = 200  # of one file; after that it is something else than ST
_SETTLED = 3  # tokens read since the last error, before the next one is its own

_LISTS = ("statement", "declaration", "qualifier", "unit", "section", "type_declaration", "config_item", "case")


class Anchors(NamedTuple):
    """States of the parser where reading can begin again: before a list of the language or in it."""

    any: set[int]
    statement: set[int]
    unit: set[int]

    @classmethod
    def of(cls, table: tables.Table) -> Anchors:
        def before(wanted: set[int]) -> set[int]:
            return {i for i, row in enumerate(table.gotos) if not wanted.isdisjoint(row)}

        names = table.nonterminals
        lists = {i for i, name in enumerate(names) if name.removesuffix("s") in _LISTS}
        units = {names.index("unit"), names.index("units")}
        return cls(before(lists), before({names.index("statement")}), before(units))


class Repairs:
    """The repairs of one parse."""

    def __init__(self, machine: Machine, anchors: Anchors) -> None:
        self.machine = machine
        self.anchors = anchors
        self.tokens = machine.tokens
        self.table = machine.table
        self.count = 0
        self.settled = -1  # an error before this token only follows from the last one
        self.panics: set[int] = set()
        self.lost: dict[int, int] = {}  # closers whose opener was skipped
        self.reads_program = False  # statements stood alone: their END_PROGRAM is not missed
        self.prompt = machine.prompt  # what was typed at a prompt needs no semicolon at its end

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
        change = Search(self, at).best()
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
        text = self.tokens.texts[token] or (word(0) if self.machine.whole else "the end")
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

    def row(self, depth: int) -> dict[int, int]:
        """What can follow when the stack is cut to `depth` entries."""
        return self.table.rows[self.machine.states[depth]]

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
            if states[entry + 1] in self.anchors.any:
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
        row = self.row(depth)
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
        row = self.row(depth)
        signs = sorted({word(k) for k in row if word(k) != word(KIND["BINOP"])} - {word(0)})
        return f"expected {' or '.join(signs)}" if 0 < len(signs) <= 2 else ""

    # -------------------------------------------------------------------------------------------------- panic

    def panic(self, at: int) -> int:
        """Nothing small helps: skip to where a statement, declaration or unit begins that reads on."""
        tokens, kinds, machine = self.tokens, self.tokens.kinds, self.machine
        found = self.found(at)
        self.report("E0101", at, at + 1, found=found, hint=self._expected(len(machine.values)))
        entries = [e for e in range(len(machine.states) - 1) if machine.states[e + 1] in self.anchors.any]
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

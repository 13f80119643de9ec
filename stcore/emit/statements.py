"""Statements to WebAssembly text."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.check.width import wide
from stcore.emit.changes import acts
from stcore.emit.loops import Loops
from stcore.emit.values import constant, load, number, store, wasm_type, wrap
from stcore.program import Branch
from stcore.scope import Var, key

SHORT = 128  # bytes that are copied by loads and stores


class Statements(Loops):
    """Emits statements, one or more lines each."""

    def body(self, statements: list[s.Node]) -> None:
        if any(isinstance(n, s.Label) for n in statements):
            self._labelled(statements)
            return
        for node in statements:
            self.statement(node)

    def statement(self, node: s.Node) -> None:
        if self.probed and not isinstance(node, s.Label):
            self._probe(node)
        self.STATEMENTS[type(node)](self, node)

    def _probe(self, node: s.Node) -> None:
        """Here a probed build can stop."""
        site = self.module.site(self.source, node, self.pou.full_name, "", "")
        self.module.probed[site] = self.number
        self.sites[node] = site
        this = self.this_address() if self.pou.type is not None else "(i32.const 0)"
        self.line(f"(call $stop (i32.const {site}) (i32.const {self.number}) {this} (local.get $fp))")

    def _branch(self, node: s.Node, kind: str, label: s.Node | str, last: s.Node | None = None) -> None:
        """A way that is taken here, for a probed build to count. last: of several labels, which end there."""
        if not self.probed:
            return
        where, text = node, label
        if not isinstance(label, str):
            where, text = label, " ".join(self.source.text[label.start : (last or label).end].split())
        line, _ = self.source.position(where.start)
        self.line(f"(call $taken (i32.const {len(self.module.branches)}))")
        self.module.branches.append(Branch(self.sites[node], kind, text, line))

    # ---------------------------------------------------------------------------------------- assignment

    def assign(self, node: s.Assign) -> None:
        target = node.target
        if target.type is t.ERROR:
            return
        self.mark(node)
        if node.op in ("S=", "R="):
            bit = "(i32.const 1)" if node.op == "S=" else "(i32.const 0)"
            self.line(f"(if {self.value(node.value)} (then {self.store_text(target, bit)}))")
        elif node.op == "REF=":
            value = self.value(node.value) if node.value.type is t.DWORD else self.address_of(node.value)
            self.line(self.store_text(target, value))
        elif t.is_aggregate(target.type):
            self.line(self.copy_text(target.type, self.address_of(target), node.value))
            self.forget(target, stored=True)
        else:
            if acts(target):
                target = self.pinned(target)  # it is worked out before the value
            suits = self.suits(target)
            local = suits or isinstance(target.symbol, Var) and self.local_of(target.symbol)
            value = self.narrow(node.value) if local else self.value(node.value)
            if suits:
                self.remember(target.symbol)
            if wide(node.value) and local and t.base_of(node.value.type) is not t.base_of(target.type):
                value = wrap(target.type, value)
            self.line(self.store_text(target, value))

    def store_text(self, place: s.Node, value: str) -> str:
        """Store an elementary value at a place."""
        if isinstance(place, s.Part):
            return self._store_part(place, value)
        symbol = place.symbol
        if isinstance(symbol, Var):
            local = self.local_of(symbol)
            if not self.in_memory(symbol):
                return f"(local.set {local} {value})"
            if local is not None:
                value = f"(local.tee {local} {value})"
        self.forget(place, stored=True)
        base, offset = self.place(place)
        if isinstance(symbol, Var) and symbol.bit is not None:
            byte = load(t.BYTE, base, offset)
            return store(t.BYTE, base, offset, self._with_bits("i32", byte, value, symbol.bit, 1))
        return store(place.type, base, offset, value)

    def _store_part(self, place: s.Part, value: str) -> str:
        """Bits into the variable they are part of."""
        kind = t.base_of(place.base.type)
        width = {"X": 1, "B": 8, "W": 16, "D": 32}[place.size]
        if kind.wasm == "i64":
            value = f"(i64.extend_i32_u {value})"
        inner, symbol = place.base, place.base.symbol
        in_local = isinstance(symbol, Var) and (self.local_of(symbol) or symbol.bit is not None)
        if isinstance(inner, s.Part) or in_local:
            whole = self._with_bits(kind.wasm, self.value(inner), value, place.index * width, width)
            return self.store_text(inner, wrap(kind, whole))
        self.forget(inner, stored=True)
        base, offset = self.place(inner)
        first = ""
        if base and not base.startswith("(local.get"):  # worked out once, for its calls and checks
            held = self.temp("i32")
            first, base = f"(local.set {held} {base}) ", f"(local.get {held})"
        whole = self._with_bits(kind.wasm, load(inner.type, base, offset), value, place.index * width, width)
        return first + store(inner.type, base, offset, whole)

    @staticmethod
    def _with_bits(wasm: str, whole: str, value: str, shift: int, width: int) -> str:
        mask = (1 << width) - 1
        keep = number(~(mask << shift), wasm)
        if width < 32:
            value = f"({wasm}.and {value} {number(mask, wasm)})"
        return f"({wasm}.or ({wasm}.and {whole} {keep}) ({wasm}.shl {value} {number(shift, wasm)}))"

    def copy_text(self, kind: t.Type, to: str, value: s.Node) -> str:
        """Copy an aggregate value to an address. What an instance begins with stays: it tells whose it is."""
        text = self.value(value)
        if getattr(kind, "number", 0):
            room = f"(i32.const {kind.size - 4})"
            return f"(memory.copy (i32.add {to} (i32.const 4)) (i32.add {text} (i32.const 4)) {room})"
        return self.copy_bytes(kind, to, text)

    def copy_bytes(self, kind: t.Type, to: str, source: str) -> str:
        if isinstance(kind, t.String):
            call = "$wstr_copy" if kind.wide else "$str_copy"
            return f"(call {call} {to} {source} (i32.const {kind.length}))"
        return self._short_copy(kind, to, source) or f"(memory.copy {to} {source} (i32.const {kind.size}))"

    def _short_copy(self, kind: t.Type, to: str, source: str) -> str | None:
        """A structure of a few words through locals; memory.copy is a call of the host."""
        if kind.size > SHORT:
            return None
        goal, start = self.temp("i32"), self.temp("i32")
        loads, stores = [], []
        for wasm, suffix, offset in _pieces(kind):
            temp = self.temp(wasm)
            loads.append(f"(local.set {temp} ({wasm}.load{suffix} offset={offset} (local.get {start})))")
            store = suffix.partition("_")[0]
            stores.append(f"({wasm}.store{store} offset={offset} (local.get {goal}) (local.get {temp}))")
        return " ".join([f"(local.set {goal} {to}) (local.set {start} {source})", *loads, *stores])

    # ---------------------------------------------------------------------------------------- selection

    def if_(self, node: s.If) -> None:
        ways = []
        for i, (condition, body) in enumerate(node.branches):
            self.mark(node if i == 0 else condition)
            self.line(f"(if {self.value(condition)} (then")
            before = self.recent
            self._branch(node, "IF", condition)
            self.body(body)
            ways.append(self.recent)
            self.recent = before
            self.line(") (else")
        self._branch(node, "IF", "ELSE")
        if node.orelse is not None:
            self.body(node.orelse)
        self.recent = self.in_all([*ways, self.recent])
        self.line("))" * len(node.branches))

    def case(self, node: s.Case) -> None:
        self.mark(node)
        wasm = wasm_type(node.selector.type)
        selector = self.keep(wasm)
        self.line(f"(local.set {selector} {self.value(node.selector)})")
        end, other = self.label("end"), self.label("else")
        names = [self.label("case") for _ in node.branches]
        self.line(f"(block {end} (block {other}")
        for name in reversed(names):
            self.line(f"(block {name}")
        self._dispatch(node, selector, wasm, names, other)
        before, ways = self.recent, []
        for name, (labels, body) in zip(names, node.branches, strict=True):
            self.line(f") ;; {name}")
            self._branch(node, "CASE", labels[0], labels[-1])
            self.body(body)
            ways.append(self.recent)
            self.recent = before
            self.line(f"(br {end})")
        self.line(")")
        self._branch(node, "CASE", "ELSE")
        if node.orelse is not None:
            self.body(node.orelse)
        self.recent = self.in_all([*ways, self.recent])
        self.line(")")

    def _dispatch(self, node: s.Case, selector: str, wasm: str, names: list[str], other: str) -> None:
        """To the branch of the selector: by a table when the labels lie close together."""
        single = [
            (label.const, name)
            for (labels, _), name in zip(node.branches, names, strict=True)
            for label in labels
            if not isinstance(label, s.Range)
        ]
        values = [int(v) for v, _ in single if v is not None]
        simple = len(single) == sum(len(labels) for labels, _ in node.branches) and len(values) == len(single)
        if simple and wasm == "i32" and len(values) >= 4 and max(values) - min(values) < 4 * len(values) + 16:
            low = min(values)
            table = [other] * (max(values) - low + 1)
            for value, name in reversed(single):
                table[int(value) - low] = name
            self.line(f"(br_table {' '.join(table)} {other} (i32.sub (local.get {selector}) (i32.const {low})))")
            return
        for (labels, _), name in zip(node.branches, names, strict=True):
            for label in labels:
                self.line(f"(br_if {name} {self._matches(label, selector, wasm, node.selector.type)})")
        self.line(f"(br {other})")

    @staticmethod
    def _matches(label: s.Node, selector: str, wasm: str, kind: t.Type) -> str:
        here = f"(local.get {selector})"
        if isinstance(label, s.Range):
            base = t.base_of(kind)
            sign = "s" if base.signed or base.size < 4 else "u"
            low, high = constant(label.low.const, base), constant(label.high.const, base)
            return f"(i32.and ({wasm}.ge_{sign} {here} {low}) ({wasm}.le_{sign} {here} {high}))"
        return f"({wasm}.eq {here} {constant(label.const, kind)})"

    def exit(self, node: s.Exit) -> None:
        self.mark(node)
        self.line(f"(br {self.loops[-1][0]})")

    def continue_(self, node: s.Continue) -> None:
        self.mark(node)
        self.line(f"(br {self.loops[-1][1]})")

    def return_(self, node: s.Return) -> None:
        self.mark(node)
        self.line(f"(br {self.exit_label})")

    # -------------------------------------------------------------------------------------------- jumps

    def _labelled(self, statements: list[s.Node]) -> None:
        """Labels cut the list into pieces; JMP picks the next piece and goes round."""
        pieces: list[list[s.Node]] = [[]]
        places: dict[str, int] = {}
        for node in statements:
            if isinstance(node, s.Label):
                places[key(node.name)] = len(pieces)
                pieces.append([])
            else:
                pieces[-1].append(node)
        next_piece, again = self.keep("i32"), self.label("again")
        self.jumps.append((next_piece, again, places))
        names = [self.label("piece") for _ in pieces]
        self.line(f"(local.set {next_piece} (i32.const 0)) (loop {again}")
        self._ask_interrupt(statements[0])
        for name in reversed(names):
            self.line(f"(block {name}")
        self.line(f"(br_table {' '.join(names)} (local.get {next_piece}))")
        for piece in pieces:
            self.line(")")
            self.recent = {}
            for node in piece:
                self.statement(node)
        self.recent = {}
        self.line(")")
        self.jumps.pop()

    def jump(self, node: s.Jump) -> None:
        self.mark(node)
        next_piece, again, places = next(x for x in reversed(self.jumps) if key(node.name) in x[2])
        self.line(f"(local.set {next_piece} (i32.const {places[key(node.name)]})) (br {again})")

    def nothing(self, node: s.Node) -> None:
        pass

    STATEMENTS = {
        s.Assign: assign, s.ExprStmt: Loops.call_statement, s.If: if_, s.Case: case, s.For: Loops.for_,
        s.While: Loops.while_, s.Repeat: Loops.repeat, s.Exit: exit, s.Continue: continue_, s.Return: return_,
        s.Label: nothing, s.Jump: jump,
    }  # fmt: skip


def _pieces(kind: t.Type) -> list[tuple[str, str, int]]:
    """How the bytes of an aggregate are taken: type of the value, suffix of its load, offset. Members that were written
    shortly before are best read one by one: a load over two of them waits until both are in memory."""
    found, at, size = [], 0, kind.size
    widest = kind.align if kind.align >= 4 and size <= 8 * kind.align else 16
    widths = (("v128", "", 16), ("i64", "", 8), ("i32", "", 4), ("i32", "16_u", 2), ("i32", "8_u", 1))
    for wasm, suffix, width in widths:
        while width <= widest and size - at >= width:
            found.append((wasm, suffix, at))
            at += width
    return found

"""Statements to WebAssembly text."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.check.width import held, wide
from stcore.emit.calls import Calls
from stcore.emit.changes import acts, changes
from stcore.emit.counting import Counting
from stcore.emit.ranges import Range, range_of
from stcore.emit.values import constant, convert, load, number, store, wasm_type, wrap
from stcore.program import INTERRUPT, Branch
from stcore.scope import Var, key

# A loop that is known to end after so many rounds need not ask whether the host wants it to stop.
QUICK = 100_000
SHORT = 128  # bytes that are copied by loads and stores
# The ways of a loop that coverage counts: of FOR and WHILE once each time the loop is come to, of REPEAT each UNTIL
ENTERED, NOT_ENTERED = "body", "no round"
AGAIN, DONE = "another round", "done"


class Statements(Calls):
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

    # -------------------------------------------------------------------------------------------- loops

    def _ask_interrupt(self, node: s.Node) -> None:
        """The host may end this loop here."""
        fault = f"{self.marker(node, 'F0108')} (call $fault) unreachable"
        self.line(f"(if (i32.atomic.load (i32.const {INTERRUPT})) (then {fault}))")

    def _loop_body(self, body: list[s.Node], exit_label: str, next_label: str) -> None:
        self.loops.append((exit_label, next_label))
        self.line(f"(block {next_label}")
        self.body(body)
        self.line(")")
        self.recent = {}
        self.loops.pop()

    def while_(self, node: s.While) -> None:
        outer = self.keep_copies(node.condition, node.body)
        end, top, next_ = self.label("end"), self.label("loop"), self.label("next")
        entered = self.keep("i32") if self.probed else ""
        if entered:
            self.line(f"(local.set {entered} (i32.const 0))")
        self.line(f"(block {end} (loop {top}")
        self.mark(node)
        self._ask_interrupt(node)
        self.line(f"(if {self.value(node.condition)} (then")  # as br_if it would have to turn the condition round
        if entered:
            self.line(f"(if (i32.eqz (local.get {entered})) (then (local.set {entered} (i32.const 1))")
            self._branch(node, "LOOP", ENTERED)
            self.line("))")
        self._loop_body(node.body, end, next_)
        self.line(f"(br {top})))))")
        if entered:
            self.line(f"(if (i32.eqz (local.get {entered})) (then")
            self._branch(node, "LOOP", NOT_ENTERED)
            self.line("))")
        self.copies = outer

    def repeat(self, node: s.Repeat) -> None:
        outer = self.keep_copies(node.condition, node.body)
        end, top, next_ = self.label("end"), self.label("loop"), self.label("next")
        self.line(f"(block {end} (loop {top}")
        self.mark(node)
        self._ask_interrupt(node)
        self._loop_body(node.body, end, next_)
        self.mark(node.condition)
        if not self.probed:
            self.line(f"(if {self.value(node.condition)} (then) (else (br {top})))))")
            self.copies = outer
            return
        self.line(f"(if (i32.eqz {self.value(node.condition)}) (then")
        self._branch(node, "LOOP", AGAIN)
        self.line(f"(br {top})))")
        self._branch(node, "LOOP", DONE)
        self.line("))")

    def for_(self, node: s.For) -> None:
        """End and step are taken once; the variable ends one step past the end (reference/semantics.md)."""
        self.mark(node)
        kind = t.base_of(node.var.type)
        if kind is t.ERROR:
            return
        written = node
        node = s.For(node.start, node.end, self.pinned(node.var), node.first, node.last, node.step, node.body)
        step = node.step.const if node.step is not None else 1
        last = range_of(node.last, self.ranges)
        roomy = kind.size < 4 or kind.size == 4 and step is not None and _fits(last, step, kind)
        wasm = "i32" if roomy else "i64"
        counter = self.keep(wasm)
        self.line(f"(local.set {counter} {self._as(node.first, wasm)})")
        first = range_of(node.first, self.ranges)
        self._show(node, counter, wasm)
        end, by = self._once(node.last, wasm), self._once(node.step, wasm) if node.step else number(1, wasm)
        counting = Counting(kind, wasm, f"(local.get {counter})", end, by, step)
        if self.probed:
            self.line(f"(if {counting.inside()} (then")
            self._branch(written, "LOOP", ENTERED)
            self.line(") (else")
            self._branch(written, "LOOP", NOT_ENTERED)
            self.line("))")
        self._for_loop(node, counting, counter, first, last)

    def _once(self, node: s.Node, wasm: str) -> str:
        """A value that is worked out before the loop begins."""
        text = self._as(node, wasm)
        if node.const is not None:
            return text
        held = self.keep(wasm)
        self.line(f"(local.set {held} {text})")
        return f"(local.get {held})"

    def _show(self, node: s.For, counter: str, wasm: str) -> None:
        """The counter into the variable."""
        kind = t.base_of(node.var.type)
        value = f"(local.get {counter})"
        if wasm != kind.wasm:
            value = f"(i32.wrap_i64 {value})"
        in_local = isinstance(node.var.symbol, Var) and self.local_of(node.var.symbol)
        self.line(self.store_text(node.var, wrap(kind, value) if in_local else value))

    def _for_loop(self, node: s.For, counting: Counting, counter: str, first: Range, last: Range) -> None:
        kind, wasm, step = counting.kind, counting.wasm, counting.step
        var = node.var.symbol if isinstance(node.var, s.Name) and isinstance(node.var.symbol, Var) else None
        rounds = (max(last[1] - first[0], first[1] - last[0]) // abs(step) + 1) if step else QUICK + 1
        end, top, next_ = self.label("end"), self.label("loop"), self.label("next")
        copies = self.keep_copies(node.body)
        self.line(f"(block {end} (br_if {end} (i32.eqz {counting.inside()}))")
        self.line(f"(loop {top}")
        # in a build with probes a debugger may change it at any statement
        unseen = self.probed or var is None or step is None
        trusted = not unseen and changes(node.body, self.pou).steady(var)
        outer = self.rounds
        self.rounds *= max(rounds, 1)
        if self.rounds > QUICK or not trusted:
            self._ask_interrupt(node)
        saved, shadow = self.ranges, self.shadows
        if trusted and kind.size <= 4:
            bounds = (first[0], max(last[1], first[0])) if step > 0 else (min(last[0], first[1]), first[1])
            self.ranges = saved | {var: bounds}
            if wasm == kind.wasm:
                self.shadows = shadow | {var: counter}
        self._loop_body(node.body, end, next_)
        self.ranges, self.shadows, self.rounds = saved, shadow, outer
        if not trusted:
            self.line(f"(local.set {counter} {self._as(node.var, wasm)})")
        again = counting.inside()
        if counting.tight:
            again = f"(local.get {self._decided(counting.fits())})"
        self.line(f"(local.set {counter} {counting.next()})")
        self._show(node, counter, wasm)
        self.line(f"(br_if {top} {again})))")
        self.copies = copies

    def _decided(self, test: str) -> str:
        """A local with the result of a test."""
        name = self.keep("i32")
        self.line(f"(local.set {name} {test})")
        return name

    def _as(self, node: s.Node, wasm: str) -> str:
        """An integer in the width of the loop's counter."""
        if node.const is not None:
            return constant(node.const, t.LINT if wasm == "i64" else t.DINT)
        return convert(held(node), t.LINT if wasm == "i64" else t.DINT, self.value(node))

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
        s.Assign: assign, s.ExprStmt: Calls.call_statement, s.If: if_, s.Case: case, s.For: for_, s.While: while_,
        s.Repeat: repeat, s.Exit: exit, s.Continue: continue_, s.Return: return_, s.Label: nothing, s.Jump: jump,
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


def _fits(last: tuple[int, int], step: int, kind: t.Elementary) -> bool:
    """True if one step past any end value is still a DINT."""
    return kind.signed and t.DINT.low <= last[0] + min(step, 0) and last[1] + max(step, 0) <= t.DINT.high

"""Loops to WebAssembly text."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.check.width import held
from stcore.emit.calls import Calls
from stcore.emit.changes import changes
from stcore.emit.counting import Counting
from stcore.emit.ranges import Range, range_of
from stcore.emit.values import constant, convert, number, wrap
from stcore.program import INTERRUPT
from stcore.scope import Var

# A loop that is known to end after so many rounds need not ask whether the host wants it to stop.
QUICK = 100_000
# The ways of a loop that coverage counts: of FOR and WHILE once each time the loop is come to, of REPEAT each UNTIL
ENTERED, NOT_ENTERED = "body", "no round"
AGAIN, DONE = "another round", "done"


class Loops(Calls):
    """FOR, WHILE and REPEAT; their bodies are statements (emit/statements.py)."""

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


def _fits(last: tuple[int, int], step: int, kind: t.Elementary) -> bool:
    """True if one step past any end value is still a DINT."""
    return kind.signed and t.DINT.low <= last[0] + min(step, 0) and last[1] + max(step, 0) <= t.DINT.high

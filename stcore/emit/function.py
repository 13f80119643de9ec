"""One function of the module: the code of a POU or an action, with its locals and its stack frame."""

from __future__ import annotations

import itertools
from collections.abc import Callable

from stcore import syntax as s
from stcore import types as t
from stcore.emit.calls import aggregate_outputs, scalar_outputs
from stcore.emit.image import InitCall, Late
from stcore.emit.inline import ROOM, Inlining, NeedsFrame
from stcore.emit.values import address, constant, load, store, wasm_type, wrap
from stcore.scope import Pou, Var
from stcore.source import Source


class FunctionEmitter(Inlining):
    """Emits the code of one POU. lines: WebAssembly text, one statement or part of one each.

    static_base: the address of the instance when there is only one (a program), else None: it comes in $this.
    caller: the code that takes this code in, in place of a call (emit/inline.py).
    """

    wrap = staticmethod(wrap)

    def __init__(
        self, module, pou: Pou, source: Source, static_base: int | None = None, caller: FunctionEmitter | None = None
    ) -> None:
        self.module = module
        self.pou = pou
        self.source = source
        self.static_base = static_base
        self.this = ("(local.get $this)", 0) if static_base is None else ("", static_base)
        self.caller = caller
        self.within = caller.here if caller else -1  # the site of the call
        self.here = -1  # the site of the statement
        self.exit_label = "$return"
        self.room = ROOM  # for code that is taken in
        self.lines: list[str] = []
        self.declared: list[str] = caller.declared if caller else []  # (local ...) declarations
        self.free: dict[str, list[str]] = {}
        self.lent: list[tuple[str, str]] = []
        self.capturing = False
        self.borrowed: list[tuple[str, str]] = []
        self.counter = caller.counter if caller else itertools.count(1)
        self.locals_of: dict[Var, str] = {}
        self.frame_of: dict[Var, int] = {}
        self.in_out_locals: dict[Var, str] = {}
        self.open_locals: dict[Var, list[tuple[str, str]]] = {}  # bounds of ARRAY[*]
        self.frame_size = 0
        self.loops: list[tuple[str, str]] = []
        self.jumps: list[tuple[str, str, dict[str, int]]] = []  # lists of statements with labels, innermost last
        self.ranges: dict[Var, tuple[int, int]] = {}
        self.shadows: dict[Var, str] = {}  # these three: emit/copies.py
        self.copies: dict[Var, str] = {}
        self.recent: dict[Var, str] = {}
        self.homes: dict[Var, str] = {}  # the locals for what is recent
        self.rounds = 1
        self.probed = False
        self.number = -1  # of the body, in a probed build
        self.sites: dict[s.Node, int] = {}  # of the statements, in a probed build
        self.seen: list[tuple[str, t.Type, int, bool]] = []  # what a probed build shows of the frame

    # ------------------------------------------------------------------------------------------- output

    def line(self, text: str) -> None:
        """A piece of code at statement level; its temporaries are free again."""
        self.lines.append(text)
        if not self.capturing:
            self._give_back(self.lent)

    def _give_back(self, names: list[tuple[str, str]]) -> None:
        for wasm, name in names:
            self.free.setdefault(wasm, []).append(name)
        names.clear()

    def captured(self, action: Callable[[], None]) -> list[str]:
        """The lines that an action emits, as part of a statement: its temporaries stay in use until that ends."""
        outer, self.lines = (self.lines, self.capturing), []
        self.capturing = True
        action()
        made = self.lines
        self.lines, self.capturing = outer
        return made

    def label(self, name: str) -> str:
        return f"${name}{next(self.counter)}"

    def _local(self, wasm: str, name: str = "t") -> str:
        text = f"${name}{next(self.counter)}"
        self.declared.append(f"(local {text} {wasm})")
        return text

    def temp(self, wasm: str) -> str:
        """A local for the length of one statement."""
        pool = self.free.setdefault(wasm, [])
        name = pool.pop() if pool else self._local(wasm)
        self.lent.append((wasm, name))
        return name

    def keep(self, wasm: str) -> str:
        """A local of its own."""
        return self._local(wasm, "k")

    def borrow(self, wasm: str) -> str:
        """A local until this code ends."""
        pool = self.free.setdefault(wasm, [])
        name = pool.pop() if pool else self._local(wasm)
        self.borrowed.append((wasm, name))
        return name

    def take_free(self, caller: FunctionEmitter) -> None:
        """The locals that the caller does not need are used by code that is taken in."""
        self.free, caller.free = caller.free, {}

    def release(self) -> None:
        """Code that was taken in gives its locals back; they are free again after the statement that it is part of."""
        self._give_back(self.lent)
        self._give_back(self.borrowed)
        self.caller.lent += [(wasm, name) for wasm, names in self.free.items() for name in names]

    def frame(self, size: int, alignment: int) -> int:
        """Room in the stack frame: its offset."""
        if self.caller:
            raise NeedsFrame
        self.frame_size = (self.frame_size + alignment - 1) // alignment * alignment
        offset = self.frame_size
        self.frame_size += size
        return offset

    def marker(self, node: s.Node, code: str = "", note: str = "") -> str:
        """A constant that is dropped: no instruction in the end, but a fault behind it finds its place by it."""
        number = self.module.site(self.source, node, self.pou.full_name, code, note, self.within)
        return f"(drop (i32.const {number}))"

    def mark(self, node: s.Node, note: str = "") -> None:
        self.here = len(self.module.sites)
        self.line(self.marker(node, "", note))

    # -------------------------------------------------------------------------------------------- whole

    def code(self, body: list[s.Node], name: str) -> str:
        """The whole (func ...) of a body."""
        pou = self.pou
        if self.module.probes:
            self.probed = True
            self.number = len(self.module.bodies)
            self.module.bodies.append(None)  # filled in when its frame is known
        params: list[str] = []
        results: list[str] = []
        if pou.is_called:
            params, results = self._parameters()
        if pou.type is not None and self.static_base is None:
            params.insert(0, "(param $this i32)")
        if not pou.checked:  # left out: nothing that could call it is in the program (attribute only_with)
            stop = f"{self.marker(pou.tree, 'F0107')} (call $fault) unreachable"
            return self._assemble(name, params, results, [], [stop])
        self._own_variables()
        self._in_outs()
        prologue, self.lines = self.lines, []
        self.body(body)
        main, self.lines = self.lines, []
        return self._assemble(name, params, results, prologue, main)

    def _assemble(self, name, params, results, prologue, main) -> str:
        head = f"(func {name} {' '.join(params)} {' '.join(f'(result {r})' for r in results)}"
        parts = [head, " ".join(self.declared)]
        framed = self.frame_size or self.probed
        if framed:
            size = (self.frame_size + 7) // 8 * 8
            site = self.marker(self.pou.tree, "F0105")
            parts[1] += " (local $fp i32)"
            parts.append(
                f"(if (i32.lt_u (local.tee $fp (i32.sub (global.get $sp) (i32.const {size}))) (global.get $stack))"
                f" (then {site} (call $fault) unreachable))\n(global.set $sp (local.get $fp))"
            )
        parts += prologue
        if self.probed:
            parts.append("(call $enter)")
        parts.append("(block $return")
        parts += main
        parts.append(")")
        if self.probed:
            parts.append("(call $leave)")
        if framed:
            parts.append(f"(global.set $sp (i32.add (local.get $fp) (i32.const {size})))")
        parts += self._results()
        parts.append(")")
        return "\n".join(parts)

    def _name(self, var: Var) -> str:
        readable = var.name if var.name.isascii() else ""
        return f"$v{next(self.counter)}.{readable}"

    def _parameters(self) -> tuple[list[str], list[str]]:
        """A function's signature; inputs whose address is taken, and strings, move into the frame."""
        pou, params, results = self.pou, [], []
        for p in pou.inputs():
            name = self._name(p)
            params.append(f"(param {name} {'i32' if p.indirect else wasm_type(p.type)})")
            self._take_parameter(p, name)
            if getattr(p.type, "open", 0):
                bounds = [(f"{name}.low{d}", f"{name}.high{d}") for d in range(p.type.open)]
                params += [f"(param {x} i32)" for pair in bounds for x in pair]
                self.open_locals[p] = bounds
        for p in aggregate_outputs(pou):
            name = self._name(p)
            params.append(f"(param {name} i32)")
            p.indirect = True
            self.locals_of[p] = name
            self._set_default(p)
        if pou.result is not None:
            self._declare_result(params, results)
        results += [wasm_type(p.type) for p in scalar_outputs(pou)]
        for p in scalar_outputs(pou):
            self._local_variable(p)
        return params, results

    def _take_parameter(self, p: Var, name: str) -> None:
        if p.indirect:
            self.locals_of[p] = name
            self._show_address(p, name)
        elif t.is_aggregate(p.type):
            pou = self.pou
            elsewhere = pou.writes_outside or aggregate_outputs(pou)  # F(s := x, o => x)
            elsewhere = elsewhere or pou.holder is not None and pou.writes_instance
            if not p.written and not p.addressed and not elsewhere:
                p.indirect = True  # never changed here: the caller's own bytes will do
                self.locals_of[p] = name
                self._show_address(p, name)
            else:
                self.frame_of[p] = offset = self.frame(p.type.size, p.type.align)
                self.seen.append((p.name, p.type, offset, False))
                self.line(self.copy_bytes(p.type, address("(local.get $fp)", offset), f"(local.get {name})"))
                if getattr(p.type, "number", 0):
                    self.line(store(t.UDINT, "(local.get $fp)", offset, f"(i32.const {p.type.number})"))
        elif p.addressed or self.probed:
            self.frame_of[p] = offset = self.frame(p.type.size, p.type.align)
            self.seen.append((p.name, p.type, offset, False))
            self.line(store(p.type, "(local.get $fp)", offset, f"(local.get {name})"))
        else:
            self.locals_of[p] = name

    def _show_address(self, var: Var, name: str) -> None:
        """A probed build keeps the address of what is passed by reference where it can be seen."""
        if self.probed and not getattr(var.type, "open", 0):
            offset = self.frame(4, 4)
            self.seen.append((var.name, var.type, offset, True))
            self.line(store(t.DWORD, "(local.get $fp)", offset, f"(local.get {name})"))

    def _declare_result(self, params: list[str], results: list[str]) -> None:
        result = self.pou.result
        if t.is_aggregate(result.type):
            name = self._name(result)
            params.append(f"(param {name} i32)")
            result.indirect = True
            self.locals_of[result] = name
            self._show_address(result, name)
            self._set_default(result)
        else:
            results.append(wasm_type(result.type))
            self._local_variable(result)

    def _own_variables(self) -> None:
        """VAR of a function, VAR_TEMP: fresh at every call."""
        taken = set(self.pou.parameters) if self.pou.is_called else set()
        for var in self.pou.variables.values():
            if var.storage == "local" and var not in taken and var.owner is self.pou:
                self._local_variable(var)

    def _local_variable(self, var: Var) -> None:
        """Place a variable in a local, or in the frame if its address matters, with its initial value."""
        if t.is_aggregate(var.type) or var.addressed or self.probed:
            self.frame_of[var] = offset = self.frame(var.type.size, var.type.align)
            self.seen.append((var.name, var.type, offset, False))
            self._set_default(var)
            return
        name = self._name(var)
        self.declared.append(f"(local {name} {wasm_type(var.type)})")
        self.locals_of[var] = name
        value = self.module.initial_value(var)
        if isinstance(value, s.Node):
            self.line(f"(local.set {name} {self.narrow(value)})")
        elif value or self.caller:  # code that was taken in may stand in a loop
            self.line(f"(local.set {name} {constant(value, var.type)})")

    def _set_default(self, var: Var) -> None:
        """Initial bytes of a variable in memory."""
        base, offset = self.var_place(var)
        to = address(base, offset)
        if not t.is_aggregate(var.type):
            value = self.module.initial_value(var)
            text = self.narrow(value) if isinstance(value, s.Node) else constant(value, var.type)
            self.line(store(var.type, base, offset, text))
        elif isinstance(var.type, t.String) and var.init is None:
            self.line(store(t.WORD if var.type.wide else t.BYTE, base, offset, "(i32.const 0)"))
        else:
            template = self.module.template(var)
            if template == 0:
                self.line(f"(memory.fill {to} (i32.const 0) (i32.const {var.type.size}))")
            else:
                self.line(f"(memory.copy {to} (i32.const {template}) (i32.const {var.type.size}))")
            for late in self.module.images.of_variable(var)[1]:
                if late.pou in (None, self.pou):
                    self.set_late(late, base, offset)
                else:  # of an instance: in the names of its block
                    self.line(f"(call {self.module.late_code(late)} {address(base, offset + late.owner)})")

    def set_late(self, late: Late, base: str, offset: int) -> None:
        """An initial value that is no constant, into the variable at this place; or the call of FB_init there."""
        if isinstance(late.node, InitCall):
            self.init_call(late.node, address(base, offset + late.offset))
            return
        text, offset = self.narrow(late.node), offset + late.offset
        if t.is_aggregate(late.type):
            self.line(self.copy_bytes(late.type, address(base, offset), text))
        else:
            self.line(store(late.type, base, offset, text))

    def _in_outs(self) -> None:
        """The addresses of a block's in-outs, taken once; not connected is a fault at once."""
        if self.pou.is_called:
            return
        for var in self.pou.parameters:
            if var.section != "VAR_IN_OUT" or var in self.in_out_locals:
                continue
            base, offset = self.this_place()
            name = self._local("i32", "io")
            pointer = load(t.DWORD, base, offset + var.address)
            mark = self.marker(var.decl, "F0103", var.name)
            self.line(
                f"(if (i32.lt_u (local.tee {name} {pointer}) (i32.const 1024))"
                f" (then {mark} (call $fault_pointer (local.get {name})) unreachable))"
            )
            self.in_out_locals[var] = name

    def _results(self) -> list[str]:
        pou = self.pou
        if not pou.is_called:
            return []
        returned = [pou.result] if pou.result is not None and not t.is_aggregate(pou.result.type) else []
        lines = []
        for var in [*returned, *scalar_outputs(pou)]:
            local = self.locals_of.get(var)
            if local is None or var in self.frame_of:
                lines.append(load(var.type, *self.var_place(var)))
            else:
                lines.append(f"(local.get {local})")
        return lines

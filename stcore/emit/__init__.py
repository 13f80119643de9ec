"""The emitter: a checked project to a WebAssembly module in text form, with its first image and its sites."""

from __future__ import annotations

from collections import deque
from pathlib import Path

from stcore import syntax as s
from stcore.check.initial import check_init
from stcore.declare_types import align
from stcore.emit.calls import abstract
from stcore.emit.dispatch import Dispatch, signature
from stcore.emit.function import FunctionEmitter
from stcore.emit.image import ImageBuilder, Late, encode_text
from stcore.emit.inline import Inlinable
from stcore.emit.routines import methods_to_test, test_export
from stcore.emit.values import wasm_type
from stcore.program import (
    ALONE,
    NULL_PAGE,
    SIDE_SIZE,
    TASK_RATIOS,
    Body,
    Branch,
    External,
    Sites,
    TaskSpec,
)
from stcore.scope import Pou, Var, key, place_node
from stcore.source import Source

STACK_SIZE = 256 * 1024
_KERNEL = Path(__file__).parent / "kernel.wat"
_PROBES = Path(__file__).parent / "probes.wat"


class ModuleEmitter:
    """Emits everything that the tasks reach. `emit` gives the text; then image, sites, functions are complete.

    probes: put a stop in front of every statement (emit/probes.wat); everything else stays the same.
    """

    def __init__(self, project, probes: bool = False) -> None:
        self.project = project
        self.probes = probes
        self.inlining = Inlinable() if not probes else None
        self.bodies: list[Body] = []
        self.probed: dict[int, int] = {}  # sites of statements -> the number of their body
        self.branches: list[Branch] = []
        self.images = ImageBuilder(project)
        self.sites = Sites()
        self.functions: list[str] = []
        self.externals: list[External] = []
        self.needed: dict[str, tuple[Pou, s.Action | None]] = {}
        self.queue: deque[tuple[str, Pou, s.Action | None, int | None]] = deque()
        self.late_codes: dict[tuple[s.Node, int], str] = {}  # initial value and offset -> function
        self.dispatch = Dispatch([*project.reached], self.need, self._no_instance)
        self.copies: set[str] = set()  # of programs, for instances after the first
        self.texts: dict[tuple[str, bool], int] = {}
        self.templates: dict[object, int] = {}
        self.constants = bytearray()  # strings and templates, after the variables
        self.late: list[tuple[int, Late]] = []  # (address of the instance or variable, value)
        self.areas = {}
        for area, used in project.areas.items():
            self.areas[area] = project.allocate(align(used, 8), 8)
        self.constants_at = align(project.top, 8)
        self.addressed: set[tuple[int, int]] = set()  # variables whose address is taken: where each begins and ends
        self.rooms = False  # $room_at is called

    # ------------------------------------------------------------------------------- what functions ask

    def need(self, pou: Pou) -> None:
        """The module calls this POU."""
        if pou.symbol in self.needed:
            return
        self.needed[pou.symbol] = (pou, None)
        if pou.external:
            self._import(pou)
        else:
            self.queue.append((pou.symbol, pou, None, pou.address))

    def need_action(self, pou: Pou, action: s.Action) -> str:
        name = f"{pou.symbol}.{action.name}"
        if name not in self.needed:
            self.needed[name] = (pou, action)
            self.queue.append((name, pou, action, pou.address))
        return name

    def need_instance(self, pou: Pou, action: s.Action | None, address: int) -> str:
        """The code of a program or its action for the instance at an address; each has its own."""
        if address == pou.address:
            self.need(pou)
            return pou.symbol if action is None else self.need_action(pou, action)
        name = f"{pou.symbol}{'.' + action.name if action else ''}.{address}"
        if name not in self.copies:
            self.copies.add(name)
            self.queue.append((name, pou, action, address))
        return name

    def _import(self, pou: Pou) -> None:
        inputs = [(p.name, p.type) for p in pou.inputs()]
        self.externals.append(External(_host_name(pou), inputs, pou.result.type if pou.result else None))

    def site(self, source: Source, node: s.Node, pou: str, code: str, note: str, within: int = -1) -> int:
        line, column = source.position(node.start)
        return self.sites.add(source.path, line, column, pou, code, " ".join(note.split()) if note else "", within)

    def string(self, text: str, wide: bool) -> int:
        """The address of a constant string."""
        if (text, wide) not in self.texts:
            data = encode_text(text, wide) + (b"\0\0" if wide else b"\0")
            self.texts[text, wide] = self._constant(data, 2 if wide else 1)
        return self.texts[text, wide]

    def _constant(self, data: bytes, alignment: int) -> int:
        self.constants += bytes(-len(self.constants) % alignment)
        address = self.constants_at + len(self.constants)
        self.constants += data
        return address

    def room_at(self, end: int) -> str:
        """The function that gives where the variable ends that an address lies in: the outermost of those whose address
        is taken somewhere; else `end`, that of all variables."""
        tests = "".join(
            f" (if (i32.lt_u (i32.sub (local.get 0) (i32.const {low})) (i32.const {high - low}))"
            f" (then (return (i32.const {high}))))"
            for low, high in sorted(self.addressed, key=lambda x: (x[0] - x[1], x))
        )
        return f"(func $room_at (param i32) (result i32){tests} (i32.const {end}))" if self.rooms else ""

    def template(self, var: Var) -> int:
        """The address of the initial bytes of a function's variable; 0 when they are all zero."""
        mark = var if var.init is not None else var.type
        if mark not in self.templates:
            data, _ = self.images.of_variable(var)
            self.templates[mark] = self._constant(data, 8) if any(data) else 0
        return self.templates[mark]

    def zeros(self, size: int) -> int:
        """The address of so many zero bytes."""
        if size not in self.templates:
            self.templates[size] = self._constant(bytes(size), 8)
        return self.templates[size]

    def initial_value(self, var: Var) -> object:
        """The constant (or else the checked expression) that a variable starts with."""
        if var.init is not None:
            node = check_init(self.project, var.init, var.type)
            if not isinstance(node, s.ArrayInit | s.StructInit):
                return node.const if node.const is not None else node
        data, _ = self.images.of_type(var.type)
        return int.from_bytes(data, "little") if any(data) else 0

    # ------------------------------------------------------------------------------------------- module

    def emit(self, tasks: list[TaskSpec], hooks: list[Pou], kept: list[Pou]) -> str:
        """The module's text. tasks name programs of the project; hooks run after the tasks of every scan; kept are in
        the module even if nothing calls them."""
        scan = self._scan(tasks, hooks)
        for pou in (p for p in kept if p.kind != "INTERFACE"):
            self.need(pou)
            for action in pou.actions.values():
                self.need_action(pou, action)
        self._keep_methods(kept)
        start = self._initialisation()
        self._drain()
        limit = self.image_end = align(self.constants_at + len(self.constants), 16)
        limit += SIDE_SIZE + STACK_SIZE
        self.limit = limit
        parts = ["(module", *self._imports(), _KERNEL.read_text(encoding="utf-8")]
        if self.probes:
            counts, branches = 4 * len(self.sites), 4 * len(self.branches)
            self.limit += counts + branches + len(self.sites)
            parts.append(_PROBES.read_text(encoding="utf-8"))
            parts.append(f"(global $counts i32 (i32.const {limit}))")
            parts.append(f"(global $branches i32 (i32.const {limit + counts}))")
            parts.append(f"(global $flags i32 (i32.const {limit + counts + branches}))")
        self.stack_top = limit
        parts += [
            f"(global $span i32 (i32.const {limit - NULL_PAGE}))",
            f"(global $stack i32 (i32.const {self.image_end + SIDE_SIZE}))",
            f"(global (export \"stack_top\") i32 (i32.const {limit}))",
            scan,
            start,
            *self.functions,
            *self.dispatch.functions.values(),
            self.room_at(self.constants_at),
            *(f'(export "{symbol[1:]}" (func {symbol}))' for symbol in [*self.needed, *self.dispatch.functions]),
            ")",
        ]
        return "\n".join(parts)

    def _keep_methods(self, kept: list[Pou]) -> None:
        """All methods of these POUs can be called by what is typed beside the program; tests have a function each."""
        for pou in kept:
            if pou.kind == "FUNCTION_BLOCK":
                self.dispatch.body(pou)
            for method in pou.methods.values():
                if not abstract(method):
                    self.need(method)
                if abstract(method) or not self.dispatch.is_only(method):
                    self.dispatch.method(method)
        for pou, address in self.project.test_instances.items():
            for method in methods_to_test(pou):
                params, results = signature(method)
                call = f"(call {method.symbol} (i32.const {address}))" + " drop" * len(results)
                call = "unreachable" if params else call  # who runs the test says that it may have none
                self.functions.append(f'(func (export "{test_export(pou, method)}") {call})')

    def _no_instance(self, pou: Pou) -> str:
        """The marker of the fault that an instance known as one of this block or interface is none."""
        at = pou.tree
        return f"(drop (i32.const {self.site(pou.source, at, pou.name, 'F0109', pou.name)}))"

    def _imports(self) -> list[str]:
        lines = ['(import "host" "probe" (func $probe (param i32 i32 i32 i32)))'] if self.probes else []
        for e in self.externals:
            params = " ".join(f"(param {wasm_type(k)})" for _, k in e.parameters)
            result = f"(result {wasm_type(e.result)})" if e.result else ""
            symbol = next(p.symbol for p, _ in self.needed.values() if _host_name(p) == e.name)
            lines.append(f'(import "host" "{e.name}" (func {symbol} {params} {result}))')
        return lines

    def _scan(self, tasks: list[TaskSpec], hooks: list[Pou]) -> str:
        """One scan: each task that is due, then the hooks."""
        lines = ["(func $scan", *self._mirrored("IM", "$inputs")]
        for i, task in enumerate(tasks):
            calls = []
            for name in task.programs:
                calls.append(f"(call {self._connected(name, task)})")
            text = " ".join(calls)
            if task.test:
                first = next(k for k, x in enumerate(tasks) if x.test)
                text = f"(if (i32.eq (i32.load (i32.const {ALONE})) (i32.const {i - first + 1})) (then {text}))"
            elif len(tasks) > 1:
                ratio = f"(i64.extend_i32_u (i32.load (i32.const {TASK_RATIOS + 4 * i})))"
                due = f"(i64.eqz (i64.rem_u (i64.load (i32.const 24)) {ratio}))"
                text = f"(if {due} (then {text}))"
            lines.append(text)
        lines += self._mirrored("QM", "$outputs")
        for pou in hooks:
            self.need(pou)
            lines.append(f"(call {pou.symbol})")
        return "\n".join([*lines, ")"])

    def _connected(self, name: str, task: TaskSpec) -> str:
        """The function that a task calls: the program, or its call with the arguments of the configuration."""
        _, pou, address = self.project.program_instances.get(key(name), ("", self.project.lookup(name), None))
        symbol = self.need_instance(pou, None, pou.address if address is None else address)
        node, source = self.project.connections.get(key(name), (None, None))
        if node is None:
            return symbol
        emitter = FunctionEmitter(self, Pou("FUNCTION", task.name, s.Exit(node.start, node.end), source), source)
        emitter.statement(node)
        name = f"{symbol}.connected"
        self.functions.append(emitter._assemble(name, [], [], [], emitter.lines))
        return name

    def _mirrored(self, areas: str, name: str) -> list[str]:
        """The call that moves what VAR_CONFIG has placed between the members of instances and these areas."""
        moved = [m for m in self.project.mirrors if m.area is not None and m.area.area in areas]
        if not moved:
            return []
        emitter = FunctionEmitter(self, Pou("FUNCTION", "VAR_CONFIG", moved[0].decl, moved[0].source), moved[0].source)
        for mirror in moved:
            emitter.source = mirror.source
            sides = [place_node(mirror.decl, var) for var in (mirror.member, mirror.area)]
            to, value = sides if name == "$inputs" else sides[::-1]
            emitter.statement(s.Assign(mirror.decl.start, mirror.decl.end, to, ":=", value))
        self.functions.append(emitter._assemble(name, [], [], [], emitter.lines))
        return [f"(call {name})"]

    def late_code(self, late: Late) -> str:
        """A function that gives a member of an instance its initial value; for instances that calls make anew."""
        mark = late.node, late.offset - late.owner
        name = self.late_codes.get(mark)
        if name is None:
            name = self.late_codes[mark] = f"$late{len(self.late_codes)}"
            emitter = FunctionEmitter(self, late.pou, late.source)
            emitter.set_late(late, "(local.get $this)", -late.owner)
            self.functions.append(emitter._assemble(name, ["(param $this i32)"], [], [], emitter.lines))
        return name

    def _drain(self) -> None:
        while self.queue:
            # callers first: what has one call is taken in where the tasks run it
            name, pou, action, address = self.queue.popleft()
            emitter = FunctionEmitter(self, pou, pou.source, address)
            body = pou.tree.body if action is None else action.body
            self.functions.append(emitter.code(body, name))
            if self.probes:
                hook = "call_after_scan" in pou.attributes
                self.bodies[emitter.number] = Body(pou.full_name, pou.type, address, emitter.seen, pou.library, hook)

    def _initialisation(self) -> str:
        """$init: the initial values that are not constants, each in the names of its own instance."""
        for address, kind, var in self.storage():
            data, late = self.images.of_variable(var) if var is not None else self.images.of_type(kind)
            self.late += [(address, x) for x in late]
        lines = []
        for base, late in self.late:
            pou = late.pou
            emitter = FunctionEmitter(self, pou or _NOWHERE, late.source, base + late.owner)
            emitter.set_late(late, "", base)
            name = f"$init{len(lines)}"
            self.functions.append(emitter._assemble(name, [], [], [], emitter.lines))
            lines.append(f"(call {name})")
        return "\n".join(['(func (export "init")', *lines, ")"])

    def storage(self):
        """(address, type, variable or None) of everything that the image holds, constants first."""
        for var in sorted(self.project.globals, key=lambda v: not v.constant):
            yield self.address_of(var), var.type, var
        for pou in self.project.pous:
            for var in pou.variables.values():
                if var.owner is pou and var.storage in ("global", "area"):
                    yield self.address_of(var), var.type, var
            if pou.address is not None:
                yield pou.address, pou.type, None
        for _, pou, address in self.project.program_instances.values():
            if address != pou.address:
                yield address, pou.type, None
        for pou, address in self.project.test_instances.items():
            yield address, pou.type, None

    def address_of(self, var: Var) -> int:
        return self.areas[var.area] + var.address if var.storage == "area" else var.address

    def image(self) -> bytes:
        """The first image, from 0 to image_end."""
        image = bytearray(self.image_end)
        for address, kind, var in self.storage():
            data, _ = self.images.of_variable(var) if var is not None else self.images.of_type(kind)
            if var is not None and var.bit is not None:
                image[address] |= data[0] << var.bit
            else:
                image[address : address + len(data)] = data
        for mirror in self.project.mirrors:
            if mirror.init is not None:
                node = check_init(self.project, mirror.init, mirror.member.type)
                data, _ = self.images.value(node, mirror.member.type, mirror.init)
                image[mirror.member.address : mirror.member.address + len(data)] = data
        image[self.constants_at : self.constants_at + len(self.constants)] = self.constants
        return bytes(image)


_NOWHERE = Pou("FUNCTION", "initial value", s.Exit(0, 0), Source(""))


def _host_name(pou: Pou) -> str:
    """The name of an external function; of a generic one each instance has its own."""
    return f"{pou.name} {', '.join(str(p.type) for p in pou.inputs())}" if pou.tree.generics else pou.name

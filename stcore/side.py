"""ST typed while a program is loaded: an expression or statements as a small module of its own.

A side module shares the memory, the stack and the functions of the program's module. It is compiled against the
Program, not against source text, so that it works on a build that comes from the cache. Names are those of paths:
full ones, and a variable without its program where that is unique; functions and blocks of the program are called in
it, a function of the library that the program does not use is compiled along.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from stcore import syntax as s
from stcore import types as t
from stcore.build_program import at_full_length
from stcore.check import Checker
from stcore.diagnostics import CompileError, Diagnostic, Reporter
from stcore.emit import ModuleEmitter
from stcore.emit.dispatch import Dispatch, signature
from stcore.emit.function import FunctionEmitter
from stcore.emit.values import load, store
from stcore.known import Known, Names, Scene
from stcore.machine import SIDE, assemble
from stcore.parser import parse_expression, parse_statements
from stcore.program import NULL_PAGE, SIDE_SIZE, Program, Site
from stcore.scope import Pou, Var
from stcore.source import Source

CONDITIONS = SIDE_SIZE // 2  # the lower half is for what runs at once, the upper for conditions that stay
ROOM = SIDE_SIZE // 2


class SideError(Exception):
    """What was typed can't be run beside the program: one clear sentence."""


@dataclass(slots=True)
class Side:
    """A side module. type: of the result, None for statements; its address is what the function gives. size: bytes of
    constants that it occupies. sites: the places of its own checks. simple: it calls nothing of the program and checks
    nothing, so that it can't fail."""

    wasm: bytes
    type: t.Type | None
    size: int
    sites: Sequence[Site]
    simple: bool = False


def compile_side(names: Names, text: str, scene: Scene | None = None) -> Side:
    """An expression, or statements; what can be read as both is an expression.

    scene: the POU whose own variables are known besides, as where a probe stopped; the function then takes the address
    of its instance and of its stack frame. Raises CompileError, SideError.
    """
    source = Source(text, "<input>")
    quiet = Reporter()
    tree = parse_expression(source, quiet)
    if tree is not None and not quiet.failed:
        return _compile(names, source, tree, scene)
    reporter = Reporter()
    body = parse_statements(source, reporter)
    if reporter.failed:
        raise CompileError(max(reporter.sorted(), quiet.sorted(), key=_reach))
    return _compile(names, source, body, scene)


def _reach(diagnostics: list[Diagnostic]) -> tuple[int, int, int]:
    """How well a text was understood: few errors, the first of them far behind."""
    errors = [d for d in diagnostics if d.severity == "error"]
    return -len(errors), errors[0].line, errors[0].column


def compile_condition(program: Program, text: str) -> bytes:
    """A module whose function tells whether a condition holds, for the scan loop. Raises CompileError, SideError."""
    return condition(Names(program), text).wasm


def condition(names: Names, text: str, scene: Scene | None = None, offset: int = 0) -> Side:
    """A condition that may stay linked. offset: bytes that other conditions occupy."""
    source = Source(text, "<condition>")
    reporter = Reporter()
    tree = parse_expression(source, reporter)
    if reporter.failed or tree is None:
        raise CompileError(reporter.sorted())
    return _compile(names, source, tree, scene, CONDITIONS + offset, boolean=True)


def _compile(names: Names, source: Source, tree, scene: Scene | None, offset: int = 0, boolean: bool = False) -> Side:
    with at_full_length([source]):
        return _compiled(names, source, tree, scene, offset, boolean)


def _compiled(names: Names, source: Source, tree, scene: Scene | None, offset: int, boolean: bool) -> Side:
    program = names.program
    reporter = Reporter()
    at = program.image_end + offset
    project = Known(names, reporter, at + 16)  # the first bytes are for the result
    pou = project.scene_pou(scene)
    checker = Checker(project, source, pou, False)
    checker.labels = set()
    if isinstance(tree, list):
        checker.labels = {x.name.upper() for x in tree if isinstance(x, s.Label)}
        checker.body(tree)
    elif boolean:
        tree = checker.boolean(tree, "a condition")
    else:
        tree = checker.settle(checker.expr(tree))
        if tree.type is None and not isinstance(tree, s.Call):
            tree = checker.value(tree)
    project.check_reached()
    if reporter.failed:
        raise CompileError(reporter.sorted())
    project.check_addresses()
    project.spread_writes()
    emitter = _Emitter(project)
    function = FunctionEmitter(emitter, pou, source, None)
    return _module(emitter, function, tree, scene, at, boolean)


def _module(emitter: _Emitter, function: FunctionEmitter, tree, scene, at: int, boolean: bool) -> Side:
    """Emit the function and everything that goes with it."""
    emitter.take_locals(function)
    prologue, function.lines = function.lines, []
    if isinstance(tree, list) or tree.type is None:
        kind, result = None, "(i32.const 0)"
        function.body(tree if isinstance(tree, list) else [s.ExprStmt(tree.start, tree.end, tree)])
    elif boolean:
        kind, result = t.BOOL, function.value(tree)
    else:
        kind, result = tree.type, _result(function, tree, at)
    main, function.lines = function.lines, []
    params = [] if boolean and scene is None else ["(param $this i32)", "(param $outer i32)"]
    if boolean:
        # the result may need the frame, which is given back behind it
        function.declared.append("(local $result i32)")
        main.append(f"(local.set $result {result})")
        result = "(local.get $result)"
    function._results = lambda: [result]
    text = function._assemble("$side", params, ["i32"], prologue, main)
    start = emitter._initialisation()
    emitter._drain()
    room = ROOM - (at - emitter.project.names.program.image_end) % ROOM
    data, size = emitter.data(at, room)
    program = emitter.project.names.program
    stack = f"(global $span i32 (i32.const {program.stack_top - NULL_PAGE}))"
    stack += f" (global $stack i32 (i32.const {program.image_end + SIDE_SIZE}))"
    code = "\n".join([start, *emitter.functions, emitter.room_at(program.state_end), text])
    module = [
        f"(module ${SIDE}", '(import "plc" "memory" (memory 1)) (import "plc" "sp" (global $sp (mut i32)))',
        *emitter.imported.values(), _helpers(code), stack, code, '(export "side" (func $side))', data, ")",
    ]  # fmt: skip
    simple = not emitter.imported and not emitter.functions and not emitter.sites
    return Side(assemble("\n".join(module)), kind, size, emitter.sites, simple)


@functools.cache
def _kernel() -> dict[str, str]:
    """The functions of the kernel by name."""
    text = (Path(__file__).parent / "emit" / "kernel.wat").read_text(encoding="utf-8")
    forms = re.split(r"^(?=\()", re.sub(r"^;;.*$", "", text, flags=re.M), flags=re.M)
    return {form.split()[1]: form for form in forms if form.startswith("(func ")}


def _helpers(code: str) -> str:
    """The kernel's functions that some code calls, and those that they call."""
    found: dict[str, str] = {}
    todo = [code]
    while todo:
        for name in re.findall(r"\(call (\$\w+)", todo.pop()):
            if name in _kernel() and name not in found:
                found[name] = _kernel()[name]
                todo.append(found[name])
    return "\n".join(found.values())


def _result(function: FunctionEmitter, tree: s.Node, at: int) -> str:
    """The address of the value of an expression."""
    if t.is_aggregate(tree.type):
        text = function.value(tree)
        function.declared.append("(local $result i32)")
        function.line(f"(local.set $result {text})")
        return "(local.get $result)"
    function.line(store(tree.type, "", at, function.narrow(tree)))
    return f"(i32.const {at})"


class _Emitter(ModuleEmitter):
    """Emits what a side module holds itself, and imports the rest from the program's module."""

    def __init__(self, project: Known) -> None:
        super().__init__(project)
        self.inlining = None  # what the program's module holds is called there
        program = project.names.program
        self.areas = {"I": program.inputs[0], "Q": program.outputs[0], "M": program.markers[0]}
        self.addressed = set(program.taken)
        self.imported: dict[str, str] = {}
        self.dispatch = _Choosers(self)

    def need(self, pou: Pou) -> None:
        export = self.project.exports.get(pou)
        if export is None:
            if pou.external:
                raise SideError(f"{pou.name} is provided by the host only to a program that uses it")
            super().need(pou)
            return
        signature = self._signature(pou)
        self.imported[pou.symbol] = f'(import "plc" "{export}" (func {pou.symbol} {signature}))'

    def choose(self, pou: Pou) -> str:
        """The program's function that finds out which code an instance has in the place of this one."""
        name = f"{pou.symbol}.of"
        export = self.project.names.choosers[pou]
        self.imported[name] = f'(import "plc" "{export}" (func {name} {self._signature(pou)}))'
        return name

    def need_action(self, pou: Pou, action: s.Action) -> str:
        export = self.project.exports.get(pou)
        if export is None:
            return super().need_action(pou, action)
        name = f"{pou.symbol}.{action.name}"
        self.imported[name] = f'(import "plc" "{action.body}" (func {name} {self._signature(pou)}))'
        return name

    def need_instance(self, pou: Pou, action: s.Action | None, address: int) -> str:
        if address != pou.address:
            raise SideError(f"of the instances of {pou.name} only the first can be called here")
        return super().need_instance(pou, action, address)

    def _signature(self, pou: Pou) -> str:
        if not pou.is_called:
            return "" if pou.kind == "PROGRAM" else "(param i32)"
        params, results = signature(pou)
        if pou.holder is not None:
            params.insert(0, "i32")
        head = f"(param {' '.join(params)})" if params else ""
        return f"{head} (result {' '.join(results)})" if results else head

    def template(self, var: Var) -> int:
        """The initial bytes of a parameter of the program's function are in its signature."""
        data = self.project.defaults.get(var)
        if data is None:
            return super().template(var)
        if var not in self.templates:
            self.templates[var] = self._constant(data, 8) if data else 0
        return self.templates[var]

    def initial_value(self, var: Var) -> object:
        data = self.project.defaults.get(var)
        return super().initial_value(var) if data is None else self.project.constant_of(var.type, data)

    def take_locals(self, function: FunctionEmitter) -> None:
        """Locals of the function where a probe stopped: their addresses, from its stack frame."""
        for var, (offset, by_reference) in self.project.frame.items():
            name = self.project.local_names[var]
            function.locals_of[var] = name
            function.declared.append(f"(local {name} i32)")
            here = f"(i32.add (local.get $outer) (i32.const {offset}))"
            if by_reference:
                here = load(t.DWORD, "(local.get $outer)", offset)
            function.line(f"(local.set {name} {here})")

    def data(self, at: int, room: int) -> tuple[str, int]:
        """The data segment of constants and of the library's own variables, and its size from `at`."""
        self.image_end = self.constants_at + len(self.constants)
        size = self.image_end - at
        if size > room:
            raise SideError("that needs more memory than there is beside the program; put it into the program")
        image = self.image()[at:]
        text = "".join(f"\\{byte:02x}" for byte in image)
        return f'(data (i32.const {at}) "{text}")', size


class _Choosers(Dispatch):
    """Calls of which only the instance knows the code: the program's module decides."""

    def __init__(self, emitter: _Emitter) -> None:
        super().__init__([], emitter.need, str)
        self.emitter = emitter

    def is_only(self, code: Pou) -> bool:
        return code not in self.emitter.project.names.choosers

    def method(self, method: Pou) -> str:
        return self.emitter.choose(method)

    body = method

    def query(self, interface: Pou) -> str:
        raise SideError(f"whether an instance has {interface.name} can only be asked in the program")


def summary(diagnostics: list[Diagnostic]) -> str:
    """The first error in one sentence."""
    error = next(d for d in diagnostics if d.severity == "error")
    return f"{error.message}{'; ' + error.hint if error.hint else ''}"


__all__ = ["Side", "SideError", "compile_condition", "compile_side", "condition", "summary"]

"""An ST expression over a compiled program, as a small module of its own that shares the program's memory.

It ends a run (`--until`, run_until): the scan loop asks it after every scan. It is compiled against the Program, not
against source text, so that it works on a build that comes from the cache.
"""

from __future__ import annotations

from pathlib import Path

from stcore import types as t
from stcore.check import CheckedProject, Checker
from stcore.declare import Pending
from stcore.diagnostics import CompileError, Reporter
from stcore.emit import ModuleEmitter
from stcore.emit.function import FunctionEmitter
from stcore.machine import assemble
from stcore.parser import parse_expression
from stcore.program import NULL_PAGE, Program
from stcore.scope import EnumValue, GlobalList, Pou, TypeName, Var, key
from stcore.source import Source

_KERNEL = Path(__file__).parent / "emit" / "kernel.wat"
_IMPORT = '(import "plc" "memory" (memory 1))'


class _Known(CheckedProject):
    """The names of a compiled program: its globals, its programs' instances, and a program's variable alone."""

    def __init__(self, program: Program, reporter: Reporter) -> None:
        super().__init__(reporter, [])
        self.program = program
        for path, variable in program.variables.items():
            var = Var(variable.name, variable.type, "global", variable.address, bit=variable.bit)
            self._know(path, var)
            if "." in path:
                head, _, name = path.rpartition(".")
                self._know(name, var)
                group = self._know(head, GlobalList(head, set()))
                if isinstance(group, GlobalList):  # else the variable of a program, at a direct address
                    group.variables.add(name)
        for variable in program.programs():
            for name, field in variable.type.members.items():
                static = field.section == "VAR_STAT"
                address = field.offset if static else variable.address + field.offset
                self._know(name, Var(field.name, field.type, "global", address, indirect=field.by_reference))
        for name, kind in program.types.items():
            self._know(name, TypeName(kind))
            if isinstance(kind, t.Enum):
                for label, number in kind.values.items():
                    self._know(key(label), EnumValue(kind, number))
            elif isinstance(kind, t.Block):
                self.block_pous[kind] = Pou(kind.kind, kind.name, None, Source(""), type=kind)

    def _know(self, name: str, symbol: object) -> object:
        entry = self.user.setdefault(name, Pending("known", None, Source(""), False, symbol=symbol))
        return entry.symbol


def compile_condition(program: Program, text: str) -> bytes:
    """The module. Raises CompileError when the text is no condition over the program's variables."""
    source = Source(text, "<condition>")
    reporter = Reporter()
    tree = parse_expression(source, reporter)
    project = _Known(program, reporter)
    checker = Checker(project, source, None, False)
    if tree is not None:
        tree = checker.boolean(tree, "a condition")
    if reporter.failed or tree is None:
        raise CompileError(reporter.sorted())
    project.top = program.limit
    emitter = ModuleEmitter(project)
    emitter.areas = {"I": program.inputs[0], "Q": program.outputs[0], "M": program.markers[0]}
    function = FunctionEmitter(emitter, Pou("PROGRAM", "condition", None, source), source, 0)
    value = function.value(tree)
    kernel = _KERNEL.read_text(encoding="utf-8").replace('(memory (export "memory") 1)', "")
    module = [
        "(module", _IMPORT, kernel,
        f"(global $span i32 (i32.const {program.limit - NULL_PAGE})) (global $stack i32 (i32.const 0))",
        "(func $scan)", *emitter.functions,
        '(func (export "condition") (result i32)', *function.declared, value, ")", ")",
    ]  # fmt: skip
    return assemble("\n".join(module))

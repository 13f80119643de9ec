"""What a module offers to those outside: the code of every POU by name, for typed statements and for tests."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stcore.objects import method_key
from stcore.program import Parameter, Routine
from stcore.scope import Pou, Var

if TYPE_CHECKING:
    from stcore.emit import ModuleEmitter


def methods_to_test(pou: Pou) -> list[Pou]:
    """The methods of a block, its own and inherited ones, that are tests."""
    names = dict.fromkeys(n for x in reversed([*pou.chain()]) for n in x.methods)
    return [m for m in map(pou.method, names) if "test" in m.attributes and m.kind == "METHOD"]


def test_export(pou: Pou, method: Pou) -> str:
    """Under which name a module exports the function that runs a method of a block as a test."""
    return f"{pou.symbol[1:]}:{method.symbol[1:]}"


def routines(emitter: ModuleEmitter) -> dict[str, Routine]:
    """Every POU of the module by upper-case name, but for the instances of generic functions; a method as Block.Method,
    an accessor of a property as Block.Property.GET."""
    found: dict[str, Routine] = {}
    taken = emitter.inlining.taken if emitter.inlining else {}
    pous = {pou: None for pou, _ in emitter.needed.values()} | taken
    for pou in sorted((p for p in pous if not p.bindings and p.holder is None), key=lambda p: p.library):
        names = {n: f"{pou.symbol}.{a.name}" for n, a in pou.actions.items()}
        routine = _routine(emitter, pou)
        routine.actions = {n: symbol[1:] for n, symbol in names.items() if symbol in emitter.needed}
        found.setdefault(pou.name.upper(), routine)
    for pou in emitter.project.reached:
        if pou.holder is not None:
            found.setdefault(f"{pou.holder.name}.{method_key(pou.tree)}".upper(), _routine(emitter, pou))
    for pou in emitter.project.test_instances:
        for method in methods_to_test(pou):
            routine = found.setdefault(f"{pou.name}.{method.name}".upper(), _routine(emitter, method))
            routine.name, routine.test = f"{pou.name}.{method.name}", test_export(pou, method)
    return found


def _routine(emitter: ModuleEmitter, pou: Pou) -> Routine:
    routine = Routine(
        pou.full_name, pou.kind, pou.symbol[1:] if pou.symbol in emitter.needed else "", library=pou.library,
        file=pou.source.path, line=pou.source.position(pou.tree.name_start)[0], attributes=pou.attributes,
    )  # fmt: skip
    chooser = f"{pou.symbol}.of"
    routine.chooser = chooser[1:] if chooser in emitter.dispatch.functions else ""
    if pou.is_called:
        routine.parameters = [_parameter(emitter, p) for p in pou.parameters]
        routine.result = pou.result.type if pou.result is not None else None
    return routine


def _parameter(emitter: ModuleEmitter, var: Var) -> Parameter:
    data = emitter.images.of_variable(var)[0] if var.section != "VAR_IN_OUT" else b""
    return Parameter(var.name, var.type, var.section, var.constant, data if any(data) else b"", var.room_of)

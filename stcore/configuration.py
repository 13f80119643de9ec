"""CONFIGURATION: instances of programs, the tasks that run them; variables that VAR_CONFIG and VAR_ACCESS name."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial

from stcore import syntax as s
from stcore import types as t
from stcore.check import CheckedProject, Checker
from stcore.check.conversions import same
from stcore.check.initial import check_init
from stcore.declare import Declarer
from stcore.direct import place_direct
from stcore.near import near
from stcore.program import TaskSpec
from stcore.scope import GlobalList, Init, Pou, Var, key, place_node
from stcore.source import Source

_STEP = re.compile(r"[^\W\d]\w*|\[[^\]]*\]")


@dataclass(slots=True)
class Mirror:
    """A member of an instance that VAR_CONFIG gives a direct address. The member has its own bytes, which are read from
    the inputs before the tasks of a scan and go to the outputs after them, as a process image does."""

    decl: s.VarDecl
    source: Source
    member: Var
    area: Var | None = None
    init: Init | None = None


def configure(project: CheckedProject) -> None:
    """Take the instances, connections and addresses of all configurations; errors go to the reporter."""
    _instances(project)
    _connect(project)
    for path, (decl, source) in project.configured.items():
        _mirror(project, path, decl, source)
    for decl, source in project.access_paths:
        _access(project, decl, source)


def tasks(project: CheckedProject) -> list[TaskSpec]:
    """The tasks of the configurations, the highest priority first."""
    made: dict[str, TaskSpec] = {}
    for tree, source in project.configurations:
        for task in tree.tasks:
            values = {n: project.evaluate(v, source, None, False) for n, v in task.properties.items()}
            interval = values.get("INTERVAL")
            made[key(task.name)] = TaskSpec(
                task.name, [], interval * 10**6 if isinstance(interval, int) else None, values.get("PRIORITY") or 0
            )
        for instance in tree.programs:
            task = made.setdefault(key(instance.task or "main"), TaskSpec(instance.task or "main", []))
            several = key(instance.name) in project.program_instances
            task.programs.append(instance.name if several else instance.type_name)
    return sorted((x for x in made.values() if x.programs), key=lambda x: x.priority)


def _instances(project: CheckedProject) -> None:
    """Room for each instance of a program that has several; a program with one keeps its own name."""
    by_type: dict[str, list[tuple[s.ProgramInstance, Source]]] = {}
    names: dict[str, int] = {}
    for tree, source in project.configurations:
        for instance in tree.programs:
            line = source.position(instance.start)[0]
            if key(instance.name) in names:
                at = instance.start, instance.end
                project.reporter.add("E0201", source, *at, name=instance.name, line=names[key(instance.name)])
                continue
            names[key(instance.name)] = line
            by_type.setdefault(key(instance.type_name), []).append((instance, source))
    for name, found in by_type.items():
        pou = project.lookup(name)
        if not isinstance(pou, Pou) or pou.kind != "PROGRAM":
            continue  # the task that runs it says so
        first = project.instance(pou)
        for i, (instance, _) in enumerate(found):
            if len(found) == 1:
                project.aliases[key(instance.name)] = pou.name
                continue
            address = first if i == 0 else project.allocate(pou.type.size, 8)
            project.program_instances[key(instance.name)] = (instance.name, pou, address)
        if len(found) > 1:
            project.aliases[name] = found[0][0].name


def _connect(project: CheckedProject) -> None:
    """PROGRAM p WITH task : Prg(x := a, y => b): the task calls the program with these arguments."""
    for tree, source in project.configurations:
        for instance in tree.programs:
            if not instance.inits:
                continue
            at = (instance.start, instance.end)
            call = s.Call(*at, s.Name(*at, instance.type_name), instance.inits)
            node = s.ExprStmt(*at, call)
            Checker(project, source, None, False).statement(node)
            several = project.program_instances.get(key(instance.name))
            if several is not None and node.expr.symbol is not None:
                _, pou, address = several
                node.expr.symbol.instance = place_node(node, Var(instance.name, pou.type, "global", address))
            project.connections[key(instance.name if several else instance.type_name)] = (node, source)


class _Lost(Exception):
    """A path that leads nowhere: why."""


def _mirror(project: CheckedProject, path: str, decl: s.VarDecl, source: Source) -> None:
    """One variable of VAR_CONFIG. Those of a program itself have been placed where they are declared."""
    program, _, name = path.partition(".")
    pou = project.lookup(program)
    if isinstance(pou, Pou) and pou.kind == "PROGRAM" and name in pou.variables:
        if key(program) not in project.program_instances:
            return
    found = _found(project, decl, source, decl.name)
    if found is None:
        return
    kind, address = found
    mirror = Mirror(decl, source, Var(decl.name, kind, "global", address))
    if decl.init is not None:
        mirror.init = Init(decl.init, source)
        check_init(project, mirror.init, kind)
    if decl.address:
        mirror.area = _direct(project, decl, source, kind, decl.address)
    project.mirrors.append(mirror)


def _access(project: CheckedProject, decl: s.VarDecl, source: Source) -> None:
    """One name of VAR_ACCESS: another path to a variable, for those who look at the program from outside."""
    path = decl.address
    if "%" in path:
        path = path[path.index("%") :]
        _direct(project, decl, source, Declarer(project, source, False).type(decl.type), path)
    else:
        if _found(project, decl, source, path) is None:
            return
        steps = _own_steps(project, path)
        path = steps[0] + "".join(x if x[0] == "[" else f".{x}" for x in steps[1:])
    project.accesses[key(decl.name)] = (path, decl.attributes["rights"] == "READ_ONLY")


def _direct(project: CheckedProject, decl: s.VarDecl, source: Source, kind: t.Type, address: str) -> Var:
    """A variable at a direct address, with room for it."""
    var = Var(decl.name, kind, "area")
    wrong = partial(project.reporter.add, "E0206", source, decl.start, decl.end, address=address)
    place_direct(var, address.upper(), wrong)
    project.direct(var)
    return var


def _found(project: CheckedProject, decl: s.VarDecl, source: Source, path: str) -> tuple[t.Type, int] | None:
    """Type and address of what a path leads to, which must have the type that the declaration says."""
    said, why = Declarer(project, source, False).type(decl.type), ""
    try:
        kind, address = _follow(project, path)
        if same(said, kind) or t.ERROR in (said, kind):
            return kind, address
        why = f"it is declared as {kind}, not {said}"
    except _Lost as lost:
        why = str(lost)
    project.reporter.add("E0209", source, decl.start, decl.start + len(decl.name), name=decl.name, why=why)
    return None


def _own_steps(project: CheckedProject, path: str) -> list[str]:
    """The steps of a path without the names of the configuration and of a resource in front."""
    steps = _STEP.findall(path)
    outer = {key(x) for tree, _ in project.configurations for x in (tree.name, *tree.resources)}
    while len(steps) > 1 and key(steps[0]) in outer and key(steps[0]) not in project.program_instances:
        steps = steps[1:]
    return steps


def _follow(project: CheckedProject, path: str) -> tuple[t.Type, int]:
    """Type and address of a variable by its path from a program instance or a global variable. Raises _Lost."""
    steps = _own_steps(project, path)
    kind, address, rest = _root(project, steps)
    for step in rest:
        if step[0] == "[":
            kind, address = _element(project, kind, address, step)
            continue
        members = kind.members if isinstance(kind, t.Struct | t.Block) else {}
        field = members.get(key(step))
        if field is None:
            known = [f.name for f in members.values()]
            raise _Lost(f"{kind} has no member {step}" + (f"; {hint}" if (hint := near(step, known)) else ""))
        if field.by_reference:
            raise _Lost(f"{field.name} is VAR_IN_OUT")
        kind, address = field.type, field.offset if field.section == "VAR_STAT" else address + field.offset
    return kind, address


def _root(project: CheckedProject, steps: list[str]) -> tuple[t.Type, int, list[str]]:
    """The variable or program that a path begins with, and the steps that follow."""
    name = project.aliases.get(key(steps[0]), steps[0])
    if key(name) in project.program_instances:
        _, pou, address = project.program_instances[key(name)]
        return pou.type, address, steps[1:]
    symbol, rest = project.lookup(name), steps[1:]
    if isinstance(symbol, GlobalList) and rest:
        symbol, rest = project.lookup(f"{symbol.name}.{rest[0]}"), rest[1:]
    if isinstance(symbol, Pou) and symbol.kind == "PROGRAM":
        return symbol.type, project.instance(symbol), rest
    if isinstance(symbol, Var) and symbol.storage == "global":
        return symbol.type, symbol.address, rest
    raise _Lost(f"there is no program or global variable {steps[0]}")


def _element(project: CheckedProject, kind: t.Type, address: int, step: str) -> tuple[t.Type, int]:
    indices = [int(x) for x in step[1:-1].split(",") if x.strip().lstrip("-").isdecimal()]
    if not isinstance(kind, t.Array) or len(indices) != len(kind.bounds):
        raise _Lost(f"{kind} has no element {step}")
    for index, (low, high) in zip(indices, kind.bounds, strict=True):
        if not low <= index <= high:
            raise _Lost(f"the index {index} is outside {low}..{high}")
    return kind.element, address + kind.number_of(indices) * kind.element.size

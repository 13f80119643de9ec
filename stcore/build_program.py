"""The pipeline of one build: declare, check, emit, assemble."""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Iterator, Sequence
from pathlib import Path

from stcore import configuration, depth
from stcore import syntax as s
from stcore.check import CheckedProject
from stcore.check.initial import check_init
from stcore.diagnostics import CompileError, Diagnostic, Reporter
from stcore.emit import ModuleEmitter
from stcore.emit.routines import methods_to_test, routines
from stcore.machine import assemble, load_ahead
from stcore.near import near
from stcore.program import Program, TaskSpec, Variable
from stcore.scope import Pou, Var, key
from stcore.source import Source


@contextlib.contextmanager
def at_full_length(sources: list[Source]) -> Iterator[None]:
    """Without the garbage collector, since a build makes many small objects and frees none on the way, and with room
    for deep trees. What is too deep even so is one error: raises CompileError."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        with depth.room():
            yield
    except RecursionError:
        reporter = Reporter()
        reporter.add("E0113", sources[0], 0)
        raise CompileError(reporter.sorted()) from None
    finally:
        if collecting:
            gc.enable()


def check_only(sources: list[Source], libraries: Sequence[Path], strict: bool) -> list[Diagnostic]:
    try:
        with at_full_length(sources):
            project, reporter, _ = _checked(sources, libraries, strict, own_only=True)
            return reporter.sorted()
    except CompileError as error:
        return error.diagnostics


def build(
    sources: list[Source], tasks: list[TaskSpec] | None, libraries: Sequence[Path], strict: bool, probes: bool = False
) -> tuple[Program, list[str]]:
    """The Program, and the paths of everything else that it was made of. probes: a build that can stop anywhere."""
    with at_full_length(sources):
        return _build(sources, tasks, libraries, strict, probes)


def _build(
    sources: list[Source], tasks: list[TaskSpec] | None, libraries: Sequence[Path], strict: bool, probes: bool
) -> tuple[Program, list[str]]:
    project, reporter, user_pous = _checked(sources, libraries, strict)
    if not reporter.failed:
        tasks = tasks or _tasks(project, user_pous, reporter, sources)
        for task in tasks or []:
            for name in task.programs:
                _, pou, _ = project.program_instances.get(key(name)) or ("", project.lookup(name), 0)
                if isinstance(pou, Pou) and pou.kind == "PROGRAM":
                    project.instance(pou)
                    project.reach(pou)
                else:
                    known = [p.name for p in user_pous if p.kind == "PROGRAM"]
                    reporter.add("E0702", sources[0], 0, name=name, near=near(name, known))
        project.check_reached()
    if reporter.failed:
        raise CompileError(reporter.sorted())
    for pou in user_pous:
        if pou.kind == "PROGRAM":
            project.instance(pou)  # its variables can be looked at, even if no task runs it
        if pou.kind in ("FUNCTION_BLOCK", "PROGRAM") and "ABSTRACT" not in pou.tree.modifiers and methods_to_test(pou):
            project.test_instances[pou] = pou.address or project.allocate(pou.type.size, 8)
    project.spread_writes()
    program = _emit(project, tasks, reporter, sources, user_pous, probes)
    program.libraries = [str(x) for x in libraries]
    named = {x.path for x in sources}
    used = [p for p in project.loaded if p not in named]
    folders = {str(Path(p).parent) for p in used if Path(p).is_file()} | {str(x.folder) for x in sources if x.folder}
    return program, used + sorted(folders)


def _checked(sources: list[Source], libraries: Sequence[Path], strict: bool, *, own_only: bool = False):
    """Read and check everything that the user wrote, and what it needs; own_only: not the bodies of the library."""
    reporter = Reporter(strict)
    folders = [folder for folder in dict.fromkeys(x.folder for x in sources) if folder is not None]
    project = CheckedProject(reporter, list(libraries), folders)
    project.own_only = own_only
    trees = [project.add_file(source) for source in sources]
    pous = []
    for source, tree in zip(sources, trees, strict=True):
        for unit in tree.units:
            if isinstance(unit, s.Pou):
                symbol = project.lookup(unit.name)
                if isinstance(symbol, Pou) and symbol.tree is unit:
                    pous.append(symbol)
                    if not unit.generics:
                        project.reach(symbol)
            elif isinstance(unit, s.TypeDecl):
                project.lookup(unit.name)
            for section in _sections(unit):
                for decl in section.decls if section.kind == "VAR_GLOBAL" else ():
                    project.lookup(f"{section.name or Path(source.path).stem}.{decl.name}")
    configuration.configure(project)
    project.check_reached()
    for var in project.globals:
        project.direct(var)
        if var.init is not None:
            check_init(project, var.init, var.type)
        project.reach_type(var.type)
    for field, init in list(project.field_inits.items()):
        check_init(project, init, field.type)
    project.check_reached()
    return project, reporter, pous


def _sections(unit: s.Node) -> list[s.VarSection]:
    """The lists of global variables in a unit of a file."""
    if isinstance(unit, s.VarSection):
        return [unit]
    return unit.sections if isinstance(unit, s.Configuration) else []


def _tasks(
    project: CheckedProject, pous: list[Pou], reporter: Reporter, sources: list[Source]
) -> list[TaskSpec] | None:
    """Of a CONFIGURATION; else one task with PLC_PRG, MAIN or the only program."""
    configured = configuration.tasks(project)
    if configured:
        return configured
    programs = [p for p in pous if p.kind == "PROGRAM"]
    by_name = {key(p.name): p for p in programs}
    chosen = by_name.get("PLC_PRG") or by_name.get("MAIN") or (programs[0] if len(programs) == 1 else None)
    if chosen is None:
        code = "E0703" if programs else "E0701"
        reporter.add(code, sources[0], 0, names=", ".join(p.name for p in programs))
        return None
    return [TaskSpec("main", [chosen.name])]


def _emit(
    project: CheckedProject, tasks: list[TaskSpec], reporter: Reporter, sources: list[Source], pous: list[Pou],
    probes: bool,
) -> Program:  # fmt: skip
    hooks = [p for p in project.reached if "call_after_scan" in p.attributes]
    emitter = ModuleEmitter(project, probes)
    kept = [p for p in pous if not p.tree.generics]
    wasm = assemble(emitter.emit(tasks, hooks, kept))
    load_ahead(wasm)
    program = Program(
        wasm=wasm, image=emitter.image(), image_end=emitter.image_end, limit=emitter.limit,
        sites=emitter.sites, externals=emitter.externals, tasks=tasks, diagnostics=reporter.sorted(),
        files=[x.path for x in sources] + [p for p in project.loaded if p not in {x.path for x in sources}],
    )  # fmt: skip
    for area, name in (("I", "inputs"), ("Q", "outputs"), ("M", "markers")):
        setattr(program, name, (emitter.areas[area], project.areas[area]))
    program.constants_at, program.taken = emitter.constants_at, emitter.addressed
    program.types = dict(project.named_types)
    program.routines = routines(emitter)
    if probes:
        program.bodies, program.probed, program.probes = emitter.bodies, emitter.probed, emitter.stack_top
        program.branches = emitter.branches
    _variables(program, project, emitter)
    return program


def _variables(program: Program, project: CheckedProject, emitter: ModuleEmitter) -> None:
    """Globals under their list's name (and their own, by the path rules), programs under theirs."""
    program.aliases, program.accesses = project.aliases, project.accesses
    several = {pou for _, pou, _ in project.program_instances.values()}
    running = [(p.name, p, p.address) for p in project.pous if p.kind == "PROGRAM" and p.address is not None]
    running = [x for x in running if x[1] not in several]
    for name, pou, address in [*running, *project.program_instances.values()]:
        line = pou.source.position(pou.tree.name_start)[0]
        program.variables[key(name)] = Variable(
            name, name, pou.type, address, library=pou.library, file=pou.source.path, line=line,
            attributes=pou.attributes,
        )  # fmt: skip
    for var in project.globals:
        path = f"{var.section.removeprefix('VAR_GLOBAL ')}.{var.name}"
        program.variables[key(path)] = _variable(var, path, emitter)
    for pou in project.pous:
        for var in pou.variables.values():
            if var.owner is pou and var.storage == "area" and pou.kind == "PROGRAM":
                path = f"{pou.name}.{var.name}"
                program.variables[key(path)] = _variable(var, path, emitter)


def _variable(var: Var, path: str, emitter: ModuleEmitter) -> Variable:
    line = var.source.position(var.decl.start)[0]
    return Variable(
        var.name, path, var.type, emitter.address_of(var), var.constant, var.retain, var.persistent, var.library,
        var.decl.address, var.bit, var.source.path, line, var.decl.attributes,
    )  # fmt: skip

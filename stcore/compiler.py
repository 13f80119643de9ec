"""From files to a Program: the whole pipeline, and the cache of whole builds."""

from __future__ import annotations

import os
import pickle
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from stcore import cache
from stcore.diagnostics import CompileError, Diagnostic, Reporter
from stcore.program import Program, TaskSpec
from stcore.recent import Recent
from stcore.source import Source, read

LIBRARY = Path(__file__).parent / "library"

Files = Sequence[Path | str | Source]


def compile(  # noqa: A001 - the verb that users know
    files: Files, *, tasks: list[TaskSpec] | None = None, libraries: Sequence[Path] = (), strict: bool = False,
    probes: bool = False,
) -> Program:  # fmt: skip
    """Compile ST files (folders stand for the .st files in them) to a Program.

    tasks: which programs run; by default those of a CONFIGURATION, else PLC_PRG, else MAIN, else the only program.
    libraries: folders of ST besides the standard library. strict: mends of printed listings are errors.
    probes: the same program, able to stop in front of every statement (slower).
    The Program is not to be changed: who compiles the same again may be given the same one.
    Raises CompileError with all diagnostics.
    """
    sources = _sources(files)
    key = _build_key(sources, tasks, libraries, strict, probes)
    build = _recent.get(key)
    if build is None or not build.holds():
        build = _Build.load(key)
    if build is None:
        from stcore.build_program import build as make  # the compiler proper is not loaded for a build that is kept

        program, used = make(sources, tasks, [LIBRARY, *map(Path, libraries)], strict, probes)
        program.digest = _digest(sources, used)
        build = _Build({path: _stamp(path) for path in used}, program)
        build.store(key)
    return _recent.keep(key, build).program


def diagnose(files: Files, *, libraries: Sequence[Path] = (), strict: bool = False) -> list[Diagnostic]:
    """All diagnostics of the files, in order; no module is made."""
    from stcore.build_program import check_only

    return check_only(_sources(files), [LIBRARY, *map(Path, libraries)], strict)


def compile_condition(program: Program, text: str) -> bytes:
    """An ST expression of type BOOL over the program's variables, for Machine.set_until. Raises CompileError."""
    key = program.digest, program.wasm, text  # the same texts may make another module, for other tasks
    made = _conditions.get(key) if program.digest else None
    if made is None:
        from stcore.side import compile_condition as make

        made = _conditions.keep(key, make(program, text))
    return made


def _sources(files: Files) -> list[Source]:
    """The texts. Raises CompileError (E0704, E0705) with every file that can't be read."""
    sources: list[Source] = []
    seen: set[Path] = set()  # a file that is given twice, or within a folder too, is one file
    reporter = Reporter()
    for file in files:
        if isinstance(file, Source):
            sources.append(file)
            continue
        paths = sorted(Path(file).rglob("*.st")) if Path(file).is_dir() else [Path(file)]
        if not paths:
            reporter.add("E0705", Source("", str(file)), 0, path=file)
        for path in paths:
            if path.resolve() in seen:
                continue
            seen.add(path.resolve())
            try:
                sources.append(read(path))
            except OSError as error:
                reporter.add("E0704", Source("", str(path)), 0, path=path, why=error.strerror or error)
    if reporter.failed:
        raise CompileError(reporter.sorted())
    return sources


# ------------------------------------------------------------------------------------------- cache of builds


def _own_fingerprint() -> bytes:
    """Changes whenever a file of the compiler does."""
    root = Path(__file__).parent
    folders = (root, root / "check", root / "emit")
    files = [f for folder in folders for f in sorted(folder.iterdir()) if f.suffix in (".py", ".wat", ".lark")]
    return cache.fingerprint(files)


def _build_key(
    sources: list[Source], tasks: list[TaskSpec] | None, libraries: Sequence[Path], strict: bool, probes: bool
) -> str:
    parts = [_own_fingerprint(), repr((tasks, [str(x) for x in libraries], strict, probes)).encode()]
    for source in sources:
        parts += [_bytes(x) for x in (source.path, str(source.folder or ""), source.text)]
    return cache.digest(*parts)


def _digest(sources: list[Source], used: list[str]) -> str:
    """Of all texts that a program was made of."""
    others = [Path(path) for path in sorted(used) if Path(path).is_file()]
    parts = [(x.path, _bytes(x.text)) for x in sources]
    parts += [(str(x), x.read_bytes()) for x in others]
    return cache.digest(*(part for path, data in parts for part in (_bytes(path), data)))


def _bytes(text: str) -> bytes:
    """Also of a path that the file system's encoding can't read."""
    return text.encode("utf-8", "surrogatepass")


def _stamp(path: str) -> tuple[int, int] | None:
    try:
        info = os.stat(path)
    except OSError:
        return None
    return info.st_mtime_ns, info.st_size


class _Build(NamedTuple):
    """A program with the stamps of the files and folders that it was made of besides the sources named."""

    stamps: dict[str, tuple[int, int] | None]
    program: Program

    def holds(self) -> bool:
        return all(_stamp(path) == stamp for path, stamp in self.stamps.items())

    def store(self, key: str) -> None:
        cache.store("build", key, pickle.dumps((self.stamps, pickle.dumps(self.program, protocol=5)), protocol=5))

    @classmethod
    def load(cls, key: str) -> _Build | None:
        """From the cache; None where it is not, or does not hold any more."""
        data = cache.load("build", key)
        if data is None:
            return None
        try:
            stamps, inner = pickle.loads(data)
            return cls(stamps, pickle.loads(inner)) if cls(stamps, None).holds() else None
        except (pickle.UnpicklingError, EOFError, AttributeError, ImportError, IndexError, ValueError, TypeError):
            return None  # written by another version, or damaged: build again


# A suite of tests loads the same programs again and again, and waits for the same things: so many does a process keep.
_recent: Recent[str, _Build] = Recent(8)  # key of the build -> it
_conditions: Recent[tuple[str, bytes, str], bytes] = Recent(64)  # digest, module of the program, condition -> module

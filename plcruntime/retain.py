"""The retain file: the RETAIN and PERSISTENT variables of a program, kept over processes.

A file is written whole or not at all: into a file beside it, to the disk, then renamed over the old one. It names every
variable with its type, so that a program that was changed since finds its values by name:

    magic, length of the table (8 bytes), table (JSON), the values one after another, SHA-256 of all that

The table: {"build": of the program, "enums": {name: [base, {label: number}]}, "variables": [[path, type, size of an
element, bounds or null, persistent], ...]}.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from plcruntime import kept as survivors
from plcruntime.errors import UsageError
from plcruntime.kept import Kept
from plcruntime.migrate import Report, migrate
from stcore.program import Program
from stcore.types import Array, Enum, Pointer, SubrangeType, Type

MAGIC = b"scancycle retain 1\n"
EVERY = 1.0  # s of wall clock between two saves while the PLC runs
STALE = 3600.0  # s after which a part of a file that nobody finished is taken away


@dataclass(slots=True)
class Stored:
    """What a retain file holds. entries: path, type, size of an element, bounds, persistent; values: bytes of each."""

    build: str
    enums: dict[str, list]
    entries: list[list]
    values: list[bytes]


class RetainFile:
    """Keeps the variables of one PLC in a file. memory: gives the machine's memory. every: s between two saves.

    report: what became of the values when they were read; problem: why the last save failed, or ''.
    """

    def __init__(self, path: str | Path, program: Program, memory: Callable[[], memoryview], every: float) -> None:
        self.path, self.every = Path(path), every
        self.report = Report()
        self.problem = ""
        self._memory = memory
        self._build = hashlib.sha256(program.wasm + program.image).hexdigest()
        self._leaves = _leaves(program)
        self._table = _table(self._build, self._leaves)
        self._saved: list[bytes] | None = None
        self._keep_former = False
        self._next = time.monotonic() + every
        self._check_folder()

    def _check_folder(self) -> None:
        folder = self.path.parent
        if self.path.is_dir():
            raise UsageError(f"the retain file {self.path} is a folder")
        if not folder.is_dir():
            raise UsageError(f"there is no folder {folder} for the retain file {self.path.name}")
        if not os.access(folder, os.W_OK):
            raise UsageError(f"the retain file {self.path} can't be written: no right to write to {folder}")
        for part in folder.glob(f"{self.path.name}.*.part"):
            with suppress(OSError):  # another process was quicker
                if time.time() - part.stat().st_mtime > STALE:
                    part.unlink()

    # ------------------------------------------------------------------------------------------------ reading

    def load(self) -> Report:
        """Write the file's values into the memory; without a file nothing happens.

        Raises UsageError: a file that can't be read, is damaged, or has values that the program can't take. Then
        nothing was written, neither memory nor file.
        """
        if not self.path.exists():
            return self.report
        stored = read(self.path)
        same = json.loads(self._table)
        if stored.entries == same["variables"] and stored.enums == same["enums"]:
            same_build = stored.build == self._build
            pairs = zip(self._leaves, stored.values, strict=True)
            values = [(k, v) for k, v in pairs if same_build or not survivors.is_pointer(k.type)]
            self.report = Report(kept=len(values))
        else:
            values, self.report = migrate(stored, self._leaves, self.path)
            self._keep_former = True
        memory = self._memory()
        survivors.put_back(values, memory)
        if not self._keep_former:
            self._saved = self._values(memory)  # a PLC that never runs does not write
        return self.report

    def _values(self, memory) -> list[bytes]:
        return [survivors.read(memory, leaf) for leaf in self._leaves]

    # ------------------------------------------------------------------------------------------------ writing

    def poll(self) -> None:
        """Save when it is time; a failure is kept in `problem`, for the end of the run."""
        if time.monotonic() >= self._next:
            with suppress(UsageError):
                self.save()

    def save(self) -> None:
        """Write the file, if a value changed since. Raises UsageError when that is not possible."""
        self._next = time.monotonic() + self.every
        values = self._values(self._memory())
        if values == self._saved or not self._leaves:
            return
        body = MAGIC + len(self._table).to_bytes(8, "little") + self._table + b"".join(values)
        self.problem = f"the retain file {self.path} can't be written"
        try:
            if self._keep_former and self.path.exists():
                _write(self.path.with_name(self.path.name + ".bak"), self.path.read_bytes())
            _write(self.path, body + hashlib.sha256(body).digest())
        except OSError as error:
            self.problem += f": {error.strerror or error}"
            raise UsageError(self.problem) from None
        self.problem = ""
        self._saved, self._keep_former = values, False


def _write(path: Path, data: bytes) -> None:
    """Write a file whole or not at all, whatever happens meanwhile."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        with open(part, "wb") as out:
            out.write(data)
            out.flush()
            os.fsync(out.fileno())
        os.replace(part, path)
    except OSError:
        part.unlink(missing_ok=True)
        raise
    if os.name == "posix":  # the new name lasts when its folder is on the disk
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


def read(path: Path) -> Stored:
    """Read a retain file and check it. Raises UsageError."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UsageError(f"can't read the retain file {path}: {error.strerror}") from None
    if not data.startswith(MAGIC):
        raise UsageError(f"{path} is no retain file of this version; it stays as it is")
    start = len(MAGIC) + 8
    body, checksum = data[:-32], data[-32:]
    if len(data) < start + 32 or hashlib.sha256(body).digest() != checksum:
        raise UsageError(f"the retain file {path} is damaged (its checksum is wrong); delete it to start anew")
    at = start + int.from_bytes(data[len(MAGIC) : start], "little")
    table = json.loads(data[start:at])
    values = []
    for _, _, size, bounds, _ in table["variables"]:
        size *= math.prod(high - low + 1 for low, high in bounds or [])
        values.append(body[at : at + size])
        at += size
    return Stored(table["build"], table["enums"], table["variables"], values)


def _leaves(program: Program) -> list[Kept]:
    """The single values and arrays of the kept variables, each once; PERSISTENT where one of its owners is."""
    found: dict[tuple[int, int | None], Kept] = {}
    for kept in survivors.kept_variables(program):
        for leaf in survivors.leaves(kept):
            known = found.setdefault((leaf.address, leaf.bit), leaf)
            known.persistent = known.persistent or leaf.persistent
    return list(found.values())


def _table(build: str, leaves: list[Kept]) -> bytes:
    enums, entries = {}, []
    for leaf in leaves:
        bounds = [list(b) for b in leaf.type.bounds] if isinstance(leaf.type, Array) else None
        element = leaf.type.element if bounds else leaf.type
        if isinstance(element, Enum):
            enums[element.name] = [element.base.name, element.values]
        entries.append([leaf.path, type_text(element), element.size, bounds, leaf.persistent])
    table = {"build": build, "enums": enums, "variables": entries}
    return json.dumps(table, ensure_ascii=False, separators=(",", ":")).encode("utf-8")


def type_text(t: Type) -> str:
    """What must be equal so that the bytes of two values mean the same, apart from an ENUM's labels."""
    if isinstance(t, SubrangeType):
        return f"{t.base.name}({t.low}..{t.high})"
    if isinstance(t, Enum):
        return f"ENUM {t.name}"
    if isinstance(t, Pointer):
        return "POINTER"
    if getattr(t, "union", False):
        members = ", ".join(f"{f.name}: {type_text(f.type)}" for f in t.members.values())
        return f"UNION ({members})"
    return t.name

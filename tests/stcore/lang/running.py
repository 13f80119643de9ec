"""Small ST programs, compiled and run: their variables, their errors, their faults."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from stcore import paths, values
from stcore.build_program import build, check_only
from stcore.compiler import LIBRARY
from stcore.diagnostics import CompileError, Diagnostic
from stcore.faults import Fault
from stcore.machine import Machine
from stcore.source import Source

EXPECT = re.compile(r"//\s*expect:\s*([^=]+?)\s*=\s*(.+)")


class Run:
    """A program in memory. Variables by path; a name of PLC_PRG needs no program in front."""

    def __init__(self, text: str, path: str = "case.st", host: dict | None = None) -> None:
        self.program, _ = build([Source(text, path)], None, [LIBRARY], False)
        self.machine = Machine(self.program, host)

    def _place(self, path: str) -> paths.Place:
        try:
            return paths.resolve(self.program, f"PLC_PRG.{path}")
        except paths.PathError:
            return paths.resolve(self.program, path)

    def __getitem__(self, path: str):
        return values.read(self.machine.memory, self._place(path))

    def __setitem__(self, path: str, value) -> None:
        place = self._place(path)
        for address, data in values.encode(self.machine.memory, place, value):
            self.machine.memory[address : address + len(data)] = data

    def scan(self, count: int = 1) -> Run:
        assert self.machine.run(count) == count
        return self

    def fault(self) -> Fault:
        """The fault that the next scan ends with."""
        with pytest.raises(Fault) as caught:
            self.machine.run(1)
        return caught.value

    @property
    def warnings(self) -> list[Diagnostic]:
        return self.program.diagnostics


def program(body: str, declarations: str = "", before: str = "") -> str:
    """PLC_PRG with these variables and statements; `before`: other units."""
    return f"{before}\nPROGRAM PLC_PRG\nVAR\n{declarations}\nEND_VAR\n{body}\nEND_PROGRAM\n"


def run(body: str, declarations: str = "", before: str = "") -> Run:
    return Run(program(body, declarations, before)).scan()


def diagnostics(text: str) -> list[Diagnostic]:
    return check_only([Source(text, "case.st")], [LIBRARY], False)


def errors(text: str) -> list[Diagnostic]:
    found = [d for d in diagnostics(text) if d.severity == "error"]
    if found:
        with pytest.raises(CompileError):
            build([Source(text, "case.st")], None, [LIBRARY], False)
    return found


def expectations(file: Path) -> list[tuple[int, str, str]]:
    """(line, path of a variable, its value as ST writes it) of each ``// expect:`` of a file."""
    lines = file.read_text(encoding="utf-8").splitlines()
    return [(n, *m.groups()) for n, line in enumerate(lines, 1) if (m := EXPECT.search(line))]


def meant(text: str) -> object:
    """What an expectation says, in Python: TRUE, 16#FF, -5, 1.5, 'text', [1, 2], 1.5s."""
    text = text.strip()
    if text in ("TRUE", "FALSE"):
        return text == "TRUE"
    if text[0] == "[":
        return [meant(x) for x in text[1:-1].split(",")]
    if text[0] in "'\"":
        return text[1:-1]
    if "#" in text:
        base, _, digits = text.partition("#")
        return int(digits.replace("_", ""), int(base))
    if text[-1] == "s":
        return float(text[:-1])
    return float(text) if re.search(r"[.ni]", text) else int(text)

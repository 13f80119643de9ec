"""Breakpoints: from POU and line to the statements of a probed build."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from plcruntime.errors import UsageError
from stcore.near import near
from stcore.paths import PathError
from stcore.program import Body, Program, Variable
from stcore.types import Block

if TYPE_CHECKING:
    from plcruntime.plc import PLC


@dataclass(slots=True)
class Breakpoint:
    """pou: its name, or that of one instance of a program. site: of the statement that it stops before; sites: all of
    that place, one for each instance of a generic function or of a program. condition: ST, understood in the POU; None
    stops always."""

    number: int
    pou: str
    line: int
    site: int
    sites: set[int]
    condition: str | None = None
    hits: int = 0


class Breakpoints:
    """The breakpoints of a PLC. program: the probed build, once there is one."""

    def __init__(self, plc: PLC) -> None:
        self._plc = plc
        self._next = 1
        self.program: Program | None = None
        self.points: dict[int, Breakpoint] = {}

    @property
    def active(self) -> bool:
        return bool(self.points)

    def add(self, pou: str, line: int, condition: str | None = None) -> Breakpoint:
        """At the first statement of a POU at or below a line. Raises UsageError for a POU or line without one."""
        sites = self.statements(pou)
        below = [(self.program.sites[s].line, self.program.sites[s].column, s) for s in sites]
        below = [x for x in below if x[0] >= line]
        if not below:
            last = max(self.program.sites[s].line for s in sites)
            raise UsageError(f"{pou} has no statement at line {line} or below; its last is at line {last}")
        found, column, site = min(below)
        same = {s for line, other, s in below if (line, other) == (found, column)}
        instance = self._instance(pou)
        name = instance.path if instance else self.program.sites[site].pou
        point = Breakpoint(self._next, name, found, site, same, condition)
        self._next += 1
        self.points[point.number] = point
        return point

    def statements(self, pou: str) -> list[int]:
        """The sites of the statements of a POU, of one instance of a program, or of a file named in its place."""
        sites, wanted = self.program.sites, pou.upper()
        if instance := self._instance(pou):
            bodies = self.program.bodies
            return [s for s, body in self.program.probed.items() if bodies[body].address == instance.address]
        found = [s for s in self.program.probed if sites[s].pou.upper() == wanted]
        found = found or [s for s in self.program.probed if Path(sites[s].file).name.upper() == wanted]
        if not found:
            known = sorted({sites[s].pou for s in self.program.probed})
            hint = near(pou, known) or self._block_of(pou)
            raise UsageError(f"no POU {pou} with statements is in this program{'; ' + hint if hint else ''}")
        return found

    def _instance(self, name: str) -> Variable | None:
        """The instance of a program that has a name of its own (CONFIGURATION)."""
        variable = next((v for v in self.program.programs() if v.path.upper() == name.upper()), None)
        return variable if variable and variable.type.name.upper() != name.upper() else None

    def _block_of(self, path: str) -> str:
        """Where to stop instead in the instance of a block: its code is that of all instances."""
        try:
            kind = self._plc.place(path).type
        except PathError:
            return ""
        block = isinstance(kind, Block)
        return f"{path} is an instance of {kind.name}, whose code is that of all: break {kind.name}" if block else ""

    def remove(self, number: int | None) -> None:
        """One breakpoint, or all. Raises UsageError."""
        if number is None:
            self.points.clear()
        elif self.points.pop(number, None) is None:
            raise UsageError(f"there is no breakpoint {number}; there are {', '.join(map(str, self.points)) or 'none'}")

    def at(self, site: int) -> list[Breakpoint]:
        return [p for p in self.points.values() if site in p.sites]

    def write_flags(self, memory, flag: Callable[[Breakpoint, Body], int]) -> None:
        """Mark the sites in the memory of the probed build. flag: what a breakpoint wants to have there in a body;
        where several stop, the host asks each of them."""
        program = self.program
        start = program.flags
        memory[start : start + len(program.sites)] = bytes(len(program.sites))
        for point in self.points.values():
            for site in point.sites:
                alone = len(self.at(site)) == 1
                memory[start + site] = flag(point, program.bodies[program.probed[site]]) if alone else 1

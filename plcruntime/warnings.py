"""What a running program does wrong with its motion blocks: codes W08.., which `plc.warnings` gives.

The library notes the address of the block and a reason where a command begins or fails (mclib/library/sim/SimWarn.st);
here the address becomes the path of an instance and the line that calls it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from plcruntime.report import line_of
from stcore import paths
from stcore.codes import CODES
from stcore.diagnostics import Diagnostic
from stcore.paths import PathError, Place
from stcore.program import Program, Site
from stcore.types import Block

if TYPE_CHECKING:
    from plcruntime.plc import PLC

COUNT, NOTED = "SIM.warnings", "SIM.warned"


@dataclass(slots=True)
class RunWarning(Diagnostic):
    """A mistake that showed while the program ran, once for each instance and code.

    instance: path of the block; axis: of the simulator, from 1; scan, time (s): when it showed first. file and line:
    where the instance is called, '' and 0 where that is not known.
    """

    instance: str = ""
    axis: int = 0
    scan: int = 0
    time: float = 0.0


def of(plc: PLC) -> list[RunWarning]:
    """The warnings so far, in the order of their time."""
    if COUNT.upper() not in plc.program.variables:
        return []
    found: list[RunWarning] = []
    seen: set[tuple] = set()
    for noted in plc[NOTED][: plc[COUNT]]:
        code = f"W08{noted['reason']:02}"
        names = [_instance(plc.program, noted[which]) for which in ("instance", "other")]
        key = (code, frozenset(n for n in names if n))
        if key not in seen:
            seen.add(key)
            found.append(_warning(plc, code, noted, *names))
    return found


def _warning(plc: PLC, code: str, noted: dict, name: str, other: str) -> RunWarning:
    site = _call_of(plc.program, name)
    axis = f"axis {noted['axis']}"
    if path := _axis_path(plc, noted["axis"]):
        axis += f" ({path})"
    time = noted["scan"] * plc.interval
    message = CODES[code].message.format(name=name, other=other, axis=axis)
    file, line, column = (site.file, site.line, site.column) if site else ("", 0, 0)
    return RunWarning(
        code, "warning", f"{message} (scan {noted['scan']}, {time:.9g} s)", file, line, column, column + 1,
        CODES[code].hint, line_of(file, line) or "", name, noted["axis"], noted["scan"], time,
    )  # fmt: skip


def _instance(program: Program, address: int) -> str:
    """The path of the innermost block instance around an address."""
    blocks = [p.name for p in paths.around(program, address) if isinstance(p.type, Block)]
    return blocks[-1] if blocks else ""


def _axis_path(plc: PLC, number: int) -> str:
    """The program's own name for an axis."""
    address = int.from_bytes(_bytes(plc, plc.place(f"SIM.Axis[{number}].ref")), "little")
    return paths.instance_at(plc.program, plc.program.types["AXIS_REF_SM3"], address)


def _bytes(plc: PLC, place: Place) -> bytes:
    return bytes(plc._machine.memory[place.address : place.address + place.size])


def _call_of(program: Program, path: str) -> Site | None:
    """Where an instance is called first."""
    parent, _, name = path.rpartition(".")
    try:
        pou = paths.resolve(program, parent).type.name if parent else ""
    except PathError:  # an instance in a list of global variables: any POU may call it
        pou = ""
    called = name.split("[")[0].upper()
    for site in program.sites:
        note = site.note.split("[")[0].rpartition(".")[2].upper()
        if not site.code and note == called and pou.upper() in ("", site.pou.upper()):
            return site
    return None


"""What motion needs of the host: configuration files, and which axis of the program is which of the simulator."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

from mclib import configuration, mram
from mclib.configuration import ConfigError
from stcore.program import Program
from stcore.types import Array, Block, Field, Struct, Type

AXIS = "AXIS_REF_SM3"
REASON = 95  # characters of SimReturn.why


def functions(plc) -> dict[str, Callable]:
    """The external functions of the library, by upper-case name, for one PLC."""

    def read_config(name_at: int, entries_at: int, most: int, why_at: int) -> int:
        memory = _memory(plc)
        raw = bytes(memory[name_at : name_at + 256]).split(b"\0")[0]
        name = raw.decode("utf-8", "replace")
        try:
            entries = _configuration(plc, name)
        except (ConfigError, OSError) as error:
            reason = str(error).encode()[:REASON] + b"\0"
            memory[why_at : why_at + len(reason)] = reason
            return -getattr(error, "line", 0) - 1
        for i, (key, axis, value) in enumerate(entries[:most]):
            struct.pack_into("<iid", memory, entries_at + 16 * i, key, axis, value)
        return len(entries)

    kept = mram.Mram(mram.place(plc.project.path, plc.program.files))

    def read_mram(words_at: int, address: int, count: int) -> int:
        try:
            _memory(plc)[words_at : words_at + 2 * count] = kept.read(address, count)
        except OSError:
            return 0
        return 1

    def write_mram(words_at: int, address: int, count: int) -> int:
        try:
            kept.write(address, bytes(_memory(plc)[words_at : words_at + 2 * count]))
        except OSError:
            return 0
        return 1

    def refused(number: int) -> int:
        plc.returns.note(number)
        return 1

    found = {
        "HOSTREADCONFIG": read_config, "HOSTREADMRAM": read_mram, "HOSTWRITEMRAM": write_mram, "HOSTREFUSED": refused,
    }  # fmt: skip
    if any(e.name.upper().endswith("MOTION") for e in plc.program.externals):
        from mclib.motion_programs import host

        found |= host.functions(plc, lambda: _memory(plc))
    return found


def _configuration(plc, name: str) -> list[tuple[int, int, float]]:
    """The settings of a file. Raises ConfigError, OSError with a sentence."""
    if len(name) > configuration.LONGEST:
        raise OSError(f"the name of the file has more than {configuration.LONGEST} characters")
    file = configuration.find(name, [Path(f).parent for f in plc.program.files[:1]])
    if file is None:
        raise OSError(f"there is no file '{name}' beside the program, in the working folder or among the examples")
    return configuration.parse(file.read_text(encoding="utf-8", errors="replace"))


# ------------------------------------------------------------------------------------------- axes of the program


def bind_axes(plc) -> None:
    """Give every AXIS_REF_SM3 of the program its number in the simulator: that of plc.toml for an axis declared there,
    else the order of declaration.

    Raises ValueError when there are more than the simulator has.
    """
    program, memory = plc.program, _memory(plc)
    simulated = program.variables.get("SIM.AXIS")
    if simulated is None or not isinstance(simulated.type, Array):
        return
    ref_type = program.types.get(AXIS)
    if ref_type is None:
        return
    declared = {program.variables[f"AXES.{a.name.upper()}"].address: a.number for a in plc.project.axes if a.kind}
    addresses = [a for a in axis_addresses(program) if a not in declared]
    (low, high), element = simulated.type.bounds[0], simulated.type.element
    free = [n for n in range(low, high + 1) if n not in declared.values()]
    if len(addresses) > len(free) or max(declared.values(), default=0) > high:
        count = len(addresses) + len(declared)
        raise ValueError(f"the program declares {count} axes of type {AXIS}; the simulator has {high - low + 1}")
    numbers = sorted((declared | dict(zip(addresses, free, strict=False))).items(), key=lambda item: item[1])
    count = program.variables["SIM.COUNT"].address
    used, number, ref = (element.members[m].offset for m in ("USED", "NUMBER", "REF"))
    for address, n in numbers:
        axis = simulated.address + (n - low) * element.size
        struct.pack_into("<h", memory, address + ref_type.members["AXISNO"].offset, n)
        struct.pack_into("<d", memory, address + ref_type.members["FTASKCYCLE"].offset, plc.interval)
        struct.pack_into("<B", memory, axis + used, 1)
        struct.pack_into("<h", memory, axis + number, n)
        struct.pack_into("<I", memory, axis + ref, address)
    most = max(numbers[-1][1] if numbers else 0, struct.unpack_from("<h", memory, count)[0])
    struct.pack_into("<h", memory, count, most)
    # how many scans a block may stay away from its axis: those of the slowest task
    slowest = max((task.interval or 0 for task in program.timed), default=0)
    patience = min(max(1, math.ceil(slowest / round(plc.interval * 1e9))), 32766) + 1
    struct.pack_into("<h", memory, program.variables["SIM.PATIENCE"].address, patience)


def axis_addresses(program: Program) -> Iterator[int]:
    """Addresses of the program's AXIS_REF_SM3, in order of declaration, file by file."""
    order = {file: i for i, file in enumerate(program.files)}
    own = [v for v in program.variables.values() if not v.library and v.direct is None]
    for variable in sorted(own, key=lambda v: (order.get(v.file, len(order)), v.line)):
        yield from _inside(variable.type, variable.address)


def _inside(of: Type, address: int) -> Iterator[int]:
    if not _holds_axis(of):
        return
    if isinstance(of, Array):
        for i in range(of.size // of.element.size):
            yield from _inside(of.element, address + i * of.element.size)
    elif of.name.upper() == AXIS:
        yield address
    else:
        for member in of.members.values():
            if _own(member):
                yield from _inside(member.type, address + member.offset)


@cache
def _holds_axis(of: Type) -> bool:
    """Is there an AXIS_REF_SM3 by value in variables of this type?"""
    if isinstance(of, Array):
        return _holds_axis(of.element)
    if isinstance(of, Struct | Block):
        return of.name.upper() == AXIS or any(_holds_axis(m.type) for m in of.members.values() if _own(m))
    return False


def _own(member: Field) -> bool:
    """Does the member lie in the instance itself?"""
    return member.section not in ("VAR_IN_OUT", "VAR_STAT", "VAR_TEMP", "VAR_EXTERNAL")


def _memory(plc):
    return plc._machine.memory

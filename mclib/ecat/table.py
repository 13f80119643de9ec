"""The bus of an [ecat] table of plc.toml."""

from __future__ import annotations

import re
import struct
from functools import cache
from pathlib import Path
from typing import Any

from mclib.ecat.bus import (
    AXES,
    COUPLER_PROFILE,
    DRIVE_PROFILE,
    FAULTS,
    IO_PROFILE,
    SLAVES,
    Bus,
    BusError,
    Entry,
    Slave,
    number_axes,
    place,
)

FOREVER = 2**63 - 1
# objects of a drive and their bits (mclib/library/ecat/EcatKind.st)
DRIVE_BITS = {
    **dict.fromkeys((0x6060, 0x6061, 0x6098), 8),
    **dict.fromkeys((0x6040, 0x6041, 0x603F, 0x6071, 0x6077, 0x6078, 0x60B8, 0x60B9, 0x20F2, 0x20F9), 16),
}
# the objects that the manual names, all of them (chapter 13)
DRIVE_OUTPUTS = ["6040", "607A", "6060", "6071", "60FF", "60B8", "60FE:01"]
DRIVE_INPUTS = [
    "6041", "6064", "606C", "6061", "6077", "6078", "60F4", "60FD", "60B9", "60BA", "60BB", "60BC", "60BD", "20F2",
    "20F9",
]  # fmt: skip
# what a kind of slave maps when the configuration does not say
KINDS: dict[str, tuple[list[str], list[str]]] = {
    "drive": (DRIVE_OUTPUTS, DRIVE_INPUTS),
    "gthd": (["6040", "607A"], ["6041", "6064", "606C"]),  # figure 5-2
    "io": (["7000:01/16"], ["6000:01/16"]),  # figure 5-3
    "coupler": (["F200:01/16"], ["F100:01/16"]),  # and its modules: figure 5-4
    "slave": ([], []),
}
# module of a coupler -> input or output, channels; 16 bits each
MODULES = {"di16": (True, 1), "do16": (False, 1), "ai4": (True, 4), "ao4": (False, 4)}
# without a configuration: the coupler of figure 5-4, four IO slaves so that the addresses of figure 5-3 hold, 12 drives
DEFAULT: list[dict[str, Any]] = [
    {"kind": "coupler", "modules": ["di16", "do16", "ai4", "ao4"]},
    *({"kind": "io"} for _ in range(4)),
    *({"kind": "drive"} for _ in range(AXES)),
]
TYPES = {
    "BOOL": 1, "SINT": 1, "USINT": 1, "BYTE": 1, "INT": 2, "UINT": 2, "WORD": 2, "DINT": 4, "UDINT": 4, "DWORD": 4,
    "REAL": 4, "LINT": 8, "ULINT": 8, "LWORD": 8, "LREAL": 8,
}  # fmt: skip
MAPPED = re.compile(r"(?:16#|0x|#x)?([0-9a-f]{4})(?::([0-9a-f]{1,2}))?(?:/(\d+))?", re.IGNORECASE)
GIVEN = re.compile(
    r"(?:16#|0x|#x)?([0-9a-f]{4})(?::([0-9a-f]{1,2}))?\s+(\w+)\s*=\s*(\S+)(\s+ro)?", re.IGNORECASE
)  # fmt: skip


def read(table: dict[str, Any], folder: Path, nanoseconds=None) -> Bus:
    """The bus of an [ecat] table of plc.toml. folder: where an ENI file is looked for. nanoseconds: reads a duration.

    Raises BusError.
    """
    duration = nanoseconds or (lambda value: int(value))
    bus = Bus([], startup=_time(duration, "startup", table.get("startup", 0)))
    if "eni" in table and "slave" in table:
        raise BusError("eni and slave name the slaves twice: take one of them away")
    if "eni" in table:
        file = folder / table["eni"]
        if file.is_file():
            from mclib.ecat.eni import read_eni

            bus.slaves = read_eni(file)
        else:
            bus.eni_missing = True
    else:
        for entry in table.get("slave", DEFAULT):
            for _ in range(_within("count", entry.get("count", 1), 1, SLAVES)):
                bus.slaves.append(_slave(entry, len(bus.slaves)))
    number_axes(bus.slaves)
    place(bus.slaves)
    for fault in table.get("fault", []):
        at = _time(duration, "fault.at", fault.get("at", 0))
        until = _time(duration, "fault.until", fault["until"]) if "until" in fault else FOREVER
        if until <= at:
            raise BusError("fault.until must be later than fault.at")
        slave = _within("fault.slave", fault.get("slave", 0), 0, max(len(bus.slaves) - 1, 0))
        bus.faults.append((slave, at, until))
    if len(bus.faults) > FAULTS:
        raise BusError(f"there are more than {FAULTS} faults")
    return bus


@cache
def default() -> Bus:
    """The bus of a program without a configuration."""
    return read({}, Path())


def _time(duration, key: str, value) -> int:
    try:
        return duration(value)
    except ValueError as error:
        raise BusError(f"{key}: {error}") from None


def _within(key: str, value: int, low: int, high: int) -> int:
    if not low <= value <= high:
        raise BusError(f"{key} goes from {low} to {high}, not {value}")
    return value


def _slave(table: dict[str, Any], number: int) -> Slave:
    kind = table.get("kind", "slave")
    if kind not in KINDS:
        raise BusError(f"slave.kind '{kind}' is none of {', '.join(KINDS)}")
    outputs, inputs = KINDS[kind]
    modules = table.get("modules", [])
    if modules and kind != "coupler":
        raise BusError("only a coupler has modules")
    more = [_module(slot, module) for slot, module in enumerate(modules)]
    entries = [_mapped(text, False) for text in table.get("outputs", outputs)]
    entries += [e for module in more for e in module if not e.input]
    entries += [_mapped(text, True) for text in table.get("inputs", inputs)]
    entries += [e for module in more for e in module if e.input]
    indexes = {e.index for e in entries}
    drive = {0x6040, 0x6041} <= indexes
    profile = COUPLER_PROFILE if kind == "coupler" else DRIVE_PROFILE if drive else IO_PROFILE
    identity = tuple(_within(key, table.get(key, 0), 0, 2**32 - 1) for key in ("vendor", "product", "revision"))
    slave = Slave(
        table.get("name", f"{kind}{number}")[:31], entries, axis=-1 if drive else 0, profile=profile,
        identity=(*identity, number + 1), wired=table.get("wired", True),
    )  # fmt: skip
    if "axis" in table:
        if not drive:
            raise BusError("axis belongs to a slave that maps 6040h and 6041h: a drive")
        slave.axis = _within("slave.axis", table["axis"], 1, AXES)
    slave.objects = [_given(text) for text in table.get("objects", [])]
    return slave


def _module(slot: int, name: str) -> list[Entry]:
    """The objects of a coupler's module: 6000h for inputs, 7000h for outputs, 10h on from slot to slot (figure 5-4)."""
    if name not in MODULES:
        raise BusError(f"module '{name}' is none of {', '.join(MODULES)}")
    is_input, channels = MODULES[name]
    index = (0x6000 if is_input else 0x7000) + 0x10 * slot
    return [Entry(index, channel, is_input, 16) for channel in range(1, channels + 1)]


def _mapped(text: str, is_input: bool) -> Entry:
    match = MAPPED.fullmatch(text.strip())
    if not match:
        raise BusError(f"'{text}' is no object; write '6040', '60FE:01' or '7000:01/16' (bits)")
    index, subindex = int(match[1], 16), int(match[2] or "0", 16)
    bits = int(match[3]) if match[3] else DRIVE_BITS.get(index, 32)
    if not 1 <= bits <= 32 and bits != 64:
        raise BusError(f"'{text}': an object has 1 to 32 bits, or 64")
    return Entry(index, subindex, is_input, bits)


def _given(text: str) -> tuple[int, int, int, bool, bytes]:
    match = GIVEN.fullmatch(text.strip())
    if not match or match[3].upper() not in TYPES:
        raise BusError(f"'{text}' is no object; write '2001:00 DINT = 5', and 'ro' after it if it is only read")
    kind, value = match[3].upper(), match[4]
    size = TYPES[kind]
    try:
        if kind in ("REAL", "LREAL"):
            data = struct.pack("<f" if kind == "REAL" else "<d", float(value))
        else:
            number = int(re.sub("^16#", "0x", value), 0)
            data = number.to_bytes(size, "little", signed=number < 0)
    except (ValueError, OverflowError):
        raise BusError(f"'{text}': {value} is not a value of type {kind}") from None
    return int(match[1], 16), int(match[2] or "0", 16), size, bool(match[5]), data

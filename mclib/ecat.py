"""The simulated EtherCAT bus: what is on it, from plc.toml or an ENI file, written to the image before the first scan.

docs/ecat.md describes the slaves and the keys. The bus itself runs in ST (mclib/library/ecat).
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from stcore.types import Array, String, Struct

AXES, SLAVES, ENTRIES, OBJECTS, FAULTS, IMAGE = 12, 64, 1024, 256, 16, 2040  # of mclib/library/ecat/ECAT.st
FOREVER = 2**63 - 1
DRIVE_PROFILE, IO_PROFILE, COUPLER_PROFILE = 0x00020192, 0x00000191, 0x00001389  # object 1000h
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


class BusError(ValueError):
    """What is wrong with the configuration of the bus."""


@dataclass(slots=True)
class Entry:
    """An object in the process data. bit: where it is, worked out last."""

    index: int
    subindex: int
    input: bool
    bits: int
    bit: int = 0


@dataclass(slots=True)
class Slave:
    """A slave on the bus. axis: of its drive, 0 none. start: byte of its data; outputs and inputs: their bytes."""

    name: str
    entries: list[Entry] = field(default_factory=list)
    axis: int = 0
    profile: int = IO_PROFILE
    identity: tuple[int, int, int, int] = (0, 0, 0, 0)
    wired: bool = True
    objects: list[tuple[int, int, int, bool, bytes]] = field(default_factory=list)
    start: int = 0
    outputs: int = 0
    inputs: int = 0


@dataclass(slots=True)
class Bus:
    """Everything that is on the bus. startup and the times of faults (slave, from, till) are ns."""

    slaves: list[Slave]
    startup: int = 0
    faults: list[tuple[int, int, int]] = field(default_factory=list)
    eni_missing: bool = False


# ------------------------------------------------------------------------------------------- configuration


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
            bus.slaves = read_eni(file)
        else:
            bus.eni_missing = True
    else:
        for entry in table.get("slave", DEFAULT):
            for _ in range(_within("count", entry.get("count", 1), 1, SLAVES)):
                bus.slaves.append(_slave(entry, len(bus.slaves)))
    _number_axes(bus.slaves)
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


def _number_axes(slaves: list[Slave]) -> None:
    """Drives without a number get the free ones in order."""
    taken = [s.axis for s in slaves if s.axis > 0]
    for axis in taken:
        if taken.count(axis) > 1:
            raise BusError(f"axis {axis} has two drives")
    free = (n for n in range(1, AXES + 1) if n not in taken)
    for slave in slaves:
        if slave.axis < 0:
            axis = next(free, None)
            if axis is None:
                raise BusError(f"there are more than {AXES} drives")
            slave.axis = axis


def place(slaves: list[Slave]) -> None:
    """Give every object its place in the process data: slave by slave, outputs first, each slave on whole bytes."""
    if len(slaves) > SLAVES:
        raise BusError(f"there are more than {SLAVES} slaves")
    if sum(len(s.entries) for s in slaves) > ENTRIES:
        raise BusError(f"there are more than {ENTRIES} objects in the process data")
    if sum(len(s.objects) for s in slaves) > OBJECTS:
        raise BusError(f"there are more than {OBJECTS} objects with values")
    at = 0
    for slave in slaves:
        slave.entries.sort(key=lambda e: e.input)
        slave.start = at
        for is_input in (False, True):
            begin = bit = at * 8
            for entry in slave.entries:
                if entry.input == is_input:
                    if entry.bits == 64 and bit % 8:
                        raise BusError(f"{slave.name}: {entry.index:04X}h has 64 bits and must begin at a byte")
                    entry.bit = bit
                    bit += entry.bits
            at = (bit + 7) // 8
            if is_input:
                slave.inputs = at - begin // 8
            else:
                slave.outputs = at - begin // 8
    if at > IMAGE:
        raise BusError(f"the process data have {at} bytes; {IMAGE} are the most")


def read_eni(file: Path) -> list[Slave]:
    """The slaves of an EtherCAT Network Information file (ETG.2100): identity and mapped objects. Raises BusError."""
    import xml.etree.ElementTree as ET

    try:
        root = ET.parse(file).getroot()
    except ET.ParseError as error:
        raise BusError(f"{file} is not XML: {error}") from None
    slaves = []
    for number, node in enumerate(root.iterfind("./Config/Slave")):
        info = node.find("Info")
        text = lambda tag, info=info: (info.findtext(tag) or "0") if info is not None else "0"  # noqa: E731
        entries = []
        for tag, is_input in (("RxPdo", False), ("TxPdo", True)):
            for pdo in node.iterfind(f"./ProcessData/{tag}"):
                # a PDO that is offered but not assigned to a sync manager carries nothing
                if pdo.get("Sm") is None:
                    continue
                for entry in pdo.iterfind("Entry"):
                    index, subindex = _number(entry, "Index"), _number(entry, "SubIndex")
                    bits = _number(entry, "BitLen")
                    while bits > 0:  # padding may be longer than a number
                        part = bits if bits <= 32 or bits == 64 else 32
                        entries.append(Entry(index, subindex, is_input, part))
                        bits -= part
        drive = {0x6040, 0x6041} <= {e.index for e in entries}
        identity = tuple(_eni_int(text(tag)) for tag in ("VendorId", "ProductCode", "RevisionNo", "SerialNo"))
        name = info.findtext("Name") if info is not None else None
        slaves.append(
            Slave((name or f"slave{number}")[:31], entries, -1 if drive else 0,
                  DRIVE_PROFILE if drive else IO_PROFILE, identity)
        )  # fmt: skip
    if not slaves:
        raise BusError(f"{file} has no Config/Slave")
    return slaves


def _number(node, tag: str) -> int:
    return _eni_int(node.findtext(tag) or "0")


def _eni_int(text: str) -> int:
    """A number of an ENI file: 12, #x1A, 0x1A."""
    text = text.strip().lower()
    try:
        return int(text[2:], 16) if text.startswith(("#x", "0x")) else int(text)
    except ValueError:
        raise BusError(f"'{text}' in the ENI file is not a number") from None


# ------------------------------------------------------------------------------------------- into the image


def configure(plc, bus: Bus | None = None) -> None:
    """Write the bus, the default one if None, into the image of a program that uses it."""
    variables = plc.program.variables
    if "ECAT.SLAVE" not in variables:
        return
    bus = bus or default()
    image = _Image(plc._machine.memory, variables)
    entries = objects = 0
    for n, slave in enumerate(bus.slaves):
        first = entries
        for entry in slave.entries:
            image.put("entry", entries, index=entry.index, subindex=entry.subindex, input=entry.input,
                      bits=entry.bits, bit=entry.bit)  # fmt: skip
            entries += 1
        for index, subindex, size, read_only, data in slave.objects:
            image.put("object", objects, slave=n, index=index, subindex=subindex, readOnly=read_only, bytes=size,
                      value=int.from_bytes(data, "little"))  # fmt: skip
            objects += 1
        vendor, product, revision, serial = slave.identity
        image.put("Slave", n, name=slave.name, vendor=vendor, product=product, revision=revision, serial=serial,
                  profile=slave.profile, wired=slave.wired, axis=slave.axis, start=slave.start,
                  outputs=slave.outputs, inputs=slave.inputs, first=first, last=entries - 1)  # fmt: skip
        if slave.axis:
            image.put("Drive", slave.axis, slave=n, axis=slave.axis)
    for k, (slave, at, till) in enumerate(bus.faults):
        image.put("fault", k, slave=slave, **{"from": at, "till": till})
    image.set(
        slaves=len(bus.slaves), objects=objects, faults=len(bus.faults), startup=bus.startup,
        axes=max((s.axis for s in bus.slaves), default=0), noEni=bus.eni_missing,
        size=sum(s.outputs + s.inputs for s in bus.slaves),
    )  # fmt: skip
    image.finish()
    _tell_blocks(plc, variables, bus)


def _tell_blocks(plc, variables, bus: Bus) -> None:
    """Which drive MC_Home and the parameters of an axis mean (mclib/library/mc/McHomeDrive.st)."""
    homing = variables.get("MCHOMING.AXIS")
    if homing is None:
        return
    drives, memory = variables["ECAT.DRIVE"], plc._machine.memory
    for axis in (s.axis for s in bus.slaves if s.axis):
        at = homing.address + (axis - homing.type.bounds[0][0]) * homing.type.element.size
        drive = drives.address + (axis - drives.type.bounds[0][0]) * drives.type.element.size
        struct.pack_into("<I", memory, at + homing.type.element.members["BUS"].offset, drive)


class _Image:
    """Writes ECAT's variables, those of them that the program uses."""

    def __init__(self, memory, variables) -> None:
        self.memory, self.variables = memory, variables
        self.layouts: dict[str, tuple[int, int, dict[str, tuple[int, Any]], bytearray]] = {}

    def set(self, **values) -> None:
        for name, value in values.items():
            variable = self.variables.get(f"ECAT.{name.upper()}")
            if variable:
                data = _bytes(variable.type, value)
                self.memory[variable.address : variable.address + len(data)] = data

    def put(self, array: str, number: int, **members) -> None:
        if array not in self.layouts:
            self.layouts[array] = self._layout(array)
        low, size, layout, data = self.layouts[array]
        for name, value in members.items() if size else ():
            offset, kind = layout[name]
            at = (number - low) * size + offset
            new = _bytes(kind, value)
            data[at : at + len(new)] = new

    def finish(self) -> None:
        """Write the arrays."""
        for array, (_, size, _, data) in self.layouts.items():
            if size:
                address = self.variables[f"ECAT.{array.upper()}"].address
                self.memory[address : address + len(data)] = data

    def _layout(self, array: str) -> tuple[int, int, dict[str, tuple[int, Any]], bytearray]:
        """Lowest index, size of an element (0: the program does not use it), offset and type of members, content."""
        variable = self.variables.get(f"ECAT.{array.upper()}")
        if variable is None:
            return 0, 0, {}, bytearray()
        assert isinstance(variable.type, Array) and isinstance(variable.type.element, Struct)
        element = variable.type.element
        layout = {member.name: (member.offset, member.type) for member in element.members.values()}
        data = bytearray(self.memory[variable.address : variable.address + variable.type.size])
        return variable.type.bounds[0][0], element.size, layout, data


def _bytes(kind, value) -> bytes:
    if isinstance(kind, String):
        return value.encode("utf-8")[:31] + b"\0"
    return (int(value) & (1 << 8 * kind.size) - 1).to_bytes(kind.size, "little")

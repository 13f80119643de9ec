"""Writes a bus into the image of a program that uses it."""

from __future__ import annotations

import struct
from typing import Any

from mclib.ecat.bus import Bus
from mclib.ecat.table import default
from stcore.types import Array, String, Struct


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

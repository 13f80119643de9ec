"""What is on the bus: slaves, their objects in the process data, and where each of them lies."""

from __future__ import annotations

from dataclasses import dataclass, field

AXES, SLAVES, ENTRIES, OBJECTS, FAULTS, IMAGE = 12, 64, 1024, 256, 16, 2040  # of mclib/library/ecat/ECAT.st
DRIVE_PROFILE, IO_PROFILE, COUPLER_PROFILE = 0x00020192, 0x00000191, 0x00001389  # object 1000h


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


def number_axes(slaves: list[Slave]) -> None:
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

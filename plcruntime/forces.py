"""Forced variables: the table in the memory that the module applies before and after the programs of every scan."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from stcore.program import FORCES

ENTRY = struct.Struct("<II8s8s")  # address, size (1 or 8), value, mask: the bits that are forced
Piece = tuple[int, bytes]


class Forces:
    """active: path -> (address, value, mask) pieces; value and mask are equally long."""

    def __init__(self, machine) -> None:
        self._machine = machine
        self._capacity = 0
        self._table = 0
        self.active: dict[str, tuple[tuple[int, bytes, bytes], ...]] = {}

    def hold(self, name: str, pieces: Sequence[Piece], bit: int | None = None) -> None:
        """Force bytes, or one bit of a byte, under a path. In effect after `write_table`."""
        mask = None if bit is None else bytes([1 << bit])
        self.active[name] = tuple((address, data, mask or b"\xff" * len(data)) for address, data in pieces)

    def state(self) -> dict:
        """What is forced now, for a snapshot."""
        return dict(self.active)

    def set_state(self, state: dict) -> None:
        self.active = dict(state)
        self.write_table()

    def move_to(self, machine) -> None:
        """Another machine runs the program from now on."""
        self._machine, self._capacity = machine, 0
        self.write_table()

    def write_table(self) -> None:
        """Bring the module's table up to date; to be called again after the memory was initialised."""
        entries = [e for pieces in self.active.values() for piece in pieces for e in _split(*piece)]
        if len(entries) > self._capacity:
            self._capacity = max(16, 2 * len(entries))
            self._table = self._machine.allocate(self._capacity * ENTRY.size)
        memory = self._machine.memory
        for i, (address, data, mask) in enumerate(entries):
            ENTRY.pack_into(memory, self._table + i * ENTRY.size, address, len(data), data, mask)
        struct.pack_into("<II", memory, FORCES, self._table, len(entries))


def _split(address: int, data: bytes, mask: bytes):
    """Entries of 8 bytes or 1 for a piece of any length."""
    while data:
        size = 8 if len(data) >= 8 else 1
        yield address, data[:size], mask[:size]
        address, data, mask = address + size, data[size:], mask[size:]

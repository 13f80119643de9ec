"""Forced variables: the table in the memory that the module applies before and after the programs of every scan."""

from __future__ import annotations

import struct

from stcore.program import FORCES

ENTRY = struct.Struct("<II8s")  # address, size, value
Piece = tuple[int, bytes]


class Forces:
    """active: path -> (address, bytes) pieces. A bit is forced by `apply_bits`, between scans."""

    def __init__(self, machine) -> None:
        self._machine = machine
        self._capacity = 0
        self._table = 0
        self.active: dict[str, tuple[Piece, ...]] = {}
        self.bits: dict[str, tuple[int, int, bool]] = {}  # path -> address, bit, value

    def state(self) -> tuple[dict, dict]:
        """What is forced now, for a snapshot."""
        return dict(self.active), dict(self.bits)

    def set_state(self, state: tuple[dict, dict]) -> None:
        self.active, self.bits = dict(state[0]), dict(state[1])
        self.write_table()

    def write_table(self) -> None:
        """Bring the module's table up to date; to be called again after the memory was initialised."""
        entries = [e for pieces in self.active.values() for piece in pieces for e in _split(piece)]
        if len(entries) > self._capacity:
            self._capacity = max(16, 2 * len(entries))
            self._table = self._machine.allocate(self._capacity * ENTRY.size)
        memory = self._machine.memory
        for i, (address, data) in enumerate(entries):
            ENTRY.pack_into(memory, self._table + i * ENTRY.size, address, len(data), data)
        struct.pack_into("<II", memory, FORCES, self._table, len(entries))

    def apply_bits(self) -> None:
        """Set the forced bits in the memory."""
        memory = self._machine.memory
        for address, bit, value in self.bits.values():
            old = memory[address]
            memory[address] = old | 1 << bit if value else old & ~(1 << bit)


def _split(piece: Piece):
    """Entries of 8, 4, 2 or 1 bytes for a piece of any length."""
    address, data = piece
    while data:
        size = next(s for s in (8, 4, 2, 1) if s <= len(data))
        yield address, data[:size]
        address, data = address + size, data[size:]

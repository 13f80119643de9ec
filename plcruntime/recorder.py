"""The recorder: the tables and the buffer in the memory through which the module records all traces of a PLC.

The module copies a row of blocks of 16 bytes at the end of every scan, and writes down after every 16 rows which words
of 8 bytes changed: a row of all the variables of a program costs little time, and what does not change no memory.
"""

from __future__ import annotations

import struct
from bisect import bisect_right

from plcruntime.rows import HEADER, TOGETHER, WORD, Chunk, Keeper, Segment
from plcruntime.trace import Trace
from stcore.paths import PathError, Place
from stcore.program import TRACE

BUFFER = 1 << 23  # bytes of changes between two looks of the host
BLOCK = 2 * WORD
WORDS = 1 << 16  # of a row at most
MOST = 1 << 16  # times that 16 rows are searched
LINE = 64  # bytes of the processor's cache

# The control words, UDINT each: at 0 the address of a table of (UDINT address, UDINT bytes) and that of its end, at 20
# the bytes of a row, at 32 the bytes of the buffer that 16 more rows may need, and
ROWS = 8  # address of the copied rows (in front of them lies the one before), of the next row, of the end of the 16th
FOUND = 24  # address of the next value and, above which there is none, of the next header
SEARCHED = 36  # so many times 16 rows since the host looked
CONTROL = struct.Struct("<10I")


class Recorder:
    """Records the traces of one PLC."""

    def __init__(self, machine) -> None:
        self._machine = machine
        self._traces: list[Trace] = []
        self._finished: list[Trace] = []  # with a trigger that has fired
        self._ranges: list[tuple[int, int]] = []  # address, bytes: whole blocks
        self._moving: list[Place] = []  # behind pointers: ranges of their own, which may be elsewhere in every scan
        self._offsets: list[tuple[int, ...]] = []  # for each trace those of its columns in a row
        self._size = 0  # bytes of a row
        self._keeper = Keeper()
        self._first = b""  # the row before the first that is not drained
        self._control = 0
        self._table = self._table_capacity = 0
        self._rows = self._rows_size = 0  # room for 16 rows and the one before them
        self._buffer = self._buffer_size = 0
        self._zero = self._zero_size = 0  # bytes that stand for a variable behind a NULL pointer

    @property
    def active(self) -> bool:
        return bool(self._traces)

    @property
    def dynamic(self) -> bool:
        """True when a column lies behind a pointer, which may change with every scan."""
        return bool(self._moving)

    @property
    def waiting(self) -> list[Trace]:
        """The traces whose trigger has not fired."""
        return [t for t in self._traces if t.trigger and t.trigger.scan is None]

    @property
    def full(self) -> bool:
        """True when it is time for `drain`: the module ends a run there."""
        value, header, needed, searched = self._words(FOUND, 4)
        return header - value < needed or searched == MOST

    def _words(self, at: int, count: int) -> tuple[int, ...]:
        return struct.unpack_from(f"<{count}I", self._machine.memory, self._control + at)

    def add(self, trace: Trace, scan: int) -> None:
        """Begin a trace; `scan` scans are finished. Raises ValueError when it and the others hold too many bytes."""
        bytes_wanted = sum(p.size + 2 * BLOCK for t in (*self._traces, trace) for p in t.places)
        if bytes_wanted > WORDS * WORD and sum(_row_bytes(t.places) for t in (*self._traces, trace)) > WORDS * WORD:
            raise ValueError(f"a trace holds at most {WORDS * WORD // 1024} KB a scan; name fewer variables")
        self.drain(scan)
        self._traces.append(trace)
        self.arrange()

    def remove(self, trace: Trace, scan: int) -> None:
        self.drain(scan)
        (self._finished if trace in self._finished else self._traces).remove(trace)
        self.arrange()

    def swap(self, traces: list[Trace]) -> list[Trace]:
        """Record other traces from now on; gives those that were recorded until now."""
        before, self._traces = self._traces, traces
        self.arrange()
        return before

    def move_to(self, machine) -> None:
        """Another machine runs the program from now on."""
        self._machine = machine
        self._control = self._table_capacity = self._rows_size = self._buffer_size = self._zero_size = 0
        self.arrange()

    def forget_from(self, scan: int) -> None:
        """Drop the rows of a scan and of all after it: the PLC went back. To be followed by `arrange`."""
        for trace in self._traces + self._finished:
            trace.forget_from(scan)
        self._traces += [t for t in self._finished if not t.done]
        self._finished = [t for t in self._finished if t.done]

    def pause(self) -> None:
        """Record nothing until `arrange`."""
        struct.pack_into("<I", self._machine.memory, TRACE, 0)

    def arrange(self) -> None:
        """Write the tables; to be called again after the memory was initialised."""
        self.pause()
        places = [p for t in self._traces for p in t.places]
        self._ranges = _ranges([p for p in places if not p.hops])
        self._moving = [p for p in places if p.hops]
        self._lay_out()
        if not places:
            return
        self._control = self._control or self._machine.allocate(CONTROL.size)
        count = len(self._ranges) + len(self._moving)
        if count > self._table_capacity:
            self._table_capacity = 2 * count
            self._table = self._machine.allocate(8 * self._table_capacity)
        if (TOGETHER + 1) * self._size > self._rows_size:
            self._rows_size = (TOGETHER + 1) * self._size
            self._rows = -(-self._machine.allocate(self._rows_size + LINE) // LINE) * LINE
        needed = self._size // BLOCK * (HEADER.size + TOGETHER * BLOCK)
        if max(BUFFER, 4 * needed) > self._buffer_size:
            self._buffer_size = max(BUFFER, 4 * needed)
            self._buffer = self._machine.allocate(self._buffer_size)
        most = max((_whole(p.size) for p in self._moving), default=0)
        if most > self._zero_size:
            self._zero, self._zero_size = self._machine.allocate(most), most
        memory = self._machine.memory
        for i, (address, size) in enumerate(self._ranges):
            struct.pack_into("<II", memory, self._table + 8 * i, address, size)
        self.follow_pointers()
        first = self._rows + self._size
        CONTROL.pack_into(
            memory, self._control, self._table, self._table + 8 * count, first, first, first + TOGETHER * self._size,
            self._size, 0, 0, needed, 0,
        )  # fmt: skip
        self._rewind()
        struct.pack_into("<I", memory, TRACE, self._control)

    def _lay_out(self) -> None:
        """Where every column lies in a row: the ranges one after another, then what lies behind pointers."""
        starts, at = [], 0
        for _, size in self._ranges:
            starts.append(at)
            at += size
        bases = [address for address, _ in self._ranges]
        self._offsets = []
        for trace in self._traces:
            offsets = []
            for place in trace.places:
                if place.hops:
                    offsets.append(at)
                    at += _whole(place.size)
                else:
                    k = bisect_right(bases, place.address) - 1
                    offsets.append(starts[k] + place.address - bases[k])
            self._offsets.append(tuple(offsets))
        self._size = at

    def follow_pointers(self) -> None:
        """Write where the columns behind pointers live now."""
        memory = self._machine.memory
        for i, place in enumerate(self._moving, len(self._ranges)):
            try:
                address = place.locate(memory)
            except PathError:  # not connected yet: recorded as 0
                address = self._zero
            size = _whole(place.size)
            if address + size > len(memory):  # a wild pointer to the end of the memory
                address = self._zero
            struct.pack_into("<II", memory, self._table + 8 * i, address, size)

    def drain(self, scan: int) -> None:
        """Take out the rows; `scan` scans are finished now."""
        if not self._traces:
            return
        start, following = self._words(ROWS, 2)
        rows = self._words(SEARCHED, 1)[0] * TOGETHER + (following - start) // self._size
        if rows:
            if following != start:
                self._machine.search_rows()
            value, header = self._words(FOUND, 2)
            memory, end = self._machine.memory, self._buffer + self._buffer_size
            values = self._keeper.keep(memory[self._buffer : value])
            chunk = Chunk(self._first, self._keeper.keep(memory[header + HEADER.size : end]), values, rows)
            for trace, offsets in zip(self._traces, self._offsets, strict=True):
                trace.segments.append(Segment(scan - rows, 0, rows, offsets, chunk))
                trace.trim()
        finished = [t for t in self._traces if t.done]
        if finished:
            self._finished += finished
            self._traces = [t for t in self._traces if t not in finished]
            self.arrange()
        elif rows:
            self._rewind()

    def _rewind(self) -> None:
        """Begin the buffer anew; what changes from now on changes from the row before, as it is noted."""
        memory = self._machine.memory
        self._first = bytes(memory[self._rows : self._rows + self._size])
        header = self._buffer + self._buffer_size - HEADER.size
        struct.pack_into("<II", memory, self._control + FOUND, self._buffer, header)
        struct.pack_into("<I", memory, self._control + SEARCHED, 0)


def _row_bytes(places: list[Place]) -> int:
    """Bytes of the blocks that a trace needs by itself."""
    still = sum(size for _, size in _ranges([p for p in places if not p.hops]))
    return still + sum(_whole(p.size) for p in places if p.hops)


def _whole(size: int) -> int:
    """Bytes of the blocks that hold so many."""
    return -(-size // BLOCK) * BLOCK


def _ranges(places: list[Place]) -> list[tuple[int, int]]:
    """(address, bytes) of stretches of whole blocks that hold all the places."""
    ranges: list[list[int]] = []
    for address, end in sorted((p.address, p.address + p.size) for p in places):
        address = address // BLOCK * BLOCK
        if ranges and address <= ranges[-1][1]:
            ranges[-1][1] = max(ranges[-1][1], address + _whole(end - address))
        else:
            ranges.append([address, address + _whole(end - address)])
    return [(address, end - address) for address, end in ranges]

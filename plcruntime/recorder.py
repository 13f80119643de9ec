"""The recorder: the tables and the buffer in the memory through which the module records all traces of a PLC.

The module compares whole blocks of 32 bytes and writes down the words that have changed since the last scan: a row of
all the variables of a program costs little time and memory where few of them change.
"""

from __future__ import annotations

import struct
from bisect import bisect_right

from plcruntime.rows import ENTRY, ROWS, WORD, WORDS, Chunk, Keeper, Segment
from plcruntime.trace import Trace
from stcore.paths import PathError, Place
from stcore.program import TRACE, TRACE_BEFORE, TRACE_END, TRACE_NEXT, TRACE_ROW

BUFFER = 1 << 20  # bytes of changes between two looks of the host
BLOCK = 4 * WORD


class Recorder:
    """Records the traces of one PLC."""

    def __init__(self, machine) -> None:
        self._machine = machine
        self._traces: list[Trace] = []
        self._finished: list[Trace] = []  # with a trigger that has fired
        self._ranges: list[tuple[int, int]] = []  # address, number of blocks
        self._moving: list[Place] = []  # behind pointers: ranges of their own, which may be elsewhere in every scan
        self._offsets: list[tuple[int, ...]] = []  # for each trace those of its columns in the blocks
        self._start = 0  # of the buffer
        self._row_size = 0  # bytes of the changes of a row in which every word changes
        self._blocks = 0
        self._keeper = Keeper()
        self._first = b""  # the blocks before the first row in the buffer
        self._table = self._table_capacity = self._buffer_size = 0
        self._before = self._before_size = 0  # the blocks at the last row
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
    def room(self) -> int:
        """Scans that may run before `drain`; 0 when it is time for that."""
        left = self._start + self._buffer_size - self._word(TRACE_NEXT)
        if left < self._buffer_size // 4:
            return 0
        return min(left // self._row_size, ROWS - self._word(TRACE_ROW))

    def _word(self, address: int) -> int:
        return int.from_bytes(self._machine.memory[address : address + 4], "little")

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
        self._table_capacity = self._buffer_size = self._before_size = self._zero_size = 0
        self.arrange()

    def forget_from(self, scan: int) -> None:
        """Drop the rows of a scan and of all after it: the PLC went back. To be followed by `arrange`."""
        for trace in self._traces + self._finished:
            trace.forget_from(scan)
        self._traces += [t for t in self._finished if not t.done]
        self._finished = [t for t in self._finished if t.done]

    def pause(self) -> None:
        """Record nothing until `arrange`."""
        struct.pack_into("<I", self._machine.memory, TRACE + 4, 0)

    def arrange(self) -> None:
        """Write the table; to be called again after the memory was initialised."""
        places = [p for t in self._traces for p in t.places]
        self._ranges = _ranges([p for p in places if not p.hops])
        self._moving = [p for p in places if p.hops]
        self._lay_out()
        count = len(self._ranges) + len(self._moving)
        if count > self._table_capacity:
            self._table_capacity = 2 * count
            self._table = self._machine.allocate(8 * self._table_capacity)
        needed = max(BUFFER, 16 * self._row_size) if places else 0
        if needed > self._buffer_size:
            self._start, self._buffer_size = self._machine.allocate(needed), needed
        if self._blocks * BLOCK > self._before_size:
            self._before_size = self._blocks * BLOCK
            self._before = self._machine.allocate(self._before_size)
        most = max((_blocks(p.size) * BLOCK for p in self._moving), default=0)
        if most > self._zero_size:
            self._zero, self._zero_size = self._machine.allocate(most), most
        memory = self._machine.memory
        for i, (address, blocks) in enumerate(self._ranges):
            struct.pack_into("<II", memory, self._table + 8 * i, address, blocks)
        self.follow_pointers()
        struct.pack_into("<II", memory, TRACE, self._table, count)
        struct.pack_into("<I", memory, TRACE_BEFORE, self._before)
        self._rewind()

    def _lay_out(self) -> None:
        """Where every column lies in the blocks: the ranges one after another, then what lies behind pointers."""
        starts, at = [], 0
        for _, blocks in self._ranges:
            starts.append(at)
            at += blocks * BLOCK
        bases = [address for address, _ in self._ranges]
        self._offsets = []
        for trace in self._traces:
            offsets = []
            for place in trace.places:
                if place.hops:
                    offsets.append(at)
                    at += _blocks(place.size) * BLOCK
                else:
                    k = bisect_right(bases, place.address) - 1
                    offsets.append(starts[k] + place.address - bases[k])
            self._offsets.append(tuple(offsets))
        self._blocks = at // BLOCK
        self._row_size = self._blocks * (BLOCK // WORD) * ENTRY.size

    def follow_pointers(self) -> None:
        """Write where the columns behind pointers live now."""
        memory = self._machine.memory
        for i, place in enumerate(self._moving, len(self._ranges)):
            try:
                address = place.locate(memory)
            except PathError:  # not connected yet: recorded as 0
                address = self._zero
            blocks = _blocks(place.size)
            if address + blocks * BLOCK > len(memory):  # a wild pointer to the end of the memory
                address = self._zero
            struct.pack_into("<II", memory, self._table + 8 * i, address, blocks)

    def drain(self, scan: int) -> None:
        """Take the rows out of the buffer; `scan` scans are finished now."""
        if not self._traces:
            return
        rows = self._word(TRACE_ROW)
        if rows:
            entries = self._keeper.keep(self._machine.memory[self._start : self._word(TRACE_NEXT)])
            chunk = Chunk(self._first, entries, rows)
            for trace, offsets in zip(self._traces, self._offsets, strict=True):
                trace.segments.append(Segment(scan - rows, 0, rows, offsets, chunk))
                trace.trim()
        finished = [t for t in self._traces if t.done]
        if finished:
            self._finished += finished
            self._traces = [t for t in self._traces if t not in finished]
            self.arrange()
        else:
            self._rewind()

    def _rewind(self) -> None:
        """Begin the buffer anew; what changes from now on changes from the blocks as they are noted."""
        memory = self._machine.memory
        self._first = bytes(memory[self._before : self._before + self._blocks * BLOCK])
        struct.pack_into("<I", memory, TRACE_NEXT, self._start)
        struct.pack_into("<I", memory, TRACE_END, self._start + self._buffer_size - self._row_size)
        struct.pack_into("<I", memory, TRACE_ROW, 0)


def _row_bytes(places: list[Place]) -> int:
    """Bytes of the blocks that a trace needs by itself."""
    still = sum(blocks for _, blocks in _ranges([p for p in places if not p.hops]))
    return (still + sum(_blocks(p.size) for p in places if p.hops)) * BLOCK


def _blocks(size: int) -> int:
    return -(-size // BLOCK)


def _ranges(places: list[Place]) -> list[tuple[int, int]]:
    """(address, number of blocks) of stretches of whole blocks that hold all the places."""
    ranges: list[list[int]] = []
    for address, end in sorted((p.address, p.address + p.size) for p in places):
        address = address // BLOCK * BLOCK
        if ranges and address <= ranges[-1][1]:
            ranges[-1][1] = max(ranges[-1][1], address + _blocks(end - address) * BLOCK)
        else:
            ranges.append([address, address + _blocks(end - address) * BLOCK])
    return [(address, (end - address) // BLOCK) for address, end in ranges]

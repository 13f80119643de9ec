"""The recorder: the table and the buffer in the memory through which the module records all traces of a PLC.

Variables that lie side by side are copied as one: a row of all the variables of a program is a few copies.
"""

from __future__ import annotations

import struct
from bisect import bisect_right

from plcruntime.trace import Segment, Trace
from stcore.paths import PathError, Place
from stcore.program import TRACE, TRACE_NEXT

BUFFER = 1 << 20  # bytes of rows between two looks of the host
GAP = 16  # bytes that nobody traces and that are copied rather than a second range begun


class Recorder:
    """Records the traces of one PLC."""

    def __init__(self, machine) -> None:
        self._machine = machine
        self._traces: list[Trace] = []
        self._finished: list[Trace] = []  # with a trigger that has fired
        self._ranges: list[tuple[int, int]] = []  # address, size
        self._moving: list[Place] = []  # behind pointers: ranges of their own, which may be elsewhere in every scan
        self._offsets: list[tuple[int, ...]] = []  # for each trace those of its columns in a row
        self._start = 0  # of the buffer
        self._rows_that_fit = 0
        self._row_size = 0
        self._table = self._table_capacity = self._buffer_size = 0
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
        """Scans that may run before `drain`."""
        end = int.from_bytes(self._machine.memory[TRACE_NEXT : TRACE_NEXT + 4], "little")
        return self._rows_that_fit - (end - self._start) // self._row_size

    def add(self, trace: Trace, scan: int) -> None:
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
        self._table_capacity = self._buffer_size = self._zero_size = 0
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
        most = max((p.size for p in self._moving), default=0)
        if most > self._zero_size:
            self._zero, self._zero_size = self._machine.allocate(most), most
        self._rows_that_fit = self._buffer_size // self._row_size if self._row_size else 0
        memory = self._machine.memory
        for i, (address, size) in enumerate(self._ranges):
            struct.pack_into("<II", memory, self._table + 8 * i, address, size)
        self.follow_pointers()
        struct.pack_into("<II", memory, TRACE, self._table, count)
        self._rewind()

    def _lay_out(self) -> None:
        """Where in a row every column lies: the ranges one after another, then what lies behind pointers."""
        starts, at = [], 0
        for _, size in self._ranges:
            starts.append(at)
            at += size
        where = {}
        for (address, size), start in zip(self._ranges, starts, strict=True):
            where[address] = (start, size)
        bases = sorted(where)
        self._offsets = []
        for trace in self._traces:
            offsets = []
            for place in trace.places:
                if place.hops:
                    offsets.append(at)
                    at += place.size
                else:
                    base = bases[bisect_right(bases, place.address) - 1]
                    offsets.append(where[base][0] + place.address - base)
            self._offsets.append(tuple(offsets))
        self._row_size = at

    def follow_pointers(self) -> None:
        """Write where the columns behind pointers live now."""
        memory = self._machine.memory
        for i, place in enumerate(self._moving, len(self._ranges)):
            try:
                address = place.locate(memory)
            except PathError:  # not connected yet: recorded as 0
                address = self._zero
            struct.pack_into("<II", memory, self._table + 8 * i, address, place.size)

    def drain(self, scan: int) -> None:
        """Take the rows out of the buffer; `scan` scans are finished now."""
        if not self._traces:
            return
        memory = self._machine.memory
        end = int.from_bytes(memory[TRACE_NEXT : TRACE_NEXT + 4], "little")
        data = bytes(memory[self._start : end])
        rows = len(data) // self._row_size if self._row_size else 0
        if rows:
            for trace, offsets in zip(self._traces, self._offsets, strict=True):
                trace.segments.append(Segment(scan - rows, rows, self._row_size, 0, offsets, data))
                trace.trim()
        finished = [t for t in self._traces if t.done]
        if finished:
            self._finished += finished
            self._traces = [t for t in self._traces if t not in finished]
            self.arrange()
        else:
            self._rewind()

    def _rewind(self) -> None:
        end = self._start + self._rows_that_fit * self._row_size
        struct.pack_into("<II", self._machine.memory, TRACE_NEXT, self._start, end)


def _ranges(places: list[Place]) -> list[tuple[int, int]]:
    """(address, size) of stretches of memory that hold all the places."""
    ranges: list[list[int]] = []
    for address, end in sorted((p.address, p.address + p.size) for p in places):
        if ranges and address - ranges[-1][1] <= GAP:
            ranges[-1][1] = max(ranges[-1][1], end)
        else:
            ranges.append([address, end])
    return [(address, end - address) for address, end in ranges]

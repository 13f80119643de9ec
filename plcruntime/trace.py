"""Traces: variables recorded at the end of every scan, by the module itself, as columns of numbers."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from stcore.paths import PathError, Place
from stcore.program import TRACE, TRACE_NEXT
from stcore.types import Elementary, Pointer, base_of
from stcore.values import FORMATS, PER_SECOND, decode

BUFFER = 1 << 20  # bytes of rows between two looks of the host


@dataclass(slots=True)
class Segment:
    """Rows of successive scans. data: whole rows of the recorder, of which this trace's part begins at offset."""

    first_scan: int
    rows: int
    row_size: int
    offset: int
    data: bytes


class Trace:
    """Recorded variables; grows while the PLC runs. ``trace["PLC_PRG.x"]`` is a numpy array with one value a scan.

    time: seconds of virtual time that each scan saw. BOOL is bool, TIME and dates are seconds, an ENUM its number.
    """

    def __init__(self, places: Sequence[Place], interval: int) -> None:
        self.places = list(places)
        self.interval = interval  # ns
        self.segments: list[Segment] = []
        self._offsets: dict[str, tuple[int, Place]] = {}
        at = 0
        for place in self.places:
            self._offsets[place.name.upper()] = (at, place)
            at += place.size
        self.row_size = at

    @property
    def names(self) -> list[str]:
        """Full paths of the columns, in order."""
        return [p.name for p in self.places]

    def __len__(self) -> int:
        return sum(s.rows for s in self.segments)

    @property
    def time(self):
        """numpy array: seconds of virtual time, one a row."""
        import numpy as np

        parts = [np.arange(s.first_scan, s.first_scan + s.rows) for s in self.segments]
        return _joined(np, parts, np.int64) * self.interval / 1e9

    def __getitem__(self, path: str):
        """The column of a path, or of the end of one (``x`` for ``PLC_PRG.x``). Raises PathError."""
        import numpy as np

        offset, place = self._find(path)
        code = _code(place)
        text = "s" in code
        dtype = np.dtype(f"V{place.size}" if text else "<" + code)
        parts = [
            np.ndarray((s.rows,), dtype, s.data, s.offset + offset, (s.row_size,)) for s in self.segments if s.rows
        ]
        column = _joined(np, parts, dtype)
        if text:
            return np.array([decode(v.tobytes(), place.type, 0) for v in column], dtype=object)
        if place.bit is not None:
            return column >> place.bit & 1 == 1
        scale = _scale(place)
        return column / scale if scale else column

    def _find(self, path: str) -> tuple[int, Place]:
        wanted = path.upper().replace(" ", "")
        if wanted in self._offsets:
            return self._offsets[wanted]
        ending = [entry for name, entry in self._offsets.items() if name.endswith("." + wanted)]
        if len(ending) == 1:
            return ending[0]
        what = "stands for several columns" if ending else "is not traced"
        raise PathError(f"'{path}' {what}; traced: {', '.join(self.names)}")

    @property
    def columns(self) -> dict:
        """Full path -> numpy array."""
        return {name: self[name] for name in self.names}

    def tail(self, count: int) -> list[tuple]:
        """The last rows, as `rows` gives them."""
        kept = Trace(self.places, self.interval)
        for s in reversed(self.segments):
            take = min(count - len(kept), s.rows)
            if take > 0:
                skipped = s.rows - take
                offset = s.offset + skipped * s.row_size
                kept.segments.insert(0, Segment(s.first_scan + skipped, take, s.row_size, offset, s.data))
        return list(kept.rows())

    def compare(self, path, tolerance: float = 0.0, tolerances: dict | None = None) -> None:
        """Compare with a recorded trace (a .csv that `to_csv` wrote); plcruntime.golden tells more.

        Raises plcruntime.golden.GoldenMismatch (an AssertionError) with the difference, UsageError for a bad file."""
        from plcruntime.golden import compare

        compare(self, path, tolerance, tolerances)

    def rows(self) -> Iterator[tuple]:
        """(time in s, value, value ...) of every scan, without numpy."""
        layout = struct.Struct("<" + "".join(_code(p) for p in self.places))
        shapes = [(i, p, _scale(p)) for i, p in enumerate(self.places)]
        odd = [(i, p, scale) for i, p, scale in shapes if scale or p.bit is not None or "s" in _code(p)]
        for s in self.segments:
            for k in range(s.rows):
                values = layout.unpack_from(s.data, s.offset + k * s.row_size)
                if odd:
                    values = list(values)
                    for i, p, scale in odd:
                        values[i] = _converted(values[i], p, scale)
                yield ((s.first_scan + k) * self.interval / 1e9, *values)

    def forget_from(self, scan: int) -> None:
        """Drop the rows of a scan and of all after it: the PLC went back."""
        self.segments = [s for s in self.segments if s.first_scan < scan]
        for s in self.segments:
            s.rows = min(s.rows, scan - s.first_scan)

    def to_csv(self, path) -> None:
        """Write a header (time, full paths) and a row for each scan; BOOL as 0 and 1. Raises OSError."""
        import csv

        with open(path, "w", newline="", encoding="utf-8") as out:
            writer = csv.writer(out, lineterminator="\n")
            writer.writerow(["time", *self.names])
            flags = [i + 1 for i, p in enumerate(self.places) if p.bit is not None or p.type.name == "BOOL"]
            if not flags:
                writer.writerows(self.rows())
                return
            for row in self.rows():
                row = list(row)
                for i in flags:
                    row[i] = int(row[i])
                writer.writerow(row)

    def to_npz(self, path) -> None:
        """Write a numpy archive: the array `time` and one under each full path. Raises OSError."""
        import numpy as np

        columns = {n: c.astype(str) if c.dtype == object else c for n, c in self.columns.items()}
        with open(path, "wb") as out:
            np.savez_compressed(out, time=self.time, **columns)

    def to_html(self, path, title: str = "") -> None:
        """Write a self-contained page with the curves and a cursor. Raises OSError."""
        from plcruntime.plot import draw

        draw(self, path, title=title)

    plot = to_html


class Recorder:
    """The table and the buffer in the memory through which the module records all traces of a PLC."""

    def __init__(self, machine) -> None:
        self._machine = machine
        self._traces: list[Trace] = []
        self._start = 0  # of the buffer
        self._rows_that_fit = 0
        self._row_size = 0
        self._table = self._table_capacity = self._buffer_size = 0
        self._zero = 0  # bytes that stand for a variable behind a NULL pointer

    @property
    def active(self) -> bool:
        return bool(self._traces)

    @property
    def dynamic(self) -> bool:
        """True when a column lies behind a pointer, which may change with every scan."""
        return any(p.hops for t in self._traces for p in t.places)

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
        self._traces.remove(trace)
        self.arrange()

    def swap(self, traces: list[Trace]) -> list[Trace]:
        """Record other traces from now on; gives those that were recorded until now."""
        before, self._traces = self._traces, traces
        self.arrange()
        return before

    def move_to(self, machine) -> None:
        """Another machine runs the program from now on."""
        self._machine = machine
        self._table_capacity = self._buffer_size = self._zero = 0
        self.arrange()

    def forget_from(self, scan: int) -> None:
        for trace in self._traces:
            trace.forget_from(scan)

    def pause(self) -> None:
        """Record nothing until `arrange`."""
        struct.pack_into("<I", self._machine.memory, TRACE + 4, 0)

    def arrange(self) -> None:
        """Write the table; to be called again after the memory was initialised."""
        places = [p for t in self._traces for p in t.places]
        self._row_size = sum(t.row_size for t in self._traces)
        if len(places) > self._table_capacity:
            self._table_capacity = 2 * len(places)
            self._table = self._machine.allocate(8 * self._table_capacity)
        needed = max(BUFFER, 16 * self._row_size) if places else 0
        if needed > self._buffer_size:
            self._start, self._buffer_size = self._machine.allocate(needed), needed
        if self.dynamic and not self._zero:
            self._zero = self._machine.allocate(max(p.size for p in places))
        self._rows_that_fit = self._buffer_size // self._row_size if self._row_size else 0
        self.follow_pointers()
        self._rewind()

    def follow_pointers(self) -> None:
        """Write where every column lives now."""
        memory = self._machine.memory
        places = [p for t in self._traces for p in t.places]
        for i, place in enumerate(places):
            try:
                address = place.locate(memory)
            except PathError:  # not connected yet: recorded as 0
                address = self._zero
            struct.pack_into("<II", memory, self._table + 8 * i, address, place.size)
        struct.pack_into("<II", memory, TRACE, self._table, len(places))

    def drain(self, scan: int) -> None:
        """Take the rows out of the buffer; `scan` scans are finished now."""
        if not self._traces:
            return
        memory = self._machine.memory
        end = int.from_bytes(memory[TRACE_NEXT : TRACE_NEXT + 4], "little")
        data = bytes(memory[self._start : end])
        rows = len(data) // self._row_size if self._row_size else 0
        if rows:
            offset = 0
            for trace in self._traces:
                trace.segments.append(Segment(scan - rows, rows, self._row_size, offset, data))
                offset += trace.row_size
        self._rewind()

    def _rewind(self) -> None:
        end = self._start + self._rows_that_fit * self._row_size
        struct.pack_into("<II", self._machine.memory, TRACE_NEXT, self._start, end)


def _code(place: Place) -> str:
    """The struct code of a column."""
    t = base_of(place.type)
    if place.bit is not None:
        return "B"
    if isinstance(t, Pointer):
        return "I"
    if isinstance(t, Elementary) and t.kind != "char":
        return FORMATS[t.name]
    return f"{place.size}s"


def _scale(place: Place) -> int | None:
    t = base_of(place.type)
    return PER_SECOND.get(t.name) if isinstance(t, Elementary) else None


def _converted(value, place: Place, scale: int | None):
    if place.bit is not None:
        return bool(value >> place.bit & 1)
    return value / scale if scale else decode(value, place.type, 0)


def _joined(np, parts: list, dtype):
    return np.concatenate(parts) if parts else np.empty(0, dtype)

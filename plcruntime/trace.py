"""Traces: variables recorded at the end of every scan, by the module itself, as columns of numbers."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence

from plcruntime.rows import Segment
from plcruntime.trigger import Trigger
from stcore.paths import PathError, Place
from stcore.types import Elementary, Pointer, base_of
from stcore.values import FORMATS, PER_SECOND, decode


class Trace:
    """Recorded variables; grows while the PLC runs. ``trace["PLC_PRG.x"]`` is a numpy array with one value a scan.

    time: seconds of virtual time that each scan saw. BOOL is bool, TIME and dates are seconds, an ENUM its number.
    trigger: what it waits for, None for a trace that keeps every scan. left_out: arrays too large for a trace of all.
    """

    def __init__(self, places: Sequence[Place], interval: int, trigger: Trigger | None = None) -> None:
        self.places = list(places)
        self.interval = interval  # ns
        self.trigger = trigger
        self.left_out: list[str] = []
        self.segments: list[Segment] = []
        self._columns = {place.name.upper(): i for i, place in enumerate(self.places)}

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

        i = self._find(path)
        place = self.places[i]
        code = _code(place)
        text = "s" in code
        dtype = np.dtype(f"V{place.size}" if text else "<" + code)
        column = _joined(np, [s.column(i, dtype) for s in self.segments if s.rows], dtype)
        if text:
            return np.array([decode(v.tobytes(), place.type, 0) for v in column], dtype=object)
        if place.bit is not None:
            return column >> place.bit & 1 == 1
        scale = _scale(place)
        return column / scale if scale else column

    def _find(self, path: str) -> int:
        wanted = path.upper().replace(" ", "")
        if wanted in self._columns:
            return self._columns[wanted]
        ending = [i for name, i in self._columns.items() if name.endswith("." + wanted)]
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
                kept.segments.insert(0, s.part(s.rows - take, take))
        return list(kept.rows())

    def compare(self, path, tolerance: float = 0.0, tolerances: dict | None = None) -> None:
        """Compare with a recorded trace (a .csv that `to_csv` wrote); plcruntime.golden tells more.

        Raises plcruntime.golden.GoldenMismatch (an AssertionError) with the difference, UsageError for a bad file."""
        from plcruntime.golden import compare

        compare(self, path, tolerance, tolerances)

    def rows(self) -> Iterator[tuple]:
        """(time in s, value, value ...) of every scan, without numpy."""
        shapes = [(i, p, _scale(p)) for i, p in enumerate(self.places)]
        odd = [(i, p, scale) for i, p, scale in shapes if scale or p.bit is not None or "s" in _code(p)]
        row: list = [None] * len(self.places)
        for s in self.segments:
            layers = _layers(self.places, s.offsets)
            for k, image in enumerate(s.images()):
                for layout, columns in layers:
                    for i, value in zip(columns, layout.unpack_from(image), strict=True):
                        row[i] = value
                for i, p, scale in odd:
                    row[i] = _converted(row[i], p, scale)
                yield ((s.first_scan + k) * self.interval / 1e9, *row)

    def forget_from(self, scan: int) -> None:
        """Drop the rows of a scan and of all after it: the PLC went back."""
        self.segments = [s for s in self.segments if s.first_scan < scan]
        for s in self.segments:
            s.rows = min(s.rows, scan - s.first_scan)
        if self.trigger and self.trigger.scan is not None and self.trigger.scan >= scan:
            self.trigger.scan = None

    @property
    def triggered(self) -> float | None:
        """The virtual time in s of the scan that fired the trigger, None while it waits."""
        waits = self.trigger is None or self.trigger.scan is None
        return None if waits else self.trigger.scan * self.interval / 1e9

    @property
    def done(self) -> bool:
        """Whether all the rows around the trigger are there; such a trace records no more."""
        if self.trigger is None or self.trigger.scan is None or not self.segments:
            return False
        last = self.segments[-1]
        return last.first_scan + last.rows > self.trigger.last

    def trim(self) -> None:
        """Drop the rows too far from the trigger; while it waits, those too old for it."""
        if self.trigger is None or not self.segments:
            return
        last = self.segments[-1]
        first, end = self.trigger.window(last.first_scan + last.rows)
        kept = []
        for s in self.segments:
            skip = max(0, first - s.first_scan)
            rows = min(s.rows, end - s.first_scan) - skip
            if rows > 0:
                kept.append(s.part(skip, rows))
        self.segments = kept

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


def _layers(places: Sequence[Place], offsets: Sequence[int]) -> list[tuple[struct.Struct, list[int]]]:
    """How to read a row: formats with the columns that they give. Columns that overlap (x and x.3) take several."""
    layers: list[list] = []  # end, format, columns
    for i in sorted(range(len(places)), key=offsets.__getitem__):
        at, size = offsets[i], places[i].size
        layer = next((x for x in layers if x[0] <= at), None)
        if layer is None:
            layers.append(layer := [0, "<", []])
        layer[1] += f"{at - layer[0]}x{_code(places[i])}"
        layer[2].append(i)
        layer[0] = at + size
    return [(struct.Struct(form), columns) for _, form, columns in layers]


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

"""Rows of a trace as the module records them: all words at first, then every word that changed, with its row."""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field

WORD = 8  # bytes
ENTRY = struct.Struct(f"<HH{WORD}s")  # row, number of the word, the word
ROWS = WORDS = 1 << 16  # so many of each at most
ARENA = 1 << 24  # bytes of memory taken at once for what was recorded
LARGE = 1 << 18  # bytes from which on it pays
_HUGE = getattr(mmap, "MADV_HUGEPAGE", None)  # Linux


class Keeper:
    """Keeps copies of recorded bytes. Touching new memory takes longer than recording: large pages make it bearable."""

    def __init__(self) -> None:
        self._arena: memoryview | None = None
        self._used = ARENA

    def keep(self, data: memoryview) -> bytes | memoryview:
        """A copy."""
        if _HUGE is None or len(data) < LARGE or len(data) > ARENA:
            return bytes(data)
        if self._used + len(data) > ARENA:
            memory = mmap.mmap(-1, ARENA, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
            memory.madvise(_HUGE)
            self._arena, self._used = memoryview(memory), 0
        part = self._arena[self._used : self._used + len(data)]
        part[:] = data
        self._used += len(data)
        return part


@dataclass(slots=True)
class Chunk:
    """Successive rows. before: all words before the first row; entries: what changed, in order."""

    before: bytes
    entries: bytes | memoryview
    rows: int
    _changes: dict = field(default_factory=dict)  # number -> (rows, words) as arrays
    _grouped: bool = False

    def column(self, offset: int, dtype):
        """numpy array: the value at an offset in every row."""
        import numpy as np

        size = dtype.itemsize
        numbers = range(offset // WORD, (offset + size - 1) // WORD + 1)
        parts = [self._word(number) for number in numbers]  # a text may need several
        skip = offset - numbers[0] * WORD
        whole = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
        return np.ascontiguousarray(whole[:, skip : skip + size]).view(dtype)[:, 0]

    def _word(self, number: int):
        """numpy array of bytes: a word in every row."""
        import numpy as np

        if not self._grouped:
            self._group()
        first = np.frombuffer(self.before, np.uint8, WORD, number * WORD)
        rows, words = self._changes.get(number, (np.empty(0, np.uint16), np.empty((0, WORD), np.uint8)))
        held = np.searchsorted(rows, np.arange(self.rows), side="right")  # how often it has changed by then
        return np.concatenate((first[None, :], words))[held]

    def _group(self) -> None:
        import numpy as np

        entries = np.frombuffer(self.entries, np.dtype([("row", "<u2"), ("word", "<u2"), ("data", np.uint8, WORD)]))
        order = np.argsort(entries["word"], kind="stable")
        numbers, starts = np.unique(entries["word"][order], return_index=True)
        for number, of_word in zip(numbers.tolist(), np.split(order, starts[1:]), strict=False):
            self._changes[number] = (entries["row"][of_word], entries["data"][of_word])
        self._grouped = True

    def images(self) -> Iterator[bytearray]:
        """All words as they are in row after row; the same bytearray each time."""
        image = bytearray(self.before)
        entries = ENTRY.iter_unpack(self.entries)
        entry = next(entries, None)
        for row in range(self.rows):
            while entry is not None and entry[0] == row:
                image[entry[1] * WORD : entry[1] * WORD + WORD] = entry[2]
                entry = next(entries, None)
            yield image


@dataclass(slots=True)
class Segment:
    """Rows of successive scans of one trace: some of a chunk. offsets: of each column of the trace among the words."""

    first_scan: int
    skip: int
    rows: int
    offsets: tuple[int, ...]
    chunk: Chunk

    def part(self, skip: int, rows: int) -> Segment:
        """Some of the rows."""
        return Segment(self.first_scan + skip, self.skip + skip, rows, self.offsets, self.chunk)

    def column(self, i: int, dtype):
        """numpy array: the values of column i."""
        return self.chunk.column(self.offsets[i], dtype)[self.skip : self.skip + self.rows]

    def images(self) -> Iterator[bytearray]:
        """The words in row after row."""
        for k, image in enumerate(self.chunk.images()):
            if k >= self.skip + self.rows:
                return
            if k >= self.skip:
                yield image

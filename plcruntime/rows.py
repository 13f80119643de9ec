"""Rows of a trace as the module records them: all words at first, then those that changed, 16 rows at a time."""

from __future__ import annotations

import ctypes
import functools
import mmap
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future

WORD = 8  # bytes
TOGETHER = 16  # rows that are searched at a time
HEADER = struct.Struct("<HHI")  # number of a pair of words, number of the 16 rows, for each row two bits: what changed
ARENA = 1 << 24  # bytes of memory taken at once for what was recorded
LARGE = 1 << 18  # bytes from which on it pays
_HUGE = getattr(mmap, "MADV_HUGEPAGE", None)  # Linux


class Keeper:
    """Keeps copies of recorded bytes. Touching new memory takes longer than recording: large pages make it bearable,
    and while one arena fills another is made ready beside the running PLC."""

    def __init__(self) -> None:
        self._arena: memoryview | None = None
        self._used = ARENA
        self._next: Future | None = None

    def keep(self, data: memoryview) -> bytes | memoryview:
        """A copy."""
        if _HUGE is None or len(data) < LARGE or len(data) > ARENA:
            return bytes(data)
        if self._used + len(data) > ARENA:
            self._arena = self._next.result() if self._next else _arena()
            self._next, self._used = None, 0
        part = self._arena[self._used : self._used + len(data)]
        part[:] = data
        self._used += len(data)
        if self._next is None and self._used >= ARENA // 2:
            self._next = _helper().submit(_touched)
        return part


def _arena() -> memoryview:
    memory = mmap.mmap(-1, ARENA, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)  # shared pages are never large
    memory.madvise(_HUGE)
    return memoryview(memory)


def _touched() -> memoryview:
    arena = _arena()
    ctypes.memset(ctypes.addressof(ctypes.c_char.from_buffer(arena)), 0, ARENA)  # others run meanwhile
    return arena


@functools.cache
def _helper() -> Executor:
    from concurrent.futures import ThreadPoolExecutor  # most traces do without

    return ThreadPoolExecutor(1)


@dataclass(slots=True)
class Chunk:
    """Successive rows. before: all words before the first row; values: the words that changed, 16 rows at a time.

    headers: from the end to the beginning, which they are."""

    before: bytes
    headers: bytes | memoryview
    values: bytes | memoryview
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
        rows, words = self._changes.get(number, (np.empty(0, np.uint32), np.empty((0, WORD), np.uint8)))
        held = np.searchsorted(rows, np.arange(self.rows), side="right")  # how often it has changed by then
        return np.concatenate((first[None, :], words))[held]

    def _group(self) -> None:
        import numpy as np

        headers = np.frombuffer(self.headers, np.dtype([("pair", "<u2"), ("rows", "<u2"), ("bits", "<u4")]))[::-1]
        bits = np.ascontiguousarray(headers["bits"]).view(np.uint8).reshape(-1, 4)
        entry, bit = np.nonzero(np.unpackbits(bits, axis=1, bitorder="little"))
        words = headers["pair"][entry] * np.uint32(2) + (bit & 1)
        order = np.argsort(words, kind="stable")
        rows = (headers["rows"][entry] * np.uint32(TOGETHER) + (bit >> 1))[order]
        values = np.frombuffer(self.values, np.uint8).reshape(-1, WORD)[order]
        numbers, starts = np.unique(words[order], return_index=True)
        for number, start, end in zip(numbers.tolist(), starts, np.append(starts[1:], len(order)), strict=False):
            self._changes[number] = (rows[start:end], values[start:end])
        self._grouped = True

    def images(self) -> Iterator[bytearray]:
        """All words as they are in row after row; the same bytearray each time."""
        image = bytearray(self.before)
        headers = reversed(list(HEADER.iter_unpack(self.headers)))
        header, at = next(headers, None), 0
        for first in range(0, self.rows, TOGETHER):
            changes: list[list[tuple[int, int]]] = [[] for _ in range(TOGETHER)]  # (word, where its value is)
            while header is not None and header[1] * TOGETHER == first:
                pair, _, bits = header
                while bits:
                    bit = (bits & -bits).bit_length() - 1
                    changes[bit >> 1].append((2 * pair + (bit & 1), at))
                    bits &= bits - 1
                    at += WORD
                header = next(headers, None)
            for changed in changes[: self.rows - first]:
                for number, k in changed:
                    image[number * WORD : number * WORD + WORD] = self.values[k : k + WORD]
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

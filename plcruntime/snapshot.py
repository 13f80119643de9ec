"""Snapshots, and going back: keyframes of the image plus a journal of what the host wrote in between.

A PLC in virtual time is deterministic: from an image, the same writes at the same scans lead to the same bytes. So
going back restores the last keyframe before the goal and runs forward again, with the writes of the journal instead
of their causes (schedules, Python callbacks, the user).
"""

from __future__ import annotations

import struct
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass

from stcore.program import NOW, NULL_PAGE, SCAN, Program

FRAMES = 64  # keyframes kept at most
FRAME_BYTES = 64 << 20  # and their size together
FRAME_SECONDS = 0.03  # of execution between two keyframes: what a step back costs at most, at first
JOURNAL = 200_000  # writes kept at most


@dataclass(slots=True, eq=False)
class Snapshot:
    """The state of a PLC at a scan boundary: all variables, the clock, what is forced. Opaque; for `PLC.restore`."""

    program: Program
    image: bytes  # from NULL_PAGE to state_end
    scans: int
    now: int
    forces: dict
    fault: Exception | None = None


def take(plc_program: Program, memory, forces: dict, fault: Exception | None = None) -> Snapshot:
    now, scans = struct.unpack_from("<qq", memory, NOW)
    image = bytes(memory[NULL_PAGE : plc_program.state_end])
    return Snapshot(plc_program, image, scans, now, forces, fault)


def put_back(snapshot: Snapshot, memory) -> None:
    """Write image and clock; forces are the caller's business."""
    memory[NULL_PAGE : NULL_PAGE + len(snapshot.image)] = snapshot.image
    struct.pack_into("<qq", memory, NOW, snapshot.now, snapshot.scans)


assert SCAN == NOW + 8  # take and put_back move both words as one


@dataclass(slots=True)
class Frame:
    snapshot: Snapshot
    journal_at: int  # entries of the journal that the image already holds


class History:
    """Keyframes and journal of one PLC. A journal entry is (scan, action), taken before that scan ran."""

    def __init__(self) -> None:
        self.frames: list[Frame] = []
        self.journal: list[tuple[int, Callable[[], None]]] = []
        self._dropped = 0  # entries that were cut off the journal's beginning
        self._last_cost = 0.0
        self._spacing = FRAME_SECONDS

    def clear(self) -> None:
        self.__init__()

    def log(self, scan: int, action: Callable[[], None]) -> None:
        self.journal.append((scan, action))
        if len(self.journal) > JOURNAL:
            self._prune()

    def due(self, cost: float) -> bool:
        """cost: seconds of execution so far. True when enough has passed for another keyframe."""
        if not self.frames or cost - self._last_cost >= self._spacing:
            return True
        return self._dropped + len(self.journal) - self.frames[-1].journal_at > JOURNAL // 8

    def mark(self, snapshot: Snapshot, cost: float) -> None:
        """Keep a keyframe."""
        if self.frames and self.frames[-1].snapshot.scans == snapshot.scans:
            return
        self._last_cost = cost
        self.frames.append(Frame(snapshot, self._dropped + len(self.journal)))
        if len(self.frames) > max(4, min(FRAMES, FRAME_BYTES // max(1, len(snapshot.image)))):
            # thin out the older ones: far back costs more, but the start stays in reach
            self.frames = self.frames[:1] + self.frames[2::2]
            self._spacing *= 2

    def _prune(self) -> None:
        """Forget the older half of the keyframes and the writes before the first that stays."""
        self.frames = self.frames[len(self.frames) // 2 :]
        keep_from = self.frames[0].journal_at if self.frames else self._dropped + len(self.journal)
        del self.journal[: keep_from - self._dropped]
        self._dropped = keep_from

    @property
    def reach(self) -> int | None:
        """The first scan count that one can go back to."""
        return self.frames[0].snapshot.scans if self.frames else None

    def path_from(self, scan: int) -> tuple[Snapshot, list[tuple[int, Callable[[], None]]]]:
        """The keyframe before `scan`, or the first of all, and every action since; forgets nothing."""
        at = max(0, bisect_right([f.snapshot.scans for f in self.frames], scan) - 1)
        frame = self.frames[at]
        return frame.snapshot, self.journal[frame.journal_at - self._dropped :]

    def path_to(self, scan: int) -> tuple[Snapshot, list[tuple[int, Callable[[], None]]]]:
        """The keyframe to start from, and the actions to repeat; forgets what came after `scan`."""
        at = bisect_right([f.snapshot.scans for f in self.frames], scan) - 1
        frame = self.frames[at]
        del self.frames[at + 1 :]
        start = frame.journal_at - self._dropped
        end = start
        while end < len(self.journal) and self.journal[end][0] <= scan:
            end += 1
        del self.journal[end:]
        return frame.snapshot, self.journal[start:]

"""Triggers: what a trace waits for, as on an oscilloscope, and the conditions that the module looks at for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from plcruntime.errors import UsageError
from stcore.program import Program

# Conditions that are linked at the same time keep their constants apart: those of triggers lie behind that of a run.
ROOM_OF_RUN = 16 * 1024
ROOM = 32 * 1024
MOST = 8  # triggers that may wait at the same time


@dataclass(slots=True)
class Trigger:
    """text: an ST condition; it fires at the end of the first scan in which it holds. pre, post: scans to keep.

    module: the condition as the machine knows it, size: bytes of its constants; scan: in which it fired, or None.
    """

    text: str
    pre: int
    post: int
    module: object = None
    size: int = 0
    scan: int | None = None

    @property
    def last(self) -> int:
        """The last scan to keep, once it has fired."""
        return self.scan + self.post

    def window(self, now: int) -> tuple[int, int]:
        """The first scan to keep and the one after the last. now: scans finished."""
        if self.scan is None:
            return max(0, now - self.pre), now
        return max(0, self.scan - self.pre), self.last + 1


def compile_trigger(program: Program, text: str, pre: int, post: int, others: Sequence[Trigger]) -> Trigger:
    """A trigger beside others that are compiled. Raises CompileError for what is no condition, UsageError."""
    from stcore.side import Names, condition

    if len(others) >= MOST:
        raise UsageError(f"{MOST} traces wait for a trigger already; stop one")
    offset = ROOM_OF_RUN + sum(t.size for t in others)
    made = condition(Names(program), text, None, offset)
    if offset + made.size > ROOM:
        raise UsageError(f"the trigger '{text}' needs more memory than there is; put its texts into the program")
    return Trigger(text, pre, post, made.wasm, made.size)

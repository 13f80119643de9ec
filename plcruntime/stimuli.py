"""Stimuli: values that variables get, or are forced to, at times: ``PLC_PRG.xStart=TRUE@10ms``."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable
from dataclasses import dataclass

from plcruntime import durations
from plcruntime.errors import UsageError


@dataclass(slots=True)
class Stimulus:
    """What the user typed, in parts. time: as typed, '' for the start."""

    path: str
    value: str
    time: str
    text: str


def parse(text: str) -> Stimulus:
    """``VAR=VALUE[@TIME]`` in its parts. Raises UsageError."""
    path, equals, rest = text.partition("=")
    path = path.removesuffix(":").strip()
    if not equals or not path or not rest.strip():
        raise UsageError(f"'{text}' is not VAR=VALUE or VAR=VALUE@TIME")
    value, time = rest, ""
    at = _last_at(rest)
    if at >= 0:
        value, time = rest[:at], rest[at + 1 :].strip()
        if not time:
            raise UsageError(f"'{text}': the time after '@' is missing")
        if not value.strip():
            raise UsageError(f"'{text}': the value before '@' is missing")
    return Stimulus(path, value.strip(), time, text)


def _last_at(text: str) -> int:
    """The place of the last '@' outside of quotes, -1 for none."""
    found, quote, i = -1, "", 0
    while i < len(text):
        c = text[i]
        if quote:
            if c == "$":
                i += 1
            elif c == quote:
                quote = ""
        elif c in "'\"":
            quote = c
        elif c == "@":
            found = i
        i += 1
    return found


def scan_of(stimulus: Stimulus, interval: int) -> int:
    """The scan before which the stimulus is applied. Raises UsageError for a bad time."""
    if not stimulus.time:
        return 0
    try:
        return durations.scans(stimulus.time, interval)
    except ValueError as error:
        raise UsageError(f"'{stimulus.text}': {error}") from None


class Schedule:
    """Actions that are due before given scans, in the order in which they were added."""

    def __init__(self) -> None:
        self._entries: list[tuple[int, int, Callable[[], None]]] = []
        self._next = 0

    def add(self, scan: int, action: Callable[[], None], now: int) -> None:
        """now: scans finished; what was due before has been done."""
        entry = (scan, len(self._entries), action)
        at = bisect_right(self._entries, entry[:2], key=lambda e: e[:2])
        self._entries.insert(at, entry)
        self.rewind(now)

    def rewind(self, scan: int) -> None:
        """The next action is the first that is due at `scan` or later."""
        self._next = bisect_left(self._entries, scan, key=lambda e: e[0])

    def run_due(self, scan: int) -> None:
        """Take every action that is due before scan number `scan` runs."""
        while self._next < len(self._entries) and self._entries[self._next][0] <= scan:
            self._next += 1
            self._entries[self._next - 1][2]()

    def scans_until_next(self, scan: int) -> int | None:
        """Scans that may run before the next action, None when there is none."""
        return self._entries[self._next][0] - scan if self._next < len(self._entries) else None

"""Durations as users write them: ``500ms``, ``2.5s``, ``T#1s500ms``, a number of seconds, or ``#120`` scans."""

from __future__ import annotations

import re

Time = str | float | int  # '500ms', 'T#1s', '#120' (scans), or a number of seconds
UNITS = {
    "d": 86_400 * 10**9,
    "h": 3_600 * 10**9,
    "m": 60 * 10**9,
    "min": 60 * 10**9,
    "s": 10**9,
    "ms": 10**6,
    "us": 10**3,
    "ns": 1,
}
_PIECE = re.compile(r"(\d+)(?:\.(\d+))?(min|ms|us|ns|[dhms])", re.IGNORECASE)
_PREFIX = re.compile(r"(?:L?TIME|L?T)#", re.IGNORECASE)


def nanoseconds(text: str | float | int) -> int:
    """The nanoseconds of ``500ms``, ``2.5s``, ``1h30m``, ``T#1s500ms``; a number is seconds. Raises ValueError."""
    if not isinstance(text, str):
        if isinstance(text, bool) or not text >= 0:
            raise ValueError(f"'{text}' is not a duration; write 500ms, 2.5s or T#1s500ms")
        return text * 10**9 if isinstance(text, int) else round(text * 1e9)
    body = _PREFIX.sub("", text.strip().replace("_", ""), count=1).replace(" ", "")
    total = at = 0
    while m := _PIECE.match(body, at):
        unit, decimals = UNITS[m[3].lower()], m[2] or ""
        # whole numbers throughout: 0.1 s is exactly 100 ms
        total += int(m[1] + decimals) * unit // 10 ** len(decimals)
        at = m.end()
    if not body or at < len(body):
        raise ValueError(f"'{text}' is not a duration; write 500ms, 2.5s or T#1s500ms")
    return total


def scans(text: str | float | int, interval: int) -> int:
    """The number of the first scan that starts at or after a time; ``#120`` is scan 120. interval: ns."""
    if isinstance(text, str) and text.strip().startswith("#"):
        number = text.strip()[1:]
        if not number.isdecimal():
            raise ValueError(f"'{text}' is not a scan number; write #120")
        return int(number)
    return -(-nanoseconds(text) // interval)


def text(ns: int) -> str:
    """A duration for reading: 0.25 ms, 2.5 s."""
    if ns and ns < 10**6:
        return f"{ns / 1000:.6g} us"
    return f"{ns / 10**6:.6g} ms" if ns < 10**9 else f"{ns / 10**9:.6g} s"

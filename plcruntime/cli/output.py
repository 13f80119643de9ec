"""What the commands share when they print: tables, diagnostics, progress, JSON."""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Iterable, Sequence
from contextlib import contextmanager

from stcore.diagnostics import Diagnostic, text

_INFINITE = "\x00infinite\x00"


PIPE = 160  # characters in a line of a table, where no terminal says
_GAP = "   "


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """A table on the standard output, its head bold on a terminal. A cell that is too wide goes on in the next line.

    rich, which could do it, takes longer to load than a whole run."""
    rows = [tuple(columns), *map(tuple, rows)]
    widths = [max(_width(row[i]) for row in rows) for i in range(len(columns))]
    room = _room() - 2  # a blank at both sides
    while sum(widths) + len(_GAP) * (len(widths) - 1) > room and max(widths) > 1:
        widths[widths.index(max(widths))] -= 1
    lines = [line for row in rows for line in _lines(row, widths)]
    heads = len(_lines(rows[0], widths))
    if sys.stdout.isatty():
        lines[:heads] = [f"\x1b[1m{line}\x1b[0m" for line in lines[:heads]]
    rule = " " + "─" * (sum(widths) + len(_GAP) * (len(widths) - 1))
    print("\n".join(["", *lines[:heads], rule, *lines[heads:], ""]))


def _room() -> int:
    """The characters in a line: what COLUMNS or the terminal says."""
    named = os.environ.get("COLUMNS", "")
    if named.isdigit() and int(named):
        return int(named)
    try:
        return os.get_terminal_size(sys.stdout.fileno()).columns or PIPE
    except (OSError, ValueError):  # no terminal
        return PIPE


def _lines(row: Sequence[str], widths: list[int]) -> list[str]:
    """The lines of a row."""
    cells = [_folded(cell, width) for cell, width in zip(row, widths, strict=True)]
    lines = []
    for i in range(max(map(len, cells))):
        parts = [cell[i] if i < len(cell) else "" for cell in cells]
        filled = [part + " " * (width - _width(part)) for part, width in zip(parts, widths, strict=True)]
        lines.append(f" {_GAP.join(filled)}".rstrip())
    return lines


def _folded(cell: str, width: int) -> list[str]:
    """A cell in pieces that are no wider, cut at a blank where there is one."""
    pieces = []
    while _width(cell) > width:
        end = _fitting(cell, width)
        blank = cell.rfind(" ", 1, end + 1)
        pieces.append(cell[: blank if blank > 0 else end])
        cell = cell[len(pieces[-1]) :].lstrip(" ")
    return [*pieces, cell]


def _fitting(text: str, width: int) -> int:
    """How many of its characters take no more cells; at least one."""
    taken = 0
    for i, c in enumerate(text):
        taken += _width(c)
        if taken > width:
            return max(i, 1)
    return len(text)


def _width(text: str) -> int:
    """How many cells of a terminal a text takes: two for a Chinese character."""
    if text.isascii():
        return len(text)
    from unicodedata import combining, east_asian_width

    return sum(0 if combining(c) else 2 if east_asian_width(c) in "WF" else 1 for c in text)


def print_diagnostics(diagnostics: Sequence[Diagnostic]) -> None:
    """On the standard error, with source lines; the severity is coloured on a terminal."""
    colours = sys.stderr.isatty()
    for d in diagnostics:
        shown = text(d)
        if colours:
            word = f"{d.severity} {d.code}"
            shown = shown.replace(word, f"\x1b[1;{31 if d.severity == 'error' else 33}m{word}\x1b[0m", 1)
        print(shown, file=sys.stderr)


def summary(diagnostics: Sequence[Diagnostic]) -> str:
    """'2 errors, 1 warning', or 'no errors'."""
    parts = []
    for severity in ("error", "warning"):
        count = sum(d.severity == severity for d in diagnostics)
        if count:
            parts.append(f"{count} {severity}{'s' if count > 1 else ''}")
    return ", ".join(parts) or "no errors"


def to_json(data) -> str:
    """JSON for every number: infinity is 1e999, which every reader takes for infinity; what is no number is null."""
    return json.dumps(_finite(data), ensure_ascii=False, indent=1).replace(
        json.dumps(_INFINITE), "1e999"
    ).replace(json.dumps("-" + _INFINITE), "-1e999")  # fmt: skip


def _finite(data):
    if isinstance(data, float):
        if data != data:
            return None
        return data if data - data == 0 else _INFINITE if data > 0 else "-" + _INFINITE
    if isinstance(data, dict):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, list):
        return [_finite(value) for value in data]
    return data


@contextmanager
def working(text: str):
    """Say what is going on when it lasts longer than a second, on a terminal only."""
    if not sys.stderr.isatty():
        yield
        return
    timer = threading.Timer(1.0, lambda: print(f"{text} ...", end="", file=sys.stderr, flush=True))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        timer.join()
        print("\r\x1b[K", end="", file=sys.stderr, flush=True)


class Progress:
    """A line on the standard error for what takes longer than a second, on a terminal only."""

    def __init__(self, interval_s: float) -> None:
        self.interval_s = interval_s
        self._began = time.monotonic()
        self._shown = 0.0
        self._active = sys.stderr.isatty()

    def __call__(self, done: int, goal: int) -> None:
        now = time.monotonic()
        if not self._active or now - self._began < 1 or now - self._shown < 0.2:
            return
        self._shown = now
        part, spent = done / goal, now - self._began
        left = spent / part - spent if part else 0
        bar = "=" * int(24 * part)
        text = f"[{bar:<24}] {100 * part:3.0f} %  {done * self.interval_s:.3f} s of virtual time, {left:.0f} s to go"
        print(f"\r{text}\x1b[K", end="", file=sys.stderr, flush=True)

    def end(self) -> None:
        """Take the line away."""
        if self._shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)

"""What the commands share when they print: tables, diagnostics, progress, JSON."""

from __future__ import annotations

import json
import os
import shutil
import sys
import threading
import time
from collections.abc import Iterable, Sequence
from contextlib import contextmanager

from stcore.diagnostics import Diagnostic, text

WORTH_TELLING = 7 * 86400  # s that a run may still take; longer ones are meant to be stopped
_INFINITE = "\x00infinite\x00"


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """A table on the standard output, coloured on a terminal only."""
    from rich import box
    from rich.cells import cell_len
    from rich.table import Table
    from rich.text import Text

    screen = console(sys.stdout)
    rows = [tuple(row) for row in rows]
    widths = [max(map(cell_len, column)) for column in zip(columns, *rows, strict=True)]
    folds = sum(widths) + 3 * len(widths) > screen.width or any("\n" in cell for row in rows for cell in row)
    if rows and not folds:
        # as one tall row, which is drawn five times as fast: a program may have thousands of variables
        rows = [tuple("\n".join(column) for column in zip(*rows, strict=True))]
    table = Table(*columns, box=box.SIMPLE_HEAD, pad_edge=False)
    for column in table.columns:
        column.overflow = "fold"
    for row in rows:
        table.add_row(*map(Text, row))
    screen.print(table)


def console(stream):
    """A rich console that leaves our text as it is. Lines for a file or a pipe are not broken at 80 characters."""
    from rich.console import Console

    made = Console(file=stream, highlight=False, soft_wrap=False)
    if not made.is_terminal and "COLUMNS" not in os.environ:
        made.width = 160
    return made


def coloured(stream) -> bool:
    """Whether text for this stream may be in colours (no-color.org)."""
    return stream.isatty() and not os.environ.get("NO_COLOR")


def print_diagnostics(diagnostics: Sequence[Diagnostic]) -> None:
    """On the standard error, with source lines; the severity is coloured on a terminal."""
    colours = coloured(sys.stderr)
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
        bar = "=" * int(20 * part)
        text = f"{done * self.interval_s:.3f} s of virtual time"
        if left < WORTH_TELLING:
            text = f"[{bar:<20}] {100 * part:3.0f} %  {text}, {left:.0f} s to go"
        room = shutil.get_terminal_size().columns - 1  # a line that goes on in the next one can't be drawn again
        print(f"\r{text[:room]}\x1b[K", end="", file=sys.stderr, flush=True)

    def end(self) -> None:
        """Take the line away."""
        if self._shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)

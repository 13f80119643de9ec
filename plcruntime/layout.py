"""Text in a terminal: what is longer than a line is broken between words, tables within their columns.

rich would take longer to load than an answer may. Nothing is broken for a pipe or a file.
"""

from __future__ import annotations

import re
import shutil
import sys
import textwrap

INDENT = "  "
NARROW = 6  # characters that a column of words keeps at least
_PART = re.compile(r"\s+|[^\s._]*[._]+|[^\s._]+")  # of a cell, that is not broken


def width() -> int | None:
    """Characters in a line of the terminal; None for a pipe or a file."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def broken(text: str, room: int | None, indent: str = INDENT) -> list[str]:
    """The lines of a text; indent: of those that go on."""
    lines = text.split("\n")
    if room is None:
        return lines
    return [part for line in lines for part in (_wrap(line, room, indent) if len(line) > room else [line])]


def _wrap(line: str, room: int, indent: str) -> list[str]:
    return textwrap.wrap(
        line, room, subsequent_indent=indent, replace_whitespace=False, break_on_hyphens=False, expand_tabs=False
    ) or [""]  # fmt: skip


def _fold(cell: str, room: int) -> list[str]:
    """The lines of a cell: broken between words, behind the dots and underscores of a name, else anywhere."""
    lines = [""]
    for part in _PART.findall(cell):
        while len(lines[-1]) + len(part.rstrip()) > room:
            if lines[-1].strip():
                lines.append("")
            else:
                lines[-1], part = part[:room], part[room:]
                lines.append("")
        lines[-1] += part if lines[-1] or len(lines) == 1 else part.lstrip()
    return [line.rstrip() for line in lines]


def table(heads: tuple[str, ...], rows: list[tuple[str, ...]], room: int | None) -> list[str]:
    """Aligned columns, numbers to the right; where they are wider than the terminal, words fold in their column."""
    numeric = [all(_is_number(row[i]) for row in rows) for i in range(len(heads))]
    widths = [max(len(str(row[i])) for row in (heads, *rows)) for i in range(len(heads))]
    if room is not None:
        columns = list(zip(heads, *rows, strict=True))
        parts = [max(len(p) for cell in column for p in _PART.findall(cell) or [""]) for column in columns]
        least = [w if n else p for w, n, p in zip(widths, numeric, parts, strict=True)]
        widths = _fitted(widths, least, numeric, room - len(INDENT) * len(heads))
    lines = []
    for row in (heads, *rows):
        cells = [_fold(cell, w) if len(cell) > w else [cell] for cell, w in zip(row, widths, strict=True)]
        for k in range(max(map(len, cells))):
            parts = [c[k] if k < len(c) else "" for c in cells]
            aligned = [p.rjust(w) if n else p.ljust(w) for p, w, n in zip(parts, widths, numeric, strict=True)]
            lines.append((INDENT + "  ".join(aligned)).rstrip())
    return lines


def _fitted(widths: list[int], least: list[int], numeric: list[bool], room: int) -> list[int]:
    """Narrower columns of words, the widest first, until all fit; none below its longest part if that can be."""
    widths = list(widths)
    while sum(widths) > room:
        free = [i for i, w in enumerate(widths) if w > least[i]]
        if free:
            widths[max(free, key=lambda i: widths[i])] -= 1
            continue
        words = [i for i, w in enumerate(widths) if not numeric[i] and w > NARROW]
        if not words:
            break
        least[max(words, key=lambda i: widths[i])] -= 1
    return widths


def _is_number(text: str) -> bool:
    """Also with a unit behind it."""
    try:
        float((text.split() or [""])[0])
    except ValueError:
        return False
    return True

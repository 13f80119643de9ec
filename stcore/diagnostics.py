"""Diagnostics: what the compiler has to say about a source, each with code, place, message and hint."""

from __future__ import annotations

import json
import unicodedata
from dataclasses import asdict, dataclass

from stcore.codes import CODES
from stcore.source import Source

_CONTROLS = {c: "\N{REPLACEMENT CHARACTER}" for c in (*range(9), *range(10, 32), 127)}  # a terminal would obey them


@dataclass(slots=True)
class Diagnostic:
    """line and column count from 1, column in characters; end_column is exclusive, on the same line."""

    code: str
    severity: str  # error, warning
    message: str
    file: str
    line: int
    column: int
    end_column: int
    hint: str = ""
    source_line: str = ""


class CompileError(Exception):
    """The source has errors. ``diagnostics``: all of them, warnings too, in the order of the source."""

    def __init__(self, diagnostics: list[Diagnostic]) -> None:
        self.diagnostics = diagnostics
        super().__init__("\n".join(text(d) for d in diagnostics if d.severity == "error"))


class Reporter:
    """Collects the diagnostics of one compilation, at most one error for one place.

    strict: each mend of a printed listing (codes W01..) is an error.
    """

    def __init__(self, strict: bool = False) -> None:
        self.strict = strict
        self.diagnostics: list[Diagnostic] = []
        self._error_places: set[tuple[str, int]] = set()

    @property
    def failed(self) -> bool:
        return any(d.severity == "error" for d in self.diagnostics)

    def add(self, code: str, source: Source, start: int, end: int | None = None, /, hint: str = "", **fields) -> None:
        """Report `code` (stcore.codes) at the offsets start..end of source; fields fill the message."""
        entry = CODES[code]
        severity = "error" if code[0] == "E" or self.strict and code.startswith("W01") else "warning"
        line, column = source.position(start)
        if severity == "error" and (source.path, start) in self._error_places:
            return
        if severity == "error":
            self._error_places.add((source.path, start))
        width = max(1, (end or start + 1) - start)
        source_line = source.line(line)
        end_column = min(column + width, max(len(source_line) + 1, column + 1))
        message = entry.message.format(**fields)
        hint = hint or entry.hint.format(**fields)
        self.diagnostics.append(
            Diagnostic(code, severity, message, source.path, line, column, end_column, hint, source_line)
        )

    def sorted(self) -> list[Diagnostic]:
        """The diagnostics, by file in order of first appearance, then by place."""
        order = {d.file: i for i, d in reversed(list(enumerate(self.diagnostics)))}
        return sorted(self.diagnostics, key=lambda d: (order[d.file], d.line, d.column))


def _columns(c: str) -> int:
    """How wide a terminal shows a character: a Chinese one takes two columns."""
    return 1 if c.isascii() else 2 if unicodedata.east_asian_width(c) in "WF" else 1


def text(d: Diagnostic) -> str:
    """For reading: place, code, message, the source line with a caret, the hint."""
    place = f"{d.file}:{d.line}:{d.column}: {d.severity} {d.code}: {d.message}"
    line = d.source_line.translate(_CONTROLS)
    before, marked = line[: d.column - 1], line[d.column - 1 : d.end_column - 1]
    # keep tabs in front of the caret, so that it stands under its character in any terminal
    pad = "".join(c if c == "\t" else " " * _columns(c) for c in before)
    marks = "^" * max(1, sum(map(_columns, marked)), d.end_column - d.column)
    shown = [f"{d.line:5} | {line}", " " * 5 + " | " + pad + marks] if line else []
    lines = [place, *shown]
    if d.hint:
        lines.append(f"      = hint: {d.hint}")
    return "\n".join(lines)


def gcc(d: Diagnostic) -> str:
    """One line, as gcc prints it: editors and CI annotate from it."""
    return f"{d.file}:{d.line}:{d.column}: {d.severity}: {d.message} [{d.code}]"


def as_json(diagnostics: list[Diagnostic]) -> str:
    return json.dumps({"diagnostics": [asdict(d) for d in diagnostics]}, ensure_ascii=False, indent=1)

"""Golden traces: a recorded run in a CSV file, and what differs from it."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from plcruntime.errors import UsageError

if TYPE_CHECKING:
    from plcruntime.trace import Trace

SHOWN = 5  # rows around the first difference of a column


class GoldenMismatch(AssertionError):
    """A trace is not what was recorded; its text shows where."""


@dataclass(slots=True)
class Difference:
    """Of one column: the first row that differs, how many do, the largest deviation (numbers)."""

    name: str
    first: int
    count: int
    largest: float
    tolerance: float


def compare(
    trace: Trace, path: str | Path, tolerance: float = 0.0, tolerances: Mapping[str, float] | None = None
) -> None:
    """Compare with the file that `Trace.to_csv` wrote. tolerance: absolute, for all columns; tolerances: by path.

    Raises GoldenMismatch, UsageError for a missing or damaged file, a tolerance for an unknown column.
    """
    __tracebackhide__ = True
    heads, rows = _read(Path(path))
    limits = {name.upper(): value for name, value in (tolerances or {}).items()}
    unknown = [name for name in limits if name not in {h.upper() for h in heads}]
    if unknown:
        raise UsageError(f"a tolerance is given for {unknown[0]}, which {path} does not have")
    problems = list(_columns(trace, heads, path))
    now = [[_number(v) for v in row] for row in trace.rows()]
    if len(now) != len(rows):
        problems.append(f"{len(now)} scans, recorded were {len(rows)}")
    names = [n for n in trace.names if n in heads]
    for name in names:
        mine, theirs = trace.names.index(name) + 1, heads.index(name)
        found = _differences(name, now, rows, mine, theirs, limits.get(name.upper(), tolerance))
        if found is not None:
            problems.append(_told(found, now, rows, mine, theirs))
    if problems:
        raise GoldenMismatch(f"the trace is not what {path} holds:\n" + "\n".join(problems))


def _read(path: Path) -> tuple[list[str], list[list]]:
    try:
        with open(path, newline="", encoding="utf-8") as file:
            heads, *rows = csv.reader(file)
    except OSError as error:
        raise UsageError(f"no golden trace {path}: {error.strerror}; pytest --plc-record writes it") from None
    except ValueError:
        raise UsageError(f"{path} is no recorded trace: it is empty") from None
    if heads[:1] != ["time"] or any(len(row) != len(heads) for row in rows):
        raise UsageError(f"{path} is no recorded trace: its rows do not fit its first line")
    return heads, [[_number(v) for v in row] for row in rows]


def _columns(trace: Trace, heads: list[str], path) -> Iterator[str]:
    missing = [n for n in heads[1:] if n not in trace.names]
    extra = [n for n in trace.names if n not in heads]
    if missing:
        yield f"not traced now: {', '.join(missing)}"
    if extra:
        yield f"not in {path}: {', '.join(extra)}"


def _number(value):
    """Numbers and BOOLs as float, texts as they are."""
    try:
        return float(value)
    except ValueError:
        return value


def _differences(name: str, now, rows, mine: int, theirs: int, tolerance: float) -> Difference | None:
    first, count, largest = -1, 0, 0.0
    for i, (a, b) in enumerate(zip(now, rows, strict=False)):
        x, y = a[mine], b[theirs]
        if x == y or x != x and y != y:
            continue
        deviation = abs(x - y) if isinstance(x, float) and isinstance(y, float) else float("inf")
        if deviation <= tolerance:
            continue
        first = i if first < 0 else first
        count += 1
        largest = max(largest, deviation)
    return Difference(name, first, count, largest, tolerance) if count else None


def _told(found: Difference, now, rows, mine: int, theirs: int) -> str:
    allowed = f", allowed {found.tolerance:g}" if found.tolerance else ""
    lines = [f"{found.name}: {found.count} scans differ, by {found.largest:g} at most{allowed}"]
    begin = max(0, found.first - 1)
    lines.append(f"  {'time':>12}  {'recorded':>16}  {'now':>16}")
    for i in range(begin, min(begin + SHOWN, len(now), len(rows))):
        a, b = now[i][mine], rows[i][theirs]
        mark = "  <" if a != b and not (isinstance(a, float) and abs(a - b) <= found.tolerance) else ""
        lines.append(f"  {now[i][0]:10.6g} s  {_text(b):>16}  {_text(a):>16}{mark}")
    return "\n".join(lines)


def _text(value) -> str:
    return f"{value:.12g}" if isinstance(value, float) else str(value)

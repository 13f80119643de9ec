"""Stimulus files: which variable gets which value, or is forced to it, at which time. CSV and TOML.

CSV has a header with the columns time, variable, value and, if wanted, force; separated by commas or semicolons:

    time,variable,value,force
    10ms,PLC_PRG.start,TRUE,
    1.5s,Axis[1].drive.alarm,TRUE,force
    2s,Axis[1].drive.alarm,,release

TOML has tables [[stimulus]] with the same keys; `force = true`, `release = true`. A time is 500ms, T#1s500ms, a number
of seconds or #120 (a scan); a value is written as in ST.
"""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from plcruntime import durations
from plcruntime.errors import UsageError
from stcore.paths import PathError, Place

if TYPE_CHECKING:
    from plcruntime.plc import PLC

COLUMNS = ("time", "variable", "value", "force")
WRITE = ("", "0", "no", "false")
FORCE = ("1", "yes", "true", "force")
RELEASE = "release"


@dataclass(slots=True)
class Entry:
    """One line of a file. where: file and line; how: 'write', 'force' or 'release'; value: as ST writes it."""

    where: str
    time: str
    variable: str
    value: str
    how: str


def read(path: str | Path) -> list[Entry]:
    """The entries of a .csv or .toml file. Raises UsageError, naming file and line."""
    path = Path(path)
    readers = {".csv": _read_csv, ".toml": _read_toml}
    if path.suffix.lower() not in readers:
        raise UsageError(f"{path}: the name of a stimulus file ends with .csv or .toml")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise UsageError(f"can't read {path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise UsageError(f"{path} is not UTF-8") from None
    return readers[path.suffix.lower()](path, text)


def _read_csv(path: Path, text: str) -> list[Entry]:
    lines = text.splitlines()
    kept = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and not _is_comment(line)]
    if not kept:
        raise UsageError(f"{path}: no header; the first line is time,variable,value,force")
    mark = ";" if ";" in kept[0][1] else ","
    header = [c.strip().lower() for c in kept[0][1].split(mark)]
    missing = [c for c in COLUMNS[:3] if c not in header]
    unknown = [c for c in header if c not in COLUMNS]
    if missing or unknown:
        problem = f"no column {missing[0]}" if missing else f"unknown column '{unknown[0]}'"
        raise UsageError(f"{path}:{kept[0][0]}: {problem}; the first line is time,variable,value,force")
    entries = []
    for number, line in kept[1:]:
        where = f"{path}:{number}"
        cells = next(csv.reader(io.StringIO(line), delimiter=mark, skipinitialspace=True))
        if len(cells) > len(header):
            raise UsageError(f"{where}: {len(cells)} columns, not {len(header)}; a value with commas stands in quotes")
        row = dict(zip(header, (c.strip() for c in cells), strict=False))
        word = row.get("force", "").lower()
        if word not in (*WRITE, *FORCE, RELEASE):
            raise UsageError(f"{where}: force is '{row['force']}'; it may be empty, force or release")
        how = "release" if word == RELEASE else "force" if word in FORCE else "write"
        entries.append(_entry(where, row.get("time", ""), row.get("variable", ""), row.get("value", ""), how))
    return entries


def _is_comment(line: str) -> bool:
    """A line that begins with #, unless that is the number of a scan."""
    line = line.lstrip()
    return line.startswith("#") and not line[1:2].isdigit()


def _read_toml(path: Path, text: str) -> list[Entry]:
    import tomllib

    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"{path} is not TOML: {error}") from None
    tables = data.pop("stimulus", None)
    if data or not isinstance(tables, list) or not all(isinstance(t, dict) for t in tables):
        raise UsageError(f"{path}: a stimulus file has tables [[stimulus]] with time, variable, value, no more")
    entries = []
    for number, table in enumerate(tables, 1):
        where = f"{path}: stimulus {number}"
        unknown = [k for k in table if k not in (*COLUMNS, RELEASE)]
        if unknown:
            raise UsageError(f"{where}: unknown key {unknown[0]}; known: {', '.join((*COLUMNS, RELEASE))}")
        for key in ("force", RELEASE):
            if not isinstance(table.get(key, False), bool):
                raise UsageError(f"{where}: {key} is true or false")
        how = "release" if table.get(RELEASE) else "force" if table.get("force") else "write"
        value = table.get("value", "")
        if isinstance(value, bool):
            value = str(value).upper()
        entries.append(_entry(where, str(table.get("time", "")), str(table.get("variable", "")), str(value), how))
    return entries


def _entry(where: str, time: str, variable: str, value: str, how: str) -> Entry:
    for name, cell in (("time", time), ("variable", variable)):
        if not cell:
            raise UsageError(f"{where}: the {name} is missing")
    if how != "release" and not value:
        raise UsageError(f"{where}: the value of {variable} is missing")
    if how == "release" and value:
        raise UsageError(f"{where}: a variable is released without a value")
    return Entry(where, time, variable, value, how)


def schedule(plc: PLC, path: str | Path, program: str = "") -> int:
    """Schedule a file's entries; how many there are. All are checked before the first is scheduled.

    program: names that it has are its own, before those that are unique among all.
    Raises UsageError for the first that can't be: then nothing is scheduled.
    """
    checked = []
    for entry in read(path):
        try:
            scan = _scan(entry.time, round(plc.interval * 1e9))
            place = _place(plc, entry.variable, program)
            value = None if entry.how == "release" else plc.parse_value(place.name, entry.value)
            if entry.how != "release":
                plc.check_value(place.name, value)
        except (PathError, TypeError, ValueError) as error:
            raise UsageError(f"{entry.where}: {error}") from None
        checked.append((scan, place.name, value, entry.how))
    for scan, name, value, how in checked:
        if how == "release":
            plc.schedule_release(name, f"#{scan}")
        else:
            plc.schedule(name, value, f"#{scan}", force=how == "force")
    return len(checked)


def _place(plc: PLC, name: str, program: str) -> Place:
    try:
        return plc.place(f"{program}.{name}" if program else name)
    except PathError:
        return plc.place(name)


def _scan(time: str, interval: int) -> int:
    try:
        seconds = float(time)
    except ValueError:
        return durations.scans(time, interval)
    return durations.scans(seconds, interval)

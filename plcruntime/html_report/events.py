"""The events of a run: stimuli, commands that returned errors, blocks in error, warnings, axes in errorstop, faults."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from plcruntime import report
from plcruntime.picture import axis_label
from stcore.types import Enum

if TYPE_CHECKING:
    from plcruntime.html_report.recording import Recording

MOST = 2000  # events shown


@dataclass(slots=True)
class Event:
    """kind: 'stimulus', 'command', 'block', 'warning', 'axis' or 'fault'. time: s. lines: (number of the file, line) to
    mark."""

    time: float
    kind: str
    text: str
    lines: list[tuple[int, int]] = field(default_factory=list)


def collect(recording: Recording, sources: list[tuple[str, str]]) -> list[Event]:
    """In the order of time; sources: (path, text) of the program's files."""
    files = [path for path, _ in sources]
    found = [*_stimuli(recording), *_commands(recording, files), *_blocks(recording), *_axes(recording)]
    found += _warnings(recording, files)
    found += _fault(recording, files)
    found.sort(key=lambda e: e[0].time)
    for event, words in found:
        event.lines = event.lines or _mentions(sources, words)
    events = [event for event, _ in found]
    if len(events) > MOST:
        left = len(events) - MOST
        events = [*events[:MOST], Event(events[MOST].time, "stimulus", f"{left} more events are not shown")]
    return events


def _stimuli(recording: Recording):
    plc = recording.plc
    for scan, text in plc.scheduled:
        if scan < plc.scans:
            yield Event(scan * plc.interval, "stimulus", text), ""


def _commands(recording: Recording, files: list[str]):
    interval = recording.plc.interval
    returns = recording.returns
    for entry in returns.entries:
        call = entry.call
        lines = [(files.index(call.file), call.line)] if call.file in files else []
        yield Event(entry.scan * interval, "command", entry.words(interval), lines), call.command
    if returns.lost:
        yield Event(recording.plc.time, "command", f"{returns.lost} more commands returned errors, not noted"), ""


def _blocks(recording: Recording):
    trace = recording.trace
    if not len(trace):
        return
    known = set(trace.names)
    time = trace.time
    for name in recording.error_names:
        if not name.upper().endswith(".ERROR"):
            continue
        column = trace[name]
        instance = name.rsplit(".", 1)[0]
        number = next((n for n in known if n.upper() == name.upper() + "ID"), None)
        place = recording.plc.place(instance)
        for k in _rises(column):
            what = f": {_label(recording, number, trace[number][k])}" if number else ""
            text = f"{instance} ({place.type.name}) reports an error{what}"
            yield Event(float(time[k]), "block", text), instance.rsplit(".", 1)[-1].split("[")[0]


def _label(recording: Recording, name: str, value) -> str:
    kind = recording.plc.place(name).type
    label = kind.label(int(value)) if isinstance(kind, Enum) else None
    return f"{label} ({value})" if label else str(value)


def _axes(recording: Recording):
    trace = recording.trace
    if not len(trace):
        return
    known, time = set(trace.names), trace.time
    for name in recording.state_names:
        if name in known:
            axis = axis_label(recording.plc, int(re.search(r"[0-9]+", name)[0]))
            labels = recording.plc.place(name).type.values
            stop = next((v for n, v in labels.items() if n.upper() == "ERRORSTOP"), None)
            for k in _rises(trace[name] == stop):
                yield Event(float(time[k]), "axis", f"{axis} goes to errorstop"), ""
        alarm = name.replace(".state", ".drive.alarm")
        if alarm in known:
            for k in _rises(trace[alarm]):
                yield Event(float(time[k]), "axis", f"{axis}: the drive reports an alarm"), ""


def _rises(column) -> list[int]:
    """The rows at which a column of BOOL becomes TRUE."""
    import numpy as np

    column = np.asarray(column, bool)
    return (np.flatnonzero(column[1:] & ~column[:-1]) + 1).tolist() + ([0] if len(column) and column[0] else [])


def _warnings(recording: Recording, files: list[str]):
    for w in recording.plc.warnings:
        lines = [(files.index(w.file), w.line)] if w.file in files else []
        yield Event(w.time, "warning", f"{w.code}: {w.message}: {w.hint}", lines), ""


def _fault(recording: Recording, files: list[str]):
    plc = recording.plc
    if plc.fault:
        event = Event(plc.time, "fault", report.fault_text(plc.fault, plc.time).split("\n")[0])
        if plc.fault.file in files:
            event.lines = [(files.index(plc.fault.file), plc.fault.line)]
        yield event, ""


def _mentions(sources: list[tuple[str, str]], word: str) -> list[tuple[int, int]]:
    """The lines that call something of a name."""
    if not word:
        return []
    pattern = re.compile(rf"(?<![\w.]){re.escape(word)}\s*(?:\[[^\]]*\]\s*)?\(", re.IGNORECASE)
    return [
        (number, line)
        for number, (_, text) in enumerate(sources)
        for line, content in enumerate(text.splitlines(), 1)
        if pattern.search(content)
    ]


def sources_of(plc) -> list[tuple[str, str]]:
    """(path, text) of the user's files; of a program that was given as a text, that text."""
    from stcore.source import read

    files = [f for f in plc.program.files if Path(f).is_file() and not _of_library(plc, Path(f))]
    found = [(f, read(f).text) for f in files]
    if not found and plc.origin and isinstance(plc.origin["source"], str) and "\n" in plc.origin["source"]:
        found = [("<text>", plc.origin["source"])]
    return found


def _of_library(plc, file: Path) -> bool:
    from stcore.compiler import LIBRARY

    folders = [LIBRARY, *map(Path, plc.program.libraries)]
    return any(file.resolve().is_relative_to(folder.resolve()) for folder in folders)

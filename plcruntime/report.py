"""Faults and stops as text and as JSON."""

from __future__ import annotations

from pathlib import Path

from stcore.source import read


def fault_text(fault, time: float | None = None) -> str:
    """For reading: place, code, message, the source line with a caret, instance, scan and time, hint."""
    place = f"{fault.file}:{fault.line}:{fault.column}: " if fault.file else ""
    lines = [f"{place}fault {fault.code}: {fault.message}"]
    source_line = line_of(fault.file, fault.line)
    if source_line is not None:
        # keep tabs in front of the caret, so that it stands under its character in any terminal
        pad = "".join(c if c == "\t" else " " for c in source_line[: max(0, fault.column - 1)])
        lines += [f"{fault.line:5} | {source_line}", f"      | {pad}^"]
    when = f"in scan {fault.scan}" + (f", at {time:.9g} s" if time is not None else "")
    lines.append(f"      = {'in ' + fault.instance + ', ' if fault.instance else ''}{when}")
    if fault.hint:
        lines.append(f"      = hint: {fault.hint}")
    return "\n".join(lines)


def fault_json(fault, time: float | None = None) -> dict:
    """The `fault` object of `run --json`."""
    keys = ("code", "message", "file", "line", "column", "instance", "scan", "hint")
    return {**{key: getattr(fault, key) for key in keys}, "time": time}


def line_of(file: str, number: int) -> str | None:
    """The line of the source, None where there is none to show: a text without file, a line past the end."""
    if not file or number < 1 or not Path(file).is_file():
        return None
    source = read(file)
    return source.line(number) if number <= len(source.starts) else None

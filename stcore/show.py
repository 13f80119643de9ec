"""Values as ST writes them: T#1.5s, D#2024-01-31, 'text', a label, [..], (a := 1)."""

from __future__ import annotations

import math

from stcore.types import Array, Elementary, Enum, Pointer, String, Type, base_of

_ESCAPES = {"\n": "$N", "\r": "$R", "\t": "$T", "\f": "$P"}


def show(t: Type, value) -> str:
    """A decoded value as ST writes it: TRUE, T#1.5s, D#2024-01-31, 'text', labels of an ENUM, [..], (a := 1)."""
    if isinstance(t, Enum):
        return t.label(value) or str(value)
    base = base_of(t)
    if isinstance(base, Elementary):
        if base.kind == "bool":
            return "TRUE" if value else "FALSE"
        if base.kind == "real":
            return f"{value:.7g}" if base.size == 4 else repr(value)
        if base.kind == "time":
            return f"T#{value:.12g}s"
        return _moment(base.name, value) if base.kind == "date" else repr(value) if base.kind == "char" else str(value)
    if isinstance(t, String):
        quote = '"' if t.wide else "'"
        return quote + "".join(_escaped(c, quote) for c in value) + quote
    if isinstance(t, Pointer):
        return f"16#{value:08X}"
    if isinstance(t, Array):
        element = Array(t.element, t.bounds[1:]) if len(t.bounds) > 1 else t.element
        return "[" + ", ".join(show(element, v) for v in value) + "]"
    members = {f.name: f.type for f in t.members.values()}
    return "(" + ", ".join(f"{name} := {show(members[name], v)}" for name, v in value.items()) + ")"


def _moment(name: str, seconds: float) -> str:
    """D#2024-01-31, TOD#12:34:56.789, DT#2024-01-31-12:34:56; of a long type LD#, LTOD#, LDT#."""
    from datetime import datetime, timedelta

    whole = math.floor(seconds)
    digits = {"LTOD": 9, "LDT": 6}.get(name, 3)  # a moment in seconds has no more
    fraction = f"{seconds - whole:.{digits}f}"[1:].rstrip("0").rstrip(".")
    moment = datetime(1970, 1, 1) + timedelta(seconds=whole)
    date, clock = f"{moment:%Y-%m-%d}", f"{moment:%H:%M:%S}{fraction}"
    kind = name.removeprefix("L")
    text = {"DATE": date, "TOD": clock, "DT": f"{date}-{clock}"}[kind]
    return f"{name.replace('DATE', 'D')}#{text}"


def _escaped(character: str, quote: str) -> str:
    """A character of a text as ST writes it; what is no character to look at would garble a terminal."""
    if character in ("$", quote):
        return "$" + character
    if character.isprintable():
        return character
    return _ESCAPES.get(character) or "".join(f"${byte:02X}" for byte in character.encode("utf-8", "replace"))

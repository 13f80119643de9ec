"""Values of a retain file for a program that was changed since: found by name, taken where the type can hold them.

A value is never read as something else: a number goes into another type of numbers when that can hold exactly this
value, an ENUM's value by its label, a text where it is short enough. What can't be taken is an error that names all.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from plcruntime import kept as survivors
from plcruntime.errors import UsageError
from plcruntime.kept import Kept
from stcore.types import ELEMENTARY, Array, Elementary, Enum, Pointer, String, SubrangeType, Type, base_of
from stcore.values import FORMATS, PER_SECOND

if TYPE_CHECKING:
    from plcruntime.retain import Stored

NAMED = 6  # variables that a sentence names before it says how many more there are
_FAMILIES = ({"DATE", "LDATE"}, {"DT", "LDT"}, {"TOD", "LTOD"}, {"TIME", "LTIME"})


@dataclass(slots=True)
class Report:
    """What became of stored values. kept: how many were taken; converted: (path, old type, new type).

    new: variables that the file does not have; lost: those of the file that the program does not have.
    """

    kept: int = 0
    new: list[str] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)
    converted: list[tuple[str, str, str]] = field(default_factory=list)

    def sentences(self) -> list[str]:
        """For reading; nothing when all is as it was."""
        converted = [f"{path} ({old} to {new})" for path, old, new in self.converted]
        parts = (
            ("not in the program any more, so dropped: ", self.lost),
            ("not in the file, so at its initial value: ", self.new),
            ("converted: ", converted),
        )
        return [text + _names(names) for text, names in parts if names]


class _Misfit(Exception):
    """Why a stored value can't become a variable's."""


def migrate(stored: Stored, leaves: list[Kept], path: Path) -> tuple[list[tuple[Kept, bytes]], Report]:
    """What to write where, and what was done. Raises UsageError, naming every value that can't be taken."""
    old = _elements(stored)
    values: list[tuple[Kept, bytes]] = []
    problems: list[str] = []
    report = Report()
    for leaf in leaves:
        for target in _targets(leaf):
            entry = old.pop(target.path.upper(), None)
            if isinstance(target.type, Pointer):  # an address means nothing to another build
                continue
            if entry is None:
                report.new.append(target.path)
                continue
            try:
                values.append((target, _converted(entry, stored.enums, target.type)))
            except _Misfit as misfit:
                problems.append(f"{target.path} was {entry.type} and is {_shown(target.type)}{misfit}")
                continue
            if entry.type != _shown(target.type):
                report.converted.append((target.path, entry.type, _shown(target.type)))
    report.kept = len(values)
    report.lost = [entry.path for entry in old.values() if entry.type != "POINTER"]
    again = "The file stays as it is; name another, or delete it to start anew"
    if problems:
        raise UsageError(f"the retain file {path} does not fit the program: {_names(problems, '; ')}. {again}")
    if not values and report.lost:
        none = f"none of its variables ({_names(report.lost)}) is in this one"
        raise UsageError(f"the retain file {path} is of another program: {none}. {again}")
    return values, report


def _names(names: list[str], joint: str = ", ") -> str:
    more = len(names) - NAMED
    return joint.join(names[:NAMED]) + (f"{joint}and {more} more" if more > 0 else "")


@dataclass(slots=True)
class _Entry:
    """A single stored value. type: as retain.type_text has it, without ENUM."""

    path: str
    type: str
    data: bytes


def _elements(stored: Stored) -> dict[str, _Entry]:
    """Every single value of a file by its upper-case path."""
    found = {}
    for (path, kind, size, bounds, _), data in zip(stored.entries, stored.values, strict=True):
        kind = kind.removeprefix("ENUM ")
        paths = [(path, 0)]
        if bounds:
            array = Array(_Sized(kind, size), [tuple(b) for b in bounds])
            paths = [(f"{path}[{index}]", offset) for index, offset in survivors.elements(array)]
        for name, offset in paths:
            found[name.upper()] = _Entry(name, kind, data[offset : offset + size])
    return found


@dataclass(slots=True)
class _Sized(Type):
    """A type of which only name and size are known."""

    name: str
    size: int
    align: int = 1


def _targets(leaf: Kept) -> Iterator[Kept]:
    """The single values of a leaf of the program."""
    if not isinstance(leaf.type, Array):
        yield leaf
        return
    for index, offset in survivors.elements(leaf.type):
        yield Kept(f"{leaf.path}[{index}]", leaf.type.element, leaf.address + offset, leaf.persistent)


def _shown(t: Type) -> str:
    from plcruntime.retain import type_text

    return type_text(t).removeprefix("ENUM ")


def _converted(entry: _Entry, enums: dict[str, list], t: Type) -> bytes:
    """The bytes of a stored value as type t. Raises _Misfit."""
    if isinstance(t, Enum) or entry.type in enums:
        return _label(entry, enums, t)
    if isinstance(t, String):
        return _string(entry, t)
    base = base_of(t)
    old = ELEMENTARY.get(entry.type.partition("(")[0])  # without the limits of a subrange
    if not isinstance(base, Elementary) or old is None:
        if entry.type == _shown(t) and len(entry.data) == t.size:
            return entry.data  # a UNION as it was
        raise _Misfit
    value = _value(old, entry.data)
    if base.kind in ("int", "bits", "real") and old.kind in ("int", "bits", "real"):
        return _number(t, base, value)
    if base is old:
        return entry.data
    if any({base.name, old.name} <= family for family in _FAMILIES):
        ticks, rest = divmod(value * PER_SECOND[base.name], PER_SECOND[old.name])
        if rest:
            raise _Misfit(", which can't hold it exactly")
        return _number(t, base, ticks)
    raise _Misfit


def _value(t: Elementary, data: bytes) -> int | float:
    return struct.unpack("<" + FORMATS[t.name], data)[0]


def _number(t: Type, base: Elementary, value: int | float) -> bytes:
    """The bytes of exactly this number. Raises _Misfit."""
    if base.kind == "real":
        try:
            data = struct.pack("<" + FORMATS[base.name], value)
        except OverflowError:
            raise _Misfit(f", which can't hold {value}") from None
        back = _value(base, data)
        if back == value or math.isnan(back) and math.isnan(value):
            return data
        raise _Misfit(f", which can't hold {value} exactly")
    low, high = (t.low, t.high) if isinstance(t, SubrangeType) else (base.low, base.high)
    if not math.isfinite(value) or value != int(value) or not low <= value <= high:
        raise _Misfit(f", which can't hold {value}")
    return struct.pack("<" + FORMATS[base.name], int(value))


def _label(entry: _Entry, enums: dict[str, list], t: Type) -> bytes:
    """An ENUM's value by its label: the numbers may have changed. A number without label stays that number."""
    if not isinstance(t, Enum) or entry.type not in enums:
        raise _Misfit
    base, labels = enums[entry.type]
    number = _value(ELEMENTARY[base], entry.data)
    label = next((name for name, value in labels.items() if value == number), None)
    if label is not None:
        known = {name.upper(): value for name, value in t.values.items()}
        if label.upper() not in known:
            raise _Misfit(f", which has no {label}")
        number = known[label.upper()]
    return _number(t, t.base, number)


def _string(entry: _Entry, t: String) -> bytes:
    name, _, length = entry.type.partition("(")
    if name != ("WSTRING" if t.wide else "STRING") or not length:
        raise _Misfit
    unit = 2 if t.wide else 1
    characters = [entry.data[i : i + unit] for i in range(0, len(entry.data), unit)]
    end = characters.index(bytes(unit)) if bytes(unit) in characters else len(characters)
    if end > t.length:
        raise _Misfit(f", too short for a text of {end} characters")
    return b"".join(characters[:end]).ljust(t.size, b"\0")

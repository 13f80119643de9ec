"""What a plot shows, apart from how it is drawn: curves of the axes that moved, other values, a timeline of BOOLs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from plcruntime.axes import ROOT
from stcore.paths import PathError, Place
from stcore.program import NULL_PAGE
from stcore.types import Elementary, Enum, base_of

if TYPE_CHECKING:
    from plcruntime.plc import PLC
    from plcruntime.trace import Trace

AXIS_BYTES = 200 << 20  # memory that the curves of the axes may take
CURVES = ("prfPos", "prfVel", "prfAcc")
FLAGS = {"drive.enabled": "enabled", "moving": "moving", "drive.alarm": "alarm"}
MAX_LANES = 24
MAX_PANELS = 16


@dataclass(slots=True)
class Curve:
    """One line: values over the picture's time. stepped: holds its value between scans (a counter, an INT)."""

    label: str
    values: object  # numpy array
    unit: str = ""
    stepped: bool = False


@dataclass(slots=True)
class Panel:
    """Curves with one scale. title: of the scale, with its unit. limits: mark extreme values."""

    title: str
    curves: list[Curve]
    limits: bool = False
    names: dict[int, str] = field(default_factory=dict)  # labels of an ENUM's numbers


@dataclass(slots=True)
class Picture:
    """time: numpy array of s. lanes: (label, numpy array of bool) from the top down."""

    title: str
    time: object
    panels: list[Panel]
    lanes: list[tuple[str, object]]


def axis_names(plc: PLC, scans: int) -> list[str]:
    """Paths to trace so that the curves of the axes can be drawn; as many axes as memory allows for `scans` scans."""
    numbers = list(plc.axes.numbers)
    numbers = numbers[: max(8, AXIS_BYTES // (max(1, scans) * 27))]
    return [f"{ROOT}[{n}].{member}" for n in numbers for member in (*CURVES, *FLAGS) if _there(plc, n, member)]


def _there(plc: PLC, number: int, member: str) -> bool:
    try:
        plc.place(f"{ROOT}[{number}].{member}")
        return True
    except PathError:  # a simulator without that member: not drawn
        return False


def compose(plc: PLC | None, trace: Trace, title: str, watched: list[str] | None = None) -> Picture:
    """The picture of a trace. watched: the columns that the user named; None: those that changed."""
    numbers = _moved(plc, trace) if plc else []
    panels = _axis_panels(plc, trace, numbers) if numbers else []
    own = [p for p in trace.places if not p.name.startswith(ROOT)]
    if watched is not None:
        own = [p for p in own if p.name in watched]
    lanes, values = [], []
    for place in own:
        column = trace[place.name]
        if not len(column) or column.dtype == object:
            continue
        changed = bool((column != column[0]).any())
        if watched is None and not changed:
            continue
        if column.dtype == bool:
            lanes.append((_short(place), column))
        elif _kind(place) == "bits":
            lanes += _bits(place, column)
        elif watched is not None or not numbers:
            values.append(value_panel(place, column))
    if numbers and not (watched and lanes):
        lanes = _axis_lanes(plc, trace, numbers) + lanes
    left_out = max(0, len(values) - MAX_PANELS) + max(0, len(lanes) - MAX_LANES)
    if left_out:
        title = f"{title} ({left_out} more values are not shown)".strip()
    return Picture(title, trace.time, panels + values[:MAX_PANELS], lanes[:MAX_LANES])


def _short(place: Place) -> str:
    """The name as its program knows it."""
    return place.name.split(".", 1)[1] if "." in place.name else place.name


def _kind(place: Place) -> str:
    t = base_of(place.type)
    return t.kind if isinstance(t, Elementary) else ""


def _bits(place: Place, column) -> list:
    """A lane for each bit of a status word that was ever set."""
    shown = 0
    for value in set(column.tolist()):
        shown |= value
    name = _short(place)
    bits = [b for b in range(64) if shown >> b & 1]
    return [(f"{name}.{b}", column >> column.dtype.type(b) & column.dtype.type(1) == 1) for b in bits]


def value_panel(place: Place, column) -> Panel:
    """A panel for one variable."""
    kind = _kind(place)
    unit = " (s)" if kind in ("time", "date") else ""
    names = {v: n for n, v in place.type.values.items()} if isinstance(place.type, Enum) else {}
    return Panel(_short(place) + unit, [Curve(_short(place), column, stepped=kind != "real")], names=names)


def _moved(plc: PLC, trace: Trace) -> list[int]:
    """The axes whose planned position changed."""
    names = set(trace.names)
    moved = []
    for n in plc.axes.numbers:
        if f"{ROOT}[{n}].prfPos" in names:
            position = trace[f"{ROOT}[{n}].prfPos"]
            if len(position) and (position != position[0]).any():
                moved.append(n)
    return moved


def _axis_lanes(plc: PLC, trace: Trace, numbers: list[int]) -> list:
    lanes = []
    for n in numbers:
        for member, label in FLAGS.items():
            name = f"{ROOT}[{n}].{member}"
            if name in trace.names and trace[name].any():
                lanes.append((f"{axis_label(plc, n)} {label}", trace[name]))
    return lanes


def axis_label(plc: PLC, number: int) -> str:
    """The name of an axis in plc.toml, else its number."""
    name = next((a.name for a in plc.project.axes if a.number == number and a.name), "")
    return name or f"axis {number}"


def _axis_panels(plc: PLC, trace: Trace, numbers: list[int]) -> list[Panel]:
    """Position, velocity and acceleration; axes of the same units share a panel."""
    groups: dict[tuple[str, str, str], list[tuple[int, float, float]]] = {}
    for n in numbers:
        units, scale, zero = _units(plc, n)
        groups.setdefault(units, []).append((n, scale, zero))
    panels = []
    for units, members in groups.items():
        per_second = 1000.0 if units[1].endswith("/s") else 1.0
        for k, (quantity, member) in enumerate(zip(("Position", "Velocity", "Acceleration"), CURVES, strict=True)):
            curves = []
            for n, scale, zero in members:
                values = trace[f"{ROOT}[{n}].{member}"]
                values = (values - zero) / scale if k == 0 else values / scale * per_second**k
                curves.append(Curve(axis_label(plc, n), values, units[k]))
            panels.append(Panel(f"{quantity} ({units[k]})", curves, limits=True))
    return panels


def _units(plc: PLC, number: int) -> tuple[tuple[str, str, str], float, float]:
    """(names of the units, pulses per unit, pulses at 0): u and s for an AXIS_REF_SM3, pulses and ms for GT_."""
    axis = plc.axes[number]
    try:
        reference, scale, zero = axis.ref, axis.scale, axis.zero
    except (AttributeError, PathError):  # a simulator without units of the program
        reference, scale, zero = 0, 0.0, 0.0
    if isinstance(reference, int) and reference >= NULL_PAGE and scale:
        return ("u", "u/s", "u/s²"), scale, zero
    return ("pulse", "pulse/ms", "pulse/ms²"), 1.0, 0.0

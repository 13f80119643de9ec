"""What `axes` shows: one row for each simulated axis that is in use."""

from __future__ import annotations

from plcruntime import layout
from plcruntime.axes import ROOT
from plcruntime.plc import PLC
from stcore.paths import instance_at
from stcore.values import decode

_HEADS = ("axis", "name", "state", "position", "velocity", "actual", "unit", "status", "signals")
_SIGNALS = {
    "drive.enabled": "on", "moving": "moving", "drive.alarm": "alarm", "drive.offline": "offline",
    "switches.positive": "+limit", "switches.negative": "-limit", "switches.home": "home",
}  # fmt: skip
_USED = ("used", "moving", "drive.enabled", "prfPos")


def lines(plc: PLC, room: int | None) -> list[str]:
    """The table; [] when no axis is in use. room: characters of a line of the terminal; a narrow one has no status."""
    rows = [_row(plc, number) for number in _in_use(plc)]
    if not rows:
        return []
    shown = [i for i in range(len(_HEADS)) if any(row[i] for row in rows)]
    made = _table(rows, shown, room)
    if room is not None and max(map(len, made)) > room:
        made = _table(rows, [i for i in shown if _HEADS[i] != "status"], room)
    return made


def _table(rows: list[tuple[str, ...]], columns: list[int], room: int | None) -> list[str]:
    return layout.table(tuple(_HEADS[i] for i in columns), [tuple(r[i] for i in columns) for r in rows], room)


def _in_use(plc: PLC) -> list[int]:
    """Numbers of axes. The simulator has hundreds: where the first has its members is looked up once."""
    numbers, memory = plc.axes.numbers, plc._machine.memory
    if not numbers:
        return []
    first = f"{ROOT}[{numbers[0]}]"
    size = plc.place(first).size
    signs = [plc.place(f"{first}.{member}") for member in _USED]
    return [n for k, n in enumerate(numbers) if any(decode(memory, s.type, s.address + k * size) for s in signs)]


def _row(plc: PLC, number: int) -> tuple[str, ...]:
    path = f"{ROOT}[{number}]"
    axis = plc.axes[number]
    state = plc.show(f"{path}.state")
    if axis.error:
        state += f" ({plc.show(f'{path}.error')})"
    if axis.ref:  # an axis of the program, in its own units
        ref = f"{path}.ref^"
        values, unit = [plc[f"{ref}.{n}"] for n in ("fSetPosition", "fSetVelocity", "fActPosition")], "u, s"
    else:
        values, unit = [axis.prfPos, axis.prfVel, axis.encPos], "pulse, ms"
    position, velocity, actual = (f"{value:11.4f}" for value in values)  # as wide as most: columns that do not jump
    signals = [word for member, word in _SIGNALS.items() if plc[f"{path}.{member}"]]
    name = _name(plc, number, axis.ref)
    return str(number), name, state, position, velocity, actual, unit, f"{axis.status:08X}", " ".join(signals)


def _name(plc: PLC, number: int, ref: int) -> str:
    """Of the plc.toml, else of the AXIS_REF_SM3."""
    configured = next((a.name for a in plc.project.axes if a.number == number and a.name), "")
    return configured or ref and instance_at(plc.program, plc.place(f"{ROOT}[{number}].ref^").type, ref) or ""

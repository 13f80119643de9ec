"""What `axes` shows: one row for each simulated axis that is in use."""

from __future__ import annotations

from plcruntime.axes import ROOT
from plcruntime.plc import PLC
from stcore.paths import instance_at

HEADS = ("axis", "name", "state", "set position", "velocity", "actual position", "status", "signals")
_SIGNALS = {
    "drive.enabled": "on", "moving": "moving", "drive.alarm": "alarm", "drive.offline": "offline",
    "switches.positive": "+limit", "switches.negative": "-limit", "switches.home": "home",
}  # fmt: skip


def rows(plc: PLC) -> list[tuple[str, ...]]:
    """Cells as HEADS names them; [] when no axis is in use."""
    return [_row(plc, number) for number in plc.axes.numbers if _in_use(plc.axes[number])]


def _in_use(axis) -> bool:
    return axis.used or axis.moving or axis.drive.enabled or bool(axis.prfPos)


def _row(plc: PLC, number: int) -> tuple[str, ...]:
    path = f"{ROOT}[{number}]"
    axis = plc.axes[number]
    state = plc.show(f"{path}.state")
    if axis.error:
        state += f" ({plc.show(f'{path}.error')})"
    if axis.ref:  # an axis of the program, in its own units
        ref = f"{path}.ref^"
        set_position, actual = (f"{plc[f'{ref}.{name}']:.3f} u" for name in ("fSetPosition", "fActPosition"))
        velocity = f"{plc[f'{ref}.fSetVelocity']:.3f} u/s"
    else:
        set_position, actual = f"{axis.prfPos:.3f} pulse", f"{axis.encPos:.3f} pulse"
        velocity = f"{axis.prfVel:.4f} pulse/ms"
    signals = [word for member, word in _SIGNALS.items() if plc[f"{path}.{member}"]]
    name = _name(plc, number, axis.ref)
    return str(number), name, state, set_position, velocity, actual, f"{axis.status:08X}", " ".join(signals)


def _name(plc: PLC, number: int, ref: int) -> str:
    """Of the plc.toml, else of the AXIS_REF_SM3."""
    configured = next((a.name for a in plc.project.axes if a.number == number and a.name), "")
    return configured or ref and instance_at(plc.program, plc.place(f"{ROOT}[{number}].ref^").type, ref) or ""

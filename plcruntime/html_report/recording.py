"""Records what a report shows: the axes, the variables, the errors of blocks, the commands that returned errors."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from plcruntime.axes import ROOT
from plcruntime.picture import axis_names
from stcore import paths
from stcore.paths import PathError

if TYPE_CHECKING:
    from plcruntime.plc import PLC

COLUMNS = 1500  # variables recorded when none is named; with more only the programs' own scalars


class Recording:
    """What happens to a PLC from now on, for `to_html`. names: the variables that the report shows first."""

    def __init__(self, plc: PLC, names: list[str] | None = None, scans: int = 0) -> None:
        """scans: how many are to be expected, which limits the axes that are recorded. Raises PathError, ValueError."""
        self.plc = plc
        self.names = [plc.place(n).name for n in names] if names else None
        self.error_names = _error_names(plc)
        self.state_names = [n for n in (f"{ROOT}[{k}].state" for k in plc.axes.numbers) if _is_there(plc, n)]
        curves = axis_names(plc, scans)
        states = [n for n in self.state_names if n.replace(".state", ".prfPos") in curves]
        self.trace = plc.trace(*dict.fromkeys((*curves, *states, *self.error_names, *(names or _everything(plc)))))
        self.returns = plc.log_returns()

    def to_html(
        self, path: str | Path, *, title: str = "", overlay: str | Path | None = None, stopped: str = ""
    ) -> None:
        """Write the report. overlay: the .npz of another run, drawn dashed. stopped: why the run ended.

        Raises UsageError (plotly is not installed, an overlay that is no trace), OSError."""
        from plcruntime.html_report.page import write

        write(self, Path(path), title, Path(overlay) if overlay else None, stopped)


def _is_there(plc: PLC, path: str) -> bool:
    try:
        plc.place(path)
        return True
    except PathError:  # a program without axes
        return False


def _leaves(plc: PLC) -> list[paths.Place]:
    small, _ = paths.small_places(plc.program, 64)
    return [leaf for place in small for leaf in paths.leaves(place)]


def _everything(plc: PLC) -> list[str]:
    """Every number, BOOL and time of the user, or only the programs' own when there are too many."""
    found = [p.name for p in _leaves(plc) if paths.is_scalar(p)]
    if len(found) > COLUMNS:
        found = [p.name for p in paths.user_places(plc.program) if paths.is_scalar(p)][:COLUMNS]
    return found


def _error_names(plc: PLC) -> list[str]:
    """The Error and ErrorID of every instance that has them: what the MC_ blocks say."""
    names = {p.name.upper(): p for p in _leaves(plc)}
    found = []
    for upper, place in names.items():
        if upper.endswith(".ERROR") and place.type.name == "BOOL":
            number = names.get(upper + "ID")
            found += [place.name, number.name] if number and paths.is_scalar(number) else [place.name]
    return found[:COLUMNS]

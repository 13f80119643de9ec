"""The simulator's axes as Python objects: ``plc.axes[1].position``, ``plc.axes[1].drive.alarm = True``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from stcore.paths import PathError
from stcore.types import Array, Block, Struct

if TYPE_CHECKING:
    from plcruntime.plc import PLC

ROOT = "SIM.Axis"


class Members:
    """The members of a structure or an instance as attributes; names are not case-sensitive."""

    def __init__(self, plc: PLC, path: str) -> None:
        object.__setattr__(self, "_plc", plc)
        object.__setattr__(self, "_path", path)

    def _place(self, name: str):
        try:
            return self._plc.place(f"{self._path}.{name}")
        except PathError as error:
            raise AttributeError(str(error)) from None

    def __getattr__(self, name: str):
        if name.startswith("__"):
            raise AttributeError(name)
        place = self._place(name)
        if isinstance(place.type, Struct | Block):
            return Members(self._plc, place.name)
        return self._plc[place.name]

    def __setattr__(self, name: str, value) -> None:
        self._plc[self._place(name).name] = value

    def __dir__(self) -> list[str]:
        return [f.name for f in self._plc.place(self._path).type.members.values()]

    def __repr__(self) -> str:
        return f"<{self._path}: {', '.join(dir(self))}>"


class Axes:
    """Axes of the simulator by number (from 1) or by the name in plc.toml. Empty when the program moves none.

    ``plc.axes[1].position`` and ``.velocity`` are the motor's, in pulse and pulse/ms, ``.status`` is the status word;
    mclib/library/sim/SimAxis.st has all members. They can be written too: ``plc.axes[1].switches.positive = True``.
    """

    def __init__(self, plc: PLC) -> None:
        self._plc = plc

    @property
    def numbers(self) -> range:
        """The numbers of the axes that the simulator has."""
        variable = self._plc.program.variables.get(ROOT.upper())
        if variable is None or not isinstance(variable.type, Array):
            return range(0)
        low, high = variable.type.bounds[0]
        return range(low, high + 1)

    def __getitem__(self, key: int | str) -> Members:
        number = key
        if isinstance(key, str):
            number = next((a.number for a in self._plc.project.axes if a.name.upper() == key.upper()), None)
        if number not in self.numbers:
            known = f"{self.numbers[0]}..{self.numbers[-1]}" if self.numbers else "none: the program moves no axis"
            raise PathError(f"there is no axis {key}; axes: {known}")
        return Members(self._plc, f"{ROOT}[{number}]")

    def __iter__(self) -> Iterator[Members]:
        return (self[n] for n in self.numbers)

    def __len__(self) -> int:
        return len(self.numbers)

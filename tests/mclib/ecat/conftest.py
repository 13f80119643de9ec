"""A PLC that can call any function of the bus: the call is typed, as at the prompt, and one scan follows it."""

import re
from functools import cache
from pathlib import Path

import pytest

from plcruntime import project
from plcruntime.plc import PLC, build

LIBRARY = Path(__file__).parents[3] / "mclib/library/ecat"
VARIABLES = (
    "i : INT; x : DINT; n, got, abort : UDINT; u : UINT; bit : BYTE := 1; d : ARRAY[0..3] OF DINT; "
    "jog : TJogPrm; trap : TTrapPrm;"
)
OTHERS = (
    "GT_AxisOn(1)", "GT_AxisOff(1)", "GT_ClrSts(1)", "GT_Reset()", "GT_GetSts(1, ADR(x))", "GT_PrfJog(1)",
    "GT_SetJogPrm(1, ADR(jog))", "GT_SetVel(1, 1)", "GT_Update(1)", "GT_Stop(1, 0)", "GT_PrfTrap(1)",
    "GT_SetTrapPrm(1, ADR(trap))", "GT_SetPos(1, 1)",
)  # fmt: skip


def _given(inputs: str) -> str:
    """Without what the compiler itself gives."""
    return inputs.partition("{attribute 'room_of'")[0]


def _call(file: Path) -> str:
    """A call of the function with its defaults, for a program that only has to know it."""
    text = file.read_text(encoding="utf-8")
    inputs = re.search(r"VAR_INPUT\n(.*?)END_VAR", text, re.S)
    names = (
        [n.strip() for line in re.findall(r"^ +([\w, ]+) :", _given(inputs[1]), re.M) for n in line.split(",")]
        if inputs
        else []
    )
    return f"{file.stem}({', '.join('0' for _ in names)})"


@cache
def compiled():
    calls = [_call(f) for f in sorted(LIBRARY.glob("GT_*.st"))] + list(OTHERS)
    body = "\n".join(f"    rtn := {c};" for c in calls)
    text = (
        f"PROGRAM PLC_PRG\nVAR never : BOOL; rtn : INT; {VARIABLES} END_VAR\nIF never THEN\n{body}\nEND_IF\nEND_PROGRAM"
    )
    return build(text)[0]


@cache
def shared() -> PLC:
    return PLC(compiled())


class Bench:
    """bus("GT_X(...)") calls it and runs a scan; bus["name"] is a variable that calls may use."""

    def __init__(self, config: Path | None = None, **options) -> None:
        """config: a plc.toml; options: of PLC. Without either one PLC serves all, as new."""
        if config or options:
            self.plc = PLC(compiled(), project=project.load(config) if config else None, **options)
        else:
            self.plc = shared()
            self.plc.reset("origin")
        self.axis = self.plc.axes[1]

    def __call__(self, call: str):
        rtn = self.plc.evaluate(call)
        self.plc.scan()
        return rtn

    def __getitem__(self, name: str):
        return self.plc[f"PLC_PRG.{name}"]

    def __setitem__(self, name: str, value) -> None:
        self.plc[f"PLC_PRG.{name}"] = value

    @property
    def why(self) -> str:
        return self.plc[f"SIM.refused[{(self.plc['SIM.refusals'] - 1) % 32}].why"]

    def scan(self, count: int = 1) -> None:
        self.plc.scan(count)

    def power(self) -> None:
        assert self("GT_AxisOn(1)") == 0

    def jog(self, vel: float, acc: float = 1.0) -> None:
        """Velocity 'vel' from the next scan on."""
        self["jog"] = {"acc": acc, "dec": acc, "smooth": 0}
        for call in ("GT_PrfJog(1)", "GT_SetJogPrm(1, ADR(jog))", f"GT_SetVel(1, {vel})", "GT_Update(1)"):
            assert self(call) == 0, call


@pytest.fixture
def bus():
    return Bench()


@pytest.fixture
def bench():
    """The class itself, for another program or configuration."""
    return Bench

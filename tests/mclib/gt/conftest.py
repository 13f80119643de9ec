"""A controller whose commands are called one a scan, by name, with the arguments that a test gives."""

import sys
from pathlib import Path

import pytest

from plcruntime import PLC

sys.path.insert(0, str(Path(__file__).parent))  # for controller.py: the tests are no package

# a axis; i, j, k INT; x, y, z DINT; v LREAL; those with o in front receive
COMMANDS = (
    "GT_AxisOn(a)", "GT_AxisOff(a)", "GT_ClrSts(a)", "GT_ZeroPos(a, 1)", "GT_SetPrfPos(a, x)", "GT_SetEncPos(a, x)",
    "GT_SynchAxisPos(x)", "GT_Stop(x, y)", "GT_Reset()", "GT_PrfTrap(a)", "GT_PrfJog(a)", "GT_SetTrapPrm(a, ADR(trap))",
    "GT_SetJogPrm(a, ADR(jog))", "GT_SetPos(a, x)", "GT_SetVel(a, v)", "GT_Update(x)", "GT_GetSts(a, ADR(ox))",
    "GT_GetPrfMode(a, ADR(ox))", "GT_SetSoftLimit(a, x, y)", "GT_ProfileScale(a, i, j)", "GT_EncScale(a, i, j)",
    "GT_SetStopDec(a, v, w)",
    "GT_PrfPt(a, i)", "GT_SetPtMemory(a, i)", "GT_GetPtMemory(a, ADR(oi))", "GT_PtSpace(a, ADR(oi), j)",
    "GT_PtData(a, v, x, i, j)", "GT_PtClear(a, j)", "GT_PtStart(x, y)", "GT_SetPtLoop(a, x)",
    "GT_GetPtLoop(a, ADR(ox))", "GT_GetPtRemainder(a, ADR(ox))",
    "GT_PrfGear(a, i)", "GT_SetGearMaster(a, i, j, k)", "GT_GetGearMaster(a, ADR(oi), ADR(oj), ADR(ok))",
    "GT_SetGearRatio(a, x, y, z)", "GT_GetGearRatio(a, ADR(ox), ADR(oy), ADR(oz))", "GT_GearStart(x)",
    "GT_PrfFollow(a, i)", "GT_SetFollowMaster(a, i, j, k)", "GT_GetFollowMaster(a, ADR(oi), ADR(oj), ADR(ok))",
    "GT_FollowData(a, x, v, i, j)", "GT_FollowSpace(a, ADR(oi), j)", "GT_FollowClear(a, j)", "GT_FollowStart(x, y)",
    "GT_FollowSwitch(x)", "GT_SetFollowLoop(a, i)", "GT_GetFollowLoop(a, ADR(ox))", "GT_SetFollowEvent(a, i, j, x)",
    "GT_GetFollowEvent(a, ADR(oi), ADR(oj), ADR(ox))", "GT_SetFollowMemory(a, i)", "GT_GetFollowMemory(a, ADR(oi))",
)  # fmt: skip
PROGRAM = f"""
PROGRAM PLC_PRG
VAR
    job, rtn, a, i, j, k, oi, oj, ok : INT; x, y, z, ox, oy, oz : DINT; v, w : LREAL; trap : TTrapPrm; jog : TJogPrm;
END_VAR
CASE job OF
{"".join(f"    {n}: rtn := {c};" + chr(10) for n, c in enumerate(COMMANDS, 1))}
END_CASE
job := 0;
END_PROGRAM
"""
JOB = {c[: c.index("(")]: n for n, c in enumerate(COMMANDS, 1)}
MOVING, ENABLED = 1 << 10, 1 << 9


class Console:
    def __init__(self) -> None:
        self.plc = PLC.load(PROGRAM, interval="1ms")

    def __call__(self, command: str, a: int = 1, **arguments) -> int:
        """Call a command in the next scan; arguments not given are 0."""
        for name in "ijkxyzvw":
            self.plc[f"PLC_PRG.{name}"] = arguments.get(name, 0)
        for name in ("trap", "jog"):
            if name in arguments:
                self.plc[f"PLC_PRG.{name}"] = arguments[name]
        self.plc["PLC_PRG.a"] = a
        self.plc["PLC_PRG.job"] = JOB[command]
        self.plc.scan()
        return self.plc["PLC_PRG.rtn"]

    def ok(self, command: str, a: int = 1, **arguments) -> None:
        code = self(command, a, **arguments)
        assert code == 0, f"{command} gave {code}: {self.why}"

    def read(self, command: str, a: int = 1, **arguments):
        """What a reading command gives through its first pointer."""
        self.ok(command, a, **arguments)
        return self["ox" if "ADR(ox)" in COMMANDS[JOB[command] - 1] else "oi"]

    def __getitem__(self, name: str):
        return self.plc[f"PLC_PRG.{name}"]

    @property
    def why(self) -> str:
        return self.plc["SIM.refused"][(self.plc["SIM.refusals"] - 1) % 32]["why"]

    def axis(self, n: int = 1):
        return self.plc.axes[n]

    def jog(self, n: int, vel: float, acc: float = 1.0) -> None:
        """Jog an axis: set up when it rests, changed when it moves."""
        if not self.axis(n).moving:
            self.ok("GT_PrfJog", n)
            self.ok("GT_SetJogPrm", n, jog={"acc": acc, "dec": acc, "smooth": 0.0})
        self.ok("GT_SetVel", n, v=vel)
        self.ok("GT_Update", x=1 << (n - 1))

    def follow(self, *axes: int):
        """Record planned position and velocity of axes at the end of every scan: use rows() afterwards."""
        self._watched = [f"SIM.Axis[{n}].{m}" for n in axes for m in ("prfPos", "prfVel", "prfAcc")]
        self._trace = self.plc.trace(*self._watched)

    def rows(self, axis: int) -> list[tuple[float, float, float]]:
        columns = [[float(x) for x in self._trace[f"SIM.Axis[{axis}].{m}"]] for m in ("prfPos", "prfVel", "prfAcc")]
        return list(zip(*columns, strict=True))


@pytest.fixture
def gt():
    return Console()

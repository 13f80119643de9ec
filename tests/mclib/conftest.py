"""One axis under every block, its inputs set from Python; after every scan the rules that always hold are checked."""

import pytest

from plcruntime import PLC

PROGRAM = """
PROGRAM PLC_PRG
VAR
    ax : AXIS_REF_SM3;
    power : MC_Power; absolute, second : MC_MoveAbsolute; relative : MC_MoveRelative; additive : MC_MoveAdditive;
    velocity : MC_MoveVelocity; halt : MC_Halt; stop, stop2 : MC_Stop; reset : MC_Reset; jog : MC_Jog; inch : SMC_Inch;
    status : MC_ReadStatus; fault : MC_ReadAxisError; setpos : MC_SetPosition;
    rtn : INT; gt : BYTE; prfPos, prfVel : LREAL; sts : DWORD; trap : TTrapPrm; jogPrm : TJogPrm;
END_VAR
CASE gt OF
    1: rtn := GT_PrfTrap(1);
       trap.acc := 1; trap.dec := 1; trap.smoothTime := 0;
       rtn := GT_SetTrapPrm(1, ADR(trap)); rtn := GT_SetPos(1, 1000); rtn := GT_SetVel(1, 10); rtn := GT_Update(1);
    2: rtn := GT_Update(1);
    3: rtn := GT_Stop(1, 0);
    4: rtn := GT_AxisOn(1);
    5: rtn := GT_ClrSts(1, 1);
    6: rtn := GT_Stop(1, 1);
    7: rtn := GT_AxisOff(1);
    8: rtn := GT_PrfJog(1); jogPrm.acc := 1; jogPrm.dec := 1;
       rtn := GT_SetJogPrm(1, ADR(jogPrm)); rtn := GT_SetVel(1, 5); rtn := GT_Update(1);
END_CASE
gt := 0;
power(Axis := ax); absolute(Axis := ax); second(Axis := ax); relative(Axis := ax); additive(Axis := ax);
velocity(Axis := ax); halt(Axis := ax); stop(Axis := ax); stop2(Axis := ax); reset(Axis := ax); jog(Axis := ax);
inch(Axis := ax); setpos(Axis := ax); status(Axis := ax, Enable := TRUE); fault(Axis := ax, Enable := TRUE);
GT_GetPrfPos(1, ADR(prfPos)); GT_GetPrfVel(1, ADR(prfVel)); GT_GetSts(1, ADR(sts));
END_PROGRAM
"""
EDGE = ("absolute", "second", "relative", "additive", "halt", "stop", "stop2", "reset", "velocity")
MOTION = ("absolute", "second", "relative", "additive", "halt", "stop", "stop2", "velocity", "jog", "inch")
STATES = (
    "Disabled", "Errorstop", "Stopping", "StandStill", "DiscreteMotion", "ContinuousMotion", "SynchronizedMotion",
    "Homing",
)  # fmt: skip


class Bench:
    """A PLC with one axis. Units are pulses: the axis is unscaled unless a test says otherwise."""

    def __init__(self) -> None:
        self.plc = PLC.load(PROGRAM)
        self.continuous = True  # position and velocity may not jump
        self._last: tuple[float, float] | None = None

    def __getitem__(self, name: str):
        return self.plc[f"PLC_PRG.{name}"]

    def __setitem__(self, name: str, value) -> None:
        self.plc[f"PLC_PRG.{name}"] = value

    @property
    def state(self) -> str:
        names = [n for n in STATES if self[f"status.{n}"]]
        assert len(names) == 1, names
        return names[0]

    def scan(self, count: int = 1) -> None:
        for _ in range(count):
            self.plc.scan()
            self._rules()

    def until(self, name: str, most: int = 20000) -> int:
        for n in range(most):
            if self[name]:
                return n
            self.scan()
        raise AssertionError(f"{name} did not come in {most} scans")

    def start(self, block: str, **inputs) -> None:
        """Set a block's inputs and its Execute, and scan once."""
        for name, value in inputs.items():
            self[f"{block}.{name}"] = value
        self[f"{block}.Execute"] = True
        self.scan()

    def power(self) -> None:
        for name in ("Enable", "bRegulatorOn", "bDriveStart"):
            self[f"power.{name}"] = True
        self.until("power.Status")
        self.scan()

    def _rules(self) -> None:
        owners, axis = 0, self.plc.axes[1]
        for name in MOTION:
            block = self[name]
            outputs = [o for o in ("Done", "Busy", "CommandAborted", "Error") if block.get(o)]
            assert len(outputs) <= 1, f"{name}: {outputs}"
            if name in EDGE and block["Execute"]:
                assert outputs or block.get("InVelocity"), f"{name}: Execute and no output"
            assert bool(block.get("Error")) == (block["ErrorID"] != 0), name
            # a block that was called before the one that took the axis learns of it in the next scan
            owners += block["Busy"] and block["order"]["result"] == 0
        assert owners <= 1, "two blocks own the axis"
        now = (axis.prfPos, axis.prfVel)
        if self._last and self.continuous:
            assert abs(now[0] - self._last[0] - (now[1] + self._last[1]) / 2) < 2.6, "the position jumped"
        self._last = now


@pytest.fixture
def bench():
    return Bench()

"""Three axes under the blocks of PLCopen Part 1. The program itself watches the axes in every scan, so that many scans
run in one call: no jump of position or velocity, one owner an axis,
at most one of Busy, Done, Error and CommandAborted."""

import pytest
from waiting import VARIABLE, wait

from plcruntime import PLC

BLOCKS = {
    "first": "MC_MoveAbsolute", "second": "MC_MoveAbsolute", "third": "MC_MoveAbsolute", "relative": "MC_MoveRelative",
    "additive": "MC_MoveAdditive", "velocity": "MC_MoveVelocity", "onward": "MC_MoveContinuousAbsolute",
    "further": "MC_MoveContinuousRelative", "smcOnward": "SMC_MoveContinuousAbsolute",
    "smcFurther": "SMC_MoveContinuousRelative", "over": "MC_MoveSuperImposed", "over2": "MC_MoveSuperImposed",
    "haltOver": "MC_HaltSuperimposed", "halt": "MC_Halt", "stop": "MC_Stop", "reset": "MC_Reset", "home": "MC_Home",
    "torque": "MC_TorqueControl",
}  # fmt: skip
INPUTS = {"jog": "JogForward", "inch": "InchForward", "smcHome": "bExecute"}  # what starts a block, if not Execute
TABLES = {"positions": ("MC_PositionProfile", "TimePosition", "MC_TP_REF"),
          "velocities": ("MC_VelocityProfile", "TimeVelocity", "MC_TV_REF"),
          "accelerations": ("MC_AccelerationProfile", "TimeAcceleration", "MC_TA_REF")}  # fmt: skip
LINKS = {
    "gear": "MC_GearIn", "gear2": "MC_GearIn", "meet": "MC_GearInPos", "cam": "MC_CamIn",
    "phase": "MC_PhasingAbsolute", "further2": "MC_PhasingRelative",
}  # fmt: skip
PLACES = dict.fromkeys(LINKS, "link.") | dict.fromkeys(TABLES, "profile.")  # of the order in the block
OUTPUTS = ("Done", "Busy", "Error", "CommandAborted")


def _block(name: str, call: str, *, done: bool = True) -> str:
    """Call a block and check its outputs."""
    outputs = ["Busy", "Error"] + (["Done"] if done else [])
    if name not in ("reset", "gearOut", "camOut"):
        outputs.append("CommandAborted")
    count = " + ".join(f"BOOL_TO_INT({name}.{o})" for o in outputs)
    text = f"IF skip <> '{name}' THEN {name}({call}); END_IF\nn := {count};\n"
    text += f"IF n > 1 THEN wrong := '{name}: two outputs'; END_IF\n"
    if done:
        text += f"IF {name}.Execute AND n = 0 THEN wrong := '{name}: no output'; END_IF\n"
    text += f"IF {name}.Error <> ({name}.ErrorID <> 0) THEN wrong := '{name}: ErrorID'; END_IF\n"
    return text


ENDLESS = ("velocity", "onward", "further", "smcOnward", "smcFurther", "torque")
PROGRAM = (
    "PROGRAM PLC_PRG\nVAR\n"
    + "".join(f"    {n} : {t};\n" for n, t in (BLOCKS | LINKS).items())
    + "".join(f"    {n} : {b}; {n}Table : {t};\n" for n, (b, _, t) in TABLES.items())
    + """    ax, master, other : AXIS_REF_SM3;
    power, power2, power3 : MC_Power; run, run3 : MC_MoveVelocity; carry : MC_MoveAbsolute; masterHalt : MC_Halt;
    combine : MC_CombineAxes; jog : MC_Jog; inch : SMC_Inch; smcHome : SMC_Homing;
    gearOut : MC_GearOut; camOut : MC_CamOut;
    table : MC_CAM_REF; select : MC_CamTableSelect; override : MC_SetOverride;
    status : MC_ReadStatus; motion : MC_ReadMotionState; info : MC_ReadAxisInfo;
    """ + VARIABLE + """
    n, owners : INT; skip, wrong : STRING; calm : BOOL := TRUE;
    p, v, jumpP, jumpV, fastest, mark, atMark, before : LREAL; scans : DINT;
END_VAR
owners := 0;
power(Axis := ax); power2(Axis := master, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
power3(Axis := other, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
run(Axis := master); run3(Axis := other); carry(Axis := master); masterHalt(Axis := master); override(Axis := ax);
jog(Axis := ax); inch(Axis := ax); smcHome(Axis := ax);
"""
    + "".join(_block(n, "Axis := ax", done=n not in ENDLESS) for n in BLOCKS)
    + "".join(_block(n, f"Axis := ax, {table} := {n}Table") for n, (_, table, _) in TABLES.items())
    + "".join(_block(n, "Master := master, Slave := ax", done=False) for n in ("gear", "meet", "cam"))
    + "gear2(Master := ax, Slave := other);\n"
    + "".join(_block(n, "Master := master, Slave := ax") for n in ("phase", "further2"))
    + _block("combine", "Master1 := master, Master2 := other, Slave := ax", done=False)
    + "".join(
        f"IF {n}.Busy AND {n}.{PLACES.get(n, '')}order.result = 0 THEN owners := owners + 1; END_IF\n"
        for n in (BLOCKS | TABLES | LINKS).keys() - {"over", "over2", "haltOver", "reset", "gear2", "phase", "further2"}
    )
    + """gearOut(Slave := ax); camOut(Slave := ax); select(Master := master, Slave := ax, CamTable := table);
IF owners > 1 THEN wrong := 'two owners'; END_IF
status(Axis := ax, Enable := TRUE); motion(Axis := ax, Enable := TRUE); info(Axis := ax, Enable := TRUE);
scans := scans + 1;
fastest := MAX(fastest, ABS(ax.fSetVelocity));
IF (before - mark) * (ax.fSetPosition - mark) <= 0 AND before <> ax.fSetPosition THEN atMark := ax.fSetVelocity; END_IF
before := ax.fSetPosition;
IF calm AND scans > 5 THEN
    jumpP := MAX(jumpP, ABS(ax.fSetPosition - p - (ax.fSetVelocity + v) * 0.0005));
    jumpV := MAX(jumpV, ABS(ax.fSetVelocity - v));
END_IF
p := ax.fSetPosition; v := ax.fSetVelocity;
END_PROGRAM
"""
)
STATES = ("power_off", "errorstop", "stopping", "standstill", "discrete", "continuous", "synchronized", "homing")


class Bench:
    """Units are pulses. Limits of `start` unless given: 1000 u/s, 10000 u/s2, no jerk limit."""

    def __init__(self) -> None:
        self.plc = PLC.load(PROGRAM)
        for name in ("Enable", "bRegulatorOn", "bDriveStart"):
            self[f"power.{name}"] = True
        self.plc.scan(10)

    def __getitem__(self, name: str):
        return self.plc[f"PLC_PRG.{name}"]

    def __setitem__(self, name: str, value) -> None:
        self.plc[f"PLC_PRG.{name}"] = value

    @property
    def state(self) -> str:
        return STATES[self["ax.nAxisState"]]

    def scan(self, count: int = 1) -> None:
        self.plc.scan(count)
        self._rules()

    def _rules(self) -> None:
        assert self["wrong"] == ""
        # without a jerk limit half an acceleration jump of 20 000 u/s2 within a scan of 1 ms
        assert self["jumpP"] < 0.0026, "the position jumped"
        assert self["jumpV"] < 20.1, "the velocity jumped"

    def until(self, name: str, most: int = 20000) -> int:
        """Scans until an output comes."""
        scans = wait(self.plc, f"PLC_PRG.{name}", most)
        self._rules()
        return scans

    def start(self, block: str, scans: int = 1, **inputs) -> None:
        """Give a block a rising edge and scan."""
        members = self[block]
        limits = {"Velocity": 1000.0, "VelocityDiff": 1000.0, "Acceleration": 10000.0, "Deceleration": 10000.0}
        for name, value in {**limits, **inputs}.items():
            if name in members or name in inputs:
                self[f"{block}.{name}"] = value
        edge = INPUTS.get(block, "Execute")
        if members[edge]:
            self[f"{block}.{edge}"] = False
            self.scan()
        self[f"{block}.{edge}"] = True
        self.scan(scans)

    def profile(self, name, pairs, absolute=True, **inputs):
        """Write the (ms, value) pairs into the table of a profile block and start it."""
        letter, member = {
            "positions": ("P", "position"),
            "velocities": ("V", "velocity"),
            "accelerations": ("A", "acceleration"),
        }[name]
        for i, (time, value) in enumerate(pairs, 1):
            self[f"{name}Table.MC_T{letter}_Array[{i}].delta_time"] = time / 1000
            self[f"{name}Table.MC_T{letter}_Array[{i}].{member}"] = value
        self[f"{name}Table.IsAbsolute"] = absolute
        self.start(name, ArraySize=len(pairs), **inputs)

    def outputs(self, block: str) -> str:
        """The one output that is TRUE."""
        members = self[block]
        return next((o for o in OUTPUTS if members.get(o) or members.get(f"b{o}")), "")

    def take_cam(self) -> None:
        """Give MC_CamIn what MC_CamTableSelect has made."""
        for member, value in self["select.CamTableID"].items():
            self[f"cam.CamTableID.{member}"] = value


    def fill_tables(self, seconds: float) -> None:
        """The tables of cams and profiles that some blocks need; how long the first segment of a profile takes."""
        self["table.nElements"] = 2
        self["table.Element[2].dX"] = 100.0
        self.start("select")
        self.take_cam()
        for table in ("positionsTable.MC_TP", "velocitiesTable.MC_TV", "accelerationsTable.MC_TA"):
            self[f"{table}_Array[1].delta_time"] = seconds


@pytest.fixture
def bench():
    return Bench()

"""Random programs of every block that moves an axis, with power losses, overrides and errors that are reset: one
owner, one output a block, no jump of the position, nothing that moves in standstill. Of a linear axis, and of a modulo
one whose units are turned round."""

import pytest

from plcruntime import PLC
from tests.mclib.mc import test_random as small

MOTION = small.MOTION | {
    "smcOnward": "SMC_MoveContinuousAbsolute", "smcFurther": "SMC_MoveContinuousRelative", "torque": "MC_TorqueControl",
    "home": "MC_Home", "setpos": "MC_SetPosition", "positions": "MC_PositionProfile",
    "velocities": "MC_VelocityProfile", "accelerations": "MC_AccelerationProfile", "jog": "MC_Jog", "inch": "SMC_Inch",
    "reset": "MC_Reset",
}  # fmt: skip
LINKS = small.LINKS | {"meet": "MC_GearInPos", "phase2": "MC_PhasingAbsolute"}
OUTS = {"gearOut": "MC_GearOut", "camOut": "MC_CamOut"}
TABLES = {
    "positions": "TimePosition := tp",
    "velocities": "TimeVelocity := tv",
    "accelerations": "TimeAcceleration := ta",
}
INPUTS = small.INPUTS | {
    "Torque": "draw(0.001, 0.008)", "TorqueRamp": "draw(0.05, 0.4)", "Mode": "draw(0, 1) < 0.5",
    "Direction": "whole(-1, 3)", "ArraySize": "whole(1, 3)", "EndVelocityDirection": "whole(-1, 3)",
    "RatioNumerator": "whole(-1, 1)", "RatioDenominator": "2", "InchForward": "draw(0, 1) < 0.5",
    "InchBackward": "NOT {}.InchForward OR draw(0, 1) < 0.1", "JogForward": "draw(0, 1) < 0.5",
    "JogBackward": "NOT {}.JogForward OR draw(0, 1) < 0.1", "StartMode": "whole(2, 4)",
    "MasterSyncPosition": "master.fSetPosition + draw(10, 60)", "SlaveOffset": "draw(-20, 20)",
    "SlaveSyncPosition": "ax.fSetPosition + draw(-5, 40)",
}  # fmt: skip
MOVE = small.MOVE
PROFILE = ("ArraySize", "BufferMode", "ContinuousUpdate")
TAKES = small.TAKES | {
    "smcOnward": ("Distance", "EndVelocity", "EndVelocityDirection", "Direction", *MOVE),
    "smcFurther": ("Distance", "EndVelocity", "EndVelocityDirection", *MOVE),
    "torque": ("Torque", "TorqueRamp", "Velocity", "BufferMode"), "home": ("Position", "BufferMode"),
    "setpos": ("Position", "Mode"), "positions": PROFILE, "velocities": PROFILE, "accelerations": PROFILE,
    "jog": ("JogForward", "JogBackward", *MOVE[:4]), "inch": ("InchForward", "InchBackward", "Distance", *MOVE[:4]),
    "gear": ("RatioNumerator", "RatioDenominator", *MOVE[1:]), "phase2": ("PhaseShift", *MOVE[:5]),
    "cam": ("StartMode", "VelocityDiff", "SlaveOffset", *MOVE[1:]), "gearOut": (), "camOut": (),
    "meet": ("RatioDenominator", "MasterSyncPosition", "SlaveSyncPosition", "BufferMode"),
}  # fmt: skip
for name in ("first", "second", "velocity", "onward"):
    TAKES[name] = ("Direction", *TAKES[name])
EXTRA = {"cam": "cam.CamTableID := select.CamTableID;"}
LEVEL = {"jog": ("JogForward", "JogBackward"), "inch": ("InchForward", "InchBackward")}  # what starts them
DONE = (*small.DONE, "home", "setpos", *TABLES, "reset", "phase2", *OUTS)
NEVER_ABORTED = ("setpos", "reset", *OUTS)
OWN = [n for n in TAKES if n not in ("over", "over2", "haltOver", "phase", "phase2", "setpos", *OUTS)]
ORDER = dict.fromkeys(("gear", "cam", "meet"), "link.") | dict.fromkeys(TABLES, "profile.")
ALL = MOTION | LINKS | OUTS


def call(name: str) -> str:
    axes = "Master := master, Slave := ax" if name in LINKS else "Slave := ax" if name in OUTS else "Axis := ax"
    return f"{name}({axes}{', ' + TABLES[name] if name in TABLES else ''});"


def start(name: str) -> str:
    off = " ".join(f"{name}.{i} := FALSE;" for i in LEVEL.get(name, ("Execute",)))
    inputs = " ".join(f"{name}.{i} := {INPUTS[i].format(name)};" for i in TAKES[name])
    return f"{off} {call(name)} {inputs} {EXTRA.get(name, '')}{'' if name in LEVEL else f' {name}.Execute := TRUE;'}"


def outputs(name: str) -> str:
    names = ["Busy", "Error"] + ["Done"] * (name in DONE) + ["CommandAborted"] * (name not in NEVER_ABORTED)
    count = " + ".join(f"BOOL_TO_INT({name}.{o})" for o in names)
    rules = f"IF {count} > 1 THEN wrong := '{name}: two outputs'; END_IF\n"
    if name not in LEVEL:
        rules += f"IF {name}.Execute AND {count} = 0 THEN wrong := '{name}: no output'; END_IF\n"
    return rules + f"IF {name}.Error <> ({name}.ErrorID <> 0) THEN wrong := '{name}: ErrorID'; END_IF\n"


STARTS = "\n".join(f"{k}: {start(n)}" for k, n in enumerate(TAKES))
SERVED = "\n".join(f"{k}: IF NOT {n}.Error THEN served[{k}] := served[{k}] + 1; END_IF" for k, n in enumerate(TAKES))
STOP = list(TAKES).index("stop")
PROGRAM = f"""
{small.PROGRAM[: small.PROGRAM.index("PROGRAM PLC_PRG")]}
FUNCTION whole : INT
VAR_INPUT low, high : INT; END_VAR
whole := REAL_TO_INT(LREAL_TO_REAL(draw(low - 0.49, high + 0.49)));
END_FUNCTION

PROGRAM PLC_PRG
VAR
    ax, master : AXIS_REF_SM3; power, power2 : MC_Power; run : MC_MoveVelocity; override : MC_SetOverride;
    {"; ".join(f"{n} : {t}" for n, t in ALL.items())};
    tp : MC_TP_REF; tv : MC_TV_REF; ta : MC_TA_REF; table : MC_CAM_REF; select : MC_CamTableSelect;
    left, scans, commands, faults, since : DINT; which, owners, i : INT; was : SMC_AXIS_STATE;
    p, v, d, jerk, jumpP : LREAL; wrong : STRING; on : BOOL; served : ARRAY[0..{len(TAKES) - 1}] OF DINT;
END_VAR
scans := scans + 1;
IF scans = 1 THEN
    table.nElements := 3; table.Element[2].dX := 200; table.Element[2].dY := 40; table.Element[3].dX := 400;
    FOR i := 1 TO 3 DO
        tp.MC_TP_Array[i].delta_time := T#80ms; tp.MC_TP_Array[i].position := 10 * i; tp.IsAbsolute := FALSE;
        tv.MC_TV_Array[i].delta_time := T#60ms; ta.MC_TA_Array[i].delta_time := T#50ms;
    END_FOR
    tv.MC_TV_Array[1].velocity := 100; tv.MC_TV_Array[2].velocity := -50;
    ta.MC_TA_Array[1].acceleration := 1000; ta.MC_TA_Array[2].acceleration := -1000;
    meet.Velocity := 3000; meet.Acceleration := 100000; meet.Deceleration := 100000;
END_IF
left := left - 1;
on := TRUE;
reset.Execute := FALSE;
IF ax.nAxisState = SMC_AXIS_STATE.errorstop THEN
    faults := faults + 1;
    since := scans;
    IF faults MOD 20 = 0 THEN
        reset(Axis := ax);
        reset.Execute := TRUE;
    END_IF
END_IF
IF scans > 10 AND left < 0 THEN
    stop.Execute := FALSE;
    on := draw(0, 1) > 0.01;
    override.Enable := TRUE;
    IF draw(0, 1) < 0.1 THEN
        override.VelFactor := SEL(draw(0, 1) < 0.2, 1.0, SEL(draw(0, 1) < 0.2, draw(0.1, 1), 0.0));
    END_IF
    which := whole(0, {len(TAKES) - 1});
    IF which = {STOP} AND (ax.nAxisState = SMC_AXIS_STATE.stopping OR draw(0, 1) < 0.7) THEN
        which := 0; (* a second stop is errorstop *)
    END_IF
    jerk := SEL(draw(0, 1) < 0.6, 0.0, draw(20000, 400000));
    CASE which OF
{STARTS}
    END_CASE
    commands := commands + 1;
    left := LREAL_TO_DINT(draw(0, 8) * draw(0, 8) * draw(0, 4));
END_IF
power(Axis := ax, Enable := TRUE, bRegulatorOn := on, bDriveStart := TRUE);
power2(Axis := master, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
run(Axis := master, Execute := power2.Status, Velocity := 200, Acceleration := 2000, Deceleration := 2000);
override(Axis := ax);
select(Master := master, Slave := ax, CamTable := table, Execute := power.Status);
{"".join(call(n) for n in ALL)}
{"".join(outputs(n) for n in ALL)}
owners := {" + ".join(f"BOOL_TO_INT({n}.Busy AND {n}.{ORDER.get(n, '')}order.result = 0)" for n in OWN)};
IF owners > 1 THEN wrong := 'two owners'; END_IF
IF ax.nAxisState = SMC_AXIS_STATE.standstill AND ax.fSetVelocity <> 0 THEN wrong := 'it moves in standstill'; END_IF
CASE which OF
{SERVED}
END_CASE
(* where the position is set, or an error stops the axis at once *)
IF setpos.Execute AND which = {list(TAKES).index("setpos")} OR home.Busy OR home.Done OR NOT on
    OR ax.nAxisState <= SMC_AXIS_STATE.errorstop OR was = SMC_AXIS_STATE.errorstop THEN
    since := scans;
END_IF
d := ax.fSetPosition - p;
IF ax.iMovementType = 0 THEN
    d := d - 360.0 * LREAL_TO_DINT(d / 360.0);
END_IF
IF scans > 15 AND scans - since > 3 THEN
    (* within a scan the velocity changes evenly, or has a peak *)
    jumpP := MAX(jumpP, ABS(d - (ax.fSetVelocity + v) * 0.0005) - 0.00051 * ABS(ax.fSetVelocity - v));
    IF ABS(ax.fActPosition - ax.fSetPosition) > 1E-6 AND ABS(ax.fActPosition - ax.fSetPosition) < 359.999 THEN
        wrong := 'the motor is somewhere else';
    END_IF
END_IF
p := ax.fSetPosition;
v := ax.fSetVelocity;
was := ax.nAxisState;
END_PROGRAM
"""


@pytest.mark.parametrize(("kind", "scale"), [(1, 1.0), (0, -2.5)], ids=["linear", "modulo"])
def test_random_programs_of_all_blocks_break_no_rule(kind, scale):
    plc = PLC.load(PROGRAM)
    plc["PLC_PRG.ax.iMovementType"], plc["PLC_PRG.ax.fScalefactor"] = kind, scale
    start_ = plc.snapshot()
    served = [0] * len(TAKES)
    for seed in range(3):
        plc.restore(start_)
        plc["seed"] = 7919 * seed + 1
        plc.scan(40_000)
        assert plc["PLC_PRG.wrong"] == "", f"seed {seed}"
        assert plc["PLC_PRG.jumpP"] < 0.01, f"seed {seed}"
        assert plc["PLC_PRG.commands"] > 700
        served = [a + b for a, b in zip(served, plc["PLC_PRG.served"], strict=True)]
    assert min(served) > 0, "a block was never served"

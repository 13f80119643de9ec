"""Random programs of overlapping commands, thousands of them in one call: the program draws block, inputs and pauses
itself and looks at the rules in every scan. Each seed is another run of the same compiled program."""

import pytest

from plcruntime import PLC

MOTION = {
    "first": "MC_MoveAbsolute", "second": "MC_MoveAbsolute", "third": "MC_MoveRelative", "additive": "MC_MoveAdditive",
    "velocity": "MC_MoveVelocity", "onward": "MC_MoveContinuousAbsolute", "further": "MC_MoveContinuousRelative",
    "over": "MC_MoveSuperImposed", "over2": "MC_MoveSuperImposed", "haltOver": "MC_HaltSuperimposed", "halt": "MC_Halt",
    "stop": "MC_Stop",
}  # fmt: skip
LINKS = {"gear": "MC_GearIn", "cam": "MC_CamIn", "phase": "MC_PhasingRelative"}
OWN = [n for n in (*MOTION, *LINKS) if n not in ("over", "over2", "haltOver", "phase")]  # those that own the axis
DONE = [n for n in MOTION if n not in ("velocity", "onward", "further")] + ["phase"]
INPUTS = {
    "Position": "draw(-400, 400)", "Distance": "draw(-200, 200)", "PhaseShift": "draw(-30, 30)",
    "Velocity": "draw(50, VMAX)", "VelocityDiff": "draw(20, VMAX)", "EndVelocity": "draw(-40, 40)",
    "Acceleration": "draw(1000, AMAX)", "Deceleration": "draw(1000, AMAX)", "Jerk": "jerk",
    "BufferMode": "REAL_TO_INT(LREAL_TO_REAL(draw(-0.5, 5.49)))", "ContinuousUpdate": "draw(0, 1) < 0.3",
}  # fmt: skip
MOVE = ("Velocity", "Acceleration", "Deceleration", "Jerk", "BufferMode", "ContinuousUpdate")
TAKES = {
    "first": ("Position", *MOVE), "second": ("Position", *MOVE), "third": ("Distance", *MOVE),
    "additive": ("Distance", *MOVE), "velocity": MOVE, "onward": ("Position", "EndVelocity", *MOVE),
    "further": ("Distance", "EndVelocity", *MOVE), "over": ("Distance", "VelocityDiff", *MOVE[1:4]),
    "over2": ("Distance", "VelocityDiff", *MOVE[1:4]), "haltOver": MOVE[2:4], "halt": (*MOVE[2:4], "BufferMode"),
    "stop": MOVE[2:4], "gear": MOVE[1:5], "cam": MOVE[1:5],
    "phase": ("PhaseShift", *MOVE[:4]),
}  # fmt: skip
EXTRA = {
    "velocity": "velocity.Direction := SEL(draw(0, 1) < 0.5, MC_DIRECTION.negative, MC_DIRECTION.positive);",
    "gear": "gear.RatioNumerator := SEL(draw(0, 1) < 0.5, -1, 1); gear.RatioDenominator := 2;",
    "cam": "cam.CamTableID := select.CamTableID; cam.StartMode := MC_START_MODE.ramp_in;"
    " cam.VelocityDiff := draw(50, 200);",
}
STEP = "\n".join(
    f"    {k}: {n}.Execute := FALSE; {n}({{call}});\n"
    + "".join(f"       {n}.{i} := {INPUTS[i]};" for i in TAKES[n])
    + f"\n       {EXTRA.get(n, '')} {n}.Execute := TRUE;"
    for k, n in enumerate(TAKES)
)
for name in TAKES:
    axes = "Master := master, Slave := ax" if name in LINKS else "Axis := ax"
    STEP = STEP.replace(f"{name}({{call}})", f"{name}({axes})")
CALLS = "".join(f"{n}(Axis := ax);\n" for n in MOTION)
CALLS += "".join(f"{n}(Master := master, Slave := ax);\n" for n in LINKS)
SERVED = "\n".join(
    f"    {k}: IF {n}.Error THEN refused := refused + 1; ELSE served[{k}] := served[{k}] + 1; END_IF"
    for k, n in enumerate(TAKES)
)


def outputs(name: str) -> str:
    names = ["Busy", "Error", "CommandAborted"] + (["Done"] if name in DONE else [])
    count = " + ".join(f"BOOL_TO_INT({name}.{o})" for o in names)
    never = f"IF {count} > 1 THEN wrong := '{name}: two outputs'; END_IF\n"
    if name in DONE:
        never += f"IF {name}.Execute AND {count} = 0 THEN wrong := '{name}: no output'; END_IF\n"
    return never


PROGRAM = f"""
VAR_GLOBAL seed : UDINT := 1; END_VAR
VAR_GLOBAL CONSTANT VMAX : LREAL := 1000; AMAX : LREAL := 8000; END_VAR

FUNCTION draw : LREAL
VAR_INPUT low, high : LREAL; END_VAR
seed := seed * 1664525 + 1013904223; (* modulo 2**32 *)
draw := low + (high - low) * UDINT_TO_LREAL(SHR(seed, 8)) / 16777216.0;
END_FUNCTION

PROGRAM PLC_PRG
VAR
    ax, master : AXIS_REF_SM3; power, power2 : MC_Power; run : MC_MoveVelocity;
    {"; ".join(f"{n} : {t}" for n, t in (MOTION | LINKS).items())};
    table : MC_CAM_REF; select : MC_CamTableSelect;
    left : DINT; commands, scans, refused : DINT; owners, which, i : INT;
    p, v, jerk, jumpP, jumpV, fastest : LREAL; wrong : STRING;
    served : ARRAY[0..{len(TAKES) - 1}] OF DINT; (* how often each block was started and not refused *)
END_VAR
power(Axis := ax, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
power2(Axis := master, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
run(Axis := master, Execute := power2.Status, Velocity := 200, Acceleration := 2000, Deceleration := 2000);
IF table.nElements = 0 THEN
    table.nElements := 3;
    table.Element[2].dX := 200; table.Element[2].dY := 40;
    table.Element[3].dX := 400;
END_IF
select(Master := master, Slave := ax, CamTable := table, Execute := power.Status);
scans := scans + 1;
left := left - 1;
IF scans > 10 AND left < 0 THEN
    stop.Execute := FALSE;
    which := REAL_TO_INT(LREAL_TO_REAL(draw(-0.49, {len(TAKES) - 1}.49)));
    IF which = {list(TAKES).index("stop")} AND (ax.nAxisState = SMC_AXIS_STATE.stopping OR draw(0, 1) < 0.7) THEN
        which := 0; (* a stop that is at work is not started anew *)
    END_IF
    jerk := SEL(draw(0, 1) < 0.6, 0.0, draw(20000, 400000));
    CASE which OF
{STEP}
    END_CASE
    commands := commands + 1;
    left := LREAL_TO_DINT(draw(0, 8) * draw(0, 8) * draw(0, 4)); (* mostly short, up to 256 scans *)
END_IF
{CALLS}
{"".join(outputs(n) for n in TAKES)}
owners := {" + ".join(f"BOOL_TO_INT({n}.Busy AND {n}.{'link.' if n in LINKS else ''}order.result = 0)" for n in OWN)};
IF owners > 1 THEN wrong := 'two owners'; END_IF
IF left >= 0 AND scans > 11 THEN
    CASE which OF
{SERVED}
    END_CASE
END_IF
IF ax.bError THEN wrong := 'errorstop'; END_IF
IF scans > 11 THEN
    jumpP := MAX(jumpP, ABS(ax.fSetPosition - p - (ax.fSetVelocity + v) * 0.0005));
    jumpV := MAX(jumpV, ABS(ax.fSetVelocity - v));
    fastest := MAX(fastest, ABS(ax.fSetVelocity));
END_IF
p := ax.fSetPosition; v := ax.fSetVelocity;
END_PROGRAM
"""


@pytest.mark.parametrize("seed", range(4))
def test_random_programs_break_no_rule(seed):
    plc = PLC.load(PROGRAM)
    plc["seed"] = 7919 * seed + 1
    plc.scan(100_000)
    assert plc["PLC_PRG.wrong"] == ""
    assert plc["PLC_PRG.commands"] > 2000
    assert min(plc["PLC_PRG.served"]) > 0, "a block was never served"
    # two motions at most are added: each with an acceleration of 8000 u/s2 over 1 ms, and its turn within a scan;
    # the curve of the cam has 231 u/s2 (5.77 * 40 u in a second)
    assert plc["PLC_PRG.jumpV"] <= 2 * 8.0 + 0.24
    assert plc["PLC_PRG.jumpP"] <= 2 * 8000 * 1e-6 / 4 * 1.01
    assert plc["PLC_PRG.fastest"] <= 3000.1

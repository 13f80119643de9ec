"""Blocks that never change the state of an axis (PLCopen Part 1, figure 2, the list below it): each in every state."""

import pytest

from plcruntime import PLC

EXECUTE = {
    "setPosition": ("MC_SetPosition", "Position := 5"),
    "probe": ("MC_TouchProbe", "TriggerInput := trigger"),
    "abort": ("MC_AbortTrigger", "TriggerInput := trigger"),
    "select": ("MC_CamTableSelect", ""),
    "phase": ("MC_PhasingAbsolute", "PhaseShift := 1, Velocity := 10, Acceleration := 1000, Deceleration := 1000"),
    "shift": ("MC_PhasingRelative", "PhaseShift := 1, Velocity := 10, Acceleration := 1000, Deceleration := 1000"),
    "haltOver": ("MC_HaltSuperimposed", "Deceleration := 1000"),
    "write": ("MC_WriteParameter", "ParameterNumber := 2, Value := 900"),
    "writeBool": ("MC_WriteBoolParameter", "ParameterNumber := 5, Value := FALSE"),
}
ENABLE = {
    "override": ("MC_SetOverride", "VelFactor := 0.9"),
    "cams": ("MC_DigitalCamSwitch", "Switches := switches, Outputs := outs, TrackOptions := tracks"),
    "read": ("MC_ReadParameter", "ParameterNumber := 1"),
    "readBool": ("MC_ReadBoolParameter", "ParameterNumber := 4"),
    "position": ("MC_ReadActualPosition", ""),
    "speed": ("MC_ReadActualVelocity", ""),
    "torque": ("MC_ReadActualTorque", ""),
    "status": ("MC_ReadStatus", ""),
    "fault": ("MC_ReadAxisError", ""),
    "info": ("MC_ReadAxisInfo", ""),
    "motion": ("MC_ReadMotionState", ""),
}
AXES = {"phase": "Master := master, Slave := ax", "shift": "Master := master, Slave := ax",
        "select": "Master := master, Slave := ax, CamTable := table"}  # fmt: skip
CALLS = "".join(
    f"{n}({AXES.get(n, 'Axis := ax')}{', ' if extra else ''}{extra});\n" for n, (_, extra) in (EXECUTE | ENABLE).items()
)
MOVE = "Velocity := 100, Acceleration := 1000, Deceleration := 1000"
PROGRAM = f"""
PROGRAM P
VAR
    ax, master : AXIS_REF_SM3; power, power2 : MC_Power; on : BOOL := TRUE;
    move : MC_MoveAbsolute; run : MC_MoveVelocity; stop : MC_Stop; gear : MC_GearIn; home : MC_Home;
    trigger : TRIGGER_REF := (iTriggerNumber := 0); table : MC_CAM_REF := (nElements := 2);
    switches : MC_CAMSWITCH_REF; outs : MC_OUTPUT_REF; tracks : MC_TRACK_REF;
    {" ".join(f"{n} : {block};" for n, (block, _) in (EXECUTE | ENABLE).items())}
END_VAR
table.Element[2].dX := 100;
power(Axis := ax, Enable := TRUE, bRegulatorOn := on, bDriveStart := TRUE);
power2(Axis := master, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
move(Axis := ax, Position := 1E6, {MOVE}); run(Axis := ax, {MOVE}); stop(Axis := ax, Deceleration := 100);
gear(Master := master, Slave := ax, Acceleration := 1000, Deceleration := 1000); home(Axis := ax);
{CALLS}
END_PROGRAM
"""
NUMBERS = {"power_off": 0, "errorstop": 1, "stopping": 2, "standstill": 3, "discrete": 4, "continuous": 5,
           "synchronized": 6, "homing": 7}  # fmt: skip
STARTS = {"discrete": ("move",), "continuous": ("run",), "stopping": ("run", "stop"), "synchronized": ("gear",),
          "homing": ("home",)}  # fmt: skip


def brought(state: str) -> PLC:
    """A PLC whose axis is in a state, and stays in it."""
    plc = PLC.load(PROGRAM)
    plc.scan(5)
    if state == "homing":
        plc["McHoming.Axis[1].drive.home.method"] = 17
    for block in STARTS.get(state, ()):
        plc[f"P.{block}.Execute"] = True
        plc.scan(50)
    if state == "power_off":
        plc["P.on"] = False
    plc.axes[1].drive.alarm = state == "errorstop"
    plc.scan(3)
    assert plc["P.ax.nAxisState"] == NUMBERS[state]
    return plc


@pytest.mark.parametrize("state", NUMBERS)
def test_no_state_is_left(state):
    plc = brought(state)
    start = plc.snapshot()
    for block in EXECUTE | ENABLE:
        plc.restore(start)
        plc[f"P.{block}.{'Execute' if block in EXECUTE else 'Enable'}"] = True
        for _ in range(4):
            plc.scan()
            assert plc["P.ax.nAxisState"] == NUMBERS[state], block
        members = plc[f"P.{block}"]
        said = [o for o in ("Done", "Busy", "Error") if members.get(o)]
        assert len(said) == 1, (block, said)
        if block in ENABLE and not members["Error"]:
            assert members.get("Valid", True) and members.get("Enabled", True), block


def test_what_is_read_is_what_the_axis_has():
    plc = brought("continuous")
    plc.axes[1].drive.lag = 20.0
    for block in ENABLE:
        plc[f"P.{block}.Enable"] = True
    for _ in range(30):
        before = {m: plc[f"P.ax.{m}"] for m in ("fSetPosition", "fActPosition", "fActVelocity", "fActTorque")}
        plc.scan()
        assert plc["P.read.Value"] == before["fSetPosition"]
        assert plc["P.position.Position"] == before["fActPosition"]
        assert plc["P.speed.Velocity"] == before["fActVelocity"]
        assert plc["P.torque.Torque"] == before["fActTorque"]
    assert abs(before["fSetPosition"] - before["fActPosition"]) > 0.1  # the motor does lag
    assert plc["P.status.ContinuousMotion"] and plc["P.motion.DirectionPositive"] and plc["P.info.PowerOn"]
    plc["P.ax.bSWLimitEnable"] = True
    plc["P.ax.fSWLimitPositive"] = 1e6
    plc.scan()
    assert plc["P.readBool.Value"]
    plc["P.writeBool.Execute"] = True
    plc.scan()
    assert plc["P.writeBool.Done"] and not plc["P.ax.bSWLimitEnable"]


QUEUED = {
    "place": ("MC_SetPosition", "Axis := ax, Position := 7"),
    "limit": ("MC_WriteParameter", "Axis := ax, ParameterNumber := 2, Value := 900"),
    "on": ("MC_WriteBoolParameter", "Axis := ax, ParameterNumber := 4, Value := TRUE"),
    "light": ("MC_WriteDigitalOutput", "Output := outs, OutputNumber := 3, Value := TRUE"),
    "select": ("MC_CamTableSelect", "Master := master, Slave := ax, CamTable := table"),
}
WAITING = f"""
PROGRAM P
VAR
    ax, master : AXIS_REF_SM3; power : MC_Power; move, next : MC_MoveAbsolute; run : MC_MoveVelocity; jog : MC_Jog;
    table : MC_CAM_REF := (nElements := 2); outs : MC_OUTPUT_REF; go, follow : BOOL;
    {" ".join(f"{n} : {block};" for n, (block, _) in QUEUED.items())}
END_VAR
table.Element[2].dX := 100;
outs.Axis := ADR(ax);
power(Axis := ax, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
move(Axis := ax, Position := 10, {MOVE}); next(Axis := ax, Position := 20, BufferMode := mcBuffered, {MOVE});
run(Axis := ax, {MOVE}); jog(Axis := ax, {MOVE});
{"".join(f"{n}({call}, Execute := go, ExecutionMode := mcQueued);" for n, (_, call) in QUEUED.items())}
END_PROGRAM
"""


@pytest.fixture
def waiting():
    plc = PLC.load(WAITING)
    plc.scan(5)
    return plc


def outputs(plc, name: str) -> set:
    return {plc[f"P.{block}.{name}"] for block in QUEUED}


def test_what_is_queued_waits_for_the_commands_before_it(waiting):
    waiting["P.move.Execute"] = waiting["P.next.Execute"] = True
    waiting.scan()
    waiting["P.go"] = True
    waiting.scan()
    waiting["P.go"] = False  # it waits on
    waiting["P.limit.Value"] = 1.0
    waiting.run_until("P.ax.fSetPosition = 20.0")
    assert outputs(waiting, "Busy") == {True} and outputs(waiting, "Done") == {False}
    assert waiting["P.ax.fSetPosition"] == 20.0 and waiting["P.outs.Values"] == 0
    waiting.scan()
    assert outputs(waiting, "Busy") == {False} and outputs(waiting, "Done") == {True}
    assert waiting["P.ax.fSetPosition"] == 7.0 and waiting["P.ax.fSWLimitPositive"] == 900.0
    assert waiting["P.ax.bSWLimitEnable"] and waiting["P.outs.Values"] == 8 and waiting["P.select.CamTableID.pCT"]
    waiting.scan()
    assert outputs(waiting, "Done") == {False}


@pytest.mark.parametrize("before", ["rest", "aborted", "jog"])
def test_what_is_queued_waits_no_longer_than_for_those(waiting, before):
    if before == "aborted":
        waiting["P.run.Execute"] = True
    elif before == "jog":
        waiting["P.jog.JogForward"] = True
    waiting.scan(50)
    waiting["P.go"] = True
    waiting.scan(2)
    assert outputs(waiting, "Done") == {before == "rest"}
    waiting.scan(200)
    assert outputs(waiting, "Done") == {before == "rest"}
    waiting["P.jog.JogForward"] = False
    waiting["P.move.Execute"] = before == "aborted"
    waiting.scan(2 if before == "aborted" else 150)
    assert outputs(waiting, "Done") == {True}


@pytest.mark.parametrize("mode", ["mcAborting", "mcBuffered"])
def test_a_block_that_is_called_with_another_axis_meanwhile(mode):
    """One instance for two axes, in a loop: the second one is an error, and the first axis misses its block."""
    plc = PLC.load(f"""
PROGRAM P
VAR
    ax : ARRAY[1..2] OF AXIS_REF_SM3; power : ARRAY[1..2] OF MC_Power; first : MC_MoveVelocity; move : MC_MoveAbsolute;
    i : INT; go : BOOL; way : LREAL;
END_VAR
FOR i := 1 TO 2 DO
    power[i](Axis := ax[i], Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
END_FOR
first(Axis := ax[1], Execute := {mode} = mcBuffered AND power[1].Status, {MOVE});
FOR i := 1 TO 2 DO
    move(Axis := ax[i], Execute := go, BufferMode := {mode}, Position := 100, {MOVE});
END_FOR
END_PROGRAM
""")
    plc.scan(5)
    plc["P.go"] = True
    plc.scan()
    assert plc["P.move.ErrorID"] == 32 and not plc["P.move.Busy"]  # SMC_AXIS_REF_CHANGED_DURING_OPERATION
    plc.scan(200)
    assert plc["P.ax[2].fSetPosition"] == 0.0 and plc["P.ax[2].nAxisState"] == 3
    # what was running is an error of its axis, too; what waited does not wait any more
    assert plc["P.ax[1].dwErrorID"] == (32 if mode == "mcAborting" else 0)
    plc["P.go"] = False
    plc.scan(2)
    assert not plc["P.move.Error"]


def test_a_block_that_is_started_for_another_axis_meanwhile():
    plc = PLC.load(f"""
PROGRAM P
VAR
    a, b : AXIS_REF_SM3; powerA, powerB : MC_Power; move : MC_MoveAbsolute; step : INT;
END_VAR
powerA(Axis := a, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
powerB(Axis := b, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
IF powerB.Status THEN
    step := step + 1;
END_IF
IF step < 20 THEN
    move(Axis := a, Execute := powerA.Status, Position := 100, {MOVE});
ELSE
    move(Axis := a, Execute := FALSE);
    move(Axis := b, Execute := TRUE, Position := 50, {MOVE});
END_IF
END_PROGRAM
""")
    plc.scan(1000)
    assert plc["P.a.dwErrorID"] == 32 and 0.0 < plc["P.a.fSetPosition"] < 10.0

"""The state diagram (PLCopen Part 1, figure 2): each state and each block that may move an axis."""

import random

import pytest

from plcruntime import PLC

NOT_READY, NOT_STANDSTILL, IN_ERRORSTOP = 34, 170, 174


def power_off(bench):
    bench["power.bRegulatorOn"] = False
    bench.scan()


def errorstop(bench):
    bench["calm"] = False
    bench.plc.axes[1].drive.alarm = True
    bench.scan(2)
    bench.plc.axes[1].drive.alarm = False
    bench.scan()


def stopping(bench):
    bench.start("velocity", 50)
    bench.start("stop", 2)


def standstill(bench):
    pass


def discrete(bench):
    bench.start("third", 50, Position=500.0)


def continuous(bench):
    bench.start("velocity", 50)


def synchronized(bench):
    bench.start("gear", 20)


def homing(bench):
    bench.plc["McHoming.Axis[1].drive.home.method"] = 17
    bench["calm"] = False  # the drive's own motion
    bench.start("home", 5)


BEFORE = (power_off, errorstop, stopping, standstill, discrete, continuous, synchronized, homing)
MOTION = {
    "first": ("discrete", {"Position": 900.0}),
    "relative": ("discrete", {"Distance": 300.0}),
    "additive": ("discrete", {"Distance": 300.0}),
    "velocity": ("continuous", {"Velocity": 300.0}),
    "onward": ("continuous", {"Position": 900.0, "EndVelocity": 100.0}),
    "further": ("continuous", {"Distance": 900.0, "EndVelocity": 100.0}),
    "smcOnward": ("discrete", {"Distance": 900.0, "EndVelocity": 100.0}),
    "smcFurther": ("discrete", {"Distance": 900.0, "EndVelocity": 100.0}),
    "torque": ("continuous", {"Torque": 0.01, "TorqueRamp": 1.0, "Velocity": 500.0}),
    "gear": ("synchronized", {}),
    "meet": ("synchronized", {"MasterSyncPosition": 100.0, "MasterStartDistance": 10.0}),
    "combine": ("synchronized", {}),
    "halt": ("discrete", {}),
    "stop": ("stopping", {}),
    "home": ("homing", {}),
    "over": (None, {"Distance": 100.0, "VelocityDiff": 100.0}),
    "positions": ("discrete", {"ArraySize": 1}),
    "velocities": ("discrete", {"ArraySize": 1}),
    "accelerations": ("discrete", {"ArraySize": 1}),
    "cam": ("synchronized", {"StartMode": 2, "VelocityDiff": 100.0}),
    "gearOut": ("continuous", {}),
    "camOut": ("continuous", {}),
    "jog": ("continuous", {}),
    "inch": ("discrete", {"Distance": 300.0}),
    "smcHome": (
        "homing",
        {"fVelocityFast": 100.0, "fVelocitySlow": 10.0, "fAcceleration": 1e3, "fDeceleration": 1e3,
         "bReferenceSwitch": True},
    ),
}  # fmt: skip


def prepare(bench):
    """The tables that some blocks need."""
    bench.fill_tables(2.0)
    bench["positionsTable.MC_TP_Array[1].position"] = 900.0
    bench["velocitiesTable.MC_TV_Array[1].velocity"] = 300.0
    bench["accelerationsTable.MC_TA_Array[1].acceleration"] = 300.0


def expected(block: str, was: str) -> tuple[str, int, str]:
    """The output, the error number and the state after the block's rising edge."""
    state = MOTION[block][0]
    if was == "power_off":
        return "Error", NOT_READY, was
    if was == "errorstop":
        return "Error", {"stop": 183, "home": IN_ERRORSTOP, "smcHome": IN_ERRORSTOP}.get(block, NOT_READY), was
    if was == "stopping":
        return ("Error", 183, "errorstop") if block == "stop" else ("Error", NOT_READY, was)
    if block == "stop":
        return "Busy", 0, "stopping"
    if was == "homing":
        return "Error", NOT_READY, was
    if block in ("gearOut", "camOut"):
        return ("Done", 0, state) if was == "synchronized" else ("Error", NOT_READY, was)
    if block in ("home", "smcHome") and was != "standstill":
        return "Error", NOT_STANDSTILL, was
    if block == "halt" and was == "standstill":
        return "Done", 0, was
    if block == "home" or (block, was) == ("halt", "synchronized"):
        # over in the same scan: the drive homes where it stands, the slave's master rests
        return "Busy", 0, "standstill"
    return "Busy", 0, state or ("discrete" if was == "standstill" else was)


@pytest.mark.parametrize("before", BEFORE, ids=lambda f: f.__name__)
def test_each_block_in_this_state(bench, before):
    prepare(bench)
    before(bench)
    was = before.__name__
    assert bench.state == was
    snapshot = bench.plc.snapshot()
    found = {}
    for block, (_, inputs) in MOTION.items():
        bench.plc.restore(snapshot)
        if (block, was) == ("stop", "stopping"):
            bench["stop.Execute"] = False  # the same block again
            bench["calm"] = False
            bench.scan()
        bench.start(block, **inputs)
        found[block] = (bench.outputs(block), bench[f"{block}.ErrorID"], bench.state)
    assert found == {block: expected(block, was) for block in MOTION}


@pytest.mark.parametrize("before", BEFORE, ids=lambda f: f.__name__)
def test_power_off_ends_everything(bench, before):
    before(bench)
    bench["calm"] = False
    bench["power.bRegulatorOn"] = False
    bench.scan(2)
    assert bench.state == ("errorstop" if before is errorstop else "power_off")
    for block in ("third", "velocity", "gear", "home", "stop"):
        assert not bench[f"{block}.Busy"], block


def test_stop_is_kept_until_execute_falls_and_shows_active(bench):
    continuous(bench)
    bench.start("stop", 200)
    assert bench["stop.Done"] and bench["stop.Active"] and bench.state == "stopping"
    bench["stop.Execute"] = False
    bench.scan()
    assert bench.state == "standstill" and not bench["stop.Active"]
    bench.profile("positions", [(100, 10.0)])
    assert bench.state == "discrete"


def test_a_block_may_be_called_by_a_slower_task():
    text = """
PROGRAM Fast VAR n : INT; END_VAR n := n + 1; END_PROGRAM
PROGRAM Slow VAR ax : AXIS_REF_SM3; power : MC_Power; move : MC_MoveAbsolute; stay : BOOL; END_VAR
power(Axis := ax, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
IF NOT stay THEN
    move(Axis := ax, Execute := power.Status, Position := 100, Velocity := 100, Acceleration := 1000,
        Deceleration := 1000);
END_IF
END_PROGRAM
CONFIGURATION plant
  VAR_GLOBAL unused : INT; END_VAR
  RESOURCE cpu ON PLC
    TASK quick (INTERVAL := T#1ms, PRIORITY := 1);
    TASK slow (INTERVAL := T#4ms, PRIORITY := 2);
    PROGRAM p1 WITH quick : Fast;
    PROGRAM p2 WITH slow : Slow;
  END_RESOURCE
END_CONFIGURATION
"""
    plc = PLC.load(text)
    plc.scan(1200)
    assert plc["Slow.ax.fSetPosition"] == 100.0 and plc["Slow.move.Done"]
    plc = PLC.load(text)
    plc.scan(200)
    plc["Slow.stay"] = True
    plc.scan(8)
    assert plc["Slow.ax.dwErrorID"] == 30


def test_random_commands_with_buffers_and_superimposed_motion(bench):
    """Whatever is commanded: no jump, one owner, one output a block; in the end the axis comes to rest."""
    rng = random.Random(6)
    blocks = (
        "first", "second", "third", "relative", "additive", "velocity", "onward", "further", "halt", "over", "over2",
        "haltOver", "gear", "phase",
    )  # fmt: skip
    bench.start("run", Velocity=300.0, Acceleration=2000.0, Deceleration=2000.0)
    for _ in range(400):
        block = rng.choice(blocks)
        inputs = {
            "Velocity": rng.uniform(50, 1000), "VelocityDiff": rng.uniform(20, 300), "BufferMode": rng.randrange(6),
            "Acceleration": rng.uniform(1000, 8000), "Deceleration": rng.uniform(1000, 8000),
            "Jerk": rng.choice([0.0, 50000.0, 500000.0]), "Position": rng.uniform(-500, 500),
            "Distance": rng.uniform(-300, 300), "EndVelocity": rng.uniform(-50, 50), "PhaseShift": rng.uniform(-50, 50),
            "Direction": rng.choice([-1, 1, 2]), "ContinuousUpdate": rng.random() < 0.3,
        }  # fmt: skip
        members = bench[block]
        bench.start(block, **{n: v for n, v in inputs.items() if n in members})
        assert bench.outputs(block) in ("Busy", "Done") or bench[f"{block}.ErrorID"] in (34, 278), block
        if rng.random() < 0.2:
            bench["override.VelFactor"] = rng.choice([0.0, 0.3, 1.0])
            bench["override.Enable"] = True
        bench.scan(rng.choice([1, 5, 40, 200]))
        assert bench["jumpP"] < 0.02
    bench["override.VelFactor"] = 1.0
    bench.start("stop", 2000)
    assert bench["stop.Done"] and bench["ax.fSetVelocity"] == 0.0

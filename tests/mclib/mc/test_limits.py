"""Values out of range, and the limits of an axis: Error and ErrorID by the manual's rule, and nothing moves."""

import pytest

from tests.mclib.mc.conftest import INPUTS

MOVE = {"Velocity": 100.0, "Acceleration": 1000.0, "Deceleration": 1000.0, "Jerk": 0.0}
# block -> inputs beside MOVE, ErrorID of a wrong value
BLOCKS = {
    "first": ({"Position": 100.0}, 201), "relative": ({"Distance": 100.0}, 226), "additive": ({"Distance": 100.0}, 251),
    "over": ({"Distance": 100.0}, 276), "velocity": ({}, 301),
    "onward": ({"Position": 100.0}, 451), "further": ({"Distance": 100.0}, 426),
    "smcOnward": ({"Distance": 100.0}, 451), "smcFurther": ({"Distance": 100.0}, 426),
}  # fmt: skip
# MC_MoveVelocity takes any velocity
WRONG = [
    (block, name, value)
    for block in BLOCKS
    for name in ("Velocity", "Acceleration", "Deceleration", "Jerk")
    for value in (0.0, -1.0, float("nan"))
    if not (name == "Jerk" and value == 0.0) and not (name == "Velocity" and block == "velocity" and value == value)
]
REFUSED_AS_DISCRETE = {"first", "relative", "additive", "onward", "further", "smcOnward", "smcFurther"}


def inputs_of(block: str, **changed) -> dict:
    """Everything that a block takes, with some values changed; MC_MoveSuperImposed calls its velocity VelocityDiff."""
    inputs = MOVE | BLOCKS[block][0] | changed
    if block == "over":
        inputs["VelocityDiff"] = inputs.pop("Velocity")
    return inputs


@pytest.fixture(scope="module")
def shared():
    from tests.mclib.mc.conftest import Bench

    bench = Bench()
    return bench, bench.plc.snapshot()


@pytest.fixture
def ready(shared):
    bench, start = shared
    bench.plc.restore(start)
    return bench


@pytest.mark.parametrize(("block", "name", "value"), WRONG)
def test_a_wrong_value(ready, block, name, value):
    ready.start(block, **inputs_of(block, **{name: value}))
    assert (ready.outputs(block), ready[f"{block}.ErrorID"]) == ("Error", BLOCKS[block][1])
    assert ready.state == ("discrete" if block in REFUSED_AS_DISCRETE else "standstill")
    ready.scan(20)
    assert ready["ax.fSetPosition"] == 0.0 and ready["ax.fSetVelocity"] == 0.0
    ready[f"{block}.Execute"] = False
    ready.scan()
    assert ready.state == "standstill" and ready.outputs(block) == "" and ready[f"{block}.ErrorID"] == 0
    ready.start(block, **inputs_of(block))
    assert ready.outputs(block) == "Busy"


@pytest.mark.parametrize("block", ["halt", "stop"])
@pytest.mark.parametrize(("name", "value"), [("Deceleration", 0.0), ("Deceleration", -1.0), ("Jerk", -1.0)])
def test_a_wrong_stop_leaves_the_motion_as_it_is(ready, block, name, value):
    ready.start("velocity", 200, **MOVE)
    ready.start(block, **{"Deceleration": 1000.0, name: value})
    assert ready[f"{block}.Error"] and ready[f"{block}.ErrorID"] == 181
    ready.scan(10)
    assert ready.state == "continuous" and ready["ax.fSetVelocity"] == 100.0 and ready["velocity.Busy"]


@pytest.mark.parametrize("block", ["first", "relative", "additive", "onward", "further", "over"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_target_beyond_the_software_limit(ready, block, sign):
    ready["ax.bSWLimitEnable"] = True
    ready["ax.fSWLimitPositive"], ready["ax.fSWLimitNegative"] = 50.0, -50.0
    way = "Position" if block in ("first", "onward") else "Distance"
    ready.start(block, **inputs_of(block, **{way: sign * 50.001}))
    assert (ready.outputs(block), ready[f"{block}.ErrorID"]) == ("Error", 10)
    ready.scan(20)
    assert ready["ax.fSetPosition"] == 0.0 and ready.state == "standstill"
    if block not in ("onward", "further"):
        ready.start(block, **inputs_of(block, **{way: sign * 50.0}))
        ready.until(f"{block}.Done")
        assert ready["ax.fSetPosition"] == sign * 50.0


def test_a_velocity_runs_to_the_limit_and_stops(ready):
    ready["ax.bSWLimitEnable"] = True
    ready["ax.fSWLimitPositive"], ready["ax.fSWLimitNegative"] = 50.0, -50.0
    ready["calm"] = False
    ready.start("velocity", 800, **MOVE)
    assert ready["velocity.Error"] and ready["velocity.ErrorID"] == 10 and ready.state == "errorstop"
    assert 50.0 < ready["ax.fSetPosition"] < 50.2


def test_a_profile_beyond_the_software_limit(ready):
    ready["ax.bSWLimitEnable"] = True
    ready["ax.fSWLimitPositive"], ready["ax.fSWLimitNegative"] = 50.0, -50.0
    ready.profile("positions", [(1000, 10.0), (1000, 60.0), (1000, 0.0)])
    assert ready["positions.ErrorID"] == 10 and ready.state == "standstill"
    ready.profile("positions", [(1000, 10.0), (1000, 50.0), (1000, 0.0)])
    ready.until("positions.Done")


@pytest.mark.parametrize(("table", "size", "step"), [("positions", 325, 326), ("velocities", 350, 351),
                                                     ("accelerations", 375, 376)])  # fmt: skip
def test_tables(ready, table, size, step):
    pairs = [(10, 0.0)] * 100
    ready.profile(table, pairs)
    assert ready[f"{table}.Busy"]
    ready.until(f"{table}.Done")
    for points in (101, 0, -1, 32767):
        ready.start(table, ArraySize=points)
        assert ready[f"{table}.ErrorID"] == size and ready.state == "standstill", points
    ready[f"{table}Table.Number_of_pairs"] = 5
    ready.start(table, ArraySize=6)
    assert ready[f"{table}.ErrorID"] == size
    ready[f"{table}Table.MC_T{table[0].upper()}_Array[3].delta_time"] = 0
    ready.start(table, ArraySize=5)
    assert ready[f"{table}.ErrorID"] == step and ready["ax.fSetPosition"] == 0.0


def test_what_is_asked_for_is_cut_to_the_limits_of_the_axis(ready):
    ready["ax.fSWMaxVelocity"], ready["ax.fSWMaxAcceleration"] = 50.0, 200.0
    ready["ax.fSWMaxDeceleration"] = 400.0
    ready["jumpV"] = 0.0
    ready.start("first", Position=100.0, **MOVE)
    # 50 / 200 s to speed, 50 / 400 s to rest, the rest of the way with 50 u/s
    assert ready.until("first.Done") == pytest.approx(250 + 125 + (100 - 6.25 - 3.125) / 50 * 1000, abs=2)
    assert ready["fastest"] <= 50.0 and ready["jumpV"] <= 0.4001
    ready.start("velocity", 400, **MOVE)
    assert ready["velocity.InVelocity"] and ready["ax.fSetVelocity"] == 50.0


def test_blocks_on_an_axis_that_is_off_or_faulted(ready):
    ready["calm"] = False
    ready.plc.axes[1].drive.alarm = True
    ready.scan(3)
    for block in BLOCKS:
        ready.start(block, **inputs_of(block))
        assert (ready.outputs(block), ready[f"{block}.ErrorID"], ready.state) == ("Error", 34, "errorstop")
        ready[f"{block}.Execute"] = False
    ready.plc.axes[1].drive.alarm = False
    ready["power.bRegulatorOn"] = False
    ready.start("reset", 3)
    assert ready["reset.Done"] and ready.state == "power_off"
    for block in BLOCKS:
        ready.start(block, **inputs_of(block))
        assert (ready.outputs(block), ready[f"{block}.ErrorID"], ready.state) == ("Error", 34, "power_off")
    assert ready["ax.fSetPosition"] == 0.0


@pytest.mark.parametrize("direction", ["Positive", "Negative"])
def test_a_direction_that_is_not_enabled(bench, direction):
    sign = 1.0 if direction == "Positive" else -1.0
    assert bench["power.Valid"]
    bench[f"power.Enable{direction}"] = False
    bench["calm"] = False
    bench.start("velocity", 100, Velocity=-sign * 100.0, Direction=1)  # the other way
    assert bench["velocity.InVelocity"]
    bench.start("velocity", 30, Velocity=sign * 100.0)
    assert bench["velocity.ErrorID"] == 20 and bench.state == "errorstop"
    assert bench["power.ErrorID"] == 20 and not bench["power.Valid"]
    bench.start("reset", 3)
    bench[f"power.Enable{direction}"] = True
    bench.start("velocity", 150)
    assert bench["velocity.InVelocity"]


BARRED = {
    "first": {"Position": 100.0}, "velocity": {"Velocity": 100.0}, "torque": {"Torque": 0.01, "Velocity": 100.0},
    "jog": {}, "over": {"Distance": 100.0}, "gear": {}, "positions": {"ArraySize": 1},
    "smcHome": {"fVelocityFast": 100.0, "fVelocitySlow": 10.0, "fAcceleration": 1e3, "fDeceleration": 1e3,
                "bReferenceSwitch": True},
}  # fmt: skip


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_nothing_moves_where_it_is_not_enabled(ready, sign):
    """With the units turned round what was backwards is the positive direction."""
    ready["ax.fScalefactor"] = sign
    ready["power.bRegulatorOn"] = False
    ready.scan()
    ready["power.bRegulatorOn"] = True
    ready["power.EnablePositive"] = False
    ready.scan(3)
    ready["positionsTable.MC_TP_Array[1]"] = {"delta_time": 1.0, "position": 100.0}
    ready["smcHome.nDirection"] = 1
    ready.start("run", 200, Velocity=100.0, Acceleration=1000.0, Deceleration=1000.0)
    snapshot = ready.plc.snapshot()
    for block, inputs in BARRED.items():
        ready.plc.restore(snapshot)
        ready["calm"] = False
        ready.start(block, 3, **inputs)
        place = (ready["ax.fSetPosition"], ready["ax.fActPosition"], ready["ax.fSetVelocity"])
        assert place == (0.0, 0.0, 0.0), block
        assert ready.state == "errorstop" and ready[f"{block}.Error"] and ready["ax.dwErrorID"] == 20, block
        ready[f"{block}.{INPUTS.get(block, 'Execute')}"] = False
        ready.start("reset", 3)
        assert ready.state == "standstill", block
        ready.start("velocity", 100, Velocity=-100.0, Direction=1)
        assert ready["velocity.InVelocity"], block
        here = ready["ax.fSetPosition"]
        ready.start("first", 200, Position=here + 100.0)
        assert ready.state == "errorstop" and here - 1.0 < ready["ax.fSetPosition"] < here, block  # it turns no further


WRONG_AGAIN = [
    ("first", {"Position": 500.0}, {"Position": 5000.0}, 500.0),
    ("relative", {"Distance": 500.0}, {"Distance": 5000.0}, 500.0),
    ("onward", {"Position": 100.0, "EndVelocity": 50.0}, {"EndVelocity": float("nan")}, 0.0),
    ("further", {"Distance": 100.0, "EndVelocity": 50.0}, {"Distance": 5000.0}, 0.0),
    ("smcOnward", {"Distance": 100.0, "EndVelocity": 50.0}, {"EndVelocityDirection": 0}, 0.0),
    ("positions", {"ArraySize": 1}, {"PositionScale": 50.0}, 500.0),
]


@pytest.mark.parametrize(("block", "inputs", "wrong", "end"), WRONG_AGAIN, ids=[w[0] for w in WRONG_AGAIN])
def test_a_running_block_started_anew_with_wrong_values_goes_on_as_it_was(ready, block, inputs, wrong, end):
    """A replan afterwards still has the first values: 500 u, or 50 u/s behind the target."""
    ready["ax.bSWLimitEnable"], ready["ax.fSWLimitPositive"] = True, 1000.0
    ready["positionsTable.MC_TP_Array[1]"] = {"delta_time": 0.8, "position": 500.0}
    ready["override.Enable"] = True
    ready.start(block, 150, **inputs)
    ready.start(block, 5, **wrong)
    assert ready.outputs(block) == "Error"
    ready["override.VelFactor"] = 0.5
    ready.scan(20)
    ready["override.VelFactor"] = 1.0
    ready.scan(1500)
    assert ready["ax.fSetVelocity"] == (0.0 if end else 50.0)
    assert ready.state == ("standstill" if end else "continuous")
    assert not end or ready["ax.fSetPosition"] == pytest.approx(end)

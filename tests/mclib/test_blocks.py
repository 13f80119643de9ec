"""MC_ blocks on one axis: states, outputs, aborts, errors. After every scan conftest checks PLCopen Part 1's rules."""

import math
import random

import pytest

MOVE = {"Velocity": 1000.0, "Acceleration": 10000.0, "Deceleration": 10000.0, "Jerk": 0.0}  # 0.1 s to full speed
ERRORS = {"NOT_READY": 34, "MA": 201, "MR": 226, "MAD": 251, "MV": 301, "MS": 181, "ERRORSTOP": 183}


def test_power_takes_one_scan_and_shows_busy(bench):
    assert bench["ax.nAxisState"] == 0
    for name in ("Enable", "bRegulatorOn", "bDriveStart"):
        bench[f"power.{name}"] = True
    bench.scan()
    assert bench["power.Busy"] and not bench["power.Status"] and bench.state == "Disabled"
    bench.scan()
    assert bench["power.Status"] and not bench["power.Busy"]
    assert bench.state == "StandStill" and bench["ax.nAxisState"] == 3
    assert bench["power.bRegulatorRealState"] and bench["power.bDriveStartRealState"]
    bench["power.bRegulatorOn"] = False
    bench.scan()
    assert bench.state == "Disabled" and not bench["power.Status"]


def test_absolute_move_takes_the_closed_form_and_ends_exactly(bench):
    bench.power()
    bench.start("absolute", Position=500.0, **MOVE)
    assert bench["absolute.Busy"] and bench.state == "DiscreteMotion"
    scans = bench.until("absolute.Done")
    # trapezoid: 0.1 s + 0.4 s + 0.1 s; Done is seen in the scan at that time, the first one was the start
    assert scans == 600 - 1 + 1
    assert bench["ax.fSetPosition"] == 500.0 and bench["ax.fActPosition"] == 500.0
    assert bench.state == "StandStill"
    bench.scan()
    assert bench["absolute.Done"]
    bench["absolute.Execute"] = False
    bench.scan()
    assert not bench["absolute.Done"]


def test_jerk_limited_move_takes_the_closed_form(bench):
    bench.power()
    bench.start("absolute", Position=500.0, **{**MOVE, "Jerk": 200000.0})
    # each ramp is longer by acceleration / jerk = 0.05 s: 0.15 + 0.15 s with half of 1000 u/s, 350 u left
    scans = bench.until("absolute.Done")
    assert scans == 650


def test_done_lasts_one_scan_when_execute_has_fallen(bench):
    bench.power()
    bench.start("absolute", Position=10.0, **MOVE)
    bench["absolute.Execute"] = False
    bench.until("absolute.Done")
    bench.scan()
    assert not bench["absolute.Done"] and not bench["absolute.Busy"]
    assert bench["ax.fSetPosition"] == 10.0


def test_retrigger_takes_new_values_without_an_abort(bench):
    bench.power()
    bench.start("absolute", Position=500.0, **MOVE)
    bench.scan(50)
    bench["absolute.Execute"] = False
    bench.scan()
    bench.start("absolute", Position=100.0)
    assert bench["absolute.Busy"] and not bench["absolute.CommandAborted"]
    bench.until("absolute.Done")
    assert bench["ax.fSetPosition"] == 100.0


def test_a_second_move_aborts_the_first(bench):
    bench.power()
    bench.start("absolute", Position=500.0, **MOVE)
    bench.scan(150)
    bench.start("second", Position=-200.0, **MOVE)
    bench.scan()
    assert bench["absolute.CommandAborted"] and not bench["absolute.Busy"] and bench["second.Busy"]
    bench.until("second.Done")
    assert bench["ax.fSetPosition"] == -200.0


def test_relative_and_additive(bench):
    bench.power()
    bench.start("relative", Distance=100.0, **MOVE)
    bench.until("relative.Done")
    assert bench["ax.fSetPosition"] == 100.0
    bench.start("absolute", Position=500.0, **MOVE)
    bench.scan(20)
    bench.start("additive", Distance=50.0, **MOVE)  # from the end of the move that it takes over
    bench.until("additive.Done")
    assert bench["ax.fSetPosition"] == 550.0


@pytest.mark.parametrize(
    ("speed", "direction", "final"), [(800.0, 1, 800.0), (800.0, -1, -800.0), (-800.0, -1, 800.0), (-800.0, 2, -800.0)]
)
def test_velocity_and_direction(bench, speed, direction, final):
    bench.power()
    bench.start("velocity", **{**MOVE, "Velocity": speed}, Direction=direction)
    assert bench.state == "ContinuousMotion" and bench["velocity.Busy"]
    bench.until("velocity.InVelocity")
    assert bench["ax.fSetVelocity"] == pytest.approx(final)
    bench.scan(100)
    assert bench["velocity.InVelocity"] and bench["status.ConstantVelocity"]
    bench.start("halt", Deceleration=10000.0)
    assert bench["status.DiscreteMotion"]
    bench.scan()
    assert bench["velocity.CommandAborted"] and not bench["velocity.InVelocity"] and bench["status.Decelerating"]
    bench.until("halt.Done")
    assert bench.state == "StandStill" and bench["ax.fSetVelocity"] == 0.0


def test_halt_may_be_taken_over(bench):
    bench.power()
    bench.start("velocity", **MOVE)
    bench.until("velocity.InVelocity")
    bench.start("halt", Deceleration=1000.0)
    bench.scan(10)
    bench.start("absolute", Position=1000.0, **MOVE)
    bench.scan()
    assert bench["halt.CommandAborted"]
    bench.until("absolute.Done")
    assert bench["ax.fSetPosition"] == 1000.0


def test_stop_locks_the_axis_until_execute_falls(bench):
    bench.power()
    bench.start("velocity", **MOVE)
    bench.until("velocity.InVelocity")
    bench.start("stop", Deceleration=10000.0)
    assert bench.state == "Stopping"
    bench.start("absolute", Position=5.0, **MOVE)
    assert bench["absolute.Error"] and bench["absolute.ErrorID"] == ERRORS["NOT_READY"]
    bench.until("stop.Done")
    bench.scan(50)
    assert bench.state == "Stopping" and bench["ax.fSetVelocity"] == 0.0
    bench["absolute.Execute"] = False
    bench.scan()
    bench.start("absolute")
    assert bench["absolute.Error"]
    bench["stop.Execute"] = False
    bench.scan()
    assert bench.state == "StandStill"
    bench["absolute.Execute"] = False
    bench.scan()
    bench.start("absolute")
    assert bench["absolute.Busy"]


def test_stop_at_standstill_is_stopping_too(bench):
    bench.power()
    bench.start("stop", Deceleration=1.0)
    assert bench.state == "Stopping"
    bench.until("stop.Done", 3)
    bench["stop.Execute"] = False
    bench.scan()
    assert bench.state == "StandStill"


def test_a_second_stop_brings_errorstop(bench):
    bench.power()
    bench.start("velocity", **MOVE)
    bench.until("velocity.InVelocity")
    bench.start("stop", Deceleration=1000.0)
    bench.scan(5)
    bench.continuous = False  # an emergency stop
    bench.start("stop2", Deceleration=1000.0)
    assert bench["stop2.Error"] and bench["stop2.ErrorID"] == ERRORS["ERRORSTOP"]
    bench.scan()
    assert bench.state == "Errorstop" and bench["stop.Error"]
    assert bench["fault.AxisError"] and bench["fault.AxisErrorID"] == ERRORS["ERRORSTOP"]
    for name in ("stop", "stop2"):
        bench[f"{name}.Execute"] = False
    bench.scan()
    bench.start("reset")
    bench.until("reset.Done", 5)
    bench.scan()
    assert bench.state == "StandStill" and not bench["fault.AxisError"]


@pytest.mark.parametrize(
    ("block", "inputs", "error"),
    [
        ("absolute", {"Position": 5.0, **MOVE, "Acceleration": 0.0}, "MA"),
        ("absolute", {"Position": 5.0, **MOVE, "Deceleration": 0.0}, "MA"),
        ("absolute", {"Position": 5.0, **MOVE, "Velocity": 0.0}, "MA"),
        ("absolute", {"Position": 5.0, **MOVE, "Velocity": -1.0}, "MA"),
        ("absolute", {"Position": 5.0, **MOVE, "Jerk": -1.0}, "MA"),
        ("relative", {"Distance": 5.0, **MOVE, "Acceleration": -1.0}, "MR"),
        ("additive", {"Distance": 5.0, **MOVE, "Acceleration": math.nan}, "MAD"),
        ("velocity", {**MOVE, "Deceleration": 0.0}, "MV"),
        ("stop", {"Deceleration": 0.0}, "MS"),
        ("halt", {"Deceleration": 0.0}, "MS"),
    ],
)
def test_wrong_values_are_errors_and_nothing_moves(bench, block, inputs, error):
    bench.power()
    bench.start(block, **inputs)
    assert bench[f"{block}.Error"] and bench[f"{block}.ErrorID"] == ERRORS[error]
    moves = block in ("absolute", "relative", "additive")
    bench.scan(10)
    # the AM600 manual: the axis shows discrete motion although the command was refused
    assert bench.state == ("DiscreteMotion" if moves else "StandStill")
    assert bench["ax.fSetPosition"] == 0.0 and bench["ax.bFBErrorOccured"]
    bench[f"{block}.Execute"] = False
    bench.scan(2)
    assert bench.state == "StandStill" and not bench[f"{block}.Error"]
    bench.start("second", Position=5.0, **MOVE)
    bench.until("second.Done")


def test_nothing_moves_without_power(bench):
    bench.start("absolute", Position=5.0, **MOVE)
    assert bench["absolute.Error"] and bench["absolute.ErrorID"] == ERRORS["NOT_READY"]
    assert bench.state == "Disabled"


def test_power_off_aborts(bench):
    bench.power()
    bench.start("absolute", Position=500.0, **MOVE)
    bench.scan(50)
    bench.continuous = False
    bench["power.bRegulatorOn"] = False
    bench.scan()
    assert bench["absolute.CommandAborted"] and bench.state == "Disabled"
    position = bench["ax.fActPosition"]
    bench.scan(100)
    assert bench["ax.fActPosition"] == position


def test_alarm_brings_errorstop_and_reset_ends_it(bench):
    bench.power()
    bench.start("velocity", **MOVE)
    bench.scan(50)
    bench.continuous = False
    bench.plc.axes[1].drive.alarm = True
    bench.scan(2)
    assert bench.state == "Errorstop" and bench["velocity.Error"] and bench["velocity.ErrorID"] == 2
    assert bench["fault.AxisErrorID"] == 2 and bench["power.Error"]
    bench["velocity.Execute"] = False
    bench.start("reset")
    bench.until("reset.Error", 5)
    assert bench["reset.ErrorID"] == 122
    bench["reset.Execute"] = False
    bench.plc.axes[1].drive.alarm = False
    bench.scan(2)
    assert bench.state == "Errorstop"
    at = bench["ax.fActPosition"]
    bench.start("reset")
    bench.until("reset.Done", 5)
    assert bench.state == "StandStill"  # MC_Power still has it on
    assert bench["ax.fSetPosition"] == bench["ax.fActPosition"] == at
    bench.scan()
    assert bench["power.Status"] and not bench["power.Error"]
    bench.start("absolute", Position=0.0, **MOVE)
    bench.until("absolute.Done")


@pytest.mark.parametrize("name", ["bRegulatorOn", "Enable"])
def test_reset_ends_in_power_off_where_power_is_not_asked_for(bench, name):
    bench.power()
    bench.plc.axes[1].drive.alarm = True
    bench.scan(2)
    bench.plc.axes[1].drive.alarm = False
    bench[f"power.{name}"] = False
    bench.scan()
    assert bench.state == "Errorstop"
    bench.start("reset")
    bench.until("reset.Done", 5)
    assert bench.state == "Disabled" and not bench["power.Status"]
    bench.scan(5)
    assert bench.state == "Disabled"
    bench[f"power.{name}"] = True
    bench.until("power.Status", 5)
    assert bench.state == "StandStill"


def test_limit_switch_stops_and_lets_the_axis_back(bench):
    bench.power()
    bench.start("velocity", **MOVE)
    bench.until("velocity.InVelocity")
    bench.continuous = False
    bench.plc.axes[1].switches.positive = True
    bench.scan(2)
    assert bench.state == "Errorstop" and bench["velocity.ErrorID"] == 11 and bench["sts"] & 0x20
    bench["velocity.Execute"] = False
    bench.scan()
    bench.start("reset")
    bench.until("reset.Done", 10)
    bench.start("relative", Distance=-50.0, **MOVE)
    bench.until("relative.Done")


def test_software_limits_of_the_axis(bench):
    bench["ax.fSWLimitPositive"] = 100.0
    bench["ax.fSWLimitNegative"] = -100.0
    bench["ax.bSWLimitEnable"] = True
    bench.power()
    bench.start("absolute", Position=101.0, **MOVE)
    assert bench["absolute.Error"] and bench["absolute.ErrorID"] == 10 and bench.state == "StandStill"
    bench.start("second", Position=100.0, **MOVE)
    bench.until("second.Done")
    bench.continuous = False
    bench.start("velocity", **MOVE)
    bench.until("velocity.Error", 200)
    assert bench.state == "Errorstop" and bench["fault.SWEndSwitchActive"]


def test_units_scale(bench):
    bench["ax.dwRatioTechUnitsDenom"] = 1000
    bench["ax.iRatioTechUnitsNum"] = 10  # 100 pulses a unit
    bench.power()
    bench.start("absolute", Position=2.5, Velocity=10.0, Acceleration=100.0, Deceleration=100.0)
    bench.until("absolute.Done")
    assert bench["ax.fSetPosition"] == 2.5 and bench["prfPos"] == 250.0
    bench.start("velocity", Velocity=10.0, Acceleration=100.0, Deceleration=100.0)
    bench.until("velocity.InVelocity")
    assert bench["ax.fSetVelocity"] == pytest.approx(10.0)
    assert bench["prfVel"] == pytest.approx(1.0)  # pulse/ms


@pytest.mark.parametrize(
    ("start", "target", "direction", "way"),
    [
        (10.0, 380.0, 1, 10.0), (350.0, 10.0, 1, 20.0), (10.0, 350.0, 0, -20.0), (350.0, 10.0, 0, 20.0),
        (10.0, 100.0, 0, 90.0), (100.0, 10.0, 0, -90.0), (10.0, 350.0, -1, -20.0), (350.0, 10.0, -1, -340.0),
        (10.0, 350.0, 3, -20.0), (10.0, 10.0, 1, 0.0), (10.0, -10.0, 0, -20.0),
    ],
)  # fmt: skip
def test_modulo_axis(bench, start, target, direction, way):
    bench["ax.iMovementType"] = 0
    bench.power()
    bench.start("relative", Distance=start, **MOVE)
    bench.until("relative.Done")
    before = bench["prfPos"]
    bench.start("absolute", Position=target, **MOVE, Direction=direction)
    bench.until("absolute.Done")
    assert bench["prfPos"] - before == pytest.approx(way)
    assert bench["ax.fSetPosition"] == target % 360.0


def test_set_position_moves_nothing(bench):
    bench.power()
    bench.start("absolute", Position=100.0, **MOVE)
    bench.until("absolute.Done")
    bench["setpos.Position"] = 1000.0
    bench["setpos.Execute"] = True
    bench.scan()
    assert bench["setpos.Done"] and bench["ax.fSetPosition"] == 1000.0 and bench["prfPos"] == 100.0
    bench.start("second", Position=1010.0, **MOVE)
    bench.until("second.Done")
    assert bench["prfPos"] == 110.0


def test_random_commands_never_have_two_owners_nor_a_jump(bench):
    """The rules that conftest checks after every scan, under random overlapping commands."""
    rng = random.Random(3)
    bench.power()
    blocks = ("absolute", "second", "relative", "additive", "velocity", "halt")
    for _ in range(50):
        block = rng.choice(blocks)
        bench[f"{block}.Execute"] = False
        bench.scan()
        inputs = {
            "Velocity": rng.uniform(50, 2000), "Acceleration": rng.uniform(1000, 20000),
            "Deceleration": rng.uniform(1000, 20000), "Jerk": rng.choice([0.0, 50000.0, 500000.0]),
        }  # fmt: skip
        if block in ("absolute", "second"):
            inputs["Position"] = rng.uniform(-500, 500)
        elif block in ("relative", "additive"):
            inputs["Distance"] = rng.uniform(-500, 500)
        elif block == "velocity":
            inputs["Direction"] = rng.choice([-1, 1, 2])
        else:
            inputs = {"Deceleration": inputs["Deceleration"], "Jerk": inputs["Jerk"]}
        bench.start(block, **inputs)
        assert bench[f"{block}.Busy"] or bench[f"{block}.Done"]
        bench.scan(rng.choice([1, 5, 40, 200]))

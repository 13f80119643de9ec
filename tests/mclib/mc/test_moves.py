"""Superimposed and continuous moves, profiles, torque, a block that is not called."""

import pytest


def test_superimposed_leaves_the_time_of_the_base_move(bench):
    bench.start("first", 150, Position=500.0)
    assert bench["fastest"] == pytest.approx(1000.0)
    bench.start("over", Distance=50.0, VelocityDiff=200.0)
    assert bench["over.Busy"] and bench["first.Busy"]
    bench.until("over.Done")
    assert bench["fastest"] == pytest.approx(1200.0) and bench["over.CoveredDistance"] <= 50.0
    bench.until("first.Done")
    assert bench["scans"] - 10 - 1 == 600  # 0.1 + 0.4 + 0.1 s, as without it
    assert bench["ax.fSetPosition"] == pytest.approx(550.0)


def test_superimposed_goes_on_behind_the_base_move(bench):
    bench.start("first", Position=50.0)
    bench.start("over", Distance=100.0, VelocityDiff=200.0)
    bench.until("first.Done")
    assert bench["over.Busy"] and bench.state == "discrete"
    bench.until("over.Done")
    assert bench["ax.fSetPosition"] == pytest.approx(150.0) and bench.state == "standstill"


def test_superimposed_at_standstill_is_relative(bench):
    bench.start("over", Distance=-30.0)
    assert bench.state == "discrete"
    bench.until("over.Done")
    assert bench["ax.fSetPosition"] == -30.0


def test_superimposed_again_and_by_another(bench):
    bench.start("velocity", 150, Velocity=500.0)
    start = bench["ax.fSetPosition"] - 0.5 * bench["scans"]
    bench.start("over", 100, Distance=50.0, VelocityDiff=200.0)
    bench.start("over", Distance=0.0)  # taken back
    bench.until("over.Done")
    assert bench["ax.fSetPosition"] - 0.5 * bench["scans"] == pytest.approx(start)
    bench.start("over", 100, Distance=50.0)
    added = bench["ax.fSetPosition"] - 0.5 * bench["scans"] - start
    bench.start("over2", Distance=10.0, VelocityDiff=100.0)
    bench.until("over2.Done")
    assert bench["over.CommandAborted"] or bench["over.Done"]
    assert bench["ax.fSetPosition"] - 0.5 * bench["scans"] - start == pytest.approx(
        60.0 if added >= 50 else added + 10, abs=6
    )


def test_halt_superimposed_leaves_the_base_alone(bench):
    bench.start("velocity", 150, Velocity=500.0)
    bench.start("over", 50, Distance=500.0, VelocityDiff=200.0)
    bench.start("haltOver")
    bench.until("haltOver.Done")
    assert bench["over.CommandAborted"] and bench["velocity.InVelocity"]
    assert bench["ax.fSetVelocity"] == 500.0


def test_an_aborting_command_ends_both(bench):
    bench.start("first", 100, Position=500.0)
    bench.start("over", 20, Distance=100.0)
    bench.start("second", 2, Position=0.0)
    assert bench["first.CommandAborted"] and bench["over.CommandAborted"]
    bench.until("second.Done")
    assert bench["ax.fSetPosition"] == 0.0


def test_a_buffered_move_keeps_what_was_superimposed(bench):
    bench.start("first", Position=200.0)
    bench.start("over", Distance=50.0)
    bench.start("second", Position=400.0, BufferMode=1)
    bench.until("second.Done")
    assert bench["ax.fSetPosition"] == pytest.approx(450.0)


def test_superimposed_wants_values_and_no_profile(bench):
    bench.start("velocity")
    bench.start("over", Distance=5.0, VelocityDiff=0.0)
    assert bench["over.ErrorID"] == 276
    bench.start("halt")
    bench.until("halt.Done")
    bench.profile("positions", [(500, 100.0)])
    bench.start("over", Distance=5.0, VelocityDiff=10.0)
    assert bench["over.ErrorID"] == 278


@pytest.mark.parametrize(("block", "way"), [("onward", "Position"), ("further", "Distance")])
def test_continuous_moves_pass_the_position(bench, block, way):
    bench["mark"] = 300.0
    bench.start(block, **{way: 300.0}, EndVelocity=400.0)
    assert bench.state == "continuous"
    bench.until(f"{block}.InEndVelocity")
    assert bench["ax.fSetPosition"] == pytest.approx(300.0, abs=1.0)
    bench.scan(50)
    assert bench["ax.fSetVelocity"] == pytest.approx(400.0) and bench[f"{block}.InEndVelocity"]
    bench.start("halt", 2)
    assert bench[f"{block}.CommandAborted"] and not bench[f"{block}.InEndVelocity"]


def test_continuous_move_with_a_negative_end_velocity_turns(bench):
    bench.start("onward", Position=300.0, EndVelocity=-400.0)
    bench.until("onward.InEndVelocity")
    assert bench["ax.fSetVelocity"] == pytest.approx(-400.0)
    assert bench["ax.fSetPosition"] == pytest.approx(300.0, abs=1.0)


@pytest.mark.parametrize(("direction", "end"), [(2, 250.0), (1, 250.0), (-1, -250.0)])
def test_smc_continuous_takes_a_direction(bench, direction, end):
    bench.start("smcOnward", Distance=200.0, EndVelocity=250.0, EndVelocityDirection=direction)
    assert bench.state == "discrete"  # the AM600 manual
    bench.until("smcOnward.InEndVelocity")
    assert bench["ax.fSetVelocity"] == pytest.approx(end) and bench.state == "continuous"
    bench.start("smcFurther", Distance=-400.0, EndVelocity=100.0)
    bench.until("smcFurther.InEndVelocity")
    assert bench["ax.fSetVelocity"] == pytest.approx(-100.0)
    bench.start("smcFurther", Distance=5.0, EndVelocity=100.0, EndVelocityDirection=0)
    assert bench["smcFurther.ErrorID"] == 427


def test_position_profile_passes_its_points(bench):
    bench.profile("positions", [(400, 100.0), (300, 100.0), (500, -50.0)], Offset=0.0)
    assert bench.state == "discrete" and bench["positions.Active"]
    bench.scan(399)
    assert bench["ax.fSetPosition"] == pytest.approx(100.0)
    # one cubic from rest to rest: 3/2 of the mean velocity
    assert bench["fastest"] == pytest.approx(1.5 * 100.0 / 0.4, rel=1e-3)
    bench.scan(200)
    assert bench["ax.fSetPosition"] == pytest.approx(100.0) and bench["ax.fSetVelocity"] == pytest.approx(0.0, abs=1e-9)
    bench.until("positions.Done")
    assert bench["scans"] - 10 - 1 == 1200
    assert bench["ax.fSetPosition"] == -50.0 and bench.state == "standstill"


def test_relative_position_profile_scales_and_offsets(bench):
    bench.profile("positions", [(200, 10.0), (200, 20.0)], absolute=False, PositionScale=2.0, Offset=5.0)
    bench.until("positions.Done")
    assert bench["ax.fSetPosition"] == pytest.approx(65.0)


def test_velocity_profile_is_an_s_curve(bench):
    bench.profile("velocities", [(200, 300.0), (400, 300.0), (200, 0.0)])
    bench.scan(99)
    assert bench["ax.fSetVelocity"] == pytest.approx(150.0) and bench["ax.fSetAcceleration"] == pytest.approx(3000.0)
    bench.scan(100)
    assert bench["ax.fSetVelocity"] == pytest.approx(300.0) and bench["ax.fSetAcceleration"] == pytest.approx(
        0.0, abs=1e-6
    )
    bench.until("velocities.Done")
    # mean velocities: 150 * 0.2 + 300 * 0.4 + 150 * 0.2
    assert bench["ax.fSetPosition"] == pytest.approx(180.0)


def test_acceleration_profile_adds_half_the_sum_of_a_segment(bench):
    bench.profile("accelerations", [(100, 2000.0), (100, 0.0), (100, -2000.0), (100, 0.0)])
    bench.scan(99)
    assert bench["ax.fSetVelocity"] == pytest.approx(100.0)  # (0 + 2000) / 2 * 0.1 (AM600)
    bench.scan(100)
    assert bench["ax.fSetVelocity"] == pytest.approx(200.0)
    bench.until("accelerations.Done")
    assert bench["ax.fSetVelocity"] == 0.0 and bench.state == "standstill"


def test_a_profile_that_ends_in_motion_needs_a_command(bench):
    bench.profile("velocities", [(200, 300.0)])
    bench["calm"] = False
    bench.until("velocities.Done")
    bench.scan(3)
    assert bench.state == "errorstop" and bench["ax.dwErrorID"] == 30001


def test_a_profile_that_ends_in_motion_may_be_followed(bench):
    bench.profile("velocities", [(200, 300.0)])
    bench.start("first", Position=400.0, BufferMode=1)
    bench.until("first.Done")
    assert bench["velocities.Done"] and bench["ax.fSetPosition"] == 400.0


@pytest.mark.parametrize(
    ("name", "size", "step"), [("positions", 325, 326), ("velocities", 350, 351), ("accelerations", 375, 376)]
)
def test_wrong_tables(bench, name, size, step):
    bench.profile(name, [(0, 1.0)])
    assert bench[f"{name}.ErrorID"] == step
    for count in (0, 101, -1):
        bench.start(name, ArraySize=count)
        assert bench[f"{name}.ErrorID"] == size and bench.state == "standstill"


def test_torque_accelerates_the_inertia(bench):
    bench.start("torque", Torque=0.005, TorqueRamp=0.05, Velocity=1000.0, Deceleration=0.0)
    bench.until("torque.InTorque")
    assert bench["ax.fActTorque"] == pytest.approx(0.005)  # inertia 1: 0.005 pulse/ms2
    assert bench["scans"] - 10 == pytest.approx(101, abs=2)  # the ramp: 0.005 / 0.05 per second
    bench.scan(300)
    assert bench["ax.fSetVelocity"] == 1000.0 and not bench["torque.InTorque"] and bench["torque.Busy"]


def test_torque_takes_changed_inputs(bench):
    """Inertia 1: a torque of 0.005 is 5000 u/s2, which Acceleration bounds."""
    inputs = {"Torque": 0.005, "TorqueRamp": 0.0, "Velocity": 900.0, "Acceleration": 2000.0, "Deceleration": 0.0}
    bench.start("torque", 20, ContinuousUpdate=True, **inputs)
    assert bench["ax.fSetAcceleration"] == pytest.approx(2000.0) and not bench["torque.InTorque"]
    bench["torque.Acceleration"] = 0.0
    bench.scan(2)
    assert bench["ax.fSetAcceleration"] == pytest.approx(5000.0)
    bench.scan()
    assert bench["torque.InTorque"]
    bench["torque.Torque"] = 0.002
    bench.scan(2)
    assert bench["ax.fActTorque"] == pytest.approx(0.002) and bench["torque.InTorque"]
    bench["torque.ContinuousUpdate"] = False
    bench["torque.Torque"] = 0.004  # is not looked at any more
    bench.scan(10)
    assert bench["ax.fActTorque"] == pytest.approx(0.002) and bench["torque.InTorque"]


@pytest.mark.parametrize("sign", [1, -1])
def test_torque_has_a_sign_of_its_own(bench, sign):
    """Braking is a torque, too, but not in the direction that is asked for."""
    bench["ax.fScalefactor"] = float(sign)
    bench["power.bRegulatorOn"] = False
    bench.scan()
    bench["power.bRegulatorOn"] = True
    bench.scan(3)
    bench.start("velocity", 150, Velocity=500.0)
    bench.start("torque", 20, Torque=0.005, TorqueRamp=0.0, Velocity=100.0, Deceleration=8000.0, Acceleration=0.0)
    assert bench["ax.fSetAcceleration"] == pytest.approx(-8000.0) and not bench["torque.InTorque"]


@pytest.mark.parametrize(("block", "error"), [("first", 30), ("velocity", 30), ("stop", 184)])
def test_a_block_that_is_not_called_stops_its_axis(bench, block, error):
    if block == "stop":
        bench.start("velocity", 120)
    bench.start(block, **({"Position": 500.0} if block == "first" else {}), Deceleration=2000.0)
    bench.scan(50)
    bench["calm"] = False
    bench["skip"] = block
    bench.scan(3)
    assert bench.state == "errorstop" and bench["ax.dwErrorID"] == error
    bench["skip"] = ""
    bench.scan()
    assert bench[f"{block}.Error"] and bench[f"{block}.ErrorID"] == error


def test_a_running_block_started_anew_with_wrong_values_lets_the_motion_go_on(bench):
    bench.start("first", 100, Position=500.0)
    bench.start("first", Velocity=-1.0)
    assert bench["first.ErrorID"] == 201
    bench.scan(1000)
    assert bench["ax.fSetPosition"] == 500.0 and bench.state == "standstill"


def test_read_blocks(bench):
    bench.start("velocity", 20)
    assert bench["motion.Accelerating"] and bench["motion.DirectionPositive"] and not bench["motion.ConstantVelocity"]
    bench.scan(200)
    assert bench["motion.ConstantVelocity"] and not bench["motion.Accelerating"]
    bench.plc.axes[1].switches.home = True
    bench.scan()
    assert bench["info.HomeAbsSwitch"] and bench["info.PowerOn"] and not bench["info.IsHomed"]
    assert bench["info.ReadyForPowerOn"] and bench["info.CommunicationReady"]


def test_a_profile_takes_changed_inputs(bench):
    """ContinuousUpdate: the running segment keeps its goal and its time, the next ones take the new values."""
    bench.profile("velocities", [(100, 300.0), (200, 300.0), (100, 100.0), (100, 0.0)], ContinuousUpdate=True)
    bench.scan(199)  # in the middle of the second segment
    bench["velocities.VelocityScale"] = 2.0
    bench["velocities.Offset"] = 50.0
    bench.scan(100)
    assert bench["ax.fSetVelocity"] == pytest.approx(300.0)
    bench.scan(50)
    bench["velocities.TimeScale"] = 2.0
    bench.scan(50)
    assert bench["ax.fSetVelocity"] == pytest.approx(250.0)
    bench.scan(50)
    bench["velocities.ContinuousUpdate"] = False
    bench["velocities.Offset"] = 0.0
    bench.scan(50)
    assert bench["ax.fSetVelocity"] == pytest.approx(150.0)  # half of the way from 250 to 50 in twice the time


def test_an_acceleration_profile_takes_changed_inputs(bench):
    bench.profile("accelerations", [(100, 2000.0), (200, 2000.0), (100, 1000.0), (100, 0.0)], ContinuousUpdate=True)
    bench.scan(199)
    bench["accelerations.AccelerationScale"] = 0.5
    bench.scan(200)
    assert bench["ax.fSetAcceleration"] == pytest.approx(500.0)
    assert bench["ax.fSetVelocity"] == pytest.approx(100.0 + 400.0 + 125.0)


@pytest.mark.parametrize("absolute", [True, False])
def test_a_position_profile_takes_changed_inputs(bench, absolute):
    values = (100.0, 200.0) if absolute else (100.0, 100.0)
    bench.profile("positions", list(zip((200, 300), values, strict=True)), absolute, ContinuousUpdate=True)
    bench.scan(99)
    bench["positions.Offset"] = -10.0
    bench["positions.PositionScale"] = 0.8
    bench["positions.TimeScale"] = 0.7
    bench.scan(100)
    assert bench["ax.fSetPosition"] == pytest.approx(100.0)
    bench.scan(20)
    bench["positions.PositionScale"] = 3.0  # too late
    assert bench.until("positions.Done") == pytest.approx(191, abs=1)
    assert bench["ax.fSetPosition"] == pytest.approx(150.0) and bench.state == "standstill"


def test_a_profile_leaves_changed_inputs_alone_that_are_none(bench):
    bench.profile("positions", [(100, 10.0), (100, 20.0)], ContinuousUpdate=True)
    bench["positions.PositionScale"], bench["positions.TimeScale"] = -1.0, 0.0
    assert bench.until("positions.Done") == pytest.approx(200, abs=1)
    assert bench["ax.fSetPosition"] == pytest.approx(20.0)


def test_a_profile_that_waits_begins_from_where_the_axis_then_is(bench):
    bench.start("first", Position=30.0)
    bench.profile("positions", [(200, 100.0), (200, 50.0)], BufferMode=1)
    bench.until("positions.Done")
    assert bench["ax.fSetPosition"] == pytest.approx(50.0)
    bench.start("velocity", Velocity=200.0)
    bench.profile("velocities", [(100, 100.0), (100, -200.0)], BufferMode=1)
    bench.until("velocities.Done")
    assert bench.state == "standstill"


def test_a_position_profile_begins_with_the_velocity_of_the_axis(bench):
    bench.start("velocity", 100, Velocity=200.0)
    start = bench["ax.fSetPosition"]
    bench.profile("positions", [(200, 30.0), (200, 10.0)], absolute=False)
    bench.until("positions.Done")
    assert bench["ax.fSetPosition"] == pytest.approx(start + 40.0)


@pytest.mark.parametrize("base", ["first", None])
def test_superimposed_takes_changed_inputs(bench, base):
    if base:
        bench.start(base, 200, Position=2000.0, Velocity=500.0)
    bench.start("over", 100, Distance=50.0, VelocityDiff=100.0, ContinuousUpdate=True)
    bench["over.Distance"] = 80.0
    bench["over.VelocityDiff"] = 200.0
    bench.scan(50)
    assert bench["ax.fSetVelocity"] == pytest.approx((500.0 if base else 0.0) + 200.0)
    bench["over.Acceleration"] = -1.0  # is none
    bench.until("over.Done")
    assert bench["over.CoveredDistance"] == pytest.approx(80.0)
    if base:
        bench.until("first.Done")
    assert bench["ax.fSetPosition"] == pytest.approx(2080.0 if base else 80.0)

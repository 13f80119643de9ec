"""BufferMode, ContinuousUpdate and what becomes of those that wait."""

import pytest

ABORTING, BUFFERED, LOW, PREVIOUS, NEXT, HIGH = range(6)


def test_buffered_starts_at_the_very_end(bench):
    bench.start("first", Position=100.0)
    bench.start("second", Position=300.0, BufferMode=BUFFERED)
    assert bench["second.Busy"] and not bench["second.Active"] and bench["first.Active"]
    bench.mark = 100.0
    bench["mark"] = 100.0
    bench.until("first.Done")
    assert bench["second.Active"] or bench["second.Busy"]
    assert bench["ax.fSetPosition"] == pytest.approx(100.0, abs=0.01)
    bench.until("second.Done")
    # 100 and 200 units: 0.2 and 0.3 s with ramps of 0.1 s, no scan between them; Done is seen one scan later
    assert bench["scans"] - 10 - 1 == 500
    assert bench["ax.fSetPosition"] == 300.0 and bench.state == "standstill"


@pytest.mark.parametrize(
    ("mode", "v1", "v2", "at"),
    [
        (BUFFERED, 500, 1000, 0), (LOW, 500, 1000, 500), (PREVIOUS, 500, 1000, 500), (NEXT, 500, 1000, 1000),
        (HIGH, 500, 1000, 1000), (LOW, 1000, 500, 500), (PREVIOUS, 1000, 500, 1000), (NEXT, 1000, 500, 500),
        (HIGH, 1000, 500, 1000),
    ],
)  # fmt: skip
@pytest.mark.parametrize("jerk", [0.0, 200000.0])
def test_blending_passes_the_end_with_its_velocity(bench, mode, v1, v2, at, jerk):
    bench["mark"] = 300.0
    bench.start("first", Position=300.0, Velocity=float(v1), Jerk=jerk)
    bench.start("second", 50, Position=800.0, Velocity=float(v2), BufferMode=mode, Jerk=jerk)
    bench.until("second.Active")
    assert bench["first.Done"]
    assert bench["ax.fSetPosition"] == pytest.approx(300.0, abs=2.1)
    assert bench["atMark"] == pytest.approx(at, abs=20.0 if jerk == 0 else 5.0)
    bench.until("second.Done")
    assert bench["ax.fSetPosition"] == 800.0
    assert bench["fastest"] <= max(v1, v2) + 1e-6


def test_blending_into_the_other_direction_stops(bench):
    bench["mark"] = 300.0
    bench.start("first", Position=300.0)
    bench.start("second", Position=100.0, BufferMode=HIGH)
    bench.until("second.Done")
    assert abs(bench["atMark"]) <= 10.0 and bench["ax.fSetPosition"] == 100.0


def test_blending_never_passes_faster_than_the_next_can_stop(bench):
    bench["mark"] = 300.0
    bench.start("first", Position=300.0)
    bench.start("second", Position=305.0, BufferMode=PREVIOUS)
    bench.until("second.Done")
    # 5 units with 10000 u/s2: sqrt(2 * 10000 * 5)
    assert bench["atMark"] == pytest.approx(316.2, abs=12)
    assert bench["ax.fSetPosition"] == 305.0


def test_a_chain_of_three(bench):
    for block, position in (("first", 100.0), ("second", 250.0), ("third", 400.0)):
        bench.start(block, Position=position, BufferMode=PREVIOUS)
    assert [bench[f"{b}.Active"] for b in ("first", "second", "third")] == [True, False, False]
    bench.until("third.Done")
    assert bench["scans"] - 10 - 1 == 500  # as one move of 400 units
    bench.scan()
    assert bench["first.Done"] and bench["second.Done"]


def test_a_velocity_gives_way_when_it_is_reached(bench):
    bench.start("velocity", Velocity=500.0)
    bench.start("second", Position=500.0, BufferMode=BUFFERED)
    assert bench["velocity.Busy"]
    bench.until("velocity.InVelocity")
    assert bench["second.Active"] and bench["velocity.Busy"] and not bench["velocity.Active"]
    assert bench["ax.fSetVelocity"] == pytest.approx(500.0, abs=20)
    bench.scan()
    assert bench["velocity.CommandAborted"] and not bench["velocity.InVelocity"]
    bench.until("second.Done")


REACHED = {
    "velocity": ("InVelocity", {"Velocity": 300.0}),
    "onward": ("InEndVelocity", {"Position": 50.0, "EndVelocity": 90.0}),
    "further": ("InEndVelocity", {"Distance": 50.0, "EndVelocity": -90.0}),
    "smcOnward": ("InEndVelocity", {"Distance": 50.0, "EndVelocity": 90.0}),
    "smcFurther": ("InEndVelocity", {"Distance": 50.0, "EndVelocity": 90.0}),
    "torque": ("InTorque", {"Torque": 0.005, "TorqueRamp": 0.5, "Velocity": 500.0}),
    "gear": ("InGear", {}), "meet": ("InSync", {"MasterSyncPosition": 60.0, "SlaveSyncPosition": 30.0,
                                                "Velocity": 0.0, "Acceleration": 0.0, "Deceleration": 0.0}),
    "combine": ("InSync", {}),
}  # fmt: skip


@pytest.mark.parametrize("block", REACHED)
@pytest.mark.parametrize("late", [False, True])
def test_what_gives_way_shows_that_it_was_reached(bench, block, late):
    """PLCopen Part 1, table 4: this output starts the command that waits, at once where it is TRUE already."""
    output, inputs = REACHED[block]
    bench["run.Acceleration"] = bench["run.Deceleration"] = 2000.0
    bench.start("run", Velocity=200.0, Acceleration=2000.0, Deceleration=2000.0)
    bench.start(block, **inputs)
    if late:
        bench.until(f"{block}.{output}")
        bench.scan(1 if block == "torque" else 20)
        assert bench[f"{block}.{output}"]
    bench.start("third", Position=1000.0, BufferMode=BUFFERED)
    if not late:
        assert not bench[f"{block}.{output}"]
        bench.until(f"{block}.{output}")
    bench.scan(0 if bench["third.Active"] else 1)
    assert bench["third.Active"] and bench["scans"] < 600
    bench.scan()
    assert bench[f"{block}.CommandAborted"] and not bench[f"{block}.{output}"] and not bench[f"{block}.Busy"]
    bench.until("third.Done")
    assert bench["ax.fSetPosition"] == 1000.0


def test_an_override_of_0_is_nothing_reached(bench):
    bench["override.Enable"] = True
    bench.start("onward", 150, Position=100.0, EndVelocity=50.0)
    bench.start("third", 30, Position=400.0, BufferMode=BUFFERED)
    bench.until("third.Done")
    bench.start("velocity", 200, Velocity=500.0)
    assert bench["velocity.InVelocity"]
    bench["override.VelFactor"] = 0.0
    bench.scan(100)
    assert bench["ax.fSetVelocity"] == 0.0 and not bench["velocity.InVelocity"]
    bench.start("third", 30, Position=900.0, BufferMode=BUFFERED)
    assert not bench["third.Active"] and bench["velocity.Active"] and bench.state == "continuous"
    bench["override.VelFactor"] = 0.5
    bench.until("velocity.InVelocity")
    assert bench["ax.fSetVelocity"] == pytest.approx(250.0, abs=10.0)
    bench.until("third.Done")


def test_an_override_after_the_target_of_a_continuous_move_scales_its_end_velocity(bench):
    bench["override.Enable"] = True
    bench.start("smcOnward", Distance=-100.0, EndVelocity=50.0)
    bench.until("smcOnward.InEndVelocity")
    for factor in (0.5, 0.0, 1.0):
        bench.scan(200)
        bench["override.VelFactor"] = factor
        bench.scan(20)
        assert bench["ax.fSetVelocity"] == pytest.approx(-50.0 * factor), factor
        assert bench["smcOnward.InEndVelocity"] == (factor > 0) and bench.state == "continuous"


def test_continuous_update_of_an_end_velocity(bench):
    bench.start("onward", 20, Position=100.0, EndVelocity=50.0, ContinuousUpdate=True)
    bench["onward.EndVelocity"] = 200.0
    bench.until("onward.InEndVelocity")
    assert bench["ax.fSetVelocity"] == pytest.approx(200.0) and bench["ax.fSetPosition"] == pytest.approx(100.0, abs=1)
    bench["onward.EndVelocity"] = -30.0
    bench.scan(50)
    assert bench["ax.fSetVelocity"] == -30.0 and bench["onward.InEndVelocity"]
    bench["onward.Acceleration"] = 500.0
    bench.scan()
    assert bench["onward.InEndVelocity"]


def test_relative_waits_and_counts_from_the_end_before(bench):
    bench.start("first", Position=100.0)
    bench.start("relative", Distance=50.0, BufferMode=BUFFERED)
    bench.start("velocity", Velocity=-300.0, Direction=1, BufferMode=LOW)
    bench.until("relative.Done")
    assert bench["ax.fSetPosition"] == pytest.approx(150.0, abs=0.1)
    bench.until("velocity.InVelocity")
    assert bench["ax.fSetVelocity"] == -300.0


def test_an_aborting_command_empties_the_buffer(bench):
    bench.start("first", Position=500.0)
    bench.start("second", Position=800.0, BufferMode=BUFFERED)
    bench.start("third", 2, Position=-100.0)
    assert bench["first.CommandAborted"] and bench["second.CommandAborted"] and bench["third.Active"]
    bench.until("third.Done")
    assert bench["ax.fSetPosition"] == -100.0


def test_an_axis_error_is_an_error_of_those_that_wait(bench):
    bench.start("first", Position=500.0)
    bench.start("second", 20, Position=800.0, BufferMode=BUFFERED)
    bench["calm"] = False
    bench.plc.axes[1].drive.alarm = True
    bench.scan(3)
    assert bench["first.Error"] and bench["first.ErrorID"] == 2
    assert bench["second.Error"] and bench["second.ErrorID"] == 34


def test_a_waiting_block_started_anew_goes_to_the_end(bench):
    bench.start("first", Position=200.0)
    bench.start("second", Position=400.0, BufferMode=BUFFERED)
    bench.start("third", Position=300.0, BufferMode=BUFFERED)
    bench.start("second", Position=500.0)
    bench.until("third.Done")
    assert bench["second.Busy"] and not bench["second.Done"]
    bench.until("second.Done")
    assert bench["ax.fSetPosition"] == 500.0


def test_continuous_update_follows_the_inputs(bench):
    bench.start("first", 60, Position=500.0, ContinuousUpdate=True)
    bench["first.Position"] = 700.0
    bench["first.Velocity"] = 400.0
    bench.scan(100)
    assert bench["ax.fSetVelocity"] == 400.0 and bench["first.Busy"]
    bench["first.ContinuousUpdate"] = False
    bench["first.Position"] = 900.0
    bench.until("first.Done")
    assert bench["ax.fSetPosition"] == 700.0


def test_continuous_update_of_a_distance_counts_from_the_start(bench):
    bench.start("first", Position=100.0)
    bench.until("first.Done")
    bench.start("relative", 50, Distance=200.0, ContinuousUpdate=True)
    bench["relative.Distance"] = 20.0
    bench.until("relative.Done")
    assert bench["ax.fSetPosition"] == pytest.approx(120.0)


def test_continuous_update_needs_to_be_set_at_the_edge(bench):
    bench.start("velocity", 200, Velocity=500.0)
    bench["velocity.ContinuousUpdate"] = True
    bench["velocity.Velocity"] = 800.0
    bench.scan(200)
    assert bench["ax.fSetVelocity"] == 500.0
    bench.start("velocity", 200, Velocity=800.0)
    bench["velocity.Velocity"] = 600.0
    bench.scan()
    assert not bench["velocity.InVelocity"]
    bench.scan(200)
    assert bench["ax.fSetVelocity"] == 600.0 and bench["velocity.InVelocity"]


def test_override_scales_what_runs(bench):
    bench.start("first", 200, Position=2000.0)
    for factor, speed in ((0.5, 500.0), (0.0, 0.0), (0.25, 250.0)):
        bench["override.VelFactor"] = factor
        bench["override.Enable"] = True
        bench.scan(150)
        assert bench["ax.fSetVelocity"] == pytest.approx(speed)
        assert bench.state == "discrete" and bench["first.Busy"]
    bench["override.VelFactor"] = -1.0
    bench.scan()
    assert bench["override.Error"] and not bench["override.Enabled"]
    bench["override.VelFactor"] = 1.0
    bench.until("first.Done")
    assert bench["ax.fSetPosition"] == 2000.0


def test_override_scales_what_is_superimposed(bench):
    bench["override.Enable"] = True
    bench.start("velocity", 100, Velocity=500.0)
    bench.start("over", 50, Distance=100.0, VelocityDiff=200.0)
    start, at = bench["ax.fSetPosition"], bench["scans"]
    for factor in (0.5, 0.0, 0.25):
        bench["override.VelFactor"] = factor
        bench.scan(80)
        assert bench["ax.fSetVelocity"] == pytest.approx(700.0 * factor), factor
        assert bench["over.Busy"]
    bench["override.VelFactor"] = 1.0
    bench.until("over.Done")
    assert bench["over.CoveredDistance"] <= 100.0 and bench["ax.fSetVelocity"] == 500.0
    assert bench["scans"] > at and bench["ax.fSetPosition"] > start


def test_a_way_of_no_length_between_two_moves_takes_no_time(bench):
    """5.1 ms with 10 000 u/s2 up and down are 0.2601 u; what follows begins then and there."""
    begin = bench["scans"]
    bench.start("relative", Distance=0.2601)
    bench.start("halt", BufferMode=BUFFERED)
    bench.start("third", Position=-1000.0, BufferMode=BUFFERED)
    bench.scan(27)
    assert bench["third.Active"] and bench["scans"] - begin == 30
    assert bench["ax.fSetVelocity"] == pytest.approx(-10.0 * (30 - 10.2))


def test_a_waiting_block_that_is_refused_waits_no_more(bench):
    bench.start("first", Position=200.0)
    bench.start("second", Position=400.0, BufferMode=HIGH)
    bench.start("third", Position=300.0, BufferMode=BUFFERED)
    bench.start("second", Velocity=0.0, BufferMode=HIGH)
    assert bench["second.Error"] and not bench["second.Busy"]
    bench.until("first.Done")
    assert bench["third.Active"] and abs(bench["ax.fSetVelocity"]) < 11.0  # nothing blends into 'first' any more
    bench.until("third.Done")
    bench.scan(5)
    assert bench["ax.fSetPosition"] == 300.0 and bench.state == "standstill" and bench["second.Error"]


def test_a_waiting_home_that_is_refused_does_not_home(bench):
    bench.start("first", Position=200.0)
    bench.start("home", Position=7.0, BufferMode=BUFFERED)
    bench.start("home", BufferMode=ABORTING)
    assert bench["home.ErrorID"] == 170  # SMC_H_AXIS_WASNT_STANDSTILL
    bench.until("first.Done")
    assert bench["ax.fSetPosition"] == 200.0


def test_a_home_behind_a_velocity_is_an_error(bench):
    """It needs standstill (PLCopen Part 1, figure 2)."""
    bench.start("velocity", 20, Velocity=500.0)
    bench.start("home", Position=7.0, BufferMode=BUFFERED)
    bench["calm"] = False
    bench.until("home.Error")
    assert bench["home.ErrorID"] == 170 and bench.state == "errorstop"


def test_a_home_behind_a_halt_forgets_what_was_superimposed(bench):
    bench.start("first", 50, Position=2000.0)
    bench.start("over", 400, Distance=30.0, VelocityDiff=200.0)
    bench.start("halt", BufferMode=ABORTING)
    bench.start("over", Distance=3.0, VelocityDiff=500.0)
    bench.start("home", Position=7.0, BufferMode=BUFFERED)
    bench.start("relative", Distance=10.0, BufferMode=BUFFERED)
    bench["calm"] = False  # homing sets the position
    bench.until("relative.Done")
    assert bench["ax.fSetPosition"] == pytest.approx(17.0) and bench["ax.fActPosition"] == pytest.approx(17.0)


FIRST = {"first": {"Position": 300.0}, "relative": {"Distance": 300.0}, "additive": {"Distance": 300.0}}
FOLLOWING = {
    "third": ("Done", {"Position": 800.0}), "relative": ("Done", {"Distance": 500.0}),
    "additive": ("Done", {"Distance": 500.0}), "velocity": ("InVelocity", {"Direction": 1}),
    "onward": ("InEndVelocity", {"Position": 800.0, "EndVelocity": 100.0}),
    "further": ("InEndVelocity", {"Distance": 500.0, "EndVelocity": 100.0}),
    "smcFurther": ("InEndVelocity", {"Distance": 500.0, "EndVelocity": 100.0}),
}  # fmt: skip


def test_every_pair_blends_with_the_velocity_of_its_mode(bench):
    """PLCopen Part 1, table 3: 300 u with 400 u/s, then 500 u with 700 u/s."""
    snapshot = bench.plc.snapshot()
    for first, inputs in FIRST.items():
        for block, (output, others) in FOLLOWING.items():
            for mode, at in ((BUFFERED, 0), (LOW, 400), (PREVIOUS, 400), (NEXT, 700), (HIGH, 700)):
                if block == first:
                    continue
                bench.plc.restore(snapshot)
                bench["mark"] = 300.0
                bench.start(first, 5, Velocity=400.0, **inputs)
                bench.start(block, Velocity=700.0, BufferMode=mode, **others)
                bench.plc.run_until(f"PLC_PRG.{first}.Done")
                assert bench["atMark"] == pytest.approx(at, abs=20.1), (first, block, mode)
                bench.plc.run_until(f"PLC_PRG.{block}.{output}")
                bench.scan()
                speed = {"Done": 0.0, "InVelocity": 700.0, "InEndVelocity": 100.0}[output]
                assert bench["ax.fSetVelocity"] == pytest.approx(speed), (first, block, mode)
                if output != "InVelocity":
                    place = pytest.approx(800.0, abs=0.0 if speed == 0.0 else 0.3)
                    assert bench["ax.fSetPosition"] == place, (first, block, mode)

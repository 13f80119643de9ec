"""Gears, axes that are combined, and phases: a slave and its masters."""

import pytest

GEAR = {"Acceleration": 5000.0, "Deceleration": 5000.0}


def test_gear_takes_the_ratio_of_velocities(bench):
    bench.start("run", 100, Velocity=400.0)
    bench.start("gear", RatioNumerator=3, RatioDenominator=2, **GEAR)
    assert bench.state == "synchronized" and bench["gear.Busy"] and not bench["gear.InGear"]
    scans = bench.until("gear.InGear")
    assert scans == pytest.approx(120, abs=2)  # 600 u/s with 5000 u/s2
    assert bench["ax.fSetVelocity"] == pytest.approx(600.0)
    slave, master = bench["ax.fSetPosition"], bench["master.fSetPosition"]
    bench.start("run", 200, Velocity=-1000.0, Direction=1)  # the slave follows without a limit of its own
    assert bench["ax.fSetVelocity"] == pytest.approx(-1500.0) and bench["gear.InGear"]
    assert bench["ax.fSetPosition"] - slave == pytest.approx(1.5 * (bench["master.fSetPosition"] - master))


def test_gear_with_jerk_limit_gets_in(bench):
    bench.start("run", 100, Velocity=400.0)
    bench.start("gear", Jerk=100000.0, **GEAR)
    scans = bench.until("gear.InGear")
    assert scans == pytest.approx(130, abs=3)  # 400 / 5000 + 5000 / 100000 s


def test_gear_ratio_may_change_and_the_master_be_stopped(bench):
    bench.start("run", 100, Velocity=400.0)
    bench.start("gear", **GEAR)
    bench.until("gear.InGear")
    bench.start("gear", RatioNumerator=-1)
    assert not bench["gear.InGear"]
    bench.until("gear.InGear")
    assert bench["ax.fSetVelocity"] == pytest.approx(-400.0)
    bench.start("masterHalt", 200)
    assert bench["ax.fSetVelocity"] == pytest.approx(0.0) and bench.state == "synchronized"


def test_gear_out_keeps_the_velocity(bench):
    bench.start("gearOut")
    assert bench["gearOut.ErrorID"] == 34
    bench.start("run", 100, Velocity=400.0)
    bench.start("gear", **GEAR)
    bench.until("gear.InGear")
    bench.start("gearOut", 3)
    assert bench["gearOut.Done"] and bench["gear.CommandAborted"] and not bench["gear.InGear"]
    bench.start("masterHalt", 200)
    assert bench["ax.fSetVelocity"] == pytest.approx(400.0) and bench.state == "continuous"
    bench.start("halt")
    bench.until("halt.Done")


def test_a_slave_of_a_slave_moves_in_the_same_scan(bench):
    bench.start("gear2", **GEAR)
    bench.start("gear", **GEAR)
    bench.start("run", 300, Velocity=400.0)
    assert bench["gear.InGear"] and bench["gear2.InGear"]
    before = bench["ax.fSetPosition"] - bench["other.fSetPosition"]
    bench.start("run", 50, Velocity=600.0)
    assert bench["ax.fSetPosition"] - bench["other.fSetPosition"] == pytest.approx(before)


def test_gear_errors(bench):
    bench.start("gear", RatioDenominator=0, **GEAR)
    assert bench["gear.ErrorID"] == 675 and bench.state == "standstill"
    bench.start("gear", RatioDenominator=1, Acceleration=0.0)
    assert bench["gear.ErrorID"] == 676
    bench.start("gear", Acceleration=1.0, Deceleration=-1.0)
    assert bench["gear.ErrorID"] == 677


def test_gear_in_pos_meets_the_master(bench):
    bench.start("run", Velocity=400.0)
    bench.start("meet", MasterSyncPosition=300.0, SlaveSyncPosition=100.0, MasterStartDistance=200.0, RatioNumerator=1)
    assert bench["meet.Busy"] and not bench["meet.StartSync"] and bench.state == "synchronized"
    bench.until("meet.StartSync")
    assert bench["master.fSetPosition"] == pytest.approx(100.0, abs=1.0)
    bench.until("meet.InSync")
    bench.scan(100)
    assert bench["ax.fSetPosition"] - 100.0 == pytest.approx(bench["master.fSetPosition"] - 300.0)
    assert bench["ax.fSetVelocity"] == pytest.approx(400.0)


def test_gear_in_pos_fails_when_the_master_turns(bench):
    bench.start("run", 100, Velocity=400.0)
    bench.start("meet", 50, MasterSyncPosition=500.0, SlaveSyncPosition=100.0, RatioNumerator=1)
    bench["calm"] = False
    bench.start("run", 500, Velocity=-400.0, Direction=1)
    assert bench["meet.Error"] and bench["meet.ErrorID"] == 775 and bench.state == "errorstop"


def test_combine_adds_and_subtracts(bench):
    bench.start("combine", CombineMode=1, GearRatioNumeratorM1=2)
    assert bench["combine.InSync"] or bench["combine.Busy"]
    bench.start("run", Velocity=300.0)
    bench.start("run3", 300, Velocity=100.0)
    assert bench["combine.InSync"]
    assert bench["ax.fSetVelocity"] == pytest.approx(500.0)
    assert bench["ax.fSetPosition"] == pytest.approx(2 * bench["master.fSetPosition"] - bench["other.fSetPosition"])


def test_combine_ramps_to_masters_that_move(bench):
    bench["ax.fSWMaxAcceleration"] = 2000.0
    bench.start("run", Velocity=300.0)
    bench.start("run3", 300, Velocity=100.0)
    bench["jumpV"] = 0.0
    bench.start("combine", CombineMode=0)
    scans = bench.until("combine.InSync")
    assert scans == pytest.approx(200, abs=2) and bench["jumpV"] < 2.001  # 400 u/s with 2000 u/s2
    bench.scan(10)
    assert bench["ax.fSetVelocity"] == pytest.approx(400.0)
    away = bench["ax.fSetPosition"] - bench["master.fSetPosition"] - bench["other.fSetPosition"]
    bench.start("run", 200, Velocity=-50.0)
    assert bench["ax.fSetVelocity"] == pytest.approx(50.0)
    assert bench["ax.fSetPosition"] - bench["master.fSetPosition"] - bench["other.fSetPosition"] == pytest.approx(away)


@pytest.mark.parametrize(
    ("limits", "error"),
    [
        # from rest over 100 u in 0.5 s to 400 u/s: at most 400 u/s and 1440 u/s2, which only grows
        ({"Velocity": 399.0}, 40), ({"Acceleration": 1000.0}, 41), ({"Jerk": 5000.0}, 41), ({"Velocity": -1.0}, 676),
        ({"Jerk": -1.0}, 676), ({"Velocity": 401.0, "Acceleration": 2400.0, "Deceleration": 1.0}, 0),
        ({"Velocity": 0.0, "Acceleration": 0.0, "Deceleration": 0.0}, 0),
    ],
)  # fmt: skip
def test_gear_in_pos_keeps_its_limits(bench, limits, error):
    bench.start("run", 100, Velocity=400.0)
    start = bench["master.fSetPosition"]
    bench.start("meet", MasterSyncPosition=start + 200.0, SlaveSyncPosition=100.0, RatioNumerator=1, **limits)
    assert bench["meet.ErrorID"] == error and bench["meet.Busy"] == (error == 0)
    assert bench.state == ("synchronized" if error == 0 else "standstill")
    if error == 0:
        bench.until("meet.InSync")
        assert bench["fastest"] <= 401.0
    else:
        bench.scan(10)
        assert bench["ax.fSetPosition"] == 0.0


def test_gear_in_pos_does_not_jump(bench):
    """The master is at the place within a cycle, the slave is not."""
    bench.start("run", 100, Velocity=400.0)
    start = bench["master.fSetPosition"]
    limits = {"Velocity": 0.0, "Acceleration": 0.0, "Deceleration": 0.0}
    bench.start("meet", MasterSyncPosition=start + 0.3, SlaveSyncPosition=50.0, RatioNumerator=1, **limits)
    assert bench["meet.ErrorID"] == 40 and bench.state == "standstill"


def test_gear_in_pos_fails_when_the_master_gets_too_fast(bench):
    bench.start("run", 100, Velocity=100.0)
    bench.start("meet", 50, MasterSyncPosition=200.0, SlaveSyncPosition=100.0, RatioNumerator=1, Velocity=150.0)
    assert bench["meet.Busy"]
    bench["calm"] = False
    bench.start("run", 500, Velocity=400.0)
    assert bench["meet.ErrorID"] == 40 and bench.state == "errorstop"


def test_phase_shifts_the_master(bench):
    bench.start("phase", PhaseShift=10.0, Velocity=100.0)
    assert bench["phase.ErrorID"] == 34
    bench.start("run", 100, Velocity=400.0)
    bench.start("gear", **GEAR)
    bench.until("gear.InGear")
    before = bench["ax.fSetPosition"] - bench["master.fSetPosition"]
    bench.start("phase", PhaseShift=20.0)
    assert bench["phase.Busy"] and bench.state == "synchronized"
    bench.until("phase.Done")
    assert bench["ax.fSetPosition"] - bench["master.fSetPosition"] - before == pytest.approx(20.0)
    bench.start("further2", PhaseShift=-5.0, Velocity=100.0)
    bench.until("further2.Done")
    assert bench["ax.fSetPosition"] - bench["master.fSetPosition"] - before == pytest.approx(15.0)
    bench.start("phase", 20, PhaseShift=200.0)
    bench.start("gearOut", 3)
    assert bench["phase.CommandAborted"]


def moves(bench) -> None:
    """The slave has gone on by its velocity in each of some scans."""
    for _ in range(5):
        before, v = bench["ax.fSetPosition"], bench["ax.fSetVelocity"]
        bench.scan()
        assert bench["ax.fSetPosition"] - before == pytest.approx((v + bench["ax.fSetVelocity"]) / 2e3, abs=0.006)


def test_a_gear_takes_the_slave_of_another_coupling_over(bench):
    bench["ax.fSWMaxAcceleration"] = bench["ax.fSWMaxDeceleration"] = 5000.0
    bench.start("run", Velocity=400.0)
    bench.start("run3", 100, Velocity=100.0)
    bench.start("gear", **GEAR)
    bench.until("gear.InGear")
    for block, other, velocity in (("combine", "gear", 500.0), ("gear", "combine", 400.0)):
        bench.start(block, 2)
        assert bench[f"{block}.Active"] and bench[f"{other}.CommandAborted"] and bench.state == "synchronized"
        moves(bench)
        bench.until(f"{block}.{'InSync' if block == 'combine' else 'InGear'}", 300)
        moves(bench)
        assert bench["ax.fSetVelocity"] == pytest.approx(velocity)


def test_a_coupling_that_waits_begins_when_the_first_is_in_gear(bench):
    bench["ax.fSWMaxAcceleration"] = bench["ax.fSWMaxDeceleration"] = 5000.0
    bench.start("run", Velocity=400.0)
    bench.start("run3", 100, Velocity=100.0)
    bench.start("gear", 20, Acceleration=5000.0, RatioNumerator=2)
    bench.start("combine", 5, BufferMode=1)
    bench.start("halt", BufferMode=1)
    moves(bench)
    assert bench["gear.Active"] and bench["combine.Busy"] and not bench["combine.Active"]
    assert not bench["gear.InGear"] and bench["ax.fSetVelocity"] < 800.0
    bench.until("gear.InGear", 200)
    assert bench["ax.fSetVelocity"] == pytest.approx(800.0) and bench["gear.Busy"]
    moves(bench)
    assert bench["combine.Active"] and bench.outputs("gear") == "CommandAborted"
    bench.until("combine.InSync", 400)
    assert bench["ax.fSetVelocity"] == pytest.approx(500.0, abs=11.0)
    bench.scan()
    assert bench.outputs("combine") == "CommandAborted"
    bench.until("halt.Done")
    assert bench.state == "standstill"


def test_a_coupling_that_waits_behind_a_move_and_another_coupling(bench):
    bench.start("run", 100, Velocity=200.0)
    bench.start("relative", Distance=50.0)
    bench.start("gear", BufferMode=1, **GEAR)
    bench.start("combine", BufferMode=1)
    bench.until("relative.Done")
    bench.until("gear.CommandAborted", 200)
    bench.until("combine.InSync", 200)
    moves(bench)
    assert bench["ax.fSetVelocity"] == pytest.approx(200.0)


def test_a_jerk_limited_gear_keeps_the_acceleration_of_the_slave(bench):
    """With Jerk 50 000 u/s3 the acceleration changes by 50 u/s2 a scan."""
    bench.start("run", Velocity=4000.0, Acceleration=2000.0)
    bench.start("gear", 100, RatioNumerator=1, Acceleration=20000.0)
    assert bench["gear.InGear"] and bench["ax.fSetAcceleration"] == pytest.approx(2000.0)
    bench.start("gear", RatioNumerator=2, Jerk=50000.0)
    for i in range(5):
        assert bench["ax.fSetAcceleration"] == pytest.approx(2000.0 + 50.0 * i)
        bench.scan()


def test_a_gear_takes_changed_inputs(bench):
    bench.start("run", 100, Velocity=400.0)
    bench.start("gear", RatioNumerator=1, ContinuousUpdate=True, **GEAR)
    bench.until("gear.InGear")
    bench["gear.RatioNumerator"] = 2
    bench["gear.Acceleration"] = 2000.0
    bench.scan(2)
    assert bench["gear.Active"] and not bench["gear.InGear"]
    assert bench.until("gear.InGear") == pytest.approx(199, abs=2)  # 400 u/s with 2000 u/s2
    bench["gear.RatioDenominator"] = 0  # is none
    bench.scan(10)
    assert bench["ax.fSetVelocity"] == pytest.approx(800.0) and bench["gear.InGear"]
    bench["gear.ContinuousUpdate"] = False
    bench["gear.RatioDenominator"] = 4
    bench.scan(10)
    assert bench["ax.fSetVelocity"] == pytest.approx(800.0)


def test_a_gear_takes_another_source_of_the_masters_values(bench):
    """The motor of the master runs 100 ms behind: it still has half of the velocity or less."""
    bench.plc["SIM.Axis[2].drive.lag"] = 100.0
    bench.start("gear", 2, ContinuousUpdate=True, **GEAR)
    bench.start("run", 40, Velocity=200.0, Acceleration=20000.0)
    assert bench["gear.InGear"] and bench["ax.fSetVelocity"] == 200.0
    bench["gear.MasterValueSource"] = 1  # the motor, slower by about 200 * exp(-0.035 / 0.1)
    bench.scan(2)
    assert not bench["gear.InGear"]
    bench.until("gear.InGear")
    assert bench["ax.fSetVelocity"] == pytest.approx(bench["master.fActVelocity"]) and bench["ax.fSetVelocity"] < 150.0
    bench["gear.ContinuousUpdate"] = False
    bench["gear.MasterValueSource"] = 0
    bench.scan(20)
    assert bench["ax.fSetVelocity"] == pytest.approx(bench["master.fActVelocity"]) and bench["gear.InGear"]


def test_combined_axes_take_changed_ratios(bench):
    bench["ax.fSWMaxAcceleration"] = bench["ax.fSWMaxDeceleration"] = 5000.0
    bench.start("run", Velocity=300.0)
    bench.start("run3", 300, Velocity=100.0)
    bench.start("combine", ContinuousUpdate=True)
    bench.until("combine.InSync")
    bench["combine.GearRatioNumeratorM2"] = -1
    bench.scan(2)
    assert not bench["combine.InSync"]
    assert bench.until("combine.InSync") == pytest.approx(39, abs=2)  # 400 to 200 u/s with 5000 u/s2
    assert bench["ax.fSetVelocity"] == pytest.approx(200.0)

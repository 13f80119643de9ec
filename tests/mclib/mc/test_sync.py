"""Gears, cams and phases: a slave and its masters."""

import pytest

from plcruntime import PLC

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


def cam(bench, points, kind=3, **inputs):
    bench["table.byType"] = kind
    bench["table.nElements"] = len(points)
    for i, point in enumerate(points, 1):
        for name, value in zip(("dX", "dY", "dV", "dA"), point, strict=False):
            bench[f"table.Element[{i}].{name}"] = value
    bench.start("select", **inputs)


def camin(bench, **inputs):
    bench.take_cam()
    bench.start("cam", **inputs)


RISE = [(0, 0, 0, 0), (200, 100, 0, 0), (400, 0, 0, 0)]


def test_cam_is_followed_and_begins_anew(bench):
    cam(bench, RISE)
    assert bench["select.Done"]
    camin(bench)
    assert bench.state == "synchronized"
    bench.start("run", 2, Velocity=200.0)
    assert bench["cam.InSync"]
    worst = 0.0
    for _ in range(450):
        bench.scan(10)
        x = bench["master.fSetPosition"] % 400
        t = x / 200 if x < 200 else 2 - x / 200
        worst = max(worst, abs(bench["ax.fSetPosition"] - 100 * t**3 * (10 - 15 * t + 6 * t * t)))
    assert worst < 1e-6


def test_end_of_profile_is_a_pulse(bench):
    cam(bench, RISE)
    camin(bench)
    bench.start("run", Velocity=200.0)
    ends = []
    for _ in range(2100):
        bench.scan()
        if bench["cam.EndOfProfile"]:
            ends.append(bench["master.fSetPosition"])
    assert len(ends) == 1 and ends[0] == pytest.approx(400.0, abs=1.0)


def test_a_cam_that_is_not_periodic_rests_behind_its_end(bench):
    cam(bench, [(0, 0, 0, 0), (200, 100, 0, 0)], Periodic=False)
    camin(bench, SlaveScaling=2.0)
    bench.start("run", 1500, Velocity=200.0)
    assert bench["ax.fSetPosition"] == 200.0 and bench["ax.fSetVelocity"] == 0.0 and bench.state == "synchronized"
    bench.start("camOut", 2)
    assert bench["camOut.Done"] and bench["cam.CommandAborted"] and bench.state == "continuous"


def test_a_relative_cam_counts_from_where_the_axes_are(bench):
    bench.start("first", Position=70.0)
    bench.start("carry", Position=30.0)
    bench.until("first.Done")
    cam(bench, [(0, 0, 0, 0), (200, 100, 0, 0)], MasterAbsolute=False, SlaveAbsolute=False)
    camin(bench)
    bench.start("carry", Position=230.0)
    bench.until("carry.Done")
    bench.scan(2)
    assert bench["ax.fSetPosition"] == pytest.approx(170.0)
    bench.start("carry", Position=630.0)
    bench.until("carry.Done")
    bench.scan(2)
    assert bench["ax.fSetPosition"] == pytest.approx(370.0)  # each turn goes on from the one before


def test_a_cam_is_not_jumped_to(bench):
    bench.start("first", Position=70.0)
    bench.until("first.Done")
    cam(bench, RISE)
    camin(bench)
    assert bench["cam.ErrorID"] == 40 and bench.state == "standstill"
    camin(bench, StartMode=2, VelocityDiff=100.0)
    assert bench["cam.Busy"] and not bench["cam.InSync"]
    bench.until("cam.InSync")
    assert bench["ax.fSetPosition"] == pytest.approx(0.0, abs=1e-9)


TWO_CAMS = """
PROGRAM P
VAR
    m, s : AXIS_REF_SM3; on, on2 : MC_Power; run : MC_MoveVelocity; go : BOOL;
    a, b : MC_CamIn; selectA, selectB : MC_CamTableSelect;
    first : MC_CAM_REF := (byType := 2, nElements := 2); behind : MC_CAM_REF := (byType := 2, nElements := 2);
END_VAR
first.Element[2].dX := 100; first.Element[2].dY := 50; behind.Element[2].dX := 100;
on(Axis := m, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
on2(Axis := s, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
selectA(Master := m, Slave := s, CamTable := first, Execute := on2.Status);
selectB(Master := m, Slave := s, CamTable := behind, Execute := on2.Status);
run(Axis := m, Execute := on2.Status, Velocity := 200, Acceleration := 2000, Deceleration := 2000);
a(Master := m, Slave := s, Execute := selectA.Done, CamTableID := selectA.CamTableID);
b(Master := m, Slave := s, Execute := go, CamTableID := selectB.CamTableID, BufferMode := mcBuffered);
END_PROGRAM
"""


@pytest.mark.parametrize(("begin", "error"), [(50.0, 0), (20.0, 40)])
def test_a_cam_that_waits_is_not_jumped_to(begin, error):
    """Absolute cams: the first ends at 50; the second begins there, or somewhere else."""
    plc = PLC.load(TWO_CAMS)
    plc["P.behind.Element[1].dY"], plc["P.behind.Element[2].dY"] = begin, begin
    plc.scan(100)
    plc["P.go"] = True
    plc.run_until("P.a.EndOfProfile", timeout="2s")
    plc.scan(2)
    assert plc["P.m.fSetPosition"] == pytest.approx(100.0, abs=1.0) and plc["P.a.CommandAborted"]
    assert plc["P.b.ErrorID"] == error and plc["P.b.Busy"] == (error == 0)
    assert plc["P.s.nAxisState"] == (1 if error else 6) and plc["P.s.fSetPosition"] == pytest.approx(50.0, abs=0.25)


def test_a_periodic_cam_of_absolute_positions_has_to_end_where_it_begins(bench):
    cam(bench, [(0, 0), (100, 50)], 2)
    camin(bench)
    bench.start("run", 200, Velocity=200.0, Acceleration=2000.0)
    assert bench["cam.InSync"]
    bench["calm"] = False
    bench.until("cam.Error", 1000)
    assert bench["cam.ErrorID"] == 40 and bench["ax.fSetPosition"] == pytest.approx(50.0, abs=0.5)


@pytest.mark.parametrize(("mode", "sign"), [(2, -1), (3, 1), (4, -1)])
def test_a_modulo_slave_ramps_to_its_cam_in_a_direction(bench, mode, sign):
    """The slave stands at 30 degrees, the cam has it at 0: backwards is the shorter way."""
    bench["ax.iMovementType"] = 0
    bench.start("relative", Distance=30.0)
    bench.until("relative.Done")
    cam(bench, [(0, 0), (100, 0)], 2)
    way = bench.plc.axes[1].prfPos
    camin(bench, StartMode=mode, VelocityDiff=100.0)
    bench["calm"] = False  # the position passes the period
    bench.until("cam.InSync")
    assert bench.plc.axes[1].prfPos - way == pytest.approx(330.0 if sign > 0 else -30.0, abs=1e-6)


def test_lines_and_wrong_tables(bench):
    nan = float("nan")
    for wrong in ([(0, 0), (100, 50), (50, 0)], [(0, 0)], [(nan, 0), (100, 0)], [(0, 0), (100, nan)]):
        cam(bench, wrong)
        assert bench["select.ErrorID"] == 752, wrong  # SMC_CAM_TABLE_EMPTY_MASTER_RANGE
    cam(bench, [(0, 0), (100, 50)], 4)
    assert bench["select.ErrorID"] == 750  # SMC_NO_CAM_REF_TYPE
    bench.start("cam")
    assert bench["cam.ErrorID"] == 625  # SMC_CI_NO_CAM_SELECTED
    cam(bench, [(0, 0), (100, 50), (200, 150)], 2, Periodic=False)
    camin(bench, MasterScaling=0.0)
    assert bench["cam.ErrorID"] == 628  # SMC_CI_SCALING_INCORRECT
    bench["cam.MasterScaling"] = 1.0
    camin(bench, StartMode=2, VelocityDiff=0.0)
    assert bench["cam.ErrorID"] == 627  # SMC_CI_RAMPIN_NEEDS_VELACC_VALUES
    camin(bench, StartMode=0)
    bench["calm"] = False
    bench.start("carry", Position=150.0)
    bench.until("carry.Done")
    assert bench["ax.fSetPosition"] == pytest.approx(100.0)


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


def test_a_command_waits_for_the_end_of_a_cam(bench):
    """PLCopen Part 1, table 4: what waits behind MC_CamIn begins at EndOfProfile."""
    cam(bench, RISE)
    camin(bench)
    bench.start("run", Velocity=200.0)
    bench.start("first", 1000, Position=60.0, BufferMode=1)
    assert bench["cam.Active"] and bench["cam.InSync"] and not bench["first.Active"]
    bench.until("first.Active", 1200)
    assert bench["master.fSetPosition"] == pytest.approx(400.0, abs=1.0)
    bench.until("cam.EndOfProfile", 2)
    bench.scan()
    assert bench.outputs("cam") == "CommandAborted" and not bench["cam.EndOfProfile"]
    bench.until("first.Done")
    assert bench["ax.fSetPosition"] == 60.0


def test_a_command_behind_a_cam_that_is_over_begins_at_once(bench):
    cam(bench, [(50, 0, 0, 0), (200, 100, 0, 0)], Periodic=False)
    camin(bench)
    bench.start("run", Velocity=200.0)
    bench.start("gear", 300, BufferMode=1, **GEAR)
    assert bench["cam.Active"] and bench["master.fSetPosition"] > 50.0  # its beginning is not its end
    bench["gear.Execute"] = False
    bench.start("cam", 900)
    assert not bench["gear.Busy"] and bench["ax.fSetPosition"] == 100.0
    bench.start("gear", 3)
    assert bench["gear.Active"] and bench.outputs("cam") == "CommandAborted"


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


@pytest.mark.parametrize("block", ["gear", "meet", "cam"])
def test_a_coupling_started_anew_with_wrong_values_goes_on(bench, block):
    bench.start("run", Velocity=200.0)
    if block == "cam":
        cam(bench, RISE)
        camin(bench, StartMode=2, VelocityDiff=300.0)
        wrong = {"MasterScaling": 0.0}
    elif block == "meet":
        bench.start("meet", MasterSyncPosition=60.0, SlaveSyncPosition=30.0, RatioNumerator=1)
        wrong = {"MasterSyncPosition": 500.0, "SlaveSyncPosition": -500.0, "Velocity": 250.0}
    else:
        bench.start("gear", RatioNumerator=1)
        wrong = {"Acceleration": 0.0}
    bench.scan(500)
    away = bench["ax.fSetPosition"] - bench["master.fSetPosition"]
    bench.start(block, **wrong)
    assert bench.outputs(block) == "Error" and bench.state == "synchronized"
    bench.scan(100)
    if block == "cam":
        t = bench["master.fSetPosition"] / 200
        assert bench["ax.fSetPosition"] == pytest.approx(100 * t**3 * (10 - 15 * t + 6 * t * t))
    else:
        assert bench["ax.fSetPosition"] - bench["master.fSetPosition"] == pytest.approx(away)


def test_a_cam_takes_changed_offsets(bench):
    cam(bench, RISE)
    camin(bench, StartMode=2, VelocityDiff=100.0, ContinuousUpdate=True)
    bench.start("run", 100, Velocity=50.0)
    assert bench["cam.InSync"]
    bench["cam.SlaveOffset"] = 20.0
    bench.scan(2)
    assert not bench["cam.InSync"] and bench["cam.Active"]
    assert bench.until("cam.InSync") == pytest.approx(209, abs=3)  # 20 u with 100 u/s and 10 000 u/s2
    t = bench["master.fSetPosition"] / 200
    assert bench["ax.fSetPosition"] == pytest.approx(20 + 100 * t**3 * (10 - 15 * t + 6 * t * t), abs=0.02)
    bench["cam.SlaveScaling"] = 0.0  # is none
    bench.scan(2)
    assert bench["cam.InSync"]


def test_a_cam_without_a_ramp_takes_a_scaling_where_it_does_not_jump(bench):
    cam(bench, RISE)
    camin(bench, ContinuousUpdate=True)
    bench.start("run", 1000, Velocity=200.0)
    assert bench["ax.fSetPosition"] > 90.0
    bench["cam.SlaveScaling"] = 0.5
    bench.scan(2)
    assert bench["ax.fSetPosition"] > 90.0
    bench.scan(1998)
    assert bench["ax.fSetPosition"] == pytest.approx(50.0, abs=1.0)


@pytest.mark.parametrize(("at", "way", "speed"), [(100.0, 80.0, 0.9375), (0.0, 80.0, 0.0), (250.0, 120.0, -0.5273)])
def test_a_cam_is_joined_at_a_position_of_the_master(bench, at, way, speed):
    """From MasterStartDistance before MasterSyncPosition on the slave goes to the cam; speed: of the cam there."""
    cam(bench, RISE)
    camin(bench, MasterSyncPosition=at, MasterStartDistance=way, SlaveOffset=30.0)
    assert bench["cam.Busy"] and bench.state == "synchronized"
    bench.start("run", 40, Velocity=400.0, Acceleration=4000.0)
    turn = at if at >= way else at + 400.0
    while bench["master.fSetPosition"] < turn - way - 1.0:
        bench.scan()
        assert bench["ax.fSetPosition"] == 0.0 and not bench["cam.InSync"]
    bench["jumpV"] = 0.0
    bench.until("cam.InSync", 400)
    assert bench["master.fSetPosition"] == pytest.approx(turn, abs=0.9)
    assert bench["ax.fSetVelocity"] == pytest.approx(400.0 * speed, abs=4.0)
    for _ in range(20):
        bench.scan(20)
        x = bench["master.fSetPosition"] % 400
        t = x / 200 if x < 200 else 2 - x / 200
        assert bench["ax.fSetPosition"] == pytest.approx(30.0 + 100 * t**3 * (10 - 15 * t + 6 * t * t))


def test_the_master_turns_on_the_way_to_a_cam(bench):
    cam(bench, RISE)
    camin(bench, MasterSyncPosition=100.0, MasterStartDistance=80.0, SlaveOffset=30.0)
    bench.start("run", 200, Velocity=400.0)
    assert bench["cam.Active"]
    bench["calm"] = False
    bench.start("run", 300, Velocity=-400.0, Direction=1)
    assert bench["cam.ErrorID"] == 775 and bench.state == "errorstop"


def test_a_cam_that_is_too_late_to_be_joined_is_joined_in_the_next_turn(bench):
    cam(bench, RISE)
    bench.start("run", 350, Velocity=200.0)
    assert 60.0 < bench["master.fSetPosition"] < 80.0
    camin(bench, MasterSyncPosition=100.0, MasterStartDistance=80.0, SlaveOffset=30.0)
    bench.until("cam.InSync", 3000)
    assert bench["master.fSetPosition"] == pytest.approx(500.0, abs=0.5)

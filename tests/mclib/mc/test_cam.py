"""Cams: how a slave gets in, follows and leaves."""

import pytest

from plcruntime import PLC


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
    bench.start("gear", 300, BufferMode=1, Acceleration=5000.0, Deceleration=5000.0)
    assert bench["cam.Active"] and bench["master.fSetPosition"] > 50.0  # its beginning is not its end
    bench["gear.Execute"] = False
    bench.start("cam", 900)
    assert not bench["gear.Busy"] and bench["ax.fSetPosition"] == 100.0
    bench.start("gear", 3)
    assert bench["gear.Active"] and bench.outputs("cam") == "CommandAborted"


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

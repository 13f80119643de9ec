"""Gear mode (iDEABOX 3, 7.5): ratio, clutch, masters, directions, return codes."""

import random

import pytest

ENCODER, PROFILE, AXIS = 1, 2, 3


def gear(gt, master_even=2, slave_even=1, slope=0, *, dir=0, kind=PROFILE, item=0, master=1, slave=2):
    gt.ok("GT_PrfGear", slave, i=dir)
    gt.ok("GT_SetGearMaster", slave, i=master, j=kind, k=item)
    gt.ok("GT_SetGearRatio", slave, x=master_even, y=slave_even, z=slope)
    gt.ok("GT_GearStart", x=1 << (slave - 1))


def test_example_7_5_clutch(gt):
    gear(gt, 2, 1, 100000)
    gt.jog(1, 100.0)
    gt.follow(1, 2)
    gt.plc.scan(2000)
    for (x, vm, _), (y, vs, _) in zip(gt.rows(1), gt.rows(2), strict=True):
        if x <= 100000:
            # the ratio grows evenly with the way of the master
            assert y == pytest.approx(x * x / 400000, abs=1e-6) and vs == pytest.approx(vm * x / 200000, abs=1e-9)
        else:
            assert y == pytest.approx(25000 + (x - 100000) / 2, abs=1e-6) and vs == pytest.approx(50.0, abs=1e-9)


def test_figure_7_10_ratio_changed_while_moving_and_kept_when_the_master_changes_speed(gt):
    gt.jog(1, 40.0)
    gt.plc.scan(100)
    gear(gt, 4, 3, 4000)
    gt.plc.scan(200)
    assert gt.axis(2).prfVel == pytest.approx(30.0)
    gt.follow(1, 2)
    gt.ok("GT_SetGearRatio", 2, x=2, y=1, z=2000)
    gt.plc.scan(24)
    assert 20.0 < gt.axis(2).prfVel < 30.0
    gt.plc.scan(30)
    assert gt.axis(2).prfVel == pytest.approx(20.0)
    gt.jog(1, 10.0)
    gt.plc.scan(100)
    assert gt.axis(2).prfVel == pytest.approx(5.0)
    for (p, v, _), (q, w, _) in zip(gt.rows(2), gt.rows(2)[1:], strict=False):
        assert q - p == pytest.approx((v + w) / 2, abs=0.01) and abs(v - w) < 0.6


def test_without_a_clutch_the_ratio_holds_at_once(gt):
    gear(gt, 3, -5)
    gt.jog(1, 30.0)
    gt.plc.scan(500)
    assert gt.axis(2).prfPos == pytest.approx(gt.axis(1).prfPos * -5 / 3, abs=1e-9)
    assert gt.axis(2).prfVel == pytest.approx(-50.0) and gt.axis(2).position == 0.0  # servo off: the planner moves


def test_motion_flag_until_gt_stop(gt):
    gt.ok("GT_AxisOn", 2)
    gear(gt, 1, 1)
    gt.plc.scan(5)
    assert gt.read("GT_GetSts", 2) == 0x600 and gt.read("GT_GetPrfMode", 2) == 3
    gt.jog(1, 20.0)
    gt.plc.scan(50)
    gt.ok("GT_Stop", x=2)
    gt.plc.scan(30)
    assert gt.read("GT_GetSts", 2) == 0x200 and gt.axis(1).moving
    gt.ok("GT_GearStart", x=2)  # again, from where it is
    before = gt.axis(2).prfPos - gt.axis(1).prfPos
    gt.plc.scan(50)
    assert gt.axis(2).prfPos - gt.axis(1).prfPos == pytest.approx(before)


@pytest.mark.parametrize("dir", [0, 1, -1])
def test_direction(gt, dir):
    """Up, further down, up again; a slave of one direction sums up the way in that direction only."""
    gear(gt, 2, 1, dir=dir)
    gt.follow(1, 2)
    for vel in (10.0, -15.0, 10.0):
        gt.jog(1, vel)
        gt.plc.scan(100)
    way, last = 0.0, 0.0
    for (x, v, _), (y, w, _) in zip(gt.rows(1), gt.rows(2), strict=True):
        followed = (x - last) * dir >= 0
        way += (x - last) / 2 * followed
        last = x
        assert y == pytest.approx(way, abs=1e-9)
        assert w == pytest.approx(v / 2 if followed else 0.0)


def test_masters(gt):
    for axis in (1, 2):
        gt.ok("GT_AxisOn", axis)
    gt.ok("GT_ProfileScale", i=2, j=1)
    gt.ok("GT_EncScale", i=4, j=1)
    gt.ok("GT_AxisOff")
    gt.ok("GT_AxisOn")
    for slave, (kind, item) in enumerate([(PROFILE, 0), (ENCODER, 0), (AXIS, 0), (AXIS, 1)], 2):
        gear(gt, 1, 1, kind=kind, item=item, slave=slave)
    gt.jog(1, 16.0)
    gt.plc.scan(100)
    profile = gt.axis(1).prfPos
    assert [gt.axis(n).prfPos for n in (2, 3, 4, 5)] == pytest.approx([profile, profile / 2, profile / 2, profile / 8])
    assert [gt.axis(n).prfVel for n in (2, 3, 4, 5)] == pytest.approx([16.0, 8.0, 8.0, 2.0])


def test_a_master_with_a_lag_pulls_its_encoder_follower_behind(gt):
    gt.ok("GT_AxisOn")
    gt.plc["SIM.Axis[1].drive.lag"] = 5.0
    gear(gt, 1, 1, kind=ENCODER)
    gt.jog(1, 20.0)
    gt.plc.scan(200)
    assert gt.axis(1).prfPos - gt.axis(2).prfPos == pytest.approx(100.0, abs=1e-6)  # 20 pulse/ms * 5 ms


def test_setting_the_masters_position_moves_no_slave(gt):
    gt.ok("GT_AxisOn")
    for slave, (kind, item) in enumerate([(PROFILE, 0), (ENCODER, 0), (AXIS, 0), (AXIS, 1)], 2):
        gear(gt, 1, 1, kind=kind, item=item, slave=slave)
    gt.ok("GT_SetPrfPos", x=12345)
    gt.ok("GT_SetEncPos", x=-777)
    gt.ok("GT_SynchAxisPos", x=1)
    gt.ok("GT_ZeroPos")
    assert [gt.axis(n).prfPos for n in (2, 3, 4, 5)] == [0.0] * 4
    gt.jog(1, 10.0)
    gt.plc.scan(50)
    assert [gt.axis(n).prfPos for n in (2, 3, 4, 5)] == pytest.approx([gt.axis(1).prfPos] * 4)


def test_chain_of_slaves_and_a_slave_before_its_master(gt):
    gear(gt, 2, 1, slave=3)
    gear(gt, 2, 1, master=3, slave=4)
    gear(gt, 2, 1, master=3, slave=2)  # a smaller number: a scan behind (7.5.2 (2))
    gt.jog(1, 80.0, 4.0)
    gt.plc.scan(50)
    before = gt.axis(3).prfPos
    assert gt.axis(4).prfPos == before / 2
    gt.plc.scan()
    assert gt.axis(2).prfPos == pytest.approx(before / 2, abs=1e-9)


def test_towards_a_flagged_limit_the_slave_does_not_move(gt):
    """9.2: not even for one scan; away from it, it does."""
    gt.ok("GT_AxisOn", 2)
    gt.axis(2).switches.positive = True
    gt.plc.scan()
    gear(gt, 1, 1)
    gt.jog(1, 10.0)
    gt.follow(2)
    gt.plc.scan(20)
    assert {(p, v) for p, v, _ in gt.rows(2)} == {(0.0, 0.0)} and not gt.axis(2).moving
    gt.jog(1, -10.0)
    gt.plc.scan(40)
    gt.ok("GT_GearStart", x=2)
    gt.plc.scan(10)
    assert gt.axis(2).prfVel == -10.0 and gt.axis(2).moving


def test_a_limit_stops_the_slave(gt):
    gt.ok("GT_AxisOn", 2)
    gear(gt, 1, 1)
    gt.jog(1, 10.0)
    gt.plc.scan(50)
    gt.plc["SIM.Axis[2].switches.positive"] = True
    gt.plc.scan(2)
    assert not gt.axis(2).moving and gt.axis(1).moving
    assert gt.read("GT_GetSts", 2) & 0x20
    gt.ok("GT_GearStart", x=2)  # the other way is allowed, this one is not
    gt.plc.scan(3)
    assert not gt.axis(2).moving


def test_return_codes(gt):
    for command in ("GT_SetGearMaster", "GT_GetGearMaster", "GT_SetGearRatio", "GT_GetGearRatio"):
        assert gt(command, 2, i=1, j=2, x=1, y=1) == 1 and "GT_PrfGear" in gt.why, command
        assert gt(command, 0) == 7 and gt(command, 13) == 7
    assert gt("GT_GearStart", x=2) == 1
    assert gt("GT_PrfGear", 2, i=2) == 7 and gt("GT_PrfGear", 2, i=-2) == 7 and gt("GT_PrfGear", 13) == 7
    gt.ok("GT_PrfGear", 2, i=1)
    assert gt("GT_PrfGear", 2, i=0) == 1 and "dir" in gt.why
    gt.ok("GT_PrfGear", 2, i=1)
    assert gt("GT_GearStart", x=2) == 1 and "master" in gt.why
    for bad in ({"i": 2, "j": 2}, {"i": 0, "j": 2}, {"i": 13, "j": 2}, {"i": 1, "j": 0}, {"i": 1, "j": 4},
                {"i": 1, "j": 3, "k": 2}):  # fmt: skip
        assert gt("GT_SetGearMaster", 2, **bad) == 7, bad
    gt.ok("GT_SetGearMaster", 2, i=1, j=3, k=1)
    gt.ok("GT_GetGearMaster", 2)
    assert [gt["oi"], gt["oj"], gt["ok"]] == [1, 3, 1]
    assert gt("GT_GearStart", x=2) == 1 and "ratio" in gt.why
    for bad in ({"x": 0}, {"x": -1}, {"x": 1, "z": 1}, {"x": 1, "z": -1}):
        assert gt("GT_SetGearRatio", 2, **bad) == 7, bad
    gt.ok("GT_SetGearRatio", 2, x=4, y=-3, z=2)
    gt.ok("GT_GetGearRatio", 2)
    assert [gt["ox"], gt["oy"], gt["oz"]] == [4, -3, 2]
    assert gt("GT_GearStart", x=0) == 7 and gt("GT_GearStart", x=0x1000) == 7
    gt.ok("GT_GearStart", x=2)
    gt.ok("GT_GearStart", x=2)
    assert gt("GT_PrfGear", 2, i=1) == 1 and gt("GT_SetGearMaster", 2, i=3, j=2) == 1 and gt("GT_PrfTrap", 2) == 1
    gt.ok("GT_Reset")
    gt.ok("GT_PrfGear", 2, i=0)
    assert gt("GT_GearStart", x=2) == 1  # nothing is left of the master


def test_random_masters_and_ratios(gt):
    """Velocity is the slope of the position, it jumps nowhere, and after the clutch the ratio is exact."""
    rng = random.Random(5)
    gear(gt, 1, 1, 500)
    gt.follow(1, 2)
    for _ in range(150):
        gt.jog(1, rng.uniform(-50, 50), 1.0)
        gt.plc.scan(rng.randint(1, 60))
        gt.ok("GT_SetGearRatio", 2, x=rng.randint(1, 9), y=rng.randint(-20, 20), z=rng.randint(1000, 3000))
        gt.plc.scan(rng.randint(1, 60))
    rows = gt.rows(2)
    for (p, v, _), (q, w, _) in zip(rows, rows[1:], strict=False):
        # masters turn at 1 pulse/ms2, ratios up to 20, the clutch adds ratio / 1000 pulse * velocity2
        assert abs(w - v) < 20 + 40 * 50 * 50 / 1000 and abs(q - p - (v + w) / 2) < 10
    gt.jog(1, 40.0)
    gt.ok("GT_SetGearRatio", 2, x=7, y=3, z=100)
    gt.plc.scan(200)
    x, y = gt.axis(1).prfPos, gt.axis(2).prfPos
    gt.plc.scan(1000)
    assert gt.axis(2).prfPos - y == pytest.approx((gt.axis(1).prfPos - x) * 3 / 7, abs=1e-6)

"""Limits, alarm, configuration files, in-position, following error, servo off."""

import pytest
from controller import ALARM, ENABLED, IN_POSITION, MOVING, NEGATIVE, POSITIVE, Controller


@pytest.fixture
def gt() -> Controller:
    return Controller()


def test_soft_limit_stops_flags_and_blocks_one_direction(gt):
    assert gt("GT_SetSoftLimit", x=-5, y=-5) == 7
    assert gt("GT_SetSoftLimit", x=500, y=-500) == 0
    gt("GT_AxisOn")
    gt.trap(target=10000)
    gt.run(150)
    assert gt.status == ENABLED | POSITIVE
    assert 500 < gt.axis.prfPos < 511
    assert gt("GT_Update", x=1) == 1 and "positive limit" in gt.why
    assert gt("GT_ClrSts") == 0 and gt.status & POSITIVE  # still beyond it
    gt("GT_SetPos", x=0)
    assert gt("GT_Update", x=1) == 0
    gt.run(150)
    assert gt.axis.prfPos == 0.0 and gt.status & POSITIVE  # latched
    assert gt("GT_ClrSts") == 0 and gt.status == ENABLED


def test_limit_switch_and_its_switching_off(gt):
    gt("GT_AxisOn")
    gt.axis.switches.negative = True
    gt.run(1)
    assert gt.status & NEGATIVE
    assert gt("GT_LmtsOff", n=1) == 0
    assert gt.status & NEGATIVE
    gt("GT_ClrSts")  # now it counts
    assert gt.status == ENABLED
    assert gt("GT_LmtsOn", n=-1) == 0 and gt.status == ENABLED
    gt("GT_ClrSts")
    assert gt.status & NEGATIVE
    assert gt("GT_LmtsOff", n=2) == 7


def test_alarm_switches_the_servo_off_and_latches(gt):
    gt("GT_AxisOn")
    gt.trap(target=100000)
    gt.run(50)
    gt.axis.drive.alarm = True
    gt.run(2)  # planned motion, too, has come to its emergency stop
    assert gt.status == ALARM
    position = gt.axis.position
    assert gt("GT_AxisOn") == 1 and "alarm" in gt.why
    gt("GT_ClrSts")
    assert gt.status == ALARM
    gt.axis.drive.alarm = False
    gt.run(1)
    assert gt.status == ALARM
    assert gt("GT_ClrSts") == 0 and gt.status == 0
    assert gt("GT_AxisOn") == 0 and gt.status == ENABLED
    assert gt.axis.position == position


def test_an_alarm_stops_the_planning_with_the_emergency_deceleration(gt):
    """9.3: servo off, emergency stop of what is planned; the motor stands at once."""
    gt("GT_AxisOn")
    assert gt("GT_SetStopDec", v=1.0, w=0.5) == 0
    gt.trap(target=100000, vel=20.0)
    gt.run(100)
    gt.axis.drive.alarm = True
    gt.run(1)
    planned, stood = gt.axis.prfPos, gt.axis.position
    assert gt.axis.prfVel == 20.0
    gt.run(20)
    assert gt.axis.prfVel == 10.0 and gt.axis.position == stood
    assert gt.status == ALARM | MOVING and gt("GT_Update", x=1) == 1
    gt.run(18)
    assert gt.status == ALARM and gt.axis.prfPos == pytest.approx(planned + 20 * 20 / 2 / 0.5)
    assert gt.axis.position == stood and gt.axis.state == 0


def test_a_muted_alarm_does_nothing(gt):
    gt("GT_AlarmOff")
    gt("GT_ClrSts")
    gt("GT_AxisOn")
    gt.axis.drive.alarm = True
    gt.run(1)
    assert gt.status == ENABLED


def test_configuration_file_without_signals(gt):
    assert gt("GT_LoadConfig", file="test.cfg") == 0
    gt("GT_ClrSts", n=12)
    gt("GT_AxisOn")
    gt.axis.drive.alarm = True
    gt.axis.switches.positive = True
    gt.run(1)
    assert gt.status == ENABLED
    assert gt("GT_AlarmOff") == 1 and gt("GT_LmtsOff", n=-1) == 1  # the file says so already
    assert gt("GT_LoadConfig", file="no such file.cfg") == 7 and "no such file" in gt.why
    assert gt("GT_LoadConfig", file="x" * 126) == 7 and "125" in gt.why


def test_in_position_after_the_hold_time(gt):
    gt("GT_AxisOn")
    gt.axis.drive.lag = 5.0
    assert gt("GT_SetAxisBand", x=2, y=16) == 0  # 16 * 250 us = 4 ms
    gt.trap(target=100, vel=10.0)
    while gt.status & MOVING:
        assert not gt.status & IN_POSITION
    seen = [abs(gt.axis.prfPos - gt.axis.position)]
    while not gt.status & IN_POSITION:
        seen.append(abs(gt.axis.prfPos - gt.axis.position))
    assert len(seen) > 4 and seen[-1] < 2.0
    assert gt("GT_GetAxisBand") == 0 and (gt.get("x"), gt.get("y")) == (2, 16)


def test_lag_is_lag_times_velocity(gt):
    gt("GT_AxisOn")
    gt.axis.drive.lag = 5.0
    gt.trap(target=100000, vel=10.0)
    gt.run(200)
    assert gt.axis.prfPos - gt.axis.position == pytest.approx(50.0)
    assert gt.axis.velocity == pytest.approx(10.0)
    assert gt("GT_SetPosErr", x=49) == 0
    gt.run(1)
    assert gt.status & 0x10
    assert gt("GT_GetAxisError") == 0 and gt.get("values")[0] == pytest.approx(50.0)


def test_encoder_resolution(gt):
    gt("GT_AxisOn")
    gt.axis.drive.resolution = 4.0
    gt.trap(target=101, vel=1.0)
    gt.run(200)
    gt("GT_GetEncPos")
    assert gt.get("values")[0] == 100.0


def test_servo_off_leaves_the_motor_where_it_is(gt):
    gt.trap(target=100)  # planning goes on without the servo
    gt.run(100)
    assert gt.axis.prfPos == 100.0 and gt.axis.position == 0.0
    assert gt("GT_AxisOn") == 0
    assert gt("GT_ZeroPos") == 0
    assert gt.axis.prfPos == 0.0
    gt("GT_SetPos", x=50)
    gt("GT_Update", x=1)
    gt.run(100)
    assert gt.axis.position == 50.0

"""GT_ commands: return codes under the documented conditions, Trap, Jog, stops, positions, clock."""

import pytest
from controller import MOVING, Controller


@pytest.fixture
def gt() -> Controller:
    return Controller()


MODES = ("GT_PrfTrap", "GT_PrfJog")
SINGLE = ["GT_AxisOn", "GT_AxisOff", "GT_PrfTrap", "GT_PrfJog", "GT_SetPos", "GT_SetVel", "GT_AlarmOff", "GT_GetSts"]


@pytest.mark.parametrize("axis", [0, 13, -1])
@pytest.mark.parametrize("command", SINGLE)
def test_axis_numbers_are_1_to_12(gt, command, axis):
    assert gt(command, a=axis) == 7
    assert "12" in gt.why


@pytest.mark.parametrize(
    ("axis", "count", "code"), [(1, 12, 0), (12, 1, 0), (12, 2, 7), (1, 13, 7), (1, 0, 7), (5, 32767, 7)]
)
def test_count_may_not_run_past_the_last_axis(gt, axis, count, code):
    assert gt("GT_GetPrfMode", a=axis, n=count) == code


def test_at_most_8_encoders_a_call_and_no_null_pointer(gt):
    assert gt("GT_GetEncPos", n=8) == 0
    assert gt("GT_GetEncPos", n=9) == 7
    assert gt(46) == 7


@pytest.mark.parametrize("command", ["GT_SetTrapPrm", "GT_GetTrapPrm", "GT_SetPos", "GT_GetPos"])
def test_trap_commands_need_trap_mode(gt, command):
    assert gt("GT_PrfJog") == 0
    assert gt(command) == 1
    assert "GT_PrfTrap" in gt.why


@pytest.mark.parametrize("command", ["GT_SetJogPrm", "GT_GetJogPrm"])
def test_jog_commands_need_jog_mode(gt, command):
    assert gt(command) == 1
    assert "GT_PrfJog" in gt.why


@pytest.mark.parametrize(
    ("prm", "code"),
    [
        ({"acc": 1.0, "dec": 0.0, "velStart": 0.0, "smoothTime": 50}, 0), ({"acc": 0.0}, 7), ({"acc": -1.0}, 7),
        ({"acc": 1.0, "dec": -1.0}, 7), ({"acc": 1.0, "smoothTime": 51}, 7), ({"acc": 1.0, "smoothTime": -1}, 7),
        ({"acc": 1.0, "velStart": -1.0}, 7),
    ],
)  # fmt: skip
def test_ranges_of_trap_parameters(gt, prm, code):
    assert gt("GT_SetTrapPrm", trap=prm) == code


@pytest.mark.parametrize(("smooth", "code"), [(0.0, 0), (0.99, 0), (1.0, 7), (-0.1, 7)])
def test_ranges_of_jog_parameters(gt, smooth, code):
    assert gt("GT_PrfJog") == 0
    assert gt("GT_SetJogPrm", jog={"acc": 1.0, "dec": 0.0, "smooth": smooth}) == code


def test_a_deceleration_that_is_not_set_is_the_acceleration(gt):
    """13 commands 113 and 125."""
    assert gt("GT_SetTrapPrm", trap={"acc": 0.5, "dec": 0.0}) == 0 and gt("GT_GetTrapPrm") == 0
    assert gt.get("trap")["dec"] == 0.5
    assert gt("GT_PrfJog") == 0 and gt("GT_SetJogPrm", jog={"acc": 0.25, "dec": 0.0, "smooth": 0.0}) == 0
    assert gt("GT_GetJogPrm") == 0 and gt.get("jog")["dec"] == 0.25


@pytest.mark.parametrize(("x", "code"), [(1073741823, 0), (1073741824, 7), (-1073741823, 0), (-1073741824, 7)])
def test_range_of_target_position(gt, x, code):
    assert gt("GT_SetPos", x=x) == code
    if code == 0:
        assert gt("GT_GetPos") == 0 and gt.get("x") == x


def test_commands_refused_while_moving(gt):
    gt("GT_AxisOn")
    gt.trap(target=100000)
    for command in (*MODES, "GT_SetTrapPrm", "GT_SetPrfPos", "GT_ZeroPos", "GT_AxisOn", "GT_ProfileScale"):
        assert gt(command, p=1, q=1) == 1, command
        assert "GT_Stop" in gt.why
    assert gt("GT_LoadConfig", file="test.cfg") == 1
    assert gt("GT_GetTrapPrm") == 0


def test_update_needs_parameters(gt):
    assert gt("GT_SetPos", x=100) == 0
    assert gt("GT_SetVel", v=1.0) == 0
    assert gt("GT_Update", x=1) == 1 and "GT_SetTrapPrm" in gt.why
    assert gt("GT_Update", x=0) == 7
    assert gt("GT_Update", x=1 << 12) == 7


def test_update_of_several_axes_starts_all_or_none(gt):
    gt.trap(target=0)
    gt("GT_SetPos", x=500)
    assert gt("GT_Update", x=3) == 1  # axis 2 has no acceleration
    gt.run(5)
    assert gt.axis.prfPos == 0.0


def test_start_velocity(gt):
    gt("GT_AxisOn")
    gt.trap(target=1000, vel=10.0, acc=0.1, start=4.0)
    assert gt.axis.prfVel == pytest.approx(4.1)
    gt.run(400)
    assert gt.axis.prfPos == 1000.0


def test_target_and_velocity_change_on_the_fly(gt):
    gt("GT_AxisOn")
    gt.trap(target=10000, vel=10.0, acc=0.5, smooth=10)
    gt.run(100)
    assert gt("GT_SetVel", v=20.0) == 0 and gt("GT_SetPos", x=-500) == 0 and gt("GT_Update", x=1) == 0
    speeds = []
    for _ in range(400):
        gt.run(1)
        speeds.append(gt.axis.prfVel)
    assert gt.axis.prfPos == -500.0 and min(speeds) >= -20.0 - 1e-9
    assert max(abs(b - a) for a, b in zip(speeds, speeds[1:], strict=False)) <= 0.5 + 1e-9


def test_jog_smoothing_makes_the_ramp_longer_and_keeps_the_acceleration(gt):
    gt("GT_AxisOn")
    gt("GT_PrfJog")
    gt("GT_SetJogPrm", jog={"acc": 0.1, "dec": 0.1, "smooth": 0.5})
    gt("GT_SetVel", v=10.0)
    assert gt("GT_Update", x=1) == 0
    gt.run(73)
    assert gt.axis.prfVel == pytest.approx(5.0, rel=0.02)  # the middle of 100 ms * 1.5
    assert gt.axis.prfAcc == pytest.approx(0.1)
    gt.run(78)
    assert gt.axis.prfVel == 10.0 and gt.axis.prfAcc == 0.0


@pytest.mark.parametrize(("option", "dec"), [(0, 0.5), (1, 5.0)])
def test_stop_smooth_and_abrupt(gt, option, dec):
    gt("GT_AxisOn")
    assert gt("GT_SetStopDec", v=0.5, w=5.0) == 0
    gt.trap(target=100000, vel=10.0)
    gt.run(100)
    assert gt.axis.prfVel == 10.0
    assert gt("GT_Stop", x=1, y=option) == 0
    assert gt.axis.prfVel == pytest.approx(10.0 - dec)
    gt.run(20)
    assert not gt.status & MOVING


@pytest.mark.parametrize(("v", "w", "code"), [(0.0, 1.0, 7), (1.0, 32768.0, 7), (32767.0, 32767.0, 0)])
def test_ranges_of_stop_decelerations(gt, v, w, code):
    assert gt("GT_SetStopDec", v=v, w=w) == code


def test_positions_given_and_synchronised(gt):
    gt("GT_AxisOn")
    gt.trap(target=100)
    gt.run(100)
    assert gt("GT_SetPrfPos", x=5000) == 0
    gt("GT_GetAxisPrfPos")
    assert gt.axis.prfPos == 5000.0 and gt.axis.position == 100.0 and gt.get("values")[0] == 100.0
    assert gt("GT_SynchAxisPos", x=0) == 1
    assert gt("GT_SynchAxisPos", x=1) == 0
    gt("GT_GetAxisPrfPos")
    assert gt.get("values")[0] == 5000.0
    assert gt("GT_SetEncPos", x=5000) == 0
    gt("GT_GetEncPos")
    assert gt.get("values")[0] == 5000.0
    gt("GT_GetAxisEncPos")
    assert gt.get("values")[0] == 100.0
    gt("GT_SynchAxisPos", x=1)
    gt("GT_GetAxisError")
    assert gt.get("values")[0] == 0.0


def test_profile_scale(gt):
    assert gt("GT_ProfileScale", p=1, q=2) == 7
    assert gt("GT_ProfileScale", p=0, q=0) == 7
    assert gt("GT_ProfileScale", p=2, q=1) == 0
    gt("GT_AxisOn")
    gt.trap(target=100)
    gt.run(100)
    gt("GT_GetAxisPrfPos")
    assert gt.axis.prfPos == 100.0 and gt.axis.position == 50.0 and gt.get("values")[0] == 50.0


def test_open_close_reset_and_clock(gt):
    assert gt("GT_Open") == 0 and gt("GT_Open") == -6
    assert gt("GT_Close") == 0 and gt("GT_Close") == 1
    gt.run(96)
    assert gt("GT_GetClock") == 0 and gt.get("clock") == 100
    gt("GT_AxisOn")
    gt.trap(target=100)
    gt.run(10)
    assert gt("GT_Reset") == 0
    assert gt.status == 0 and gt.axis.prfPos == 0.0
    assert gt("GT_GetClock") == 0 and gt.get("clock") == 2


def test_velocities_and_accelerations_read_alike(gt):
    gt("GT_AxisOn")
    gt.trap(target=10000, vel=100.0, acc=0.5)
    gt.run(10)
    for command, value in (("GT_GetPrfAcc", 0.5), ("GT_GetAxisEncAcc", 0.5)):
        assert gt(command) == 0 and gt.get("values")[0] == value
    gt("GT_GetPrfVel")
    first = gt.get("values")[0]
    gt("GT_GetEncVel")
    assert gt.get("values")[0] == first + 0.5


def test_refusals_are_noted_with_command_and_reason(gt):
    gt("GT_SetJogPrm", a=3)
    last = gt.plc["SIM.refused"][0]
    assert (last["command"], last["axis"], last["code"]) == ("GT_SetJogPrm", 3, 1)

"""GT_ commands: return codes under the documented conditions, status word, limits, alarm, in-position, Jog, Trap.

Commands are called from a PROGRAM whose variables are the arguments; 'job' says which one runs in the next scan.
"""

import pytest

from plcruntime import PLC

COMMANDS = {
    1: "GT_AxisOn(a)", 2: "GT_AxisOff(a)", 3: "GT_ClrSts(a, n)", 4: "GT_PrfTrap(a)", 5: "GT_PrfJog(a)",
    6: "GT_SetTrapPrm(a, ADR(trap))", 7: "GT_GetTrapPrm(a, ADR(trap))", 8: "GT_SetJogPrm(a, ADR(jog))",
    9: "GT_GetJogPrm(a, ADR(jog))", 10: "GT_SetPos(a, x)", 11: "GT_GetPos(a, ADR(x))", 12: "GT_SetVel(a, v)",
    13: "GT_GetVel(a, ADR(v))", 14: "GT_Update(x)", 15: "GT_Stop(x, y)", 16: "GT_SetPrfPos(a, x)",
    17: "GT_ZeroPos(a, n)", 18: "GT_GetPrfPos(a, ADR(values), n, ADR(clock))", 19: "GT_GetSts(a, ADR(words), n)",
    20: "GT_SetSoftLimit(a, x, y)", 21: "GT_GetSoftLimit(a, ADR(x), ADR(y))", 22: "GT_SetStopDec(a, v, w)",
    23: "GT_GetStopDec(a, ADR(v), ADR(w))", 24: "GT_SetAxisBand(a, x, y)", 25: "GT_GetAxisBand(a, ADR(x), ADR(y))",
    26: "GT_Open()", 27: "GT_Close()", 28: "GT_Reset()", 29: "GT_GetClock(ADR(clock))", 30: "GT_LmtsOff(a, n)",
    31: "GT_LmtsOn(a, n)", 32: "GT_AlarmOff(a)", 33: "GT_AlarmOn(a)", 34: "GT_ProfileScale(a, p, q)",
    35: "GT_EncScale(a, p, q)", 36: "GT_SetEncPos(a, x)", 37: "GT_SynchAxisPos(x)",
    38: "GT_GetPrfMode(a, ADR(words), n)", 39: "GT_GetEncPos(a, ADR(values), n)",
    40: "GT_GetAxisPrfPos(a, ADR(values), n)", 41: "GT_GetAxisEncPos(a, ADR(values), n)",
    42: "GT_GetAxisError(a, ADR(values), n)", 43: "GT_SetPosErr(a, x)", 44: "GT_GetPosErr(a, ADR(x))",
    45: "GT_LoadConfig(file)", 46: "GT_GetPrfPos(a, 0, n)", 47: "GT_GetEncVel(a, ADR(values), n)",
    48: "GT_GetAxisEncAcc(a, ADR(values), n)", 49: "GT_GetPrfAcc(a, ADR(values), n)",
    50: "GT_GetPrfVel(a, ADR(values), n)",
}  # fmt: skip
PROGRAM = f"""
PROGRAM PLC_PRG
VAR
    job, a, n, p, q, rtn : INT; x, y : DINT; v, w : LREAL; clock : UDINT; file : STRING(200);
    trap : TTrapPrm; jog : TJogPrm; values : ARRAY[0..11] OF LREAL; words : ARRAY[0..11] OF DINT;
END_VAR
CASE job OF
{"".join(f"    {n}: rtn := {c};" + chr(10) for n, c in COMMANDS.items())}
END_CASE
job := 0;
END_PROGRAM
"""
NUMBER = {c[: c.index("(")]: n for n, c in reversed(COMMANDS.items())}
ALARM, POSITIVE, NEGATIVE, ENABLED, MOVING, IN_POSITION = (1 << n for n in (1, 5, 6, 9, 10, 11))


class Controller:
    def __init__(self) -> None:
        self.plc = PLC.load(PROGRAM)
        self.axis = self.plc.axes[1]

    def __call__(self, command: str | int, **inputs) -> int:
        """Run one command in one scan and give what it returned."""
        for name, value in {"a": 1, "n": 1, **inputs}.items():
            self.plc[f"PLC_PRG.{name}"] = value
        self.plc["PLC_PRG.job"] = NUMBER[command] if isinstance(command, str) else command
        self.plc.scan()
        return self.plc["PLC_PRG.rtn"]

    def get(self, name: str):
        return self.plc[f"PLC_PRG.{name}"]

    @property
    def status(self) -> int:
        assert self("GT_GetSts") == 0
        return self.get("words")[0]

    @property
    def why(self) -> str:
        return self.plc["SIM.refused"][(self.plc["SIM.refusals"] - 1) % 32]["why"]

    def trap(self, target=1000, vel=10.0, acc=1.0, dec=0.0, smooth=0, start=0.0) -> None:
        assert self("GT_PrfTrap") == 0
        assert self("GT_SetTrapPrm", trap={"acc": acc, "dec": dec, "velStart": start, "smoothTime": smooth}) == 0
        assert self("GT_SetPos", x=target) == 0
        assert self("GT_SetVel", v=vel) == 0
        assert self("GT_Update", x=1) == 0

    def run(self, scans: int) -> None:
        self.plc.scan(scans)


@pytest.fixture
def gt():
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
    assert gt.plc["SIM.refusals"] == 1

"""Table 4-4, the state after GT_Reset, and Table 6-2, the status word bit by bit (iDEABOX 3)."""

import pytest

from plcruntime import PLC

CALLS = (
    "GT_Reset()", "GT_ClrSts(1)", "GT_ClrSts(2, 11)", "GT_ClrSts(1, 12)", "GT_AxisOn(1)", "GT_AxisOff(1)",
    "GT_SetPosErr(1, 100)", "GT_SetSoftLimit(1, 1000, -1000)", "GT_SetStopIo(1, 1, MC_GPI, 1)",
    "GT_SetStopIo(1, 0, MC_GPI, 2)", "GT_SetAxisBand(1, 10, 4)",
    "GT_PrfJog(1) + GT_SetJogPrm(1, ADR(jog)) + GT_SetVel(1, vel) + GT_Update(1)", "GT_Stop(1, 0)", "GT_Stop(1, 1)",
    "GT_ClrSts(1) + GT_Update(1)", "GT_SetStopDec(1, 7.0, 77.0)", "GT_ProfileScale(1, 4, 3)", "GT_EncScale(1, 3, 2)",
    "GT_EncSns(1)", "GT_EncOff(1)", "GT_AlarmOff(1) + GT_LmtsOff(1)", "GT_SetPrfPos(1, 555)",
)  # fmt: skip
PROGRAM = f"""
PROGRAM PLC_PRG
VAR
    job, rtn : INT; jog : TJogPrm := (acc := 1.0); vel : LREAL := 20.0; sts : ARRAY[1..12] OF DINT;
    smooth, abrupt : LREAL;
END_VAR
CASE job OF
{"".join(f"    {n}: rtn := {c};" + chr(10) for n, c in enumerate(CALLS, 1))}END_CASE
job := 0;
GT_GetSts(1, ADR(sts), 12);
GT_GetStopDec(1, ADR(smooth), ADR(abrupt));
END_PROGRAM
"""
ALARM, FOLLOWING, POSITIVE, NEGATIVE, SMOOTH, ABRUPT, ENABLED, MOVING, ARRIVED = (
    1 << n for n in (1, 4, 5, 6, 7, 8, 9, 10, 11)
)
LATCHED = ALARM | FOLLOWING | POSITIVE | NEGATIVE | SMOOTH | ABRUPT


class Axis:
    def __init__(self) -> None:
        self.plc = PLC.load(PROGRAM, interval="1ms")
        self.sim = self.plc.axes[1]

    def __call__(self, call: str, expected: int = 0) -> None:
        self.plc["PLC_PRG.job"] = CALLS.index(call) + 1
        self.plc.scan()
        assert self.plc["PLC_PRG.rtn"] == expected

    def jog(self, vel: float) -> None:
        self.plc["PLC_PRG.vel"] = vel
        self(CALLS[11])

    @property
    def status(self) -> int:
        self.plc.scan(2)  # signals are looked at behind the program
        found = self.plc["PLC_PRG.sts"]
        assert not any(s & ~(LATCHED | ENABLED | MOVING | ARRIVED) for s in found), "a reserved bit"
        return found[0]


@pytest.fixture
def axis() -> Axis:
    made = Axis()
    made("GT_AxisOn(1)")
    return made


# what brings each flag, and takes its cause away again
def alarm(axis, on):
    axis.sim.drive.alarm = on


def following_error(axis, on):
    axis("GT_SetPosErr(1, 100)")
    axis.sim.offset = axis.sim.offset + (200.0 if on else -200.0)


def positive_switch(axis, on):
    axis.sim.switches.positive = on


def negative_switch(axis, on):
    axis.sim.switches.negative = on


def positive_soft_limit(axis, on):
    axis("GT_SetSoftLimit(1, 1000, -1000)")
    axis.sim.prfPos = 1001.0 if on else 0.0


def negative_soft_limit(axis, on):
    axis("GT_SetSoftLimit(1, 1000, -1000)")
    axis.sim.prfPos = -1001.0 if on else 0.0


def smooth_stop(axis, on):
    axis("GT_SetStopIo(1, 1, MC_GPI, 1)")
    axis.plc["SimIo.gpi"] = int(on)


def abrupt_stop(axis, on):
    axis("GT_SetStopIo(1, 0, MC_GPI, 2)")
    axis.plc["SimIo.gpi"] = 2 * on


CAUSES = [
    (alarm, ALARM), (following_error, FOLLOWING), (positive_switch, POSITIVE), (negative_switch, NEGATIVE),
    (positive_soft_limit, POSITIVE), (negative_soft_limit, NEGATIVE), (smooth_stop, SMOOTH), (abrupt_stop, ABRUPT),
]  # fmt: skip


@pytest.mark.parametrize(("cause", "flag"), CAUSES, ids=[c.__name__ for c, _ in CAUSES])
def test_latched_flags(axis, cause, flag):
    """Set with its cause, kept when that is gone, cleared by GT_ClrSts then and not before, of the axes named alone."""
    assert axis.status & LATCHED == 0
    cause(axis, True)
    assert axis.status & LATCHED == flag
    axis("GT_ClrSts(1)")
    assert axis.status & LATCHED == flag
    cause(axis, False)
    assert axis.status & LATCHED == flag
    axis("GT_ClrSts(2, 11)")
    assert axis.status & LATCHED == flag
    axis("GT_ClrSts(1, 12)")
    assert axis.status & LATCHED == 0
    assert bool(axis.status & ENABLED) == (flag != ALARM)  # an alarm switches the servo off


@pytest.mark.parametrize(("cause", "flag"), CAUSES, ids=[c.__name__ for c, _ in CAUSES])
def test_what_a_flag_lets_move(axis, cause, flag):
    """Alarm, following error and stop inputs stop both directions, a limit its own, until GT_ClrSts (9.2, 9.3, 9.4)."""
    cause(axis, True)
    axis.plc.scan()
    cause(axis, False)
    axis.plc.scan()
    for vel in (20.0, -20.0):
        allowed = (flag == POSITIVE and vel < 0) or (flag == NEGATIVE and vel > 0)
        axis.plc["PLC_PRG.vel"] = vel
        axis(CALLS[11], 0 if allowed else 1)
        assert axis.sim.moving == allowed
        axis("GT_Stop(1, 1)")
        axis.plc.scan(2)
    axis("GT_ClrSts(1)")
    axis.jog(20.0)
    assert axis.status & MOVING


@pytest.mark.parametrize("cause", [alarm, following_error, smooth_stop, abrupt_stop])
def test_nothing_starts_behind_a_clrsts_while_the_cause_is_there(axis, cause):
    """6.3.1: the flag stays, in the very scan of GT_ClrSts too."""
    axis.jog(20.0)
    axis("GT_Stop(1, 1)")
    cause(axis, True)
    axis.plc.scan(2)
    axis("GT_ClrSts(1) + GT_Update(1)", 1)
    assert not axis.sim.moving


@pytest.mark.parametrize("cause", [alarm, positive_switch, smooth_stop, abrupt_stop])
def test_nothing_starts_in_the_scan_in_which_the_cause_comes(axis, cause):
    axis("GT_SetStopIo(1, 1, MC_GPI, 1)")
    axis("GT_SetStopIo(1, 0, MC_GPI, 2)")
    axis.plc["PLC_PRG.job"] = 12  # the jog
    if cause in (smooth_stop, abrupt_stop):
        axis.plc["SimIo.gpi"] = 1 if cause is smooth_stop else 2
    else:
        cause(axis, True)
    axis.plc.scan()
    assert axis.plc["PLC_PRG.rtn"] == 1 and axis.sim.prfPos == 0.0


def test_servo_and_motion_show_what_is(axis):
    assert axis.status == ENABLED
    axis.jog(20.0)
    assert axis.status == ENABLED | MOVING
    axis("GT_ClrSts(1)")
    assert axis.status == ENABLED | MOVING  # nothing that GT_ClrSts could clear
    axis("GT_Stop(1, 1)")
    axis.plc.scan(2)
    assert axis.status == ENABLED
    axis("GT_AxisOff(1)")
    assert axis.status == 0


def test_in_position_is_off_after_reset_and_needs_rest_and_band(axis):
    axis.plc.scan(100)
    assert not axis.status & ARRIVED
    axis("GT_SetAxisBand(1, 10, 4)")  # 4 * 250 us
    axis.plc.scan(2)
    assert axis.status & ARRIVED
    axis.jog(1.0)
    assert not axis.plc["PLC_PRG.sts"][0] & ARRIVED  # at once, in the scan of GT_Update (6.3.1)
    assert not axis.status & ARRIVED
    axis("GT_Stop(1, 1)")
    axis.plc.scan(3)
    assert axis.status & ARRIVED
    axis.sim.offset = axis.sim.offset + 11.0  # the motor is pushed out of the band
    axis.plc.scan()
    assert not axis.status & ARRIVED
    axis.sim.offset = axis.sim.offset - 2.0
    axis.plc.scan(2)
    assert axis.status & ARRIVED
    axis("GT_Reset()")
    axis.plc.scan(100)
    assert not axis.status & ARRIVED


@pytest.mark.parametrize("units, scans", [(0, 0), (4, 1), (5, 2), (8, 2), (9, 3)])
def test_in_position_not_before_the_hold_time_is_over(axis, units, scans):
    """The unit is 250 us (11.7); the status is seen once a millisecond."""
    axis("GT_SetAxisBand(1, 10, 4)")
    axis.sim.bandTime = units
    axis.sim.offset = axis.sim.offset + 11.0
    axis.plc.scan(3)
    axis.sim.offset = axis.sim.offset - 11.0
    axis.plc.scan()  # inside for the first time
    for _ in range(scans):
        assert not axis.sim.status & ARRIVED
        axis.plc.scan()
    assert axis.sim.status & ARRIVED


def test_state_after_reset(axis):
    """Table 4-4."""
    for call in ("GT_SetStopDec(1, 7.0, 77.0)", "GT_ProfileScale(1, 4, 3)", "GT_EncScale(1, 3, 2)", "GT_EncSns(1)",
                 "GT_EncOff(1)", "GT_AlarmOff(1) + GT_LmtsOff(1)", "GT_SetPosErr(1, 100)", "GT_SetAxisBand(1, 10, 4)",
                 "GT_SetSoftLimit(1, 1000, -1000)", "GT_SetPrfPos(1, 555)", "GT_ClrSts(1)"):  # fmt: skip
        axis(call)
    sim = axis.sim
    assert (axis.plc["PLC_PRG.smooth"], axis.plc["PLC_PRG.abrupt"]) == (7.0, 77.0)
    assert sim.alarmMute and sim.positiveMute and sim.encGain == -1.0 and sim.drive.counted
    axis("GT_Reset()")
    assert axis.status == 0 and sim.prfPos == sim.encPos == 0.0 and sim.mode == 0
    assert (axis.plc["PLC_PRG.smooth"], axis.plc["PLC_PRG.abrupt"]) == (1.0, 1000.0)
    assert (sim.prfAlpha, sim.prfBeta, sim.encAlpha, sim.encBeta) == (1, 1, 1, 1)
    assert sim.encGain == 1.0 and not sim.drive.counted
    assert (sim.softPositive, sim.softNegative) == (2147483647.0, -2147483648.0)
    for cause, flag in CAUSES[:1] + CAUSES[2:4]:  # effective, of the axis' own number
        cause(axis, True)
        assert axis.status & LATCHED == flag
        cause(axis, False)
        axis("GT_ClrSts(1)")
    other = axis.plc.axes[2]
    other.drive.alarm = other.switches.positive = True
    assert axis.status & LATCHED == 0


def test_limit_switches_that_trigger_at_low_level():
    """Bits 2(n-1) and 2(n-1)+1 of GT_LmtSns: positive and negative limit of axis n; 1 low level."""
    plc = PLC.load("""
PROGRAM PLC_PRG
VAR job, rtn : INT; sense : UINT; sts : ARRAY[1..12] OF DINT; END_VAR
CASE job OF
    1: rtn := GT_LmtSns(sense);
    2: rtn := GT_ClrSts(1, 12);
    3: rtn := GT_Reset();
END_CASE
job := 0;
GT_GetSts(1, ADR(sts), 12);
END_PROGRAM""")

    def do(job: int, sense: int = 0) -> list[int]:
        plc["PLC_PRG.sense"], plc["PLC_PRG.job"] = sense, job
        plc.scan(3)
        assert plc["PLC_PRG.rtn"] == 0
        return plc["PLC_PRG.sts"]

    assert do(1, 0x8009) == [POSITIVE, NEGATIVE, 0, 0, 0, 0, 0, NEGATIVE] + [0] * 4
    plc.axes[1].switches.positive = plc.axes[2].switches.negative = plc.axes[8].switches.negative = True
    assert do(2) == [0] * 12  # the wires carry a level again
    plc.axes[1].switches.negative = True  # as before: high level
    assert do(2) == [NEGATIVE] + [0] * 11
    assert do(3) == [POSITIVE | NEGATIVE, NEGATIVE, 0, 0, 0, 0, 0, NEGATIVE] + [0] * 4  # high level again

"""Axes in closed loop over an analogue output; pulses that a drive does not understand (iDEABOX 3, 4.2.3, 4.3.3)."""

import pytest

from plcruntime import PLC

STEPS = 32767  # DAC, at 10 V
SPEED = 500.0  # pulse/ms of the motor there
FOLLOWING, POSITIVE = 1 << 4, 1 << 5
TEXT = """
PROGRAM PLC_PRG
VAR
    job, rtn : INT; jog : TJogPrm := (acc := 1.0); trap : TTrapPrm := (acc := 1.0); pid : TPid; dac, out : INT;
    vel : LREAL; pos : DINT; number, value : INT; error : LREAL;
END_VAR
CASE job OF
    1: rtn := GT_CtrlMode(1, 0);
    2: rtn := GT_CtrlMode(1, 1);
    3: rtn := GT_LmtsOff(1) + GT_AlarmOff(1) + GT_ClrSts(1) + GT_AxisOn(1);
    4: rtn := GT_PrfJog(1) + GT_SetJogPrm(1, ADR(jog)) + GT_SetVel(1, vel) + GT_Update(1);
    5: rtn := GT_PrfTrap(1) + GT_SetTrapPrm(1, ADR(trap)) + GT_SetVel(1, vel) + GT_SetPos(1, pos) + GT_Update(1);
    6: rtn := GT_GetPid(1, number, ADR(pid));
    7: rtn := GT_SetPid(1, number, ADR(pid));
    8: rtn := GT_SetControlFilter(1, number);
    9: rtn := GT_SetMtrBias(1, value);
    10: rtn := GT_SetMtrLmt(1, value);
    11: rtn := GT_SetPosErr(1, value);
    12: rtn := GT_EncSns(1);
    13: rtn := GT_EncOff(1);
    14: rtn := GT_AxisOff(1);
    15: rtn := GT_StepPulse(1);
    16: rtn := GT_StepDir(1);
    17: rtn := GT_Reset();
    18: rtn := GT_SetAxisBand(1, 2, 40);
    19: rtn := GT_SetPrfPos(1, 12345);
    20: rtn := GT_ZeroPos(1, 1);
    21: rtn := GT_GetMtrBias(1, ADR(value));
END_CASE
job := 0;
GT_GetAxisError(1, ADR(error));
GT_GetDac(1, ADR(dac));
GT_GetDacValue(1, ADR(out));
END_PROGRAM
"""
(CLOSED, OPEN, ENABLE, JOG, MOVE, GET_PID, SET_PID, FILTER, BIAS, LIMIT, POS_ERR, INVERT, ENC_OFF, DISABLE, PULSE, DIR,
 RESET, BAND, SET_PRF_POS, ZERO, GET_BIAS) = range(1, 22)  # fmt: skip


class Bench:
    def __init__(self) -> None:
        self.plc = PLC.load(TEXT, interval="1ms")
        self.axis = self.plc.axes[1]

    def __call__(self, job: int, **values) -> int:
        for name, value in values.items():
            self.plc[f"PLC_PRG.{name}"] = value
        self.plc["PLC_PRG.job"] = job
        self.plc.scan()
        return self.plc["PLC_PRG.rtn"]

    def __getitem__(self, name: str):
        return self.plc[f"PLC_PRG.{name}"]

    def pid(self, number: int = 1, **members) -> None:
        assert self(GET_PID, number=number) == 0
        self.plc["PLC_PRG.pid"] = members
        assert self(SET_PID) == 0


@pytest.fixture
def bench() -> Bench:
    """Axis 1 in closed loop, servo on."""
    made = Bench()
    assert made(CLOSED) == 0 and made(ENABLE) == 0
    return made


@pytest.mark.parametrize(("kp", "vel"), [(1.0, 10.0), (1.0, -10.0), (4.0, 100.0), (0.5, 30.0)])
def test_following_error_at_a_steady_velocity(bench, kp, vel):
    """Velocity = kp * error / 32767 * 500 pulse/ms."""
    bench.pid(kp=kp)
    assert bench(JOG, vel=vel) == 0
    bench.plc.run("3s")
    expected = vel * STEPS / (kp * SPEED)
    assert bench["error"] == pytest.approx(expected, abs=1.5 / kp)  # the DAC has whole steps
    assert bench["dac"] == pytest.approx(vel * STEPS / SPEED, abs=1.0) and bench["out"] == bench["dac"]
    assert bench.axis.velocity == pytest.approx(vel, abs=0.02)
    assert bench.axis.encPos == bench.axis.position != bench.axis.prfPos


def test_the_error_decays_as_the_gain_says(bench):
    """At rest, pushed away by 10000 pulses: every ms takes kp * 500 / 32767 of what is left."""
    bench.pid(kp=2.0)
    bench.axis.position = bench.axis.position - 10000.0
    bench.plc.scan()
    trace = bench.plc.trace("SIM.Axis[1].position")
    bench.plc.scan(100)
    left = [-float(x) for x in trace["SIM.Axis[1].position"]]
    factor = 1 - 2.0 * SPEED / STEPS
    for k in range(90):
        assert left[k + 1] == pytest.approx(left[k] * factor, abs=0.02)  # half a step of the DAC is 0.008 pulse/ms


def test_velocity_feedforward(bench):
    bench.pid(kvff=STEPS / SPEED)
    assert bench(JOG, vel=100.0) == 0
    bench.plc.run("1s")
    assert abs(bench["error"]) < 110.0  # what is left of the ramp: without it are 6553
    bench.plc.run("1s")
    assert abs(bench["error"]) < 1.5


def test_acceleration_feedforward_fits_the_time_constant_of_the_drive(bench):
    """The drive lags 20 ms: its velocity is v when it is told v + 20 a."""
    errors = []
    for kaff in (0.0, 20.0 * STEPS / SPEED):
        made = Bench()
        made.axis.drive.lag = 20.0
        assert made(CLOSED) == 0 and made(ENABLE) == 0
        made.pid(kvff=STEPS / SPEED, kaff=kaff)
        assert made(JOG, vel=200.0) == 0
        made.plc.scan(150)
        errors.append(abs(made["error"]))
    assert errors[1] < errors[0] / 30  # what is left is the controller's scan


def test_integral_takes_the_error_away_within_its_limit(bench):
    bench.pid(ki=0.005)
    assert bench(JOG, vel=10.0) == 0
    bench.plc.run("3s")
    assert abs(bench["error"]) < 2.0
    bench.pid(integralLimit=300)  # of the 655 steps that are needed
    bench.plc.run("3s")
    assert bench["error"] == pytest.approx(10.0 * STEPS / SPEED - 300, abs=2.0)


def test_derivative_acts_on_the_change_of_the_error_within_its_limit(bench):
    bench.pid(kp=0.0, kd=3.0)
    assert bench(JOG, vel=50.0) == 0
    bench.plc.scan(5)
    assert bench["dac"] > 0
    bench.pid(kp=0.0, kd=3000.0, derivativeLimit=7)
    bench.plc.scan(5)
    assert abs(bench["dac"]) <= 7


def test_three_sets_of_parameters(bench):
    bench.pid(2, kp=2.0)
    assert bench(JOG, vel=10.0) == 0
    for number, kp in ((2, 2.0), (1, 1.0)):
        assert bench(FILTER, number=number) == 0
        bench.plc.run("2s")
        assert bench["error"] == pytest.approx(10.0 * STEPS / (kp * SPEED), abs=1.5)


def test_limits_of_controller_and_output(bench):
    """Both cut off the voltage: the motor is slower than planned, and the following error grows beyond its limit."""
    bench.pid(kp=10.0, limit=4000)
    assert bench(POS_ERR, value=5000) == 0 and bench(JOG, vel=100.0) == 0
    bench.plc.run("200ms")
    assert bench["dac"] == bench["out"] == 4000 and bench.axis.velocity == pytest.approx(4000 / STEPS * SPEED)
    assert bench(LIMIT, value=1000) == 0
    bench.plc.run("200ms")
    assert bench["dac"] == 4000 and bench["out"] == 1000
    assert bench.axis.velocity == pytest.approx(1000 / STEPS * SPEED)
    assert bench["error"] > 5000 and bench.axis.status & FOLLOWING


def test_bias_makes_up_for_the_drift_of_the_drive(bench):
    bench.axis.drive.drift = 120
    bench.plc.run("1s")
    assert bench["error"] == pytest.approx(-120.0, abs=1.0) and bench["out"] == -120
    assert bench(BIAS, value=-120) == 0
    bench.plc.run("1s")
    assert abs(bench["error"]) < 1.0 and bench["dac"] == 0 and bench["out"] == -120


def test_zeroing_the_position_makes_up_for_the_drift(bench):
    """11.6, 11.7.2, 13 command 138."""
    bench.axis.drive.drift = 120
    bench.plc.run("1s")
    stood = bench.axis.position
    assert bench["error"] == pytest.approx(-120.0, abs=1.0)
    assert bench(ZERO) == 0
    bench.plc.run("1s")
    assert bench["error"] == 0.0 and (bench["dac"], bench["out"]) == (0, -120)
    assert bench.axis.position == pytest.approx(stood, abs=1.0)
    assert bench(GET_BIAS) == 0 and bench["value"] == -120
    assert bench(MOVE, vel=50.0, pos=20000) == 0
    bench.plc.run("2s")
    assert abs(bench["error"]) < 1.0 and bench.axis.encPos == pytest.approx(20000.0, abs=1.0)
    assert bench(ZERO) == 0 and bench(GET_BIAS) == 0 and bench["value"] == -120


def test_a_move_ends_at_its_target_and_in_position(bench):
    assert bench(BAND) == 0 and bench(MOVE, vel=50.0, pos=20000) == 0
    bench.plc.run_until("(SIM.Axis[1].status AND 16#400) = 0", "5s")
    assert not bench.axis.status & 0x800 and bench["error"] > 1000
    bench.plc.run_until("(SIM.Axis[1].status AND 16#800) <> 0", "5s")
    assert abs(bench["error"]) <= 2.0 and bench.axis.prfPos == 20000.0


@pytest.mark.parametrize("wrong", [INVERT, ENC_OFF])
def test_without_its_feedback_the_motor_runs_away(bench, wrong):
    """Counted the other way the error grows without end (4.3.3); not counted at all the motor never arrives."""
    assert bench(wrong) == 0 and bench(JOG, vel=5.0) == 0
    bench.plc.run("2s")
    assert bench.axis.velocity > 100.0 and bench.axis.position > 2 * bench.axis.prfPos


def test_servo_off_and_on(bench):
    assert bench(JOG, vel=50.0) == 0
    bench.plc.run("500ms")
    assert bench(DISABLE) == 0
    stood = bench.axis.position
    bench.plc.run("100ms")
    assert bench.axis.position == stood and bench.axis.velocity == 0.0 and bench["dac"] == 0
    assert bench(ENABLE) == 0
    bench.plc.run("100ms")
    assert bench.axis.position == pytest.approx(stood, abs=1e-9)  # no jump


def test_a_new_planned_position_does_not_move_the_motor(bench):
    bench.plc.run("100ms")
    assert bench(SET_PRF_POS) == 0
    bench.plc.run("100ms")
    assert bench.axis.prfPos == 12345.0 and bench.axis.position == 0.0


def test_changing_the_mode(bench):
    assert bench(JOG, vel=50.0) == 0
    assert bench(OPEN) == 1 and bench(PULSE) == 1 and bench(DIR) == 1  # in planned motion
    assert bench(DISABLE) == 0 and bench(OPEN) == 0 and bench(ENABLE) == 0
    stood = bench.axis.position
    assert bench(MOVE, vel=50.0, pos=int(bench.axis.prfPos) + 1000) == 0
    bench.plc.run("500ms")
    assert bench.axis.velocity == 0.0 and bench.axis.position == pytest.approx(
        stood + bench.axis.prfPos % 1 + 1000, abs=1
    )


def test_reset_opens_the_loop_again(bench):
    assert bench(RESET) == 0 and bench(ENABLE) == 0 and bench(MOVE, vel=50.0, pos=1000) == 0
    bench.plc.run("1s")
    assert bench.axis.position == bench.axis.prfPos == 1000.0
    bench.pid()
    assert bench["pid"] == {
        "kp": 1.0, "ki": 0.0, "kd": 0.0, "kvff": 0.0, "kaff": 0.0, "integralLimit": 32767, "derivativeLimit": 32767,
        "limit": 32767,
    }  # fmt: skip


def test_limit_switches_stand_where_the_motor_is(bench):
    bench.axis.places.positive, bench.axis.places.placed = 5000.0, True
    assert bench(JOG, vel=20.0) == 0
    bench.plc.run_until("SIM.Axis[1].switches.positive", "2s")
    assert bench.axis.position >= 5000.0 > bench.axis.position - 21


@pytest.mark.parametrize(
    ("understood", "job", "forth", "back"),
    [
        (0, PULSE, 1000.0, 0.0), (0, DIR, 1000.0, 0.0), (1, DIR, 1000.0, 0.0), (2, PULSE, 1000.0, 0.0),
        (1, PULSE, 1000.0, 1000.0),  # the negative pulses do nothing
        (2, DIR, 1000.0, 2000.0),  # every pulse goes the positive way
    ],
)  # fmt: skip
def test_kinds_of_pulses(understood, job, forth, back):
    bench = Bench()
    bench.axis.drive.pulses = understood
    assert bench(job) == 0 and bench(ENABLE) == 0
    for pos, expected in ((1000, forth), (0, back)):
        assert bench(MOVE, vel=50.0, pos=pos) == 0
        bench.plc.run("1s")
        assert bench.axis.prfPos == pos and bench.axis.position == pytest.approx(expected)
        assert bench.axis.encPos == bench.axis.position


def test_counted_pulses_are_those_put_out():
    bench = Bench()
    bench.axis.drive.pulses = 1
    assert bench(PULSE) == 0 and bench(ENC_OFF) == 0 and bench(ENABLE) == 0
    for pos in (1000, 0):
        assert bench(MOVE, vel=50.0, pos=pos) == 0
        bench.plc.run("1s")
        assert bench.axis.encPos == pytest.approx(pos)
    assert bench.axis.position == pytest.approx(1000.0)

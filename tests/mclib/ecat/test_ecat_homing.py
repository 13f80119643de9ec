"""Homing by the methods of CiA 402: the home position of every method from every side, and who has the axis meanwhile.

The switches stand at fixed places, an index pulse comes every 1000 pulses from 300 on. Where home is then follows from
the figures of CiA 402 alone; the motor may neither jump nor be faster than it was told, nor leave the machine.
"""

import random

import pytest

LEFT, RIGHT, END = 10000.0, 13000.0, 50000.0  # edges of the home switch, limit switches at +-END
MIDDLE, TO_POSITIVE, TO_NEGATIVE = (LEFT, RIGHT), (LEFT, 1e299), (-1e299, LEFT)
# method -> home switch, home position with the index, without
HOMES = {
    1: (MIDDLE, -49700, -END), 2: (MIDDLE, 49300, END),
    3: (TO_POSITIVE, 9300, LEFT), 4: (TO_POSITIVE, 10300, LEFT),
    5: (TO_NEGATIVE, 10300, LEFT), 6: (TO_NEGATIVE, 9300, LEFT),
    7: (MIDDLE, 9300, LEFT), 8: (MIDDLE, 10300, LEFT), 9: (MIDDLE, 12300, RIGHT), 10: (MIDDLE, 13300, RIGHT),
    11: (MIDDLE, 13300, RIGHT), 12: (MIDDLE, 12300, RIGHT), 13: (MIDDLE, 10300, LEFT), 14: (MIDDLE, 9300, LEFT),
}  # fmt: skip
STARTS = (-20000.0, 11500.0, 30000.0)
POSITIVE, NEGATIVE = 1 << 5, 1 << 6


class Machine:
    def __init__(self, bench, start, home=MIDDLE, **options):
        self.bus = bus = bench(**options)
        self.axis = axis = bus.axis
        bus.scan()
        places = axis.places
        places.negative, places.positive = -END, END
        places.homeFrom, places.homeTo = home
        places.indexPeriod, places.index, places.placed = 1000.0, 300.0, True
        axis.offset = start  # the servo is off: the motor stands there
        bus.scan()
        assert axis.position == start
        assert bus("GT_AxisOn(1)") == 0

    def start(self, method, fast=40.0, slow=7.0, acc=0.8, offset=0):
        bus = self.bus
        parameters = f"{method}, {fast}, {slow}, {acc}, {offset}, 0"
        calls = ("GT_SetHomingMode(1, 6)", f"GT_SetEcatHomingPrm(1, {parameters})", "GT_StartEcatHoming(1)")
        assert bus(" + ".join(calls)) == 0  # each returns 0
        return self

    @property
    def status(self):
        return self.bus.plc["ECAT.Drive[1].home.result"]

    def finish(self):
        self.bus.plc.run_until("ECAT.Drive[1].home.result <> 0", "300s")
        return self.status

    @property
    def home(self):
        """The position of the motor that the encoder calls 0."""
        return self.axis.position - self.axis.encPos


@pytest.mark.parametrize("method", [*HOMES, *(m + 16 for m in HOMES)])
def test_home_position(bench, method):
    with_index = method < 17
    switch, at_index, at_edge = HOMES[method if with_index else method - 16]
    for start in STARTS:
        machine = Machine(bench, start, switch).start(method, fast=80)
        assert machine.finish() == 3, start
        assert machine.home == pytest.approx(at_index if with_index else at_edge, abs=1e-6), start
        assert machine.axis.velocity == 0.0 and machine.axis.state == 3


@pytest.mark.parametrize(("method", "start", "home"), [
    (33, 5000.0, 4300.0), (34, 5000.0, 5300.0), (33, -20.0, -700.0), (34, 300.0, 1300.0), (33, 300.0, -700.0),
    (35, 1234.5, 1234.5), (37, -77.0, -77.0),
])  # fmt: skip
def test_index_only_and_current_position(bench, method, start, home):
    machine = Machine(bench, start).start(method)
    assert machine.finish() == 3
    assert machine.home == pytest.approx(home, abs=1e-6)


def test_the_way_is_the_same_at_any_length_of_a_scan(bench):
    """Random speeds, all methods: home is exact, speed and acceleration keep their limits, positions do not jump."""
    rng = random.Random(5)
    for _ in range(12):
        method = rng.choice([*HOMES, *(m + 16 for m in HOMES)])
        switch, at_index, at_edge = HOMES[method if method < 17 else method - 16]
        fast, slow, acc = rng.uniform(1, 300), rng.uniform(0.5, 60), 10 ** rng.uniform(-0.5, 2)
        ms = rng.choice([0.25, 1, 4])
        machine = Machine(bench, rng.uniform(-45000, 45000), switch, interval=ms / 1000).start(method, fast, slow, acc)
        trace = machine.bus.plc.trace("SIM.Axis[1].position", "SIM.Axis[1].velocity")
        assert machine.finish() == 3
        assert machine.home == pytest.approx(at_index if method < 17 else at_edge, abs=1e-5)
        position = [float(x) for x in trace["SIM.Axis[1].position"]]
        velocity = [float(x) for x in trace["SIM.Axis[1].velocity"]]
        assert max(map(abs, velocity)) <= max(fast, slow) + 1e-9
        for p, q, v, w in zip(position, position[1:], velocity, velocity[1:], strict=False):
            assert abs(w - v) <= acc * ms + 1e-9
            assert abs(q - p - (v + w) / 2 * ms) <= acc * ms * ms / 2 + 1e-6


def test_offset_and_scale(bench):
    machine = Machine(bench, 0.0)
    assert machine.bus("GT_SetPosScale(1, 4)") == 0
    machine.start(23, offset=1600)  # zero is 1600 increments, 100 pulses, beyond home
    assert machine.finish() == 3
    assert machine.home == pytest.approx(LEFT + 100.0)
    machine.bus.scan()
    assert machine.bus("GT_GetEcatEncPos(1, ADR(x))") == 0
    assert machine.bus["x"] == round((machine.axis.position - LEFT - 100.0) * 16)
    assert machine.axis.prfPos == pytest.approx(machine.axis.encPos)


def test_after_homing_the_axis_moves_on_from_there(bench):
    machine = Machine(bench, 0.0).start(7)
    bus = machine.bus
    assert machine.finish() == 3
    assert bus("GT_SetHomingMode(1, 8)") == 0
    bus["trap"] = {"acc": 1.0, "dec": 1.0, "velStart": 0.0, "smoothTime": 0}
    for call in (
        "GT_PrfTrap(1)",
        "GT_SetTrapPrm(1, ADR(trap))",
        "GT_SetPos(1, 500)",
        "GT_SetVel(1, 20)",
        "GT_Update(1)",
    ):
        assert bus(call) == 0, call
    bus.scan(500)
    assert machine.axis.prfPos == 500.0 and machine.axis.encPos == pytest.approx(500.0)
    assert machine.axis.position == pytest.approx(9800.0)


# ------------------------------------------------------------------------------------------- errors


def test_conditions_of_the_start(bench):
    bus = bench()
    assert bus("GT_StartEcatHoming(1)") == 1 and "servo" in bus.why
    bus.power()
    assert bus("GT_StartEcatHoming(1)") == 1 and "mode" in bus.why
    assert bus("GT_SetHomingMode(1, 6)") == 0
    assert bus("GT_StartEcatHoming(1)") == 1 and "parameters" in bus.why
    for method in (0, -1, 15, 16, 31, 32, 36, 38, 300):
        assert bus(f"GT_SetEcatHomingPrm(1, {method}, 10, 5, 1, 0, 0)") == 7, method
    for values in ("0, 5, 1", "10, 0, 1", "10, 5, 0", "-1, 5, 1"):
        assert bus(f"GT_SetEcatHomingPrm(1, 3, {values}, 0, 0)") == 7, values
    assert bus("GT_StartEcatHoming(1)") == 1 and bus.axis.position == 0.0
    assert bus("GT_SetEcatHomingPrm(1, 3, 10, 5, 1, 0, 0)") == 0
    assert bus("GT_StartEcatHoming(1)") == 0
    assert bus("GT_StartEcatHoming(1)") == 1 and "already" in bus.why
    assert bus("GT_SetEcatHomingPrm(1, 3, 10, 5, 1, 0, 0)") == 1


def test_homing_parameters_by_sdo_count_too(bench):
    bus = bench()
    bus.power()
    assert bus("GT_SetHomingMode(1, 6)") == 0
    for index, sub, size, value in (
        (0x6098, 0, 1, 37),
        (0x6099, 1, 4, 1000),
        (0x6099, 2, 4, 500),
        (0x609A, 0, 4, 10**6),
    ):
        bus["n"] = value
        assert bus(f"GT_EcatSDODownload(5, 16#{index:X}, {sub}, ADR(n), {size}, ADR(abort))") == 0
    assert bus("GT_StartEcatHoming(1)") == 0
    assert bus("GT_GetEcatHomingStatus(1, ADR(i))") == 0 and bus["i"] == 3


def test_mode_is_refused_in_planned_motion(bench):
    bus = bench()
    bus.power()
    bus.jog(5)
    assert bus("GT_SetHomingMode(1, 6)") == 1 and "GT_Stop" in bus.why
    assert bus("GT_SetHomingMode(1, 5)") == 7
    assert bus("GT_Stop(1, 1)") == 0
    bus.scan(5)
    assert bus("GT_SetHomingMode(1, 6)") == 0


def test_a_limit_where_none_belongs_is_an_error(bench):
    machine = Machine(bench, 0.0, home=(-1e299, -60000.0)).start(3)  # there is no home switch on the way
    assert machine.finish() == 5
    assert machine.axis.velocity == 0.0 and machine.axis.position >= END
    assert machine.bus("GT_GetSts(1, ADR(x))") == 0 and machine.bus["x"] & POSITIVE
    machine = Machine(bench, 0.0, home=(60000.0, 1e299)).start(7)  # turns round once, then gives up
    assert machine.finish() == 5 and machine.axis.position <= -END


def test_stop(bench):
    machine = Machine(bench, 0.0).start(7)
    bus = machine.bus
    bus.scan(100)
    assert machine.axis.velocity == 40.0 and machine.status == 0
    assert bus("GT_Update(1)") == 1  # the drive has the axis
    assert bus("GT_StopEcatHoming(1)") == 0
    assert bus("GT_SetHomingMode(1, 8)") == 0
    assert machine.status == 0 and bus.plc["ECAT.Drive[1].mode"] == 6  # it is still braking
    bus.scan(60)
    assert machine.status == 1 and bus.plc["ECAT.Drive[1].mode"] == 8
    assert machine.axis.velocity == 0.0 and machine.axis.encPos == machine.axis.position  # no new zero
    assert bus("GT_StopEcatHoming(1)") == 0 and machine.status == 1


@pytest.mark.parametrize("how", ["servo", "alarm", "cable"])
def test_interrupted(bench, how):
    machine = Machine(bench, 0.0).start(7)
    bus = machine.bus
    bus.scan(100)
    if how == "servo":
        assert bus("GT_AxisOff(1)") == 0
    elif how == "alarm":
        machine.axis.drive.alarm = True
    else:
        bus.plc["ECAT.cut"] = True
    bus.scan(2)
    bus.plc["ECAT.cut"] = False
    stood = machine.axis.position
    bus.scan(20)
    assert machine.status == 5 and machine.axis.position == stood and not machine.axis.drive.enabled


def test_signals_from_outside(bench):
    """A home switch that is set from outside is seen at the scan's boundary, where the motor is then."""
    bus = bench()
    bus.power()
    for call in ("GT_SetHomingMode(1, 6)", "GT_SetEcatHomingPrm(1, 20, 10, 5, 1, 0, 0)", "GT_StartEcatHoming(1)"):
        assert bus(call) == 0
    bus.scan(100)
    at = bus.axis.position
    bus.axis.switches.home = True
    bus.scan(60)
    assert bus.axis.position - bus.axis.encPos == pytest.approx(at)
    # an index pulse from outside, where the encoder gives none
    bus.axis.places.indexPeriod = 0.0
    for call in ("GT_SetEcatHomingPrm(1, 34, 10, 5, 1, 0, 0)", "GT_StartEcatHoming(1)"):
        assert bus(call) == 0
    bus.scan(50)
    at = bus.axis.position
    bus.axis.switches.index = True
    bus.scan(20)
    assert bus("GT_GetEcatHomingStatus(1, ADR(i))") == 0 and bus["i"] == 3
    assert bus.axis.position - bus.axis.encPos == pytest.approx(at)


def test_encoder_counting_backwards(bench):
    machine = Machine(bench, 0.0)
    machine.axis.encGain = -1.0
    machine.start(23)
    assert machine.finish() == 3
    assert machine.axis.encPos == pytest.approx(-(machine.axis.position - LEFT))

"""Example 7-1 of the iDEABOX 3 manual as printed (7.2.3): point-to-point motion with smoothing.

50000 pulse at 50 pulse/ms, acceleration 0.25, deceleration 0.125 pulse/ms2, smoothing time 25 ms. Without smoothing
that is a trapezoid of 200 + 700 + 400 ms. Smoothing time is "the time in which the acceleration changes" (7.2.2): every
ramp of the velocity becomes 25 ms longer, as if the trapezoid had gone through a moving average of 25 ms. 1325 ms in
all.
"""

from pathlib import Path

import pytest

from plcruntime import PLC

LISTING = Path(__file__).parents[3] / "shared/manuals/listings/ideabox3/14_trap_move.st"
pytestmark = pytest.mark.skipif(not LISTING.exists(), reason="the manuals' listings are not beside this checkout")

START = 10  # ms, when the operator sets xStart
SMOOTH = 25.0
END = 200 + 700 + 400 + SMOOTH
ENABLED, MOVING = 1 << 9, 1 << 10


def integral(t: float) -> float:
    """Integral of the position of the unsmoothed trapezoid from 0 to t ms, pulse * ms."""
    total = 0.0
    for begin, length, p, v, a in (
        (0, 200, 0.0, 0.0, 0.25), (200, 700, 5000.0, 50.0, 0.0),
        (900, 400, 40000.0, 50.0, -0.125), (1300, 1e9, 50000.0, 0.0, 0.0),
    ):  # fmt: skip
        d = min(max(t - begin, 0.0), length)
        total += p * d + v * d**2 / 2 + a * d**3 / 6
    return total


def position(t: float) -> float:
    """Position t ms after the start: the mean of the trapezoid's over the last 25 ms."""
    return (integral(t) - integral(t - SMOOTH)) / SMOOTH


@pytest.fixture(scope="module")
def run():
    plc = PLC.load(LISTING, interval="1ms")
    plc.schedule("PLC_PRG.xStart", True, f"#{START}")
    trace = plc.trace("PLC_PRG.lrPrfPos", "PLC_PRG.dwAxisStatus", "SIM.Axis[1].prfVel", "SIM.Axis[1].prfAcc")
    plc.run("3s")
    return plc, trace


def test_position_is_the_closed_form(run):
    _, trace = run
    rows = [float(x) for x in trace["PLC_PRG.lrPrfPos"]]
    for k, seen in enumerate(rows):
        expected = position(max(k - START, 0.0)) if k < START + END else 50000.0
        assert seen == pytest.approx(expected, abs=1e-7), f"at {k} ms"


def test_ends_at_exactly_50000(run):
    plc, trace = run
    assert plc["PLC_PRG.lrPrfPos"] == 50000.0
    assert plc.axes[1].position == 50000.0
    rows = [float(x) for x in trace["PLC_PRG.lrPrfPos"]]
    assert next(k for k, x in enumerate(rows) if x == 50000.0) == START + END


def test_velocity_and_acceleration_keep_their_limits(run):
    _, trace = run
    velocity = [float(x) for x in trace["SIM.Axis[1].prfVel"]]
    acceleration = [float(x) for x in trace["SIM.Axis[1].prfAcc"]]
    assert max(velocity) == pytest.approx(50.0, abs=1e-12) and min(velocity) == 0.0
    assert max(acceleration) == pytest.approx(0.25, abs=1e-12) and min(acceleration) == pytest.approx(-0.125, abs=1e-12)
    # the acceleration takes 25 ms to change, so in a millisecond it changes by a 25th
    for a, b in zip(acceleration, acceleration[1:], strict=False):
        assert -0.25 / 25 - 1e-9 <= b - a <= 0.25 / 25 + 1e-9


def test_status_word_shows_servo_and_motion_at_the_right_scans(run):
    _, trace = run
    for k, status in enumerate(int(x) for x in trace["PLC_PRG.dwAxisStatus"]):
        moving = MOVING if START <= k < START + END else 0
        assert status == ENABLED | moving, f"at {k} ms"


def test_positions_do_not_depend_on_the_interval():
    plc = PLC.load(LISTING, interval="4ms")
    plc["PLC_PRG.xStart"] = True
    trace = plc.trace("PLC_PRG.lrPrfPos")
    plc.run("2s")
    for k, seen in enumerate(float(x) for x in trace["PLC_PRG.lrPrfPos"]):
        assert seen == pytest.approx(position(min(4.0 * k, END)), abs=1e-7)


def test_the_misprints_are_mended_with_warnings_that_name_the_lines():
    plc = PLC.load(LISTING)
    lines = {d.line for d in plc.diagnostics}
    text = LISTING.read_text(encoding="utf-8").splitlines()
    assert any("’test.cfg)" in text[n - 1] for n in lines)

"""Examples 7-3 to 7-5, 7-7 and 7-8 of the iDEABOX 3 manual as printed (7.4.3, 7.5.3, 7.6.3)."""

import math
from pathlib import Path

import pytest

from plcruntime import PLC

LISTINGS = Path(__file__).parents[3] / "shared/manuals/listings/ideabox3"
pytestmark = pytest.mark.skipif(not LISTINGS.is_dir(), reason="the manuals' listings are not beside this checkout")

START = 10  # ms, when the operator sets xStart


def run(source, time: str, *starts: int):
    """Run a listing; gives the PLC and (position, velocity) of axes 1 and 2 at every ms after the start."""
    plc = PLC.load(source, interval="1ms")
    for ms in starts or (START,):
        plc.schedule("PLC_PRG.xStart", True, f"#{ms}")
    names = [f"SIM.Axis[{n}].{m}" for n in (1, 2) for m in ("prfPos", "prfVel")]
    trace = plc.trace(*names)
    plc.run(time)
    columns = [[float(x) for x in trace[name]][START - 1 :] for name in names]
    return plc, list(zip(columns[0], columns[1], strict=True)), list(zip(columns[2], columns[3], strict=True))


def test_7_3_static_fifo():
    plc, axis, _ = run(LISTINGS / "16_pt_static.st", "4s")
    assert plc["SIM.refusals"] == 0
    assert [axis[t][1] for t in (0, 512, 1024, 1500, 2048, 2560, 3072)] == [0.0, 1.0, 2.0, 2.0, 2.0, 1.0, 0.0]
    assert [axis[t][0] for t in (0, 1024, 2048, 3072)] == [0.0, 1024.0, 3072.0, 4096.0]
    assert plc["PLC_PRG.lrPrfPos"] == 4096.0 and plc["PLC_PRG.dwAxisStatus"] == 0x200
    assert plc["PLC_PRG.space"] == 30  # as last read, before the third point


def sine(t: float) -> tuple[float, float]:
    """Position and velocity of example 7-4 at t s: velocities on the sine every 16 ms, straight lines between them."""
    turn, t = divmod(t, 1.0)
    speed = [50 * math.sin(2 * 3.1415926 * (turn + 0.016 * n)) if n else 0.0 for n in range(63)]
    n = int(t / 0.016 + 1e-9)
    pos = sum((a + b) * 8 for a, b in zip(speed[:n], speed[1 : n + 1], strict=False))
    d = t - n * 0.016
    # the last segment of a period is a STOP segment to position 0
    slope = (speed[n + 1] - speed[n]) / 0.016 if n < 62 else 2 * pos / 0.008**2 / 1000
    v0 = speed[n] if n < 62 else -2 * pos / 8
    return pos + 1000 * d * (v0 + slope * d / 2), v0 + slope * d


def test_7_4_dynamic_fifo():
    """'ttime' is printed as DINT and counts in steps of 0.016: read as LREAL."""
    plc, axis, _ = run(LISTINGS / "17_pt_dynamic.st", "3s")
    assert plc["SIM.refusals"] == 0
    assert [(d.code, d.line) for d in plc.diagnostics if "ttime" in d.message] == [("W0135", 59)]
    # one point a scan until both FIFOs of 32 are full, then the start
    for t in range(2000):
        pos, vel = sine(t / 1000)
        assert axis[64 + t] == (pytest.approx(pos, abs=1e-6), pytest.approx(vel, abs=1e-6)), f"at {t} ms"
    assert max(v for _, v in axis) == pytest.approx(50.0, rel=1e-3)
    assert min(v for _, v in axis) == pytest.approx(-50.0, rel=1e-3)
    assert axis[2064:] == [axis[-1]] * len(axis[2064:]) and axis[-1] == (pytest.approx(0.0, abs=1e-9), 0.0)


def test_7_5_gear():
    """Master 100 pulse/ms after 100 ms; the clutch is over when it has gone 100000, after 1050 ms."""
    plc, master, slave = run(LISTINGS / "19_gear_follow.st", "3s")
    assert plc["SIM.refusals"] == 0
    assert master[100] == (5000.0, 100.0) and master[1050] == (100000.0, 100.0)
    assert slave[1050] == (pytest.approx(25000.0), pytest.approx(50.0))
    for (x, vm), (y, vs) in zip(master, slave, strict=True):
        if x <= 100000:
            assert y == pytest.approx(x**2 / 400000, abs=1e-6) and vs == pytest.approx(vm * x / 200000, abs=1e-9)
        else:
            assert y == pytest.approx(25000 + (x - 100000) / 2, abs=1e-6) and vs == pytest.approx(50.0, abs=1e-9)
    assert plc["PLC_PRG.arrPrfVel"][:3] == pytest.approx([100.0, 50.0, 0.0])


def shape(x: float, segments) -> tuple[float, float]:
    """(position, ratio) at master x of segments (master length, slave length), the first ratio given in front."""
    ratio, *rest = segments
    pos = 0.0
    for length, slave in rest:
        end = 2 * slave / length - ratio
        if x < length:
            slope = (end - ratio) / length
            return pos + x * (ratio + slope * x / 2), ratio + slope * x
        x, pos, ratio = x - length, pos + slave, end
    raise AssertionError("beyond the end")


TABLE_7_10 = (0.0, (20000, 10000), (20000, 20000), (20000, 10000))


def test_7_7_follow_one_fifo():
    """The slave starts when the master passes 50000, after 1025 ms; 400 ms a segment, peak 50 pulse/ms, for ever."""
    plc, master, slave = run(LISTINGS / "20_follow_single_fifo.st", "6s")
    assert plc["SIM.refusals"] == 0
    assert master[1025] == (50000.0, 50.0) and slave[1025] == (0.0, 0.0)
    assert [slave[1025 + 400 * n][0] for n in (1, 2, 3, 4)] == pytest.approx([10000, 30000, 40000, 50000])
    assert [slave[1025 + 400 * n][1] for n in (1, 2, 3, 4)] == pytest.approx([50, 50, 0, 50])
    for (x, vm), (y, vs) in zip(master, slave, strict=True):
        turn, rest = divmod(max(x - 50000, 0.0), 60000)
        pos, ratio = shape(rest, TABLE_7_10)
        assert y == pytest.approx(turn * 40000 + pos, abs=1e-5) and vs == pytest.approx(ratio * vm, abs=1e-7)


@pytest.mark.parametrize("misprint", [True, False])
def test_7_8_follow_two_fifos(misprint, tmp_path):
    """As printed the transition's last point is +220000 pulses of the master, Table 7-12 has +20000."""
    source = LISTINGS / "21_follow_double_fifo.st"
    long = 220000 if misprint else 20000
    if not misprint:
        text = source.read_text(encoding="utf-8").replace("masterPos+220000", "masterPos+20000")
        source = tmp_path / "main.st"
        source.write_text(text, encoding="utf-8")
        handler = (LISTINGS / "01_commandhandler.st").read_text(encoding="utf-8")
        (tmp_path / "handler.st").write_text(handler, encoding="utf-8")
    plc = PLC.load(source, interval="1ms")
    for ms in (START, 500):
        plc.schedule("PLC_PRG.xStart", True, f"#{ms}")
    names = [f"SIM.Axis[{n}].{m}" for n in (1, 2) for m in ("prfPos", "prfVel")]
    trace = plc.trace(*names, "PLC_PRG.stage")
    plc.run("9s")
    assert plc["SIM.refusals"] == 0
    transition = (0.0, (20000, 10000), (20000, 20000), (long, 16000))
    end = 2 * 16000 / long - (2 * 20000 / 20000 - 1.0)
    assert end == pytest.approx(0.6) or misprint
    last = (end, (20000, 16000), (20000, 20000), (20000, 16000))
    stages, stage_of = [], trace["PLC_PRG.stage"].tolist()
    for k, (x, vm, y, vs) in enumerate(zip(*(trace[n].tolist() for n in names), strict=True)):
        if x < 60000:
            pos, ratio = shape(x, TABLE_7_10)
        elif x < 100000 + long:
            pos, ratio = shape(x - 60000, transition)
            pos += 40000
        elif x < 160000 + long:
            pos, ratio = shape(x - 100000 - long, last)
            pos += 86000
        else:
            break
        assert abs(y - pos) < 1e-5 and abs(vs - ratio * vm) < 1e-7, f"at {k} ms"
        if not stages or stages[-1] != stage_of[k]:
            stages.append(stage_of[k])
    assert stages == [4, 1, 2, 3, 4]
    if not misprint:  # the new data in FIFO 1 repeat: 0.6 - 1 - 1 - 0.6
        for x, y in zip(trace[names[0]][4000:].tolist(), trace[names[2]][4000:].tolist(), strict=True):
            turn, rest = divmod(x - 120000, 60000)
            pos, ratio = shape(rest, last)
            assert abs(y - (86000 + 52000 * turn + pos)) < 1e-4
            assert 0.6 - 1e-9 <= ratio <= 1.0 + 1e-9

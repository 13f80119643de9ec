"""PT mode (iDEABOX 3, 7.4): FIFOs, kinds of segments, loops, return codes."""

import random

import pytest

NORMAL, EVEN, STOP = 0, 1, 2
TABLE_7_5 = [(1024, 1024), (3072, 2048), (4096, 3072)]


def fill(gt, points, fifo=0, axis=1):
    """points: (position, time) or (position, time, kind)"""
    for pos, time, *kind in points:
        gt.ok("GT_PtData", axis, v=float(pos), x=time, i=kind[0] if kind else NORMAL, j=fifo)


def curve(points, continued=False):
    """(t0, p0, v0, t1, p1, v1) of every segment, by the rules of 7.4.2; 'continued' has no effect on the first."""
    t, p, v = 0, 0.0, 0.0
    for pos, time, *kind in points:
        mean = (pos - p) / (time - t)
        match kind[0] if kind else NORMAL:
            case 0:
                v0, v1 = v, 2 * mean - v
            case 1:
                v0 = v1 = mean
            case _:
                v0, v1 = 2 * mean, 0.0
        yield t, p, v0, time, pos, v1
        t, p, v = time, pos, v1


def at(points, t):
    """(position, velocity) at t ms"""
    for t0, p0, v0, t1, _, v1 in curve(points):
        if t < t1:
            a = (v1 - v0) / (t1 - t0)
            return p0 + (t - t0) * (v0 + a * (t - t0) / 2), v0 + a * (t - t0)
    return points[-1][0], 0.0


def run(gt, scans, axis=1):
    """Record the axis over scans, the next command included; row k is at k + 1 ms."""
    gt.follow(axis)
    gt.ok("GT_PtStart", x=1 << (axis - 1))
    gt.plc.scan(scans - 1)
    return gt.rows(axis)


def test_table_7_5_trapezoid(gt):
    gt.ok("GT_AxisOn")
    gt.ok("GT_PrfPt")
    fill(gt, TABLE_7_5)
    rows = run(gt, 3100)
    for t in range(1, 3100):
        pos, vel = at(TABLE_7_5, t)
        assert rows[t - 1][:2] == (pytest.approx(pos, abs=1e-9), pytest.approx(vel, abs=1e-12)), f"at {t} ms"
    assert [rows[t - 1][1] for t in (1024, 2048, 3072)] == [2.0, 2.0, 0.0]
    assert rows[3071][0] == 4096.0 and not gt.axis().moving
    assert gt.axis().position == 4096.0


def test_status_word_and_mode(gt):
    gt.ok("GT_AxisOn")
    gt.ok("GT_PrfPt")
    assert gt.read("GT_GetPrfMode") == 2
    fill(gt, [(10, 10)])
    gt.ok("GT_PtStart", x=1)
    assert gt.read("GT_GetSts") == 0x600
    gt.plc.scan(8)
    assert gt.read("GT_GetSts") == 0x200


@pytest.mark.parametrize(
    "points",
    [
        [(10, 10, EVEN), (30, 20, EVEN), (30, 25, EVEN)],
        [(100, 100), (300, 200), (400, 300, STOP)],
        [(100, 100, EVEN), (300, 200), (250, 210, STOP), (0, 400)],
        [(-50, 7), (-60, 9, EVEN), (-61, 10, STOP)],
        [(0.5, 1), (0.25, 2, STOP)],
    ],
)
def test_kinds_of_segments(gt, points):
    gt.ok("GT_PrfPt")
    fill(gt, points)
    rows = run(gt, points[-1][1] + 5)
    for t, row in enumerate(rows, 1):
        assert row[:2] == pytest.approx(at(points, t), abs=1e-9), f"at {t} ms"


def test_static_data_stay_and_run_again_from_where_the_axis_is(gt):
    gt.ok("GT_PrfPt")
    fill(gt, [(50, 10), (100, 20)])
    fill(gt, [(-30, 10, EVEN)], fifo=1)
    run(gt, 30)
    assert gt.read("GT_PtSpace") == 30
    run(gt, 30)
    assert gt.axis().prfPos == 200.0
    gt.ok("GT_PtStart", x=1, y=1)
    gt.plc.scan(20)
    assert gt.axis().prfPos == 170.0


def test_loops(gt):
    gt.ok("GT_PrfPt")
    fill(gt, [(50, 10), (100, 20)])
    gt.ok("GT_SetPtLoop", x=3)
    gt.ok("GT_PtStart", x=1)
    seen = {gt.read("GT_GetPtLoop"): gt.axis().prfPos for _ in range(70)}
    assert list(seen) == [0, 1, 2, 3]
    assert gt.axis().prfPos == 300.0 and not gt.axis().moving
    gt.ok("GT_SetPtLoop", x=0)
    gt.ok("GT_PtStart", x=1)
    gt.plc.scan(20 * 500 - 1)
    assert gt.axis().moving and gt.axis().prfPos == 300.0 + 500 * 100
    assert gt.read("GT_GetPtLoop") == 500
    gt.ok("GT_Stop", x=1)
    gt.plc.scan(20)
    assert not gt.axis().moving


@pytest.mark.parametrize(("memory", "size"), [(0, 32), (1, 1024)])
def test_memory_sizes(gt, memory, size):
    gt.ok("GT_PrfPt")
    gt.ok("GT_SetPtMemory", i=memory)
    assert gt.read("GT_GetPtMemory") == memory
    for fifo in (0, 1):
        assert gt.read("GT_PtSpace", j=fifo) == size
        fill(gt, [(n + 1.0, n + 1) for n in range(size)], fifo)
        assert gt.read("GT_PtSpace", j=fifo) == 0
        assert gt("GT_PtData", v=1e6, x=1_000_000, j=fifo) == 1
        assert "full" in gt.why
    assert gt.read("GT_GetPtRemainder") == 2 * size
    gt.ok("GT_PtStart", x=1, y=1)
    gt.plc.scan(size - 1)
    assert not gt.axis().moving and gt.axis().prfPos == size


def test_dynamic_mode_uses_both_fifos_and_empties_them(gt):
    gt.ok("GT_PrfPt", i=1)
    assert gt.read("GT_PtSpace") == 64
    points = [(10.0 * n, 10 * n, EVEN) for n in range(1, 101)]
    fill(gt, points[:64])
    assert gt.read("GT_PtSpace") == 0 and gt("GT_PtData", v=1e3, x=1000) == 1
    gt.follow(1)
    gt.ok("GT_PtStart", x=1)
    left = points[64:]
    while gt.axis().moving:
        if left and gt.read("GT_PtSpace") > 0:
            fill(gt, left[:1])
            left = left[1:]
        else:
            gt.plc.scan()
    rows = gt.rows(1)
    assert [round(r[0], 9) for r in rows[:1000]] == list(range(1, 1001))
    assert all(r[1] == pytest.approx(1.0) for r in rows[:999])
    assert gt.read("GT_PtSpace") == 64  # used up: both are empty, time and position start from 0 again
    fill(gt, [(5, 5)])
    assert len(run(gt, 10)) == 10 and gt.axis().prfPos == 1005.0


def test_dynamic_mode_goes_on_with_the_velocity_of_the_other_fifo(gt):
    gt.ok("GT_PrfPt", i=1)
    # 40 segments of a long acceleration: the seam after the 32nd must not show
    points = [(0.5 * 0.01 * (5 * n) ** 2, 5 * n) for n in range(1, 41)]
    fill(gt, points)
    rows = run(gt, 199)
    for t, (pos, vel, acc) in enumerate(rows, 1):
        assert pos == pytest.approx(0.005 * t * t, abs=1e-9)
        assert vel == pytest.approx(0.01 * t, abs=1e-9) and acc == pytest.approx(0.01, abs=1e-9)


def test_remainder_counts_down(gt):
    gt.ok("GT_PrfPt")
    fill(gt, [(10, 10), (20, 20), (30, 30)])
    assert gt.read("GT_GetPtRemainder") == 3
    gt.ok("GT_PtStart", x=1)
    seen = [gt.read("GT_GetPtRemainder") for _ in range(29)]
    assert seen[:9] == [3] * 9 and seen[10:19] == [2] * 9 and seen[20:28] == [1] * 8


def test_return_codes(gt):
    for command in ("GT_PtSpace", "GT_PtClear", "GT_SetPtLoop", "GT_GetPtLoop", "GT_SetPtMemory", "GT_GetPtMemory",
                    "GT_GetPtRemainder", "GT_PtData"):  # fmt: skip
        assert gt(command, x=1) == 1 and "GT_PrfPt" in gt.why, command
        assert gt(command, 0, x=1) == 7 and gt(command, 13, x=1) == 7, command
    assert gt("GT_PtStart", x=1) == 1
    assert gt("GT_PrfPt", i=2) == 7 and gt("GT_PrfPt", 13) == 7
    gt.ok("GT_PrfPt")
    assert gt("GT_PtStart", x=1) == 1 and "no data" in gt.why
    assert gt("GT_PtStart", x=0) == 7 and gt("GT_PtStart", x=0x1000) == 7
    assert gt("GT_SetPtMemory", i=2) == 7
    assert gt("GT_SetPtLoop", x=-1) == 7
    for bad in ({"x": 0}, {"x": -1}, {"x": 1, "i": 3}, {"x": 1, "j": 2}, {"x": 1, "j": -1}):
        assert gt("GT_PtData", **bad) == 7
    fill(gt, [(100, 100), (200, 200)])
    assert gt("GT_PtData", x=200) == 7
    gt.ok("GT_PtStart", x=1)
    assert gt("GT_PtStart", x=1) == 1 and gt("GT_PrfPt") == 1 and gt("GT_SetPtMemory", i=1) == 1
    assert gt("GT_PtClear", j=0) == 1 and "in use" in gt.why
    gt.ok("GT_PtClear", j=1)
    gt.plc.scan(300)
    gt.ok("GT_PtClear", j=0)
    assert gt.read("GT_PtSpace") == 32
    gt.ok("GT_PrfPt", i=1)
    fill(gt, [(1000, 100)])
    gt.ok("GT_PtStart", x=1)
    gt.plc.scan(50)
    assert gt("GT_PtClear") == 1
    gt.ok("GT_Stop", x=1)
    assert gt("GT_PtClear") == 1  # it is still coming to rest
    gt.plc.scan(15)
    gt.ok("GT_PtClear")
    assert gt.read("GT_PtSpace") == 64


def test_loops_have_no_effect_in_dynamic_mode(gt):
    """13 commands 66 and 119: the code is 1 in another mode than PT only."""
    gt.ok("GT_PrfPt")
    gt.ok("GT_SetPtLoop", x=3)
    gt.ok("GT_PrfPt", i=1)
    gt.plc["PLC_PRG.ox"] = -1
    gt.ok("GT_SetPtLoop", x=5)
    gt.ok("GT_SetPtLoop", x=-1)
    gt.ok("GT_GetPtLoop")
    assert gt.plc["PLC_PRG.ox"] == -1
    fill(gt, [(50, 10), (100, 20)])
    gt.ok("GT_PtStart", x=1)
    gt.plc.scan(25)
    assert gt.axis().prfPos == 100.0 and not gt.axis().moving
    gt.ok("GT_PrfPt", i=0)
    fill(gt, [(50, 10), (100, 20)])
    gt.ok("GT_PtStart", x=1)
    gt.plc.scan(65)
    assert gt.axis().prfPos == 400.0  # 3 loops, as set in static mode


def test_a_soft_limit_stops_it(gt):
    gt.ok("GT_AxisOn")
    gt.ok("GT_SetSoftLimit", x=200, y=-200)
    gt.ok("GT_PrfPt")
    fill(gt, [(1000, 1000, EVEN)])
    gt.ok("GT_PtStart", x=1)
    gt.plc.scan(500)
    assert gt.read("GT_GetSts") & 0x420 == 0x20 and 200 < gt.axis().prfPos < 205
    assert gt("GT_PtStart", x=1) == 1 and "positive limit" in gt.why


def test_reset_makes_it_trap_mode_with_empty_fifos(gt):
    gt.ok("GT_PrfPt", i=1)
    gt.ok("GT_SetPtMemory", i=1)
    fill(gt, [(10, 10)])
    gt.ok("GT_Reset")
    assert gt("GT_PtSpace") == 1
    gt.ok("GT_PrfPt")
    assert gt.read("GT_PtSpace") == 32


def test_random_curves_are_continuous_and_velocity_is_their_slope(gt):
    """NORMAL segments only: the velocity never jumps, the acceleration is constant in each segment."""
    rng = random.Random(7)
    gt.ok("GT_PrfPt")
    for _ in range(40):
        gt.ok("GT_PtClear")
        pos, time, points, speed = 0.0, 0, [], 0.0
        for _ in range(rng.randint(1, 32)):
            step = rng.randint(1, 40)
            goal = rng.uniform(-20, 20)
            pos, time, speed = pos + (speed + goal) / 2 * step, time + step, goal
            points.append((pos, time))
        fill(gt, points)
        p0 = gt.axis().prfPos
        rows = run(gt, time + 3)
        for (p, v, a), (q, w, _) in zip(rows[: time - 2], rows[1 : time - 1], strict=True):
            assert q - p == pytest.approx((v + w) / 2, abs=1e-6)
            assert w - v == pytest.approx(a, abs=1e-6)  # at the seam the row shows the segment that follows
        assert gt.axis().prfPos == pytest.approx(p0 + points[-1][0], abs=1e-9)

"""Follow mode (iDEABOX 3, 7.6): segments, events, loops, switching of FIFOs, return codes."""

import random

import pytest

NORMAL, EVEN, STOP, CONTINUE = 0, 1, 2, 3
START, PASS = 1, 2
TABLE_7_10 = [(20000, 10000), (40000, 30000), (60000, 40000)]
TABLE_7_12 = [(20000, 10000, CONTINUE), (40000, 30000), (60000, 46000)]
TABLE_7_13 = [(20000, 16000, CONTINUE), (40000, 36000), (60000, 52000)]
TABLE_7_8 = [(5000, 2500)]
TABLE_7_9 = [(1000, 1000, CONTINUE), (4000, 3400), (6000, 4600), (9000, 7000), (10000, 8000)]


def fill(gt, points, fifo=0, axis=2):
    for master, slave, *kind in points:
        gt.ok("GT_FollowData", axis, x=master, v=float(slave), i=kind[0] if kind else NORMAL, j=fifo)


def setup(gt, points=(), *, dir=0, master=1, slave=2, loop=1, kind=2, item=0):
    gt.ok("GT_PrfFollow", slave, i=dir)
    gt.ok("GT_SetFollowMaster", slave, i=master, j=kind, k=item)
    gt.ok("GT_SetFollowLoop", slave, i=loop)
    fill(gt, points, axis=slave)


def curve(points, ratio=0.0):
    """(x0, y0, x1, y1, r0, r1) of the segments, by 7.6.2 (5); ratio: where the data before ended"""
    x, y, last = 0, 0.0, ratio
    for n, (master, slave, *kind) in enumerate(points):
        mean = (slave - y) / (master - x)
        match kind[0] if kind else NORMAL:
            case 0:
                r0 = 0.0 if n == 0 else last
            case 1:
                r0 = mean
            case 2:
                r0 = 2 * mean
            case _:
                r0 = last
        last = 2 * mean - r0
        yield x, y, master, slave, r0, last
        x, y = master, slave


def at(points, x, ratio=0.0):
    """(position, ratio) of the slave when the master has gone x"""
    for x0, y0, x1, _, r0, r1 in curve(points, ratio):
        if (x - x1) * (x1 - x0) < 0:
            slope = (r1 - r0) / (x1 - x0)
            return y0 + (x - x0) * (r0 + slope * (x - x0) / 2), r0 + slope * (x - x0)
    return points[-1][1], 0.0


def check(rows, points, start=0.0, ratio=0.0):
    """rows: (master's, slave's) of every scan"""
    for (x, vm, _), (y, vs, _) in rows:
        pos, r = at(points, x - start, ratio) if (x - start) * points[0][0] > 0 else (0.0, 0.0)
        assert y == pytest.approx(pos, abs=1e-6) and vs == pytest.approx(r * vm, abs=1e-6), f"master at {x}"


def test_figure_7_13(gt):
    """From 1000 with a ratio rising to 1 at 1500 (250 pulses), then the zone of equal velocity up to 2250."""
    setup(gt, [(500, 250), (1250, 1000, EVEN)])
    gt.ok("GT_SetFollowEvent", 2, i=PASS, j=1, x=1000)
    gt.ok("GT_FollowStart", x=2)
    assert gt.read("GT_GetSts", 2) & 0x400  # waiting counts as moving
    gt.follow(1, 2)
    gt.jog(1, 5.0)
    gt.plc.scan(600)
    rows = list(zip(gt.rows(1), gt.rows(2), strict=True))
    check(rows, [(500, 250), (1250, 1000, EVEN)], 1000)
    by_master = {m[0]: s for m, s in rows}
    assert by_master[1502.5][:2] == (pytest.approx(252.5), pytest.approx(5.0))
    assert by_master[1497.5][0] == pytest.approx(247.50625)
    assert gt.axis(2).prfPos == 1000.0 and not gt.axis(2).moving


@pytest.mark.parametrize(
    "points",
    [
        TABLE_7_10,
        [(100, 50, EVEN), (200, 150, EVEN), (300, 150, EVEN)],
        [(100, 100, CONTINUE), (200, 150), (250, 200, STOP)],
        [(100, -100), (150, 0, STOP), (200, 5.5)],
        [(-100, 100), (-300, 150, EVEN), (-310, 155, STOP)],
    ],
)
def test_kinds_of_segments(gt, points):
    setup(gt, points)
    gt.ok("GT_FollowStart", x=2)
    gt.follow(1, 2)
    gt.jog(1, 50.0 if points[0][0] > 0 else -50.0)
    gt.plc.scan(1300)
    check(zip(gt.rows(1), gt.rows(2), strict=True), points)
    assert gt.axis(2).prfPos == points[-1][1] and not gt.axis(2).moving


def test_fly_shear_tables_7_8_and_7_9(gt):
    """A knife of 8000 pulses a turn cuts every 10000 pulses of the belt: equal velocity at the cut, 0.6 between."""
    setup(gt, TABLE_7_8, loop=0)
    fill(gt, TABLE_7_9, fifo=1)
    gt.ok("GT_FollowStart", x=2)
    gt.ok("GT_FollowSwitch", x=2)
    gt.follow(1, 2)
    gt.jog(1, 10.0)
    gt.plc.scan(10000)
    seen = 0
    for (x, vm, _), (y, vs, _) in zip(gt.rows(1), gt.rows(2), strict=True):
        if x < 5000:
            pos, r = at(TABLE_7_8, x)
        else:
            turn, rest = divmod(x - 5000, 10000)
            pos, r = at(TABLE_7_9, rest, 1.0)
            pos += 2500 + 8000 * turn
            if rest <= 1000 or rest >= 9000:
                assert vs == pytest.approx(vm)
            elif 4000 <= rest <= 6000:
                assert vs == pytest.approx(0.6 * vm)
                seen += 1
        assert y == pytest.approx(pos, abs=1e-6) and vs == pytest.approx(r * vm, abs=1e-6)
    assert seen > 1000
    assert gt.read("GT_FollowSpace", 2, j=0) == 16 and gt.read("GT_FollowSpace", 2, j=1) == 11
    assert gt.read("GT_GetFollowLoop", 2) == 9


def test_example_7_8_two_seams(gt):
    """FIFO 0, the transition of Table 7-12, Table 7-13 in FIFO 0 again: ratios 0-1-1-0, 0-1-1-0.6, 0.6-1-1-0.6."""
    setup(gt, TABLE_7_10, loop=0)
    gt.ok("GT_FollowStart", x=2)
    gt.follow(1, 2)
    gt.jog(1, 50.0)
    gt.plc.scan(200)
    fill(gt, TABLE_7_12, fifo=1)
    gt.ok("GT_FollowSwitch", x=2)
    while gt.read("GT_FollowSpace", 2) != 16:
        gt.plc.scan()
    assert 60000 <= gt.axis(1).prfPos < 60000 + 50 * 3
    fill(gt, TABLE_7_13)
    gt.ok("GT_FollowSwitch", x=2)
    gt.plc.scan(5000)
    for (x, vm, _), (y, vs, _) in zip(gt.rows(1), gt.rows(2), strict=True):
        if x < 60000:
            pos, r = at(TABLE_7_10, x)
        elif x < 120000:
            pos, r = at(TABLE_7_12, x - 60000, 0.0)
            pos += 40000
        else:
            turn, rest = divmod(x - 120000, 60000)
            pos, r = at(TABLE_7_13, rest, 0.6)
            pos += 86000 + 52000 * turn
        assert y == pytest.approx(pos, abs=1e-5) and vs == pytest.approx(r * vm, abs=1e-6)
    ratios = [[round(v, 12) for _, _, _, _, a, b in curve(t, r) for v in (a, b)] for t, r in
              ((TABLE_7_10, 0.0), (TABLE_7_12, 0.0), (TABLE_7_13, 0.6))]  # fmt: skip
    assert ratios == [[0, 1, 1, 1, 1, 0], [0, 1, 1, 1, 1, 0.6], [0.6, 1, 1, 1, 1, 0.6]]


@pytest.mark.parametrize("loop", [1, 3])
def test_loops_end_and_data_stay(gt, loop):
    setup(gt, [(100, 50), (200, 100)], loop=loop)
    gt.ok("GT_FollowStart", x=2)
    gt.jog(1, 10.0)
    gt.plc.scan(200)
    assert gt.axis(2).prfPos == 100.0 * loop and not gt.axis(2).moving
    assert gt.read("GT_GetFollowLoop", 2) == loop and gt.read("GT_FollowSpace", 2) == 14
    gt.ok("GT_FollowStart", x=2)
    gt.plc.scan(200)
    assert gt.axis(2).prfPos == 200.0 * loop


@pytest.mark.parametrize("loop", [0, -1, -32768])
def test_endless_loops(gt, loop):
    setup(gt, [(100, 50), (200, 100)], loop=loop)
    gt.ok("GT_FollowStart", x=2)
    gt.jog(1, 1000.0, 1000.0)  # five passes a scan
    gt.plc.scan(1000)
    assert gt.axis(2).moving and gt.axis(2).prfPos == pytest.approx(gt.axis(1).prfPos // 200 * 100, abs=100)
    assert gt.read("GT_GetFollowLoop", 2) >= 4999


def test_second_fifo(gt):
    setup(gt)
    fill(gt, [(100, -100)], fifo=1)
    assert gt("GT_FollowStart", x=2) == 1 and "no data" in gt.why
    gt.ok("GT_FollowStart", x=2, y=2)
    gt.jog(1, 10.0)
    gt.plc.scan(50)
    assert gt.axis(2).prfPos == -100.0


@pytest.mark.parametrize(("dir", "pos", "vel"), [(1, 500, 10.0), (-1, -500, -10.0)])
def test_pass_event_in_its_direction_only(gt, dir, pos, vel):
    """The master comes by in the wrong direction first."""
    points = [(100 * dir, 100 * dir, EVEN)]
    setup(gt, points)
    gt.ok("GT_SetPrfPos", x=1000 * dir)
    gt.ok("GT_SetFollowEvent", 2, i=PASS, j=dir, x=pos)
    gt.ok("GT_FollowStart", x=2)
    gt.jog(1, -vel)
    gt.plc.scan(120)
    assert gt.axis(1).prfPos * dir < 0 and gt.axis(2).prfPos == 0.0
    gt.follow(1, 2)
    gt.jog(1, vel)
    gt.plc.scan(120)
    for (x, _, _), (y, _, _) in zip(gt.rows(1), gt.rows(2), strict=True):
        assert y == pytest.approx(dir * min(max((x - pos) * dir, 0), 100), abs=1e-9)
    assert not gt.axis(2).moving


def test_a_position_that_is_set_is_not_passed(gt):
    setup(gt, [(100, 100, EVEN)])
    gt.ok("GT_SetFollowEvent", 2, i=PASS, j=1, x=500)
    gt.ok("GT_FollowStart", x=2)
    gt.ok("GT_SetPrfPos", x=600)
    gt.jog(1, 10.0)
    gt.plc.scan(50)
    assert gt.axis(2).prfPos == 0.0 and gt.axis(2).moving
    gt.ok("GT_Stop", x=2)
    gt.plc.scan(2)
    assert not gt.axis(2).moving


def test_going_back_goes_back_along_the_curve(gt):
    points = [(200, 100), (400, 250), (600, 300)]
    setup(gt, points, loop=0)
    gt.ok("GT_FollowStart", x=2)
    gt.follow(1, 2)
    gt.jog(1, 10.0)
    gt.plc.scan(150)
    gt.jog(1, -10.0)
    gt.plc.scan(250)
    gt.jog(1, 10.0)
    gt.plc.scan(150)
    beyond = 0
    for (x, _, _), (y, _, _) in zip(gt.rows(1), gt.rows(2), strict=True):
        turn, rest = divmod(x, 600)
        beyond += x < 0
        assert y == pytest.approx(at(points, rest)[0] + 300 * turn if x > 0 else 0.0, abs=1e-6)
    assert beyond > 50


@pytest.mark.parametrize("dir", [1, -1])
def test_direction(gt, dir):
    points = [(500 * dir, 500 * dir, EVEN)]
    setup(gt, points, dir=dir, loop=0)
    gt.ok("GT_FollowStart", x=2)
    gt.follow(1, 2)
    for vel in (10.0, -15.0, 10.0):
        gt.jog(1, vel)
        gt.plc.scan(100)
    way, last = 0.0, 0.0
    for (x, _, _), (y, _, _) in zip(gt.rows(1), gt.rows(2), strict=True):
        way += x - last if (x - last) * dir > 0 else 0
        last = x
        assert y == pytest.approx(way, abs=1e-6)


@pytest.mark.parametrize(("memory", "size"), [(0, 16), (1, 512)])
def test_memory_sizes(gt, memory, size):
    setup(gt)
    gt.ok("GT_SetFollowMemory", 2, i=memory)
    assert gt.read("GT_GetFollowMemory", 2) == memory
    for fifo in (0, 1):
        assert gt.read("GT_FollowSpace", 2, j=fifo) == size
        fill(gt, [(n * 10, n * 5, EVEN) for n in range(1, size + 1)], fifo)
        assert gt.read("GT_FollowSpace", 2, j=fifo) == 0
        assert gt("GT_FollowData", 2, x=size * 10 + 10, j=fifo) == 1 and "full" in gt.why
    gt.ok("GT_FollowStart", x=2)
    gt.ok("GT_FollowSwitch", x=2)
    gt.jog(1, 100.0, 100.0)
    gt.plc.scan(size // 5 + 5)
    assert gt.axis(2).prfPos == size * 10.0
    assert gt.read("GT_FollowSpace", 2, j=0) == size and gt.read("GT_FollowSpace", 2, j=1) == 0


def test_masters(gt):
    gt.ok("GT_AxisOn")
    gt.ok("GT_EncScale", i=4, j=1)
    for slave, (kind, item) in enumerate([(2, 0), (1, 0), (3, 0), (3, 1)], 2):
        setup(gt, [(100000, 100000, EVEN)], slave=slave, kind=kind, item=item)
    gt.ok("GT_FollowStart", x=0b11110)
    gt.jog(1, 16.0)
    gt.plc.scan(100)
    x = gt.axis(1).prfPos
    assert [gt.axis(n).prfPos for n in (2, 3, 4, 5)] == pytest.approx([x, x, x, x / 4])


def test_return_codes(gt):
    for command in ("GT_SetFollowMaster", "GT_GetFollowMaster", "GT_FollowData", "GT_FollowSpace", "GT_FollowClear",
                    "GT_SetFollowLoop", "GT_GetFollowLoop", "GT_SetFollowEvent", "GT_GetFollowEvent",
                    "GT_SetFollowMemory", "GT_GetFollowMemory"):  # fmt: skip
        assert gt(command, 2, i=1, x=1) == 1 and "GT_PrfFollow" in gt.why, command
        assert gt(command, 0, i=1, x=1) == 7 and gt(command, 13, i=1, x=1) == 7, command
    assert gt("GT_FollowStart", x=2) == 1 and gt("GT_FollowSwitch", x=2) == 1
    assert gt("GT_PrfFollow", 2, i=2) == 7
    gt.ok("GT_PrfFollow", 2, i=1)
    assert gt("GT_PrfFollow", 2, i=-1) == 1 and "dir" in gt.why
    assert gt("GT_FollowStart", x=2) == 1 and "master" in gt.why
    assert gt("GT_SetFollowMaster", 2, i=2, j=2) == 7 and gt("GT_SetFollowMaster", 2, i=1, j=4) == 7
    gt.ok("GT_SetFollowMaster", 2, i=1, j=3, k=1)
    gt.ok("GT_GetFollowMaster", 2)
    assert [gt["oi"], gt["oj"], gt["ok"]] == [1, 3, 1]
    gt.ok("GT_SetFollowEvent", 2, i=PASS, j=-1, x=-5)
    gt.ok("GT_GetFollowEvent", 2)
    assert [gt["oi"], gt["oj"], gt["ox"]] == [PASS, -1, -5]
    for bad in ({"i": 0}, {"i": 3}, {"i": PASS, "j": 0}, {"i": PASS, "j": 2}):
        assert gt("GT_SetFollowEvent", 2, **bad) == 7
    gt.ok("GT_SetFollowEvent", 2, i=START)
    assert gt("GT_SetFollowMemory", 2, i=2) == 7 and gt("GT_FollowClear", 2, j=2) == 7
    assert gt("GT_FollowSpace", 2, j=-1) == 7
    assert gt("GT_FollowStart", x=2) == 1 and "no data" in gt.why
    fill(gt, [(100, 100)])
    for bad in ({"x": 0}, {"x": 100}, {"x": 50}, {"x": -1}, {"x": 200, "i": 4}, {"x": 200, "j": 2}):
        assert gt("GT_FollowData", 2, **bad) == 7, bad
    assert gt("GT_FollowStart", x=0) == 1 and gt("GT_FollowStart", x=0x1000) == 7
    assert gt("GT_FollowSwitch", x=0) == 1 and gt("GT_FollowSwitch", x=0x1000) == 7
    assert gt("GT_FollowSwitch", x=2) == 1 and "under way" in gt.why
    gt.ok("GT_FollowStart", x=2)
    assert gt("GT_FollowSwitch", x=2) == 1 and "other FIFO" in gt.why
    for command in ("GT_FollowStart", "GT_FollowClear", "GT_SetFollowMaster", "GT_SetFollowMemory", "GT_PrfFollow"):
        assert gt(command, 2, i=1, j=2 if command == "GT_SetFollowMaster" else 0, x=2) == 1, command
    gt.ok("GT_FollowClear", 2, j=1)
    gt.ok("GT_Stop", x=2)
    gt.plc.scan(3)
    gt.ok("GT_FollowClear", 2)


def test_random_data_of_normal_segments(gt):
    """Whatever the master does, the slave is where the curve says; position and velocity do not jump."""
    rng = random.Random(11)
    setup(gt, loop=1)
    for _ in range(25):
        gt.ok("GT_FollowClear", 2)
        x, y, points, ratio = 0, 0.0, [], 0.0
        for _ in range(rng.randint(2, 16)):
            step, goal = rng.randint(50, 400), rng.uniform(-3, 3)
            x, y, ratio = x + step, y + (ratio + goal) / 2 * step, goal
            points.append((x, y))
        fill(gt, points)
        x0, y0 = gt.axis(1).prfPos, gt.axis(2).prfPos
        gt.ok("GT_FollowStart", x=2)
        gt.follow(1, 2)
        while gt.axis(2).moving:
            gt.jog(1, rng.uniform(5, 30))
            gt.plc.scan(rng.randint(1, 20))
        for (m, vm, _), (s, vs, _) in zip(gt.rows(1), gt.rows(2), strict=True):
            pos, r = at(points, max(m - x0, 0.0))
            assert s - y0 == pytest.approx(pos, abs=1e-5) and vs == pytest.approx(r * vm, abs=1e-5)
        gt.plc.scan(2)

"""Blocks and functions of CoDeSys V2.3's Util.lib."""

import math
import random
import statistics

import pytest
from harness import Plc, check, trace


def test_bcd():
    check(
        """
        INT BCD_TO_INT(16#49) -> 49
        INT BCD_TO_INT(16#97) -> 97
        INT BCD_TO_INT(16#00) -> 0
        INT BCD_TO_INT(16#A0) -> -1
        INT BCD_TO_INT(16#0F) -> -1
        BYTE INT_TO_BCD(49) -> 73
        BYTE INT_TO_BCD(0) -> 0
        BYTE INT_TO_BCD(99) -> 153
        BYTE INT_TO_BCD(100) -> 255
        BYTE INT_TO_BCD(-1) -> 255
        BYTE BCD_TO_BYTE(16#42) -> 42
        WORD BCD_TO_WORD(16#1234) -> 1234
        DWORD BCD_TO_DWORD(16#98765432) -> 98765432
        BYTE BCD_TO_BYTE(16#4A) -> 255
        WORD BCD_TO_WORD(16#F234) -> 65535
        DWORD BCD_TO_DWORD(16#A) -> 4294967295
        BYTE BYTE_TO_BCD(42) -> 66
        WORD WORD_TO_BCD(1234) -> 4660
        DWORD DWORD_TO_BCD(98765432) -> 2557891634
        BYTE BYTE_TO_BCD(100) -> 255
        WORD WORD_TO_BCD(10000) -> 65535
        DWORD DWORD_TO_BCD(100000000) -> 4294967295
    """
    )


def test_bits():
    check(
        """
        BOOL EXTRACT(16#80000001, 0) -> True
        BOOL EXTRACT(16#80000001, 31) -> True
        BOOL EXTRACT(16#80000001, 5) -> False
        BOOL EXTRACT(16#FFFFFFFF, 32) -> False
        DWORD PUTBIT(38, 4, TRUE) -> 54
        DWORD PUTBIT(16#FFFFFFFF, 31, FALSE) -> 2147483647
        DWORD PUTBIT(5, 0, FALSE) -> 4
        DWORD PUTBIT(5, 40, TRUE) -> 5
        BYTE PACK(TRUE, FALSE, TRUE, FALSE, FALSE, FALSE, FALSE, TRUE) -> 133
    """
    )
    got = trace("UNPACK", {"B": "BYTE"}, [(0x85,)], [f"B{i}" for i in range(8)])
    assert got == [(True, False, True, False, False, False, False, True)]


def test_limits():
    rows = [(5, 8, 3), (2, 8, 3), (5, 8, 3), (8, 8, 3), (9, 8, 3), (5, 8, 3), (3, 8, 3)]
    inputs = {"IN": "INT", "HIGH": "INT", "LOW": "INT"}
    assert [q for (q,) in trace("HYSTERESIS", inputs, rows, ["OUT"])] == [0, 1, 1, 1, 0, 0, 0]
    got = trace("LIMITALARM", inputs, [(9, 8, 3), (8, 8, 3), (3, 8, 3), (2, 8, 3)], ["O", "U", "IL"])
    assert got == [(True, False, False), (False, False, True), (False, False, True), (False, True, False)]


def test_lin_trafo():
    inputs = {n: "REAL" for n in ("IN", "IN_MIN", "IN_MAX", "OUT_MIN", "OUT_MAX")}
    rows = [(5, 0, 10, 0, 100), (0, 0, 10, 20, 40), (11, 0, 10, 20, 40), (1, 1, 1, 0, 5), (4, 10, 0, 0, 100)]
    got = trace("LIN_TRAFO", inputs, rows, ["OUT", "ERROR"])
    assert got == [(50.0, False), (20.0, False), (20.0, True), (20.0, True), (60.0, False)]


def test_derivative():
    """Exact for a straight line from the second call on, whatever the times between calls."""
    t, rows = 0.0, []
    for tm in (10, 10, 20, 5, 40, 10):
        t += tm / 1000
        rows.append((7.0 * t + 1.0, tm, False))
    got = [x for (x,) in trace("DERIVATIVE", {"IN": "REAL", "TM": "DWORD", "RESET": "BOOL"}, rows, ["OUT"])]
    assert got[0] == 0.0 and got[1:] == pytest.approx([7.0] * 5, rel=1e-4)
    rows = [(0.0, 10, False), (1.0, 10, False), (5.0, 10, True), (5.0, 10, False), (6.0, 0, False)]
    got = [x for (x,) in trace("DERIVATIVE", {"IN": "REAL", "TM": "DWORD", "RESET": "BOOL"}, rows, ["OUT"])]
    assert got[2:4] == [0.0, 0.0]


def test_integral():
    inputs = {"IN": "REAL", "TM": "DWORD", "RESET": "BOOL"}
    rows = [(0.0, 100, False)] + [(i * 1.0, 100, False) for i in range(1, 11)] + [(5.0, 100, True), (2.0, 500, False)]
    got = [x for (x,) in trace("INTEGRAL", inputs, rows, ["OUT"])]
    assert got[10] == pytest.approx(5.0) and got[11] == 0.0 and got[12] == pytest.approx(1.0)
    rows = [(3e38, 1000, False), (3e38, 1000, False), (-3e38, 1000, False), (0.0, 1, True), (1.0, 1000, False)]
    got = trace("INTEGRAL", inputs, rows, ["OUT", "OVERFLOW"])
    assert [o for _, o in got] == [False, True, True, False, False] and got[4][0] == 1.0


def test_statistics():
    rows = [(5, False), (-3, False), (10, False), (0, True), (7, False)]
    got = trace("STATISTICS_INT", {"IN": "INT", "RESET": "BOOL"}, rows, ["MN", "MX", "AVG"])
    assert got == [(5, 5, 5), (-3, 5, 1), (-3, 10, 4), (32767, -32768, 0), (7, 7, 7)]
    got = trace(
        "STATISTICS_REAL",
        {"IN": "REAL", "RESET": "BOOL"},
        [(1.0, False), (2.0, False), (6.0, False)],
        ["MN", "MX", "AVG"],
    )
    assert got[-1] == (1.0, 6.0, 3.0)


def test_variance():
    rng = random.Random(1)
    values = [1e4 + round(rng.uniform(-1, 1), 2) for _ in range(50)]
    got = trace("VARIANCE", {"IN": "REAL", "RESET": "BOOL"}, [(v, False) for v in values], ["OUT"])
    assert got[0] == (0.0,)
    assert got[-1][0] == pytest.approx(statistics.pvariance(values), rel=1e-2)


# ------------------------------------------------------------------------------------------------ controllers

INPUTS = ["ACTUAL", "SET_POINT", "KP", "TN", "TV", "Y_MANUAL", "Y_OFFSET", "Y_MIN", "Y_MAX"]


def control(block, rows, outputs=("Y", "LIMITS_ACTIVE"), interval=100, **fixed):
    """rows: dicts of what changes from scan to scan."""
    names = [n for n in INPUTS if not (block == "PD" and n == "TN")]
    inputs = {n: "REAL" for n in names} | {"MANUAL": "BOOL", "RESET": "BOOL"}
    if block == "PID_FIXCYCLE":
        inputs["CYCLE"] = "REAL"
    values, table = dict.fromkeys(inputs, 0) | {"KP": 1} | fixed, []
    for row in rows:
        values |= row
        table.append(tuple(bool(v) if inputs[n] == "BOOL" else float(v) for n, v in values.items()))
    return trace(block, inputs, table, outputs, interval=interval)


@pytest.mark.parametrize("block", ["PID", "PID_FIXCYCLE"])
def test_integral_part(block):
    """A constant error: Y grows by KP * e * t / TN."""
    fixed = {"SET_POINT": 2, "KP": 3, "TN": 4} | ({"CYCLE": 0.1} if block == "PID_FIXCYCLE" else {})
    got = [y for y, _ in control(block, [{}] * 11, **fixed)]
    assert got == pytest.approx([3 * (2 + 2 * 0.1 * i / 4) for i in range(11)], rel=1e-6)


def test_proportional_and_derivative_part():
    """A ramp of the error: KP * (e + TV * slope)."""
    rows = [{"SET_POINT": 0.5 * i} for i in range(6)]
    got = [y for y, _ in control("PD", rows, KP=2, TV=3, Y_OFFSET=1)]
    assert got[0] == 1.0 and got[1:] == pytest.approx([2 * (0.5 * i + 3 * 5) + 1 for i in range(1, 6)], rel=1e-5)


def test_controller_limits():
    got = control("PID", [{}] * 20 + [{"SET_POINT": -1}], SET_POINT=10, TN=0.1, Y_MIN=-5, Y_MAX=5)
    assert got[0] == (5.0, True)
    # the integral did not grow while Y was held: the way back is not delayed
    assert got[-1][0] < 5.0
    assert control("PID", [{}], SET_POINT=10)[0] == (10.0, False)  # no limits where Y_MIN = Y_MAX


def test_controller_manual_and_reset():
    rows = [{}, {}, {"MANUAL": 1}, {"MANUAL": 0}, {}, {"RESET": 1}, {"RESET": 0}]
    got = [y for y, _ in control("PID", rows, SET_POINT=1, TN=1, Y_MANUAL=7, Y_OFFSET=2)]
    assert got == pytest.approx([3, 3.1, 7, 3, 3.1, 2, 3], rel=1e-6)


def test_controller_closes_the_loop():
    """PID on a first-order plant comes to the set point."""
    plc = Plc(
        "PROGRAM PLC_PRG\nVAR\n  c : PID; x : REAL; sp : REAL := 10.0;\nEND_VAR\n"
        "c(ACTUAL := x, SET_POINT := sp, KP := 2.0, TN := 0.5, TV := 0.0, Y_MIN := -100.0, Y_MAX := 100.0);\n"
        "x := x + (c.Y - x) * 0.01;\nEND_PROGRAM\n",
        interval=10,
    )
    plc.scan(1000)
    assert plc["PLC_PRG.x"] == pytest.approx(10.0, abs=1e-3)


# -------------------------------------------------------------------------------------------------- signals


def test_blink():
    inputs = {"ENABLE": "BOOL", "TIMELOW": "TIME", "TIMEHIGH": "TIME"}
    rows = [(False, 0.02, 0.03)] + [(True, 0.02, 0.03)] * 8 + [(False, 0.02, 0.03)] * 2 + [(True, 0.02, 0.03)]
    got = [q for (q,) in trace("BLINK", inputs, rows, ["OUT"], interval=10)]
    assert got == [0, 1, 1, 1, 0, 0, 1, 1, 1, 1, 1, 1]


def test_frequency():
    signal = [i % 4 < 2 for i in range(60)]  # 25 Hz at 10 ms a scan
    inputs = {"IN": "BOOL", "PERIODS": "INT", "RESET": "BOOL"}
    got = trace(
        "FREQ_MEASURE",
        inputs,
        [(s, 3, False) for s in signal] + [(False, 3, False)] * 20,
        ["OUT", "VALID"],
        interval=10,
    )
    assert not got[11][1] and got[12] == (25.0, True) and got[59] == (25.0, True)
    assert got[-1][1] is False
    got = trace("FREQ_MEASURE", inputs, [(s, 3, i >= 50) for i, s in enumerate(signal)], ["OUT", "VALID"], interval=10)
    assert got[-1] == (0.0, False)


@pytest.mark.parametrize("base", [False, True])
def test_generator(base):
    """Eight steps a period, counted by calls or by time."""
    up = [-100, -50, 0, 50, 100, 50, 0, -50]
    wave = [math.sin(2 * math.pi * i / 8) for i in range(8)]
    shapes = {
        "TRIANGLE": up, "TRIANGLE_POS": [0, 25, 50, 75, 100, 75, 50, 25],
        "SAWTOOTH_RISE": [-100 + 25 * i for i in range(8)],
        "SAWTOOTH_FALL": [100 - 25 * i for i in range(8)], "RECTANGLE": [-100] * 4 + [100] * 4,
        "SINUS": [round(100 * x) for x in wave], "COSINUS": [round(100 * wave[(i + 2) % 8]) for i in range(8)],
        "SINE": [round(100 * x) for x in wave],
    }  # fmt: skip
    declared = "".join(f"  {n.lower()}_ : GEN;\n" for n in shapes)
    calls = "".join(
        f"{n.lower()}_(MODE := {n}, BASE := {str(base).upper()}, PERIOD := T#80ms,\n"
        "  CYCLES := 8, AMPLITUDE := 100, RESET := r);\n"
        for n in shapes
    )
    plc = Plc(f"PROGRAM PLC_PRG\nVAR\n{declared}  r : BOOL;\nEND_VAR\n{calls}END_PROGRAM\n", interval=10)
    rows = []
    for _ in range(11):
        plc.scan()
        rows.append({n: plc[f"PLC_PRG.{n.lower()}_.OUT"] for n in shapes})
    for name, shape in shapes.items():
        assert [r[name] for r in rows] == shape + shape[:3], name
    plc["PLC_PRG.r"] = True
    plc.scan()
    assert plc["PLC_PRG.cosinus_.OUT"] == 0
    plc["PLC_PRG.r"] = False
    plc.scan()
    assert plc["PLC_PRG.cosinus_.OUT"] == 100


def test_charcurve():
    points = "[(X := 0, Y := 0), (X := 250, Y := 50), (X := 500, Y := 150), (X := 1000, Y := -1000)]"
    plc = Plc(
        f"PROGRAM PLC_PRG\nVAR\n  p : ARRAY[0..10] OF POINT := {points};\n  c : CHARCURVE; x : INT; n : BYTE := 4;\n"
        "END_VAR\nc(IN := x, N := n, P := p);\nEND_PROGRAM\n"
    )
    for x, n, expected in [
        (0, 4, (0, 0)), (125, 4, (25, 0)), (250, 4, (50, 0)), (375, 4, (100, 0)), (750, 4, (-425, 0)),
        (1000, 4, (-1000, 0)), (1001, 4, (-1000, 2)), (-1, 4, (0, 2)), (100, 1, (0, 4)), (100, 12, (0, 4)),
        (100, 5, (0, 1)), (100, 2, (20, 0)),
    ]:  # fmt: skip
        plc["PLC_PRG.x"], plc["PLC_PRG.n"] = x, n
        plc.scan()
        assert (plc["PLC_PRG.c.OUT"], plc["PLC_PRG.c.ERR"]) == expected, x


def test_ramp():
    inputs = {"IN": "INT", "ASCEND": "INT", "DESCEND": "INT", "TIMEBASE": "TIME", "RESET": "BOOL"}
    rows = [(100, 30, 50, 0.0, False)] * 4 + [(100, 30, 50, 0.0, True)] + [(-20, 30, 50, 0.0, False)] * 3
    assert [y for (y,) in trace("RAMP_INT", inputs, rows, ["OUT"])] == [30, 60, 90, 100, 100, 50, 0, -20]
    inputs = dict.fromkeys(("IN", "ASCEND", "DESCEND"), "REAL") | {"TIMEBASE": "TIME", "RESET": "BOOL"}
    rows = [(1.0, 25.0, 50.0, 1.0, False)] * 6 + [(0.0, 25.0, 50.0, 1.0, False)] * 3
    got = [y for (y,) in trace("RAMP_REAL", inputs, rows, ["OUT"], interval=10)]
    assert got == pytest.approx([0, 0.25, 0.5, 0.75, 1, 1, 0.5, 0, 0])


def test_slow_integer_ramp():
    """A slope below one step a scan still leads there."""
    inputs = {"IN": "INT", "ASCEND": "INT", "DESCEND": "INT", "TIMEBASE": "TIME", "RESET": "BOOL"}
    got = [y for (y,) in trace("RAMP_INT", inputs, [(10, 100, 100, 1.0, False)] * 120, ["OUT"], interval=1)]
    assert got[-1] == 10 and got[50] == 5

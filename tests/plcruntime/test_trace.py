"""Traces of every variable, columns that overlap, triggers."""

import pytest

from plcruntime import PLC, CompileError, PathError, UsageError
from plcruntime.trigger import MOST

PROGRAM = """
TYPE Point : STRUCT x : LREAL; y : INT; END_STRUCT END_TYPE
TYPE U : UNION r : REAL; d : DWORD; END_UNION END_TYPE
PROGRAM PLC_PRG
VAR n : DINT; p : Point; u : U; w : WORD; a : ARRAY[1..3] OF BOOL; big : ARRAY[1..2000] OF INT; timer : TON;
  text : STRING(5); at2 AT %QX0.2 : BOOL; far : POINTER TO DINT; END_VAR
n := n + 1; p.x := n / 2; p.y := DINT_TO_INT(n); u.r := 1.5; w := DINT_TO_WORD(n); a[2] := n.0; at2 := n.1;
timer(IN := TRUE, PT := T#10ms); IF n > 5 THEN text := 'late'; far := ADR(n); END_IF
END_PROGRAM
"""


@pytest.fixture
def plc() -> PLC:
    return PLC.load(PROGRAM)


def test_every_variable(plc):
    trace = plc.trace("*")
    assert trace.left_out == ["PLC_PRG.big"]
    assert {"PLC_PRG.p.x", "PLC_PRG.a[2]", "PLC_PRG.timer.ET", "PLC_PRG.text", "PLC_PRG.at2"} <= set(trace.names)
    plc.scan(700)
    n = list(range(1, 701))
    assert trace["n"].tolist() == n and trace["p.x"].tolist() == [k // 2 for k in n] and trace["p.y"].tolist() == n
    assert trace["a[2]"].tolist() == [k % 2 == 1 for k in n] and trace["at2"].tolist() == [k & 2 > 0 for k in n]
    assert set(trace["u.d"].tolist()) == {0x3FC00000} and trace["text"].tolist() == [""] * 5 + ["late"] * 695
    assert trace["timer.ET"][:12].tolist() == [k / 1000 for k in (*range(11), 10)]
    for name, column in zip(trace.names, zip(*(row[1:] for row in trace.rows()), strict=True), strict=True):
        assert list(column) == trace[name].tolist(), name


def test_columns_that_overlap(plc):
    trace = plc.trace("w", "w.0", "w.9", "p.y", "%QB0", "at2", "far^")
    plc.scan(600)
    rows = list(trace.rows())
    assert rows[520][1:] == (521, True, True, 521, 521 & 2 and 4, bool(521 & 2), 521)
    assert rows[3][-1] == 0 and trace["far^"].tolist()[7] == 8


def test_a_trigger_keeps_what_is_around_it(plc):
    trace = plc.trace("n", trigger="n = 500", pre="10ms", post="20ms")
    whole = plc.trace("w")
    assert trace.triggered is None and not trace.done
    plc.run("2s")
    assert trace.triggered == 0.499 and trace.done
    assert trace["n"].tolist() == list(range(490, 521)) and trace.time[[0, -1]].tolist() == [0.489, 0.519]
    assert len(whole) == 2000 and whole["w"].tolist() == list(range(1, 2001))
    assert len(list(trace.rows())) == 31


@pytest.mark.parametrize("piece", [1, 7, 100, 1999])
def test_it_does_not_matter_how_the_scans_are_run(plc, piece):
    trace = plc.trace("n", trigger="n >= 64 AND a[2]", pre="5ms", post="5ms")
    for _ in range(2000 // piece):
        plc.scan(piece)
    assert trace["n"].tolist() == list(range(60, 71))


def test_at_the_edges(plc):
    first = plc.trace("n", trigger="TRUE", pre="10ms", post="3ms")
    never = plc.trace("n", trigger="n < 0", pre="10ms", post="3ms")
    open_end = plc.trace("n", trigger="n = 90", pre="#2")
    plc.scan(100)
    assert first["n"].tolist() == [1, 2, 3, 4]
    assert never.triggered is None and never["n"].tolist() == list(range(91, 101))
    assert open_end["n"].tolist() == list(range(88, 101)) and not open_end.done
    plc.scan(5)
    assert len(open_end) == 18
    plc.stop_trace(never)
    plc.stop_trace(first)
    plc.scan(5)
    assert len(never) == 10 and len(open_end) == 23


def test_triggers_beside_a_condition_of_the_run(plc):
    texts = plc.trace("n", trigger="text = 'late'", pre="1ms", post="1ms")
    other = plc.trace("n", trigger="CONCAT('la', 'te') = text AND n >= 8", pre="0ms", post="1ms")
    plc.run_until("LEFT(text, 2) = 'la' AND n >= 20", timeout="1s")
    assert plc.scans == 20
    assert texts["n"].tolist() == [5, 6, 7] and other["n"].tolist() == [8, 9]
    plc.run_until(lambda p: p.scans == 30)
    assert plc.scans == 30


def test_going_back_before_the_trigger_arms_it_again(plc):
    trace = plc.trace("n", trigger="n = 50 OR w = 0", pre="5ms", post="5ms")
    plc.scan(100)
    assert trace.done
    plc.back(70)
    assert trace.triggered is None
    plc["n"] = 47
    plc.scan(100)
    assert trace["n"].tolist()[-8:] == [48, 49, 50, 51, 52, 53, 54, 55] and trace.triggered == 0.032
    plc.power_cycle()
    assert len(trace) == 0 and trace.triggered is None
    plc.scan(60)
    assert trace["n"].tolist() == list(range(45, 56))


def test_wrong_triggers(plc):
    for wrong in ("nope > 3", "n", "n >"):
        with pytest.raises(CompileError):
            plc.trace("n", trigger=wrong)
    with pytest.raises(ValueError, match="not a duration"):
        plc.trace("n", trigger="TRUE", pre="soon")
    with pytest.raises(PathError, match="unknown variable 'm'"):
        plc.trace("m", trigger="TRUE")
    for k in range(MOST):
        plc.trace("n", trigger=f"n = {k + 1000}")
    with pytest.raises(UsageError, match="wait for a trigger already"):
        plc.trace("n", trigger="TRUE")
    plc.scan(3)

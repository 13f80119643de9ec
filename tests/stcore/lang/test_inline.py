"""Code that is taken into its caller does what a call does: the same values, the same faults with the same path."""

import pytest
from running import Run, program

from stcore.emit import inline

PARTS = """
FUNCTION Steps : INT
VAR_INPUT up : INT; END_VAR
VAR_OUTPUT last : INT; END_VAR
VAR count : INT; i : INT; END_VAR
FOR i := 1 TO 10 DO
  IF i > up THEN Steps := count; RETURN; END_IF
  count := count + 1; last := i;
END_FOR
Steps := -1;
END_FUNCTION
FUNCTION Change : BOOL
VAR_INPUT n : INT; END_VAR
VAR_IN_OUT v : INT; END_VAR
n := n * 2;
v := v + n;
Change := v > 10;
END_FUNCTION
FUNCTION_BLOCK Inner
VAR_IN_OUT total : INT; END_VAR
VAR_INPUT d : INT; END_VAR
VAR_TEMP t : INT; END_VAR
t := t + 12 / d;
IF t > 5 THEN RETURN; END_IF
total := total + t;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Outer
VAR_INPUT d : INT; END_VAR
VAR inner : Inner; sum : INT; END_VAR
inner(total := sum, d := d);
END_FUNCTION_BLOCK
FUNCTION Again : DINT
VAR_INPUT n : DINT; END_VAR
IF n > 1 THEN Again := n * Again(n - 1); ELSE Again := 1; END_IF
END_FUNCTION
"""
DECLARATIONS = "o : ARRAY[1..3] OF Outer; s, l, i, n, d : INT; b : BOOL; v : INT := 1; many : DINT;"
BODY = """
d := d + 1;
FOR i := 1 TO 3 DO
  s := s + Steps(i, last => l);        // its own variables begin anew each time
  b := Change(SEL(Change(i, v := v), i, i + 1), v := v);
  o[i](d := i + d);
  n := n + 1;
END_FOR
many := Again(5) + Again(4);
"""
SIZES = [(0, 0), (120, 4000), (100_000, 100_000)]  # nothing, what is, everything


@pytest.fixture(params=SIZES, ids=["called", "as it is", "taken in"])
def sizes(request, monkeypatch):
    for name, size in zip(("SMALL", "ONCE"), request.param, strict=True):
        monkeypatch.setattr(inline, name, size)


@pytest.mark.usefixtures("sizes")
def test_the_same_values():
    run = Run(program(BODY, DECLARATIONS, PARTS)).scan(2)
    assert (run["s"], run["l"], run["n"], run["many"]) == (12, 3, 6, 144)
    v, expected = 1, False
    for i in (1, 2, 3, 1, 2, 3):
        v += 2 * i
        v += 2 * (i + 1 if v > 10 else i)
        expected = v > 10
    assert (run["v"], run["b"]) == (v, expected)
    sums = [sum(t for t in (12 // (i + d) for d in (1, 2)) if t <= 5) for i in (1, 2, 3)]
    assert [run[f"o[{i}].sum"] for i in (1, 2, 3)] == sums


@pytest.mark.usefixtures("sizes")
def test_the_same_fault():
    run = Run(program("x := x + 1;\no[2](d := 3 - x);", "x : INT; o : ARRAY[1..3] OF Outer;", PARTS)).scan(2)
    fault = run.fault()
    lines = PARTS.splitlines()
    assert fault.code == "F0102"
    assert lines[fault.line - 1] == "t := t + 12 / d;"
    assert fault.instance == "PLC_PRG.o[2].inner"
    assert [s.pou for s in fault.stack] == ["Inner", "Outer", "PLC_PRG"]
    assert run["x"] == 3


@pytest.mark.usefixtures("sizes")
def test_a_fault_behind_a_call_is_the_callers():
    text = program("x := 1;\ny := Steps(2) / (x - 1);", "x, y : INT;", PARTS)
    fault = Run(text).fault()
    assert (fault.code, fault.instance) == ("F0102", "PLC_PRG")
    assert text.splitlines()[fault.line - 1] == "y := Steps(2) / (x - 1);"


@pytest.mark.usefixtures("sizes")
def test_an_in_out_that_is_not_connected():
    fault = Run(program("inner(total := , d := 1);", "inner : Inner;", PARTS)).fault()
    assert (fault.code, fault.instance) == ("F0103", "PLC_PRG.inner")


def test_what_is_taken_in_stays_small(monkeypatch):
    """Blocks that call each other in pairs would double with every level."""
    levels = 24
    units = ["FUNCTION F0 : INT VAR_INPUT x : INT; END_VAR F0 := x + 1; END_FUNCTION"]
    for n in range(1, levels):
        units.append(f"FUNCTION F{n} : INT VAR_INPUT x : INT; END_VAR F{n} := F{n - 1}(x) + F{n - 1}(x); END_FUNCTION")
    run = Run(program(f"y := F{levels - 1}(1);", "y : INT;", "\n".join(units)))
    assert len(run.program.wasm) < 100_000
    monkeypatch.setattr(inline, "SMALL", 0)
    assert len(run.program.wasm) < 10 * len(Run(program("y := F9(1);", "y : INT;", "\n".join(units))).program.wasm)


@pytest.mark.parametrize("size", SIZES)
def test_what_a_block_changes_is_read_again(size, monkeypatch):
    for name, limit in zip(("SMALL", "ONCE"), size, strict=True):
        monkeypatch.setattr(inline, name, limit)
    before = """
VAR_GLOBAL g : INT; END_VAR
FUNCTION_BLOCK Adds g := g + 1; END_FUNCTION_BLOCK
FUNCTION_BLOCK Outside VAR adds : Adds; END_VAR adds(); END_FUNCTION_BLOCK
FUNCTION Five : INT g := g + 5; END_FUNCTION
PROGRAM Twice g := g * 2; END_PROGRAM
"""
    body = "g := 3; o(); x := g; g := 4; Five(); y := g; g := 5; Twice(); z := g; g := 6; a(); b(); w := g;"
    r = Run(program(body, "o : Outside; a, b : Adds; x, y, z, w : INT;", before)).scan()
    assert [r[n] for n in "xyzw"] == [4, 9, 10, 8]

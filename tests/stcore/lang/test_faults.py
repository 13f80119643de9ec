"""Faults: code, place, instance path, values; the image can be read afterwards and the machine used again."""

from threading import Timer

import pytest
from running import Run, program

from stcore.faults import Fault

LEAF = """FUNCTION_BLOCK Leaf
VAR_INPUT i : INT; d : INT := 1; END_VAR
VAR_OUTPUT done : INT; END_VAR
VAR a : ARRAY[1..3] OF INT; p : POINTER TO INT; END_VAR
done := 1;
a[i] := 10 / d;
done := 2;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Branch
VAR leaf : Leaf; leaves : ARRAY[0..2] OF Leaf; END_VAR
VAR_INPUT n : INT; END_VAR
leaf(i := n, d := 1);
END_FUNCTION_BLOCK
FUNCTION Quotient : DINT
VAR_INPUT a, b : DINT; END_VAR
Quotient := a / b;
END_FUNCTION
"""


def fault(body: str, declarations: str, before: str = "") -> Fault:
    return Run(program(body, declarations, before)).fault()


INDEX = [
    ("a[i] := 1;", "a : ARRAY[0..4] OF INT; i : INT := 5;", 3, 5, 0, 4),
    ("a[i] := 1;", "a : ARRAY[0..4] OF INT; i : INT := -1;", 3, -1, 0, 4),
    ("x := a[i + 1];", "a : ARRAY[-3..3] OF INT; x : INT; i : INT := -5;", 8, -4, -3, 3),
    ("a[1, j] := 1;", "a : ARRAY[0..1, 2..3] OF INT; j : SINT := 4;", 6, 4, 2, 3),
    ("a[j, 2] := 1;", "a : ARRAY[0..1, 2..3] OF INT; j : UINT := 65535;", 3, 65535, 0, 1),
    ("x := a[1][j];", "a : ARRAY[0..1] OF ARRAY[5..6] OF INT; j : INT := 4; x : INT;", 11, 4, 5, 6),
    ("a[i].0 := TRUE;", "a : ARRAY[0..1] OF WORD; i : INT := 2;", 3, 2, 0, 1),
    ("p^[i] := 1;", "a : ARRAY[0..1] OF INT; p : POINTER TO ARRAY[0..1] OF INT := ADR(a); i : INT := 2;", 4, 2, 0, 1),
    ("s[i] := 65;", "s : STRING(5); i : INT := 6;", 3, 6, 0, 5),
    ("x := s[i];", "s : WSTRING(5); i : INT := -1; x : WORD;", 8, -1, 0, 5),
    ("a[i] := 1;", "a : ARRAY[0..4] OF INT; i : LINT := 7;", 3, 7, 0, 4),
    ("a[u] := 1;", "a : ARRAY[0..4] OF INT; u : UDINT := 7;", 3, 7, 0, 4),
]


@pytest.mark.parametrize(("body", "declarations", "column", "value", "low", "high"), INDEX)
def test_index(body, declarations, column, value, low, high):
    f = fault(body, declarations)
    assert (f.code, f.line, f.column, f.instance, f.scan) == ("F0101", 6, column, "PLC_PRG", 0)
    assert f"is {value}, outside {low}..{high}" in f.message


@pytest.mark.parametrize("kind", ["ARRAY[*]", "ARRAY[*, *]"])
def test_index_of_an_open_array(kind):
    index = "a[i]" if "," not in kind else "a[i, 1]"
    bounds = "1..3" if "," not in kind else "1..3, 0..1"
    f = fault(
        "F(a, 4);", f"a : ARRAY[{bounds}] OF INT;",
        f"FUNCTION F : INT\nVAR_IN_OUT a : {kind} OF INT; END_VAR\n"
        f"VAR_INPUT i : INT; END_VAR\n  {index} := 1;\nEND_FUNCTION",
    )  # fmt: skip
    assert (f.code, f.line, f.column, f.instance) == ("F0101", 4, 5, "PLC_PRG.F")
    assert "is 4, outside 1..3" in f.message


@pytest.mark.parametrize(
    "kind", ["SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT", "BYTE", "WORD", "DWORD", "LWORD"]
)
@pytest.mark.parametrize("op", ["/", "MOD"])
def test_division_by_zero(kind, op):
    f = fault(f"a := b {op} c;", f"a, b, c : {kind};")
    assert (f.code, f.line, f.instance) == ("F0102", 6, "PLC_PRG")
    assert f.column == len(f"a := b {op} ") + 1


@pytest.mark.parametrize(
    ("body", "column"), [("t := t / n;", 10), ("l := l / n;", 10), ("d := u / m;", 10), ("d := n MOD (n * 2);", 13)]
)
def test_other_divisions_by_zero(body, column):
    f = fault(body, "t : TIME; l : LTIME; n : INT; d : LINT; u : UDINT; m : DINT;")
    assert (f.code, f.line, f.column) == ("F0102", 6, column)


POINTERS = [
    ("p^ := 1;", "F0103", 1, "p is NULL"),
    ("i := p^;", "F0103", 6, "p is NULL"),
    ("i := p[3];", "F0103", 6, "NULL"),
    ("q^.x := 1;", "F0103", 1, "q is NULL"),
    ("q^.n^.x := 1;", "F0103", 1, "q is NULL"),
    ("q := ADR(s); q^.n^.x := 1;", "F0103", 14, "q^.n is NULL"),
    ("p := 16#40000000; p^ := 1;", "F0104", 19, "outside the memory"),
    ("r := 1;", "F0103", 1, "r is NULL"),
    ("b^(x := 1);", "F0103", 1, "b is NULL"),
    ("a[1]^ := 1;", "F0103", 1, "a[1] is NULL"),
    ("MEMCPY(p, ADR(i), 1000000000);", "F0104", 1, "outside the memory"),
]


@pytest.mark.parametrize(("body", "code", "column", "text"), POINTERS)
def test_pointer(body, code, column, text):
    f = fault(
        body, "p : POINTER TO INT; q : POINTER TO S; s : S; i : INT; r : REFERENCE TO INT; b : POINTER TO B;"
        " a : ARRAY[0..1] OF POINTER TO INT;",
        "FUNCTION_BLOCK B VAR_INPUT x : INT; END_VAR END_FUNCTION_BLOCK "
        "TYPE S : STRUCT x : INT; n : POINTER TO S; END_STRUCT END_TYPE",
    )  # fmt: skip
    assert (f.code, f.line, f.column) == (code, 6, column)
    assert text in f.message


def test_instance_path_and_what_is_left():
    run = Run(program("  b[1](n := n);\n  ok := ok + 1;", "b : ARRAY[0..1] OF Branch; n : INT := 2; ok : INT;", LEAF))
    run.scan(3)
    run["n"] = 9
    f = run.fault()
    assert (f.code, f.line, f.column, f.scan) == ("F0101", 6, 3, 3)
    assert f.instance == "PLC_PRG.b[1].leaf"
    assert run["ok"] == 3
    assert run["b[1].leaf.done"] == 1
    assert run["b[1].leaf.i"] == 9
    run.machine.initialise()
    assert run["ok"] == 0 and run["n"] == 2
    run.scan(2)
    assert run["ok"] == 2


def test_a_machine_goes_on_after_a_fault():
    run = Run(program("x := x + 1; y := 10 / d;", "x, y : INT; d : INT;"))
    run.fault()
    run["d"] = 2
    run.scan()
    assert (run["x"], run["y"]) == (2, 5)


def test_fault_in_a_function():
    f = fault("x := 1;\nx := Quotient(x, x - 1);", "x : DINT;", LEAF)
    assert (f.code, f.line, f.column, f.instance) == ("F0102", 16, 17, "PLC_PRG.Quotient")


def test_fault_in_a_condition_and_an_argument():
    f = fault("IF x > 0 THEN\n  ;\nELSIF 1 / x > 0 THEN\n  ;\nEND_IF", "x : INT;")
    assert (f.code, f.line, f.column) == ("F0102", 8, 11)
    f = fault("x := MAX(1,\n  a[x]);", "x : INT := 7; a : ARRAY[0..1] OF INT;")
    assert (f.code, f.line, f.column) == ("F0101", 7, 5)


def test_fault_in_an_initial_value():
    with pytest.raises(Fault) as caught:
        Run(
            program(
                "x := 1;",
                "z : INT; x : INT := Zero(z);",
                "FUNCTION Zero : INT VAR_INPUT a : INT; END_VAR Zero := 1 / a; END_FUNCTION",
            )
        )
    assert caught.value.code == "F0102"


RECURSION = "FUNCTION Down : DINT\nVAR_INPUT n : DINT; END_VAR\n{}\nDown := Down(n + 1) + 1;\nEND_FUNCTION\n"


@pytest.mark.parametrize("own", ["", "VAR a : ARRAY[0..99] OF DINT; END_VAR"])
def test_endless_recursion(own):
    run = Run(program("x := Down(0);\ny := 1;", "x, y : DINT;", RECURSION.format(own)))
    f = run.fault()
    assert f.code == "F0105"
    assert f.line == 4 and f.instance == "...Down.Down"
    assert run["y"] == 0
    run.machine.initialise()
    assert run.fault().code == "F0105"


def test_recursion_that_ends():
    run = Run(program("x := Sum(500);", "x : DINT;", "FUNCTION Sum : DINT VAR_INPUT n : DINT; END_VAR "
                      "VAR a : ARRAY[0..20] OF DINT; END_VAR\n"
                      "a[3] := n; IF n > 0 THEN Sum := a[3] + Sum(n - 1); END_IF END_FUNCTION"))  # fmt: skip
    assert run.scan()["x"] == 125250


@pytest.mark.parametrize(
    "body",
    ["WHILE TRUE DO\n  x := x + 1;\nEND_WHILE", "REPEAT\n  x := x + 1;\nUNTIL FALSE\nEND_REPEAT",
     "again:\nx := x + 1;\nJMP again;",
     "FOR i := 0 TO 10 BY step DO\n  x := x + 1;\nEND_FOR", "FOR i := 0 TO 10 DO\n  i := 0; x := x + 1;\nEND_FOR"],
)  # fmt: skip
def test_endless_loop(body):
    run = Run(program(body, "x : DINT; i, step : INT;"))
    f = None
    while f is None:  # an interrupt before the run begins ends it without a scan
        timer = Timer(0.02, run.machine.interrupt)
        timer.start()
        try:
            run.machine.run(1)
        except Fault as fault:
            f = fault
        timer.join()
    assert f.code == "F0108" and f.line in (6, 7)
    assert run["x"] > 0
    run.machine.clear_interrupt()


@pytest.mark.parametrize("host", [None, {"HostAdd": lambda a, b: 1 / 0}])
def test_external(tmp_path, host):
    from stcore.build_program import build
    from stcore.compiler import LIBRARY
    from stcore.machine import Machine
    from stcore.source import Source

    (tmp_path / "HostAdd.st").write_text(
        "{attribute 'external'}\nFUNCTION HostAdd : DINT\nVAR_INPUT a, b : DINT; END_VAR\nEND_FUNCTION\n"
    )
    made, _ = build(
        [Source(program("  x := HostAdd(1, 2);", "x : DINT;"), "case.st")], None, [LIBRARY, tmp_path], False
    )
    machine = Machine(made, host)
    with pytest.raises(Fault) as caught:
        machine.run(1)
    assert (caught.value.code, caught.value.line, caught.value.column) == ("F0106", 6, 8)
    machine = Machine(made, {"HostAdd": lambda a, b: a + b})
    assert machine.run(5) == 5

"""Generated code: long expressions, long chains, many levels."""

import pytest
from running import diagnostics, errors, program, run

LEVELS = 300


@pytest.mark.parametrize(
    ("kind", "op", "value"),
    [("DINT", "+", 1500), ("LREAL", "+", 1500.0), ("BOOL", "OR_ELSE", True), ("WORD", "XOR", 0)],
)
def test_an_expression_of_1500_operands(kind, op, value):
    start = "TRUE" if kind == "BOOL" else "1"
    text = f" {op} ".join(["y"] * 1500)
    assert run(f"x := {text};", f"x : {kind}; y : {kind} := {start};")["x"] == value


def test_a_chain_of_500_elsif():
    branches = "".join(f"ELSIF y = {i} THEN x := {i * 7};\n" for i in range(500))
    assert run(f"IF y < 0 THEN x := -1;\n{branches}END_IF", "x : DINT; y : DINT := 499;")["x"] == 499 * 7


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("x := " + "(1 + " * LEVELS + "y" + ")" * LEVELS + ";", LEVELS + 1),
        ("x := " + "ABS(1 + " * LEVELS + "y" + ")" * LEVELS + ";", LEVELS + 1),
        ("IF y = 1 THEN " * LEVELS + "x := 1;" + "END_IF " * LEVELS, 1),
        ("FOR i := 1 TO 1 DO " * LEVELS + "x := x + 1;" + "END_FOR " * LEVELS, 1),
        ("IF y > 1 THEN ; ELSE " * LEVELS + "x := 1;" + "END_IF " * LEVELS, 1),
        ("CASE y OF 1: " * LEVELS + "x := 1;" + "END_CASE " * LEVELS, 1),
        ("x := " + "-" * LEVELS + "y;", 1),
        ("x := " * LEVELS + "y;", 1),
    ],
    ids=["brackets", "calls", "if", "for", "else", "case", "signs", "assignments"],
)
def test_300_levels(text, value):
    assert run(text, "x, i : DINT; y : DINT := 1;")["x"] == value


def test_constants_that_build_on_each_other_300_times():
    chain = "".join(f"c{i} : INT := c{i + 1} + 1; " for i in range(LEVELS))
    lists = f"VAR_GLOBAL CONSTANT {chain}c{LEVELS} : INT := 5; END_VAR"
    assert run("x := c0;", "x : INT;", lists)["x"] == LEVELS + 5


def test_what_is_too_deep_is_one_error():
    inner = "y"
    for _ in range(12):
        inner = f"({inner}" + " + y" * 1900 + ")"
    text = program(f"x := {inner};", "x, y : DINT;")
    assert [d.code for d in errors(text)] == ["E0113"] == [d.code for d in diagnostics(text)]

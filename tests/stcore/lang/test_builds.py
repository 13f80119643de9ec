"""The optimised build does what the build with probes does, which calls all and keeps every variable in memory."""

from random import Random

import pytest
from random_units import Units
from running import program

from stcore import paths, values
from stcore.build_program import build
from stcore.compiler import LIBRARY
from stcore.emit import inline
from stcore.faults import Fault
from stcore.machine import Machine
from stcore.program import NULL_PAGE
from stcore.source import Source

UNITS = """
VAR_GLOBAL g : DINT; gHold : Holder; toReal : POINTER TO REAL; END_VAR
FUNCTION Next : DINT VAR_INPUT d : DINT := 1; END_VAR g := g + d; Next := g; END_FUNCTION
FUNCTION At : DINT VAR_INPUT i : DINT; END_VAR At := PLC_PRG.a[i] + PLC_PRG.a[i + 1]; END_FUNCTION
FUNCTION Give : Pair VAR_INPUT i : DINT; END_VAR Give.one := PLC_PRG.a[i]; Give.two := At(i); END_FUNCTION
FUNCTION Add : DINT VAR_INPUT one, two : DINT; END_VAR Add := 10 * one + two; END_FUNCTION
TYPE Pair : STRUCT one, two : DINT; END_STRUCT END_TYPE
FUNCTION_BLOCK Writer g := g + 1; END_FUNCTION_BLOCK
FUNCTION_BLOCK Sum
VAR_INPUT a, b : DINT; END_VAR VAR_OUTPUT s : DINT; END_VAR
s := 10 * a + b;
END_FUNCTION_BLOCK
FUNCTION Spoil : DINT VAR_IN_OUT sum : Sum; END_VAR sum.a := 7; Spoil := 1; END_FUNCTION
FUNCTION_BLOCK Inner
VAR x, y, z, i : DINT; END_VAR
x := 1; gHold(); y := x;
FOR i := 1 TO 3 DO x := x + 1; gHold(); END_FOR
z := x;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Holder
VAR inner : Inner; END_VAR
inner.x := inner.x + 100;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Base g := g + 1; METHOD M g := g + 3; END_METHOD END_FUNCTION_BLOCK
FUNCTION_BLOCK Derived EXTENDS Base g := g + 10; METHOD M g := g + 30; END_METHOD END_FUNCTION_BLOCK
FUNCTION_BLOCK Target
VAR x, y, z, i : DINT; END_VAR
x := 1; toReal^ := 2; y := x;
FOR i := 1 TO 3 DO x := x + 1; toReal^ := 0; END_FOR
z := x;
END_FUNCTION_BLOCK
"""
DECLARATIONS = """a : ARRAY[0..5] OF DINT := [10, 11, 12, 13, 14, 15]; x, y : DINT; d : DWORD; w : Writer; s : Sum;
 pair : ARRAY[0..9] OF Pair; t : Target; i : DINT := 3;
 base : Base; derived : Derived; pb : POINTER TO Base; p : POINTER TO DWORD;"""
CASES = {
    "a block that changes a global": ("g := 1; w(); x := g;", {"x": 2}),
    "a block that the instance decides": ("g := 1; pb := ADR(derived); pb^(); x := g;", {"x": 11}),
    "a method that the instance decides": ("g := 1; pb := ADR(derived); pb^.M(); x := g;", {"x": 31}),
    "a call in the place": ("g := 1; a[Next()] := g;", {"a[2]": 2}),
    "LIMIT": ("g := 1; x := LIMIT(g, Next(), 10); g := 1; y := LIMIT(Next(), g, 10);", {"x": 2, "y": 2}),
    "MUX": ("g := 1; x := MUX(Next(), 10, g, g, 20);", {"x": 2}),
    "SEL": ("g := 1; x := SEL(Next() > 1, 0, g);", {"x": 2}),
    "SHL": ("g := 1; x := SHL(g, Next());", {"x": 4}),
    "EN": ("g := 1; x := Add(EN := Next() > 1, g, g);", {"x": 22}),
    "inputs": ("g := 1; s(a := g, b := Next()); x := s.s; s(a := 1, b := Spoil(s)); y := s.s;", {"x": 12, "y": 71}),
    "an inner assignment in bits of what a pointer leads to": (
        "p := ADR(d); p^.%B1 := x := y := a[i] + At(i);", {"x": 40, "y": 40, "d": 40 << 8}
    ),
    "code that is taken in beside another value": (
        "x := MIN(500, At(i)); y := ROL(DINT#1, At(1)); d.%B1 := TO_BYTE(At(i)); pair[a[2] - 9] := Give(i);",
        {"x": 27, "y": 1 << 23, "d": 27 << 8, "pair[3]": {"one": 13, "two": 27}},
    ),
    "an instance that holds the one that calls it": ("gHold.inner();", {"gHold.inner.y": 101, "gHold.inner.z": 404}),
    "a pointer of another type to a member": ("toReal := ADR(t.x); t();", {"t.y": 1 << 30, "t.z": 0}),
    "a pointer of another type to an instance": ("toReal := ADR(t); t();", {"t.y": 1 << 30, "t.z": 0}),
}  # fmt: skip


@pytest.mark.parametrize("probes", [False, True], ids=["fast", "probed"])
@pytest.mark.parametrize("case", CASES)
def test_the_same(case, probes):
    body, expected = CASES[case]
    made, _ = build([Source(program(body, DECLARATIONS, UNITS), "case.st")], None, [LIBRARY], False, probes)
    machine = Machine(made)
    machine.run(1)

    def value(path: str):
        return values.read(machine.memory, paths.resolve(made, path if path[:6] == "gHold." else f"PLC_PRG.{path}"))

    assert {path: value(path) for path in expected} == expected


def left(text: str, probes: bool) -> list:
    """After each of some scans: the memory, and the fault if there was one."""
    made, _ = build([Source(text, "units.st")], None, [LIBRARY], False, probes)
    machine, found = Machine(made), []
    for _ in range(4):
        try:
            machine.run(1)
        except Fault as fault:
            found.append((fault.code, fault.message, fault.line, fault.column, fault.instance))
        found.append(bytes(machine.memory[NULL_PAGE : made.state_end]))
    return found


@pytest.mark.parametrize("probes", [False, True], ids=["fast", "probed"])
def test_a_fault_behind_the_call_of_a_method_is_not_in_it(probes):
    before = """FUNCTION_BLOCK B METHOD M : DINT M := 9; END_METHOD END_FUNCTION_BLOCK
    FUNCTION F : DINT VAR_INPUT i : DINT; END_VAR VAR a : ARRAY[0..3] OF DINT; END_VAR F := a[i]; END_FUNCTION"""
    ((code, _, _, _, instance), *_) = left(program("x := F(b.M());", "x : DINT; b : B;", before), probes)
    assert (code, instance) == ("F0101", "PLC_PRG.F")


@pytest.mark.parametrize("seed", range(12))
def test_random_units(seed, monkeypatch):
    """A third of the programs with all code taken in that can be, a third with none."""
    if seed % 3:
        for name in ("SMALL", "ONCE"):
            monkeypatch.setattr(inline, name, (0, 100_000)[seed % 3 - 1])
    text = Units(Random(seed), faults=[0, 0.02, 0.1, 0.02][seed % 4]).program()
    assert left(text, False) == left(text, True)

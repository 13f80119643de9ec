"""Expressions and statements typed beside a loaded program."""

from pathlib import Path

import pytest
from side_session import Session

from stcore.compiler import compile, compile_condition
from stcore.diagnostics import CompileError
from stcore.faults import Fault
from stcore.known import Names, Scene
from stcore.machine import Machine
from stcore.paths import PathError
from stcore.side import SideError, compile_side, summary
from stcore.source import Source
from stcore.values import decode

TEXT = """
TYPE TPoint : STRUCT x, y : LREAL; END_STRUCT END_TYPE
TYPE Mode : (Idle, Busy := 5, Done); END_TYPE
FUNCTION Twice : INT
VAR_INPUT a : INT := 7; END_VAR
Twice := a * 2;
END_FUNCTION
FUNCTION Greet : STRING
VAR_INPUT s : STRING; END_VAR
Greet := CONCAT('hi ', s);
END_FUNCTION
FUNCTION Moved : TPoint
VAR_INPUT p : TPoint; END_VAR
VAR_OUTPUT far : BOOL; END_VAR
Moved.x := p.x + 1.0; Moved.y := p.y; far := TRUE;
END_FUNCTION
FUNCTION_BLOCK Acc
VAR_INPUT d : INT; END_VAR
VAR_OUTPUT sum : INT; END_VAR
VAR CONSTANT K : INT := 3; END_VAR
sum := sum + d;
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR
  n : INT; p : TPoint := (x := 1.5); m : Mode; acc : Acc; wait : TON; arr : ARRAY[1..3] OF INT := [1, 2, 3];
  txt : STRING := 'abc'; lim : INT := 10; on AT %MX0.3 : BOOL;
END_VAR
n := n + 1;
acc(d := 2);
wait(IN := TRUE, PT := T#10ms);
m := Busy;
ACTION Clear:
  n := 0;
END_ACTION
END_PROGRAM
PROGRAM Other
VAR lim : INT; only : INT := 4; END_VAR
lim := lim + 1;
END_PROGRAM
"""


@pytest.fixture(params=[False, True], ids=["plain", "probed"])
def run(request) -> Session:
    return Session(TEXT, request.param, 3)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2", "3"), ("n", "3"), ("PLC_PRG.n * 2", "6"), ("plc_prg.N", "3"), ("Twice(n)", "6"), ("Twice()", "14"),
        ("Greet('bob')", "'hi bob'"), ("Greet(txt)", "'hi abc'"), ("CONCAT(txt, '!')", "'abc!'"), ("LEN(txt)", "3"),
        ("Moved(p)", "(x := 2.5, y := 0.0)"), ("Moved(p).x", "2.5"), ("acc.sum", "6"), ("acc.K", "3"), ("m", "Busy"),
        ("m = Done", "FALSE"), ("Mode.Done", "Done"), ("arr", "[1, 2, 3]"), ("arr[n]", "3"), ("wait.ET", "T#0.002s"),
        ("'it$'s'", "'it$'s'"), ("T#5s", "T#5s"), ("txt = 'abc' AND n > 2", "TRUE"), ("only", "4"), ("ADR(n)^", "3"),
        ("%MX0.3", "FALSE"), ("REAL_TO_STRING(1.5)", "'1.5'"), ("ABS(SIN(0.0))", "0.0"), ("n.0", "TRUE"),
    ],
)  # fmt: skip
def test_expressions(run, text, value):
    assert run(text) == value


def test_statements_change_the_program(run):
    run("n := 40; acc(d := 5)")
    assert run("acc.sum + n") == "51"
    run("FOR n := 1 TO 10 DO arr[1] := arr[1] + n; END_FOR")
    assert run("arr[1]") == "56"
    run("IF n > 5 THEN p.x := 9.0; ELSE p.x := 0.0; END_IF")
    assert run("p.x") == "9.0"
    run("Moved(p, far => on)")
    assert run("on") == "TRUE"


def test_programs_and_actions_are_called(run):
    run("Other()")
    assert run("Other.lim") == "1"
    run("PLC_PRG.Clear()")
    assert run("n") == "0"


def test_a_program_that_no_task_runs_can_be_called(run):
    run("Other(); Other()")
    assert run("Other.lim") == "2"


@pytest.mark.parametrize(
    ("text", "said"),
    [("foo", "not declared"), ("arr[7]", "outside 1..3"), ("n +", ""), ("acc.K := 4", "CONSTANT"), ("n := 'a'", "")],
)
def test_what_is_wrong_is_said(run, text, said):
    with pytest.raises(CompileError) as error:
        run(text)
    assert said in summary(error.value.diagnostics)


def test_an_ambiguous_name_lists_its_candidates(run):
    with pytest.raises(PathError, match=r"PLC_PRG\.lim, Other\.lim"):
        run("lim")


def test_a_direct_address_outside_its_area(run):
    with pytest.raises(PathError, match="has 1 bytes"):
        run("%MW40")


def test_too_large_constants(run):
    with pytest.raises(SideError, match="memory"):
        run("LEN('" + "x" * 40000 + "')")


def test_a_fault_leaves_the_machine_well(run):
    for text in ("n / (n - n)", "arr[n + 1]"):
        with pytest.raises(Fault):
            run(text)
    assert run.machine.run(2) == 2
    assert run("n") == "5"


def test_inside_an_instance(run):
    kind = run.program.types["ACC"]
    scene = Scene("Acc", kind)
    place = run.program.variables["PLC_PRG"]
    this = place.address + place.type.members["ACC"].offset
    assert run("sum * K", scene, this) == "18"
    run("sum := 1", scene, this)
    assert run("PLC_PRG.acc.sum") == "1"


def test_conditions_with_strings_and_functions(run):
    program, machine = run.program, run.machine
    machine.set_until(compile_condition(program, "Greet(txt) = 'hi abc' AND n >= 7"))
    assert machine.run(100) == 4
    machine.set_until(None)
    assert machine.run(5) == 5


def test_probed_and_plain_builds_have_the_same_image():
    plain, probed = Session(TEXT, False, 3), Session(TEXT, True, 3)
    assert plain.program.image == probed.program.image
    end = plain.program.image_end
    assert bytes(plain.machine.memory[1024:end]) == bytes(probed.machine.memory[1024:end])


def test_library_functions_that_the_program_does_not_use():
    program = compile([Path(__file__).parents[2] / "examples_st" / "blinker.st"])
    machine = Machine(program)
    side = compile_side(Names(program), "SIN(0.5)")
    address = machine.side(side)(0, 0)
    assert decode(machine.memory, side.type, address) == pytest.approx(0.479425538604203, rel=1e-15)


def test_a_library_function_that_was_taken_into_its_callers():
    """The module has no code of its own for it, so what is typed brings its own."""
    program = compile([Source("PROGRAM P VAR b : WORD; END_VAR\nb := INT_TO_BCD(12);\nEND_PROGRAM")])
    assert program.routines["INT_TO_BCD"].export == ""
    machine = Machine(program)
    machine.run(1)
    side = compile_side(Names(program), "INT_TO_BCD(34) + b")
    assert decode(machine.memory, side.type, machine.side(side)(0, 0)) == 0x34 + 0x12


@pytest.mark.parametrize(
    "text, message",
    [
        ("n >", "a value is missing before the end"), ("IF n > 3 THEN", "END_IF is missing for the IF at line 1"),
        ("foo(", ") is missing for the ( at line 1, column 4"), ("n / 0", "division by the constant 0"),
    ],
)  # fmt: skip
def test_what_is_typed_wrong_is_explained_as_what_it_resembles(text, message):
    program = compile([Source("PROGRAM P VAR n : INT; END_VAR\nn := 1;\nEND_PROGRAM")])
    with pytest.raises(CompileError) as error:
        compile_side(Names(program), text)
    assert error.value.diagnostics[0].message == message


@pytest.mark.parametrize(
    ("text", "n"),
    [
        ("n := 1; PLC_PRG.n := 5; PLC_PRG.lim := n;", 5),
        ("n := 7; PLC_PRG(); PLC_PRG.lim := n;", 8),
        ("FOR n := 1 TO 3 DO PLC_PRG.n := 9; PLC_PRG.lim := n; END_FOR", 9),
    ],
)
def test_a_variable_that_the_text_names_in_two_ways(run, text, n):
    run(text)
    assert run("PLC_PRG.lim") == str(n)

"""Programs in tasks, configurations, programs and blocks in the image."""

import struct

from running import Run, errors, program

from stcore.build_program import build
from stcore.compiler import LIBRARY
from stcore.machine import Machine
from stcore.program import TASK_RATIOS, TaskSpec
from stcore.source import Source

CONFIGURATION = """
PROGRAM Fast VAR n : INT; END_VAR n := n + 1; trace := CONCAT(trace, 'f'); END_PROGRAM
PROGRAM Slow VAR n : INT; END_VAR n := n + 1; trace := CONCAT(trace, 's'); END_PROGRAM
PROGRAM Other VAR_INPUT k : INT; END_VAR VAR_OUTPUT o : INT; END_VAR VAR n : INT; END_VAR
n := n + k; o := n * 2; trace := CONCAT(trace, 'o'); END_PROGRAM
VAR_GLOBAL trace : STRING; END_VAR
CONFIGURATION plant
  VAR_GLOBAL in : INT := 3; out : INT; END_VAR
  RESOURCE cpu ON PLC
    TASK quick (INTERVAL := T#1ms, PRIORITY := 2);
    TASK slow (INTERVAL := T#3ms, PRIORITY := 1);
    PROGRAM p1 WITH quick : Fast;
    PROGRAM p2 WITH slow : Slow;
    PROGRAM p3 WITH slow : Other (k := in, o => out);
  END_RESOURCE
  VAR_CONFIG Fast.n : INT := 9; END_VAR
END_CONFIGURATION
"""


def test_configuration():
    run = Run(CONFIGURATION)
    assert [(t.name, t.programs, t.interval, t.priority) for t in run.program.tasks] == [
        ("slow", ["Slow", "Other"], 3_000_000, 1),
        ("quick", ["Fast"], 1_000_000, 2),
    ]
    struct.pack_into("<2I", run.machine.memory, TASK_RATIOS, 3, 1)
    run.scan(4)
    assert run["trace"] == "sofffsof"
    assert (run["Fast.n"], run["Slow.n"], run["Other.n"], run["out"]) == (13, 2, 6, 12)


def test_inputs_are_taken_at_every_call():
    run = Run(CONFIGURATION).scan()
    run["in"] = 100
    run.scan()
    assert run["Other.n"] == 103


def test_tasks_that_are_given():
    text = "PROGRAM A VAR n : INT; END_VAR n := n + 1; END_PROGRAM PROGRAM B VAR n : INT; END_VAR n := A.n; END_PROGRAM"
    tasks = [TaskSpec("t", ["B", "A"])]
    made, _ = build([Source(text, "case.st")], tasks, [LIBRARY], False)
    assert Machine(made).run(3) == 3
    assert made.tasks == tasks


def test_var_config_places_a_variable():
    text = program(
        "k := k + 1; w := %MW7;", "k AT %M* : INT; w : INT;", "VAR_CONFIG PLC_PRG.k AT %MW7 : INT := 4; END_VAR"
    )
    run = Run(text).scan()
    assert (run["w"], run["%MW7"]) == (5, 5)


def test_var_config_of_what_is_not_there():
    found = errors(
        program(
            "",
            "f : F;",
            "FUNCTION_BLOCK F VAR q AT %Q* : BOOL; END_VAR END_FUNCTION_BLOCK\n"
            "VAR_CONFIG PLC_PRG.f.q AT %QX0.0 : BOOL; END_VAR",
        )
    )
    assert [(d.code, d.line, d.column) for d in found] == [("E0114", 2, 12)]


def test_wrong_connection_is_one_error():
    found = errors(CONFIGURATION.replace("k := in", "kk := in"))
    assert [d.code for d in found] == ["E0408"]

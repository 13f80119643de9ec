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


def test_wrong_connection_is_one_error():
    found = errors(CONFIGURATION.replace("k := in", "kk := in"))
    assert [d.code for d in found] == ["E0408"]


INSTANCES = """
FUNCTION_BLOCK Filter
VAR_INPUT step : INT; END_VAR
VAR in AT %I* : BOOL; out AT %Q* : INT; word AT %M* : WORD; n : INT := 5; END_VAR
IF in THEN n := n + step; END_IF
out := n; word := word + 1;
END_FUNCTION_BLOCK

PROGRAM Count
VAR_INPUT inc : INT := 1; END_VAR
VAR_OUTPUT total : INT; END_VAR
VAR n : INT := start; start : INT := 10; f : ARRAY[1..2] OF Filter; own : INT; END_VAR
VAR_STAT all : INT; END_VAR
add; all := all + 1;
f[1](step := inc); f[2](step := inc);
Count.own := Count.own + 1;
ACTION add: n := n + inc; total := n; END_ACTION
END_PROGRAM

VAR_GLOBAL result : INT; alone : Filter; END_VAR
PROGRAM Watch VAR w : INT; direct : WORD; END_VAR w := Count.n; direct := %MW3; END_PROGRAM

CONFIGURATION plant
  RESOURCE cpu ON PLC
    TASK main (INTERVAL := T#1ms, PRIORITY := 1);
    PROGRAM first WITH main : Count (inc := 2);
    PROGRAM second WITH main : Count (inc := 3, total => result);
    PROGRAM w WITH main : Watch;
  END_RESOURCE
  VAR_CONFIG
    second.f[1].in AT %IX0.3 : BOOL;
    plant.cpu.second.f[2].in AT %IX0.4 : BOOL;
    second.f[2].out AT %QW1 : INT;
    first.f[1].word AT %MW3 : WORD := 7;
    first.f[2].n : INT := 50;
    alone.n : INT := 9;
  END_VAR
END_CONFIGURATION
"""


def test_instances_of_one_program_have_their_own_variables():
    run = Run(INSTANCES)
    assert run.program.tasks[0].programs == ["first", "second", "Watch"]
    run.scan(3)
    assert [run[p] for p in ("first.n", "second.n", "first.total", "second.total", "result")] == [16, 19, 16, 19, 19]
    assert [run[p] for p in ("first.own", "second.own", "first.all", "second.all")] == [3, 3, 6, 6]
    assert (run["w.w"], run["Watch.w"], run["Count.n"]) == (16, 16, 16)


def test_var_config_places_members_of_blocks():
    run = Run(INSTANCES)
    run["%IX0.4"] = True
    run.scan(2)
    run["%IX0.3"] = True
    run.scan()
    assert [run[f"second.f[{i}].n"] for i in (1, 2)] == [8, 14] and run["first.f[1].n"] == 5
    assert (run["%QW1"], run["second.f[2].out"]) == (14, 14)
    assert (run["%MW3"], run["first.f[1].word"], run["Watch.direct"]) == (3, 3, 2)


def test_var_config_gives_initial_values_to_members():
    run = Run(INSTANCES)
    assert [run[p] for p in ("first.f[2].n", "second.f[2].n", "alone.n", "first.f[1].word")] == [50, 5, 9, 7]


def test_var_config_that_leads_nowhere():
    for old, new, part in (
        ("second.f[1].in AT", "third.f[1].in AT", "no program or global variable third"),
        ("second.f[1].in AT", "second.f[3].in AT", "outside 1..2"),
        ("second.f[1].in AT", "second.f[1].inn AT", "did you mean in"),
        ("second.f[1].in AT %IX0.3 : BOOL", "second.f[1].in AT %IX0.3 : INT", "declared as BOOL"),
    ):
        found = errors(INSTANCES.replace(old, new))
        assert [d.code for d in found] == ["E0209"] and part in found[0].message, found


def test_two_instances_of_one_name_are_an_error():
    found = errors(INSTANCES.replace("PROGRAM second WITH", "PROGRAM first WITH").replace("second.", "first."))
    assert [d.code for d in found] == ["E0201"]


def test_an_input_with_an_edge_is_seen_for_one_call():
    block = """
    FUNCTION_BLOCK Edges
    VAR_INPUT up : BOOL R_EDGE; down, other : BOOL F_EDGE; plain : BOOL; END_VAR
    VAR n, m, k : INT; R_EDGE : INT; END_VAR
    IF up THEN n := n + 1; RETURN; END_IF
    IF down THEN count(); END_IF
    IF other THEN k := k + 1; END_IF
    ACTION count: IF down AND NOT plain THEN m := m + 1; END_IF END_ACTION
    END_FUNCTION_BLOCK
    """
    made = Run(program("e(up := x, down := x); outside := e.up;", "e : Edges; x, outside : BOOL;", block))
    rows = []
    for value in (False, True, True, False, False, True, False):
        made["x"] = value
        made.scan()
        rows.append((made["e.n"], made["e.m"], made["outside"]))
    assert rows == [
        (0, 0, False), (1, 0, True), (1, 0, True), (1, 1, False), (1, 1, False), (2, 1, True), (2, 2, False)
    ]  # fmt: skip
    assert made["e.k"] == 0


def test_an_edge_is_for_inputs_of_blocks():
    for text in (
        "FUNCTION F : INT VAR_INPUT a : BOOL R_EDGE; END_VAR END_FUNCTION PROGRAM P END_PROGRAM",
        "FUNCTION_BLOCK F VAR_INPUT a : INT F_EDGE; END_VAR END_FUNCTION_BLOCK PROGRAM P END_PROGRAM",
        "PROGRAM P VAR a : BOOL R_EDGE; END_VAR END_PROGRAM",
    ):
        assert [d.code for d in errors(text)] == ["E0210"]


ACCESS = INSTANCES.replace("  RESOURCE cpu", """  VAR_ACCESS
    Speed : cpu.second.f[1].n : INT READ_WRITE;
    Total : first.total : INT;
    Input : cpu.%IX0.7 : BOOL READ_WRITE;
    Out : result : INT READ_ONLY;
  END_VAR
  RESOURCE cpu""")  # fmt: skip


def test_a_resource_runs_on_whatever_is_named():
    text = "CONFIGURATION c RESOURCE r ON Vendor.Cpu_3 TASK t (PRIORITY := 1); PROGRAM p WITH t : A; END_RESOURCE"
    run = Run(f"PROGRAM A VAR n : INT; END_VAR n := n + 1; END_PROGRAM {text} END_CONFIGURATION").scan()
    assert run["A.n"] == run["p.n"] == 1


def test_access_paths_are_names_for_variables():
    run = Run(ACCESS)
    run["Speed"] = 40
    run["Input"] = True
    run.scan()
    assert [run[p] for p in ("Speed", "second.f[1].n", "Total", "Out", "%IX0.7")] == [40, 40, 12, 13, True]
    place = run._place
    assert [place(p).read_only for p in ("Speed", "Total", "Input", "Out")] == [False, True, False, True]


def test_an_access_path_that_leads_nowhere():
    found = errors(ACCESS.replace("first.total : INT", "first.totl : INT"))
    assert [d.code for d in found] == ["E0209"] and "did you mean total" in found[0].message
    assert [d.code for d in errors(ACCESS.replace("READ_ONLY", "READ_SOME"))] == ["E0101"]

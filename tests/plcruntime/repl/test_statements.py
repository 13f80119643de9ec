"""Breakpoints and statement steps: a scan that waits in its middle."""

from pathlib import Path

import pytest

from plcruntime import PLC
from plcruntime.debugger import MANY, Debugger
from plcruntime.plc import build
from plcruntime.repl import Repl


def test_next_goes_over_calls(prompt):
    lines = [prompt("next").splitlines()[-1] for _ in range(5)]
    assert [x.split("|")[1].strip() for x in lines] == [
        "n := n + 1;", "acc(d := 2);", "blocks[2](d := n);", "wait(IN := TRUE, PT := T#10ms);", "IF n > lim THEN",
    ]  # fmt: skip
    assert prompt("next").endswith("p.x := p.x + 0.5;")
    assert prompt("next") == "1 scan, 0.001 s"


def test_into_and_out_of_blocks_and_functions(prompt):
    prompt.all("next", "next")
    assert prompt("into").startswith("PLC_PRG.acc (Acc), in scan 0")
    assert "half := a;" in prompt("into")
    assert prompt("a") == "2"
    prompt("next")
    assert prompt("half") == "2"
    assert "sum := sum + tmp" in prompt("out")
    assert prompt("tmp") == "4"
    assert "blocks[2]" in prompt("out")
    assert prompt("into").startswith("PLC_PRG.blocks[2] (Acc)")
    assert prompt("where").splitlines()[0].startswith("PLC_PRG.blocks[2], ")


def test_into_a_block_of_the_library(prompt):
    prompt.all("next", "next", "next", "next")
    text = prompt("into")
    assert text.startswith("PLC_PRG.wait (TON), in scan 0")
    assert prompt("IN") == "TRUE"
    assert "running : BOOL" in prompt("list")


def test_breakpoint_with_condition(prompt, line_of):
    line = line_of("sum := sum")
    assert prompt(f"break Acc:{line} if sum > 30 AND d = 2").startswith(f"breakpoint 1: Acc:{line}")
    text = prompt("run 1s")
    assert text.startswith("breakpoint 1: PLC_PRG.acc (Acc), in scan 8, 0.008 s")
    assert prompt("sum") == "32"
    assert prompt("PLC_PRG.n") == "9"
    assert prompt("break").endswith("hit 1 time")
    assert prompt("continue").startswith("breakpoint 1: PLC_PRG.acc (Acc), in scan 9")
    prompt("delete 1")
    assert prompt("step 5") == "14 scans, 0.014 s"


def test_breakpoint_in_a_function_and_a_file(prompt, line_of, source):
    prompt(f"break prog.st:{line_of('half := a')} if a = 5")
    assert "Twice, in scan 4" in prompt("run 1s")


def test_changing_variables_in_the_middle_of_a_scan(prompt):
    prompt.all("step 3", "next", "next")
    assert prompt("n") == "4"
    prompt("set n := 100")
    assert prompt("step") == "4 scans, 0.004 s"
    assert prompt("n") == "100"
    # such a scan can't be repeated, so going back ends there
    assert "can't go back" in prompt("back 2")
    prompt.all("step 5", "back 5")
    assert prompt("n") == "100"


def test_back_undoes_the_waiting_scan(prompt):
    prompt.all("step 3", "next", "next", "next")
    assert prompt("n") == "4"
    assert prompt("back") == "3 scans, 0.003 s"
    assert prompt("n") == "3"
    prompt.all("next", "next")
    assert prompt("back 2") == "2 scans, 0.002 s"


def test_expressions_and_watches_while_waiting(prompt, line_of):
    prompt.all("watch n", f"break Acc:{line_of('tmp := ')}")
    text = prompt("run 1s")
    assert text.splitlines()[-1] == "  n = 1"
    assert prompt("Twice(21)") == "42"
    assert "between two scans" in prompt("save x")
    assert "whole scans" in prompt("plot PLC_PRG.n")
    prompt("delete")
    assert prompt("run #10").startswith("10 scans")


def test_a_condition_that_fails_stops_and_says_why(prompt, line_of):
    prompt(f"break Acc:{line_of('tmp := ')} if PLC_PRG.arr[d + sum] > 100")
    text = prompt("run 1s")
    assert "the condition failed" in text and "16#" not in text


def test_a_fault_while_stepping(prompt, line_of):
    prompt("set n := 32767")
    prompt.all(f"break Acc:{line_of('tmp := ')}", "continue", "delete")
    prompt("PLC_PRG.arr[1] := 5")
    assert "F0101" in prompt("PLC_PRG.arr[sum + 9]")
    assert prompt("step").startswith("1 scan")


def test_probed_and_plain_runs_end_in_the_same_image(source):
    plain, probed = PLC.load(source), PLC.load(source)
    plain.scan(500)
    debugger = Debugger(probed)
    debugger.attach()
    debugger.breakpoints.add("Acc", 1, "sum > 500 AND sum < 510")
    outcome = debugger.run(500)
    stops = 0
    while outcome.stop is not None:
        stops += 1
        debugger.step("into")
        outcome = debugger.run(500 - probed.scans)
    assert stops > 0
    assert probed.scans == 500
    end = plain.program.state_end
    assert bytes(plain._machine.memory[1024:end]) == bytes(probed._machine.memory[1024:end])


def test_the_prompt_begins_with_probes_and_goes_on_without(source):
    plain, plc = PLC.load(source), PLC.load(source, probes=True)
    debugger = Debugger(plc)
    assert debugger.step("next").stop is not None  # no other build is needed, nor is there one
    debugger.run(10)
    assert debugger.active and plc.scans == 10
    debugger.prepare()
    debugger.run(MANY + 10)  # long enough to wait for the fast build
    assert not debugger.active and plc.scans == MANY + 20
    plain.scan(MANY + 20)
    end = plain.program.state_end
    assert bytes(plain._machine.memory[1024:end]) == bytes(plc._machine.memory[1024:end])
    debugger.step("next")
    debugger.breakpoints.add("Acc", 1)
    assert debugger.run(1).stop.breakpoint == 1 and debugger.active
    debugger.breakpoints.remove(None)
    debugger.finish()
    debugger.run(1)
    assert not debugger.active


@pytest.mark.parametrize("edit", [("n := n + 1;", "n := n + 2;"), ("n := n + 1;", "n := ;")])
def test_a_source_that_changes_behind_the_prompt_leaves_the_program_that_was_loaded(source, edit):
    plain, plc = PLC.load(source), PLC.load(source, probes=True)
    before = source.read_text()
    source.write_text(before.replace(*edit))
    debugger = Debugger(plc)
    debugger.prepare()
    debugger.run(MANY + 10)
    source.write_text(before)
    assert debugger.active and plc.scans == MANY + 10
    plain.scan(MANY + 10)
    assert plc["n"] == plain["n"]


def test_a_typed_loop_that_does_not_end_is_broken_off_and_undone(source, capsys):
    repl = Repl(PLC.load(source, watchdog=0.2))
    for line in ("next", "next", "WHILE TRUE DO lim := lim + 1; END_WHILE", "PLC_PRG.lim", "step", "n"):
        repl.handle(line)
    said = capsys.readouterr().out.splitlines()[-4:]
    assert "F0108" in said[0]
    assert said[1:] == ["10", "1 scan, 0.001 s", "1"]
    repl.session.close()


def test_a_loop_that_does_not_end_is_a_fault_while_there_are_breakpoints(tmp_path, capsys):
    loop = "WHILE n = 3 DO\n;\nEND_WHILE\nn := n + 1;"
    (tmp_path / "p.st").write_text(f"PROGRAM P\nVAR n : INT; END_VAR\n{loop}\nEND_PROGRAM")
    repl = Repl(PLC.load(tmp_path / "p.st", watchdog=0.3))
    for line in ("break P:6 if n > 5", "run 1s", "n"):
        repl.handle(line)
    said = capsys.readouterr().out
    assert "F0108" in said and said.splitlines()[-1] == "3"
    repl.session.close()


@pytest.mark.parametrize(
    "edit", [("lim : INT := 10", "lim : INT := 11"), ("n := n + 1;", "n := n + 2;"), ("acc(d := 2);", "")]
)
def test_a_changed_source_is_refused(prompt, source, edit):
    before = source.read_text()
    source.write_text(before.replace(*edit))
    assert "has changed" in prompt("next")
    assert prompt("step") == "1 scan, 0.001 s"
    source.write_text(before)
    assert prompt("next").endswith("n := n + 1;")


def test_a_changed_file_beside_the_source_is_refused(source, capsys):
    source.write_text("PROGRAM P\nVAR n : INT; END_VAR\nn := Other(n);\nEND_PROGRAM\n")
    other = "FUNCTION Other : INT\nVAR_INPUT a : INT; END_VAR\nOther := a + %d;\nEND_FUNCTION\n"
    (source.parent / "Other.st").write_text(other % 1)
    repl = Repl(PLC.load(source))
    (source.parent / "Other.st").write_text(other % 12)
    repl.handle("next")
    assert "has changed" in capsys.readouterr().out
    repl.session.close()


@pytest.fixture
def loop(tmp_path):
    """A debugger that counts how often the module has called it."""
    text = "FOR i := 0 TO 4 DO\n  k := k + 1;\nEND_FOR\nn := n + 1;" + "\nk := k;" * 20
    program = f"PROGRAM P\nVAR n, i, k : INT; a : ARRAY[0..30] OF INT; END_VAR\n{text}\nEND_PROGRAM\n"
    functions = [
        f"FUNCTION {name} : INT\nVAR_INPUT x : INT; END_VAR\n{name} := {value};\nEND_FUNCTION\n"
        for name, value in (("Halved", "x / 2"), ("Tenth", "10 / x"))
    ]
    (tmp_path / "p.st").write_text(program + "".join(functions))
    debugger = Debugger(PLC.load(tmp_path / "p.st"))
    debugger.attach()
    called, usual = [], debugger._engine.machine.on_probe
    debugger._engine.machine.on_probe = lambda *where: (called.append(where), usual(*where))
    debugger.calls = called
    return debugger


def test_simple_conditions_are_asked_inside_the_module(loop):
    loop.breakpoints.add("P", 4, "n = 90 AND i = 3")
    outcome = loop.run(200)
    plc = loop._plc
    assert outcome.stop.breakpoint == 1 and plc.scans == 90 and plc.evaluate("P.n") == 90
    assert loop.evaluate("i").value == 3 and len(loop.calls) == 1
    loop.run(10)
    assert plc.scans == 100 and plc["P.n"] == 100 and len(loop.calls) == 1


@pytest.mark.parametrize(
    "line, condition, scan, calls, fails",
    [
        (6, "k / (n - 20) > 1000", 20, 1, True),  # it is asked once in that scan
        (4, "10 / (k - 23) > 1000", 4, 4, True),  # k is 20 when the scan begins
        (4, "a[k] > 100", 6, 2, True),
        (4, "Halved(k) = 16", 6, 1, False),
        (4, "Halved(a[k]) = 16", 6, 2, True),
        (4, "Tenth(k - 23) = 16", 4, 4, True),
    ],
)
def test_a_condition_that_may_fail_is_asked_inside_the_module_too(loop, line, condition, scan, calls, fails):
    point = loop.breakpoints.add("P", line, condition)
    loop.breakpoints.add("Halved", 1)  # what a condition calls does not stop
    plc = loop._plc
    outcome = loop.run(200)
    assert plc.fault is None and plc.scans == scan
    assert len([site for site, *_ in loop.calls if site in point.sites]) == calls
    assert outcome.stop.note.startswith("the condition failed") == fails
    loop.breakpoints.remove(None)
    assert loop.run(200 - scan).stop is None
    assert plc.scans == 200 and plc.evaluate("P.n") == 200 and plc.evaluate("P.k") == 1000


def test_a_condition_that_fails_after_a_stop_in_the_same_scan(loop):
    loop.breakpoints.add("P", 4, "k = 21")
    loop.breakpoints.add("P", 6, "a[n * 10] > 0")
    seen = []
    for _ in range(3):
        stop = loop.run(200).stop
        seen.append((stop.breakpoint, stop.site.line, bool(stop.note), loop._plc.scans))
    assert seen == [(1, 4, False, 4), (2, 6, True, 4), (2, 6, True, 5)]


def test_two_conditions_at_one_statement(loop):
    loop.breakpoints.add("P", 6, "n = 7")
    loop.breakpoints.add("P", 6, "n = 5")
    assert [loop.run(100).stop.breakpoint for _ in range(2)] == [2, 1]
    assert loop._plc.scans == 7 and loop.run(100).stop is None


def test_more_conditions_than_the_module_has_room_for(loop):
    for line in (4, 6):
        for _ in range(20):
            point = loop.breakpoints.add("P", line, "n = 1000")
            loop.run(1)
            loop.breakpoints.remove(point.number)
    for n in range(20):
        loop.breakpoints.add("P", 7 + n, f"n = {80 - n}")
    stops = [loop.run(1000).stop.breakpoint - 40 for _ in range(20)]
    assert stops == list(range(20, 0, -1)) and loop._plc.scans == 79
    assert 20 < len(loop.calls) < 20 + 5 * 41  # four were asked by the host


def test_lists_of_values_are_set_in_the_middle_of_a_scan(prompt, line_of):
    prompt.all("next", "set p := (x := 2.5)", "set arr := [7, 8]")
    assert prompt("p") == "(x := 2.5, y := 0.0)" and prompt("arr") == "[7, 8, 3]"
    assert prompt("set arr := [1, 2, 3, 4]").startswith("PLC_PRG.arr") and prompt("arr") == "[7, 8, 3]"
    prompt.all(f"break Acc:{line_of('sum := sum')}", "continue", "set d := 40", "step")
    assert prompt("p.x") == "3.0"


def test_the_variables_of_both_builds_of_a_motion_program_lie_alike():
    file = Path(__file__).parents[3] / "examples_st" / "gt_jog.st"
    plain, _ = build(file)
    probed, _ = build(file, probes=True)
    assert plain.state_end == probed.state_end
    assert plain.image[: plain.state_end] == probed.image[: plain.state_end]


def test_the_counter_of_a_loop_that_is_set_in_its_middle(tmp_path, capsys):
    """The loop goes on from there, and an index that it leads out of range is a fault."""
    loop = "FOR i := 0 TO 3 DO\nn := n + 1;\na[i] := i;\nEND_FOR"
    (tmp_path / "p.st").write_text(f"PROGRAM P\nVAR i, n : INT; a : ARRAY[0..3] OF INT; END_VAR\n{loop}\nEND_PROGRAM")
    repl = Repl(PLC.load(tmp_path / "p.st"))
    for line in ("break P:4", "run 1ms", "set i := 3", "continue", "P.a", "n", "run 1ms", "set i := 9", "run 1ms"):
        repl.handle(line)
    said = capsys.readouterr().out.splitlines()
    repl.session.close()
    assert said[said.index("[0, 0, 0, 3]") + 1] == "1"
    assert any("F0101" in line for line in said)

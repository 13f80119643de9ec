"""Breakpoints and statement steps: a scan that waits in its middle."""

from pathlib import Path

from plcruntime import PLC
from plcruntime.debugger import Debugger
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


def test_a_changed_source_is_refused(prompt, source):
    source.write_text(source.read_text().replace("lim : INT := 10", "lim : INT := 11"))
    assert "has changed" in prompt("next")
    assert prompt("step") == "1 scan, 0.001 s"


def test_the_variables_of_both_builds_of_a_motion_program_lie_alike():
    file = Path(__file__).parents[3] / "examples_st" / "gt_jog.st"
    plain, _ = build(file)
    probed, _ = build(file, probes=True)
    assert plain.state_end == probed.state_end
    assert plain.image[: plain.state_end] == probed.image[: plain.state_end]

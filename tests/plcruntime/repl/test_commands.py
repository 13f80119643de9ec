"""Commands of the prompt between two scans: running, variables, recording, snapshots."""

import pytest

from plcruntime import PLC
from plcruntime.repl import Repl
from stcore import cache


def test_any_st_may_be_typed(prompt):
    assert prompt("1 + 2 * 3") == "7"
    assert prompt("Twice(4)") == "8"
    assert prompt("n := 5") == ""
    assert prompt("n") == "5"
    assert prompt("acc(d := 3)") == ""
    assert prompt("acc.sum") == "6"
    assert prompt("txt = 'abc' AND n >= 5") == "TRUE"
    assert prompt("FOR n := 1 TO 3 DO arr[n] := n * n; END_FOR") == ""
    assert prompt("print arr") == "[1, 4, 9]"
    assert prompt("print (n + 1) * 2") == str(2 * (int(prompt("n")) + 1))


def test_step_run_until(prompt):
    assert prompt("step") == "1 scan, 0.001 s"
    assert prompt("s 4") == "5 scans, 0.005 s"
    assert prompt("run 10ms") == "15 scans, 0.015 s"
    assert prompt("run #5") == "20 scans, 0.02 s"
    assert prompt("until acc.sum >= 100 AND flag") == "25 scans, 0.025 s"
    assert prompt("until n > 30000 for 5ms") == "'n > 30000' was not reached within 5ms: 30 scans, 0.03 s"


def test_enter_repeats_a_step(prompt):
    prompt("step")
    assert prompt("") == "2 scans, 0.002 s"
    prompt("n")
    assert prompt("") == ""


def test_back_over_thousands_of_scans(prompt):
    prompt("run #3000")
    prompt("n := 5000")
    prompt("run #2000")
    assert prompt("n") == "7000"
    assert prompt("back 1500") == "3500 scans, 3.5 s"
    assert prompt("n") == "5500"
    assert prompt("back 501") == "2999 scans, 2.999 s"
    assert prompt("n") == "2999"
    prompt("run #2001")
    assert prompt("n") == "5000"
    assert "can't go back by 9000 scans" in prompt("back 9000")


def test_what_is_typed_is_repeated_when_going_back(prompt):
    prompt.all("step 10", "acc(d := 50)", "set arr := [7, 8, 9]", "force PLC_PRG.lim := 3", "step 10")
    total = prompt("acc.sum")
    prompt.all("step 20", "back 20")
    assert prompt("acc.sum") == total
    prompt.all("back 10")
    assert prompt("arr") == "[7, 8, 9]"
    prompt.all("back 1")
    assert prompt("arr") == "[1, 2, 3]"


def test_watch(prompt):
    assert prompt("watch n") == "  n = 0"
    assert prompt("watch acc.sum * 2") == "  acc.sum * 2 = 0"
    assert prompt("step") == "1 scan, 0.001 s\n  n = 1\n  acc.sum * 2 = 8"
    assert prompt("unwatch n") == ""
    assert prompt("watch") == "  acc.sum * 2 = 8"
    assert "not watched" in prompt("unwatch n")
    prompt("unwatch")
    assert prompt("step") == "2 scans, 0.002 s"


def test_set_and_force(prompt):
    assert prompt("set p := (x := 2.5, y := 1)") == ""
    assert prompt("p") == "(x := 2.5, y := 1.0)"
    assert prompt("set p.y := p.x * 2.0") == ""
    assert prompt("p.y") == "5.0"
    assert prompt("force n := 4") == "forced: PLC_PRG.n = 4"
    prompt("step 3")
    assert prompt("n") == "4"
    assert "PLC_PRG.n" in prompt("force")
    assert prompt("unforce n") == ""
    assert prompt("force") == "nothing is forced"
    prompt("step")
    assert prompt("n") == "5"


def test_diff(prompt):
    prompt("step 10")
    prompt("step")
    text = prompt("diff")
    assert "PLC_PRG.n" in text and "PLC_PRG.flag" in text and "PLC_PRG.arr" not in text
    assert ["PLC_PRG.flag", "FALSE", "TRUE"] in [line.split() for line in text.splitlines()]


def test_diff_shows_the_outside_of_library_blocks(prompt):
    prompt("step 5")
    prompt("step")
    changed = {line.split()[0] for line in prompt("diff").splitlines()[1:]}
    assert {"PLC_PRG.wait.ET", "PLC_PRG.acc.sum", "PLC_PRG.blocks[2].sum"} <= changed
    assert "PLC_PRG.wait.elapsed" not in changed and "PLC_PRG.wait.elapsed" in prompt("diff all")
    prompt("diff")
    prompt.all("next", "PLC_PRG.wait.elapsed := 7")
    prompt.all("step", "next")
    assert prompt("diff") == "nothing has changed"


def test_snapshots_by_name(prompt, source):
    prompt.all("step 5", "force PLC_PRG.lim := 3", "save five", "unforce", "step 5")
    assert prompt("save") == "snapshots: five"
    assert prompt("load five") == "loaded five: 5 scans, 0.005 s"
    assert prompt("n") == "5"
    assert "PLC_PRG.lim" in prompt("force")
    file = next((cache.state_dir() / "snapshots").rglob("five"))
    data = bytearray(file.read_bytes())
    data[-3] ^= 1
    file.write_bytes(data)
    assert "damaged" in prompt("load five")
    assert prompt("n") == "5"
    assert prompt("load six") == "there is no snapshot six; kept: five"
    assert "no name" in prompt("save ../x")


def test_plot_in_the_terminal_shows_every_scan(prompt):
    prompt("run #500")
    text = prompt("plot n flag")
    assert "PLC_PRG.n   last 500, least 1, most 500" in text
    assert "PLC_PRG.flag   last TRUE, least FALSE, most TRUE" in text
    assert "⡇" in text or "⠉" in text or "⣀" in text
    assert prompt("n") == "500"  # repeating the scans has left no trace


def test_plot_to_a_file(prompt, tmp_path):
    prompt("run #50")
    assert prompt(f"plot n to {tmp_path / 'n.png'}") == f"wrote {tmp_path / 'n.png'}"
    assert (tmp_path / "n.png").read_bytes().startswith(b"\x89PNG")
    assert "must end with" in prompt("plot n to n.txt")


def test_trace(prompt, tmp_path):
    prompt("trace n, acc.sum")
    prompt("step 3")
    assert prompt("trace") == "recorded: 3 scans of PLC_PRG.n, PLC_PRG.acc.sum"
    assert prompt(f"trace to {tmp_path / 't.csv'}").endswith("3 scans")
    assert (tmp_path / "t.csv").read_text().splitlines()[1] == "0.0,1,4"
    prompt("trace off")
    assert prompt("trace") == "recorded: nothing; trace VAR... begins"


def test_reset(prompt):
    prompt.all("step 5", "break Acc:1 if sum > 20", "reset cold")
    assert prompt("n") == "0"
    assert "breakpoint 1" in prompt("continue")
    assert prompt("sum > 20") == "TRUE"


def test_list_and_vars(prompt):
    assert "FUNCTION_BLOCK Acc" in prompt("list Acc")
    assert "PROGRAM PLC_PRG" in prompt("list")
    assert "TON" in prompt("list 19")
    assert "PLC_PRG.acc" in prompt("vars plc_prg.a*")
    assert prompt("vars N").splitlines()[1].split() == ["PLC_PRG.n", "0", "INT"]


def test_a_snapshot_is_of_a_plc_that_is_well(tmp_path, capsys):
    repl = Repl(PLC.load("PROGRAM P\nVAR n, d : INT := 1; END_VAR\nn := 10 / d;\nEND_PROGRAM"))
    for line in ("step", "d := 0", "step", "save bad", "back", "d", "step"):
        repl.handle(line)
    said = capsys.readouterr().out.splitlines()
    assert any("not kept" in line for line in said)
    assert "1 scan, 0.001 s" in said


def test_a_fault_leaves_the_session_alive(prompt):
    prompt("lim := 0")
    text = prompt("arr[n + 4]")
    assert "F0101" in text
    prompt("step 2")
    assert prompt("n") == "2"


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("step x", "takes a number"),
        ("run", "takes a time"),
        ("run 5 bananas", "not a duration"),
        ("foo", "not declared"),
        ("n +", ""),
        ("lim", "ambiguous"),
        ("set foo := 1", "unknown"),
        ("set n", "write set"),
        ("force n := 'a'", ""),
        ("watch foo", "not declared"),
        ("plot n", "nothing has run"),
        ("plot txt", "only numbers"),
        ("help foo", "no command"),
        ("break", "no breakpoints"),
        ("break nothere:3", "no POU"),
        ("break Acc:900", "no statement"),
        ("break Acc:1 if zz > 1", "not declared"),
        ("delete 7", "no breakpoint 7"),
        ("back 5", "can't go back"),
        ("until", "takes an ST condition"),
        ("until n + 1", "BOOL"),
        ("list nothere", "no POU"),
        ("unforce n", "not forced"),
        ("load x", "no snapshot"),
        ("trace foo", "unknown"),
        ("trace to x.csv", "nothing is recorded"),
        ("reset hot", "no reset"),
        ("continue", "nothing would stop it"),
        ("axes", "uses no axis"),
        ("axes live", "uses no axis"),
        ("vars zz*", "no variable"),
        ("list 9000", "lines"),
        ("diff 3", "no diff"),
        ("next 5", "step 5 runs scans"),
        ("brek Acc:3", "did you mean break, the command?"),
        ("(" * 3000 + "1" + ")" * 3000, ""),
        ("n / 0", "0"),
        ("PLC_PRG", "n := 0"),
    ],
)
def test_a_wrong_command_gets_one_sentence_and_the_session_goes_on(prompt, line, said):
    text = prompt(line)
    assert said in text
    assert "Traceback" not in text
    assert len(text.splitlines()) == 1
    assert prompt("step") == "1 scan, 0.001 s"


def test_a_variable_wins_over_an_abbreviation(prompt):
    assert prompt("n") == "0"
    assert prompt("p.x") == "0.0"
    assert "in scan 0" in prompt("next")


def test_a_variable_that_is_called_as_a_command(tmp_path, capsys):
    repl = Repl(PLC.load("PROGRAM P\nVAR step, run : INT; END_VAR\nrun := step;\nEND_PROGRAM"))
    for line in ("step := 4", "step + 1", "step", "print run"):
        repl.handle(line)
    assert capsys.readouterr().out.splitlines() == ["5", "1 scan, 0.001 s", "4"]


def test_the_beginning_of_a_command_is_enough(prompt):
    assert prompt("ste 3") == "3 scans, 0.003 s"
    assert prompt("unt n = 5") == "5 scans, 0.005 s"
    prompt("FOR n := 1 TO 4 DO arr[1] := n; END_FOR")
    assert prompt("arr[1]") == "4"  # FOR is not force
    assert "not declared" in prompt("l_")


def test_a_mistake_of_ours_does_not_end_the_session(prompt, monkeypatch, capsys):
    monkeypatch.setattr(prompt.plc, "back", lambda count: 1 // 0)
    prompt.all("step 2")
    assert prompt("back").startswith("scancycle itself failed here")
    assert prompt("step") == "3 scans, 0.003 s"


def test_help_names_every_command(prompt):
    from plcruntime.repl.commands import COMMANDS

    text = prompt("help")
    assert all(name in text for name in COMMANDS)
    for name in COMMANDS:
        assert prompt(f"help {name}").startswith(COMMANDS[name].usage)


def test_the_page_names_every_command():
    from pathlib import Path

    from plcruntime.repl.commands import COMMANDS

    page = (Path(__file__).parents[3] / "docs" / "repl.md").read_text(encoding="utf-8")
    assert [name for name in COMMANDS if f"`{name}" not in page] == []


def test_a_list_of_values_that_is_wrong_says_why(prompt):
    assert prompt("set p := (x := 1, z := 2)") == "PLC_PRG.p has no variable z; it has x, y"
    assert "not an array" in prompt("set n := [1]")
    assert prompt("set n := (1 + 2) * 3") == "" and prompt("n") == "9"
    assert prompt("FOR zz := 1 TO 3 DO END_FOR") == "zz is not declared"


def test_a_trace_around_a_trigger(prompt, tmp_path):
    said = prompt("trace n, p.x if n >= 20 pre 3ms post 2ms")
    assert said == "recording PLC_PRG.n, PLC_PRG.p.x; 'n >= 20' came true: not yet"
    prompt("run 10ms")
    assert prompt("trace").startswith("recorded: 3 scans") and prompt("trace").endswith("not yet")
    prompt("run 90ms")
    assert prompt("trace") == "recorded: 6 scans of PLC_PRG.n, PLC_PRG.p.x; 'n >= 20' came true: in scan 19"
    prompt(f"trace to {tmp_path / 'out.csv'}")
    rows = (tmp_path / "out.csv").read_text().splitlines()[1:]
    assert [int(row.split(",")[1]) for row in rows] == list(range(17, 23))
    prompt("back 85")
    assert prompt("trace").endswith("not yet")
    prompt("run 50ms")
    assert prompt("trace").startswith("recorded: 6 scans")
    assert prompt("trace n if nothing > 3") == "nothing is not declared"
    assert "BOOL" in prompt("trace n if n") and "duration" in prompt("trace n if n > 3 pre soon")
    assert prompt("trace").startswith("recorded: 6 scans")  # the one before goes on

"""The prompt as a process: commands from a pipe, and keys in a real terminal (tmux)."""

import shutil
import subprocess
import sys
import time
import uuid
from pathlib import Path

import pytest

from plcruntime import PLC
from plcruntime.layout import broken, table
from plcruntime.repl import axis_table, live
from plcruntime.repl.chart import draw
from plcruntime.repl.completion import candidates
from plcruntime.repl.entry import incomplete
from plcruntime.repl.session import Session

COMMAND = [sys.executable, "-m", "plcruntime", "repl"]
ROOT = Path(__file__).parents[3]
WAIT = 90.0  # s that a terminal has to show something


def piped(source, text: str, *arguments: str) -> subprocess.CompletedProcess:
    return subprocess.run([*COMMAND, str(source), *arguments], input=text, capture_output=True, text=True, timeout=120)


def test_commands_from_a_pipe(source):
    done = piped(source, "# a comment\nstep 3\nn\nnonsense here\nn := 50\nrun 1s\nprint n\nquit\nstep\n")
    assert done.returncode == 0
    assert done.stdout.splitlines()[1:3] == ["3 scans, 0.003 s", "3"]
    assert done.stdout.splitlines()[-2:] == ["1003 scans, 1.003 s", "1050"]
    assert not done.stderr


def test_st_of_several_lines_from_a_pipe(source):
    text = "IF n < 5 THEN\n  n := 40;\nEND_IF\nn\n(* a\ncomment *) n + 1\nFOR n := 1 TO 3 DO\n\nn\nWHILE n < 9 DO"
    done = piped(source, text)
    assert done.returncode == 0
    said = done.stdout.splitlines()[1:]
    assert said[:2] == ["40", "41"] and "END_FOR" in said[2] and said[3] == "40" and "END_WHILE" in said[4]


@pytest.mark.parametrize(
    "text, more",
    [
        ("IF a THEN", True), ("IF a THEN b := 1; END_IF", False), ("if a then\n", False), ("n + 1", False),
        ("CASE a OF 1: IF b THEN c := 1; END_IF", True), ("// IF", False), ("'IF'", False), ("(* IF", True),
        ("until a > 1 for 5s", False), ("REPEAT a := 1; UNTIL a END_REPEAT", False), ("(* a *) b", False),
        ("s := '(*'", False), ("END_IF", False), ("FOR i := 1 TO 2 DO END_FOR WHILE b DO", True),
    ],
)  # fmt: skip
def test_which_text_goes_on_in_the_next_line(text, more):
    assert incomplete(text) == more


def test_the_end_of_the_input_ends_a_session_that_waits(source):
    done = piped(source, "next\nnext\n")
    assert done.returncode == 0 and "acc(d := 2)" in done.stdout


def test_a_program_with_errors(source):
    source.write_text("PROGRAM P\nVAR x : INT; END_VAR\nx := y;\nEND_PROGRAM\n")
    done = piped(source, "step\n")
    assert done.returncode == 1 and "E0301" in done.stderr


def test_a_missing_file(tmp_path):
    assert piped(tmp_path / "no.st", "").returncode in (1, 2)


def test_axes_of_a_motion_program(tmp_path):
    text = """PROGRAM PLC_PRG
VAR axis : AXIS_REF_SM3; power : MC_Power; END_VAR
power(Axis := axis, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
END_PROGRAM
"""
    (tmp_path / "m.st").write_text(text)
    done = piped(tmp_path / "m.st", "run 100ms\naxes\naxes live\naxes 50ms\n")
    assert done.returncode == 0
    lines = done.stdout.splitlines()[2:]
    assert lines[1].split()[:3] == ["1", "PLC_PRG.axis", "standstill"]
    assert "needs a terminal" in lines[2]
    assert lines[3] == "150 scans, 0.15 s"
    assert lines[4:] == lines[:2]


# ---------------------------------------------------------------------------------------------- completion


def completed(session: Session, text: str) -> list[str]:
    return [name for name, _ in candidates(session, text)]


def test_completion(source):
    session = Session(PLC.load(source))
    assert completed(session, "unt") == ["until"]
    assert "PLC_PRG" in completed(session, "print pl")
    assert completed(session, "print PLC_PRG.ac") == ["acc"]
    assert {"d", "sum"} <= set(completed(session, "PLC_PRG.acc."))
    assert completed(session, "PLC_PRG.blocks[2].su") == ["sum"]
    assert "ET" in completed(session, "wait.E")
    assert completed(session, "n + Twi") == ["Twice"]
    assert completed(session, "break Ac") == ["Acc"]
    assert completed(session, "help pl") == ["plot"]
    assert completed(session, "reset c") == ["cold"]
    assert completed(session, "nothing.") == []
    assert completed(session, "set flag := T")[:1] == ["TRUE"]


def test_completion_of_the_names_of_an_enum(tmp_path):
    text = "TYPE TS : (Idle, Busy); END_TYPE\nPROGRAM P\nVAR s : TS; END_VAR\ns := Busy;\nEND_PROGRAM"
    (tmp_path / "e.st").write_text(text)
    session = Session(PLC.load(tmp_path / "e.st"))
    assert completed(session, "s := ") == ["Idle", "Busy"]
    assert completed(session, "until P.s = b")[:1] == ["Busy"]


def test_a_chart_keeps_a_single_peak():
    values = [0.0] * 10_000
    values[5_000] = 1.0
    lines = draw([i / 1000 for i in range(10_000)], values, "x")
    assert "most 1" in lines[0]
    assert any(c != "\u2800" for c in lines[1].split("┤")[1])


# ------------------------------------------------------------------------------------------------ terminal


class Terminal:
    """A session in tmux: keys go in, the screen is read until it shows what is waited for."""

    def __init__(self, source, environment: dict[str, str]) -> None:
        self.name = f"scancycle-{uuid.uuid4().hex[:8]}"
        variables = [part for k, v in environment.items() for part in ("-e", f"{k}={v}")]
        self._tmux("new-session", "-d", "-s", self.name, "-x", "120", "-y", "50", *variables, *COMMAND, str(source))

    def _tmux(self, *arguments: str) -> str:
        return subprocess.run(["tmux", *arguments], capture_output=True, text=True, check=True).stdout

    def type(self, *keys: str) -> None:
        for key in keys:
            self._tmux("send-keys", "-t", self.name, *(["-l", key] if len(key) > 1 and " " in key else [key]))

    def line(self, text: str) -> None:
        self._tmux("send-keys", "-t", self.name, "-l", text)
        self._tmux("send-keys", "-t", self.name, "Enter")

    def interrupt(self, text: str) -> str:
        """Ctrl-C until the screen shows something: on a busy machine what it shall end may not have begun."""
        deadline = time.monotonic() + WAIT
        while True:
            self.type("C-c")
            again = time.monotonic() + 2
            while time.monotonic() < again:
                if text in (screen := self.screen()):
                    return screen
                time.sleep(0.05)
            assert time.monotonic() < deadline, f"Ctrl-C does not show '{text}':\n{screen}"

    def screen(self) -> str:
        return self._tmux("capture-pane", "-p", "-t", self.name)

    def shows(self, text: str) -> str:
        return self.until(lambda screen: text in screen, f"'{text}' is not on the screen")

    def until(self, holds, problem: str = "the screen stays as it is") -> str:
        deadline = time.monotonic() + WAIT
        while not holds(screen := self.screen()):
            assert time.monotonic() < deadline, f"{problem}:\n{screen}"
            time.sleep(0.05)
        return screen

    def alive(self) -> bool:
        return subprocess.run(["tmux", "has-session", "-t", self.name], capture_output=True).returncode == 0

    def close(self) -> None:
        subprocess.run(["tmux", "kill-session", "-t", self.name], capture_output=True)


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """The cache folder of all terminals here: compiled once."""
    return tmp_path_factory.mktemp("cache")


@pytest.fixture
def open_terminal(kept):
    """Begins a session in a terminal on a file."""
    if shutil.which("tmux") is None:
        pytest.skip("tmux is not on this machine")
    opened = []

    def begin(file) -> Terminal:
        opened.append(Terminal(file, {"SCANCYCLE_STATE": str(kept)}))
        return opened[-1]

    yield begin
    for terminal in opened:
        terminal.close()


@pytest.fixture
def terminal(open_terminal, source):
    return open_terminal(source)


def test_in_a_terminal(terminal, kept):
    terminal.shows("help lists the commands")
    terminal.shows("0>")
    terminal.line("step 5")
    terminal.shows("5 scans, 0.005 s")
    terminal.shows("5>")
    terminal.type("PLC_PRG.", "a")
    terminal.shows("acc")  # the menu of completions
    terminal.type("C-c")
    terminal.line("next")
    terminal.shows("PLC_PRG:")  # the prompt names the statement
    terminal.line("n * 1000")
    terminal.shows("5000")
    terminal.line("foo bar")
    terminal.line("step")
    terminal.shows("6 scans, 0.006 s")
    terminal.type("Up", "Up", "Up", "Enter")  # n * 1000 from the history
    terminal.shows("6000")
    for line in ("IF n > 0 THEN", "n := 70;", "END_IF", "n * 2"):  # a text of several lines
        terminal.line(line)
    terminal.shows("140")
    terminal.line("quit")
    deadline = time.monotonic() + WAIT
    while terminal.alive() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not terminal.alive()
    assert "n * 1000" in (kept / "repl_history").read_text()


def test_ctrl_c_stops_a_run_and_the_session_goes_on(terminal):
    terminal.shows("0>")
    terminal.line("continue")
    time.sleep(0.3)
    terminal.interrupt("interrupted")
    terminal.line("1 + 41")
    terminal.shows("42")


def test_ctrl_c_while_probes_are_in_stops_at_a_statement(terminal):
    terminal.shows("0>")
    terminal.line("break Acc:1 if sum < 0")
    terminal.shows("breakpoint 1")
    terminal.line("until n < 0 for 1h")
    time.sleep(0.3)
    terminal.interrupt("in scan")
    terminal.line("delete")
    terminal.line("step")
    terminal.shows("scans, ")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_a_late_answer_of_the_terminal_is_no_key(monkeypatch):
    import os
    import pty

    ours, theirs = pty.openpty()
    with os.fdopen(theirs) as stdin, monkeypatch.context() as patch:
        patch.setattr(sys, "stdin", stdin)
        with live._keys() as pressed:
            assert not pressed()
            os.write(ours, b"\x1b[12;1R")
            assert not pressed()
            os.write(ours, b"\x1b[12;1Rx")
            assert pressed()
            os.write(ours, b"\x1b[A")  # an arrow
            assert pressed() and not pressed()
    os.close(ours)


def test_axes_live_until_a_key_is_pressed(open_terminal):
    terminal = open_terminal(ROOT / "examples_st" / "gt_jog.st")
    terminal.shows("0>")
    terminal.line("speed := 20.0")
    terminal.line("axes live")
    terminal.shows(" 20.0000 ")
    first = terminal.shows("any key stops")
    terminal.until(lambda screen: "any key stops" in screen and screen != first)
    terminal.type("x")
    terminal.shows(" scans, ")  # the table stays, and the prompt does not get the key
    terminal.line("speed + 1.0")
    screen = terminal.shows("21.0")
    assert " 20.0000 " in screen and "pulse," in screen and "any key stops" not in screen
    terminal.line("break PLC_PRG:40 if velocity > 25")
    terminal.line("speed := 30.0")
    terminal.line("axes live")
    terminal.shows("breakpoint 1: PLC_PRG, in scan")
    terminal.shows("PLC_PRG:40>")


@pytest.mark.parametrize("example", ["gt_jog", "mc_cam_in"])
def test_the_table_of_axes_fits_a_narrow_terminal(example):
    plc = PLC.load(str(ROOT / "examples_st" / f"{example}.st"))
    if example == "gt_jog":
        plc["speed"] = 123.25
    plc.run("100s")
    text = live.picture(plc, 80).plain
    assert max(map(len, text.split("\n"))) <= 80 and "status" not in text
    assert f"{plc.axes[1].prfPos:.4f}" in text and all(w in text for w in ("position", "signals", "moving"))
    assert example != "gt_jog" or "123.2500" in text
    assert "status" in "\n".join(axis_table.lines(plc, None))


def test_long_lines_are_broken_between_words_and_cells_in_their_column():
    assert broken("one two three", 8) == ["one two", "  three"]
    assert broken("one two three", None) == ["one two three"]
    assert broken("x" * 10, 8) == ["x" * 8, "  xx"]
    rows = [("PLC_PRG.a_long_name.of_a_path", "1.5", "some words that are long"), ("b", "200", "")]
    lines = table(("name", "value", "text"), rows, 45)
    assert max(map(len, lines)) <= 45 and all(len(line) > 30 for line in lines[:1])
    assert lines[1].split()[:2] == ["PLC_PRG.a_long_", "1.5"] and "200" in lines[-1]
    end = lines[0].index("value")
    assert "".join(line[2:end].strip() for line in lines[1:-1]) == rows[0][0]
    assert table(("a", "b"), [("1", "x" * 200)], None) == ["  a  b", "  1  " + "x" * 200]

import ast
import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from plcruntime.cli import main, output
from plcruntime.cli.run import split_names

PROGRAM = """
TYPE Point : STRUCT x : LREAL; y : INT; END_STRUCT END_TYPE
TYPE Mode : (idle, busy := 5); END_TYPE
PROGRAM PLC_PRG
VAR
  n : DINT; on : BOOL; r : LREAL; t : TIME; pause : TON; p : Point; m : Mode; a : ARRAY[1..3] OF INT;
  s : STRING(10) := 'abc'; w : WORD; big : LREAL; i : INT;
END_VAR
n := n + 1;
IF on THEN r := r + 0.5; END_IF
t := t + T#1ms;
pause(IN := on, PT := T#5ms);
IF i <> 0 THEN n := 10 / (i - 1); END_IF
END_PROGRAM
"""


@pytest.fixture
def file(tmp_path) -> str:
    path = tmp_path / "prog.st"
    path.write_text(PROGRAM, encoding="utf-8")
    return str(path)


def run(capsys, *arguments) -> tuple[int, str, str]:
    """(exit code, standard output, standard error)"""
    try:
        code = main([str(a) for a in arguments])
    except SystemExit as stop:  # argparse
        code = stop.code
    printed = capsys.readouterr()
    return code, printed.out, printed.err


def run_json(capsys, *arguments) -> tuple[int, dict]:
    code, out, _ = run(capsys, "run", *arguments, "--json")
    return code, json.loads(out)


def test_json(capsys, file):
    code, result = run_json(capsys, file, "--for", "20ms", "--set", "on=TRUE@10ms")
    assert code == 0
    assert (result["scans"], result["time"], result["stopped"], result["fault"]) == (20, 0.02, "for", None)
    assert result["diagnostics"] == []
    assert set(result["timing"]) == {"compile_s", "run_s", "real_time_factor"}
    values = result["vars"]
    assert values["PLC_PRG.n"] == 20 and values["PLC_PRG.on"] is True and values["PLC_PRG.r"] == 5.0
    assert (
        values["PLC_PRG.t"] == 0.02 and values["PLC_PRG.p"] == {"x": 0.0, "y": 0} and values["PLC_PRG.a"] == [0, 0, 0]
    )
    assert values["PLC_PRG.m"] == 0 and values["PLC_PRG.s"] == "abc" and values["PLC_PRG.pause"]["Q"] is True


def test_watched_variables(capsys, file):
    code, result = run_json(capsys, file, "--scans", 3, "--watch", "N,pause.et", "--watch", "a[2],w.3")
    assert result["vars"] == {"PLC_PRG.n": 3, "PLC_PRG.pause.ET": 0.0, "PLC_PRG.a[2]": 0, "PLC_PRG.w.3": False}
    assert result["stopped"] == "scans" and code == 0
    assert split_names(["a,b[1,2]", " c "]) == ["a", "b[1,2]", "c"]


def test_values_as_in_st(capsys, file):
    sets = [
        "w=16#FF", "s='a@b=c'@#0", "a=[1,2(7)]", "p=(x:=0.25, y:=3)", "m=busy", "t=T#1s500ms", "big=1e300",
        "p.y:=-4@#2",
    ]  # fmt: skip
    code, result = run_json(capsys, file, "--scans", 3, *(x for s in sets for x in ("--set", s)))
    values = result["vars"]
    assert (
        code == 0 and values["PLC_PRG.w"] == 255 and values["PLC_PRG.s"] == "a@b=c" and values["PLC_PRG.a"] == [1, 7, 7]
    )
    assert values["PLC_PRG.p"] == {"x": 0.25, "y": -4} and values["PLC_PRG.m"] == 5 and values["PLC_PRG.t"] == 1.503
    assert values["PLC_PRG.big"] == 1e300


def test_force(capsys, file):
    code, result = run_json(capsys, file, "--for", "20ms", "--force", "n=7@10ms", "--watch", "n")
    assert result["vars"] == {"PLC_PRG.n": 7}


def test_until(capsys, file):
    code, result = run_json(capsys, file, "--until", "PLC_PRG.n = 33 AND NOT on")
    assert (code, result["scans"], result["stopped"]) == (0, 33, "until")
    code, out, err = run(capsys, "run", file, "--until", "n > 100", "--for", "50ms")
    assert code == 3 and "'n > 100' was not reached within 50 ms; now PLC_PRG.n = 50" in err
    # a condition that only the last scan of a call meets
    for scans in (15, 16, 17, 144, 145):
        code, result = run_json(capsys, file, "--until", f"n = {scans}")
        assert (code, result["scans"]) == (0, scans)


def test_interval(capsys, file):
    code, result = run_json(capsys, file, "--for", "10ms", "--task-interval", "4ms")
    assert (result["scans"], result["time"]) == (3, 0.012)


def test_text(capsys, file):
    code, out, err = run(capsys, "run", file, "--for", "10ms", "--watch", "n,on,m,pause.PT")
    assert code == 0 and err == ""
    rows = {line.split()[0]: line.split()[1:] for line in out.splitlines() if line.strip().startswith("PLC_PRG")}
    assert rows["PLC_PRG.n"] == ["10", "DINT"] and rows["PLC_PRG.on"] == ["FALSE", "BOOL"]
    assert rows["PLC_PRG.m"] == ["idle", "Mode"] and rows["PLC_PRG.pause.PT"] == ["T#0.005s", "TIME"]
    assert "10 scans of 1 ms: 0.01 s of virtual time" in out and "\x1b" not in out


def test_a_table_folds_only_what_is_too_wide(capsys, monkeypatch):
    rows = [("名字", "one two three"), ("b", ""), ("abcdef", "4")]
    shown = []
    for columns in ("24", "22"):
        monkeypatch.setenv("COLUMNS", columns)
        output.print_table(("name", "value"), rows)
        shown.append([line.rstrip() for line in capsys.readouterr().out.splitlines()])
    assert shown[0] == ["", " name     value", " " + 22 * "─", " 名字     one two three", " b", " abcdef   4", ""]
    assert shown[1][3:5] == [" 名字     one two", "          three"]
    assert shown[1][:2] + shown[1][5:] == shown[0][:2] + shown[0][4:]


def test_trace_files(capsys, file, tmp_path):
    code, out, _ = run(
        capsys, "run", file, "--scans", 4, "--set", "on=TRUE@#2", "--watch", "r,on", "--trace", tmp_path / "t.csv"
    )
    rows = list(csv.reader((tmp_path / "t.csv").open()))
    assert rows == [
        ["time", "PLC_PRG.r", "PLC_PRG.on"],
        ["0.0", "0.0", "0"],
        ["0.001", "0.0", "0"],
        ["0.002", "0.5", "1"],
        ["0.003", "1.0", "1"],
    ]
    run(capsys, "run", file, "--scans", 4, "--trace", tmp_path / "t.csv")
    header = (tmp_path / "t.csv").read_text().splitlines()[0].split(",")
    assert header[:4] == ["time", "PLC_PRG.n", "PLC_PRG.on", "PLC_PRG.r"] and "PLC_PRG.a" not in header
    for name in ("t.npz", "t.html"):
        assert run(capsys, "run", file, "--scans", 4, "--trace", tmp_path / name)[0] == 0
        assert (tmp_path / name).stat().st_size > 500


def test_plot(capsys, file, tmp_path):
    code, out, _ = run(capsys, "run", file, "--scans", 40, "--set", "on=TRUE@#20", "--plot", tmp_path / "p.svg")
    text = (tmp_path / "p.svg").read_text()
    assert code == 0 and f"wrote {tmp_path / 'p.svg'}" in out and ">on<" in text.replace("\n", "") and ">n<" in text


def test_fault(capsys, file):
    code, result = run_json(capsys, file, "--for", "20ms", "--set", "i=1@10ms")
    fault = result["fault"]
    assert code == 1 and result["stopped"] == "fault" and result["scans"] == 10
    assert (fault["code"], fault["line"], fault["scan"], fault["instance"]) == ("F0102", 13, 10, "PLC_PRG")
    assert fault["file"] == file and fault["time"] == 0.01 and fault["column"] > 1
    assert result["vars"]["PLC_PRG.i"] == 1
    code, out, err = run(capsys, "run", file, "--for", "20ms", "--set", "i=1@10ms")
    assert code == 1 and "fault F0102" in err and "10 / (i - 1)" in err and "in PLC_PRG, in scan 10, at 0.01 s" in err


def test_errors_of_the_source(capsys, tmp_path):
    bad = tmp_path / "bad.st"
    bad.write_text("PROGRAM PLC_PRG\nVAR x : INT; END_VAR\nx := y;\nx := 'a';\nEND_PROGRAM\n")
    code, result = run_json(capsys, bad)
    assert code == 1 and result["scans"] == 0 and result["vars"] == {}
    assert [d["line"] for d in result["diagnostics"]] == [3, 4]
    assert set(result["diagnostics"][0]) >= {"code", "severity", "message", "file", "line", "column", "hint"}
    code, out, err = run(capsys, "run", bad)
    assert code == 1 and "2 errors; nothing was run" in err and "x := y;" in err
    code, out, _ = run(capsys, "check", bad, "--format", "json")
    assert code == 1 and len(json.loads(out)["diagnostics"]) == 2
    code, out, _ = run(capsys, "check", bad, "--format", "gcc")
    assert code == 1 and out.startswith(f"{bad}:3:6: error: ")
    assert run(capsys, "check", bad)[0] == 1


def test_check_of_a_clean_file(capsys, file):
    assert run(capsys, "check", file) == (0, "no errors\n", "")
    code, out, _ = run(capsys, "check", file, "--format", "json")
    assert code == 0 and json.loads(out) == {"diagnostics": []}


@pytest.mark.parametrize(
    "options, words",
    [
        (["--set", "nn=1"], ["'nn=1'", "unknown variable 'nn'"]),
        (["--set", "pauze.PT=T#1s"], ["did you mean", "pause"]),
        (["--watch", "nope"], ["--watch", "nope"]),
        (["--force", "n=3000000000"], ["PLC_PRG.n", "DINT", "-2147483648..2147483647"]),
        (["--set", "n=TRUE"], ["PLC_PRG.n", "whole number"]),
        (["--set", "on=5"], ["PLC_PRG.on", "BOOL"]),
        (["--set", "n="], ["VAR=VALUE"]),
        (["--set", "n"], ["VAR=VALUE"]),
        (["--set", "n=1@"], ["time"]),
        (["--set", "n=1@soon"], ["'soon' is not a duration"]),
        (["--set", "n=1 +"], ["not a value"]),
        (["--set", "t=500"], ["T#500ms"]),
        (["--for", "soon"], ["--for", "soon"]),
        (["--for", "5"], ["--for", "500ms"]),
        (["--task-interval", "0ms"], ["--task-interval"]),
        (["--scans", "-1"], ["--scans"]),
        (["--scans", "3", "--for", "3s"], ["--for and --scans"]),
        (["--until", "nope > 3"], ["--until"]),
        (["--until", "n"], ["--until"]),
        (["--trace", "x.pdf"], ["--trace x.pdf", ".csv"]),
        (["--plot", "/nowhere/x.png"], ["--plot", "no folder /nowhere"]),
        (["--config", "nope.toml"], ["nope.toml"]),
        (["--nope"], ["--nope"]),
    ],
)
def test_wrong_usage(capsys, file, options, words):
    code, out, err = run(capsys, "run", file, *options)
    assert code == 2 and out == ""
    for word in words:
        assert word in err
    assert "Traceback" not in err


def test_files_that_can_not_be_read(capsys, tmp_path):
    for command in ("run", "check"):
        code, out, err = run(capsys, command, tmp_path / "nope.st")
        assert code == 1 and f"error E0704: {tmp_path / 'nope.st'} can't be read: No such file" in err
    code, result = run_json(capsys, tmp_path / "nope.st")
    assert code == 1 and [d["code"] for d in result["diagnostics"]] == ["E0704"]
    assert run(capsys, "run")[0] == 2
    assert run(capsys)[0] == 2


def test_a_project(capsys, tmp_path):
    (tmp_path / "a.st").write_text("PROGRAM Fast VAR n : INT; END_VAR n := n + 1; END_PROGRAM")
    (tmp_path / "b.st").write_text("PROGRAM Slow VAR n : INT; END_VAR n := n + 1; END_PROGRAM")
    (tmp_path / "plc.toml").write_text(
        '[[task]]\nprogram = "Fast"\ninterval = "2ms"\n[[task]]\nprogram = "Slow"\ninterval = "10ms"\n'
    )
    for named in (
        [tmp_path],
        [tmp_path / "plc.toml"],
        [tmp_path / "a.st", tmp_path / "b.st", "--config", tmp_path / "plc.toml"],
    ):
        code, result = run_json(capsys, *named, "--for", "20ms")
        assert (code, result["scans"]) == (0, 10)
        assert result["vars"] == {"Fast.n": 10, "Slow.n": 2}


def test_numbers_that_json_has_not():
    text = output.to_json({"a": [float("inf"), -float("inf"), float("nan"), 1.5], "s": "inf"})
    assert json.loads(text, parse_constant=pytest.fail) == {"a": [float("inf"), -float("inf"), None, 1.5], "s": "inf"}


def test_list(capsys):
    code, out, _ = run(capsys, "list", "TON", "--json")
    (ton,) = [e for e in json.loads(out) if e["name"] == "TON"]
    assert code == 0 and ton["kind"] == "function_block" and ton["file"].endswith("TON.st") and ton["source"]
    assert ton["signature"] == "TON(IN: BOOL; PT: TIME; => Q: BOOL; => ET: TIME)"
    everything = json.loads(run(capsys, "list", "--json")[1])
    names = [e["name"].upper() for e in everything]
    assert len(names) == len(set(names)) > 100 and {"LEFT", "ABS", "MC_POWER", "GT_SETVEL"} <= set(names)
    assert not any(n.startswith("__") for n in names)
    assert all(set(e) >= {"name", "kind", "signature", "file", "source", "units"} for e in everything)
    assert {"DWORD_TO_DINT", "REAL_TO_STRING"} <= set(names)
    assert "DWORD_TO_DINT(IN: DWORD): DINT" in run(capsys, "list", "dword_to_d*")[1]
    assert "DWORD_TO_DINT" not in run(capsys, "list")[1]  # only when asked for
    code, out, _ = run(capsys, "list", "mc_mov*")
    assert code == 0 and "MC_MoveAbsolute" in out and "MC_Power" not in out
    assert run(capsys, "list", "nothing_like_it")[0] == 1


def test_every_entry_of_the_library_is_documented(capsys):
    entries = [e for e in json.loads(run(capsys, "list", "--json")[1]) if e["file"].endswith(".st")]
    assert [e["name"] for e in entries if not e["summary"]] == []


def test_explain(capsys):
    code, out, _ = run(capsys, "explain", "f0102")
    assert code == 0 and "division by zero" in out
    code, _, err = run(capsys, "explain", "F9999")
    assert code == 2 and "F0101" in err
    assert run(capsys, "explain", "../README")[0] == 2


def test_doctor(capsys, tmp_path, monkeypatch):
    from stcore import cache

    monkeypatch.setattr(cache, "_problem", "")
    code, out, _ = run(capsys, "doctor")
    assert code == 0 and "wasmtime" in out and "writable" in out and "runs" in out and "All that is needed" in out
    (tmp_path / "occupied").write_text("")
    monkeypatch.setenv("SCANCYCLE_CACHE", str(tmp_path / "occupied"))
    code, out, err = run(capsys, "doctor")
    assert code == 0 and "is not a folder" in err and "SCANCYCLE_CACHE" in err
    from plcruntime.cli import doctor

    monkeypatch.setattr(doctor, "_version", lambda name: None if name in ("numpy", "plotly", "rich") else "1.0")
    code, out, err = run(capsys, "doctor")
    assert code == 1 and "numpy is missing (traces): pip install numpy" in err
    assert "only for --report: pip install 'scancycle[report]'" in out and "not tried" in out


def test_a_cache_that_can_not_be_written(capsys, file, tmp_path, monkeypatch):
    from stcore import cache

    (tmp_path / "occupied").write_text("")
    monkeypatch.setenv("SCANCYCLE_CACHE", str(tmp_path / "occupied"))
    monkeypatch.setattr(cache, "_problem", "")
    code, out, err = run(capsys, "run", file, "--scans", 3)
    assert code == 0 and "3 scans" in out
    assert len(err.splitlines()) == 1 and "can't be written" in err and "SCANCYCLE_CACHE" in err


def test_a_missing_package(capsys, file, monkeypatch):
    from plcruntime.cli import run as command

    def missing(arguments):
        raise ModuleNotFoundError("No module named 'wasmtime'", name="wasmtime")

    monkeypatch.setattr(command, "execute", missing)
    code, _, err = run(capsys, "run", file)
    assert code == 2 and "package wasmtime is missing: pip install wasmtime" in err and "doctor" in err


def test_an_old_python(tmp_path):
    text = (Path(__file__).resolve().parents[2] / "plcruntime" / "__init__.py").read_text(encoding="utf-8")
    ast.parse(text, feature_version=(3, 4))
    assert "__future__" not in text and 'f"' not in text  # else an older one fails before it can say so
    root = Path(__file__).resolve().parents[2]
    old = "import sys; sys.version_info = (3, 9, 2, 'final', 0); sys.argv = [{argv}]; import plcruntime"
    for argv in ("'-m'", "'x.py'"):
        command = [sys.executable, "-c", old.format(argv=argv)]
        done = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode == 1 and "scancycle needs Python 3.11 or newer; this is 3.9: " in done.stderr
        assert ("Traceback" in done.stderr) == (argv != "'-m'")


RETAIN = "PROGRAM PLC_PRG VAR RETAIN n : {type}; END_VAR n := n + 1; END_PROGRAM"


def test_retain_file(capsys, tmp_path):
    program, kept = tmp_path / "prog.st", tmp_path / "plc.retain"
    program.write_text(RETAIN.format(type="DINT"))
    for scans in (300, 600):
        code, result = run_json(capsys, program, "--scans", 300, "--retain", kept)
        assert code == 0 and result["vars"] == {"PLC_PRG.n": scans}
    (tmp_path / "plc.toml").write_text('[project]\nretain = "plc.retain"\nretain_every = "10s"\n')
    program.write_text(RETAIN.format(type="LINT"))
    code, _, err = run(capsys, "run", tmp_path, "--scans", 1)
    assert code == 0 and f"retain file {kept}: converted: PLC_PRG.n (DINT to LINT)" in err
    program.write_text(RETAIN.format(type="SINT"))
    code, out, err = run(capsys, "run", tmp_path, "--scans", 1)
    assert code == 2 and out == "" and "PLC_PRG.n was LINT and is SINT, which can't hold 601" in err
    kept.write_bytes(kept.read_bytes()[:-1])
    code, _, err = run(capsys, "run", tmp_path, "--scans", 1)
    assert code == 2 and "is damaged" in err


def test_stimulus_file(capsys, file, tmp_path):
    (tmp_path / "s.csv").write_text("time,variable,value\n10ms,on,TRUE\n")
    code, result = run_json(capsys, file, "--for", "20ms", "--stimuli", tmp_path / "s.csv", "--set", "w=3")
    assert code == 0 and result["vars"]["PLC_PRG.r"] == 5.0 and result["vars"]["PLC_PRG.w"] == 3
    (tmp_path / "plc.toml").write_text('[project]\nfiles = ["prog.st"]\nstimuli = "s.csv"\n')
    code, result = run_json(capsys, tmp_path, "--for", "20ms")
    assert result["vars"]["PLC_PRG.r"] == 5.0
    (tmp_path / "s.csv").write_text("time,variable,value\n10ms,on,TRUE\n11ms,of,TRUE\n")
    code, out, err = run(capsys, "run", file, "--stimuli", tmp_path / "s.csv")
    assert code == 2 and out == "" and "s.csv:3: unknown variable 'of'" in err and len(err.splitlines()) == 1


def test_a_value_behind_the_end_of_the_run_is_told(capsys, file):
    late = ("--set", "w=3@25ms", "--set", "w=4@20ms")
    for options, told in (
        (["--for", "20ms"], "scancycle: the run ended before PLC_PRG.w := 4 at 0.02 s and 1 more\n"),
        (["--for", "25ms"], "scancycle: the run ended before PLC_PRG.w := 3 at 0.025 s\n"),
        (["--for", "26ms"], ""),
        (["--for", "26ms", "--until", "PLC_PRG.n > 5"], ""),  # it got what it waited for
    ):
        assert run(capsys, "run", file, *options, *late)[2] == told


def test_trigger(capsys, file, tmp_path):
    out_file = tmp_path / "t.csv"
    watched = (file, "--for", "1s", "--watch", "n", "--trace", out_file)
    code, *_ = run(capsys, "run", *watched, "--trigger", "n = 500", "--pre", "2ms", "--post", "#1")
    assert code == 0 and [r[1] for r in csv.reader(out_file.open())][1:] == ["498", "499", "500", "501"]
    out_file.unlink()
    code, _, err = run(capsys, "run", *watched, "--trigger", "n < 0")
    assert code == 3 and "'n < 0' never came true" in err and not out_file.exists()
    for options, words in (
        (["--trigger", "q > 3"], "--trigger: 'q > 3' is not a condition"),
        (["--trigger", "TRUE", "--pre", "soon"], "--pre"),
    ):
        code, out, err = run(capsys, "run", *watched, *options)
        assert code == 2 and out == "" and words in err
    assert "give one of them" in run(capsys, "run", file, "--trigger", "TRUE")[2]
    assert "--report" in run(capsys, "run", file, "--overlay", "x.npz")[2]


def test_trace_of_every_variable(capsys, file, tmp_path):
    code, *_ = run(capsys, "run", file, "--scans", 5, "--watch", "*", "--trace", tmp_path / "t.csv")
    header = (tmp_path / "t.csv").read_text().splitlines()[0].split(",")
    assert code == 0 and {"PLC_PRG.a[3]", "PLC_PRG.p.y", "PLC_PRG.pause.ET", "PLC_PRG.s"} <= set(header)


def test_demo(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, _ = run(capsys, "demo")
    assert code == 0 and (tmp_path / "demo.png").stat().st_size > 5000
    for word in ("times real time", "demo.st", "scancycle run", "scancycle check"):
        assert word in out
    code, result = run_json(capsys, next(w for w in out.split() if w.endswith("demo.st")), "--for", "5s")
    assert result["vars"]["PLC_PRG.step"] == 4 and result["vars"]["PLC_PRG.failed"] == 0


ENDLESS = "PROGRAM PLC_PRG VAR n : DINT; on : BOOL := TRUE; END_VAR n := n + 1; {loop} END_PROGRAM"


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT")
@pytest.mark.parametrize("loop", ["", "WHILE on DO n := n + 1; END_WHILE"])
def test_ctrl_c(tmp_path, loop):
    path = tmp_path / "prog.st"
    path.write_text(ENDLESS.format(loop=loop))
    root = Path(__file__).resolve().parents[2]
    env = {**os.environ, "PYTHONPATH": str(root)}
    script = (
        "import os, signal, sys, threading, time\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # in the background it is ignored
        "from plcruntime import engine\n"
        "from plcruntime.cli import main\n"
        "def press():\n"
        "    while not started: time.sleep(0.01)\n"
        "    os.kill(os.getpid(), signal.SIGINT)\n"
        "started = []\n"
        "call = engine.Engine._call\n"
        "engine.Engine._call = lambda self, step: (started.append(1), call(self, step))[1]\n"
        "threading.Thread(target=press, daemon=True).start()\n"
        f"sys.exit(main(['run', {str(path)!r}, '--for', '10000h', '--watchdog', '0s']))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], env=env, capture_output=True, text=True, timeout=60)
    assert done.returncode == 130, done.stderr
    assert "interrupted after" in done.stderr and "Traceback" not in done.stderr
    assert ("F0108" in done.stderr) == bool(loop)


@pytest.mark.parametrize(
    "given, takes",
    [("b=maybe", "TRUE or FALSE"), ("n=abc", "a number"), ("s=abc", "a text in ''"), ("c=Grey", "Red, Green")],
)
def test_a_word_that_is_no_value_says_what_the_variable_takes(tmp_path, capsys, given, takes):
    file = tmp_path / "p.st"
    file.write_text(
        "TYPE Colour : (Red, Green); END_TYPE\nPROGRAM P\n"
        "VAR b : BOOL; n : INT; s : STRING; c : Colour; END_VAR\nEND_PROGRAM\n"
    )
    assert main(["run", str(file), "--scans", "1", "--set", given]) == 2
    assert f"it takes {takes}; unknown variable" in capsys.readouterr().err

"""``run --log-returns`` and ``plc.log_returns()``: every command that did not return 0, with time, place and reason."""

import json

import pytest

from plcruntime import PLC
from plcruntime.cli import main

PROGRAM = """FUNCTION_BLOCK Feeder
VAR_INPUT axis : INT; END_VAR
VAR rtn : INT; END_VAR
rtn := GT_PrfTrap(axis);
END_FUNCTION_BLOCK
FUNCTION Start : INT
VAR_INPUT axis : INT; END_VAR
Start := GT_Update(SHL(1, axis - 1));
END_FUNCTION
PROGRAM PLC_PRG
VAR good, bad : Feeder; n : DINT; r : INT; END_VAR
good(axis := 1);
IF n < 40 OR n = 50 THEN
    bad(axis := 13);
END_IF
IF n = 3 THEN
    r := Start(2);
END_IF
n := n + 1;
END_PROGRAM
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("returns") / "main.st"
    path.write_text(PROGRAM)
    return path


def test_text(file, capsys):
    assert main(["run", str(file), "--log-returns", "--scans", "60"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if " returned " in line]
    assert lines == [
        f"0 s  {file}:4 in PLC_PRG.bad: GT_PrfTrap(13) returned 7: profile is not 1..12 (40 times until 0.039 s)",
        f"0.003 s  {file}:8 in PLC_PRG.Start: GT_Update(2) returned 1: "
        "no acceleration: call GT_SetTrapPrm or GT_SetJogPrm first",
        f"0.05 s  {file}:4 in PLC_PRG.bad: GT_PrfTrap(13) returned 7: profile is not 1..12",
    ]


def test_json(file, capsys):
    assert main(["run", str(file), "--log-returns", "--scans", "60", "--json"]) == 0
    log = json.loads(capsys.readouterr().out)["returns"]
    assert log["lost"] == 0 and [e["scan"] for e in log["entries"]] == [0, 3, 50]
    assert log["entries"][1] == {
        "scan": 3, "time": 0.003, "command": "GT_Update", "argument": 2, "code": 1,
        "why": "no acceleration: call GT_SetTrapPrm or GT_SetJogPrm first",
        "file": str(file), "line": 8, "column": 1, "instance": "PLC_PRG.Start", "times": 1, "last_time": 0.003,
    }  # fmt: skip


def test_without_the_option_there_is_none(file, capsys):
    assert main(["run", str(file), "--scans", "60", "--json"]) == 0
    assert "returns" not in json.loads(capsys.readouterr().out)


def test_nothing_refused(tmp_path, capsys):
    path = tmp_path / "main.st"
    for text in ("n := n + 1;", "n := GT_AlarmOff(1);"):  # without and with axes
        path.write_text(f"PROGRAM PLC_PRG\nVAR n : INT; END_VAR\n{text}\nEND_PROGRAM\n")
        assert main(["run", str(path), "--scans", "2", "--log-returns"]) == 0
        assert "every command returned 0" in capsys.readouterr().out


def test_a_slower_task_repeats_in_its_own_cycle(file, tmp_path):
    toml = tmp_path / "plc.toml"
    toml.write_text(
        '[[task]]\nname="fast"\nprogram="Fast"\ninterval="1ms"\n[[task]]\nname="slow"\nprogram="PLC_PRG"\ninterval="5ms"\n'
    )
    (tmp_path / "main.st").write_text(PROGRAM + "PROGRAM Fast\nVAR n : INT; END_VAR\nn := 1;\nEND_PROGRAM\n")
    plc = PLC.load(toml)
    log = plc.log_returns()
    plc.run("300ms")
    assert [(e.scan, e.last, e.times) for e in log.entries] == [(0, 195, 40), (15, 15, 1), (250, 250, 1)]


def test_going_back_forgets(file):
    plc = PLC.load(file)
    log = plc.log_returns()
    plc.scan(20)
    plc.back(10)
    assert [e.times for e in log.entries if e.call.command == "GT_PrfTrap"] == [10]
    plc.scan(50)
    assert [(e.scan, e.times) for e in log.entries] == [(0, 40), (3, 1), (50, 1)]
    snapshot = PLC.load(file).snapshot()  # of one that keeps no log
    plc.restore(snapshot)
    plc.scan(5)
    assert [(e.scan, e.times) for e in log.entries] == [(0, 5), (3, 1)]
    plc.reset("cold")
    plc.scan(2)
    assert [(e.scan, e.times) for e in log.entries] == [(0, 2)]


def test_too_many(file, monkeypatch, capsys):
    monkeypatch.setattr("plcruntime.returns.MOST", 10)
    assert main(["run", str(file), "--log-returns", "--scans", "60"]) == 0
    out = capsys.readouterr().out
    assert "(9 times until 0.008 s)" in out and "32 more commands did not return 0" in out


def test_typed_at_the_prompt(file):
    plc = PLC.load(file)
    log = plc.log_returns()
    plc.execute("GT_PrfTrap(0);")
    (entry,) = log.entries
    assert (entry.call.command, entry.call.argument, entry.call.place) == ("GT_PrfTrap", 0, "")


def test_motion_program(tmp_path):
    (tmp_path / "m.c").write_text("void main()\n{\nGT_PrfTrap(1);\nGT_PrfTrap(13);\n}\n")
    main_st = tmp_path / "main.st"
    main_st.write_text("""PROGRAM PLC_PRG
VAR once : BOOL := TRUE; rtn, id : INT; c : STRING := 'm.c'; bin : STRING := 'm.bin'; name : STRING := 'main';
info : TCompileInfo; END_VAR
IF once THEN
    rtn := GT_Compile(ADR(c), ADR(info)) + GT_Download(ADR(bin)) + GT_GetFunId(ADR(name), ADR(id)) + GT_Bind(3, id, 0)
        + GT_RunThread(3);
    once := FALSE;
END_IF
END_PROGRAM
""")
    plc = PLC.load(main_st)
    log = plc.log_returns()
    plc.scan(3)
    (entry,) = log.entries
    assert plc["PLC_PRG.rtn"] == 0
    assert (entry.call.command, entry.call.instance) == ("GT_PrfTrap", "thread 3")
    assert entry.call.place == f"{tmp_path / 'm.c'}:4"

"""Mistakes in the use of motion blocks: the warnings W08.. of a running program, and where they are shown."""

import json
import re
from pathlib import Path

import pytest

import stcore
from plcruntime import PLC
from plcruntime.cli import main

PAGES = sorted((Path(stcore.__file__).parent / "pages").glob("W08*.md"))
STATIONS = """
FUNCTION_BLOCK Station
VAR_IN_OUT ax : AXIS_REF_SM3; END_VAR
VAR power : MC_Power; moves : ARRAY[1..2, 0..1] OF MC_MoveRelative; skip, go, next : BOOL; END_VAR
power(Axis := ax, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
IF NOT skip THEN
    moves[2, 1](Axis := ax, Execute := go, Distance := 100, Velocity := 1000, Acceleration := 10000,
        Deceleration := 10000);
END_IF
moves[1, 0](Axis := ax, Execute := next, Distance := 100, Velocity := 1000, Acceleration := 10000,
    Deceleration := 10000);
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR a, b : AXIS_REF_SM3; station : ARRAY[1..3] OF Station; END_VAR
station[1](ax := a);
station[2](ax := b);
END_PROGRAM
"""


def codes(plc) -> list[str]:
    return [w.code for w in plc.warnings]


def ran(text: str, time: str = "300ms") -> PLC:
    plc = PLC.load(text)
    plc.run(time)
    return plc


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_page(page):
    """The wrong example gives that warning and no other, the right one none."""
    text = page.read_text(encoding="utf-8")
    wrong, right = re.findall(r"```iecst\n(.*?)\n```", text, re.S)
    assert codes(ran(wrong)) == [page.stem]
    assert codes(ran(right)) == []


@pytest.fixture
def stations():
    plc = PLC.load(STATIONS)
    plc.scan(10)
    assert plc.warnings == []
    return plc


def test_the_warning_names_the_instance_the_axis_and_the_line(stations):
    stations["PLC_PRG.station[2].go"] = True
    stations.scan(20)
    stations["PLC_PRG.station[2].skip"] = True
    stations.scan(50)
    (warning,) = stations.warnings
    assert (warning.code, warning.severity) == ("W0801", "warning")
    assert warning.instance == "PLC_PRG.station[2].moves[2,1]"
    assert (warning.axis, warning.scan, warning.time) == (2, 30, 0.03)
    assert "axis 2 (PLC_PRG.b)" in warning.message and warning.line == 7
    assert stations.diagnostics == [warning]


def test_a_block_that_is_done_needs_no_call(stations):
    stations["PLC_PRG.station[1].go"] = True
    stations.run_until("PLC_PRG.station[1].moves[2,1].Done")
    stations["PLC_PRG.station[1].skip"] = True
    stations.scan(100)
    assert stations.warnings == []


def test_what_is_added_to_a_motion_goes_on_without_its_block():
    text = """
PROGRAM PLC_PRG
VAR ax : AXIS_REF_SM3; power : MC_Power; run : MC_MoveVelocity; over : MC_MoveSuperImposed; n : INT; END_VAR
n := n + 1;
power(Axis := ax, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
run(Axis := ax, Execute := power.Status, Velocity := 100, Acceleration := 1000, Deceleration := 1000);
IF n < 60 OR n > 290 THEN
    over(Axis := ax, Execute := n > 50, Distance := 10, VelocityDiff := 100, Acceleration := 1000,
        Deceleration := 1000);
END_IF
END_PROGRAM
"""
    plc = ran(text)
    assert [(w.code, w.instance) for w in plc.warnings] == [("W0801", "PLC_PRG.over")]
    assert plc["PLC_PRG.over.Done"] and plc["PLC_PRG.ax.nAxisState"] == 5


def test_one_warning_for_an_instance_and_a_reason(stations):
    for _ in range(5):
        for value in (True, False):
            stations["PLC_PRG.station[1].go"] = stations["PLC_PRG.station[1].next"] = value
            stations.scan(20)
    assert codes(stations) == ["W0805"]
    assert stations.warnings[0].instance == "PLC_PRG.station[1].moves[2,1]"
    assert "to PLC_PRG.station[1].moves[1,0]" in stations.warnings[0].message


def test_warnings_go_with_the_time(stations):
    stations["PLC_PRG.station[1].go"] = stations["PLC_PRG.station[1].next"] = True
    before = stations.snapshot()
    stations.scan(2)
    assert codes(stations) == ["W0805"]
    stations.restore(before)
    assert stations.warnings == []
    stations.scan(2)
    stations.reset()
    assert stations.warnings == []


def test_a_program_without_axes_has_none():
    assert ran("PROGRAM PLC_PRG VAR n : INT; END_VAR n := n + 1; END_PROGRAM").warnings == []


def test_stopping_in_the_same_scan_is_no_mistake():
    text = """
PROGRAM PLC_PRG
VAR ax : AXIS_REF_SM3; power : MC_Power; move : MC_MoveVelocity; halt : MC_Halt; stop : MC_Stop; END_VAR
power(Axis := ax, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
move(Axis := ax, Execute := power.Status, Velocity := 10, Acceleration := 100, Deceleration := 100);
halt(Axis := ax, Execute := power.Status, Deceleration := 100);
stop(Axis := ax, Execute := power.Status, Deceleration := 100);
END_PROGRAM
"""
    assert codes(ran(text)) == []


def test_a_step_after_status_is_no_wrong_order():
    text = """
PROGRAM PLC_PRG
VAR ax : AXIS_REF_SM3; power : MC_Power; move : MC_MoveRelative; step : INT; END_VAR
IF step = 1 THEN step := 2; END_IF
power(Axis := ax, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
move(Axis := ax, Execute := step = 2, Distance := 1, Velocity := 10, Acceleration := 100, Deceleration := 100);
IF power.Status AND step = 0 THEN step := 1; END_IF
END_PROGRAM
"""
    plc = ran(text)
    assert plc["PLC_PRG.move.Done"] and codes(plc) == []


def test_one_mc_power_after_the_other_is_no_second_one():
    text = """
PROGRAM PLC_PRG
VAR ax : AXIS_REF_SM3; hand, auto : MC_Power; n : INT; END_VAR
n := n + 1;
hand(Axis := ax, Enable := n < 20, bRegulatorOn := n < 15, bDriveStart := TRUE);
auto(Axis := ax, Enable := n > 20, bRegulatorOn := TRUE, bDriveStart := TRUE);
END_PROGRAM
"""
    plc = ran(text)
    assert plc["PLC_PRG.auto.Status"] and codes(plc) == []


def test_run_shows_them(tmp_path, capsys):
    wrong = re.search(r"```iecst\n(.*?)\n```", PAGES[0].read_text(encoding="utf-8"), re.S)[1]
    file = tmp_path / "wrong.st"
    file.write_text(wrong)
    assert main(["run", str(file), "--for", "100ms"]) == 0
    shown = capsys.readouterr().err
    assert f"{file}:11:5: warning W0801: PLC_PRG.move moves axis 1 (PLC_PRG.ax)" in shown and "hint: call it" in shown
    main(["run", str(file), "--for", "100ms", "--json"])
    (found,) = json.loads(capsys.readouterr().out)["diagnostics"]
    assert (found["code"], found["severity"], found["instance"]) == ("W0801", "warning", "PLC_PRG.move")
    assert (found["line"], found["scan"], found["time"]) == (11, 49, 0.049)


def test_the_report_has_them_among_its_events(tmp_path):
    pytest.importorskip("plotly")
    from plcruntime.html_report import events

    wrong = re.search(r"```iecst\n(.*?)\n```", PAGES[0].read_text(encoding="utf-8"), re.S)[1]
    plc = PLC.load(wrong)
    recording = plc.record()
    plc.run("100ms")
    found = [e for e in events.collect(recording, [("", wrong)]) if e.kind == "warning"]
    assert [(e.time, e.text[:6]) for e in found] == [(0.049, "W0801:")]

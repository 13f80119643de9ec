"""What the host does: configuration files, and which axis of the program is which of the simulator."""

import re
from pathlib import Path

import pytest

from mclib import host
from plcruntime import PLC

DOC = Path(__file__).parents[2] / "docs/config_files.md"


def test_settings_of_sections_in_order():
    text = "# all\n[axis *]\nalarm = none ; comment\n[Axis 2]\nALARM = 3\nstop_abrupt=500.5\n"
    entries = host.parse_config(text)
    assert entries[:2] == [(1, 1, -1.0), (1, 2, -1.0)] and len(entries) == 14
    assert entries[12:] == [(1, 2, 3.0), (9, 2, 500.5)]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("alarm = none", 1), ("[axis 13]", 1), ("[axis]", 1), ("[motor 1]", 1), ("[axis 1]\nalarm", 2),
        ("[axis 1]\n\nalarms = 1", 3), ("[axis 1]\nalarm = 0", 2), ("[axis 1]\nlag = x", 2), ("[axis 1]\nlag = nan", 2),
        ("[axis 1]\nlag = none", 2), ("[axis 1]\nprofile_alpha = 0", 2), ("[axis 1]\nstop_smooth = 40000", 2),
    ],
)  # fmt: skip
def test_wrong_lines_are_named(text, line):
    with pytest.raises(host.ConfigError) as caught:
        host.parse_config(text)
    assert caught.value.line == line


def test_every_setting_is_documented():
    documented = set(re.findall(r"`([a-z_]+)`", DOC.read_text(encoding="utf-8")))
    assert set(host.SETTINGS) <= documented


def test_the_shipped_files_are_found_last(tmp_path):
    assert host.find_config("test.cfg", []) == host.CONFIG / "test.cfg"
    (tmp_path / "test.cfg").write_text("")
    assert host.find_config("test.cfg", [tmp_path]) == tmp_path / "test.cfg"
    assert host.find_config("none.cfg", [tmp_path]) is None
    assert host.find_config("", [tmp_path]) is None
    assert host.parse_config((host.CONFIG / "servo.cfg").read_text())


def test_a_configuration_file_beside_the_program(tmp_path):
    (tmp_path / "my.cfg").write_text("[axis 1]\nstop_smooth = 7\nwrong line\n")
    program = tmp_path / "main.st"
    program.write_text("PROGRAM PLC_PRG VAR rtn : INT; d, e : LREAL; END_VAR\n"
                       "rtn := GT_LoadConfig('my.cfg'); GT_GetStopDec(1, ADR(d), ADR(e));\nEND_PROGRAM")  # fmt: skip
    plc = PLC.load(program)
    plc.scan()
    assert plc["PLC_PRG.rtn"] == 7 and plc["PLC_PRG.d"] == 1.0
    assert plc["SIM.refused[0].axis"] == 3  # the line
    (tmp_path / "my.cfg").write_text("[axis 1]\nstop_smooth = 7\n")
    plc.scan()
    assert plc["PLC_PRG.rtn"] == 0 and plc["PLC_PRG.d"] == 7.0


NESTED = """
TYPE Station : STRUCT name : STRING; axes : ARRAY[0..1] OF AXIS_REF_SM3; END_STRUCT END_TYPE
FUNCTION_BLOCK Arm
VAR_IN_OUT other : AXIS_REF_SM3; END_VAR
VAR own : AXIS_REF_SM3; power : MC_Power; END_VAR
power(Axis := own);
END_FUNCTION_BLOCK
VAR_GLOBAL first : AXIS_REF_SM3; END_VAR
PROGRAM PLC_PRG
VAR a : AXIS_REF_SM3; s : Station; arms : ARRAY[1..2] OF Arm; END_VAR
arms[1](other := a); arms[2](other := first);
END_PROGRAM
"""


def test_axes_are_numbered_in_order_of_declaration():
    plc = PLC.load(NESTED)
    order = ["first", "a", "s.axes[0]", "s.axes[1]", "arms[1].own", "arms[2].own"]
    paths = [p if p == "first" else f"PLC_PRG.{p}" for p in order]
    assert [plc[f"{p}.axisNo"] for p in paths] == [1, 2, 3, 4, 5, 6]
    assert plc["SIM.count"] == 6
    plc.scan()
    plc.reset("origin")
    assert [plc[f"{p}.axisNo"] for p in paths] == [1, 2, 3, 4, 5, 6]


def test_more_axes_than_the_simulator_has():
    with pytest.raises(ValueError, match="65.*64"):
        PLC.load("PROGRAM PLC_PRG VAR a : ARRAY[1..65] OF AXIS_REF_SM3; p : MC_Power; END_VAR p(a[1]); END_PROGRAM")

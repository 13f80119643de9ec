"""What the host does: configuration files, and which axis of the program is which of the simulator."""

import re
from pathlib import Path

import pytest

from mclib import configuration
from plcruntime import PLC
from plcruntime.errors import UsageError

DOC = Path(__file__).parents[2] / "docs/config_files.md"


def test_the_last_of_several_settings_holds():
    text = "# all\n[axis *]\nalarm = none ; comment\n[Axis 2]\nALARM = 3\nstop_abrupt=500.5\n"
    entries = configuration.parse(text)
    assert entries[:3] == [(1, 1, -1.0), (1, 2, 3.0), (1, 3, -1.0)] and entries[12:] == [(9, 2, 500.5)]
    every = {name: s for name, s in configuration.SETTINGS.items() if not name.startswith("soft")}
    most = "".join(f"[axis *]\n{name} = {s.low:g}\n" for name, s in every.items())
    assert len(configuration.parse(60 * most)) == 12 * len(every) < 512  # SIM.config


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("alarm = none", 1), ("[axis 13]", 1), ("[axis]", 1), ("[motor 1]", 1), ("[axis 1]\nalarm", 2),
        ("[axis 1]\n\nalarms = 1", 3), ("[axis 1]\nalarm = 0", 2), ("[axis 1]\nlag = x", 2), ("[axis 1]\nlag = nan", 2),
        ("[axis 1]\nalarm = 1.5", 2), ("[axis 1]\npulse_type = 3", 2), ("[axis 1]\nlag = none", 2),
        ("[axis 1]\nencoder_alpha = 2\nencoder_beta = 3", 3), ("[axis 1]\nprofile_alpha = 0", 2),
        ("[axis *]\nsoft_positive = 5\n[axis 3]\nsoft_negative = 5", 4), ("[axis 1]\nstop_smooth = 40000", 2),
    ],
)  # fmt: skip
def test_wrong_lines_are_named(text, line):
    with pytest.raises(configuration.ConfigError) as caught:
        configuration.parse(text)
    assert caught.value.line == line


@pytest.mark.parametrize(
    ("line", "words"),
    [("alarmm = 1", "mean alarm"), ("stop_smooth = 0", "more than 0 to 32767"), ("profile_beta = 0", "without 0")],
)
def test_what_is_wrong_is_told(line, words):
    with pytest.raises(configuration.ConfigError, match=words):
        configuration.parse(f"[axis 1]\n{line}")


def test_every_setting_is_documented():
    documented = set(re.findall(r"`([a-z_]+)`", DOC.read_text(encoding="utf-8")))
    assert set(configuration.SETTINGS) <= documented


def test_the_shipped_files_are_found_last(tmp_path):
    assert configuration.find("test.cfg", []) == configuration.SHIPPED / "test.cfg"
    (tmp_path / "test.cfg").write_text("")
    assert configuration.find("test.cfg", [tmp_path]) == tmp_path / "test.cfg"
    assert configuration.find("none.cfg", [tmp_path]) is None
    assert configuration.find("", [tmp_path]) is None
    assert configuration.parse((configuration.SHIPPED / "servo.cfg").read_text())


def test_a_configuration_file_beside_the_program(tmp_path):
    (tmp_path / "my.cfg").write_text("[axis 1]\nstop_smooth = 7\nwrong line\n")
    program = tmp_path / "main.st"
    program.write_text("""PROGRAM PLC_PRG VAR rtn : INT; d, e : LREAL; END_VAR
rtn := GT_LoadConfig('my.cfg'); GT_ClrSts(1); GT_GetStopDec(1, ADR(d), ADR(e));
END_PROGRAM""")
    plc = PLC.load(program)
    plc.scan()
    assert plc["PLC_PRG.rtn"] == 7 and plc["PLC_PRG.d"] == 1.0
    assert (
        plc["SIM.refused[0].axis"] == 3 and plc["SIM.refused[0].why"] == "line 3: a setting is written 'name = value'"
    )
    (tmp_path / "my.cfg").write_text("[axis 1]\nstop_smooth = 7\n")
    plc.scan()
    assert plc["PLC_PRG.rtn"] == 0 and plc["PLC_PRG.d"] == 7.0


def test_a_configuration_waits_for_clrsts(tmp_path):
    """4.4: the command takes effect with GT_ClrSts only; axis by axis here, each setting the last that was loaded."""
    (tmp_path / "a.cfg").write_text("[axis *]\nlimit_positive = none\nstop_smooth = 7\n")
    (tmp_path / "b.cfg").write_text("[axis 1]\nstop_smooth = 8\n")
    (tmp_path / "main.st").write_text("""PROGRAM P
VAR load, clear, reset : BOOL; dec : ARRAY[1..2] OF LREAL; abrupt : LREAL; END_VAR
IF load THEN GT_LoadConfig('a.cfg'); GT_LoadConfig('b.cfg'); load := FALSE; END_IF
IF reset THEN GT_Reset(); reset := FALSE; END_IF
IF clear THEN GT_ClrSts(1); clear := FALSE; END_IF
GT_GetStopDec(1, ADR(dec[1]), ADR(abrupt));
GT_GetStopDec(2, ADR(dec[2]), ADR(abrupt));
END_PROGRAM""")
    plc = PLC.load(tmp_path / "main.st")
    plc["P.load"] = True
    plc.axes[1].switches.positive = True
    plc.scan(2)
    assert plc["P.dec"] == [1.0, 1.0] and plc.axes[1].status & 0x20
    plc["P.clear"] = True
    plc.scan(2)
    assert plc["P.dec"] == [8.0, 1.0] and not plc.axes[1].status & 0x20
    plc["P.load"] = plc["P.reset"] = plc["P.clear"] = True  # GT_Reset forgets what waits
    plc.scan(2)
    assert plc["P.dec"] == [1.0, 1.0] and plc.axes[1].status & 0x20


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("none.cfg", "there is no file 'none.cfg'"), ("", "there is no file ''"),
        ("x" * 126, "more than 125 characters"), ("x" * 121 + ".cfg", "there is no file"),
    ],
)  # fmt: skip
def test_a_file_that_is_not_there(name, words):
    plc = PLC.load(
        f"PROGRAM P VAR rtn : INT; file : STRING(200) := '{name}'; END_VAR rtn := GT_LoadConfig(file); END_PROGRAM"
    )
    plc.scan()
    assert plc["P.rtn"] == 7 and words in plc["SIM.refused[0].why"] and plc.fault is None


def test_a_scale_that_is_loaded_with_the_servo_on_moves_no_motor(tmp_path):
    (tmp_path / "my.cfg").write_text("[axis 1]\nprofile_alpha = 4\nprofile_beta = 1\n")
    (tmp_path / "main.st").write_text("""PROGRAM P
VAR rtn : INT; once : BOOL := TRUE; END_VAR
IF once THEN
    rtn := GT_AxisOn(1) + GT_SetPrfPos(1, 1000) + GT_LoadConfig('my.cfg') + GT_ClrSts(1) + GT_SetPrfPos(1, 0);
    once := FALSE;
END_IF
END_PROGRAM""")
    plc = PLC.load(tmp_path / "main.st")
    plc.scan()
    assert plc["P.rtn"] == 0 and plc.axes[1].position == 0.0
    plc.axes[1].prfPos = 400.0  # four of the profile are one of the axis
    plc.scan()
    assert plc.axes[1].position == 100.0


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
    with pytest.raises(UsageError, match="257.*256"):
        PLC.load("PROGRAM PLC_PRG VAR a : ARRAY[1..257] OF AXIS_REF_SM3; p : MC_Power; END_VAR p(a[1]); END_PROGRAM")


def test_as_many_axes_as_the_simulator_has():
    plc = PLC.load(
        "PROGRAM PLC_PRG VAR a : ARRAY[1..256] OF AXIS_REF_SM3; p : ARRAY[1..256] OF MC_Power; i, on : INT; END_VAR "
        "on := 0; FOR i := 1 TO 256 DO p[i](Axis := a[i], Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);"
        "IF p[i].Status THEN on := on + 1; END_IF END_FOR END_PROGRAM"
    )
    plc.scan(5)
    assert plc["on"] == plc["SIM.count"] == 256

"""Blocks in the form of CODESYS SoftMotion and in that of PLCopen Part 1 (docs/what_differs.md)."""

import pytest

from plcruntime import PLC
from plcruntime.errors import UsageError

TEXT = """
PROGRAM PLC_PRG
VAR
    ax : AXIS_REF; power : MC_Power; on : BOOL := TRUE; move : MC_MoveAbsolute; run : MC_MoveVelocity;
    stop, again : MC_Stop; place : MC_SetPosition; table : MC_TV_REF; profile : MC_VelocityProfile;
    points : MC_TP_REF; path : MC_PositionProfile;
END_VAR
%s
move(Axis := ax, Direction := mcShortestWay, BufferMode := mcAborting);
run(Axis := ax, Velocity := 100, Acceleration := 1000, Deceleration := 1000, Direction := mcNegativeDirection);
stop(Axis := ax, Deceleration := 1000); again(Axis := ax, Deceleration := 1000);
place(Axis := ax, Relative := TRUE); profile(Axis := ax, TimeVelocity := table);
path(Axis := ax, TimePosition := points);
END_PROGRAM
"""
POWER = {
    "codesys": "power(Axis := ax, Enable := TRUE, bRegulatorOn := on, bDriveStart := TRUE);",
    "plcopen": "power(Axis := ax, Enable := on);",
}
POWER_OFF, ERRORSTOP, STANDSTILL, DISCRETE, CONTINUOUS = 0, 1, 3, 4, 5


class Bench:
    def __init__(self, dialect: str, folder) -> None:
        (folder / "prog.st").write_text(TEXT % POWER[dialect])
        (folder / "plc.toml").write_text(f'[project]\ndialect = "{dialect}"\n')
        self.plc = PLC.load(folder / "plc.toml")
        self.dialect = dialect
        self.plc.scan(5)

    def __getitem__(self, name):
        return self.plc[f"PLC_PRG.{name}"]

    def __setitem__(self, name, value):
        self.plc[f"PLC_PRG.{name}"] = value

    @property
    def state(self):
        return self["ax.nAxisState"]

    def start(self, block, scans=1, **inputs):
        for name, value in inputs.items():
            self[f"{block}.{name}"] = value
        self[f"{block}.Execute"] = True
        self.plc.scan(scans)


@pytest.fixture(params=["codesys", "plcopen"])
def bench(request, tmp_path):
    return Bench(request.param, tmp_path)


def test_power_on_and_off(bench):
    assert bench["power.Status"] and bench.state == STANDSTILL
    bench["on"] = False
    bench.plc.scan(2)
    assert not bench["power.Status"] and bench.state == POWER_OFF


def test_the_inputs_of_mc_power_that_plcopen_has_not(tmp_path):
    (tmp_path / "prog.st").write_text(TEXT % POWER["plcopen"])
    plc = PLC.load(tmp_path / "prog.st")  # CODESYS's form: Enable alone switches nothing on
    plc.scan(5)
    assert plc["PLC_PRG.ax.nAxisState"] == POWER_OFF


def test_wrong_values_at_standstill(bench):
    bench.start("move", Position=10.0)
    assert bench["move.Error"] and bench["move.ErrorID"] == 201
    assert bench.state == (DISCRETE if bench.dialect == "codesys" else STANDSTILL)
    bench["move.Execute"] = False
    bench.plc.scan()
    assert bench.state == STANDSTILL


def test_a_second_stop(bench):
    bench.start("run", 200)
    assert bench["ax.fSetVelocity"] == -100.0
    bench.start("stop", 5)
    bench.start("again")
    assert bench["again.Error"]
    bench.plc.scan(200)
    if bench.dialect == "codesys":
        assert bench.state == ERRORSTOP and bench["stop.Error"]
    else:
        assert bench["stop.Done"] and not bench["stop.Error"]


def test_a_profile_that_ends_in_motion(bench):
    for i, (time, velocity) in enumerate([(0.1, 50.0), (0.1, 20.0)], 1):
        bench[f"table.MC_TV_Array[{i}].delta_time"] = time
        bench[f"table.MC_TV_Array[{i}].velocity"] = velocity
    bench["table.Number_of_pairs"] = 2
    size = {"ArraySize": 2} if bench.dialect == "codesys" else {}
    bench.start("profile", TimeScale=2.0, **size)
    assert bench.state == (DISCRETE if bench.dialect == "codesys" else CONTINUOUS)
    bench.plc.run("300ms")
    assert bench["profile.Busy"]
    bench.plc.run("200ms")
    assert bench["profile.Done"]
    if bench.dialect == "codesys":
        assert bench.state == ERRORSTOP and bench["ax.dwErrorID"] == 30001
    else:
        assert bench.state == CONTINUOUS and bench["ax.fSetVelocity"] == pytest.approx(20.0)


def test_a_profile_by_its_number_of_pairs(bench):
    bench["points.MC_TP_Array[1].delta_time"] = 0.1
    bench["points.MC_TP_Array[1].position"] = 5.0
    bench["points.Number_of_pairs"] = 1
    bench.start("path", 150)
    if bench.dialect == "codesys":
        assert bench["path.ErrorID"] == 325
    else:
        assert bench["path.Done"] and bench["ax.fSetPosition"] == 5.0 and bench.state == STANDSTILL


def test_names_of_plcopen_are_known_in_both(bench):
    bench.start("place", Position=7.0)
    assert bench["place.Done"] and bench["ax.fSetPosition"] == 7.0
    assert bench["place.Relative"] is bench["place.Mode"] is True


def test_a_relative_profile_that_rounding_keeps_from_zero(bench):
    """0.1 + 0.2 - 0.3 is not 0, but the axis rests."""
    for i, velocity in enumerate([0.1, 0.2, -0.3], 1):
        bench[f"table.MC_TV_Array[{i}].delta_time"] = 0.01
        bench[f"table.MC_TV_Array[{i}].velocity"] = velocity
    bench["table.IsAbsolute"] = False
    bench.start("profile", 50, ArraySize=3)
    assert bench["profile.Done"] and bench.state == STANDSTILL


def test_an_unknown_dialect(tmp_path):
    (tmp_path / "plc.toml").write_text('[project]\ndialect = "plcopn"\n')
    with pytest.raises(UsageError, match="dialect is one of .*did you mean plcopen"):
        PLC.load(tmp_path / "plc.toml")


def test_the_end_of_a_profile_by_its_name_in_plcopen(bench):
    bench["table.MC_TV_Array[1].delta_time"] = 0.01
    bench["table.Number_of_pairs"] = 1
    bench.start("profile", 20, ArraySize=1)
    assert bench["profile.ProfileCompleted"] and bench["profile.Done"]

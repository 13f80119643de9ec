"""The prompt with a CONFIGURATION: several instances of one program, and the names of VAR_ACCESS."""

import pytest

from plcruntime import PLC
from plcruntime.cli import main

from .conftest import Prompt

TEXT = """\
FUNCTION_BLOCK Cnt
VAR_INPUT step : INT := 1; END_VAR
VAR_OUTPUT total : DINT; END_VAR
total := total + step;
END_FUNCTION_BLOCK
PROGRAM P
VAR_INPUT gain : INT := 1; END_VAR
VAR n : INT; cnt : Cnt; tab : ARRAY[1..2] OF INT; END_VAR
n := n + gain;
cnt(step := gain);
END_PROGRAM
CONFIGURATION Plant
RESOURCE R ON PLC
TASK t (INTERVAL := T#1ms, PRIORITY := 1);
PROGRAM one WITH t : P (gain := 1);
PROGRAM two WITH t : P (gain := 3);
END_RESOURCE
VAR_ACCESS
  speed : R.one.n : INT READ_WRITE;
  other : R.two.n : INT READ_ONLY;
  list : R.two.tab : ARRAY[1..2] OF INT READ_ONLY;
  total : R.two.cnt.total : DINT READ_WRITE;
END_VAR
END_CONFIGURATION
"""


@pytest.fixture
def plant(tmp_path, capsys):
    (tmp_path / "plant.st").write_text(TEXT)
    return Prompt(PLC.load(tmp_path / "plant.st", probes=True), capsys)


def test_names_of_var_access_are_read_and_written(plant):
    plant("step 4")
    assert [plant(x) for x in ("speed", "other + 1", "total", "list[2]")] == ["4", "13", "12", "0"]
    plant.all("speed := 50", "set total := 60", "step")
    assert plant.plc["one.n"] == 51 and plant.plc["two.cnt.total"] == 63
    plant.all("force speed := 7", "step")
    assert plant("speed") == "7" and plant("unforce speed") == ""
    assert plant("watch speed * 2") == "  speed * 2 = 14"
    assert plant("watch nothing.x") == "nothing is not declared"
    assert plant("next").splitlines()[-1] == "  speed * 2 = 14"  # in the middle of a scan too


@pytest.mark.parametrize(
    "line",
    ["other := 4", "set other := 4", "force other := 4", "list[1] := 4", "set list[1] := 4", "set list := [1, 2]"],
)
def test_what_var_access_has_read_only_is_not_written(plant, line):
    said = plant(line)
    assert "READ_ONLY" in said and "\n" not in said
    assert plant.plc["two.n"] == 0 and plant.plc["two.tab"] == [0, 0] and not plant.plc.forced


def test_var_access_on_the_command_line(tmp_path, capsys):
    file, out = tmp_path / "plant.st", tmp_path / "out.csv"
    file.write_text(TEXT)
    run = ["run", str(file), "--scans", "4"]
    assert main([*run, "--set", "speed=100@#2", "--watch", "speed,other", "--trace", str(out)]) == 0
    assert out.read_text().splitlines()[-1] == "0.003,102,12"
    assert main([*run, "--set", "other=1"]) == 2
    assert "READ_ONLY" in capsys.readouterr().err


def test_stops_in_the_second_instance_only(plant):
    assert plant("break two:10").splitlines()[0] == "breakpoint 1: two:10"
    assert plant("run 5ms").splitlines()[0] == "breakpoint 1: two (P), in scan 0, 0 s"
    assert plant.all("n := 20", "n") == "20" and plant("where").startswith("two, ")
    assert plant("into").splitlines()[0] == "two.cnt (Cnt), in scan 0, 0 s"
    plant.all("delete", "step")
    assert (plant.plc["one.n"], plant.plc["two.n"]) == (1, 20)
    assert plant("break one:9 if n = 3").startswith("breakpoint 2: one:9")
    assert plant("run 5ms").startswith("breakpoint 2: one (P), in scan 3")
    plant.all("delete", "step", "break P:9 if gain = 3")
    assert plant("run 5ms").startswith("breakpoint 3: two (P), in scan 4")
    assert "Cnt" in plant("break two.cnt:4") and plant("break three:1").startswith("no POU three")

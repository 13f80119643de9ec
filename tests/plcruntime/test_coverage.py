"""Coverage of ST, against counts made by hand."""

from pathlib import Path
from xml.etree import ElementTree

import pytest
from sample import some_examples

from plcruntime import PLC
from plcruntime.cli import main
from plcruntime.coverage import Coverage
from plcruntime.plc import build
from plcruntime.st_tests import TestFile

LIBRARY = """\
FUNCTION Sign : INT
VAR_INPUT a : INT; END_VAR
IF a > 0 THEN
  Sign := 1;
ELSIF a < 0 THEN
  Sign := -1;
END_IF
CASE a OF
  1, 2: Sign := Sign + 1;
  3..5:
    Sign := Sign + 2;
  7: Sign := Sign + 3;
END_CASE
END_FUNCTION
"""
TESTS = """\
{attribute 'test'}
FUNCTION test_one : BOOL
ASSERT_EQ(2, Sign(1));
ASSERT_EQ(3, Sign(4));
END_FUNCTION

{attribute 'test'}
PROGRAM test_two
VAR n : INT := 1; END_VAR
n := n + 1;
ASSERT(Sign(n) > 0);
IF n = 4 THEN TEST_DONE(); END_IF
END_PROGRAM
"""


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    (tmp_path / "Sign.st").write_text(LIBRARY)
    (tmp_path / "test_sign.st").write_text(TESTS)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def coverage(folder) -> Coverage:
    file, made = TestFile(folder / "test_sign.st", probes=True), Coverage()
    for test in file.tests:
        assert file.run(test).passed
        made.add(file.program, file.plc._machine.memory)
    return made


def test_statements(folder, coverage):
    # called with 1, 4, 2, 3, 4
    (path,) = coverage.files
    assert Path(path).name == "Sign.st"
    assert coverage.files[path].lines() == {3: 5, 4: 5, 6: 0, 8: 5, 9: 2, 11: 3, 12: 0}


def test_branches_and_states(folder, coverage):
    (file,) = coverage.files.values()
    ways = [(place[0], way.kind, way.label, way.line, way.count) for place, _, way in file.ways()]
    assert ways == [
        (3, "IF", "a > 0", 3, 5), (3, "IF", "a < 0", 5, 0), (3, "IF", "ELSE", 3, 0),
        (8, "CASE", "1, 2", 9, 2), (8, "CASE", "3..5", 10, 3), (8, "CASE", "7", 12, 0), (8, "CASE", "ELSE", 8, 0),
    ]  # fmt: skip


def test_table(coverage):
    ((path, *cells),) = coverage.table()
    assert cells == ["7", "71 % 5/7", "33 % 1/3", "50 % 2/4", "-", "6, 12"]


LOOPS = """\
FUNCTION Loops : INT
VAR_INPUT n : INT; END_VAR
VAR i, k : INT; END_VAR
FOR i := 1 TO n DO
  IF i = 3 THEN EXIT; END_IF
END_FOR
FOR i := 5 TO 1 BY -2 DO Loops := Loops + 1; END_FOR
WHILE k < n DO
  k := k + 1;
  WHILE k > 100 DO EXIT; END_WHILE
END_WHILE
REPEAT
  k := k - 1;
UNTIL k < 0 END_REPEAT
REPEAT k := 0; UNTIL TRUE END_REPEAT
END_FUNCTION
{attribute 'test'}
FUNCTION test_loops : BOOL
ASSERT_EQ(3, Loops(0));
ASSERT_EQ(3, Loops(2));
ASSERT_EQ(3, Loops(5));
END_FUNCTION
"""


def test_loops(tmp_path):
    (tmp_path / "test_loops.st").write_text(LOOPS)
    file, made = TestFile(tmp_path / "test_loops.st", probes=True), Coverage()
    assert file.run(file.tests[0]).passed
    made.add(file.program, file.plc._machine.memory)
    (covered,) = made.files.values()
    ways = [(place[0], way.label, way.count) for place, _, way in covered.ways("LOOP")]
    # n = 0, 2, 5: k is 0, 2, 5 before the first REPEAT, which goes 1, 3 and 6 rounds
    assert ways == [
        (4, "body", 2), (4, "no round", 1), (7, "body", 3), (7, "no round", 0), (8, "body", 2), (8, "no round", 1),
        (10, "body", 0), (10, "no round", 7), (12, "another round", 0 + 2 + 5), (12, "done", 3),
        (15, "another round", 0), (15, "done", 3),
    ]  # fmt: skip
    assert [w.count for _, _, w in covered.ways("IF")] == [1, 4]  # i = 3 with n = 5; else 1, 2 and 1, 2
    other = Coverage()
    other.merge(made.data())
    other.merge(made.data())
    assert [w.count for _, _, w in next(iter(other.files.values())).ways("LOOP")] == [2 * c for _, _, c in ways]
    assert made.table()[0][5] == "75 % 9/12"


def test_files(folder, capsys):
    assert main(["test", "--lcov", "out.info", "--cobertura", "out.xml"]) == 0
    assert "71 % 5/7" in capsys.readouterr().out
    lines = (folder / "out.info").read_text().splitlines()
    assert lines[1].startswith("SF:") and lines[1].endswith("Sign.st")
    assert {"DA:4,5", "DA:6,0", "LF:7", "LH:5", "BRF:7", "BRH:3", "BRDA:3,1,0,5", "BRDA:3,1,1,0"} <= set(lines)
    root = ElementTree.parse(folder / "out.xml").getroot()
    assert (root.get("lines-covered"), root.get("lines-valid")) == ("5", "7")
    assert (root.get("branches-covered"), root.get("branches-valid")) == ("3", "7")
    line = next(x for x in root.iter("line") if x.get("number") == "8")
    assert (line.get("hits"), line.get("condition-coverage")) == ("5", "50% (2/4)")


def test_a_file_that_cannot_be_written(folder, capsys):
    assert main(["test", "--lcov", "no/out.info"]) == 2
    assert "there is no folder no" in capsys.readouterr().err
    assert main(["test", "--cobertura", "."]) == 2
    if Path("/dev/full").exists():
        assert main(["test", "--lcov", "/dev/full"]) == 2
        assert "can't be written: No space left" in capsys.readouterr().err


SPECIAL = ("fault", "mistakes", "test_")  # examples that fail on purpose, or are no program
PROGRAMS = [e for e in some_examples() if not e.name.startswith(SPECIAL)]


@pytest.mark.parametrize("example", PROGRAMS, ids=lambda e: e.stem)
def test_a_probed_build_does_what_the_plain_one_does(example):
    plain = PLC.load(example)
    program, _ = build(example, probes=True)
    probed = PLC(program)
    for plc in (plain, probed):
        plc.scan(700)
    end = plain.program.state_end
    assert bytes(plain._machine.memory[1024:end]) == bytes(probed._machine.memory[1024:end])

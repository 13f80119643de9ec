"""Tests written in ST and ``scancycle test``."""

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from plcruntime.cli import main
from plcruntime.st_tests import TestFile, find, report
from stcore.diagnostics import CompileError

TEXT = """\
TYPE Colour : (Red, Green, Blue); END_TYPE
FUNCTION Twice : INT
VAR_INPUT a : INT; END_VAR
Twice := a * 2;
END_FUNCTION

{attribute 'test'}
FUNCTION test_every_kind : BOOL
VAR
  c : Colour := Green; t : TIME := T#2s; s : STRING := 'ab'; r : REAL := 0.5; l : LREAL := 0.1; w : WORD := 16#FF;
END_VAR
ASSERT_EQ(4, Twice(2), 'two');
ASSERT(Twice(3) = 6, 'three');
ASSERT_EQ(Green, c, 'colour');
ASSERT_EQ(T#2s, t);
ASSERT_EQ('ab', s);
ASSERT_EQ(TRUE, t > T#1s);
ASSERT_EQ(0.5, r);
ASSERT_EQ(16#FF, w);
ASSERT_NEAR(0.3, l + 0.2, 1E-9, 'near');
END_FUNCTION

{attribute 'test'}
FUNCTION test_eq : BOOL
ASSERT_EQ(5, Twice(2), 'two');
END_FUNCTION

{attribute 'test'}
FUNCTION test_near : BOOL
ASSERT_NEAR(1.0, 1.5, 0.1);
END_FUNCTION

{attribute 'test'}
FUNCTION test_text : BOOL
VAR s : STRING := 'one'; END_VAR
ASSERT_EQ('two', s, 'texts');
END_FUNCTION

{attribute 'test'}
PROGRAM test_timer
VAR t : TON; n : INT; END_VAR
t(IN := TRUE, PT := T#5ms);
n := n + 1;
IF t.Q THEN
  ASSERT_EQ(6, n);
  TEST_DONE();
END_IF
END_PROGRAM

{attribute 'test'}
{attribute 'timeout' := '50ms'}
PROGRAM test_never
VAR n : INT; END_VAR
n := n + 1;
END_PROGRAM

{attribute 'test'}
PROGRAM test_late
VAR n, other : INT; END_VAR
n := n + 1;
other := other + 3;
ASSERT(n < 8, 'too far');
END_PROGRAM

{attribute 'test'}
PROGRAM test_fault
VAR n : INT := 2; m : INT; END_VAR
n := n - 1;
m := 10 / n;
END_PROGRAM
"""


def line_of(text: str) -> int:
    return next(i for i, line in enumerate(TEXT.splitlines(), 1) if text in line)


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    (tmp_path / "test_a.st").write_text(TEXT)
    (tmp_path / "prog.st").write_text("PROGRAM PLC_PRG\nVAR x : INT; END_VAR\nx := x + 1;\nEND_PROGRAM\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def results(folder) -> dict:
    file = TestFile(folder / "test_a.st")
    return {test.name: file.run(test) for test in file.tests}


def test_what_passes_and_what_fails(results):
    failed = {name for name, result in results.items() if not result.passed}
    assert failed == {"test_eq", "test_near", "test_text", "test_never", "test_late", "test_fault"}
    assert list(results)[0] == "test_every_kind"  # in the order of the file


def test_an_assertion_names_its_own_line_and_values(results):
    result = results["test_eq"]
    assert (result.line, result.assertion.expected, result.assertion.actual) == (line_of("ASSERT_EQ(5"), "5", "4")
    assert result.message == "ASSERT_EQ failed: two: expected 5, actual 4"
    assert results["test_near"].assertion.actual == "1.5"
    assert results["test_text"].assertion.actual == "'one'"
    text = report(result)
    assert f">{result.line:6}".replace(" ", "") in text.replace(" ", "") and "expected  5" in text


def test_a_program_is_scanned_until_it_is_done(results):
    assert results["test_timer"].scans == 6
    late = results["test_late"]
    assert (late.line, late.scans) == (line_of("ASSERT(n < 8"), 7)
    assert late.heads == ["time", "test_late.n"]
    assert [row[1] for row in late.rows] == ["1", "2", "3", "4", "5", "6", "7", "8"]
    assert late.rows[-1][0] == "failed"


def test_time_out_and_fault(results):
    assert "time-out after 50ms" in results["test_never"].message
    assert results["test_never"].scans == 50
    assert "F0102" in results["test_fault"].message
    assert results["test_fault"].line == line_of("m := 10 / n")


def test_each_test_begins_afresh(folder):
    file = TestFile(folder / "test_a.st")
    timer = next(t for t in file.tests if t.name == "test_timer")
    assert [file.run(timer).passed for _ in range(3)] == [True] * 3


def test_more_tests_than_tasks_fit(tmp_path):
    one = "{{attribute 'test'}}\nPROGRAM t{0}\nVAR n : INT; END_VAR\nn := n + 1;\n"
    one += "IF n = 3 THEN TEST_DONE(); END_IF\nEND_PROGRAM\n"
    (tmp_path / "test_many.st").write_text("".join(one.format(i) for i in range(400)))
    file = TestFile(tmp_path / "test_many.st")
    assert all(file.run(t).passed and file.plc.scans == 3 for t in file.tests)
    assert len(file.tests) == 400


def test_what_is_no_test(tmp_path):
    (tmp_path / "test_b.st").write_text(
        "{attribute 'test'}\nFUNCTION f : BOOL\nVAR_INPUT a : INT; END_VAR\nf := a > 0;\nEND_FUNCTION\n"
        "{attribute 'test'}\nFUNCTION_BLOCK g\nVAR a : INT; END_VAR\na := 1;\nEND_FUNCTION_BLOCK\n"
    )
    file = TestFile(tmp_path / "test_b.st")
    messages = [file.run(t).message for t in file.tests]
    assert messages == [
        "a test takes no parameters", "a FUNCTION_BLOCK can't be a test; PROGRAM, FUNCTION and METHOD can"
    ]  # fmt: skip


# ------------------------------------------------------------------------------------------------- command


def test_find(folder):
    (folder / "deep").mkdir()
    (folder / "deep" / "test_b.st").write_text("")
    assert sorted(p.name for p in find([str(folder)])) == ["test_a.st", "test_b.st"]
    assert find(["prog.st"]) == [Path("prog.st")]


def test_command(folder, capsys):
    assert main(["test"]) == 1
    out = capsys.readouterr().out
    assert "test_a.st .FFF.FFF" in out
    assert "6 failed, 2 passed" in out
    assert f"test_a.st:{line_of('ASSERT_EQ(5')}: test_eq: ASSERT_EQ failed" in out


def test_selection_and_stop(folder, capsys):
    assert main(["test", "-k", "timer or every"]) == 0
    assert "2 passed" in capsys.readouterr().out
    assert main(["test", "-k", "not (timer or every)", "-x"]) == 1
    assert "1 failed, 0 passed" in capsys.readouterr().out
    assert main(["test", "-k", "nothing"]) == 2
    assert "no test matches -k nothing" in capsys.readouterr().out
    assert main(["test", "-k", "and or"]) == 2


def test_exit_codes(folder, capsys):
    assert main(["test", "nowhere"]) == 2
    assert main(["test", "prog.st"]) == 2
    (folder / "test_a.st").write_text("{attribute 'test'}\nFUNCTION f : BOOL\nf := y;\nEND_FUNCTION\n")
    assert main(["test"]) == 1
    out = capsys.readouterr().out
    assert "E0301" in out and "1 file with errors" in out


def test_junit(folder, capsys):
    assert main(["test", "--junit", "out.xml"]) == 1
    suite = ElementTree.parse("out.xml").getroot()[0]
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("8", "6", "0")
    case = next(c for c in suite if c.get("name") == "test_eq")
    assert case.get("line") == str(line_of("FUNCTION test_eq")) and case.get("file") == "test_a.st"
    assert case[0].get("message") == "ASSERT_EQ failed: two: expected 5, actual 4"
    assert main(["test", "--junit", "no/out.xml"]) == 2


def test_watch_runs_again_after_an_edit(folder):
    command = [sys.executable, "-m", "plcruntime", "test", "--watch", "-k", "eq"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert "1 failed" in _until(process, "watching")
        (folder / "test_a.st").unlink()
        (folder / "test_a.st").write_text(TEXT.replace("ASSERT_EQ(5,", "ASSERT_EQ(4,"))
        _until(process, "1 passed")
    finally:
        process.terminate()
        process.wait()


def _until(process: subprocess.Popen, text: str) -> str:
    read = ""
    while text not in read:
        line = process.stdout.readline()
        assert line, read
        read += line
    return read


def test_an_assertion_outside_of_tests_is_a_fault_at_its_own_line(folder, capsys):
    (folder / "prog.st").write_text(
        "PROGRAM PLC_PRG\nVAR x : INT; END_VAR\nx := x + 1;\nASSERT(x < 3, 'x grows');\nEND_PROGRAM\n"
    )
    assert main(["run", "prog.st", "--scans", "10"]) == 1
    err = capsys.readouterr().err
    assert "prog.st:4:" in err and "x grows" in err


def test_the_tests_of_the_page_pass(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "testing.md").read_text(encoding="utf-8")
    (tmp_path / "test_page.st").write_text(page.split("```iecst\n")[1].split("```")[0])
    file = TestFile(tmp_path / "test_page.st")
    assert [file.run(t).message for t in file.tests] == ["", "", "", ""]


PARTS = """\
TYPE Colour : (Red, Green, Blue); END_TYPE
TYPE Part : STRUCT x : INT; name : STRING(10); t : TIME; c : Colour; END_STRUCT END_TYPE
{attribute 'test'}
FUNCTION test_parts : BOOL
VAR a, b : ARRAY[0..1, 1..2] OF Part; i : ARRAY[1..3] OF INT := [1, 2, 3]; d : DATE := D#2024-02-29;
  s : STRING := 'it$'s$N'; c : Colour := Blue; u : UDINT := 4294967295; r : REAL := 0.3; l : ULINT; n : LREAL;
  p : POINTER TO UDINT; END_VAR
%s
END_FUNCTION
"""
DIFFERENT = "a[1,2].x := 4; a[0,1].name := 'ab'; a[1,1].t := T#1500ms; a[0,2].c := Blue;"


@pytest.mark.parametrize(
    "statements, said",
    [
        ("ASSERT_EQ(a, b); ASSERT_EQ(i, i); ASSERT_EQ(a[0,1], b[1,1]);", ""),
        ("ASSERT_EQ(0.3, r); ASSERT_EQ(16#FFFFFFFF, u); ASSERT_EQ(Blue, c); ASSERT_NEAR(r, 0.3, 1E-6);", ""),
        ("l := 18446744073709551615; ASSERT_EQ(18446744073709551615, l);", ""),
        ("i[2] := 5; ASSERT_EQ([1, 2, 3], i);", None),
        ("a[0,1].x := 4; ASSERT_EQ(a[0,1], b[0,1], 'one');", "one: x: expected 4, actual 0"),
        (
            DIFFERENT + "ASSERT_EQ(a, b);",
            "[0, 1].name: expected 'ab', actual ''; [0, 2].c: expected Blue, actual Red;"
            " [1, 1].t: expected T#1.5s, actual T#0s; 1 more differ",
        ),
        ("ASSERT_EQ(Green, c);", "expected Green, actual Blue"),
        ("ASSERT_EQ('it$'s', s, 'text');", "text: expected 'it$'s', actual 'it$'s$N'"),
        ("ASSERT_EQ(D#2024-03-01, d);", "expected D#2024-03-01, actual D#2024-02-29"),
        ("ASSERT_EQ(3, u);", "expected 3, actual 4294967295"),
        ("ASSERT_EQ(0.3, n, 'n');", "n: expected 0.3, actual 0.0"),
        ("p := ADR(u); ASSERT_EQ(ADR(u), p); p := 0; ASSERT_EQ(p, 0); ASSERT_EQ(i[1], 1);", ""),
        ("ASSERT_EQ(i, 3);", None),
        ("ASSERT_EQ(i, a);", None),
    ],
)
def test_assert_eq_compares_every_kind_of_value(tmp_path, statements, said):
    file = tmp_path / "test_parts.st"
    file.write_text(PARTS % statements)
    if said is None:
        with pytest.raises(CompileError):
            TestFile(file)
        return
    tests = TestFile(file)
    result = tests.run(tests.tests[0])
    assert result.message == (said and "ASSERT_EQ failed: " + said)


def test_parts_that_differ_are_listed_in_the_report(tmp_path):
    file = tmp_path / "test_parts.st"
    file.write_text(PARTS % (DIFFERENT + "\nASSERT_EQ(a, b);"))
    tests = TestFile(file)
    text = report(tests.run(tests.tests[0])).splitlines()
    assert text[0].startswith(f"{file}:9: test_parts: ASSERT_EQ failed: [0, 1].name")
    assert "  [0, 2].c     expected Blue, actual Red" in text and "  1 more differ" in text


STIMULATED = """\
VAR_GLOBAL limit : INT := 100; END_VAR
{attribute 'test'}
{attribute 'stimuli' := 'stimuli/presses.csv'}
PROGRAM test_presses
VAR button, before : BOOL; presses : INT; now : INT; END_VAR
presses := presses + BOOL_TO_INT(button AND NOT before);
before := button;
now := now + 1;
IF now >= limit THEN
  ASSERT_EQ(50, now);
  ASSERT_EQ(%d, presses, 'presses');
  TEST_DONE();
END_IF
END_PROGRAM

{attribute 'test'}
PROGRAM test_not_pressed
VAR button : BOOL; now : INT; END_VAR
now := now + 1;
IF now = 60 THEN
  ASSERT(NOT button AND limit = 100);
  TEST_DONE();
END_IF
END_PROGRAM
"""
PRESSES = """\
time,variable,value
10ms,button,TRUE
20ms,button,FALSE
#30,test_presses.button,TRUE
0.04,limit,50
"""


@pytest.fixture
def stimulated(tmp_path):
    (tmp_path / "stimuli").mkdir()
    (tmp_path / "stimuli" / "presses.csv").write_text(PRESSES)
    (tmp_path / "test_s.st").write_text(STIMULATED % 2)
    return tmp_path / "test_s.st"


def test_a_test_names_its_stimulus_file(stimulated, capsys, monkeypatch):
    monkeypatch.chdir(stimulated.parent.parent)  # the file is looked for beside the test, not here
    assert main(["test", str(stimulated)]) == 0 and "2 passed" in capsys.readouterr().out
    stimulated.write_text(STIMULATED % 3)
    assert main(["test", str(stimulated)]) == 1
    out = capsys.readouterr().out
    assert "ASSERT_EQ failed: presses: expected 3, actual 2" in out and "1 failed, 1 passed" in out


@pytest.mark.parametrize(
    "rows, said",
    [
        ("1ms,buton,TRUE", "presses.csv:2: unknown variable 'buton'"),
        ("1ms,button,5", "presses.csv:2: test_presses.button is BOOL"),
        ("soon,button,TRUE", "presses.csv:2: 'soon' is not a duration"),
    ],
)  # fmt: skip
def test_a_wrong_stimulus_fails_its_test_alone(stimulated, capsys, rows, said):
    (stimulated.parent / "stimuli" / "presses.csv").write_text(f"time,variable,value\n{rows}\n")
    assert main(["test", str(stimulated)]) == 1
    out = capsys.readouterr().out
    assert said in out and "1 failed, 1 passed" in out and "Traceback" not in out


def test_a_stimulus_file_that_is_missing_or_of_no_use(stimulated, capsys):
    (stimulated.parent / "stimuli" / "presses.csv").unlink()
    assert main(["test", str(stimulated)]) == 1
    assert "presses.csv: No such file or directory" in capsys.readouterr().out
    stimulated.write_text("{attribute 'test'}\n{attribute 'stimuli' := 'a.csv'}\nFUNCTION f : BOOL\nEND_FUNCTION\n")
    assert main(["test", str(stimulated)]) == 1
    assert "make the test a PROGRAM" in capsys.readouterr().out


METHODS = """\
FUNCTION_BLOCK Valve
VAR isOpen : BOOL; count : INT; END_VAR
METHOD Open : BOOL
IF isOpen THEN
  RETURN;
END_IF
isOpen := TRUE;
count := count + 1;
Open := TRUE;
END_METHOD
METHOD Never
count := 0;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK ABSTRACT Fixture
VAR v : Valve; END_VAR
{attribute 'test'}
METHOD starts_closed
ASSERT(NOT v.isOpen, 'closed');
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Opening EXTENDS Fixture
VAR first : INT := 1; END_VAR
{attribute 'test'}
METHOD opens_once
ASSERT(v.Open(), 'first');
ASSERT(NOT v.Open(), 'second');
ASSERT_EQ(first, v.count);
END_METHOD
{attribute 'test'}
METHOD counts : BOOL
ASSERT_EQ(0, v.count, 'fresh');
v.Open();
ASSERT_EQ(2, v.count, 'twice');
END_METHOD
{attribute 'test'}
METHOD with_input
VAR_INPUT x : INT; END_VAR
END_METHOD
{attribute 'test'}
METHOD with_result : STRING
END_METHOD
{attribute 'test'} {attribute 'stimuli' := 'x.csv'}
METHOD with_stimuli
END_METHOD
END_FUNCTION_BLOCK
"""


@pytest.fixture
def methods(tmp_path, monkeypatch) -> Path:
    (tmp_path / "test_methods.st").write_text(METHODS)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_methods_that_are_tests(methods):
    file = TestFile(methods / "test_methods.st")
    results = {t.name: file.run(t) for t in file.tests}
    assert [n for n, r in results.items() if r.passed] == ["Opening.starts_closed", "Opening.opens_once"]
    failed = results["Opening.counts"]
    assert (failed.assertion.expected, failed.assertion.actual, failed.line) == ("2", "1", 34)
    assert results["Opening.with_input"].message == "a test takes no parameters"
    assert "does not return STRING" in results["Opening.with_result"].message
    assert "a METHOD is called once" in results["Opening.with_stimuli"].message


def test_methods_in_reports_and_coverage(methods, capsys):
    assert main(["test", "-k", "opens_once or starts", "--junit", "o.xml", "--coverage", "--lcov", "o.info"]) == 0
    out = capsys.readouterr().out
    assert "2 passed" in out and "5/6" in out  # of the statements of Valve; the tests themselves do not count
    cases = ElementTree.parse("o.xml").getroot().iter("testcase")
    assert [c.get("name") for c in cases] == ["Opening.starts_closed", "Opening.opens_once"]
    assert "DA:12,0" in Path("o.info").read_text() and "DA:9,1" in Path("o.info").read_text()

"""The pytest plugin, run by a pytest of its own."""

import subprocess
import sys
from xml.etree import ElementTree

import pytest

from plcruntime import PLC, UsageError
from plcruntime.golden import GoldenMismatch

PROGRAM = """\
PROGRAM PLC_PRG
VAR n : INT; x : LREAL; done : BOOL; txt : STRING := 'abc'; END_VAR
n := n + 1;
x := x + 0.5;
done := n > 10;
END_PROGRAM
"""
PYTHON = """\
def test_fresh(plc):
    p = plc("prog.st")
    assert p["n"] == 0
    p.run("20ms")
    assert p["n"] == 20
    assert plc("prog.st")["n"] == 0

def test_bad(plc):
    p = plc("prog.st", interval="10ms")
    p.run_until("done AND x > 1.0")
    assert p["PLC_PRG.n"] == 12

def test_fault(plc):
    p = plc("PROGRAM A\\nVAR x, y : INT; END_VAR\\nx := x + 1;\\nIF x > 4 THEN y := x / y; END_IF\\nEND_PROGRAM")
    assert p["x"] == 0
    p.run("10ms")
"""
GOLDEN = """\
def test_golden(plc):
    p = plc("prog.st")
    trace = p.trace("n", "x")
    p.run("10ms")
    plc.golden(trace, "golden/run.csv")
"""
ST = """\
{attribute 'test'}
FUNCTION test_good : BOOL
ASSERT(TRUE);
END_FUNCTION
{attribute 'test'}
FUNCTION test_wrong : BOOL
ASSERT_EQ(1, 2, 'numbers');
END_FUNCTION
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "prog.st").write_text(PROGRAM)
    return tmp_path


def run(folder, *arguments: str) -> tuple[int, str]:
    """Without the plugin of hypothesis, which takes four times as long to load as all the rest."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:hypothesispytest", *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)
    return done.returncode, done.stdout + done.stderr


def test_fixture_and_reports(folder):
    (folder / "test_prog.py").write_text(PYTHON)
    code, out = run(folder, "--plc-trace-on-fail", "traces")
    assert code == 1 and "2 failed, 1 passed" in out
    rows = [line.split() for line in out.splitlines()]
    assert ["0.1", "s", "TRUE", "5.5", "11"] in rows  # the last scan: done, x, n
    assert ["now", "TRUE", "5.5", "11"] in rows
    assert "fault F0102" in out and "in A, in scan 4" in out
    written = sorted(p.name for p in (folder / "traces").iterdir())
    assert written == ["test_prog.py_test_bad.csv", "test_prog.py_test_fault.csv"]
    head, *lines = (folder / "traces" / "test_prog.py_test_bad.csv").read_text().splitlines()
    assert head == "time,PLC_PRG.done,PLC_PRG.x,PLC_PRG.n" and len(lines) == 11


USED_WRONGLY = """\
import pytest
@pytest.mark.parametrize("use", [
    lambda p: p["nn"], lambda p: p.run_until("n < 0", timeout="20ms"), lambda p: p.__setitem__("n", 70000),
    lambda p: p.run_until("n <"), lambda p: p.run("1x"),
])
def test_wrong(plc, use):
    use(plc("prog.st"))

def test_model(plc):
    p = plc("prog.st")
    p.on_scan(lambda: int("a model that fails"))
    p.scan()
"""


def test_a_failing_test_is_shown_down_to_its_own_line(folder):
    (folder / "test_prog.py").write_text(USED_WRONGLY)
    code, out = run(folder)
    assert code == 1 and "6 failed" in out
    assert "PathError: unknown variable 'nn'" in out and "'n < 0' was not reached within 20 ms" in out
    assert "not in -32768..32767" in out and "a value is missing before the end" in out and "not a duration" in out
    shown, _, model = out.partition("test_model")
    assert "plcruntime/" not in shown and "stcore/" not in shown
    assert "a model that fails" in model


def test_st_files_are_collected(folder):
    (folder / "test_st.st").write_text(ST)
    (folder / "test_broken.st").write_text("{attribute 'test'}\nFUNCTION f : BOOL\nf := y;\nEND_FUNCTION\n")
    code, out = run(folder, "test_st.st", "-vv")
    assert code == 1 and "1 failed, 1 passed" in out
    assert "test_st.st::test_good PASSED" in out
    assert "test_st.st:7: test_wrong: ASSERT_EQ failed: numbers: expected 1, actual 2" in out
    assert ">    7 | ASSERT_EQ(1, 2, 'numbers');" in out
    code, out = run(folder, "test_broken.st")
    assert code == 2 and "E0301" in out and "Traceback" not in out


def test_golden_is_recorded_then_compared(folder):
    (folder / "test_golden.py").write_text(GOLDEN)
    code, out = run(folder)
    assert code == 1 and "--plc-record writes it" in out
    assert run(folder, "--plc-record")[0] == 0
    assert run(folder)[0] == 0
    (folder / "prog.st").write_text(PROGRAM.replace("x + 0.5", "x + 0.5 + SEL(n > 6, 0.0, 1.0)"))
    code, out = run(folder)
    assert code == 1
    assert "PLC_PRG.x: 4 scans differ, by 4 at most" in out
    assert "0.006 s               3.5               4.5  <" in out
    assert "PLC_PRG.n:" not in out


# ----------------------------------------------------------------------------------------------- comparing


COVERED = """\
PROGRAM PLC_PRG
VAR n, i : INT; END_VAR
n := Twice(n) + 1;
IF n > 5 THEN
  n := 0;
END_IF
FOR i := 1 TO n - 4 DO
  n := n;
END_FOR
END_PROGRAM
"""
TWICE = """\
FUNCTION Twice : INT
VAR_INPUT a : INT; END_VAR
IF a > 100 THEN
  Twice := 200;
  RETURN;
END_IF
Twice := 2 * a;
END_FUNCTION
"""
COVERED_TESTS = """\
def test_one(plc):
    plc("covered.st").scan(2)

def test_two(plc):
    p = plc("covered.st")
    p.scan(1)
    p.reset("cold")
    p.scan(1)
    assert p["n"] == 1
"""
COVERED_ST = """\
{attribute 'test'}
FUNCTION test_twice : BOOL
ASSERT_EQ(6, Twice(3));
END_FUNCTION
"""


def test_coverage_of_all_tests_together(folder):
    (folder / "covered.st").write_text(COVERED)
    (folder / "Twice.st").write_text(TWICE)
    (folder / "test_covered.py").write_text(COVERED_TESTS)
    (folder / "test_twice.st").write_text(COVERED_ST)
    code, out = run(folder, "--plc-cov", "--plc-lcov", "out.info", "--plc-cobertura", "out.xml")
    assert code == 0 and "3 passed" in out and "coverage of ST" in out
    rows = [" ".join(line.split()) for line in out.splitlines()]
    assert "Twice.st 4 50 % 2/4 50 % 1/2 - - 4-5" in rows
    assert "covered.st 5 60 % 3/5 50 % 1/2 - 50 % 1/2 5, 8" in rows
    lines = (folder / "out.info").read_text().splitlines()
    twice = lines[lines.index(f"SF:{folder / 'Twice.st'}") :]
    twice = twice[: twice.index("end_of_record")]
    assert {"DA:3,5", "DA:4,0", "DA:5,0", "DA:7,5", "LF:4", "LH:2", "BRF:2", "BRH:1"} <= set(twice)
    program = lines[lines.index(f"SF:{folder / 'covered.st'}") :]
    # n is 1, 3, 1 and, after the reset, 1
    assert {"DA:3,4", "DA:4,4", "DA:5,0", "DA:7,4", "DA:8,0", "LH:3", "LF:5"} <= set(program)
    root = ElementTree.parse(folder / "out.xml").getroot()
    assert (root.get("lines-covered"), root.get("lines-valid")) == ("5", "9")


def test_coverage_of_parallel_processes_is_added_up(folder):
    pytest.importorskip("xdist")
    (folder / "covered.st").write_text(COVERED)
    (folder / "Twice.st").write_text(TWICE)
    (folder / "test_covered.py").write_text(COVERED_TESTS)
    (folder / "test_twice.st").write_text(COVERED_ST)
    # every process runs every test: twice the counts of one alone
    code, out = run(folder, "-n", "2", "--dist", "each", "--plc-cov", "--plc-lcov", "out.info")
    assert code == 0 and "6 passed" in out
    rows = [" ".join(line.split()) for line in out.splitlines()]
    assert "Twice.st 4 50 % 2/4 50 % 1/2 - - 4-5" in rows
    assert "covered.st 5 60 % 3/5 50 % 1/2 - 50 % 1/2 5, 8" in rows
    twice = (folder / "out.info").read_text().splitlines()
    assert {"DA:3,10", "DA:4,0", "DA:7,10", "DA:3,8", "DA:7,8", "DA:8,0", "LH:2", "LH:3"} <= set(twice)


def test_a_program_given_as_text_finds_what_lies_beside_the_test(folder):
    (folder / "Twice.st").write_text(TWICE)
    text = "PROGRAM P\\nVAR n, a : INT := 4; END_VAR\\nn := Twice(a);\\nEND_PROGRAM"
    (folder / "inputs.csv").write_text("time,variable,value\n#2,a,5\n")
    body = f'p = plc("{text}")\n    p.stimuli("inputs.csv")\n    p.scan(%d)\n    assert p["n"] == %d\n'
    (folder / "test_text.py").write_text("".join(f"def test_{k[0]}(plc):\n    {body % k}" for k in ((2, 8), (3, 10))))
    code, out = run(folder.parent, str(folder))  # not from the folder itself
    assert code == 0 and "2 passed" in out


def test_errors_of_the_source_are_shown_without_our_frames(folder):
    text = 'def test_wrong(plc):\n    plc("PROGRAM A\\ny := 1;\\nEND_PROGRAM", strict=True)\n'
    (folder / "test_wrong.py").write_text(text)
    code, out = run(folder)
    assert code == 1 and "error E0301: y is not declared" in out and "2 | y := 1;" in out
    assert "stcore/" not in out and "build(" not in out


def test_coverage_that_cannot_be_written(folder):
    code, out = run(folder, "--plc-lcov", "no/out.info")
    assert code == 4 and "--plc-lcov no/out.info: there is no folder no" in out and "Traceback" not in out


@pytest.fixture
def trace(folder):
    plc = PLC.load(folder / "prog.st")
    made = plc.trace("n", "x", "done")
    plc.scan(20)
    made.to_csv(folder / "gold.csv")
    return made


def change(folder, line: int, column: int, text: str) -> None:
    rows = [row.split(",") for row in (folder / "gold.csv").read_text().splitlines()]
    rows[line][column] = text
    (folder / "gold.csv").write_text("\n".join(map(",".join, rows)) + "\n")


def test_equal(trace, folder):
    trace.compare(folder / "gold.csv")


def test_tolerances(trace, folder):
    change(folder, 5, 2, "2.6")
    with pytest.raises(GoldenMismatch, match=r"PLC_PRG.x: 1 scans differ, by 0.1 at most"):
        trace.compare(folder / "gold.csv")
    trace.compare(folder / "gold.csv", 0.2)
    trace.compare(folder / "gold.csv", tolerances={"plc_prg.X": 0.11})
    with pytest.raises(GoldenMismatch, match="allowed 0.05"):
        trace.compare(folder / "gold.csv", tolerances={"PLC_PRG.x": 0.05})
    with pytest.raises(UsageError, match="does not have"):
        trace.compare(folder / "gold.csv", tolerances={"PLC_PRG.y": 1})


def test_bool_columns_and_lengths(trace, folder):
    change(folder, 3, 3, "1")
    lines = (folder / "gold.csv").read_text().splitlines()
    (folder / "gold.csv").write_text("\n".join(lines[:-2]) + "\n")
    with pytest.raises(GoldenMismatch) as error:
        trace.compare(folder / "gold.csv")
    assert "20 scans, recorded were 18" in str(error.value)
    assert "PLC_PRG.done: 1 scans differ" in str(error.value)


def test_other_columns(folder, trace):
    plc = PLC.load(folder / "prog.st")
    other = plc.trace("n")
    plc.scan(20)
    with pytest.raises(GoldenMismatch, match="not traced now: PLC_PRG.x, PLC_PRG.done"):
        other.compare(folder / "gold.csv")


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n", "time,x\n1\n"])
def test_bad_files(trace, folder, text):
    (folder / "bad.csv").write_text(text)
    with pytest.raises(UsageError, match="no recorded trace"):
        trace.compare(folder / "bad.csv")
    with pytest.raises(UsageError, match="no golden trace"):
        trace.compare(folder / "missing.csv")

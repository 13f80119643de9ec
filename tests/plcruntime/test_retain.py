"""The retain file: over processes, over changes of the program, and against everything that may happen to a file."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from plcruntime import PLC, UsageError
from plcruntime.retain import MAGIC

ROOT = Path(__file__).resolve().parents[2]
MOVER = """FUNCTION_BLOCK Mover
VAR RETAIN trips : DINT; END_VAR
VAR PERSISTENT life : DINT; END_VAR
VAR step : INT; END_VAR
trips := trips + 1; life := life + 2; step := step + 3;
END_FUNCTION_BLOCK
"""
PROGRAM = MOVER + """PROGRAM PLC_PRG
VAR movers : ARRAY[1..2] OF Mover; n : DINT; END_VAR
VAR RETAIN text : STRING(10) := 'new'; grid : ARRAY[0..1, 1..2] OF INT; flag AT %MX0.3 : BOOL; whole : Mover; END_VAR
VAR_GLOBAL_PLACE
n := n + 1;
movers[2](); whole();
END_PROGRAM
""".replace("VAR_GLOBAL_PLACE\n", "")


def load(path, source=PROGRAM) -> PLC:
    return PLC.load(source, retain=path)


def declared(lines: str, types: str = "") -> str:
    return f"{types}\nPROGRAM PLC_PRG VAR RETAIN {lines} END_VAR END_PROGRAM\n"


@pytest.fixture
def file(tmp_path) -> Path:
    return tmp_path / "plc.retain"


def test_over_processes(file):
    with load(file) as plc:
        assert plc["text"] == "new" and not file.exists()
        plc["text"], plc["grid"], plc["flag"] = "äöü", [[1, 2], [3, 4]], True
        plc.scan(5)
    again = load(file)
    assert (again["text"], again["grid"], again["flag"], again["%MB0"]) == ("äöü", [[1, 2], [3, 4]], True, 8)
    assert [m["trips"] for m in again["movers"]] == [0, 5] and again["movers[2].life"] == 10
    assert again["n"] == 0 and again["movers[2].step"] == 0 and again["whole.step"] == 15 and again.scans == 0
    assert again.retain.report.sentences() == []


def test_resets_reach_the_file(file):
    plc = load(file)
    plc.run("5ms")
    assert load(file)["movers[2].trips"] == 5  # the end of a run saves
    plc.reset("cold")
    again = load(file)
    assert (again["movers[2].trips"], again["movers[2].life"], again["whole.life"]) == (0, 10, 10)
    assert again["whole.step"] == 0 and again["text"] == "new"
    plc.reset("origin")
    assert load(file)["whole.life"] == 0
    plc.scan(2)
    plc.power_cycle()
    assert load(file)["whole.life"] == plc["whole.life"] == 4


def test_a_bit_is_kept_without_its_neighbours(file):
    plc = load(file)
    plc["%MB0"] = 0xFF
    plc.power_cycle()
    assert plc["%MB0"] == 8 and load(file)["%MB0"] == 8


def test_saving_while_it_runs(file):
    plc = load(file)
    plc.scan(3)
    assert not file.exists()  # not a second yet
    plc.retain.every = plc.retain._next = 0.0
    plc.scan(1)
    assert load(file)["whole.trips"] == 4
    before = file.stat().st_mtime_ns
    plc.retain.save()
    assert file.stat().st_mtime_ns == before  # nothing changed


def test_python_ends(file, tmp_path):
    script = f"from plcruntime import PLC; plc = PLC.load({PROGRAM!r}, retain={str(file)!r}); plc.scan(7)"
    subprocess.run([sys.executable, "-c", script], env={**os.environ, "PYTHONPATH": str(ROOT)}, check=True, timeout=60)
    assert load(file)["whole.trips"] == 7


CHANGES = [
    # before, value, after, expected
    ("x : INT;", -5, "x : DINT;", -5),
    ("x : DINT;", 200, "x : USINT;", 200),
    ("x : DINT;", 7, "x : LREAL;", 7.0),
    ("x : REAL;", 0.1, "x : LREAL;", 0.10000000149011612),
    ("x : LREAL;", 0.5, "x : REAL;", 0.5),
    ("x : WORD;", 0xFFFF, "x : UINT;", 0xFFFF),
    ("x : TIME;", 1.5, "x : LTIME;", 1.5),
    ("x : LTIME;", 1.5, "x : TIME;", 1.5),
    ("x : DATE;", 86400, "x : LDATE;", 86400.0),
    ("x : STRING(5);", "abcde", "x : STRING(40);", "abcde"),
    ("x : STRING(40);", "abc", "x : STRING(3);", "abc"),
    ("x : ARRAY[1..3] OF INT;", [1, 2, 3], "x : ARRAY[2..5] OF DINT := [4(9)];", [2, 3, 9, 9]),
    ("x : ARRAY[1..2] OF STRING(3);", ["a", "b"], "x : ARRAY[1..2] OF STRING(9);", ["a", "b"]),
    ("y : INT; x : BOOL;", True, "x : BOOL; z : LREAL;", True),
    ("x : INT(0..10);", 9, "x : INT(0..9);", 9),
]


@pytest.mark.parametrize("before, value, after, expected", CHANGES)
def test_changed_programs_find_their_values(file, before, value, after, expected):
    with load(file, declared(before)) as plc:
        plc["x"] = value
    old = file.read_bytes()
    plc = load(file, declared(after))
    assert plc["x"] == expected
    assert plc.retain.report.sentences() or before == after
    assert file.read_bytes() == old
    plc.save_retain()
    assert file.with_name(file.name + ".bak").read_bytes() == old
    assert load(file, declared(after))["x"] == expected


REFUSALS = [
    ("x : DINT;", 70000, "x : INT;", "x was DINT and is INT, which can't hold 70000"),
    ("x : LREAL;", 0.1, "x : REAL;", "can't hold 0.1 exactly"),
    ("x : LREAL;", 1e300, "x : REAL;", "can't hold 1e+300"),
    ("x : LREAL;", 0.5, "x : DINT;", "can't hold 0.5"),
    ("x : INT;", 1, "x : BOOL;", "x was INT and is BOOL"),
    ("x : BOOL;", True, "x : INT;", "x was BOOL and is INT"),
    ("x : STRING(9);", "abcdef", "x : STRING(3);", "too short for a text of 6 characters"),
    ("x : STRING(9);", "abc", "x : WSTRING(9);", "was STRING(9) and is WSTRING(9)"),
    ("x : STRING(9);", "abc", "x : INT;", "was STRING(9) and is INT"),
    ("x : TIME;", 1.0, "x : DINT;", "was TIME and is DINT"),
    ("x : LTIME;", 1e-9, "x : TIME;", "can't hold it exactly"),
    ("x : INT(0..10);", 9, "x : INT(0..5);", "was INT(0..10) and is INT(0..5), which can't hold 9"),
    ("x : INT;", 9, "other : INT;", "of another program"),
]


@pytest.mark.parametrize("before, value, after, words", REFUSALS)
def test_what_does_not_fit_is_refused(file, before, value, after, words):
    with load(file, declared(before)) as plc:
        plc["x"] = value
    old = file.read_bytes()
    with pytest.raises(UsageError) as caught:
        load(file, declared(after))
    assert words in str(caught.value) and str(file) in str(caught.value) and file.read_bytes() == old


def test_labels_of_an_enum_count_not_their_numbers(file):
    before, after = "TYPE Mode : (idle, run, halt); END_TYPE", "TYPE Mode : (halt, idle, run := 9); END_TYPE"
    with load(file, declared("x : Mode;", before)) as plc:
        plc["x"] = "run"
    plc = load(file, declared("x : Mode;", after))
    assert plc["x"] == 9 and plc.show("x") == "run"
    with pytest.raises(UsageError, match="x was Mode and is Mode, which has no run"):
        load(file, declared("x : Mode;", "TYPE Mode : (halt, idle); END_TYPE"))


def test_structures_and_instances(file):
    before = "TYPE P : STRUCT a : INT; b : ARRAY[1..2] OF REAL; END_STRUCT END_TYPE"
    after = "TYPE P : STRUCT b : ARRAY[1..3] OF LREAL := [3(7.0)]; c : INT := 5; a : DINT; END_STRUCT END_TYPE"
    with load(file, declared("x : ARRAY[0..1] OF P; gone : INT;", before)) as plc:
        plc["x[1]"] = {"a": 3, "b": [0.5, 1.5]}
    plc = load(file, declared("x : ARRAY[0..1] OF P;", after))
    assert plc["x[1]"] == {"b": [0.5, 1.5, 7.0], "c": 5, "a": 3}
    text = "\n".join(plc.retain.report.sentences())
    assert "PLC_PRG.gone" in text and "PLC_PRG.x[1].c" in text and "PLC_PRG.x[0].a (INT to DINT)" in text


def test_unions_and_pointers(file):
    union = "TYPE U : UNION r : REAL; d : DWORD; END_UNION END_TYPE"
    with load(file, declared("x : U; p : POINTER TO INT; n : INT;", union)) as plc:
        plc["x.r"], plc["p"] = 1.0, plc.place("n").address
    assert load(file, declared("x : U; p : POINTER TO INT; n : INT;", union))["p"] != 0
    plc = load(file, declared("x : U; p : POINTER TO INT; n : INT; more : INT;", union))
    assert plc["x.d"] == 0x3F800000 and plc["p"] == 0
    with pytest.raises(UsageError, match="x was UNION"):
        load(file, declared("x : U; n : INT;", union.replace("DWORD", "DINT")))


def test_damaged_files(file):
    with load(file) as plc:
        plc.scan(3)
    whole = file.read_bytes()
    for k in range(0, len(whole), 7):
        file.write_bytes(whole[:k] + bytes([whole[k] ^ 1]) + whole[k + 1 :])
        with pytest.raises(UsageError, match="damaged|no retain file"):
            load(file)
    for k in (0, 5, len(MAGIC), len(MAGIC) + 8, len(whole) // 2, len(whole) - 1):
        file.write_bytes(whole[:k])
        with pytest.raises(UsageError, match="damaged|no retain file"):
            load(file)
    file.write_bytes(whole)
    assert load(file)["whole.trips"] == 3


def test_places_that_can_not_be_used(tmp_path, monkeypatch):
    with pytest.raises(UsageError, match="is a folder"):
        load(tmp_path)
    with pytest.raises(UsageError, match="there is no folder"):
        load(tmp_path / "nope" / "plc.retain")
    plc = load(tmp_path / "plc.retain")
    plc.scan(2)

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(UsageError, match="can't be written: No space left"):
        plc.save_retain()
    assert list(tmp_path.iterdir()) == []
    plc.retain._next = 0.0
    plc.scan()  # a run goes on; the problem is told at its end
    assert "No space left" in plc.retain.problem
    monkeypatch.undo()
    plc.save_retain()
    assert plc.retain.problem == "" and load(tmp_path / "plc.retain")["whole.trips"] == 3


def test_a_program_without_such_variables(tmp_path):
    with PLC.load("PROGRAM PLC_PRG VAR n : INT; END_VAR n := n + 1; END_PROGRAM", retain=tmp_path / "r") as plc:
        plc.run("5ms")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_kill_at_any_moment(file):
    """Each child counts, saves after every scan and tells so; it is killed at a random moment within its work."""
    script = Path(__file__).parent / "kill_retain.py"
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, script, file, "200"], env=env, capture_output=True, text=True, timeout=100, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    kills, told, last = map(int, done.stdout.split())
    assert kills == 200 and told > 200 and last >= told

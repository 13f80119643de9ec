"""The Python API with compiled programs: what the fake machine of the other tests can't show."""

import pytest

from plcruntime import PLC, CompileError, ConditionTimeout, Fault, PathError

BLOCKS = """
TYPE Point : STRUCT x : LREAL; y : INT; END_STRUCT END_TYPE
FUNCTION_BLOCK Mover
VAR_IN_OUT at : Point; END_VAR
VAR_INPUT step : LREAL; END_VAR
VAR RETAIN trips : DINT; END_VAR
VAR PERSISTENT life : DINT; END_VAR
VAR seen : REFERENCE TO Point; END_VAR
seen REF= at;
at.x := at.x + step;
trips := trips + 1;
life := life + 1;
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR
  here : Point; mover : Mover; p : POINTER TO Point; grid : ARRAY[0..1, -1..1] OF INT := [1, 2, 3, 4, 5, 6];
  button AT %IX0.3 : BOOL; lamp AT %QX1.0 : BOOL; word AT %MW4 : WORD; n : DINT; pause : TON; d : DT;
  s : STRING := 'Grüße'; ws : WSTRING := "日本"; small : INT(0..10) := 3; k : LINT;
END_VAR
VAR CONSTANT top : INT := 7; END_VAR
mover(at := here, step := 0.5);
p := ADR(here);
lamp := button;
n := n + 1;
pause(IN := n MOD 50 < 40, PT := T#20ms);
k := k * 6364136223846793005 + 1442695040888963407;
END_PROGRAM
"""
GLOBALS = """VAR_GLOBAL limit : INT := 5; END_VAR
VAR_GLOBAL CONSTANT most : INT := 9; END_VAR
"""


@pytest.fixture
def plc() -> PLC:
    return PLC.load(BLOCKS)


def test_values_of_a_program(plc):
    plc.scan()
    assert plc["here"] == {"x": 0.5, "y": 0} and plc["p^.x"] == 0.5 and plc["mover.at.x"] == 0.5
    assert plc["mover.seen.x"] == 0.5 and plc["mover.seen"] == plc["here"]
    assert plc["grid"] == [[1, 2, 3], [4, 5, 6]] and plc["grid[1,-1]"] == 4
    assert plc["s"] == "Grüße" and plc["ws"] == "日本" and plc["small"] == 3
    plc["mover.at.x"] = 10
    plc.scan()
    assert plc["here.x"] == 10.5
    plc["d"] = 86400 * 365
    plc["s"], plc["ws"], plc["grid"] = "ä", "ö", [[0] * 3] * 2
    plc.scan()
    assert plc["d"] == 31536000.0 and plc["s"] == "ä" and plc["ws"] == "ö" and plc["grid"] == [[0] * 3] * 2
    with pytest.raises(ValueError, match=r"0\.\.10"):
        plc["small"] = 11
    with pytest.raises(PathError, match="NULL"):
        PLC.load(BLOCKS)["mover.at.x"]


def test_direct_addresses(plc):
    plc["%IX0.3"] = True
    plc.scan()
    assert plc["button"] is True and plc["lamp"] is True and plc["%QX1.0"] is True and plc["%QB1"] == 1
    plc["word"] = 0x1234
    assert plc["%MW4"] == 0x1234 and plc["%MB8"] == 0x34 and plc["%MW4.2"] is True


def test_force_of_a_bit_is_seen_by_the_program(plc):
    trace = plc.trace("lamp", "button")
    plc.force("%IX0.3", True)
    plc["%IB0"] = 0
    plc.scan(3)
    assert trace["lamp"].tolist() == trace["button"].tolist() == [True] * 3
    plc.unforce()
    plc["%IB0"] = 0
    plc.scan()
    assert plc["lamp"] is False


def test_a_forced_bit_leaves_its_neighbours():
    declarations = "VAR w AT %QW0 : WORD; n : UINT; END_VAR"
    plc = PLC.load(f"PROGRAM PLC_PRG {declarations} n := n + 1; w := UINT_TO_WORD(n); END_PROGRAM")
    trace = plc.trace("w")
    plc.force("w.3", True)
    plc.force("w.0", False)
    plc.scan(500)
    assert trace["w"].tolist() == [n & ~1 | 8 for n in range(1, 501)]
    plc.unforce("w.3")
    plc.scan()
    assert plc["w"] == 500 and plc.forced == ["PLC_PRG.w.0"]


def test_global_lists(tmp_path):
    (tmp_path / "GVL.st").write_text(GLOBALS)
    (tmp_path / "main.st").write_text("PROGRAM PLC_PRG VAR x : INT; END_VAR x := limit + most; END_PROGRAM")
    plc = PLC.load(tmp_path)
    plc["limit"] = 6
    plc.scan()
    assert plc["x"] == 15 and plc["GVL.limit"] == 6
    assert plc.place("limit").name == "GVL.limit"
    with pytest.raises(ValueError, match="constant"):
        plc["GVL.most"] = 3


def test_conditions(plc):
    assert plc.run_until("n >= 7 AND PLC_PRG.here.x > 1.0") == 0.007
    assert plc.run_until("pause.Q", timeout="1s") == pytest.approx(0.021)
    with pytest.raises(ConditionTimeout) as caught:
        plc.run_until("n < 0", timeout="5ms")
    assert caught.value.values == {"PLC_PRG.n": str(plc["n"])}
    with pytest.raises(CompileError):
        plc.run_until("nothing > 3")
    for scans in (30, 31, 200, 1000, 1001):
        plc.run_until(f"n = {scans}")
        assert plc.scans == scans


def test_traces_and_going_back(plc):
    trace = plc.trace("n", "here", "pause.Q")
    assert trace.names == ["PLC_PRG.n", "PLC_PRG.here.x", "PLC_PRG.here.y", "PLC_PRG.pause.Q"]
    images = {}
    for _ in range(120):
        if plc.scans % 17 == 0:
            plc["here.y"] = plc.scans
        plc.scan()
        images[plc.scans] = plc.variables()
    plc.back(75)
    assert plc.scans == 45 and plc.variables() == images[45] and len(trace) == 45
    plc.run("10ms")
    assert trace["n"].tolist() == list(range(1, 56)) and trace.time[-1] == 0.054
    assert trace["here.y"].tolist()[:52] == [17 * (k // 17) for k in range(51)] + [34]


def test_two_runs_are_the_same_bytes():
    def image():
        plc = PLC.load(BLOCKS)
        plc.schedule("%IX0.3", True, at="30ms")
        plc.run("2s")
        return bytes(plc.snapshot().image)

    assert image() == image()


def test_retain(plc):
    plc.scan(5)
    plc.power_cycle()
    assert (plc["mover.trips"], plc["mover.life"], plc["here.x"], plc["n"]) == (5, 5, 0.0, 0)
    plc.scan()
    plc.reset("cold")
    assert (plc["mover.trips"], plc["mover.life"]) == (0, 6)
    plc.reset("origin")
    assert (plc["mover.trips"], plc["mover.life"], plc["grid[0,0]"]) == (0, 0, 2)


FAULTS = {
    "F0101": "a[i] := 1;",
    "F0102": "i := 5 / (i - 9);",
    "F0103": "i := p^;",
    "F0104": "p := 16#7FFFFFF0; i := p^;",
    "F0105": "i := Deeper(i);",
    "F0108": "WHILE i > 0 DO i := 9; END_WHILE",
}


@pytest.mark.parametrize("code", FAULTS)
def test_faults(code):
    source = (
        "FUNCTION Deeper : INT VAR_INPUT n : INT; END_VAR Deeper := Deeper(n) + 1; END_FUNCTION\n"
        "FUNCTION_BLOCK Inner VAR i : INT := 9; a : ARRAY[1..5] OF INT; p : POINTER TO INT; END_VAR\n"
        f"{FAULTS[code]}\nEND_FUNCTION_BLOCK\n"
        "PROGRAM PLC_PRG VAR inner : Inner; n : INT; END_VAR\nn := n + 1;\nIF n = 4 THEN inner(); END_IF\nEND_PROGRAM\n"
    )
    plc = PLC.load(source, watchdog=0.3)
    with pytest.raises(Fault):
        plc.run("1s")
    fault = plc.fault
    assert (fault.code, fault.scan, plc.scans) == (code, 3, 3)
    assert fault.line == (1 if code == "F0105" else 3)
    assert code == "F0105" or fault.instance.startswith("PLC_PRG.inner")
    assert plc["n"] == 4
    plc.back(1)
    assert plc["n"] == 3 and plc.fault is None
    plc["n"] = 10
    plc.run("5ms")
    assert plc.scans == 8


def test_compile_errors():
    with pytest.raises(CompileError) as caught:
        PLC.load("PROGRAM PLC_PRG\nVAR x : INT; END_VAR\nx := y;\nEND_PROGRAM\n")
    assert caught.value.diagnostics[0].line == 3


def test_axes():
    plc = PLC.load(
        "PROGRAM PLC_PRG VAR axis : AXIS_REF_SM3; power : MC_Power; move : MC_MoveAbsolute; END_VAR\n"
        "power(Axis := axis, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);\n"
        "move(Axis := axis, Execute := power.Status, Position := 100, Velocity := 200, Acceleration := 1000, "
        "Deceleration := 1000);\nEND_PROGRAM\n"
    )
    plc.run_until("move.Done")
    axis = plc.axes[1]
    assert axis.position == 100.0 and axis.velocity == 0.0 and axis.status & 0x200
    assert plc["Axis[1].prfPos"] == 100.0  # of the simulator: the program's axis is no array
    axis.drive.alarm = True
    plc.run("10ms")
    assert plc["axis.bError"] is True
    plc.power_cycle()
    plc.run_until("move.Done")
    assert plc.axes[1].position == 100.0

"""Stimulus files: what they do, and what is wrong with one before anything has run."""

import pytest

from plcruntime import PLC, UsageError, stimulus_file

PROGRAM = """
TYPE Point : STRUCT x : LREAL; y : INT; END_STRUCT END_TYPE
PROGRAM PLC_PRG
VAR on : BOOL; n : DINT; r : LREAL; text : STRING(10); p : Point; a : ARRAY[1..3] OF INT; t : TIME; seen : DINT; END_VAR
VAR CONSTANT most : INT := 3; END_VAR
IF on THEN seen := seen + 1; END_IF
n := n + 1;
END_PROGRAM
"""
CSV = """# a comment
time,variable,value,force

10ms,on,TRUE,
0.02,PLC_PRG.on,FALSE
#25,r,1.5
T#30ms,n,7,force
40ms,n,,release
5ms,a,"[1,2,3]"
5ms,p,"(x := 0.5, y := 16#10)"
5ms,text,"'a,b'"
5ms,t,T#1s500ms,no
"""


@pytest.fixture
def plc() -> PLC:
    return PLC.load(PROGRAM)


@pytest.fixture
def write(tmp_path):
    def write(text: str, name: str = "s.csv"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_csv(plc, write):
    trace = plc.trace("n", "on", "r")
    assert plc.stimuli(write(CSV)) == 9
    plc.run("50ms")
    assert plc["a"] == [1, 2, 3] and plc["p"] == {"x": 0.5, "y": 16} and plc["text"] == "a,b" and plc["t"] == 1.5
    assert plc["seen"] == 10 and trace["on"].tolist() == [10 <= k < 20 for k in range(50)]
    assert trace["r"][24] == 0 and trace["r"][25] == 1.5
    assert trace["n"][29:42].tolist() == [30] + [7] * 10 + [8, 9] and not plc.forced


def test_semicolons(plc, write):
    plc.stimuli(write("\ufeffTime;Variable;Value\n5ms;a;[1,2,3]\n"))
    plc.run("10ms")
    assert plc["a"] == [1, 2, 3]


def test_toml(plc, write):
    text = """
    [[stimulus]]
    time = "10ms"
    variable = "on"
    value = true
    [[stimulus]]
    time = 0.02
    variable = "n"
    value = 16
    force = true
    [[stimulus]]
    time = "#30"
    variable = "n"
    release = true
    """
    trace = plc.trace("n")
    plc.stimuli(write(text, "s.toml"))
    plc.run("40ms")
    assert plc["seen"] == 30 and trace["n"][19:32].tolist() == [20] + [16] * 10 + [17, 18]


HEADER = "time,variable,value,force\n1ms,on,TRUE,\n"
WRONG = [
    (HEADER + "2ms,xStrat,1,", ["s.csv:3", "unknown variable 'xStrat'"]),
    (HEADER + "2ms,text,1,", ["s.csv:3", "PLC_PRG.text is STRING(10)"]),
    (HEADER + "2ms,n,1.5,", ["s.csv:3", "PLC_PRG.n is DINT"]),
    (HEADER + "2ms,a[9],1,", ["s.csv:3", "index 9 is not in 1..3"]),
    (HEADER + "2ms,most,1,", ["s.csv:3", "is a constant"]),
    (HEADER + "soon,n,1,", ["s.csv:3", "'soon' is not a duration"]),
    (HEADER + "-1,n,1,", ["s.csv:3", "not a duration"]),
    (HEADER + "2ms,n,,", ["s.csv:3", "the value of n is missing"]),
    (HEADER + "2ms,,1,", ["s.csv:3", "the variable is missing"]),
    (HEADER + "2ms,n,1,maybe", ["s.csv:3", "force is 'maybe'"]),
    (HEADER + "2ms,n,1,release", ["s.csv:3", "without a value"]),
    (HEADER + "2ms,a,[1,2,3],force", ["s.csv:3", "stands in quotes"]),
    ("time,variable\n", ["s.csv:1", "no column value"]),
    ("time,variable,value,colour\n", ["s.csv:1", "unknown column 'colour'"]),
    ("", ["no header"]),
]


@pytest.mark.parametrize("text, words", WRONG)
def test_mistakes_leave_nothing_scheduled(plc, write, text, words):
    with pytest.raises(UsageError) as caught:
        plc.stimuli(write(text))
    assert all(word in str(caught.value) for word in words), str(caught.value)
    assert "\n" not in str(caught.value)
    plc.run("10ms")
    assert plc["on"] is False and plc["n"] == 10


@pytest.mark.parametrize(
    "text, words",
    [
        ("[[stimulus]]\ntime='1ms'\nvariable='n'\nvalue=1\nforced=true", ["stimulus 1", "unknown key forced"]),
        ("[[stimulus]]\ntime='1ms'\nvariable='n'\nvalue=1\nforce=1", ["force is true or false"]),
        ("[[stimulus]]\ntime='1ms'\nvalue=1", ["the variable is missing"]),
        ("[stimulus]\ntime='1ms'", ["[[stimulus]]"]),
        ("[[stimulus", ["is not TOML"]),
    ],
)
def test_mistakes_in_toml(plc, write, text, words):
    with pytest.raises(UsageError) as caught:
        plc.stimuli(write(text, "s.toml"))
    assert all(word in str(caught.value) for word in words)


def test_files_that_can_not_be_read(plc, write, tmp_path):
    for path, words in ((tmp_path / "no.csv", "can't read"), (write("x", "s.txt"), "ends with .csv or .toml")):
        with pytest.raises(UsageError, match=words):
            plc.stimuli(path)
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe,")
    with pytest.raises(UsageError, match="not UTF-8"):
        plc.stimuli(tmp_path / "b.csv")


def test_many_stimuli(plc, write):
    plc.stimuli(write("time,variable,value\n" + "".join(f"#{k},r,{k}.5\n" for k in reversed(range(20_000)))))
    plc.run("#100")
    assert plc["r"] == 99.5 and sum(at >= plc.scans for at, _ in plc.scheduled) == 19_900


def test_going_back_over_stimuli(plc, write):
    plc.stimuli(write("time,variable,value\n10ms,on,TRUE\n20ms,on,FALSE\n"))
    plc.run("30ms")
    plc.back(15)
    assert plc["on"] is True and plc["seen"] == 5
    plc.run("15ms")
    assert plc["on"] is False and plc["seen"] == 10


AXIS = """PROGRAM PLC_PRG
VAR axis : AXIS_REF_SM3; power : MC_Power; move : MC_MoveVelocity; actual : LREAL; END_VAR
power(Axis := axis, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
move(Axis := axis, Execute := power.Status, Velocity := 100, Acceleration := 1000, Deceleration := 1000);
actual := axis.fActPosition;
END_PROGRAM
"""


def test_inputs_and_faults_of_a_simulated_axis(write):
    plc = PLC.load(AXIS)
    plc.stimuli(write("time,variable,value\n0.1,Axis[1].drive.lag,20\n0.5,Axis[1].switches.positive,TRUE\n"))
    plc.run("400ms")
    assert 1.0 < plc["axis.fSetPosition"] - plc["actual"] < 3.0  # 20 ms at 100 u/s
    plc.run("400ms")
    assert plc["axis.fSetVelocity"] == 0.0
    plc = PLC.load(AXIS)
    plc.stimuli(write("time,variable,value\n0.5,Axis[1].drive.alarm,TRUE\n0.6,SIM.Axis[1].switches.home,TRUE\n"))
    plc.run("700ms")
    assert plc["axis.bError"] is True and plc.axes[1].switches.home is True


def test_the_form_in_the_docstring(plc, write):
    example = "\n".join(line.strip() for line in stimulus_file.__doc__.splitlines()[4:8])
    plc = PLC.load(AXIS.replace("actual : LREAL", "actual : LREAL; start : BOOL"))
    assert plc.stimuli(write(example)) == 3

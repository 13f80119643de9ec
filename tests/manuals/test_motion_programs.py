"""The motion programs of the iDEABOX 3 manual as printed (10.3.8, 10.4), with the blanks that print lost."""

from pathlib import Path

import pytest

from mclib.motion_programs import files
from mclib.motion_programs.code import MotionError
from mclib.motion_programs.compiler import compile_motion
from plcruntime import PLC

LISTINGS = Path(__file__).parents[3] / "shared/manuals/listings"
pytestmark = pytest.mark.skipif(not LISTINGS.is_dir(), reason="the manuals' listings are not beside this checkout")

RUN = """
PROGRAM PLC_PRG
VAR
    first : BOOL := TRUE; rtn, fun : INT; sts : TThreadSts;
    bin : STRING := 'program.bin'; main : STRING := 'main';
END_VAR
IF first THEN
    rtn := GT_Download(ADR(bin));
    rtn := rtn + GT_GetFunId(ADR(main), ADR(fun)) + GT_Bind(0, fun, 0) + GT_RunThread(0);
    first := FALSE;
END_IF
GT_GetThreadSts(0, ADR(sts));
END_PROGRAM
"""


def text(name: str) -> str:
    return (LISTINGS / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["27_sum_single_thread.st", "28_sum_multi_thread.st"])
def test_10_1_and_10_2_sum_of_1_to_100(name, tmp_path):
    """'the program sum.bin lies in the project's folder'"""
    (tmp_path / "main.st").write_text(text(f"ideabox3/{name}"), encoding="utf-8")
    files.write(compile_motion(text("ideabox3/26_sum_motion.c")), tmp_path / "sum.c")
    plc = PLC.load(tmp_path / "main.st", interval="1ms")
    plc.scan(10)
    assert plc["SIM.refusals"] == 0
    assert plc["PLC_PRG.value"] == 5050.0
    assert plc["PLC_PRG.thread.run"] == 0 and plc["PLC_PRG.thread.result"] == 5050.0


def test_advanced_manual_compiles_it_itself_and_uses_dint(tmp_path):
    (tmp_path / "main.st").write_text(text("guc_ecat_advanced/18_sum_single_thread.st"), encoding="utf-8")
    # its own listing has lost the line breaks of its head, and with them the variable sum
    (tmp_path / "sum.c").write_text(text("ideabox3/26_sum_motion.c"), encoding="utf-8")
    plc = PLC.load(tmp_path / "main.st", interval="1ms")
    plc.scan(10)
    assert plc["SIM.refusals"] == 0
    assert plc["MAIN.value"] == 5050 and plc["MAIN.thread.result"] == 5050.0
    assert (tmp_path / "sum.bin").exists() and (tmp_path / "sum.ini").exists()


@pytest.mark.parametrize(
    ("name", "variable", "value"),
    [
        ("32_while_motion.c", "sum", 55), ("34_dowhile_motion.c", "sum", 55), ("36_for_motion.c", "sum", 55),
        ("38_ifelse_motion.c", "a", 5), ("40_switch_motion.c", "a", 5),
    ],
)  # fmt: skip
def test_10_4_3_flow_control(name, variable, value, tmp_path, monkeypatch):
    unit = compile_motion(text(f"ideabox3/{name}"))
    files.write(unit, tmp_path / "program.c")
    monkeypatch.chdir(tmp_path)
    plc = PLC.load(RUN, interval="1ms")
    plc.scan(5)
    assert plc["PLC_PRG.rtn"] == 0 and plc["PLC_PRG.sts.run"] == 0
    assert plc[f"GtMotion.globals[{unit.variables[variable].index}]"] == value
    if name.startswith("40"):
        assert plc["SimIo.gpo"] == 4  # a = 5: GT_SetDo(MC_GPO, 0x04)


@pytest.mark.parametrize("name", ["33_while", "35_dowhile", "37_for", "39_ifelse", "41_switch"])
def test_standard_c_is_refused(name):
    with pytest.raises(MotionError, match="not known in motion programs|no expression"):
        compile_motion(text(f"ideabox3/{name}_stdc.c"))


def test_every_parameter_must_be_written():
    body = text("ideabox3/25_getclock_motion_call.c")
    compile_motion("void f()\n{\n" + body + "}")
    with pytest.raises(MotionError, match="needs all its 2 parameters"):
        compile_motion("void f()\n{\n" + text("ideabox3/24_getclock_app_call.c") + "}")


def test_a_cast_and_conditional_jumps(tmp_path, monkeypatch):
    """10.4.1 (6) and 10.4.2 (5): three lines in a program around them."""
    cast = text("ideabox3/29_cast.c").strip() + ";"
    jump = text("ideabox3/30_if_goto.c")
    give = text("ideabox3/31_if_return.c").replace("value", "a")
    source = f"""
int a; double b; int var; int count;
int main()
{{
b = -7.75;
{cast}
var = 0;
label:
count = count + 1;
{give}
var = count < 3;
{jump}
var = 1;
{give}
return 0;
}}"""
    unit = compile_motion(source)
    files.write(unit, tmp_path / "program.c")
    monkeypatch.chdir(tmp_path)
    plc = PLC.load(RUN, interval="1ms")
    plc.scan(3)
    values = {name: plc[f"GtMotion.globals[{v.index}]"] for name, v in unit.variables.items()}
    assert values["a"] == -7 and values["count"] == 2  # the jump taken once, the return in the second pass
    assert plc["PLC_PRG.sts.result"] == -7.0
    for line in ("if(a > 1) goto label;", "if(a > 1) return a;"):
        with pytest.raises(MotionError, match="no expression"):
            compile_motion(f"int a; int f()\n{{\nlabel:\n{line}\nreturn a;\n}}")


def test_combined_motion_of_three_axes(tmp_path, monkeypatch):
    """guc20: arm, glue and piece wait for each other; the ST program only starts them."""
    unit = compile_motion(text("guc_ecat_advanced/20_combined_motion.c"))
    assert list(unit.functions) == ["ArmMotion", "GlueMotion", "PieceMotion"]
    files.write(unit, tmp_path / "program.c")
    monkeypatch.chdir(tmp_path)
    names = (("ArmMotion", "arm", "armStep"), ("GlueMotion", "glue", "glueStep"), ("PieceMotion", "piece", "pieceStep"))
    start = "".join(
        f"""
    fun := '{fun}'; rtn := rtn + GT_GetFunId(ADR(fun), ADR(id)) + GT_Bind({n}, id, {n});
    name := '{axis}'; rtn := rtn + GT_GetVarId(ADR(fun), ADR(name), ADR(item));
    value := {n + 1}; rtn := rtn + GT_SetVarValue({n}, ADR(item), ADR(value));
    name := '{step}'; rtn := rtn + GT_GetVarId(ADR(fun), ADR(name), ADR(item));
    value := 1000; rtn := rtn + GT_SetVarValue({n}, ADR(item), ADR(value)) + GT_RunThread({n});
    rtn := rtn + GT_AxisOn({n + 1}) + GT_PrfTrap({n + 1}) + GT_SetTrapPrm({n + 1}, ADR(trap));
    rtn := rtn + GT_SetVel({n + 1}, 10);"""
        for n, (fun, axis, step) in enumerate(names)
    )
    plc = PLC.load(
        f"""
PROGRAM PLC_PRG
VAR
    first : BOOL := TRUE; rtn, id : INT; bin : STRING := 'program.bin'; fun, name : STRING; item : TVarInfo;
    value : LREAL; trap : TTrapPrm := (acc := 1.0, dec := 1.0);
END_VAR
IF first THEN
    rtn := GT_Download(ADR(bin));{start}
    name := 'armStart'; rtn := rtn + GT_GetVarId(0, ADR(name), ADR(item));
    value := 1; rtn := rtn + GT_SetVarValue(-1, ADR(item), ADR(value));
    first := FALSE;
END_IF
END_PROGRAM
""",
        interval="1ms",
    )
    trace = plc.trace("SIM.Axis[1].prfPos", "SIM.Axis[2].prfPos", "SIM.Axis[3].prfPos")
    plc.run("2s")
    assert plc["PLC_PRG.rtn"] == 0 and plc["SIM.refusals"] == 0
    arm, glue, piece = ([float(x) for x in trace[f"SIM.Axis[{n}].prfPos"]] for n in (1, 2, 3))
    assert max(arm) == max(glue) == 1000.0 and min(arm) == min(glue) == 0.0
    first = next(k for k, x in enumerate(arm) if x == 1000.0)
    assert glue[first] == piece[first] == 0.0  # they wait for the arm
    assert all(b >= a for a, b in zip(piece, piece[1:], strict=False)) and piece[-1] >= 3000.0  # step by step
    back = [k for k in range(1, 2000) if glue[k] < glue[k - 1] and glue[k - 1] == 1000.0]
    assert back and all(piece[k] % 1000 == 0 for k in back)  # glue returns when the piece has arrived

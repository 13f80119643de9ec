"""Every GT_ function with wrong arguments: the code is 7, the run goes on, nothing has moved, and the reason is noted.

Axis 0 and 13, a NULL pointer, a count beyond the last axis, a mask with bits of no axis."""

import re
from pathlib import Path

import pytest

import mclib
from plcruntime import PLC, CompileError, catalogue
from stcore.paths import PathError

ENTRIES = [
    e
    for e in catalogue.entries([mclib.LIBRARY])
    if e.kind == "function" and Path(e.file).parent.name in ("gt", "ecat", "motion") and e.signature.count("(") == 1
]
NUMBERED = ("axis", "profile", "encoder", "control", "dac", "step", "source")
MODES = {2: "Follow", 3: "Gear", 4: "Pt", 5: "Jog"}  # axis -> mode that it is in
VALUES = {"fifo": "0", "mode": "1", "thread": "1", "page": "1", "mdl": "0", "chn": "1", "alpha": "1", "size": "1"}


def parameters(entry) -> list[tuple[str, str]]:
    inside = re.fullmatch(r"\w+(?:<.*>)?\((.*)\): INT", entry.signature)[1]
    return [tuple(p.split(" := ")[0].split(": ", 1)) for p in inside.split("; ") if p]


def argument(name: str, kind: str) -> str:
    return "ADR(room)" if kind.startswith("POINTER") or kind == "T" else VALUES.get(name, "1")


def call(entry, **changed) -> str:
    mode = next((str(n) for n, word in MODES.items() if word in entry.name), "1")  # an axis that is in this mode
    changed.setdefault("profile", mode)
    return f"{entry.name}({', '.join(changed.get(n, argument(n, k)) for n, k in parameters(entry))})"


def cases() -> dict[str, str]:
    """What is wrong -> the call."""
    found = {}
    for e in ENTRIES:
        names = [n for n, _ in parameters(e)]
        for name in names:
            if name in NUMBERED:
                for number in ("0", "13", "-1"):
                    found[f"{e.name} {name} {number}"] = call(e, **{name: number})
            if name == "thread":
                for number in ("-1", "32"):
                    found[f"{e.name} {name} {number}"] = call(e, **{name: number})
            if name == "mask":
                found[f"{e.name} mask beyond"] = call(e, mask="16#4000")
                found[f"{e.name} mask negative"] = call(e, mask="-1")
        if "count" in names and names[0] in NUMBERED:
            for first, count in (("1", "0"), ("1", "-1"), ("1", "13"), ("12", "2"), ("2", "32767")):
                found[f"{e.name} {first} count {count}"] = call(e, **{names[0]: first, "count": count})
        for name, kind in parameters(e):
            if (kind.startswith("POINTER") or kind == "T") and name not in ("pClock", "pLoop", "pFunName"):
                found[f"{e.name} {name} NULL"] = call(e, **{name: "nothing"})
                found[f"{e.name} {name} 0"] = call(e, **{name: "0"})
    return found


CASES = cases()
PROGRAM = f"""
PROGRAM PLC_PRG
VAR job, rtn : INT; room : ARRAY[0..99] OF LREAL; nothing : POINTER TO ARRAY[0..99] OF LREAL; END_VAR
CASE job OF
{"".join(f"    {n}: rtn := {c};" + chr(10) for n, c in enumerate(CASES.values(), 1))}END_CASE
job := 0;
END_PROGRAM
"""
EXCEPT = {
    # GT_Stop knows coordinate systems too, whose bits are 12 and 13; other masks are of axes alone
    "GT_LinkCaptureOffset source 0": 0,  # 0 links nothing
}


@pytest.fixture(scope="module")
def plc() -> PLC:
    plc = PLC.load(PROGRAM, interval="1ms")
    plc.execute("GT_PrfFollow(2, 0); GT_PrfGear(3, 0); GT_PrfPt(4); GT_PrfJog(5);")
    return plc


def moves(plc: PLC) -> bool:
    """Whether any axis does, of all of them at once."""
    first, second = (plc.place(f"SIM.Axis[{n}].moving").address for n in (1, 2))
    return any(plc._machine.memory[first : first + len(plc.axes) * (second - first) : second - first])


def test_a_move_is_seen(plc):
    assert not moves(plc)
    last = len(plc.axes)
    plc.axes[last].moving = True
    assert moves(plc)
    plc.axes[last].moving = False
    assert not moves(plc)


@pytest.mark.parametrize("case", CASES)
def test_parameter_errors(plc, case):
    refused = plc["SIM.refusals"]
    plc["PLC_PRG.job"] = list(CASES).index(case) + 1
    plc.scan()
    expected = EXCEPT.get(case, 7)
    assert plc["PLC_PRG.rtn"] == expected, plc[f"SIM.refused[{(plc['SIM.refusals'] - 1) % 32}]"]
    if expected:
        last = plc[f"SIM.refused[{refused % 32}]"]
        assert plc["SIM.refusals"] == refused + 1
        assert last["command"] == case.split(" ")[0][:31] and last["code"] == 7 and last["why"]
    assert plc.fault is None and not moves(plc)


# what the host does alone, or what is no command of the PLC
HOST = ("commandhandler", "GT_Compile", "GetMacAddress", "GT_Delay", "GT_DelayHighPrecision")
REACHING = {e.name: call(e) for e in ENTRIES if e.name not in HOST}


@pytest.fixture(scope="module")
def cut() -> PLC:
    cases = "".join(f"    {n}: rtn := {c};\n" for n, c in enumerate(REACHING.values(), 1))
    plc = PLC.load(f"""
PROGRAM PLC_PRG
VAR job, rtn : INT; room : ARRAY[0..99] OF LREAL := [100(7.0)]; END_VAR
CASE job OF
{cases}END_CASE
job := 0;
END_PROGRAM
""")
    plc.scan()
    return plc


@pytest.mark.parametrize("code", [-1, -7])
@pytest.mark.parametrize("name", REACHING)
def test_a_controller_that_is_not_reached(cut, name, code):
    """Table 3-1: -1 the host does not reach the controller, -7 it does not answer; -6 then GT_Open fails."""
    cut["SIM.link"] = code
    cut["PLC_PRG.job"] = list(REACHING).index(name) + 1
    cut.scan()
    last = cut[f"SIM.refused[{(cut['SIM.refusals'] - 1) % 32}]"]
    assert cut["PLC_PRG.rtn"] == last["code"] == (-6 if name == "GT_Open" else code)
    assert last["command"] == name[:31] and "SIM.link" in last["why"]
    assert cut["PLC_PRG.room"] == [7.0] * 100


@pytest.mark.parametrize("value", ["text", "number", "1.5"])
def test_what_is_no_pointer_is_told_at_the_call(value):
    """Of functions whose pointer may be to different types."""
    with pytest.raises(CompileError) as caught:
        PLC.load(f"""
PROGRAM PLC_PRG
VAR text : STRING(40); number : LREAL; variable : TVarInfo; END_VAR
GT_GetVarValue(-1, ADR(variable), {value});
GT_GetVersion({value});
END_PROGRAM""")
    found = [(d.code, d.line, d.hint) for d in caught.value.diagnostics]
    assert found == [("E0407", 4, "give its address: ADR(...)"), ("E0407", 5, "give its address: ADR(...)")]


@pytest.mark.parametrize("typed", ["GT_LoadConfig('test.cfg')", "GT_SetStopIo(1, 0, MC_GPI, 4)", "GT_SetDo(MC_GPO, 1)"])
def test_a_typed_command_that_needs_more_than_the_program_has(typed):
    plc = PLC.load("PROGRAM PLC_PRG GT_AxisOn(1); END_PROGRAM")
    with pytest.raises(PathError, match="^that needs .* this program .*; call it there$"):
        plc.evaluate(typed)
    assert plc.evaluate("GT_AxisOff(1)") == 0


def test_an_address_in_a_dword():
    plc = PLC.load("""
PROGRAM PLC_PRG
VAR at : DWORD; text : STRING(40); rtn : INT; END_VAR
at := ADR(text);
rtn := GT_GetVersion(at);
END_PROGRAM""")
    plc.scan()
    assert plc["PLC_PRG.rtn"] == 0 and len(plc["PLC_PRG.text"]) == 21


def test_the_link_comes_back():
    plc = PLC.load("""
PROGRAM PLC_PRG
VAR rtn : INT; clock : UDINT; END_VAR
rtn := GT_GetClock(ADR(clock));
END_PROGRAM""")
    plc.schedule("SIM.link", -1, "10ms")
    plc.schedule("SIM.link", 0, "20ms")
    trace = plc.trace("PLC_PRG.rtn", "PLC_PRG.clock")
    plc.scan(30)
    assert [int(x) for x in trace["PLC_PRG.rtn"]] == [0] * 10 + [-1] * 10 + [0] * 10
    assert int(trace["PLC_PRG.clock"][25]) == 25  # the controller has run on

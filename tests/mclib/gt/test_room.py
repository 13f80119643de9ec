"""Commands with 'count' or a size: what would run past the variable that the pointer leads to gives 7, changes nothing
and is noted with the reason. Commands of EtherCAT and of motion programs are tested with the others of theirs."""

import re
from pathlib import Path

import pytest

import mclib
from plcruntime import PLC, CompileError, catalogue

BYTES = {"LREAL": 8, "DINT": 4, "UDINT": 4, "INT": 2, "TTriggerStatus": 8}
SIGNATURE = re.compile(r"(\w+)\((\w+): INT; (.*?)(p\w+): POINTER TO (\w+); count: INT")
ENTRIES = [e for e in catalogue.entries([mclib.LIBRARY]) if Path(e.file).parent.name == "gt"]
COUNTED = {m[1]: m for e in ENTRIES if (m := SIGNATURE.match(e.signature))}
FIRST = {"diType": "4, 1"}  # general inputs from the first on


def call(name: str, pointer: str, count: int) -> str:
    return f"{name}({FIRST.get(COUNTED[name][2], '1')}, {pointer}, {count})"


def declared(name: str) -> str:
    """Arrays of the elements that a command has, each between two others that shall stay as they are."""
    kind, lines = COUNTED[name][5], ""
    for array, bounds in {"three": "0..2", "other": "-1..1", "square": "1..2, 0..1", "single": ""}.items():
        of = f"ARRAY[{bounds}] OF {kind}" if bounds else kind
        lines += f"{name}_{array}_a : DINT := 7; {name}_{array} : {of}; {name}_{array}_b : DINT := 7;\n"
    return lines


def cases() -> dict[str, tuple[str, int]]:
    """What is done -> the call, the code that it gives."""
    found = {}
    for name in COUNTED:
        at = f"ADR({name}_"
        for what, pointer, count, code in (
            ("exact", f"{at}three)", 3, 0),
            ("one too many", f"{at}three)", 4, 7),
            ("negative bounds", f"{at}other)", 3, 0),
            ("negative bounds, one too many", f"{at}other)", 4, 7),
            ("two dimensions", f"{at}square)", 4, 0),
            ("two dimensions, one too many", f"{at}square)", 5, 7),
            ("from an element on", f"{at}three[1])", 2, 0),
            ("from an element on, one too many", f"{at}three[1])", 3, 7),
            ("from an element of two dimensions", f"{at}square[2, 0])", 2, 0),
            ("from an element of two dimensions, one too many", f"{at}square[2, 0])", 3, 7),
            ("from a variable index on", f"{at}three[one])", 2, 0),
            ("from a variable index on, one too many", f"{at}three[one])", 3, 7),
            ("from a variable index of two dimensions, one too many", f"{at}square[one, one])", 4, 7),
            ("a scalar", f"{at}single)", 1, 0),
            ("a scalar, one too many", f"{at}single)", 2, 7),
            ("a pointer to an array", f"array_{name}", 3, 0),
            ("a pointer to an array, one too many", f"array_{name}", 4, 7),
            ("an element of what a pointer leads to, one too many", f"ADR(array_{name}^[one])", 3, 7),
            ("a number", f"number_{name}", 3, 0),
            ("a number, one too many", f"number_{name}", 4, 7),
            ("a pointer to an element", f"element_{name}", 2, 0),
            ("a pointer to an element, one too many", f"element_{name}", 3, 7),
            ("NULL", "0", 3, 7),
        ):
            found[f"{name} {what}"] = (call(name, pointer, count), code)
    return found


CASES = cases()


@pytest.fixture(scope="module")
def plc() -> PLC:
    jobs = "".join(f"    {n}: rtn := {c};\n" for n, (c, _) in enumerate(CASES.values(), 1))
    numbers = "".join(f"number_{n} := ADR({n}_three); array_{n} := ADR({n}_three);"
                      f"element_{n} := ADR({n}_three[one]);\n" for n in COUNTED)  # fmt: skip
    pointers = "".join(
        f"number_{n} : DWORD; array_{n} : POINTER TO ARRAY[0..2] OF {m[5]}; element_{n} : POINTER TO {m[5]};\n"
        for n, m in COUNTED.items()
    )
    plc = PLC.load(f"""
PROGRAM PLC_PRG
VAR
job, rtn : INT; one : INT := 1;
{pointers}{"".join(declared(n) for n in COUNTED)}END_VAR
{numbers}CASE job OF
{jobs}END_CASE
job := 0;
END_PROGRAM
""")
    plc.scan()
    return plc


def test_every_command_with_a_count_is_here():
    with_count = {e.name for e in ENTRIES if "count: INT" in e.signature and "POINTER TO" in e.signature}
    assert with_count == set(COUNTED) and len(COUNTED) == 22 and "room" not in " ".join(e.signature for e in ENTRIES)


@pytest.mark.parametrize("case", CASES)
def test_count(plc, case):
    name = case.split(" ")[0]
    arrays = [f"PLC_PRG.{name}_{a}" for a in ("three", "other", "square", "single")]
    before, refused = [plc[a] for a in arrays], plc["SIM.refusals"]
    plc["PLC_PRG.job"] = list(CASES).index(case) + 1
    plc.scan()
    expected = CASES[case][1]
    assert plc["PLC_PRG.rtn"] == expected and plc["SIM.refusals"] == refused + (expected == 7)
    assert all(plc[a + side] == 7 for a in arrays for side in ("_a", "_b"))
    if expected:
        last = plc[f"SIM.refused[{refused % 32}]"]
        assert (last["command"], last["code"]) == (name, 7)
        assert ("variable" in last["why"]) == ("NULL" not in case)
        assert [plc[a] for a in arrays] == before


def test_what_is_read_reaches_the_last_element():
    plc = PLC.load("""
PROGRAM PLC_PRG
VAR a3, part : ARRAY[0..2] OF LREAL := [3(-1.0)]; rtn : ARRAY[0..2] OF INT; at : DWORD; END_VAR
at := ADR(a3);
GT_SetPrfPos(1, 10); GT_SetPrfPos(2, 20); GT_SetPrfPos(3, 30); GT_SetPrfPos(4, 40);
rtn[0] := GT_GetPrfPos(1, ADR(a3), 4);
rtn[1] := GT_GetPrfPos(profile := 2, count := 3, pValue := ADR(a3));
rtn[2] := GT_GetPrfPos(3, ADR(part[1]), 2);
END_PROGRAM""")
    plc.scan()
    assert plc["PLC_PRG.rtn"] == [7, 0, 0]
    assert plc["PLC_PRG.a3"] == [20.0, 30.0, 40.0] and plc["PLC_PRG.part"] == [-1.0, 30.0, 40.0]
    for pointer in ("ADR(PLC_PRG.a3)", "PLC_PRG.at"):
        assert plc.evaluate(f"GT_GetPrfPos(1, {pointer}, 4)") == 7
    assert plc.evaluate("GT_GetPrfPos(1, ADR(PLC_PRG.a3), 3)") == 0 and plc["PLC_PRG.a3"] == [10.0, 20.0, 30.0]


def test_structures_instances_functions_and_arrays_of_arrays():
    """Wherever the variable lies its end counts; an array inside of an array goes on in its neighbour, a single value
    in the next one of its structure."""
    plc = PLC.load("""
TYPE Row : STRUCT before : LREAL; v : ARRAY[1..2] OF LREAL; after : LREAL; END_STRUCT END_TYPE
FUNCTION Local : INT
VAR_INPUT n : INT; END_VAR
VAR v : ARRAY[0..2] OF LREAL; END_VAR
Local := GT_GetPrfPos(1, ADR(v), n);
END_FUNCTION
FUNCTION Given : INT
VAR_IN_OUT v : ARRAY[0..2] OF LREAL; END_VAR
VAR_INPUT i, n : INT; END_VAR
Given := GT_GetPrfPos(1, ADR(v[i]), n);
END_FUNCTION
FUNCTION_BLOCK Own
VAR_INPUT i, n : INT; END_VAR
VAR_OUTPUT rtn : INT; END_VAR
VAR v : ARRAY[0..2] OF LREAL; END_VAR
rtn := GT_GetPrfPos(1, ADR(v[i]), n);
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR
    row : ARRAY[0..1] OF Row; own : Own; v : ARRAY[0..2] OF LREAL; w : ARRAY[0..1] OF ARRAY[0..1] OF LREAL;
    k : INT := 1; rtn : ARRAY[0..13] OF INT;
END_VAR
rtn[0] := GT_GetPrfPos(1, ADR(row[k].v), 2);
rtn[1] := GT_GetPrfPos(1, ADR(row[k].v), 3);
rtn[2] := GT_GetPrfPos(1, ADR(row[k].v[k + 1]), 2);
rtn[3] := GT_GetPrfPos(1, ADR(row[k].before), 4);
rtn[4] := GT_GetPrfPos(1, ADR(row[k].before), 5);
rtn[5] := Local(3);
rtn[6] := Local(4);
rtn[7] := Given(v, 1, 2);
rtn[8] := Given(v, 1, 3);
own(i := 2, n := 1);
rtn[9] := own.rtn;
own(i := 2, n := 2);
rtn[10] := own.rtn;
rtn[11] := GT_GetPrfPos(1, ADR(w[0][k]), 3);
rtn[12] := GT_GetPrfPos(1, ADR(w[0][k]), 4);
rtn[13] := GT_GetPrfPos(1, ADR(row[k]), 4);
END_PROGRAM""")
    plc.scan()
    assert plc["PLC_PRG.rtn"] == [0, 7, 7, 0, 7, 0, 7, 0, 7, 0, 7, 0, 7, 0]


def test_an_address_that_no_adr_has_given_is_held_against_the_end_of_all_variables():
    plc = PLC.load("""
PROGRAM PLC_PRG
VAR at : DWORD; element : POINTER TO LREAL; rtn : ARRAY[0..3] OF INT; last : ARRAY[0..7] OF LREAL; END_VAR
element := at;
rtn[0] := GT_GetPrfPos(1, at, 2);
rtn[1] := GT_GetPrfPos(1, at, 3);
rtn[2] := GT_GetPrfPos(1, element, 2);
rtn[3] := GT_GetPrfPos(1, element, 3);
END_PROGRAM""")
    plc["PLC_PRG.at"] = plc.program.state_end - 16
    plc.scan()
    assert plc["PLC_PRG.rtn"] == [0, 7, 0, 7]


def test_addresses_kept_by_an_instance_or_a_function():
    plc = PLC.load("""
FUNCTION Local : INT
VAR_INPUT n : INT; END_VAR
VAR at : DWORD; v : ARRAY[0..2] OF LREAL; END_VAR
at := ADR(v[1]);
Local := GT_GetPrfPos(1, at, n);
END_FUNCTION
FUNCTION_BLOCK Own
VAR_INPUT n : INT; END_VAR
VAR_OUTPUT rtn : INT; END_VAR
VAR before : DINT := 7; v : ARRAY[0..2] OF LREAL; behind : DINT := 7; at : POINTER TO LREAL; END_VAR
at := ADR(v);
rtn := GT_GetPrfPos(1, at, n);
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR own : ARRAY[1..2] OF Own; i : INT; rtn : ARRAY[1..6] OF INT; END_VAR
FOR i := 1 TO 2 DO
    own[i](n := 3);
    rtn[i] := own[i].rtn;
    own[i](n := 4);
    rtn[2 + i] := own[i].rtn;
END_FOR
rtn[5] := Local(2);
rtn[6] := Local(3);
END_PROGRAM""")
    plc.scan()
    assert plc["PLC_PRG.rtn"] == [0, 0, 7, 7, 0, 7]
    assert [plc[f"PLC_PRG.own[{i}].behind"] for i in (1, 2)] == [7, 7]


def test_an_address_of_a_part_leads_into_the_whole_where_that_is_taken_too():
    plc = PLC.load("""
TYPE Row : STRUCT before : LREAL; v : ARRAY[1..2] OF LREAL; END_STRUCT END_TYPE
FUNCTION Read : INT
VAR_INPUT at : DWORD; n : INT; END_VAR
Read := GT_GetPrfPos(1, at, n);
END_FUNCTION
PROGRAM PLC_PRG
VAR one, two : Row; wide : LWORD; rtn : ARRAY[0..7] OF INT; taken : DWORD; END_VAR
rtn[0] := Read(ADR(one.v), 2);
rtn[1] := Read(ADR(one.v), 3);
rtn[2] := Read(ADR(one.before), 3);
rtn[3] := Read(ADR(one.before), 4);
taken := ADR(two);
rtn[4] := Read(ADR(two.before), 3);
rtn[5] := Read(ADR(two.before), 4);
wide := ADR(two.v);
rtn[6] := GT_GetPrfPos(1, LWORD_TO_DWORD(wide), 3);
rtn[7] := Read(0, 1);
END_PROGRAM""")
    plc.scan()
    assert plc["PLC_PRG.rtn"] == [0, 7, 0, 7, 0, 7, 7, 7]


def test_an_array_of_smaller_elements():
    """As long as it has the bytes, V2.3's arrays of DWORD and BYTE do."""
    plc = PLC.load("""
PROGRAM PLC_PRG
VAR words : ARRAY[0..3] OF DWORD; bytes : ARRAY[1..16] OF BYTE; rtn : ARRAY[0..3] OF INT; END_VAR
rtn[0] := GT_GetSts(1, ADR(words), 4);
rtn[1] := GT_GetSts(1, ADR(words), 5);
rtn[2] := GT_GetPrfPos(1, ADR(bytes), 2);
rtn[3] := GT_GetPrfPos(1, ADR(bytes), 3);
END_PROGRAM""")
    plc.scan()
    assert plc["PLC_PRG.rtn"] == [0, 7, 0, 7]


@pytest.mark.parametrize("arguments, code", [("one, ADR(x), 1, 0, 8", "E0401"), ("1, ADR(x), room := 8", "E0408")])
def test_a_call_cannot_give_the_room_itself(arguments, code):
    with pytest.raises(CompileError) as caught:
        PLC.load(f"PROGRAM PLC_PRG VAR one : INT; x : LREAL; END_VAR GT_GetPrfPos({arguments}); END_PROGRAM")
    assert [d.code for d in caught.value.diagnostics] == [code]
    assert "room" not in caught.value.diagnostics[0].hint

"""Errors: each mistake is one diagnostic, with its code and place."""

import pytest
from running import diagnostics, errors, program

UNITS = """FUNCTION Twice : INT VAR_INPUT n : INT; k : INT := 2; END_VAR VAR_OUTPUT o : INT; END_VAR
Twice := n * k; END_FUNCTION
FUNCTION_BLOCK Fb VAR_INPUT in : INT; END_VAR VAR_OUTPUT out : INT; END_VAR VAR_IN_OUT io : INT; END_VAR
VAR own : INT; END_VAR out := in + io; END_FUNCTION_BLOCK
TYPE Color : (red, green, blue); Pt : STRUCT x, y : INT; END_STRUCT END_TYPE
VAR_GLOBAL CONSTANT LIMIT_A : INT := 5; END_VAR
"""
DECLARATIONS = """counter, i : INT; b : BOOL; r : REAL; s : STRING; t : TIME; fb : Fb; pt : Pt; c : Color; w : WORD;
p : POINTER TO INT; a : ARRAY[0..3] OF INT; m : ARRAY[0..1, 0..1] OF INT; d : DATE; a2 : ARRAY[0..4] OF INT;
pf : POINTER TO REAL; lw : LWORD; td : TOD;"""
FIRST = 6 + UNITS.count("\n") + DECLARATIONS.count("\n")

# statement, code, column, part of message or hint
MISTAKES = [
    ("countr := 1;", "E0301", 1, "counter"),
    ("i := countr + 1;", "E0301", 6, "counter"),
    ("i := b;", "E0302", 6, "BOOL_TO_INT"),
    ("b := i;", "E0302", 6, "INT_TO_BOOL"),
    ("b := 2;", "E0302", 6, ""),
    ("i := s;", "E0302", 6, "STRING_TO_INT"),
    ("s := i;", "E0302", 6, "INT_TO_STRING"),
    ("t := 5;", "E0302", 6, "T#5ms"),
    ("i := t;", "E0302", 6, "TIME_TO_INT"),
    ("i := T#5s;", "E0302", 6, "TIME_TO_INT"),
    ("i := 'text';", "E0302", 6, ""),
    ("t := i;", "E0302", 6, "INT_TO_TIME"),
    ("pt := i;", "E0302", 7, ""),
    ("i := pt;", "E0302", 6, ""),
    ("a := a2;", "E0302", 6, ""),
    ("d := t;", "E0302", 6, ""),
    ("c := i + pt;", "E0317", 6, ""),
    ("IF i THEN ; END_IF", "E0304", 4, "BOOL"),
    ("WHILE w DO ; END_WHILE", "E0304", 7, "BOOL"),
    ("i := i + b;", "E0317", 6, ""),
    ("b := b + b;", "E0317", 6, ""),
    ("b := NOT r;", "E0316", 6, ""),
    ("r := r MOD 2.0;", "E0317", 6, ""),
    ("b := s > 5;", "E0317", 6, ""),
    ("b := b AND i;", "E0317", 6, ""),
    ("t := t * t;", "E0317", 6, ""),
    ("d := d + d;", "E0317", 6, ""),
    ("i := Twice();", "", 0, ""),
    ("i := Twice(1, 2, 3);", "E0401", 6, "2 arguments"),
    ("i := Twice(n := 1, q := 2);", "E0408", 20, "no parameter q"),
    ("i := Twice(n := 1, n := 2);", "E0409", 20, "twice"),
    ("i := Twic(1);", "E0404", 6, "Twice"),
    ("i := Twice(b);", "E0302", 12, "BOOL_TO_INT"),
    ("i := Twice(countr);", "E0301", 12, "counter"),
    ("fb(inn := 1, io := i);", "E0408", 4, "in"),
    ("fb(in := 1);", "E0410", 1, "io"),
    ("fb(in := 1, io := 5);", "E0319", 19, ""),
    ("fb(in := 1, io := r);", "E0411", 13, "REAL"),
    ("fb(in := 1, io := i, out := i);", "E0412", 22, "=>"),
    ("fb(in := 1, io := i, out => b);", "E0302", 22, ""),
    ("i := fb.outt;", "E0306", 6, "out"),
    ("fb.outt := 1;", "E0306", 1, "out"),
    ("pt.z := 1;", "E0306", 1, "z"),
    ("i.z := 1;", "E0308", 1, ""),
    ("i := fb(in := 1, io := i);", "E0303", 6, ""),
    ("LIMIT_A := 3;", "E0318", 1, "CONSTANT"),
    ("i + 1;", "E0102", 2, ":="),
    ("i;", "E0502", 1, ""),
    ("a[4] := 1;", "E0314", 3, "0..3"),
    ("a[-1] := 1;", "E0314", 3, "0..3"),
    ("a[1, 2] := 1;", "E0313", 1, "1 dimension"),
    ("m[1] := 1;", "E0313", 1, "2 dimensions"),
    ("a[r] := 1;", "E0312", 3, "REAL"),
    ("a[b] := 1;", "E0312", 3, "BOOL"),
    ("i[0] := 1;", "E0311", 1, "not an array"),
    ("i^ := 1;", "E0315", 1, "not a pointer"),
    ("w.16 := TRUE;", "E0310", 1, "15"),
    ("r.0 := TRUE;", "E0309", 1, "REAL"),
    ("Twice(1) := i;", "E0319", 1, ""),
    ("EXIT;", "E0507", 1, "loop"),
    ("CONTINUE;", "E0507", 1, "loop"),
    ("JMP nowhere;", "E0508", 1, "nowhere"),
    ("FOR r := 0 TO 5 DO ; END_FOR", "E0505", 5, "REAL"),
    ("FOR i := 0 TO 5 BY 0 DO ; END_FOR", "E0506", 20, ""),
    ("FOR i := 0 TO b DO ; END_FOR", "E0302", 15, ""),
    ("CASE r OF 1: ; END_CASE", "E0503", 6, "REAL"),
    ("CASE i OF counter: ; END_CASE", "E0504", 11, "constant"),
    ("CASE i OF 5..2: ; END_CASE", "E0205", 11, "5..2"),
    ("i := 5 / 0;", "E0603", 10, ""),
    ("i := i MOD 0;", "E0603", 12, ""),
    ("R_TRIG(CLK := b);", "E0405", 1, "instance"),
    ("i := Color;", "E0303", 6, ""),
    ("c := Color.pink;", "E0306", 6, ""),
    ("c := 5;", "", 0, ""),
    ("i := Twice;", "E0303", 6, ""),
    ("p := ADR(5);", "E0319", 10, ""),
    ("p := ADR(w.3);", "E0402", 6, "bit"),
    ("i := SEL(i, 1, 2);", "E0304", 10, "BOOL"),
    ("i := ABS(b);", "E0316", 6, "BOOL"),
    ("i := ABS();", "E0401", 6, "1 arguments"),
    ("i := SHL(r, 1);", "E0316", 6, "REAL"),
    ("i := INT_TO_REAL(1, 2);", "E0401", 6, ""),
    ("i := LEN(i);", "E0407", 6, "ANY_STRING"),
    ("b S= i;", "E0304", 6, "BOOL"),
    ("i S= b;", "E0304", 1, "BOOL"),
    ("p REF= i;", "E0501", 1, ""),
    ("i := a;", "E0302", 6, ""),
    ("lw := -1.5;", "", 0, ""),
    ("fb.Run();", "E0306", 1, ""),
    ("s[0] := 'a';", "E0302", 9, ""),
]


@pytest.mark.parametrize(("body", "code", "column", "text"), [m for m in MISTAKES if m[1]])
def test_one_mistake_is_one_error(body, code, column, text):
    found = diagnostics(program(body, DECLARATIONS, UNITS))
    assert [(d.code, d.line, d.column) for d in found] == [(code, FIRST, column)], found
    assert text in f"{found[0].message} {found[0].hint}"


@pytest.mark.parametrize("body", [m[0] for m in MISTAKES if not m[1] and m[2] == 0])
def test_not_an_error(body):
    assert errors(program(body, DECLARATIONS, UNITS)) == []


# unit, code, line, column, part of message or hint
UNIT_MISTAKES = [
    ("PROGRAM P VAR x : INT;\n  x : REAL; END_VAR END_PROGRAM", "E0201", 2, 3, "line 1"),
    ("PROGRAM P VAR x : INTT; END_VAR x := 1; END_PROGRAM", "E0202", 1, 19, "INT"),
    ("PROGRAM P VAR x : ARRAY[5..1] OF INT; END_VAR END_PROGRAM", "E0205", 1, 25, "5..1"),
    ("PROGRAM P VAR n : INT; x : ARRAY[0..n] OF INT; END_VAR END_PROGRAM", "E0601", 1, 37, ""),
    ("PROGRAM P VAR x : INT := 'a'; END_VAR END_PROGRAM", "E0302", 1, 26, ""),
    ("PROGRAM P VAR x : BOOL := 5; END_VAR END_PROGRAM", "E0302", 1, 27, ""),
    ("PROGRAM P VAR x : INT := y; END_VAR END_PROGRAM", "E0301", 1, 26, ""),
    ("PROGRAM P VAR x : ARRAY[0..1] OF INT := [1, 2, 3]; END_VAR END_PROGRAM", "E0606", 1, 41, "3 values"),
    ("PROGRAM P VAR x : INT := [1]; END_VAR END_PROGRAM", "E0605", 1, 26, ""),
    (
        "TYPE S : STRUCT a : INT; END_STRUCT END_TYPE PROGRAM P VAR x : S := (b := 1); END_VAR END_PROGRAM",
        "E0306",
        1,
        70,
        "no member b",
    ),
    ("PROGRAM P VAR x AT %XYZ : INT; END_VAR END_PROGRAM", None, 1, None, ""),
    ("PROGRAM P VAR x : ARRAY[*] OF INT; END_VAR END_PROGRAM", "E0207", 1, 15, ""),
    ("PROGRAM P VAR_EXTERNAL x : INT; END_VAR x := 1; END_PROGRAM", "E0208", 1, 24, "x"),
    (
        "TYPE A : STRUCT b : B; END_STRUCT B : STRUCT a : A; END_STRUCT END_TYPE "
        "PROGRAM P VAR a : A; END_VAR END_PROGRAM",
        "E0203",
        None,
        None,
        "itself",
    ),
    (
        "TYPE A : STRUCT a : A; END_STRUCT END_TYPE PROGRAM P VAR a : A; END_VAR END_PROGRAM",
        "E0203",
        None,
        None,
        "itself",
    ),
    (
        "FUNCTION_BLOCK F VAR f : F; END_VAR END_FUNCTION_BLOCK PROGRAM P VAR f : F; END_VAR END_PROGRAM",
        "E0203",
        None,
        None,
        "itself",
    ),
    (
        "TYPE A : STRUCT a : INT; a : REAL; END_STRUCT END_TYPE PROGRAM P VAR a : A; END_VAR END_PROGRAM",
        "E0201",
        1,
        26,
        "twice",
    ),
    ("TYPE A : (x, y, x); END_TYPE PROGRAM P VAR a : A; END_VAR END_PROGRAM", "E0201", 1, 17, "twice"),
    ("FUNCTION F : INT END_FUNCTION\nFUNCTION F : INT END_FUNCTION PROGRAM P END_PROGRAM", "E0201", 2, 10, "line 1"),
    ("PROGRAM P VAR CONSTANT c : INT := 40000; END_VAR END_PROGRAM", "W0304", 1, 35, "40000"),
    ("PROGRAM P VAR s : INT (0..10) := 11; END_VAR END_PROGRAM", "E0602", 1, 34, "0..10"),
    (
        "FUNCTION F : INT VAR_INPUT a : INT; END_VAR a := 1; END_FUNCTION\n"
        "PROGRAM P VAR CONSTANT c : INT := 1; END_VAR c := 2; END_PROGRAM",
        "E0318",
        2,
        46,
        "CONSTANT",
    ),
    ("PROGRAM P VAR a : P; END_VAR END_PROGRAM", "E0203", 1, 9, ""),
]


@pytest.mark.parametrize(("text", "code", "line", "column", "part"), UNIT_MISTAKES)
def test_mistakes_in_declarations(text, code, line, column, part):
    found = diagnostics(text)
    assert len(found) == 1, found
    d = found[0]
    assert code in (d.code, None) and line in (d.line, None) and column in (d.column, None), d
    assert part in f"{d.message} {d.hint}"


def test_all_errors_of_a_file_in_one_pass():
    found = errors(program("i := b;\nx := 1;\ny[0] := x;\nb := i;\nx := 2;", "i : INT; b : BOOL;"))
    assert [(d.code, d.line) for d in found if d.code == "E0302"] == [("E0302", 6), ("E0302", 9)]


def test_memory_that_is_made_at_run_time_is_one_clear_error():
    found = errors(program("p := __NEW(INT); __DELETE(p);", "p : POINTER TO INT;"))
    assert [d.code for d in found] == ["E0114", "E0114"] and "__NEW" in found[0].message and "array" in found[0].hint


def test_isvalidref_is_for_references():
    assert [d.code for d in errors(program("b := __ISVALIDREF(i);", "b : BOOL; i : INT;"))] == ["E0501"]


def test_an_array_with_wrong_bounds_is_one_error():
    text = program(
        "a[1] := 2; b[3] := a[2]; FOR n := 0 TO 3 DO a[n] := b[n]; END_FOR",
        "n : INT := 3; a : ARRAY[1..n] OF INT := [1, 2, 3]; b : ARRAY[5..2] OF INT;",
    )
    assert [d.code for d in errors(text)] == ["E0601", "E0205"]


def test_a_member_that_a_type_lacks_is_told_once():
    text = program("n := t.nosuch; n := t.NoSuch; t.other := 1;", "n : INT; t : TON;")
    assert [d.message for d in errors(text)] == ["TON has no member nosuch", "TON has no member other"]

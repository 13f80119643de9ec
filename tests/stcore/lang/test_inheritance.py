"""EXTENDS, ABSTRACT and FINAL, interfaces: whose method runs, where variables lie, what has to be declared."""

import re

import pytest
from running import Run, errors, program, run

from stcore.emit import inline

SHAPES = """
INTERFACE IShape
METHOD Area : LREAL END_METHOD
PROPERTY Name : STRING(20) GET END_GET END_PROPERTY
END_INTERFACE
INTERFACE IScaled EXTENDS IShape
METHOD Scale VAR_INPUT f : LREAL; END_VAR VAR_OUTPUT old : LREAL; END_VAR END_METHOD
PROPERTY Size : LREAL GET END_GET SET END_SET END_PROPERTY
END_INTERFACE
FUNCTION_BLOCK ABSTRACT Shape IMPLEMENTS IShape
VAR_INPUT id : INT := 7; END_VAR
VAR bodies : INT; END_VAR
VAR CONSTANT LIMIT : INT := 12; END_VAR
VAR_TEMP t : INT; END_VAR
METHOD ABSTRACT Area : LREAL END_METHOD
PROPERTY PUBLIC Name : STRING(20)
GET
Name := CONCAT('shape ', What());
END_GET
END_PROPERTY
METHOD PROTECTED What : STRING(20)
VAR_INST asked : INT; END_VAR
asked := asked + 1;
What := 'any';
END_METHOD
METHOD FINAL Ident : INT
Ident := id + LIMIT;
END_METHOD
bodies := bodies + 1;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Square EXTENDS Shape IMPLEMENTS IScaled
VAR_INPUT side : LREAL := 2; END_VAR
VAR_TEMP t : BOOL; END_VAR
METHOD Area : LREAL
Area := side * side;
END_METHOD
METHOD Scale VAR_INPUT f : LREAL; END_VAR VAR_OUTPUT old : LREAL; END_VAR
old := side;
side := side * f;
END_METHOD
METHOD PROTECTED What : STRING(20)
What := CONCAT(SUPER^.What(), ' square');
END_METHOD
PROPERTY Size : LREAL
GET
Size := side;
END_GET
SET
side := Size;
END_SET
END_PROPERTY
SUPER^();
bodies := bodies + 100;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Circle EXTENDS Shape
VAR r : LREAL := 1; END_VAR
METHOD Area : LREAL
Area := 3 * r * r;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Disk EXTENDS Circle
METHOD PROTECTED What : STRING(20)
What := 'disk';
END_METHOD
bodies := LIMIT;
END_FUNCTION_BLOCK
FUNCTION Total : LREAL
VAR_INPUT a : IShape; END_VAR
VAR_IN_OUT b : Shape; END_VAR
Total := a.Area() + b.Area();
b();
END_FUNCTION
"""
DECLARATIONS = (
    "p : POINTER TO Shape; r : REFERENCE TO Shape; sq : Square := (side := 3, id := 5); ci : Circle; di : Disk;"
    "any, none : IShape; scaled : IScaled; s1, s2, s3, s4 : STRING; a1, a2, a3, old, size, sum1, sum2 : LREAL;"
    "same, isNull : BOOL; all : ARRAY[1..3] OF IShape; i, ids : INT; sum : LREAL; first : IShape := di;"
)


def test_whose_method_runs():
    r = run(
        """p := ADR(sq); s1 := p^.Name; p^(); any := sq; a1 := any.Area(); s2 := any.Name;
        r REF= di; s3 := r.Name; r(); a3 := r.Area(); any := ci; a2 := any.Area(); s4 := any.Name;
        scaled := sq; scaled.Scale(3, old => old); size := scaled.Size; scaled.Size := 10; sq.Size := sq.Size + 1;
        any := scaled; same := any = scaled AND any <> 0; isNull := none = 0;
        sum1 := Total(sq, ci); sum2 := Total(any, sq);
        all[1] := sq; all[2] := ci; all[3] := di; FOR i := 1 TO 3 DO sum := sum + all[i].Area(); END_FOR
        ids := sq.Ident() + first.Area();""",
        DECLARATIONS,
        SHAPES,
    )
    assert [r[x] for x in ("s1", "s2", "s3", "s4")] == [
        "shape any square",
        "shape any square",
        "shape disk",
        "shape any",
    ]
    assert [r[x] for x in ("a1", "a2", "a3", "old", "size")] == [9, 3, 3, 3, 9]
    assert r["same"] and r["isNull"] and (r["sum1"], r["sum2"]) == (121 + 3, 121 + 121)
    assert (r["sum"], r["ids"]) == (121 + 3 + 3, 5 + 12 + 3)
    assert (r["sq.bodies"], r["ci.bodies"], r["di.bodies"]) == (202, 0, 12)


def test_an_instance_begins_with_the_variables_of_its_base():
    types = Run(program("i := sq.Ident();", DECLARATIONS, SHAPES)).program.types
    shape, square = types["SHAPE"], types["SQUARE"]
    assert [f.name for f in square.members.values()][:3] == ["id", "bodies", "LIMIT"]
    assert square.members["SIDE"].offset == 16 and square.members["ID"] is shape.members["ID"]
    assert (shape.members["ID"].offset, shape.size, square.size) == (4, 12, 24)  # the word of its class is the first


def test_without_methods_that_are_overridden_a_call_is_the_same_as_ever():
    before = (
        "FUNCTION_BLOCK A VAR_INPUT x : INT; END_VAR x := x + 1; END_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK B EXTENDS A VAR y : INT; END_VAR SUPER^(); y := x; END_FUNCTION_BLOCK"
    )
    r = run(
        "b(x := 4); c(b);",
        "b : B; c : C;",
        before + "\nFUNCTION_BLOCK C VAR_IN_OUT a : A; END_VAR a(x := 7); END_FUNCTION_BLOCK",
    )
    assert r["b"] == {"x": 8, "y": 5}
    assert r.program.types["B"].number == 0 and r.program.types["B"].members["Y"].offset == 4


def test_a_copy_of_an_instance_stays_what_it_is():
    r = run(
        "di.r := 9; r REF= di; p := ADR(sq); p^ := r; s1 := p^.Name; sq2 := sq;", DECLARATIONS + "sq2 : Square;", SHAPES
    )
    assert (r["s1"], r["sq.id"], r["sq2.id"]) == ("shape any square", 7, 7)


@pytest.mark.parametrize(
    "statement, code, words",
    [
        ("a1 := none.Area();", "F0103", "none is NULL"),
        ("s1 := none.Name;", "F0103", "none is NULL"),
        ("a1 := p^.Area();", "F0103", "p is NULL"),
        ("MEMSET(ADR(sq), 0, 4); any := sq; a1 := any.Area();", "F0109", "IShape"),
        ("p := ADR(DECLS); a1 := p^.Area();", "F0109", "Shape"),
    ],
)
def test_faults(statement, code, words):
    fault = Run(program(f"\n{statement}", DECLARATIONS + "DECLS : ARRAY[0..9] OF DWORD;", SHAPES)).fault()
    assert (fault.code, fault.instance) == (code, "PLC_PRG") and words in fault.message
    line = next(
        n for n, x in enumerate(program(f"\n{statement}", DECLARATIONS, SHAPES).splitlines(), 1) if statement[:9] in x
    )
    assert fault.line == line


@pytest.mark.parametrize(
    "body, code, words",
    [
        ("any := 5;", "E0302", "IShape"),
        ("any := p;", "E0302", "IShape"),
        ("scaled := any;", "E0302", "IScaled"),
        ("scaled := ci;", "E0302", "IScaled"),
        ("i := any.Arae();", "E0306", "did you mean Area"),
        ("i := any.side;", "E0306", "IShape has no member side"),
        ("any.Name := 'x';", "E0414", "no SET"),
        ("i := any^;", "E0315", "any is IShape"),
        ("any();", "E0406", "can't be called"),
        ("s1 := sq.What();", "E0413", "Square.What is PROTECTED"),
        ("sq := ci;", "E0302", "Circle"),
        ("sq.LIMIT := 3;", "E0318", "CONSTANT"),
        ("IShape();", "E0405", "IShape"),
        ("scaled.Scale(2, old := 3);", "E0319", "3 is not a variable"),
    ],
)
def test_one_clear_error(body, code, words):
    (found,) = errors(program(body, DECLARATIONS, SHAPES))
    assert found.code == code and words in f"{found.message} {found.hint}"


@pytest.mark.parametrize(
    "units, code, words",
    [
        ("FB B EXTENDS Missing END_FB", "E0202", "Missing"),
        ("INTERFACE I EXTENDS J END_INTERFACE INTERFACE J EXTENDS I END_INTERFACE", "E0212", "it extends this one"),
        ("FUNCTION F : INT END_FUNCTION METHOD m END_METHOD", "E0122", "the METHOD m belongs to no"),
        ("FB B EXTENDS F END_FB FUNCTION F : INT END_FUNCTION", "E0212", "no FUNCTION_BLOCK"),
        ("FB B EXTENDS I END_FB INTERFACE I END_INTERFACE", "E0212", "no FUNCTION_BLOCK"),
        ("FB B IMPLEMENTS A END_FB FB A END_FB", "E0212", "no INTERFACE"),
        ("FB B IMPLEMENTS I END_FB", "E0202", "I"),
        ("FB FINAL A END_FB FB B EXTENDS A END_FB", "E0212", "FINAL"),
        ("FB A EXTENDS B END_FB FB B EXTENDS A END_FB", "E0212", "B can't extend or implement A: it extends this one"),
        (
            "FB A VAR x : INT; END_VAR END_FB\n"
            "FB B EXTENDS A VAR x : INT; END_VAR END_FB", "E0201", "line 1",
        ),
        (
            "INTERFACE I METHOD m END_METHOD METHOD n END_METHOD PROPERTY p : INT GET END_GET END_PROPERTY\n"
            "END_INTERFACE\n"
            "FB B IMPLEMENTS I METHOD n END_METHOD END_FB", "E0213", "B implements I but lacks m, p",
        ),
        (
            "INTERFACE I METHOD m : INT END_METHOD END_INTERFACE\n"
            "FB B IMPLEMENTS I METHOD m : DINT END_METHOD END_FB", "E0214", "result is DINT, there INT",
        ),
        (
            "FB A METHOD m VAR_INPUT i : INT; END_VAR END_METHOD END_FB\n"
            "FB B EXTENDS A METHOD m END_METHOD END_FB", "E0214", "i is declared there only",
        ),
        (
            "FB A METHOD FINAL m END_METHOD END_FB\n"
            "FB B EXTENDS A METHOD m END_METHOD END_FB", "E0214", "FINAL",
        ),
        ("FB A METHOD ABSTRACT m END_METHOD END_FB", "E0213", "A is not ABSTRACT but lacks m"),
        (
            "FB ABSTRACT A METHOD ABSTRACT m END_METHOD END_FB\n"
            "FB B EXTENDS A END_FB", "E0213", "B extends A but lacks m",
        ),
        (
            "FB ABSTRACT A END_FB TYPE T : STRUCT a : ARRAY[1..2] OF A; END_STRUCT END_TYPE",
            "E0215", "A is ABSTRACT",
        ),
    ],
)  # fmt: skip
def test_errors_of_declarations(units, code, words):
    units = re.sub(r"\b(END_)?FB\b", r"\1FUNCTION_BLOCK", units)
    (found,) = errors(units + "\nPROGRAM PLC_PRG\nEND_PROGRAM")
    assert found.code == code and words in found.message


QUERIED = """
INTERFACE I1 METHOD Go : INT END_METHOD END_INTERFACE
INTERFACE I2 METHOD Up : INT END_METHOD END_INTERFACE
FUNCTION_BLOCK A IMPLEMENTS I1 VAR a : INT := 4; END_VAR METHOD Go : INT Go := a; END_METHOD END_FUNCTION_BLOCK
FUNCTION_BLOCK B EXTENDS A IMPLEMENTS I2 METHOD Up : INT Up := a * 10; END_METHOD END_FUNCTION_BLOCK
"""
QUERYING = "a : A; b : B; x : I1; y, z : I2; q : ARRAY[1..6] OF BOOL; p : POINTER TO A; u, v, w : INT;"


def test_what_an_instance_is_can_be_asked():
    r = run(
        """x := a; q[1] := __QUERYINTERFACE(x, y); x := b; q[2] := __QUERYINTERFACE(x, z); u := z.Up();
        q[3] := __QUERYPOINTER(x, p); v := p^.a; IF __QUERYINTERFACE(b, z) THEN w := z.Up(); END_IF
        x := 0; q[4] := __QUERYINTERFACE(x, z); q[5] := __QUERYPOINTER(x, p);""",
        QUERYING,
        QUERIED,
    )
    assert r["q"] == [False, True, True, False, False, False]
    assert [r[n] for n in ("u", "v", "w", "y", "z", "p")] == [40, 4, 40, 0, 0, 0]


@pytest.mark.parametrize("call", ["__QUERYINTERFACE(x, p)", "__QUERYPOINTER(x, y)", "__QUERYINTERFACE(5, y)"])
def test_what_can_be_asked(call):
    (found,) = errors(program(f"q[1] := {call};", QUERYING, QUERIED))
    assert found.code == "E0407"


def test_an_error_in_a_name_behind_extends_or_implements_is_one():
    for right in ("EXTENDS Shape", "IMPLEMENTS IShape"):
        wrong = f"{right}s"
        before = SHAPES.replace(right, wrong, 1)
        text = program("a1 := sq.Area() + ci.Area(); any := ci; s1 := sq.Name;", DECLARATIONS, before)
        assert [d.code for d in errors(text)] == ["E0202"], wrong


def test_probed_and_plain_builds_have_one_image():
    from stcore.build_program import build
    from stcore.compiler import LIBRARY
    from stcore.source import Source

    text = program("any := sq; a1 := any.Area(); p := ADR(di); s1 := p^.Name;", DECLARATIONS, SHAPES)
    plain, probed = (build([Source(text, "case.st")], None, [LIBRARY], False, probes)[0] for probes in (False, True))
    assert plain.image[: plain.state_end] == probed.image[: probed.state_end]


def test_a_private_method_is_not_replaced():
    before = """
FUNCTION_BLOCK A
METHOD PRIVATE Own : INT Own := 1; END_METHOD
METHOD Both : INT Both := 10 * Own() + Shared(); END_METHOD
METHOD Shared : INT Shared := 2; END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK B EXTENDS A
METHOD Own : LREAL VAR_INPUT k : LREAL := 2; END_VAR Own := 4 * k; END_METHOD
METHOD Shared : INT Shared := 9; END_METHOD
END_FUNCTION_BLOCK
"""
    r = run("x := a.Both(); y := b.Both(); z := b.Own();", "a : A; b : B; x, y : INT; z : LREAL;", before)
    assert (r["x"], r["y"], r["z"]) == (12, 19, 8)


def test_a_block_of_the_library_is_extended():
    method = "METHOD Left : TIME Left := PT - ET; END_METHOD"
    before = f"FUNCTION_BLOCK Mine EXTENDS TON {method} SUPER^(); END_FUNCTION_BLOCK"
    r = Run(program("t(IN := TRUE, PT := T#5ms); left := t.Left();", "t : Mine; left : TIME;", before)).scan(3)
    assert (r["t.ET"], r["left"]) == (0.002, 0.003)


CHANGES = """
VAR_GLOBAL gv : INT; END_VAR
INTERFACE I METHOD Go END_METHOD END_INTERFACE
FUNCTION_BLOCK F IMPLEMENTS I
VAR n, m : INT; END_VAR
METHOD Inc n := n + 1; gv := gv + 1; END_METHOD
METHOD Loop : INT
VAR k : INT; END_VAR
n := 0;
FOR k := 1 TO 10 DO n := n + 1; Inc(); m := m + n; END_FOR
Loop := n;
END_METHOD
METHOD Go n := n + 100; gv := gv + 100; END_METHOD
METHOD Two : INT
n := 1; Inc(); Two := n; n := 5; THIS^.Inc(); Two := Two * 10 + n;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK G EXTENDS F
METHOD Inc n := n + 2; gv := gv + 2; END_METHOD
METHOD Go SUPER^.Go(); n := n + 1; END_METHOD
END_FUNCTION_BLOCK
"""


@pytest.mark.parametrize("size", [(0, 0), (120, 4000), (100_000, 100_000)], ids=["called", "as it is", "taken in"])
def test_what_methods_change_is_read_again(size, monkeypatch):
    for name, limit in zip(("SMALL", "ONCE"), size, strict=True):
        monkeypatch.setattr(inline, name, limit)
    r = run(
        """gv := 5; f.Inc(); a := gv; gv := 7; ii := f; ii.Go(); b := gv; p := ADR(g); gv := 1; p^.Inc(); c := gv;
        d := f.Loop(); e := g.Loop(); h := p^.Two(); j := f.Two(); gv := 0;
        WHILE gv < 20 DO gv := gv + 1; p^.Inc(); END_WHILE k := gv; gv := 0;
        REPEAT gv := gv + 1; f.Inc(); UNTIL gv >= 9 END_REPEAT l := gv;
        FOR i := 1 TO 5 DO x := x + 1; f.Inc(); y := y + gv; IF x > 2 THEN ii.Go(); END_IF END_FOR z := gv;
        FOR i := 1 TO 3 DO w[i].Inc(); w[i].Inc(); w[i].n := w[i].n * 2; END_FOR o := w[1].n + w[2].n + w[3].n;""",
        "f : F; g : G; ii : I; p : POINTER TO F; a,b,c,d,e,h,j,k,l,i,x,y,z,o : INT; w : ARRAY[1..3] OF G;",
        CHANGES,
    )
    assert [r[n] for n in ("a", "b", "c", "d", "e", "h", "j")] == [6, 107, 3, 20, 30, 37, 26]
    assert [r[n] for n in ("k", "l", "x", "y", "z", "o")] == [21, 10, 5, 365, 315, 24]
    assert [r[n] for n in ("f.n", "f.m", "g.n", "g.m")] == [316, 110, 21, 165]

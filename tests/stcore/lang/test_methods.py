"""Methods of blocks and programs, and properties."""

import pytest
from running import Run, errors, program, run

from stcore.emit import inline

COUNTER = """
FUNCTION_BLOCK Counter
VAR_INPUT step : INT := 1; END_VAR
VAR_IN_OUT outer : INT; END_VAR
VAR_OUTPUT n : DINT; END_VAR
VAR text : STRING(20) := 'abc'; END_VAR
METHOD PUBLIC Add : DINT
VAR_INPUT up : INT := 5; times : INT := 1; END_VAR
VAR_OUTPUT twice : DINT; last : STRING(20); END_VAR
VAR i : INT; fresh : DINT; END_VAR
VAR_TEMP temp : DINT; END_VAR
VAR_INST calls : INT := 0; END_VAR
VAR_STAT total : INT; END_VAR
VAR CONSTANT HUNDRED : INT := 100; END_VAR
FOR i := 1 TO times DO n := n + up; fresh := fresh + up; temp := temp + up; END_FOR
calls := calls + 1;
total := total + 1;
twice := fresh + temp;
last := text;
Add := n + HUNDRED * calls + 10000 * total;
END_METHOD
n := n + step;                           // the body, with methods before and after it
METHOD Name : STRING(20)
VAR_IN_OUT x : INT; END_VAR
x := x + 1;
Name := CONCAT(text, 'x');
END_METHOD
METHOD Both
Add(up := 1);
THIS^.Add();
END_METHOD
METHOD Factorial : DINT
VAR_INPUT n : DINT; END_VAR              // hides the output
IF n <= 1 THEN Factorial := 1; ELSE Factorial := n * Factorial(n - 1); END_IF
END_METHOD
METHOD Self : REFERENCE TO Counter
Self REF= THIS^;
END_METHOD
METHOD Far : INT
Far := outer + 1;
END_METHOD
ACTION Clear
n := 0;
END_ACTION
METHOD Again
Clear();
END_METHOD
END_FUNCTION_BLOCK
METHOD Behind : INT                      // behind its block, as an exporter may write it
Behind := step;
END_METHOD
"""
SIZES = [(0, 0), (120, 4000), (100_000, 100_000)]  # called, as it is, taken into the caller


@pytest.fixture(params=SIZES, ids=["called", "as it is", "taken in"])
def sizes(request, monkeypatch):
    for name, size in zip(("SMALL", "ONCE"), request.param, strict=True):
        monkeypatch.setattr(inline, name, size)


def test_methods_of_a_block(sizes):
    r = run(
        """a := c.Add(); b := c.Add(up := 3, times := 2, twice => twice, last => s1); c.Both(); m := d[1].Add(7);
        s2 := d[k].Name(x := k); p := ADR(c); z := p^.Add(1); rf REF= d[2]; z2 := rf.Add(2); c.Both;
        f := c.Factorial(10); c.Self().step := 9; step := c.Self().Behind(); d[3](outer := io); d[3].Again();
        c(outer := io); o := c.Far();""",
        "c : Counter; d : ARRAY[1..3] OF Counter; a, b, twice, m, z, z2, f : DINT; s1, s2 : STRING; k : INT := 2;"
        "p : POINTER TO Counter; rf : REFERENCE TO Counter; step, o : INT; io : INT := 41;",
        COUNTER,
    )
    assert (r["a"], r["b"], r["twice"], r["m"]) == (10105, 20211, 12, 50107)
    assert (r["s1"], r["s2"], r["k"]) == ("abc", "abcx", 3)
    assert (r["z"], r["z2"], r["f"]) == (60518, 70102, 3628800)
    assert (r["c.n"], r["d[1].n"], r["d[2].n"], r["d[3].n"]) == (33, 7, 2, 0)  # 24 by methods, 9 by the body
    assert (r["step"], r["o"]) == (9, 42)


VALUES = """
TYPE Pair : STRUCT a, b : INT; END_STRUCT END_TYPE
FUNCTION_BLOCK Holder
VAR v : INT; pair : Pair; limit : INT := 10; END_VAR
METHOD Swapped : Pair
VAR_INPUT p : Pair; more : ARRAY[0..2] OF INT; END_VAR
VAR_OUTPUT c : ARRAY[0..1] OF INT; d : LREAL; END_VAR
pair.b := 99;                                // of the instance: what came in stays as it was
Swapped.a := p.b + more[1];
Swapped.b := p.a;
c[1] := 9;
d := 1.5;
END_METHOD
METHOD Sum : DINT
VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR
VAR i : DINT; END_VAR
FOR i := LOWER_BOUND(a, 1) TO UPPER_BOUND(a, 1) DO Sum := Sum + a[i]; END_FOR
END_METHOD
PROPERTY Pr : Pair
GET
Pr := pair;
END_GET
SET
VAR limited : INT; END_VAR
limited := MIN(Pr.a, limit);
pair.a := limited;
END_SET
END_PROPERTY
PROPERTY R : REFERENCE TO INT
GET
R REF= v;
END_GET
END_PROPERTY
PROPERTY PUBLIC Level : LREAL
GET
Level := v / 2.0;
END_GET
SET
v := LREAL_TO_INT(Level * 2);
END_SET
END_PROPERTY
METHOD Up
Level := Level + 1;
THIS^.Level := THIS^.Level + 1;
END_METHOD
END_FUNCTION_BLOCK
PROGRAM Other
VAR x : INT; END_VAR
METHOD Go : INT
VAR_INPUT y : INT; END_VAR
x := x + y;
Go := x + Here();
END_METHOD
METHOD PRIVATE Here : INT
Here := 1000;
END_METHOD
PROPERTY Half : INT
GET
Half := x / 2;
END_GET
END_PROPERTY
x := x + 1;
END_PROGRAM
FUNCTION Made : INT
VAR h : Holder; END_VAR
h.Level := 3;
h.Up();
Made := h.v;
END_FUNCTION
"""


def test_structures_properties_and_programs(sizes):
    r = run(
        """h.pair.a := 3; h.pair.b := 4;
        pb := h.Swapped(h.pair, nums, c => ca, d => d); g := h.Swapped(pb, nums).a; t := h.Sum(nums);
        h.Pr := pb; pr := h.Pr.a; pr2 := h.Pr.b; h.R := 5; rr := h.R + 1; h.Up(); lv := h.Level;
        o := Other.Go(5); o := Other.Go(y := 5); Other(); half := Other.Half; m := Made();
        FOR i := 0 TO 2 DO hs[i].Level := i; hs[i].Up(); END_FOR""",
        "h : Holder; hs : ARRAY[0..2] OF Holder; pb : Pair; nums : ARRAY[0..2] OF INT := [1, 20, 3];"
        "ca : ARRAY[0..1] OF INT; d, lv : LREAL; g, pr, pr2, rr, o, half, m, i : INT; t : DINT;",
        VALUES,
    )
    assert (r["pb"], r["ca"], r["d"], r["g"], r["t"]) == ({"a": 24, "b": 3}, [0, 9], 1.5, 23, 24)
    assert (r["pr"], r["pr2"], r["rr"], r["lv"]) == (10, 99, 6, 4.5)
    assert (r["o"], r["Other.x"], r["half"], r["m"]) == (1010, 11, 5, 10)
    assert [x["v"] for x in r["hs"]] == [4, 6, 8]


def test_words_that_are_names_elsewhere():
    r = run(
        "method := get + set; property := method; interface(CLK := TRUE); override := interface.Q; get := final;",
        "method, property, final : INT; get : INT := 1; set : INT := 2; interface : R_TRIG; override, internal : BOOL;",
    )
    assert (r["method"], r["property"], r["override"], r["get"]) == (3, 3, True, 0)


def test_a_block_without_methods_that_are_overridden_has_no_more_bytes():
    r = Run(program("c.Add();", "c : Counter; plain : Plain;", COUNTER + "FUNCTION_BLOCK Plain END_FUNCTION_BLOCK"))
    kinds = r.program.types
    assert kinds["COUNTER"].members["STEP"].offset == 0 and kinds["COUNTER"].number == 0
    assert kinds["COUNTER"].members["ADD__CALLS"].section == "VAR_INST" and kinds["PLAIN"].size == 4


@pytest.mark.parametrize(
    "body, code, line, words",
    [
        ("c.Add(7, 8, 9);", "E0401", 10, "Add takes 2 arguments"),
        ("c.Add(dwn := 7);", "E0408", 10, "Add has no parameter dwn"),
        ("c.Ad(7);", "E0306", 10, "did you mean Add"),
        ("c.Add('x');", "E0302", 10, "STRING"),
        ("x := c.Hide(1);", "E0413", 10, "C.Hide is PRIVATE"),
        ("x := c.Kept(1);", "E0413", 10, "C.Kept is PROTECTED"),
        ("c.P := 5;", "E0414", 10, "the property P has no SET"),
        ("x := c.W;", "E0414", 10, "the property W has no GET"),
        ("x := c.Add;", "E0303", 10, "c.Add is not a value"),
        ("c.Nothing().x := 1;", "E0308", 10, "no type"),
        ("x := c.Nothing();", "E0303", 10, "is not a value"),
        ("p := ADR(c.P);", "E0319", 10, "c.P is not a variable"),
        ("x := c.W := 3;", "E0319", 10, "c.W is not a variable"),
        ("c.Swap(c.P);", "E0319", 10, "c.P is not a variable"),
        ("c.P();", "E0406", 10, "can't be called"),
        ("SUPER^();", "E0415", 10, "extends no other block"),
    ],
)
def test_one_clear_error(body, code, line, words):
    text = f"""FUNCTION_BLOCK C
METHOD Add : INT VAR_INPUT up : INT; times : INT; END_VAR END_METHOD METHOD Nothing END_METHOD
METHOD PRIVATE Hide : INT VAR_INPUT i : INT; END_VAR Hide := Kept(i); END_METHOD
METHOD PROTECTED Kept : INT VAR_INPUT i : INT; END_VAR Kept := Hide(i); END_METHOD
METHOD Swap VAR_IN_OUT i : INT; END_VAR END_METHOD
PROPERTY P : INT GET END_GET END_PROPERTY PROPERTY W : INT SET END_SET END_PROPERTY
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR c : C; x : INT; p : POINTER TO INT; END_VAR
{body}
END_PROGRAM"""
    (found,) = errors(text)
    assert (found.code, found.line) == (code, line) and words in f"{found.message} {found.hint}"


@pytest.mark.parametrize(
    "text, code, line",
    [
        ("METHOD m END_METHOD\nMETHOD m END_METHOD", "E0201", 4),
        ("METHOD m END_METHOD\nPROPERTY m : INT GET END_GET END_PROPERTY", "E0201", 4),
        ("METHOD v END_METHOD", "E0201", 3),
        ("METHOD a END_METHOD ACTION a END_ACTION", "E0201", 3),
        ("PROPERTY p : INT GET END_GET GET END_GET END_PROPERTY", "E0201", 3),
        ("METHOD m : Nowhere END_METHOD", "E0202", 3),
        ("METHOD m VAR x : INT; x : INT; END_VAR END_METHOD", "E0201", 3),
        ("METHOD m VAR_INST v : INT; w, w : INT; END_VAR END_METHOD", "E0201", 3),
        ("METHOD m : INT\nm := y;\nEND_METHOD", "E0301", 4),
        ("METHOD m : INT\nm := 1;\nEND_METHD\n", "E0115", 5),
        ("METHOD m : INT\nm := 1;\n", "E0103", 3),
        ("METHDO m : INT\nm := 1;\nEND_METHOD", "E0115", 3),
        ("PROPERTY p : INT\nGET\np := 1;\nEND_PROPERTY", "E0103", 4),
        ("METHOD m : INT\nIF v = 1 THEN\nm := 1;\nEND_METHOD", "E0103", 4),
    ],
)
def test_errors_of_declarations(text, code, line):
    (found,) = errors(f"FUNCTION_BLOCK C\nVAR v : INT; END_VAR\n{text}\nEND_FUNCTION_BLOCK\nPROGRAM p\nEND_PROGRAM")
    assert (found.code, found.line) == (code, line), found


def test_faults_name_the_instance():
    before = COUNTER + (
        "FUNCTION_BLOCK Line VAR c : ARRAY[0..3] OF Counter; END_VAR METHOD Go : INT VAR_INPUT i : INT; END_VAR\n"
        "Go := c[i].Far();\nEND_METHOD\nGo(i := 2);\nEND_FUNCTION_BLOCK"
    )
    fault = Run(program("line_();", "line_ : Line;", before)).fault()
    assert (fault.code, fault.instance) == ("F0103", "PLC_PRG.line_.Go.c[i].Far") and "outer" in fault.message
    fault = Run(program("line_.Go(8);", "line_ : Line;", before)).fault()
    assert (fault.code, fault.instance) == ("F0101", "PLC_PRG.line_.Go")
    fault = Run(program("x := c.Factorial(100000000);", "c : Counter; x : DINT;", COUNTER)).fault()
    assert fault.code == "F0105"


WITH_INIT = """
FUNCTION_BLOCK A
VAR_INPUT start : INT := 5; END_VAR
VAR seen, order : INT; p : POINTER TO INT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; n : INT := 1; place : POINTER TO INT; END_VAR
seen := start + n;
order := 1;
p := place;
IF bInitRetains AND NOT bInCopyCode THEN seen := seen + 1000; END_IF
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK B EXTENDS A
VAR own : INT; inner : A(n := 7); END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; n : INT := 2; END_VAR
own := n + order + inner.seen;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION Fresh : INT
VAR a : A(n := 3); END_VAR
Fresh := a.seen;
a.seen := 99;
END_FUNCTION
"""


def test_fb_init(sizes):
    r = run(
        "f1 := Fresh(); f2 := Fresh(); x := 78; through := c.p^;",
        "a : A; b : A(n := 10); x : INT := 77; c : A(n := 3, place := ADR(x)) := (start := 8); d : ARRAY[1..3] OF A;"
        "e : B(n := 30); f1, f2, through : INT;",
        WITH_INIT,
    )
    assert [r[n] for n in ("a.seen", "b.seen", "d[3].seen")] == [1006, 1015, 1006]
    assert (r["c.seen"], r["c.start"], r["through"]) == (1008, 8, 78)  # its initial values come after FB_init
    assert (r["e.seen"], r["e.inner.seen"], r["e.own"]) == (1035, 1012, 30 + 1 + 1012)  # inner ones, base, own
    assert r["f1"] == r["f2"] == 1008


def test_an_input_that_fb_init_has_not():
    (found,) = errors(program("", "a : A(m := 3);", WITH_INIT))
    assert (found.code, found.message) == ("E0306", "A has no member m")

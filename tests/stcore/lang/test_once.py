"""What is evaluated, and how often: places with calls in them, initial values of instances that calls make."""

from running import program, run

from stcore import paths, values
from stcore.build_program import build
from stcore.compiler import LIBRARY
from stcore.machine import Machine
from stcore.source import Source

NEXT = "FUNCTION Next : INT VAR_IN_OUT n : INT; END_VAR n := n + 1; Next := n; END_FUNCTION\n"


def test_the_place_of_a_for_variable_is_worked_out_once():
    made = run(
        "FOR a[Next(n)] := 10 TO 30 BY 10 DO sum := sum + a[1]; END_FOR\n"
        "FOR p[Next(m)].v := 1 TO 3 DO rounds := rounds + 1; m := 5; END_FOR\n"
        "FOR w[Next(k)].%B1 := 1 TO 3 DO ; END_FOR",
        "a : ARRAY[0..9] OF INT; n, m, k, sum, rounds : INT; q : ARRAY[0..9] OF S; p : POINTER TO S := ADR(q);"
        "w : ARRAY[0..3] OF WORD;",
        NEXT + "TYPE S : STRUCT pad : BYTE; v : LINT; END_STRUCT END_TYPE",
    )
    assert (made["n"], made["sum"], made["a"]) == (1, 60, [0, 40] + [0] * 8)
    assert (made["m"], made["rounds"], made["q[1].v"], made["q[2].v"]) == (5, 3, 4, 0)
    assert (made["k"], made["w"]) == (1, [0, 0x0400, 0, 0])


def test_the_place_of_an_inner_assignment_is_worked_out_once():
    made = run(
        "x := a[Next(n)] := b[Next(n)] := y; z := s[Next(m)].w.3 := TRUE; u := p[Next(k)] := 300;",
        "a, b : ARRAY[0..9] OF INT; n, m, k, x, y : INT; z : BOOL; s : ARRAY[0..2] OF S; bytes : ARRAY[0..3] OF BYTE;"
        "p : POINTER TO BYTE := ADR(bytes); u : DINT;",
        NEXT + "TYPE S : STRUCT pad : BYTE; w : WORD; END_STRUCT END_TYPE",
    )
    assert (made["n"], made["m"], made["k"]) == (2, 1, 1)
    assert (made["z"], made["s[1].w"], made["s[0].w"]) == (True, 8, 0)
    assert (made["bytes"], made["u"]) == ([0, 44, 0, 0], 44)


INSTANCES = """
VAR_GLOBAL base : INT := 100; END_VAR
FUNCTION Twice : INT VAR_INPUT n : INT; END_VAR Twice := 2 * n; END_FUNCTION
FUNCTION_BLOCK Inner
VAR a : INT := Twice(base); p : POINTER TO INT := ADR(a); b : INT := a + 1; name : STRING := CONCAT('n', 'm'); END_VAR
END_FUNCTION_BLOCK
FUNCTION_BLOCK Outer
VAR k : INT := Twice(3); in : ARRAY[0..1] OF Inner; sum : INT := in[1].b + k; END_VAR
END_FUNCTION_BLOCK
FUNCTION Use : INT
VAR_INPUT change : INT; END_VAR
VAR one : Inner; o : Outer := (in := [(a := 7)]); end : INT := one.b; END_VAR
base := base + change;
IF o.in[1].p <> ADR(o.in[1].a) OR o.in[0].name <> 'nm' THEN RETURN; END_IF
o.in[1].p^ := o.in[1].p^ + 1;
Use := one.b + o.sum + o.in[0].b + o.in[1].a + end;
END_FUNCTION
FUNCTION_BLOCK Holder
VAR_TEMP t : Inner; END_VAR
VAR_OUTPUT b : INT; END_VAR
b := t.b; t.b := 0;
END_FUNCTION_BLOCK
"""


def test_initial_values_of_instances_in_functions_are_worked_out_at_each_call():
    made = run(
        "x := Use(10); y := Use(0); h(); z := h.b; h(); z2 := h.b;", "x, y, z, z2 : INT; h : Holder;", INSTANCES
    )
    assert made["x"] == 201 + (201 + 6) + 8 + 201 + 201
    assert made["y"] == 221 + (221 + 6) + 8 + 221 + 221
    assert (made["z"], made["z2"]) == (221, 221)


def test_a_string_input_stays_what_it_was_whatever_the_library_writes(tmp_path):
    inputs = "VAR_INPUT p : POINTER TO BYTE; END_VAR"
    (tmp_path / "Put.st").write_text(f"FUNCTION Put : BOOL {inputs} p^ := 88; END_FUNCTION")
    (tmp_path / "PutPut.st").write_text(f"FUNCTION PutPut : BOOL {inputs} PutPut := Put(p); END_FUNCTION")
    (tmp_path / "PutAll.st").write_text(f"FUNCTION PutAll : BOOL {inputs} PutAll := PutPut(p); END_FUNCTION")
    text = program(
        "y := Keep(x, ADR(x));",
        "x : STRING := 'abc'; y : STRING;",
        "FUNCTION Keep : STRING VAR_INPUT s : STRING; p : POINTER TO BYTE; END_VAR PutAll(p); Keep := s; END_FUNCTION",
    )
    made, _ = build([Source(text, "case.st")], None, [LIBRARY, tmp_path], False)
    machine = Machine(made)
    machine.run(1)
    x, y = (values.read(machine.memory, paths.resolve(made, n)) for n in ("x", "y"))
    assert (x, y) == ("Xbc", "abc")

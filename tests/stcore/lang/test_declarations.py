"""Declarations that refer to each other: types in a circle of pointers, constants in any order."""

import pytest
from running import errors, program, run


def test_a_pointer_to_an_array_of_the_structure_it_stands_in():
    made = run(
        "tree[0].n := 1; tree[0].kids := ADR(leaves); leaves[2].n := 7; leaves[1].kids := ADR(leaves);"
        "x := tree[0].kids^[2].n; y := leaves[1].kids^[2].n; size := SIZEOF(tree[0].kids^); other := leaves;",
        "tree : ARRAY[0..1] OF Node; leaves, other : ARRAY[1..3] OF Node; x, y, size : INT;",
        "TYPE Node : STRUCT n : INT; kids : POINTER TO ARRAY[1..3] OF Node; deep : POINTER TO POINTER TO Node;"
        " END_STRUCT END_TYPE",
    )
    assert [made[n] for n in ("x", "y", "size", "other[2].n")] == [7, 7, 36, 7]


def test_types_that_lead_to_each_other_through_pointers():
    made = run(
        "a.next := ADR(b); b.own.n := 5; b.back := ADR(a); x := a.next^.own.n; a.next^.back^.n := 6; y := a.n; f();"
        " g.fs[1].n := 9; g.fs[1].owner := ADR(g); f.owner := ADR(g); z := f.owner^.fs[1].n;",
        "a : A; b : B; x, y, z : INT; f : F; g : G;",
        "TYPE A : STRUCT n : INT; next : POINTER TO B; row : POINTER TO ARRAY[0..1] OF B; END_STRUCT\n"
        "B : STRUCT own : A; back : POINTER TO A; END_STRUCT END_TYPE\n"
        "FUNCTION_BLOCK F VAR n : INT; owner : POINTER TO G; END_VAR END_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK G VAR fs : ARRAY[0..1] OF F; END_VAR END_FUNCTION_BLOCK",
    )
    assert [made[n] for n in ("x", "y", "z")] == [5, 6, 9]


def test_a_structure_that_holds_itself_is_still_an_error():
    kind = "TYPE A : STRUCT p : POINTER TO A; row : ARRAY[0..1] OF A; END_STRUCT END_TYPE"
    found = errors(program("", "a : A;", kind))
    assert [d.code for d in found] == ["E0203"]


def test_an_unknown_type_behind_a_pointer_is_one_error():
    found = errors(program("a.p^.n := 1;", "a : A;", "TYPE A : STRUCT p : POINTER TO Nowhere; END_STRUCT END_TYPE"))
    assert [d.code for d in found] == ["E0202"]


@pytest.mark.parametrize(
    "text",
    [
        "VAR_GLOBAL CONSTANT a : INT := b + 1; b : INT := a; END_VAR PROGRAM P END_PROGRAM",
        "VAR_GLOBAL CONSTANT a : INT := a; END_VAR PROGRAM P END_PROGRAM",
        "VAR_GLOBAL CONSTANT a : LREAL := SIN(b); b : LREAL := a; END_VAR PROGRAM P END_PROGRAM",
        "VAR_GLOBAL CONSTANT a : STRING := b; b : STRING := c; c : STRING := a; END_VAR PROGRAM P END_PROGRAM",
        "PROGRAM P VAR CONSTANT a : INT := b + 1; b : INT := a; END_VAR END_PROGRAM",
        "FUNCTION F : INT VAR CONSTANT a : INT := b + 1; b : INT := a; END_VAR END_FUNCTION PROGRAM P END_PROGRAM",
        "VAR_GLOBAL CONSTANT n : INT := SIZEOF(t); END_VAR VAR_GLOBAL t : ARRAY[0..n] OF BYTE; END_VAR"
        " PROGRAM P END_PROGRAM",
    ],
)
def test_constants_in_a_circle_are_one_error(text):
    found = errors(text)
    assert [d.code for d in found] == ["E0608"] and "->" in found[0].message


def test_constants_may_use_those_further_down():
    made = run(
        "x := A + UPPER_BOUND(row, 1) + F(); y := g;",
        "x, y : INT; row : ARRAY[0..A] OF INT; END_VAR VAR CONSTANT A : INT := B + 1; B : INT := C * 2; END_VAR"
        " VAR CONSTANT C : INT := D; D : INT := 3;",
        "VAR_GLOBAL CONSTANT g : INT := h + 1; h : INT := 4; END_VAR\n"
        "FUNCTION F : INT VAR CONSTANT p : INT := q + 1; q : INT := 10; END_VAR F := p; END_FUNCTION",
    )
    assert (made["x"], made["y"]) == (7 + 7 + 11, 5)


def test_a_constant_declared_twice_is_one_error():
    found = errors("PROGRAM P VAR CONSTANT a : INT := b; b : INT := 1; b : INT := 2; END_VAR END_PROGRAM")
    assert [(d.code, d.column) for d in found] == [("E0201", 52)]


CHILD = """FUNCTION_BLOCK Child VAR_IN_OUT p : Parent; END_VAR VAR_INPUT k : INT; END_VAR p.sum := p.sum + k;
END_FUNCTION_BLOCK
"""
PARENT = """FUNCTION_BLOCK Parent VAR a, b : Child; sum : INT; END_VAR a(p := THIS^, k := 3); b(p := THIS^, k := 4);
END_FUNCTION_BLOCK
"""


@pytest.mark.parametrize("units", [CHILD + PARENT, PARENT + CHILD], ids=["child", "parent"])
def test_a_block_may_be_given_the_block_that_holds_it(units):
    assert run("p(); p(); x := p.sum;", "p : Parent; x : INT;", units)["x"] == 14

"""Where implementations of ST differ: each line of the page "What differs" is a test here, named after it."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent / "lang"))

from running import Run, diagnostics, errors, program, run  # noqa: E402

from stcore.faults import Fault  # noqa: E402


def values(body: str, declarations: str, *names: str, before: str = "") -> tuple:
    made = run(body, declarations, before)
    return tuple(made[n] for n in names)


def test_integers_are_computed_in_the_larger_operand_type_at_least_dint():
    assert values(
        "d := a + a; l := big + 1; q := u / m; w := i * i / i;",
        "a : INT := 30000; d : DINT; big : LINT := 4000000000; l : LINT; u : UDINT := 4000000000; m : INT := 2;"
        "q : UDINT;"
        "i : INT := 300; w : INT;",
        "d", "l", "q", "w",
    ) == (60000, 4000000001, 2000000000, 300)  # fmt: skip


def test_a_constant_that_cannot_fit_is_a_warning():
    found = diagnostics(program("i := 40000;", "i : INT;"))
    assert [(d.code, d.severity, d.line, d.column) for d in found] == [("W0304", "warning", 6, 6)]


def test_int_32767_plus_1_stored_in_int_is_minus_32768():
    assert values("i := i + 1;", "i : INT := 32767;", "i") == (-32768,)


@pytest.mark.parametrize("op", ["/", "MOD"])
def test_integer_division_by_zero_is_a_located_fault(op):
    with pytest.raises(Fault) as caught:
        run(f"i := 1 {op} i;", "i : INT;")
    assert (caught.value.code, caught.value.line) == ("F0102", 6)


def test_real_division_by_zero_gives_inf():
    assert values("a := 1 / z; b := -1 / z; y := 1 / z;", "a, b, z : REAL; y : LREAL;", "a", "b", "y") == (
        float("inf"), float("-inf"), float("inf"),
    )  # fmt: skip


def test_index_out_of_range_is_a_located_fault():
    with pytest.raises(Fault) as caught:
        run("a[i] := 1;", "a : ARRAY[0..3] OF INT; i : INT := 4;")
    assert (caught.value.code, caught.value.line, caught.value.column) == ("F0101", 6, 3)


def test_real_to_int_rounds_half_away_from_zero_and_trunc_cuts():
    assert values(
        "a := REAL_TO_INT(r); b := REAL_TO_INT(s); c := TRUNC(s); d := REAL_TO_INT(2.5); e := REAL_TO_INT(-2.5);",
        "a, b, c, d, e : INT; r : REAL := 2.5; s : REAL := -7.9;", "a", "b", "c", "d", "e",
    ) == (3, -8, -7, 3, -3)  # fmt: skip


def test_conversion_out_of_range_wraps_for_integers_and_saturates_from_real():
    assert values(
        "a := DINT_TO_INT(d); b := REAL_TO_INT(r); c := REAL_TO_USINT(-r);",
        "a, b : INT; c : USINT; d : DINT := 65537; r : REAL := 1.0E9;",
        "a", "b", "c",
    ) == (1, 32767, 0)  # fmt: skip


def test_saturation_of_a_constant_is_a_warning():
    assert [d.severity for d in diagnostics(program("i := REAL_TO_INT(1.0E9);", "i : INT;"))] == ["warning"]


TOUCH = (
    "FUNCTION Touch : BOOL VAR_INPUT r : BOOL; END_VAR VAR_IN_OUT n : INT; END_VAR n := n + 1; Touch := r; END_FUNCTION"
)


def test_and_or_evaluate_both_sides_and_then_or_else_short_circuit():
    assert values(
        "x := Touch(FALSE, a) AND Touch(TRUE, a); x := Touch(TRUE, b) OR Touch(TRUE, b);"
        "x := Touch(FALSE, c) AND_THEN Touch(TRUE, c); x := Touch(TRUE, d) OR_ELSE Touch(TRUE, d);",
        "x : BOOL; a, b, c, d : INT;", "a", "b", "c", "d", before=TOUCH,
    ) == (2, 2, 1, 1)  # fmt: skip


def test_for_variable_is_one_step_past_the_end():
    assert values("FOR i := 1 TO 2 DO ; END_FOR FOR j := 5 TO 1 BY -2 DO ; END_FOR", "i, j : INT;", "i", "j") == (3, -1)


def test_for_to_the_last_value_of_the_type_ends():
    assert values("FOR i := 250 TO 255 DO n := n + 1; END_FOR", "i : USINT; n : INT;", "n") == (6,)


def test_for_end_and_step_are_evaluated_once():
    assert values(
        "FOR i := 1 TO e BY s DO e := 100; s := 1; n := n + 1; END_FOR", "i, n : INT; e : INT := 5; s : INT := 2;", "n"
    ) == (3,)


def test_minus_binds_tighter_than_power_which_groups_from_the_left():
    assert values(
        "a := -x ** 2; b := 0 - x ** 2; c := 2 ** 3 ** 2; d := 2 ** -1; e := -2 ** 2; f := NOT k ** 2 = 0;",
        "a, b, c, d, e : LREAL; x : LREAL := 3; k : DINT := 0; f : BOOL;", "a", "b", "c", "d", "e", "f",
    ) == (9.0, -9.0, 64.0, 0.5, 4.0, False)  # fmt: skip


def test_mux_and_sel_take_the_nearest_legal_input():
    assert values(
        "a := MUX(i, 10, 20, 30); i := -7; b := MUX(i, 10, 20, 30);", "a, b : INT; i : INT := 9;", "a", "b"
    ) == (30, 10)


def test_sel_and_mux_evaluate_only_the_input_that_they_take():
    assert values(
        "a := SEL(n = 0, x / n, -1); b := SEL(n <> 0, -2, x MOD n); c := MUX(n + 1, x / n, 7);"
        "t := SEL(f, Touch(TRUE, i), Touch(TRUE, j)); u := MUX(1, Touch(TRUE, k), Touch(FALSE, l));",
        "a, b, c, n, i, j, k, l : INT; x : INT := 9; f, t, u : BOOL;",
        "a", "b", "c", "i", "j", "k", "l", before=TOUCH,
    ) == (-1, -2, 7, 1, 0, 0, 1)  # fmt: skip


def scanned(block: str, call: str, names: list[str], scans: int = 2) -> list[tuple]:
    made = Run(program(f"x({call});", f"x : {block}; on : BOOL;"))
    rows = []
    for _ in range(scans):
        made.scan()
        rows.append(tuple(made[f"x.{n}"] for n in names))
    return rows


def test_ton_starts_at_0_and_is_done_at_once_when_pt_is_0():
    assert scanned("TON", "IN := TRUE, PT := T#1ms", ["ET", "Q"]) == [(0.0, False), (0.001, True)]
    assert scanned("TON", "IN := TRUE, PT := T#0ms", ["ET", "Q"], 1) == [(0.0, True)]


def test_f_trig_on_the_first_scan_with_clk_false_is_false():
    assert scanned("F_TRIG", "CLK := FALSE", ["Q"]) == [(False,), (False,)]


def test_time_is_32_bit_ms_and_ltime_64_bit_ns():
    assert values("a := SIZEOF(t); b := SIZEOF(l); c := TIME_TO_DINT(t); d := LTIME_TO_LINT(l);",
                  "t : TIME := T#1s5ms; l : LTIME := LT#1us; a, b, c : DINT; d : LINT;", "a", "b", "c", "d",
                  ) == (4, 8, 1005, 1000)  # fmt: skip


def test_string_without_length_has_80():
    assert values("n := SIZEOF(s);", "s : STRING; n : INT;", "n") == (81,)


def test_word_to_string_42():
    assert values("s := WORD_TO_STRING(42);", "s : STRING;", "s") == ("42",)


def test_real_to_string_is_the_shortest_text_that_reads_back():
    assert values("a := REAL_TO_STRING(3.14); b := LREAL_TO_STRING(0.1);", "a, b : STRING;", "a", "b") == (
        "3.14",
        "0.1",
    )


def test_s_r_st_ld_are_names():
    assert values("s := 1; r := s + 1; st := r + 1; ld := st + 1;", "s, r, st, ld : INT;", "s", "r", "st", "ld") == (
        1,
        2,
        3,
        4,
    )


def test_initial_values_of_elements_members_and_nested_structs():
    before = (
        "TYPE In : STRUCT a : INT := 3; END_STRUCT Out : STRUCT i : In := (a := 4); l : ARRAY[0..1] OF In;"
        " END_STRUCT END_TYPE\n"
        "FUNCTION_BLOCK F VAR o : ARRAY[0..1] OF Out := [(i := (a := 7))]; t : INT := K * 2; p : INT := t + 1; END_VAR"
        " VAR CONSTANT K : INT := 21; END_VAR END_FUNCTION_BLOCK"
    )
    made = run("", "f : ARRAY[0..1] OF F;", before)
    got = [made[f"f[1].{n}"] for n in ("o[0].i.a", "o[1].i.a", "o[0].l[1].a", "t", "p")]
    assert got == [7, 4, 3, 42, 43]


def test_an_omitted_input_of_a_function_is_its_initial_value_of_a_block_the_value_it_had():
    before = (
        "FUNCTION G : INT VAR_INPUT a : INT := 5; END_VAR G := a; END_FUNCTION\n"
        "FUNCTION_BLOCK B VAR_INPUT a : INT := 5; END_VAR VAR_OUTPUT o : INT; END_VAR o := a; END_FUNCTION_BLOCK"
    )
    assert values("G(9); x := G(); b(a := 9); b(); y := b.o;", "b : B; x, y : INT;", "x", "y", before=before) == (5, 9)


@pytest.mark.parametrize(("body", "hint"), [("b := i;", "INT_TO_BOOL"), ("i := b;", "BOOL_TO_INT")])
def test_bool_and_integer_only_by_conversion_function(body, hint):
    found = errors(program(body, "b : BOOL; i : INT;"))
    assert [d.code for d in found] == ["E0302"] and hint in found[0].hint


@pytest.mark.parametrize(
    ("body", "name"), [("i := Abss(1);", "ABS"), ("t(INN := TRUE);", "IN"), ("i := LIMITT(1, 2, 3);", "LIMIT")]
)
def test_unknown_function_or_pin_is_an_error_with_the_nearest_name(body, name):
    found = errors(program(body, "t : TON; i : INT;"))
    assert len(found) == 1 and name in found[0].hint


def test_a_missing_end_for_is_one_error_at_its_for():
    found = errors(program("FOR i := 0 TO 3 DO\n  i := i;\n\nIF i = 0 THEN i := 1; END_IF", "i : INT;"))
    assert len(found) == 1 and "END_FOR" in found[0].message


def test_else_if_suggests_elsif():
    found = errors(program("IF i = 0 THEN i := 1;\nELSE IF i = 1 THEN i := 2;\nEND_IF", "i : INT;"))
    assert len(found) == 1 and "ELSIF" in f"{found[0].message} {found[0].hint}"


def test_a_duplicate_declaration_points_at_both_places():
    found = errors("PROGRAM P\nVAR\n  a : INT;\n  A : REAL;\nEND_VAR\nEND_PROGRAM")
    assert [(d.code, d.line) for d in found] == [("E0201", 4)] and "line 3" in found[0].message


def test_what_other_compilers_trip_over_works():
    made = run(
        "{vendor pragma} s := 'abcdef'; FOR i := 0 TO 3 DO IF i = 1 THEN CONTINUE; END_IF n := n + i; END_FOR "
        "c := E#two; u.w := 16#0102; f(); f.Act();",
        "s : STRING(3); t : TON := (PT := T#2s); t2 : TON(PT := T#3s); i, n : INT; c : E; u : U; f : F;",
        "TYPE E : (one := 1, two); U : UNION w : WORD; b : ARRAY[0..1] OF BYTE; END_UNION END_TYPE\n"
        "VAR_GLOBAL PERSISTENT k : INT := 5; END_VAR\n"
        "FUNCTION_BLOCK F VAR n : INT; END_VAR END_FUNCTION_BLOCK ACTION Act: n := 7; END_ACTION",
    )
    assert [made[n] for n in ("s", "t.PT", "t2.PT", "n", "c", "u.b[0]", "k", "f.n")] == ["abc", 2.0, 3.0, 5, 2, 2, 5, 7]

"""Printed listings: what is mended, and said so; every listing of the manuals reads."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from stcore import parser
from stcore import syntax as s
from stcore.diagnostics import Reporter
from stcore.source import Source, read

_MANUALS = Path(__file__).parents[3] / "shared" / "manuals"
_INDEX = _MANUALS / "listings" / "INDEX.csv"


def diagnose(text: str, strict: bool = False) -> tuple[s.File, Reporter]:
    reporter = Reporter(strict)
    return parser.parse(Source(text), reporter), reporter


def program(body: str) -> str:
    return f"PROGRAM p\nVAR x : INT; END_VAR\n{body}\nEND_PROGRAM\n"


@pytest.mark.parametrize(
    "text, code, line",
    [
        (program("f(‘a’);"), "W0101", 3),
        (program("x = 5;"), "W0102", 3),
        (program("a := 1;\nvel = velPre = 0;"), "W0102", 4),
        (program("FOR i = 0 TO 9 DO ; END_FOR"), "W0102", 3),
        ("PROGRAM p\nVAR x : INT = 5; END_VAR\nEND_PROGRAM", "W0102", 2),
        (program("CASE x OF 1: y = 5; END_CASE"), "W0102", 3),
        (program("rtn:GT_RunThread(0);"), "W0103", 3),
        (program("x : 5;"), "W0103", 3),
        ("VAR_GLOBAL CONSTANT\nAXIS : INT := 1\nTABLE : INT := 2;\nEND_VAR", "W0104", 2),
        ("VAR_GLOBAL\nx : INT\nEND_VAR", "W0104", 2),
        (program("x := 1\nIF x = 2 THEN ; END_IF"), "W0104", 3),
        (program("f(1,\n2)\ng(3);"), "W0104", 4),
        ("PROGRAM p\nVAR x : INT; END_VAR\n-----\nx := 1;\nEND_PROGRAM", "W0105", 3),
        ("PROGRAM p\nVAR x : INT; END_VAR\n_____\nx := 1;\nEND_PROGRAM", "W0105", 3),
        (program("......\nx := 1;"), "W0106", 3),
        (program("x := 1; ... ..."), "W0106", 3),
        ("PROGRAM p\nx := 1;\n", "W0107", 2),
        ("FUNCTION f : INT\nf := 1;\nPROGRAM p\nEND_PROGRAM", "W0107", 2),
        ("x := 1;\nf(x);", "W0108", 1),
        ("VAR x : INT; END_VAR", "W0108", 1),
        ("Rtn : INT; First : BOOL := TRUE;\nIF First THEN rtn := f(1); END_IF", "W0108", 1),
        (program("x := f(FOLLOW_SEGMENT_ CONTINUE, 0);"), "W0109", 3),
        (program("x := GT LnXY(1, 2);"), "W0109", 3),
        ("TYPE t : STRUCT a : INT; END_STRUCT\nEND TYPE", "W0109", 2),
        (program("f(Axis:= , Execute:= , Done=> );"), "W0110", 3),
        (program("f(‘a);"), "W0111", 3),
        (program("x := 1；"), "W0112", 3),
        ("TYPE t : ARRAY[07] OF INT; END_TYPE", "W0113", 1),
        (program("f(Axis:= a\nData:= b);"), "W0114", 3),
        (program("x := a – 1;"), "W0112", 3),
        (program("IF a ≤ b THEN ; END_IF"), "W0112", 3),
        (program("x : = 5;"), "W0112", 3),
        (program("x :＝ 5;"), "W0112", 3),
        (program("f(a ＝＞ x);"), "W0112", 3),
        (program("x := 1; （* a note *）"), "W0112", 3),
        (program("x := 1; (* a note *）\nx := 2; (* b *)"), "W0112", 3),
        (program("x := 1; ( * a note * )"), "W0112", 3),
        (program("x := 1; ／／ a note"), "W0112", 3),
        (program("CASE x OF 1…3: y := 1; END_CASE"), "W0112", 3),
        (program("x := １０．５;"), "W0109", 3),
        (program("ＩＦ x THEN ; END_IF"), "W0109", 3),
        (program("FOLLOW_SEGMENT_\u00a0CONTINUE := 1;"), "W0109", 3),
        (program("x := 1;\n- 34 -\ny := 2;"), "W0105", 4),
        (program("x := 1;\n128\ny := 2;"), "W0105", 4),
        (program("CASE x OF 1: y := 1;\n128\ny := 2; END_CASE"), "W0105", 4),
        (program("f(Axis:= 1,\n- 34 -\nData:= b);"), "W0105", 4),
        (program("x := 1;\nPage 12 of 300\ny := 2;"), "W0105", 4),
        (program("x := 1;\nExample 7-1 (continued)\ny := 2;"), "W0105", 4),
        (program("x := 1;\n© 2015 A. Company\ny := 2;"), "W0105", 4),
        (program("x := 1;\n第 12 页\ny := 2;"), "W0105", 4),
        (program("x := 1;\n──────\ny := 2;"), "W0105", 4),
        ("```iecst\nPROGRAM p\nEND_PROGRAM", "W0105", 1),
        (program("• x := 1;"), "W0115", 3),
        ("1 PROGRAM p\n2 VAR x : INT; END_VAR\n3 x := 1;\n4 END_PROGRAM", "W0115", 1),
        ("001: PROGRAM p\n003: x := 1;\n004: END_PROGRAM\n", "W0115", 1),
        ("> PROGRAM p\n> x := 1;\n>\n> END_PROGRAM\n", "W0115", 1),
        ("{attribute ‘test’}\nPROGRAM p\nEND_PROGRAM", "W0101", 1),
    ],
)
def test_a_mend_is_one_warning(text, code, line):
    _, reporter = diagnose(text)
    assert [(d.severity, d.code, d.line) for d in reporter.diagnostics] == [("warning", code, line)]
    _, strict = diagnose(text, strict=True)
    assert [(d.severity, d.code) for d in strict.diagnostics] == [("error", code)]


@pytest.mark.parametrize(
    "text",
    [
        program("CASE x OF\n1: y := 1;\n2: y := 2;\nEND_CASE"),
        "VAR_GLOBAL\na : ARRAY[0..1] OF INT := [\n1,\n128\n];\nEND_VAR",
        program("x := a\n- 34\n- b;"),
        program("CASE x OF\n128\n: y := 1;\nEND_CASE"),
        program("(* © 2015\nPage 12 of 300\n1 note\n*) // 第 12 页\nx := '©'; Page := 1; Example(3);"),
        program("x := 'a ： b – c'; // ≤ （* ／／"),
        program("x := 1; (* speed（*mm*）and more *) y := 2;"),
        program("x :=\u00a01;\u3000y := GT_Set\u00adVel;"),
    ],
)
def test_what_is_no_trace_of_print_stays(text):
    _, reporter = diagnose(text)
    assert not reporter.diagnostics


def test_without_mending_it_is_an_error():
    reporter = Reporter()
    parser.parse(Source(program("x = 5;")), reporter, mend=False)
    assert reporter.failed and not reporter.strict


def body(text: str) -> list[s.Node]:
    tree, reporter = diagnose(program(text))
    assert not reporter.failed
    return tree.units[0].body


def test_equals_signs_in_a_row_assign_from_the_right():
    (node,) = body("a = b = c = 0;")
    targets = []
    while isinstance(node, s.Assign):
        targets.append(node.target.name)
        node = node.value
    assert targets == ["a", "b", "c"] and node.value == 0


def test_a_comparison_in_brackets_stays_one():
    (node,) = body("a = (b = 0);")
    assert isinstance(node.value, s.Binary) and node.value.op == "="
    (node,) = body("a := b = 0;")
    assert isinstance(node.value, s.Binary)


def test_a_label_that_is_jumped_to_stays_one():
    label, call, _ = body("again: f(1); JMP again;")
    assert isinstance(label, s.Label) and isinstance(call, s.ExprStmt)
    (case,) = body("CASE x OF one: f(1); END_CASE")
    assert case.branches[0][0][0].name == "one"


def test_a_colon_for_an_assignment():
    first, second = body("rtn:GT_Reset(); x : 5;")
    assert (first.target.name, second.target.name, second.value.value) == ("rtn", "x", 5)


def test_joined_names():
    first, second = body("x := f(0, FOLLOW_SEGMENT_ CONTINUE, 1); x := GT LnXY(1);")
    assert first.value.args[1].value.name == "FOLLOW_SEGMENT_CONTINUE"
    assert second.value.callee.name == "GT_LnXY"


def test_statements_alone_become_a_program():
    tree, _ = diagnose("a, b : INT;\nf : TTrapPrm;\nrtn:GT_Reset();\nb := a;")
    (pou,) = tree.units
    assert (pou.kind, pou.name, [d.name for d in pou.sections[0].decls]) == ("PROGRAM", "PLC_PRG", ["a", "b", "f"])
    assert [type(n) for n in pou.body] == [s.Assign, s.Assign]


def test_globals_then_statements():
    tree, reporter = diagnose("VAR_GLOBAL a : INT; END_VAR\na := 1;")
    assert [type(u) for u in tree.units] == [s.VarSection, s.Pou] and not reporter.failed


@pytest.mark.parametrize(
    "text, wanted",
    [
        (program("IF x = 1 THEN\nx := 2;\n"), "END_IF is missing for the IF at line 3"),
        (program("x > 1 THEN x := 2; END_IF"), "IF is missing before x"),
        (program("x := f(vel Max);"), ", is missing after vel"),
    ],
)
def test_what_is_ambiguous_stays_an_error(text, wanted):
    _, reporter = diagnose(text)
    assert [d.message for d in reporter.diagnostics] == [wanted]


def _rows() -> list[dict]:
    if not _INDEX.exists():
        return []
    with _INDEX.open(encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if row["file"].endswith(".st")]


_NO_ST = {"am14", "am17", "am22", "am24"}  # formulas with prose in brackets

# complete = no: what the listing has lost, as the parser sees it
_LOST = {
    "guc04": 1,  # sizeof(crdPrn<tab>n)
    "guc05": 1,  # an END_IF
    "guc06": 2,  # an END_IF stuck to the next word, and the body of the last IF
    "guc07": 1,  # I.INT, for I:INT;
    "guc13": 1,  # key<>"
    "guc15": 1,  # vel Max_x
}


@pytest.mark.skipif(not _INDEX.exists(), reason="the manuals are not beside this checkout")
def test_there_are_listings():
    assert len(_rows()) > 80


@pytest.mark.parametrize("row", _rows(), ids=lambda r: r["id"])
def test_every_listing_reads(row):
    reporter = Reporter()
    tree = parser.parse(read(_MANUALS / row["file"]), reporter)
    errors = [d for d in reporter.diagnostics if d.severity == "error"]
    if row["id"] in _NO_ST:
        assert errors
    else:
        assert tree.units
        assert len(errors) <= _LOST.get(row["id"], 0), [d.message for d in errors]

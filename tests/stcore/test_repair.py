"""Syntax errors: one for one slip, in the user's words, at its place; never a crash, whatever the text."""

from __future__ import annotations

import random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stcore import lexer, parser
from stcore import syntax as s
from stcore.diagnostics import Reporter
from stcore.source import Source


def errors(text: str) -> list:
    reporter = Reporter()
    parser.parse(Source(text), reporter)
    return [d for d in reporter.sorted() if d.severity == "error"]


def program(body: str) -> str:
    return f"PROGRAM p\nVAR x : INT; END_VAR\n{body}\nEND_PROGRAM\n"


@pytest.mark.parametrize(
    "body, place, message, hint",
    [
        ("IF x = 1 x := 2; END_IF", (3, 9), "THEN is missing after the condition of IF", ""),
        ("IF x = 1 THNE x := 2; END_IF", (3, 10), "THNE is not expected here", "did you mean THEN?"),
        ("IF x = 1 THEN x := 2; END_FI;", (3, 23), "END_FI is not expected here", "did you mean END_IF?"),
        ("IF x = 1 THEN x := 2; ENDIF", (3, 23), "ENDIF is not expected here", "did you mean END_IF?"),
        ("WHILE x = 1 x := 2; END_WHILE", (3, 12), "DO is missing after the condition of WHILE", ""),
        ("FOR x := 1 TO 2 x := 2; END_FOR", (3, 16), "DO is missing after the head of FOR", ""),
        ("CASE x 1: x := 2; END_CASE", (3, 7), "OF is missing after the value of CASE", ""),
        ("x := 1 x := 2;", (3, 7), "; is missing after 1", ""),
        ("f(1, 2;", (3, 7), ") is missing for the ( at line 3, column 2", ""),
        ("x := (1 + 2 * 3;", (3, 16), ") is missing for the ( at line 3, column 6", ""),
        ("x := a[1;", (3, 9), "] is missing for the [ at line 3, column 7", ""),
        ("x := 1);", (3, 7), ") is not expected here", ""),
        ("x := ;", (3, 5), "a value is missing before ;", ""),
        ("x := 1 + * 2;", (3, 9), "a value is missing before *", ""),
        ("x := := 1;", (3, 6), ":= stands here twice", "remove one"),
        ("IF IF x = 1 THEN END_IF", (3, 4), "IF stands here twice", "remove one"),
        ("x := 1; END_IF", (3, 9), "END_IF without IF", "remove it"),
        ("x > 1 THEN x := 2; END_IF", (2, 21), "IF is missing before x", ""),
        ("FOR x := 1 TO 3 DO x := 2; END_IF", (3, 28), "END_IF is not expected here", "did you mean END_FOR?"),
        ("IF x = 1 THEN\n x := 2;\nELSE IF x = 2 THEN\n x := 3;\nEND_IF", (5, 1), "ELSE IF opens", "ELSIF"),
        ("x := 1;\nVAR y : INT; END_VAR\nx := 2;", (4, 1), "VAR belongs before the statements", ""),
        ("to := 1;", (3, 1), "to is a reserved word and can't be a name", ""),
        ("f(a, b c);", (3, 7), ", is missing after b", ""),
    ],
)
def test_messages(body, place, message, hint):
    (error,) = errors(program(body))
    assert ((error.line, error.column), error.message[: len(message)]) == (place, message)
    assert hint in error.hint


@pytest.mark.parametrize(
    "text, line, message",
    [
        ("PROGRAM p\nVAR x INT; END_VAR\nEND_PROGRAM", 2, ": is missing after x"),
        ("PROGRAM p\nVAR x : ; y : INT; END_VAR\nEND_PROGRAM", 2, "a type is missing before ;"),
        ("PROGRAM p\nVAR x : ARRAY[0..3] INT; END_VAR\nEND_PROGRAM", 2, "OF is missing after the bounds of ARRAY"),
        ("PROGRAM p\nVAR x : INT 5; END_VAR\nEND_PROGRAM", 2, ":= is missing after INT"),
        ("PROGRAM p\nVAR x : INT;\nx := 1;\nEND_PROGRAM", 2, "END_VAR is missing for the VAR at line 2"),
        ("PROGRAM p\nx : INT; y : INT; END_VAR\nx := 1;\nEND_PROGRAM", 1, "VAR is missing before x"),
        ("PROGRAM p\nVARR x : INT; END_VAR\nEND_PROGRAM", 2, "VARR is not expected here"),
        ("PROGRM p\nVAR x : INT; END_VAR\nx := 1;\nEND_PROGRAM", 1, "PROGRM is not expected here"),
        ("p\nVAR x : INT; END_VAR\nx := 1;\nEND_PROGRAM", 1, "PROGRAM is missing before p"),
        ("PROGRAM\nVAR x : INT; END_VAR\nx := 1;\nEND_PROGRAM", 1, "a name is missing before VAR"),
        ("TYPE t : STRUCT a : INT; END_TYPE", 1, "END_STRUCT is missing for the STRUCT at line 1"),
        ("TYPE t : STRUCT a : INT; END_STRUCT", 1, "END_TYPE is missing for the TYPE at line 1"),
        ("PROGRAM p\nVAR a.b : INT; END_VAR\nEND_PROGRAM", 2, "a.b is not a name that can be declared"),
        ("PROGRAM p\nVAR a : ARRAY[5] OF INT; END_VAR\nEND_PROGRAM", 2, "an array needs a lowest and a highest index"),
        ("ACTION a: x := 1; END_ACTION", 1, "the ACTION a belongs to no program"),
        ("METHOD m : INT\nm := 1;\nEND_METHOD", 1, "the METHOD m belongs to no program"),
        ("PROPERTY p : INT\nGET END_GET\nSET END_SET\nEND_PROPERTY", 1, "the PROPERTY p belongs to no program"),
        ("INTERFACE i\nMETHOD m : INT\nm := 1;\nEND_METHOD\nEND_INTERFACE", 3, "a method of the INTERFACE i has no"),
        ("FUNCTION_BLOCK f\nPROPERTY p : INT\nEND_PROPERTY\nEND_FUNCTION_BLOCK", 2, "GET or SET is missing"),
    ],
)
def test_messages_of_declarations(text, line, message):
    (error,) = errors(text)
    assert (error.line, error.message[: len(message)]) == (line, message)


@pytest.mark.parametrize("first", ["1 : INT;", ": a INT;", ":= : INT;", "[ : INT;", "'a' : INT;"])
def test_a_wrong_first_declaration_takes_no_other_with_it(first):
    text = f"PROGRAM p\nVAR\n  {first}\n  t : TON;\n  b : INT;\nEND_VAR\nb := 1;\nEND_PROGRAM\n"
    reporter = Reporter()
    tree = parser.parse(Source(text), reporter)
    assert [(d.code, d.line) for d in reporter.diagnostics] == [("E0101", 3)]
    (pou,) = tree.units
    assert [d.name for d in pou.sections[0].decls] == ["t", "b"] and len(pou.body) == 1


def test_a_missing_end_is_told_at_the_block_it_belongs_to():
    text = program("IF x = 1 THEN\n  FOR x := 1 TO 3 DO\n    x := 2;\nEND_IF\nIF x = 2 THEN\n  x := 1;\nEND_IF")
    (error,) = errors(text)
    assert (error.line, error.message) == (4, "END_FOR is missing for the FOR at line 4")


def test_indentation_tells_which_of_two_blocks_of_a_kind_is_open():
    (error,) = errors(program("IF x = 1 THEN\n  IF x = 2 THEN\n    x := 3;\nEND_IF\nx := 4;"))
    assert error.line == 4
    (error,) = errors(program("IF x = 1 THEN\n  IF x = 2 THEN\n    x := 3;\n  END_IF\nx := 4;"))
    assert error.line == 3


def test_all_errors_of_a_file_in_one_pass():
    slips = ["x := ;", "IF x THNE x := 1; END_IF", "f(1, 2;", "y := 1 + * 2;", "x := 1));"]
    good = "FOR x := 1 TO 5 DO x := x + 1; f(x); END_FOR\n" * 3
    found = errors(program(good.join(f"{slip}\n" for slip in slips)))
    assert [e.line for e in found] == [3, 7, 11, 15, 19]


def test_what_follows_an_error_is_understood():
    tree = parser.parse(Source(program("x := ;\nIF x = 1 THNE y := 2; END_IF\nz := 3;")), Reporter())
    assert [type(n) for n in tree.units[0].body] == [s.Assign, s.If, s.Assign]


def test_one_odd_character_is_one_error():
    for body in ("x := 1 ? 2;", "f(1, g(2?, 3);", "x ?= 5;", "IF x = 1 ? 2 THEN ; END_IF", "x := 5?"):
        assert [e.code for e in errors(program(body))] == ["E0105"]


# --------------------------------------------------------------------------------------------- every single slip

_PROGRAM = """TYPE Phase : (stop, ready := 2, go) INT; END_TYPE
TYPE Rec : STRUCT a, b : INT := 5; c : ARRAY[0..3] OF LREAL := [4(1.5)]; END_STRUCT END_TYPE
VAR_GLOBAL CONSTANT N : INT := 10; END_VAR
FUNCTION mean : LREAL
VAR_INPUT values : POINTER TO LREAL; count : INT; END_VAR
VAR i : INT; sum : LREAL; END_VAR
FOR i := 0 TO count - 1 DO
  sum := sum + values[i];
END_FOR
mean := sum / INT_TO_LREAL(count);
END_FUNCTION
PROGRAM PLC_PRG
VAR
  state : Phase := Phase.go;
  timer : TON := (PT := T#500ms);
  rec : Rec := (a := 1, c := [1, 2, 3, 4]);
  text : STRING(20) := 'start';
  start AT %IX0.0 : BOOL;
END_VAR
timer(IN := start AND NOT timer.Q, PT := T#2s);
IF timer.Q OR rec.a > 3 THEN
  state := Phase.stop;
  rec.c[1] := mean(ADR(rec.c), 4) * -2.0;
ELSIF start THEN
  text := CONCAT(text, '!');
ELSE
  WHILE rec.b > 0 DO
    rec.b := rec.b - 1;
    IF rec.b.3 THEN EXIT; END_IF;
  END_WHILE
END_IF
CASE state OF
  Phase.stop, Phase.ready: rec.a := rec.a + 1;
  Phase.go:
    REPEAT
      rec.a := rec.a MOD 7;
    UNTIL rec.a < 5 END_REPEAT
ELSE
  RETURN;
END_CASE
END_PROGRAM
"""


def _misspelt(word: str, rng: random.Random) -> str:
    if len(word) < 2:
        return word + word if word.isalnum() else "?"
    at = rng.randrange(len(word) - 1)
    return (
        word[:at] + word[at + 1] + word[at] + word[at + 2 :],
        word[:at] + word[at + 1 :],
        word[: at + 1] + word[at:],
    )[rng.randrange(3)]


@pytest.mark.parametrize("slip", ["deleted", "doubled", "misspelt"])
def test_one_slip_one_diagnostic(slip):
    assert not errors(_PROGRAM)
    tokens = lexer.tokenize(Source(_PROGRAM), Reporter())
    rng = random.Random(1)
    counts = []
    for start, end in zip(tokens.starts[:-1], tokens.ends[:-1], strict=True):
        word = _PROGRAM[start:end]
        changed = {"deleted": "", "doubled": f"{word} {word}", "misspelt": _misspelt(word, rng)}[slip]
        counts.append(len(errors(_PROGRAM[:start] + changed + _PROGRAM[end:])))
    assert max(counts) <= 4
    assert sum(c <= 2 for c in counts) >= 0.99 * len(counts)
    assert sum(c <= 1 for c in counts) >= 0.95 * len(counts)


# ---------------------------------------------------------------------------------------------------- robustness


@pytest.mark.parametrize(
    "text",
    [
        "x := " + "(" * 10_000 + "1" + ")" * 10_000 + ";",
        "x := " + "a[" * 10_000 + "1" + "]" * 10_000 + ";",
        "x := " + "f(" * 10_000 + ")" * 10_000 + ";",
        "x := " + "NOT " * 10_000 + "y;",
        "x := a" + "[1]" * 10_000 + ";",
        "x := p" + "^" * 10_000 + ";",
        "x := a" + ".b" * 10_000 + ";",
        "x := " * 10_000 + "1;",
        "IF a THEN " * 10_000,
        "x := " + "1 + " * 10_000 + "1;",
    ],
    ids=[
        "brackets",
        "indices",
        "calls",
        "not",
        "index chain",
        "deref chain",
        "members",
        "assignments",
        "blocks",
        "sum",
    ],
)
def test_deep_nesting_is_one_error(text):
    found = errors(program(text))
    assert [e.code for e in found] in (["E0113"], ["E0120"])


@pytest.mark.parametrize(
    "text",
    [
        "", " ", "\n" * 1000, "(*", "{", "'", '"', "‘", "?" * 10_000, ")" * 10_000, "END_IF " * 5_000, "a " * 20_000,
        "PROGRAM", "PROGRAM p VAR", "TYPE", "x := 5", ":=", ";", "METHOD", "METHOD m", "{IF defined(x)}" * 500,
        "IF x THEN y = ; END_FOR ( [ " * 300, "a := b +* c;\n" * 1000, "a:\n" * 2000, "\x00\ufffd", "1" * 10_000,
        "ACTION a", "VAR x : INT; END_VAR VAR", "REPEAT", "CASE", "ELSE IF a THEN " * 200, "- " * 5000, "x AT",
    ],
    ids=range(33),
)  # fmt: skip
def test_nothing_crashes(text):
    for whole in (text, program(text)):
        assert isinstance(parser.parse(Source(whole), Reporter()), s.File)


_SIGNS = ":= .. => <> x a.b 5 1.5 16#F T#5s 'text' %IX0.0 \n (* *) // {IF defined(x)} {END_IF} ----- .... GT".split(" ")
_PIECES = st.sampled_from(sorted(lexer.WORDS) + list("()[];:,.^=+-*/<>&#'\"{}‘’?") + _SIGNS)


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.lists(_PIECES, max_size=60))
def test_any_heap_of_tokens(pieces):
    parser.parse(Source(" ".join(pieces)), Reporter())
    parser.parse(Source(program(" ".join(pieces))), Reporter())


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.text(max_size=200))
def test_any_text(text):
    parser.parse(Source(text), Reporter())
    parser.parse_expression(Source(text), Reporter())
    parser.parse_initializer(Source(text), Reporter())
    parser.parse_statements(Source(text), Reporter())


@settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.integers(0, len(_PROGRAM)), st.integers(0, 200), st.lists(_PIECES, max_size=5))
def test_any_part_replaced(start, length, pieces):
    parser.parse(Source(_PROGRAM[:start] + " ".join(pieces) + _PROGRAM[start + length :]), Reporter())

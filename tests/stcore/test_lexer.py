"""Tokens: kinds, literals, comments, pragmas, and what is no token."""

from __future__ import annotations

import pytest

from stcore import literals
from stcore.diagnostics import Reporter
from stcore.lexer import TERMINALS, tokenize
from stcore.source import Source


def lex(text: str) -> tuple[list[str], list[str]]:
    """Kinds of the tokens, without $END, and the codes reported."""
    reporter = Reporter()
    tokens = tokenize(Source(text), reporter)
    return [TERMINALS[k] for k in tokens.kinds[:-1]], [d.code for d in reporter.diagnostics]


def kinds(text: str) -> str:
    found, codes = lex(text)
    assert not codes
    return " ".join(found)


@pytest.mark.parametrize(
    "text, wanted",
    [
        ("a_1 Größe 变量", "NAME NAME NAME"),
        ("if If IF", "IF IF IF"),
        ("s r st ld begin end n t pi it d", " ".join(["NAME"] * 11)),
        ("interval priority single step get set read_only with on task", " ".join(["NAME"] * 10)),
        ("INT TON BOOL", "NAME NAME NAME"),
        ("VAR_INPUT VAR_GLOBAL END_VAR CONSTANT", "VAR VAR_GLOBAL END_VAR QUALIFIER"),
        ("1..5", "NUMBER DOTDOT NUMBER"),
        ("1.5 1.5E-3 1e3 16#FF 2#1010_0110 1_000", " ".join(["NUMBER"] * 6)),
        ("16#FE-3", "NUMBER SIGN NUMBER"),
        ("x.9 x.%B1", "NAME DOT NUMBER NAME DOT PART"),
        ("%IX0.0 %qw4 %MD*", "ADDRESS ADDRESS ADDRESS"),
        ("T#1d2h3m4s5.5ms TIME#-5s LTIME#5us", "TYPED TYPED TYPED"),
        ("D#2024-01-31 TOD#12:34:56.789 DT#2024-01-31-12:34:56", "TYPED TYPED TYPED"),
        ("D#2024-01-31 - x", "TYPED SIGN NAME"),
        ("INT#5 WORD#16#FF REAL#1.5e-3 BOOL#1 INT#-5", " ".join(["TYPED"] * 5)),
        ("WORD#1,Axis-1 WORD#1-1", "TYPED COMMA NAME SIGN NUMBER TYPED SIGN NUMBER"),
        ("Color#Red", "NAME HASH NAME"),
        ("'It$'s' \"wide\" ''", "TEXT TEXT TEXT"),
        ("STRING#'x'", "TEXT"),
        ("a (* c *) b // d\nc /* e */ (*f*)(*g*) d", "NAME NAME NAME NAME"),
        ("a * (b)", "NAME BINOP LPAR NAME RPAR"),
        ("a S= b; c REF= d", "NAME SETOP NAME SEMI NAME SETOP NAME"),
        ("IF s=1 OR r=0 THEN", "IF NAME EQ NUMBER WORDOP NAME EQ NUMBER THEN"),
        ("x AT %IX0.0; at := 1", "NAME AT ADDRESS SEMI NAME ASSIGN NUMBER"),
        ("x : REF_TO INT; ref_to := 1", "NAME COLON REF_TO NAME SEMI NAME ASSIGN NUMBER"),
        ("; ACTION act; action := 1", "SEMI ACTION NAME SEMI NAME ASSIGN NUMBER"),
        ("a ** b <> c <= d => e", "NAME BINOP NAME BINOP NAME BINOP NAME ARROW NAME"),
    ],
)
def test_kinds(text, wanted):
    assert kinds(text) == wanted


def test_places():
    tokens = tokenize(Source("  ab(* x *):=  12;\n"), Reporter())
    assert [(s, e) for s, e in zip(tokens.starts, tokens.ends, strict=True)] == [
        (2, 4),
        (11, 13),
        (15, 17),
        (17, 18),
        (19, 19),
    ]
    assert tokens.texts == ["ab", ":=", "12", ";", ""]


def test_nested_comments_by_pragma():
    assert kinds("{nested_comments} a (* b (* c *) d *) e") == "NAME NAME"
    assert kinds("a (* b (* c *) d") == "NAME NAME"


@pytest.mark.parametrize(
    "text, wanted",
    [
        ("{define v2} {IF defined (v2)} a {ELSE} b {END_IF} c", ["a", "c"]),
        ("{IF defined (v2)} a {ELSE} b {END_IF} c", ["b", "c"]),
        ("{IF defined(x)} a {ELSIF NOT defined(x)} b {ELSE} c {END_IF}", ["b"]),
        ("{define x} {IF defined(x) AND NOT defined(y)} a {IF defined(y)} b {END_IF} {END_IF}", ["a"]),
        ("{IF defined(x)} {define y} {END_IF} {IF defined(y)} a {END_IF} b", ["b"]),
        ("{define x}{undefine x}{IF defined(x) OR hasvalue(x, '1')} a {END_IF}", []),
        ("{IF defined(x)} ? 'open\n{END_IF} a", ["a"]),
    ],
)
def test_conditional_pragmas(text, wanted):
    reporter = Reporter()
    assert tokenize(Source(text), reporter).texts[:-1] == wanted
    assert not reporter.diagnostics


def test_attributes_are_kept_by_offset():
    text = "{attribute 'hidden'} {attribute 'pack_mode' := '1'} a {info 'x'} {library base} b"
    tokens = tokenize(Source(text), Reporter())
    assert tokens.attributes == {text.index(" a ") + 1: {"hidden": "", "pack_mode": "1"}}
    assert tokens.file_attributes["library"] == "base"


@pytest.mark.parametrize(
    "text, code",
    [
        ("a ? b", "E0105"),
        ("a := 'open;", "E0106"),
        ("a (* open", "E0107"),
        ("a {open", "E0108"),
        ("{ELSE}", "E0118"),
        ("{IF defined(x)}", "E0118"),
        ("‘a’", "W0101"),
        ("f(’test.cfg);", "W0111"),
        ("a；", "W0112"),
        ("a\n-----\nb", "W0105"),
        ("a\n_____\nb", "W0105"),
        ("......", "W0106"),
        (" . . . . b", "W0106"),
    ],
)
def test_what_is_no_token(text, code):
    assert lex(text)[1] == [code]


@pytest.mark.parametrize("quoted", ["‘Trap’", "’Trap’", "‘Trap‘", "“Trap”", "′Trap′", "`Trap`", "‘Trap'", "'Trap’"])
def test_any_typographic_quote_opens_and_closes(quoted):
    tokens = tokenize(Source(f"x := {quoted};"), Reporter())
    assert tokens.texts[2:4] == ["'Trap'", ";"]


def test_a_quote_never_closed_ends_before_the_bracket():
    tokens = tokenize(Source("f(‘a);\ng(‘b, c);\nx := ‘d;\ny := ‘e’;"), Reporter())
    assert [t for t in tokens.texts if t.startswith("'")] == ["'a'", "'b'", "'d'", "'e'"]


def test_a_string_left_open_spares_the_word_behind():
    assert lex('IF key<>" THEN') == (["IF", "NAME", "BINOP", "TEXT", "THEN"], ["E0106"])


def test_dashes_within_an_expression_are_signs():
    assert kinds("a := b - - -c") == "NAME ASSIGN NAME SIGN SIGN SIGN NAME"


def test_a_long_tail_of_blanks_is_nothing():
    assert kinds("a" + " \n" * 100_000) == "NAME"


# ---------------------------------------------------------------------------------------------------- literals


@pytest.mark.parametrize(
    "text, value",
    [
        ("5", 5),
        ("1_000", 1000),
        ("16#FF", 255),
        ("16#ff_ff", 65535),
        ("2#1010_0110", 166),
        ("8#17", 15),
        ("1.5", 1.5),
        ("1.5E3", 1500.0),
        ("1e-3", 0.001),
        ("1_0.2_5", 10.25),
        ("16#FFFFFFFFFFFFFFFF", 2**64 - 1),
    ],
)
def test_numbers(text, value):
    found = literals.number(text)
    assert found == value and type(found) is type(value)


@pytest.mark.parametrize(
    "text", ["12ab", "1__0", "8#19", "3#1", "16#", "0x1F", "16#1FFFFFFFFFFFFFFFF", "1e999", "2#2", "16#G"]
)
def test_bad_numbers(text):
    with pytest.raises(literals.BadLiteral) as bad:
        literals.number(text)
    assert bad.value.code == "E0109" and bad.value.why


@pytest.mark.parametrize(
    "text, value, name",
    [
        ("INT#5", 5, "INT"),
        ("INT#-5", -5, "INT"),
        ("WORD#16#FF", 255, "WORD"),
        ("BOOL#1", True, "BOOL"),
        ("bool#false", False, "BOOL"),
        ("REAL#1.5", 1.5, "REAL"),
        ("REAL#5", 5.0, "REAL"),
        ("LREAL#-1e3", -1000.0, "LREAL"),
        ("T#1d2h3m4s5.5ms", 93_784_005_500_000, "TIME"),
        ("TIME#90s", 90 * 10**9, "TIME"),
        ("T#1.5s", 1_500_000_000, "TIME"),
        ("LTIME#5us3ns", 5003, "LTIME"),
        ("LTIME#-1s", -(10**9), "LTIME"),
        ("T#49d17h2m47s295ms", 4_294_967_295 * 10**6, "TIME"),
        ("D#1970-01-02", 86_400, "DATE"),
        ("DATE#2024-02-29", 1_709_164_800, "DATE"),
        ("TOD#12:34:56.789", 45_296_789, "TOD"),
        ("TIME_OF_DAY#1:2", 3_720_000, "TOD"),
        ("DT#1970-01-02-00:00:01", 86_401, "DT"),
        ("DATE_AND_TIME#2024-01-31-12:34:56", 1_706_704_496, "DT"),
        ("LDT#2200-01-01-00:00:00.5", 7_258_118_400_500_000_000, "LDT"),
    ],
)
def test_typed_literals(text, value, name):
    assert literals.typed(text) == (value, name)


@pytest.mark.parametrize(
    "text, code, why",
    [
        ("T#5", "E0110", "units"),
        ("T#5ms3s", "E0110", "order"),
        ("T#-5s", "E0110", "TIME goes"),
        ("T#50d", "E0110", "TIME goes"),
        ("D#2024-13-01", "E0111", "month 13"),
        ("D#2023-02-29", "E0111", "day 29"),
        ("D#1969-12-31", "E0111", "year"),
        ("TOD#24:00:00", "E0111", "hour 24"),
        ("TOD#12:60:00", "E0111", "minute 60"),
        ("DT#2024-01-31", "E0111", "written"),
        ("BOOL#2", "E0109", "BOOL"),
        ("INT#1.5", "E0109", "fraction"),
        ("WORD#2#2", "E0109", "base 2"),
    ],
)
def test_bad_typed_literals(text, code, why):
    with pytest.raises(literals.BadLiteral, match=why) as bad:
        literals.typed(text)
    assert bad.value.code == code


@pytest.mark.parametrize(
    "text, value",
    [
        ("'It$'s'", "It's"),
        ("'a$Nb$l$R$T$P'", "a\nb\n\r\t\f"),
        ("'$$ $\"'", '$ "'),
        ("'$41$4a'", "AJ"),
        ("'$4142'", "A42"),
        ('"$0041$00e4"', "Aä"),
        ("''", ""),
    ],
)
def test_escapes(text, value):
    assert literals.string(text) == value


def test_a_wrong_escape():
    with pytest.raises(literals.BadLiteral) as bad:
        literals.string("'50$%'")
    assert bad.value.code == "E0112"

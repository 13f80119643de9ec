"""Correct programs: what tree they make, where its nodes lie, and the cache of trees."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

from stcore import cache, parser
from stcore import syntax as s
from stcore.diagnostics import Reporter
from stcore.source import Source, read

_ROOT = Path(__file__).parents[2]
_SHARED = _ROOT.parent / "shared"


def parse(text: str) -> s.File:
    """The tree of a text that must be free of errors and warnings."""
    reporter = Reporter()
    tree = parser.parse(Source(text), reporter)
    assert [d.message for d in reporter.diagnostics] == []
    return tree


def body(text: str) -> list[s.Node]:
    (pou,) = parse(f"PROGRAM p\n{text}\nEND_PROGRAM").units
    return pou.body


def declared(text: str) -> list[s.VarDecl]:
    (pou,) = parse(f"PROGRAM p\nVAR {text} END_VAR\nEND_PROGRAM").units
    return pou.sections[0].decls


def lisp(node) -> str:
    """A node in brackets, short enough to compare."""
    match node:
        case None:
            return "-"
        case list():
            return "[" + " ".join(map(lisp, node)) + "]"
        case tuple():
            return "(" + " ".join(map(lisp, node)) + ")"
        case s.Name():
            return node.name
        case s.Literal():
            return node.text
        case s.Address():
            return node.text
        case s.Binary() | s.Unary():
            return f"({' '.join([node.op, *(lisp(getattr(node, f)) for f in node.fields[1:])])})"
        case s.Member():
            return f"{lisp(node.base)}.{node.name}"
        case s.Part():
            return f"{lisp(node.base)}.%{node.size}{lisp(node.index)}"
        case s.Index():
            return f"{lisp(node.base)}{lisp(node.indices)}"
        case s.Deref():
            return f"{lisp(node.base)}^"
        case s.Arg():
            sign = "=>" if node.output else ":=" if node.name else ""
            return f"{node.name or ''}{sign}{'!' if node.negated else ''}{lisp(node.value)}"
        case s.Call():
            return f"{lisp(node.callee)}({' '.join(map(lisp, node.args))})"
        case s.Node():
            return f"({' '.join([type(node).__name__, *(lisp(getattr(node, f)) for f in node.fields)])})"
    return str(node)


def expression(text: str) -> str:
    reporter = Reporter()
    node = parser.parse_expression(Source(text), reporter)
    assert not reporter.diagnostics
    return lisp(node)


# -------------------------------------------------------------------------------------------------- expressions


@pytest.mark.parametrize(
    "text, wanted",
    [
        ("1", "1"),
        ("a + b * c", "(+ a (* b c))"),
        ("a - b - c", "(- (- a b) c)"),
        ("(a + b) * c", "(* (+ a b) c)"),
        ("a / b MOD c", "(MOD (/ a b) c)"),
        ("a ** b * c ** d", "(* (** a b) (** c d))"),
        ("-x ** 2", "(** (- x) 2)"),  # IEC 61131-3 table 71: the sign binds tighter
        ("NOT a AND b", "(AND (NOT a) b)"),
        ("a = b OR c < d AND e <> f", "(OR (= a b) (AND (< c d) (<> e f)))"),
        ("a = b < c", "(= a (< b c))"),
        ("a XOR b OR c & d", "(OR (XOR a b) (AND c d))"),
        ("a AND_THEN b OR_ELSE c", "(OR_ELSE (AND_THEN a b) c)"),
        ("- - a", "(- (- a))"),
        ("+a", "(+ a)"),
        ("a.b[1, i + 1].c^.d", "a.b[1 (+ i 1)].c^.d"),
        ("p^[3].x", "p^[3].x"),
        ("ADR(x)^", "ADR(x)^"),
        ("f(1)[2].y", "f(1)[2].y"),
        ("THIS^.x + SUPER^.y", "(+ THIS^.x SUPER^.y)"),
        ("x.9", "x.%X9"),
        ("x.%B1 + a[2].%W0", "(+ x.%B1 a[2].%W0)"),
        ("Color#Red", "Color.Red"),
        ("%ix0.0 OR %MW4 = 5", "(OR %IX0.0 (= %MW4 5))"),
        ("f(a, b := 1, c => d, e =>, g => NOT h, EN := TRUE)", "f(a b:=1 c=>d e=>- g=>!h EN:=TRUE)"),
        ("AND(a, b) OR NOT(c)", "(OR AND(a b) (NOT c))"),
        ("MOD(7, 3)", "MOD(7 3)"),
        ("f()", "f()"),
        ("'a' = \"b\"", "(= 'a' \"b\")"),
    ],
)
def test_expressions(text, wanted):
    assert expression(text) == wanted


@pytest.mark.parametrize(
    "text, value, type_name",
    [
        ("5", 5, None), ("1.5", 1.5, None), ("TRUE", True, "BOOL"), ("'a$N'", "a\n", "STRING"), ('"a"', "a", "WSTRING"),
        ("T#5ms", 5_000_000, "TIME"), ("WORD#16#FF", 255, "WORD"),
    ],
)  # fmt: skip
def test_literals(text, value, type_name):
    node = parser.parse_expression(Source(text), Reporter())
    assert (node.value, node.type_name, node.text) == (value, type_name, text)


def test_places_of_nodes():
    text = "x := (a + b.c) * f(1);"
    (assign,) = body(text)
    source = f"PROGRAM p\n{text}\nEND_PROGRAM"

    def of(node):
        return source[node.start : node.end]

    assert of(assign) == text
    assert of(assign.target) == "x"
    assert of(assign.value) == "(a + b.c) * f(1)"
    assert of(assign.value.left) == "a + b.c"
    assert of(assign.value.left.right) == "b.c"
    assert source[assign.value.left.right.name_start] == "c"
    assert of(assign.value.right) == "f(1)"


def test_a_tree_survives_pickling():
    tree = parse("PROGRAM p\nVAR x : INT := 1; END_VAR\nx := x + 1;\nEND_PROGRAM")
    assert repr(pickle.loads(pickle.dumps(tree, 5))) == repr(tree)


# --------------------------------------------------------------------------------------------------- statements


@pytest.mark.parametrize(
    "text, wanted",
    [
        ("a := 1;", "(Assign a := 1)"),
        ("a := b := c;", "(Assign a := (Assign b := c))"),
        ("a S= b;", "(Assign a S= b)"),
        ("a r= b;", "(Assign a R= b)"),
        ("a REF= b;", "(Assign a REF= b)"),
        ("p^.x[1] := 1;", "(Assign p^.x[1] := 1)"),
        ("%QX0.1 := TRUE;", "(Assign %QX0.1 := TRUE)"),
        ("fb(a := 1);", "(ExprStmt fb(a:=1))"),
        ("act;", "(ExprStmt act)"),
        ("fb.act;", "(ExprStmt fb.act)"),
        ("EXIT; CONTINUE; RETURN;", "(Exit) (Continue) (Return)"),
        ("again: JMP again;", "(Label again) (Jump again)"),
        (";;", ""),
        ("IF a THEN b; END_IF", "(If [(a [(ExprStmt b)])] -)"),
        ("IF a THEN ELSIF b THEN ; ELSE c; END_IF;", "(If [(a []) (b [])] [(ExprStmt c)])"),
        ("FOR i := 1 TO 9 DO END_FOR", "(For i 1 9 - [])"),
        ("FOR a[1] := n TO -1 BY -2 DO x; END_FOR;", "(For a[1] n (- 1) (- 2) [(ExprStmt x)])"),
        ("WHILE a DO b; END_WHILE", "(While a [(ExprStmt b)])"),
        ("REPEAT b; UNTIL a END_REPEAT", "(Repeat [(ExprStmt b)] a)"),
        ("REPEAT b; UNTIL a; END_REPEAT;", "(Repeat [(ExprStmt b)] a)"),
        (
            "CASE x OF 1: a := 1; 2, 3..5: b; Color.red, Color#blue, N+1: ELSE c; END_CASE",
            "(Case x [([1] [(Assign a := 1)]) ([2 (Range 3 5)] [(ExprStmt b)]) ([Color.red Color.blue (+ N 1)] [])]"
            " [(ExprStmt c)])",
        ),
        ("CASE x OF a: f(x); x.y := 1; b: END_CASE", "(Case x [([a] [(ExprStmt f(x)) (Assign x.y := 1)]) ([b] [])] -)"),
        ("CASE x OF -1: ; 'a': ; END_CASE", "(Case x [([(- 1)] []) (['a'] [])] -)"),
        ("IF s=1 THEN r:=0; END_IF FOR n := 1 TO 2 DO IF n = t THEN EXIT; END_IF END_FOR", None),
    ],
)
def test_statements(text, wanted):
    found = " ".join(map(lisp, body(text)))
    assert wanted is None or found == wanted


@pytest.mark.parametrize(
    "name",
    "s r st ld begin end n t pi it interval priority single step get set on with read_only task action at".split(),
)
def test_words_that_stay_names(name):
    (decl,) = declared(f"{name} : INT;")
    assert decl.name == name
    (assign,) = body(f"{name} := {name} + 1;")
    assert assign.target.name == name


# ------------------------------------------------------------------------------------------------- declarations


@pytest.mark.parametrize(
    "text, wanted",
    [
        ("INT", "(NamedType INT -)"),
        ("Lib.Kind", "(NamedType Lib.Kind -)"),
        ("Blk(a := 1, b := 2)", "(NamedType Blk [a:=1 b:=2])"),
        ("STRING", "(StringType False -)"),
        ("WSTRING(80)", "(StringType True 80)"),
        ("STRING[N]", "(StringType False N)"),
        ("ARRAY[0..3, 1..N+1] OF INT", "(ArrayOf [(0 3) (1 (+ N 1))] (NamedType INT -))"),
        ("ARRAY[*, *] OF INT", "(ArrayOf [- -] (NamedType INT -))"),
        ("ARRAY[0..1] OF ARRAY[0..1] OF INT", "(ArrayOf [(0 1)] (ArrayOf [(0 1)] (NamedType INT -)))"),
        ("POINTER TO POINTER TO Blk", "(PointerTo (PointerTo (NamedType Blk -)))"),
        ("REFERENCE TO INT", "(ReferenceTo (NamedType INT -))"),
        ("REF_TO INT", "(PointerTo (NamedType INT -))"),
        ("INT (0..100)", "(Subrange INT 0 100)"),
        ("(a, b := 5, c)", "(EnumDef [(a 19 -) (b 22 5) (c 30 -)] -)"),
    ],
)
def test_types(text, wanted):
    (decl,) = declared(f"x : {text};")
    assert lisp(decl.type) == wanted


@pytest.mark.parametrize(
    "text, wanted",
    [
        ("5", "5"),
        ("[1, 2, 3(0)]", "(ArrayInit [(- 1) (- 2) (3 0)])"),
        ("0, 1200, 2000", "(ArrayInit [(- 0) (- 1200) (- 2000)])"),
        ("3(0), 1", "(ArrayInit [(3 0) (- 1)])"),
        ("[2(1, 2)]", "(ArrayInit [(- 1) (- 2) (- 1) (- 2)])"),
        ("[3()]", "(ArrayInit [(3 -)])"),
        ("[[1, 2], [3, 4]]", "(ArrayInit [(- (ArrayInit [(- 1) (- 2)])) (- (ArrayInit [(- 3) (- 4)]))])"),
        ("(a := 1, b := [1, 2])", "(StructInit [a:=1 b:=(ArrayInit [(- 1) (- 2)])])"),
        ("(a := 3, 4, b := (c := 5))", "(StructInit [a:=(ArrayInit [(- 3) (- 4)]) b:=(StructInit [c:=5])])"),
        ("[(a := 1), (a := 2)]", "(ArrayInit [(- (StructInit [a:=1])) (- (StructInit [a:=2]))])"),
        ("(a + 1) * 2", "(* (+ a 1) 2)"),
    ],
)
def test_initial_values(text, wanted):
    (decl,) = declared(f"x : T := {text};")
    assert lisp(decl.init) == wanted


def test_declarations():
    decls = declared("a, b : INT := 5; x AT %IX0.0 : BOOL; {attribute 'displaymode' := 'hex'} y : DWORD;")
    assert [d.name for d in decls] == ["a", "b", "x", "y"]
    assert decls[0].type is decls[1].type
    assert [d.address for d in decls] == [None, None, "%IX0.0", None]
    assert [d.attributes for d in decls] == [{}, {}, {}, {"displaymode": "hex"}]


def test_sections():
    text = """FUNCTION_BLOCK f EXTENDS g IMPLEMENTS i, j
VAR_INPUT CONSTANT a : INT; END_VAR
VAR RETAIN PERSISTENT b : INT; END_VAR;
VAR_TEMP END_VAR VAR_STAT END_VAR VAR_INST END_VAR VAR_IN_OUT END_VAR VAR_OUTPUT END_VAR VAR_EXTERNAL END_VAR
x := 1;
ACTION act: y := 1; END_ACTION
END_FUNCTION_BLOCK
ACTION other z := 1; END_ACTION"""
    (pou,) = parse(text).units
    assert [x.kind for x in pou.sections] == [
        "VAR_INPUT", "VAR", "VAR_TEMP", "VAR_STAT", "VAR_INST", "VAR_IN_OUT", "VAR_OUTPUT", "VAR_EXTERNAL",
    ]  # fmt: skip
    assert pou.sections[0].qualifiers == {"CONSTANT"}
    assert pou.sections[1].qualifiers == {"RETAIN", "PERSISTENT"}
    assert (pou.kind, pou.name, pou.extends, pou.implements) == ("FUNCTION_BLOCK", "f", "g", ["i", "j"])
    assert [a.name for a in pou.actions] == ["act", "other"]
    assert text[pou.name_start] == "f"


def test_functions():
    generic, none, plain = parse("""{attribute 'hidden'}
FUNCTION len <T: ANY_STRING, U: ANY_NUM> : STRING(80) VAR_INPUT s : T; END_VAR END_FUNCTION
FUNCTION none VAR_INPUT a : INT; END_VAR END_FUNCTION
FUNCTION plain : INT; plain := 1; END_FUNCTION""").units
    assert generic.generics == [("T", "ANY_STRING"), ("U", "ANY_NUM")]
    assert lisp(generic.result) == "(StringType False 80)"
    assert generic.attributes == {"hidden": ""}
    assert none.result is None and none.attributes == {}
    assert lisp(plain.result) == "(NamedType INT -)" and len(plain.body) == 1


def test_type_declarations():
    text = """TYPE
 Color : (red, green := 5) INT := green;
 Color2 : INT (red2, green2 := 5);
 {attribute 'strict'} P : STRUCT a, b : INT := 5; END_STRUCT;
 Q EXTENDS P : STRUCT c AT %MW0 : INT; END_STRUCT
 U : UNION a : DWORD; b : ARRAY[0..3] OF BYTE; END_UNION
 Sub : INT (0..100) := 7;
 Alias : INT;
END_TYPE"""
    units = parse(text).units
    assert [u.name for u in units] == ["Color", "Color2", "P", "Q", "U", "Sub", "Alias"]
    assert units[0].type.base == "INT" and units[0].init.name == "green"
    assert [i[0] for i in units[1].type.items] == ["red2", "green2"] and units[1].type.base == "INT"
    assert units[2].attributes == {"strict": ""}
    assert units[3].type.extends == "P"
    assert isinstance(units[4].type, s.UnionDef) and isinstance(units[5].type, s.Subrange)


def test_globals_and_configuration():
    text = """{attribute 'qualified_only'}
VAR_GLOBAL CONSTANT N : INT := 5; END_VAR
VAR_CONFIG PLC_PRG.fb.x AT %QX1.1 : BOOL; END_VAR
CONFIGURATION cfg
 VAR_GLOBAL g : INT; END_VAR
 RESOURCE res ON PLC
  TASK slow (INTERVAL := T#10ms, PRIORITY := 1);
  PROGRAM p1 WITH slow : PLC_PRG;
  PROGRAM p2 : PLC_PRG (x := 1);
 END_RESOURCE
END_CONFIGURATION"""
    constants, config, whole = parse(text).units
    assert constants.attributes == {"qualified_only": ""} and constants.qualifiers == {"CONSTANT"}
    assert (config.kind, config.decls[0].name) == ("VAR_CONFIG", "PLC_PRG.fb.x")
    assert [len(x) for x in (whole.sections, whole.tasks, whole.programs)] == [1, 1, 2]
    assert {k: lisp(v) for k, v in whole.tasks[0].properties.items()} == {"INTERVAL": "T#10ms", "PRIORITY": "1"}
    assert [(p.name, p.task, p.type_name, lisp(p.inits)) for p in whole.programs] == [
        ("p1", "slow", "PLC_PRG", "[]"),
        ("p2", None, "PLC_PRG", "[x:=1]"),
    ]


def test_conditional_declarations():
    (pou,) = parse("{define v3}\nPROGRAM p\n{IF defined(v3)} a := 1; {ELSE} a := 2 2; {END_IF}\nEND_PROGRAM").units
    assert lisp(pou.body) == "[(Assign a := 1)]"


# ---------------------------------------------------------------------------------------- prompts and values


def test_statements_of_a_prompt_need_no_last_semicolon():
    reporter = Reporter()
    statements = parser.parse_statements(Source("x := 5; fb(a := 1)"), reporter)
    assert lisp(statements) == "[(Assign x := 5) (ExprStmt fb(a:=1))]" and not reporter.diagnostics


@pytest.mark.parametrize(
    "text, wanted",
    [
        ("5", "5"), ("-1.5", "(- 1.5)"), ("TRUE", "TRUE"), ("'text'", "'text'"), ("T#5ms", "T#5ms"),
        ("[1,2,3]", "(ArrayInit [(- 1) (- 2) (- 3)])"), ("(acc:=0.25)", "(StructInit [acc:=0.25])"),
        ("Phase.go", "Phase.go"),
    ],
)  # fmt: skip
def test_values_of_the_command_line(text, wanted):
    reporter = Reporter()
    assert lisp(parser.parse_initializer(Source(text), reporter)) == wanted and not reporter.diagnostics


@pytest.mark.parametrize("text", ["", "5 5", "x :=", "[1,", ")", "?"])
def test_what_is_no_value(text):
    reporter = Reporter()
    parser.parse_initializer(Source(text), reporter)
    assert reporter.failed


# --------------------------------------------------------------------------------------------------- whole files


@pytest.mark.parametrize("path", sorted((_ROOT / "stcore/library").rglob("*.st")), ids=lambda p: p.stem)
def test_the_library_parses(path):
    reporter = Reporter()
    parser.parse(read(path), reporter)
    assert not reporter.diagnostics


@pytest.mark.parametrize("name", ["B1", "B2", "B3", "B4", "big"])
def test_the_benchmarks_parse(name):
    path = _SHARED / "benchmarks" / f"{name}.st"
    if not path.exists():
        pytest.skip("the benchmark programs are not beside this checkout")
    reporter = Reporter()
    assert parser.parse(read(path), reporter).units and not reporter.diagnostics


# -------------------------------------------------------------------------------------------------------- cache


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("SCANCYCLE_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


_LISTING = Source("PROGRAM p\nx = 1;\nEND_PROGRAM", "p.st")


def test_a_tree_comes_back_with_its_warnings(folder, monkeypatch):
    first, second = Reporter(), Reporter()
    tree = cache.parse_cached(_LISTING, first)
    assert list((folder / "tree").rglob("*"))
    monkeypatch.setattr(parser, "parse", None)  # not needed again
    assert repr(cache.parse_cached(_LISTING, second)) == repr(tree)
    assert first.diagnostics == second.diagnostics and first.diagnostics[0].code == "W0102"


def test_strictness_is_not_cached(folder):
    cache.parse_cached(_LISTING, Reporter())
    strict = Reporter(strict=True)
    cache.parse_cached(_LISTING, strict)
    assert strict.failed


def test_errors_are_not_cached(folder):
    cache.parse_cached(Source("PROGRAM p\nx := ;\nEND_PROGRAM"), Reporter())
    assert not [f for f in (folder / "tree").rglob("*") if f.is_file()]


def test_a_broken_cache_file_is_made_anew(folder):
    cache.parse_cached(_LISTING, Reporter())
    (file,) = [f for f in (folder / "tree").rglob("*") if f.is_file()]
    good = file.read_bytes()
    for broken in (b"", b"nonsense", good[: len(good) // 2]):
        file.write_bytes(broken)
        assert cache.parse_cached(_LISTING, Reporter()).units[0].name == "p"
        assert file.read_bytes() == good


def test_without_a_writable_cache(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    monkeypatch.setenv("SCANCYCLE_CACHE", str(blocked))
    monkeypatch.setattr(cache, "_problem", "")
    assert cache.parse_cached(_LISTING, Reporter()).units
    assert str(blocked) in cache.problem()
    assert cache.load("tree", "none") is None


@pytest.mark.parametrize(
    "text", ["a := " + "1+" * 199 + "1;", "a := " + "NOT " * 90 + "b;", "a := " + "f(" * 140 + ")" * 140 + ";"]
)
def test_the_deepest_trees_are_cached(folder, text):
    source = Source(f"PROGRAM p\n{text}\nEND_PROGRAM")
    for _ in range(2):
        reporter = Reporter()
        assert cache.parse_cached(source, reporter).units and not reporter.diagnostics


def test_store_and_load(folder):
    key = cache.digest(b"a", b"b")
    assert key != cache.digest(b"ab") and cache.load("kind", key) is None
    cache.store("kind", key, b"data")
    assert cache.load("kind", key) == b"data" and not list(folder.rglob("*.part"))

"""X_TO_Y and TO_Y of every pair of numeric types, of constants and of variables, against Python."""

import math
from random import Random

import pytest
from model import KINDS, convert, single, written
from running import Run, errors, program, run

EDGES = [0, 1, 2, 3, 100, 127, 128, 200, 255, 256, 32767, 32768, 65535, 65536, 2**31 - 1, 2**31, 2**32 - 1, 2**32]
EDGES += [2**53, 2**53 + 1, 2**63 - 1, 2**63, 2**64 - 1]
REALS = [0.0, 0.4, 0.5, 0.49999999999999994, 1.5, 2.5, 3.5, 127.5, 255.5, 32767.4, 32767.5, 65535.5, 8388607.5]
REALS += [2147483647.0, 2147483648.0, 4294967295.0, 4294967296.0, 9.2e18, 9.3e18, 1.8e19, 1.9e19, 1e30]


def samples(kind) -> list:
    random = Random(kind.name)
    if kind.sort == "bool":
        return [False, True]
    if kind.sort == "real":
        values = [sign * v for v in REALS for sign in (1, -1)] + [random.uniform(-1e5, 1e5) for _ in range(6)]
        return [single(v) if kind.name == "REAL" else v for v in values]
    edges = [sign * e for e in EDGES for sign in (1, -1)] + [random.randint(kind.low, kind.high) for _ in range(6)]
    return [e for e in dict.fromkeys(edges) if kind.low <= e <= kind.high] + [kind.low]


@pytest.mark.parametrize("name", KINDS)
def test_conversions_from(name):
    kind = KINDS[name]
    values = samples(kind)
    targets = [k for k in KINDS.values() if k is not kind]
    top = len(values) - 1
    texts = [written(v, kind) for v in values]
    lines = ["PROGRAM PLC_PRG", "VAR", f"  v : ARRAY[0..{top}] OF {name} := [{', '.join(texts)}];", "  i : DINT;"]
    lines += [f"  {p}{k.name} : ARRAY[0..{top}] OF {k.name};" for k in targets for p in ("c_", "m_", "o_")]
    lines += ["END_VAR", f"FOR i := 0 TO {top} DO"]
    lines += [f"  m_{k.name}[i] := {name}_TO_{k.name}(v[i]); o_{k.name}[i] := TO_{k.name}(v[i]);" for k in targets]
    lines += ["END_FOR"]
    lines += [f"c_{k.name}[{i}] := {name}_TO_{k.name}({x});" for k in targets for i, x in enumerate(texts)]
    run = Run("\n".join([*lines, "END_PROGRAM"])).scan()
    for k in targets:
        wanted = [convert(v, kind, k) for v in values]
        for way in "cmo":
            got = run[f"{way}_{k.name}"]
            wrong = [(v, g, w) for v, g, w in zip(values, got, wanted, strict=True) if g != w]
            assert not wrong, f"{name}_TO_{k.name} {way}: {wrong}"


@pytest.mark.parametrize("name", ["REAL", "LREAL"])
def test_special_values(name):
    bits = {"REAL": "pd^ := 16#7FC00000", "LREAL": "pl^ := 16#7FF8000000000000"}[name]
    run = Run(
        f"PROGRAM PLC_PRG\nVAR x : {name}; pd : POINTER TO DWORD := ADR(x); pl : POINTER TO LWORD := ADR(x);"
        f" i, j, k : DINT;"
        f" zero : {name}; u : USINT; b : BOOL; y : {name}; END_VAR\n"
        f"{bits}; i := {name}_TO_DINT(x); x := 1 / zero; j := {name}_TO_DINT(x);"
        f" x := -1 / zero; k := {name}_TO_DINT(x);"
        f" u := {name}_TO_USINT(x); y := x; b := x = y;\nEND_PROGRAM"
    ).scan()
    assert (run["i"], run["j"], run["k"], run["u"], run["b"]) == (0, 2**31 - 1, -(2**31), 0, True)
    assert math.isinf(run["y"])


def test_long_dates_and_times_of_day_keep_nanoseconds():
    made = run(
        "a := LTOD_TO_LINT(t); b := LDT_TO_LINT(d); c := LDATE_TO_LINT(e); s := LDT_TO_STRING(d); f := TOD_TO_DINT(u);",
        "a, b, c : LINT; t : LTOD := LTOD#12:34:56.123456789; d : LDT := LDT#2024-02-29-12:00:00.000000001; f : DINT;"
        "e : LDATE := LDATE#2261-12-31; s : STRING; u : TOD := TOD#00:00:01.2345;",
    )
    assert made["a"] == ((12 * 60 + 34) * 60 + 56) * 10**9 + 123456789
    assert made["b"] == 1709208000 * 10**9 + 1
    assert (made["c"], made["f"]) == (9214560000 * 10**9, 1234)
    assert made["s"] == "LDT#2024-02-29-12:00:00.000000001"


def test_long_dates_beyond_64_bits_of_nanoseconds_are_an_error():
    assert [d.code for d in errors(program("d := LDT#2300-01-01-00:00:00;", "d : LDT;"))] == ["E0111"]


def test_any_to_is_another_spelling_of_the_overloaded_conversions():
    made = run(
        "a := ANY_TO_INT(2.7); b := ANY_TO_REAL('2.5'); c := ANY_TO_STRING(T#1s);", "a : INT; b : REAL; c : STRING;"
    )
    assert (made["a"], made["b"], made["c"]) == (3, 2.5, "T#1s")

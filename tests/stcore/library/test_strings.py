"""Character string functions: positions from 1, clipped to the string; room for the result."""

import re

import pytest
from harness import Plc, check, evaluate

NARROW = """
    INT LEN('') -> 0
    INT LEN('abc') -> 3
    INT LEN(full) -> 80
    STRING LEFT('abcdef', 2) -> 'ab'
    STRING LEFT('abc', 3) -> 'abc'
    STRING LEFT('abc', 4) -> 'abc'
    STRING LEFT('abc', 0) -> ''
    STRING LEFT('abc', -1) -> ''
    STRING LEFT('', 3) -> ''
    STRING LEFT('abc', 32767) -> 'abc'
    STRING RIGHT('abcdef', 2) -> 'ef'
    STRING RIGHT('abc', 3) -> 'abc'
    STRING RIGHT('abc', 9) -> 'abc'
    STRING RIGHT('abc', 0) -> ''
    STRING RIGHT('abc', -32768) -> ''
    STRING RIGHT('', 1) -> ''
    STRING MID('abcdef', 2, 3) -> 'cd'
    STRING MID('abcdef', 1, 1) -> 'a'
    STRING MID('abcdef', 9, 5) -> 'ef'
    STRING MID('abcdef', 2, 7) -> ''
    STRING MID('abcdef', 2, 99) -> ''
    STRING MID('abcdef', 0, 2) -> ''
    STRING MID('abcdef', -1, 2) -> ''
    STRING MID('abcdef', 2, 0) -> 'ab'
    STRING MID('', 1, 1) -> ''
    STRING MID(STR := 'abcdef', LEN := 3, POS := 2) -> 'bcd'
    STRING MID('abc', 32767, 1) -> 'abc'
    STRING CONCAT('ab', 'cd') -> 'abcd'
    STRING CONCAT('', '') -> ''
    STRING CONCAT('', 'x') -> 'x'
    STRING CONCAT('x', '') -> 'x'
    STRING CONCAT('a', 'b', 'c', 'd') -> 'abcd'
    STRING CONCAT(CONCAT('a', s), LEFT(s, 1)) -> 'ahelloh'
    STRING INSERT('abcd', 'XY', 2) -> 'abXYcd'
    STRING INSERT('abcd', 'XY', 0) -> 'XYabcd'
    STRING INSERT('abcd', 'XY', 4) -> 'abcdXY'
    STRING INSERT('abcd', 'XY', 9) -> 'abcdXY'
    STRING INSERT('abcd', 'XY', -3) -> 'XYabcd'
    STRING INSERT('', 'XY', 1) -> 'XY'
    STRING DELETE('abcdef', 2, 3) -> 'abef'
    STRING DELETE('abcdef', 9, 3) -> 'ab'
    STRING DELETE('abcdef', 2, 9) -> 'abcdef'
    STRING DELETE('abcdef', 0, 3) -> 'abcdef'
    STRING DELETE('abcdef', -2, 3) -> 'abcdef'
    STRING DELETE('abcdef', 6, 1) -> ''
    STRING DELETE('abcdef', 2, 0) -> 'cdef'
    STRING DELETE('', 1, 1) -> ''
    STRING REPLACE('abcdef', 'X', 3, 2) -> 'aXef'
    STRING REPLACE('abcdef', 'XYZ', 1, 6) -> 'abcdeXYZ'
    STRING REPLACE('abcdef', 'X', 0, 2) -> 'aXbcdef'
    STRING REPLACE('abcdef', '', 2, 2) -> 'adef'
    STRING REPLACE('abc', 'X', 1, 9) -> 'abcX'
    STRING REPLACE('abc', 'X', 9, 1) -> 'X'
    STRING REPLACE('abc', 'X', 1, 0) -> 'Xbc'
    STRING REPLACE('', 'X', 1, 1) -> 'X'
    INT FIND('abcbc', 'bc') -> 2
    INT FIND('abc', 'x') -> 0
    INT FIND('abc', '') -> 0
    INT FIND('', 'a') -> 0
    INT FIND('abc', 'abcd') -> 0
    INT FIND('abc', 'abc') -> 1
    INT FIND('aaab', 'aab') -> 2
    INT FIND('abc', 'c') -> 3
    BOOL LEFT(s, 4) = 'hell' -> True
    INT LEN(CONCAT(s, ' world')) -> 11
"""
WIDE = "\n".join(
    re.sub(r"\bSTRING\b", "WSTRING", case.split(" -> ")[0]).replace("'", '"') + " -> " + case.split(" -> ")[1]
    for case in NARROW.strip().splitlines()
)


def test_narrow():
    check(NARROW, f"  s : STRING := 'hello'; full : STRING := '{80 * 'x'}';")


def test_wide():
    check(WIDE, f'  s : WSTRING := "hello"; full : WSTRING := "{80 * "x"}";')


def test_wide_characters():
    check(
        """
        WSTRING CONCAT("位置", "µm") -> '位置µm'
        INT LEN("位置") -> 2
        INT FIND("a位置", "置") -> 3
        WSTRING MID("a位置b", 2, 2) -> '位置'
    """
    )


def test_names_of_standard64():
    check(
        """
        INT WLEN("abc") -> 3
        WSTRING WLEFT("abc", 2) -> 'ab'
        WSTRING WRIGHT("abc", 2) -> 'bc'
        WSTRING WMID("abcd", 2, 2) -> 'bc'
        WSTRING WCONCAT("ab", "c") -> 'abc'
        WSTRING WINSERT("ac", "b", 1) -> 'abc'
        WSTRING WDELETE("abcd", 2, 2) -> 'ad'
        WSTRING WREPLACE("abcd", "X", 2, 2) -> 'aXd'
        INT WFIND("abc", "c") -> 3
    """
    )


def test_target_cuts_off():
    """A result that is longer than its target is cut to the target's length."""
    check("""
        STRING(3) CONCAT('ab', 'cdef') -> 'abc'
        STRING(1) INSERT('abc', 'x', 1) -> 'a'
    """)


@pytest.mark.parametrize(("length", "room"), [(200, 255), (400, 400)])
def test_room_of_result(length, room):
    """A result has room for 255 characters, or for the longest argument's declared length."""
    plc = Plc(
        f"PROGRAM PLC_PRG\nVAR\n  a, b : STRING({length}); r, i, d : STRING(1000); n : INT;\nEND_VAR\n"
        "r := CONCAT(a, b); i := INSERT(a, b, 5); d := REPLACE(a, b, 1, 1); n := LEN(CONCAT(a, b));\nEND_PROGRAM\n"
    )
    plc["PLC_PRG.a"], plc["PLC_PRG.b"] = "a" * length, "b" * length
    plc.scan()
    assert plc["PLC_PRG.r"] == ("a" * length + "b" * length)[:room]
    assert plc["PLC_PRG.i"] == ("a" * 5 + "b" * length + "a" * length)[:room]
    assert plc["PLC_PRG.d"] == ("b" * length + "a" * length)[:room]
    assert plc["PLC_PRG.n"] == room


def test_result_into_argument():
    """s := LEFT(s, n) and its like: the result is complete before s changes."""
    plc = Plc(
        "PROGRAM PLC_PRG\nVAR\n  s : STRING := 'abc'; t : STRING := 'abcdef'; u : STRING := 'xyz';\nEND_VAR\n"
        "s := CONCAT(s, s); t := DELETE(t, 2, 2); u := REPLACE(u, u, 1, 2);\nEND_PROGRAM\n"
    )
    plc.scan()
    assert [plc[f"PLC_PRG.{n}"] for n in "stu"] == ["abcabc", "adef", "xxyzz"]


def test_many_against_python():
    """Every length and position around a short text, against slices."""
    text = "abcde"
    cases, expected = [], []
    for n in range(-1, 8):
        for p in range(-1, 8):
            first, count = max(p - 1, 0), max(n, 0)
            cases += [("STRING", f"MID(s, {n}, {p})"), ("STRING", f"DELETE(s, {n}, {p})")]
            expected += [text[first : first + count], text[:first] + text[first + count :]]
            cases.append(("STRING", f"REPLACE(s, 'XY', {n}, {p})"))
            expected.append(text[:first] + "XY" + text[first + count :])
    assert evaluate(cases, "  s : STRING := 'abcde';") == expected

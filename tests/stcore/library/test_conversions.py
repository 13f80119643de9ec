"""Values to text and back."""

import math
import random
import struct

import numpy
import pytest
from harness import Plc, check, evaluate

TYPES = {
    "SINT": (-128, 127), "INT": (-32768, 32767), "DINT": (-(2**31), 2**31 - 1), "LINT": (-(2**63), 2**63 - 1),
    "USINT": (0, 255), "UINT": (0, 65535), "UDINT": (0, 2**32 - 1), "ULINT": (0, 2**64 - 1),
    "BYTE": (0, 255), "WORD": (0, 65535), "DWORD": (0, 2**32 - 1), "LWORD": (0, 2**64 - 1),
}  # fmt: skip


@pytest.mark.parametrize("wide", ["", "W"])
def test_integers(wide):
    """Both ends of every type, to text and back."""
    q = '"' if wide else "'"
    numbers = [(t, n) for t, (low, high) in TYPES.items() for n in {low, high, 0, 42}]
    declared = "".join(f"  v{i} : {t};\n" for i, (t, n) in enumerate(numbers))
    text = [
        f"  t{i} := {t}_TO_{wide}STRING(v{i}); b{i} := {wide}STRING_TO_{t}(t{i});" for i, (t, n) in enumerate(numbers)
    ]
    declared += "".join(f"  t{i} : {wide}STRING; b{i} : {t};\n" for i, (t, n) in enumerate(numbers))
    plc = Plc(f"PROGRAM PLC_PRG\nVAR\n{declared}END_VAR\n" + "\n".join(text) + "\nEND_PROGRAM\n")
    for i, (_, n) in enumerate(numbers):
        plc[f"PLC_PRG.v{i}"] = n
    plc.scan()
    for i, (t, n) in enumerate(numbers):
        assert plc[f"PLC_PRG.t{i}"] == str(n), t
        assert plc[f"PLC_PRG.b{i}"] == n, t
    check([("INT", f"{wide}STRING_TO_INT({q}{q})", 0)])


def test_text_to_integer():
    check(
        """
        INT STRING_TO_INT('12abc') -> 12
        INT STRING_TO_INT('abc') -> 0
        INT STRING_TO_INT('') -> 0
        INT STRING_TO_INT('  -7 ') -> -7
        INT STRING_TO_INT('+8') -> 8
        INT STRING_TO_INT('-') -> 0
        INT STRING_TO_INT('16#FF') -> 255
        INT STRING_TO_INT('16#ff') -> 255
        INT STRING_TO_INT('2#101') -> 5
        INT STRING_TO_INT('8#17') -> 15
        INT STRING_TO_INT('3.99') -> 3
        DINT STRING_TO_DINT('1_000_000') -> 1000000
        INT STRING_TO_INT('40000') -> -25536
        SINT STRING_TO_SINT('300') -> 44
        BYTE STRING_TO_BYTE('300') -> 44
        DWORD STRING_TO_DWORD('16#DEADBEEF') -> 3735928559
        LINT STRING_TO_LINT('-9223372036854775808') -> -9223372036854775808
        INT STRING_TO_INT('7 8') -> 7
        INT STRING_TO_INT('16#') -> 0
        INT STRING_TO_INT('0') -> 0
        DINT TO_DINT('77') -> 77
        WORD WSTRING_TO_WORD("16#1F") -> 31
    """
    )


def test_overloaded():
    check(
        """
        STRING TO_STRING(INT#-5) -> '-5'
        STRING TO_STRING(TRUE) -> 'TRUE'
        STRING TO_STRING(T#1S) -> 'T#1s'
        WSTRING TO_WSTRING(LREAL#0.1) -> '0.1'
        LREAL TO_LREAL('2.5') -> 2.5
    """
    )


def test_bool():
    check(
        """
        STRING BOOL_TO_STRING(TRUE) -> 'TRUE'
        STRING BOOL_TO_STRING(FALSE) -> 'FALSE'
        WSTRING BOOL_TO_WSTRING(TRUE) -> 'TRUE'
        BOOL STRING_TO_BOOL('TRUE') -> True
        BOOL STRING_TO_BOOL('true') -> True
        BOOL STRING_TO_BOOL('FALSE') -> False
        BOOL STRING_TO_BOOL('') -> False
        BOOL STRING_TO_BOOL('1') -> True
        BOOL STRING_TO_BOOL('0') -> False
        BOOL WSTRING_TO_BOOL("True") -> True
    """
    )


# ------------------------------------------------------------------------------------------------- reals


def real_texts(kind: str, numbers: list[float]) -> list[str]:
    count, code = len(numbers), "d" if kind == "LREAL" else "f"
    plc = Plc(
        f"PROGRAM PLC_PRG\nVAR\n  x : ARRAY[0..{count - 1}] OF {kind}; s : ARRAY[0..{count - 1}] OF STRING(40);\n"
        f"  i : DINT;\nEND_VAR\nFOR i := 0 TO {count - 1} DO s[i] := {kind}_TO_STRING(x[i]); END_FOR\nEND_PROGRAM\n"
    )
    plc.write_numbers("PLC_PRG.x", numbers, code)
    plc.scan()
    return plc["PLC_PRG.s"]


def parsed(kind: str, texts: list[str]) -> list[float]:
    count, length = len(texts), max(map(len, texts))
    plc = Plc(
        f"PROGRAM PLC_PRG\nVAR\n  x : ARRAY[0..{count - 1}] OF {kind};\n"
        f"  s : ARRAY[0..{count - 1}] OF STRING({length}); i : DINT;\nEND_VAR\n"
        f"FOR i := 0 TO {count - 1} DO x[i] := STRING_TO_{kind}(s[i]); END_FOR\nEND_PROGRAM\n"
    )
    plc["PLC_PRG.s"] = texts
    plc.scan()
    return plc["PLC_PRG.x"]


def doubles(rng: random.Random, count: int) -> list[float]:
    return [struct.unpack("<d", struct.pack("<Q", rng.getrandbits(63)))[0] for _ in range(count)]


def finite(numbers: list[float]) -> list[float]:
    return [x for x in numbers if math.isfinite(x)]


EXAMPLES = [
    0.1, 3.14, 5.0, 100.0, -0.5, 1e20, 1e16, 123456789012345.0, 1e15, 9007199254740993.0, 0.0001, 0.00001, 2.5e-7,
    1e23, 5e-324, 2.2250738585072014e-308, 1.7976931348623157e308, 1 / 3, 2 / 3, 0.3, 1e22, 1e21, 4.35, 0.0, -0.0,
    2.0**-44, 2.0**60, 12.0, 9.5, 99.99, 1e-5, 123456.789, 1.5e300, 4503599627370496.5, 9999999999999998.0,
]  # fmt: skip


def test_lreal_to_text():
    """The shortest text that reads back, in the form that Python's repr has too."""
    rng = random.Random(1)
    numbers = (
        EXAMPLES + finite(doubles(rng, 300)) + [round(rng.uniform(-1e6, 1e6), rng.randint(0, 6)) for _ in range(300)]
    )
    numbers += [2.0**k for k in range(-1074, 1024, 13)]
    assert real_texts("LREAL", numbers) == [repr(x) for x in numbers]


def test_real_to_text():
    rng = random.Random(2)
    single = [struct.unpack("<f", struct.pack("<I", rng.getrandbits(31)))[0] for _ in range(300)]
    numbers = [float(numpy.float32(x)) for x in EXAMPLES if 1e-44 < abs(x) < 1e38] + finite(single)
    numbers += [float(numpy.float32(round(rng.uniform(-100, 100), 3))) for _ in range(200)] + [
        2.0**k for k in range(-149, 128)
    ]
    for number, text in zip(numbers, real_texts("REAL", numbers), strict=True):
        expected = float(str(numpy.float32(number)))
        assert text == repr(expected), number


def test_special_reals():
    assert real_texts("LREAL", [math.inf, -math.inf, math.nan, 0.0, -0.0]) == ["INF", "-INF", "NAN", "0.0", "-0.0"]
    assert real_texts("REAL", [math.inf, -math.inf, math.nan, 0.0]) == ["INF", "-INF", "NAN", "0.0"]
    got = parsed("LREAL", ["INF", "-inf", "NaN", "1e400", "-1e400", "1e-400", "-0.0"])
    assert [repr(x) for x in got] == ["inf", "-inf", "nan", "inf", "-inf", "0.0", "-0.0"]


def test_text_to_lreal():
    """Correctly rounded, however long the text."""
    rng = random.Random(3)
    texts = [repr(x) for x in EXAMPLES + finite(doubles(rng, 300))]
    texts += [f"{x:.{rng.randint(0, 30)}e}" for x in finite(doubles(rng, 300))]
    # halfway between two numbers: to the even one, unless a digit far behind decides
    texts += [
        "9007199254740993",
        "9007199254740993.000000000000000000001",
        "9007199254740992.9999999999",
        "2.4703282292062327e-324",
    ]
    texts += ["2.4703282292062328e-324", "1.7976931348623158e308", "1.7976931348623159e308", "2.2250738585072011e-308"]
    texts += [
        "123456789012345678901234567890",
        "9.630051362209999934e+06",
        "0.000000000000000000000000000000012345",
        "1E5",
        "1e+5",
        "+2.5",
        ".5",
        "5.",
        "00012.5",
    ]
    got = parsed("LREAL", texts)
    assert [repr(x) for x in got] == [repr(float(x)) for x in texts]


def test_long_text_to_lreal():
    tie = f"{2**53 + 1}." + 900 * "0"
    got = parsed("LREAL", [tie, tie + "1", "0." + 700 * "0" + "1e700", 309 * "9", 300 * "1" + "e-299"])
    assert got == [2.0**53, 2.0**53 + 2, 0.1, math.inf, float(300 * "1" + "e-299")]


def test_text_to_real():
    """Rounded once, to REAL."""
    rng = random.Random(4)
    texts = [repr(rng.uniform(-1, 1) * 10.0 ** rng.randint(-44, 38)) for _ in range(300)]
    texts += ["16777217", "16777219", "3.4028235e38", "1e-46", "7e-46", "8e-46"]
    got = parsed("REAL", texts)
    assert got == [float(numpy.float32(t)) for t in texts]
    # a digit far behind decides: not rounded to LREAL first
    got = parsed("REAL", ["16777217.0000000001", "16777216.9999999999", "3.4028236e38", "1e39"])
    assert got == [16777218.0, 16777216.0, math.inf, math.inf]


def test_text_begins_with_number():
    check(
        """
        LREAL STRING_TO_LREAL('2.5 mm') -> 2.5
        LREAL STRING_TO_LREAL('abc') -> 0.0
        LREAL STRING_TO_LREAL('') -> 0.0
        LREAL STRING_TO_LREAL(' -1.5') -> -1.5
        LREAL STRING_TO_LREAL('1.2.3') -> 1.2
        LREAL STRING_TO_LREAL('7') -> 7.0
        REAL STRING_TO_REAL('3e2x') -> 300.0
        LREAL STRING_TO_LREAL('1_000.5') -> 1000.5
        LREAL WSTRING_TO_LREAL("1.5") -> 1.5
        LREAL STRING_TO_LREAL('e5') -> 0.0
        LREAL STRING_TO_LREAL('.') -> 0.0
    """
    )


# ------------------------------------------------------------------------------------------ times and dates


def test_durations():
    check(
        """
        STRING TIME_TO_STRING(T#1h2m3s4ms) -> 'T#1h2m3s4ms'
        STRING TIME_TO_STRING(T#0ms) -> 'T#0ms'
        STRING TIME_TO_STRING(T#12ms) -> 'T#12ms'
        STRING TIME_TO_STRING(T#1d12h) -> 'T#1d12h'
        STRING TIME_TO_STRING(T#90s) -> 'T#1m30s'
        STRING TIME_TO_STRING(T#49d17h2m47s295ms) -> 'T#49d17h2m47s295ms'
        STRING LTIME_TO_STRING(LTIME#1us5ns) -> 'LTIME#1us5ns'
        STRING LTIME_TO_STRING(LTIME#0ns) -> 'LTIME#0ns'
        STRING LTIME_TO_STRING(LTIME#1d2h3m4s5ms6us7ns) -> 'LTIME#1d2h3m4s5ms6us7ns'
        WSTRING TIME_TO_WSTRING(T#5s) -> 'T#5s'
        TIME STRING_TO_TIME('T#1h2m3s4ms') -> 3723.004
        TIME STRING_TO_TIME('t#1.5s') -> 1.5
        TIME STRING_TO_TIME('TIME#100ms') -> 0.1
        TIME STRING_TO_TIME('250') -> 0.25
        TIME STRING_TO_TIME('') -> 0.0
        TIME STRING_TO_TIME('T#1h_30m') -> 5400.0
        TIME STRING_TO_TIME('x') -> 0.0
        TIME WSTRING_TO_TIME("T#2s") -> 2.0
        LTIME STRING_TO_LTIME('LTIME#1us5ns') -> 1.005e-06
        LTIME STRING_TO_LTIME('LTIME#-1s') -> -1.0
        LTIME STRING_TO_LTIME('LTIME#1.000000001s') -> 1.000000001
    """
    )


def test_dates():
    check(
        """
        STRING DATE_TO_STRING(D#2002-08-18) -> 'D#2002-08-18'
        STRING DATE_TO_STRING(D#1970-01-01) -> 'D#1970-01-01'
        STRING DATE_TO_STRING(D#2000-02-29) -> 'D#2000-02-29'
        STRING DATE_TO_STRING(D#2105-12-31) -> 'D#2105-12-31'
        STRING TOD_TO_STRING(TOD#14:01:05.123) -> 'TOD#14:01:05.123'
        STRING TOD_TO_STRING(TOD#00:00:00) -> 'TOD#00:00:00'
        STRING DT_TO_STRING(DT#1998-02-13-14:20:00) -> 'DT#1998-02-13-14:20:00'
        STRING DT_TO_STRING(DT#2024-12-31-23:59:59) -> 'DT#2024-12-31-23:59:59'
        WSTRING DATE_TO_WSTRING(D#2002-08-18) -> 'D#2002-08-18'
        STRING LDATE_TO_STRING(LDATE#2002-08-18) -> 'LDATE#2002-08-18'
        STRING LTOD_TO_STRING(LTOD#14:01:05.5) -> 'LTOD#14:01:05.500'
        STRING LDT_TO_STRING(LDT#2024-02-29-12:00:00) -> 'LDT#2024-02-29-12:00:00'
        DATE STRING_TO_DATE('D#1970-01-02') -> 86400.0
        DATE STRING_TO_DATE('1970-01-03') -> 172800.0
        DATE STRING_TO_DATE('DATE#2000-03-01') -> 951868800.0
        DATE STRING_TO_DATE('') -> 0.0
        TOD STRING_TO_TOD('TOD#14:01:05.123') -> 50465.123
        TOD STRING_TO_TOD('6:30') -> 23400.0
        DT STRING_TO_DT('DT#1970-01-02-00:00:01') -> 86401.0
        DT STRING_TO_DT('1970-01-02 01:00') -> 90000.0
        LDT STRING_TO_LDT('LDT#1970-01-02-00:00:01') -> 86401.0
        LTOD STRING_TO_LTOD('LTOD#00:00:01.5') -> 1.5
        LDATE STRING_TO_LDATE('LDATE#1970-01-02') -> 86400.0
        DATE WSTRING_TO_DATE("D#1970-01-02") -> 86400.0
    """
    )


def test_every_day_reads_back():
    plc = Plc(
        "PROGRAM PLC_PRG\nVAR\n  i, wrong : DINT; d : DATE; s : STRING;\nEND_VAR\nFOR i := 0 TO 49700 DO\n"
        "  d := DINT_TO_DATE(i * 86400); s := DATE_TO_STRING(d);\n"
        "  IF STRING_TO_DATE(s) <> d THEN wrong := wrong + 1; END_IF\n"
        "END_FOR\nEND_PROGRAM\n"
    )
    plc.scan()
    assert plc["PLC_PRG.wrong"] == 0


# ------------------------------------------------------------------------------------------------ characters


def test_between_narrow_and_wide():
    check(
        """
        WSTRING STRING_TO_WSTRING('abc') -> 'abc'
        WSTRING STRING_TO_WSTRING('') -> ''
        STRING WSTRING_TO_STRING("abc") -> 'abc'
        STRING WSTRING_TO_STRING("") -> ''
    """
    )


def test_utf8():
    """Text of any language goes from narrow to wide and back."""
    text = "Grad \u00b0C \u00b5m \u4f4d\u7f6e \U0001f527"
    plc = Plc(
        "PROGRAM PLC_PRG\nVAR\n  a, c : STRING; b : WSTRING;\nEND_VAR\n"
        "b := STRING_TO_WSTRING(a); c := WSTRING_TO_STRING(b);\nEND_PROGRAM\n"
    )
    plc["PLC_PRG.a"] = text
    plc.scan()
    assert plc["PLC_PRG.b"] == text and plc["PLC_PRG.c"] == text
    plc["PLC_PRG.a"] = b"\xb5m \xe4"  # Latin-1
    plc.scan()
    assert plc["PLC_PRG.b"] == "\u00b5m \u00e4"


def test_characters():
    assert evaluate(
        [("STRING", "CHAR_TO_STRING(c)"), ("WSTRING", "WCHAR_TO_WSTRING(w)"), ("CHAR", "STRING_TO_CHAR('xyz')"),
         ("WCHAR", 'WSTRING_TO_WCHAR("\u4f4d")'),
         ("WSTRING", "CHAR_TO_WSTRING(c)"), ("STRING", "WCHAR_TO_STRING(w)")],
        "  c : CHAR; w : WCHAR;", "c := BYTE_TO_CHAR(65); w := WORD_TO_WCHAR(16#4F4D);",
    ) == ["A", "\u4f4d", "x", "\u4f4d", "A", "\u4f4d"]  # fmt: skip

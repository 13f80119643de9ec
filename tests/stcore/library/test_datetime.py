"""Functions of time and date."""

import datetime

import pytest
from harness import Plc, check

DAY = 86400.0


def test_arithmetic():
    check(
        """
        TIME ADD_TIME(T#1s, T#500ms) -> 1.5
        TIME SUB_TIME(T#1s, T#400ms) -> 0.6
        LTIME ADD_LTIME(LTIME#1us, LTIME#2ns) -> 1.002e-06
        LTIME SUB_LTIME(LTIME#1ns, LTIME#3ns) -> -2e-09
        TOD ADD_TOD_TIME(TOD#10:00:00, T#90m) -> 41400.0
        TOD ADD_TOD_TIME(TOD#23:00:00, T#2h) -> 3600.0
        TOD SUB_TOD_TIME(TOD#10:00:00, T#30m) -> 34200.0
        TOD SUB_TOD_TIME(TOD#01:00:00, T#2h) -> 82800.0
        DT ADD_DT_TIME(DT#1970-01-01-23:59:59, T#1s) -> 86400.0
        DT SUB_DT_TIME(DT#1970-01-02-00:00:00, T#1s) -> 86399.0
        TIME SUB_DATE_DATE(D#2024-03-01, D#2024-02-28) -> 172800.0
        TIME SUB_TOD_TOD(TOD#10:00:00, TOD#09:00:00.5) -> 3599.5
        TIME SUB_DT_DT(DT#2000-01-02-00:00:00, DT#2000-01-01-12:00:00) -> 43200.0
        TIME MULTIME(T#1s, 2.5) -> 2.5
        TIME DIVTIME(T#1s, 4) -> 0.25
        TIME MUL_TIME(T#10ms, 3) -> 0.03
        TIME DIV_TIME(T#10ms, 3) -> 0.003
        TIME MULTIME(T#1ms, 1.5) -> 0.002
        LTIME MUL_LTIME(LTIME#3ns, 2) -> 6e-09
        LTIME DIV_LTIME(LTIME#1us, 8) -> 1.25e-07
    """
    )


def test_long_types():
    check(
        """
        LTOD ADD_LTOD_LTIME(LTOD#23:00:00, LTIME#2h) -> 3600.0
        LTOD ADD_LTOD_LTIME(LTOD#01:00:00, LTIME#-2h) -> 82800.0
        LTOD SUB_LTOD_LTIME(LTOD#01:00:00, LTIME#2h) -> 82800.0
        LDT ADD_LDT_LTIME(LDT#1970-01-01-23:59:59, LTIME#1s) -> 86400.0
        LDT SUB_LDT_LTIME(LDT#1970-01-02-00:00:00, LTIME#500ms) -> 86399.5
        LTIME SUB_LDATE_LDATE(LDATE#2024-03-01, LDATE#2024-02-28) -> 172800.0
        LTIME SUB_LTOD_LTOD(LTOD#10:00:00, LTOD#09:00:00.5) -> 3599.5
        LTIME SUB_LDT_LDT(LDT#2000-01-02-00:00:00, LDT#2000-01-01-12:00:00) -> 43200.0
        LDT CONCAT_DATE_LTOD(D#1970-01-02, LTOD#00:00:00.5) -> 86400.5
        LDT CONCAT_LDATE_LTOD(LDATE#1970-01-02, LTOD#00:00:00.5) -> 86400.5
        LDATE CONCAT_LDATE(1970, 1, 3) -> 172800.0
        LTOD CONCAT_LTOD(1, 2, 3, 4) -> 3723.004
        LDT CONCAT_LDT(1970, 1, 2, 1, 2, 3, 500) -> 90123.5
    """
    )


def test_composing():
    check(
        """
        DT CONCAT_DATE_TOD(D#1970-01-02, TOD#00:00:05) -> 86405.0
        DATE CONCAT_DATE(1970, 1, 3) -> 172800.0
        TOD CONCAT_TOD(1, 2, 3, 4) -> 3723.004
        DT CONCAT_DT(1970, 1, 2, 1, 2, 3, 999) -> 90123.0
        INT DAY_OF_WEEK(D#1970-01-01) -> 4
        INT DAY_OF_WEEK(D#2024-02-29) -> 4
        INT DAY_OF_WEEK(D#2023-12-31) -> 0
    """
    )


def test_splitting():
    plc = Plc(
        "PROGRAM PLC_PRG\nVAR\n  y, m, d, h, n, s, f, y2, m2, d2, h2, n2, s2, f2 : INT;\nEND_VAR\n"
        "SPLIT_DT(DT#2024-02-29-13:14:15, YEAR => y, MONTH => m, DAY => d, HOUR => h, MINUTE => n,\n"
        "  SECOND => s, MILLISECOND => f);\n"
        "SPLIT_DATE(D#1999-12-31, YEAR => y2, MONTH => m2, DAY => d2);\n"
        "SPLIT_TOD(TOD#23:59:58.007, HOUR => h2, MINUTE => n2, SECOND => s2, MILLISECOND => f2);\nEND_PROGRAM\n"
    )
    plc.scan()
    assert [plc[f"PLC_PRG.{v}"] for v in "y m d h n s f".split()] == [2024, 2, 29, 13, 14, 15, 0]
    assert [plc[f"PLC_PRG.{v}2"] for v in "y m d h n s f".split()] == [1999, 12, 31, 23, 59, 58, 7]


def test_splitting_long_types():
    plc = Plc(
        "PROGRAM PLC_PRG\nVAR\n  y, m, d, h, n, s, f, y2, m2, d2, h2, n2, s2, f2 : INT;\nEND_VAR\n"
        "SPLIT_LDT(LDT#2024-02-29-13:14:15 + LTIME#250ms, YEAR => y, MONTH => m, DAY => d, HOUR => h, MINUTE => n,\n"
        "  SECOND => s, MILLISECOND => f);\n"
        "SPLIT_LDATE(LDATE#1999-12-31, YEAR => y2, MONTH => m2, DAY => d2);\n"
        "SPLIT_LTOD(LTOD#23:59:58.007, HOUR => h2, MINUTE => n2, SECOND => s2, MILLISECOND => f2);\nEND_PROGRAM\n"
    )
    plc.scan()
    assert [plc[f"PLC_PRG.{v}"] for v in "y m d h n s f".split()] == [2024, 2, 29, 13, 14, 15, 250]
    assert [plc[f"PLC_PRG.{v}2"] for v in "y m d h n s f".split()] == [1999, 12, 31, 23, 59, 58, 7]


def test_every_day():
    """All days of DATE: split, put together again, day of the week."""
    count = 49710
    plc = Plc(
        f"PROGRAM PLC_PRG\nVAR\n  i, wrong : DINT; d : DATE; y, m, day : INT; years : ARRAY[0..{count - 1}] OF INT;\n"
        f"  months : ARRAY[0..{count - 1}] OF INT; days : ARRAY[0..{count - 1}] OF INT;\n"
        f"  week : ARRAY[0..{count - 1}] OF INT;\nEND_VAR\n"
        f"FOR i := 0 TO {count - 1} DO\n  d := LINT_TO_DATE(DINT_TO_LINT(i) * 86400);\n"
        "  SPLIT_DATE(d, YEAR => y, MONTH => m, DAY => day);\n"
        "  years[i] := y; months[i] := m; days[i] := day; week[i] := DAY_OF_WEEK(d);\n"
        "  IF CONCAT_DATE(y, m, day) <> d THEN wrong := wrong + 1; END_IF\nEND_FOR\nEND_PROGRAM\n"
    )
    plc.scan()
    assert plc["PLC_PRG.wrong"] == 0
    years, months, days, week = (plc[f"PLC_PRG.{n}"] for n in ("years", "months", "days", "week"))
    first = datetime.date(1970, 1, 1)
    for i in range(0, count, 7):
        day = first + datetime.timedelta(days=i)
        assert (years[i], months[i], days[i], week[i]) == (day.year, day.month, day.day, day.isoweekday() % 7)


@pytest.mark.parametrize("name", ["TIME", "CURTIME"])
def test_time_of_scan(name):
    plc = Plc(f"PROGRAM PLC_PRG\nVAR\n  t : TIME;\nEND_VAR\nt := {name}();\nEND_PROGRAM\n", interval=5)
    plc.scan(3)
    assert plc["PLC_PRG.t"] == 0.01

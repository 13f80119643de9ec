"""Literals: text as written -> Python value and type name, as syntax.Literal documents them."""

from __future__ import annotations

import re
from datetime import date

_INTEGER = re.compile(r"\d+(?:_\d+)*")
_REAL = re.compile(r"(\d+(?:_\d+)*)\.(\d+(?:_\d+)*)(?:[eE][+-]?\d+)?|\d+(?:_\d+)*[eE][+-]?\d+")
_DURATION = re.compile(r"(\d[\d_]*)(?:\.(\d[\d_]*))?(ms|us|ns|d|h|m|s)_?", re.I)
_ESCAPE = re.compile(r"\$(?:([NLRTP$'\"])|([0-9A-F]{4})|([0-9A-F]{2})|(.?))", re.I)

_NANOSECONDS = {
    "d": 86_400 * 10**9, "h": 3_600 * 10**9, "m": 60 * 10**9, "s": 10**9, "ms": 10**6, "us": 10**3, "ns": 1,
}  # fmt: skip
_ESCAPES = {"N": "\n", "L": "\n", "R": "\r", "T": "\t", "P": "\f", "$": "$", "'": "'", '"': '"'}
_LONG_NAMES = {
    "T": "TIME", "LT": "LTIME", "D": "DATE", "LD": "LDATE", "TIME_OF_DAY": "TOD", "LTIME_OF_DAY": "LTOD",
    "DATE_AND_TIME": "DT", "LDATE_AND_TIME": "LDT",
}  # fmt: skip
_EPOCH = date(1970, 1, 1).toordinal()
_MAX_TIME = 2**32 * 10**6  # TIME is 32-bit milliseconds
_MAX_LTIME = 2**63


class BadLiteral(ValueError):
    """A literal that is none: the code of the problem, and why."""

    def __init__(self, code: str, why: str) -> None:
        self.code = code
        self.why = why
        super().__init__(why)


def number(text: str) -> int | float:
    """5, 1_000, 16#FF, 2#1010, 1.5, 1.5e-3. Raises BadLiteral."""
    if text.isdecimal():
        value = int(text)
    elif "#" in text:
        base, _, digits = text.partition("#")
        value = _based(base, digits)
    elif _INTEGER.fullmatch(text):
        value = int(text)
    elif _REAL.fullmatch(text):
        real = float(text)
        if real in (float("inf"), float("-inf")):
            raise BadLiteral("E0109", "it is larger than an LREAL can be")
        return real
    else:
        raise BadLiteral("E0109", _why_no_number(text))
    if value >= 1 << 64:
        raise BadLiteral("E0109", "it needs more than 64 bits")
    return value


def _based(base: str, digits: str) -> int:
    sign = -1 if digits.startswith("-") else 1
    digits = digits.lstrip("+-")
    if base not in ("2", "8", "10", "16"):
        raise BadLiteral("E0109", f"a base is 2, 8, 10 or 16, not {base}")
    allowed = "0123456789ABCDEF"[: int(base)]
    for digit in digits.upper():
        if digit != "_" and digit not in allowed:
            raise BadLiteral("E0109", f"{digit} is no digit in base {base}")
    if not digits.strip("_"):
        raise BadLiteral("E0109", "its digits are missing")
    return sign * int(digits.replace("_", ""), int(base))


def _why_no_number(text: str) -> str:
    if re.fullmatch(r"0[xX][0-9A-Fa-f]+", text):
        return f"hexadecimal is written 16#{text[2:]}"
    if match := re.search(r"[^\d_.]", text):
        return f"{match[0]} does not belong in a number"
    return "an underscore stands between two digits"


def typed(text: str) -> tuple[object, str]:
    """INT#5, WORD#16#FF, T#1d2h, D#2024-01-31, ...: value and type name. Raises BadLiteral."""
    prefix, _, rest = text.partition("#")
    name = prefix.upper()
    name = _LONG_NAMES.get(name, name)
    match name:
        case "TIME" | "LTIME":
            return _duration(rest, name), name
        case "DATE" | "LDATE":
            return _date(rest, name), name
        case "TOD" | "LTOD":
            return _clock(rest) // (10**6 if name == "TOD" else 1), name
        case "DT" | "LDT":
            day, _, clock = rest.rpartition("-")
            return _date(day, name) + _clock(clock) // (10**9 if name == "DT" else 1), name
        case "BOOL":
            values = {"TRUE": True, "FALSE": False, "1": True, "0": False, "2#1": True, "2#0": False}
            if rest.upper() not in values:
                raise BadLiteral("E0109", "a BOOL is TRUE, FALSE, 1 or 0")
            return values[rest.upper()], name
        case "REAL" | "LREAL":
            sign = -1 if rest.startswith("-") else 1
            return sign * float(number(rest.lstrip("+-"))), name
    sign = -1 if rest.startswith("-") else 1
    value = number(rest.lstrip("+-"))
    if isinstance(value, float):
        raise BadLiteral("E0109", f"{prefix} has no fraction")
    return sign * value, name


def _duration(text: str, name: str) -> int:
    """1d2h3m4s5.5ms -> nanoseconds."""
    negative = text.startswith("-")
    body = text.lstrip("+-")
    total, at, last = 0, 0, None
    for match in _DURATION.finditer(body):
        if match.start() != at:
            break
        whole, fraction, unit = match[1].replace("_", ""), (match[2] or "").replace("_", ""), match[3].lower()
        size = _NANOSECONDS[unit]
        if last is not None and size >= last:
            raise BadLiteral("E0110", f"{unit} stands after a unit that is not longer; the order is d h m s ms us ns")
        total += int(whole) * size + (int(fraction) * size // 10 ** len(fraction) if fraction else 0)
        at, last = match.end(), size
    if at == 0 or at != len(body):
        raise BadLiteral("E0110", "it is made of numbers with the units d h m s ms us ns, as in T#1m30s500ms")
    if name == "TIME" and (negative and total or total >= _MAX_TIME):
        raise BadLiteral("E0110", "TIME goes from T#0ms to T#49d17h2m47s295ms; LTIME# reaches further")
    if total >= _MAX_LTIME:
        raise BadLiteral("E0110", "LTIME reaches 292 years")
    return -total if negative else total


def _date(text: str, name: str) -> int:
    """2024-01-31 -> seconds since 1970-01-01; nanoseconds for LDATE and LDT."""
    parts = text.split("-")
    if len(parts) != 3 or not all(p.isdecimal() for p in parts):
        raise BadLiteral("E0111", "it is written year-month-day, as in D#2024-01-31")
    year, month, day = map(int, parts)
    last = 2261 if name[0] == "L" else 2106
    if not 1970 <= year <= last:
        raise BadLiteral("E0111", f"the year is from 1970 to {last}, not {year}")
    if not 1 <= month <= 12:
        raise BadLiteral("E0111", f"there is no month {month}")
    try:
        days = date(year, month, day).toordinal() - _EPOCH
    except ValueError:
        raise BadLiteral("E0111", f"month {month} of {year} has no day {day}") from None
    return days * 86_400 * (10**9 if name[0] == "L" else 1)


def _clock(text: str) -> int:
    """12:34:56.789 -> nanoseconds since midnight."""
    match = re.fullmatch(r"(\d+):(\d+)(?::(\d+)(?:\.(\d+))?)?", text)
    if not match:
        raise BadLiteral("E0111", "a time of day is written hours:minutes:seconds, as in TOD#12:34:56.789")
    hours, minutes, seconds = int(match[1]), int(match[2]), int(match[3] or 0)
    for value, limit, what in ((hours, 24, "hour"), (minutes, 60, "minute"), (seconds, 60, "second")):
        if value >= limit:
            raise BadLiteral("E0111", f"there is no {what} {value}")
    fraction = int((match[4] or "0")[:9].ljust(9, "0"))
    return ((hours * 60 + minutes) * 60 + seconds) * 10**9 + fraction


def string(text: str) -> str:
    """The characters of 'text' or "text", escapes resolved. Raises BadLiteral."""
    body, wide = text[1:-1], text[0] == '"'
    if "$" not in body:
        return body

    def resolve(match: re.Match) -> str:
        simple, four, two, other = match.groups()
        if simple:
            return _ESCAPES[simple.upper()]
        if four:
            return chr(int(four, 16)) if wide else chr(int(four[:2], 16)) + four[2:]
        if two and not wide:
            return chr(int(two, 16))
        raise BadLiteral("E0112", f"${two or other}")

    return _ESCAPE.sub(resolve, body)

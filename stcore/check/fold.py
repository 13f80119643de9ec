"""Arithmetic of constants: the same results at compile time as the module gives at run time."""

from __future__ import annotations

import math
import struct

from stcore import types as t

COMPARISONS = {
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
}
LOGIC = {
    "AND": lambda a, b: a & b,
    "OR": lambda a, b: a | b,
    "XOR": lambda a, b: a ^ b,
    "AND_THEN": lambda a, b: a and b,
    "OR_ELSE": lambda a, b: a or b,
}


def logic(op: str, a, b, kind: t.Elementary):
    """a op b of BOOL or of the bits of `kind`."""
    if kind.kind not in ("int", "bits"):
        return LOGIC[op](a, b)
    room = computing_type(kind)
    return wrap(LOGIC[op](wrap(a, room), wrap(b, room)), room)


def wrap(value: int, kind: t.Elementary) -> int:
    """Keep the low bits of an integer, as a store into `kind` does."""
    bits = kind.size * 8
    value &= (1 << bits) - 1
    return value - (1 << bits) if kind.signed and value >> (bits - 1) else value


def single(value: float) -> float:
    """Round to REAL."""
    try:
        return struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        return math.copysign(math.inf, value)


def round_away(value: float) -> int:
    """Nearest integer, half away from zero."""
    whole = math.trunc(value)
    return whole + int(math.copysign(1, value)) if abs(value - whole) >= 0.5 else whole


def saturate(value: float, kind: t.Elementary, *, cut: bool = False) -> int:
    """A real as an integer of `kind`: rounded (or cut off), held at the ends of the range, NaN to 0."""
    if math.isnan(value):
        return 0
    if math.isinf(value):
        return kind.high if value > 0 else kind.low
    return min(max(math.trunc(value) if cut else round_away(value), kind.low), kind.high)


def computing_type(kind: t.Type) -> t.Type:
    """The type in which integers of `kind` are computed: DINT at least (reference/semantics.md)."""
    if isinstance(kind, t.Elementary) and kind.kind in ("int", "bits", "bool", "char") and kind.size < 4:
        return t.DINT
    return kind


def _divide(a: int, b: int) -> int:
    quotient = abs(a) // abs(b)
    return quotient if (a < 0) == (b < 0) else -quotient


def arithmetic(op: str, a, b, kind: t.Elementary):
    """a op b in `kind`; None when it has no value (integer division by zero)."""
    if kind is t.REAL:
        result = _real(op, single(float(a)), single(float(b)))
        return None if result is None else single(result)
    if kind.kind == "real" or kind is t.REAL_LITERAL:
        return _real(op, float(a), float(b))
    if kind is not t.INT_LITERAL:
        a, b = wrap(a, computing_type(kind)), wrap(b, computing_type(kind))
    if op in ("/", "MOD") and b == 0:
        return None
    if op == "**":
        return None if b < 0 else a**b if b < 200 else None
    result = {
        "+": lambda: a + b,
        "-": lambda: a - b,
        "*": lambda: a * b,
        "/": lambda: _divide(a, b),
        "MOD": lambda: a - b * _divide(a, b),
    }[op]()
    return result if kind is t.INT_LITERAL else wrap(result, computing_type(kind))


def _real(op: str, a: float, b: float) -> float | None:
    if op == "/":
        if b == 0:
            return math.nan if a == 0 or math.isnan(a) else math.copysign(math.inf, a) * math.copysign(1, b)
        return a / b
    if op == "+":
        return a + b
    if op == "-":
        return a - b
    if op == "*":
        return a * b
    return None  # ** of reals is computed by the library, so that both ways give the same bits

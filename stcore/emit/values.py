"""Instructions for values: constants, loads, stores, conversions between elementary types."""

from __future__ import annotations

import math
import struct

from stcore import types as t
from stcore.check.conversions import TIME_UNIT


def number(value: object, wasm: str) -> str:
    """A constant instruction."""
    if wasm[0] == "i":
        bits = int(wasm[1:])
        low = int(value) & ((1 << bits) - 1)
        return f"({wasm}.const {low - (1 << bits) if low >> (bits - 1) else low})"
    value = float(value)
    if math.isnan(value):
        return f"({wasm}.const nan)"
    if math.isinf(value):
        return f"({wasm}.const {'-' if value < 0 else ''}inf)"
    if wasm == "f32":
        value = struct.unpack("<f", struct.pack("<f", value))[0]
    return f"({wasm}.const {value.hex()})"


def constant(value: object, kind: t.Type) -> str:
    """A constant of an elementary type."""
    return number(value, wasm_type(kind))


def wasm_type(kind: t.Type) -> str:
    """What holds a value of this type: aggregates and pointers are addresses."""
    base = t.base_of(kind)
    return base.wasm if isinstance(base, t.Elementary) else "i32"


def _access(kind: t.Type) -> tuple[str, str]:
    base = t.base_of(kind)
    return (base.wasm, base.access) if base.__class__ is t.Elementary else ("i32", "")


def _at(base: str, offset: int) -> str:
    where = f"offset={offset} " if offset else ""
    return where + (base or "(i32.const 0)")


def load(kind: t.Type, base: str, offset: int) -> str:
    wasm, suffix = _access(kind)
    return f"({wasm}.load{suffix} {_at(base, offset)})"


def store(kind: t.Type, base: str, offset: int, value: str) -> str:
    wasm, suffix = _access(kind)
    return f"({wasm}.store{suffix.partition('_')[0]} {_at(base, offset)} {value})"


def address(base: str, offset: int) -> str:
    if not base:
        return f"(i32.const {offset})"
    return f"(i32.add {base} (i32.const {offset}))" if offset else base


def wrap(kind: t.Type, value: str) -> str:
    """Keep a value computed in 32 bits within a smaller type."""
    base = t.base_of(kind)
    if not isinstance(base, t.Elementary) or base.size >= 4 or base.kind == "bool":
        return value
    if base.signed:
        return f"(i32.extend{base.size * 8}_s {value})"
    return f"(i32.and {value} (i32.const {(1 << base.size * 8) - 1}))"


def _to_real(base: t.Elementary, goal: t.Elementary, value: str) -> str:
    if base.kind == "real":
        if base.size == goal.size:
            return value
        return f"(f64.promote_f32 {value})" if goal.size == 8 else f"(f32.demote_f64 {value})"
    sign = "s" if base.signed or base.size < 4 else "u"
    return f"({goal.wasm}.convert_{base.wasm}_{sign} {value})"


def _from_real(base: t.Elementary, goal: t.Elementary, value: str) -> str:
    """Rounded, and held at the ends of the range (reference/semantics.md)."""
    value = _to_real(base, t.LREAL, value)
    value = f"(call $round {value})"
    sign = "s" if goal.signed else "u"
    if goal.size < 4:
        low, high = number(goal.low, "f64"), number(goal.high, "f64")
        value = f"(f64.min (f64.max {value} {low}) {high})"
        sign = "s"
    return f"({goal.wasm}.trunc_sat_f64_{sign} {value})"


def _between_times(base: t.Elementary, goal: t.Elementary, value: str) -> str:
    """Through nanoseconds in 64 bits."""
    value = value if base.size == 8 else f"(i64.extend_i32_u {value})"
    if TIME_UNIT[base.name] != 1:
        value = f"(i64.mul {value} (i64.const {TIME_UNIT[base.name]}))"
    day = 86400 * 10**9
    if goal.name in ("TOD", "LTOD") and base.name not in ("TOD", "LTOD"):
        value = f"(i64.rem_u {value} (i64.const {day}))"
    elif goal.name in ("DATE", "LDATE") and base.name not in ("DATE", "LDATE"):
        value = f"(i64.mul (i64.div_u {value} (i64.const {day})) (i64.const {day}))"
    if TIME_UNIT[goal.name] != 1:
        value = f"(i64.div_s {value} (i64.const {TIME_UNIT[goal.name]}))"
    return value if goal.size == 8 else f"(i32.wrap_i64 {value})"


def convert(base: t.Elementary, goal: t.Elementary, value: str) -> str:
    """A value of type base as one of type goal; an integer may come computed in 32 bits."""
    if base is goal:
        return value
    if goal.kind == "real":
        return _to_real(base, goal, value)
    if goal.kind == "bool":
        return f"({base.wasm}.ne {value} {number(0, base.wasm)})"
    if base.kind == "real":
        return _from_real(base, goal, value)
    if base.name in TIME_UNIT and goal.name in TIME_UNIT:
        return _between_times(base, goal, value)
    if goal.size == 8:
        sign = "s" if base.signed or base.size < 4 else "u"
        return value if base.size == 8 else f"(i64.extend_i32_{sign} {value})"
    if base.size == 8:
        value = f"(i32.wrap_i64 {value})"
    return value if base.low >= goal.low and base.high <= goal.high and base.kind == "bool" else wrap(goal, value)

"""Instructions of the built-in functions (the checker's half: stcore/check/builtins.py)."""

from __future__ import annotations

from collections.abc import Callable

from stcore import syntax as s
from stcore import types as t
from stcore.emit.values import address, number, wasm_type
from stcore.program import INTERVAL, NOW, SCAN
from stcore.scope import BuiltinCall


def _unsigned(kind: t.Type) -> bool:
    base = t.base_of(kind)
    return not (isinstance(base, t.Elementary) and (base.signed or base.size < 4))


def _abs(e, node: s.Call, call: BuiltinCall) -> str:
    wasm = wasm_type(call.kind)
    value = e.value(call.args[0])
    if wasm[0] == "f":
        return f"({wasm}.abs {value})"
    if _unsigned(call.kind):
        return value
    temp = e.temp(wasm)
    return (
        f"(select (local.tee {temp} {value}) ({wasm}.sub ({wasm}.const 0) (local.get {temp}))"
        f" ({wasm}.ge_s (local.get {temp}) ({wasm}.const 0)))"
    )


def _pick(e, kind: t.Type, test: str, first: str, second: str) -> str:
    """first if (first test second) else second; both are evaluated once."""
    wasm = wasm_type(kind)
    a, b = e.temp(wasm), e.temp(wasm)
    sign = "" if wasm[0] == "f" else "_u" if _unsigned(kind) else "_s"
    return (
        f"(block (result {wasm}) (local.set {a} {first}) (local.set {b} {second})"
        f" (select (local.get {a}) (local.get {b}) ({wasm}.{test}{sign} (local.get {a}) (local.get {b}))))"
    )


def _extreme(test: str) -> Callable:
    def emit(e, node: s.Call, call: BuiltinCall) -> str:
        text = e.value(call.args[0])
        for arg in call.args[1:]:
            text = _pick(e, call.kind, test, text, e.value(arg))
        return text

    return emit


def _limit(e, node: s.Call, call: BuiltinCall) -> str:
    """LIMIT(MN, IN, MX)"""
    low, value, high = (e.value(a) for a in call.args)
    wasm = wasm_type(call.kind)
    first = e.temp(wasm)
    text = _pick(e, call.kind, "lt", _pick(e, call.kind, "gt", value, f"(local.get {first})"), high)
    return f"(block (result {wasm}) (local.set {first} {low}) {text})"


def _sel(e, node: s.Call, call: BuiltinCall) -> str:
    """Only the input that is taken is worked out, as CODESYS does: SEL(n = 0, x / n, 0) is no division by zero."""
    selector, off, on = (e.value(a) for a in call.args)
    wasm = wasm_type(call.kind)
    if any(word in text for text in (selector, off, on) for word in ("(call", "(block", "(if", ".div", ".rem")):
        return f"(if (result {wasm}) {selector} (then {on}) (else {off}))"
    a = e.temp(wasm)
    return f"(block (result {wasm}) (local.set {a} {off}) (select {on} (local.get {a}) {selector}))"


def _mux(e, node: s.Call, call: BuiltinCall) -> str:
    """Nested choices; an index outside takes the nearest input."""
    wasm = wasm_type(call.kind)
    k = e.temp("i32")
    selector, *inputs = (e.value(a) for a in call.args)
    text = inputs[-1]
    for i in range(len(inputs) - 2, -1, -1):
        text = f"(if (result {wasm}) (i32.le_s (local.get {k}) (i32.const {i})) (then {inputs[i]}) (else {text}))"
    return f"(block (result {wasm}) (local.set {k} {selector}) {text})"


def _trunc(e, node: s.Call, call: BuiltinCall) -> str:
    wasm = wasm_type(call.kind)
    target = t.base_of(node.type)
    value = e.value(call.args[0])
    if target.size < 4:
        low, high = number(target.low, wasm), number(target.high, wasm)
        value = f"({wasm}.min ({wasm}.max {value} {low}) {high})"
    return f"({target.wasm}.trunc_sat_{wasm}_s {value})"


def _shift(e, node: s.Call, call: BuiltinCall) -> str:
    """Bits that leave the type are lost; a count of its width or more leaves none."""
    kind = call.kind
    wasm, bits = kind.wasm, kind.size * 8
    value, count = e.narrow(call.args[0]), call.args[1]
    left = call.name == "SHL"
    op = "shl" if left else "shr_s" if kind.signed else "shr_u"
    if isinstance(count.const, int):
        if not 0 <= count.const < bits:
            return f"({wasm}.const 0)" if op != "shr_s" else f"({wasm}.shr_s {value} ({wasm}.const {bits - 1}))"
        text = f"({wasm}.{op} {value} ({wasm}.const {count.const}))"
    else:
        by = e.value(count)
        n, shifted = e.temp("i32"), e.temp(wasm)
        here, room = f"(local.get {shifted})", f"(i32.const {bits})"
        beyond = f"({wasm}.const 0)" if op != "shr_s" else f"({wasm}.shr_s {here} ({wasm}.const {bits - 1}))"
        amount = f"(local.get {n})" if wasm == "i32" else f"(i64.extend_i32_u (local.get {n}))"
        text = (
            f"(block (result {wasm}) (local.set {shifted} {value}) (local.set {n} {by})"
            f" (if (result {wasm}) (i32.ge_u (local.get {n}) {room})"
            f" (then {beyond}) (else ({wasm}.{op} {here} {amount}))))"
        )
    return e.wrap(kind, text) if left else text


def _rotate(e, node: s.Call, call: BuiltinCall) -> str:
    kind = call.kind
    wasm, bits = kind.wasm, kind.size * 8
    value, count = e.narrow(call.args[0]), e.value(call.args[1])
    by = count if wasm == "i32" else f"(i64.extend_i32_u {count})"
    if bits >= 32:
        return f"({wasm}.rot{'l' if call.name == 'ROL' else 'r'} {value} {by})"
    raw, n = e.temp("i32"), e.temp("i32")
    forth, back = ("shl", "shr_u") if call.name == "ROL" else ("shr_u", "shl")
    mask = (1 << bits) - 1
    text = (
        f"(block (result i32) (local.set {raw} (i32.and {value} (i32.const {mask})))"
        f" (local.set {n} (i32.and {count} (i32.const {bits - 1})))"
        f" (i32.or (i32.{forth} (local.get {raw}) (local.get {n}))"
        f" (i32.{back} (local.get {raw}) (i32.sub (i32.const {bits}) (local.get {n})))))"
    )
    return e.wrap(kind, text)


def _adr(e, node: s.Call, call: BuiltinCall) -> str:
    arg = call.args[0]
    if isinstance(arg.const, str):
        return e.value(arg)
    e.take_address(arg)
    return e.address_of(arg)


def _room(e, node: s.Call, call: BuiltinCall) -> str:
    """The address behind a variable (stcore/check/room.py)."""
    place = call.args[0]
    if isinstance(place, s.Deref) and place.base.symbol != "this":
        return f"(i32.add {e.value(place.base)} (i32.const {place.type.size}))"  # not followed: it may be NULL
    base, offset = e.place(place)
    return address(base, offset + place.type.size)


def _room_at(e, node: s.Call, call: BuiltinCall) -> str:
    """The address behind the variable that an address lies in: one of this POU's own whose place is not fixed, or what
    the module knows."""
    e.module.rooms = True
    if not call.args:
        return "(call $room_at (i32.const 0))"
    at = e.temp("i32")
    text = f"(call $room_at (local.get {at}))"
    for var, (base, low) in e.own_taken():
        start = address(base, low)
        inside = f"(i32.lt_u (i32.sub (local.get {at}) {start}) (i32.const {var.type.size}))"
        text = f"(select {address(base, low + var.type.size)} {text} {inside})"
    return f"(block (result i32) (local.set {at} {e.narrow(call.args[0])}) {text})"


def _memmove(e, node: s.Call, call: BuiltinCall) -> str:
    to, source, count = (e.value(a) for a in call.args)
    temp = e.temp("i32")
    mark = e.marker(node, "F0104")
    copied = f"(local.tee {temp} {to}) {source} {count} {mark} (memory.copy)"
    return f"(block (result i32) {copied} (local.get {temp}))"


def _memset(e, node: s.Call, call: BuiltinCall) -> str:
    to, value, count = (e.value(a) for a in call.args)
    if wasm_type(call.args[1].type) == "i64":
        value = f"(i32.wrap_i64 {value})"
    temp = e.temp("i32")
    mark = e.marker(node, "F0104")
    filled = f"(local.tee {temp} {to}) {value} {count} {mark} (memory.fill)"
    return f"(block (result i32) {filled} (local.get {temp}))"


def _bound(e, node: s.Call, call: BuiltinCall) -> str:
    """LOWER_BOUND, UPPER_BOUND of ARRAY[*]."""
    array, dimension = call.args
    pairs = e.bounds_of(array)
    values = [pair[call.name == "UPPER_BOUND"] for pair in pairs]
    if isinstance(dimension.const, int):
        return values[min(max(dimension.const, 1), len(values)) - 1]
    text, which = values[-1], e.temp("i32")
    for i in range(len(values) - 1, 0, -1):
        text = f"(if (result i32) (i32.le_s (local.get {which}) (i32.const {i})) (then {values[i - 1]}) (else {text}))"
    return f"(block (result i32) (local.set {which} {e.value(dimension)}) {text})"


def _instruction(name: str) -> Callable:
    def emit(e, node: s.Call, call: BuiltinCall) -> str:
        return f"({name} {' '.join(e.value(a) for a in call.args)})"

    return emit


def _system(address: int) -> Callable:
    return lambda e, node, call: f"(i64.load (i32.const {address}))"


def _sqrt(e, node: s.Call, call: BuiltinCall) -> str:
    return f"({wasm_type(call.kind)}.sqrt {e.value(call.args[0])})"


def _query(e, node: s.Call, call: BuiltinCall) -> str:
    """The address of the instance, if it is asked for or has the interface, into the second argument."""
    what, place = call.args
    text = e.value(what)
    if call.name == "__QUERYINTERFACE":
        text = f"(call {e.module.dispatch.query(e.module.project.block_pous[call.kind.target])} {text})"
    found = e.temp("i32")
    store = e.store_text(place, f"(local.get {found})")
    return f"(block (result i32) (local.set {found} {text}) {store} (i32.ne (local.get {found}) (i32.const 0)))"


EMIT: dict[str, Callable] = {
    "ABS": _abs, "SQRT": _sqrt, "MIN": _extreme("lt"), "MAX": _extreme("gt"), "LIMIT": _limit, "SEL": _sel, "MUX": _mux,
    "TRUNC": _trunc, "TRUNC_INT": _trunc, "SHL": _shift, "SHR": _shift, "ROL": _rotate, "ROR": _rotate, "ADR": _adr,
    "__ROOM": _room, "__ROOM_AT": _room_at,
    "LOWER_BOUND": _bound, "UPPER_BOUND": _bound, "MEMMOVE": _memmove, "MEMSET": _memset,
    "__QUERYINTERFACE": _query, "__QUERYPOINTER": _query,
    "__ISVALIDREF": lambda e, node, call: f"(i32.ne {e.value(call.args[0])} (i32.const 0))",
    "__FLOOR": _instruction("f64.floor"), "__CEIL": _instruction("f64.ceil"),
    "__NEAREST": _instruction("f64.nearest"), "__COPYSIGN": _instruction("f64.copysign"),
    "__BITS": _instruction("i64.reinterpret_f64"), "__LREAL": _instruction("f64.reinterpret_i64"),
    "__REAL_BITS": _instruction("i32.reinterpret_f32"), "__REAL": _instruction("f32.reinterpret_i32"),
    "__CLZ": lambda e, node, call: f"(i32.wrap_i64 (i64.clz {e.value(call.args[0])}))",
    "__NOW_NS": _system(NOW), "__SCAN": _system(SCAN), "__INTERVAL_NS": _system(INTERVAL),
}  # fmt: skip

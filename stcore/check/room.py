"""How many bytes an argument that is an address leads to, for an input with {attribute 'room_of' := 'pValue'}."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.scope import BuiltinCall, Convert, Var, key


def room_argument(call: s.Call, parameter: Var, values: list[tuple[Var, s.Node | None]]) -> s.Literal:
    """What a call gives to such an input, from the arguments before it."""
    pointer = next(value for p, value in values if key(p.name) == parameter.room_of)
    made = s.Literal(call.start, call.end, _room(pointer), None, "")
    made.const, made.type = made.value, parameter.type
    return made


def _room(value: s.Node | None) -> int:
    """The bytes of the array that a pointer is to, from its constant index on in ADR(a[2]); 0 where that is not known:
    NULL, a number that holds an address, the address of a scalar or of an element whose index is a variable."""
    while isinstance(value, Convert):
        value = value.operand
    if value is None or not isinstance(value.type, t.Pointer):
        return 0
    if isinstance(value.type.target, t.Array):
        return value.type.target.size
    if isinstance(value, s.Call) and isinstance(value.symbol, BuiltinCall) and value.symbol.name == "ADR":
        return _behind(value.symbol.args[0])
    return 0


def _behind(place: s.Node) -> int:
    """From an element to the end of its array. An array inside of an array goes on in its neighbour."""
    if not isinstance(place, s.Index) or isinstance(place.base, s.Index) or not isinstance(place.base.type, t.Array):
        return 0
    array = place.base.type
    if not array.bounds or not all(isinstance(i.const, int) for i in place.indices):
        return 0
    return array.size - array.number_of(index.const for index in place.indices) * array.element.size

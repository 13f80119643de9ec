"""Where the room of an argument that is an address ends, for an input with {attribute 'room_of' := 'pValue'}."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.scope import BuiltinCall, Convert, Var, key


def room_argument(call: s.Call, parameter: Var, values: list[tuple[Var, s.Node | None]]) -> s.Call:
    """What a call gives to such an input, from the arguments before it: __ROOM of the variable that the pointer leads
    into, or, where only the running program knows that, __ROOM_AT of the pointer."""
    pointer = next(value for p, value in values if key(p.name) == parameter.room_of)
    place = _place(pointer)
    made = s.Call(call.start, call.end, call.callee, [])
    if place is not None:
        made.symbol = BuiltinCall("__ROOM", parameter.type, [place])
    else:
        known = pointer is not None and _simple(pointer)
        made.symbol = BuiltinCall("__ROOM_AT", parameter.type, [pointer] if known else [])
    made.type = parameter.type
    return made


def whole(place: s.Node) -> s.Node | None:
    """The variable that a part belongs to: the array of a[i], the structure of p.x. None where p[i] or an ARRAY[*]
    does not tell."""
    while isinstance(place, s.Index) or _goes_on(place):  # an array inside of an array goes on in its neighbour
        place = place.base
        if isinstance(place.type, t.Pointer) or getattr(place.type, "open", 0):
            return None
    return place


def _goes_on(place: s.Node) -> bool:
    """A single value of a structure: x, y and z of a point are read with count 3."""
    return isinstance(place, s.Member) and isinstance(place.base.type, t.Struct) and not t.is_aggregate(place.type)


def _place(value: s.Node | None) -> s.Node | None:
    """The variable that a pointer leads into: the array in ADR(a) and ADR(a[i]), the scalar in ADR(x), what a pointer
    to an array points to. None: a number that holds an address, a pointer to an element."""
    while isinstance(value, Convert):
        value = value.operand
    if value is None or not isinstance(value.type, t.Pointer):
        return None
    place = None
    if isinstance(value, s.Call) and isinstance(value.symbol, BuiltinCall) and value.symbol.name == "ADR":
        place = whole(value.symbol.args[0])
    elif isinstance(value.type.target, t.Array):
        place = s.Deref(value.start, value.end, value)
        place.type = value.type.target
    return place if place is not None and _simple(place) and place.type.size else None


def _simple(node: s.Node) -> bool:
    """May it be worked out a second time? Calls may not."""
    match node:
        case s.Name() | s.Address() | s.Literal():
            return True
        case s.Member() | s.Deref():
            return _simple(node.base)
        case Convert():
            return _simple(node.operand)
        case s.Index():
            return _simple(node.base) and all(_simple(i) for i in node.indices)
        case s.Binary():
            return _simple(node.left) and _simple(node.right)
    return False

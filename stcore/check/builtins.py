"""The functions that the compiler itself provides: which arguments they take and what they give.

Each is an instruction or needs to know types; the emitter's half is stcore/emit/builtins.py. Everything else that ST
calls standard is written in ST, in stcore/library.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import reduce

from stcore import syntax as s
from stcore import types as t
from stcore.check.conversions import INTEGER, common, convert_value, kind_of
from stcore.check.fold import computing_type, saturate, wrap
from stcore.scope import BuiltinCall, Convert, Pou, TypeName, Var

_CONVERSION = re.compile(r"(?:([A-Z_]+?|[A-Z]+)_)?TO_([A-Z_]+)$")


def conversion_types(name: str) -> tuple[t.Elementary | None, t.Elementary] | None:
    """INT_TO_REAL -> (INT, REAL), TO_INT and ANY_TO_INT -> (None, INT), else None; those of strings are in ST."""
    match = _CONVERSION.match(name.removeprefix("ANY_"))
    if not match:
        return None
    source, target = (t.ALIASES.get(x, x) if x else None for x in match.groups())
    pair = [t.ELEMENTARY.get(x) if x else None for x in (source, target)]
    if pair[1] is None or source and pair[0] is None or any(p and p.kind in ("literal", "error") for p in pair):
        return None
    return pair[0], pair[1]


def is_builtin(name: str) -> bool:
    return name in HANDLERS or conversion_types(name) is not None


def check(checker, name: str, node: s.Call) -> s.Node:
    """Check a call of the built-in `name` (upper case). Returns the node to use."""
    args = [a for a in node.args if not a.output]
    if any(a.value is None for a in args):
        args = [a for a in args if a.value is not None]
    handler = HANDLERS.get(name)
    if handler is None:
        return _convert(checker, node, args, *conversion_types(name))
    function, low, high = handler
    if not low <= len(args) <= high:
        wanted = low if low == high else f"{low} or more" if high > 99 else f"{low} to {high}"
        checker.error("E0401", node, name=name, wanted=wanted, given=len(args))
        for a in args:
            checker.value(a.value)
        return checker.wrong(node)
    return function(checker, node, name, [a.value for a in args])


def _done(node: s.Call, name: str, kind: t.Type, result: t.Type, args: list[s.Node]) -> s.Call:
    node.symbol = BuiltinCall(name, kind, args)
    node.type = result
    return node


def _convert(checker, node: s.Call, args: list[s.Arg], source: t.Elementary | None, target: t.Elementary) -> s.Node:
    if len(args) != 1:
        checker.error("E0401", node, name=checker.text(node.callee), wanted=1, given=len(args))
        return checker.wrong(node)
    value = checker.value(args[0].value)
    if value.type is t.ERROR:
        return checker.wrong(node)
    if isinstance(value.type, t.String) and source is None:
        return checker.library_call(node, f"{'W' * value.type.wide}STRING_TO_{target.name}", [value])
    value = checker.settle(value) if source is None else checker.convert(value, source)
    if isinstance(value.type, t.Pointer):
        value = checker.convert(value, t.DWORD)
    base = t.base_of(value.type)
    if not isinstance(base, t.Elementary):
        checker.error("E0302", node, source=value.type, target=target, what="")
        return checker.wrong(node)
    made = Convert(node.start, node.end, value)
    made.type = target
    if value.const is not None:
        made.const = convert_value(value.const, base, target)
        if isinstance(value.const, float) and target.kind in INTEGER and abs(made.const - value.const) >= 1:
            checker.warn("W0306", value, value=value.const, type=target, held=made.const)
    return made


# ------------------------------------------------------------------------------------------------- numbers


def _unify(checker, node: s.Node, values: list[s.Node]) -> tuple[t.Type, list[s.Node]] | None:
    """The values in their common type."""
    values = [checker.value(v) for v in values]
    if any(v.type is t.ERROR for v in values):
        return None
    kind = values[0].type
    for v in values[1:]:
        if isinstance(kind, t.String) and isinstance(v.type, t.String):
            kind = kind if kind.length >= v.type.length else v.type
            continue
        met = common(kind, v.type)
        if met is None and kind_of(kind) == "literal":
            kind = v.type
        elif met is not None and not isinstance(kind, t.Enum):
            kind = met
    if kind_of(kind) == "literal":
        kind = checker.settle(next(v for v in values if v.type is kind)).type
    return kind, [checker.convert(v, kind) for v in values]


def _same_type(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    """MIN, MAX, LIMIT, MOVE: arguments and result of one type."""
    unified = _unify(checker, node, values)
    if unified is None:
        return checker.wrong(node)
    kind, values = unified
    if name == "MOVE":
        return values[0]
    if isinstance(kind, t.String | t.Array | t.Struct | t.Block):
        checker.error("E0316", node, op=name, type=kind)
        return checker.wrong(node)
    constants = [v.const for v in values]
    if None not in constants:
        node.const = {
            "MIN": lambda: reduce(lower, constants),
            "MAX": lambda: reduce(higher, constants),
            "LIMIT": lambda: lower(higher(constants[1], constants[0]), constants[2]),
        }[name]()
    return _done(node, name, kind, kind, values)


def lower(a, b):
    """The lower one; b when they can't be told apart or one is NaN, as the module has it."""
    return a if a < b else b


def higher(a, b):
    return a if a > b else b


def _abs(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    value = checker.value(values[0])
    if kind_of(value.type) not in ("int", "bits", "real", "literal"):
        if value.type is not t.ERROR:
            checker.error("E0316", node, op=name, type=value.type)
        return checker.wrong(node)
    if value.const is not None:
        node.const = abs(value.const)
        if kind_of(value.type) in INTEGER:
            node.const = wrap(node.const, computing_type(t.base_of(value.type)))
    elif kind_of(value.type) == "literal":
        value = checker.settle(value)
    return _done(node, name, t.base_of(value.type), t.base_of(value.type), [value])


def _sqrt(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    value = checker.value(values[0])
    value = checker.convert(value, t.REAL if value.type is t.REAL else t.LREAL)
    if isinstance(value.const, float) and value.const >= 0 and value.type is t.LREAL:
        node.const = math.sqrt(value.const)
    return _done(node, name, value.type, value.type, [value])


def _trunc(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    value = checker.value(values[0])
    value = checker.convert(value, t.REAL if value.type is t.REAL else t.LREAL)
    target = t.INT if name == "TRUNC_INT" else t.DINT
    if isinstance(value.const, float):
        node.const = saturate(value.const, target, cut=True)
    return _done(node, name, value.type, target, [value])


def _choice(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    """SEL(G, IN0, IN1), MUX(K, IN0, IN1, ...): a K outside takes the nearest input (reference/semantics.md)."""
    if name == "SEL":
        selector = checker.boolean(values[0], "the selector of SEL")
    else:
        selector = checker.typed(values[0], t.DINT, "the selector of MUX")
    unified = _unify(checker, node, values[1:])
    if unified is None:
        return checker.wrong(node)
    kind, rest = unified
    return _done(node, name, kind, kind, [selector, *rest])


def _shift(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    value = checker.settle(checker.value(values[0]))
    count = checker.typed(values[1], t.DINT, "the count of a shift")
    if kind_of(value.type) not in INTEGER:
        if value.type is not t.ERROR:
            checker.error("E0316", node, op=name, type=value.type)
        return checker.wrong(node)
    kind = t.base_of(value.type)
    if value.const is not None and isinstance(count.const, int) and count.const >= 0:
        node.const = _shifted(name, wrap(value.const, kind), count.const, kind)
    return _done(node, name, kind, kind, [value, count])


def _shifted(name: str, value: int, count: int, kind: t.Elementary) -> int:
    if name == "SHL":
        return wrap(value << min(count, 64), kind)
    if name == "SHR":
        return wrap(value >> min(count, 64), kind)
    count %= kind.bits
    count = kind.bits - count if name == "ROR" else count
    raw = value & ((1 << kind.bits) - 1)
    return wrap(raw << count | raw >> (kind.bits - count), kind)


_OPERATORS = {
    "ADD": "+", "SUB": "-", "MUL": "*", "DIV": "/", "MOD": "MOD", "EQ": "=", "NE": "<>", "GT": ">", "GE": ">=",
    "LT": "<",
    "LE": "<=", "AND": "AND", "OR": "OR", "XOR": "XOR",
}  # fmt: skip


def _operator(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    """ADD(a, b, c) is a + b + c; GT(a, b, c) is a > b AND b > c."""
    op = _OPERATORS[name]
    made = s.Binary(node.start, node.end, op, values[0], values[1])
    for previous, v in zip(values[1:], values[2:], strict=False):
        if op in ("=", ">", ">=", "<", "<="):
            pair = s.Binary(node.start, node.end, op, previous, v)
            made = s.Binary(node.start, node.end, "AND", made, pair)
        else:
            made = s.Binary(node.start, node.end, op, made, v)
    return checker.expr(made)


def _not(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    return checker.expr(s.Unary(node.start, node.end, "NOT", values[0]))


# ------------------------------------------------------------------------------------------------- memory


def _adr(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    value = values[0]
    if isinstance(value, s.Literal) and isinstance(value.value, str):
        value = checker.value(value)
    else:
        value = checker.place(value, write=True, addressed=True)
        checker.addressed_whole(value.type)
    if value.type is t.ERROR:
        return checker.wrong(node)
    if isinstance(value, s.Part):
        checker.error("E0402", node, name=checker.text(value))
        return checker.wrong(node)
    return _done(node, name, value.type, t.Pointer(value.type), [value])


def _elementary(checker, node: s.Node) -> t.Elementary | None:
    """SIZEOF(INT): the type, where no variable has its name."""
    if not isinstance(node, s.Name) or checker.lookup(node.name) is not None:
        return None
    return t.ELEMENTARY.get(t.ALIASES.get(node.name.upper(), node.name.upper()))


def _sizeof(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    kind = _elementary(checker, values[0])
    if kind is None:
        value = checker.expr(values[0])
        kind = value.symbol.type if isinstance(value.symbol, TypeName | Pou) else value.type
    if kind is None or kind is t.ERROR:
        return checker.wrong(node)
    node.const = kind.size
    node.type = t.UDINT
    if isinstance(kind, t.Array) and not kind.bounds:
        node.const = None
        return _done(node, name, kind, t.UDINT, [value])
    node.type = t.INT_LITERAL
    return node


def _isvalidref(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    """__ISVALIDREF(r): whether a REFERENCE leads anywhere (CODESYS V3)."""
    value = checker.value(values[0])
    if value.type is t.ERROR:
        return checker.wrong(node)
    if not isinstance(value, s.Deref) or not value.base.type.reference:
        checker.error("E0501", values[0], name=checker.text(values[0]))
        return checker.wrong(node)
    return _done(node, name, t.DWORD, t.BOOL, [value.base])


def _query(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    """__QUERYINTERFACE(itf, other): whether the instance behind an interface has another one, which it is put into;
    __QUERYPOINTER(itf, p): the address of the instance. FALSE and 0 where there is none (CODESYS V3)."""
    what = checker.value(values[0])
    place = checker.place(values[1], write=True)
    if t.ERROR in (what.type, place.type):
        return checker.wrong(node)
    wanted = t.Interface if name == "__QUERYINTERFACE" else t.Pointer
    if not isinstance(what.type, t.Interface | t.Block) or place.type.__class__ is not wanted:
        kinds = "an instance or an interface, and " + ("an interface" if wanted is t.Interface else "a pointer")
        checker.error("E0407", node, name=name, wanted=kinds, given=f"{what.type} and {place.type}", hint="")
        return checker.wrong(node)
    return _done(node, name, place.type, t.BOOL, [what, place])


def _dynamic(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    hint = "every variable lives as long as the program: declare an array of them and hand out its elements"
    checker.error("E0114", node, what=name, hint=hint)
    return checker.wrong(node)


def _bitadr(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    """BITADR(x): 8 * byte offset + bit within the area of a direct address (CoDeSys V2.3)."""
    value = checker.place(values[0], write=False)
    if value.type is t.ERROR:
        return checker.wrong(node)
    var = value.symbol
    if not isinstance(var, Var) or var.storage != "area":
        checker.error("E0403", node, name=checker.text(value))
        return checker.wrong(node)
    area = {"I": 0x80000000, "Q": 0x40000000, "M": 0}[var.area]
    node.type, node.const = t.DWORD, area + var.address * 8 + (var.bit or 0)
    return node


def _memory(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    """MEMCPY(dest, src, n), MEMMOVE, MEMSET(dest, value, n) and their names in CoDeSys V2.3."""
    kinds = [t.DWORD, t.BYTE if "SET" in name else t.DWORD, t.DINT]
    args = []
    for v, kind in zip(values, kinds, strict=True):
        v = checker.value(v)
        if kind is t.BYTE and v.type is not t.ERROR:
            v = checker.settle(v)
            kind = t.base_of(v.type)
        args.append(checker.convert(v, kind) if not isinstance(v.type, t.Pointer) else v)
    if checker.pou is not None:
        checker.pou.writes_outside = True
    operation = "MEMSET" if "SET" in name else "MEMMOVE"
    return _done(node, operation, t.BYTE, t.DWORD, args)


def _bound(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
    array = checker.value(values[0])
    dimension = checker.typed(values[1], t.DINT, "the dimension")
    if array.type is t.ERROR:
        return checker.wrong(node)
    if not isinstance(array.type, t.Array):
        checker.error("E0311", node, name=checker.text(array), type=array.type)
        return checker.wrong(node)
    if array.type.bounds and isinstance(dimension.const, int) and 1 <= dimension.const <= len(array.type.bounds):
        node.const = array.type.bounds[dimension.const - 1][name == "UPPER_BOUND"]
        node.type = t.DINT
        return node
    return _done(node, name, t.DINT, t.DINT, [array, dimension])


def _typed(result: t.Elementary, *kinds: t.Elementary) -> Callable:
    """A function of the compiler with fixed types."""

    def handler(checker, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
        args = [checker.typed(v, k) for v, k in zip(values, kinds, strict=True)]
        return _done(node, name, result, result, args)

    return handler


_L = t.LREAL
HANDLERS: dict[str, tuple[Callable, int, int]] = {
    "ABS": (_abs, 1, 1), "SQRT": (_sqrt, 1, 1), "MIN": (_same_type, 2, 999), "MAX": (_same_type, 2, 999),
    "LIMIT": (_same_type, 3, 3), "MOVE": (_same_type, 1, 1), "SEL": (_choice, 3, 3), "MUX": (_choice, 2, 999),
    "TRUNC": (_trunc, 1, 1), "TRUNC_INT": (_trunc, 1, 1), "SHL": (_shift, 2, 2), "SHR": (_shift, 2, 2),
    "ROL": (_shift, 2, 2), "ROR": (_shift, 2, 2), "NOT": (_not, 1, 1), "ADR": (_adr, 1, 1), "SIZEOF": (_sizeof, 1, 1),
    "XSIZEOF": (_sizeof, 1, 1), "__ISVALIDREF": (_isvalidref, 1, 1), "__QUERYINTERFACE": (_query, 2, 2),
    "__QUERYPOINTER": (_query, 2, 2), "__NEW": (_dynamic, 0, 99),
    "__DELETE": (_dynamic, 0, 99),
    "BITADR": (_bitadr, 1, 1), "LOWER_BOUND": (_bound, 2, 2), "UPPER_BOUND": (_bound, 2, 2),
    "__FLOOR": (_typed(_L, _L), 1, 1), "__CEIL": (_typed(_L, _L), 1, 1), "__NEAREST": (_typed(_L, _L), 1, 1),
    "__COPYSIGN": (_typed(_L, _L, _L), 2, 2), "__BITS": (_typed(t.LWORD, _L), 1, 1),
    "__LREAL": (_typed(_L, t.LWORD), 1, 1), "__REAL_BITS": (_typed(t.DWORD, t.REAL), 1, 1),
    "__REAL": (_typed(t.REAL, t.DWORD), 1, 1), "__CLZ": (_typed(t.DINT, t.LWORD), 1, 1),
    "__NOW_NS": (_typed(t.LINT), 0, 0), "__SCAN": (_typed(t.LINT), 0, 0), "__INTERVAL_NS": (_typed(t.LINT), 0, 0),
}  # fmt: skip
HANDLERS |= {name: (_operator, 2, 999) for name in _OPERATORS}
HANDLERS |= {
    name: (_memory, 3, 3) for name in ("MEMCPY", "MEMMOVE", "MEMSET", "SYSMEMCPY", "SYSMEMMOVE", "SYSMEMSET")
}  # fmt: skip

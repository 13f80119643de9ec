"""What values an integer expression can have: array accesses that can't go wrong need no check."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.check.calls import BlockCall, FunctionCall
from stcore.check.methods import MethodCall
from stcore.check.width import held
from stcore.scope import BuiltinCall, Convert, Var

Range = tuple[int, int]


def range_of(node: s.Node, known: dict[Var, Range]) -> Range:
    """Lowest and highest value. known: the ranges of variables that hold at this place."""
    if isinstance(node.const, int):
        return int(node.const), int(node.const)
    match node:
        case s.Name() if node.symbol in known:
            return known[node.symbol]
        case Convert() if isinstance(t.base_of(node.operand.type), t.Elementary):
            inner = range_of(node.operand, known)
            low, high = _of_type(node.type)
            return inner if low <= inner[0] and inner[1] <= high else (low, high)
        case s.Binary() if node.op in ("+", "-", "*", "MOD", "/"):
            found = _binary(node, known)
            low, high = _of_type(held(node))
            return found if found and low <= found[0] and found[1] <= high else (low, high)
        case s.Binary() if node.op == "AND":
            highest = [r[1] for r in (range_of(node.left, known), range_of(node.right, known)) if r[0] >= 0]
            if highest:
                return 0, min(highest)
    return _of_type(held(node))


def _of_type(kind: t.Type) -> Range:
    base = t.base_of(kind)
    return (base.low, base.high) if isinstance(base, t.Elementary) else (0, t.UDINT.high)


def _binary(node: s.Binary, known: dict[Var, Range]) -> Range | None:
    (a, b), (c, d) = range_of(node.left, known), range_of(node.right, known)
    match node.op:
        case "+":
            return a + c, b + d
        case "-":
            return a - d, b - c
        case "*":
            ends = (a * c, a * d, b * c, b * d)
            return min(ends), max(ends)
        case "MOD" if c == d and c > 0:
            return (0 if a >= 0 else 1 - c), (c - 1 if b >= 0 else 0)
        case "/" if c == d and c > 0:
            return (a // c if a >= 0 else -(-a // c)), (b // c if b >= 0 else -(-b // c))
    return None


def walk(node: object):
    """Every node below (and with) this one."""
    todo = [node]
    while todo:
        node = todo.pop()
        if isinstance(node, s.Node):
            yield node
            todo += reversed(_parts(node))
        elif isinstance(node, list | tuple):
            todo += reversed(node)


def _parts(node: s.Node) -> list:
    """What is worked out for a node; of a call as the checker understood it."""
    symbol = getattr(node, "symbol", None)
    if isinstance(symbol, BuiltinCall):
        return list(symbol.args)
    first = [symbol.base] if isinstance(symbol, MethodCall) else []
    if isinstance(symbol, FunctionCall):
        return [*first, *(v for _, v in (*symbol.values, *symbol.outputs)), symbol.en, symbol.eno]
    if isinstance(symbol, BlockCall):
        values = [v for _, v in (*symbol.inputs, *symbol.in_outs, *symbol.outputs)]
        return [*first, *values, symbol.instance, symbol.en, symbol.eno]
    return [*first, *(getattr(node, name) for name in node.fields)]

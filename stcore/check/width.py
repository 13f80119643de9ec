"""Which values an integer expression can have before it is stored.

Integers below 32 bits are computed as DINT and narrowed where they are stored: INT 30000 + INT 30000 is 60000 first.
"""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.scope import BuiltinCall

_BITWISE = ("AND", "OR", "XOR")
_CHOICES = {"MIN": 0, "MAX": 0, "LIMIT": 0, "SEL": 1, "MUX": 1}  # built-in -> its first argument that can be the result


def wide(node: s.Node) -> bool:
    """True if the computed value may lie outside the type of the expression; constants are no exception."""
    base = t.base_of(node.type)
    if not isinstance(base, t.Elementary) or base.kind not in ("int", "bits") or base.size >= 4:
        return False
    match node:
        case s.Binary(op=op):
            return op not in _BITWISE or wide(node.left) or wide(node.right)
        case s.Unary(op="-"):
            return True
        case s.Unary(op="+"):
            return wide(node.operand)
        case s.Call(symbol=BuiltinCall(name="ABS")):
            return base.signed or wide(node.symbol.args[0])
        case s.Call(symbol=BuiltinCall(name=name)) if name in _CHOICES:
            return any(wide(a) for a in node.symbol.args[_CHOICES[name] :])
    return False


def held(node: s.Node) -> t.Type:
    """The type that holds every value that the expression can have."""
    return t.DINT if wide(node) else t.base_of(node.type)

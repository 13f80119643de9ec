"""Which types go together, and the conversions that the language does by itself."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.check.fold import saturate, single, wrap
from stcore.check.printed import Printed
from stcore.scope import Convert

NUMERIC = ("int", "bits", "real", "literal")
INTEGER = ("int", "bits")
# what a date is counted in, by type: nanoseconds
TIME_UNIT = {
    "TIME": 10**6, "LTIME": 1, "TOD": 10**6, "LTOD": 1, "DATE": 10**9, "DT": 10**9, "LDATE": 1, "LDT": 1,
}  # fmt: skip


def kind_of(kind: t.Type) -> str:
    """'int', 'bits', 'real', 'bool', 'time', 'date', 'char', 'literal', 'error', or the class of type."""
    base = t.base_of(kind)
    return base.kind if base.__class__ is t.Elementary else base.__class__.__name__.lower()


def same(a: t.Type, b: t.Type) -> bool:
    """True if the two are one type: named types by identity, the others by structure."""
    if a is b:
        return True
    match a, b:
        case t.String(), t.String():
            return a.length == b.length and a.wide == b.wide
        case t.Array(), t.Array():
            return a.bounds == b.bounds and same(a.element, b.element)
        case t.Pointer(), t.Pointer():
            return a.reference == b.reference and same(a.target, b.target)
    return False


def _element(kind: t.Type) -> t.Type:
    """What an array or a text is made of in the end."""
    while isinstance(kind, t.Array):
        kind = kind.element
    if isinstance(kind, t.String):
        return t.WORD if kind.wide else t.BYTE
    return kind


def common(a: t.Type, b: t.Type) -> t.Elementary | None:
    """The type in which numbers of types a and b meet, None if they do not."""
    a, b = t.base_of(a), t.base_of(b)
    if not (isinstance(a, t.Elementary) and isinstance(b, t.Elementary)):
        return None
    if a is b:
        return a
    if a.kind not in NUMERIC or b.kind not in NUMERIC:
        return None
    if "real" in (a.kind, b.kind) or t.REAL_LITERAL in (a, b):
        return _common_real(a, b)
    if a is t.INT_LITERAL or b is t.INT_LITERAL:
        return b if a is t.INT_LITERAL else a
    if a.signed == b.signed:
        return a if a.size >= b.size else b
    signed, unsigned = (a, b) if a.signed else (b, a)
    if signed.size > unsigned.size:
        return signed
    return t.DINT if unsigned.size <= 4 else t.LINT


def _common_real(a: t.Elementary, b: t.Elementary) -> t.Elementary:
    if t.LREAL in (a, b):
        return t.LREAL
    if t.REAL in (a, b):
        other = b if a is t.REAL else a
        return t.LREAL if other.kind in INTEGER and other.size == 8 else t.REAL
    literal = all(x.kind == "literal" for x in (a, b))
    return t.REAL_LITERAL if literal else t.LREAL


def holds(target: t.Elementary, source: t.Elementary) -> bool:
    """True if every value of source is one of target."""
    if target.kind == "real":
        if source.kind == "real":
            return target.size >= source.size
        return source.size * 8 - source.signed <= (53 if target.size == 8 else 24)
    return source.kind != "real" and target.low <= source.low and target.high >= source.high


class Conversions(Printed):
    """Implicit conversions of checked expressions."""

    def convert(self, node: s.Node, target: t.Type, what: str = "") -> s.Node:
        """`node` as a value of `target`; what it can't be is reported once, at the node."""
        source = node.type
        if same(source, target) or t.ERROR in (source, target):
            return node
        if source.__class__ is t.Interface or target.__class__ is t.Interface:
            return self._to_interface(node, target, what)
        if node.const is not None and isinstance(source, t.Elementary) and source.kind in ("literal", "int", "bits"):
            folded = self._convert_constant(node, target)
            if folded is not None:
                return folded
        base, goal = t.base_of(source), t.base_of(target)
        if isinstance(target, t.Enum) and isinstance(source, t.Enum):
            self.warn("W0305", node, source=source, target=target)
            return self._wrapped(node, target)
        if isinstance(base, t.Elementary) and isinstance(goal, t.Elementary):
            return self._convert_elementary(node, base, goal, target)
        if kind_of(target) == "char" and isinstance(node.const, str) and len(node.const) == 1:
            made = self._literal(node, ord(node.const))
            made.type = target
            return made
        if self._compatible_aggregates(node, source, target):
            longer = isinstance(source, t.Pointer) and target.size == 8
            return self._wrapped(node, target) if longer or isinstance(target, t.String | t.Pointer) else node
        if isinstance(target, t.String) and target.wide and isinstance(node.const, str):
            node.type = target
            return node
        self._refuse(node, source, target, what)
        return node

    def _to_interface(self, node: s.Node, target: t.Type, what: str) -> s.Node:
        """For a variable of an interface: an instance whose block implements it, an interface that extends it, or 0."""
        source = node.type
        if isinstance(target, t.Interface):
            if source is t.NULL or source is t.INT_LITERAL and node.const == 0:
                return self._convert_constant(node, target)
            if isinstance(source, t.Interface) and source.extends(target):
                return self._wrapped(node, target)
            if isinstance(source, t.Block) and source.implements(target):
                self._mark(node, node, True, True)
                return self._wrapped(node, target)
            if isinstance(source, t.Block) and self.project.block_pous[source].incomplete:
                return node
        self._refuse(node, source, target, what)
        return node

    def _wrapped(self, node: s.Node, target: t.Type) -> s.Node:
        made = Convert(node.start, node.end, node)
        made.type = target
        if isinstance(node.const, str):
            made.const = node.const[: target.length] if isinstance(target, t.String) else node.const
        base, goal = t.base_of(node.type), t.base_of(target)
        if node.const is not None and isinstance(base, t.Elementary) and isinstance(goal, t.Elementary):
            made.const = convert_value(node.const, base, goal)
        return made

    def _convert_constant(self, node: s.Node, target: t.Type) -> s.Node | None:
        """A literal takes the type that its place asks for."""
        goal, value = t.base_of(target), node.const
        if isinstance(target, t.Pointer) and isinstance(value, int):
            made = self._literal(node, wrap(value, t.UDINT))
            made.type = target
            return made
        if not isinstance(goal, t.Elementary) or isinstance(value, str):
            return None
        if goal.kind in INTEGER and isinstance(value, int):
            low, high = (target.low, target.high) if isinstance(target, t.SubrangeType) else (goal.low, goal.high)
            if not low <= value <= high and not (node.type is not t.INT_LITERAL and goal.kind == "bits"):
                code = "E0602" if isinstance(target, t.SubrangeType) else "W0304"
                self.report(code, node, value=value, type=target, low=low, high=high)
            value = wrap(value, goal)
        elif goal.kind == "real" and node.type.kind == "literal":
            value = single(float(value)) if goal is t.REAL else float(value)
        elif goal.kind == "bool" and node.type is t.INT_LITERAL and value in (0, 1):
            value = bool(value)
        else:
            return None
        made = self._literal(node, value)
        made.type = target
        return made

    @staticmethod
    def _literal(node: s.Node, value: object) -> s.Node:
        made = node if node.__class__ is s.Literal else s.Literal(node.start, node.end, value, None, "")
        made.const = value
        return made

    def _convert_elementary(self, node: s.Node, base: t.Elementary, goal: t.Elementary, target: t.Type) -> s.Node:
        numbers = base.kind in NUMERIC and goal.kind in NUMERIC
        times = base.kind == goal.kind == "time" or base.kind == goal.kind == "char"
        letters = {base.kind, goal.kind} == {"char", "bits"}
        if base is goal:
            return self._wrapped(node, target)
        if not (numbers or times or letters):
            self._refuse(node, node.type, target, "")
            return node
        if base.kind == "literal":
            base = t.LREAL if base is t.REAL_LITERAL else t.LINT
            if node.const is not None and goal.kind in INTEGER and float(node.const).is_integer():
                return self._wrapped(node, target)
        if not holds(goal, base) and not (base.kind == "bits" and goal.kind in INTEGER and goal.size >= base.size):
            if not always_fits(node, goal):
                code = "W0302" if base.kind == "real" and goal.kind != "real" else "W0301"
                self.warn(code, node, source=node.type, target=target)
        return self._wrapped(node, target)

    def _compatible_aggregates(self, node: s.Node, source: t.Type, target: t.Type) -> bool:
        match source, target:
            case t.String(), t.String():
                return source.wide == target.wide or isinstance(node.const, str)
            case t.Array(), t.Array():
                lengths = [b - a for a, b in source.bounds] == [b - a for a, b in target.bounds]
                return lengths and same(source.element, target.element)
            case t.Pointer(), t.Pointer():
                pointed = source.target  # the address of an array is that of its first element
                while isinstance(pointed, t.Array) and not isinstance(target.target, t.Array):
                    pointed = pointed.element
                exact = same(pointed, target.target) or target.target.size == pointed.size
                exact |= isinstance(pointed, t.Block) and pointed.extends(target.target)
                elements = _element(source.target), _element(target.target)
                generic = t.BYTE in elements or elements[0] is elements[1]  # how V2.3 hands over arrays of any length
                if not exact and not generic and t.ERROR not in (source.target, target.target):
                    self.warn("W0303", node, source=source, target=target)
                return True
            case t.String(), t.Pointer():  # char* of a C prototype: the text itself may be given
                return isinstance(target.target, t.String) and not target.reference
            case t.Pointer(), t.Elementary():
                return target.kind in INTEGER and target.size >= 4
            case t.Elementary(), t.Pointer():
                return source is t.NULL or source.kind in INTEGER and source.size >= 4
            case t.Elementary(), t.String():
                return source.kind == "char" and (source.size == 2) == target.wide
        return False

    def _refuse(self, node: s.Node, source: t.Type, target: t.Type, what: str) -> None:
        base, goal = t.base_of(source), t.base_of(target)
        hint = ""
        if base is t.INT_LITERAL and goal.kind == "time" if isinstance(goal, t.Elementary) else False:
            hint = f"write the time as a literal: T#{node.const}ms" if node.const is not None else ""
        elif isinstance(base, t.Elementary | t.String) and isinstance(goal, t.Elementary | t.String):
            names = ["STRING" if isinstance(x, t.String) else x.name for x in (base, goal)]
            names = [{"ANY_INT": "DINT", "ANY_REAL": "LREAL"}.get(n, n) for n in names]
            hint = f"convert it: {names[0]}_TO_{names[1]}(...)"
        self.error("E0302", node, hint=hint, source=_called(source), target=_called(target), what=what and f" ({what})")

    def settle(self, node: s.Node) -> s.Node:
        """Give a literal that nothing else fixes its own type."""
        if node.type is t.INT_LITERAL:
            value = node.const or 0
            target = t.DINT if t.DINT.low <= value <= t.DINT.high else t.LINT if value <= t.LINT.high else t.ULINT
            return self._convert_constant(node, target) if node.const is not None else self._wrapped(node, target)
        if node.type is t.REAL_LITERAL:
            return self._convert_constant(node, t.LREAL) or node
        return node


def _called(kind: t.Type) -> str:
    return {"ANY_INT": "an integer", "ANY_REAL": "a real number"}.get(kind.name, kind.name)


def always_fits(node: s.Node, goal: t.Elementary) -> bool:
    """True for a constant that fits, and for a choice among such constants: SEL(b, 1, 2)."""
    if node.const is not None:
        return _fits(node.const, goal)
    choice = getattr(node, "symbol", None)
    if getattr(choice, "name", "") not in ("SEL", "MUX", "MIN", "MAX", "LIMIT") or not hasattr(choice, "args"):
        return False
    values = choice.args[1:] if choice.name in ("SEL", "MUX") else choice.args
    return all(always_fits(v, goal) for v in values)


def _fits(value: object, goal: t.Elementary) -> bool:
    if goal.kind in INTEGER:
        return isinstance(value, int) and goal.low <= value <= goal.high
    return goal.kind == "real" and (isinstance(value, float) or abs(value) <= 1 << 24)


def convert_value(value: object, base: t.Elementary, goal: t.Elementary) -> object:
    """What X_TO_Y makes of a constant."""
    if isinstance(value, str):
        return value
    if goal.kind == "real":
        if base.kind in ("time", "date"):
            value = value / 1
        return single(float(value)) if goal is t.REAL else float(value)
    if goal.kind == "bool":
        return value != 0
    if isinstance(value, float):
        return saturate(value, goal)
    if base.name in TIME_UNIT and goal.name in TIME_UNIT:
        return wrap(convert_time(int(value), base, goal), goal)
    return wrap(int(value), goal)


def convert_time(value: int, base: t.Elementary, goal: t.Elementary) -> int:
    """Between times and dates: their units, and of a date-and-time the part that the goal keeps."""
    nanoseconds = value * TIME_UNIT[base.name]
    day = 86400 * 10**9
    if goal.name in ("TOD", "LTOD"):
        nanoseconds %= day
    elif goal.name in ("DATE", "LDATE"):
        nanoseconds -= nanoseconds % day
    return nanoseconds // TIME_UNIT[goal.name]

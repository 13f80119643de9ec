"""What expressions are worth, in Python: random well-typed ST expressions with their values.

The rules are those of the page "What differs": integers are computed in the larger operand type, at least DINT; what
is stored wraps around; REAL and LREAL are IEEE 754. A value here is the computed one: INT 30000 + INT 30000 is 60000
until it is stored into an INT.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random


@dataclass(frozen=True)
class Kind:
    name: str
    sort: str  # int, bits, bool, real
    size: int
    signed: bool = False

    @property
    def low(self) -> int:
        return -(1 << (self.size * 8 - 1)) if self.signed else 0

    @property
    def high(self) -> int:
        return 1 if self.sort == "bool" else (1 << (self.size * 8 - self.signed)) - 1


KINDS = {
    k.name: k
    for k in (
        Kind("SINT", "int", 1, True), Kind("INT", "int", 2, True), Kind("DINT", "int", 4, True),
        Kind("LINT", "int", 8, True), Kind("USINT", "int", 1), Kind("UINT", "int", 2), Kind("UDINT", "int", 4),
        Kind("ULINT", "int", 8), Kind("BYTE", "bits", 1), Kind("WORD", "bits", 2), Kind("DWORD", "bits", 4),
        Kind("LWORD", "bits", 8), Kind("BOOL", "bool", 1), Kind("REAL", "real", 4, True),
        Kind("LREAL", "real", 8, True),
    )
}  # fmt: skip
BOOL, DINT, LINT, REAL, LREAL = (KINDS[n] for n in ("BOOL", "DINT", "LINT", "REAL", "LREAL"))
INTEGERS = [k for k in KINDS.values() if k.sort in ("int", "bits")]
REALS = [REAL, LREAL]


def wrap(value: int, kind: Kind) -> int:
    value &= (1 << kind.size * 8) - 1
    return value - (1 << kind.size * 8) if kind.signed and value >> (kind.size * 8 - 1) else value


def single(value: float) -> float:
    try:
        return struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        return math.copysign(math.inf, value)


def round_away(value: float) -> int:
    whole = math.trunc(value)
    return whole + int(math.copysign(1, value)) if abs(value - whole) >= 0.5 else whole


def convert(value, source: Kind, target: Kind):
    """X_TO_Y; also what an assignment does by itself."""
    if target.sort == "bool":
        return value != 0
    if target.sort == "real":
        return single(float(value)) if target is REAL else float(value)
    if source.sort != "real":
        return wrap(int(value), target)
    if math.isnan(value):
        return 0
    if math.isinf(value):
        return target.high if value > 0 else target.low
    return min(max(round_away(value), target.low), target.high)


def common(a: Kind, b: Kind) -> Kind:
    """The type in which two numbers meet."""
    if a is b:
        return a
    if "real" in (a.sort, b.sort):
        if LREAL in (a, b):
            return LREAL
        other = b if a is REAL else a
        return LREAL if other.size == 8 else REAL
    if a.signed == b.signed:
        return a if a.size >= b.size else b
    signed, unsigned = (a, b) if a.signed else (b, a)
    if signed.size > unsigned.size:
        return signed
    return DINT if unsigned.size <= 4 else LINT


def computing(kind: Kind) -> Kind:
    return DINT if kind.sort in ("int", "bits") and kind.size < 4 else kind


def divide(a: int, b: int) -> int:
    quotient = abs(a) // abs(b)
    return quotient if (a < 0) == (b < 0) else -quotient


@dataclass(frozen=True)
class Expr:
    """kind: the type that ST gives it. constant, variable: its text with typed literals, and with variables.

    value: of the environment (name -> value), as it is computed. held: the type that holds every computed value.
    """

    kind: Kind
    constant: str
    variable: str
    value: Callable[[dict], object]
    held: Kind
    literal: bool = False


@dataclass
class Maker:
    """Makes expressions. variables: name -> (kind, value) of the leaves that it made up."""

    random: Random
    variables: dict[str, tuple[Kind, object]] = field(default_factory=dict)

    # ------------------------------------------------------------------------------------------ leaves

    def number(self, kind: Kind):
        r = self.random
        if kind.sort == "bool":
            return r.random() < 0.5
        if kind.sort == "real":
            value = r.choice([0.0, 1.0, -1.0, 0.5, 2.5, -2.5, 1e6, 3.25e9, r.uniform(-100, 100), r.uniform(-1e5, 1e5)])
            return single(value) if kind is REAL else value
        edges = [kind.low, kind.low + 1, kind.high, kind.high - 1, 0, 1, 2, 3, 7, 10, 100]
        edges += [-1, -2, -7] if kind.signed else []
        return r.choice([*edges, r.randint(kind.low, kind.high), r.randint(max(kind.low, -99), 99)])

    def leaf(self, kind: Kind) -> Expr:
        value = self.number(kind)
        name = f"v{len(self.variables)}"
        self.variables[name] = (kind, value)
        return Expr(kind, written(value, kind), name, lambda env: env[name], kind)

    def named(self, kind: Kind) -> Expr:
        """A leaf that is a variable, whose bits can be selected."""
        return self.leaf(kind)

    def literal(self, at_most: int = 100) -> Expr:
        """A number without a type: it takes that of its neighbour."""
        value = self.random.randint(0, at_most)
        return Expr(LINT, str(value), str(value), lambda env: value, LINT, literal=True)

    # --------------------------------------------------------------------------------------- operators

    def integer(self, depth: int) -> Expr:
        r = self.random
        if depth == 0 or r.random() < 0.15:
            return self.leaf(r.choice(INTEGERS))
        form = r.choice(
            ["+", "-", "*", "/", "MOD", "AND", "OR", "XOR", "NOT", "neg", "conv", "shift", "pick", "abs", "*"]
        )
        if form == "NOT":
            a = self.integer(depth - 1)
            return make(a.kind, "NOT ({})", [a], lambda x: wrap(~wrap(x, a.kind), a.kind))
        if form == "neg":
            return negative(self.integer(depth - 1))
        if form == "abs":
            a = self.integer(depth - 1)
            held = computing(a.kind) if a.kind.signed else a.held
            return make(a.kind, "ABS({})", [a], lambda x: wrap(abs(x), computing(held)), held)
        if form == "conv":
            a = self.any(depth - 1)
            target = r.choice(INTEGERS)
            name = r.choice([f"{a.kind.name}_TO_{target.name}", f"TO_{target.name}"])
            return make(target, name + "({})", [a], lambda x: convert(x, a.kind, target))
        if form == "shift":
            return self.shift(depth)
        if form == "pick":
            return self.pick(depth)
        a, b = self.integer(depth - 1), self.integer(depth - 1)
        if r.random() < 0.25:
            b = self.literal(min(100, a.kind.high))
        return self.integer_operator(form, a, b)

    def integer_operator(self, op: str, a: Expr, b: Expr) -> Expr:
        kind = a.kind if b.literal else common(a.kind, b.kind)
        room = computing(kind)
        if op in ("/", "MOD"):
            if b.literal and b.value({}) == 0:
                b = self.literal_but_zero()
            if not b.literal:
                b = make(b.kind, "SEL(({0}) = 0, {0}, 3)", [b], lambda x: x or 3, b.held)
            held = [a.held if b.literal else x.held for x in (a, b)]
            if len({h.signed for h in held}) == 2 and max(h.size for h in held if not h.signed) == 4:
                kind = room = LINT
            if op == "/":
                return make(
                    kind, "({} / {})", [a, b], lambda x, y: wrap(divide(wrap(x, room), wrap(y, room)), room), room
                )
            return make(kind, "({} MOD {})", [a, b], lambda x, y: remainder(wrap(x, room), wrap(y, room)), room)
        operation = {
            "+": lambda x, y: x + y, "-": lambda x, y: x - y, "*": lambda x, y: x * y, "AND": lambda x, y: x & y,
            "OR": lambda x, y: x | y, "XOR": lambda x, y: x ^ y,
        }[op]  # fmt: skip
        narrow = op in ("AND", "OR", "XOR") and all(x.literal or x.held is x.kind for x in (a, b))
        return make(
            kind, f"({{}} {op} {{}})", [a, b], lambda x, y: wrap(operation(x, y), room), kind if narrow else room
        )

    def literal_but_zero(self) -> Expr:
        value = self.random.randint(1, 100)
        return Expr(LINT, str(value), str(value), lambda env: value, LINT, literal=True)

    def shift(self, depth: int) -> Expr:
        a, op = self.integer(depth - 1), self.random.choice(["SHL", "SHR", "ROL", "ROR"])
        kind, bits = a.kind, a.kind.size * 8
        count = self.random.choice([0, 1, 3, bits - 1, bits, bits + 1, 70])
        n = Expr(DINT, str(count), str(count), lambda env: count, DINT)
        if self.random.random() < 0.5:
            name = f"v{len(self.variables)}"
            self.variables[name] = (DINT, count)
            n = Expr(DINT, f"DINT#{count}", name, lambda env: env[name], DINT)

        def shifted(x: int, by: int) -> int:
            x = wrap(x, kind)
            if op == "SHL":
                return wrap(x << by, kind)
            if op == "SHR":
                return x >> by
            by = by % bits if op == "ROL" else -by % bits
            raw = x & ((1 << bits) - 1)
            return wrap(raw << by | raw >> (bits - by), kind)

        return make(kind, op + "({}, {})", [a, n], shifted)

    def pick(self, depth: int) -> Expr:
        """MIN, MAX, LIMIT, SEL, MUX of one type."""
        r = self.random
        first = self.integer(depth - 1)
        rest = [self.leaf(first.kind) for _ in range(2)]
        args, kind, held = [first, *rest], first.kind, first.held
        name = r.choice(["MIN", "MAX", "LIMIT", "SEL", "MUX"])
        if name == "SEL":
            return make(kind, "SEL({}, {}, {})", [self.boolean(1), *args[:2]], lambda g, x, y: y if g else x, held)
        if name == "MUX":
            index = r.randint(-1, 4)
            choose = lambda *x: x[min(max(index, 0), 2)]  # noqa: E731
            return make(kind, f"MUX({index}, {{}}, {{}}, {{}})", args, choose, held)
        function = {"MIN": min, "MAX": max, "LIMIT": lambda low, x, high: min(max(x, low), high)}[name]
        return make(kind, name + "({}, {}, {})", args, function, held)

    def real(self, depth: int) -> Expr:
        r = self.random
        if depth == 0 or r.random() < 0.15:
            return self.leaf(r.choice(REALS))
        form = r.choice(["+", "-", "*", "/", "neg", "conv", "pick", "abs"])
        if form in ("neg", "abs"):
            a = self.real(depth - 1)
            return make(a.kind, "(-{})" if form == "neg" else "ABS({})", [a], lambda x: -x if form == "neg" else abs(x))
        if form == "conv":
            a, target = self.any(depth - 1), r.choice(REALS)
            return make(target, f"{a.kind.name}_TO_{target.name}({{}})", [a], lambda x: convert(x, a.kind, target))
        if form == "pick":
            a = self.real(depth - 1)
            b = self.leaf(a.kind)
            name = r.choice(["MIN", "MAX"])
            return make(a.kind, name + "({}, {})", [a, b], lambda x, y: extreme(name, x, y))
        a, b = self.real(depth - 1), self.any_number(depth - 1)
        if r.random() < 0.5:
            a, b = b, a
        kind = common(a.kind, b.kind)
        operation = {"+": lambda x, y: x + y, "-": lambda x, y: x - y, "*": lambda x, y: x * y, "/": real_quotient}[
            form
        ]

        def compute(x, y):
            return convert(operation(convert(x, a.kind, kind), convert(y, b.kind, kind)), LREAL, kind)

        return make(kind, f"({{}} {form} {{}})", [a, b], compute)

    def boolean(self, depth: int) -> Expr:
        r = self.random
        if depth == 0 or r.random() < 0.15:
            return self.leaf(BOOL)
        form = r.choice(["NOT", "AND", "OR", "XOR", "AND_THEN", "OR_ELSE", "compare", "compare", "bit", "conv"])
        if form == "NOT":
            return make(BOOL, "NOT {}", [self.boolean(depth - 1)], lambda x: not x)
        if form == "compare":
            return self.comparison(depth)
        if form == "bit":
            a = self.named(r.choice(INTEGERS))
            bit = r.randrange(a.kind.size * 8)
            return Expr(
                BOOL, f"(({a.constant} AND {1 << bit}) <> 0)" if a.kind.size < 8 else f"{a.variable}.{bit}",
                f"{a.variable}.{bit}", lambda env: bool(a.value(env) >> bit & 1), BOOL,
            )  # fmt: skip
        if form == "conv":
            a = self.any(depth - 1)
            return make(BOOL, f"{a.kind.name}_TO_BOOL({{}})", [a], lambda x: x != 0)
        operation = {"XOR": lambda x, y: x != y}.get(form) or (
            (lambda x, y: x and y) if form.startswith("AND") else (lambda x, y: x or y)
        )
        return make(BOOL, f"({{}} {form} {{}})", [self.boolean(depth - 1), self.boolean(depth - 1)], operation)

    def comparison(self, depth: int) -> Expr:
        r = self.random
        op = r.choice(["=", "<>", "<", "<=", ">", ">="])
        reals = r.random() < 0.3
        a = self.real(depth - 1) if reals else self.integer(depth - 1)
        b = self.any_number(depth - 1) if reals else self.integer(depth - 1)
        if not reals and r.random() < 0.3:
            b = self.literal()
        kind = common(a.kind, b.kind) if reals else None
        tests = {
            "=": lambda x, y: x == y, "<>": lambda x, y: x != y, "<": lambda x, y: x < y, "<=": lambda x, y: x <= y,
            ">": lambda x, y: x > y, ">=": lambda x, y: x >= y,
        }  # fmt: skip

        def compare(x, y):
            if kind is not None:
                x, y = convert(x, a.kind, kind), convert(y, b.kind, kind)
            return tests[op](x, y)

        return make(BOOL, f"({{}} {op} {{}})", [a, b], compare)

    def any_number(self, depth: int) -> Expr:
        return self.integer(depth) if self.random.random() < 0.6 else self.real(depth)

    def any(self, depth: int) -> Expr:
        return self.boolean(depth) if self.random.random() < 0.2 else self.any_number(depth)


def make(kind: Kind, form: str, args: list[Expr], function: Callable, held: Kind | None = None) -> Expr:
    return Expr(
        kind, form.format(*(a.constant for a in args)), form.format(*(a.variable for a in args)),
        lambda env: function(*(a.value(env) for a in args)), held or kind,
    )  # fmt: skip


def negative(a: Expr) -> Expr:
    kind = a.kind if a.kind.signed else DINT if a.kind.size <= 4 else LINT
    room = computing(kind)
    return make(kind, "(-{})", [a], lambda x: wrap(-x, room), room)


def remainder(a: int, b: int) -> int:
    return a - b * divide(a, b)


def real_quotient(x: float, y: float) -> float:
    if y == 0:
        return math.nan if x == 0 or math.isnan(x) else math.copysign(math.inf, x) * math.copysign(1, y)
    return x / y


def extreme(name: str, x: float, y: float) -> float:
    """MIN, MAX: the second when they can't be told apart or one is NaN."""
    if name == "MIN":
        return x if x < y else y
    return x if x > y else y


def written(value, kind: Kind) -> str:
    """A value as a typed literal."""
    if kind.sort == "bool":
        return str(value).upper()
    if kind.sort == "real":
        text = repr(float(value))
        return f"{kind.name}#{text if '.' in text else text.replace('e', '.0e')}"
    return f"{kind.name}#{value}"

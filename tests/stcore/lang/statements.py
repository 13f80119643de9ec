"""Random programs: statements with what they do, in Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import product
from random import Random

from model import BOOL, INTEGERS, KINDS, REALS, Expr, Kind, Maker, convert, wrap, written


class Leave(Exception):
    """EXIT or CONTINUE on its way."""

    def __init__(self, word: str) -> None:
        self.word = word


@dataclass(frozen=True)
class Statement:
    lines: list[str]
    run: Callable[[dict], None]


@dataclass
class Programmer(Maker):
    """Makes bodies over these variables: two of each type, arrays a_..., a structure s, counters of loops."""

    arrays: dict[str, tuple[Kind, list[tuple[int, int]]]] = field(default_factory=dict)
    loops: list[str] = field(default_factory=list)
    bound: dict[str, tuple[int, int]] = field(default_factory=dict)  # loop variables that stay in a range

    def __post_init__(self) -> None:
        r = self.random
        for kind in KINDS.values():
            for n in (1, 2):
                self.variables[f"{kind.name.lower()}{n}"] = (kind, self.number(kind))
                self.variables[f"s.{kind.name.lower()}{n}"] = (kind, self.number(kind))
        for n in range(4):
            low = r.choice([-3, 0, 0, 1, 5])
            bounds = [(low, low + r.choice([2, 3, 6]))] + ([(0, 2)] if n == 3 else [])
            self.arrays[f"a{n}"] = (r.choice([*INTEGERS, BOOL, *REALS]), bounds)

    # -------------------------------------------------------------------------------------- expressions

    def leaf(self, kind: Kind) -> Expr:
        r = self.random
        if r.random() < 0.15:
            value = self.number(kind)
            return Expr(kind, written(value, kind), written(value, kind), lambda env: value, kind)
        fitting = [n for n, (k, _) in self.arrays.items() if k is kind]
        if fitting and r.random() < 0.5:
            return self.element(r.choice(fitting))
        return self.named(kind)

    def named(self, kind: Kind) -> Expr:
        name = self.random.choice([n for n, (k, _) in self.variables.items() if k is kind])
        return Expr(kind, name, name, lambda env: env[name], kind)

    def index(self, low: int, high: int) -> Expr:
        """An index inside its bounds."""
        r = self.random
        fitting = [n for n in self.loops if self.bound.get(n) and low <= self.bound[n][0] and self.bound[n][1] <= high]
        if fitting and r.random() < 0.6:
            name = r.choice(fitting)
            return Expr(self.variables[name][0], name, name, lambda env: env[name], self.variables[name][0])
        if r.random() < 0.5:
            value = r.randint(low, high)
            return Expr(KINDS["DINT"], str(value), str(value), lambda env: value, KINDS["DINT"])
        count = high - low + 1
        inner = self.named(KINDS[r.choice(["USINT", "BYTE", "UINT", "WORD"])])
        text = f"{inner.variable} MOD {count} + {low}" if low >= 0 else f"{inner.variable} MOD {count} - {-low}"
        return Expr(KINDS["DINT"], text, text, lambda env: inner.value(env) % count + low, KINDS["DINT"])

    def cell(self, name: str) -> tuple[str, Callable[[dict], tuple]]:
        """An element of an array: its text, and its indices."""
        at = [self.index(*b) for b in self.arrays[name][1]]
        text = f"{name}[{', '.join(i.variable for i in at)}]"
        return text, lambda env: tuple(i.value(env) for i in at)

    def element(self, name: str) -> Expr:
        text, at = self.cell(name)
        return Expr(self.arrays[name][0], text, text, lambda env: env[name][at(env)], self.arrays[name][0])

    # ---------------------------------------------------------------------------------------- statements

    def body(self, depth: int, count: int) -> Statement:
        made = [self.statement(depth) for _ in range(count)]
        return Statement([line for m in made for line in m.lines], lambda env: [m.run(env) for m in made] and None)

    def statement(self, depth: int) -> Statement:
        r = self.random
        forms = [self.assign] * 4 + [self.assign_element] * 3 + [self.assign_bit]
        if depth:
            forms += [self.if_, self.case, self.for_, self.while_, self.repeat, self.for_]
        if self.loops:
            forms += [self.leave]
        return r.choice(forms)(depth)

    def assign(self, depth: int) -> Statement:
        r = self.random
        name = r.choice([n for n in self.variables if n not in self.loops])
        kind = self.variables[name][0]
        value = self.for_kind(kind)
        return Statement(
            [f"{name} := {value.variable};"],
            lambda env: env.__setitem__(name, convert(value.value(env), value.kind, kind)),
        )

    def for_kind(self, kind: Kind) -> Expr:
        """A value that may be assigned to this type."""
        depth = self.random.choice([0, 1, 1, 2])
        if kind is BOOL:
            return self.boolean(depth)
        if kind.sort == "real":
            return self.any_number(depth)
        return self.integer(depth)

    def assign_element(self, depth: int) -> Statement:
        name = self.random.choice(list(self.arrays))
        kind, (text, at) = self.arrays[name][0], self.cell(name)
        value = self.for_kind(kind)

        def run(env: dict) -> None:
            env[name][at(env)] = convert(value.value(env), value.kind, kind)

        return Statement([f"{text} := {value.variable};"], run)

    def assign_bit(self, depth: int) -> Statement:
        r = self.random
        name = r.choice(
            [n for n, (k, _) in self.variables.items() if k.sort in ("int", "bits") and n not in self.loops]
        )
        kind = self.variables[name][0]
        bit, value = r.randrange(kind.size * 8), self.boolean(1)

        def run(env: dict) -> None:
            on = value.value(env)
            env[name] = wrap(env[name] | 1 << bit if on else env[name] & ~(1 << bit), kind)

        return Statement([f"{name}.{bit} := {value.variable};"], run)

    def if_(self, depth: int) -> Statement:
        conditions = [self.boolean(1) for _ in range(self.random.choice([1, 2]))]
        bodies = [self.body(depth - 1, 2) for _ in conditions]
        otherwise = self.body(depth - 1, 1)
        lines = []
        for word, c, b in zip(("IF", "ELSIF"), conditions, bodies, strict=False):
            lines += [f"{word} {c.variable} THEN", *b.lines]

        def run(env: dict) -> None:
            for c, b in zip(conditions, bodies, strict=True):
                if c.value(env):
                    return b.run(env)
            return otherwise.run(env)

        return Statement([*lines, "ELSE", *otherwise.lines, "END_IF"], run)

    def case(self, depth: int) -> Statement:
        r = self.random
        kind = r.choice([k for k in INTEGERS])
        base = self.leaf(kind) if r.random() < 0.5 else self.integer(1)
        kind = base.kind
        selector = base if r.random() < 0.5 else self.integer_operator("MOD", base, self.literal_but_zero())
        middle = r.choice([0, 0, kind.low + 5, kind.high - 5, 10])
        numbers = r.sample([n for n in range(middle - 5, middle + 6) if kind.low <= n <= kind.high], 4)
        if r.random() < 0.3:
            numbers.append(r.randint(kind.low, kind.high))
        branches = [([n], self.body(depth - 1, 1)) for n in dict.fromkeys(numbers)]
        if r.random() < 0.5:
            low = min(max(middle + 7, kind.low), kind.high - 3)
            branches.append((range(low, low + 3), self.body(depth - 1, 1)))
        otherwise = self.body(depth - 1, 1)
        lines = [f"CASE {selector.variable} OF"]
        for numbers, body in branches:
            label = f"{numbers[0]}" if len(numbers) == 1 else f"{numbers[0]}..{numbers[-1]}"
            lines += [f"{label}:", *body.lines]

        def run(env: dict) -> None:
            value = selector.value(env)
            return next((b for numbers, b in branches if value in numbers), otherwise).run(env)

        return Statement([*lines, "ELSE", *otherwise.lines, "END_CASE"], run)

    def for_(self, depth: int) -> Statement:
        r = self.random
        kind = r.choice(INTEGERS)
        name = f"f{len([n for n in self.variables if n.startswith('f')])}"
        self.variables[name] = (kind, 0)
        step = r.choice([1, 1, 1, 2, 3, -1, -2])
        start = r.choice([0, 0, 1, 5, kind.low, kind.high - 4])
        if kind.signed:
            start = r.choice([start, -3])
        span = r.choice([0, 2, 3, 4]) * (1 if step > 0 else -1)
        first, last = (x if kind.low <= x <= kind.high else start for x in (start, start + span))
        changed = r.random() < 0.1 and step > 0
        if not changed:
            self.bound[name] = (min(first, last), max(first, last))
        self.loops.append(name)
        inner = self.body(depth - 1, 2)
        self.loops.pop()
        end = written(last, kind) if r.random() < 0.7 else f"SEL(bool1, {written(last, kind)}, {written(last, kind)})"
        by = f" BY {step}" if step != 1 or r.random() < 0.2 else ""
        lines = [f"FOR {name} := {first} TO {end}{by} DO", *inner.lines]
        if changed:
            lines.append(f"IF {name} < {kind.high} THEN {name} := {name} + 1; END_IF")

        def run(env: dict) -> None:
            counter = env[name] = first
            while counter <= last if step > 0 else counter >= last:
                try:
                    inner.run(env)
                    if changed and env[name] < kind.high:
                        env[name] += 1
                except Leave as leave:
                    if leave.word == "EXIT":
                        return
                counter = env[name] + step
                env[name] = wrap(counter, kind)

        return Statement([*lines, "END_FOR"], run)

    def while_(self, depth: int) -> Statement:
        name, inner, rounds = self.counted(depth)
        condition = self.boolean(1)

        def run(env: dict) -> None:
            env[name] = 0
            while env[name] < rounds and condition.value(env):
                env[name] += 1
                if self.round(inner, env):
                    return

        head = [f"{name} := 0;", f"WHILE {name} < {rounds} AND {condition.variable} DO", f"{name} := {name} + 1;"]
        return Statement([*head, *inner.lines, "END_WHILE"], run)

    def repeat(self, depth: int) -> Statement:
        name, inner, rounds = self.counted(depth)
        condition = self.boolean(1)

        def run(env: dict) -> None:
            env[name] = 0
            while True:
                env[name] += 1
                if self.round(inner, env) or env[name] >= rounds or condition.value(env):
                    return

        lines = [f"{name} := 0;", "REPEAT", f"{name} := {name} + 1;", *inner.lines]
        return Statement([*lines, f"UNTIL {name} >= {rounds} OR {condition.variable}", "END_REPEAT"], run)

    def counted(self, depth: int) -> tuple[str, Statement, int]:
        name = f"w{len([n for n in self.variables if n.startswith('w') and n[1].isdigit()])}"
        self.variables[name] = (KINDS["DINT"], 0)
        self.loops.append(name)
        inner = self.body(depth - 1, 2)
        self.loops.pop()
        return name, inner, self.random.choice([1, 3, 4])

    @staticmethod
    def round(inner: Statement, env: dict) -> bool:
        """True if the loop is left."""
        try:
            inner.run(env)
        except Leave as leave:
            return leave.word == "EXIT"
        return False

    def leave(self, depth: int) -> Statement:
        r = self.random
        word = r.choice(["EXIT", "CONTINUE"])
        condition = self.boolean(1)

        def run(env: dict) -> None:
            if condition.value(env):
                raise Leave(word)

        return Statement([f"IF {condition.variable} THEN {word}; END_IF"], run)


def random_program(seed: int) -> tuple[str, dict]:
    """ST text, and the variables after one scan. The same body runs as a program, a function and a block."""
    maker = Programmer(Random(seed))
    body = maker.body(3, 6)
    env: dict = {n: v for n, (_, v) in maker.variables.items()}
    declared = [f"  {n} : {k.name} := {written(v, k)};" for n, (k, v) in maker.variables.items() if "." not in n]
    for name, (kind, bounds) in maker.arrays.items():
        cells = list(product(*(range(a, b + 1) for a, b in bounds)))
        env[name] = {c: maker.number(kind) for c in cells}
        dims = ", ".join(f"{a}..{b}" for a, b in bounds)
        values = ", ".join(written(v, kind) for v in env[name].values())
        declared.append(f"  {name} : ARRAY[{dims}] OF {kind.name} := [{values}];")
    members = {n[2:]: (k, v) for n, (k, v) in maker.variables.items() if n.startswith("s.")}
    declared.append(f"  s : Rec := ({', '.join(f'{n} := {written(v, k)}' for n, (k, v) in members.items())});")
    record = [f"  {n} : {k.name};" for n, (k, _) in members.items()]
    names = [d.split(":")[0].strip() for d in declared]
    text = "\n".join([
        "TYPE Rec : STRUCT", *record, "END_STRUCT", "All : STRUCT", *declared, "END_STRUCT END_TYPE",
        "VAR_GLOBAL fromFunction : All; END_VAR",
        "FUNCTION F : INT", "VAR", *declared, "END_VAR", *body.lines, *(f"fromFunction.{n} := {n};" for n in names),
        "END_FUNCTION",
        "FUNCTION_BLOCK B", "VAR", *declared, "END_VAR", *body.lines, "END_FUNCTION_BLOCK",
        "PROGRAM Body", "VAR", *declared, "END_VAR", *body.lines, "END_PROGRAM",
        "PROGRAM PLC_PRG", "VAR b : B; END_VAR", "Body(); b(); F();", "END_PROGRAM",
    ])  # fmt: skip
    body.run(env)
    return text, env

"""Random programs whose units change the same few variables in every way there is: by name, through pointers,
references and in-outs, as a whole, in bits, and in calls that stand inside of expressions.

They end: loops are short, and what could go round for ever needs `fuel`, of which each scan has some. Some end in a
fault: an index out of range, a division by zero, a pointer that is 0.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random

SHARED = """TYPE
Rec : STRUCT a : DINT; b : INT; c : BOOL; e : ARRAY[0..3] OF DINT; END_STRUCT
Mix : UNION d : DINT; w : ARRAY[0..1] OF WORD; y : ARRAY[0..3] OF BYTE; END_UNION
END_TYPE
VAR_GLOBAL
g, h : DINT := 1; gi : INT := 2; gw : WORD := 3; gb : BOOL; gr : REAL := 1.5; fuel : DINT;
k : DINT := 4; ki : INT := 5; kb : BOOL; ks, ks2 : Rec; ka : ARRAY[0..3] OF DINT; km : Mix; text : STRING(6) := 'abc';
p : POINTER TO DINT := ADR(k); pi : POINTER TO INT := ADR(ki); py : POINTER TO BYTE := ADR(k); ps : POINTER TO Rec :=
ADR(ks); pb : POINTER TO BOOL := ADR(kb); r : REFERENCE TO DINT;
m AT %MD0 : DINT; mi AT %MW0 : INT; mx AT %MX0.3 : BOOL;
"""
OWN = "x, y : DINT := 2; n : INT := -1; b : BOOL := TRUE;"
LARGE = "s : Rec; a : ARRAY[0..3] OF DINT;"
# {} is an index 0..3. What is named can't be reached by an address, so locals may hold it.
NAMED = {
    "DINT": ["g", "g", "h", "x", "x", "y", "units.g", "PLC_PRG.x", "g.%W0", "h.%B1"],
    "INT": ["gi", "n"],
    "WORD": ["gw"],
    "BOOL": ["gb", "b", "b", "g.3", "gw.1", "n.0", "PLC_PRG.b"],
    "REAL": ["gr"],
}
LED_TO = {
    "DINT": ["k", "p^", "r", "ka[{}]", "ks.a", "ps^.a", "ps^.e[{}]", "km.d", "m"],
    "INT": ["ki", "pi^", "ks.b", "mi"],
    "WORD": ["km.w[1]"],
    "BYTE": ["py^", "py[{}]", "km.y[{}]"],
    "BOOL": ["kb", "pb^", "mx", "k.5"],
    "Rec": ["ks", "ks2", "ps^"],
    "REAL": [],
}
POINTERS = (("p", "DINT"), ("pi", "INT"), ("ps", "Rec"), ("pb", "BOOL"), ("py", "DINT"), ("py", "INT"), ("py", "Rec"))
NUMBERS = ("DINT", "DINT", "DINT", "INT", "WORD", "BYTE")


@dataclass
class Unit:
    """cost: statements that a call runs at most. callees: how others name it, as {callee}(...)."""

    kind: str
    result: str
    inputs: list[str]
    in_outs: list[str]
    outputs: list[str]
    callees: list[str]
    cost: int = 1


@dataclass
class Units:
    """Makes a program. faults: how often an index or a divisor is left to chance."""

    random: Random
    faults: float = 0.02
    known: list[Unit] = field(default_factory=list)
    counters: list[str] = field(default_factory=list)  # of the loops around, 0..3 each
    cost: int = 1
    times: int = 1  # how often the loops around run this
    made: int = 0  # counters of this unit
    named: dict[str, list[str]] = field(default_factory=dict)
    led_to: dict[str, list[str]] = field(default_factory=dict)
    letter: str = "c"  # what their names begin with
    large: bool = True  # it has variables that don't fit into locals

    def chance(self, share: float) -> bool:
        return self.random.random() < share

    def program(self) -> str:
        """The text, to be compiled as units.st."""
        self.named, self.led_to = (self.few(table) for table in (NAMED, LED_TO))
        texts = [self.function("F0"), self.block("B0", ""), self.function("F1"), self.function("F2")]
        texts.append(self.block("B1", "B0" if self.chance(0.5) else ""))
        texts.append(self.unit("PROGRAM P1", f"VAR {OWN + LARGE} END_VAR\nVAR_TEMP t : DINT; END_VAR"))
        start = f"fuel := 30; r REF= {self.place('DINT', LED_TO)};"
        texts.append(self.unit("PROGRAM PLC_PRG", f"VAR {OWN + LARGE} END_VAR", start, "P1();"))
        instances = "q{0} : {0}; v{0} : ARRAY[0..1] OF {0}; p{0} : POINTER TO {0} := ADR(q{0});"
        return "\n".join([SHARED, instances.format("B0"), instances.format("B1"), "END_VAR", *texts])

    def few(self, table: dict[str, list[str]]) -> dict[str, list[str]]:
        """The first place of each kind and some others: the fewer, the more often they meet."""
        return {k: v[:1] + self.random.sample(v, min(len(v), self.random.choice([0, 1, 3]))) for k, v in table.items()}

    # --------------------------------------------------------------------------------------------- units

    def parameters(self, unit: Unit) -> str:
        sections = ("VAR_INPUT", unit.inputs, "i"), ("VAR_IN_OUT", unit.in_outs, "v"), ("VAR_OUTPUT", unit.outputs, "o")
        return " ".join(
            f"{section} {' '.join(f'{letter}{i} : {kind};' for i, kind in enumerate(kinds))} END_VAR"
            for section, kinds, letter in sections if kinds
        )  # fmt: skip

    def some(self, *kinds: str) -> list[str]:
        return self.random.choices(kinds, k=self.random.choice([0, 1, 1, 2]))

    def function(self, name: str) -> str:
        result = self.random.choice(["DINT", "DINT", "INT", "BOOL"])
        in_outs = self.some("DINT", "INT") if self.chance(0.4) else []
        unit = Unit("FUNCTION", result, self.some("DINT", "BOOL"), in_outs, self.some("DINT"), [name])
        self.large = self.chance(0.3)
        sections = f"{self.parameters(unit)}\nVAR {OWN + (LARGE if self.large else '')} END_VAR"
        last = f"{name} := {self.value(result, 1)};"
        text = self.unit(f"FUNCTION {name} : {result}", sections, "", last, unit=unit)
        self.known.append(unit)
        return text

    def block(self, name: str, base: str) -> str:
        """A block with a method. One that extends another has the parameters and variables of that one."""
        self.large = True
        callees = [f"q{name}", f"v{name}[{{}} AND 1]", f"p{name}^"]
        unit = Unit("BLOCK", "", self.some("DINT", "BOOL"), self.some("DINT")[:1], self.some("DINT"), callees)
        method = Unit("METHOD", "DINT", ["DINT"], [], [], [f"{c}.Go" for c in callees])
        if base:
            other = next(u for u in self.known if u.kind == "BLOCK")
            unit.inputs, unit.in_outs, unit.outputs = other.inputs, other.in_outs, other.outputs
        last = "Go := SUPER^.Go(x + i0);" if base else f"Go := {self.value('DINT', 1)} + i0;"
        do = self.unit("METHOD Go : DINT", "VAR_INPUT i0 : DINT; END_VAR", "", last, unit=method)
        method.cost *= 2
        self.known.append(method)
        head = f"FUNCTION_BLOCK {name} {'EXTENDS ' + base if base else ''}"
        sections = "" if base else f"{self.parameters(unit)}\nVAR {OWN + LARGE} END_VAR"
        text = self.unit(head, sections, do, unit=unit)
        self.known.append(unit)
        return text

    def unit(self, head: str, sections: str, first: str = "", last: str = "", unit: Unit | None = None) -> str:
        """Half of those that are called are a line or two: they are taken in wherever they are called."""
        r = self.random
        self.cost, self.times, self.made = 1, 1, 0
        self.letter = "d" if "EXTENDS" in head else "c"
        if unit is not None and self.chance(0.5):
            lines = [self.assign(0) for _ in range(r.choice([1, 2]))]
        else:
            lines = self.body(3, r.choice([2, 5]) if unit is not None else 12)
        if unit is not None:
            unit.cost = self.cost
        names = " ".join(f"{self.letter}{i} : {r.choice(NUMBERS)};" for i in range(self.made))
        counters = f"VAR {names} END_VAR" if names else ""
        return "\n".join([head, sections, counters, first, *lines, last, f"END_{head.split()[0]}"])

    # ----------------------------------------------------------------------------------- places and values

    def place(self, kind: str, *tables: dict[str, list[str]]) -> str:
        """A variable of this kind, of one of the tables; of all there are when none is given."""
        all_of_them = self.named, self.named, self.named, self.led_to
        fitting = [x for table in tables or all_of_them for x in table.get(kind, [])]
        if self.large and kind == "DINT" and not tables and self.chance(0.2):  # in a function they lie on the stack
            fitting += ["s.a", "a[{}]", "s.e[{}]"]
        text = self.random.choice(fitting)
        return text.replace("{}", self.index()) if "{}" in text else text

    def index(self) -> str:
        r = self.random
        if self.counters and self.chance(0.5):
            return r.choice(self.counters)
        if self.chance(self.faults):
            return self.place("INT", NAMED)
        return r.choice([str(r.randrange(4)), f"{self.value('DINT', 1)} AND 3", f"LIMIT(0, {self.value('INT', 1)}, 3)"])

    def value(self, kind: str, depth: int) -> str:
        r = self.random
        if depth > 0 and self.chance(0.3):
            call = self.called([u for u in self.known if u.result == kind], depth - 1)
            if call:
                return call
        if depth <= 0 or self.chance(0.2):
            if self.counters and kind == "DINT" and self.chance(0.3):
                return r.choice(self.counters)
            return self.place(kind) if self.chance(0.8) else {"BOOL": "TRUE"}.get(kind, str(r.randrange(5)))
        args = [self.value(kind, depth - 1) for _ in range(3)]
        if kind == "BOOL":
            other = r.choice(NUMBERS)
            compared = f"({self.value(other, depth - 1)} {r.choice(['=', '<', '>=', '<>'])} {self.value(other, 0)})"
            forms = ["NOT {0}", "({0} AND_THEN {1})", "({0} OR_ELSE {1})", "({0} XOR {1})", "({0} AND {1})", compared]
            return r.choice(forms).format(*args)
        forms = ["({0} + {1})", "({0} - {1})", "MAX({0}, {1})", "LIMIT({0}, {1}, {2})"]
        if kind != "REAL":  # its products may become NaN, whose bits are not defined
            divisor = self.place("INT", NAMED) if self.chance(self.faults) else "MAX(1, {1})"
            choice = f"{self.value('BOOL', depth - 1)}"
            forms += [f"({{0}} / {divisor})", f"({{0}} MOD {divisor})", f"SEL({choice}, {{0}}, {{1}})", "ROL({0}, {1})"]
            forms += ["MUX({0}, {1}, {2})", "SHL({0}, {1})", "({0} XOR {1})", "({0} * {1})", f"TO_{kind}({choice})"]
        return r.choice(forms).format(*args)

    def called(self, units: list[Unit], depth: int) -> str:
        """A call of one of these units, '' where that would take too long."""
        r = self.random
        units = [u for u in units if self.cost + self.times * u.cost < 3000]
        if not units:
            return ""
        unit = r.choice(units)
        self.cost += self.times * unit.cost
        args = [f"EN := {self.value('BOOL', depth)}"] if self.chance(0.1) else []
        args += [f"i{i} := {self.value(kind, depth)}" for i, kind in enumerate(unit.inputs)]
        args += [f"v{i} := {self.place(kind, LED_TO)}" for i, kind in enumerate(unit.in_outs)]
        args += [f"o{i} => {self.place(kind)}" for i, kind in enumerate(unit.outputs) if self.chance(0.7)]
        callee = r.choice(unit.callees)
        callee = callee.replace("{}", self.index()) if "{}" in callee else callee
        return f"{callee}({', '.join(args)})"

    # ------------------------------------------------------------------------------------------ statements

    def body(self, depth: int, count: int) -> list[str]:
        forms = [self.assign] * 8 + [self.call] * 5 + [self.move] * 2 + [self.leave]
        forms += [self.if_, self.if_, self.case, self.for_, self.for_, self.while_] if depth else []
        return [self.random.choice(forms)(depth) for _ in range(count)]

    def assign(self, depth: int) -> str:
        r = self.random
        self.cost += self.times
        kind = r.choice([*NUMBERS, "BOOL", "BOOL", "REAL"])
        if kind == "BOOL" and self.chance(0.3):
            return f"{self.place(kind)} {r.choice(['S=', 'R='])} {self.value(kind, 1)};"
        middle = f"{self.place(kind)} := " if self.chance(0.1) else ""
        return f"{self.place(kind)} := {middle}{self.value(kind, r.choice([0, 1, 2]))};"

    def call(self, depth: int) -> str:
        """A call, half of them between the assignment and the use of a variable that it may change."""
        units = [u for u in self.known if u.kind == "BLOCK"] * 2 + self.known
        call = f"{self.called(units, 1)};"
        if self.chance(0.5):
            return call
        kind = self.random.choice(["DINT", "BOOL", "INT"])
        name = self.place(kind, self.named)
        return f"{name} := {self.value(kind, 1)}; {call} {self.place(kind)} := {name};"

    def move(self, depth: int) -> str:
        """Pointers that lead elsewhere, and what is assigned as a whole."""
        r = self.random
        name, kind = r.choice(POINTERS)
        places = [x.replace("{}", self.index()) for x in LED_TO[kind] if x not in ("mx", "k.5")]
        to, other = (self.place("Rec", LED_TO) for _ in range(2))
        moved = f"SysMemCpy(ADR({to}), ADR({other}), 8)"
        filled = f"SysMemSet(ADR({self.place('DINT', {'DINT': ['k', 'ka', 'ks']})}), {self.value('BYTE', 1)}, 4)"
        led = f"{name} := ADR({r.choice(places)})"
        return r.choice([led, led, led, f"{to} := {other}", moved, filled, "text := CONCAT('a', LEFT(text, 3))"]) + ";"

    def leave(self, depth: int) -> str:
        words = ["EXIT", "CONTINUE", "RETURN"] if self.times > 1 else ["RETURN"]
        return f"IF {self.value('BOOL', 2)} THEN {self.random.choice(words)}; END_IF"

    def if_(self, depth: int) -> str:
        lines = [f"IF {self.value('BOOL', 2)} THEN", *self.body(depth - 1, 2)]
        lines += [f"ELSIF {self.value('BOOL', 1)} THEN", *self.body(depth - 1, 1)] if self.chance(0.4) else []
        lines += ["ELSE", *self.body(depth - 1, 1)] if self.chance(0.5) else []
        return "\n".join([*lines, "END_IF"])

    def case(self, depth: int) -> str:
        lines = [f"CASE {self.value('DINT', 1)} OF"]
        for label in self.random.sample(["0", "1", "2..5", "7, 9"], 3):
            lines += [f"{label}:", *self.body(depth - 1, 1), ";"]
        return "\n".join([*lines, "ELSE", *self.body(depth - 1, 1), "END_CASE"])

    def looped(self, depth: int) -> list[str]:
        self.times *= 4
        lines = self.body(depth - 1, 2)
        self.times //= 4
        return lines

    def for_(self, depth: int) -> str:
        """Over a counter of its own, or one that others may change, too."""
        if self.chance(0.3):
            head = f"FOR {self.place(self.random.choice(['DINT', 'INT']))} := 0 TO 3 DO"
            lines = ["fuel := fuel - 1; IF fuel < 0 THEN EXIT; END_IF", *self.looped(depth)]
            return "\n".join([head, *lines, "END_FOR"])
        counter = f"{self.letter}{self.made}"
        self.made += 1
        bounds = self.random.choice(["0 TO 3", "1 TO 3", "0 TO 3 BY 2", f"0 TO LIMIT(0, {self.value('INT', 1)}, 3)"])
        self.counters.append(counter)
        lines = self.looped(depth)
        self.counters.pop()
        return "\n".join([f"FOR {counter} := {bounds} DO", *lines, "END_FOR"])

    def while_(self, depth: int) -> str:
        condition = self.value("BOOL", 1)
        lines = ["fuel := fuel - 1;", *self.looped(depth)]
        if self.chance(0.5):
            return "\n".join(["REPEAT", *lines, f"UNTIL {condition} OR fuel <= 0 END_REPEAT"])
        return "\n".join([f"WHILE fuel > 0 AND_THEN {condition} DO", *lines, "END_WHILE"])

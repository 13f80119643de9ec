"""Expressions to WebAssembly text. Integers below 32 bits are computed in 32 and narrowed where they are stored."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.check.calls import FunctionCall
from stcore.check.conversions import common, kind_of
from stcore.check.methods import MethodCall
from stcore.check.width import wide
from stcore.emit import builtins, values
from stcore.emit.places import Places
from stcore.emit.ranges import range_of
from stcore.emit.values import address, constant, load, number, wasm_type, wrap
from stcore.program import NULL_PAGE
from stcore.scope import BuiltinCall, Convert, Pinned, Var

_ARITHMETIC = {"+": "add", "-": "sub", "*": "mul"}
_COMPARE = {"=": "eq", "<>": "ne", "<": "lt", "<=": "le", ">": "gt", ">=": "ge"}
_LOGIC = {"AND": "and", "OR": "or", "XOR": "xor"}


class Expressions(Places):
    """Emits expressions. `value` gives the text of one value; of an aggregate, its address."""

    def value(self, node: s.Node) -> str:
        if node.const is None:
            return self.EMIT[node.__class__](self, node)
        if isinstance(node.const, str):
            return self.string_constant(node.const, node.type)
        return constant(node.const, node.type)

    def narrow(self, node: s.Node) -> str:
        """A value inside its type."""
        text = self.value(node)
        return wrap(node.type, text) if wide(node) else text

    def string_constant(self, text: str, kind: t.Type) -> str:
        wide_ = isinstance(kind, t.String) and kind.wide
        if isinstance(t.base_of(kind), t.Elementary):
            return number(ord(text), "i32")
        return f"(i32.const {self.module.string(text, wide_)})"

    def variable(self, node: s.Node) -> str:
        """The value at a place; of an aggregate, its address."""
        symbol = node.symbol
        if isinstance(symbol, Var):
            local = self.local_of(symbol)
            if local is not None:
                return f"(local.get {local})"
        if symbol in ("this", "super"):
            return self.this_address()
        base, offset = self.place(node)
        if t.is_aggregate(node.type):
            return address(base, offset)
        if isinstance(symbol, Var) and symbol.bit is not None:
            byte = load(t.BYTE, base, offset)
            return f"(i32.and (i32.shr_u {byte} (i32.const {symbol.bit})) (i32.const 1))"
        return load(node.type, base, offset)

    def part(self, node: s.Part) -> str:
        """Bits of a value."""
        base = t.base_of(node.base.type)
        width = {"X": 1, "B": 8, "W": 16, "D": 32}[node.size]
        value = self.narrow(node.base)
        wasm = base.wasm
        shift = node.index * width
        if shift:
            value = f"({wasm}.shr_u {value} ({wasm}.const {shift}))"
        if wasm == "i64":
            value = f"(i32.wrap_i64 {value})"
        return value if width == 32 else f"(i32.and {value} (i32.const {(1 << width) - 1}))"

    def unary(self, node: s.Unary) -> str:
        kind = t.base_of(node.type)
        operand = self.value(node.operand)
        if node.op == "NOT":
            if kind.kind == "bool":
                return f"(i32.eqz {operand})"
            ones = -1 if kind.signed or kind.size >= 4 else kind.high
            return f"({kind.wasm}.xor {self.narrow(node.operand)} ({kind.wasm}.const {ones}))"
        if node.op == "+":
            return operand
        if kind.kind == "real":
            return f"({kind.wasm}.neg {operand})"
        return f"({kind.wasm}.sub ({kind.wasm}.const 0) {operand})"

    def binary(self, node: s.Binary) -> str:
        op = node.op
        if op in _COMPARE:
            return self._comparison(node)
        if op == "AND_THEN":
            return f"(if (result i32) {self.value(node.left)} (then {self.value(node.right)}) (else (i32.const 0)))"
        if op == "OR_ELSE":
            return f"(if (result i32) {self.value(node.left)} (then (i32.const 1)) (else {self.value(node.right)}))"
        left_kind, right_kind = kind_of(node.left.type), kind_of(node.right.type)
        if "time" in (left_kind, right_kind) or "date" in (left_kind, right_kind):
            return self._time(node)
        kind = t.base_of(node.type)
        wasm = wasm_type(kind)
        left, right = self.value(node.left), self.value(node.right)
        if op in _LOGIC:
            return f"({wasm}.{_LOGIC[op]} {left} {right})"
        if op in _ARITHMETIC:
            return f"({wasm}.{_ARITHMETIC[op]} {left} {right})"
        if wasm[0] == "f":
            return f"({wasm}.div {left} {right})"
        return self._divide(node, kind, wasm, left, right)

    def _divide(self, node: s.Binary, kind: t.Type, wasm: str, left: str, right: str) -> str:
        unsigned = isinstance(kind, t.Pointer) or kind.size >= 4 and not kind.signed
        divisor = node.right.const
        if node.op == "MOD":
            operation = f"{wasm}.rem_{'u' if unsigned else 's'}"
        elif unsigned:
            operation = f"{wasm}.div_u"
        elif divisor is not None and divisor != -1:
            operation = f"{wasm}.div_s"
        else:
            operation = f"call $div_{wasm}"
        if divisor is not None:
            return f"({operation} {left} {right})"
        return self._marked_division(node, wasm, operation, left, right)

    def _marked_division(self, node: s.Binary, wasm: str, operation: str, left: str, right: str) -> str:
        """The marker stands behind what the operands themselves mark."""
        return f"(block (result {wasm}) {left} {right} {self.marker(node.right, 'F0102')} ({operation}))"

    def _comparison(self, node: s.Binary) -> str:
        left, right = node.left, node.right
        test = _COMPARE[node.op]
        if isinstance(left.type, t.String):
            call = "$wstr_cmp" if left.type.wide else "$str_cmp"
            order = f"(call {call} {self.value(left)} {self.value(right)})"
            return f"(i32.{test}{'' if test in ('eq', 'ne') else '_s'} {order} (i32.const 0))"
        wasm = wasm_type(left.type)
        a, b = self.value(left), self.value(right)
        if wasm[0] == "f":
            return f"({wasm}.{test} {a} {b})"
        if wasm == "i64" and (sign := self._signs(left, right)):
            return self._mixed(test, a, b, sign)
        if test in ("eq", "ne"):
            if test == "eq" and right.const in (0, False) and wasm == "i32":
                return f"(i32.eqz {a})"
            return f"({wasm}.{test} {a} {b})"
        return f"({wasm}.{test}_{'u' if self._unsigned(left, right) else 's'} {a} {b})"

    @staticmethod
    def _signs(left: s.Node, right: s.Node) -> str:
        """'su', 'us' where one of two 64-bit numbers is signed, else ''."""
        signs = "".join("s" if t.base_of(x.type).signed else "u" for x in (left, right))
        return signs if signs in ("su", "us") else ""

    def _mixed(self, test: str, a: str, b: str, signs: str) -> str:
        """Compare a signed with an unsigned number of 64 bits: a negative one is the smaller."""
        x, y = self.temp("i64"), self.temp("i64")
        both = f"(local.set {x} {a}) (local.set {y} {b})"
        signed, unsigned = (x, y) if signs == "su" else (y, x)
        if signs == "us":
            test = {"lt": "gt", "le": "ge", "gt": "lt", "ge": "le"}.get(test, test)
        op = test if test in ("eq", "ne") else test + "_u"
        plain = f"(i64.{op} (local.get {signed}) (local.get {unsigned}))"
        negative = f"(i64.lt_s (local.get {signed}) (i64.const 0))"
        if test in ("ne", "lt", "le"):
            return f"(block (result i32) {both} (i32.or {negative} {plain}))"
        return f"(block (result i32) {both} (i32.and (i32.eqz {negative}) {plain}))"

    @staticmethod
    def _unsigned(left: s.Node, right: s.Node) -> bool:
        met = common(left.type, right.type)
        if met is None:  # pointers, times, dates
            base = t.base_of(left.type)
            return not (isinstance(base, t.Elementary) and base.signed)
        return met.size >= 4 and not met.signed

    def _time(self, node: s.Binary) -> str:
        """TIME in ms and LTIME in ns, unsigned 32 and signed 64 bits; DT in seconds."""
        a, b = t.base_of(node.left.type), t.base_of(node.right.type)
        left, right = self.value(node.left), self.value(node.right)
        kind = t.base_of(node.type)
        if a.kind == b.kind == "date":
            return self._difference(a, kind, left, right)
        if a.kind == "date":
            right = values.convert(b, t.LTIME, right)
            unit = values.TIME_UNIT[a.name]
            amount = f"(i64.div_s {right} (i64.const {unit}))" if unit != 1 else right
            amount = amount if a.size == 8 else f"(i32.wrap_i64 {amount})"
            return f"({a.wasm}.{_ARITHMETIC[node.op]} {left} {amount})"
        if b.kind == "time":
            if node.op == "MOD":
                operation = f"{kind.wasm}.rem_{'s' if kind.signed else 'u'}"
                return self._marked_division(node, kind.wasm, operation, left, right)
            return f"({kind.wasm}.{_ARITHMETIC[node.op]} {left} {right})"
        return self._scaled(node, kind, b, left, right)

    def _difference(self, date: t.Elementary, kind: t.Elementary, left: str, right: str) -> str:
        gap = f"({date.wasm}.sub {left} {right})"
        factor = values.TIME_UNIT[date.name] // (10**6 if kind is t.TIME else 1)
        return gap if factor <= 1 else f"({date.wasm}.mul {gap} ({date.wasm}.const {factor}))"

    def _scaled(self, node: s.Binary, kind: t.Elementary, factor: t.Elementary, left: str, right: str) -> str:
        """TIME * number, TIME / number."""
        if factor.kind == "real":
            left = values.convert(t.ULINT if kind is t.TIME else t.LINT, t.LREAL, self._long(kind, left))
            text = f"(f64.{'mul' if node.op == '*' else 'div'} {left} {values.convert(factor, t.LREAL, right)})"
            return values.convert(t.LREAL, t.UDINT if kind is t.TIME else t.LINT, text)
        right = values.convert(factor, t.LINT, right)
        left = self._long(kind, left)
        text = f"(i64.mul {left} {right})"
        if node.op == "/":
            text = self._marked_division(node, "i64", "call $div_i64", left, right)
        return text if kind.size == 8 else f"(i32.wrap_i64 {text})"

    @staticmethod
    def _long(kind: t.Elementary, text: str) -> str:
        return text if kind.size == 8 else f"(i64.extend_i32_u {text})"

    def convert(self, node: Convert) -> str:
        source, target = node.operand.type, node.type
        base, goal = t.base_of(source), t.base_of(target)
        if isinstance(source, t.String) and isinstance(target, t.String):
            return self._string_fit(node.operand, target)
        text = self.value(node.operand)
        if not isinstance(base, t.Elementary) or not isinstance(goal, t.Elementary):
            return self._pointer_bits(base, goal, text)
        if base.kind == "literal":
            base = t.LREAL if base is t.REAL_LITERAL else t.DINT
        if base.size < 4 and goal.size < 4 and base.kind != "bool" and goal.kind not in ("real", "bool"):
            return wrap(goal, text)
        return values.convert(base, goal, text)

    @staticmethod
    def _pointer_bits(base: t.Type, goal: t.Type, text: str) -> str:
        """Pointers are 32-bit numbers."""
        if isinstance(base, t.Elementary) and base.size == 8:
            return f"(i32.wrap_i64 {text})"
        if isinstance(goal, t.Elementary) and goal.size == 8:
            return f"(i64.extend_i32_u {text})"
        return text

    def _string_fit(self, operand: s.Node, target: t.String) -> str:
        """A string for a shorter one: cut off in a copy."""
        text = self.value(operand)
        if operand.type.length <= target.length:
            return text
        temp = self.frame(target.size, target.align)
        call = "$wstr_copy" if target.wide else "$str_copy"
        where = address("(local.get $fp)", temp)
        return f"(block (result i32) (call {call} {where} {text} (i32.const {target.length})) {where})"

    def call(self, node: s.Call) -> str:
        symbol = node.symbol
        self.forget(node)
        if isinstance(symbol, BuiltinCall):
            return builtins.EMIT[symbol.name](self, node, symbol)
        if isinstance(symbol, MethodCall):
            return self.method_call(node, symbol)
        if isinstance(symbol, FunctionCall):
            return self.function_call(node, symbol)
        raise TypeError(f"no value: {node!r}")

    def assignment(self, node: s.Assign) -> str:
        """a := b as a value."""
        inner = s.Assign(node.start, node.end, node.target, node.op, node.value)

        def emit() -> None:
            inner.target = self.pinned(node.target)
            self.statement(inner)

        before = self.recent
        lines = self.captured(emit)
        self.recent = self.in_all([before, self.recent])  # it may stand where it is not always worked out
        return f"(block (result {wasm_type(node.type)}) {' '.join(lines)} {self.value(inner.target)})"

    def deref_check(self, node: s.Node) -> str:
        """The address in a pointer, checked to lie in the image."""
        return self.checked_address(self.value(node), node)

    def checked_address(self, pointer: str, node: s.Node) -> str:
        temp = self.temp("i32")
        mark = self.marker(node, "F0103", self.source.text[node.start : node.end])
        return (
            f"(block (result i32) (if (i32.ge_u (i32.sub (local.tee {temp} {pointer}) (i32.const {NULL_PAGE}))"
            f" (global.get $span)) (then {mark} (call $fault_pointer (local.get {temp})) unreachable))"
            f" (local.get {temp}))"
        )

    def offset_of(self, node: s.Index, kind: t.Array) -> tuple[str, int]:
        """Byte offset of an element: (computed part or '', constant part). Indices are checked where they must be."""
        text, fixed = "", 0
        stride = kind.element.size
        strides = []
        for low, high in reversed(kind.bounds):
            strides.append(stride)
            stride *= high - low + 1
        for index, (low, high), step in zip(node.indices, kind.bounds, reversed(strides), strict=True):
            if isinstance(index.const, int):
                fixed += (int(index.const) - low) * step
                continue
            found = range_of(index, self.ranges)
            if low <= found[0] and found[1] <= high:
                term = self.value(index)
                if low < 0:  # base and offset of a load are added without wrapping: neither may be negative
                    term = f"(i32.sub {term} (i32.const {low}))"
                else:
                    fixed -= low * step
            else:
                term = self._checked_index(index, low, high)
            if step != 1:
                shift = step.bit_length() - 1
                by = f"(i32.const {shift})" if step == 1 << shift else f"(i32.const {step})"
                term = f"(i32.{'shl' if step == 1 << shift else 'mul'} {term} {by})"
            text = f"(i32.add {text} {term})" if text else term
        return text, fixed

    def _checked_index(self, index: s.Node, low: int, high: int) -> str:
        """index - low, or the fault F0101."""
        value = self.value(index)
        temp = self.temp("i32")
        if low:
            value = f"(i32.sub {value} (i32.const {low}))"
        again = f"(i32.add (local.get {temp}) (i32.const {low}))" if low else f"(local.get {temp})"
        mark = self.marker(index, "F0101", self.source.text[index.start : index.end])
        return (
            f"(block (result i32) (if (i32.ge_u (local.tee {temp} {value}) (i32.const {high - low + 1}))"
            f" (then {mark} (call $fault_index {again} (i32.const {low}) (i32.const {high})) unreachable))"
            f" (local.get {temp}))"
        )

    EMIT = {
        s.Name: variable, s.Address: variable, s.Member: variable, s.Index: variable, s.Deref: variable, s.Part: part,
        s.Unary: unary, s.Binary: binary, Convert: convert, s.Call: call, s.Assign: assignment,
        Pinned: variable,
    }  # fmt: skip

"""Expressions: every node gets its type, its value where it is constant, and its symbol."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.check.conversions import INTEGER, NUMERIC, common, kind_of
from stcore.check.fold import COMPARISONS, LOGIC, arithmetic, computing_type, logic, wrap
from stcore.check.names import Names
from stcore.check.width import held
from stcore.scope import Convert


class Expressions(Names):
    """Checks expressions. `expr` returns the node to use in place of the one given."""

    def expr(self, node: s.Node) -> s.Node:
        return self.METHODS[type(node)](self, node)

    def value(self, node: s.Node) -> s.Node:
        """An expression that must be a value: not the name of a type, a function or an action."""
        return self.as_value(self.expr(node))

    def as_value(self, node: s.Node) -> s.Node:
        """The same of an expression that has been checked."""
        if node.type is None:
            self.error("E0303", node, name=self.text(node))
            node.type = t.ERROR
        return node

    def typed(self, node: s.Node, target: t.Type, what: str = "") -> s.Node:
        """An expression as a value of `target`."""
        return self.convert(self.value(node), target, what)

    def boolean(self, node: s.Node, what: str) -> s.Node:
        node = self.value(node)
        if node.type not in (t.BOOL, t.ERROR) and not (node.type is t.INT_LITERAL and node.const in (0, 1)):
            self.error("E0304", node, what=what, type=node.type)
            return node
        return self.convert(node, t.BOOL)

    # --------------------------------------------------------------------------------------- operators

    def unary(self, node: s.Unary) -> s.Node:
        node.operand = operand = self.value(node.operand)
        kind = t.base_of(operand.type)
        node.type = kind
        if kind is t.ERROR:
            return node
        name = kind_of(kind)
        if node.op == "-" and name in INTEGER and not kind.signed:
            node.type = kind = t.DINT if kind.size <= 4 else t.LINT
            node.operand = operand = self._widen(operand, kind)
        if node.op == "NOT":
            if name not in ("bool", *INTEGER) and kind is not t.INT_LITERAL:
                self.error("E0316", node, op="NOT", type=operand.type)
                return self.wrong(node)
            if operand.const is not None:
                node.const = not operand.const if name == "bool" else wrap(~operand.const, kind)
        elif name not in (*NUMERIC, "time"):
            self.error("E0316", node, op=node.op, type=operand.type)
            return self.wrong(node)
        elif operand.const is not None:
            node.const = -operand.const if node.op == "-" else operand.const
            if name in INTEGER:
                node.const = wrap(node.const, computing_type(kind))
        return node

    def binary(self, node: s.Binary) -> s.Node:
        node.left, node.right = self.value(node.left), self.value(node.right)
        if t.ERROR in (node.left.type, node.right.type):
            node.type = t.BOOL if node.op in COMPARISONS else t.ERROR
            return node
        if node.op in COMPARISONS:
            return self._comparison(node)
        if node.op in LOGIC:
            return self._logic(node)
        if {kind_of(node.left.type), kind_of(node.right.type)} & {"time", "date"}:
            return self._time_arithmetic(node)
        if isinstance(node.left.type, t.Pointer) or isinstance(node.right.type, t.Pointer):
            return self._pointer_arithmetic(node)
        if node.op == "**":
            return self.power(node)
        kind = common(node.left.type, node.right.type)
        if kind is None or kind.kind not in NUMERIC or node.op == "MOD" and kind_of(kind) == "real":
            return self._refused(node)
        return self._arithmetic(node, kind)

    def _refused(self, node: s.Binary) -> s.Node:
        self.error("E0317", node, op=node.op, left=node.left.type, right=node.right.type)
        return self.wrong(node)

    def _operands(self, node: s.Binary, kind: t.Type) -> None:
        """Both operands as `kind`; small integers stay as they are, they are computed as DINT anyway."""
        if kind.kind in INTEGER and kind.size < 4:
            kind = t.DINT
        node.left = self._widen(node.left, kind)
        node.right = self._widen(node.right, kind)

    def _widen(self, node: s.Node, kind: t.Elementary) -> s.Node:
        base = t.base_of(node.type)
        if base is t.INT_LITERAL and kind.kind in INTEGER and not kind.low <= node.const <= kind.high:
            value = wrap(node.const, kind)  # 16#FFFFFFFF beside a DINT
            made = self._literal(node, value)
            made.type = kind
            return made
        if base.kind in INTEGER and kind.kind in INTEGER and base.size < 4 and kind.size == 4:
            return node
        if base.kind in INTEGER and base.size == kind.size == 4 and kind.kind in INTEGER:
            return node
        if base.kind == "literal" and node.const is None:
            return self._wrapped(node, kind)
        if base.kind == "literal" or base is kind:
            return self.convert(node, kind)
        return self._wrapped(node, kind)

    def _arithmetic(self, node: s.Binary, kind: t.Elementary) -> s.Node:
        left, right = node.left.const, node.right.const
        if kind is t.INT_LITERAL and (left is None or right is None):
            kind = t.DINT
        if kind.kind in INTEGER and kind.size <= 4:
            kind = self._room(kind, node)
            if node.op in ("/", "MOD"):
                kind = self._quotient_type(kind, node)
        node.type = kind
        if right == 0 and node.op in ("/", "MOD") and kind.kind != "real" and kind is not t.REAL_LITERAL:
            self.error("E0603", node.right)
            if kind is t.INT_LITERAL:
                node.const = left  # a value of some size, so that nothing follows from it
            return node
        if left is not None and right is not None:
            node.const = arithmetic(node.op, left, right, kind)
        if kind.kind != "literal":
            self._operands(node, kind)
        return node

    @staticmethod
    def _room(kind: t.Elementary, node: s.Binary) -> t.Elementary:
        """A literal that the other operand's type can't hold widens the computation."""
        for side in (node.left, node.right):
            if side.type is t.INT_LITERAL and not kind.low <= side.const <= kind.high:
                if kind.size < 4 and t.DINT.low <= side.const <= t.DINT.high:
                    kind = t.DINT
                elif not (0 <= side.const <= t.UDINT.high):
                    kind = t.LINT
        return kind

    @staticmethod
    def _quotient_type(kind: t.Elementary, node: s.Binary) -> t.Elementary:
        """UDINT beside a signed number: only LINT holds both, and here the sign matters in every bit of the result."""
        kinds = [held(x) for x in (node.left, node.right) if x.type is not t.INT_LITERAL]
        mixed = len({k.signed for k in kinds}) == 2
        return t.LINT if mixed and any(k.size == 4 and not k.signed for k in kinds) else kind

    def power(self, node: s.Binary) -> s.Node:
        """a ** b: LREAL or REAL by the library's EXPT, whatever the operands (IEC 61131-3, table 29)."""
        call = s.Call(
            node.start, node.end, s.Name(node.start, node.start, "EXPT"),
            [s.Arg(x.start, x.end, None, x, False, False) for x in (node.left, node.right)],
        )  # fmt: skip
        if node.left.const is not None and node.right.const is not None and node.left.type is t.INT_LITERAL:
            value = arithmetic("**", node.left.const, node.right.const, t.INT_LITERAL)
            if value is not None and node.right.type is t.INT_LITERAL:
                node.type, node.const = t.INT_LITERAL, value
                return node
        return self.call(call, checked=True)

    def _comparison(self, node: s.Binary) -> s.Node:
        left, right = node.left, node.right
        node.type = t.BOOL
        kinds = kind_of(left.type), kind_of(right.type)
        number = common(left.type, right.type)
        if kinds == ("string", "string"):
            if left.type.wide != right.type.wide:
                wide = left.type if left.type.wide else right.type
                node.left, node.right = self.convert(left, wide), self.convert(right, wide)
        elif number is not None:
            self._compare_numbers(node, number)
        elif isinstance(left.type, t.Enum) or isinstance(right.type, t.Enum):
            self._compare_enums(node)
        elif not self._comparable(node, kinds):
            return self._refused(node)
        left, right = node.left.const, node.right.const
        if left is not None and right is not None and type(left) is type(right):
            node.const = COMPARISONS[node.op](left, right)
        return node

    def _compare_numbers(self, node: s.Binary, number: t.Elementary) -> None:
        """Integers are compared by what they are worth, whatever their types."""
        if number.kind not in INTEGER:
            if number.kind == "literal":
                node.left, node.right = self.settle(node.left), self.settle(node.right)
            else:
                self._operands(node, number)
            return
        left, right = (self._settle_beside(x, number) for x in (node.left, node.right))
        kinds = held(left), held(right)
        if len({k.signed for k in kinds}) == 1:
            number = max(kinds, key=lambda k: k.size)
        elif any(k.size == 8 and not k.signed for k in kinds):  # no type holds both: the emitter looks at the sign
            node.left, node.right = (
                self._widen(x, t.LINT if k.signed else t.ULINT) for x, k in zip((left, right), kinds, strict=True)
            )
            return
        else:
            number = t.LINT if any(k.size >= 4 and not k.signed or k.size == 8 for k in kinds) else t.DINT
        node.left, node.right = left, right
        self._operands(node, number)

    def _settle_beside(self, node: s.Node, number: t.Elementary) -> s.Node:
        """A literal gets the other side's type if that holds it."""
        if node.type is not t.INT_LITERAL:
            return node
        return self.convert(node, number) if number.low <= (node.const or 0) <= number.high else self.settle(node)

    def _compare_enums(self, node: s.Binary) -> None:
        for side in ("left", "right"):
            operand = getattr(node, side)
            if isinstance(operand.type, t.Enum):
                made = Convert(operand.start, operand.end, operand)
                made.type, made.const = operand.type.base, operand.const
                setattr(node, side, made)
        number = common(node.left.type, node.right.type)
        if number is None:
            self._refused(node)
        else:
            self._compare_numbers(node, number)

    def _comparable(self, node: s.Binary, kinds: tuple[str, str]) -> bool:
        left, right = node.left, node.right
        if set(kinds) == {"interface", "block"}:
            interface = left.type if kinds[0] == "interface" else right.type
            node.left, node.right = left, right = self.convert(left, interface), self.convert(right, interface)
        if "pointer" in kinds or "interface" in kinds:
            node.left, node.right = self._as_address(left), self._as_address(right)
            return t.ERROR not in (node.left.type, node.right.type)
        if kinds[0] == kinds[1] and kinds[0] in ("bool", "time", "date", "char"):
            if t.base_of(left.type) is not t.base_of(right.type):
                wide = max(left.type, right.type, key=lambda x: x.size)
                node.left, node.right = self.convert(left, wide), self.convert(right, wide)
            return kinds[0] != "bool" or node.op in ("=", "<>") or True
        if "bool" in kinds and "literal" in kinds:
            node.left, node.right = self.convert(left, t.BOOL), self.convert(right, t.BOOL)
            return True
        if "char" in kinds:
            other = left.type if kinds[0] == "char" else right.type
            node.left, node.right = self.convert(left, other), self.convert(right, other)
            return True
        return False

    def _as_address(self, node: s.Node) -> s.Node:
        if isinstance(node.type, t.Interface):
            return self._wrapped(node, t.DWORD)
        return node if node.type in (t.NULL, t.DWORD) else self.convert(node, t.DWORD)

    def _logic(self, node: s.Binary) -> s.Node:
        left, right = node.left, node.right
        kinds = kind_of(left.type), kind_of(right.type)
        if node.op in ("AND_THEN", "OR_ELSE") or "bool" in kinds:
            if not set(kinds) <= {"bool", "literal"}:
                return self._refused(node)
            node.type = t.BOOL
            node.left, node.right = self.convert(left, t.BOOL), self.convert(right, t.BOOL)
        else:
            kind = common(left.type, right.type)
            if kind is None or kind.kind == "real" or kind is t.REAL_LITERAL:
                return self._refused(node)
            node.type = self._room(kind, node) if kind.kind in INTEGER else kind
            if node.type.kind != "literal":
                self._operands(node, node.type)
        if node.left.const is not None and node.right.const is not None:
            node.const = logic(node.op, node.left.const, node.right.const, node.type)
        return node

    def _time_arithmetic(self, node: s.Binary) -> s.Node:
        """TIME and dates: +, - among them, * and / of a TIME by a number. The emitter sees the operands' types."""
        left, right, op = node.left, node.right, node.op
        kinds = kind_of(left.type), kind_of(right.type)
        a, b = t.base_of(left.type), t.base_of(right.type)
        long = a.size == 8 or b.size == 8
        if kinds == ("time", "time") and op in ("+", "-", "MOD"):
            node.type = t.LTIME if long else t.TIME
            node.left, node.right = self.convert(left, node.type), self.convert(right, node.type)
            if left.const is not None and right.const is not None and op != "MOD":
                node.const = wrap(left.const + right.const if op == "+" else left.const - right.const, node.type)
        elif kinds[0] == "time" and kinds[1] in NUMERIC and op in ("*", "/"):
            node.type = a
            node.right = self.settle(right)
        elif kinds[1] == "time" and kinds[0] in NUMERIC and op == "*":
            node.type = b
            node.left, node.right = right, self.settle(left)
        elif kinds == ("date", "time") and op in ("+", "-") and a.name not in ("DATE", "LDATE"):
            node.type = a
        elif kinds == ("date", "date") and op == "-" and a is b:
            node.type = t.LTIME if a.size == 8 else t.TIME
        else:
            return self._refused(node)
        return node

    def _pointer_arithmetic(self, node: s.Binary) -> s.Node:
        """p + n counts bytes, as in CoDeSys V2.3 and V3."""
        left, right = node.left, node.right
        pointers = [x for x in (left, right) if isinstance(x.type, t.Pointer)]
        if node.op not in ("+", "-", "MOD", "/", "*"):
            return self._refused(node)
        if len(pointers) == 2 or node.op not in ("+", "-"):
            node.left, node.right = self.convert(left, t.DWORD), self.convert(right, t.DWORD)
            node.type = t.DINT if node.op == "-" else t.DWORD
            return node
        for side in ("left", "right"):
            operand = getattr(node, side)
            if not isinstance(operand.type, t.Pointer):
                if kind_of(operand.type) not in INTEGER and operand.type is not t.INT_LITERAL:
                    return self._refused(node)
                setattr(node, side, self._widen(operand, t.DINT))
        node.type = pointers[0].type
        return node

    # ------------------------------------------------------------------------------------------ others

    def assignment(self, node: s.Assign) -> s.Node:
        """a := b := c: the inner assignment as a value."""
        if self.statement(node) is not None:  # a property: what its SET makes of the value is not known here
            self.error("E0319", node.target, name=self.text(node.target))
            return self.wrong(node)
        if node.op == "=" or node.target.type is None:
            return self.wrong(node)
        node.type = node.target.type
        return node

    def initialiser(self, node: s.Node) -> s.Node:
        self.error("E0604", node)
        return self.wrong(s.Literal(node.start, node.end, 0, None, ""))

    def checked(self, node: s.Node) -> s.Node:
        return node

    def call_expression(self, node: s.Call) -> s.Node:
        made = self.call(node)
        refers = isinstance(made.type, t.Pointer) and made.type.reference and isinstance(made, s.Call)
        return self._follow(made) if refers else made

    METHODS = {
        s.Literal: Names.literal, s.Name: Names.name, s.Address: Names.address, s.Member: Names.member,
        s.Part: Names.part, s.Index: Names.index, s.Deref: Names.deref, s.Unary: unary, s.Binary: binary,
        s.Call: call_expression, s.Assign: assignment, Convert: checked, s.ArrayInit: initialiser,
        s.StructInit: initialiser,
    }  # fmt: skip

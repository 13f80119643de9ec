"""Names and expressions: every node gets its type, its value where it is constant, and its symbol."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.check.conversions import INTEGER, NUMERIC, Conversions, common, kind_of
from stcore.check.fold import COMPARISONS, LOGIC, arithmetic, computing_type, wrap
from stcore.declare import parse_direct
from stcore.near import near
from stcore.scope import ActionOf, Builtin, Convert, EnumValue, GlobalList, Pou, TypeName, Var, key

DIRECT_TYPES = {0: t.BOOL, 1: t.BYTE, 2: t.WORD, 4: t.DWORD, 8: t.LWORD}
PART_TYPES = {"X": t.BOOL, "B": t.BYTE, "W": t.WORD, "D": t.DWORD}


class Expressions(Conversions):
    """Checks expressions. `expr` returns the node to use in place of the one given."""

    def expr(self, node: s.Node) -> s.Node:
        return self.METHODS[type(node)](self, node)

    def value(self, node: s.Node) -> s.Node:
        """An expression that must be a value: not the name of a type, a function or an action."""
        node = self.expr(node)
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

    # ---------------------------------------------------------------------------------------- operands

    def literal(self, node: s.Literal) -> s.Node:
        value, name = node.value, node.type_name
        node.const = value
        if name is None:
            node.type = t.INT_LITERAL if isinstance(value, int) else t.REAL_LITERAL
            return node
        if name in ("STRING", "WSTRING"):
            node.type = t.String(max(len(value), 1), name == "WSTRING")
            return node
        name = t.ALIASES.get(name, name)
        if name not in t.ELEMENTARY:
            return self._typed_literal(node, name)
        node.type = t.ELEMENTARY[name]
        if name == "TIME":
            node.const = wrap(value // 10**6, t.TIME)
        elif name in ("LDATE", "LDT", "LTOD"):
            node.const = value * (10**6 if name == "LTOD" else 10**9)
        elif node.type.kind in INTEGER and not node.type.low <= value <= node.type.high:
            self.warn("W0304", node, value=value, type=node.type)
            node.const = wrap(value, node.type)
        elif node.type.kind == "bool":
            node.const = bool(value)
        elif node.type.kind == "real":
            node.const = float(value)
        return node

    def _typed_literal(self, node: s.Literal, name: str) -> s.Node:
        symbol = self.lookup(name)
        if not isinstance(symbol, TypeName):
            self.unknown_name(node, name, "E0202")
            return self.wrong(node)
        node.type = t.INT_LITERAL
        return self.convert(node, symbol.type)

    def name(self, node: s.Name) -> s.Node:
        symbol = self.lookup(node.name)
        if symbol is None:
            if key(node.name) == "NULL":
                node.type, node.const = t.NULL, 0
                return node
            if key(node.name) == "THIS" and self.pou is not None and self.pou.type is not None:
                node.type, node.symbol = t.Pointer(self.pou.type), "this"
                return node
            self.unknown_name(node, node.name)
            return self.wrong(node)
        return self._use(node, symbol)

    def _use(self, node: s.Node, symbol: object) -> s.Node:
        """What a name stands for, put on its node."""
        node.symbol = symbol
        if isinstance(symbol, Var):
            node.type, node.const = symbol.type, symbol.const
            if symbol.owner is None and symbol.storage == "global" and symbol.library and self.pou is not None:
                self.project.library_globals.add(symbol)
            if isinstance(symbol.type, t.Pointer) and symbol.type.reference:
                return self._follow(node)
        elif isinstance(symbol, EnumValue):
            node.type, node.const = symbol.type, symbol.number
        elif isinstance(symbol, Pou) and symbol.kind == "PROGRAM":
            self.project.instance(symbol)
            self.use(symbol)
            node.type = symbol.type
        elif isinstance(symbol, s.Action):
            node.symbol = ActionOf(self.pou, symbol)
        return node

    def use(self, pou: Pou) -> None:
        """Note that this POU's code needs another."""
        self.project.reach(pou)
        if self.pou is not None:
            self.pou.uses.add(pou)

    def _follow(self, node: s.Node) -> s.Node:
        made = s.Deref(node.start, node.end, node)
        made.type = node.type.target
        return made

    def address(self, node: s.Address) -> s.Node:
        place = parse_direct(node.text)
        if place is None:
            self.error("E0206", node, address=node.text)
            return self.wrong(node)
        area, byte, bit, size = place
        node.type = DIRECT_TYPES[size]
        node.symbol = Var(node.text, node.type, "area", byte, area=area, bit=bit)
        self.project.direct(node.symbol)
        return node

    # ------------------------------------------------------------------------------------------- paths

    def member(self, node: s.Member) -> s.Node:
        node.base = base = self.expr(node.base)
        symbol, name = base.symbol, key(node.name)
        if isinstance(symbol, GlobalList) and base.type is None:
            found = self.project.lookup(f"{symbol.name}.{node.name}", self.library)
            if found is None:
                self.error("E0306", node, name=node.name, type=symbol.name, near=near(node.name, symbol.variables))
                return self.wrong(node)
            return self._use(node, found)
        if isinstance(symbol, TypeName) and isinstance(symbol.type, t.Enum):
            return self._enum_value(node, symbol.type)
        kind = base.type
        if kind is t.ERROR:
            return self.wrong(node)
        if isinstance(kind, t.Struct | t.Block):
            return self._field(node, kind, name)
        if isinstance(kind, t.Pointer) and isinstance(kind.target, t.Struct | t.Block):
            self.error("E0307", node, name=node.name, base=self.text(base))
            return self.wrong(node)
        index = self.lookup(node.name)
        if isinstance(index, Var) and isinstance(index.const, int) and kind is not None:
            part = s.Part(node.start, node.end, base, "X", index.const)
            return self.part(part)
        self.error("E0308", node, name=node.name, base=self.text(base), type=kind or "no type")
        return self.wrong(node)

    def _enum_value(self, node: s.Member, kind: t.Enum) -> s.Node:
        number = {key(n): v for n, v in kind.values.items()}.get(key(node.name))
        if number is None:
            self.error("E0306", node, name=node.name, type=kind.name, near=near(node.name, kind.values))
            return self.wrong(node)
        node.type, node.const, node.symbol = kind, number, EnumValue(kind, number)
        return node

    def _field(self, node: s.Member, kind: t.Struct | t.Block, name: str) -> s.Node:
        field = kind.members.get(name)
        if field is None and isinstance(kind, t.Block):
            pou = self.project.block_pous[kind]
            if name in pou.actions:
                node.symbol = ActionOf(pou, pou.actions[name], node.base)
                self.use(pou)
                return node
            var = pou.variables.get(name)
            if var is not None and var.storage == "area":
                return self._use(node, var)
        if field is None:
            known = [f.name for f in kind.members.values()]
            self.error("E0306", node, name=node.name, type=kind.name, near=near(node.name, known))
            return self.wrong(node)
        node.type, node.symbol = field.type, field
        if field.constant and isinstance(kind, t.Block):
            node.const = self.project.block_pous[kind].variables[name].const
        if isinstance(field.type, t.Pointer) and field.type.reference:
            return self._follow(node)
        return node

    def part(self, node: s.Part) -> s.Node:
        node.base = base = self.value(node.base)
        kind = t.base_of(base.type)
        if base.type is t.ERROR:
            return self.wrong(node)
        if isinstance(node.index, s.Node):
            node.index = self.value(node.index)
            node.index = node.index.const if isinstance(node.index.const, int) else -1
        if not isinstance(kind, t.Elementary) or kind.kind not in (*INTEGER, "time", "date", "bool", "literal"):
            self.error("E0309", node, type=base.type)
            return self.wrong(node)
        width = {"X": 1, "B": 8, "W": 16, "D": 32}[node.size]
        count = kind.bits // width
        if not 0 <= node.index < count:
            self.error("E0310", node, index=node.index, type=base.type, last=count - 1)
            return self.wrong(node)
        node.type = PART_TYPES[node.size]
        if isinstance(base.const, int):
            node.const = base.const >> node.index * width & ((1 << width) - 1)
            node.const = bool(node.const) if node.size == "X" else node.const
        return node

    def index(self, node: s.Index) -> s.Node:
        node.base = base = self.value(node.base)
        kind = base.type
        if kind is t.ERROR:
            node.indices = [self.value(i) for i in node.indices]
            return self.wrong(node)
        node.indices = [self._index_value(i) for i in node.indices]
        if isinstance(kind, t.Array):
            return self._array_element(node, kind)
        if isinstance(kind, t.Pointer | t.String) and len(node.indices) == 1:
            if isinstance(kind, t.Pointer):
                node.type = kind.target
            else:
                node.type = t.WORD if kind.wide else t.BYTE
            return node
        self.error("E0311", node, name=self.text(base), type=kind)
        return self.wrong(node)

    def _index_value(self, node: s.Node) -> s.Node:
        node = self.value(node)
        if node.type is t.ERROR:
            return node
        if kind_of(node.type) not in ("int", "bits") and node.type is not t.INT_LITERAL:
            self.error("E0312", node, type=node.type)
            return self.wrong(node)
        return self.convert(node, t.DINT) if t.base_of(node.type).size == 8 else node

    def _array_element(self, node: s.Index, kind: t.Array) -> s.Node:
        bounds = kind.bounds
        if not bounds:
            node.type = kind.element
            return node
        if len(node.indices) > len(bounds) and isinstance(kind.element, t.Array):
            inner = s.Index(node.start, node.end, node.base, node.indices[: len(bounds)])
            inner = self._array_element(inner, kind)
            outer = s.Index(node.start, node.end, inner, node.indices[len(bounds) :])
            return self._array_element(outer, kind.element)
        if len(node.indices) != len(bounds):
            self.error("E0313", node, name=self.text(node.base), wanted=len(bounds), given=len(node.indices))
            return self.wrong(node)
        for i, (low, high) in zip(node.indices, bounds, strict=True):
            if isinstance(i.const, int) and not low <= i.const <= high:
                self.error("E0314", i, value=i.const, low=low, high=high, name=self.text(node.base))
        node.type = kind.element
        if isinstance(node.type, t.Pointer) and node.type.reference:
            return self._follow(node)
        return node

    def deref(self, node: s.Deref) -> s.Node:
        node.base = base = self.value(node.base)
        if base.type is t.ERROR:
            return self.wrong(node)
        if not isinstance(base.type, t.Pointer):
            self.error("E0315", node, name=self.text(base), type=base.type)
            return self.wrong(node)
        node.type = base.type.target
        return node

    # --------------------------------------------------------------------------------------- operators

    def unary(self, node: s.Unary) -> s.Node:
        node.operand = operand = self.value(node.operand)
        kind = t.base_of(operand.type)
        node.type = kind
        if kind is t.ERROR:
            return node
        name = kind_of(kind)
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
        if node.op == "-" and name in ("bits", "int") and not kind.signed and node.const is None:
            node.type = t.DINT if kind.size <= 4 else t.LINT
            node.operand = self.convert(operand, node.type) if kind.size >= 4 else operand
        elif node.op == "-" and name in ("bits", "int") and node.const is not None and not kind.signed:
            node.type = t.INT_LITERAL
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
        if kind is None or node.op == "MOD" and kind_of(kind) == "real":
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
        node.type = kind
        if right == 0 and node.op in ("/", "MOD") and kind.kind != "real" and kind is not t.REAL_LITERAL:
            self.error("E0603", node.right, op=node.op)
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
        sides = [t.base_of(node.left.type), t.base_of(node.right.type)]
        mixed = {(x.signed, x.size) for x in sides if x.kind in INTEGER}
        if {(True, 4), (False, 4)} <= mixed or number.kind in INTEGER and self._room(number, node).size == 8:
            number = t.LINT  # so that a large UDINT is not a negative DINT
        if number.kind == "literal":
            node.left, node.right = self.settle(node.left), self.settle(node.right)
        else:
            self._operands(node, self._room(number, node) if number.kind in INTEGER else number)

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
        if "pointer" in kinds:
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
            node.const = LOGIC[node.op](node.left.const, node.right.const)
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
        self.statement(node)
        if node.op == "=" or node.target.type is None:
            return self.wrong(node)
        node.type = node.target.type
        return node

    def initialiser(self, node: s.Node) -> s.Node:
        self.error("E0604", node)
        return self.wrong(node)

    def checked(self, node: s.Node) -> s.Node:
        return node

    def call_expression(self, node: s.Call) -> s.Node:
        return self.call(node)

    METHODS = {
        s.Literal: literal, s.Name: name, s.Address: address, s.Member: member, s.Part: part, s.Index: index,
        s.Deref: deref, s.Unary: unary, s.Binary: binary, s.Call: call_expression, s.Assign: assignment,
        Convert: checked, s.ArrayInit: initialiser, s.StructInit: initialiser,
    }  # fmt: skip

    # ------------------------------------------------------------------------------------- assignability

    def place(self, node: s.Node, *, write: bool, addressed: bool = False) -> s.Node:
        """An expression that must be a variable: what := fills, ADR takes, VAR_IN_OUT is given."""
        node = self.value(node)
        if node.type is not t.ERROR:
            self._mark(node, node, write, addressed)
        return node

    def _mark(self, node: s.Node, whole: s.Node, write: bool, addressed: bool) -> None:
        match node:
            case s.Name() | s.Address() if isinstance(node.symbol, Var):
                self._mark_variable(node.symbol, whole, write, addressed)
            case s.Member():
                if isinstance(node.symbol, Var):
                    self._mark_variable(node.symbol, whole, write, addressed)
                elif isinstance(node.symbol, t.Field):
                    if node.symbol.constant and write:
                        self.error("E0318", whole, name=self.text(whole), why="it is a CONSTANT")
                    if not node.symbol.by_reference:
                        self._mark(node.base, whole, write, addressed)
                else:
                    self.error("E0319", whole, name=self.text(whole))
            case s.Index() if isinstance(node.base.type, t.Pointer):
                self._outside(write)
            case s.Index():
                self._mark(node.base, whole, write, addressed or isinstance(node.base.type, t.String))
            case s.Part():
                self._mark(node.base, whole, write, addressed)
            case s.Deref():
                self._outside(write)
            case s.Name() if isinstance(node.symbol, Pou) or node.symbol == "this":
                self._outside(write)
            case s.Call():
                self._outside(write)
            case _:
                self.error("E0319", whole, name=self.text(whole))

    def _outside(self, write: bool) -> None:
        if write and self.pou is not None:
            self.pou.writes_outside = True

    def _mark_variable(self, var: Var, whole: s.Node, write: bool, addressed: bool) -> None:
        if write and var.read_only:
            self.error("E0318", whole, name=self.text(whole), why=var.read_only)
        if write and isinstance(var.type, t.String) and self.pou is not None and self.pou.bindings:
            if var.section == "VAR_INPUT":
                self.error("E0318", whole, name=self.text(whole), why="it is passed without a copy")
        var.written |= write
        var.addressed |= addressed
        if var.storage in ("global", "area") or var.indirect:
            self._outside(write)


def builtin_name(symbol: object) -> str:
    return symbol.name if isinstance(symbol, Builtin) else ""

"""Names and paths: what they stand for, their type and constant value, and whether they can be written."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.check.conversions import INTEGER, Conversions, kind_of
from stcore.check.fold import wrap
from stcore.direct import parse_direct
from stcore.near import near
from stcore.scope import ActionOf, EnumValue, GlobalList, MethodOf, Pou, PropertyOf, TypeName, Var, key, member_of

DIRECT_TYPES = {0: t.BOOL, 1: t.BYTE, 2: t.WORD, 4: t.DWORD, 8: t.LWORD}
PART_TYPES = {"X": t.BOOL, "B": t.BYTE, "W": t.WORD, "D": t.DWORD}


class Names(Conversions):
    """Checks literals, names and paths."""

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
        if isinstance(symbol, Pou):
            symbol = self.project.constant_beside(symbol) or symbol
        if symbol is None:
            if key(node.name) == "NULL":
                node.type, node.const = t.NULL, 0
                return node
            if key(node.name) == "THIS" and self.pou is not None and self.pou.type is not None:
                node.type, node.symbol = t.Pointer(self.pou.type), "this"
                return node
            if key(node.name) == "SUPER" and self.pou is not None and self.pou.type is not None:
                return self._super(node)
            meant = self.meant(node, node.name, self.known_names())
            symbol = self.lookup(meant) if meant else self.declare_missing(node)
            if symbol is None:
                self.unknown_name(node, node.name)
                return self.wrong(node)
        return self._use(node, symbol)

    def _super(self, node: s.Name) -> s.Node:
        """The running instance as one of the block that its block extends."""
        base = (self.pou.holder or self.pou).base
        if base is None:
            if not self.pou.incomplete:
                self.error("E0415", node, name=(self.pou.holder or self.pou).name)
            return self.wrong(node)
        node.type, node.symbol = t.Pointer(base.type), "super"
        return node

    def _use(self, node: s.Node, symbol: object) -> s.Node:
        """What a name stands for, put on its node."""
        node.symbol = symbol
        if isinstance(symbol, Var):
            if symbol.constant and symbol in self.project.evaluated:
                return self._circle(node, symbol)
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
        elif isinstance(symbol, MethodOf | PropertyOf):
            return self.of_instance(node, symbol)
        return node

    def _circle(self, node: s.Node, symbol: Var) -> s.Node:
        """A constant whose value needs its value."""
        names = [v.name for v in self.project.evaluated]
        names = [*names[self.project.evaluated.index(symbol) :], symbol.name]
        self.error("E0608", node, name=symbol.name, way=" -> ".join(names))
        return self.wrong(node)

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
        if isinstance(kind, t.Interface):
            return self.interface_member(node, kind)
        if isinstance(kind, t.Struct | t.Block):
            return self._field(node, kind, name)
        if isinstance(kind, t.Enum) and key(kind.name) == key(self.text(base)):
            return self._enum_value(node, kind)  # color : Color := Color.red, where the variable hides its type
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
            action = pou.action(name)
            if action is not None:
                node.symbol = ActionOf(action.pou, action.action, node.base)
                self.use(action.pou)
                return node
            found = member_of(pou, name, node.base)
            if found is not None:
                return self.of_instance(node, found)
            var = pou.variables.get(name)
            if var is not None and var.storage == "area":
                return self._use(node, var)
            field = self._other_name(node, kind, pou.parameters)
        if field is None:
            known = [f.name for f in kind.members.values()]
            if isinstance(kind, t.Block):
                if self.project.block_pous[kind].incomplete:
                    return self.wrong(node)
                known += [m.name for p in self.project.block_pous[kind].chain() for m in p.methods.values()]
            self.no_member(node, node.name, kind, known)
            return self.wrong(node)
        node.type, node.symbol = field.type, field
        if field.constant and isinstance(kind, t.Block):
            node.const = self.project.block_pous[kind].variables[name].const
        if isinstance(field.type, t.Pointer) and field.type.reference:
            return self._follow(node)
        return node

    def _other_name(self, node: s.Member, kind: t.Block, parameters: list[Var]) -> t.Field | None:
        """The parameter of a block that has this name too, or that a misprint of it means."""
        name = next((p.name for p in parameters if p.also == key(node.name)), None)
        name = name or self.meant(node, node.name, [p.name for p in parameters])
        return kind.members.get(key(name)) if name else None

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
        if isinstance(kind, t.Pointer | t.String) and len(node.indices) == 1 and not isinstance(kind, t.Interface):
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
            if len(node.indices) != kind.open:
                self.error("E0313", node, name=self.text(node.base), wanted=kind.open, given=len(node.indices))
                return self.wrong(node)
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
        if not isinstance(base.type, t.Pointer) or isinstance(base.type, t.Interface):
            self.error("E0315", node, name=self.text(base), type=base.type)
            return self.wrong(node)
        node.type = base.type.target
        return node

    # ------------------------------------------------------------------------------------- assignability

    def place(self, node: s.Node, *, write: bool, addressed: bool = False) -> s.Node:
        """An expression that must be a variable: what := fills, ADR takes, VAR_IN_OUT is given."""
        return self.placed(self.expr(node), write=write, addressed=addressed)

    def placed(self, node: s.Node, *, write: bool, addressed: bool = False) -> s.Node:
        """The same of an expression that has been checked."""
        node = self.as_value(node)
        if node.type is not t.ERROR:
            self._mark(node, node, write, addressed)
        return node

    def addressed_whole(self, kind: t.Type) -> None:
        """A pointer to a variable of this type may lead to all members of the blocks in it."""
        while isinstance(kind, t.Array):
            kind = kind.element
        if isinstance(kind, t.Struct | t.Block):
            for field in kind.members.values():
                self.addressed_whole(field.type)
        if isinstance(kind, t.Block):
            for var in self.project.block_pous[kind].variables.values():
                var.addressed = True

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
                    if addressed and isinstance(node.base.type, t.Block):
                        self.project.block_pous[node.base.type].variables[key(node.symbol.name)].addressed = True
                    if not node.symbol.by_reference:
                        self._mark(node.base, whole, write, addressed)
                else:
                    self._no_variable(whole)
            case s.Index() if isinstance(node.base.type, t.Pointer):
                self._outside(write)
            case s.Index():
                self._mark(node.base, whole, write, addressed or isinstance(node.base.type, t.String))
            case s.Part():
                self._mark(node.base, whole, write, addressed)
            case s.Deref():
                self._outside(write)
            case s.Name() if isinstance(node.symbol, Pou) or node.symbol in ("this", "super"):
                self._outside(write)
            case s.Call() if write and not addressed:
                self._no_variable(whole)
            case s.Call() if node.type is not None and t.is_aggregate(node.type):
                self._outside(write)
            case _:
                self._no_variable(whole)

    def _no_variable(self, node: s.Node) -> None:
        self.error("E0319", node, name=self.text(node))
        self.wrong(node)

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
        elif write and var.storage == "this" and self.pou is not None:
            self.pou.writes_instance = True

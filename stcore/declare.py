"""Declarations of one file: syntax to types, variables and POUs, with their layout."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from stcore import objects
from stcore import syntax as s
from stcore import types as t
from stcore.near import near
from stcore.scope import EnumValue, Init, Pou, TypeName, Var, key
from stcore.source import Source

if TYPE_CHECKING:
    from stcore.project import Project


@dataclass(eq=False, slots=True)
class Pending:
    """A declaration that has been read but not resolved."""

    kind: str  # 'pou', 'type', 'enum value', 'global', 'list'
    tree: s.Node
    source: Source
    library: bool
    extra: object = None  # the section of a global; the type name of an enum value; a GlobalList
    symbol: object = None
    early: object = None  # an enumeration while it is being resolved: for values that use those before them
    busy: bool = False
    at: int = 0  # where the name stands


def align(value: int, to: int) -> int:
    return (value + to - 1) // to * to


class Declarer:
    """Resolves the declarations of one file."""

    def __init__(self, project: Project, source: Source, library: bool) -> None:
        self.project = project
        self.source = source
        self.library = library

    def error(self, code: str, node: s.Node, **fields) -> None:
        self.project.reporter.add(code, self.source, node.start, node.end, **fields)

    # ------------------------------------------------------------------------------------------- types

    def type(self, node: s.Node, name: str = "", pou: Pou | None = None) -> t.Type:
        """The type that a type node means; ERROR, which goes with everything, after an error was reported."""
        match node:
            case s.NamedType():
                return self.named(node, pou)
            case s.StringType():
                length = 80 if node.length is None else self._integer(node.length, pou, 80)
                return t.String(min(max(length, 1), 65535), node.wide)
            case s.ArrayOf():
                return self._array(node, pou)
            case s.PointerTo() | s.ReferenceTo():
                return self._pointer(node, pou)
            case s.EnumDef():
                return self._enum(node, name or "ENUM", pou)
            case s.Subrange():
                base = t.base_of(self.named(s.NamedType(node.start, node.end, node.base, None), pou))
                low, high = self._integer(node.low, pou, 0), self._integer(node.high, pou, 0)
                return t.SubrangeType(name or f"{base}({low}..{high})", base, low, high)
            case s.StructDef() | s.UnionDef():
                return self._struct(node, name or "STRUCT", pou)
        raise TypeError(node)

    def named(self, node: s.NamedType, pou: Pou | None = None) -> t.Type:
        upper = key(node.name)
        if pou is not None and upper in pou.bindings:
            return pou.bindings[upper]
        upper = t.ALIASES.get(upper, upper)
        if upper in t.ELEMENTARY and t.ELEMENTARY[upper].kind != "literal":
            return t.ELEMENTARY[upper]
        name = node.name.rpartition(".")[2]
        symbol = self.project.lookup(name, self.library)
        if symbol is None and (meant := self._respelt(name)):
            symbol = self.project.lookup(meant, self.library)
            self.error("W0130", node, name=node.name, meant=meant)
        if isinstance(symbol, TypeName):
            return symbol.type
        if isinstance(symbol, Pou) and symbol.type is not None:
            return symbol.type
        if symbol is not None:
            self.error("E0204", node, name=node.name)
        elif self.being_declared(node.name) is None:  # else it contains itself, which has been said
            known = [n for n in t.ELEMENTARY if not n.startswith("ANY")] + self.project.known_names(self.library)
            self.error("E0202", node, name=node.name, near=near(node.name, known))
        return t.ERROR

    def _respelt(self, name: str) -> str | None:
        """The type that a manual of a library prints with this name."""
        spellings = {key(printed): meant for printed, meant in self.project.spellings().items()}
        return spellings.get(key(name))

    def _pointer(self, node: s.PointerTo | s.ReferenceTo, pou: Pou | None) -> t.Pointer:
        """What it points to may lead back to the type that is being declared: then it is filled in later."""
        target, project = node.target, self.project
        pointer = t.Pointer(t.ERROR, isinstance(node, s.ReferenceTo))
        if project.declaring and self._is_open(target, pou):
            pointer.name = pointer.name.replace("?", " ".join(self.source.text[target.start : target.end].split()))
            project.postponed.append(lambda: pointer.lead_to(self.type(target, pou=pou)))
        else:
            pointer.lead_to(self.type(target, pou=pou))
        return pointer

    def _is_open(self, node: s.Node, pou: Pou | None) -> bool:
        """Whether a type can't be used yet without resolving another declaration."""
        while isinstance(node, s.ArrayOf):
            node = node.element
        if not isinstance(node, s.NamedType) or pou is not None and key(node.name) in pou.bindings:
            return False
        upper = t.ALIASES.get(key(node.name), key(node.name))
        entry = (self.project.library if self.library else self.project.user).get(upper)
        return upper not in t.ELEMENTARY and (entry is None or entry.symbol is None)

    def _integer(self, node: s.Node, pou: Pou | None, default: int) -> int:
        said = len(self.project.reporter.diagnostics)
        value = self.project.evaluate(node, self.source, pou, self.library)
        if isinstance(value, bool) or not isinstance(value, int):
            if len(self.project.reporter.diagnostics) == said:
                self.error("E0601", node)
            return default
        return value

    def _array(self, node: s.ArrayOf, pou: Pou | None) -> t.Type:
        element = self.type(node.element, pou=pou)
        bounds = self._bounds(node, pou)
        if bounds is None:
            return t.ERROR
        array = t.Array(element, bounds, 0 if bounds else len(node.dims))
        if isinstance(node.element, s.NamedType) and key(node.element.name) in self.project.type_inits:
            self.project.element_inits[array] = self.project.type_inits[key(node.element.name)]
        return array

    def _bounds(self, node: s.ArrayOf, pou: Pou | None) -> list[tuple[int, int]] | None:
        """Lowest and highest index of each dimension; none for ARRAY[*], None where one is wrong."""
        bounds, said = [], len(self.project.reporter.diagnostics)
        for dim in node.dims:
            if dim is None:
                return []
            low, high = (self._integer(b, pou, 0) for b in dim)
            if len(self.project.reporter.diagnostics) == said and high < low:
                self.project.reporter.add("E0205", self.source, dim[0].start, dim[1].end, low=low, high=high)
            bounds.append((low, high))
        return bounds if len(self.project.reporter.diagnostics) == said else None

    def _enum(self, node: s.EnumDef, name: str, pou: Pou | None) -> t.Enum:
        base = t.base_of(self.named(s.NamedType(node.start, node.end, node.base, None), pou)) if node.base else t.INT
        enum = t.Enum(name, base, {})
        entry = self.being_declared(name)
        if entry is not None:
            entry.early = TypeName(enum)  # a value may be worked out from those before it
        number = 0
        for item, _, value in node.items:
            if value is not None:
                number = self._integer(value, pou, number)
            enum.values[item] = number
            if pou is not None:
                pou.enum_names[key(item)] = EnumValue(enum, number)
            number += 1
        return enum

    def being_declared(self, name: str) -> Pending | None:
        """The declaration of a type of this name that is being resolved now."""
        entry = (self.project.library if self.library else self.project.user).get(key(name))
        return entry if entry is not None and entry.busy else None

    def _struct(self, node: s.StructDef | s.UnionDef, name: str, pou: Pou | None) -> t.Struct:
        union = isinstance(node, s.UnionDef)
        struct = t.Struct(name, {}, union)
        if not union and node.extends:
            base = self.named(s.NamedType(node.start, node.end, node.extends, None), pou)
            if isinstance(base, t.Struct):
                struct.members.update(base.members)
                struct.size, struct.align = base.size, base.align
        for decl in node.fields_:
            kind = self.type(decl.type, pou=pou)
            self._no_abstract(decl, kind)
            offset = 0 if union else align(struct.size, kind.align)
            field = t.Field(decl.name, kind, offset, attributes=decl.attributes)
            if key(decl.name) in struct.members:
                first = struct.members[key(decl.name)]
                self.project.reporter.add(
                    "E0201", self.source, decl.start, decl.start + len(decl.name), name=decl.name, line=first.name
                )
                continue
            struct.members[key(decl.name)] = field
            init = self.initial(decl, pou)
            if init is not None:
                self.project.field_inits[field] = init
            struct.size = max(struct.size, offset + kind.size)
            struct.align = max(struct.align, kind.align)
        struct.size = align(max(struct.size, 1), struct.align)
        return struct

    def initial(self, decl: s.VarDecl, pou: Pou | None) -> Init | None:
        """What a declaration says of the initial value: its own, or its type's."""
        if decl.init is not None:
            args = decl.type.args if isinstance(decl.type, s.NamedType) else None
            if args and isinstance(decl.init, s.StructInit):  # fb : Block(n := 3) := (x := 4)
                both = s.StructInit(decl.type.start, decl.init.end, [*args, *decl.init.items])
                return Init(both, self.source, pou, self.library)
            return Init(decl.init, self.source, pou, self.library)
        if isinstance(decl.type, s.NamedType):
            if decl.type.args:
                given = s.StructInit(decl.type.start, decl.type.end, decl.type.args)
                return Init(given, self.source, pou, self.library)
            return self.project.type_inits.get(key(decl.type.name))
        return None

    # ----------------------------------------------------------------------------------------- globals

    def global_variable(self, entry: Pending) -> Var:
        section, list_name = entry.extra
        decl = entry.tree
        var = self._var(decl, section, None)
        var.storage = "global"
        var.source = self.source
        self._place_static(var)
        var.name = decl.name
        var.decl = decl
        entry.symbol = var
        self.project.globals.append(var)
        if var.constant:
            self._constant(var)
        var.section = f"VAR_GLOBAL {list_name}"
        return var

    def _place_static(self, var: Var) -> None:
        address = var.decl.address
        if address and "*" not in address:
            place_direct(var, address, lambda: self.error("E0206", var.decl, address=address))
        else:
            var.address = self.project.allocate(var.type.size, max(var.type.align, 4))

    def _constant(self, var: Var) -> None:
        """Evaluate a CONSTANT, if it is one that a value can stand for."""
        if var.init is None:
            start = var.decl.start
            self.project.reporter.add("W0202", self.source, start, start + len(var.name), name=var.name)
        elif not t.is_aggregate(var.type) or isinstance(var.type, t.String):
            if not isinstance(var.init.node, s.ArrayInit | s.StructInit):
                var.const = self.project.evaluate(var, self.source, var.owner, self.library)

    def _var(self, decl: s.VarDecl, section: s.VarSection, pou: Pou | None) -> Var:
        enum_name = f"{pou.name}.{decl.name}" if pou else decl.name
        later = section.kind == "VAR_IN_OUT" and self.project.declaring and isinstance(decl.type, s.NamedType)
        later = later and self._is_open(decl.type, pou)  # an address: the block it leads to may hold this one
        kind = t.ERROR if later else self.type(decl.type, enum_name, pou)
        q = section.qualifiers
        var = Var(
            decl.name, kind, "this", section=section.kind, constant="CONSTANT" in q, retain="RETAIN" in q,
            persistent="PERSISTENT" in q, owner=pou, decl=decl, source=self.source, library=self.library,
        )  # fmt: skip
        if later:
            self.project.postponed.append(lambda: self._type_later(var, decl, pou))
        var.also = key(decl.attributes.get("also", ""))
        var.room_of = key(decl.attributes.get("room_of", "")) if self.library else ""
        var.init = self.initial(decl, pou)
        if var.constant:
            var.read_only = "it is a CONSTANT"
        if section.kind != "VAR_IN_OUT":
            self._no_abstract(decl, kind)
        if isinstance(kind, t.Array) and not kind.bounds and section.kind != "VAR_IN_OUT":
            self.error("E0207", decl, name=decl.name)
        return var

    def _no_abstract(self, decl: s.VarDecl, kind: t.Type) -> None:
        """An ABSTRACT block has no instances of its own."""
        while isinstance(kind, t.Array):
            kind = kind.element
        pou = self.project.block_pous.get(kind) if isinstance(kind, t.Block) else None
        if pou is not None and "ABSTRACT" in pou.tree.modifiers:
            self.error("E0215", decl.type, name=pou.name)

    def _type_later(self, var: Var, decl: s.VarDecl, pou: Pou) -> None:
        var.type = self.type(decl.type, pou=pou)
        field = pou.type.members.get(key(var.name)) if pou.type is not None else None
        if field is not None:
            field.type = var.type

    # -------------------------------------------------------------------------------------------- POUs

    def pou(self, entry: Pending, bindings: dict[str, t.Type] | None = None) -> Pou:
        tree: s.Pou = entry.tree
        if tree.kind == "INTERFACE":
            return objects.interface(self, entry)
        pou = Pou(tree.kind, tree.name, tree, self.source, self.library, attributes=tree.attributes)
        pou.bindings = bindings or {}
        pou.serial = len(self.project.pous)
        pou.symbol = f"${tree.name if tree.name.isascii() else 'pou'}.{pou.serial}"
        for action in tree.actions:
            pou.actions[key(action.name)] = action
        if tree.kind == "FUNCTION":
            entry.symbol = pou  # a function may call itself
            if not tree.generics or bindings is not None:
                self._variables(pou)
                if tree.result is not None:
                    kind = self.type(tree.result, pou=pou)
                    pou.result = Var(tree.name, kind, "local", section="RESULT", owner=pou, library=self.library)
        else:
            pou.type = t.Block(tree.name, tree.kind, file=self.source.path, attributes=tree.attributes)
            self.project.block_pous[pou.type] = pou
            self.project.named_types[key(tree.name)] = pou.type
            if tree.kind == "FUNCTION_BLOCK":
                objects.extend(self, pou)
            self._variables(pou)
            if tree.methods:
                objects.declare_methods(self, pou)
            self._lay_out(pou)
        self.project.pous.append(pou)
        return pou

    def method(self, pou: Pou) -> None:
        """The variables of a method, and its result."""
        self._variables(pou)
        if pou.tree.result is not None:
            kind = self.type(pou.tree.result, pou=pou)
            pou.result = Var(pou.name, kind, "local", section="RESULT", owner=pou, library=self.library)

    def kept_variables(self, pou: Pou) -> None:
        """VAR_INST of a method: they live in the instance of its block."""
        for section in pou.tree.sections:
            for decl in section.decls if section.kind == "VAR_INST" else ():
                if key(decl.name) not in pou.variables:
                    pou.variables[key(decl.name)] = self._var(decl, section, pou)

    def _variables(self, pou: Pou) -> None:
        """Constants first: bounds, and initial values above them in the text, may use them."""
        sections = sorted(pou.tree.sections, key=lambda x: "CONSTANT" not in x.qualifiers)
        made: dict[int, Var] = {id(v.decl): v for v in pou.variables.values() if v.section == "VAR_INST"}
        inherited = {n: v for n, v in pou.variables.items() if v.owner is not pou}
        for section in sections:
            for decl in section.decls if "CONSTANT" in section.qualifiers else ():
                pou.later.setdefault(key(decl.name), partial(self._declare, decl, section, pou, made))
        for section in sections:
            for decl in section.decls:
                self._declare(decl, section, pou, made)
        order = [made[id(d)] for x in pou.tree.sections for d in x.decls if id(d) in made]
        order += [v for v in pou.variables.values() if v.section == "EDGE"]
        pou.variables = inherited | {key(v.name): v for v in order}
        pou.parameters += [v for v in order if v.section in ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")]

    def _declare(self, decl: s.VarDecl, section: s.VarSection, pou: Pou, made: dict[int, Var]) -> None:
        name, given = key(decl.name), decl
        pou.later.pop(name, None)
        if id(decl) in made:
            return
        first = pou.variables.get(name)
        if first is not None:
            where = first.source or self.source
            line = where.position(first.decl.start)[0]
            line = line if where is self.source else f"{line} of {where.path}"
            self.project.reporter.add(
                "E0201", self.source, decl.start, decl.start + len(decl.name), name=decl.name, line=line
            )
            return
        if section.kind == "VAR_EXTERNAL":
            var = self.project.lookup(decl.name, self.library)
            if not isinstance(var, Var):
                self.error("E0208", decl, name=decl.name)
                var = made[id(decl)] = Var(decl.name, t.ERROR, "global", decl=decl)
            pou.variables[name] = var
            return
        if pou.kind == "PROGRAM":
            decl = self._configured(decl, pou)
        var = self._var(decl, section, pou)
        pou.variables[name] = var
        made[id(given)] = var
        if decl.address and "*" not in decl.address:
            place_direct(var, decl.address, lambda: self.error("E0206", decl, address=decl.address))
        elif var.constant and section.kind == "VAR" or section.kind == "VAR_STAT":
            var.storage = "global"
            var.address = self.project.allocate(var.type.size, max(var.type.align, 4))
        elif pou.is_called or section.kind == "VAR_TEMP":
            var.storage = "local"
        var.indirect = section.kind == "VAR_IN_OUT"
        if "edge" in decl.attributes:
            self._edge(var, decl, pou)
        if var.constant and not var.indirect:
            self._constant(var)
        if var.constant and section.kind == "VAR_INPUT":
            var.storage = "local" if pou.is_called else "this"

    def _edge(self, var: Var, decl: s.VarDecl, pou: Pou) -> None:
        """Two hidden variables for an input with an edge: what the body sees, and the input at the last call."""
        edge = decl.attributes["edge"]
        if pou.is_called or var.section != "VAR_INPUT" or var.type is not t.BOOL:
            self.error("E0210", decl, edge=edge)
            return
        seen, last = (
            Var(f"{var.name}__{x}", t.BOOL, "this", section="EDGE", owner=pou, decl=decl, source=self.source)
            for x in (edge, "last")
        )
        pou.edges[key(var.name)] = seen
        pou.variables |= {key(v.name): v for v in (seen, last)}

    def _configured(self, decl: s.VarDecl, pou: Pou) -> s.VarDecl:
        """The declaration with the address and the initial value that VAR_CONFIG has for it."""
        found, _ = self.project.configured.get(key(f"{pou.name}.{decl.name}"), (None, None))
        if found is None:
            return decl
        made = s.VarDecl(decl.start, decl.end, *(getattr(decl, f) for f in s.VarDecl.fields))
        made.address = found.address or decl.address
        made.init = found.init or decl.init
        return made

    def _lay_out(self, pou: Pou) -> None:
        """Give each variable its place in an instance."""
        block = pou.type
        block.align = max(block.align, 4)
        if block.number and block.base is None:
            block.size = 4
        own = [v for v in pou.variables.values() if v.owner is pou and v.storage != "local"]
        for var in own + [v for m in pou.methods.values() for v in m.variables.values()]:
            size, alignment = (4, 4) if var.indirect else (var.type.size, var.type.align)
            size += 8 * getattr(var.type, "open", 0)  # low and high of each dimension of ARRAY[*]
            if var.storage == "this":
                var.address = align(block.size, alignment)
                block.size = var.address + size
                block.align = max(block.align, alignment)
            section = "VAR_STAT" if var.storage == "global" else var.section
            name = var.name if var.owner is pou else f"{var.owner.name}__{var.name}"
            field = t.Field(
                name, var.type, var.address, section, var.constant, var.retain, var.persistent, var.decl.attributes
            )
            if var.storage == "area":
                continue
            block.members[key(name)] = field
            if var.init is not None and var.storage == "this":
                self.project.field_inits[field] = var.init
        block.size = align(max(block.size, 4), block.align)


DIRECT_SIZES = {"X": 0, "B": 1, "W": 2, "D": 4, "L": 8}


def parse_direct(text: str) -> tuple[str, int, int | None, int] | None:
    """'%QX1.3' -> ('Q', 1, 3, 0); '%MW4' -> ('M', 8, None, 2); None if it is no direct address."""
    body = text.upper().lstrip("%")
    if not body or body[0] not in "IQM":
        return None
    area, rest = body[0], body[1:]
    letter = rest[0] if rest and rest[0] in DIRECT_SIZES else "X"
    numbers = (rest[1:] if rest and rest[0] in DIRECT_SIZES else rest).split(".")
    if not all(n.isdigit() for n in numbers) or len(numbers) > (2 if letter == "X" else 1):
        return None
    first = int(numbers[0])
    if letter == "X":
        byte, bit = (first, int(numbers[1])) if len(numbers) == 2 else divmod(first, 8)
        return (area, byte, bit, 0) if bit < 8 else None
    size = DIRECT_SIZES[letter]
    return area, first * size, None, size


def place_direct(var: Var, address: str, wrong: Callable[[], None]) -> None:
    """AT %IX0.0: put the variable into its area."""
    place = parse_direct(address)
    if place is None:
        wrong()
        place = ("M", 0, None, var.type.size)
    var.storage = "area"
    var.area, var.address, var.bit, size = place
    if var.type is not t.BOOL:
        var.bit = None

"""Declarations of types: syntax to types with their layout."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stcore import syntax as s
from stcore import types as t
from stcore.near import near
from stcore.scope import EnumValue, Init, Pou, TypeName, key
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


class TypeDeclarer:
    """Resolves the types that one file declares and names."""

    def __init__(self, project: Project, source: Source, library: bool) -> None:
        self.project = project
        self.source = source
        self.library = library

    def error(self, code: str, node: s.Node, **fields) -> None:
        self.project.reporter.add(code, self.source, node.start, node.end, **fields)

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

    def _no_abstract(self, decl: s.VarDecl, kind: t.Type) -> None:
        """An ABSTRACT block has no instances of its own."""
        while isinstance(kind, t.Array):
            kind = kind.element
        pou = self.project.block_pous.get(kind) if isinstance(kind, t.Block) else None
        if pou is not None and "ABSTRACT" in pou.tree.modifiers:
            self.error("E0215", decl.type, name=pou.name)

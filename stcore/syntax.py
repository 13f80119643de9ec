"""The syntax tree: one class per construct of the language, with exact spans.

The parser builds these nodes and nothing else; the rest of the compiler never sees tokens or the grammar.
``start`` and ``end`` are character offsets into the source text (end exclusive). Expression nodes carry three
slots that the checker fills in: ``type`` (stcore.types), ``const`` (a Python value when the expression is
constant, else None) and ``symbol`` (what a name stands for).

Names keep the spelling of the source; every comparison in the compiler folds case.
"""

from __future__ import annotations

from operator import attrgetter

ANNOTATIONS = ("type", "const", "symbol")  # what the checker adds to an expression; None until then


class Node:
    """A construct of the source. ``Node(start, end, *fields)`` fills the fields of the class in order."""

    __slots__ = ("start", "end")
    fields: tuple[str, ...] = ()

    def __init_subclass__(cls) -> None:
        """Write the constructor out: building a hundred thousand nodes through a loop would cost a second."""
        slots = cls.__slots__
        annotations = ANNOTATIONS if set(ANNOTATIONS) <= set(slots) else ()  # VarDecl has a type of its own
        cls.fields = tuple(s for s in slots if s not in annotations)
        lines = [f"def __init__({', '.join(('self', 'start', 'end', *cls.fields))}):"]
        lines += [f"    self.{name} = {name}" for name in ("start", "end", *cls.fields)]
        lines += [f"    self.{name} = None" for name in annotations]
        namespace: dict = {}
        exec("\n".join(lines), namespace)
        cls.__init__ = namespace["__init__"]
        cls._given = attrgetter("start", "end", *cls.fields)

    def __reduce__(self):
        """Pickle what the parser built, without the checker's annotations."""
        return type(self), self._given(self)

    def __repr__(self) -> str:
        inner = ", ".join(f"{f}={getattr(self, f)!r}" for f in self.fields)
        return f"{type(self).__name__}({inner})"


# --------------------------------------------------------------------------------------------------- files


class File(Node):
    """A whole source file. units: Pou, TypeDecl, VarSection (VAR_GLOBAL, VAR_CONFIG), Configuration.

    attributes: the pragmas before the first unit that are not the first unit's own, as for Pou.
    """

    __slots__ = ("units", "attributes")


# kinds of the methods of a block, and the word that each is written with
WRITTEN = {"METHOD": "METHOD", "GET": "PROPERTY", "SET": "PROPERTY"}


class Pou(Node):
    """PROGRAM, FUNCTION, FUNCTION_BLOCK, INTERFACE, METHOD, and GET, SET of a property (kind, upper case).

    result: a type node for a FUNCTION, METHOD or GET with a result, else None. generics: list of (name, ANY type name),
    written ``FUNCTION LEN <T: ANY_STRING> : INT``, used by the library. parts: what belongs to it: Action, and the Pou
    of each method, GET and SET. attributes: dict of ``{attribute 'name' := 'value'}`` pragmas, lower-case names,
    value '' when absent. extends: the name of the block that it extends, or None. implements: names of interfaces; of
    an INTERFACE those that it extends. modifiers: frozenset of ABSTRACT, FINAL, PUBLIC, PRIVATE, ... name_start: where
    the name stands.
    """

    __slots__ = (
        "kind", "name", "name_start", "result", "generics", "sections", "body", "parts", "attributes",
        "extends", "implements", "modifiers",
    )  # fmt: skip

    @property
    def actions(self) -> list[Action]:
        return [p for p in self.parts if isinstance(p, Action)]

    @property
    def methods(self) -> list[Pou]:
        return [p for p in self.parts if isinstance(p, Pou)]


class Action(Node):
    """ACTION name: body END_ACTION, attached to the POU it belongs to."""

    __slots__ = ("name", "name_start", "body")


class VarSection(Node):
    """kind: VAR, VAR_INPUT, VAR_OUTPUT, VAR_IN_OUT, VAR_GLOBAL, VAR_TEMP, VAR_STAT, VAR_INST, VAR_EXTERNAL, VAR_CONFIG.

    qualifiers: frozenset of CONSTANT, RETAIN, PERSISTENT, NON_RETAIN. name: of a named global list, else None.
    """

    __slots__ = ("kind", "qualifiers", "decls", "name", "attributes")


class VarDecl(Node):
    """One variable (``a, b : INT`` gives two, sharing type and init). type: a type node. init: an expression,
    ArrayInit or StructInit, or None. address: ``%IX0.0`` text or None. attributes: dict as for Pou."""

    __slots__ = ("name", "type", "init", "address", "attributes")


class TypeDecl(Node):
    """TYPE name : type := init; END_TYPE (one node per name)."""

    __slots__ = ("name", "name_start", "type", "init", "attributes")


class Configuration(Node):
    """CONFIGURATION ... END_CONFIGURATION. sections, tasks, programs: of it and of its resources (their names)."""

    __slots__ = ("name", "sections", "tasks", "programs", "resources")


class Task(Node):
    """TASK name (INTERVAL := T#1ms, PRIORITY := 1). properties: dict of upper-case name to expression."""

    __slots__ = ("name", "properties")


class ProgramInstance(Node):
    """PROGRAM name WITH task : type (inits). task and inits may be None and []."""

    __slots__ = ("name", "task", "type_name", "inits")


# --------------------------------------------------------------------------------------------------- types


class NamedType(Node):
    """INT, TON, MyStruct, Lib.Type. args: the call-style initialiser of ``fb : Blk(a := 1)``, list of Arg or None."""

    __slots__ = ("name", "args")


class StringType(Node):
    """STRING, STRING(80), STRING[80], WSTRING. length: an expression or None."""

    __slots__ = ("wide", "length")


class ArrayOf(Node):
    """dims: list of (low expression, high expression); [None] entries for ARRAY[*]."""

    __slots__ = ("dims", "element")


class PointerTo(Node):
    __slots__ = ("target",)


class ReferenceTo(Node):
    __slots__ = ("target",)


class Subrange(Node):
    """INT (low..high). base: a type name."""

    __slots__ = ("base", "low", "high")


class EnumDef(Node):
    """(a, b := 5, c) base. items: list of (name, offset, expression or None). base: a type name or None."""

    __slots__ = ("items", "base")


class StructDef(Node):
    """fields_: list of VarDecl. extends: a type name or None."""

    __slots__ = ("fields_", "extends")


class UnionDef(Node):
    __slots__ = ("fields_",)


# --------------------------------------------------------------------------------------------- initialisers


class ArrayInit(Node):
    """[1, 2, 3(0)] or the bare list ``1, 2, 3(0)``. items: list of (count expression or None, value or None)."""

    __slots__ = ("items",)


class StructInit(Node):
    """(a := 1, b := 2). items: list of Arg."""

    __slots__ = ("items",)


# ---------------------------------------------------------------------------------------------- statements


class Assign(Node):
    """op: ':=', 'S=', 'R=', 'REF='. value may itself be an Assign (a := b := c)."""

    __slots__ = ("target", "op", "value", "type", "const", "symbol")


class ExprStmt(Node):
    """A call, or a bare name that calls an action or a program."""

    __slots__ = ("expr",)


class If(Node):
    """branches: list of (condition, body); orelse: a body or None."""

    __slots__ = ("branches", "orelse")


class Case(Node):
    """branches: list of (labels, body); a label is an expression or a Range. orelse: a body or None."""

    __slots__ = ("selector", "branches", "orelse")


class Range(Node):
    __slots__ = ("low", "high")


class For(Node):
    """FOR var := first TO last BY step DO body; step None means 1. var: an expression."""

    __slots__ = ("var", "first", "last", "step", "body")


class While(Node):
    __slots__ = ("condition", "body")


class Repeat(Node):
    __slots__ = ("body", "condition")


class Exit(Node):
    __slots__ = ()


class Continue(Node):
    __slots__ = ()


class Return(Node):
    __slots__ = ()


class Label(Node):
    __slots__ = ("name",)


class Jump(Node):
    __slots__ = ("name",)


# --------------------------------------------------------------------------------------------- expressions


class Literal(Node):
    """value by type_name: None -> int or float (untyped number); BOOL -> bool; STRING, WSTRING -> str (escapes
    resolved); TIME, LTIME -> int nanoseconds; DATE, DT -> int seconds since 1970-01-01; TOD -> int
    milliseconds; LDATE, LDT, LTOD -> int nanoseconds; any other elementary type name (typed literal INT#5,
    WORD#16#FF, REAL#1.5) -> int or float.
    text: as written, for messages."""

    __slots__ = ("value", "type_name", "text", "type", "const", "symbol")


class Name(Node):
    __slots__ = ("name", "type", "const", "symbol")


class Address(Node):
    """A direct address: text '%IX0.3' (upper case)."""

    __slots__ = ("text", "type", "const", "symbol")


class Member(Node):
    """base.name. name_start: offset of the name. Also Type#Value and GVL.x; the checker tells which."""

    __slots__ = ("base", "name", "name_start", "type", "const", "symbol")


class Part(Node):
    """Bit and partial access: base.9 (size 'X', index 9), base.%B1, base.%W0, base.%D1. index: int, or a Name
    (a constant) for base.bitName, which the checker turns a Member into."""

    __slots__ = ("base", "size", "index", "type", "const", "symbol")


class Index(Node):
    __slots__ = ("base", "indices", "type", "const", "symbol")


class Deref(Node):
    __slots__ = ("base", "type", "const", "symbol")


class Unary(Node):
    """op: '-', '+', 'NOT'."""

    __slots__ = ("op", "operand", "type", "const", "symbol")


class Binary(Node):
    """op: + - * / MOD ** = <> < <= > >= AND OR XOR AND_THEN OR_ELSE ('&' is AND)."""

    __slots__ = ("op", "left", "right", "type", "const", "symbol")


class Call(Node):
    """callee(args). callee: Name, Member, Index, Deref, ..."""

    __slots__ = ("callee", "args", "type", "const", "symbol")


class Arg(Node):
    """name := value, name => value (output TRUE), or value (name None). value None: written but left empty
    (``Axis:= ,``), which means not connected. negated: ``Q => NOT x``."""

    __slots__ = ("name", "value", "output", "negated")

"""The types of ST, with their layout in the memory image.

Sizes and alignment are those of C on a 32-bit machine: what ADR, SIZEOF and MEMCPY of a CoDeSys program expect.
TIME is 32-bit milliseconds, LTIME 64-bit nanoseconds; DATE and DT are seconds since 1970 in 32 bits, TOD is
milliseconds since midnight (reference/semantics.md). A pointer is a 32-bit offset into the image.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field


class Type:
    """A type: name as ST writes it, size and alignment in bytes."""

    name: str
    size: int
    align: int

    def __str__(self) -> str:
        return self.name


@dataclass(eq=False, slots=True, repr=False)
class Elementary(Type):
    """INT, LREAL, BOOL, TIME, ... kind: 'bool', 'int', 'bits', 'real', 'time', 'date', 'char'.

    wasm: the WebAssembly type that holds a value ('i32', 'i64', 'f32', 'f64').
    access: suffix of its load and store instructions ('8_u', '16_s', '' ...).
    """

    name: str
    kind: str
    size: int
    signed: bool = False
    align: int = 0
    wasm: str = ""
    access: str = ""
    bits: int = 0
    low: int = 0
    high: int = 0

    def __post_init__(self) -> None:
        self.align = self.size
        self.wasm = ("f" if self.kind == "real" else "i") + ("64" if self.size == 8 else "32")
        self.access = f"{self.size * 8}_{'s' if self.signed else 'u'}" if self.size < 4 else ""
        self.bits = 1 if self.kind == "bool" else self.size * 8
        self.low = -(1 << (self.size * 8 - 1)) if self.signed else 0
        self.high = 1 if self.kind == "bool" else (1 << (self.size * 8 - self.signed)) - 1

    def __reduce__(self):
        return _elementary, (self.name,)


def _elementary(name: str) -> Elementary:
    return ELEMENTARY[name]


ELEMENTARY: dict[str, Elementary] = {
    t.name: t
    for t in (
        Elementary("BOOL", "bool", 1),
        Elementary("SINT", "int", 1, True),
        Elementary("INT", "int", 2, True),
        Elementary("DINT", "int", 4, True),
        Elementary("LINT", "int", 8, True),
        Elementary("USINT", "int", 1),
        Elementary("UINT", "int", 2),
        Elementary("UDINT", "int", 4),
        Elementary("ULINT", "int", 8),
        Elementary("BYTE", "bits", 1),
        Elementary("WORD", "bits", 2),
        Elementary("DWORD", "bits", 4),
        Elementary("LWORD", "bits", 8),
        Elementary("REAL", "real", 4, True),
        Elementary("LREAL", "real", 8, True),
        Elementary("TIME", "time", 4),
        Elementary("LTIME", "time", 8, True),
        Elementary("DATE", "date", 4),
        Elementary("TOD", "date", 4),
        Elementary("DT", "date", 4),
        Elementary("LDATE", "date", 8, True),
        Elementary("LTOD", "date", 8, True),
        Elementary("LDT", "date", 8, True),
        Elementary("CHAR", "char", 1),
        Elementary("WCHAR", "char", 2),
        # what a constant is before its context fixes it; never the type of a variable
        Elementary("ANY_INT", "literal", 8, True),
        Elementary("ANY_REAL", "literal", 8, True),
        Elementary("NULL", "literal", 4),
        Elementary("?", "error", 4),  # of an expression that was reported; goes with every type
    )
}
ALIASES = {
    "TIME_OF_DAY": "TOD", "DATE_AND_TIME": "DT", "LTIME_OF_DAY": "LTOD", "LDATE_AND_TIME": "LDT",
    "PVOID": "DWORD", "XINT": "DINT", "XWORD": "DWORD", "UXINT": "UDINT", "__XWORD": "DWORD", "__XINT": "DINT",
    "__UXINT": "UDINT", "BIT": "BOOL",
}  # fmt: skip

BOOL, SINT, INT, DINT, LINT = (ELEMENTARY[n] for n in ("BOOL", "SINT", "INT", "DINT", "LINT"))
USINT, UINT, UDINT, ULINT = (ELEMENTARY[n] for n in ("USINT", "UINT", "UDINT", "ULINT"))
BYTE, WORD, DWORD, LWORD = (ELEMENTARY[n] for n in ("BYTE", "WORD", "DWORD", "LWORD"))
REAL, LREAL, TIME, LTIME = (ELEMENTARY[n] for n in ("REAL", "LREAL", "TIME", "LTIME"))
INT_LITERAL, REAL_LITERAL, NULL, ERROR = (ELEMENTARY[n] for n in ("ANY_INT", "ANY_REAL", "NULL", "?"))


@dataclass(eq=False, slots=True, repr=False)
class String(Type):
    """STRING(length) or WSTRING(length): length characters and a closing zero."""

    length: int = 80
    wide: bool = False
    name: str = ""
    size: int = 0
    align: int = 1

    def __post_init__(self) -> None:
        unit = 2 if self.wide else 1
        self.name = f"{'W' if self.wide else ''}STRING({self.length})"
        self.size = (self.length + 1) * unit
        self.align = unit


@dataclass(eq=False, slots=True, repr=False)
class Array(Type):
    """bounds: (low, high) of each dimension; [] for ARRAY[*], then open is the number of dimensions and the bounds
    come with the call."""

    element: Type
    bounds: list[tuple[int, int]]
    open: int = 0
    name: str = ""
    size: int = 0
    align: int = 1

    def __post_init__(self) -> None:
        dims = ", ".join(f"{a}..{b}" for a, b in self.bounds) or ", ".join("*" * self.open)
        self.name = f"ARRAY[{dims}] OF {self.element.name}"
        self.size = self.element.size if self.bounds else 0
        for a, b in self.bounds:
            self.size *= max(b - a + 1, 0)
        self.align = self.element.align

    def number_of(self, indices: Iterable[int]) -> int:
        """The number of the element with these indices, from 0, where they are within the bounds."""
        number = 0
        for index, (low, high) in zip(indices, self.bounds, strict=True):
            number = number * (high - low + 1) + index - low
        return number


@dataclass(eq=False, slots=True, repr=False)
class Pointer(Type):
    """POINTER TO target, or REFERENCE TO target (reference=True)."""

    target: Type
    reference: bool = False
    name: str = ""
    size: int = 4
    align: int = 4

    def __post_init__(self) -> None:
        self.lead_to(self.target)

    def lead_to(self, target: Type) -> None:
        """Set the target, of a pointer that was made before it."""
        self.target = target
        self.name = f"{'REFERENCE' if self.reference else 'POINTER'} TO {target.name}"


@dataclass(eq=False, slots=True, repr=False)
class Enum(Type):
    """values: spelling -> number, in order; index: upper-case name -> number."""

    name: str
    base: Elementary
    values: dict[str, int]
    size: int = 0
    align: int = 0

    def __post_init__(self) -> None:
        self.size, self.align = self.base.size, self.base.align

    def label(self, number: int) -> str | None:
        return next((n for n, v in self.values.items() if v == number), None)


@dataclass(eq=False, slots=True, repr=False)
class SubrangeType(Type):
    """base(low..high): stored as base."""

    name: str
    base: Elementary
    low: int
    high: int
    size: int = 0
    align: int = 0

    def __post_init__(self) -> None:
        self.size, self.align = self.base.size, self.base.align


@dataclass(eq=False, slots=True, repr=False)
class Field:
    """A member of a STRUCT, UNION, FUNCTION_BLOCK or PROGRAM at a byte offset of its instance.

    section: VAR, VAR_INPUT, VAR_OUTPUT, VAR_IN_OUT (a pointer in the instance), VAR_TEMP, VAR_STAT; 'FIELD' for a
    structure. For VAR_STAT the offset is absolute.
    """

    name: str
    type: Type
    offset: int
    section: str = "FIELD"
    constant: bool = False
    retain: bool = False
    persistent: bool = False
    attributes: dict = field(default_factory=dict)

    @property
    def by_reference(self) -> bool:
        return self.section == "VAR_IN_OUT"

    @property
    def also(self) -> str:
        """Its second name in upper case: the standard's, where CODESYS has another."""
        return self.attributes.get("also", "").upper()


@dataclass(eq=False, slots=True, repr=False)
class Struct(Type):
    """A STRUCT or UNION. members: upper-case name -> Field, in order."""

    name: str
    members: dict[str, Field]
    union: bool = False
    size: int = 0
    align: int = 1


@dataclass(eq=False, slots=True, repr=False)
class Block(Type):
    """A FUNCTION_BLOCK or PROGRAM as the type of its instances: a structure with code.

    kind: 'FUNCTION_BLOCK' or 'PROGRAM'. members in order of declaration, those of the base first. size is 4 at least,
    so that two instances never share an address. base: the block that it EXTENDS. interfaces: those that it
    IMPLEMENTS itself. number: what its instances begin with where a call may have to find out whose they are
    (stcore/objects.py); 0 where they have no such word.
    """

    name: str
    kind: str
    members: dict[str, Field] = field(default_factory=dict)
    size: int = 0
    align: int = 4
    file: str = ""
    attributes: dict = field(default_factory=dict)
    base: Block | None = None
    interfaces: list[Interface] = field(default_factory=list)
    number: int = 0

    def extends(self, other: Type) -> bool:
        """True if it is the other block or extends it, maybe over others."""
        block = self
        while block is not None and block is not other:
            block = block.base
        return block is not None

    def implements(self, interface: Interface) -> bool:
        """True if its instances may stand for the interface."""
        own = any(i.extends(interface) for i in self.interfaces)
        return own or self.base is not None and self.base.implements(interface)


@dataclass(eq=False, slots=True, repr=False)
class Interface(Pointer):
    """An INTERFACE as the type of variables: the address of an instance of a block that implements it, or 0.

    target: a block without members that stands for it. bases: the interfaces that it extends.
    """

    bases: list[Interface] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.name = self.target.name

    def extends(self, other: Type) -> bool:
        """True if it is the other interface or extends it, maybe over others."""
        return self is other or any(b.extends(other) for b in self.bases)


def base_of(t: Type) -> Type:
    """The elementary type that stores an ENUM or a subrange; any other type unchanged."""
    kind = t.__class__  # asked for every expression: quicker than isinstance
    return t.base if kind is Enum or kind is SubrangeType else t


def is_aggregate(t: Type) -> bool:
    """True for what is passed and copied as bytes: strings, arrays, structures, instances."""
    return t.__class__ in _AGGREGATES


_AGGREGATES = frozenset((String, Array, Struct, Block))

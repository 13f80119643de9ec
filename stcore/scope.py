"""Symbols: what a name of a program can stand for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from stcore import syntax as s
from stcore.source import Source
from stcore.types import Block, Enum, Type


@dataclass(eq=False, slots=True)
class Var:
    """A variable, wherever it lives.

    storage: 'global' (address is absolute), 'this' (address is the offset in the instance of its block), 'local' (of a
    function, or VAR_TEMP: the emitter chooses a WebAssembly local or the stack frame), 'area' (at a direct address:
    area 'I', 'Q' or 'M', address in bytes within it).
    indirect: what is stored is the address of the variable (VAR_IN_OUT, a string passed without a copy).
    const: the value of a constant that is known at compile time.
    written, addressed: found by the checker; they let the emitter keep a variable out of memory.
    """

    name: str
    type: Type
    storage: str
    address: int = 0
    section: str = "VAR"
    indirect: bool = False
    constant: bool = False
    const: object = None
    retain: bool = False
    persistent: bool = False
    written: bool = False
    addressed: bool = False
    read_only: str = ""  # why an assignment is refused; '' if it is not
    area: str = ""
    bit: int | None = None
    owner: Pou | None = None
    init: Init | None = None
    decl: s.VarDecl | None = None
    source: Source | None = None
    library: bool = False
    also: str = ""  # a second name as a parameter, upper case
    room_of: str = ""  # the pointer, upper case, of which the compiler gives the room (stcore/check/room.py)


@dataclass(eq=False, slots=True)
class Init:
    """An initial value as written, with what is needed to understand its names."""

    node: s.Node
    source: Source
    pou: Pou | None = None
    library: bool = False  # its names are those of the library
    value: object = None  # the checked expression
    checked: bool = False


@dataclass(eq=False, slots=True)
class Pou:
    """A PROGRAM, FUNCTION, FUNCTION_BLOCK, INTERFACE, or a METHOD of one (GET, SET: an accessor of a property).

    type: the Block of its instances (None for a function), of a method that of its block. variables: upper-case name
    -> Var. parameters: the inputs, in-outs and outputs in order of declaration. result: the variable of a function's
    name. bindings: what the type names of a generic function stand for in this instance of it. uses: the POUs and
    globals that its code needs. calls: how many places call it. holder: the block, program or interface whose method
    it is. base: the block that it EXTENDS. interfaces: those that it IMPLEMENTS; of an interface those that it EXTENDS.
    methods: its own, accessors as NAME.GET and NAME.SET (stcore/objects.py).
    """

    kind: str
    name: str
    tree: s.Pou
    source: Source
    library: bool = False
    type: Block | None = None
    variables: dict[str, Var] = field(default_factory=dict)
    parameters: list[Var] = field(default_factory=list)
    result: Var | None = None
    bindings: dict[str, Type] = field(default_factory=dict)
    enum_names: dict[str, EnumValue] = field(default_factory=dict)  # of enumerations declared in a variable
    edges: dict[str, Var] = field(default_factory=dict)  # input with R_EDGE or F_EDGE -> what the body sees of it
    later: dict[str, Callable[[], None]] = field(default_factory=dict)  # declares a constant that stands further down
    actions: dict[str, s.Action] = field(default_factory=dict)
    holder: Pou | None = None
    base: Pou | None = None
    interfaces: list[Pou] = field(default_factory=list)
    methods: dict[str, Pou] = field(default_factory=dict)
    attributes: dict[str, str] = field(default_factory=dict)
    uses: set[Pou] = field(default_factory=set)
    address: int | None = None  # of a program's instance
    checked: bool = False
    calls: int = 0
    writes_outside: bool = False
    writes_instance: bool = False  # the instance whose method it is may change while it runs
    symbol: str = ""  # its name in the module
    serial: int = 0

    @property
    def external(self) -> bool:
        return "external" in self.attributes

    @property
    def is_called(self) -> bool:
        """True for a function and a method: called with arguments, its variables are new for each call."""
        return self.kind == "FUNCTION" or self.holder is not None

    @property
    def full_name(self) -> str:
        """As messages name it: Block.Method, Block.Property.GET."""
        if self.holder is None:
            return self.name
        return f"{self.holder.name}.{self.name}{'' if self.kind == 'METHOD' else '.' + self.kind}"

    def chain(self) -> Iterator[Pou]:
        """It and the blocks that it extends, or the interfaces."""
        yield self
        if self.base is not None:
            yield from self.base.chain()
        if self.kind == "INTERFACE":
            for interface in self.interfaces:
                yield from interface.chain()

    @property
    def incomplete(self) -> bool:
        """True if the name of what it extends or implements means nothing, which has been said."""
        own = self.tree.extends is not None and self.base is None or len(self.tree.implements) > len(self.interfaces)
        return own or any(p.incomplete for p in (self.base, self.holder) if p is not None)

    def method(self, name: str) -> Pou | None:
        """Its own or inherited method of an upper-case name (accessors: NAME.GET, NAME.SET)."""
        return next((p.methods[name] for p in self.chain() if name in p.methods), None)

    def action(self, name: str) -> ActionOf | None:
        """Its own or inherited action of an upper-case name."""
        return next((ActionOf(p, p.actions[name]) for p in self.chain() if name in p.actions), None)

    def inputs(self) -> list[Var]:
        """What the code of a function takes, in order: inputs and in-outs."""
        return [p for p in self.parameters if p.section != "VAR_OUTPUT"]

    def arguments(self) -> list[Var]:
        """What a positional call fills, in order: of these, all but what the compiler itself gives."""
        return [p for p in self.inputs() if not p.room_of]


@dataclass(eq=False, slots=True)
class TypeName:
    """The name of a type where an expression may stand: SIZEOF(T), T#Value."""

    type: Type
    pou: Pou | None = None


@dataclass(eq=False, slots=True)
class EnumValue:
    type: Enum
    number: int


@dataclass(eq=False, slots=True)
class GlobalList:
    """A list of global variables as a name before a dot: GVL.x."""

    name: str
    variables: set[str]  # upper-case


@dataclass(eq=False, slots=True)
class Builtin:
    """A function that the compiler itself provides (stcore/check/builtins.py)."""

    name: str


@dataclass(eq=False, slots=True)
class BuiltinCall:
    """A checked call of a built-in function: operation type and arguments, in order."""

    name: str
    kind: Type
    args: list[s.Node]


@dataclass(eq=False, slots=True)
class ActionOf:
    """An action of a program or block: `base` is the instance expression, None for the running one."""

    pou: Pou
    action: s.Action
    base: s.Node | None = None


@dataclass(eq=False, slots=True)
class MethodOf:
    """A method of a block or interface: `base` is the instance expression, None for the running one. fixed: it is this
    one whatever the instance is of: SUPER^.m()."""

    pou: Pou
    base: s.Node | None = None
    fixed: bool = False


@dataclass(eq=False, slots=True)
class PropertyOf:
    """A property as `MethodOf` is a method; an accessor that it lacks is None."""

    name: str
    getter: Pou | None
    setter: Pou | None
    base: s.Node | None = None
    fixed: bool = False


def member_of(pou: Pou, name: str, base: s.Node | None = None) -> MethodOf | PropertyOf | None:
    """The method or property of a block or interface that has this upper-case name."""
    fixed = isinstance(base, s.Deref) and base.base.symbol == "super"
    method = pou.method(name)
    if method is not None:
        return MethodOf(method, base, fixed)
    getter, setter = pou.method(f"{name}.GET"), pou.method(f"{name}.SET")
    if getter is None and setter is None:
        return None
    return PropertyOf((getter or setter).name, getter, setter, base, fixed)


class Convert(s.Node):
    """An implicit conversion that the checker put into the tree: the operand's value as `type`."""

    __slots__ = ("operand", "type", "const", "symbol")


class Pinned(s.Node):
    """A place whose address the emitter has worked out already: where it is, and an offset from there."""

    __slots__ = ("base", "offset", "type", "const", "symbol")


def place_node(at: s.Node, var: Var) -> s.Name:
    """A variable as an expression that has been checked, standing at the place of another node."""
    node = s.Name(at.start, at.end, var.name)
    node.symbol, node.type = var, var.type
    return node


def key(name: str) -> str:
    """The form in which names are compared: ST does not tell upper from lower case."""
    return name.upper()

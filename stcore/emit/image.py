"""The first memory image: the initial value of every variable, as bytes."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from stcore import syntax as s
from stcore import types as t
from stcore.check.initial import check_init
from stcore.scope import Pou, Var, key

_FORMAT = {1: "<B", 2: "<H", 4: "<I", 8: "<Q"}


@dataclass(eq=False, slots=True)
class InitCall:
    """A call of FB_init for an instance. given: what its declaration says, by upper-case name of the input."""

    method: Pou
    given: dict[str, s.Node]


@dataclass(slots=True)
class Late:
    """An initial value that only the running program can work out: ADR(x), a function's result, another variable; or
    the call of FB_init of the instance at this offset."""

    offset: int
    type: t.Type
    node: s.Node | InitCall
    pou: Pou | None
    owner: int  # offset of the instance whose names the expression uses
    source: object = None


def encode(value: object, kind: t.Type) -> bytes:
    """A constant as the bytes of a type."""
    base = t.base_of(kind)
    if isinstance(base, t.String):
        return encode_text(value, base.wide, base.length).ljust(base.size, b"\0")
    if isinstance(base, t.Elementary) and base.kind == "real":
        return struct.pack("<d" if base.size == 8 else "<f", value)
    if isinstance(value, str):
        value = ord(value)
    return struct.pack(_FORMAT[base.size], int(value) & ((1 << base.size * 8) - 1))


def encode_text(text: str, wide: bool, length: int | None = None) -> bytes:
    """Latin-1 where that holds the text, else UTF-8; UTF-16 for WSTRING. Cut to length units."""
    if wide:
        data = text.encode("utf-16-le", "surrogatepass")
        return data if length is None else data[: 2 * length]
    try:
        data = text.encode("latin-1")
    except UnicodeEncodeError:
        data = text.encode("utf-8")
    return data if length is None else data[:length]


class ImageBuilder:
    """Builds initial bytes for types and variables; what is not constant is kept as Late."""

    def __init__(self, project) -> None:
        self.project = project
        self._blocks: dict[t.Type, tuple[bytes, list[Late]]] = {}
        self._open: set[t.Array] = set()  # arrays whose default is being made

    def of_type(self, kind: t.Type) -> tuple[bytes, list[Late]]:
        """The default of a type."""
        if isinstance(kind, t.Array):
            if kind in self.project.array_inits and kind not in self._open:
                return self._default_array(kind)
            data, late = self._element(kind)
            count = kind.size // kind.element.size if kind.element.size else 0
            if not any(data):
                data = b""
            moved = [_moved(x, i * kind.element.size) for i in range(count) for x in late]
            return (data * count).ljust(kind.size, b"\0"), moved
        if isinstance(kind, t.Struct | t.Block):
            if kind not in self._blocks:
                self._blocks[kind] = self._members(kind)
            return self._blocks[kind]
        if isinstance(kind, t.Enum) and 0 not in kind.values.values() and kind.values:
            return encode(next(iter(kind.values.values())), kind), []
        if isinstance(kind, t.SubrangeType) and not kind.low <= 0 <= kind.high:
            return encode(kind.low, kind), []
        return bytes(kind.size), []

    def _default_array(self, kind: t.Array) -> tuple[bytes, list[Late]]:
        """What the named type of an array says; what it leaves out is as its elements are."""
        init = self.project.array_inits[kind]
        self._open.add(kind)
        made = self.value(check_init(self.project, init, kind), kind, init)
        self._open.discard(kind)
        return made

    def _element(self, kind: t.Array) -> tuple[bytes, list[Late]]:
        init = self.project.element_inits.get(kind)
        if init is None:
            return self.of_type(kind.element)
        return self.value(check_init(self.project, init, kind.element), kind.element, init)

    def _members(self, kind: t.Struct | t.Block) -> tuple[bytes, list[Late]]:
        image, late = bytearray(kind.size), []
        for field in kind.members.values():
            if field.section in ("VAR_STAT", "VAR_IN_OUT"):
                continue
            data, inner = self.of_field(field)
            if any(data) or not getattr(kind, "union", False):
                image[field.offset : field.offset + len(data)] = data
            late += [_moved(x, field.offset) for x in inner]
        if getattr(kind, "number", 0):
            image[:4] = struct.pack("<I", kind.number)
        if isinstance(kind, t.Block):
            chain = reversed([*self.project.block_pous[kind].chain()])  # the base is the first
            methods = [pou.methods["FB_INIT"] for pou in chain if "FB_INIT" in pou.methods]
            late += [Late(0, kind, InitCall(m, {}), None, 0, m.source) for m in methods]
        return bytes(image), late

    def of_field(self, field: t.Field) -> tuple[bytes, list[Late]]:
        init = self.project.field_inits.get(field)
        if init is None:
            return self.of_type(field.type)
        node = check_init(self.project, init, field.type)
        data, late = self.value(node, field.type, init)
        for x in late:
            if x.pou is init.pou and x.pou is not None:
                x.owner -= field.offset  # its names are those of the instance around the field
        return data, late

    def of_variable(self, var: Var) -> tuple[bytes, list[Late]]:
        if var.init is None:
            return self.of_type(var.type)
        return self.value(check_init(self.project, var.init, var.type), var.type, var.init)

    def value(self, node: s.Node, kind: t.Type, init) -> tuple[bytes, list[Late]]:
        """A checked initial value as bytes."""
        if isinstance(node, s.ArrayInit):
            return self._array(node, kind, init)
        if isinstance(node, s.StructInit):
            return self._struct(node, kind, init)
        if node.type is t.ERROR:
            return bytes(kind.size), []
        if node.const is not None:
            return encode(node.const, kind), []
        data, late = self.of_type(kind)
        return data, [Late(0, kind, node, init.pou, 0, init.source)]

    def _array(self, node: s.ArrayInit, kind: t.Array, init) -> tuple[bytes, list[Late]]:
        if not isinstance(kind, t.Array):
            return bytes(kind.size), []
        default, default_late = self.of_type(kind)
        image, late, at = bytearray(default), [], 0
        size = kind.element.size
        covered = 0
        for count, value in node.items:
            if value is None:
                at += count * size
                continue
            data, inner = self.value(value, kind.element, init)
            for _ in range(count):
                if at + size > kind.size:
                    break
                image[at : at + size] = data
                late += [_moved(x, at) for x in inner]
                at += size
            covered = at
        return bytes(image), late + [x for x in default_late if x.offset >= covered]

    def _struct(self, node: s.StructInit, kind: t.Type, init) -> tuple[bytes, list[Late]]:
        default, late = self.of_type(kind)
        image, late = bytearray(default), list(late)
        calls = [x for x in late if isinstance(x.node, InitCall) and x.offset == 0 and x.type is kind]
        if calls:
            return self._initialised(node, kind, init, calls)
        for field, value in node.items:
            data, inner = self.value(value, field.type, init)
            image[field.offset : field.offset + len(data)] = data
            inside = range(field.offset, field.offset + field.type.size)
            late = [x for x in late if x.offset not in inside] + [_moved(x, field.offset) for x in inner]
        return bytes(image), sorted(late, key=lambda x: x.offset)  # the order of declaration


    def _initialised(self, node: s.StructInit, kind: t.Block, init, calls: list[Late]) -> tuple[bytes, list[Late]]:
        """An instance with FB_init and initial values of its own: those are set when FB_init is done, as in CODESYS."""
        data, late = self.of_type(kind)
        given = {key(x.name): value for x, value in node.items if isinstance(x, Var)}
        late = [x for x in late if x not in calls]
        late += [Late(0, kind, InitCall(x.node.method, given), init.pou, 0, init.source) for x in calls]
        for field, value in node.items:
            if not isinstance(field, Var):
                late.append(Late(field.offset, field.type, value, init.pou, 0, init.source))
        return data, late


def _moved(late: Late, by: int) -> Late:
    return Late(late.offset + by, late.type, late.node, late.pou, late.owner + by, late.source)

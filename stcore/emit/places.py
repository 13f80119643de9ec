"""Where variables live: base address and constant offset of every place that an expression can name."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.check.room import whole
from stcore.emit.copies import Copies
from stcore.emit.values import address, load
from stcore.scope import Convert, Pinned, Pou, Var

FRAME = "(local.get $fp)"


class Places(Copies):
    """Addresses of places. `place` gives (base, offset): base '' when the address is a constant."""

    def place(self, node: s.Node) -> tuple[str, int]:
        match node:
            case s.Name() | s.Address():
                if isinstance(node.symbol, Pou):
                    own = node.symbol is self.pou and self.static_base is not None  # one of several instances
                    return "", self.static_base if own else node.symbol.address
                return self.var_place(node.symbol, node)
            case s.Member():
                return self._member(node)
            case s.Index():
                return self._index(node)
            case s.Deref():
                if node.base.symbol in ("this", "super"):
                    return self.this_place()
                return self.deref_check(node.base), 0
            case s.Part():
                return self.place(node.base)
            case Convert():
                return self.place(node.operand)
            case Pinned():
                return node.base, node.offset
        return self.value(node), 0  # a result: its address

    def pinned(self, node: s.Node) -> s.Node:
        """The same place, with its address worked out here, once, if it takes more than a constant."""
        if isinstance(node, s.Part):
            made = s.Part(node.start, node.end, self.pinned(node.base), node.size, node.index)
        elif isinstance(node, s.Name | s.Address):
            return node
        else:
            base, offset = self.place(node)
            if base in ("", "(local.get $this)", FRAME):
                return node
            name = self.keep("i32")
            self.line(f"(local.set {name} {base})")
            made = Pinned(node.start, node.end, f"(local.get {name})", offset)
        made.type = node.type
        return made

    def take_address(self, node: s.Node) -> None:
        """ADR: note where the variable lies, if that is the same at every time."""
        outer = inner = whole(node)
        while isinstance(inner, s.Member):
            inner = inner.base
        if isinstance(inner, s.Name) and not isinstance(inner.symbol, Pou):
            base, offset = self.place(outer)
            if not base:
                self.module.addressed.add((offset, offset + outer.type.size))

    def own_taken(self) -> list[tuple[Var, tuple[str, int]]]:
        """The variables of this instance, or of this call of a function, whose address is taken, with their places."""
        taken = [v for v in self.pou.variables.values() if v.addressed and not v.indirect]
        return [(v, self.var_place(v)) for v in taken if v.storage == "this" or v in self.frame_of]

    def this_place(self) -> tuple[str, int]:
        """The instance whose code this is."""
        return self.this

    def this_address(self) -> str:
        return address(*self.this_place())

    def var_place(self, var: Var, node: s.Node | None = None) -> tuple[str, int]:
        """A variable in memory. node: where it is used."""
        if var.storage == "global":
            base, offset = "", var.address
        elif var.storage == "area":
            return "", self.module.areas[var.area] + var.address
        elif var.storage == "this":
            base, offset = self.this_place()
            offset += var.address
        elif var.indirect:
            return f"(local.get {self.locals_of[var]})", 0
        else:
            base, offset = FRAME, self.frame_of[var]
        if var.indirect:
            pointer = self.in_out_locals.get(var)
            if pointer is None and node is not None and self.pou.holder is not None:
                # a method may be called before the block ever was
                return self.checked_address(load(t.DWORD, base, offset), node), 0
            return (f"(local.get {pointer})" if pointer else load(t.DWORD, base, offset)), 0
        return base, offset

    def _member(self, node: s.Member) -> tuple[str, int]:
        field = node.symbol
        if isinstance(field, Var):
            return self.var_place(field)
        if field.section == "VAR_STAT":
            return "", field.offset
        base, offset = self.place(node.base)
        offset += field.offset
        if field.by_reference:
            return load(t.DWORD, base, offset), 0
        return base, offset

    def _index(self, node: s.Index) -> tuple[str, int]:
        kind = node.base.type
        if isinstance(kind, t.Pointer):
            return self._pointer_index(node)
        if isinstance(kind, t.String):
            return self._character(node, kind)
        base, offset = self.place(node.base)
        if kind.open:
            text = self._open_offset(node, kind)
            return (f"(i32.add {base} {text})" if base else text), offset
        text, fixed = self.offset_of(node, kind)
        offset += fixed
        if text:
            if offset < 0:  # a load's own offset can't be negative
                text, offset = f"(i32.add {text} (i32.const {offset}))", 0
            base = f"(i32.add {base} {text})" if base else text
        return base, offset

    def _stride(self, index: s.Node, size: int) -> str:
        text = self.value(index)
        return text if size == 1 else f"(i32.mul {text} (i32.const {size}))"

    def _pointer_index(self, node: s.Index) -> tuple[str, int]:
        """p[i]: the i-th element from where p points to (CODESYS)."""
        index = node.indices[0]
        text = f"(i32.add {self.value(node.base)} {self._stride(index, node.type.size)})"
        return self.checked_address(text, node), 0

    def _character(self, node: s.Index, kind: t.String) -> tuple[str, int]:
        """s[i], from 0; the closing zero may be read."""
        base, offset = self.place(node.base)
        index = node.indices[0]
        unit = 2 if kind.wide else 1
        generic = isinstance(node.base.symbol, Var) and node.base.symbol.indirect
        if isinstance(index.const, int):
            return base, offset + index.const * unit
        text = self.value(index) if generic else self._checked_index(index, 0, kind.length)
        if unit == 2:
            text = f"(i32.shl {text} (i32.const 1))"
        return (f"(i32.add {base} {text})" if base else text), offset

    def bounds_of(self, node: s.Node) -> list[tuple[str, str]]:
        """Low and high bound of each dimension of an array, as values."""
        kind, var = node.type, node.symbol
        if not kind.open:
            return [(f"(i32.const {low})", f"(i32.const {high})") for low, high in kind.bounds]
        if var in self.open_locals:
            return [(f"(local.get {low})", f"(local.get {high})") for low, high in self.open_locals[var]]
        base, offset = self.this_place()
        offset += var.address + 4
        return [tuple(load(t.DINT, base, offset + 8 * d + at) for at in (0, 4)) for d in range(kind.open)]

    def _open_offset(self, node: s.Index, kind: t.Array) -> str:
        """Byte offset of an element of ARRAY[*]."""
        text = ""
        for index, (low, high) in zip(node.indices, self.bounds_of(node.base), strict=True):
            length = f"(i32.add (i32.sub {high} {low}) (i32.const 1))"
            checked = self._checked_between(index, low, high, length)
            text = f"(i32.add (i32.mul {text} {length}) {checked})" if text else checked
        return f"(i32.mul {text} (i32.const {kind.element.size}))"

    def _checked_between(self, index: s.Node, low: str, high: str, length: str) -> str:
        """index - low, or the fault F0101."""
        temp = self.temp("i32")
        mark = self.marker(index, "F0101", self.source.text[index.start : index.end])
        again = f"(i32.add (local.get {temp}) {low})"
        return (
            f"(block (result i32) (if (i32.ge_u (local.tee {temp} (i32.sub {self.value(index)} {low})) {length})"
            f" (then {mark} (call $fault_index {again} {low} {high}) unreachable)) (local.get {temp}))"
        )

"""Initial values: checked against the types they are for."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.check.conversions import Conversions
from stcore.scope import Init, Var, key


class Initials(Conversions):
    """Checks what declarations say of initial values."""

    def initial_values(self) -> None:
        """Of every variable of the POU, and of the fields of the types they have."""
        for var in self.pou.variables.values():
            if var.owner is self.pou and var.init is not None:
                check_init(self.project, var.init, var.type)

    def initial(self, node: s.Node, kind: t.Type) -> s.Node:
        """An initial value for a variable of `kind`: an expression, ArrayInit or StructInit."""
        if isinstance(node, s.ArrayInit):
            return self._array(node, kind)
        if isinstance(node, s.StructInit):
            return self._struct(node, kind)
        if isinstance(kind, t.Array) and not isinstance(node, s.Name | s.Member | s.Call):
            # ARRAY[1..4] OF INT := 7: printed listings give one value for the first element
            wrapped = s.ArrayInit(node.start, node.end, [(None, node)])
            return self._array(wrapped, kind)
        value = self.value(node)
        if isinstance(kind, t.Pointer) and kind.reference:
            return value
        return self.convert(value, kind, "initial value")

    def _array(self, node: s.ArrayInit, kind: t.Type) -> s.Node:
        if not isinstance(kind, t.Array):
            if kind is not t.ERROR:
                self.error("E0605", node, type=kind)
            return self.wrong_init(node)
        room = 1
        for low, high in kind.bounds:
            room *= high - low + 1
        element = kind.element
        items, used = [], 0
        for count, value in node.items:
            times = 1
            if count is not None:
                checked = self.value(count)
                times = checked.const if isinstance(checked.const, int) else 1
            if isinstance(value, s.ArrayInit) and not isinstance(element, t.Array) and len(kind.bounds) > 1:
                for c, v in value.items:  # [[1, 2], [3, 4]] for a two-dimensional array
                    repeat = self.value(c).const if c is not None else 1
                    items.append((repeat, self.initial(v, element)))
                    used += repeat
                continue
            items.append((times, None if value is None else self.initial(value, element)))
            used += times
        if used > room:
            self.error("E0606", node, given=used, room=room)
        made = s.ArrayInit(node.start, node.end, items)
        return made

    def _struct(self, node: s.StructInit, kind: t.Type) -> s.Node:
        if not isinstance(kind, t.Struct | t.Block):
            if kind is not t.ERROR:
                self.error("E0607", node, type=kind)
            return self.wrong_init(node)
        items = []
        for position, arg in enumerate(node.items):
            field = kind.members.get(key(arg.name)) if arg.name else None
            field = self._of_init(kind, arg) or field
            if arg.name is None and position < len(kind.members):
                field = list(kind.members.values())[position]
            if field is None:
                known = [f.name for f in kind.members.values()]
                pou = self.project.block_pous.get(kind)
                if pou is not None and pou.incomplete:
                    continue
                self.no_member(arg, arg.name or "", kind, known)
                continue
            if arg.value is not None:
                items.append((field, self.initial(arg.value, field.type)))
        return s.StructInit(node.start, node.end, items)

    def _of_init(self, kind: t.Type, arg: s.Arg) -> Var | None:
        """The input of FB_init that an argument in a declaration is for: fb : Block(n := 3)."""
        pou = self.project.block_pous.get(kind)
        for method in [p.methods["FB_INIT"] for p in pou.chain() if "FB_INIT" in p.methods] if pou and arg.name else ():
            if method.variables.get(key(arg.name)) in method.inputs():
                return method.variables[key(arg.name)]
        return None

    def wrong_init(self, node: s.Node) -> s.Node:
        made = s.StructInit(node.start, node.end, [])
        return made


def check_init(project, init: Init, kind: t.Type) -> s.Node:
    """The checked initial value, checked once however many instances use it."""
    if not init.checked:
        from stcore.check import Checker  # the checker is built on this module

        init.checked = True
        checker = Checker(project, init.source, init.pou, init.library)
        init.value = checker.initial(init.node, kind)
    return init.value

"""Methods and properties: what a name stands for, calls of them, who may call, and what a block has to provide."""

from __future__ import annotations

from dataclasses import dataclass

from stcore import syntax as s
from stcore import types as t
from stcore.check.calls import Calls, FunctionCall, is_borrowed
from stcore.check.conversions import same
from stcore.near import near
from stcore.scope import MethodOf, Pou, PropertyOf, key, member_of

_OWN_INPUTS = ("FB_INIT", "FB_REINIT", "FB_EXIT")  # each block has its own, and its base's runs besides


@dataclass(eq=False, slots=True)
class MethodCall(FunctionCall):
    """A call of a method. base: the instance, None for the running one; of a method of an interface the variable that
    holds the instance. bound: whose method it is, is known; else the instance itself decides (emit/dispatch.py).
    note: how the source names the callee."""

    base: s.Node | None = None
    bound: bool = True
    note: str = ""


class Methods(Calls):
    """Checks calls of methods, reading and writing of properties."""

    def interface_member(self, node: s.Member, kind: t.Interface) -> s.Node:
        """itf.m, itf.p: what the instance behind an interface has."""
        pou = self.project.block_pous[kind.target]
        found = member_of(pou, key(node.name), node.base)
        if found is None:
            known = [m.name for p in pou.chain() for m in p.methods.values()]
            self.error("E0306", node, name=node.name, type=kind.name, near=near(node.name, known))
            return self.wrong(node)
        return self.of_instance(node, found)

    def of_instance(self, node: s.Node, found: MethodOf | PropertyOf) -> s.Node:
        """The node for a method (to be called) or the value of a property."""
        node.symbol = found
        if isinstance(found, MethodOf) or node is self.target and not _refers(found):
            return node
        if found.getter is None:
            self.error("E0414", node, name=found.name, accessor="GET", done="read")
            return self.wrong(node)
        call = s.Call(node.start, node.end, node, [])
        made = self.method_call(call, MethodOf(found.getter, found.base, found.fixed))
        kind = made.type
        if isinstance(kind, t.Pointer) and kind.reference:
            return self._follow(made)
        return made

    def method_call(self, node: s.Call, symbol: MethodOf, checked: bool = False) -> s.Node:
        """m(), inst.m(a := 1), itf.m(): like a call of a function, on an instance."""
        pou = symbol.pou
        self._may_call(node.callee, pou)
        bound = self.match(node, pou)
        if bound is None:
            return self._skip(node) if not checked else self.wrong(node)
        call = MethodCall(pou, [], [], base=symbol.base, note=self.text(node.callee))
        call.bound = symbol.fixed or not self._decides(symbol)
        self.fill(node, call, bound, checked)
        self.use(pou)
        pou.calls += 1
        if self.pou is not None:
            self.pou.writes_instance = True
            self.pou.writes_outside |= not call.bound
        if symbol.base is not None and not isinstance(symbol.base.type, t.Interface):
            self._mark(symbol.base, symbol.base, True, True)
        node.symbol = call
        node.type = pou.result.type if pou.result is not None else None
        return node

    def write_property(self, node: s.Assign, found: PropertyOf) -> s.Node:
        """inst.p := x: a call of the accessor SET."""
        if found.setter is None:
            self.error("E0414", node.target, name=found.name, accessor="SET", done="written")
            self.value(node.value)
            return node
        value = s.Arg(node.value.start, node.value.end, None, node.value, False, False)
        call = s.Call(node.start, node.end, node.target, [value])
        return s.ExprStmt(node.start, node.end, self.method_call(call, MethodOf(found.setter, found.base, found.fixed)))

    def _decides(self, symbol: MethodOf) -> bool:
        """Whether only the instance knows which method runs: it may be of a block that extends the one known here."""
        pou, base = symbol.pou, symbol.base
        if pou.holder.kind == "INTERFACE":
            return True
        modifiers = pou.tree.modifiers | (pou.holder.tree.modifiers & {"FINAL"})
        if not pou.holder.type.number or modifiers & {"FINAL", "PRIVATE"}:
            return False
        return base is None or is_borrowed(base)

    def _may_call(self, node: s.Node, pou: Pou) -> None:
        """PRIVATE: from the block itself; PROTECTED: from blocks that extend it, too."""
        access = next((x for x in ("PRIVATE", "PROTECTED") if x in pou.tree.modifiers), None)
        here = self.pou and (self.pou.holder or self.pou)
        if access is None or here is pou.holder:
            return
        inside = here is not None and here.type is not None and isinstance(here.type, t.Block)
        if access == "PROTECTED" and inside and here.type.extends(pou.holder.type):
            return
        who = "only its own methods and body" + (" and those of blocks that extend it" if access == "PROTECTED" else "")
        self.error("E0413", node, name=pou.full_name, access=access, hint=f"{who} may use it")

    # ------------------------------------------------------------------------------------- what a block provides

    def check_members(self) -> None:
        """Whether the block declares its methods as its base and its interfaces do, and lacks none."""
        pou = self.pou
        said = self.project.reporter.diagnostics
        if any(d.code.startswith("E01") and d.file == self.source.path for d in said):
            return  # it may have what the parser could not read
        for name, method in pou.methods.items():
            inherited = pou.base.method(name) if pou.base is not None else None
            private = inherited is not None and "PRIVATE" in inherited.tree.modifiers
            if inherited is not None and name not in _OWN_INPUTS and not private:
                self._as_declared(method, inherited)
        for interface in pou.interfaces:
            wanted = {n: m for x in interface.chain() for n, m in x.methods.items()}
            missing = [m for n, m in wanted.items() if pou.method(n) is None]
            if missing:
                self._lacks(f"implements {interface.name}", missing)
            for name, declared in wanted.items():
                if pou.method(name) is not None:
                    self._as_declared(pou.method(name), declared)
        names = dict.fromkeys(n for x in pou.chain() for n in x.methods)
        missing = [pou.method(n) for n in names if "ABSTRACT" in pou.method(n).tree.modifiers]
        if missing and "ABSTRACT" not in pou.tree.modifiers:
            own = any(m.holder is pou for m in missing)
            self._lacks("is not ABSTRACT" if own else f"extends {missing[0].holder.name}", missing)

    def _lacks(self, why: str, missing: list[Pou]) -> None:
        tree = self.pou.tree
        at = s.Name(tree.name_start, tree.name_start + len(tree.name), tree.name)
        declaration = f"{s.WRITTEN[missing[0].kind]} {missing[0].name} in {tree.name}"
        names = ", ".join(dict.fromkeys(_shown(m) for m in missing))
        self.error("E0213", at, name=tree.name, why=why, missing=names, declaration=declaration)

    def _as_declared(self, method: Pou, declared: Pou) -> None:
        why = _difference(method, declared)
        if why:
            source = method.source
            start = method.tree.name_start
            self.project.reporter.add(
                "E0214",
                source,
                start,
                start + len(method.name),
                name=method.full_name,
                base=declared.holder.name,
                why=why,
            )


def _refers(found: PropertyOf) -> bool:
    """True for a property that gives a reference: to write it is to write what it refers to."""
    kind = found.getter.result.type if found.getter is not None and found.setter is None else None
    return isinstance(kind, t.Pointer) and kind.reference


def _shown(method: Pou) -> str:
    return method.name if method.kind == "METHOD" else f"{method.name} ({method.kind})"


def _difference(method: Pou, declared: Pou) -> str:
    """How a method differs from the one that it stands for; '' where it does not."""
    if (
        "FINAL" in declared.tree.modifiers
        and method.holder is not declared.holder
        and declared.holder.kind != "INTERFACE"
    ):
        return "it is FINAL there"
    own, wanted = _signature(method), _signature(declared)
    for (name, section, kind), (other_name, other_section, other) in zip(own, wanted, strict=False):
        if section != other_section or not (same(kind, other) or t.ERROR in (kind, other)):
            return f"{name} is {section} {kind}, {other_name} there {other_section} {other}"
        if key(name) != key(other_name):
            return f"{name} is called {other_name} there"
    if len(own) != len(wanted):
        more = own[len(wanted) :] or wanted[len(own) :]
        return f"{more[0][0]} is declared {'here' if len(own) > len(wanted) else 'there'} only"
    result, other = (m.result.type if m.result is not None else None for m in (method, declared))
    if (
        (result is None) != (other is None)
        or result is not None
        and not (same(result, other) or t.ERROR in (result, other))
    ):
        return f"its result is {result or 'nothing'}, there {other or 'nothing'}"
    return ""


def _signature(method: Pou) -> list[tuple[str, str, t.Type]]:
    return [(p.name, p.section, p.type) for p in method.parameters]

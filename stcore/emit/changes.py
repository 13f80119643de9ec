"""What the code of a loop can change: a variable that it changes only by name need not be read from memory again."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from stcore import syntax as s
from stcore import types as t
from stcore.check.calls import BlockCall, FunctionCall
from stcore.check.methods import MethodCall
from stcore.emit.ranges import walk
from stcore.scope import BuiltinCall, Pou, Var, key

MOST = 12  # variables that one loop keeps in locals: more would not fit into the processor's registers
_Kind = tuple[str, int]


def _kind(of: t.Type) -> _Kind | None:
    """Kind and size of a value that a pointer can lead to; None for what may lie over anything, as a BYTE does."""
    base = t.base_of(of)
    if not isinstance(base, t.Elementary):
        return None if t.is_aggregate(of) else ("address", 4)
    if base.size == 1 and base.kind != "bool":
        return None
    return "int" if base.kind == "bits" else base.kind, base.size


def _root(place: s.Node) -> Var | Pou | None:
    """The variable or program that a place is part of; None if a pointer or an in-out leads there."""
    while True:
        match place:
            case s.Name() | s.Address() | s.Member() if isinstance(place.symbol, Var):
                return None if place.symbol.indirect else place.symbol
            case s.Member() if not place.symbol.by_reference:
                place = place.base
            case s.Index() if not isinstance(place.base.type, t.Pointer):
                place = place.base
            case s.Name() if isinstance(place.symbol, Pou):
                return place.symbol
            case _:
                return None


def may_hold(instance: s.Node) -> bool:
    """True if an instance that is called may be the one that calls, or hold it: it is no part of that one."""
    root = _root(instance)
    return not isinstance(root, Var) or root.storage not in ("this", "local")


def acts(code: object) -> bool:
    """True if working this out may change something."""
    return any(isinstance(node, s.Call | s.Assign) for node in walk(code))


@dataclass(slots=True)
class Changes:
    """Found in some code of a POU. named: variables that it assigns by name; counters: those of its FOR loops; behind:
    those that it assigns as a member of its program; used: how often it names each variable.

    kinds: what is stored through pointers and in-outs. anything: a pointer to bytes, or code that is not seen here, may
    have changed any variable in memory; library: only variables of the library; own: only those of an instance.
    """

    pou: Pou
    named: set[Var] = field(default_factory=set)
    counters: set[Var] = field(default_factory=set)
    behind: set[Var | None] = field(default_factory=set)
    used: Counter[Var] = field(default_factory=Counter)
    kinds: set[_Kind] = field(default_factory=set)
    anything: bool = False
    library: bool = False
    own: bool = False

    def more_than_names(self) -> bool:
        """False if it changes nothing but the variables that it names."""
        return bool(self.kinds or self.behind) or self.anything or self.library or self.own

    def unseen(self, var: Var) -> bool:
        """True if the code may change the variable otherwise than by its name."""
        if var.addressed or var.indirect or var.storage == "area" or var in self.behind:
            return True
        if var.storage == "local":
            return False
        if self.anything or self.own and var.storage == "this" or self.library and var.library:
            return True
        return bool(self.kinds) and (_kind(var.type) in self.kinds or _kind(var.type) is None)

    def steady(self, var: Var) -> bool:
        return var not in self.named and not self.unseen(var)

    def store(self, place: s.Node) -> None:
        """Something is stored at this place."""
        while isinstance(place, s.Part):
            place = place.base
        if isinstance(place.symbol, Var):
            self.named.add(place.symbol)
        elif isinstance(place, s.Member) and place.base.symbol is self.pou:  # PLC_PRG.x in PLC_PRG
            self.behind.add(self.pou.variables.get(key(place.name)))
        if _root(place) is None:
            kind = _kind(place.type)
            if kind is None:
                self.anything = True
            else:
                self.kinds.add(kind)

    def call(self, node: s.Call) -> None:
        call = node.symbol
        if isinstance(call, BuiltinCall):
            self.anything |= call.name in ("MEMMOVE", "MEMSET")
            if call.name in ("__QUERYINTERFACE", "__QUERYPOINTER"):
                self.store(call.args[1])
        elif isinstance(call, FunctionCall | BlockCall):
            for place in [*(place for _, place in call.outputs), *([call.eno] if call.eno is not None else [])]:
                self.store(place)
            if call.pou.writes_outside or call.pou.external:
                self.library |= call.pou.library
                self.anything |= not call.pou.library
            self.own |= call.pou is self.pou or isinstance(call, BlockCall) and may_hold(call.instance)
            if isinstance(call, MethodCall):
                self.own |= call.base is None or may_hold(call.base)
                self.anything |= not call.bound
            elif isinstance(call, BlockCall):
                self.anything |= call.decides
        else:
            self.anything = True


def changes(code: object, pou: Pou) -> Changes:
    """What some code of this POU changes."""
    found = Changes(pou)
    for node in walk(code):
        if isinstance(getattr(node, "symbol", None), Var):
            found.used[node.symbol] += 1
        match node:
            case s.Assign():
                found.store(node.target)
            case s.For():
                found.store(node.var)
                found.counters.add(node.var.symbol)
            case s.Call():
                found.call(node)
    return found


def worth_keeping(found: Changes) -> list[Var]:
    """The variables in memory that a loop had better keep in locals, too: those that it both changes and reads."""
    held = [
        var
        for var, times in found.used.items()
        if times > 1 and var in found.named - found.counters and var.storage in ("global", "this")
        and not t.is_aggregate(var.type) and var.bit is None and not found.unseen(var)
    ]  # fmt: skip
    return sorted(held, key=lambda v: -found.used[v])[:MOST]

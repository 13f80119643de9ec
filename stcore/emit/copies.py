"""Variables that WebAssembly locals hold as well: memory is always written, but need not be read again.

Three kinds, by how long they hold. shadows: the counter of a FOR loop, in it. copies: what a loop changes and reads, in
it. recent: what was assigned, until the next loop, label, or code that may change it otherwise.
"""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.emit.changes import Changes, changes, worth_keeping
from stcore.emit.values import load, wasm_type
from stcore.scope import Var

Held = dict[Var, str]


class Copies:
    """Which local holds a variable. The dictionaries are never changed, always replaced: branches keep the old one."""

    def local_of(self, var: Var) -> str | None:
        """The WebAssembly local that holds a variable's value here, None if it is in memory."""
        for held in (self.shadows, self.copies, self.recent):
            if var in held:
                return held[var]
        if var.storage == "local" and not var.indirect:
            return self.locals_of.get(var)
        return None

    def in_memory(self, var: Var) -> bool:
        """True if an assignment has to write to memory, whatever locals hold."""
        return var in self.copies or var in self.recent or self.local_of(var) is None

    def suits(self, place: s.Node) -> bool:
        """True if a local may hold what is assigned to this place."""
        var = place.symbol
        return (
            not self.probed and isinstance(var, Var) and isinstance(place, s.Name) and var.storage in ("global", "this")
            and not var.indirect and not var.addressed and var.bit is None and not t.is_aggregate(var.type)
        )  # fmt: skip

    def remember(self, var: Var) -> None:
        """From this assignment on a local holds the variable."""
        if self.local_of(var) is None:
            if var not in self.homes:
                self.homes[var] = self.borrow(wasm_type(var.type))
            self.recent = self.recent | {var: self.homes[var]}

    def forget(self, node: s.Node, stored: bool = False) -> None:
        """What a call may change, or an assignment to this place, is read from memory again; in the callers, too."""
        emitter = self
        while emitter:
            if emitter.recent:
                found = Changes(emitter.pou)
                if stored:
                    found.store(node)
                else:
                    found.call(node)
                if found.more_than_names():
                    changed = found.unseen if emitter is self else lambda v, found=found: not found.steady(v)
                    emitter.recent = {v: name for v, name in emitter.recent.items() if not changed(v)}
                elif emitter is not self and found.named:
                    emitter.recent = {v: name for v, name in emitter.recent.items() if v not in found.named}
            emitter = emitter.caller

    @staticmethod
    def in_all(ways: list[Held]) -> Held:
        """What locals hold where several ways meet."""
        first, *others = ways
        others = [way for way in others if way is not first]  # often none has changed anything
        return {v: name for v, name in first.items() if all(v in way for way in others)} if others else first

    def keep_copies(self, *code: object) -> Held:
        """Before a loop: what it changes by name and reads is kept in locals, too. The copies of outside the loop."""
        outer, self.recent = self.copies, {}
        if not self.probed:  # there a debugger may change any variable at any statement
            found = changes(code, self.pou)
            new = {v: self.keep(wasm_type(v.type)) for v in worth_keeping(found) if self.local_of(v) is None}
            for var, name in new.items():
                self.line(f"(local.set {name} {load(var.type, *self.var_place(var))})")
            self.copies = outer | new
        return outer

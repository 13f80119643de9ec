"""The checker: names and types of every POU that a program needs.

It annotates the tree (type, const, symbol of each expression), puts implicit conversions into it, and leaves to the
emitter nothing to decide but instructions.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stcore import syntax as s
from stcore import types as t
from stcore.check import builtins
from stcore.check.calls import copy_tree
from stcore.check.initial import Initials
from stcore.check.statements import Statements
from stcore.declare import Declarer
from stcore.declare_types import Pending
from stcore.diagnostics import Reporter
from stcore.project import Project
from stcore.scope import Pou, Var, key
from stcore.source import Source

if TYPE_CHECKING:
    from stcore.configuration import Mirror


class Checker(Statements, Initials):
    """Checks one POU, or one expression outside any."""


class CheckedProject(Project):
    """A project whose POUs are checked as they are reached."""

    def __init__(self, reporter: Reporter, libraries: list[Path], siblings: list[Path] | None = None) -> None:
        super().__init__(reporter, libraries, siblings)
        self.evaluate = self._evaluate
        self.is_builtin = builtins.is_builtin
        self.reached: dict[Pou, None] = {}
        self.looked_into: set[t.Struct] = set()  # for blocks among its members
        self.queue: list[Pou] = []
        self.left_out: list[Pou] = []  # functions of the library that work for another one alone, which nothing needs
        self.own_only = False  # leave the bodies of the library unchecked: only diagnostics are wanted
        self.library_globals: set[Var] = set()
        self.instances: dict[tuple, Pou] = {}
        # what stcore/configuration.py finds; names in upper case
        self.program_instances: dict[str, tuple[str, Pou, int]] = {}  # of programs that have several: name, address
        self.connections: dict[str, tuple[s.ExprStmt, Source]] = {}  # program or instance -> its call by the task
        self.mirrors: list[Mirror] = []
        self.test_instances: dict[Pou, int] = {}  # blocks with methods that are tests: an instance for these
        self.aliases: dict[str, str] = {}  # other names for programs
        self.accesses: dict[str, tuple[str, bool]] = {}  # VAR_ACCESS: name -> path, whether it is read only
        self.evaluated: list[Var] = []  # constants whose values are being worked out, one for another
        self.areas = {"I": 0, "Q": 0, "M": 0}  # bytes in use

    def known_names(self, library: bool = False) -> list[str]:
        return super().known_names(library) + [n for n in builtins.HANDLERS if library or not n.startswith("__")]

    def reach(self, pou: Pou) -> None:
        """The program needs this POU; with a block what it extends, and methods that may be called on an instance."""
        if pou not in self.reached:
            self.reached[pou] = None
            self.queue.append(pou)
            for method in pou.methods.values():
                self.reach(method)
            if pou.base is not None:
                self.reach(pou.base)

    def check_reached(self) -> None:
        """Check every POU that is needed, and what those need."""
        while self.queue or self.needs:
            while self.needs:
                pou = self.lookup(self.needs.pop(), library=True)
                if pou is not None:
                    self.instance(pou)
                    self.reach(pou)
            while self.queue:
                self._check(self.queue.pop())
            self.queue = [pou for pou in self.left_out if self._is_wanted(pou)]
            self.left_out = [pou for pou in self.left_out if pou not in self.queue]

    def _check(self, pou: Pou) -> None:
        if pou.checked or pou.library and self.own_only:
            return
        if not self._is_wanted(pou):
            self.left_out.append(pou)
            return
        pou.checked = True
        checker = Checker(self, pou.source, pou, pou.library)
        checker.sums_of_fractions()
        for var in [*pou.variables.values(), *([pou.result] if pou.result else [])]:
            self.direct(var)
            self.reach_type(var.type)
        checker.initial_values()
        checker.check_pou()

    def _is_wanted(self, pou: Pou) -> bool:
        """False while nothing needs the function that this one works for (attribute only_with)."""
        other = self.library.get(key(pou.attributes.get("only_with", ""))) if pou.library else None
        return "only_with" not in pou.attributes or other is not None and other.symbol in self.reached

    def spread_writes(self) -> None:
        """A POU writes outside itself when one that it uses does; that one may have been checked after it."""
        users: dict[Pou, list[Pou]] = {}
        for pou in [*self.reached, *self.instances.values()]:
            for used in pou.uses:
                users.setdefault(used, []).append(pou)
        todo = [p for p in users if p.writes_outside or p.external]
        while todo:
            for user in users.get(todo.pop(), ()):
                if not user.writes_outside:
                    user.writes_outside = True
                    todo.append(user)

    def reach_type(self, kind: t.Type) -> None:
        """An instance may be called through a pointer: its code must be there."""
        while isinstance(kind, t.Array):
            kind = kind.element
        if isinstance(kind, t.Block):
            self.reach(self.block_pous[kind])
        elif isinstance(kind, t.Struct) and kind not in self.looked_into:
            self.looked_into.add(kind)
            for field in kind.members.values():
                self.reach_type(field.type)

    def direct(self, var: Var) -> None:
        """Make room for a variable at a direct address."""
        if var.storage == "area":
            size = max(var.type.size, 1)
            self.areas[var.area] = max(self.areas[var.area], var.address + size)

    def instantiate(self, generic: Pou, bindings: dict[str, t.Type]) -> Pou:
        """A generic function for given types."""
        mark = (generic, *sorted((n, k.name) for n, k in bindings.items()))
        pou = self.instances.get(mark)
        if pou is None:
            tree = copy_tree(generic.tree)
            entry = Pending("pou", tree, generic.source, generic.library)
            pou = Declarer(self, generic.source, generic.library).pou(entry, bindings)
            for var in pou.parameters:
                if var.section == "VAR_INPUT" and isinstance(var.type, t.String):
                    var.indirect = True
            self.instances[mark] = pou
        return pou

    def _evaluate(self, what: s.Node | Var, source: Source, pou: Pou | None, library: bool) -> object:
        """The value of a constant expression, or of a constant from its initial value; None if it has none."""
        checker = Checker(self, source, pou, library)
        if isinstance(what, Var):
            init = what.init
            if init.checked:
                return init.value.const if isinstance(init.value, s.Node) else None
            checker.source = init.source
            self.evaluated.append(what)
            init.value = checker.typed(init.node, what.type, f"initial value of {what.name}")
            self.evaluated.pop()
            init.checked = True
            return init.value.const
        return checker.value(what).const

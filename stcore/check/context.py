"""What every part of the checker shares: the POU it is in, names, messages."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.near import near
from stcore.project import Project
from stcore.scope import ActionOf, Pou, key, member_of
from stcore.source import Source


class Context:
    """Checks one POU (or one expression outside any) of a project. errors and warnings go to the reporter."""

    def __init__(self, project: Project, source: Source, pou: Pou | None, library: bool) -> None:
        self.project = project
        self.source = source
        self.pou = pou
        self.library = library
        family = pou and [*(pou.holder or pou).chain()][-1]  # reported once a POU and all that belongs to it
        self.unknown: set[str] = project.unknown.setdefault(family, set()) if family else set()
        self.loops = 0
        self.labels: frozenset[str] = frozenset()  # that JMP can reach
        self.target: s.Node | None = None  # what an assignment writes: a property there is not read

    def report(self, code: str, node: s.Node, hint: str = "", **fields) -> None:
        self.project.reporter.add(code, self.source, node.start, node.end, hint=hint, **fields)

    error = report

    def warn(self, code: str, node: s.Node, **fields) -> None:
        if not self.library:  # the library's own business
            self.report(code, node, **fields)

    def no_member(self, node: s.Node, name: str, kind: t.Type, known: list[str]) -> None:
        """Told once a type and name: it may well be that another type was meant."""
        mark = f"{kind.name}.{key(name)}"
        if mark not in self.unknown:
            self.unknown.add(mark)
            self.error("E0306", node, name=name, type=kind.name, near=near(name, known))

    def text(self, node: s.Node) -> str:
        """The source text of a node."""
        return self.source.text[node.start : node.end]

    def lookup(self, name: str) -> object | None:
        """The symbol of a name: of this POU first, of the block whose method it is, then global."""
        upper, pou = key(name), self.pou
        while pou is not None:
            found = self._own(pou, upper)
            if found is not None:
                return found
            pou = pou.holder
        return self.project.lookup(name, self.library)

    @staticmethod
    def _own(pou: Pou, upper: str) -> object | None:
        """What a name means in a POU itself."""
        if upper in pou.later:
            pou.later[upper]()
        var = pou.edges.get(upper) or pou.variables.get(upper)
        if var is not None:
            return var
        if pou.result is not None and upper == key(pou.name):
            return pou.result
        if upper in pou.enum_names:
            return pou.enum_names[upper]
        if pou.base is None and not pou.methods:  # most POUs: asked for every name
            return ActionOf(pou, pou.actions[upper]) if upper in pou.actions else None
        found = pou.action(upper) or member_of(pou, upper)
        if found is None and pou.base is not None:
            return next((p.enum_names[upper] for p in pou.chain() if upper in p.enum_names), None)
        return found

    def known_names(self) -> list[str]:
        """Every name that can be used here."""
        known = self.project.known_names(self.library)
        pou = self.pou
        while pou is not None:
            methods = [m.name for p in pou.chain() for m in p.methods.values()]
            known = [v.name for v in pou.variables.values()] + methods + known
            pou = pou.holder
        return known

    def near(self, name: str) -> str:
        """'did you mean ...' for a name that is not known here."""
        return near(name, self.known_names())

    def unknown_name(self, node: s.Node, name: str, code: str = "E0301") -> None:
        if key(name) not in self.unknown and not (self.pou is not None and self.pou.incomplete):
            self.unknown.add(key(name))
            self.error(code, node, name=name, near=self.near(name))

    def wrong(self, node: s.Node) -> s.Node:
        """Mark a node as already reported: nothing that follows from it is."""
        node.type = t.ERROR
        return node

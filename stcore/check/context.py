"""What every part of the checker shares: the POU it is in, names, messages."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.near import near
from stcore.project import Project
from stcore.scope import Pou, key
from stcore.source import Source


class Context:
    """Checks one POU (or one expression outside any) of a project. errors and warnings go to the reporter."""

    def __init__(self, project: Project, source: Source, pou: Pou | None, library: bool) -> None:
        self.project = project
        self.source = source
        self.pou = pou
        self.library = library
        self.unknown: set[str] = set()  # reported once a POU
        self.loops = 0
        self.labels: frozenset[str] = frozenset()  # that JMP can reach

    def report(self, code: str, node: s.Node, hint: str = "", **fields) -> None:
        self.project.reporter.add(code, self.source, node.start, node.end, hint=hint, **fields)

    error = report

    def warn(self, code: str, node: s.Node, **fields) -> None:
        if not self.library:  # the library's own business
            self.report(code, node, **fields)

    def text(self, node: s.Node) -> str:
        """The source text of a node."""
        return self.source.text[node.start : node.end]

    def lookup(self, name: str) -> object | None:
        """The symbol of a name: of this POU first, then global."""
        upper = key(name)
        if self.pou is not None:
            if upper in self.pou.later:
                self.pou.later[upper]()
            var = self.pou.edges.get(upper) or self.pou.variables.get(upper)
            if var is not None:
                return var
            if self.pou.result is not None and upper == key(self.pou.name):
                return self.pou.result
            if upper in self.pou.enum_names:
                return self.pou.enum_names[upper]
            if upper in self.pou.actions:
                return self.pou.actions[upper]
        return self.project.lookup(name, self.library)

    def known_names(self) -> list[str]:
        """Every name that can be used here."""
        known = self.project.known_names(self.library)
        if self.pou is not None:
            known = [v.name for v in self.pou.variables.values()] + known
        return known

    def near(self, name: str) -> str:
        """'did you mean ...' for a name that is not known here."""
        return near(name, self.known_names())

    def unknown_name(self, node: s.Node, name: str, code: str = "E0301") -> None:
        if key(name) not in self.unknown:
            self.unknown.add(key(name))
            self.error(code, node, name=name, near=self.near(name))

    def wrong(self, node: s.Node) -> s.Node:
        """Mark a node as already reported: nothing that follows from it is."""
        node.type = t.ERROR
        return node

"""Names in printed listings: misread letters, and identifiers whose declaration was never printed.

A printed text shows itself by what else had to be mended in it, or by the marks of an export. In any other text a name
that is not declared is an error: a typing mistake must not become a new variable.
"""

from __future__ import annotations

import functools
import re
from fnmatch import fnmatchcase
from itertools import zip_longest

from stcore import syntax as s
from stcore import types as t
from stcore.check.context import Context
from stcore.near import nearest
from stcore.scope import Pou, Var, key

_EXPORT_MARK = "@END_DECLARATION"
_ALIKE = str.maketrans({"i": "l", "1": "l", "0": "o", " ": None})


def look(name: str) -> str:
    """A name as a bad print shows it: l, I and 1 are alike, and O and 0."""
    return name.lower().translate(_ALIKE)


@functools.lru_cache(maxsize=16)
def _exported(text: str) -> bool:
    """Has this text the mark of an export? Asked again for every POU of it."""
    return _EXPORT_MARK in text


class Printed(Context):
    """What to make of a name that is not known."""

    @property
    def printed(self) -> bool:
        """True if this text was printed, not typed."""
        if _exported(self.source.text):
            return True
        found = self.project.reporter.diagnostics
        return any(d.code.startswith("W01") and d.file == self.source.path for d in found)

    def meant(self, node: s.Node, name: str, known: list[str]) -> str | None:
        """The known name that a misprint stands for, after a warning; None if it is no known misprint."""
        found = self._respelt(name) or self._misread(name, known)
        if found is not None and found.upper() != name.upper():
            self.report("W0130", node, name=name, meant=found)
            return found
        return None

    def _respelt(self, name: str) -> str | None:
        """By the libraries' lists of misprints (listings.toml)."""
        for printed, meant in self.project.spellings().items():
            if fnmatchcase(name.upper(), printed.upper()):
                return meant.replace("*", name[printed.index("*") :]) if "*" in meant else meant
        return None

    @staticmethod
    def _misread(name: str, known: list[str]) -> str | None:
        found = {n.upper(): n for n in known if len(n) == len(name) and look(n) == look(name)}
        return next(iter(found.values())) if len(found) == 1 else None

    def declare_missing(self, node: s.Name) -> object | None:
        """A variable for an identifier without declaration, if its use tells the type."""
        pou = self.pou
        if pou is None or self.library:
            return None
        counter = any(isinstance(n, s.For) and _is(n.var, node.name) for n in _all(pou.tree.body))
        if not (self.printed or counter and not nearest(node.name, self._own_names())):
            return None
        if not counter:
            unused = self._unused_like(node.name)
            if unused is not None:
                self.report("W0131", node, name=node.name, meant=unused.name)
                pou.variables[key(node.name)] = unused
                return unused
        kind = Use(self, node.name).kind()
        if kind is None:
            return None
        self.report("W0132", node, name=node.name, type=kind)
        return self._declare(node.name, kind)

    def declare_instance(self, node: s.Name, block: Pou) -> Var | None:
        """An instance of a block that a printed template calls by the block's own name."""
        if self.pou is None or block.type is None or not self.printed:
            return None
        self.report("W0134", node, name=block.name)
        return self._declare(block.name, block.type)

    def numbered_instance(self, node: s.Name) -> Var | None:
        """MC_Power0, MC_Power_1: how templates name an instance whose declaration they leave out."""
        match = re.fullmatch(r"(\w+?)_?\d+", node.name)
        block = self.lookup(match[1]) if match and self.printed and self.pou is not None else None
        if not isinstance(block, Pou) or block.type is None:
            return None
        self.report("W0132", node, name=node.name, type=block.type)
        return self._declare(node.name, block.type)

    def sums_of_fractions(self) -> None:
        """A variable printed as a whole number to which its POU adds fractions, x := x + 0.016, is an LREAL: the sum
        would stay what it is."""
        if self.pou is None or self.library or not self.printed:
            return
        for node in _all(self.pou.tree.body):
            if not isinstance(node, s.Assign) or not isinstance(node.target, s.Name):
                continue
            var, value = self.pou.variables.get(key(node.target.name)), node.value
            if var is None or var.section != "VAR" or not isinstance(var.type, t.Elementary) or var.type.kind != "int":
                continue
            if not isinstance(value, s.Binary) or value.op not in "+-" or not _is(value.left, var.name):
                continue
            if self._fraction(value.right):
                self.report("W0135", node, name=var.name, type=var.type, text=self.text(value.right))
                self._declare(var.name, t.LREAL).init = var.init

    def _fraction(self, node: s.Node) -> bool:
        """Is it a constant that is no whole number?"""
        if isinstance(node, s.Name):
            var = self.lookup(node.name)
            node = var.init.node if isinstance(var, Var) and var.constant and var.init is not None else None
        return isinstance(node, s.Literal) and isinstance(node.value, float) and not node.value.is_integer()

    def _declare(self, name: str, kind: t.Type) -> Var:
        """A variable that the text forgot; static, so that the layout of instances stays."""
        var = Var(name, kind, "global", self.project.allocate(kind.size, max(kind.align, 4)), owner=self.pou)
        self.pou.variables[key(name)] = var
        if self.pou.type is not None:
            self.pou.type.members[key(name)] = t.Field(name, kind, var.address, "VAR_STAT")
        self.project.reach_type(kind)
        return var

    def _own_names(self) -> list[str]:
        return [v.name for v in self.pou.variables.values()]

    def _unused_like(self, name: str) -> Var | None:
        """A declared variable that looks like the name and is used nowhere: one of the two is a misprint."""
        for near in nearest(name, self._own_names()):
            if not any(_is(n, near) for n in _all(self.pou.tree.body)):
                return self.pou.variables[key(near)]
        return None


def _is(node: object, name: str) -> bool:
    return isinstance(node, s.Name) and key(node.name) == key(name)


def _all(node: object):
    """Every node of a tree that has not been checked."""
    if isinstance(node, s.Node):
        yield node
        for field in node.fields:
            yield from _all(getattr(node, field))
    elif isinstance(node, list | tuple):
        for item in node:
            yield from _all(item)


class Use:
    """What the uses of an identifier say of its type."""

    def __init__(self, context: Context, name: str) -> None:
        self.context = context
        self.name = name
        self.nodes = list(_all(context.pou.tree.body))

    def kind(self) -> t.Type | None:
        return self._counter() or self._condition() or self._argument() or self._assigned()

    def _counter(self) -> t.Type | None:
        return t.INT if any(isinstance(n, s.For) and _is(n.var, self.name) for n in self.nodes) else None

    def _condition(self) -> t.Type | None:
        tests = []
        for n in self.nodes:
            if isinstance(n, s.If):
                tests += [c for c, _ in n.branches]
            elif isinstance(n, s.While | s.Repeat):
                tests.append(n.condition)
        return t.BOOL if any(self._logical(c) for c in tests) else None

    def _logical(self, node: s.Node) -> bool:
        if isinstance(node, s.Unary) and node.op == "NOT":
            return self._logical(node.operand)
        if isinstance(node, s.Binary) and node.op in ("AND", "OR", "XOR", "AND_THEN", "OR_ELSE"):
            return self._logical(node.left) or self._logical(node.right)
        return _is(node, self.name)

    def _argument(self) -> t.Type | None:
        """Of a function or block that takes it, or its address."""
        for call in self.nodes:
            if not isinstance(call, s.Call) or not isinstance(call.callee, s.Name):
                continue
            pou = self._called(call.callee.name)
            if pou is None:
                continue
            bound = self._bound(call, pou)
            for parameter, value in bound:
                if (kind := self._from_parameter(value, parameter)) is not None:
                    bytes_at = isinstance(parameter.type, t.Pointer) and kind.size == 1
                    return bytes_at and self._buffer(bound) or kind
        return None

    @staticmethod
    def _bound(call: s.Call, pou: Pou) -> list[tuple[Var, s.Node | None]]:
        """The parameters of a call and what they are given; a core number in front of them is left out."""
        inputs, args = pou.arguments(), call.args
        if len(args) == len(inputs) + 1 and isinstance(args[0].value, s.Literal):
            args = args[1:]
        named = {key(p.name): p for p in pou.parameters}
        given = [(named.get(key(a.name)) if a.name else p, a.value) for a, p in zip_longest(args, inputs) if a]
        return [(p, value) for p, value in given if p is not None]

    @staticmethod
    def _buffer(bound: list[tuple[Var, s.Node | None]]) -> t.Type | None:
        """Of bytes whose address is taken: as many as the parameter 'nSize' or the like of the same call says."""
        sizes = [v for p, v in bound if key(p.name).endswith("SIZE") and isinstance(v, s.Literal)]
        if len(sizes) != 1 or not isinstance(sizes[0].value, int) or sizes[0].value < 1:
            return None
        whole = {1: t.BYTE, 2: t.WORD, 4: t.DWORD, 8: t.LWORD}
        return whole.get(sizes[0].value) or t.Array(t.BYTE, [(0, sizes[0].value - 1)])

    def _called(self, name: str) -> Pou | None:
        """The function of a name, or the block that it is, or is an instance of."""
        symbol = self.context.lookup(name)
        if isinstance(symbol, Var) and isinstance(symbol.type, t.Block):
            return self.context.project.block_pous[symbol.type]
        return symbol if isinstance(symbol, Pou) and symbol.kind != "PROGRAM" else None

    def _from_parameter(self, value: s.Node | None, parameter: Var) -> t.Type | None:
        if _is(value, self.name):
            return parameter.type
        address = isinstance(value, s.Call) and _is(value.callee, "ADR") and value.args
        taken = address and _is(value.args[0].value, self.name)
        return parameter.type.target if taken and isinstance(parameter.type, t.Pointer) else None

    def _assigned(self) -> t.Type | None:
        """What is assigned to it: a function's result, another variable, a constant."""
        for n in self.nodes:
            if isinstance(n, s.Assign) and _is(n.target, self.name):
                value = n.value
                while isinstance(value, s.Assign):
                    value = value.value
                if (kind := self._of_value(value)) is not None:
                    return kind
        return None

    def _of_value(self, value: s.Node) -> t.Type | None:
        if isinstance(value, s.Literal):
            if value.type_name == "STRING":
                return t.String(80)
            if value.type_name is None:
                return t.LREAL if isinstance(value.value, float) else t.DINT
            return t.ELEMENTARY.get(value.type_name)
        name = value.callee if isinstance(value, s.Call) else value
        symbol = self.context.lookup(name.name) if isinstance(name, s.Name) else None
        if isinstance(symbol, Pou) and symbol.result is not None:
            return symbol.result.type
        if isinstance(symbol, Var) and not isinstance(value, s.Call):
            return symbol.type
        return None

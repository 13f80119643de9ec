"""Declarations of object orientation: methods and properties, EXTENDS, IMPLEMENTS, interfaces (CODESYS V3).

A property is up to two methods, its accessors, known as ``NAME.GET`` and ``NAME.SET``. A block that extends another
begins with the variables of that one. A call through a pointer, a reference or an interface has to find out whose
method it runs: the instances of families of blocks where that can happen begin with a word, the number of their block
in ``Project.classes``; all other blocks are laid out as if they had no methods.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from stcore import syntax as s
from stcore import types as t
from stcore.near import near
from stcore.scope import Pou, Var, key

if TYPE_CHECKING:
    from stcore.declare import Declarer
    from stcore.declare_types import Pending
    from stcore.project import Project


def method_key(tree: s.Pou) -> str:
    """Under which name a block knows a method."""
    return key(tree.name) if tree.kind == "METHOD" else f"{key(tree.name)}.{tree.kind}"


# ---------------------------------------------------------------------------------------------------- EXTENDS


def extend(d: Declarer, pou: Pou) -> None:
    """Take over what the block has from its base, and the number of its class where its family needs it."""
    tree, block = pou.tree, pou.type
    if tree.extends is not None:
        name = tree.extends.rpartition(".")[2]
        circle = d.being_declared(name) is not None
        base = None if circle else d.project.lookup(name, d.library)
        why = "it extends this one" if circle else _no_base(base)
        if base is None and not circle:
            known = d.project.known_names(d.library)
            _at_name(d, tree, "E0202", name=tree.extends, near=near(tree.extends, known))
        elif why:
            _at_name(d, tree, "E0212", name=tree.name, base=tree.extends, why=why)
        else:
            _inherit(pou, base)
    pou.interfaces = [x for x in (_interface(d, tree, name) for name in tree.implements) if x is not None]
    block.interfaces = [x.type for x in pou.interfaces]
    if block.base.number if block.base is not None else _needs_number(d.project, tree, d.library):
        d.project.classes.append(block)
        block.number = len(d.project.classes)


def _no_base(base: object) -> str:
    """Why a block can't be extended; '' where it can."""
    if not isinstance(base, Pou) or base.kind != "FUNCTION_BLOCK":
        return "it is no FUNCTION_BLOCK"
    return "it is FINAL" if "FINAL" in base.tree.modifiers else ""


def _inherit(pou: Pou, base: Pou) -> None:
    block = pou.type
    pou.base, block.base = base, base.type
    block.size, block.align = base.type.size, base.type.align
    block.members.update(base.type.members)
    pou.variables.update({n: v for n, v in base.variables.items() if v.storage != "local"})
    pou.parameters = list(base.parameters)


def _at_name(d: Declarer, tree: s.Pou, code: str, **fields) -> None:
    """An error at the name of a POU."""
    d.project.reporter.add(code, d.source, tree.name_start, tree.name_start + len(tree.name), **fields)


def _needs_number(project: Project, tree: s.Pou, library: bool) -> bool:
    """Whether a call may have to ask an instance of this block, or of one that extends it, which block it is of."""
    family = list(_family(project, tree, library))
    if any(x.implements for x in family):
        return True
    return len(family) > 1 and any(x.methods for x in family)


def _family(project: Project, tree: s.Pou, library: bool) -> Iterator[s.Pou]:
    """A block and all that extend it, as far as they have been read."""
    seen, todo = set(), [tree]
    while todo:
        block = todo.pop()
        if key(block.name) not in seen:
            seen.add(key(block.name))
            yield block
            todo += project.extensions.get(key(block.name), []) if library else project.extensions_of(key(block.name))


# ------------------------------------------------------------------------------------------------- interfaces


def _interface(d: Declarer, tree: s.Pou, name: str) -> Pou | None:
    name = name.rpartition(".")[2]
    if d.being_declared(name) is not None:
        _at_name(d, tree, "E0212", name=tree.name, base=name, why="it extends this one")
        return None
    found = d.project.lookup(name, d.library)
    if isinstance(found, Pou) and found.kind == "INTERFACE":
        return found
    if found is None:
        near_names = near(name, d.project.known_names(d.library))
        _at_name(d, tree, "E0202", name=name, near=near_names)
    else:
        _at_name(d, tree, "E0212", name=tree.name, base=name, why="it is no INTERFACE")
    return None


def interface(d: Declarer, entry: Pending) -> Pou:
    """The symbol of an INTERFACE; its type is that of variables that hold an instance."""
    tree: s.Pou = entry.tree
    pou = Pou("INTERFACE", tree.name, tree, d.source, d.library, attributes=tree.attributes)
    pou.symbol = f"${tree.name if tree.name.isascii() else 'interface'}.i{len(d.project.pous)}"
    pou.type = t.Interface(t.Block(tree.name, "INTERFACE", size=4, file=d.source.path))
    d.project.block_pous[pou.type.target] = pou
    d.project.named_types[key(tree.name)] = pou.type
    pou.interfaces = [x for x in (_interface(d, tree, name) for name in tree.implements) if x is not None]
    pou.type.bases = [x.type for x in pou.interfaces]
    declare_methods(d, pou)
    d.project.pous.append(pou)
    return pou


# ---------------------------------------------------------------------------------------------------- methods


def declare_methods(d: Declarer, pou: Pou) -> None:
    """The methods of a block; their variables wait until the block is known, since their types may need it."""
    for tree in pou.tree.methods:
        name = method_key(tree)
        first = pou.methods.get(name) or pou.variables.get(key(tree.name)) or pou.actions.get(key(tree.name))
        other = next((m for n, m in pou.methods.items() if n.partition(".")[0] == key(tree.name)), None)
        if other is not None and "METHOD" in (other.kind, tree.kind):
            first = other
        if first is not None:
            start = first.decl.start if isinstance(first, Var) else getattr(first, "tree", first).start
            _at_name(d, tree, "E0201", name=tree.name, line=d.source.position(start)[0])
            if isinstance(first, Pou):
                continue
        method = Pou(tree.kind, tree.name, tree, d.source, d.library, pou.type, attributes=tree.attributes)
        method.holder = pou
        ascii_name = tree.name if tree.name.isascii() else f"method{len(pou.methods)}"
        method.symbol = f"{pou.symbol}.{ascii_name}{'' if tree.kind == 'METHOD' else '.' + tree.kind.lower()}"
        pou.methods[name] = method
        d.kept_variables(method)
        d.project.postponed.append(lambda method=method: d.method(method))

"""Completion at the prompt: commands, names of the program, members behind a dot."""

from __future__ import annotations

import re
from collections.abc import Iterator

from plcruntime.repl import store
from plcruntime.repl.commands import COMMANDS, split
from plcruntime.repl.session import Session
from stcore import paths
from stcore.paths import PathError
from stcore.program import Program
from stcore.types import BOOL, Block, Enum, Interface, Pointer, Struct

_PATH = re.compile(r"[^\W\d][\w.^]*(?:\[[^\]]*\][\w.^]*)*$|%\w*$")
_TARGET = re.compile(r"([^\W\d][\w.^]*(?:\[[^\]]*\][\w.^]*)*)\s*(?::=|=|<>)\s*$")


def candidates(session: Session, text: str) -> Iterator[tuple[str, int]]:
    """(completion, how many characters before the cursor it replaces) for the text before the cursor."""
    match = _PATH.search(text)
    word = match[0] if match else ""
    before = text[: len(text) - len(word)]
    if not before.strip():
        for name in COMMANDS:
            if name.startswith(word.lower()):
                yield name, len(word)
    options = _arguments(session, before)
    if options is not None:
        for name in options:
            if name.upper().startswith(word.upper()):
                yield name, len(word)
        return
    head, dot, tail = word.rpartition(".")
    if dot:
        for name in _members(session, head):
            if name.upper().startswith(tail.upper()):
                yield name, len(tail)
        return
    for name in _values(session, before):
        if name.upper().startswith(word.upper()):
            yield name, len(word)
    if word:
        for name in sorted(_names(session), key=str.upper):
            if name.upper().startswith(word.upper()):
                yield name, len(word)


def _arguments(session: Session, before: str) -> list[str] | None:
    """What a command takes that is no expression."""
    command, rest = split(before) if before.strip() else ("", "")
    if rest:
        return None
    if command == "help":
        return list(COMMANDS)
    if command == "load":
        return store.names(session.plc)
    if command == "reset":
        return ["warm", "cold", "origin"]
    if command in ("break", "list"):
        return [r.name for r in session.plc.program.routines.values()]
    if command == "unforce":
        return session.plc.forced
    if command == "unwatch":
        return session.watched
    return None


def _values(session: Session, before: str) -> list[str]:
    """What may stand behind `state := ` or `state = `: the names of an ENUM's values, TRUE and FALSE."""
    match = _TARGET.search(before)
    if not match:
        return []
    try:
        kind = session.place(match[1]).type
    except PathError:
        return []
    return list(kind.values) if isinstance(kind, Enum) else ["FALSE", "TRUE"] if kind is BOOL else []


def _members(session: Session, head: str) -> list[str]:
    """The members of what stands before the dot: an instance, a structure, a global list."""
    plc = session.plc
    lists = [v.path.rpartition(".")[2] for k, v in plc.program.variables.items() if k.startswith(head.upper() + ".")]
    try:
        kind = session.place(head).type
    except PathError:
        return lists
    if isinstance(kind, Pointer) and kind.reference:
        kind = kind.target
    if isinstance(kind, Interface):
        return _methods(plc.program, kind)
    if not isinstance(kind, Struct | Block):
        return lists
    return [f.name for f in kind.members.values()] + (_methods(plc.program, kind) if isinstance(kind, Block) else [])


def _methods(program: Program, kind: Block | Interface) -> list[str]:
    """Names of the methods and properties of a block or an interface, the inherited ones, too."""
    bases = kind.bases if isinstance(kind, Interface) else [kind.base] if kind.base is not None else []
    own = [r.name.split(".")[1] for n, r in program.routines.items() if n.startswith(f"{kind.name}.".upper())]
    return list(dict.fromkeys([*own, *(name for base in bases for name in _methods(program, base))]))


def _names(session: Session) -> set[str]:
    """Names that may begin a path, or call something."""
    program = session.plc.program
    names = {v.path.split(".")[0] for v in program.variables.values()}
    names |= {p.name.rpartition(".")[2] for p in paths.user_places(program)}
    names |= {r.name for r in program.routines.values() if r.kind == "FUNCTION"}
    stop = session.debugger.stop
    if stop is not None:
        names |= {name for name, *_ in stop.body.locals}
        if stop.body.block is not None:
            names |= {f.name for f in stop.body.block.members.values()}
    return names

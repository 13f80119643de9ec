"""Which variables survive a restart: RETAIN and PERSISTENT ones, members of instances included.

As in CODESYS: a warm restart keeps both, a cold one only PERSISTENT, an origin reset nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from stcore.program import Program
from stcore.types import Array, Block, Field, Pointer, Struct, Type


@dataclass(slots=True)
class Kept:
    """A variable that is declared RETAIN or PERSISTENT. path: its full name; bit: of a BOOL at a bit address."""

    path: str
    type: Type
    address: int
    persistent: bool
    bit: int | None = None


def kept_variables(program: Program) -> list[Kept]:
    """Every variable that a warm restart keeps. A PERSISTENT member of a RETAIN instance is there besides."""
    found: list[Kept] = []
    for v in program.variables.values():
        if not v.constant:
            _collect(found, Kept(v.path, v.type, v.address, v.persistent, v.bit), v.retain, False)
    unique = {(k.address, k.bit, k.persistent): k for k in reversed(found)}  # VAR_STAT: one for all instances
    return [k for k in found if unique[k.address, k.bit, k.persistent] is k]


def _collect(found: list[Kept], item: Kept, retain: bool, inside: bool) -> None:
    """inside: a variable around this one is kept as RETAIN already."""
    if item.persistent or retain and not inside:
        found.append(item)
    if item.persistent or not _holds_kept(item.type):
        return
    inside = inside or retain
    if isinstance(item.type, Array):
        for index, offset in elements(item.type):
            element = Kept(f"{item.path}[{index}]", item.type.element, item.address + offset, False)
            _collect(found, element, False, inside)
        return
    for f in _members(item.type):
        at = f.offset if f.section == "VAR_STAT" else item.address + f.offset
        _collect(found, Kept(f"{item.path}.{f.name}", f.type, at, f.persistent), f.retain, inside)


@cache
def _holds_kept(t: Type) -> bool:
    """Whether a type has such a member at any depth; spares the walk over the elements of large arrays."""
    if isinstance(t, Array):
        return _holds_kept(t.element)
    if isinstance(t, Struct | Block):
        return any(f.retain or f.persistent or _holds_kept(f.type) for f in _members(t))
    return False


def _members(t: Struct | Block) -> Iterator[Field]:
    """The members that have a value of their own. A constant is never read back: the program may say another now."""
    return (f for f in t.members.values() if f.section not in ("VAR_TEMP", "VAR_IN_OUT") and not f.constant)


def elements(t: Array) -> Iterator[tuple[str, int]]:
    """(index as in a path, offset) of every element of an array."""
    sizes = [high - low + 1 for low, high in t.bounds]
    for i in range(math.prod(sizes)):
        rest, index = i, []
        for (low, _), size in zip(reversed(t.bounds), reversed(sizes), strict=True):
            rest, k = divmod(rest, size)
            index.append(str(low + k))
        yield ",".join(reversed(index)), i * t.element.size


def leaves(kept: Kept) -> Iterator[Kept]:
    """What a kept variable is made of: single values, and arrays of single values. A UNION stays whole."""
    t = kept.type
    if isinstance(t, Array) and isinstance(t.element, Array | Struct | Block):
        for index, offset in elements(t):
            yield from leaves(Kept(f"{kept.path}[{index}]", t.element, kept.address + offset, kept.persistent))
    elif isinstance(t, Struct | Block) and not getattr(t, "union", False):
        for f in _members(t):
            at = f.offset if f.section == "VAR_STAT" else kept.address + f.offset
            yield from leaves(Kept(f"{kept.path}.{f.name}", f.type, at, kept.persistent))
    else:
        yield kept


def is_pointer(t: Type) -> bool:
    """A POINTER or REFERENCE, or an array of them: an address, which means nothing to another build."""
    return isinstance(t, Pointer) or isinstance(t, Array) and isinstance(t.element, Pointer)


# ------------------------------------------------------------------------------------------------- restarts


def remember(program: Program, memory, kind: str) -> list[tuple[Kept, bytes]]:
    """The values that a restart keeps. kind: 'warm', 'cold' or 'origin'."""
    if kind == "origin":
        return []
    kept = [k for k in kept_variables(program) if k.persistent or kind == "warm"]
    return [(k, read(memory, k)) for k in kept]


def put_back(remembered: list[tuple[Kept, bytes]], memory) -> None:
    """Write them into the memory of a machine that was initialised."""
    for kept, data in remembered:
        write(memory, kept, data)


def read(memory, kept: Kept) -> bytes:
    """The bytes of a variable; 0 or 1 of a BOOL at a bit address."""
    if kept.bit is not None:
        return bytes([memory[kept.address] >> kept.bit & 1])
    return bytes(memory[kept.address : kept.address + kept.type.size])


def write(memory, kept: Kept, data: bytes) -> None:
    """Write the bytes of a variable; of a BOOL at a bit address only its bit."""
    if kept.bit is None:
        memory[kept.address : kept.address + len(data)] = data
    else:
        old = memory[kept.address] & ~(1 << kept.bit)
        memory[kept.address] = old | (data[0] & 1) << kept.bit

"""From an address in the image to the path of the instance there."""

from __future__ import annotations

from stcore.program import Body, Program
from stcore.types import Array, Block, Struct, Type


def instance_path(program: Program, body: Body, address: int) -> str:
    """The path of the instance of a block at an address: PLC_PRG.trap; the POU's own name where there is none."""
    if body.block is None or body.block.kind == "PROGRAM":
        return body.pou
    return path_at(program, body.block, address) or body.pou


def path_at(program: Program, wanted: Block | Struct, address: int) -> str | None:
    """The path of the variable of a type that begins at an address."""
    for variable in program.variables.values():
        if variable.address <= address < variable.address + variable.type.size:
            found = _inside(variable.type, variable.address, variable.path, wanted, address)
            if found:
                return found
    return None


def _inside(kind: Type, at: int, path: str, wanted: Block | Struct, address: int) -> str | None:
    """The path of the instance of type `wanted` at an address within a variable."""
    if kind is wanted and at == address:
        return path
    if isinstance(kind, Array) and kind.element.size:
        index = (address - at) // kind.element.size
        indices, rest = [], index
        for low, high in reversed(kind.bounds):
            rest, k = divmod(rest, high - low + 1)
            indices.append(str(low + k))
        name = f"{path}[{','.join(reversed(indices))}]"
        return _inside(kind.element, at + index * kind.element.size, name, wanted, address)
    if isinstance(kind, Struct | Block):
        for member in kind.members.values():
            begin = at + member.offset
            if member.section in ("VAR_IN_OUT", "VAR_TEMP", "VAR_STAT"):
                continue
            if begin <= address < begin + member.type.size:
                return _inside(member.type, begin, f"{path}.{member.name}", wanted, address)
    return None

"""Paths: from what a user types to where a variable lives (``PLC_PRG.trap.acc``, ``arr[3]``, ``%MW4``, ``x.3``).

Names are not case-sensitive. A name without its program is found when it is unique; a name that the user's programs
do not have is looked for in the library's global lists, so that ``Axis[1].prfPos`` means ``SIM.Axis[1].prfPos``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from stcore.program import NULL_PAGE, Program, Variable
from stcore.types import ELEMENTARY, Array, Block, Elementary, Field, Pointer, Struct, Type, base_of


class PathError(KeyError):
    """A path that names no variable, or more than one, or one that can't be reached now (a NULL pointer)."""

    def __str__(self) -> str:
        return self.args[0]


@dataclass(slots=True)
class Place:
    """Where a variable lives. name: its full path; bit: the bit of the byte at its address, None for whole bytes.
    read_only: by the VAR_ACCESS whose name was used.

    hops: for each pointer on the way, what to add to the address that it holds: `address` is then the first pointer's.
    """

    name: str
    type: Type
    address: int
    bit: int | None = None
    hops: tuple[int, ...] = ()
    constant: bool = False
    read_only: bool = False

    @property
    def size(self) -> int:
        """Bytes in memory."""
        return self.type.size

    def locate(self, memory) -> int:
        """The address in the memory as it is now. Raises PathError for a NULL or wild pointer on the way."""
        address = self.address
        for offset in self.hops:
            target = int.from_bytes(memory[address : address + 4], "little")
            if target < NULL_PAGE:
                raise PathError(f"{self.name}: a pointer on the way is NULL (not connected yet)")
            address = target + offset
            if address + self.type.size > len(memory):
                raise PathError(f"{self.name}: a pointer on the way leads out of the memory (16#{target:X})")
        return address

    def _at(self, name: str, t: Type, offset: int, constant: bool = False) -> Place:
        constant = constant or self.constant
        if self.hops:
            hops = (*self.hops[:-1], self.hops[-1] + offset)
            return Place(name, t, self.address, None, hops, constant, self.read_only)
        return Place(name, t, self.address + offset, None, (), constant, self.read_only)

    def _through(self, name: str, t: Type) -> Place:
        """What the pointer at this place points to."""
        return Place(name, t, self.address, None, (*self.hops, 0))


# ------------------------------------------------------------------------------------------------- reading

_TOKEN = re.compile(
    r"\s*(?:(?P<name>[^\W\d]\w*)|\[(?P<index>[^\]]*)\]|(?P<deref>\^)|\.\s*(?:(?P<bit>\d+)|%(?P<part>[XBWDxbwd])(?P<number>\d+)"
    r"|(?P<dot>(?=[^\W\d]))))"
)  # fmt: skip
_DIRECT = re.compile(r"%([IQM])([XBWDL]?)(\d+)(?:\.(\d+))?$", re.IGNORECASE)
_SIZES = {"X": 1, "": 1, "B": 1, "W": 2, "D": 4, "L": 8}
_BITS = {1: "BYTE", 2: "WORD", 4: "DWORD", 8: "LWORD"}
Step = tuple  # ("name", text) ("index", [3]) ("deref",) ("part", "X", 3)


def _steps(path: str) -> list[Step]:
    steps: list[Step] = []
    at, after_dot = 0, True
    text = path.rstrip()
    while at < len(text):
        m = _TOKEN.match(text, at)
        if not m or bool(m["name"]) != after_dot and (m["name"] or after_dot):
            raise PathError(f"'{path}' is not the path of a variable: can't read it from '{text[at:]}' on")
        after_dot = m["dot"] is not None
        if m["name"]:
            steps.append(("name", m["name"]))
        elif m["index"] is not None:
            steps.append(("index", _indices(path, m["index"])))
        elif m["deref"]:
            steps.append(("deref",))
        elif m["bit"]:
            steps.append(("part", "X", int(m["bit"])))
        elif m["part"]:
            steps.append(("part", m["part"].upper(), int(m["number"])))
        at = m.end()
    if not steps or after_dot:
        raise PathError(f"'{path}' is not the path of a variable")
    return steps


def _indices(path: str, text: str) -> list[int]:
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise PathError(f"{path}: the index '{text}' is not a number") from None


# ----------------------------------------------------------------------------------------------- resolving


def resolve(program: Program, path: str) -> Place:
    """The place of a path. Raises PathError: unknown (with the nearest names) or ambiguous (with the candidates)."""
    if path.lstrip().startswith("%"):
        return _direct(program, path.strip())
    steps = _steps(path)
    if steps[0][0] != "name":
        raise PathError(f"'{path}' is not the path of a variable")
    first_error = None
    for candidates in _roots(program, steps):
        found: dict[str, Place] = {}
        for place, rest in candidates:
            try:
                place = _walk(program, place, rest)
                found[place.name] = place
            except PathError as error:
                first_error = first_error or error
        if len(found) == 1:
            return next(iter(found.values()))
        if found:
            raise PathError(f"'{path}' is ambiguous: {', '.join(found)}")
    if first_error:
        raise first_error
    raise PathError(f"unknown variable '{path}'{_near(steps[0][1], _known(program))}")


def _roots(program: Program, steps: list[Step]) -> Iterator[list[tuple[Place, list[Step]]]]:
    """Where a path may begin, the best first: as written, in the user's programs and lists, in the library's."""
    exact = []
    first = steps[0][1].upper()
    if len(steps) > 1 and steps[1][0] == "name":
        variable = program.variables.get(f"{first}.{steps[1][1].upper()}")
        if variable:
            exact.append((_root(variable), steps[2:]))
    if not exact and first in program.variables:
        exact.append((_root(program.variables[first]), steps[1:]))
    if not exact and first in program.accesses:
        path, read_only = program.accesses[first]
        place = resolve(program, path)
        exact.append((replace(place, read_only=read_only), steps[1:]))
    if not exact and first in program.aliases:
        place = resolve(program, program.aliases[first])
        exact.append((place, steps[1:]))
    yield exact
    user = [(_root(v), steps) for v in program.programs() if first in v.type.members]
    user += [(_root(v), steps[1:]) for v in _ending(program, first) if not v.library]
    yield user
    yield [(_root(v), steps[1:]) for v in _ending(program, first) if v.library]


def _ending(program: Program, name: str) -> list[Variable]:
    """The variables of global lists that are called `name` (upper case)."""
    return [v for key, v in program.variables.items() if key.endswith("." + name)]


def _root(v: Variable) -> Place:
    return Place(v.path, v.type, v.address, v.bit, (), v.constant)


def _walk(program: Program, place: Place, steps: list[Step]) -> Place:
    for step in steps:
        if isinstance(place.type, Pointer) and place.type.reference and step[0] != "deref":
            place = place._through(place.name, place.type.target)
        kind = step[0]
        if kind == "name":
            _no_code(program, place, step[1])
            place = member(place, step[1])
        elif kind == "index":
            place = _element(place, step[1])
        elif kind == "deref":
            if not isinstance(place.type, Pointer):
                raise PathError(f"{place.name} is {place.type}, not a pointer")
            place = place._through(place.name + "^", place.type.target)
        else:
            place = _part(place, step[1], step[2])
    if isinstance(place.type, Pointer) and place.type.reference:
        place = place._through(place.name, place.type.target)
    return place


def _no_code(program: Program, place: Place, name: str) -> None:
    """Raises PathError for a property or a method: it has no memory, its value comes from code."""
    block = place.type if isinstance(place.type, Block) else getattr(place.type, "target", None)
    while isinstance(block, Block) and block.base is not None and name.upper() not in block.members:
        if _is_code(program, block, name):
            break
        block = block.base
    if isinstance(block, Block) and _is_code(program, block, name):
        call = f"{place.name}.{name}"
        raise PathError(f"{call} is code, not a variable: type it at the prompt, or plc.evaluate('{call}')")


def _is_code(program: Program, block: Block, name: str) -> bool:
    names = (f"{block.name}.{name}{accessor}".upper() for accessor in ("", ".GET", ".SET"))
    return name.upper() not in block.members and any(n in program.routines for n in names)


def member(place: Place, name: str) -> Place:
    """A member of a structure or an instance; a VAR_IN_OUT is followed to the variable that it stands for."""
    if not isinstance(place.type, Struct | Block):
        raise PathError(f"{place.name} is {place.type} and has no member {name}")
    members = place.type.members
    found = members.get(name.upper()) or next((f for f in members.values() if f.also == name.upper()), None)
    if not found:
        raise PathError(
            f"{place.name} has no variable {name}{_near(name, [f.name for f in place.type.members.values()])}"
        )
    return of_field(place, found)


def of_field(place: Place, found: Field) -> Place:
    """The place of a member of a structure or an instance at `place`."""
    name = f"{place.name}.{found.name}"
    if found.section == "VAR_STAT":
        return Place(name, found.type, found.offset, None, (), found.constant)
    if not found.by_reference:
        return place._at(name, found.type, found.offset, found.constant)
    if isinstance(found.type, Array) and not found.type.bounds:
        raise PathError(f"{name} is {found.type}: it has a size only while its block runs")
    return place._at(name, found.type, found.offset)._through(name, found.type)


def _element(place: Place, indices: list[int]) -> Place:
    name = f"{place.name}[{','.join(map(str, indices))}]"
    t = place.type
    if isinstance(t, Pointer) and len(indices) == 1:
        return place._through(name, t.target)._at(name, t.target, indices[0] * t.target.size)
    if not isinstance(t, Array):
        raise PathError(f"{place.name} is {t}, not an array")
    if len(indices) != len(t.bounds):
        raise PathError(f"{place.name} is {t}: {len(t.bounds)} indices, not {len(indices)}")
    for i, (low, high) in zip(indices, t.bounds, strict=True):
        if not low <= i <= high:
            raise PathError(f"{name}: index {i} is not in {low}..{high}")
    return place._at(name, t.element, t.number_of(indices) * t.element.size)


def _part(place: Place, size: str, number: int) -> Place:
    """Bit `number` of a place, or one of its bytes, words, double words."""
    t = base_of(place.type)
    name = f"{place.name}.{number}" if size == "X" else f"{place.name}.%{size}{number}"
    if not isinstance(t, Elementary) or t.kind not in ("int", "bits") or place.bit is not None:
        raise PathError(f"{place.name} is {place.type} and has no bits")
    width = 1 if size == "X" else _SIZES[size] * 8
    if (number + 1) * width > t.bits:
        raise PathError(f"{name}: {place.name} is {place.type}, its last is {t.bits // width - 1}")
    if size == "X":
        part = place._at(name, ELEMENTARY["BOOL"], number // 8)
        part.bit = number % 8
        return part
    return place._at(name, ELEMENTARY[_BITS[_SIZES[size]]], number * _SIZES[size])


def _direct(program: Program, path: str) -> Place:
    m = _DIRECT.match(path)
    if not m:
        raise PathError(f"'{path}' is not a direct address; write %IX0.3, %QB1, %MW4")
    area, size, number, bit = m[1].upper(), m[2].upper(), int(m[3]), m[4]
    start, length = {"I": program.inputs, "Q": program.outputs, "M": program.markers}[area]
    width = _SIZES[size]
    if (number + 1) * width > length:
        raise PathError(f"{path} lies outside %{area}, which has {length} bytes")
    name = path.upper()
    if size in ("X", ""):
        if bit is None or int(bit) > 7:
            raise PathError(f"{path}: a bit address needs its bit, 0 to 7: %{area}X{number}.0")
        return Place(name, ELEMENTARY["BOOL"], start + number, int(bit))
    whole = Place(name, ELEMENTARY[_BITS[width]], start + number * width)
    return whole if bit is None else _part(whole, "X", int(bit))


# ------------------------------------------------------------------------------------------------- listing


def user_places(program: Program) -> list[Place]:
    """Every variable of the user's programs and global lists, without their members' members."""
    places = []
    for v in program.variables.values():
        if v.library:
            continue
        if isinstance(v.type, Block) and v.type.kind == "PROGRAM":
            fields = (f for f in v.type.members.values() if f.section != "VAR_TEMP")
            places += [of_field(_root(v), f) for f in fields if not f.by_reference]
        else:
            places.append(_root(v))
    return places


def around(program: Program, address: int) -> list[Place]:
    """What lies around an address: the user's variable, its member, that one's member, and so on inwards."""
    for v in program.variables.values():
        if not v.library and v.address <= address < v.address + v.type.size:
            whole = _root(v)
            return [*([] if getattr(v.type, "kind", "") == "PROGRAM" else [whole]), *_inwards(whole, address)]
    return []


def instance_at(program: Program, wanted: Block | Struct, address: int) -> str:
    """The path of the user's block instance or structure that begins at an address; "" where none does."""
    return next((p.name for p in around(program, address) if p.type is wanted and p.address == address), "")


def _inwards(place: Place, address: int) -> Iterator[Place]:
    while True:
        inner, t = None, place.type
        if isinstance(t, Array):
            inner = _element(place, _indices_of(t, (address - place.address) // t.element.size))
        elif isinstance(t, Struct | Block):
            own = (of_field(place, f) for f in t.members.values()
                   if not f.by_reference and f.section not in ("VAR_TEMP", "VAR_STAT"))  # fmt: skip
            inner = next((p for p in own if p.address <= address < p.address + p.size), None)
        if inner is None:
            return
        place = inner
        yield place


def small_places(program: Program, most: int) -> tuple[list[Place], list[str]]:
    """Every variable of the user down to members, but no array of more than `most` elements; and the names of those."""
    found: list[Place] = []
    left_out: list[str] = []
    todo = user_places(program)[::-1]
    while todo:
        place = todo.pop()
        t = place.type
        if isinstance(t, Array) and t.element.size and t.size // t.element.size > most:
            left_out.append(place.name)
        elif isinstance(t, Struct | Block):
            fields = [f for f in t.members.values() if not f.by_reference and f.section not in ("VAR_TEMP", "VAR_STAT")]
            todo += [of_field(place, f) for f in fields[::-1]]
        else:
            found.append(place)
    return found, left_out


def is_scalar(place: Place) -> bool:
    """True for numbers, BOOL, times, ENUM: what a trace can hold in one column of numbers."""
    t = base_of(place.type)
    return isinstance(t, Elementary) and t.kind != "char"


def leaves(place: Place, own: Callable[[Block], bool] = lambda _: True) -> Iterator[Place]:
    """The place itself when it is no array, structure or instance; else all that it is made of. own: whether that goes
    for the inner variables of a block, too; else it is its inputs and outputs."""
    t = place.type
    if isinstance(t, Array):
        for i in range(t.size // t.element.size if t.element.size else 0):
            yield from leaves(_element(place, _indices_of(t, i)), own)
    elif isinstance(t, Struct | Block):
        outer_only = isinstance(t, Block) and not own(t)
        for f in t.members.values():
            inner = f.section in ("VAR_TEMP", "VAR_STAT") or outer_only and f.section not in ("VAR_INPUT", "VAR_OUTPUT")
            if not f.by_reference and not inner:
                yield from leaves(of_field(place, f), own)
    else:
        yield place


def _indices_of(t: Array, number: int) -> list[int]:
    """The indices of the element of an array that comes `number` elements after the first."""
    indices = []
    for low, high in reversed(t.bounds):
        number, k = divmod(number, high - low + 1)
        indices.append(low + k)
    return indices[::-1]


def _known(program: Program) -> list[str]:
    names = [v.path for v in program.variables.values() if not v.library]
    names += [v.path.rsplit(".", 1)[-1] for v in program.variables.values() if not v.library]
    for v in program.programs():
        names += [f.name for f in v.type.members.values()]
    return names


def _near(name: str, known: list[str]) -> str:
    from stcore.near import near  # only a mistake needs it, and what it imports

    hint = near(name, known)
    return f"; {hint}" if hint else ""

"""Values: between bytes of the memory image and Python.

BOOL is bool; integers, bit strings, enums and pointers are int; REAL and LREAL are float; TIME, DATE, DT and TOD are
seconds as float (DATE and DT since 1970-01-01 00:00, TOD since midnight); strings are str; arrays are lists, nested
when they have several dimensions; structures and instances are dicts by member name.
"""

from __future__ import annotations

import math
import re
import struct
from operator import index

from stcore.paths import PathError, Place, resolve
from stcore.program import Program
from stcore.syntax import ArrayInit, Literal, Member, Name, Node, StructInit, Unary
from stcore.types import (
    ELEMENTARY,
    Array,
    Block,
    Elementary,
    Enum,
    Pointer,
    String,
    Struct,
    SubrangeType,
    Type,
    base_of,
)

FORMATS = {
    "BOOL": "?", "SINT": "b", "INT": "h", "DINT": "i", "LINT": "q", "USINT": "B", "UINT": "H", "UDINT": "I",
    "ULINT": "Q", "BYTE": "B", "WORD": "H", "DWORD": "I", "LWORD": "Q", "REAL": "f", "LREAL": "d", "TIME": "I",
    "LTIME": "q", "DATE": "I", "TOD": "I", "DT": "I", "LDATE": "q", "LTOD": "q", "LDT": "q", "CHAR": "B", "WCHAR": "H",
}  # fmt: skip
PER_SECOND = {
    "TIME": 1000,
    "LTIME": 10**9,
    "DATE": 1,
    "TOD": 1000,
    "DT": 1,
    "LDATE": 10**9,
    "LTOD": 10**9,
    "LDT": 10**9,
}
_NUMBERS = ("int", "bits", "real")
_CODECS = {name: struct.Struct("<" + code) for name, code in FORMATS.items()}


class Nanoseconds(int):
    """A duration or a moment as an ST literal gives it, exact; where a number in seconds may stand."""


class Partial(list):
    """The values of an array from its first element on; the rest stays as it is (an ST initialiser)."""


# ------------------------------------------------------------------------------------------------ decoding


def read(memory, place: Place):
    """The value at a place. Raises PathError when a pointer on the way is NULL."""
    address = place.locate(memory)
    if place.bit is not None:
        return bool(memory[address] >> place.bit & 1)
    return decode(memory, place.type, address)


def decode(memory, t: Type, address: int):
    """The Python value of type t at an address. Members that are VAR_IN_OUT or VAR_TEMP are left out of a dict."""
    if isinstance(t, Elementary):
        value = _CODECS[t.name].unpack_from(memory, address)[0]
        if t.kind in ("time", "date"):
            return value / PER_SECOND[t.name]
        return chr(value) if t.kind == "char" else value
    if isinstance(t, Enum | SubrangeType):
        return decode(memory, t.base, address)
    if isinstance(t, String):
        return _text(bytes(memory[address : address + t.size]), t.wide)
    if isinstance(t, Pointer):
        return int.from_bytes(memory[address : address + 4], "little")
    if isinstance(t, Array):
        return _nested(_elements(memory, t, address), [high - low + 1 for low, high in t.bounds])
    if isinstance(t, Struct | Block):
        return {
            f.name: decode(memory, f.type, f.offset if f.section == "VAR_STAT" else address + f.offset)
            for f in t.members.values()
            if not f.by_reference and f.section != "VAR_TEMP"
        }
    raise TypeError(f"a value of type {t} has no form in Python")


def _elements(memory, t: Array, address: int) -> list:
    e = t.element
    count = t.size // e.size if e.size else 0
    if isinstance(e, Elementary) and e.kind in ("bool", "int", "bits", "real"):
        return list(struct.unpack_from(f"<{count}{FORMATS[e.name]}", memory, address))
    return [decode(memory, e, address + i * e.size) for i in range(count)]


def _nested(flat: list, dims: list[int]) -> list:
    for size in reversed(dims[1:]):
        flat = [flat[i : i + size] for i in range(0, len(flat), size)]
    return flat


def _text(data: bytes, wide: bool) -> str:
    if wide:
        units = struct.unpack(f"<{len(data) // 2}H", data)
        units = units[: units.index(0)] if 0 in units else units
        return struct.pack(f"<{len(units)}H", *units).decode("utf-16-le", errors="replace")
    data = data.split(b"\0", 1)[0]
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


# ------------------------------------------------------------------------------------------------ encoding


def encode(memory, place: Place, value) -> list[tuple[int, bytes]]:
    """What to write where, so that the place holds the value: (address, bytes) pieces; nothing is written yet.

    A dict may name only some members; a list gives all elements. Raises TypeError or ValueError, naming path, type
    and range, and PathError for a member that does not exist; then nothing of the value has been taken.
    """
    address = place.locate(memory)
    if place.bit is not None:
        bit = 1 << place.bit
        old = memory[address]
        return [(address, bytes([old | bit if _bool(place.name, value) else old & ~bit]))]
    pieces: list[tuple[int, bytes]] = []
    _encode(pieces, place.name, place.type, address, value)
    return pieces


def _encode(pieces: list, path: str, t: Type, address: int, value) -> None:
    if isinstance(t, Array):
        for i, element in enumerate(_flat(path, t, value)):
            _encode(pieces, f"{path}[{_index_text(t, i)}]", t.element, address + i * t.element.size, element)
    elif isinstance(t, Struct | Block):
        if not isinstance(value, dict):
            raise TypeError(f"{path} is {t}: it takes a dict of its members, not {_shown(value)}")
        for name, item in value.items():
            f = t.members.get(str(name).upper())
            if f is None or f.by_reference:
                raise PathError(
                    f"{path} has no variable {name}; it has {', '.join(m.name for m in t.members.values())}"
                )
            at = f.offset if f.section == "VAR_STAT" else address + f.offset
            _encode(pieces, f"{path}.{f.name}", f.type, at, item)
    else:
        pieces.append((address, _scalar(path, t, value)))


def _scalar(path: str, t: Type, value) -> bytes:
    if isinstance(t, String):
        return _string(path, t, value)
    if isinstance(t, Pointer):
        return _integer(path, t, value, 0, 0xFFFFFFFF).to_bytes(4, "little")
    if isinstance(t, Enum):
        return _enum(path, t, value)
    if isinstance(t, SubrangeType):
        return _CODECS[t.base.name].pack(_integer(path, t, value, t.low, t.high))
    codec = _CODECS[t.name]
    if t.kind == "bool":
        return codec.pack(_bool(path, value))
    if t.kind == "real":
        return _real(path, t, value, codec)
    if t.kind in ("time", "date"):
        return codec.pack(_ticks(path, t, value))
    if t.kind == "char":
        if not isinstance(value, str) or len(value) != 1 or ord(value) > t.high:
            raise TypeError(f"{path} is {t}: it takes one character, not {_shown(value)}")
        return codec.pack(ord(value))
    return codec.pack(_integer(path, t, value, t.low, t.high))


def _bool(path: str, value) -> bool:
    # numpy's bool is neither bool nor int, but it is an index
    try:
        number = index(value) if not isinstance(value, str) else None
    except TypeError:
        number = int(value) if type(value).__name__ == "bool_" or type(value).__name__ == "bool" else None
    if number is None:
        raise TypeError(f"{path} is BOOL: it takes TRUE or FALSE, not {_shown(value)}")
    if number not in (0, 1):
        raise ValueError(f"{path} is BOOL: it takes TRUE or FALSE, not {_shown(value)}")
    return bool(number)


def _integer(path: str, t: Type, value, low: int, high: int) -> int:
    try:
        if isinstance(value, bool | Nanoseconds):
            raise TypeError
        number = index(value)
    except TypeError:
        raise TypeError(f"{path} is {t}: it takes a whole number, not {_shown(value)}") from None
    if not low <= number <= high:
        raise ValueError(f"{path} is {t}: {number} is not in {low}..{high}")
    return number


def _number(path: str, t: Type, value) -> float:
    if isinstance(value, bool | str | bytes | Nanoseconds):
        raise TypeError(f"{path} is {t}: it takes a number, not {_shown(value)}")
    try:
        return float(value)
    except TypeError:
        raise TypeError(f"{path} is {t}: it takes a number, not {_shown(value)}") from None


def _real(path: str, t: Elementary, value, codec: struct.Struct) -> bytes:
    try:
        return codec.pack(_number(path, t, value))
    except OverflowError:
        raise ValueError(f"{path} is {t}: {_shown(value)} is too large for it") from None


def _ticks(path: str, t: Elementary, value) -> int:
    """value in the units of a time or date type, from exact nanoseconds, seconds or a timedelta."""
    unit = PER_SECOND[t.name]
    if isinstance(value, Nanoseconds):
        ticks = int(value) * unit // 10**9
    else:
        seconds = value.total_seconds() if hasattr(value, "total_seconds") else _number(path, t, value)
        if not math.isfinite(seconds):
            raise ValueError(f"{path} is {t}: {seconds} is not a time")
        ticks = round(seconds * unit)
    if not t.low <= ticks <= t.high:
        raise ValueError(f"{path} is {t}: {_shown(value)} is not in {t.low / unit:.10g}..{t.high / unit:.10g} s")
    return ticks


def _string(path: str, t: String, value) -> bytes:
    if isinstance(value, bytes) and not t.wide:
        data = value
    elif isinstance(value, str):
        data = value.encode("utf-16-le" if t.wide else "utf-8")
    else:
        raise TypeError(f"{path} is {t}: it takes a str, not {_shown(value)}")
    unit = 2 if t.wide else 1
    if len(data) > t.length * unit:
        raise ValueError(f"{path} is {t}: the text has {len(data) // unit} characters")
    return data + bytes(unit)


def _enum(path: str, t: Enum, value) -> bytes:
    if isinstance(value, str):
        labels = {label.upper(): number for label, number in t.values.items()}
        if value.upper() not in labels:
            raise ValueError(f"{path} is {t}: it has no value {value}; it has {', '.join(t.values)}")
        value = labels[value.upper()]
    return _CODECS[t.base.name].pack(_integer(path, t, value, t.base.low, t.base.high))


def _flat(path: str, t: Array, value) -> list:
    """The elements of an array in memory order, from nested lists, or one list of all."""
    if isinstance(value, str | bytes | dict) or not hasattr(value, "__len__"):
        raise TypeError(f"{path} is {t}: it takes a list, not {_shown(value)}")
    count = math.prod(high - low + 1 for low, high in t.bounds)
    if len(t.bounds) > 1 and not (len(value) == count and not hasattr(value[0], "__len__")):
        rows = t.bounds[0][1] - t.bounds[0][0] + 1
        if isinstance(value, Partial) and not any(isinstance(v, list) for v in value):
            return value
        if len(value) != rows:
            raise ValueError(f"{path} is {t}: {rows} rows, not {len(value)}")
        inner = Array(t.element, t.bounds[1:])
        return [v for i, row in enumerate(value) for v in _flat(f"{path}[{t.bounds[0][0] + i}]", inner, row)]
    if len(value) > count or len(value) < count and not isinstance(value, Partial):
        raise ValueError(f"{path} is {t}: {count} elements, not {len(value)}")
    return list(value)


def _index_text(t: Array, i: int) -> str:
    parts = []
    for low, high in reversed(t.bounds):
        i, k = divmod(i, high - low + 1)
        parts.append(str(low + k))
    return ",".join(reversed(parts))


# ------------------------------------------------------------------------------------------------ literals

_DECIMAL = re.compile(r"[+-]?[0-9]+(\.[0-9]+([eE][+-]?[0-9]+)?)?")
_TIMES = {"TIME", "LTIME"}
_UNITS = {"DATE": 10**9, "DT": 10**9, "TOD": 10**6, "LDATE": 1, "LDT": 1, "LTOD": 1, "TIME": 1, "LTIME": 1}  # ns


def literal(program: Program, memory, node: Node, t: Type, path: str):
    """The Python value, for `encode`, of an ST literal that shall be stored in `path`, of type t.

    node: as stcore.parser.parse_initializer gives it. Raises TypeError or ValueError as encode does.
    """
    if isinstance(node, ArrayInit):
        if not isinstance(t, Array):
            raise TypeError(f"{path} is {t}, not an array")
        values = Partial()
        for count, item in node.items:
            times = literal(program, memory, count, ELEMENTARY["DINT"], path) if count is not None else 1
            values += [literal(program, memory, item, t.element, path)] * times
        return values
    if isinstance(node, StructInit):
        return _members(program, memory, node, t, path)
    if isinstance(node, Unary) and node.op in "+-":
        value = literal(program, memory, node.operand, t, path)
        return value if node.op == "+" else type(value)(-value)
    if isinstance(node, Name | Member):
        return _named(program, memory, node, t, path)
    if isinstance(node, Literal):
        return _literal(node, base_of(t), path)
    raise TypeError(f"{path} is {t}: it takes a literal, not an expression")


def plain_literal(text: str) -> Literal | None:
    """The node of TRUE, FALSE or a decimal number, None for anything else: most values need no parser, whose import
    takes longer than a short run."""
    text = text.strip()
    if text.upper() in ("TRUE", "FALSE"):
        return Literal(0, len(text), text.upper() == "TRUE", "BOOL", text)
    if _DECIMAL.fullmatch(text):
        return Literal(0, len(text), float(text) if "." in text else int(text), None, text)
    return None


def _members(program: Program, memory, node: StructInit, t: Type, path: str) -> dict:
    if not isinstance(t, Struct | Block):
        raise TypeError(f"{path} is {t} and has no members")
    values = {}
    for arg in node.items:
        member = t.members.get((arg.name or "").upper())
        if member is None:
            raise PathError(
                f"{path} has no variable {arg.name}; it has {', '.join(m.name for m in t.members.values())}"
            )
        values[member.name] = literal(program, memory, arg.value, member.type, f"{path}.{member.name}")
    return values


def _named(program: Program, memory, node: Name | Member, t: Type, path: str):
    """An enum's label, else the value of the constant or variable of that name."""
    if isinstance(t, Enum) and node.name.upper() in (label.upper() for label in t.values):
        return node.name
    text, base = node.name, node
    while isinstance(base, Member):
        base = base.base
        text = f"{base.name}.{text}"
    try:
        return read(memory, resolve(program, text))
    except PathError as error:
        raise PathError(f"{path} is {t}{_takes(t)}; {error}") from None


def _takes(t: Type) -> str:
    """What a variable of a type may be given, for somebody who wrote a word."""
    if isinstance(t, Enum):
        return f": it takes {', '.join(t.values)}"
    base = base_of(t)
    if isinstance(base, String):
        quote = '"' if base.wide else "'"
        return f": it takes a text in {quote}{quote}"
    if not isinstance(base, Elementary):
        return ""
    return ": it takes TRUE or FALSE" if base.kind == "bool" else ": it takes a number" if base.kind in _NUMBERS else ""


def _literal(node: Literal, t: Type, path: str):
    """The value of a literal for an elementary type or a string, after the checks that Python's types don't make."""
    name = node.type_name
    is_time = name in _UNITS
    wants = t.kind if isinstance(t, Elementary) else ""
    if wants == "time" and name not in _TIMES:
        raise TypeError(f"{path} is {t}: it takes a time such as T#500ms, not {node.text}")
    if wants == "date" and (not is_time or name in _TIMES):
        raise TypeError(
            f"{path} is {t}: it takes a date or time of day such as DT#2026-01-31-12:00:00, not {node.text}"
        )
    if is_time and wants not in ("time", "date"):
        raise TypeError(f"{path} is {t}: it can't hold {node.text}")
    if not is_time:
        return node.value
    return Nanoseconds(node.value * _UNITS[name])


def _shown(value) -> str:
    if isinstance(value, Nanoseconds):
        return f"T#{int(value) / 10**6:.15g}ms"
    if isinstance(value, bool):
        return str(value).upper()
    text = repr(value)
    kind = "" if isinstance(value, int | float | str) else f" ({type(value).__name__})"
    return f"{text if len(text) <= 40 else text[:37] + '...'}{kind}"

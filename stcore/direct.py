"""Direct addresses: %IX0.0, %QW2, %MD4."""

from __future__ import annotations

from collections.abc import Callable

from stcore import types as t
from stcore.scope import Var

DIRECT_SIZES = {"X": 0, "B": 1, "W": 2, "D": 4, "L": 8}


def parse_direct(text: str) -> tuple[str, int, int | None, int] | None:
    """'%QX1.3' -> ('Q', 1, 3, 0); '%MW4' -> ('M', 8, None, 2); None if it is no direct address."""
    body = text.upper().lstrip("%")
    if not body or body[0] not in "IQM":
        return None
    area, rest = body[0], body[1:]
    letter = rest[0] if rest and rest[0] in DIRECT_SIZES else "X"
    numbers = (rest[1:] if rest and rest[0] in DIRECT_SIZES else rest).split(".")
    if not all(n.isdigit() for n in numbers) or len(numbers) > (2 if letter == "X" else 1):
        return None
    first = int(numbers[0])
    if letter == "X":
        byte, bit = (first, int(numbers[1])) if len(numbers) == 2 else divmod(first, 8)
        return (area, byte, bit, 0) if bit < 8 else None
    size = DIRECT_SIZES[letter]
    return area, first * size, None, size


def place_direct(var: Var, address: str, wrong: Callable[[], None]) -> None:
    """AT %IX0.0: put the variable into its area."""
    place = parse_direct(address)
    if place is None:
        wrong()
        place = ("M", 0, None, var.type.size)
    var.storage = "area"
    var.area, var.address, var.bit, size = place
    if var.type is not t.BOOL:
        var.bit = None

"""What a motion program is compiled to: commands of at most one operation each, functions and variables."""

from __future__ import annotations

from dataclasses import dataclass, field

MOST = 1024  # variables of a function, global variables
MOST_COMMANDS = 4096
MOST_FUNCTIONS = 32
MOST_NAMES = 2048  # functions and variables together: GtMotion.symbol
LONGEST_NAME = 31  # of GtMotionSymbol and TVarInfo
ONE = 1 << 16  # 1.0 in fixed point
CONSTANT, GLOBAL, LOCAL = 0, 1, 2  # mode of an operand
MOVE, TO_DOUBLE, TO_INT, NEG, NOT, BIT_NOT = 1, 2, 3, 4, 5, 6
ARITHMETIC = {"+": 10, "-": 11, "*": 12, "/": 13, "%": 14}  # of int; 10 more for double
LOGIC = {"&&": 30, "||": 31}
COMPARE = {">": 32, "<": 33, "==": 34, ">=": 35, "<=": 36, "!=": 37}
BITS = {"&": 40, "|": 41, "^": 42, "<<": 43, ">>": 44}
GOTO, IF_GOTO, RETURN, IF_RETURN, CALL, ARG = 50, 51, 52, 53, 60, 61


class MotionError(Exception):
    """A mistake in a motion program. line: from 1."""

    def __init__(self, line: int, message: str) -> None:
        super().__init__(message)
        self.line, self.message = line, message


@dataclass(slots=True)
class Operand:
    """A constant (value), a variable (index), or an element that another variable (by, at) chooses of `length`."""

    mode: int = CONSTANT
    index: int = 0
    by: int = 0
    at: int = 0
    length: int = 0
    value: int = 0


@dataclass(slots=True)
class Command:
    op: int
    line: int
    dst: Operand = field(default_factory=Operand)
    a: Operand = field(default_factory=Operand)
    b: Operand = field(default_factory=Operand)


@dataclass(slots=True)
class Variable:
    name: str
    type: str
    mode: int
    index: int
    length: int = 0  # 0: no array


@dataclass(slots=True)
class Function:
    name: str
    type: str
    entry: int
    variables: dict[str, Variable] = field(default_factory=dict)
    size: int = 0


@dataclass(slots=True)
class Unit:
    """What a file has become. variables: the global ones."""

    commands: list[Command] = field(default_factory=list)
    functions: dict[str, Function] = field(default_factory=dict)
    variables: dict[str, Variable] = field(default_factory=dict)
    size: int = 0

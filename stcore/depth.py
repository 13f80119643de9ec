"""How deep the tree of a program may be, and room for the compiler to go down it.

The parser has stacks of its own; checker and emitter call themselves for each level, three Python calls or so each.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator

OPERANDS = 2000  # of one expression without brackets: a level each
STEPS = 400  # of a path, a.b[i]^.c, of signs in a row, of assignments in a row
STACK = 2500  # entries of the parser's stack; a level of brackets or statements takes two to seven
_CALLS = 20_000  # Python's default of 1000 would end at the 300th operand


@contextlib.contextmanager
def room() -> Iterator[None]:
    """Let functions call each other as deep as the trees that the parser lets through need."""
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, _CALLS))
    try:
        yield
    finally:
        sys.setrecursionlimit(limit)

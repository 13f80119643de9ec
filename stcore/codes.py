"""The table of problem codes: one line per problem, message and hint; ``explain`` prints the page of a code.

E01.. lexing and parsing, W01.. mends of printed listings (errors under --strict), E02.. declarations and types,
E03.. names and expressions, W03.. conversions that may lose something, E04.. calls, E05.. statements,
E06.. constants and initial values, E07.. files and projects, F.... faults of a running program.
"""

from __future__ import annotations

from typing import NamedTuple


class Code(NamedTuple):
    message: str
    hint: str = ""


CODES: dict[str, Code] = {
    # --- E01: lexing and parsing (the parser's own table is stcore/parse_codes.py)
    # --- E02: declarations and types
    "E0201": Code("{name} is declared twice; first at line {line}", "rename one of them or remove it"),
    "E0202": Code("unknown type {name}", "{near}"),
}

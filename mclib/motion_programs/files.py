"""The files of a compiled motion program: *.bin for the controller, *.ini with its symbols. They belong together."""

from __future__ import annotations

import configparser
import hashlib
import os
import struct
from pathlib import Path

from mclib.motion_programs.code import Function, Operand, Unit, Variable

MAGIC = b"scancycle motion program 1\n"
_OPERAND = "hhhhh6xq"  # as GtMotionOperand.st and GtMotionCode.st lie in memory
_COMMAND = struct.Struct("<hh4x" + 3 * _OPERAND)
COMMAND_SIZE = _COMMAND.size


class Damaged(Exception):
    """A file that is not what this module has written, or one without the other."""


def write(unit: Unit, source: Path) -> None:
    """Write the two files beside the source. Raises OSError."""
    code = b"".join(_COMMAND.pack(c.op, c.line, *_fields(c.dst), *_fields(c.a), *_fields(c.b)) for c in unit.commands)
    code = MAGIC + code
    lines = ["[program]", f"bin = {hashlib.sha256(code).hexdigest()}", ""]
    lines += _section("global", unit.variables)
    for number, function in enumerate(unit.functions.values()):
        lines += [f"[function {function.name}]", f"id = {number}", f"entry = {function.entry}"]
        lines += [f"type = {function.type}", ""]
        lines += _section(f"local {function.name}", function.variables)
    for suffix, data in ((".bin", code), (".ini", "\n".join(lines).encode())):
        file = source.with_suffix(suffix)
        part = file.with_name(f"{file.name}.{os.getpid()}.part")
        part.write_bytes(data)
        os.replace(part, file)


def read(file: Path) -> tuple[bytes, list[Function], list[tuple[int, Variable]]]:
    """(commands as they lie in memory, functions, (function's number or -1, variable)). Raises Damaged."""
    try:
        code = file.read_bytes()
        names = configparser.ConfigParser(delimiters=("=",), interpolation=None)
        names.optionxform = str  # C knows upper and lower case
        names.read_string(file.with_suffix(".ini").read_text(encoding="utf-8"))
        if not code.startswith(MAGIC) or names["program"]["bin"] != hashlib.sha256(code).hexdigest():
            raise Damaged(f"{file.name} and {file.stem}.ini do not belong together")
        functions, variables = [], [(-1, v) for v in _variables(names, "global", 1)]
        for section in names.sections():
            if section.startswith("function "):
                name = section.removeprefix("function ")
                functions.append(Function(name, names[section]["type"], int(names[section]["entry"])))
                variables += [(len(functions) - 1, v) for v in _variables(names, f"local {name}", 2)]
    except (OSError, UnicodeDecodeError, configparser.Error, KeyError, ValueError) as error:
        raise Damaged(str(error)) from None
    return code[len(MAGIC) :], functions, variables


def _fields(o: Operand) -> tuple[int, ...]:
    return o.mode, o.index, o.by, o.at, o.length, o.value


def _section(name: str, variables: dict[str, Variable]) -> list[str]:
    return [f"[{name}]", *(f"{v.name} = {v.index} {v.type} {v.length}" for v in variables.values()), ""]


def _variables(names: configparser.ConfigParser, section: str, mode: int) -> list[Variable]:
    found = []
    for name, text in names[section].items():
        index, kind, length = text.split()
        found.append(Variable(name, kind, mode, int(index), int(length)))
    return found

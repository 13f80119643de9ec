"""What GT_Compile and GT_Download need of the host (mclib/library/motion)."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

from mclib.motion_programs import files
from mclib.motion_programs.code import LONGEST_NAME, MOST_COMMANDS, MOST_FUNCTIONS, MOST_NAMES, MotionError
from mclib.motion_programs.compiler import compile_motion

LONGEST = 125  # of a file name
ROOM = 255  # of the strings that tell of an error
MISSING, DAMAGED, TOO_MANY, UNREADABLE = -1, -2, -3, -1
_SYMBOL = struct.Struct("<32shhhh")  # GtMotionSymbol.st


def functions(plc, memory: Callable[[], memoryview]) -> dict[str, Callable]:
    """The external functions, by upper-case name. memory: gives that of the PLC."""

    def compile_program(name_at: int, file_at: int, message_at: int) -> int:
        name = _text(memory(), name_at)
        file = find(name, plc)
        line, message = 0, ""
        try:
            if file is None:
                raise OSError("there is no such file")
            unit = compile_motion(_source(file))
            files.write(unit, file)
        except MotionError as error:
            line, message = error.line, error.message
        except OSError as error:
            line, message = UNREADABLE, f"{name}: {error.strerror or error}"
        _put(memory(), file_at, str(file or name))
        _put(memory(), message_at, message)
        return line

    def download(name_at: int, code_at: int, symbols_at: int, loaded_at: int) -> int:
        name = _text(memory(), name_at)
        file = find(name, plc) if len(name) <= LONGEST else None
        if file is None:
            return MISSING
        try:
            code, entries, variables = files.read(file)
        except files.Damaged:
            return DAMAGED
        if len(entries) > MOST_FUNCTIONS:
            return TOO_MANY
        symbols = [_symbol(f.name, -2, n, f.type, f.entry) for n, f in enumerate(entries)]
        symbols += [_symbol(v.name, owner, v.index, v.type, 0) for owner, v in variables]
        if len(symbols) > MOST_NAMES or len(code) > MOST_COMMANDS * files.COMMAND_SIZE:
            return DAMAGED
        data = b"".join(symbols)
        memory()[code_at : code_at + len(code)] = code
        memory()[symbols_at : symbols_at + len(data)] = data
        _put(memory(), loaded_at, str(file))
        return len(symbols)

    return {"HOSTCOMPILEMOTION": compile_program, "HOSTDOWNLOADMOTION": download}


def find(name: str, plc) -> Path | None:
    """The file as named when that is absolute, else in the folder of the project or program, or the working folder."""
    if not name:
        return None
    folders = [Path(plc.project.path).parent] if plc.project.path else []
    folders += [Path(f).parent for f in plc.program.files[:1] if Path(f).is_file()]
    for folder in (*folders, Path.cwd()):
        if (folder / name).is_file():
            return folder / name
    return None


def _source(file: Path) -> str:
    data = file.read_bytes()
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("gb18030", "replace")


def _symbol(name: str, owner: int, number: int, kind: str, entry: int) -> bytes:
    return _SYMBOL.pack(name.encode()[:LONGEST_NAME], owner, number, int(kind == "double"), entry)


def _text(memory: memoryview, at: int) -> str:
    return bytes(memory[at : at + ROOM + 1]).split(b"\0")[0].decode("utf-8", "replace")


def _put(memory: memoryview, at: int, text: str) -> None:
    data = text.encode()[:ROOM] + b"\0"
    memory[at : at + len(data)] = data

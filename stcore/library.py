"""Folders of ST files as libraries: which file defines a name, found without parsing them all.

A library file is named after the POU or type it defines. Besides, a list of global variables or an enumeration
defines every name in it; those are found by one quick reading of the text, kept in the cache.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path

from stcore import cache
from stcore.source import read

_COMMENT = re.compile(r"\(\*.*?\*\)|//[^\n]*|\{[^}]*\}|'(?:[^'$\n]|\$.)*'", re.S)
_POU = re.compile(r"^\s*(?:PROGRAM|FUNCTION_BLOCK|FUNCTION)\s+(\w+)", re.M | re.I)
_TYPES = re.compile(r"\bTYPE\b(.*?)\bEND_TYPE\b", re.S | re.I)
_STRUCT = re.compile(r"\b(STRUCT|UNION)\b.*?\bEND_(STRUCT|UNION)\b", re.S | re.I)
_TYPE_NAME = re.compile(r"(\w+)\s*:(?!=)")
_ENUM = re.compile(r":\s*(?:\w+\s*)?\(([^()]*)\)", re.S)
_GLOBALS = re.compile(r"\bVAR_GLOBAL\b(.*?)\bEND_VAR\b", re.S | re.I)
_GLOBAL_NAMES = re.compile(r"(?:^|;)\s*(?:CONSTANT\b|RETAIN\b|PERSISTENT\b|\s)*([\w\s,]+?)(?:\bAT\b[^:]*)?:(?!=)", re.I)
_QUALIFIED = re.compile(r"\{\s*attribute\s+'qualified_only'", re.I)


@dataclass(slots=True)
class Entry:
    """A name and the file that defines it."""

    path: Path
    library: bool


def names_of(text: str) -> set[str]:
    """The names that a text defines for other files, upper case."""
    qualified = bool(_QUALIFIED.search(text))
    text = _COMMENT.sub(" ", text)
    names = {m.upper() for m in _POU.findall(text)}
    for body in _TYPES.findall(text):
        body = _STRUCT.sub(" ", body)
        names |= {m.upper() for m in _TYPE_NAME.findall(body)}
        for items in _ENUM.findall(body):
            if not qualified and ".." not in items:
                names |= {i.split(":=")[0].strip().upper() for i in items.split(",")}
    if not qualified:
        for body in _GLOBALS.findall(text):
            for group in _GLOBAL_NAMES.findall(body):
                names |= {n.strip().upper() for n in group.split(",")}
    return {n for n in names if n}


def index(folder: Path, *, recursive: bool, library: bool) -> dict[str, Entry]:
    """Upper-case name -> the file of `folder` that defines it; the file's own name counts as defined."""
    files = sorted(folder.rglob("*.st") if recursive else folder.glob("*.st"))
    stamp = json.dumps([[str(f), (i := f.stat()).st_mtime_ns, i.st_size] for f in files])
    cached = cache.load("index", cache.digest(stamp.encode()))
    if cached is None:
        table = {str(f): sorted(names_of(read(f).text)) for f in files}
        cached = json.dumps(table).encode()
        cache.store("index", cache.digest(stamp.encode()), cached)
    entries: dict[str, Entry] = {}
    for path, names in json.loads(cached).items():
        file = Path(path)
        for name in {file.stem.upper(), *names}:
            # a file named after the thing wins over one that merely mentions it in a list
            if name not in entries:
                entries[name] = Entry(file, library)
            elif name == file.stem.upper():
                entries[listed(name)] = entries[name]
                entries[name] = Entry(file, library)
            elif name == entries[name].path.stem.upper():
                entries[listed(name)] = Entry(file, library)
    return entries


def listed(name: str) -> str:
    """Where an index has a constant of a list beside a block of the same name: MC_HOME and MC_Home."""
    return f"{name}#"

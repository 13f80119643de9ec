"""Folders of ST files as libraries: which file defines a name, found without parsing them all.

A library file is named after the POU or type it defines. Besides, a list of global variables or an enumeration
defines every name in it; those are found by one quick reading of the text, kept in the cache.
"""

from __future__ import annotations

import functools
import json
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from stcore import cache
from stcore.source import read

_COMMENT = re.compile(r"\(\*.*?\*\)|//[^\n]*|\{[^}]*\}|'(?:[^'$\n]|\$.)*'", re.S)
_MODIFIERS = r"(?:(?:ABSTRACT|FINAL|PUBLIC|INTERNAL)\s+(?=\w+\s))*"
_POU = re.compile(
    rf"^\s*(?:PROGRAM|FUNCTION_BLOCK|FUNCTION|INTERFACE)\s+{_MODIFIERS}(\w+)(?:\s+EXTENDS\s+(?:\w+\.)*(\w+))?",
    re.M | re.I,
)
_TYPES = re.compile(r"\bTYPE\b(.*?)\bEND_TYPE\b", re.S | re.I)
_STRUCT = re.compile(r"\b(STRUCT|UNION)\b.*?\bEND_(STRUCT|UNION)\b", re.S | re.I)
_TYPE_NAME = re.compile(r"(\w+)\s*:(?!=)")
_ENUM = re.compile(r":\s*(?:\w+\s*)?\(([^()]*)\)", re.S)
_GLOBALS = re.compile(r"\bVAR_GLOBAL\b(.*?)\bEND_VAR\b", re.S | re.I)
_GLOBAL_NAMES = re.compile(r"(?:^|;)\s*(?:CONSTANT\b|RETAIN\b|PERSISTENT\b|\s)*([\w\s,]+?)(?:\bAT\b[^:]*)?:(?!=)", re.I)
_QUALIFIED = re.compile(r"\{\s*attribute\s+'qualified_only'", re.I)


def names_of(text: str) -> set[str]:
    """The names that a text defines for other files, upper case; and ``B<A`` for a block B that extends A."""
    qualified = bool(_QUALIFIED.search(text))
    text = _COMMENT.sub(" ", text)
    names = set()
    for name, base in _POU.findall(text):
        names |= {name.upper(), f"{name}<{base}".upper() if base else name.upper()}
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


class Index(dict[str, str]):
    """Upper-case name -> path of the file that defines it. Not to be changed: who asks again gets the same one."""

    @functools.cached_property
    def names(self) -> list[str]:
        """Every name, as its own file spells it."""
        stems = {name: os.path.basename(path).removesuffix(".st") for name, path in self.items()}
        names = (name for name in self if name[-1] != "#" and "<" not in name)
        return [stems[name] if stems[name].upper() == name else name for name in names]


def index(folders: Iterable[Path], *, recursive: bool) -> Index:
    """What the files of folders define, the first of the folders first; the name of a file counts as defined in it."""
    return _index(tuple((f"{folder} {recursive}", tuple(sorted(_files(str(folder), recursive)))) for folder in folders))


@functools.lru_cache(maxsize=16)
def _index(folders: tuple[tuple[str, tuple[tuple[str, int, int], ...]], ...]) -> Index:
    found = Index()
    for folder, files in folders:
        for name, path in _defined(folder, files).items():
            found.setdefault(name, path)
    return found


def _files(folder: str, recursive: bool) -> Iterator[tuple[str, int, int]]:
    """(path, time in ns, bytes) of the ST files; of a folder that is missing or closed to us there are none."""
    try:
        entries = list(os.scandir(folder))
    except (FileNotFoundError, NotADirectoryError, PermissionError):
        return
    for entry in entries:
        if entry.name.endswith(".st") and entry.is_file():
            info = entry.stat()
            yield entry.path, info.st_mtime_ns, info.st_size
        elif recursive and entry.is_dir(follow_symlinks=False):
            yield from _files(entry.path, True)


def _names_in(path: str) -> list[str]:
    """What a file defines; nothing where it is no text or is closed to us."""
    try:
        return sorted(names_of(read(path).text))
    except OSError:
        return []


def _defined(folder: str, files: tuple[tuple[str, int, int], ...]) -> dict[str, str]:
    """What the files of a folder define. The cache has it as it was at the last look; only what has changed since is
    read again."""
    key = cache.digest(cache.fingerprint([Path(__file__)]), folder.encode("utf-8", "surrogateescape"))
    stamp = repr(files)
    before = _kept(key)
    if before.get("stamp") == stamp:
        return before["defined"]
    known = {tuple(file): names for file, names in before.get("names", [])}
    names = {file: known[file] if file in known else _names_in(file[0]) for file in files}
    defined = _owners({path: names[path, time, size] for path, time, size in files})
    kept = {"stamp": stamp, "names": list(names.items()), "defined": defined}
    cache.store("index", key, json.dumps(kept).encode())
    return defined


def _kept(key: str) -> dict:
    try:
        return json.loads(cache.load("index", key) or b"{}")
    except ValueError:  # damaged
        return {}


def _owners(names: dict[str, list[str]]) -> dict[str, str]:
    """Upper-case name -> path, from the names that each file defines."""
    defined: dict[str, str] = {}
    for path in sorted(names, key=lambda path: path.split(os.sep)):
        own = Path(path).stem.upper()
        for name in sorted({own, *names[path]}):
            # a file named after the thing wins over one that merely mentions it in a list
            if name not in defined:
                defined[name] = path
            elif name == own:
                defined[listed(name)] = defined[name]
                defined[name] = path
            elif name == Path(defined[name]).stem.upper():
                defined[listed(name)] = path
    return defined


def listed(name: str) -> str:
    """Where an index has a constant of a list beside a block of the same name: MC_HOME and MC_Home."""
    return f"{name}#"

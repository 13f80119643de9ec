"""The library as a catalogue: what each file of the library folders declares, from its header and first comment.

The headers are read with regular expressions: the library is our own and has one form (docs/architecture.md), and a
list of some hundred POUs shall not wait for the compiler.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

_COMMENT = re.compile(r"\(\*(.*?)\*\)", re.S)
_ATTRIBUTE = re.compile(r"\{attribute\s+'([^']+)'", re.I)
_POU = re.compile(
    r"^\s*(FUNCTION_BLOCK|FUNCTION|PROGRAM)\s+([^\W\d]\w*)\s*(<[^>]*>)?\s*(?::\s*([^\n;(]+))?", re.I | re.M
)  # fmt: skip
_TYPE = re.compile(r"^\s*TYPE\s+([^\W\d]\w*)\s*(?:EXTENDS\s+\w+\s*)?:\s*(\(|\w+)", re.I | re.M)
_GLOBALS = re.compile(r"^\s*VAR_GLOBAL\b(.*?)^\s*END_VAR\b", re.I | re.M | re.S)
_SECTION = re.compile(r"^\s*(VAR_INPUT|VAR_OUTPUT|VAR_IN_OUT)\b[^\n]*?\n?(.*?)\bEND_VAR\b", re.I | re.M | re.S)
_MEMBER = re.compile(r"^[ \t]+([^\W\d][\w, ]*?)\s*:(?!=)\s*([^;]+);[ \t]*(?:\(\*(.*?)\*\))?", re.M | re.S)
_GIVEN = r"\{attribute\s+'room_of'[^}]*\}[^;]*;"  # an input that the compiler itself gives
_NOISE = re.compile(rf"{_GIVEN}|\(\*.*?\*\)|//[^\n]*|\{{[^}}]*\}}", re.S)
_KEYS = ("units", "ranges", "returns", "source")
CONVERSION = "a conversion, built into the compiler"
ARROW = {"VAR_INPUT": "", "VAR_IN_OUT": "VAR_IN_OUT ", "VAR_OUTPUT": "=> "}


@dataclass(slots=True)
class Entry:
    """A function, block or type of the library. file: where it is written; source: manual and section.

    members: of a structure, an ENUM or a list of constants, each as declared, with what its comment says."""

    name: str
    kind: str  # function, function_block, program, type, constants
    signature: str
    summary: str
    units: str
    ranges: str
    returns: str
    source: str
    file: str
    members: list[str] = field(default_factory=list)


def entries(folders: list[Path]) -> list[Entry]:
    """Everything in the folders that is not hidden, and what the compiler itself provides, by name."""
    found = [e for folder in folders for path in sorted(folder.rglob("*.st")) for e in _of_file(path)]
    return sorted([*found, *_built_in({e.name.upper() for e in found})], key=lambda e: e.name.upper())


def _of_file(path: Path) -> Iterator[Entry]:
    text = path.read_text(encoding="utf-8-sig")
    doc = _documentation(text)
    bare = _NOISE.sub(lambda m: "\n" * m[0].count("\n") or " ", text)
    pou = _POU.search(bare)
    if any(a.lower() == "hidden" for a in _ATTRIBUTE.findall(text)) or pou and pou[2].startswith("__"):
        return
    common = {**{key: doc.get(key, "") for key in _KEYS}, "summary": doc[""], "file": str(path)}
    if pou:
        kind = pou[1].lower()
        result = (pou[4] or "").strip() if kind == "function" else ""
        signature = f"{pou[2]}({_parameters(bare)})" + (f": {result}" if result else "")
        if pou[3]:
            signature = signature.replace("(", f"{' '.join(pou[3].split())}(", 1)
        yield Entry(pou[2], kind, signature, **common)
    elif declared := _TYPE.search(bare):
        enum = declared[2] == "("
        members = _values(bare) if enum else _members(text)
        yield Entry(
            declared[1], "type", f"{declared[1]}: {'ENUM' if enum else declared[2].upper()}", **common, members=members
        )
    elif _GLOBALS.search(bare):
        kind = "constants" if "CONSTANT" in bare.upper() else "variables"
        yield Entry(path.stem, kind, path.stem, **common, members=_members(text))


def _members(text: str) -> list[str]:
    """'name: TYPE := value - comment' of what a structure or a list declares, one a line."""
    found = []
    for names, declared, comment in _MEMBER.findall(text, _COMMENT.search(text).end() if _COMMENT.search(text) else 0):
        words = " ".join(comment.split())
        found.append(f"{names}: {' '.join(declared.split())}" + (f" - {words}" if words else ""))
    return found


def _values(bare: str) -> list[str]:
    """The names of an ENUM, with their values where these are given."""
    inside = re.search(r"\((.*)\)", bare, re.S)
    return [" ".join(part.split()) for part in inside[1].split(",")] if inside else []


def _documentation(text: str) -> dict[str, str]:
    """'' -> what the first comment says before its keys; key -> its text, which may go on in the next line."""
    comment = _COMMENT.search(text)
    found, key = {"": ""}, ""
    for line in comment[1].splitlines() if comment else []:
        start = re.match(rf"\s*({'|'.join(_KEYS)}):(.*)", line)
        if start:
            key, line = start[1], start[2]
        found[key] = f"{found.get(key, '')} {line.strip()}".strip()
    # 'GT_SetVel: what it does' and 'What it does' are both in use
    found[""] = re.sub(r"^[^\W\d]\w*:\s+", "", found[""])
    return found


def _parameters(bare: str) -> str:
    parts = []
    for section in _SECTION.finditer(bare):
        for names, declared in re.findall(r"([^\W\d][\w\s,]*?)\s*:(?!=)\s*([^;]+);", section[2]):
            arrow = ARROW[section[1].upper()]
            parts.append(f"{arrow}{', '.join(n.strip() for n in names.split(','))}: {' '.join(declared.split())}")
    return "; ".join(parts)


def _built_in(known: set[str]) -> list[Entry]:
    """The functions that are instructions of the compiler; of the conversions X_TO_Y the library lists its own."""
    from stcore.check import builtins
    from stcore.types import ELEMENTARY

    made = []
    for name, (_, low, high) in builtins.HANDLERS.items():
        inputs = ", ".join(f"IN{i + 1}" for i in range(low)) + (", ..." if high > low else "")
        made.append((name, f"{name}({inputs})", "built into the compiler"))
    for source in ELEMENTARY:
        for target in ELEMENTARY:
            name = f"{source}_TO_{target}"
            if source != target and builtins.conversion_types(name):
                made.append((name, f"{name}(IN: {source}): {target}", CONVERSION))
    details = {"units": "", "ranges": "", "returns": "", "source": "IEC 61131-3", "file": builtins.__file__}
    return [
        Entry(name, "function", signature, summary, **details)
        for name, signature, summary in made
        if name not in known and not name.startswith("__")
    ]

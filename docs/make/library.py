"""The motion blocks as their library files have them: members, units, ranges, errors, from declarations and first
comments (their form: docs/architecture.md)."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import mclib
from plcruntime import catalogue
from stcore import syntax
from stcore.parser import parse
from stcore.source import Source

ROOT = Path(__file__).resolve().parents[2]
FOLDER = mclib.LIBRARY / "mc"
SECTIONS = {"VAR_IN_OUT": "in_out", "VAR_INPUT": "input", "VAR_OUTPUT": "output"}
ERROR = re.compile(r"SMC_[A-Z0-9_]+")
NUMBERS = {"SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT", "BYTE", "WORD", "DWORD", "REAL", "LREAL"}
AXES = ("AXIS_REF_SM3", "AXIS_REF_LOGICAL_SM3", "AXIS_REF_VIRTUAL_SM3")


@dataclass(slots=True)
class Member:
    """An input or output. kind: in_out, input, output; initial: as written, '' when it is the type's own; also: its
    second name, '' when it has none."""

    name: str
    also: str
    kind: str
    type: str
    initial: str
    unit: str
    range: str
    meaning: str


@dataclass(slots=True)
class Block:
    """remarks: what the first comment says under ranges about no member in particular."""

    name: str
    summary: str
    members: list[Member]
    errors: list[tuple[int, str, str]]  # number, name, when
    remarks: list[str]
    source: str
    file: Path

    def of_kind(self, kind: str) -> list[Member]:
        return [m for m in self.members if m.kind == kind]


@cache
def blocks() -> dict[str, Block]:
    """Every function block of the motion library by name."""
    found = {}
    for entry in catalogue.entries([FOLDER]):
        if entry.kind == "function_block":
            found[entry.name] = _block(entry)
    return found


def _block(entry: catalogue.Entry) -> Block:
    text = Path(entry.file).read_text(encoding="utf-8-sig")
    (pou,) = (u for u in parse(Source(text, entry.file)).units if isinstance(u, syntax.Pou))
    declared = [
        (SECTIONS[section.kind], decl) for section in pou.sections if section.kind in SECTIONS for decl in section.decls
    ]
    names = {decl.name for _, decl in declared}
    units, _ = by_member(entry.units, names)
    ranges, remarks = by_member(entry.ranges, names)
    members = []
    for kind, decl in declared:
        type_ = text[decl.type.start : decl.type.end]
        initial = text[decl.init.start : decl.init.end] if decl.init else ""
        members.append(
            Member(
                name=decl.name,
                also=(decl.attributes or {}).get("also", ""),
                kind=kind,
                type=type_,
                initial=initial.removeprefix(f"{type_}."),
                unit=units.get(decl.name, ""),
                range=ranges.get(decl.name, ""),
                meaning=meaning(entry.name, decl.name),
            )
        )
    summary = entry.summary[0].upper() + entry.summary[1:]
    return Block(entry.name, summary, members, errors(entry.returns), remarks, entry.source, Path(entry.file))


def gaps() -> list[str]:
    """What a page needs and the library, words.toml or examples_st don't say."""
    found = []
    for block in blocks().values():
        if not example(block.name).exists():
            found.append(f"{block.name}: there is no {example(block.name).name}")
        for m in block.members:
            missing = [
                what
                for what, said, needed in (
                    ("meaning", m.meaning, True),
                    ("unit", m.unit, m.type == "LREAL"),
                    ("range", m.range, m.kind == "input" and m.type in NUMBERS),
                )
                if needed and not said
            ]
            found += [f"{block.name}.{m.name} has no {what}" for what in missing]
    return found


def by_member(text: str, names: set[str]) -> tuple[dict[str, str], list[str]]:
    """'Position u; Velocity, Jerk > 0; at rest only' -> what is said of each member, and the rest."""
    found, rest = {}, []
    for clause in filter(None, (c.strip() for c in text.split(";"))):
        start = re.match(r"(\w+(?:, \w+)*):? (.+)", clause)
        named = start[1].split(", ") if start else []
        if named and all(n in names for n in named):
            for n in named:
                found[n] = f"{found[n]}; {start[2]}" if n in found else start[2]
        elif clause != "-":
            rest.append(clause)
    return found, rest


def errors(text: str) -> list[tuple[int, str, str]]:
    """The errors that a comment names: number, name, and when it comes: what SMC_ERROR says of it and what stands
    around the name."""
    places = list(ERROR.finditer(text))
    found, prefix = [], ""
    for place, following in zip(places, [*places[1:], None], strict=True):
        if place[0] == places[0][0]:
            prefix = text[: place.start()].rpartition(";")[2].strip(" ,")
        between = text[place.end() : following.start() if following else len(text)]
        note, _, after = between.rpartition(";") if following and ";" in between else (between, "", "")
        note = " ".join(p for p in (prefix, note.strip(" ,;.").strip("()")) if p)
        prefix = after.strip(" ,")
        number, meant = error_numbers()[place[0]]
        found.append((number, place[0], f"{meant} ({note})" if meant and note and note not in meant else note or meant))
    return found


@cache
def error_numbers() -> dict[str, tuple[int, str]]:
    """Name -> number and comment of each SMC_ERROR."""
    text = (FOLDER / "SMC_ERROR.st").read_text(encoding="utf-8")
    return {
        m[1]: (int(m[2]), m[3] or "")
        for m in re.finditer(r"^\s+(SMC_\w+) := (\d+),?[ \t]*(?:\(\* (.*?) \*\))?$", text, re.M)
    }


@cache
def labels(name: str) -> dict[str, int]:
    """The labels of an ENUM of the library, {} when the type is none."""
    path = FOLDER / f"{name}.st"
    text = re.sub(r"\(\*.*?\*\)", "", path.read_text(encoding="utf-8"), flags=re.S) if path.exists() else ""
    inside = re.search(r"TYPE\s+\w+\s*:\s*\(([^)]*)\)", text)
    found: dict[str, int] = {}
    for label in (part.strip() for part in inside[1].split(",")) if inside else ():
        key, _, value = (p.strip() for p in label.partition(":="))
        found[key] = int(value) if value else max(found.values(), default=-1) + 1
    return found


@cache
def _words() -> dict[str, str]:
    return tomllib.loads(Path(__file__).with_name("words.toml").read_text(encoding="utf-8"))["members"]


def meaning(block: str, member: str) -> str:
    return _words().get(f"{block}.{member}") or _words().get(member, "")


def example(block: str) -> Path:
    """The example of a block: MC_MoveAbsolute -> examples_st/mc_move_absolute.st."""
    return ROOT / "examples_st" / (re.sub(r"(?<=[a-z])(?=[A-Z])", "_", block).lower() + ".st")


def in_manual(block: Block) -> bool:
    """It is one of the AM600 manual's."""
    return block.source.startswith("AM600")

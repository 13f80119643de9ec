"""docs/compliance.md: PLCopen Motion Control Part 1 in the standard's own form, each input and output with its level
(B basic, E extended, V of the vendor) and whether the library has it."""

from __future__ import annotations

import ast
import functools
import re
import tomllib
from pathlib import Path

import library
from library import Block, Member

TESTS = library.ROOT / "tests" / "mclib"
DIRECTIONS = {"in_out": "VAR_IN_OUT", "input": "VAR_INPUT", "output": "VAR_OUTPUT"}
HEAD = """# PLCopen Motion Control Part 1, version 2.0: compliance

{note}

In the form of the standard's compliance statement: every block with its inputs and outputs. B: basic; E: extended;
V: of the vendor, here CODESYS SoftMotion as the AM600 manual has it. Y: the library has it; N: it has not. Blocks,
inputs and outputs are read from the library, tests from `tests/mclib`; `python docs/make --text` writes this page
anew. Where CODESYS and PLCopen ask for different behaviour, `dialect` in plc.toml chooses;
[what_differs.md](what_differs.md) lists the differences.

{counts}

## Data types

| data type | supported | comment |
|---|---|---|
| BOOL, INT, DINT, WORD, DWORD, TIME | Y | |
| REAL | Y | positions, velocities and the like are LREAL; REAL inputs are converted |
| enumerations | Y | numbers: see the pages of the blocks |
| AXIS_REF | Y | AXIS_REF_SM3 and its alias AXIS_REF |
"""
TYPES = (
    "MC_BUFFER_MODE", "MC_DIRECTION", "MC_TP_REF", "MC_TV_REF", "MC_TA_REF", "MC_CAMSWITCH_REF", "MC_TRACK_REF",
    "MC_TRIGGER_REF", "MC_INPUT_REF", "MC_OUTPUT_REF", "MC_CAM_REF", "MC_CAM_ID", "MC_START_MODE",
    "MC_EXECUTION_MODE", "MC_SOURCE", "MC_SYNC_MODE", "MC_COMBINE_MODE",
)  # fmt: skip
OTHER_NAMES = {"MC_TRIGGER_REF": "TRIGGER_REF"}  # of CODESYS


def page(note: str) -> str:
    standard = _standard()
    rows = {name: _rows(_find(name), levels) for name, levels in standard.items()}
    lines = [HEAD.format(note=note, counts=_counts(rows))[:-1], *_types(), "", "## Function blocks", ""]
    lines += ["| block | supported | tested by |", "|---|---|---|"]
    for name in standard:
        block = _find(name)
        missing = [row[1] for row in rows[name] if row[3] == "N"]
        supported = "N" if block is None else "Y" + (f", without {', '.join(missing)}" if missing else "")
        lines.append(f"| {_link(name, block)} | {supported} | {', '.join(_tests(block)) if block else ''} |")
    for name in standard:
        lines += ["", f"### {name}", "", "| B/E/V | name | kind | supported | comment |", "|---|---|---|---|---|"]
        lines += [f"| {' | '.join(row)} |" for row in rows[name]]
    return "\n".join([*lines, ""])


def _standard() -> dict[str, dict[str, str]]:
    """Block -> kind -> 'Name Name? ...'."""
    return tomllib.loads(Path(__file__).with_name("plcopen_part1.toml").read_text(encoding="utf-8"))


def _find(name: str) -> Block | None:
    return next((b for b in library.blocks().values() if b.name.lower() == name.lower()), None)


def _link(name: str, block: Block | None) -> str:
    return f"[{name}](blocks/{block.name}.md)" if block else name


def _rows(block: Block | None, levels: dict[str, str]) -> list[tuple[str, str, str, str, str]]:
    """(level, name, kind, Y or N, comment) of each input and output: the standard's, then the vendor's."""
    rows, used = [], set()
    for kind, names in levels.items():
        for entry in names.split():
            name, level = entry.rstrip("?"), "E" if entry.endswith("?") else "B"
            member = _member(block, kind, name)
            if member:
                used.add(member.name)
            rows.append((level, name, DIRECTIONS[kind], "Y" if member else "N", _comment(name, member)))
    rest = [m for m in block.members if m.name not in used] if block else []
    return rows + [("V", m.name, DIRECTIONS[m.kind], "Y", m.meaning) for m in rest]


def _member(block: Block | None, kind: str, name: str) -> Member | None:
    wanted = name.lower()
    members = block.of_kind(kind) if block else []
    return next((m for m in members if wanted in (m.name.lower(), m.also.lower())), None)


def _comment(name: str, member: Member | None) -> str:
    if member is None:
        return ""
    parts = [] if member.name.lower() == name.lower() else [f"also {member.name}"]
    if member.type in ("SMC_ERROR", "LREAL") or member.type.startswith("MC_"):
        parts.append(member.type)
    return "; ".join(parts)


def _counts(rows: dict[str, list]) -> str:
    def of(level: str) -> str:
        all_ = [row[3] for found in rows.values() for row in found if row[0] == level]
        return f"{all_.count('Y')} of {len(all_)}"

    blocks = sum(_find(name) is not None for name in rows)
    return f"{blocks} of {len(rows)} blocks; {of('B')} basic and {of('E')} extended inputs and outputs."


def _types() -> list[str]:
    lines = []
    for name in TYPES:
        actual = OTHER_NAMES.get(name, name)
        there = (library.FOLDER / f"{actual}.st").exists()
        labels = ", ".join(library.labels(actual)) if there else ""
        comment = labels or (f"{actual}" if actual != name else "")
        lines.append(f"| {name} | {'Y' if there else 'N'} | {comment} |")
    return lines


def _tests(block: Block) -> list[str]:
    """The test files that use the block, by its type or by its name on a shared bench."""
    return sorted(path.name for path in _texts() if _uses(path, block.name))


@functools.cache
def _texts() -> dict[Path, str]:
    return {path: path.read_text(encoding="utf-8") for path in TESTS.rglob("test_*.py")}


def _uses(path: Path, name: str) -> bool:
    text = _texts()[path]
    if re.search(rf"\b{name}\b", text):
        return True
    aliases = [alias for alias, block in _bench(path.parent / "conftest.py").items() if block == name]
    return "bench" in text and any(re.search(rf"[\"']{alias}[.\"']", text) for alias in aliases)


@functools.cache
def _bench(conftest: Path) -> dict[str, str]:
    """Instance -> block of the program that the tests of a folder share."""
    if not conftest.exists():
        return {}
    found = {}
    for node in ast.walk(ast.parse(conftest.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            for names, block in re.findall(r"((?:\w+, )*\w+) ?: (S?MC\d?_\w+);", node.value):
                found |= dict.fromkeys(names.split(", "), block)
        elif isinstance(node, ast.Dict):
            for key, value in zip(node.keys, node.values, strict=True):
                first = value.elts[0] if isinstance(value, ast.Tuple) and value.elts else value
                if isinstance(key, ast.Constant) and isinstance(first, ast.Constant) and "MC_" in str(first.value):
                    found[key.value] = first.value
    return found

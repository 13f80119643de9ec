"""The page of a block: docs/blocks/NAME.md, and the index docs/blocks/README.md."""

from __future__ import annotations

import re

import examples
import library
from library import Block, Member

NOTE = "<!-- written by docs/make from the library and the examples; change those -->"
UNITS = {"u/s2": "u/s²", "u/s3": "u/s³", "-": "-"}


def page(block: Block) -> str:
    shown = examples.read(library.example(block.name))
    lines = [
        f"# {block.name}",
        "",
        NOTE,
        "",
        block.summary,
        "",
        f"![timing chart of {block.name}]({block.name}.png)",
        "",
    ]
    lines += [shown.shows, "", "## Inputs", "", *_table(block, ("in_out", "input")), ""]
    lines += ["## Outputs", "", *_table(block, ("output",)), ""]
    if block.remarks:
        lines += ["## Remarks", "", *(f"- {r[0].upper()}{r[1:]}." for r in block.remarks), ""]
    lines += ["## Errors", "", *_errors(block), "", "## Example", "", *_example(block, shown)]
    lines += [
        "",
        f"Library: [{block.file.name}](../../{block.file.relative_to(library.ROOT)}). Source: {block.source}.",
        "",
    ]
    return "\n".join(lines)


def _table(block: Block, kinds: tuple[str, ...]) -> list[str]:
    inputs = "input" in kinds
    lines = ["| name | type | unit |" + (" range | initial |" if inputs else "") + " meaning |"]
    lines += ["|---|---|---|" + ("---|---|" if inputs else "") + "---|"]
    for kind in kinds:
        for m in block.of_kind(kind):
            cells = [name(m), m.type, UNITS.get(m.unit, _powers(m.unit)) or "-"]
            if inputs:
                cells += [_range(m), m.initial or _initial(m)]
            text = m.meaning if inputs or not m.range else f"{m.meaning}: {m.range}" if m.meaning else m.range
            lines.append("| " + " | ".join([*cells, _powers(text)]) + " |")
    return lines


def name(member: Member) -> str:
    return f"{member.name} (also {member.also})" if member.also else member.name


def _powers(text: str) -> str:
    return text.replace("u/s2", "u/s²").replace("u/s3", "u/s³").replace("|", "\\|")


def _range(m: Member) -> str:
    """What the library says, else what the type says."""
    choices = ", ".join(f"{label} {number}" for label, number in _once(library.labels(m.type)).items())
    if m.kind == "in_out":
        return m.range or "-"
    if choices:
        return f"{m.range} ({choices})" if m.range else choices
    return m.range or ("TRUE, FALSE" if m.type == "BOOL" else "-")


def _once(labels: dict[str, int]) -> dict[str, int]:
    """The first label of each number, by number."""
    first = {n: label for label, n in reversed(labels.items())}
    return {first[n]: n for n in sorted(first)}


def _initial(m: Member) -> str:
    if m.kind == "in_out":
        return "-"
    return "FALSE" if m.type == "BOOL" else "0" if m.type in library.NUMBERS else _first(m.type)


def _first(type_: str) -> str:
    """The label that an ENUM begins with: 0 where it has it."""
    labels = library.labels(type_)
    return next((label for label, n in labels.items() if n == 0), next(iter(labels), "-"))


def _errors(block: Block) -> list[str]:
    if not block.errors:
        return ["None."]
    lines = ["| ErrorID | name | when |", "|--:|---|---|"]
    return lines + [f"| {number} | {error} | {_powers(when)} |" for number, error, when in block.errors]


def _example(block: Block, shown: examples.Example) -> list[str]:
    path = shown.path.relative_to(library.ROOT)
    body = re.sub(r"\A\(\*.*?\*\)\n", "", shown.text, count=1, flags=re.S)
    command = f"scancycle run {path} {shown.run} --plot out.png"
    if shown.again:
        command = f"scancycle run {path} {shown.run} --retain kept\nscancycle run {path} {shown.again} --retain kept"
    return [
        f"[{path.name}](../../{path}); the tests run it as the chart shows it:", "", "```console",
        *(f"$ {line}" for line in command.splitlines()), "```", "", "```pascal", body.rstrip(), "```",
    ]  # fmt: skip


def index(blocks: list[Block]) -> str:
    """All pages, those of the AM600 manual first."""
    manual = [b for b in blocks if library.in_manual(b)]
    rest = [b for b in blocks if not library.in_manual(b)]
    lines = [
        "# Motion blocks", "", NOTE, "",
        "One page a block: what it does, inputs and outputs with units and ranges, errors, a timing chart drawn from a",
        "run of the example on the page. `u` is the unit of the axis. [compliance.md](../compliance.md) has the blocks",
        "of PLCopen Part 1 in the standard's own form, [motion.md](../motion.md) what all blocks have in common.", "",
        "`python docs/make` writes these pages anew; `python docs/make --text` leaves the charts as they are.", "",
        f"## The blocks of the AM600 manual ({len(manual)})", "", *_list(manual), "",
        f"## The rest of PLCopen Part 1 ({len(rest)})", "", *_list(rest), "",
    ]  # fmt: skip
    return "\n".join(lines)


def _list(blocks: list[Block]) -> list[str]:
    first = (re.split(r"(?<=\w)[.;] ", b.summary.rstrip("."))[0] for b in blocks)
    return ["| block | |", "|---|---|"] + [
        f"| [{b.name}]({b.name}.md) | {s} |" for b, s in zip(blocks, first, strict=True)
    ]

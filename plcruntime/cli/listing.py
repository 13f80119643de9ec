"""``scancycle list``: the library's functions and blocks, for reading or as JSON."""

from __future__ import annotations

import argparse
import re
import sys
import textwrap
from dataclasses import asdict
from fnmatch import fnmatchcase
from pathlib import Path

from plcruntime import catalogue
from plcruntime.cli import DONE, FAILED, output

WIDTH = 110


def execute(arguments: argparse.Namespace) -> int:
    import mclib
    import stcore.compiler

    found = [e for e in catalogue.entries([stcore.compiler.LIBRARY, mclib.LIBRARY]) if _matches(e, arguments.pattern)]
    if arguments.json:
        print(output.to_json([asdict(e) for e in found]))
        return DONE
    if not found:
        print(f"scancycle: nothing in the library matches {arguments.pattern}", file=sys.stderr)
        return FAILED
    if arguments.pattern == "*":  # some hundred conversions would hide the rest
        found = [e for e in found if e.summary != catalogue.CONVERSION]
    for entry in found:
        print(_card(entry, output.coloured(sys.stdout)))
    print(f"{len(found)} in the library")
    return DONE


def _matches(entry: catalogue.Entry, pattern: str) -> bool:
    """A pattern with * or ? is of the whole name; else it may stand anywhere in it. Constants have names too."""
    pattern = pattern.upper()
    if not set(pattern) & set("*?["):
        pattern = f"*{pattern}*"
    constants = entry.members if entry.kind == "constants" or entry.signature.endswith("ENUM") else []
    names = [entry.name, *(re.match(r"\w+", member)[0] for member in constants)]
    return any(fnmatchcase(name.upper(), pattern) for name in names)


def _card(entry: catalogue.Entry, coloured: bool) -> str:
    """Signature, what it does, its details, where it comes from."""
    signature = textwrap.fill(entry.signature, WIDTH, subsequent_indent="        ")
    if coloured:
        signature = signature.replace(entry.name, f"\x1b[1;36m{entry.name}\x1b[0m", 1)
    texts = [entry.summary, *(f"    {member}" for member in entry.members)]
    texts += [f"{key}: {text}" for key in ("units", "ranges", "returns") if (text := getattr(entry, key))]
    texts += [" - ".join(part for part in (entry.kind.replace("_", " "), entry.source, _short(entry.file)) if part)]
    lines = [textwrap.fill(t, WIDTH, initial_indent="    ", subsequent_indent="        ") for t in texts if t]
    return "\n".join([signature, *lines, ""])


def _short(file: str) -> str:
    """The path from the package on."""
    parts = Path(file).parts
    packages = [i for i, part in enumerate(parts) if part in ("stcore", "mclib")]
    return "/".join(parts[packages[-1] :]) if packages else file

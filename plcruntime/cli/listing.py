"""``scancycle list``: the library's functions and blocks, as a table or as JSON."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict
from fnmatch import fnmatchcase
from pathlib import Path

from plcruntime import catalogue
from plcruntime.cli import DONE, FAILED, output


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
    rows = ((e.kind, e.signature, e.summary, e.units, _short(e.file), e.source) for e in found)
    output.print_table(("kind", "signature", "what it does", "units", "file", "source"), rows)
    print(f"{len(found)} in the library")
    return DONE


def _matches(entry: catalogue.Entry, pattern: str) -> bool:
    """A pattern with * or ? is of the whole name; else it may stand anywhere in it."""
    name, pattern = entry.name.upper(), pattern.upper()
    return fnmatchcase(name, pattern) if set(pattern) & set("*?[") else pattern in name


def _short(file: str) -> str:
    """The path from the package on."""
    parts = Path(file).parts
    packages = [i for i, part in enumerate(parts) if part in ("stcore", "mclib")]
    return "/".join(parts[packages[-1] :]) if packages else file

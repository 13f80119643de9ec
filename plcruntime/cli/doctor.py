"""``scancycle doctor``: what is installed, what is missing, where things are kept."""

from __future__ import annotations

import argparse
import os
import platform
import sys
from importlib import metadata
from pathlib import Path

from plcruntime.cli import DONE, FAILED, output

NEEDED = ("lark", "wasmtime", "numpy")
EXTRAS = {
    "matplotlib": "--plot",
    "rich": "tables",
    "prompt_toolkit": "the prompt",
    "pytest": "tests in Python",
    "plotly": "reports",
}


def execute(arguments: argparse.Namespace) -> int:
    rows = [
        ("scancycle", _version("scancycle") or "not installed", ""),
        ("python", platform.python_version(), sys.executable),
    ]
    missing = []
    for name in NEEDED:
        version = _version(name)
        rows.append((name, version or "missing", "" if version else f"pip install {name}"))
        missing += [] if version else [name]
    for name, purpose in EXTRAS.items():
        version = _version(name)
        rows.append((name, version or "not installed", purpose if version else f"for {purpose}: pip install {name}"))
    rows.append(("processor", f"{os.cpu_count()} cores", f"{platform.machine()}, {platform.system()}"))
    folder, problem = _cache()
    rows.append(("cache", problem or "writable", str(folder)))
    if _version("rich"):
        output.print_table(("what", "state", "where"), rows)
    else:
        print("\n".join("  ".join(row) for row in rows))
    if missing:
        print(f"scancycle: missing: {', '.join(missing)}", file=sys.stderr)
    if problem:
        print(f"scancycle: the cache can't be used ({problem}): every start compiles anew", file=sys.stderr)
    return FAILED if missing else DONE


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _cache() -> tuple[Path, str]:
    """The folder of kept builds, and what stands against writing there."""
    from stcore import cache

    folder = cache.cache_dir()
    existing = next(p for p in (folder, *folder.parents) if p.exists())
    if not existing.is_dir():
        return folder, f"{existing} is not a folder"
    return folder, "" if os.access(existing, os.W_OK) else f"no right to write to {existing}"

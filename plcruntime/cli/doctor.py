"""``scancycle doctor``: what is installed, what is missing, where things are kept, and whether a program runs."""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import sys
import time
from importlib import metadata
from pathlib import Path

from plcruntime.cli import DONE, FAILED, output

PYTHON = (3, 11)
# package -> what it is for
NEEDED = {
    "lark": "the parser", "wasmtime": "runs programs", "numpy": "traces", "matplotlib": "--plot",
    "rich": "tables", "prompt_toolkit": "the prompt", "pytest": "tests in Python",
}  # fmt: skip
# package -> the extra of the distribution that brings it, and what it is for
EXTRAS = {"plotly": ("report", "--report"), "selenium": ("test", "browser tests"), "ruff": ("lint", "make lint")}
PROGRAM = "PROGRAM PLC_PRG VAR n : DINT; END_VAR n := n + 1; END_PROGRAM\n"


def execute(arguments: argparse.Namespace) -> int:
    rows = [
        ("scancycle", _version("scancycle") or "not installed", str(Path(__file__).resolve().parents[2])),
        ("Python", platform.python_version(), sys.executable),
    ]
    problems = []
    if sys.version_info < PYTHON:
        problems.append(f"Python is too old: {PYTHON[0]}.{PYTHON[1]} or newer is needed")
    for name, purpose in NEEDED.items():
        version = _version(name)
        rows.append((name, version or "missing", purpose))
        problems += [] if version else [f"{name} is missing ({purpose}): pip install {name}"]
    for name, (extra, purpose) in EXTRAS.items():
        version = _version(name)
        how = purpose if version else f"only for {purpose}: pip install 'scancycle[{extra}]'"
        rows.append((name, version or "not installed", how))
    rows.append(("browser", *_browser()))
    rows.append(("processor", f"{os.cpu_count()} cores", f"{_processor()}, {platform.machine()}, {platform.system()}"))
    folder, problem = _cache()
    rows.append(("cache", problem or f"writable, {_size(folder)}", str(folder)))
    rows.append(("program", *_trial(problems)))
    if _version("rich"):
        output.print_table(("what", "state", "about"), rows)
    else:
        print("\n".join("  ".join(row) for row in rows))
    if problem:
        print(
            f"scancycle: the cache can't be used ({problem}), so every start compiles anew; SCANCYCLE_CACHE names "
            "another folder", file=sys.stderr,
        )  # fmt: skip
    for sentence in problems:
        print(f"scancycle: {sentence}", file=sys.stderr)
    if not problems:
        print("All that is needed is there.")
    return FAILED if problems else DONE


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _browser() -> tuple[str, str]:
    """Nothing needs one, but a report is looked at in one."""
    names = ("chromium", "google-chrome", "chrome", "firefox", "msedge", "safari")
    found = next((path for path in map(shutil.which, names) if path), None)
    return ("found", found) if found else ("not found", "only for looking at reports")


def _processor() -> str:
    """The model, where the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:  # no Linux
        return platform.processor() or "unknown model"
    models = [line.partition(":")[2].strip() for line in lines if line.lower().startswith("model name")]
    return models[0] if models else platform.processor() or "unknown model"


def _cache() -> tuple[Path, str]:
    """The folder of kept builds, and what stands against writing there: found out by writing."""
    from stcore import cache

    folder = cache.cache_dir()
    existing = next(p for p in (folder, *folder.parents) if p.exists())
    if not existing.is_dir():
        return folder, f"{existing} is not a folder"
    trial = folder / f"doctor.{os.getpid()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        trial.write_bytes(b"scancycle")
        trial.unlink()
    except OSError as error:
        return folder, f"{error.strerror or error}: {error.filename or folder}"
    return folder, ""


def _size(folder: Path) -> str:
    total = sum(f.stat().st_size for f in folder.rglob("*") if f.is_file())
    return f"{total / 1e6:.1f} MB"


def _trial(problems: list[str]) -> tuple[str, str]:
    """Compile and run the smallest of programs."""
    if problems:
        return "not tried", "something that is needed is missing"
    from plcruntime.plc import PLC

    began = time.perf_counter()
    plc = PLC.load(PROGRAM)
    plc.scan(1000)
    took = 1000 * (time.perf_counter() - began)
    if plc["n"] != 1000:
        problems.append("the trial program does not count right: please report this with the table above")
        return "wrong", f"n is {plc['n']} after 1000 scans"
    return "runs", f"compiled, loaded and run for 1000 scans in {took:.0f} ms"

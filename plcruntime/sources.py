"""From what the user names (files, a folder, a project, a text) to what the compiler reads."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from plcruntime import project as projects
from plcruntime.errors import UsageError
from plcruntime.project import Project
from stcore.source import Source

SUFFIXES = (".st", ".exp", ".iecst")


def gather(
    named: str | Path | Sequence[str | Path], config: str | Path | None = None, beside: Path | None = None
) -> tuple[list[Path | Source], Project]:
    """The files to compile and the project's settings.

    named: a file, a folder (all its ST files, or its plc.toml), a plc.toml, the text of a program, or a list of those.
    beside: the folder where a text's further POUs are looked for.
    A file that can't be read is the compiler's to report. Raises UsageError for a wrong plc.toml, a folder without ST.
    """
    items = [named] if isinstance(named, str | Path) else list(named)
    if not items and config is None:
        raise UsageError("no file named")
    project = projects.load(config) if config is not None else Project()
    files: list[Path | Source] = []
    for item in items:
        if is_text(item):
            files.append(Source(str(item), "<text>", beside))
            continue
        path = Path(item)
        toml = path / projects.NAME if path.is_dir() else path
        if toml.suffix == ".toml" and toml.is_file() and config is None:
            project = projects.load(toml)
            files += _of_project(project)
        elif path.is_dir():
            files += _of_folder(path)
        else:
            files.append(path)
    return [*(files or _of_project(project)), *projects.declarations(project)], project


def is_text(item: str | Path) -> bool:
    """True for the text of a program: no file's name has a line break, and hardly one a semicolon."""
    return isinstance(item, str) and ("\n" in item or ";" in item and not os.path.exists(item))


def _of_project(project: Project) -> list[Path | Source]:
    files: list[Path | Source] = []
    for path in project.files:
        files += _of_folder(path) if path.is_dir() else [path]
    return files


def _of_folder(folder: Path) -> list[Path]:
    found = sorted(p for p in folder.iterdir() if p.suffix.lower() in SUFFIXES and p.is_file())
    if not found:
        raise UsageError(f"no .st file in the folder {folder}")
    return found

"""The examples of examples_st and how they are run; the form of their first comment: examples_st/README.md."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

KEYS = ("run", "again", "picture", "expect", "fault", "errors")


@dataclass(slots=True)
class Example:
    path: Path
    text: str
    shows: str
    run: str
    again: str
    picture: list[str]


@cache
def read(path: Path) -> Example:
    text = path.read_text(encoding="utf-8")
    found, key = {"shows": ""}, "shows"
    for line in re.match(r"\(\*(.*?)\*\)", text, re.S)[1].splitlines():
        start = re.match(rf"\s*({'|'.join(KEYS)}):(.*)", line)
        if start:
            key, line = start[1], start[2]
        found[key] = f"{found.get(key, '')} {line.strip()}".strip()
    picture = [p.strip() for p in found.get("picture", "").split(",") if p.strip()]
    return Example(path, text, found["shows"], found["run"], found.get("again", ""), picture)

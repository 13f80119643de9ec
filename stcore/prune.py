"""Keeps the cache small: once a day, what was not used for long goes, and the oldest of what is too much.

Ages are those of the file system's own clock; a file is as old as its last use, where the file system notes uses.
"""

from __future__ import annotations

import os
from pathlib import Path

DAY = 24 * 3600
UNUSED = 14 * DAY  # s without a use
LIMIT = 400 * 2**20  # bytes; more than that is cut down to half of it
STAMP = "pruned"  # an empty file: its time is that of the last look


def prune_daily(folder: Path) -> None:
    """Look at the cache if the last look is a day ago. Raises OSError where it can't be written."""
    stamp = folder / STAMP
    before = stamp.stat().st_mtime if stamp.exists() else 0.0
    fresh = folder / f"{STAMP}.{os.getpid()}.part"
    fresh.touch()
    now = fresh.stat().st_mtime
    if now - before < DAY:
        fresh.unlink()
        return
    os.replace(fresh, stamp)  # first: another process that starts now leaves it to this one
    prune(folder, now)


def prune(folder: Path, now: float) -> None:
    """Remove what is unused since UNUSED before `now` (s, as in st_mtime), and the oldest beyond LIMIT."""
    files = []
    for place, _, names in os.walk(folder):
        for name in names:
            if name == STAMP:
                continue
            path = os.path.join(place, name)
            try:
                stat = os.stat(path)
            except FileNotFoundError:
                continue  # another process has removed it
            files.append((max(stat.st_mtime, stat.st_atime), stat.st_size, path))
    files.sort(reverse=True)
    total = sum(size for _, size, _ in files)
    room = LIMIT // 2 if total > LIMIT else total
    for used, size, path in files:
        room -= size
        if now - used > UNUSED or room < 0:
            Path(path).unlink(missing_ok=True)

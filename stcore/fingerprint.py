"""What a cached thing was made of: digests of texts, and of the compiler's own files."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path


def digest(*parts: bytes) -> str:
    """A name for content."""
    state = hashlib.sha256()
    for part in parts:
        state.update(len(part).to_bytes(8, "little"))
        state.update(part)
    return state.hexdigest()


@cache
def compiler_fingerprint() -> str:
    """Changes whenever a file of the compiler does."""
    root = Path(__file__).parent
    files = sorted(f for f in root.rglob("*") if f.suffix in (".py", ".wat", ".lark"))
    return digest(*(f"{f.name} {(i := f.stat()).st_mtime_ns} {i.st_size}".encode() for f in files))

"""'Did you mean ...': the known names nearest to one that is not known."""

from __future__ import annotations

from collections.abc import Iterable


def nearest(name: str, known: Iterable[str], count: int = 3) -> list[str]:
    """Up to `count` names that look like `name`, the nearest first; case does not matter."""
    from difflib import get_close_matches  # a program without mistakes starts without it

    spelling = {k.upper(): k for k in known}
    return [spelling[n] for n in get_close_matches(name.upper(), spelling, count, 0.75)]


def near(name: str, known: Iterable[str]) -> str:
    """A hint, or '' when nothing is near."""
    names = nearest(name, known)
    return f"did you mean {' or '.join(names)}?" if names else ""

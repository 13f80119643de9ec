"""Whether a typed text goes on in the next line: an IF without its END_IF, a comment that is not closed."""

from __future__ import annotations

import re

from plcruntime.repl.commands import split

OPENING = ("IF", "CASE", "FOR", "WHILE", "REPEAT")
_PIECE = re.compile(
    r"""\(\*.*?\*\)|/\*.*?\*/|//[^\n]*|'(?:\$.|[^'$\n])*'|"(?:\$.|[^"$\n])*"|(?P<open>\(\*|/\*)|(?P<word>[^\W\d]\w*)""",
    re.S,
)


def incomplete(text: str) -> bool:
    """True while more lines have to follow. A line that begins with a command is whole; an empty line ends any text."""
    if text.endswith("\n") or split(text)[0]:
        return False
    depth = 0
    for piece in _PIECE.finditer(text):
        if piece["open"]:
            return True
        word = (piece["word"] or "").upper()
        depth += (word in OPENING) - (word.startswith("END_") and word[4:] in OPENING)
    return depth > 0

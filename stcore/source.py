"""A source text and its places."""

from __future__ import annotations

import re
from bisect import bisect_right
from pathlib import Path

from stcore.typeset import joined

_NO_TEXT = re.compile(rb"[\x00-\x08\x0e-\x1f]")


class Source:
    """A text with its path; offsets are characters of `text` (line ends normalised to \\n). folder: where POUs that it
    does not define are looked for, that of its file unless told."""

    __slots__ = ("path", "text", "_folder", "_starts")

    def __init__(self, text: str, path: str = "<text>", folder: Path | None = None) -> None:
        self._folder = folder
        self.text = joined(text.replace("\r\n", "\n").replace("\r", "\n"))
        self.path = path
        self._starts: list[int] | None = None

    @property
    def starts(self) -> list[int]:
        if self._starts is None:
            starts = [0]
            find = self.text.find
            at = find("\n")
            while at >= 0:
                starts.append(at + 1)
                at = find("\n", at + 1)
            self._starts = starts
        return self._starts

    @property
    def folder(self) -> Path | None:
        """None for a text without one."""
        return self._folder or (Path(self.path).parent if Path(self.path).is_file() else None)

    def position(self, offset: int) -> tuple[int, int]:
        """(line, column) of an offset, both from 1."""
        line = bisect_right(self.starts, offset)
        return line, offset - self.starts[line - 1] + 1

    def line(self, number: int) -> str:
        """The text of a line (from 1), without its end."""
        start = self.starts[number - 1]
        end = self.text.find("\n", start)
        return self.text[start : end if end >= 0 else len(self.text)]


def read(path: str | Path) -> Source:
    """Read a file as UTF-8, else as GB18030 (the code page of the Chinese tools).

    Raises OSError when the file can't be read or is no text; a byte that neither encoding knows becomes U+FFFD, which
    the lexer reports at its place.
    """
    data = Path(path).read_bytes()
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return Source(data.decode("utf-16", errors="replace"), str(path))
    if 100 * len(_NO_TEXT.findall(data)) > len(data):
        raise OSError("it is no text")
    for encoding in ("utf-8-sig", "gb18030"):
        try:
            return Source(data.decode(encoding), str(path))
        except UnicodeDecodeError:
            continue
    return Source(data.decode("utf-8", errors="replace"), str(path))

"""What print and copying put around and into a text: line numbers, page heads, signs of a typesetter.

`without_frame` blanks out what is no part of the program; offsets stay. The signs are read by stcore/lexer.py.
"""

from __future__ import annotations

import re

# Signs that stand for one of ST: in the width of a Chinese character, as a typesetter or a word processor sets them.
SIGNS = {
    **dict(zip("；，：（）＝．＋－＊／＜＞［］＆＾、【】", ";,:()=.+-*/<>[]&^,[]", strict=True)),
    **dict(zip("–—−‒∶×÷⋅", "----:*/*", strict=True)),
    "≤": "<=", "≥": ">=", "≠": "<>", "≔": ":=", "⇒": "=>",
}  # fmt: skip
_LETTERS = {**{0xFF00 + c: c + 0x20 for c in range(1, 0x5F)}, 0xFB00: "ff", 0xFB01: "fi", 0xFB02: "fl", 0xFB03: "ffi"}
_LETTERS |= dict.fromkeys(map(ord, "–−"), "-")  # in an exponent

# Lines that a page, a web page or a chat has beside the code; no statement looks like one.
_FRAME = re.compile(
    r"""(?imx) ^[ \t]* (?:
    ```[\w+-]*
  | [─━═—–−]{3,}
  | (?:page|example|figure|fig\.|table|listing|chapter)[ \t]+\d[\d.-]*(?!\w)(?![ \t]*[:=(;]).*
  | 第[ \t]*\d+[ \t]*[页頁章].*
  | [^'\n]*(?:[©®™]|\(c\)[ \t]*(?:19|20)\d\d).*
    ) [ \t]*$"""
)
_NUMBERED = re.compile(r"[ \t]*(\d+)(?:[ \t]*[:.|)](?!=)[ \t]?|[ \t]+|$)")
_QUOTED = re.compile(r"[ \t]*>[ \t]?")
_BULLET = re.compile(r"(?m)^[ \t]*([•▪●◦‣■►])[ \t]*")
_SKIPPED = re.compile(r"\(\*.*?\*\)|/\*.*?\*/|//[^\n]*|\{[^}]*\}", re.S)
_INSIDE = re.compile("(?<=\\w)[\u00ad\u200b\u2060]+(?=\\w)")  # soft hyphens and what has no width, in a word


def joined(text: str) -> str:
    """The text without what divides words for the eye only, and with the line that joins them in its usual width."""
    if "＿" in text:
        text = text.replace("＿", "_")
    if "\u00ad" in text or "\u200b" in text or "\u2060" in text:
        return _INSIDE.sub("", text)
    return text


def plain_sign(text: str) -> str:
    """A sign as ST has it: the blank taken out of `: =`, each character in its usual width."""
    return "".join(SIGNS.get(c, c) for c in text if not c.isspace())


def plain_word(word: str) -> str:
    """A name or number in plain letters and digits where it has wide ones or ligatures."""
    return word.translate(_LETTERS)


def without_frame(text: str, problems: list[tuple]) -> str:
    """Blank out numbers or > in front of every line, bullets, and lines of the page."""
    text = _unnumbered(text, problems)
    if found := [m for m in _FRAME.finditer(text) if m[0].strip()]:
        comments = [m.span() for m in _SKIPPED.finditer(text)]
        for match in found:
            start = match.start() + len(match[0]) - len(match[0].lstrip())
            if not any(first <= start < last for first, last in comments):
                problems.append(("W0105", start, match.end(), {"text": match[0].strip()}))
                text = _blanked(text, match.start(), match.end())
    for match in _BULLET.finditer(text):
        problems.append(("W0115", match.start(1), match.end(1), {"what": f"the sign {match[1]} at the start"}))
        text = _blanked(text, match.start(1), match.end(1))
    return text


def _blanked(text: str, start: int, end: int) -> str:
    return f"{text[:start]}{' ' * (end - start)}{text[end:]}"


def _unnumbered(text: str, problems: list[tuple]) -> str:
    start = text.lstrip()[:1]
    if not (start.isdigit() or start == ">"):
        return text
    pattern, what = (_QUOTED, "the signs >") if start == ">" else (_NUMBERED, "the line numbers")
    lines = text.split("\n")
    matches = [pattern.match(line) for line in lines]
    if len(lines) < 3 or any(match is None and line.strip() for match, line in zip(matches, lines, strict=True)):
        return text
    if start != ">":
        numbers = [int(match[1]) for match in matches if match]
        if any(b <= a for a, b in zip(numbers, numbers[1:], strict=False)) or numbers[-1] - numbers[0] > len(lines):
            return text
    at = len(text) - len(text.lstrip())
    problems.append(("W0115", at, at + 1, {"what": f"{what} in front of the lines"}))
    ends = [match.end() if match else 0 for match in matches]
    return "\n".join(" " * end + line[end:] for line, end in zip(lines, ends, strict=True))

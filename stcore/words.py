"""The parser's words for its user: how each terminal is called, and which keyword a misspelt word was meant to be."""

from __future__ import annotations

import re

from stcore.lexer import KEYWORDS, KIND, SOFT, TERMINALS, WORDS

_NAMES = {
    "$END": "the end of the file", "NAME": "a name", "NUMBER": "a value", "TYPED": "a value", "TEXT": "a string",
    "BOOLEAN": "TRUE or FALSE", "ADDRESS": "an address", "PART": "a part", "ASSIGN": ":=", "SETOP": "S=",
    "ARROW": "=>", "EQ": "=", "SIGN": "+ or -", "BINOP": "an operator", "WORDOP": "an operator", "COLON": ":",
    "SEMI": ";", "COMMA": ",", "DOT": ".", "DOTDOT": "..", "CARET": "^", "HASH": "#", "LPAR": "(", "RPAR": ")",
    "LBRACKET": "[", "RBRACKET": "]", "QUALIFIER": "CONSTANT or RETAIN",
    "MODIFIER": "PUBLIC",
}  # fmt: skip

# what stands for a token that was missing, so that the tree is whole
_TEXTS = {"NAME": "_", "NUMBER": "0", "TYPED": "T#0s", "TEXT": "''", "BOOLEAN": "FALSE", "SIGN": "+", "BINOP": "*"}

CLOSERS = {
    "IF": "END_IF", "CASE": "END_CASE", "FOR": "END_FOR", "WHILE": "END_WHILE", "REPEAT": "END_REPEAT",
    "STRUCT": "END_STRUCT", "UNION": "END_UNION", "TYPE": "END_TYPE", "VAR": "END_VAR", "VAR_GLOBAL": "END_VAR",
    "VAR_ACCESS": "END_VAR",
    "PROGRAM": "END_PROGRAM", "FUNCTION": "END_FUNCTION", "FUNCTION_BLOCK": "END_FUNCTION_BLOCK",
    "METHOD": "END_METHOD", "PROPERTY": "END_PROPERTY", "GET": "END_GET", "SET": "END_SET",
    "INTERFACE": "END_INTERFACE",
    "ACTION": "END_ACTION", "CONFIGURATION": "END_CONFIGURATION", "RESOURCE": "END_RESOURCE",
}  # fmt: skip
_GLUED = re.compile(rf"({'|'.join(k for k in KEYWORDS if k.startswith('END_'))})(?!_)(\w+)", re.I)
CLOSER_OF = {KIND[opener]: KIND[closer] for opener, closer in CLOSERS.items()}
CLOSING = frozenset(CLOSER_OF.values()) | {KIND["ELSE"], KIND["ELSIF"], KIND["UNTIL"]}
UNIT_STARTERS = frozenset(
    KIND[n] for n in (
        "PROGRAM", "FUNCTION", "FUNCTION_BLOCK", "TYPE", "VAR_GLOBAL", "CONFIGURATION", "ACTION", "METHOD", "PROPERTY",
        "INTERFACE",
    )
)


def word(kind: int) -> str:
    """A terminal as the user knows it."""
    name = TERMINALS[kind]
    return _NAMES.get(name, name)


def text_for(kind: int) -> str:
    """The text of a token that is put in."""
    return _TEXTS.get(TERMINALS[kind]) or word(kind)


def opener_of(closer: int) -> str:
    """What END_IF, ELSE, ... belong to."""
    name = TERMINALS[closer]
    if name == "UNTIL":
        return "REPEAT"
    return name[4:] if name.startswith("END_") else "IF"


def distance(a: str, b: str, limit: int) -> int:
    """Letters to change, drop, add or swap with their neighbour to make b of a; limit + 1 when there are more."""
    if abs(len(a) - len(b)) > limit:
        return limit + 1
    before, row = [], list(range(len(b) + 1))
    for i, letter in enumerate(a, 1):
        before, last, row = row, before, [i]
        for j, other in enumerate(b, 1):
            cost = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (letter != other))
            if i > 1 and j > 1 and letter == b[j - 2] and a[i - 2] == other:
                cost = min(cost, last[j - 2] + 1)
            row.append(cost)
        if min(row) > limit:
            return limit + 1
    return min(row[-1], limit + 1)


def near_keywords(text: str) -> list[tuple[str, int]]:
    """The keywords that a misspelt word may have meant, with their distance, nearest first."""
    wanted = text.upper()
    found = []
    for keyword in KEYWORDS:
        limit = 1 if len(keyword) < 5 else 2
        if (away := distance(wanted, keyword, limit)) <= limit:
            found.append((keyword, away))
    return sorted(found, key=lambda f: f[1])


def keyword_kind(keyword: str) -> int:
    """The terminal of a keyword, also of one that is a keyword only in its place."""
    return KIND[keyword] if WORDS[keyword] == SOFT else WORDS[keyword]


def glued(text: str) -> str:
    """END_IF for END_IFrtn, a keyword that the next word stuck to; '' for any other name."""
    match = _GLUED.fullmatch(text)
    return match[1].upper() if match else ""

"""Pragmas: ``{attribute 'name' := 'value'}`` kept for the tree, ``{IF defined (x)}`` evaluated while lexing."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stcore.lexer import Tokens

_ATTRIBUTE = re.compile(r"\{\s*attribute\s+'([^']*)'\s*(?::=\s*'([^']*)')?\s*\}", re.I | re.S)
_QUOTES = dict.fromkeys(map(ord, "‘’“”′‵`´\""), "'")
_OTHER = re.compile(r"\{\s*(\w+)\s*(.*?)\s*\}", re.S)
_CONDITION = re.compile(r"\{\s*(IF|ELSIF|ELSE|END_IF|DEFINE|UNDEFINE)\b\s*(.*?)\s*\}", re.I | re.S)
_TERM = re.compile(r"\s*(?:(defined|hasvalue)\s*\(([^()]*)\)|(AND|OR|XOR|NOT)\b|([()])|(\S+))", re.I)


class Pragmas:
    """Gathers the pragmas of a text with the number of the token that follows them."""

    def __init__(self, problems: list[tuple]) -> None:
        self.found: list[tuple[int, str, str]] = []
        self.others: dict[str, str] = {}
        self.problems = problems

    def take(self, text: str, start: int, next_token: int) -> None:
        """Note a pragma. Unknown ones ({info ..}, {warning ..}) are somebody else's and no error."""
        plain = text.translate(_QUOTES)
        if match := _ATTRIBUTE.fullmatch(plain):
            if plain != text:
                self.problems.append(("W0101", start, start + len(text), {"text": text}))
            self.found.append((next_token, match[1].lower(), match[2] or ""))
        elif match := _OTHER.fullmatch(text):
            if match[1].lower() == "attribute":
                why = "an attribute is written {attribute 'name' := 'value'}"
                self.problems.append(("E0109", start, start + len(text), {"text": text, "why": why}))
            self.others[match[1].lower()] = match[2].strip("'")

    def attach(self, tokens: Tokens) -> None:
        """Give the tokens their attributes, by offset: repairs may still move them in the list."""
        for number, name, value in self.found:
            offset = tokens.starts[min(number, len(tokens.starts) - 1)]
            tokens.attributes.setdefault(offset, {})[name] = value
        tokens.file_attributes = self.others


class Conditions:
    """Conditional pragmas: the tokens of a branch not taken are cut off again."""

    def __init__(self, tokens: Tokens, problems: list[tuple]) -> None:
        self.tokens = tokens
        self.problems = problems
        self.defined: set[str] = set()
        self.open: list[list] = []  # [a branch was taken, this one is, tokens before, problems before, offset]

    def take(self, text: str, start: int) -> bool:
        """Handle a conditional pragma; False when it is another one."""
        match = _CONDITION.fullmatch(text)
        if not match:
            return False
        word, rest = match[1].upper(), match[2]
        if word == "IF":
            self.open.append([False, True, 0, 0, start])
            self._begin(self._holds(rest))
        elif word in ("DEFINE", "UNDEFINE"):
            if all(taken for _, taken, *_ in self.open):
                name = rest.split()[0].lower() if rest else ""
                (self.defined.add if word == "DEFINE" else self.defined.discard)(name)
        elif not self.open:
            self.problems.append(("E0118", start, start + len(text), {"what": "{IF}", "found": text}))
        else:
            self._end()
            if word == "END_IF":
                self.open.pop()
            else:
                self._begin(not self.open[-1][0] and (word == "ELSE" or self._holds(rest)))
        return True

    def finish(self) -> None:
        """The end of the text: an {IF} still open is an error."""
        while self.open:
            self._end()
            start = self.open.pop()[4]
            self.problems.append(("E0118", start, start + 4, {"what": "{END_IF}", "found": "{IF}"}))

    def _begin(self, taken: bool) -> None:
        branch = self.open[-1]
        branch[0] |= taken
        branch[1:4] = taken, len(self.tokens.kinds), len(self.problems)

    def _end(self) -> None:
        _, taken, tokens, problems, _ = self.open[-1]
        if not taken:
            self.tokens.delete(tokens, len(self.tokens.kinds))
            del self.problems[problems:]

    def _holds(self, text: str) -> bool:
        """A condition: defined (x), NOT, AND, OR, XOR, parentheses. What is not known of the project is false."""
        terms = [m.groups() for m in _TERM.finditer(text)]
        at = 0

        def unary() -> bool:
            nonlocal at
            if at >= len(terms):
                return False
            kind, argument, word, bracket, _ = terms[at]
            at += 1
            if word and word.upper() == "NOT":
                return not unary()
            if bracket == "(":
                value = binary()
                at += 1
                return value
            return bool(kind) and kind.lower() == "defined" and argument.strip().lower() in self.defined

        def binary() -> bool:
            nonlocal at
            value = unary()
            while at < len(terms) and (word := (terms[at][2] or "").upper()) in ("AND", "OR", "XOR"):
                at += 1
                other = unary()
                value = value and other if word == "AND" else value or other if word == "OR" else value != other
            return value

        return binary()

"""The words of a motion program, with macros replaced, and the reader that goes through them."""

from __future__ import annotations

import re
from dataclasses import dataclass

from mclib.motion_programs.code import MotionError

TYPES = {"int": "int", "short": "int", "long": "int", "double": "double", "void": "void"}
FOREIGN_TYPES = frozenset(("char", "float", "signed", "unsigned", "const", "static", "bool"))
_SPLIT = re.compile(r"(int|short|long|double|void)([A-Za-z_]\w*)$")
_TOKEN = re.compile(
    r"(?P<blank>[ \t\r\f]+|…+|\.{3,})|(?P<line>\n)|(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<define>\#[ \t]*define\b[^\n]*)"
    r"|(?P<number>0[xX][0-9a-fA-F]+|\d+\.\d*|\.\d+|\d+)|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<sign>&&|\|\||==|>=|<=|!=|<<|>>|[-+*/%<>=!~&|^(){}\[\];:,])",
    re.S | re.A,
)


@dataclass(slots=True)
class Token:
    kind: str
    text: str
    line: int


class Words:
    """The words of a text, one after the other."""

    def __init__(self, text: str) -> None:
        self.macros: dict[str, list[Token]] = {}
        self.tokens = self._tokens(text.replace("；", ";").replace("，", ","))
        self.at = 0

    def _tokens(self, text: str) -> list[Token]:
        tokens, line, at = [], 1, 0
        while at < len(text):
            found = _TOKEN.match(text, at)
            if found is None:
                end = text.find("\n", at)
                rest = text[at : end if end >= 0 else None]
                if not rest.isascii() and not re.search("[;{}]", rest):
                    at += len(rest)  # a comment that was printed on two lines
                    continue
                raise MotionError(line, f"'{text[at]}' has no meaning here")
            if text.startswith("/*", at) and found.lastgroup != "comment":
                raise MotionError(line, "the comment is not closed: */ is missing")
            at = found.end()
            kind = found.lastgroup
            if kind == "define":
                self._define(found.group().split("//")[0], line)
            elif kind in ("number", "word", "sign"):
                tokens += self.macros.get(found.group()) or [Token(kind, found.group(), line)]
                tokens[-1] = Token(tokens[-1].kind, tokens[-1].text, line)
            line += found.group().count("\n")
        return [*tokens, Token("end", "end of the file", line)]

    def _define(self, text: str, line: int) -> None:
        words = re.match(r"#\s*define\s+([A-Za-z_]\w*)\s+(-?\s*[\w.]+)\s*$", text)
        if words is None:
            raise MotionError(line, "a macro is written '#define NAME number'")
        name, value = words.groups()
        found = [Token(m.lastgroup or "", m.group(), line) for m in _TOKEN.finditer(value) if m.lastgroup != "blank"]
        if found[0].text == "-" and len(found) == 2:
            found = [Token("number", "-" + found[1].text, line)]
        self.macros[name] = found[:1]

    @property
    def token(self) -> Token:
        return self.tokens[self.at]

    def take(self) -> Token:
        token = self.token
        self.at += 1
        return token

    def accept(self, text: str) -> bool:
        if self.token.text == text and self.token.kind != "end":
            self.at += 1
            return True
        return False

    def expect(self, text: str, after: str) -> None:
        if not self.accept(text):
            line = self.tokens[max(self.at - 1, 0)].line
            raise MotionError(line, f"{text} is missing {after}")

    def name(self, what: str) -> Token:
        token = self.take()
        if token.kind != "word":
            raise MotionError(token.line, f"{what} is missing before '{token.text}'")
        return token

    def split(self, *, but: set[str]) -> None:
        """Take a word apart that has lost the blank behind its type: intsum."""
        token = self.token
        found = _SPLIT.match(token.text) if token.kind == "word" and token.text not in but else None
        if found:
            self.tokens[self.at : self.at + 1] = [Token("word", x, token.line) for x in found.groups()]

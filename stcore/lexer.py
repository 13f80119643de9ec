"""Text -> tokens: one master expression, one pass.

A token is four parallel entries of `Tokens`: kind (an index into TERMINALS), start, end, text. Keywords are found by
looking the identifier up in a table of words, each spelling classified once; everything else that reads like a name
is a NAME. A few words are keywords only where their neighbours say so (`ON`, `TASK`, `ACTION`, `AT`, ...): a program
may use them as names.

Comments disappear. Attribute pragmas are kept beside the tokens, by the offset of the token that they stand before;
conditional pragmas are evaluated here.
"""

from __future__ import annotations

import re

from stcore.diagnostics import Reporter
from stcore.pragmas import Conditions, Pragmas
from stcore.source import Source
from stcore.typeset import SIGNS, plain_sign, plain_word, without_frame

# The terminals of grammar.lark, and behind SOFT those that only the lexer and the mends see.
TERMINALS = (
    "$END", "NAME", "NUMBER", "TYPED", "TEXT", "BOOLEAN", "ADDRESS", "PART", "STRING",
    "ASSIGN", "SETOP", "ARROW", "EQ", "SIGN", "BINOP", "WORDOP", "NOT",
    "COLON", "SEMI", "COMMA", "DOT", "DOTDOT", "CARET", "HASH", "LPAR", "RPAR", "LBRACKET", "RBRACKET",
    "PROGRAM", "END_PROGRAM", "FUNCTION", "END_FUNCTION", "FUNCTION_BLOCK", "END_FUNCTION_BLOCK",
    "ACTION", "END_ACTION", "TYPE", "END_TYPE", "STRUCT", "END_STRUCT", "UNION", "END_UNION",
    "CONFIGURATION", "END_CONFIGURATION", "RESOURCE", "END_RESOURCE", "ON", "TASK", "WITH",
    "VAR", "VAR_GLOBAL", "VAR_ACCESS", "EDGE", "END_VAR", "QUALIFIER", "AT", "ARRAY", "OF",
    "POINTER", "REFERENCE", "REF_TO", "TO",
    "EXTENDS", "IMPLEMENTS",
    "METHOD", "END_METHOD", "PROPERTY", "END_PROPERTY", "GET", "END_GET", "SET", "END_SET",
    "INTERFACE", "END_INTERFACE", "MODIFIER",
    "IF", "THEN", "ELSIF", "ELSE", "END_IF", "CASE", "END_CASE", "FOR", "BY", "DO", "END_FOR",
    "WHILE", "END_WHILE", "REPEAT", "UNTIL", "END_REPEAT", "EXIT", "CONTINUE", "RETURN", "JMP",
    "SOFT", "RULE", "DOTS", "BAD",
)  # fmt: skip
KIND = {name: i for i, name in enumerate(TERMINALS)}
NAME, NUMBER, SOFT, RULE, DOTS, BAD = (KIND[n] for n in ("NAME", "NUMBER", "SOFT", "RULE", "DOTS", "BAD"))
END_KINDS = frozenset(k for n, k in KIND.items() if n.startswith("END_"))
OBJECT_ENDS = frozenset(KIND[f"END_{n}"] for n in ("METHOD", "PROPERTY", "GET", "SET"))

_RESERVED = """
PROGRAM END_PROGRAM FUNCTION END_FUNCTION FUNCTION_BLOCK END_FUNCTION_BLOCK END_ACTION TYPE END_TYPE STRUCT
END_STRUCT UNION END_UNION END_CONFIGURATION END_RESOURCE VAR VAR_GLOBAL END_VAR ARRAY OF POINTER REFERENCE TO
VAR_ACCESS END_METHOD END_PROPERTY END_GET END_SET END_INTERFACE
IF THEN ELSIF ELSE END_IF CASE END_CASE FOR BY DO END_FOR WHILE END_WHILE REPEAT UNTIL END_REPEAT EXIT
CONTINUE RETURN JMP NOT STRING
"""
_SAME = {  # several words, one terminal
    "VAR": "VAR_INPUT VAR_OUTPUT VAR_IN_OUT VAR_TEMP VAR_STAT VAR_INST VAR_EXTERNAL",
    "VAR_GLOBAL": "VAR_CONFIG",
    "QUALIFIER": "CONSTANT RETAIN PERSISTENT NON_RETAIN",
    "STRING": "WSTRING",
    "BOOLEAN": "TRUE FALSE",
    "WORDOP": "AND OR XOR MOD",
    "BINOP": "AND_THEN OR_ELSE",
    # keywords only in their place, see soft_words.py
    "SOFT": "ACTION CONFIGURATION RESOURCE ON TASK WITH AT REF_TO EXTENDS IMPLEMENTS METHOD INTERFACE PROPERTY GET SET "
    "S R REF ABSTRACT FINAL PUBLIC PRIVATE PROTECTED INTERNAL OVERRIDE R_EDGE F_EDGE",
}
WORDS = {word: KIND[word] for word in _RESERVED.split()}
for _terminal, _words in _SAME.items():
    WORDS.update((word, KIND[_terminal]) for word in _words.split())
_BY_PLACE = ("ACTION", "METHOD", "PROPERTY", "INTERFACE")  # words that a slip may have been meant for all the same
KEYWORDS = sorted(w for w, k in WORDS.items() if k != SOFT) + [*_BY_PLACE]

_SIGNS = {
    ":=": "ASSIGN", "=>": "ARROW", "=": "EQ", "+": "SIGN", "-": "SIGN", ":": "COLON", ";": "SEMI", ",": "COMMA",
    ".": "DOT", "..": "DOTDOT", "^": "CARET", "#": "HASH", "(": "LPAR", ")": "RPAR", "[": "LBRACKET", "]": "RBRACKET",
    **dict.fromkeys(("*", "/", "**", "<", ">", "<=", ">=", "<>", "&"), "BINOP"),
}  # fmt: skip
_KNOWN = {sign: KIND[terminal] for sign, terminal in _SIGNS.items()}

_TIMES = "LTIME|TIME|LT|T"
_DATES = "LDATE|DATE|LD|D"
_CLOCKS = "LTIME_OF_DAY|TIME_OF_DAY|LTOD|TOD"
_STAMPS = "LDATE_AND_TIME|DATE_AND_TIME|LDT|DT"
_NUMERIC = "BOOL|BYTE|[DL]?WORD|U?[SDL]?INT|L?REAL"
_Q = "‘’“”′‵`´"  # typographic quotes; any of them opens or closes

_SIMPLE = rf"""
    [^\W\d]\w*+(?!\#)
  | (?i:(?:{_TIMES})\#[+-]?\w+(?:\.\w+)*
      | (?:{_DATES})\#\w+(?:-\w+){{0,2}}
      | (?:{_CLOCKS})\#\w+(?::\w+){{0,2}}(?:\.\w+)?
      | (?:{_STAMPS})\#\w+(?:-\w+){{0,3}}(?::\w+){{0,2}}(?:\.\w+)?
      | (?:{_NUMERIC})\#[+-]?\w+(?:\#\w+|\.\d\w*(?:(?<=e)[+-]\d+)?|(?<=\#\de)[+-]\d+)?)
  | \d\w*+(?:\#\w+|[.．]\d\w*+(?:(?<=[eE])[-+–−]\d+)?|(?<=[eE])[-+–−]\d+)?
  | (?!(?i:W?STRING|W?CHAR)\#['"])[^\W\d]\w*+
  | %[A-Za-z]*\*?\d*(?:\.\d+)*
  | -{{3,}}(?=[ \t]*$) | ={{3,}}(?=[ \t]*$) | (?<![\w\])])\.(?:[ \t]*\.){{2,}} | …+
  | :=|=>|<=|>=|<>|\*\*|\.\.|[-+*/=<>&,;:.\[\]^\#)]|\((?!\*)
"""
_TEXTS = rf"""
    '(?:[^'$\n]|\$[^\n])*'
  | "(?:[^"$\n]|\$[^\n])*"
  | [{_Q}][^\n'{_Q};)；）]*[{_Q}']
  | [{_Q}][^\n'{_Q}]*[{_Q}'](?=[ \t]*(?:[),;=<>+]|$))
  | '[^\n'{_Q}]*[{_Q}]
  | [{_Q}][^\n'{_Q}),;）；，]*
  | ['"][^\n'"),;]*?(?=[ \t]+(?i:THEN|DO|OF)\b|[\n'"),;]|\Z)
"""
# A comment and a sign of two characters of which one is wide, or with a blank between.
_PRINTED = r"""
    [(（][ \t]*\*(?s:.*?)\*[ \t]*[)）] | ／／[^\n]*
  | [:：∶][ \t]*[=＝] | [=＝][>＞] | [<＜][=＝>＞] | [>＞][=＝] | [.．][.．] | [*＊][*＊]
"""
_COMMENT = r"\(\*(?![^\n*(]*\*）[ \t]*$)"  # the beginning of one that does not end with a wide bracket
# groups: 1 word, number or sign, 2 comment, 3 pragma, 4 string, 5 comment or pragma without end, 6 anything else;
# STRING#'x' says nothing that 'x' does not
_MASTER = re.compile(
    rf"""(?xm) [\s\ufeff\u200b]*+ (?:
    (?!/[/*] | :[ \t]*＝ | :[ \t]+= | [=<>][＝＞] | \.． | \*＊ | \([ \t]+\*) ({_SIMPLE})
  | (//[^\n]* | {_COMMENT}(?s:.*?)\*\) | /\*(?s:.*?)\*/)
  | (\{{[^}}]*\}})
  | (?:(?i:W?STRING|W?CHAR)\#)? ({_TEXTS})
  | ((?:{_COMMENT}|/\*|\{{)(?s:.*))
  | ({_PRINTED}|\S)
  | \Z )"""
)
_NESTED = re.compile(r"\{\s*nested_comments\s*\}", re.I)
_MAX_JUNK = 100
_WORD = re.compile(r"[^\W\d]")


class Tokens:
    """The tokens of a source, as parallel lists that end with $END.

    attributes: offset of a token -> the attribute pragmas in front of it. file_attributes: other pragmas, by name.
    """

    __slots__ = ("source", "kinds", "starts", "ends", "texts", "attributes", "file_attributes", "soft", "junk")

    def __init__(self, source: Source) -> None:
        self.source = source
        self.kinds: list[int] = []
        self.starts: list[int] = []
        self.ends: list[int] = []
        self.texts: list[str] = []
        self.attributes: dict[int, dict[str, str]] = {}
        self.file_attributes: dict[str, str] = {}
        self.junk: list[int] = []  # where characters stood that are no tokens
        self.soft = False  # there are words whose neighbours decide what they are

    def insert(self, at: int, kind: int, text: str = "", offset: int | None = None) -> None:
        """Put a token in that the text does not have; it lies at the end of the token before it."""
        if offset is None:
            offset = self.ends[at - 1] if at else 0
        self.kinds.insert(at, kind)
        self.starts.insert(at, offset)
        self.ends.insert(at, offset)
        self.texts.insert(at, text)

    def delete(self, first: int, last: int) -> None:
        """Take the tokens first..last-1 out."""
        for column in (self.kinds, self.starts, self.ends, self.texts):
            del column[first:last]

    def replace(self, first: int, last: int, kind: int, text: str) -> None:
        """One token of this kind and text for the tokens first..last-1."""
        self.ends[first] = self.ends[last - 1]
        self.kinds[first], self.texts[first] = kind, text
        self.delete(first + 1, last)

    def line(self, at: int) -> int:
        """The line, from 1, that a token starts on."""
        return self.source.position(self.starts[at])[0]

    def starts_line(self, at: int) -> bool:
        """Whether nothing but blanks and comments stands on the line before a token."""
        return at == 0 or self.line(at - 1) < self.line(at)


def tokenize(source: Source, reporter: Reporter) -> Tokens:
    """All tokens of a source. Reports what is no token, and the typographic signs that it reads as plain ones."""
    tokens = Tokens(source)
    kinds, starts, ends, texts = tokens.kinds, tokens.starts, tokens.ends, tokens.texts
    problems: list[tuple] = []
    text = without_frame(source.text, problems)
    if _NESTED.search(text):
        text = flatten_comments(text)
    known = dict(_KNOWN)  # spelling -> kind, each classified once
    wide: dict[str, str] = {}  # spelling in wide letters -> the plain one
    pragmas = Pragmas(problems)
    conditions = Conditions(tokens, problems)
    for match in _MASTER.finditer(text):
        word = match[1]
        if word is not None:
            kind = known.get(word)
            if kind is None:
                plain = word if word.isascii() else plain_word(word)
                kind = known[word] = _classify(plain, tokens)
                if plain != word:
                    wide[word] = plain
            kinds.append(kind)
            starts.append(match.start(1))
            ends.append(match.end())
            texts.append(word)
        elif match.lastindex == 3:
            if not conditions.take(match[3], match.start(3)):
                pragmas.take(match[3], match.start(3), len(kinds))
        elif match.lastindex is not None and match.lastindex != 2:
            _unusual(match, tokens, problems)
    for i, word in enumerate(texts if wide else ()):
        if word in wide:
            problems.append(("W0109", starts[i], ends[i], {"text": word, "plain": wide[word]}))
            texts[i] = wide[word]
    conditions.finish()
    starts.append(len(text))
    kinds.append(0)
    ends.append(len(text))
    texts.append("")
    for code, start, end, fields in problems:
        reporter.add(code, source, start, end, **fields)
    pragmas.attach(tokens)
    if tokens.soft:
        from stcore.soft_words import resolve  # that module is built on this one

        resolve(tokens, reporter)
    return tokens


def _classify(word: str, tokens: Tokens) -> int:
    """The kind of a spelling met for the first time."""
    first = word[0]
    if first.isdigit():
        return NUMBER
    if _WORD.match(first):
        if "#" in word:
            return KIND["TYPED"]
        kind = WORDS.get(word.upper(), NAME)
        if kind == SOFT or kind in OBJECT_ENDS:
            tokens.soft = True
        elif kind == NAME and len(word) > 2 and not word.strip("_"):
            tokens.soft = True
            return RULE
        return kind
    if first == "%":
        return KIND["ADDRESS"] if re.match(r"%[IQM]", word, re.I) else KIND["PART"]
    tokens.soft = True
    return RULE if first in "-=" else DOTS


def _unusual(match: re.Match, tokens: Tokens, problems: list[tuple]) -> None:
    """A string, an unclosed comment or pragma, a character that is no token of ST."""
    group, start, end = match.lastindex, match.start(match.lastindex), match.end()
    text = match[group]
    kind = KIND["TEXT"]
    if group == 4:
        text = _string(text, start, end, problems)
    elif group == 5:
        # the rest of the file is inside it; say so once, at its start
        problems.append(("E0108" if text[0] == "{" else "E0107", start, start + 2 - (text[0] == "{"), {}))
        return
    elif text[:2] == "／／" or text[-1] in ")）" and len(text) > 1:
        problems.append(("W0112", start, start + 2, {"found": text[:2], "plain": "//" if text[0] == "／" else "(*"}))
        return
    elif (plain := plain_sign(text)) in _KNOWN and (text[0] in SIGNS or len(text) > 1):
        problems.append(("W0112", start, end, {"found": text, "plain": plain}))
        kind, text = _KNOWN[plain], plain
    else:
        # a run of them is one problem, and a file of them needs no list
        if len(tokens.junk) < _MAX_JUNK and (not tokens.junk or start > tokens.junk[-1] + 1):
            shown = text if text.isprintable() else f"U+{ord(text):04X}"
            problems.append(("E0105", start, end, {"found": shown}))
        tokens.junk.append(start)
        return
    tokens.kinds.append(kind)
    tokens.starts.append(start)
    tokens.ends.append(end)
    tokens.texts.append(text)


def _string(text: str, start: int, end: int, problems: list[tuple]) -> str:
    """The string as it should have been written."""
    opening, closing = text[0], text[-1] if len(text) > 1 else ""
    if opening in "'\"" and closing == opening:
        return text
    if closing and (closing == "'" or closing in _Q):
        problems.append(("W0101", start, end, {"text": text}))
        return f"'{text[1:-1]}'"
    if opening in _Q:
        problems.append(("W0111", start, end, {"text": text}))
        return f"'{text[1:]}'"
    problems.append(("E0106", start, end, {"text": text}))
    return text.rstrip() + opening


def flatten_comments(text: str) -> str:
    """Blank out comments that contain comments, keeping every offset: ``{nested_comments}`` stands in the text."""
    out, depth, last = [], 0, 0
    for match in re.finditer(r"\(\*|\*\)|'(?:[^'$\n]|\$[^\n])*'|//[^\n]*", text):
        if match[0] == "(*":
            if depth == 0:
                out.append(text[last : match.start()])
                last = match.start()
            depth += 1
        elif match[0] == "*)" and depth:
            depth -= 1
            if depth == 0:
                out.append(re.sub(r"[^\n]", " ", text[last : match.end()]))
                last = match.end()
    out.append(text[last:])
    return "".join(out)

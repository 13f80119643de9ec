"""Words in their place: what the lexer found that is a keyword only between certain neighbours.

`METHOD Open` begins a method, `method := 1` assigns to a variable: words that programs use as names are kept for them.
Slips in the heads of methods are told here, since statements may follow a head and the parser would not see them.
"""

from __future__ import annotations

from stcore.diagnostics import Reporter
from stcore.lexer import DOTS, END_KINDS, KIND, NAME, NUMBER, OBJECT_ENDS, RULE, SOFT, TERMINALS, Tokens
from stcore.words import distance

_PATH_ENDS = frozenset(KIND[n] for n in ("NAME", "RBRACKET", "CARET", "NUMBER", "PART", "SOFT"))
_PATH_GOES_ON = frozenset(KIND[n] for n in ("ASSIGN", "DOT", "CARET", "LBRACKET", "LPAR", "SETOP", "COLON"))
_MODIFIERS = ("ABSTRACT", "FINAL", "PUBLIC", "PRIVATE", "PROTECTED", "INTERNAL", "OVERRIDE")
_OBJECTS = ("METHOD", "INTERFACE", "PROPERTY")
_HEADS = ("PROGRAM", "FUNCTION", "FUNCTION_BLOCK", *_OBJECTS)  # what a modifier may stand behind
_ACCESSOR_ENDS = (KIND["END_GET"], KIND["END_SET"])
_OUTER_ENDS = [KIND[f"END_{n}"] for n in ("METHOD", "PROPERTY", "INTERFACE", "FUNCTION_BLOCK", "PROGRAM")]
_BETWEEN = END_KINDS | {KIND["SEMI"], 0}  # a METHOD may begin behind these on the same line


def resolve(tokens: Tokens, reporter: Reporter) -> None:
    """Decide what the words are that are keywords only between certain neighbours; drop rule lines and placeholders."""
    kinds, texts = tokens.kinds, tokens.texts
    for i in [i for i, kind in enumerate(kinds) if kind in OBJECT_ENDS]:
        _misspelt(tokens, i, reporter)
    special = [i for i, kind in enumerate(kinds) if kind >= SOFT]
    for i in reversed(special):  # from the end, so that what is taken out moves nothing that is still to come
        kind = kinds[i]
        if kind == RULE or kind == DOTS:
            _drop_rule(tokens, i, reporter)
        elif kind == SOFT:
            word = texts[i].upper()
            if word in ("S", "R", "REF"):
                _set_operator(tokens, i)
            elif word in _MODIFIERS:
                before = texts[i - 1].upper() if i else ""
                kinds[i] = KIND["MODIFIER"] if _is_modifier(before, kinds[i + 1]) else NAME
            elif word in ("R_EDGE", "F_EDGE"):  # clk : BOOL R_EDGE;
                kinds[i] = KIND["EDGE"] if kinds[i - 1] in (NAME, SOFT) and kinds[i - 2] == KIND["COLON"] else NAME
            else:
                kinds[i] = KIND[word] if _is_keyword(tokens, i, word) else NAME
    for i in [i for i, kind in enumerate(kinds) if kind == KIND["PROPERTY"]]:
        _accessors(tokens, i)
    for i in [i for i, kind in enumerate(kinds) if kind in _ACCESSOR_ENDS]:
        _ended_accessor(tokens, i)
    for i in reversed([i for i, kind in enumerate(kinds) if TERMINALS[kind] in _HEADS]):
        _misspelt_modifier(tokens, i + 1, reporter)
        if kinds[i] == KIND["METHOD"]:
            _method_head(tokens, i, reporter)


def _misspelt(tokens: Tokens, end: int, reporter: Reporter) -> None:
    """The METHOD, PROPERTY, GET or SET of an end, if it is misspelt: no other word stands before a name."""
    kinds, texts = tokens.kinds, tokens.texts
    word = TERMINALS[kinds[end]][4:]
    stops = (*OBJECT_ENDS, *_OUTER_ENDS) if word in ("GET", "SET") else _OUTER_ENDS
    meant = -1
    for at in range(end - 1, -1, -1):
        if kinds[at] in stops or texts[at].upper() == word:
            break
        if kinds[at] == NAME and kinds[at + 1] in (NAME, SOFT) and tokens.starts_line(at):
            if distance(texts[at].upper(), word, 2) <= 2:
                meant = at
    if meant >= 0 and texts[at].upper() != word:
        reporter.add("E0115", tokens.source, tokens.starts[meant], tokens.ends[meant], found=texts[meant], keyword=word)
        kinds[meant], texts[meant] = SOFT, word


def _misspelt_modifier(tokens: Tokens, at: int, reporter: Reporter) -> None:
    """`FUNCTION_BLOCK ABSTARCT Shape`: of two names the first is one of these words."""
    kinds, texts = tokens.kinds, tokens.texts
    if kinds[at] != NAME or kinds[at + 1] != NAME or tokens.starts_line(at + 1):
        return
    for word in _MODIFIERS:
        if distance(texts[at].upper(), word, 2) <= 2:
            reporter.add("E0115", tokens.source, tokens.starts[at], tokens.ends[at], found=texts[at], keyword=word)
            kinds[at], texts[at] = KIND["MODIFIER"], word
            return


def _is_modifier(before: str, after: int) -> bool:
    return (before in _HEADS or before in _MODIFIERS) and after in (NAME, KIND["MODIFIER"])


def _method_head(tokens: Tokens, at: int, reporter: Reporter) -> None:
    """`METHOD Open BOOL`, `METHOD Open Open : BOOL`: statements may follow a head, the parser would not see it."""
    kinds, texts = tokens.kinds, tokens.texts
    while kinds[at] != NAME:
        at += 1
    second = at + 1
    if kinds[second] != NAME or tokens.starts_line(second):
        return
    place = tokens.source, tokens.starts[second], tokens.ends[second]
    if kinds[second + 1] == KIND["COLON"] and texts[second].upper() == texts[at].upper():
        reporter.add("E0116", *place, found=texts[second])
        tokens.delete(second, second + 1)
    elif kinds[second + 1] in (KIND["VAR"], KIND["END_METHOD"]) or tokens.starts_line(second + 1):
        reporter.add("E0102", tokens.source, tokens.ends[at], tokens.ends[at] + 1, what=":", where=f"after {texts[at]}")
        tokens.insert(second, KIND["COLON"], ":")


def _accessors(tokens: Tokens, at: int) -> None:
    """GET and SET of a property, where no accessor is open."""
    kinds, texts = tokens.kinds, tokens.texts
    inside = True  # of the name of the property
    while kinds[at] not in (KIND["END_PROPERTY"], KIND["END_FUNCTION_BLOCK"], KIND["END_PROGRAM"], 0):
        at += 1
        if kinds[at] in _ACCESSOR_ENDS or kinds[at] == KIND["COLON"] and inside:
            inside = False
        elif kinds[at - 1] != KIND["COLON"] and _begins_accessor(tokens, at) and (not inside or tokens.starts_line(at)):
            kinds[at], inside = KIND[texts[at].upper()], True


def _begins_accessor(tokens: Tokens, at: int) -> bool:
    """GET or SET that is no variable of that name."""
    word = tokens.kinds[at] == NAME and tokens.texts[at].upper() in ("GET", "SET")
    return word and tokens.kinds[at + 1] not in _PATH_GOES_ON


def _ended_accessor(tokens: Tokens, end: int) -> None:
    """The beginning of an accessor, from its end: the PROPERTY may be misspelt."""
    word = tokens.texts[end].upper()[4:]
    for at in range(end - 1, -1, -1):
        if tokens.kinds[at] in (*_OUTER_ENDS, *_ACCESSOR_ENDS, KIND[word]):
            return
        if tokens.texts[at].upper() == word and _begins_accessor(tokens, at):
            tokens.kinds[at] = KIND[word]
            return


def _is_keyword(tokens: Tokens, i: int, word: str) -> bool:
    """Whether the neighbours make a keyword of a word."""
    kinds, texts = tokens.kinds, tokens.texts
    before = kinds[i - 1] if i else 0
    after, then = kinds[i + 1], kinds[i + 2] if i + 2 < len(kinds) else 0
    named = after == NAME  # what follows was resolved already
    if word in _OBJECTS:  # behind the name of a block, too
        begins = before in _BETWEEN or before == NAME or before == SOFT or tokens.starts_line(i)
        return (named or after == KIND["MODIFIER"]) and begins
    if word in ("GET", "SET"):
        return False  # decided by _accessors
    if word == "AT":
        return after == KIND["ADDRESS"]
    if word == "REF_TO":
        return before in (KIND["COLON"], KIND["OF"], KIND["TO"]) and after != KIND["SEMI"]
    if word in ("EXTENDS", "IMPLEMENTS"):
        return named and before in (NAME, SOFT)
    if word == "ON":
        return named and before in (NAME, SOFT) and i >= 2 and texts[i - 2].upper() == "RESOURCE"
    if word == "WITH":
        return named and before in (NAME, SOFT) and kinds[i - 2] == KIND["PROGRAM"]
    if word == "TASK":
        return named and then == KIND["LPAR"]
    if word == "RESOURCE" and then == KIND["ON"]:
        return named
    return named and before not in _PATH_ENDS  # ACTION, CONFIGURATION, RESOURCE


def _set_operator(tokens: Tokens, i: int) -> None:
    """`a S= b`, `a R= b`, `a REF= b`: two names never stand side by side otherwise, so `s=1` keeps its meaning."""
    kinds, texts = tokens.kinds, tokens.texts
    if texts[i + 1] == "=" and tokens.starts[i + 1] == tokens.ends[i] and i and kinds[i - 1] in _PATH_ENDS:
        tokens.replace(i, i + 2, KIND["SETOP"], texts[i].upper() + "=")
    else:
        kinds[i] = NAME


def _drop_rule(tokens: Tokens, i: int, reporter: Reporter) -> None:
    """A line of dashes or underscores, a row of dots: what a printed listing has between or instead of code."""
    code = "W0105" if tokens.kinds[i] == RULE else "W0106"
    alone = tokens.starts_line(i) and (tokens.kinds[i + 1] == 0 or tokens.starts_line(i + 1))
    if code == "W0106" and not alone and _between_bounds(tokens, i):
        reporter.add("W0112", tokens.source, tokens.starts[i], tokens.ends[i], found=tokens.texts[i], plain="..")
        tokens.kinds[i], tokens.texts[i] = KIND["DOTDOT"], ".."
        return
    if code == "W0105" and not alone and tokens.texts[i][0] == "_":
        tokens.kinds[i] = NAME
        return
    reporter.add(code, tokens.source, tokens.starts[i], tokens.ends[i], text=tokens.texts[i])
    tokens.delete(i, i + 1)


def _between_bounds(tokens: Tokens, i: int) -> bool:
    """`[0…9]`, `1…3:`: the dots of a range."""
    bounds = (NUMBER, NAME)
    before, after = tokens.kinds[i - 1] if i else 0, tokens.kinds[i + 1]
    signed = after == KIND["SIGN"] and tokens.kinds[i + 2] in bounds
    near = not tokens.starts_line(i) and (tokens.kinds[i + 1] == 0 or not tokens.starts_line(i + 1))
    return near and before in bounds and (after in bounds or signed)

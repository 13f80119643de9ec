"""Rules of the grammar -> nodes of the syntax tree: files, declarations and types; the rest is in build_statements.py.

One function for each name behind `->` in grammar.lark. It gets the context (the tokens and the reporter), the start and
end of the rule in the text and the list of the values of its symbols: for a terminal the number of its token, for
anything else what its own function returned.
"""

from __future__ import annotations

import re

from stcore import syntax as s
from stcore.diagnostics import Reporter
from stcore.lexer import KIND, Tokens

_INTEGERS = frozenset("SINT INT DINT LINT USINT UINT UDINT ULINT BYTE WORD DWORD LWORD".split())


class Context:
    """What the functions need beside the values: texts and places of the tokens, and somewhere to complain."""

    __slots__ = ("texts", "starts", "ends", "kinds", "attributes", "tokens", "reporter", "_targets", "_told")

    def __init__(self, tokens: Tokens, reporter: Reporter) -> None:
        self.tokens = tokens
        self.texts, self.starts, self.ends, self.kinds = tokens.texts, tokens.starts, tokens.ends, tokens.kinds
        self.attributes = tokens.attributes
        self.reporter = reporter
        self._targets: set[str] | None = None
        self._told: set[tuple[str, int]] = set()

    def report(self, code: str, start: int, end: int, **fields) -> None:
        """Report once; a repair may read the same tokens again."""
        if (code, start) in self._told:
            return
        self._told.add((code, start))
        self.reporter.add(code, self.tokens.source, start, end, **fields)

    def jumped_to(self, label: str) -> bool:
        """Whether some JMP of the file names the label."""
        if self._targets is None:
            jump = KIND["JMP"]
            self._targets = {self.texts[i + 1].upper() for i, kind in enumerate(self.kinds) if kind == jump}
        return label.upper() in self._targets


# ------------------------------------------------------------------------------------------- lists and values


def new_list(t, a, b, v):
    return []


def one(t, a, b, v):
    return v


def append(t, a, b, v):
    v[0].append(v[1])
    return v[0]


def append3(t, a, b, v):
    v[0].append(v[2])
    return v[0]


def append_index(t, a, b, v):
    """The brackets of a name that only VAR_CONFIG may have."""
    v[0].append(v[3])
    return v[0]


def extend(t, a, b, v):
    v[0] += v[1]
    return v[0]


def keep(t, a, b, v):
    return v[0]


def second(t, a, b, v):
    return v[1]


def pair(t, a, b, v):
    return [v[0], v[2]]


def pass_on(t, a, b, v):
    return v[0]


def nothing(t, a, b, v):
    return None


def text(t, a, b, v):
    return t.texts[v[0]]


def dotted_text(t, a, b, v):
    return f"{v[0]}.{t.texts[v[2]]}"


# ------------------------------------------------------------------------------------------------------- files


def file(t, a, b, v):
    units: list[s.Node] = []
    for unit in v[0]:
        for part in unit if isinstance(unit, list) else [unit]:
            if not _is_member(part):
                units.append(part)
            elif units and isinstance(units[-1], s.Pou) and _may_have(units[-1].kind, part):
                units[-1].parts.append(part)
            else:
                _report_lost(t, part)
    return s.File(0, len(t.tokens.source.text), units, t.tokens.file_attributes)


def _report_lost(t, part: s.Node) -> None:
    """An action or method where there is nothing that it could belong to."""
    what = "ACTION" if isinstance(part, s.Action) else s.WRITTEN[part.kind]
    t.report("E0122", part.name_start, part.name_start + len(part.name), what=what, name=part.name)


def _may_have(kind: str, part: s.Node) -> bool:
    """Whether a POU of this kind can have an action, or a method."""
    return kind in ("PROGRAM", "FUNCTION_BLOCK") or kind == "FUNCTION" and isinstance(part, s.Action)


def _is_member(unit: s.Node) -> bool:
    return isinstance(unit, s.Action) or isinstance(unit, s.Pou) and unit.kind in s.WRITTEN


def _pou(
    t, a, b, kind, name, modifiers=(), result=None, generics=(), sections=(), body=(), parts=(), extends=None,
    implements=(),
):  # fmt: skip
    _check_names(t, sections)
    name_start, name = t.starts[name], t.texts[name]
    attributes = t.attributes.get(a) or {}
    return s.Pou(
        a, b, kind, name, name_start, result, list(generics), sections, body, list(parts), attributes, extends,
        list(implements), frozenset(t.texts[i].upper() for i in modifiers),
    )  # fmt: skip


def program(t, a, b, v):
    _, modifiers, name, sections, methods, body, actions, _ = v
    return _pou(t, a, b, "PROGRAM", name, modifiers, sections=sections, body=body, parts=methods + actions)


def function_block(t, a, b, v):
    _, modifiers, name, extends, implements, sections, methods, body, actions, _ = v
    return _pou(
        t, a, b, "FUNCTION_BLOCK", name, modifiers, sections=sections, body=body, parts=methods + actions,
        extends=extends, implements=implements,
    )  # fmt: skip


def function(t, a, b, v):
    _, modifiers, name, generics, result, sections, methods, body, _ = v
    for part in methods:
        _report_lost(t, part)
    return _pou(t, a, b, "FUNCTION", name, modifiers, result, generics, sections, body)


def interface(t, a, b, v):
    _, modifiers, name, bases, methods, _ = v
    for method in methods:
        if method.body:
            t.report("E0211", method.body[0].start, method.body[-1].end, name=t.texts[name])
    return _pou(t, a, b, "INTERFACE", name, modifiers, sections=[], body=[], parts=methods, implements=bases)


def method(t, a, b, v):
    _, modifiers, name, result, sections, body, *_ = v
    return _pou(t, a, b, "METHOD", name, modifiers, result, sections=sections, body=body)


def property_parts(t, a, b, v):
    """A method for GET, whose result is the property, and one for SET, whose input it is."""
    _, modifiers, name, _, kind, _, accessors, *_ = v
    made = []
    for word, start, end, sections, body in accessors:
        getter = t.texts[word].upper() == "GET"
        if not getter:
            value = s.VarDecl(t.starts[name], t.ends[name], t.texts[name], kind, None, None, {})
            sections = [s.VarSection(value.start, value.end, "VAR_INPUT", frozenset(), [value], None, {}), *sections]
        accessor = _pou(
            t, start, end, t.texts[word].upper(), name, modifiers, kind if getter else None, (), sections, body
        )
        accessor.attributes = t.attributes.get(a) or {}
        made.append(accessor)
    if not made:
        t.report("E0102", t.starts[name], t.ends[name], what="GET or SET", where=f"in the PROPERTY {t.texts[name]}")
    return made


def accessor(t, a, b, v):
    word, sections, body, *_ = v
    return word, a, b, sections, body


def generics(t, a, b, v):
    if t.texts[v[0]] != "<" or t.texts[v[2]] != ">":
        t.report("E0101", a, b, found=t.texts[v[0]], hint="the types of a generic function stand in < >")
    return v[1]


def generic(t, a, b, v):
    return t.texts[v[0]], t.texts[v[2]]


def action(t, a, b, v):
    return s.Action(a, b, t.texts[v[1]], t.starts[v[1]], v[3])


def configuration(t, a, b, v):
    items = _flat(v[2])
    resources = [item[0] for item in v[2] if isinstance(item, list)]
    sections = [i for i in items if isinstance(i, s.VarSection)]
    tasks = [i for i in items if isinstance(i, s.Task)]
    programs = [i for i in items if isinstance(i, s.ProgramInstance)]
    return s.Configuration(a, b, t.texts[v[1]], sections, tasks, programs, resources)


def resource(t, a, b, v):
    return [t.texts[v[1]], *v[4]]


def _flat(items: list) -> list:
    """The items of a configuration with those of its resources (after their names) in their place."""
    flat = []
    for item in items:
        flat += _flat(item[1:]) if isinstance(item, list) else [item]
    return flat


def task(t, a, b, v):
    properties = {arg.name.upper(): arg.value for arg in v[3] if arg.name}
    return s.Task(a, b, t.texts[v[1]], properties)


def instance(t, a, b, v):
    return s.ProgramInstance(a, b, t.texts[v[1]], None, v[3], v[5] if len(v) > 5 else [])


def instance_with(t, a, b, v):
    return s.ProgramInstance(a, b, t.texts[v[1]], t.texts[v[3]], v[5], v[7] if len(v) > 7 else [])


# ------------------------------------------------------------------------------------------------ declarations


def section(t, a, b, v):
    kind = t.texts[v[0]].upper()
    words = frozenset(t.texts[i].upper() for i in v[1])
    return s.VarSection(a, b, kind, words, v[2], None, t.attributes.get(a) or {})


def _check_names(t, sections) -> None:
    """Only VAR_CONFIG names its variables by their paths."""
    for part in sections:
        for decl in part.decls if part.kind != "VAR_CONFIG" else ():
            if "." in decl.name or "[" in decl.name:
                t.report("E0117", decl.start, decl.end, name=decl.name)


def declaration(t, a, b, v):
    type_, init = v[2], v[4] if len(v) > 4 else None
    attributes = t.attributes.get(a)
    if attributes is None:
        return [s.VarDecl(start, end, name, type_, init, address, {}) for start, end, name, address in v[0]]
    return [s.VarDecl(start, end, name, type_, init, address, attributes) for start, end, name, address in v[0]]


def edge_declaration(t, a, b, v):
    """An input that the block sees for one call, when it rises or falls (IEC 61131-3, table 40)."""
    made = declaration(t, a, b, v[:3])
    for decl in made:
        decl.attributes = {**decl.attributes, "edge": t.texts[v[3]].upper()}
    return made


def accesses(t, a, b, v):
    return s.VarSection(a, b, "VAR_ACCESS", frozenset(), v[1], None, {})


def access(t, a, b, v):
    """name : path : type READ_WRITE; the path is kept as the address of a declaration."""
    name, parts, rights = v[0], v[2], t.texts[v[5]].upper() if len(v) > 6 else "READ_ONLY"
    if rights not in ("READ_ONLY", "READ_WRITE"):
        t.report("E0101", t.starts[v[5]], t.ends[v[5]], found=t.texts[v[5]], hint="READ_ONLY or READ_WRITE stands here")
    path = "".join(t.tokens.source.text[t.starts[parts[0]] : t.ends[parts[-1]]].split())
    return s.VarDecl(t.starts[name], t.ends[name], t.texts[name], v[4], None, path, {"rights": rights})


def declared_name(t, a, b, v):
    parts = v[0]
    name = t.texts[parts[0]]
    if len(parts) > 1:
        name = "".join(t.tokens.source.text[a : t.ends[parts[-1]]].split())
    return a, t.ends[parts[-1]], name, t.texts[v[2]].upper() if len(v) > 2 else None


def types(t, a, b, v):
    if shared := t.attributes.get(a):
        for decl in v[1]:
            decl.attributes = {**shared, **decl.attributes}
    return v[1]


def type_declaration(t, a, b, v):
    name, extends, type_, init = t.texts[v[0]], v[1], v[3], v[5] if len(v) > 5 else None
    if isinstance(type_, s.NamedType) and type_.args and type_.name.upper() in _INTEGERS:
        type_ = _enum_with_base(t, type_)
    if isinstance(type_, (s.StructDef, s.UnionDef)):
        _check_names(t, [s.VarSection(a, b, "", frozenset(), type_.fields_, None, {})])
    if extends is not None:
        if isinstance(type_, s.StructDef):
            type_.extends = extends
        else:
            t.report("E0101", a, b, found="EXTENDS", hint="only a STRUCT or a FUNCTION_BLOCK extends another")
    return s.TypeDecl(a, b, name, a, type_, init, t.attributes.get(a) or {})


def _enum_with_base(t, type_: s.NamedType) -> s.Node:
    """`INT (red, green := 5)`: an enumeration with its base in front reads like a type with initial values."""
    items = []
    for arg in type_.args:
        if arg.name is not None and not arg.output:
            items.append((arg.name, arg.start, arg.value))
        elif isinstance(arg.value, s.Name):
            items.append((arg.value.name, arg.start, None))
        else:
            return type_
    return s.EnumDef(type_.start, type_.end, items, type_.name)


# ------------------------------------------------------------------------------------------------------- types


def named_type(t, a, b, v):
    return s.NamedType(a, b, v[0], v[2] if len(v) > 1 else None)


def subrange(t, a, b, v):
    return s.Subrange(a, b, v[0], v[2], v[4])


def string_type(t, a, b, v):
    return s.StringType(a, b, t.texts[v[0]].upper() == "WSTRING", v[2] if len(v) > 1 else None)


def array_type(t, a, b, v):
    return s.ArrayOf(a, b, v[2], v[5])


def pointer_type(t, a, b, v):
    return s.PointerTo(a, b, v[-1])


def reference_type(t, a, b, v):
    return s.ReferenceTo(a, b, v[2])


def enum_type(t, a, b, v):
    return s.EnumDef(a, b, v[1], t.texts[v[3]] if len(v) > 3 else None)


def struct_type(t, a, b, v):
    return s.StructDef(a, b, v[1], None)


def union_type(t, a, b, v):
    return s.UnionDef(a, b, v[1])


def dimension(t, a, b, v):
    return v[0], v[2]


def lone_dimension(t, a, b, v):
    """[07], as a scanned listing prints [0..7], is unmistakable; any other single bound is an error."""
    bound = v[0]
    if isinstance(bound, s.Literal) and re.fullmatch(r"0[1-9]", bound.text):
        t.report("W0113", a, b, text=bound.text, high=bound.text[1])
        return s.Literal(a, a + 1, 0, None, "0"), s.Literal(a + 1, b, int(bound.text), None, bound.text[1])
    t.report("E0119", a, b, text=t.tokens.source.text[a:b])
    return s.Literal(a, a, 0, None, "0"), bound


def open_dimension(t, a, b, v):
    if t.texts[v[0]] != "*":
        t.report("E0101", a, b, found=t.texts[v[0]], hint="an open bound is written [*]")
    return None


def enum_item(t, a, b, v):
    return t.texts[v[0]], a, v[2] if len(v) > 1 else None

"""Rules of the grammar -> nodes of the syntax tree: initial values, statements and expressions.

The functions are called as those of build.py, whose module text says how.
"""

from __future__ import annotations

import re

from stcore import depth, literals
from stcore import syntax as s

_LONG = 200  # characters; what is shorter can't have too many steps to matter

_PRECEDENCE = {
    "**": 8, "*": 7, "/": 7, "MOD": 7, "+": 6, "-": 6, "<": 5, ">": 5, "<=": 5, ">=": 5, "=": 4, "<>": 4,
    "AND": 3, "&": 3, "AND_THEN": 3, "XOR": 2, "OR": 1, "OR_ELSE": 1,
}  # fmt: skip


# ------------------------------------------------------------------------------------------------ initialisers


def _items(values: list) -> list:
    """Values and repetitions (lists of items) -> items of an ArrayInit."""
    items: list[tuple] = []
    for value in values:
        items += value if isinstance(value, list) else [(None, value)]
    return items


def bare_list(t, a, b, v):
    return s.ArrayInit(a, b, _items(v[0]))


def bare_repetition(t, a, b, v):
    """`4(7)` with nothing around it."""
    return s.ArrayInit(a, b, v[0])


def array_init(t, a, b, v):
    return s.ArrayInit(a, b, _items(v[1]) if len(v) > 2 else [])


def repeated(t, a, b, v):
    """3(0) is one item with a count; 2(1, 2) is written out."""
    count = number(t, t.starts[v[0]], t.ends[v[0]], v)
    if len(v) == 3:
        return [(count, None)]
    items = _items(v[2])
    if len(items) == 1 and items[0][0] is None:
        return [(count, items[0][1])]
    if not isinstance(count.value, int) or not 0 <= count.value * len(items) <= 65536:
        t.report("E0123", a, b, text=t.texts[v[0]])
        return items
    return items * count.value


def _value(value):
    """A repetition standing alone is an array of it."""
    if not isinstance(value, list):
        return value
    last = value[-1][1] or value[-1][0]
    return s.ArrayInit((value[0][0] or value[0][1]).start, last.end, value)


def field(t, a, b, v):
    return s.Arg(a, b, t.texts[v[0]], _value(v[2]), False, False)


def struct_init(t, a, b, v):
    """(a := 1, b := 2); also V2.3's (a := 1, 2, 3, b := 4), where a is an array."""
    fields: list[s.Arg] = []
    for part in v[1]:
        if isinstance(part, s.Arg):
            fields.append(part)
            continue
        last = fields[-1]
        if not isinstance(last.value, s.ArrayInit):
            last.value = s.ArrayInit(last.value.start, last.value.end, [(None, last.value)])
        last.value.items += _items([part])
        last.value.end = last.end = last.value.items[-1][1].end if last.value.items[-1][1] else last.end
    return s.StructInit(a, b, fields)


# -------------------------------------------------------------------------------------------------- statements


def add_statement(t, a, b, v):
    statements, statement = v
    if statements and type(statements[-1]) is s.Label and type(statement) is s.ExprStmt:
        statement = _printed_result(t, statements, statement)
    statements.append(statement)
    return statements


def _printed_result(t, statements: list, call: s.ExprStmt) -> s.Node:
    """`rtn:GT_Reset();` of a listing has lost the = of its :=, unless something jumps to that label."""
    label = statements[-1]
    line = t.tokens.source.position
    if not isinstance(call.expr, s.Call) or line(label.start)[0] != line(call.start)[0] or t.jumped_to(label.name):
        return call
    t.report("W0103", label.end - 1, label.end, name=label.name)
    statements.pop()
    target = s.Name(label.start, label.start + len(label.name), label.name)
    return s.Assign(label.start, call.end, target, ":=", call.expr)


def add_label(t, a, b, v):
    v[0].append(s.Label(t.starts[v[1]], t.ends[v[2]], t.texts[v[1]]))
    return v[0]


def assignment(t, a, b, v):
    return s.Assign(a, b, v[0], t.texts[v[1]], v[2])


def chained_assignment(t, a, b, v):
    return _level(t, s.Assign(a, b, v[0], ":=", v[2]))


def printed_assignment(t, a, b, v):
    """`pos = 0;` and `vel = velPre = 0;`: nothing but an assignment can stand here."""
    target, sign, value, _ = v
    t.report("W0102", t.starts[sign], t.ends[sign])
    if t.starts[sign + 1] == value.start:  # a bracket would start before it
        value = _chain_of_assignments(value)
    return s.Assign(a, b, target, ":=", value)


def _chain_of_assignments(value: s.Node) -> s.Node:
    targets = []
    while isinstance(value, s.Binary) and value.op == "=":
        targets.append(value.right)
        value = value.left
    targets.append(value)
    last, targets = targets[0], targets[:0:-1]
    if not all(isinstance(n, (s.Name, s.Member, s.Index, s.Deref, s.Address, s.Part)) for n in targets):
        return s.Binary(targets[0].start, last.end, "=", targets[0], last) if len(targets) == 1 else value
    for target in reversed(targets):
        last = s.Assign(target.start, last.end, target, ":=", last)
    return last


def bare_statement(t, a, b, v):
    return s.ExprStmt(a, b, v[0])


def if_statement(t, a, b, v):
    return s.If(a, b, [(v[1], v[3]), *v[4]], v[5])


def elsif(t, a, b, v):
    return v[1], v[3]


def case_statement(t, a, b, v):
    branches: list[tuple[list, list]] = []
    for item in v[3]:
        if type(item) is tuple:
            branches.append((item[0], []))
        elif branches:
            branches[-1][1].append(item)
        else:
            t.report("E0124", item.start, item.end)
            branches.append(([], [item]))
    return s.Case(a, b, v[1], [branch for branch in branches if branch[0]], v[4])


def add_labels(t, a, b, v):
    v[0].append((v[1],))
    return v[0]


def label_range(t, a, b, v):
    return s.Range(a, b, v[0], v[2])


def for_statement(t, a, b, v):
    return s.For(a, b, v[1], v[3], v[5], None, v[7])


def for_by_statement(t, a, b, v):
    return s.For(a, b, v[1], v[3], v[5], v[7], v[9])


def while_statement(t, a, b, v):
    return s.While(a, b, v[1], v[3])


def repeat_statement(t, a, b, v):
    return s.Repeat(a, b, v[1], v[3])


def exit_statement(t, a, b, v):
    return s.Exit(a, b)


def continue_statement(t, a, b, v):
    return s.Continue(a, b)


def return_statement(t, a, b, v):
    return s.Return(a, b)


def jump_statement(t, a, b, v):
    return s.Jump(a, b, t.texts[v[1]])


# ------------------------------------------------------------------------------------------------- expressions


def chain2(t, a, b, v):
    return v


def chain3(t, a, b, v):
    v[0] += v[1:]
    return v[0]


def _operator(word: str) -> str:
    return "AND" if word == "&" else word.upper()


def chain(t, a, b, v):
    """A flat list of operands and operators -> a tree by precedence; equals group from the left."""
    items, texts = v[0], t.texts
    if len(items) == 3:
        return s.Binary(a, b, _operator(texts[items[1]]), items[0], items[2])
    if len(items) > 2 * depth.OPERANDS:
        t.report("E0120", a, b, count=len(items) // 2 + 1, limit=depth.OPERANDS)
        return items[0]
    operands, operators = [items[0]], []
    at = 1
    while at < len(items):
        operator = _operator(texts[items[at]])
        level = _PRECEDENCE[operator]
        while operators and _PRECEDENCE[operators[-1]] >= level:
            _join(operands, operators.pop())
        operators.append(operator)
        operands.append(items[at + 1])
        at += 2
    while operators:
        _join(operands, operators.pop())
    whole = operands[0]
    whole.start, whole.end = a, b  # brackets at the ends belong to it
    return whole


def _join(operands: list, operator: str) -> None:
    right = operands.pop()
    left = operands[-1]
    operands[-1] = s.Binary(left.start, right.end, operator, left, right)


def unary(t, a, b, v):
    return _level(t, s.Unary(a, b, t.texts[v[0]].upper(), v[1]))


def bracketed(t, a, b, v):
    return v[1]


def name(t, a, b, v):
    return s.Name(a, b, t.texts[v[0]])


def address(t, a, b, v):
    return s.Address(a, b, t.texts[v[0]].upper())


def _inner(node):
    """The part of a node that lies one level deeper."""
    if isinstance(node, (s.Member, s.Part, s.Index, s.Deref)):
        return node.base
    if isinstance(node, s.Unary):
        return node.operand
    return node.callee if isinstance(node, s.Call) else node.value if isinstance(node, s.Assign) else None


def _level(t, node):
    """Refuse a node that only lies around another, around another, hundreds of times."""
    if node.end - node.start > _LONG:
        steps, inner = 0, node
        while steps <= depth.STEPS and (deeper := _inner(inner)) is not None:
            inner = deeper
            steps += 1
        if steps > depth.STEPS:
            t.report("E0113", inner.start, node.end)
            return inner
    return node


def member(t, a, b, v):
    return _level(t, s.Member(a, b, v[0], t.texts[v[2]], t.starts[v[2]]))


def bit(t, a, b, v):
    text = t.texts[v[2]]
    if not text.isdecimal() or int(text) > 63:
        t.report("E0109", t.starts[v[2]], t.ends[v[2]], text=text, why="a bit has a number from 0 to 63")
        return v[0]
    return s.Part(a, b, v[0], "X", int(text))


def part(t, a, b, v):
    text = t.texts[v[2]].upper()
    if not re.fullmatch(r"%[XBWDL]\d{1,2}", text):
        t.report("E0121", t.starts[v[2]], t.ends[v[2]], text=text)
        return v[0]
    return s.Part(a, b, v[0], text[1], int(text[2:]))


def index(t, a, b, v):
    return _level(t, s.Index(a, b, v[0], v[2]))


def deref(t, a, b, v):
    return _level(t, s.Deref(a, b, v[0]))


def call(t, a, b, v):
    arguments = v[2]
    for argument in arguments:
        if argument.value is None and not argument.output:
            t.report("W0110", argument.start, argument.end, name=argument.name)
            break
    return _level(t, s.Call(a, b, v[0], arguments))


def word_call(t, a, b, v):
    word = v[0]
    return s.Call(a, b, s.Name(a, t.ends[word], t.texts[word]), v[2])


def argument(t, a, b, v):
    return s.Arg(a, b, None, v[0], False, False)


def named_argument(t, a, b, v):
    return s.Arg(a, b, t.texts[v[0]], _value(v[2]), False, False)


def empty_argument(t, a, b, v):
    return s.Arg(a, b, t.texts[v[0]], None, False, False)


def output_argument(t, a, b, v):
    return s.Arg(a, b, t.texts[v[0]], v[-1] if len(v) > 2 else None, True, len(v) > 3)


# ---------------------------------------------------------------------------------------------------- literals


def number(t, a, b, v):
    text = t.texts[v[0]]
    if text.isdecimal() and len(text) < 19:
        return s.Literal(a, b, int(text), None, text)
    try:
        value = literals.number(text)
    except literals.BadLiteral as bad:
        t.report(bad.code, a, b, text=text, why=bad.why)
        value = 0
    return s.Literal(a, b, value, None, text)


def boolean(t, a, b, v):
    text = t.texts[v[0]]
    return s.Literal(a, b, text.upper() == "TRUE", "BOOL", text)


def string(t, a, b, v):
    text = t.texts[v[0]]
    try:
        value = literals.string(text)
    except literals.BadLiteral as bad:
        t.report(bad.code, a, b, text=bad.why)
        value = text[1:-1]
    return s.Literal(a, b, value, "WSTRING" if text[0] == '"' else "STRING", text)


def typed(t, a, b, v):
    text = t.texts[v[0]]
    try:
        value, type_name = literals.typed(text)
    except literals.BadLiteral as bad:
        t.report(bad.code, a, b, text=text, why=bad.why)
        value, type_name = 0, None
    return s.Literal(a, b, value, type_name, text)

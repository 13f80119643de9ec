"""Tokens -> syntax tree: a small LALR machine that runs the table of stcore/tables.py.

A token is shifted, or a rule is reduced by calling its function of stcore/build.py. Three stacks run in parallel:
states, values, and the number of the first token of each value, which gives every node its place. On a token that
cannot follow, stcore/repair.py finds the smallest change that lets the parser go on, and says it in the user's words.
"""

from __future__ import annotations

import functools
import gc
from collections.abc import Callable

from stcore import build, build_statements, depth, lexer, tables
from stcore import syntax as s
from stcore.diagnostics import Reporter
from stcore.lexer import Tokens
from stcore.source import Source


def parse(source: Source, reporter: Reporter | None = None, mend: bool = True) -> s.File:
    """The tree of a file. Never raises for what the text says: errors go to the reporter, and what could be understood
    is returned. mend: read printed listings as they are meant, with warnings; without, what they need is an error."""
    tree = _run(source, reporter or Reporter(), "file", mend)
    return tree if tree is not None else s.File(0, len(source.text), [], {})


def parse_expression(source: Source, reporter: Reporter) -> s.Node | None:
    """A single expression, as the prompt and ``--until`` take it; None when it is none."""
    return _run(source, reporter, "expression", True)


def parse_statements(source: Source, reporter: Reporter) -> list[s.Node]:
    """Statements as typed at the prompt. The last one needs no semicolon."""
    return _run(source, reporter, "statements", True) or []


def parse_initializer(source: Source, reporter: Reporter) -> s.Node | None:
    """A value as the command line takes it: 5, TRUE, 'text', T#5ms, [1, 2, 3], (acc := 0.25); None when it is none."""
    return _run(source, reporter, "initials", True)


def _run(source: Source, reporter: Reporter, start: str, mend: bool):
    collecting = gc.isenabled()
    strict = reporter.strict
    if not mend:
        reporter.strict = True
    gc.disable()  # a tree has no cycles; looking for some while it grows takes a third of the time
    try:
        tokens = lexer.tokenize(source, reporter)
        return Machine(tokens, reporter, mend, start == "statements").run(start)
    finally:
        reporter.strict = strict
        if collecting:
            gc.enable()


@functools.cache
def _table() -> tables.Table:
    return tables.load()


@functools.cache
def _functions() -> list[Callable]:
    return [getattr(build, name, None) or getattr(build_statements, name) for name in _table().names]


@functools.cache
def _anchors():
    from stcore.repair import Anchors

    return Anchors.of(_table())


class Machine:
    """One parse. The repair reads and changes its stacks and its tokens."""

    def __init__(self, tokens: Tokens, reporter: Reporter, mend: bool, prompt: bool) -> None:
        self.tokens = tokens
        self.reporter = reporter
        self.mend = mend
        self.prompt = prompt
        self.whole = True  # a file; not what was typed, which has no end of a file
        self.context = build.Context(tokens, reporter)
        self.table = _table()
        self.states: list[int] = []
        self.values: list = []
        self.firsts: list[int] = []

    @functools.cached_property
    def repairs(self):
        """What knows how to go on; made at the first token that cannot follow."""
        from stcore.repair import Repairs

        return Repairs(self, _anchors())

    def run(self, start: str):
        """The value of the start symbol, or None when no repair leads to one."""
        tokens = self.tokens
        self.whole = start == "file"
        self.states.append(self.table.starts[start])
        at = 0
        while True:
            at = self._advance(at)
            if at > len(tokens.kinds) - 1:
                return self.values[0]
            if len(self.states) > depth.STACK:
                at = self.repairs.too_deep(at)
            else:
                at = self.repairs.repair(at)
            if at < 0:
                return None

    def _advance(self, at: int) -> int:
        """Run from token `at` until the end (a number past the last token) or an error (the token it is at)."""
        rows, gotos, lengths, origins = self.table.rows, self.table.gotos, self.table.lengths, self.table.origins
        functions, context = _functions(), self.context
        shift_reduce = tables.SHIFT_REDUCE
        kinds, starts, ends = self.tokens.kinds, self.tokens.starts, self.tokens.ends
        states, values, firsts = self.states, self.values, self.firsts
        state = states[-1]
        last = len(kinds)
        while at < last:
            action = rows[state].get(kinds[at])
            if action is None:
                return at
            if action >= 0:
                states.append(action)
                values.append(at)
                firsts.append(at)
                state = action
                at += 1
                if len(states) > depth.STACK:
                    return at
                continue
            if action <= -shift_reduce:
                states.append(-1)
                values.append(at)
                firsts.append(at)
                at += 1
                rule = -action - shift_reduce
            else:
                rule = ~action
            while True:
                length = lengths[rule]
                if length:
                    first = firsts[-length]
                    value = functions[rule](context, starts[first], ends[at - 1], values[-length:])
                    del states[-length:], values[-length:], firsts[-length:]
                else:
                    first = at
                    value = functions[rule](context, starts[at], ends[at - 1], ())
                values.append(value)
                firsts.append(first)
                state = gotos[states[-1]][origins[rule]]
                states.append(state)
                if state >= 0:
                    break
                rule = ~state
        return at

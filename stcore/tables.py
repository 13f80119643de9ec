"""grammar.lark -> parse table: Lark builds the LALR table once; here it becomes small, fast and plain data.

Two steps make the parser quick. A production of one symbol that only passes its value on (operand -> path) is worked
into the states, so that it costs nothing at run time. A state in which nothing but one reduction is possible is never
entered: the action that leads to it names the rule.

A `Table` is what parser.py runs. It is kept in the cache, so that a normal start does not import Lark.
"""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import NamedTuple

from stcore import cache
from stcore.lexer import KIND

GRAMMAR = Path(__file__).with_name("grammar.lark")
STARTS = ("file", "expression", "statements", "initials")
SHIFT_REDUCE = 1 << 20  # below -SHIFT_REDUCE: shift the token, then reduce


class Table(NamedTuple):
    """rows[state][terminal]: >= 0 shift and go to that state; < 0 reduce by rule ~action; <= -SHIFT_REDUCE shift, then
    reduce by rule -action - SHIFT_REDUCE. gotos[state][nonterminal]: the state, or ~rule when only that rule can
    follow. Rules: lengths, the nonterminal they make, the name of their function in build.py."""

    rows: list[dict[int, int]]
    gotos: list[dict[int, int]]
    lengths: list[int]
    origins: list[int]
    names: list[str]
    starts: dict[str, int]
    nonterminals: list[str]


def load() -> Table:
    """The table, from the cache or newly built."""
    key = cache.digest(cache.fingerprint([GRAMMAR, Path(__file__), Path(__file__).with_name("lexer.py")]))
    stored = cache.load("table", key)
    if stored is not None:
        try:
            return Table(*pickle.loads(stored))
        except Exception:  # a broken cache file may raise anything; it is built anew
            pass
    table = build()
    cache.store("table", key, pickle.dumps(tuple(table), 5))
    return table


def build() -> Table:
    """Run Lark over the grammar. Raises lark's GrammarError for a grammar that is not LALR(1)."""
    from lark import Lark
    from lark.lexer import Lexer

    class Unused(Lexer):
        """Our own lexer makes the tokens; Lark is asked for its table only."""

        __future_interface__ = True

        def __init__(self, conf) -> None:
            pass

        def lex(self, lexer_state, parser_state):
            return iter(())

    lark = Lark(GRAMMAR.read_text(encoding="utf-8"), parser="lalr", lexer=Unused, start=list(STARTS))
    return _compact(lark.parser.parser._parse_table)


def _compact(lark_table) -> Table:
    """Lark's table in our own numbers: shift s -> s, reduce r -> ~r."""
    from lark.parsers.lalr_analysis import Shift

    rules: dict[object, int] = {}
    lengths, origins, names = [], [], []
    nonterminals: dict[str, int] = {}
    terminals: list[dict[int, int]] = [{} for _ in lark_table.states]
    gotos: list[dict[int, int]] = [{} for _ in lark_table.states]
    for state, actions in lark_table.states.items():
        for symbol, (action, argument) in actions.items():
            if action is not Shift:
                if argument not in rules:
                    rules[argument] = len(rules)
                    lengths.append(len(argument.expansion))
                    origins.append(nonterminals.setdefault(str(argument.origin.name), len(nonterminals)))
                    names.append(argument.alias or "pass_on")
                terminals[state][KIND[symbol]] = ~rules[argument]
            elif symbol in KIND:
                terminals[state][KIND[symbol]] = argument
            else:
                gotos[state][nonterminals.setdefault(str(symbol), len(nonterminals))] = argument
    units = {i for i, (n, name) in enumerate(zip(lengths, names, strict=True)) if name == "pass_on" and n == 1}
    names = ["nothing" if n == "pass_on" and i not in units else n for i, n in enumerate(names)]
    starts = {name: lark_table.start_states[name] for name in STARTS}
    for end in lark_table.end_states.values():
        terminals[end][KIND["$END"]] = end  # the parser is done there
    _skip_units(terminals, gotos, units, origins)
    _skip_states(terminals, gotos)
    return _reachable(Table(terminals, gotos, lengths, origins, names, starts, list(nonterminals)))


def _skip_units(terminals: list[dict], gotos: list[dict], units: set[int], origins: list[int]) -> None:
    """Merge the state after X with the state after A where X alone is an A, so that A -> X needs no step.

    After p X, on the terminals that say "reduce A -> X", the parser would go on as after p A; the merged state does so
    at once. It is made for each pair of states, unless their own gotos clash.
    """
    merged: dict[tuple[int, int, int], int] = {}
    at = 0
    while at < len(gotos):
        changed = True
        while changed:
            changed = False
            for symbol, state in list(gotos[at].items()):
                for rule in {~a for a in terminals[state].values() if a < 0 and ~a in units}:
                    after = gotos[at].get(origins[rule])
                    if after is None or origins[rule] == symbol:
                        continue
                    key = (state, after, rule)
                    if key not in merged:
                        new = _merge(terminals, gotos, state, after, rule)
                        if new is None:
                            continue
                        merged[key] = new
                    gotos[at][symbol] = merged[key]
                    changed = True
                    break
        at += 1


def _merge(terminals: list[dict], gotos: list[dict], state: int, after: int, rule: int) -> int | None:
    """A new state: `state`, but where it reduces by the unit rule, as `after`. None where that can't be told apart."""
    if any(gotos[after].get(s, target) != target for s, target in gotos[state].items()):
        return None
    row = {}
    for terminal, action in terminals[state].items():
        if action != ~rule:
            row[terminal] = action
        elif terminal in terminals[after]:
            row[terminal] = terminals[after][terminal]
    terminals.append(row)
    gotos.append(gotos[after] | gotos[state])
    return len(gotos) - 1


def _skip_states(terminals: list[dict], gotos: list[dict]) -> None:
    """Where a state can only reduce by one rule, whatever follows, let the way into it name the rule."""
    only: dict[int, int] = {}
    for state, row in enumerate(terminals):
        if row and not gotos[state] and len(set(row.values())) == 1 and next(iter(row.values())) < 0:
            only[state] = ~next(iter(row.values()))
    for row in terminals:
        for terminal, action in row.items():
            if action in only:
                row[terminal] = -SHIFT_REDUCE - only[action]
    for row in gotos:
        for symbol, state in row.items():
            if state in only:
                row[symbol] = ~only[state]


def _reachable(table: Table) -> Table:
    """Drop the states that nothing leads to any more and number the rest anew."""
    number: dict[int, int] = {}
    todo = list(table.starts.values())
    while todo:
        state = todo.pop()
        if state in number:
            continue
        number[state] = len(number)
        todo += [a for a in (*table.rows[state].values(), *table.gotos[state].values()) if a >= 0]
    order = list(number)
    rows = [{t: number[a] if a >= 0 else a for t, a in table.rows[s].items()} for s in order]
    gotos = [{n: number[a] if a >= 0 else a for n, a in table.gotos[s].items()} for s in order]
    return table._replace(rows=rows, gotos=gotos, starts={n: number[s] for n, s in table.starts.items()})

"""Random expressions, with typed literals (folded by the compiler), with variables in memory, with locals."""

import math
from random import Random

import pytest
from model import Maker, convert, written
from running import Run

EACH = 40  # expressions of a program


def cases(seed: int):
    """A Maker and the expressions that it made."""
    maker = Maker(Random(seed))
    return maker, [maker.any(maker.random.choice([1, 2, 2, 3])) for _ in range(EACH)]


def source(maker: Maker, made: list) -> str:
    variables = [f"  {n} : {k.name} := {written(v, k)};" for n, (k, v) in maker.variables.items()]
    results = [f"  {p}{i} : {e.kind.name};" for i, e in enumerate(made) for p in "cml"]
    copies = [f"  {n} := PLC_PRG.{n};" for n in maker.variables]
    declared = [f"  {n} : {k.name};" for n, (k, _) in maker.variables.items()]
    own = [f"  l{i} : {e.kind.name};" for i, e in enumerate(made)]
    return "\n".join([
        "FUNCTION F : INT", "VAR", *declared, *own, "END_VAR", *copies,
        *(f"  l{i} := {e.variable};\n  PLC_PRG.l{i} := l{i};" for i, e in enumerate(made)), "END_FUNCTION",
        "PROGRAM PLC_PRG", "VAR", *variables, *results, "END_VAR",
        *(f"  c{i} := {e.constant};\n  m{i} := {e.variable};" for i, e in enumerate(made)), "F();", "END_PROGRAM",
    ])  # fmt: skip


def same(a, b) -> bool:
    if isinstance(a, float):
        return a == b or math.isnan(a) and math.isnan(b)
    return a == b and type(a) is type(b)


def mismatches(seed: int) -> list[str]:
    maker, made = cases(seed)
    text = source(maker, made)
    run = Run(text).scan()
    env = {n: v for n, (_, v) in maker.variables.items()}
    wrong = []
    for i, e in enumerate(made):
        wanted = convert(e.value(env), e.kind, e.kind)
        for way, written_ in (("c", e.constant), ("m", e.variable), ("l", e.variable)):
            got = run[f"PLC_PRG.{way}{i}"]
            if not same(got, wanted):
                leaves = {n: v for n, v in env.items() if n in e.variable}
                wrong.append(f"{way}: {e.kind.name} {written_} = {got}, not {wanted} {leaves if way != 'c' else ''}")
    return wrong


@pytest.mark.parametrize("seed", range(16))
def test_random_expressions(seed):
    wrong = mismatches(seed)
    assert not wrong, "\n".join(wrong)

"""Random programs give in memory, in locals and in an instance what Python says that they do."""

import math

import pytest
from running import Run
from statements import random_program


def differences(seed: int) -> list[str]:
    text, env = random_program(seed)
    run = Run(text).scan()
    wrong = []
    for where in ("Body", "PLC_PRG.b", "fromFunction"):
        for name, wanted in env.items():
            got = run[f"{where}.{name}"]
            if isinstance(wanted, dict):
                got, wanted = flat(got), list(wanted.values())
            else:
                got, wanted = [got], [wanted]
            if not all(g == w or g != g and math.isnan(w) for g, w in zip(got, wanted, strict=True)):
                wrong.append(f"{where}.{name} = {got}, not {wanted}")
    return wrong


def flat(values: list) -> list:
    return [x for v in values for x in (flat(v) if isinstance(v, list) else [v])]


@pytest.mark.parametrize("seed", range(30))
def test_random_programs(seed):
    assert differences(seed) == []

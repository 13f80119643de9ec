"""Counters, edges, bistable blocks, semaphore: scan by scan."""

import pytest
from harness import trace

LIMITS = {
    "": ("WORD", 0, 65535), "_INT": ("INT", -32768, 32767), "_DINT": ("DINT", -(2**31), 2**31 - 1),
    "_LINT": ("LINT", -(2**63), 2**63 - 1), "_UINT": ("UINT", 0, 65535), "_UDINT": ("UDINT", 0, 2**32 - 1),
    "_ULINT": ("ULINT", 0, 2**64 - 1),
}  # fmt: skip
VARIANTS = list(LIMITS)


def names(variant):
    return ("RESET", "LOAD") if variant == "" else ("R", "LD")


@pytest.mark.parametrize("variant", VARIANTS)
def test_up(variant):
    kind, _, high = LIMITS[variant]
    inputs = {"CU": "BOOL", names(variant)[0]: "BOOL", "PV": kind}
    rows = [(1, 0, 2), (1, 0, 2), (0, 0, 2), (1, 0, 2), (0, 0, 2), (1, 0, 2), (1, 1, 2), (1, 0, 2), (0, 0, 0)]
    got = trace(f"CTU{variant}", inputs, rows, ["Q", "CV"])
    assert got == [
        (False, 1), (False, 1), (False, 1), (True, 2), (True, 2), (True, 3), (False, 0), (False, 0), (True, 0)
    ]  # fmt: skip
    # at the end of the type
    block = f"CTU{variant} := (CV := {high - 1})"
    assert trace(block, inputs, [(1, 0, 5), (0, 0, 5), (1, 0, 5)], ["CV"]) == [(high,)] * 3


@pytest.mark.parametrize("variant", VARIANTS)
def test_down(variant):
    kind, low, _ = LIMITS[variant]
    inputs = {"CD": "BOOL", names(variant)[1]: "BOOL", "PV": kind}
    rows = [(0, 0, 2), (0, 1, 2), (1, 1, 2), (1, 0, 2), (0, 0, 2), (1, 0, 2), (0, 0, 2), (1, 0, 2)]
    got = trace(f"CTD{variant}", inputs, rows, ["Q", "CV"])
    last = (True, -1) if low < 0 else (True, 0)
    assert got == [(True, 0), (False, 2), (False, 2), (False, 2), (False, 2), (False, 1), (False, 1), (True, 0)]
    rows = [(1, 0, 2)]
    assert trace(f"CTD{variant}", inputs, rows, ["Q", "CV"]) == [last]


@pytest.mark.parametrize("variant", VARIANTS)
def test_up_and_down(variant):
    kind = LIMITS[variant][0]
    reset, load = names(variant)
    inputs = {"CU": "BOOL", "CD": "BOOL", reset: "BOOL", load: "BOOL", "PV": kind}
    rows = [
        (0, 0, 0, 0, 2), (1, 0, 0, 0, 2), (1, 1, 0, 0, 2), (0, 0, 0, 0, 2), (1, 1, 0, 0, 2), (0, 0, 0, 1, 2),
        (1, 0, 0, 0, 2), (0, 0, 1, 1, 2),
    ]  # fmt: skip
    got = trace(f"CTUD{variant}", inputs, rows, ["QU", "QD", "CV"])
    assert got == [
        (False, True, 0), (False, False, 1), (False, True, 0), (False, True, 0), (False, True, 0), (True, False, 2),
        (True, False, 3), (False, True, 0),
    ]  # fmt: skip


def test_edges():
    rows = [(x,) for x in (0, 1, 1, 0, 0, 1, 0)]
    assert [q for (q,) in trace("R_TRIG", {"CLK": "BOOL"}, rows, ["Q"])] == [0, 1, 0, 0, 0, 1, 0]
    assert [q for (q,) in trace("F_TRIG", {"CLK": "BOOL"}, rows, ["Q"])] == [0, 0, 0, 1, 0, 0, 1]


def test_edges_on_the_first_scan():
    """R_TRIG sees a CLK that is TRUE from the start; F_TRIG does not take a CLK that was never TRUE for an edge."""
    assert trace("R_TRIG", {"CLK": "BOOL"}, [(1,), (1,)], ["Q"]) == [(True,), (False,)]
    assert trace("F_TRIG", {"CLK": "BOOL"}, [(0,), (0,)], ["Q"]) == [(False,), (False,)]


def test_bistable():
    rows = [(0, 0), (1, 0), (0, 0), (0, 1), (0, 0), (1, 1), (0, 1)]
    assert [q for (q,) in trace("SR", {"SET1": "BOOL", "RESET": "BOOL"}, rows, ["Q1"])] == [0, 1, 1, 0, 0, 1, 0]
    assert [q for (q,) in trace("RS", {"SET": "BOOL", "RESET1": "BOOL"}, rows, ["Q1"])] == [0, 1, 1, 0, 0, 0, 0]


def test_semaphore():
    rows = [(0, 0), (1, 0), (1, 0), (0, 0), (1, 1), (0, 1), (1, 0)]
    got = trace("SEMA", {"CLAIM": "BOOL", "RELEASE": "BOOL"}, rows, ["BUSY"])
    assert [b for (b,) in got] == [0, 0, 1, 1, 1, 0, 0]

"""Timers against the timing diagrams of IEC 61131-3, scan by scan (10 ms each)."""

import struct

import pytest
from harness import Plc, trace

from stcore.program import NOW


def run(block, steps, wide=False, pt=0.03):
    """steps: (IN,) or (IN, PT) per scan; Q and ET in ms after each."""
    rows = [s if len(s) == 2 else (*s, pt) for s in steps]
    kind = "LTIME" if wide else "TIME"
    got = trace(block, {"IN": "BOOL", "PT": kind}, rows, ["Q", "ET"], interval=10)
    return [(q, round(et * 1000)) for q, et in got]


ON, OFF = (True,), (False,)
CASES = {
    "delay": ("TON", [OFF, ON, ON, ON, ON, ON, OFF, OFF],
              [(0, 0), (0, 0), (0, 10), (0, 20), (1, 30), (1, 30), (0, 0), (0, 0)]),
    "first scan": ("TON", [ON, ON], [(0, 0), (0, 10)]),
    "too short": ("TON", [ON, ON, OFF, ON, ON], [(0, 0), (0, 10), (0, 0), (0, 0), (0, 10)]),
    "at once": ("TON", [(True, 0), (True, 0), (False, 0)], [(1, 0), (1, 0), (0, 0)]),
    "PT grows": ("TON", [ON, ON, (True, 0.05), (True, 0.05), (True, 0.05), (True, 0.05)],
                 [(0, 0), (0, 10), (0, 20), (0, 30), (0, 40), (1, 50)]),
    "PT shrinks": ("TON", [(True, 0.1), (True, 0.1), (True, 0.1), (True, 0.02), (True, 0.02)],
                   [(0, 0), (0, 10), (0, 20), (1, 20), (1, 20)]),
    "PT grows after the end": ("TON", [(True, 0.01), (True, 0.01), (True, 1), (False, 1)],
                               [(0, 0), (1, 10), (1, 10), (0, 0)]),
    "off delay": ("TOF", [OFF, ON, ON, OFF, OFF, OFF, OFF, OFF, ON],
                  [(0, 0), (1, 0), (1, 0), (1, 0), (1, 10), (1, 20), (0, 30), (0, 30), (1, 0)]),
    "off at once": ("TOF", [(True, 0), (False, 0)], [(1, 0), (0, 0)]),
    "on again": ("TOF", [ON, OFF, OFF, ON, OFF, OFF], [(1, 0), (1, 0), (1, 10), (1, 0), (1, 0), (1, 10)]),
    "pulse, IN longer": ("TP", [OFF, ON, ON, ON, ON, ON, OFF, ON],
                         [(0, 0), (1, 0), (1, 10), (1, 20), (0, 30), (0, 30), (0, 0), (1, 0)]),
    "pulse, IN shorter": ("TP", [ON, OFF, OFF, OFF, OFF], [(1, 0), (1, 10), (1, 20), (0, 0), (0, 0)]),
    "pulse is not retriggered": ("TP", [ON, OFF, ON, ON, ON, OFF, ON],
                                 [(1, 0), (1, 10), (1, 20), (0, 30), (0, 30), (0, 0), (1, 0)]),
    "edge in the last scan of a pulse": ("TP", [ON, OFF, OFF, ON, ON, OFF, ON],
                                         [(1, 0), (1, 10), (1, 20), (0, 30), (0, 30), (0, 0), (1, 0)]),
    "no pulse": ("TP", [(True, 0), (True, 0), (False, 0)], [(0, 0), (0, 0), (0, 0)]),
}  # fmt: skip


@pytest.mark.parametrize("wide", [False, True])
@pytest.mark.parametrize("name", CASES)
def test_diagram(name, wide):
    block, steps, expected = CASES[name]
    got = run("L" + block if wide else block, steps, wide)
    assert got == [(bool(q), et) for q, et in expected]


def test_off_delay_that_never_was_on():
    assert run("TOF", [OFF] * 6) == [(False, 0)] * 6


def test_nanoseconds():
    """LTON counts in ns where the scan is shorter than a millisecond."""
    rows = [(True, 250e-6)] * 4
    got = trace("LTON", {"IN": "BOOL", "PT": "LTIME"}, rows, ["Q", "ET"], interval=0.1)
    assert [(q, round(et * 1e6)) for q, et in got] == [(False, 0), (False, 100), (False, 200), (True, 250)]


def test_long_times():
    """The longest TIME, 49.7 days: ET neither wraps nor ends early; TIME() begins anew."""
    plc = Plc(
        "PROGRAM PLC_PRG\nVAR\n  t : TON; go : BOOL; now, cur : TIME; long : LTIME;\nEND_VAR\n"
        "t(IN := go, PT := T#49d17h2m47s295ms); now := TIME(); cur := CURTIME(); long := LTIME();\nEND_PROGRAM\n",
        interval=1000,
    )
    plc["PLC_PRG.go"] = True
    plc.scan(1)
    assert (plc["PLC_PRG.now"], plc["PLC_PRG.t.ET"]) == (0.0, 0.0)
    struct.pack_into("<qq", plc.machine.memory, NOW, 4294967 * 10**9, 4294967)  # and the number of scans
    plc.scan()
    assert plc["PLC_PRG.t.Q"] is False and plc["PLC_PRG.t.ET"] == plc["PLC_PRG.now"] == 4294967.0
    plc.scan()
    assert plc["PLC_PRG.t.Q"] is True and plc["PLC_PRG.t.ET"] == 4294967.295
    assert plc["PLC_PRG.now"] == plc["PLC_PRG.cur"] == pytest.approx(0.704)
    assert plc["PLC_PRG.long"] == 4294968.0


def test_clock():
    """RTC: runs from PDT while EN is TRUE, by virtual time."""
    rows = [(False, 0.0), (True, 86400.0), (True, 0.0), (True, 0.0), (False, 0.0), (True, 5.0), (True, 5.0)]
    got = trace("RTC", {"EN": "BOOL", "PDT": "DT"}, rows, ["Q", "CDT"], interval=500)
    assert got == [
        (False, 0.0), (True, 86400.0), (True, 86400.0), (True, 86401.0), (False, 0.0), (True, 5.0), (True, 5.0)
    ]  # fmt: skip


def test_virtual_time_is_at_its_address():
    plc = Plc("PROGRAM PLC_PRG\nVAR\n  t : TIME;\nEND_VAR\nt := TIME();\nEND_PROGRAM\n", interval=10)
    plc.scan(5)
    assert plc["PLC_PRG.t"] == pytest.approx(0.04)
    assert struct.unpack_from("<q", plc.machine.memory, NOW)[0] >= 40_000_000

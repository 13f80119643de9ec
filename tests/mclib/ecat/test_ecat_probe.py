"""Touch probes (iDEABOX 3, 5.2.2.3, 13 commands 73, 123, 124): single and continuous, both edges, both probes.

An input that changes before a scan captures where the motor is at that moment: the end of the scan before.
"""

import pytest

STATUS = "GT_GetTouchProbeStatus(1, ADR(u), ADR(d[0]), ADR(d[1]), ADR(d[2]), ADR(d[3]))"


@pytest.fixture
def probe(bus):
    bus.power()
    bus.jog(3)
    bus.scan(20)
    return Probe(bus)


class Probe:
    def __init__(self, bus):
        self.bus = bus

    def input(self, n, value):
        """Set an input and give the position that it captures."""
        at = round(self.bus.axis.position)
        self.bus.plc[f"SIM.Axis[1].switches.probe{n}"] = value
        self.bus.scan(3)
        return at

    def pulse(self, n):
        """Positions of a rising and a falling edge."""
        return self.input(n, True), self.input(n, False)

    @property
    def status(self):
        assert self.bus.plc.evaluate(STATUS) == 0
        return self.bus["u"]

    @property
    def values(self):
        assert self.bus.plc.evaluate(STATUS) == 0
        return self.bus["d"]


def test_off_captures_nothing(probe):
    probe.pulse(1)
    assert probe.status == 0 and probe.values == [0, 0, 0, 0]


def test_single_rising(probe):
    assert probe.bus("GT_SetTouchProbeFunction(1, 16#0011)") == 0
    assert probe.status == 0x0001
    at, _ = probe.pulse(1)
    assert probe.status == 0x0043 and probe.values == [at, 0, 0, 0]
    probe.pulse(1)
    assert probe.status == 0x0043 and probe.values[0] == at  # the first one only
    assert probe.bus("GT_SetTouchProbeFunction(1, 0)") == 0
    assert probe.status == 0 and probe.values[0] == at  # the value stays
    assert probe.bus("GT_SetTouchProbeFunction(1, 16#0011)") == 0
    assert probe.status & 7 == 1
    at, _ = probe.pulse(1)
    assert probe.status & 7 == 3 and probe.values[0] == at


def test_continuous_rising_turns_bit_6_over(probe):
    assert probe.bus("GT_SetTouchProbeFunction(1, 16#0013)") == 0
    for turn in (0x43, 0x03, 0x43):
        at, _ = probe.pulse(1)
        assert probe.status == turn and probe.values == [at, 0, 0, 0]


def test_both_edges_of_both_probes(probe):
    call = (
        "GT_SetTouchProbeFunctionEx(1, 1, ECAT_PROBE_TRIGGER_TYPE_CONTINUES, ECAT_PROBE_TRIGGER_LEVEL_DUL, "
        "1, ECAT_PROBE_TRIGGER_TYPE_FIRST_EVENT, ECAT_PROBE_TRIGGER_LEVEL_NEG)"
    )
    assert probe.bus(call) == 0
    assert probe.bus.plc["ECAT.Drive[1].probe.control"] == 0x2133
    rise, fall = probe.pulse(1)
    _, fall2 = probe.pulse(2)
    assert probe.values == [rise, fall, 0, fall2]
    assert probe.status == 0x85C7
    rise, fall = probe.pulse(1)
    probe.pulse(2)
    assert probe.values == [rise, fall, 0, fall2] and probe.status == 0x8507


@pytest.mark.parametrize("arguments", ["2, 0, 1, 0, 0, 1", "1, 2, 1, 0, 0, 1", "1, 0, 2, 0, 0, 1", "0, 0, 1, -1, 0, 1",
                                       "0, 0, 1, 1, 0, -2"])  # fmt: skip
def test_wrong_arguments(bus, arguments):
    assert bus(f"GT_SetTouchProbeFunctionEx(1, {arguments})") == 7


def test_an_input_that_is_high_when_the_probe_is_switched_on_has_no_edge(probe):
    probe.input(1, True)
    assert probe.bus("GT_SetTouchProbeFunction(1, 16#0033)") == 0
    probe.bus.scan(3)
    assert probe.status == 1
    at = probe.input(1, False)
    assert probe.status == 0x85 and probe.values[1] == at


def test_the_index_pulse_as_input(probe):
    """Bit 2 of 60B8h; an index pulse comes every 100 pulses here."""
    probe.bus.axis.places.indexPeriod = 100.0
    probe.bus.axis.places.index = 50.0
    assert probe.bus("GT_SetTouchProbeFunction(1, 16#0015)") == 0
    before = probe.bus.axis.position
    probe.bus.scan(40)
    assert probe.status & 3 == 3
    value = probe.values[0]
    assert value % 100 == 50 and before - 3 <= value <= before + 103


def test_switched_off_by_reset(probe):
    assert probe.bus("GT_SetTouchProbeFunction(1, 16#0013)") == 0
    probe.pulse(1)
    assert probe.bus("GT_Reset()") == 0
    assert probe.status == 0

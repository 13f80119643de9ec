"""MC_PhasingAbsolute and MC_PhasingRelative with BufferMode (PLCopen Part 1, table 4: they may wait)."""

import pytest

SLOW = {"RatioNumerator": 1, "Acceleration": 1000.0, "Deceleration": 1000.0}


def test_a_buffered_phase_waits_for_the_gear(bench):
    bench.start("run", 100, Velocity=400.0)
    bench.start("gear", **SLOW)
    bench.start("phase", PhaseShift=20.0, BufferMode=1)
    assert bench["phase.Busy"] and not bench["phase.Active"] and bench["phase.AbsolutePhaseShift"] == 0.0
    assert bench.until("phase.Active") == pytest.approx(399, abs=2)  # 400 u/s with 1000 u/s2
    assert bench["gear.InGear"]
    bench.until("phase.Done")
    assert bench["phase.AbsolutePhaseShift"] == pytest.approx(20.0)


def test_a_buffered_phase_waits_for_the_one_before_it(bench):
    bench.start("gear", 3, **SLOW)
    bench.start("phase", 3, PhaseShift=20.0)
    bench.start("further2", 3, PhaseShift=5.0, BufferMode=1)
    assert bench["phase.Active"] and bench["further2.Busy"] and not bench["further2.Active"]
    bench.until("phase.Done")
    bench.until("further2.Done")
    assert bench["further2.AbsolutePhaseShift"] == pytest.approx(25.0)
    assert bench["further2.CoveredPhaseShift"] == pytest.approx(5.0)
    assert bench["ax.fSetPosition"] == pytest.approx(25.0)


def test_a_buffered_phase_waits_for_the_end_of_a_cam(bench):
    bench["table.nElements"] = 2
    bench["table.Element[2].dX"] = 100.0
    bench["select.Periodic"] = bench["select.Execute"] = True
    bench.scan(3)
    bench["cam.CamTableID"] = bench["select.CamTableID"]
    bench.start("cam", 3)
    bench.start("run", Velocity=100.0)
    bench.start("phase", PhaseShift=20.0, BufferMode=1)
    bench.until("phase.Active")
    assert bench["master.fSetPosition"] == pytest.approx(100.0, abs=0.3)


@pytest.mark.parametrize("end, result", [("halt", "CommandAborted"), ("alarm", "Error")])
def test_a_phase_that_waits_ends_with_its_gear(bench, end, result):
    bench.start("run", 100, Velocity=400.0)
    bench.start("gear", **SLOW)
    bench.start("phase", PhaseShift=20.0, BufferMode=1)
    bench["calm"] = False
    if end == "halt":
        bench.start("halt", 2)
    else:
        bench.plc.axes[1].drive.alarm = True
        bench.scan(2)
        assert bench["phase.ErrorID"] == 34
    assert bench.outputs("phase") == result


def test_a_buffered_phase_needs_a_gear(bench):
    bench.start("phase", PhaseShift=20.0, BufferMode=1)
    assert bench["phase.ErrorID"] == 34
    bench.start("first", Position=100.0)
    bench.start("phase", PhaseShift=20.0, BufferMode=1)
    assert bench["phase.ErrorID"] == 34
    bench.start("gear", BufferMode=1, **SLOW)
    bench.start("phase", PhaseShift=20.0, BufferMode=1)  # the gear waits for its turn
    assert bench["phase.Busy"] and not bench["phase.Active"]
    bench.until("phase.Done")
    assert bench["gear.InGear"] and bench["ax.fSetPosition"] == pytest.approx(120.0)

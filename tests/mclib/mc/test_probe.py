"""MC_TouchProbe and MC_AbortTrigger."""

import pytest
from one_axis import load

PROBE = "probe, probe2 : MC_TouchProbe; abort : MC_AbortTrigger; trigger : TRIGGER_REF; velocity : MC_MoveVelocity;"
PROBING = (
    "velocity(Axis := ax, Velocity := 100, Acceleration := 1000, Deceleration := 1000);"
    "probe(Axis := ax, TriggerInput := trigger); probe2(Axis := ax, TriggerInput := trigger);"
    "abort(Axis := ax, TriggerInput := trigger);"
)


@pytest.mark.parametrize("number", [0, 1, 2, 3, -1])
def test_probe_records_once(number):
    plc = load(PROBE, PROBING)
    plc["P.trigger.bFastLatching"] = number >= 0
    plc["P.trigger.iTriggerNumber"] = number

    def signal(on: bool) -> None:
        if number < 0:
            plc["P.trigger.bInput"] = on
        else:
            setattr(plc.axes[1].switches, "probe1" if number < 2 else "probe2", on != bool(number % 2))

    signal(False)
    plc["P.velocity.Execute"] = plc["P.probe.Execute"] = True
    plc.scan(200)
    assert plc["P.probe.Busy"] and plc["P.trigger.bActive"]
    plc["P.probe2.Execute"] = True
    plc.scan()
    assert plc["P.probe2.ErrorID"] == 400
    at = plc["P.ax.fActPosition"]
    signal(True)
    plc.scan()
    assert plc["P.probe.Done"] and plc["P.probe.RecordedPosition"] == at and not plc["P.trigger.bActive"]
    signal(False)
    plc.scan()
    signal(True)
    plc.scan()
    assert plc["P.probe.RecordedPosition"] == at


@pytest.mark.parametrize(
    ("modulo", "first", "last", "hits"),
    [(False, 10, 20, (10, 20)), (True, 350, 10, (350, 370)), (True, 350, 370, (350, 370)), (True, -10, 5, (350, 365)),
     (False, 20, 10, None), (False, float("nan"), 10, None)],
)  # fmt: skip
def test_probe_window(modulo, first, last, hits):
    plc = load(PROBE, PROBING)
    if modulo:
        plc["P.ax.iMovementType"] = 0
    plc["P.trigger.iTriggerNumber"] = 0
    plc["P.probe.WindowOnly"] = True
    plc["P.probe.FirstPosition"], plc["P.probe.LastPosition"] = float(first), float(last)
    plc["P.probe.Execute"] = True
    plc.scan()
    if hits is None:
        assert plc["P.probe.ErrorID"] == 401
        return
    plc["P.velocity.Execute"] = True
    plc.scan(150)  # past 0, where it began: 10 u
    for _ in range(4000):
        plc.axes[1].switches.probe1 = not plc.axes[1].switches.probe1
        plc.scan()
        if plc["P.probe.Done"]:
            break
    position = plc["P.probe.RecordedPosition"]
    assert plc["P.probe.Done"] and (hits[0] <= position <= hits[1] or hits[0] <= position + 360 <= hits[1])


def test_abort_trigger():
    plc = load(PROBE, PROBING)
    plc["P.abort.Execute"] = True
    plc.scan()
    assert plc["P.abort.ErrorID"] == 410
    plc["P.abort.Execute"] = False
    plc["P.trigger.iTriggerNumber"] = 2
    plc["P.probe.Execute"] = True
    plc.scan()
    plc["P.abort.Execute"] = True
    plc.scan(2)
    assert plc["P.abort.Done"] and plc["P.probe.CommandAborted"]
    plc["P.probe.Execute"] = False
    plc["P.trigger.iTriggerNumber"] = 4
    plc.scan()
    plc["P.probe.Execute"] = True
    plc.scan()
    assert plc["P.probe.ErrorID"] == 402

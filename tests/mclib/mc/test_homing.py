"""MC_Home, SMC_Homing, probes, positions over a power cycle, digital inputs and cam switches."""

import pytest

from plcruntime import PLC

POWER = "power(Axis := ax, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);"


def load(declared: str, statements: str):
    plc = PLC.load(
        f"PROGRAM P VAR ax : AXIS_REF_SM3; power : MC_Power; {declared} END_VAR\n{POWER} {statements}\nEND_PROGRAM"
    )
    plc.scan(10)
    return plc


def until(plc, name: str, most: int = 20000) -> int:
    for n in range(most):
        if plc[f"P.{name}"]:
            return n
        plc.scan()
    raise AssertionError(name)


def test_home_where_it_stands():
    plc = load(
        "home : MC_Home; move : MC_MoveAbsolute;",
        "home(Axis := ax); move(Axis := ax, Velocity := 100, Acceleration := 1000, Deceleration := 1000);",
    )
    plc["P.home.Position"] = 50.0
    plc["P.home.Execute"] = True
    until(plc, "home.Done", 5)
    plc.scan()
    assert plc["P.ax.fActPosition"] == 50.0 and plc["P.ax.nAxisState"] == 3
    plc["P.move.Position"] = 60.0
    plc["P.move.Execute"] = True
    until(plc, "move.Done")
    assert plc["P.ax.fActPosition"] == 60.0 and plc.axes[1].encPos == 10.0


HOME = (
    "home : MC_Home; stop : MC_Stop; write : MC_WriteParameter; read : MC_ReadParameter; info : MC_ReadAxisInfo;"
    "velocity : MC_MoveVelocity;"
)
CALLS = (
    "home(Axis := ax); stop(Axis := ax, Deceleration := 50000); write(Axis := ax); read(Axis := ax, Enable := TRUE);"
    "info(Axis := ax, Enable := TRUE);"
    "velocity(Axis := ax, Velocity := 100, Acceleration := 1000, Deceleration := 1000);"
)


def write(plc, length: int, index: int, sub: int, value: float) -> None:
    plc["P.write.ParameterNumber"] = -(length * 2**24 + index * 2**8 + sub)
    plc["P.write.Value"] = value
    plc["P.write.Execute"] = True
    plc.scan()
    assert plc["P.write.Done"], (hex(index), value)
    plc["P.write.Execute"] = False
    plc["P.read.ParameterNumber"] = plc["P.write.ParameterNumber"]
    plc.scan()
    assert plc["P.read.Value"] == value


def drive(plc, method: int) -> None:
    write(plc, 1, 0x6098, 0, method)
    write(plc, 4, 0x6099, 1, 500.0)
    write(plc, 4, 0x6099, 2, 50.0)
    write(plc, 4, 0x609A, 0, 5000.0)
    axis = plc.axes[1]
    axis.places.placed = True
    axis.places.negative = -200.0
    axis.places.positive = 300.0
    axis.places.homeFrom, axis.places.homeTo = 100.0, 120.0
    axis.places.indexPeriod, axis.places.index = 30.0, 7.0


@pytest.mark.parametrize(
    ("method", "home"),
    [(17, -200), (18, 300), (1, -173), (2, 277), (23, 100), (24, 100), (27, 120), (33, -23), (34, 7), (35, 0)],
)
def test_home_by_the_drive(method, home):
    """Limit switches at -200 and 300, home switch from 100 to 120, index pulses at 7 + 30 n."""
    plc = load(HOME, CALLS)
    drive(plc, method)
    plc["P.home.Position"] = 5.0
    plc["P.home.Execute"] = True
    plc.scan()
    assert method == 35 or (plc["P.ax.nAxisState"] == 7 and plc["P.home.Busy"])
    until(plc, "home.Done")
    plc.scan()
    assert plc["P.info.IsHomed"] and plc["P.ax.nAxisState"] == 3
    # the position is 5 at the home position: the motor has stopped a little behind it
    assert plc["P.ax.fActPosition"] - 5.0 == pytest.approx(plc.axes[1].position - home, abs=1e-6)
    assert abs(plc["P.ax.fActPosition"] - 5.0) < 25.1  # 500 u/s stopped with 5000 u/s2


def test_home_wants_standstill_and_may_be_stopped():
    plc = load(HOME, CALLS)
    drive(plc, 17)
    plc["P.velocity.Execute"] = True
    plc.scan(10)
    plc["P.home.Execute"] = True
    plc.scan()
    assert plc["P.home.ErrorID"] == 170
    plc["P.home.Execute"] = plc["P.velocity.Execute"] = False
    plc["P.stop.Execute"] = True
    until(plc, "stop.Done")
    plc["P.stop.Execute"] = False
    plc.scan()
    plc["P.home.Execute"] = True
    plc.scan(150)
    assert plc["P.ax.fActVelocity"] == pytest.approx(-500.0)
    plc["P.velocity.Execute"] = True
    plc.scan()
    assert plc["P.velocity.ErrorID"] == 34  # homing lets no other motion in
    plc["P.stop.Execute"] = True
    before = plc.axes[1].position
    plc.scan(2)
    assert plc["P.home.CommandAborted"] and plc["P.ax.nAxisState"] == 2
    assert -1.1 < plc.axes[1].position - before < 0
    until(plc, "stop.Done")
    assert plc["P.ax.fActPosition"] == plc["P.ax.fSetPosition"]


def test_home_fails_at_the_limit_and_by_its_timeout():
    plc = load(HOME, CALLS)
    drive(plc, 27)
    plc.axes[1].places.homeFrom = plc.axes[1].places.homeTo = 1e300
    plc["P.home.Execute"] = True
    until(plc, "home.Error")
    assert plc["P.home.ErrorID"] == 17 and plc["P.ax.nAxisState"] == 1
    plc = load(HOME, CALLS)
    drive(plc, 17)
    write(plc, 2, 0x2005, 0x24, 100.0)
    plc["P.home.Execute"] = True
    until(plc, "home.Error")
    assert plc["P.home.ErrorID"] == 172


SMC = """
homing(Axis := ax, fHomePosition := 5, fVelocitySlow := 10, fVelocityFast := 100, fAcceleration := 1000,
    fDeceleration := 1000,
    bReferenceSwitch := NOT (ax.fActPosition + shift >= from_ AND ax.fActPosition + shift <= to_),
    bIndexOccured := index, fIndexPosition := indexAt);
"""
SMC_VARS = "homing : SMC_Homing; from_, to_, shift, indexAt : LREAL; index : BOOL;"


@pytest.mark.parametrize(
    ("mode", "direction", "edge"), [(0, -1, 1), (1, -1, 1), (4, -1, -1), (5, -1, -1), (0, 1, -1), (4, 1, 1)]
)
def test_smc_homing_finds_the_edge(mode, direction, edge):
    """The switch is closed from -30 to -20 (from 20 to 30 in the positive direction).

    shift: what the position read is away from the motor's.
    """
    plc = load(SMC_VARS, SMC)
    plc["P.from_"], plc["P.to_"] = (-30.0, -20.0) if direction < 0 else (20.0, 30.0)
    plc["P.homing.nHomingMode"] = mode
    plc["P.homing.nDirection"] = direction
    plc["P.homing.bExecute"] = True
    fastest = 0.0
    while not plc["P.homing.bDone"]:
        raw = plc.axes[1].position
        plc["P.shift"] = raw - plc["P.ax.fActPosition"]
        plc.scan()
        fastest = max(fastest, abs(plc["P.ax.fSetVelocity"]))
        assert plc["P.homing.bBusy"] != plc["P.homing.bDone"] and not plc["P.homing.bError"]
    assert fastest == pytest.approx(100.0) and plc["P.ax.nAxisState"] == 3
    # inside, the switch reads closed; the edge is at its upper end when the slow motion goes up
    at = plc["P.to_"] if edge > 0 else plc["P.from_"]
    zero = plc.axes[1].position - plc["P.ax.fActPosition"]
    if mode in (0, 4):
        # AM600: fHomePosition + (fSignalDelay + one cycle) * fVelocitySlow, where the edge was seen
        assert zero + 5.0 == pytest.approx(at, abs=0.011)
    else:
        assert plc["P.ax.fActPosition"] == 5.0
        assert plc.axes[1].position == pytest.approx(at + edge * 0.05, abs=0.025)  # 10 u/s stopped with 1000 u/s2


def test_smc_homing_compensates_the_signal_delay_exactly():
    plc = load(
        SMC_VARS + "seen : LREAL; was : BOOL;",
        SMC + "IF ax.fActPosition - seen > 1 AND homing.bBusy THEN was := TRUE; END_IF seen := ax.fActPosition;",
    )
    plc["P.from_"], plc["P.to_"] = -30.0, -20.0
    plc["P.homing.fSignalDelay"] = 0.05
    plc["P.homing.bExecute"] = True
    while not plc["P.was"]:
        plc.scan()
    # 5 + (0.05 * 1000 + 1) / 1000 * 10, and one scan further as the program reads it
    assert plc["P.ax.fActPosition"] == pytest.approx(5.0 + 0.051 * 10, abs=0.0101)


@pytest.mark.parametrize("mode", [3, 7, -1])
def test_smc_homing_knows_six_modes(mode):
    plc = load(SMC_VARS, SMC)
    plc["P.homing.nHomingMode"] = mode
    plc["P.homing.bExecute"] = True
    plc.scan(3)
    assert plc["P.homing.nErrorID"] == 50 and plc["P.ax.nAxisState"] == 3 and plc["P.ax.fSetVelocity"] == 0.0


def test_smc_homing_that_may_not_return_to_zero_ends_at_standstill():
    plc = load(SMC_VARS, SMC)
    plc["P.from_"], plc["P.to_"] = -30.0, -20.0
    plc["P.ax.fSWLimitNegative"], plc["P.ax.fSWLimitPositive"] = 3.0, 1000.0
    plc["P.homing.bReturnToZero"] = plc["P.homing.bExecute"] = True
    while plc["P.ax.fActPosition"] < 4.0:  # then the position is set
        raw = plc.axes[1].position
        plc["P.shift"] = raw - plc["P.ax.fActPosition"]
        plc.scan()
    plc["P.ax.bSWLimitEnable"] = True
    until(plc, "homing.bError")
    assert plc["P.homing.nErrorID"] == 10 and plc["P.ax.nAxisState"] == 3
    assert not plc["P.homing.bBusy"] and not plc["P.homing.bDone"]


@pytest.mark.parametrize("mode", [2, 6])
def test_smc_homing_by_index_and_return_to_zero(mode):
    plc = load(SMC_VARS, SMC)
    plc["P.from_"], plc["P.to_"] = -30.0, -20.0
    plc["P.homing.nHomingMode"] = mode
    plc["P.homing.bReturnToZero"] = True
    plc["P.homing.bExecute"] = True
    until(plc, "homing.bStartLatchingIndex")
    plc.scan(50)
    at = plc["P.ax.fActPosition"]
    raw = plc.axes[1].position
    plc["P.indexAt"] = at
    plc["P.index"] = True
    until(plc, "homing.bDone")
    assert plc["P.ax.fActPosition"] == 0.0
    assert plc.axes[1].position == pytest.approx(raw - 5.0)  # the index is at 5
    assert not plc["P.homing.bStartLatchingIndex"]


def test_smc_homing_begins_on_the_switch_and_is_refused():
    plc = load(SMC_VARS, SMC)
    plc["P.from_"], plc["P.to_"] = -3.0, 3.0
    plc["P.homing.bExecute"] = True
    plc.scan(50)
    assert plc["P.ax.fSetVelocity"] == 10.0  # off the switch at once
    until(plc, "homing.bDone")
    plc["P.homing.bExecute"] = False
    plc.scan()
    plc["P.homing.nDirection"] = 0
    plc["P.homing.bExecute"] = True
    plc.scan()
    assert plc["P.homing.bError"] and plc["P.homing.nErrorID"] == 50


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


PERSIST = """
VAR_GLOBAL PERSISTENT RETAIN data : SMC3_PersistPosition{kind}_Data; END_VAR
PROGRAM P
VAR ax : {axis}; power : MC_Power; persist : SMC3_PersistPosition{kind}; on : BOOL := TRUE;
    move : MC_MoveAbsolute; setpos : MC_SetPosition; END_VAR
persist(Axis := ax, PersistentData := data, bEnable := on);
power(Axis := ax, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
setpos(Axis := ax);
move(Axis := ax, Velocity := 1000, Acceleration := 10000, Deceleration := 10000);
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("kind", "axis"), [("", "AXIS_REF_SM3"), ("Singleturn", "AXIS_REF_SM3"), ("Logical", "AXIS_REF_LOGICAL_SM3")]
)
def test_a_position_outlives_the_power(kind, axis):
    plc = PLC.load(PERSIST.format(kind=kind, axis=axis))
    plc.scan(5)
    assert not plc["P.persist.bPositionRestored"] and plc["P.persist.bPositionStored"]
    plc["P.setpos.Position"] = 1000.0
    plc["P.setpos.Execute"] = True
    plc["P.move.Position"] = 1234.5
    plc.scan()
    plc["P.move.Execute"] = True
    until(plc, "move.Done")
    plc.scan(3)
    plc.power_cycle()
    plc.scan(5)
    assert plc["P.persist.bPositionRestored"] and plc["P.persist.eRestoringDiag"] == 0
    assert plc["P.ax.fActPosition"] == 1234.5 and plc["P.ax.fSetPosition"] == 1234.5
    plc["data.begun"] += 1  # the power went off while the block was storing
    plc.power_cycle()
    plc.scan()
    assert plc["P.persist.eRestoringDiag"] == 2 and plc["P.ax.fActPosition"] == 1234.5
    plc.scan(3)
    plc.power_cycle()
    plc["P.ax.fScalefactor"] = 2.0
    plc.scan()
    assert plc["P.persist.eRestoringDiag"] == 1 and not plc["P.persist.bPositionRestored"]


@pytest.mark.parametrize(
    ("kind", "axis"),
    [("", "AXIS_REF_LOGICAL_SM3"), ("Singleturn", "AXIS_REF_VIRTUAL_SM3"), ("Logical", "AXIS_REF_SM3")],
)
def test_other_kinds_of_axes_are_refused(kind, axis):
    plc = PLC.load(PERSIST.format(kind=kind, axis=axis))
    plc.scan(2)
    assert plc["P.persist.bError"] and plc["P.persist.eErrorID"] == 25


def test_digital_inputs_and_outputs():
    plc = load(
        "i : MC_INPUT_REF; o : MC_OUTPUT_REF; ri : MC_ReadDigitalInput; ro : MC_ReadDigitalOutput;"
        "w : MC_WriteDigitalOutput;",
        "w(Output := o, OutputNumber := 31, Value := TRUE); ri(Input := i, Enable := TRUE, InputNumber := 3);"
        "ro(Output := o, Enable := TRUE);",
    )
    plc["P.i.Values"] = 8
    plc["P.w.Execute"] = True
    plc["P.ro.OutputNumber"] = 31
    plc.scan()
    assert plc["P.ri.Value"] and plc["P.ro.Value"] and plc["P.o.Values"] == 2**31 and plc["P.w.Done"]
    plc["P.ro.OutputNumber"] = 32
    plc.scan()
    assert plc["P.ro.Error"] and not plc["P.ro.Value"]


def test_cam_switches():
    plc = load(
        "cams : MC_CAMSWITCH_REF; o : MC_OUTPUT_REF; tracks : MC_TRACK_REF; digital : MC_DigitalCamSwitch;"
        "velocity : MC_MoveVelocity;",
        "velocity(Axis := ax, Velocity := 100, Acceleration := 1E6, Deceleration := 1E6);"
        "digital(Axis := ax, Switches := cams, Outputs := o, TrackOptions := tracks, Enable := TRUE, EnableMask := 7);",
    )
    switches = [
        (1, 10.0, 20.0, 0, 0, 0.0),
        (2, 15.0, 30.0, 2, 0, 0.0),
        (3, 10.0, 0.0, 0, 1, 0.05),
        (1, 40.0, 50.0, 0, 0, 0.0),
    ]
    plc["P.cams.Number"] = len(switches)
    for i, (track, first, last, way, mode, duration) in enumerate(switches, 1):
        for name, value in (
            ("TrackNumber", track),
            ("FirstOnPosition", first),
            ("LastOnPosition", last),
            ("AxisDirection", way),
            ("CamSwitchMode", mode),
            ("Duration", duration),
        ):
            plc[f"P.cams.Switches[{i}].{name}"] = value
    plc["P.tracks.OnAdvance[1]"] = 0.01  # 10 ms at 100 u/s: one unit earlier
    plc["P.velocity.Execute"] = True
    on = {1: [], 2: [], 3: []}
    for _ in range(600):
        at = plc["P.ax.fSetPosition"]
        plc.scan()
        for track, places in on.items():
            if plc["P.o.Values"] >> (track - 1) & 1:
                places.append(at)
    assert min(on[1]) == pytest.approx(9.0, abs=0.11) and max(p for p in on[1] if p < 30) == pytest.approx(
        20.0, abs=0.11
    )
    assert min(p for p in on[1] if p > 30) == pytest.approx(39.0, abs=0.11)
    assert on[2] == []  # only in the negative direction
    assert min(on[3]) == pytest.approx(10.0, abs=0.11) and len(on[3]) == 50


@pytest.mark.parametrize(("number", "track", "error"), [(1, 0, 30003), (1, 33, 30003), (33, 1, 30003), (1, 32, 0)])
def test_cam_switches_have_a_track(number, track, error):
    plc = load(
        "cams : MC_CAMSWITCH_REF; o : MC_OUTPUT_REF := (Values := 1); tracks : MC_TRACK_REF;"
        "digital : MC_DigitalCamSwitch;",
        "digital(Axis := ax, Switches := cams, Outputs := o, TrackOptions := tracks, Enable := TRUE);",
    )
    plc["P.cams.Number"], plc["P.cams.Switches[1].TrackNumber"] = number, track
    plc.scan()
    assert plc["P.digital.ErrorID"] == error and plc["P.digital.InOperation"] == (error == 0)
    assert plc["P.o.Values"] == (0 if error else 2**31)  # from 0 to 0: the axis is there


@pytest.mark.parametrize(("direction", "times"), [(0, 2), (1, 1), (2, 1)])
def test_a_cam_switch_by_time_needs_no_last_position(direction, times):
    plc = load(
        "cams : MC_CAMSWITCH_REF; o : MC_OUTPUT_REF; tracks : MC_TRACK_REF; digital : MC_DigitalCamSwitch;"
        "move : MC_MoveAbsolute; begun : INT; up : R_TRIG;",
        "move(Axis := ax, Velocity := 100, Acceleration := 1E4, Deceleration := 1E4);"
        "digital(Axis := ax, Switches := cams, Outputs := o, TrackOptions := tracks, Enable := TRUE);"
        "up(CLK := o.Values.0); begun := begun + BOOL_TO_INT(up.Q);",
    )
    plc["P.cams.Number"] = 1
    for name, value in (("TrackNumber", 1), ("FirstOnPosition", 15.0), ("AxisDirection", direction),
                        ("CamSwitchMode", 1), ("Duration", 0.02)):  # fmt: skip
        plc[f"P.cams.Switches[1].{name}"] = value
    on = 0
    for goal in (30.0, 0.0):
        plc["P.move.Position"] = goal
        plc["P.move.Execute"] = False
        plc.scan()
        plc["P.move.Execute"] = True
        for _ in range(400):
            plc.scan()
            on += plc["P.o.Values"]
    assert plc["P.begun"] == times and on == times * 20


def test_nothing_waits_behind_smc_homing(bench):
    """Its steps are motions that end one by one; behind MC_Home a command may wait."""
    bench["smcHome.bReferenceSwitch"] = True
    bench.start("smcHome", 50, fVelocityFast=100.0, fVelocitySlow=10.0, fAcceleration=1e3, fDeceleration=1e3)
    bench.start("third", Position=50.0, BufferMode=1)
    assert bench["third.ErrorID"] == 34 and bench.state == "homing"
    bench.scan(200)
    assert bench["smcHome.bBusy"] and bench["ax.fSetVelocity"] == -100.0

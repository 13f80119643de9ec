"""MC_Home and SMC_Homing."""

import pytest
from one_axis import load, until


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


def test_nothing_waits_behind_smc_homing(bench):
    """Its steps are motions that end one by one; behind MC_Home a command may wait."""
    bench["smcHome.bReferenceSwitch"] = True
    bench.start("smcHome", 50, fVelocityFast=100.0, fVelocitySlow=10.0, fAcceleration=1e3, fDeceleration=1e3)
    bench.start("third", Position=50.0, BufferMode=1)
    assert bench["third.ErrorID"] == 34 and bench.state == "homing"
    bench.scan(200)
    assert bench["smcHome.bBusy"] and bench["ax.fSetVelocity"] == -100.0

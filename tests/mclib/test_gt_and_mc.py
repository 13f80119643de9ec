"""One axis under GT_ commands and MC_ blocks: each sees the other's motion, one owner at a time."""

MOVE = {"Velocity": 1000.0, "Acceleration": 10000.0, "Deceleration": 10000.0}
ENABLED, MOVING = 1 << 9, 1 << 10


def gt(bench, number: int) -> int:
    bench["gt"] = number
    bench.scan()
    return bench["rtn"]


def test_gt_reads_what_a_block_moves_in_pulses_and_ms(bench):
    bench["ax.fScalefactor"] = 10.0
    bench.power()
    assert bench["sts"] == ENABLED
    bench.start("velocity", **MOVE)
    bench.until("velocity.InVelocity")
    assert bench["prfVel"] == 10.0  # 1000 u/s of 10 pulses
    assert bench["sts"] == ENABLED | MOVING


def test_a_block_sees_gt_motion_in_its_state(bench):
    assert gt(bench, 4) == 0
    assert bench.state == "StandStill" and bench["ax.bRegulatorRealState"]
    assert gt(bench, 1) == 0
    bench.scan()
    assert bench.state == "DiscreteMotion"
    bench.scan(200)
    assert bench.state == "StandStill" and bench["ax.fSetPosition"] == 1000.0
    assert gt(bench, 8) == 0
    bench.scan(20)
    assert bench.state == "ContinuousMotion" and bench["ax.fSetVelocity"] == 5000.0
    assert gt(bench, 3) == 0
    bench.scan(20)
    assert bench.state == "StandStill"


def test_gt_update_takes_the_axis_from_a_block(bench):
    bench.power()
    assert gt(bench, 1) == 0
    bench.scan(300)
    bench.start("velocity", **MOVE)
    bench.scan(50)
    assert bench["velocity.Busy"]
    assert gt(bench, 2) == 0  # GT_Update to 1000 again
    bench.scan()
    assert bench["velocity.CommandAborted"]
    bench.scan(1000)
    assert bench["prfPos"] == 1000.0 and bench.state == "StandStill"


def test_a_block_takes_the_axis_from_gt(bench):
    bench.power()
    assert gt(bench, 8) == 0
    bench.scan(30)
    bench.start("absolute", Position=50.0, **MOVE)
    assert bench["absolute.Busy"]
    bench.until("absolute.Done")
    assert bench["prfPos"] == 50.0


def test_gt_is_refused_while_mc_stop_has_the_axis(bench):
    bench.power()
    assert gt(bench, 1) == 0
    bench.scan(10)
    bench.start("stop", Deceleration=20000.0)
    assert gt(bench, 2) == 1
    assert gt(bench, 3) == 1
    bench.until("stop.Done")
    assert gt(bench, 2) == 1
    bench["stop.Execute"] = False
    bench.scan()
    assert gt(bench, 2) == 0


def test_gt_stop_aborts_a_block(bench):
    bench.power()
    bench.start("absolute", Position=1000.0, **MOVE)
    bench.scan(30)
    assert gt(bench, 3) == 0
    bench.scan(20)
    assert bench["absolute.CommandAborted"] and bench.state == "StandStill"


def test_gt_axis_off_aborts_a_block(bench):
    bench.continuous = False
    bench.power()
    bench.start("absolute", Position=1000.0, **MOVE)
    bench.scan(30)
    for name in ("Enable", "bRegulatorOn", "bDriveStart"):
        bench[f"power.{name}"] = False
    assert gt(bench, 7) == 0
    bench.scan()
    assert bench["absolute.CommandAborted"] and bench.state == "Disabled" and not bench["sts"] & (ENABLED | MOVING)


def test_mode_can_not_change_while_a_block_moves(bench):
    bench.power()
    bench.start("velocity", **MOVE)
    bench.scan(10)
    bench["gt"] = 8
    bench.scan()
    # GT_PrfJog and GT_SetJogPrm return 1; GT_Update in Trap mode without parameters returns 1
    assert bench["rtn"] == 1 and bench["velocity.Busy"]


def test_clearing_ends_errorstop_when_no_cause_is_left(bench):
    bench.continuous = False
    bench.power()
    bench.start("velocity", **MOVE)
    bench.scan(10)
    bench.plc.axes[1].switches.positive = True
    bench.scan(2)
    assert bench.state == "Errorstop"
    bench["velocity.Execute"] = False
    assert gt(bench, 5) == 0 and bench["sts"] & 0x20
    bench.plc.axes[1].switches.positive = False
    assert gt(bench, 5) == 0
    bench.scan()
    assert bench.state == "StandStill" and not bench["sts"] & 0x20

"""MC_Jog and SMC_Inch. After every scan conftest checks PLCopen Part 1's rules."""

import pytest

MOVE = {"Velocity": 1000.0, "Acceleration": 10000.0, "Deceleration": 10000.0, "Jerk": 0.0}  # 0.1 s to full speed


def test_jog_follows_its_inputs(bench):
    bench.power()
    for name, value in MOVE.items():
        bench[f"jog.{name}"] = value
    bench["jog.JogForward"] = True
    bench.scan(200)
    assert bench["jog.Busy"] and bench["ax.fSetVelocity"] == 1000.0
    bench["jog.JogBackward"] = True  # both: it comes to rest
    bench.scan(100)
    assert bench["jog.Busy"] and bench.state == "ContinuousMotion" and bench["ax.fSetVelocity"] == pytest.approx(0.0)
    bench.scan()
    assert not bench["jog.Busy"] and bench.state == "StandStill"
    bench["jog.JogForward"] = False
    bench.scan(300)
    assert bench["ax.fSetVelocity"] == -1000.0
    bench["jog.JogBackward"] = False
    bench.scan(110)
    assert bench.state == "StandStill" and not bench["jog.Busy"]


def test_jog_takes_changed_values_at_once(bench):
    bench.power()
    for name, value in MOVE.items():
        bench[f"jog.{name}"] = value
    bench["jog.JogForward"] = True
    bench.scan(150)
    bench["jog.Velocity"], bench["jog.Deceleration"] = 200.0, 4000.0
    bench.scan(200)  # 800 u/s with 4000 u/s2
    assert bench["ax.fSetVelocity"] == 200.0
    bench["jog.Velocity"] = -5.0  # is none
    bench["jog.Acceleration"] = 0.0
    bench.scan(5)
    assert bench["ax.fSetVelocity"] == 200.0 and bench["jog.Busy"]
    bench["jog.Velocity"], bench["jog.Acceleration"] = 0.0, 1000.0
    bench.scan(60)
    assert bench["ax.fSetVelocity"] == 0.0 and bench["jog.Busy"] and bench.state == "ContinuousMotion"
    bench["jog.JogForward"] = False
    bench.scan(2)
    assert not bench["jog.Busy"] and bench.state == "StandStill"


def test_jog_the_other_way_with_wrong_values_stops(bench):
    bench.power()
    for name, value in MOVE.items():
        bench[f"jog.{name}"] = value
    bench["jog.JogForward"] = True
    bench.scan(150)
    bench["jog.Velocity"] = 0.0
    bench["jog.JogForward"], bench["jog.JogBackward"] = False, True
    bench.scan()
    assert bench["jog.Error"] and bench["jog.ErrorID"] == 301  # SMC_MV_INVALID_ACCDEC_VALUES
    bench.scan(110)
    assert bench["ax.fSetVelocity"] == 0.0 and bench.state == "StandStill" and bench["jog.Error"]
    bench["jog.JogBackward"] = False
    bench.scan()
    assert not bench["jog.Error"]


@pytest.mark.parametrize("forward", [True, False])
def test_a_jog_that_is_taken_over_while_it_comes_to_rest(bench, forward):
    bench.power()
    for name, value in MOVE.items():
        bench[f"jog.{name}"] = value
    bench["jog.JogForward"] = True
    bench.scan(150)
    bench["jog.JogForward"] = forward
    bench.scan(20)
    bench.start("absolute", Position=0.0, **MOVE)
    assert bench["jog.CommandAborted"] and not bench["jog.Busy"]
    bench.scan()
    assert bench["jog.CommandAborted"] == forward  # for one scan where no input is TRUE
    bench.until("absolute.Done")


def test_inch_steps_once_an_edge(bench):
    bench.power()
    for name, value in {**MOVE, "Distance": 20.0}.items():
        bench[f"inch.{name}"] = value
    bench["inch.InchForward"] = True
    bench.scan(300)
    assert bench["ax.fSetPosition"] == 20.0 and not bench["inch.Busy"]
    bench["inch.InchForward"] = False
    bench.scan()
    bench["inch.InchBackward"] = True
    bench.scan(20)
    bench["inch.InchBackward"] = False
    bench.scan(5)
    assert bench["inch.Busy"] and bench.state == "DiscreteMotion"
    bench.scan(95)
    assert not bench["inch.Busy"]
    assert 0.0 < bench["ax.fSetPosition"] < 20.0 and bench.state == "StandStill"

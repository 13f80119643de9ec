"""Digital inputs and outputs, cam switches."""

import pytest
from one_axis import load


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

"""Numbers that the iDEABOX 3 manual prints, or that follow from those it prints, beside what the other tests show."""

import pytest

from plcruntime import PLC


def trap(gt, target, vel, acc, dec, smooth=0):
    gt.ok("GT_PrfTrap")
    gt.ok("GT_SetTrapPrm", trap={"acc": acc, "dec": dec, "velStart": 0.0, "smoothTime": smooth})
    gt.ok("GT_SetPos", x=target)
    gt.ok("GT_SetVel", v=vel)
    gt.ok("GT_Update", x=1)


def test_example_7_1_without_smoothing(gt):
    """50000 pulses with 50 pulse/ms, 0.25 and 0.125 pulse/ms2: 200 ms and 5000, 700 ms and 35000, 400 ms and 10000."""
    gt.follow(1)
    trap(gt, 50000, 50.0, 0.25, 0.125)
    gt.plc.scan(1310)
    rows = gt.rows(1)[4:]  # four scans set it up, that of GT_Update is the first ms
    assert [rows[t - 1][:2] for t in (200, 900, 1300)] == [(5000.0, 50.0), (40000.0, 50.0), (50000.0, 0.0)]


@pytest.mark.parametrize("command", ["GT_ProfileScale", "GT_EncScale"])
def test_range_of_scales(gt, command):
    """4.3.1: (-32767, 0) and (0, 32767), alpha not smaller than beta."""
    for alpha, beta in ((1, 1), (32766, 1), (-32766, 1), (32766, 32766), (-3, 2), (3, -2), (-3, -3)):
        gt.ok(command, i=alpha, j=beta)
    for alpha, beta in ((32767, 1), (-32767, 1), (-32768, 1), (0, 1), (1, 0), (1, 2), (2, -3), (-32768, -32768)):
        assert gt(command, i=alpha, j=beta) == 7


def test_scales_are_ratios_of_changes(gt):
    """4.3.1: dP of the profile : dP of the axis = alpha : beta; the motor turns as the axis says."""
    gt.ok("GT_AxisOn")
    gt.ok("GT_ProfileScale", i=5, j=2)
    gt.ok("GT_EncScale", i=4, j=1)
    trap(gt, 1000, 50.0, 1.0, 1.0)
    gt.plc.scan(200)
    axis = gt.axis()
    assert (axis.prfPos, axis.position, axis.encPos) == (1000.0, 400.0, 400.0)
    assert gt.plc.evaluate("SimAxisPrf(SIM.Axis[1])") == 400.0 and gt.plc.evaluate("SimAxisEnc(SIM.Axis[1])") == 100.0


def test_default_decelerations_of_stops_and_limits(gt):
    """Table 4-4 and 9.2.2: 1 pulse/ms2 smooth, 1000 pulse/ms2 in an emergency."""
    gt.ok("GT_AxisOn")
    gt.jog(1, 50.0)
    gt.plc.scan(100)
    at = gt.axis().prfPos
    gt.ok("GT_Stop", x=1)
    gt.plc.scan(49)
    assert gt.axis().prfPos == at + 50 * 50 / 2 and not gt.axis().moving
    gt.jog(1, 50.0)
    gt.plc.scan(100)
    at = gt.axis().prfPos
    gt.ok("GT_Stop", x=1, y=1)
    assert gt.axis().prfPos == at + 50 * 50 / 2 / 1000 and not gt.axis().moving
    gt.jog(1, 50.0)
    gt.plc.scan(100)
    gt.axis().switches.positive = True
    gt.plc.scan()
    at = gt.axis().prfPos
    gt.plc.scan()
    assert gt.axis().prfPos == at + 50 * 50 / 2 / 1000


def test_figure_11_1_band_of_100_pulses_for_500_us():
    """The motor rests at 1000 pulses and oscillates; bit 11 comes 500 us after it has stayed inside of 100 pulses."""
    plc = PLC.load(
        """PROGRAM PLC_PRG VAR once : BOOL; END_VAR
IF NOT once THEN
    GT_SetPrfPos(1, 1000); GT_SynchAxisPos(1); GT_SetAxisBand(1, 100, 2);
    once := TRUE;
END_IF
END_PROGRAM""",
        interval="250us",
    )
    plc.scan()
    seen = []
    for away in (300, -200, 150, 99, -120, 80, -60, 40, -30, 101, 50, 50, 50):
        plc["SIM.Axis[1].offset"] = 1000.0 + away
        plc.scan()
        seen.append(plc["SIM.Axis[1].status"] >> 11 & 1)
    # inside from the sixth on: 500 us later is the eighth; outside at the tenth, inside from the eleventh on
    assert seen == [0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 1]

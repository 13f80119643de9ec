"""Examples 5-1 to 5-5 of the iDEABOX 3 manual as printed, and the calls in 5.2.2.4 and 5.2.2.5, with their numbers."""

from pathlib import Path

import pytest

from plcruntime import PLC

LISTINGS = Path(__file__).parents[3] / "shared/manuals/listings/ideabox3"
pytestmark = pytest.mark.skipif(not LISTINGS.exists(), reason="the manuals' listings are not beside this checkout")


def test_5_1_returns_until_the_bus_is_ready():
    plc = PLC.load(LISTINGS / "08_ecat_ready.st")
    plc.scan()
    assert plc["PLC_PRG.iEcatSts"] == 1 and plc["PLC_PRG.rtn"] == 0
    plc["ECAT.cut"] = True
    plc.scan()
    assert plc["PLC_PRG.iEcatSts"] == 0


# ------------------------------------------------------------------------------------------- 5-2 homing


@pytest.fixture
def homing():
    """Example 5-2. The servo is on, which the printed part leaves to others; the switch stands at 100000 pulses."""
    plc = PLC.load(LISTINGS / "09_homing_method3.st")
    plc.scan()
    plc.execute("SimEnable(SIM.Axis[1], TRUE)")
    places = plc.axes[1].places
    places.homeFrom, places.placed = 100000.0, True
    return plc


def test_5_2_homes_by_method_3(homing):
    """To the switch at 5000 pulse/ms, back at 3000: home is the last index pulse in front of it, at 90000."""
    plc, axis = homing, homing.axes[1]
    trace = plc.trace("SIM.Axis[1].velocity", "PLC_PRG.iHomeSts")
    plc["PLC_PRG.xStart"] = True
    plc.scan()
    assert plc["PLC_PRG.xHoming"] and not plc["PLC_PRG.xStart"] and plc["PLC_PRG.rtn"] == 0
    assert plc["ECAT.Drive[1].mode"] == 6
    plc.run_until("NOT PLC_PRG.xHoming", "1s")
    assert plc["PLC_PRG.iHomeSts"] == 3 and plc["ECAT.Drive[1].mode"] == 8
    assert axis.position - axis.encPos == pytest.approx(90000.0)
    assert axis.prfPos == axis.encPos
    velocity = [float(x) for x in trace["SIM.Axis[1].velocity"]]
    assert max(velocity) == 5000.0 and min(velocity) == -3000.0
    status = [int(x) for x in trace["PLC_PRG.iHomeSts"]]
    assert set(status) == {0, 3} and status == sorted(status)
    plc.scan(10)
    assert plc["SIM.refusals"] == 0  # mode 8 again in every scan: nothing wrong with it


def test_5_2_does_nothing_with_the_servo_off():
    plc = PLC.load(LISTINGS / "09_homing_method3.st")
    plc["PLC_PRG.xStart"] = True
    plc.scan(5)
    assert not plc["PLC_PRG.xHoming"] and not plc["PLC_PRG.xStart"] and plc.axes[1].position == 0.0


def test_5_2_stopped(homing):
    plc, axis = homing, homing.axes[1]
    plc["PLC_PRG.xStart"] = True
    plc.scan(10)
    plc["PLC_PRG.xStop"] = True
    plc.scan(2)
    stood = axis.position
    plc.scan(10)
    assert not plc["PLC_PRG.xHoming"] and not plc["PLC_PRG.xStop"] and axis.position == stood < 100000.0
    assert plc["PLC_PRG.iHomeSts"] == 1 and plc["ECAT.Drive[1].mode"] == 8
    plc["PLC_PRG.xStart"] = True  # and again from there
    plc.scan(2)
    plc.run_until("NOT PLC_PRG.xHoming", "1s")
    assert plc["PLC_PRG.iHomeSts"] == 3 and axis.position - axis.encPos == pytest.approx(90000.0)


# ------------------------------------------------------------------------------------------- 5-3 touch probe


def test_5_3_takes_every_rising_edge():
    plc = PLC.load(LISTINGS / "10_touch_probe.st")
    axis = plc.axes[1]

    def capture(position):
        """The motor, its servo off, is moved; then the probe is triggered."""
        axis.offset = position
        plc.scan()
        plc["SIM.Axis[1].switches.probe1"] = True
        plc.scan(2)
        plc["SIM.Axis[1].switches.probe1"] = False
        plc.scan()

    capture(111.0)
    assert plc["PLC_PRG.uiProbeSts"] == 0 and plc["PLC_PRG.diLastValue"] == 0
    plc["PLC_PRG.xStartProbe"] = True
    plc.scan(2)
    assert plc["ECAT.Drive[1].probe.control"] == 0x0013 and plc["PLC_PRG.uiProbeSts"] == 1
    for position in (1000, -2500, 123456, 7):
        capture(float(position))
        assert plc["PLC_PRG.diRiseValue1"] == plc["PLC_PRG.diLastValue"] == position
        assert plc["PLC_PRG.uiProbeSts"] & 7 == 3
    assert plc["PLC_PRG.diFallValue1"] == plc["PLC_PRG.diRiseValue2"] == plc["PLC_PRG.diFallValue2"] == 0
    plc["PLC_PRG.xStopProbe"] = True
    plc.scan(2)
    assert plc["PLC_PRG.uiProbeSts"] == 0
    capture(5.0)
    assert plc["PLC_PRG.diLastValue"] == 7
    plc["PLC_PRG.xStartProbe"] = True
    plc.scan(2)
    capture(31.0)
    assert plc["PLC_PRG.diLastValue"] == 31


# ------------------------------------------------------------------------------------------- 5-4 and the calls of 5.2.2


def test_5_4_reads_and_writes_the_modules_of_the_coupler():
    plc = PLC.load(LISTINGS / "11_ecat_io.st")
    for k, byte in enumerate((0x34, 0x12, 1, 0, 2, 0, 3, 0, 4, 0)):
        plc[f"ECAT.image[{14 + k}]"] = byte
    # the names that are declared; three of them are printed otherwise in the calls
    plc["PLC_PRG.wDOuput"], plc["PLC_PRG.arrAOutput1234"] = 0xA55A, [11, 12, 13, 14]
    plc.scan()
    assert plc["PLC_PRG.rtn"] == 0 and plc["SIM.refusals"] == 0
    assert plc["PLC_PRG.wDInput"] == 0x1234
    assert (plc["PLC_PRG.wAInput1"], plc["PLC_PRG.wAInput2"], plc["PLC_PRG.arrAInput34"]) == (1, 2, [3, 4])
    assert [plc[f"ECAT.image[{k}]"] for k in range(2, 12)] == [0x5A, 0xA5, 11, 0, 12, 0, 13, 0, 14, 0]


def fragment(name, declarations):
    calls = (LISTINGS / name).read_text(encoding="utf-8").replace(",\n", ", ").strip().splitlines()
    body = "\n".join(f"rtn{k} := {call};" for k, call in enumerate(calls))
    results = ", ".join(f"rtn{k}" for k in range(len(calls)))
    return f"PROGRAM PLC_PRG\nVAR {results} : INT; {declarations} END_VAR\n{body}\nEND_PROGRAM", len(calls)


def test_the_raw_data_calls_of_5_2_2_4(tmp_path):
    """On the bus of figures 5-2 and 5-3: the IO slaves lie at 32 and 36, their outputs first."""
    (tmp_path / "plc.toml").write_text('[[ecat.slave]]\nkind="gthd"\ncount=2\n[[ecat.slave]]\nkind="io"\ncount=2\n')
    text, count = fragment("06_pdo_raw_data_calls.st", "wInput, wOutput : WORD;")
    plc = PLC.load(text, config=tmp_path / "plc.toml")
    assert [plc[f"ECAT.Slave[{k}].start"] for k in range(4)] == [0, 16, 32, 36] and plc["ECAT.size"] == 40
    plc["ECAT.image[38]"], plc["ECAT.image[39]"], plc["PLC_PRG.wOutput"] = 0xCD, 0xAB, 0x1122
    plc.scan()
    assert all(plc[f"PLC_PRG.rtn{k}"] == 0 for k in range(count)) and plc["PLC_PRG.wInput"] == 0xABCD
    assert [plc[f"ECAT.image[{k}]"] for k in (32, 33, 36, 37)] == [0x22, 0x11, 0x22, 0x11]
    # and without a configuration: other slaves, the same addresses
    plc = PLC.load(text)
    plc["PLC_PRG.wOutput"] = 0x1122
    plc.scan()
    assert [plc[f"ECAT.image[{k}]"] for k in (32, 33, 36, 37)] == [0x22, 0x11, 0x22, 0x11]


def test_the_io_calls_of_5_2_2_5():
    """Printed with a core number in front, which the reader takes away."""
    text, count = fragment(
        "07_ecat_io_calls.st",
        "wDInput, wDOutput, wAInput1, wAInput2 : WORD; arrAInput34 : ARRAY[0..1] OF WORD; "
        "arrAOutput1234 : ARRAY[0..3] OF WORD;",
    )
    plc = PLC.load(text)
    for k in range(10):
        plc[f"ECAT.image[{14 + k}]"] = k
    plc["PLC_PRG.wDOutput"], plc["PLC_PRG.arrAOutput1234"] = 0xBEEF, [1, 2, 3, 0x1234]
    plc.scan()
    assert all(plc[f"PLC_PRG.rtn{k}"] == 0 for k in range(count))
    assert plc["PLC_PRG.wDInput"] == 0x0100 and plc["PLC_PRG.arrAInput34"] == [0x0706, 0x0908]
    assert [plc[f"ECAT.image[{k}]"] for k in range(2, 12)] == [0xEF, 0xBE, 1, 0, 2, 0, 3, 0, 0x34, 0x12]


def test_the_calls_as_printed():
    """No declarations: the number of bytes says what the variables are."""
    plc = PLC.load(LISTINGS / "06_pdo_raw_data_calls.st")
    plc["PLC_PRG.wOutput"] = 0x1122
    plc["ECAT.image[38]"], plc["ECAT.image[39]"] = 0xCD, 0xAB
    plc.scan()
    assert plc["PLC_PRG.wInput"] == 0xABCD and plc["PLC_PRG.wOutput"] == 0x1122
    assert [plc[f"ECAT.image[{k}]"] for k in (32, 33, 36, 37)] == [0x22, 0x11, 0x22, 0x11]
    plc = PLC.load(LISTINGS / "07_ecat_io_calls.st")
    for k in range(10):
        plc[f"ECAT.image[{14 + k}]"] = k
    plc["PLC_PRG.wDOutput"], plc["PLC_PRG.arrAOutput1234"] = 0xBEEF, 0x1234000300020001
    plc.scan()
    assert [plc[f"PLC_PRG.{n}"] for n in ("wDInput", "wAInput1", "wAInput2")] == [0x0100, 0x0302, 0x0504]
    assert plc["PLC_PRG.arrAInput34"] == 0x09080706
    assert [plc[f"ECAT.image[{k}]"] for k in range(2, 12)] == [0xEF, 0xBE, 1, 0, 2, 0, 3, 0, 0x34, 0x12]


# ------------------------------------------------------------------------------------------- 5-5


def test_5_5_as_a_program(tmp_path):
    """The C program opens the controller from outside; here are its calls in their order."""
    (tmp_path / "GTS800.cfg").write_text("[axis *]\nalarm = none\n")
    (tmp_path / "main.st").write_text("""
PROGRAM PLC_PRG
VAR rtn : ARRAY[0..5] OF INT; status : INT; END_VAR
rtn[0] := GT_Open(CHANNEL_PCI_ECAT);
rtn[1] := GT_InitEcatComm();
REPEAT
    rtn[2] := GT_IsEcatReady(ADR(status));
UNTIL NOT (status <> 1 OR rtn[2] <> 0)
END_REPEAT
rtn[3] := GT_StartEcatComm();
rtn[4] := GT_Reset();
rtn[5] := GT_LoadConfig('GTS800.cfg') + GT_ClrSts(1);
END_PROGRAM
""")
    plc = PLC.load(tmp_path / "main.st")
    plc.scan()
    assert plc["PLC_PRG.rtn"] == [0] * 6 and plc["PLC_PRG.status"] == 1
    assert plc.axes[1].alarmFrom == -1

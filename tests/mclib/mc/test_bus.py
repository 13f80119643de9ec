"""Axes that plc.toml declares, and the blocks on an axis whose drive is on the EtherCAT bus."""

import pytest

from plcruntime import PLC
from plcruntime.errors import UsageError

PROGRAM = """
PROGRAM PLC_PRG
VAR
    power : MC_Power; home : MC_Home; move : MC_MoveRelative; reset : MC_Reset; write : MC_WriteParameter;
    read : MC_ReadParameter; info : MC_ReadAxisInfo; on : BOOL := TRUE; away : BOOL; got : DINT; rtn : INT;
END_VAR
power(Axis := X, Enable := TRUE, bRegulatorOn := on, bDriveStart := TRUE);
IF NOT away THEN home(Axis := X, Position := 5); END_IF
move(Axis := X, Velocity := 1000, Acceleration := 10000, Deceleration := 10000);
reset(Axis := X); write(Axis := X); read(Axis := X, Enable := TRUE); info(Axis := X, Enable := TRUE);
IF got = -1 THEN rtn := GT_AxisOff(3); got := 0; END_IF
END_PROGRAM
"""
AXIS = """
[[axis]]
number = 3
name = "X"
kind = "ethercat"
home_from = 100
home_to = 120
limit_negative = -500
limit_positive = 500
"""
POWER_OFF, ERRORSTOP, STANDSTILL, HOMING = 0, 1, 3, 7


def load(folder, toml: str = AXIS, text: str = PROGRAM) -> PLC:
    (folder / "prog.st").write_text(text)
    (folder / "plc.toml").write_text(toml)
    return PLC.load(folder / "plc.toml")


def give(plc, block: str, **inputs) -> None:
    for name, value in inputs.items():
        plc[f"{block}.{name}"] = value
    plc[f"{block}.Execute"] = True
    plc.scan()


def write(plc, length: int, index: int, sub: int, value: float) -> int:
    """Gives the ErrorID."""
    plc["write.Execute"] = False
    plc.scan()
    give(plc, "write", ParameterNumber=-(length * 2**24 + index * 2**8 + sub), Value=value)
    return plc["write.ErrorID"]


def read(plc, length: int, index: int, sub: int = 0):
    plc["read.ParameterNumber"] = -(length * 2**24 + index * 2**8 + sub)
    plc.scan()
    return plc["read.Value"] if plc["read.Valid"] else -plc["read.ErrorID"]


def test_power_waits_for_the_bus(tmp_path):
    plc = load(tmp_path, AXIS + "[ecat]\nstartup = '50ms'\n[[ecat.slave]]\nkind = 'drive'\naxis = 3\n")
    plc.run("40ms")
    assert plc["power.Busy"] and not plc["power.Error"] and plc["X.nAxisState"] == POWER_OFF
    assert not plc["X.bCommunication"] and plc["X.wCommunicationState"] == 0 and not plc["info.CommunicationReady"]
    give(plc, "move", Distance=1.0)
    assert plc["move.ErrorID"] == 27  # SMC_AXIS_IS_NOT_OPERATIONAL
    plc.run("20ms")
    assert plc["power.Status"] and plc["X.bCommunication"] and plc["info.CommunicationReady"]


def test_power_tells_that_the_bus_does_not_come(tmp_path):
    plc = load(tmp_path)
    plc["ECAT.cut"] = True
    plc.run("4.9s")
    assert plc["power.Busy"]
    plc.run("200ms")
    assert plc["power.Error"] and plc["power.ErrorID"] == 27 and not plc["power.Busy"]
    plc["ECAT.cut"] = False
    plc.scan(5)
    assert plc["power.Status"] and not plc["power.Error"]


def test_a_lost_drive_is_errorstop_until_reset(tmp_path):
    plc = load(tmp_path)
    plc.scan(5)
    give(plc, "move", Distance=1000.0)
    plc.run("50ms")
    plc["ECAT.Slave[0].wired"] = False
    plc.scan(2)
    assert plc["move.Error"] and plc["move.ErrorID"] == 3 and plc["X.nAxisState"] == ERRORSTOP
    assert plc["power.Error"] and plc["power.ErrorID"] == 3
    give(plc, "reset")
    plc.scan()
    assert plc["reset.ErrorID"] == 121  # SMC_R_DRIVE_DOESNT_ANSWER
    plc["ECAT.Slave[0].wired"] = True
    plc["reset.Execute"] = False
    plc.scan(2)
    give(plc, "reset")
    plc.scan(4)
    assert plc["power.Status"] and plc["X.nAxisState"] == STANDSTILL


def test_a_drive_that_somebody_else_switches_off_is_errorstop(tmp_path):
    plc = load(tmp_path)
    plc.scan(5)
    plc["got"] = -1
    plc.scan(2)
    assert plc["rtn"] == 0 and plc["X.nAxisState"] == ERRORSTOP and plc["power.ErrorID"] == 20
    give(plc, "reset")
    plc.scan(3)
    assert plc["power.Status"] and plc["X.nAxisState"] == STANDSTILL
    plc["on"] = False
    plc.scan(2)
    assert plc["X.nAxisState"] == POWER_OFF and not plc["power.Error"]


def test_home_by_the_drive_on_the_bus(tmp_path):
    """Method 23, the home switch from 100 to 120: home is its edge at 100."""
    plc = load(tmp_path)
    plc.scan(5)
    assert write(plc, 1, 0x6098, 0, 23) == 0
    assert write(plc, 4, 0x6099, 1, 500) == 0 and write(plc, 4, 0x6099, 2, 50) == 0
    assert write(plc, 4, 0x609A, 0, 5000) == 0
    assert plc["ECAT.Drive[3].home.method"] == 23 and plc["ECAT.Drive[3].home.fast"] == 0.5
    give(plc, "home")
    plc.scan(5)
    assert plc["X.nAxisState"] == HOMING and read(plc, 1, 0x6061) == 6
    plc.run_until("home.Done")
    plc.scan(3)
    assert plc["X.nAxisState"] == STANDSTILL and plc["info.IsHomed"] and read(plc, 1, 0x6061) == 8
    assert plc["X.fActPosition"] - 5.0 == pytest.approx(plc.axes[3].position - 100.0, abs=1e-6)
    assert read(plc, 4, 0x6064) == pytest.approx(plc.axes[3].position - 100.0, abs=0.5)
    before = plc["X.fActPosition"]
    give(plc, "move", Distance=50.0)
    plc.run_until("move.Done")
    assert plc["X.fActPosition"] == pytest.approx(before + 50.0)
    assert plc.warnings == []


def test_a_homing_whose_block_is_not_called_goes_on(tmp_path):
    plc = load(tmp_path)
    plc.scan(5)
    write(plc, 1, 0x6098, 0, 17)
    give(plc, "home")
    plc["away"] = True
    plc.run("5s")
    assert plc["X.nAxisState"] == STANDSTILL and plc["home.Busy"] and plc["info.IsHomed"]
    assert [(w.code, w.instance) for w in plc.warnings] == [("W0801", "PLC_PRG.home")]
    plc["away"] = False
    plc.scan()
    assert plc["home.Done"]


@pytest.mark.parametrize("toml", [AXIS, AXIS.replace("ethercat", "pulse")], ids=["bus", "pulse"])
def test_objects_by_their_number(tmp_path, toml):
    plc = load(tmp_path, toml)
    plc.scan(5)
    give(plc, "move", Distance=-300.0)
    plc.run_until("move.Done")
    plc.scan(2)
    assert read(plc, 4, 0x6064) == -300 and read(plc, 4, 0x607A) == -300
    assert int(read(plc, 2, 0x6041)) & 0x6F == 0x27  # operation enabled
    assert read(plc, 4, 0x6502) == 0x3AD
    assert write(plc, 4, 0x607C, 0, -20) == 0 and read(plc, 4, 0x607C) == -20
    assert write(plc, 4, 0x6065, 0, 500) == 0 and read(plc, 4, 0x6065) == 500
    assert read(plc, 2, 0x6064) == -131  # SMC_RP_REQUESTING_ERROR: it has four bytes
    assert read(plc, 4, 0x5999) == -130 and read(plc, 4, 0x6064, 3) == -130
    assert write(plc, 4, 0x6064, 0, 1) == 140  # SMC_WP_PARAM_INVALID: read only
    assert write(plc, 2, 0x6040, 0, 6) == 140  # the controller's own
    assert write(plc, 2, 0x6098, 0, 17) == 141  # SMC_WP_SENDING_ERROR: it has one byte
    assert write(plc, 1, 0x6098, 0, 200) == 143  # SMC_WP_PARAM_CONVERSION_ERROR
    assert write(plc, 1, 0x6098, 0, 99) == 140  # no such method
    assert write(plc, 4, 0x6099, 1, 0) == 140 and write(plc, 4, 0x6080, 0, 3e9) == 0


def test_parameters_by_their_number(tmp_path):
    """PLCopen's 1 to 17 and those that CODESYS numbers as members of AXIS_REF_SM3."""
    (tmp_path / "prog.st").write_text(PROGRAM)
    (tmp_path / "plc.toml").write_text("[project]\ninterval = '2ms'\n" + AXIS.replace("ethercat", "pulse"))
    plc = PLC.load(tmp_path / "plc.toml")
    plc.scan(5)
    plc["X.fSWLimitPositive"], plc["X.fSWMaxVelocity"], plc["X.wDriveId"] = 70.0, 500.0, 7
    give(plc, "move", Distance=40.0)
    plc.run_until("move.Done")
    plc.scan()
    values = {
        1: 40.0, 2: 70.0, 4: 0.0, 6: 0.0, 8: 500.0, 9: 500.0, 10: 0.0, 11: 0.0, 1000: 3.0, 1010: 1.0, 1012: 1.0,
        1013: 100.0, 1015: 1.0, 1021: 7.0, 1025: 0.002, 1030: 0.0, 1051: 1.0, 1054: 1.0, 1100: 40.0, 1101: 40.0,
    }  # fmt: skip
    for number, value in values.items():
        plc["read.ParameterNumber"] = number
        plc.scan()
        assert plc["read.Valid"] and plc["read.Value"] == value, number
    for number, error in ((999, 130), (18, 130), (0, 130)):
        plc["read.ParameterNumber"] = number
        plc.scan()
        assert plc["read.ErrorID"] == error
    for number, value, error in ((3, -70.0, 0), (1051, 2.0, 91), (1, 5.0, 140), (8, 5.0, 140), (17, 9e5, 0)):
        plc["write.Execute"] = False
        plc.scan()
        give(plc, "write", ParameterNumber=number, Value=value)
        assert plc["write.ErrorID"] == error, number
    assert plc["X.fSWLimitNegative"] == -70.0 and plc["X.fSWMaxJerk"] == 9e5


def test_axes_of_plc_toml(tmp_path):
    toml = """
[[axis]]
number = 2
name = "V"
kind = "virtual"
modulo = 360.0
[[axis]]
number = 4
name = "Shaft"
kind = "Logical"
"""
    text = """
PROGRAM PLC_PRG
VAR a, b, c : AXIS_REF_SM3; move : MC_MoveRelative; END_VAR
move(Axis := V); move(Axis := Shaft);
END_PROGRAM
"""
    plc = load(tmp_path, toml, text)
    plc.scan()
    assert [plc[f"{n}.axisNo"] for n in ("V", "Shaft", "a", "b", "c")] == [2, 4, 1, 3, 5]
    assert (plc["V.eAxisKind"], plc["Shaft.eAxisKind"], plc["a.eAxisKind"]) == (1, 2, 0)
    assert plc["Axes.V.fPositionPeriod"] == 360.0 and plc["V.iMovementType"] == 0
    assert "ECAT.SLAVE" not in plc.program.variables


@pytest.mark.parametrize(
    ("toml", "why"),
    [
        ('name = "X"\nkind = "ethercad"', "kind is one of .*did you mean ethercat"),
        ('kind = "pulse"', "needs a name"),
        ('name = "1st axis"\nkind = "pulse"', "needs a name"),
    ],
)
def test_a_wrong_kind(tmp_path, toml, why):
    with pytest.raises(UsageError, match=why):
        load(tmp_path, f"[[axis]]\n{toml}\n")


def test_one_input_is_seen_by_the_block_and_by_the_drive(tmp_path):
    text = PROGRAM.replace("got : DINT;", "got : DINT; probe : MC_TouchProbe; trigger : TRIGGER_REF;").replace(
        "reset(Axis := X);",
        "reset(Axis := X); probe(Axis := X, TriggerInput := trigger); rtn := GT_SetTouchProbeFunction(3, 16#11);",
    )
    plc = load(tmp_path, text=text)
    plc.scan(10)
    assert plc["rtn"] == 0 and read(plc, 2, 0x60B8) == 0x11  # probe 1, first rising edge
    plc["trigger.iTriggerNumber"] = 0
    give(plc, "probe")
    give(plc, "move", Distance=100.0)
    plc.scan(50)
    plc.axes[3].switches.probe1 = True
    at = plc["X.fActPosition"]
    plc.scan(2)
    assert plc["probe.Done"] and plc["probe.RecordedPosition"] == at
    assert read(plc, 4, 0x60BA) == int(at) and int(read(plc, 2, 0x60B9)) & 2


def test_what_the_process_data_carry_is_not_written_by_number(tmp_path):
    """The next cycle would overwrite it; 60B8h has parameter 10184, which writes into the process data."""
    plc = load(tmp_path)
    plc.scan(5)
    for length, index, sub in ((1, 0x6060, 0), (2, 0x6071, 0), (4, 0x60FF, 0), (2, 0x60B8, 0), (4, 0x60FE, 1)):
        assert write(plc, length, index, sub, 3) == 140, hex(index)
    assert read(plc, 1, 0x6061) == 8
    plc["write.Execute"] = False
    plc.scan()
    give(plc, "write", ParameterNumber=10184, Value=0x0511)
    assert plc["write.Done"]
    plc.scan(20)
    assert read(plc, 2, 0x60B8) == 0x0511
    plc["write.Execute"] = False
    plc.scan()
    give(plc, "write", ParameterNumber=10184, Value=65536)
    assert plc["write.ErrorID"] == 143 and read(plc, 2, 0x60B8) == 0x0511


def test_a_drive_that_maps_less_takes_more_by_number(tmp_path):
    plc = load(tmp_path, AXIS + "[ecat]\n[[ecat.slave]]\nkind = 'gthd'\naxis = 3\n")
    plc.scan(5)
    assert write(plc, 2, 0x60B8, 0, 0x11) == 0 and read(plc, 2, 0x60B8) == 0x11
    assert write(plc, 2, 0x6040, 0, 6) == 140

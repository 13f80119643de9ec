"""MC_ReadParameter and its kin beyond the plain numbers; axes that are only read."""

import pytest

from plcruntime import PLC

PROGRAM = """
PROGRAM P
VAR ax : AXIS_REF_SM3; power : MC_Power; on : BOOL := TRUE; number : DINT; value : LREAL; flag : BOOL;
    read : MC_ReadParameter; write : MC_WriteParameter; readBool : MC_ReadBoolParameter;
    writeBool : MC_WriteBoolParameter; setPosition : MC_SetPosition; END_VAR
power(Axis := ax, Enable := TRUE, bRegulatorOn := on, bDriveStart := TRUE);
read(Axis := ax, Enable := TRUE, ParameterNumber := number);
readBool(Axis := ax, Enable := TRUE, ParameterNumber := number);
write(Axis := ax, ParameterNumber := number, Value := value);
writeBool(Axis := ax, ParameterNumber := number, Value := flag); setPosition(Axis := ax, Position := value);
END_PROGRAM
"""
NAN = float("nan")


class Parameters:
    def __init__(self) -> None:
        self.plc = PLC.load(PROGRAM)
        self.plc.scan(5)

    def write(self, number: int, value: float | bool, block: str = "write") -> int:
        """The ErrorID of writing a parameter."""
        self.plc["P.number"] = number
        self.plc["P.flag" if block == "writeBool" else "P.value"] = value
        self.plc[f"P.{block}.Execute"] = True
        self.plc.scan(2)
        error = self.plc[f"P.{block}.ErrorID"]
        assert self.plc[f"P.{block}.Done"] == (error == 0)
        self.plc[f"P.{block}.Execute"] = False
        self.plc.scan()
        return error

    def read(self, number: int) -> float:
        self.plc["P.number"] = number
        self.plc.scan(2)
        assert self.plc["P.read.Valid"]
        return self.plc["P.read.Value"]


@pytest.fixture
def parameters():
    return Parameters()


@pytest.mark.parametrize("number", [9, 13, 15, 17])
def test_limits_are_positive_numbers(parameters, number):
    assert parameters.write(number, 500.0) == 0
    for value in (0.0, -5.0, NAN, float("inf")):
        assert parameters.write(number, value) == 143
    assert parameters.read(number) == 500.0


def test_scale_is_written_while_the_drive_is_off(parameters):
    assert parameters.write(1054, 2.0) == 91
    parameters.plc["P.on"] = False
    parameters.plc.scan(2)
    for number in (1051, 1052, 1054):
        assert parameters.write(number, 0.0) == 90
        assert parameters.write(number, NAN) == 143
        assert parameters.write(number, 2.0) == 0
        assert parameters.read(number) == 2.0


def test_lag_monitoring_is_switched(parameters):
    assert parameters.write(7, 50.0) == 0
    assert parameters.read(6) == 1.0
    assert parameters.write(6, False, "writeBool") == 0
    assert (parameters.read(6), parameters.read(7), parameters.plc["SIM.Axis[1].posErr"]) == (0.0, 50.0, 2147483647)
    assert parameters.write(6, True, "writeBool") == 0
    assert (parameters.read(6), parameters.plc["SIM.Axis[1].posErr"]) == (1.0, 50)


def test_10184_is_the_control_word_of_the_touch_probes(parameters):
    assert parameters.write(10184, 17.0) == 0
    assert parameters.read(10184) == parameters.read(-(2 * 2**24 + 0x60B8 * 2**8)) == 17.0


def test_a_position_that_is_no_number_is_not_set(parameters):
    assert parameters.write(0, NAN, "setPosition") == 12
    assert parameters.plc["P.ax.fSetPosition"] == 0.0


def test_axes_that_are_only_read():
    plc = PLC.load("""
    PROGRAM P
    VAR ax : AXIS_REF_SM3; status : MC_ReadStatus; where : MC_ReadActualPosition; fault : MC_ReadAxisError; END_VAR
    status(Axis := ax, Enable := TRUE); where(Axis := ax, Enable := TRUE); fault(Axis := ax, Enable := TRUE);
    END_PROGRAM
    """)
    plc.scan()
    assert plc["P.status.Valid"] and plc["P.status.Disabled"] and plc["P.where.Valid"] and plc["P.fault.Valid"]
    assert not plc["P.status.Error"] and plc["P.ax.nAxisState"] == 0 and plc.axes[1].position == 0.0

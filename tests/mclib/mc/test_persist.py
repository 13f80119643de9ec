"""The three blocks of persistent positions, over a power cycle."""

import pytest
from one_axis import until

from plcruntime import PLC

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

"""Names as the tables of the AM600 manual print them, beside those of its templates: one warning each."""

import pytest

import mclib
import stcore
from stcore.source import Source

PROGRAM = """
PROGRAM PLC_PRG
VAR
    ax : AXIS_REF; a : BOOL; move : MC_MoveAbsolute; probe : MC_TouchProbe; trigger : TRIGGER_REF;
    status : MC_ReadStatus; jog : MC_Jog; home : SMC_Homing; error : SMC_ERROR; mode : SMC_HOMING_MODE;
    keep : SMC3_PersistPositionSingleturn; data : SMC3_PersistPositionSingleturn_Data;
    %s
END_VAR
%s
END_PROGRAM
"""
PRINTED = [
    ("", "move(Axis := ax, CommandAbort => a);", "CommandAborted"),
    ("", "a := move.CommandAbort;", "CommandAborted"),
    ("", "probe(Axis := ax, TruggerInput := trigger);", "TriggerInput"),
    ("", "status(Axis := ax, Stoping => a);", "Stopping"),
    ("", "status(Axis := ax); a := status.Dccelerating;", "Decelerating"),
    ("", "keep(Axis := ax, PersistentData := data, bPositionRestroed => a);", "bPositionRestored"),
    ("", "keep(Axis := ax, PersistentData := data, usiNumberofAbsoluteBites := 20);", "usiNumberOfAbsoluteBits"),
    ("t : TRIIGGER_REF;", "probe(Axis := ax, TriggerInput := t);", "TRIGGER_REF"),
    ("m : SMC_HOMING_MOD;", "home(Axis := ax, nHomingMode := m);", "SMC_HOMING_MODE"),
    # both are right
    ("", "jog(Axis := ax, ErrorId => error);", None),
    ("", "home(Axis := ax, bReturnTozero := TRUE, Error => a, ErrorID => error);", None),
    ("", "home(Axis := ax, bError => a, nErrorID => error); a := home.Error; error := home.ErrorID;", None),
    ("o : MC_MoveSuperimposed; d : SMC3_PersistPositionSingleTurn_Data;", "o(Axis := ax);", None),
]


@pytest.mark.parametrize(("declaration", "statement", "meant"), PRINTED)
def test_printed_names(declaration, statement, meant):
    source = Source(PROGRAM % (declaration, statement), "printed.st")
    found = stcore.diagnose([source], libraries=mclib.libraries())
    assert [d.code for d in found] == (["W0130"] if meant else [])
    assert not meant or f"read as {meant}" in found[0].message

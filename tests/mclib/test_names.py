"""MC_HOME is a constant of the GT_ functions, MC_Home a block: IEC names don't tell them apart, their use does."""

import pytest

from plcruntime import PLC

BLOCK = "ax : AXIS_REF; home : MC_Home;"


@pytest.mark.parametrize(
    ("declared", "statements"),
    [
        ("", "a := MC_HOME;"),
        ("", "b := MC_ALARM; a := MC_HOME;"),
        (BLOCK, "a := MC_HOME; home(Axis := ax);"),
        (BLOCK, "b := MC_ALARM; home(Axis := ax, Execute := TRUE); a := mc_home;"),
    ],
)
def test_a_value_is_the_constant_and_a_type_the_block(declared, statements):
    plc = PLC.load(f"PROGRAM P VAR a, b : INT; {declared} END_VAR {statements} END_PROGRAM")
    plc.scan()
    assert plc["P.a"] == 3
    if declared:
        assert plc["P.home.Busy"] is False


def test_a_printed_template_calls_the_block(tmp_path):
    text = "MC_Home (\n    Axis:= Axis,\n    Execute:= ,\n    Position:= ,\n    Done=> );"
    assert PLC.load(text).program

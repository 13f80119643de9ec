"""Return values, configuration, status word and Jog of the iDEABOX 3 manual as printed.

Examples 3-1, 4-2, 4-3, 6-1, 7-2, the call in 7.5.2, and the C declarations of chapter 13."""

import re
from pathlib import Path

import pytest

from plcruntime import PLC

LISTINGS = Path(__file__).parents[3] / "shared/manuals/listings/ideabox3"
pytestmark = pytest.mark.skipif(not LISTINGS.is_dir(), reason="the manuals' listings are not beside this checkout")


def load(name: str) -> PLC:
    return PLC.load(LISTINGS / name, interval="1ms")


def test_3_1_reads_the_status_and_checks_what_is_returned():
    plc = load("02_check_return_value.st")
    plc.axes[1].status = 0xA62
    plc.scan()
    assert plc["PLC_PRG.sts"] == 0xA62 and plc["PLC_PRG.rtn"] == 0


def test_a_listing_alone_has_the_librarys_commandhandler():
    text = (LISTINGS / "02_check_return_value.st").read_text(encoding="utf-8").replace("(1,1,", "(1,13,")
    plc = PLC.load(text)
    plc.scan()
    assert plc["PLC_PRG.rtn"] == 7 and plc["GtErrorText.text"] == "GT_GetSts = 7"


def test_4_2_limits_off_from_the_next_clearing_on():
    plc = load("04_lmts_off.st")
    plc.scan()
    axis = plc.axes[1]
    assert plc["PLC_PRG.rtn"] == 0 and axis.positiveOff and axis.negativeOff and not axis.positiveMute
    assert not plc.axes[2].positiveOff


def test_4_3_initialisation():
    """Alarm and limits have no effect on axis 1 any more, its servo is on; the other axes are as after GT_Reset."""
    plc = load("05_init_config.st")
    axis = plc.axes[1]
    axis.drive.alarm = axis.switches.positive = axis.switches.negative = True
    plc.scan()
    assert plc["PLC_PRG.rtn"] == 0 and plc["SIM.refusals"] == 0
    assert axis.status == 1 << 9 and axis.drive.enabled
    assert not plc.axes[2].alarmMute and not plc.axes[2].drive.enabled


FLAGS = {1: "Alarm", 4: "MError", 5: "PosLimit", 6: "NegLimit", 7: "SmoothStop", 8: "AbruptStop", 9: "ServoOn",
         10: "Motion"}  # fmt: skip


@pytest.mark.parametrize("bit", range(32))
def test_6_1_flags_are_the_bits_of_table_6_2(status_program, bit):
    status_program.axes[1].status = 1 << bit
    status_program.scan()
    shown = {name for name in FLAGS.values() if status_program[f"PLC_PRG.bFlag{name}"]}
    assert shown == ({FLAGS[bit]} if bit in FLAGS else set())


@pytest.mark.parametrize(
    ("mode", "text"),
    list(enumerate(["Trap", "Jog", "PT", "Gear", "Follow", "Interpolation", "PVT"])),
)
def test_6_1_modes(status_program, mode, text):
    status_program.axes[1].mode = mode
    status_program.scan()
    assert status_program["PLC_PRG.diPrfMode"] == mode and status_program["PLC_PRG.sPrfMode"] == text


@pytest.fixture(scope="module")
def status_program() -> PLC:
    return load("13_axis_status.st")


def test_7_2_jog_changes_its_velocity_on_the_way():
    """To 100 pulse/ms in 1600 ms and 80000 pulses; beyond 100000 pulses to 50 pulse/ms, in 800 ms and 60000 pulses."""
    plc = load("15_jog_move.st")
    plc.scan(10)
    plc["PLC_PRG.xStart"] = True
    names = ("SIM.Axis[1].prfPos", "SIM.Axis[1].prfVel", "PLC_PRG.lrPrfPos", "PLC_PRG.lrPrfVel")
    trace = plc.trace(*names)
    plc.run_until("PLC_PRG.lrPrfPos > 100000", "3s")
    changed = plc.scans - 10  # the operator sees it and sets xUpdate
    plc["PLC_PRG.xUpdate"] = True
    plc.run("3s")
    pos, vel, seen_pos, seen_vel = ([float(x) for x in trace[n]] for n in names)
    assert seen_pos[1:] == pos[:-1] and seen_vel[1:] == vel[:-1]  # the program reads what the scan before has brought
    assert vel[1599] == 100.0 and pos[1599] == pytest.approx(80000.0) and vel[1598] < 100.0
    assert pos[changed - 1] == 100200.0  # the program saw 100100
    assert vel[changed + 798] > 50.0 and set(vel[changed + 799 :]) == {50.0}
    assert pos[changed + 799] - pos[changed - 1] == pytest.approx(60000.0)
    steps = [b - a for a, b in zip(vel, vel[1:], strict=False)]
    assert max(steps) == pytest.approx(0.0625) and min(steps) == pytest.approx(-0.0625)
    assert plc["PLC_PRG.dwAxisStatus"] == 1 << 9 | 1 << 10 and plc["SIM.refusals"] == 0


def test_the_call_of_7_5_2_sets_the_ratio():
    call = (LISTINGS / "18_set_gear_ratio_call.st").read_text(encoding="utf-8").strip()
    plc = PLC.load(f"""
PROGRAM PLC_PRG
VAR rtn, slave : INT := 2; alpha : DINT := 4; beta : DINT := 3; slope : DINT := 1000; a, b, c : DINT; END_VAR
rtn := GT_PrfGear(slave, 0);
rtn := rtn + {call}
rtn := rtn + GT_GetGearRatio(slave, ADR(a), ADR(b), ADR(c));
END_PROGRAM""")
    plc.scan()
    assert plc["PLC_PRG.rtn"] == 0 and [plc[f"PLC_PRG.{n}"] for n in "abc"] == [4, 3, 1000]


TYPES = {"short": "INT", "double": "LREAL", "char *": "POINTER TO STRING(80)", "short *": "POINTER TO INT"}


@pytest.mark.parametrize(
    "name", ["46_type_compileinfo.c", "47_type_threadsts.c", "48_type_jogprm.c", "49_type_trapprm.c"]
)
def test_structures_have_the_members_of_their_c_declarations(name):
    text = (LISTINGS / name).read_text(encoding="utf-8")
    members = [f"{n}: {TYPES[t + p]}" for t, p, n in re.findall(r"(char|short|double)( \*)?\s*(\w+);", text)]
    structure = re.search(r"}\s*(\w+)", text)[1]
    plc = PLC.load(f"PROGRAM P VAR x : {structure}; END_VAR x := x; END_PROGRAM")
    assert [f"{m.name}: {m.type}" for m in plc.place("P.x").type.members.values()] == members

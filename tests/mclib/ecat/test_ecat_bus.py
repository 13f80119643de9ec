"""The EtherCAT bus: communication, process data, IO slaves, SDO, drive modes. Homing and probes have their files."""

import pytest

from plcruntime import PLC

ENABLED, ALARM = 1 << 9, 1 << 1


# ------------------------------------------------------------------------------------------- communication


def test_the_bus_without_configuration(bus):
    assert bus("GT_IsEcatReady(ADR(i))") == 0 and bus["i"] == 1
    assert bus("GT_GetEcatSlaves(ADR(i))") == 0 and bus["i"] == 17
    assert bus("GT_GetMcEcatAxisNum(ADR(i))") == 0 and bus["i"] == 12
    assert bus.plc["ECAT.size"] == 24 + 4 * 4 + 12 * 64


def test_null_pointers_are_parameter_errors(bus):
    for call in (
        "GT_IsEcatReady(0)", "GT_GetEcatSlaves(0)", "GT_GetMcEcatAxisNum(0)", "GT_GetEcatAxisAI(1, 1, 0)",
        "GT_GetEcatAxisAtlCurrent(1, 0)", "GT_GetEcatAxisAtlTorque(1, 0)", "GT_GetEcatAxisDI(1, 0)",
        "GT_GetEcatAxisDO(1, 0)", "GT_GetEcatAxisMode(1, 0)", "GT_GetEcatAxisPE(1, 0)", "GT_GetEcatEncPos(1, 0)",
        "GT_GetEcatEncVel(1, 0)", "GT_GetEcatHomingStatus(1, 0)", "GT_GetPosScale(1, 0)",
        "GT_GetEcatRawData(0, 1, 0)", "GT_SetEcatRawData(0, 1, 0)", "GT_EcatIOReadInput(0, 0, 1, 0)",
        "GT_EcatIOWriteOutput(0, 0, 1, 0)", "GT_EcatSDODownload(5, 16#6060, 0, 0, 1, ADR(abort))",
        "GT_EcatSDODownload(5, 16#6060, 0, ADR(i), 1, 0)", "GT_EcatSDOUpLoad(5, 16#6060, 0, 0, 1, ADR(n), ADR(abort))",
        "GT_GetTouchProbeStatus(1, ADR(u), 0, 0, 0, 0)",
    ):  # fmt: skip
        assert bus(call) == 7, call


@pytest.mark.parametrize("axis", [0, 13, -1])
def test_axis_numbers(bus, axis):
    for call in (
        "GT_GetEcatAxisAI({}, 1, ADR(i))", "GT_GetEcatAxisAtlCurrent({}, ADR(i))", "GT_GetEcatAxisMode({}, ADR(i))",
        "GT_GetEcatAxisDI({}, ADR(n))", "GT_GetEcatAxisPE({}, ADR(x))", "GT_SetEcatAxisMode({}, 8)",
        "GT_SetEcatAxisPT({}, 0)", "GT_SetEcatAxisPV({}, 0)", "GT_SetEcatAxisDO({}, 0)", "GT_SetHomingMode({}, 6)",
        "GT_StartEcatHoming({})", "GT_StopEcatHoming({})", "GT_SetEcatHomingPrm({}, 35, 1, 1, 1, 0, 0)",
        "GT_SetPosScale({}, 0)", "GT_GetPosScale({}, ADR(u))", "GT_SetTouchProbeFunction({}, 0)",
        "GT_SetTouchProbeFunctionEx({}, 0, 0, 0, 0, 0, 0)", "GT_GetEcatHomingStatus({}, ADR(i))",
    ):  # fmt: skip
        assert bus(call.format(axis)) == 7, call


def test_broken_and_restored(bus):
    bus.power()
    bus.jog(5)
    bus.scan(20)
    assert bus.axis.velocity == 5.0
    bus.plc["ECAT.cut"] = True
    assert bus("GT_IsEcatReady(ADR(i))") == 0 and bus["i"] == 0
    stood = bus.axis.position
    bus.scan(10)
    assert bus.axis.position == stood and bus.axis.velocity == 0.0
    assert bus("GT_GetSts(1, ADR(x))") == 0 and bus["x"] & (ENABLED | ALARM) == ALARM
    assert bus("GT_GetEcatSlaves(ADR(i))") == 0 and bus["i"] == 0
    assert bus("GT_GetEcatEncPos(1, ADR(x))") == 1 and "does not answer" in bus.why
    assert bus("GT_GetEcatRawData(0, 2, ADR(u))") == 1
    assert bus("GT_EcatIOReadInput(0, 14, 2, ADR(u))") == 1
    assert bus("GT_EcatSDOUpLoad(5, 16#6041, 0, ADR(u), 2, ADR(n), ADR(abort))") == 1 and bus["abort"] == 0x05040000
    assert bus("GT_AxisOn(1)") == 1 and "EtherCAT" in bus.why
    bus.plc["ECAT.cut"] = False
    assert bus("GT_IsEcatReady(ADR(i))") == 0 and bus["i"] == 1
    assert bus("GT_ClrSts(1)") == 0 and bus("GT_AxisOn(1)") == 0
    bus.jog(5)
    bus.scan(20)
    assert bus.axis.velocity == 5.0 and bus.axis.position > stood


def test_a_lost_slave_takes_those_behind_it_along(bus):
    bus.plc["ECAT.Slave[7].wired"] = False
    assert bus("GT_GetEcatSlaves(ADR(i))") == 0 and bus["i"] == 7
    assert bus("GT_GetEcatAxisMode(2, ADR(i))") == 0 and bus["i"] == 8
    assert bus("GT_GetEcatAxisMode(3, ADR(i))") == 1
    assert bus("GT_EcatIOReadInput(0, 14, 2, ADR(u))") == 0
    assert bus("GT_EcatIOReadInput(8, 0, 2, ADR(u))") == 1
    assert bus("GT_EcatIOReadInput(17, 0, 2, ADR(u))") == 1


def test_init_start_terminate(bus):
    assert bus("GT_InitEcatComm()") == 0 and bus("GT_StartEcatComm()") == 0  # needless, harmless
    bus.power()
    assert bus("GT_TerminateEcatComm()") == 0
    assert bus("GT_TerminateEcatComm()") == 1
    assert bus("GT_IsEcatReady(ADR(i))") == 0 and bus["i"] == 0
    assert bus("GT_StartEcatComm()") == 1
    assert bus("GT_AxisOn(1)") == 1
    bus.plc["ECAT.cut"] = True
    assert bus("GT_InitEcatComm()") == -10
    bus.plc["ECAT.cut"] = False
    bus.plc["ECAT.Slave[16].wired"] = False
    assert bus("GT_InitEcatComm()") == -8
    bus.plc["ECAT.Slave[16].wired"] = True
    assert bus("GT_InitEcatComm()") == 0
    assert bus("GT_IsEcatReady(ADR(i))") == 0 and bus["i"] == 1
    assert bus("GT_AxisOn(1)") == 1  # GT_StartEcatComm first
    assert bus("GT_StartEcatComm()") == 0
    assert bus("GT_ClrSts(1)") == 0 and bus("GT_AxisOn(1)") == 0


# ------------------------------------------------------------------------------------------- data


def test_raw_data_stay_in_range_and_off_the_inputs(bus):
    size = bus.plc["ECAT.size"]
    assert bus(f"GT_GetEcatRawData({size - 2}, 2, ADR(u))") == 0
    assert bus(f"GT_GetEcatRawData({size - 1}, 2, ADR(u))") == 7
    assert bus("GT_GetEcatRawData(0, 0, ADR(u))") == 7
    assert bus("GT_GetEcatRawData(65535, 65535, ADR(u))") == 7
    bus.plc["ECAT.image[34]"] = 0x12
    bus["n"] = 0x44332211
    assert bus("GT_SetEcatRawData(32, 4, ADR(n))") == 0  # two bytes of outputs, two of inputs
    assert [bus.plc[f"ECAT.image[{k}]"] for k in range(32, 36)] == [0x11, 0x22, 0x12, 0]
    assert bus("GT_GetEcatRawData(32, 4, ADR(n))") == 0 and bus["n"] == 0x00122211


@pytest.mark.parametrize("function", ["Get", "Set", "Read", "Write"])
def test_data_stay_in_the_array_that_the_pointer_leads_to(bus, function):
    words = [0x11223344, 2, 3, 4]
    call = {
        "Get": "GT_GetEcatRawData(0, {}, ADR({}))", "Set": "GT_SetEcatRawData(0, {}, ADR({}))",
        "Read": "GT_EcatIOReadInput(0, 0, {}, ADR({}))", "Write": "GT_EcatIOWriteOutput(0, 0, {}, ADR({}))",
    }[function]  # fmt: skip
    bus["d"] = words
    assert bus(call.format(17, "d")) == 7
    assert "variable" in bus.why or function == "Write"  # it has 12 bytes of outputs
    assert bus(call.format(9, "d[2]")) == 7 and "variable" in bus.why
    assert bus["d"] == words and bus.plc["ECAT.image"][:24] == [0] * 24
    assert bus(call.format(8, "d[2]")) == 0
    if function in ("Get", "Read"):
        assert bus["d"] == [*words[:2], 0, 0]
    else:
        assert bus["d"] == words and bus.plc["ECAT.image"][:8] == [3, 0, 0, 0, 4, 0, 0, 0]


def test_objects_stay_in_the_array_that_the_pointer_leads_to(bus):
    bus["d"] = [1, 2, 3, 4]
    assert bus("GT_EcatSDOUpLoad(5, 16#607A, 0, ADR(d), 17, ADR(got), ADR(abort))") == 7 and "variable" in bus.why
    assert bus("GT_EcatSDOUpLoad(5, 16#607A, 0, ADR(d[3]), 5, ADR(got), ADR(abort))") == 7
    assert bus["d"] == [1, 2, 3, 4]
    assert bus("GT_EcatSDOUpLoad(5, 16#607A, 0, ADR(d[3]), 4, ADR(got), ADR(abort))") == 0
    assert bus["got"] == 4 and bus["d"][:3] == [1, 2, 3]
    bus["abort"] = 1
    assert bus("GT_EcatSDODownload(5, 16#6081, 0, ADR(d[3]), 5, ADR(abort))") == 7 and bus["abort"] == 1
    assert bus("GT_EcatSDODownload(5, 16#6081, 0, ADR(d[2]), 4, ADR(abort))") == 0 and bus["abort"] == 0


def test_io_of_a_slave(bus):
    bus["u"] = 0xBEEF
    assert bus("GT_EcatIOWriteOutput(0, 2, 2, ADR(u))") == 0
    assert (bus.plc["ECAT.image[2]"], bus.plc["ECAT.image[3]"]) == (0xEF, 0xBE)
    assert bus("GT_EcatIOWriteOutput(0, 11, 2, ADR(u))") == 7  # reaches into the inputs
    assert bus("GT_EcatIOReadInput(0, 23, 2, ADR(u))") == 7
    assert bus("GT_EcatIOReadInput(0, 0, 0, ADR(u))") == 7
    bus.plc["ECAT.image[26]"] = 0x5A  # input of slave 1, which begins at 24
    assert bus("GT_EcatIOReadInput(1, 2, 1, ADR(u))") == 0 and bus["u"] & 0xFF == 0x5A


def test_sdo(bus):
    def up(slave, index, sub, size=4):
        bus["n"] = 0
        rtn = bus(f"GT_EcatSDOUpLoad({slave}, 16#{index:X}, {sub}, ADR(n), {size}, ADR(got), ADR(abort))")
        return rtn, bus["n"], bus["got"], bus["abort"]

    def down(slave, index, sub, value, size):
        bus["n"] = value & 0xFFFFFFFF
        rtn = bus(f"GT_EcatSDODownload({slave}, 16#{index:X}, {sub}, ADR(n), {size}, ADR(abort))")
        return rtn, bus["abort"]

    assert up(5, 0x1000, 0) == (0, 0x00020192, 4, 0)
    assert up(0, 0x1000, 0) == (0, 0x00001389, 4, 0)
    assert up(5, 0x1018, 0) == (0, 4, 1, 0) and up(5, 0x1018, 4) == (0, 6, 4, 0)
    assert bus("GT_EcatSDOUpLoad(5, 16#1008, 0, ADR(d), 6, ADR(got), ADR(abort))") == 0 and bus["got"] == 6
    assert up(5, 0x1000, 0, 5)[0] == 7  # n has four bytes
    assert up(5, 0x6502, 0) == (0, 0x3AD, 4, 0)
    assert up(5, 0x6061, 0) == (0, 8, 1, 0)
    assert down(5, 0x6099, 1, 20000, 4) == (0, 0) and up(5, 0x6099, 1) == (0, 20000, 4, 0)
    assert up(5, 0x6099, 0) == (0, 2, 1, 0)
    assert down(5, 0x607C, 0, -5, 4) == (0, 0) and up(5, 0x607C, 0) == (0, 0xFFFFFFFB, 4, 0)
    assert down(5, 0x6098, 0, 3, 1) == (0, 0) and up(5, 0x6098, 0) == (0, 3, 1, 0)
    assert down(5, 0x6083, 0, 250000, 4) == (0, 0) and bus.plc["ECAT.Drive[1].profileAcc"] == 0.25
    assert down(5, 0x6098, 0, 15, 1) == (1, 0x06090030)  # a method that the drive does not have
    assert down(5, 0x609A, 0, 0, 4) == (1, 0x06090032)
    assert down(5, 0x6041, 0, 0, 2) == (1, 0x06010002)
    assert down(5, 0x6071, 0, 0, 4) == (1, 0x06070012)
    assert down(5, 0x607C, 0, 0, 2) == (1, 0x06070013) and "607Ch" in bus.why
    assert up(5, 0x5FFF, 0)[3] == 0x06020000 and up(5, 0x6099, 3)[3] == 0x06090011
    assert up(0, 0x6041, 0)[3] == 0x06020000  # the coupler is no drive
    assert up(5, 0x6064, 0, 2)[0] == 7  # the target is too small
    assert up(17, 0x6064, 0)[0] == 7
    assert down(0, 0x7010, 1, 0x1234, 2) == (0, 0) and bus.plc["ECAT.image[2]"] == 0x34
    bus.plc["ECAT.image[14]"] = 0x77
    assert up(0, 0x6000, 1, 2)[:3] == (0, 0x77, 2) and down(0, 0x6000, 1, 1, 2) == (1, 0x06010002)


def test_a_mapped_object_written_by_sdo_is_overwritten_by_the_process_data(bus):
    bus["n"] = 9
    assert bus("GT_EcatSDODownload(5, 16#6060, 0, ADR(n), 1, ADR(abort))") == 0
    bus.scan()
    assert bus("GT_GetEcatAxisMode(1, ADR(i))") == 0 and bus["i"] == 8


# ------------------------------------------------------------------------------------------- drives


def test_analogue_and_digital_signals(bus):
    bus.plc["ECAT.Drive[1].ai1"], bus.plc["ECAT.Drive[1].ai2"] = -1234, 567
    bus.plc["ECAT.Drive[1].inputs"] = 0xABCD1234
    bus.axis.switches.home = bus.axis.switches.negative = True
    bus.scan()
    assert bus("GT_GetEcatAxisAI(1, 1, ADR(i))") == 0 and bus["i"] == -1234
    assert bus("GT_GetEcatAxisAI(1, 2, ADR(i))") == 0 and bus["i"] == 567
    assert bus("GT_GetEcatAxisAI(1, 3, ADR(i))") == 7 and bus("GT_GetEcatAxisAI(1, 0, ADR(i))") == 7
    assert bus("GT_GetEcatAxisDI(1, ADR(n))") == 0 and bus["n"] == 0xABCD0005
    assert bus("GT_SetEcatAxisDO(1, 16#80000001)") == 0
    assert bus("GT_GetEcatAxisDO(1, ADR(n))") == 0 and bus["n"] == 0x80000001
    bus.scan()
    assert bus.plc["ECAT.Drive[1].outputs"] == 0x80000001


def test_position_velocity_and_following_error_in_increments(bus):
    assert bus("GT_SetPosScale(1, 32)") == 7
    assert bus("GT_SetPosScale(1, 6)") == 0 and bus("GT_GetPosScale(1, ADR(u))") == 0 and bus["u"] == 6
    bus.axis.drive.lag = 4.0
    bus.power()
    bus.jog(10)
    assert bus("GT_SetPosScale(1, 5)") == 1  # in motion
    bus.scan(200)
    assert bus("GT_GetEcatEncVel(1, ADR(x))") == 0 and bus["x"] == 10 * 64 * 1000
    assert bus("GT_GetEcatAxisPE(1, ADR(x))") == 0 and bus["x"] == 4 * 10 * 64
    before = bus.axis.position
    assert bus("GT_GetEcatEncPos(1, ADR(x))") == 0 and bus["x"] == pytest.approx(before * 64, abs=1)


def test_scale_6_makes_17_bits_of_a_23_bit_encoder(bus):
    """13 command 117."""
    assert bus("GT_SetPosScale(1, 6)") == 0
    bus.power()
    bus["trap"] = {"acc": 50.0, "dec": 50.0, "velStart": 0.0, "smoothTime": 0}
    for call in ("GT_PrfTrap(1)", "GT_SetTrapPrm(1, ADR(trap))", f"GT_SetPos(1, {2**17})", "GT_SetVel(1, 1000)"):
        assert bus(call) == 0, call
    assert bus("GT_Update(1)") == 0
    bus.scan(200)
    assert bus("GT_GetEcatEncPos(1, ADR(x))") == 0 and bus["x"] == 2**23


def test_torque_is_acceleration_times_inertia_and_the_load(bus):
    bus.axis.drive.inertia = 200.0
    bus.plc["ECAT.Drive[1].load"] = 30.0
    bus.power()
    bus.jog(10, acc=0.5)
    bus.scan(5)
    assert bus("GT_GetEcatAxisAtlTorque(1, ADR(i))") == 0 and bus["i"] == 130
    assert bus("GT_GetEcatAxisAtlCurrent(1, ADR(i))") == 0 and bus["i"] == 130
    bus.scan(50)
    assert bus("GT_GetEcatAxisAtlTorque(1, ADR(i))") == 0 and bus["i"] == 30


def test_cyclic_velocity(bus):
    bus.power()
    for mode in (-1, 2, 5, 7, 11):  # the list of 13 command 100; 7 is read only (command 39)
        assert bus(f"GT_SetEcatAxisMode(1, {mode})") == 7, mode
    for mode in (0, 1, 3, 4, 6, 8, 10, 9):
        assert bus(f"GT_SetEcatAxisMode(1, {mode})") == 0, mode
    bus.scan()
    assert bus("GT_GetEcatAxisMode(1, ADR(i))") == 0 and bus["i"] == 9
    before = bus.axis.position
    assert bus("GT_SetEcatAxisPV(1, -3000)") == 0  # increments/s
    bus.scan(9)
    assert bus.axis.velocity == -3.0 and bus.axis.position == pytest.approx(before - 30.0)
    assert bus("GT_SetEcatAxisMode(1, 8)") == 0
    bus.scan()
    assert bus.axis.velocity == 0.0 and bus.axis.prfPos == bus.axis.encPos == bus.axis.position
    bus.jog(1)
    bus.scan(100)
    assert bus.axis.velocity == 1.0 and bus.axis.position == pytest.approx(bus.axis.prfPos)


def test_profile_velocity_ramps(bus):
    bus.power()
    assert bus("GT_SetEcatAxisMode(1, 3)") == 0
    bus.plc["ECAT.Drive[1].profileAcc"], bus.plc["ECAT.Drive[1].profileDec"] = 0.5, 0.25
    bus.scan()
    before = bus.axis.position
    assert bus("GT_SetEcatAxisPV(1, 10000)") == 0
    bus.scan(19)
    assert bus.axis.velocity == pytest.approx(10.0) and bus.axis.position - before == pytest.approx(100.0)
    assert bus("GT_SetEcatAxisPV(1, -5000)") == 0  # 40 ms down, 10 ms up
    bus.scan(39)
    assert bus.axis.velocity == pytest.approx(0.0, abs=1e-9)
    assert bus.axis.position - before == pytest.approx(300.0)
    bus.scan(10)
    assert bus.axis.velocity == pytest.approx(-5.0) and bus.axis.position - before == pytest.approx(275.0)


@pytest.mark.parametrize("mode", [4, 10])
def test_torque_modes(bus, mode):
    bus.axis.drive.inertia = 100.0
    bus.plc["ECAT.Drive[1].load"] = 20.0
    bus.plc["ECAT.Drive[1].maxVel"] = 8.0
    bus.power()
    assert bus("GT_SetEcatAxisPT(1, 70)") == 0
    bus.scan()
    assert bus(f"GT_SetEcatAxisMode(1, {mode})") == 0  # 0.5 pulse/ms2 from this scan on
    bus.scan(9)
    assert bus.axis.velocity == pytest.approx(5.0) and bus.axis.position == pytest.approx(25.0)
    bus.scan(10)
    assert bus.axis.velocity == 8.0 and bus.axis.position == pytest.approx(64.0 + 8.0 * 4)
    assert bus("GT_AxisOff(1)") == 0
    bus.scan()
    assert bus.axis.velocity == 0.0


def test_profile_position_by_raw_data(bus):
    """The control word of axis 1 is at byte 40, its target position at 42 on the bus without configuration."""
    bus.power()
    for name, value in (("profileVel", 10.0), ("profileAcc", 1.0), ("profileDec", 0.5)):
        bus.plc[f"ECAT.Drive[1].{name}"] = value
    assert bus("GT_SetEcatAxisMode(1, 1)") == 0
    bus.scan()
    assert bus("GT_GetEcatRawData(59, 2, ADR(u))") == 0 and bus["u"] & 0x1637 == 0x0637 & 0x1637
    bus["n"] = 1000
    assert bus("GT_SetEcatRawData(42, 4, ADR(n))") == 0
    bus["n"] = 0x1F
    assert bus("GT_SetEcatRawData(40, 2, ADR(n))") == 0  # moves from this scan on: 10 + 85 + 20 ms
    bus.scan(9)
    assert bus.axis.velocity == 10.0 and bus.axis.position == pytest.approx(50.0)
    assert bus("GT_GetEcatRawData(59, 2, ADR(u))") == 0 and bus["u"] & 0x1400 == 0x1000  # acknowledged, not there
    bus.scan(104)
    assert bus.axis.position == 1000.0 and bus.axis.velocity == 0.0
    assert bus("GT_GetEcatRawData(59, 2, ADR(u))") == 0 and bus["u"] & 0x0400
    bus["n"] = 0x0F
    assert bus("GT_SetEcatRawData(40, 2, ADR(n))") == 0
    bus["n"] = 100
    assert bus("GT_SetEcatRawData(42, 4, ADR(n))") == 0
    bus["n"] = 0x5F  # relative
    assert bus("GT_SetEcatRawData(40, 2, ADR(n))") == 0
    bus.scan(10)
    bus["n"] = 0x11F  # halt
    assert bus("GT_SetEcatRawData(40, 2, ADR(n))") == 0
    bus.scan(40)
    assert bus.axis.velocity == 0.0 and 1000.0 < bus.axis.position


def test_the_control_word_belongs_to_the_controller(bus):
    bus.power()
    bus["n"] = 0
    assert bus("GT_SetEcatRawData(40, 2, ADR(n))") == 0
    bus.scan()
    assert bus.plc["ECAT.image[40]"] == 0x0F and bus.axis.drive.enabled


def test_status_word(bus):
    def word():
        assert bus("GT_GetEcatRawData(59, 2, ADR(u))") == 0
        return bus["u"]

    assert word() == 0x0250  # switch-on disabled
    bus.power()
    bus.scan()
    assert word() == 0x1237  # operation enabled, follows the target
    bus.axis.switches.positive = True
    bus.scan()
    assert word() == 0x1A37
    bus.axis.drive.alarm = True
    bus.scan(2)
    assert word() & 0x6F == 0x08  # fault
    assert bus("GT_EcatSDOUpLoad(5, 16#603F, 0, ADR(u), 2, ADR(n), ADR(abort))") == 0 and bus["u"] == 0x5441


def test_reset_brings_back_cyclic_position(bus):
    bus.power()
    assert bus("GT_SetEcatAxisMode(1, 9)") == 0 and bus("GT_SetEcatAxisPV(1, 5000)") == 0
    bus.scan(5)
    assert bus("GT_Reset()") == 0
    bus.scan()
    assert bus("GT_GetEcatAxisMode(1, ADR(i))") == 0 and bus["i"] == 8
    bus.power()
    bus.scan(5)
    assert bus.axis.velocity == 0.0 and not bus.axis.moving


def test_a_reset_in_the_same_scan_does_not_undo_what_follows_it():
    plc = PLC.load(
        "PROGRAM PLC_PRG VAR done : BOOL; rtn : INT; END_VAR\n"
        "IF NOT done THEN rtn := GT_Reset(); rtn := GT_AxisOn(1); rtn := GT_SetHomingMode(1, 6); done := TRUE; END_IF\n"
        "END_PROGRAM"
    )
    plc.scan(3)
    assert plc["ECAT.Drive[1].mode"] == 6 and plc["PLC_PRG.rtn"] == 0

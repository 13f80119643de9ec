"""The bus as plc.toml or an ENI file has it: process data, axes, faults; mistakes are told."""

import pytest

from mclib.ecat import table
from mclib.ecat.bus import place
from plcruntime import UsageError, project

FIGURE_5_2 = """
[[ecat.slave]]
kind = "gthd"
count = 2
[[ecat.slave]]
kind = "io"
count = 2
"""
ENI = """<?xml version="1.0"?>
<EtherCATConfig><Config>
<Master><Info><Name>Master</Name></Info></Master>
<Slave><Info><Name>GTHD</Name><PhysAddr>1001</PhysAddr><VendorId>741</VendorId><ProductCode>#x1A</ProductCode>
  <RevisionNo>1</RevisionNo><SerialNo>7</SerialNo></Info>
  <ProcessData>
    <RxPdo Sm="2"><Index>#x1600</Index>
      <Entry><Index>#x6040</Index><SubIndex>0</SubIndex><BitLen>16</BitLen></Entry>
      <Entry><Index>#x607A</Index><SubIndex>0</SubIndex><BitLen>32</BitLen></Entry></RxPdo>
    <RxPdo><Index>#x1601</Index><Entry><Index>#x60FF</Index><SubIndex>0</SubIndex><BitLen>32</BitLen></Entry></RxPdo>
    <TxPdo Sm="3"><Index>#x1A00</Index>
      <Entry><Index>#x6041</Index><SubIndex>0</SubIndex><BitLen>16</BitLen></Entry>
      <Entry><Index>#x6064</Index><SubIndex>0</SubIndex><BitLen>32</BitLen></Entry></TxPdo>
  </ProcessData></Slave>
<Slave><Info><Name>IO bits</Name><VendorId>2</VendorId><ProductCode>3</ProductCode></Info>
  <ProcessData>
    <RxPdo Sm="2"><Index>#x1600</Index>
      <Entry><Index>#x7000</Index><SubIndex>1</SubIndex><BitLen>1</BitLen></Entry>
      <Entry><Index>#x7000</Index><SubIndex>2</SubIndex><BitLen>1</BitLen></Entry>
      <Entry><Index>#x0</Index><BitLen>6</BitLen></Entry></RxPdo>
    <TxPdo Sm="3"><Index>#x1A00</Index>
      <Entry><Index>#x6000</Index><SubIndex>1</SubIndex><BitLen>3</BitLen></Entry>
      <Entry><Index>#x6000</Index><SubIndex>2</SubIndex><BitLen>12</BitLen></Entry></TxPdo>
  </ProcessData></Slave>
</Config></EtherCATConfig>
"""


def write(folder, text):
    path = folder / "plc.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_figure_5_2(tmp_path, bench):
    bus = bench(write(tmp_path, FIGURE_5_2))
    slaves = project.load(tmp_path / "plc.toml").ecat.slaves
    assert [s.start for s in slaves] == [0, 16, 32, 36] and [s.axis for s in slaves] == [1, 2, 0, 0]
    at = {(n, e.index): e.bit // 8 for n, s in enumerate(slaves) for e in s.entries}
    assert (at[0, 0x6040], at[0, 0x6041], at[1, 0x6040], at[1, 0x6041]) == (0, 6, 16, 22)
    assert bus("GT_GetMcEcatAxisNum(ADR(i))") == 0 and bus["i"] == 2
    # what figure 5-2 does not map is not there
    for call in ("GT_GetEcatAxisMode(1, ADR(i))", "GT_SetEcatAxisMode(1, 9)", "GT_SetEcatAxisPT(1, 0)",
                 "GT_SetEcatAxisPV(1, 0)", "GT_GetEcatAxisAI(1, 1, ADR(i))", "GT_GetEcatAxisAtlCurrent(1, ADR(i))",
                 "GT_GetEcatAxisAtlTorque(1, ADR(i))", "GT_GetEcatAxisDI(1, ADR(n))", "GT_GetEcatAxisDO(1, ADR(n))",
                 "GT_SetEcatAxisDO(1, 0)", "GT_GetEcatAxisPE(1, ADR(x))", "GT_SetTouchProbeFunction(1, 0)",
                 "GT_SetTouchProbeFunctionEx(1, 0, 0, 0, 0, 0, 0)",
                 "GT_GetTouchProbeStatus(1, ADR(u), ADR(d), ADR(d), ADR(d), ADR(d))"):  # fmt: skip
        assert bus(call) == 1 and "not mapped" in bus.why, call
    assert bus("GT_GetEcatAxisMode(3, ADR(i))") == 1 and "no drive" in bus.why
    # homing goes by SDO then (5.2.2.2)
    bus.power()
    assert bus("GT_SetHomingMode(1, 6)") == 0 and bus.plc["ECAT.Drive[1].mode"] == 6
    assert bus("GT_SetEcatHomingPrm(1, 37, 1, 1, 1, 0, 0)") == 0 and bus("GT_StartEcatHoming(1)") == 0
    assert bus("GT_GetEcatHomingStatus(1, ADR(i))") == 0 and bus["i"] == 3
    assert bus("GT_GetEcatEncPos(1, ADR(x))") == 0 and bus("GT_GetEcatEncVel(1, ADR(x))") == 0


def test_figure_5_4():
    (slave,) = [table._slave({"kind": "coupler", "modules": ["di16", "do16", "ai4", "ao4"]}, 0)]
    place([slave])
    at = {(e.index, e.subindex): e.bit // 8 for e in slave.entries}
    assert at[0x7010, 1] == 2 and at[0x6000, 1] == 14
    assert [at[0x7030, n] for n in range(1, 5)] == [4, 6, 8, 10]
    assert [at[0x6020, n] for n in range(1, 5)] == [16, 18, 20, 22]
    assert (slave.outputs, slave.inputs) == (12, 12)


def test_eni(tmp_path, bench):
    (tmp_path / "Gecat.eni").write_text(ENI)
    bus = bench(write(tmp_path, '[ecat]\neni = "Gecat.eni"\n'))
    slaves = project.load(tmp_path / "plc.toml").ecat.slaves
    assert [(s.name, s.axis, s.start, s.outputs, s.inputs) for s in slaves] == [
        ("GTHD", 1, 0, 6, 6), ("IO bits", 0, 12, 1, 2)]  # fmt: skip
    assert slaves[0].identity == (741, 0x1A, 1, 7)
    assert bus("GT_EcatSDOUpLoad(0, 16#1018, 2, ADR(n), 4, ADR(got), ADR(abort))") == 0 and bus["n"] == 0x1A
    bus.plc["ECAT.image[13]"] = 0b11101101  # 3 bits, then 12
    bus.plc["ECAT.image[14]"] = 0b01010101
    assert bus("GT_EcatSDOUpLoad(1, 16#6000, 1, ADR(n), 4, ADR(got), ADR(abort))") == 0 and bus["n"] & 0xFF == 5
    assert bus("GT_EcatSDOUpLoad(1, 16#6000, 2, ADR(u), 2, ADR(got), ADR(abort))") == 0
    assert bus["u"] == 0b101010111101 and bus["got"] == 2
    assert bus("GT_EcatSDODownload(1, 16#7000, 2, ADR(bit), 1, ADR(abort))") == 0 and bus.plc["ECAT.image[12]"] == 2
    bus.power()
    bus.jog(4)
    bus.scan(50)
    assert bus("GT_GetEcatRawData(8, 4, ADR(x))") == 0 and bus["x"] == pytest.approx(bus.axis.position, abs=5)


def test_without_its_eni_file(tmp_path, bench):
    bus = bench(write(tmp_path, '[ecat]\neni = "Gecat.eni"\n'))
    assert bus("GT_InitEcatComm()") == -9 and "ENI" in bus.why
    assert bus("GT_IsEcatReady(ADR(i))") == 0 and bus["i"] == 0
    assert bus("GT_GetEcatAxisMode(1, ADR(i))") == 1 and bus("GT_GetEcatRawData(0, 1, ADR(u))") == 7


def test_startup_and_faults(tmp_path, bench):
    text = '[ecat]\nstartup = "20ms"\n' + FIGURE_5_2 + '[[ecat.fault]]\nslave = 1\nat = "50ms"\nuntil = "60ms"\n'
    bus = bench(write(tmp_path, text))
    ready, online = [], []
    for _ in range(100):
        assert bus("GT_IsEcatReady(ADR(i)) + GT_GetEcatSlaves(ADR(u))") == 0
        ready.append(bus["i"])
        online.append(bus["u"])
    assert ready == [0] * 20 + [1] * 30 + [0] * 30 + [1] * 20
    assert online == [4] * 50 + [1] * 10 + [4] * 40


def test_axes_objects_and_wiring(tmp_path, bench):
    bus = bench(write(tmp_path, """
        [[ecat.slave]]
        kind = "drive"
        axis = 3
        name = "Spindle"
        objects = ["2001:00 DINT = -5", "2001:02 UINT = 16#FF ro", "2002:00 LREAL = 2.5"]
        vendor = 741
        [[ecat.slave]]
        kind = "drive"
        [[ecat.slave]]
        outputs = ["7000:01/8"]
        inputs = ["6000:01/64", "6001"]
        [[ecat.slave]]
        kind = "io"
        wired = false
        """))  # fmt: skip
    assert bus.plc["ECAT.Drive[3].slave"] == 0 and bus.plc["ECAT.Drive[1].slave"] == 1
    assert bus("GT_IsEcatReady(ADR(i))") == 0 and bus["i"] == 0 and bus("GT_InitEcatComm()") == -8
    up = "GT_EcatSDOUpLoad(0, 16#{}, {}, ADR({}), {}, ADR(got), ADR(abort))"
    assert bus(up.format("2001", 0, "x", 4)) == 0 and bus["x"] == -5
    assert bus(up.format("2001", 2, "u", 2)) == 0 and bus["u"] == 255 and bus["got"] == 2
    assert bus(up.format("2001", 1, "u", 2)) == 1 and bus["abort"] == 0x06090011
    assert bus(up.format("1008", 0, "d", 16)) == 0 and bus["got"] == len("Spindle")
    assert bytes(b for w in bus["d"][:2] for b in w.to_bytes(4, "little"))[:7] == b"Spindle"
    bus["x"] = 77
    assert bus("GT_EcatSDODownload(0, 16#2001, 0, ADR(x), 4, ADR(abort))") == 0
    bus["x"] = 0
    assert bus(up.format("2001", 0, "x", 4)) == 0 and bus["x"] == 77
    assert bus("GT_EcatSDODownload(0, 16#2001, 2, ADR(u), 2, ADR(abort))") == 1 and bus["abort"] == 0x06010002
    slaves = project.load(tmp_path / "plc.toml").ecat.slaves
    assert (slaves[2].outputs, slaves[2].inputs) == (1, 12)


@pytest.mark.parametrize(("text", "words"), [
    ('[ecat]\nslaves = 3', ["unknown key ecat.slaves", "slave"]),
    ('[[ecat.slave]]\nkind = "driver"', ["slave.kind 'driver'", "drive, gthd"]),
    ('[[ecat.slave]]\nkind = "io"\naxis = 1', ["axis belongs to"]),
    ('[[ecat.slave]]\nkind = "drive"\naxis = 13', ["from 1 to 12"]),
    ('[[ecat.slave]]\nkind = "drive"\ncount = 13', ["more than 12 drives"]),
    ('[[ecat.slave]]\nkind = "drive"\naxis = 1\ncount = 2', ["axis 1 has two drives"]),
    ('[[ecat.slave]]\nkind = "io"\ncount = 65', ["from 1 to 64"]),
    ('[[ecat.slave]]\nkind = "io"\nmodules = ["di16"]', ["only a coupler"]),
    ('[[ecat.slave]]\nkind = "coupler"\nmodules = ["di8"]', ["module 'di8'", "di16"]),
    ('[[ecat.slave]]\noutputs = ["70000"]', ["'70000' is no object"]),
    ('[[ecat.slave]]\noutputs = ["7000:01/40"]', ["1 to 32 bits"]),
    ('[[ecat.slave]]\nobjects = ["2001 DINT"]', ["'2001 DINT' is no object"]),
    ('[[ecat.slave]]\nobjects = ["2001 USINT = 300"]', ["300 is not a value of type USINT"]),
    ('[ecat]\neni = "a.eni"\n[[ecat.slave]]\nkind = "io"', ["twice"]),
    ('[ecat]\nstartup = "soon"', ["startup", "soon"]),
    ('[[ecat.fault]]\nat = "5ms"\nuntil = "5ms"', ["later than"]),
    ('[[ecat.fault]]\nslave = 17', ["from 0 to 16"]),
    ('[[ecat.slave]]\nkind = "coupler"\ncount = 40\noutputs = [' + '"7000:01/64",' * 12 + ']', ["2040"]),
])  # fmt: skip
def test_mistakes(tmp_path, text, words):
    with pytest.raises(UsageError) as caught:
        project.load(write(tmp_path, text))
    for word in (*words, "plc.toml"):
        assert word in str(caught.value)


@pytest.mark.parametrize("text", ["<a>", "<EtherCATConfig><Config/></EtherCATConfig>",
                                  ENI.replace("#x6040", "x6040")])  # fmt: skip
def test_wrong_eni_files(tmp_path, text):
    (tmp_path / "Gecat.eni").write_text(text)
    with pytest.raises(UsageError):
        project.load(write(tmp_path, '[ecat]\neni = "Gecat.eni"\n'))


def test_switches_of_plc_toml_home_the_axis(tmp_path, bench):
    bus = bench(write(tmp_path, """
        [[axis]]
        home_from = 2000
        index_period = 500
        index_at = 20
        limit_positive = 9000
        """))  # fmt: skip
    bus.power()
    calls = ("GT_SetHomingMode(1, 6)", "GT_SetEcatHomingPrm(1, 3, 50, 20, 2, 0, 0)", "GT_StartEcatHoming(1)")
    assert bus(" + ".join(calls)) == 0
    bus.plc.run_until("ECAT.Drive[1].home.result = 3", "2s")
    assert bus.axis.position - bus.axis.encPos == pytest.approx(1520.0)
    assert not bus.axis.switches.home

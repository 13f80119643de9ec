"""Inputs, outputs, captures, stop inputs, encoders, extension modules, MRAM (iDEABOX 3, 4.5, 9.4, 10.5, 11.8)."""

import pytest

from mclib import mram
from plcruntime import PLC


class Board:
    """Runs ST statements, one call a scan: each distinct one is a case of one program."""

    def __init__(self, *calls: str, **options) -> None:
        self.calls = calls
        cases = "".join(f"    {n}: rtn := {call};\n" for n, call in enumerate(calls, 1))
        text = f"""
PROGRAM PLC_PRG
VAR
    job, rtn, i, k : INT; d : DINT; u : UINT; r : LREAL; counts : ARRAY[0..15] OF UDINT; words : ARRAY[0..24] OF INT;
    trigger : TTrigger; done : ARRAY[0..11] OF TTriggerStatus; pid : TPid; mac : ARRAY[0..7] OF USINT; jog : TJogPrm;
    v : ARRAY[0..11] OF LREAL;
END_VAR
CASE job OF
{cases}END_CASE
job := 0;
END_PROGRAM
"""
        source = text
        if "folder" in options:
            source = options["folder"] / "main.st"
            source.write_text(text, encoding="utf-8")
        self.plc = PLC.load(source, interval="1ms")

    def __call__(self, call: str, **values) -> int:
        for name, value in values.items():
            if isinstance(value, list):  # the first elements
                value = value + self[name][len(value) :]
            self.plc[f"PLC_PRG.{name}"] = value
        self.plc["PLC_PRG.job"] = self.calls.index(call) + 1
        self.plc.scan()
        return self.plc["PLC_PRG.rtn"]

    def __getitem__(self, name: str):
        return self.plc[f"PLC_PRG.{name}"]


def test_inputs():
    get = "GT_GetDi(i, ADR(d))"
    io = Board(get, "GT_GetDi(0, 0)", "GT_AxisOn(3)")
    io.plc["SIM.Axis[2].switches.positive"] = True
    io.plc["SIM.Axis[12].switches.negative"] = True
    io.plc["SIM.Axis[1].drive.alarm"] = True
    io.plc["SIM.Axis[4].switches.home"] = True
    io.plc["SimIo.gpi"] = 0x8001
    io.plc["SimIo.mpg"] = 0x0100
    io("GT_AxisOn(3)")
    seen = {}
    for kind in range(7):
        assert io(get, i=kind) == 0
        seen[kind] = io["d"]
    assert seen == {0: 2, 1: 0x800, 2: 1, 3: 8, 4: 0x8001, 5: 4, 6: 0x100}
    assert io(get, i=7) == 7 and io(get, i=-1) == 7 and io("GT_GetDi(0, 0)") == 7


def test_outputs():
    set_all, set_bit, get = "GT_SetDo(i, d)", "GT_SetDoBit(i, k, DINT_TO_INT(d))", "GT_GetDo(i, ADR(d))"
    io = Board(set_all, set_bit, get)
    assert io(set_all, i=12, d=0x1A005) == 0
    assert io(get) == 0 and io["d"] == 0xA005 == io.plc["SimIo.gpo"]
    assert io(set_bit, k=2, d=1) == 0 and io(set_bit, k=16, d=0) == 0
    assert io.plc["SimIo.gpo"] == 0x2007
    for bad in ({"k": 0}, {"k": 17}, {"k": 1, "d": 2}, {"i": 11, "k": 13, "d": 0}, {"i": 13, "k": 1}):
        assert io(set_bit, **bad) == 7, bad
    assert io(set_all, i=9) == 7 and io(get, i=9) == 7
    # servo enables are those of the axes; a servo with an alarm stays off, until the alarm is reset
    io.plc["SIM.Axis[2].drive.alarm"] = True
    assert io(set_all, i=10, d=0b111) == 0
    assert [io.plc.axes[n].drive.enabled for n in (1, 2, 3)] == [True, False, True]
    assert io(get) == 0 and io["d"] == 0b101
    assert io(set_bit, i=11, k=2, d=1) == 0 and not io.plc.axes[2].drive.alarm
    assert io(set_bit, i=10, k=1, d=0) == 0 and not io.plc.axes[1].drive.enabled


def test_counts_of_level_changes():
    get, put = "GT_GetDiReverseCount(i, k, ADR(counts), 3)", "GT_SetDiReverseCount(i, k, ADR(counts), 3)"
    io = Board(get, put, "GT_Reset()")
    for level in (1, 0, 4, 5):
        io.plc["SimIo.gpi"] = level
        io.plc.scan()
    assert io(get, i=4, k=1) == 0 and io["counts"][:3] == [3, 0, 1]
    assert io(put, counts=[10, 20, 30]) == 0
    io.plc["SimIo.gpi"] = 0
    io.plc.scan()
    assert io(get) == 0 and io["counts"][:3] == [11, 20, 31]
    assert io(get, k=14) == 0 and io(get, k=15) == 7 and io(get, k=0) == 7 and io(get, i=0, k=10) == 0
    assert io(get, i=0, k=11) == 7
    assert io("GT_Reset()") == 0 and io(get, i=4, k=1) == 0 and io["counts"][:3] == [0, 0, 0]


def test_analogue_outputs_and_their_limits():
    calls = ("GT_SetDac(i, ADR(words), k)", "GT_GetDac(i, ADR(words), k)", "GT_GetDacValue(i, ADR(words), k)",
             "GT_SetMtrBias(i, k)", "GT_GetMtrBias(i, ADR(k))", "GT_SetMtrLmt(i, k)",
             "GT_GetMtrLmt(i, ADR(k))")  # fmt: skip
    io = Board(*calls)
    put, get, out, set_bias, get_bias, set_limit, get_limit = calls
    assert io(put, i=11, k=2, words=[32767, -32768]) == 0
    assert io(set_bias, i=12, k=-100) == 0 and io(get_bias, k=0) == 0 and io["k"] == -100
    assert io(set_limit, i=11, k=30000) == 0 and io(get_limit, k=0) == 0 and io["k"] == 30000
    assert io(get, i=11, k=2, words=[0, 0]) == 0 and io["words"][:2] == [32767, -32768]
    assert io(out, i=11, k=2, words=[0, 0]) == 0 and io["words"][:2] == [30000, -32767]
    for call in calls:
        assert io(call, i=13, k=1) == 7 and io(call, i=0, k=1) == 7, call
    assert io(put, i=12, k=2) == 7 and io(put, i=12, k=0) == 7 and io(set_limit, i=1, k=-1) == 7


def test_controllers_settings():
    calls = ("GT_SetPid(i, k, ADR(pid))", "GT_GetPid(i, k, ADR(pid))", "GT_SetControlFilter(i, k)",
             "GT_GetControlFilter(i, ADR(k))", "GT_CtrlMode(i, k)", "GT_StepDir(i)", "GT_StepPulse(i)")  # fmt: skip
    io = Board(*calls)
    assert io(calls[0], i=2, k=3, pid={"kp": 1.5, "limit": 7}) == 0
    assert io(calls[1], pid={"kp": 0.0, "limit": 0}) == 0 and io["pid"]["kp"] == 1.5 and io["pid"]["limit"] == 7
    assert io(calls[1], k=1) == 0 and io["pid"]["kp"] == 1.0
    assert io(calls[0], pid={"limit": -1}) == 7 and io(calls[0], k=4) == 7
    assert io(calls[3], k=0) == 0 and io["k"] == 1
    assert io(calls[2], k=3) == 0 and io(calls[3], k=0) == 0 and io["k"] == 3
    assert io(calls[2], k=0) == 7
    assert io(calls[4], k=0) == 0 and io.plc["SimIo.analogue"][1] and io(calls[4], k=2) == 7
    assert io(calls[6]) == 0 and io.plc["SimIo.cwCcw"][1]
    assert io(calls[5]) == 0 and not io.plc["SimIo.cwCcw"][1]
    assert all(io(call, i=13, k=1) == 7 for call in calls)


def test_reset_sets_outputs_and_settings_back():
    put, limit, capture = "GT_SetDo(12, 255)", "GT_SetMtrLmt(3, 100)", "GT_SetTrigger(1, ADR(trigger))"
    io = Board(put, limit, capture, "GT_Reset()", "GT_GetTriggerStatus(1, ADR(done))", "GT_SetExtIoValue(2, 7)")
    home = {"encoder": 1, "probeType": 1, "probeIndex": 0, "offset": 0, "windowOnly": 0}
    io.plc["SimIo.gpi"] = 3
    assert [io(c, trigger=home) for c in (put, limit, capture, "GT_SetExtIoValue(2, 7)")] == [0, 0, 0, 0]
    assert io("GT_Reset()") == 0
    assert io.plc["SimIo.gpo"] == 0 and io.plc["SimIo.limit"][2] == 32767 and io.plc["SimIo.module[2].outputs"] == 0
    assert io.plc["SimIo.gpi"] == 3
    assert io("GT_GetTriggerStatus(1, ADR(done))") == 0 and io["done"][0]["execute"] == 0


def test_extension_modules():
    calls = ("GT_SetExtIoValue(i, u)", "GT_GetExtIoValue(i, ADR(u))", "GT_SetExtIoBit(i, k, u)",
             "GT_GetExtIoBit(i, k, ADR(u))", "GT_GetExtAdValue(i, k, ADR(u))", "GT_GetExtAdVoltage(i, k, ADR(r))",
             "GT_SetExtDaValue(i, k, u)", "GT_SetExtDaVoltage(i, k, r)", "GT_GetStsExtMdl(i, k, ADR(u))")  # fmt: skip
    io = Board(*calls)
    assert io(calls[0], i=15, u=0x8001) == 0 and io(calls[2], k=4, u=1) == 0 and io(calls[2], k=0, u=0) == 0
    assert io.plc["SimIo.module[15].outputs"] == 0x8010
    io.plc["SimIo.module[15].inputs"] = 0x1234
    assert io(calls[1]) == 0 and io["u"] == 0x1234
    assert [(io(calls[3], k=n), io["u"])[1] for n in range(6)] == [0, 0, 1, 0, 1, 1]
    assert io(calls[5], k=7) == 0 and io["r"] == 0.0
    io.plc["SimIo.module[15].ad[7]"] = 0
    assert io(calls[5]) == 0 and io["r"] == -10.0 and io(calls[4]) == 0 and io["u"] == 0
    for volts, value in ((-10.0, 0), (0.0, 32768), (5.0, 49152), (10.0, 65535)):
        assert io(calls[7], r=volts) == 0 and io.plc["SimIo.module[15].da[7]"] == value
    assert io(calls[6], u=77) == 0 and io.plc["SimIo.module[15].da[7]"] == 77
    assert io(calls[7], r=10.1) == 7 and io(calls[2], k=16) == 7 and io(calls[2], k=1, u=2) == 7
    assert io(calls[8]) == 0 and io["u"] == 0
    io.plc["SimIo.module[15].fault"] = True
    assert io(calls[8]) == 0 and io["u"] == 1 and all(io(c, u=0, r=0.0) == 1 for c in calls[:8])
    assert all(io(c, i=16) == 7 and io(c, i=-1) == 7 for c in calls)


JOG = ("GT_AxisOn(1)", "GT_PrfJog(1)", "GT_SetJogPrm(1, ADR(jog))", "GT_SetVel(1, r)", "GT_Update(1)")


def jog(io: Board, vel: float) -> None:
    for call in JOG:
        assert io(call, jog={"acc": 1.0, "dec": 1.0, "smooth": 0.0}, r=vel) == 0


def test_captures():
    put, get = "GT_SetTrigger(i, ADR(trigger))", "GT_GetTriggerStatus(i, ADR(done), 2)"
    link, offset = "GT_LinkCaptureOffset(i, k)", "GT_GetCaptureOffset(i, ADR(d))"
    io = Board(*JOG, put, get, link, offset)
    jog(io, 10.0)
    home = {"encoder": 1, "probeType": 1, "probeIndex": 0, "offset": 0, "windowOnly": 0}
    assert io(put, i=1, trigger=home) == 0
    assert io(put, i=2, trigger={**home, "probeType": 3, "probeIndex": 5, "offset": 7}) == 0
    assert io(get, i=1) == 0 and [(x["execute"], x["done"]) for x in io["done"][:2]] == [(1, 0), (1, 0)]
    assert io(offset, i=1) == 1
    io.plc["SIM.Axis[1].switches.home"] = True
    io.plc.scan()
    at = io.plc.axes[1].encPos
    io.plc.scan(20)
    io.plc["SimIo.probe[5]"] = True
    io.plc.scan()
    later = io.plc.axes[1].encPos
    assert io(get, i=1) == 0
    assert [(x["execute"], x["done"], x["position"]) for x in io["done"][:2]] == [
        (0, 1, pytest.approx(at, abs=0.5)), (0, 1, pytest.approx(later + 7, abs=0.5)),
    ]  # fmt: skip
    assert io(offset, i=2) == 0 and io["d"] == io["done"][1]["position"]
    assert io(link, i=2, k=1) == 0 and io(offset, i=2) == 0
    assert io["d"] == io["done"][1]["position"] - io["done"][0]["position"]
    # outside its window nothing is captured; a signal that is on already must fall and rise
    window = {**home, "windowOnly": 1, "firstPosition": -100, "lastPosition": 100}
    assert io(put, i=1, trigger=window) == 0
    for level in (False, True, True):
        io.plc["SIM.Axis[1].switches.home"] = level
        io.plc.scan(2)
    assert io(get, i=1) == 0 and io["done"][0]["done"] == 0
    for bad in (
        {"encoder": 0},
        {"probeType": 0},
        {"probeType": 4},
        {"probeType": 3, "probeIndex": 0},
        {"windowOnly": 2},
    ):
        assert io(put, i=1, trigger={**home, **bad}) == 7, bad
    assert io(put, i=13) == 7 and io(get, i=12) == 7 and io(link, i=1, k=13) == 7 and io(offset, i=0) == 7


def test_captures_are_exact_where_signals_have_their_places():
    """The hardware keeps the position of the edge itself, at any speed: the switch at 1000..2000, an index pulse every
    500 from 300 on."""
    put, get = "GT_SetTrigger(i, ADR(trigger))", "GT_GetTriggerStatus(i, ADR(done), 2)"
    io = Board(*JOG, put, get)
    io.plc.scan()
    places = io.plc.axes[1].places
    places.homeFrom, places.homeTo, places.indexPeriod, places.index, places.placed = 1000.0, 2000.0, 500.0, 300.0, True
    home = {"encoder": 1, "probeType": 1, "probeIndex": 0, "offset": 0, "windowOnly": 0}

    def passes(vel: float, scans: int, window=(0, 0)) -> list[int]:
        assert io(put, i=1, trigger=home) == 0
        index = {**home, "probeType": 2, "windowOnly": int(window != (0, 0)), "firstPosition": window[0]}
        assert io(put, i=2, trigger={**index, "lastPosition": window[1]}) == 0
        for call in JOG if not io.plc.axes[1].moving else JOG[-2:]:
            assert io(call, jog={"acc": 1.0, "dec": 1.0, "smooth": 0.0}, r=vel) == 0
        io.plc.scan(scans)
        assert io(get, i=1) == 0 and [x["done"] for x in io["done"][:2]] == [1, 1]
        return [x["position"] for x in io["done"][:2]]

    assert passes(37.0, 100) == [1000, 300]
    assert passes(-37.0, 160, window=(1400, 2200)) == [2000, 1800]
    assert io.plc.axes[1].position < 1000.0
    assert passes(23.0, 250, window=(1100, 1900)) == [1000, 1300]


@pytest.mark.parametrize(("kind", "bit", "scans"), [(1, 1 << 7, 20), (0, 1 << 8, 1)])
def test_stop_inputs(kind, bit, scans):
    put, clear, more = "GT_SetStopIo(1, k, 4, 3)", "GT_ClrSts(1)", "GT_SetStopIo(i, 0, DINT_TO_INT(d), k)"
    io = Board(*JOG, put, clear, more)
    assert io(put, k=kind) == 0
    jog(io, 20.0)
    io.plc.scan(50)
    before = io.plc.axes[1].prfPos
    io.plc["SimIo.gpi"] = 0b100
    io.plc.scan()
    assert io.plc.axes[1].prfPos == pytest.approx(before + 20.0)  # it runs until the scan in which the input is seen
    path = [io.plc.axes[1].prfPos]
    while io.plc.axes[1].moving:
        io.plc.scan()
        path.append(io.plc.axes[1].prfPos)
    assert len(path) == scans + 1
    assert path[-1] - path[0] == pytest.approx(200.0 if kind else 0.2, abs=1e-6)  # v2 / 2a, a = 1 or 1000
    assert io.plc.axes[1].status & 0x180 == bit
    assert io("GT_Update(1)") == 1
    assert io(clear) == 0 and io.plc.axes[1].status & bit  # the cause is still there
    io.plc["SimIo.gpi"] = 0
    assert io(clear) == 0 and not io.plc.axes[1].status & bit
    assert io("GT_Update(1)") == 0
    for axis, source, index in ((13, 4, 1), (1, 6, 1), (1, -1, 1), (1, 4, 17), (1, 0, 13), (1, 4, 0)):
        assert io(more, i=axis, d=source, k=index) == 7


def test_encoder_source_and_direction():
    sense, off, on = "GT_EncSns(u)", "GT_EncOff(i)", "GT_EncOn(i)"
    read, vel = "GT_GetEncPos(1, ADR(v))", "GT_GetEncVel(1, ADR(v))"
    io = Board(*JOG, sense, off, on, read, vel)
    io.plc["SIM.Axis[1].drive.lag"] = 5.0
    jog(io, 10.0)
    io.plc.scan(200)
    axis = io.plc.axes[1]
    assert axis.prfPos - axis.encPos == pytest.approx(50.0)
    before = axis.encPos
    assert io(off, i=1) == 0  # counting pulses goes on from the value there is
    assert axis.encPos == pytest.approx(before + 10.0)
    io.plc.scan(10)
    assert axis.encPos == pytest.approx(before + 110.0)
    assert io(on) == 0 and axis.encPos == pytest.approx(before + 120.0)
    before = axis.encPos
    assert io(sense, u=0x801) == 0 and axis.encPos == pytest.approx(before - 10.0)
    assert [io.plc.axes[n].encGain for n in (1, 2, 12)] == [-1.0, 1.0, -1.0]
    assert io(vel) == 0 and io["v"][0] == pytest.approx(-10.0)
    assert io(sense, u=0) == 0 and io(vel) == 0 and io["v"][0] == pytest.approx(10.0)
    assert io(sense, u=0x1000) == 7 and io(off, i=0) == 7 and io(on, i=13) == 7


def test_mac_address():
    io = Board("GetMacAddress(INT_TO_UDINT(i), ADR(mac), INT_TO_UDINT(k))")
    (get,) = io.calls
    assert io(get, i=0, k=8) == 0
    first = io["mac"]
    assert first[0] & 3 == 2 and first[6:] == [0, 0]  # administered locally, one station
    assert io(get, i=1, k=6) == 0 and io["mac"][:6] != first[:6]
    assert io(get, i=0, k=5) == 7 and io(get, i=8, k=6) == 7


MRAM = ("GT_SetMRAMData(i, ADR(words), k)", "GT_GetMRAMData(i, ADR(words), k)",
        "GT_StartAccessMRAM(i, k, DINT_TO_INT(d))", "GT_GetMRAMStatus(ADR(i))", "GT_StopAccessMRAM()")  # fmt: skip


@pytest.fixture
def state(monkeypatch, tmp_path):
    monkeypatch.setenv("SCANCYCLE_STATE", str(tmp_path / "state"))
    return tmp_path


def test_mram_survives_power_cycle_and_process(state):
    (state / "project").mkdir()
    io = Board(*MRAM, folder=state / "project")
    put, get, start, status, stop = MRAM
    assert io(put, i=4090, k=6, words=[1, -2, 3, -4, 5, -6]) == 0
    assert io(start, i=4090, k=6, d=1) == 0 and io(status) == 0 and io["i"] == 1
    io.plc.power_cycle()
    assert io(get, i=4090, k=6) == 0 and io["words"][:6] == [0] * 6  # the buffer is not the memory
    assert io(start, i=4090, k=6, d=0) == 0 and io(status) == 0 and io(get, i=4090, k=6) == 0
    assert io["words"][:6] == [1, -2, 3, -4, 5, -6]
    again = Board(*MRAM, folder=state / "project")
    assert again(start, i=4089, k=7, d=0) == 0 and again(status) == 0 and again(get, i=4089, k=7) == 0
    assert again["words"][:7] == [0, 1, -2, 3, -4, 5, -6]
    (state / "elsewhere").mkdir()
    other = Board(*MRAM, folder=state / "elsewhere")
    assert other(start, i=4090, k=6, d=0) == 0 and other(status) == 0 and other(get, i=4090, k=6) == 0
    assert other["words"][:6] == [0] * 6
    assert not list(state.rglob("*.part"))


def test_mram_takes_its_time_and_can_be_stopped(state):
    io = Board(*MRAM)
    put, get, start, status, stop = MRAM
    assert io(put, i=0, k=1, words=[99]) == 0
    assert io(start, i=0, k=4096, d=1) == 0 and io(start, i=0, k=1, d=0) == 1  # 65 ms
    assert io(status) == 0 and io["i"] == 0
    assert io(stop) == 0 and io(status) == 0 and io["i"] == 0  # given up is not finished
    io.plc.scan(100)
    assert io(status) == 0 and io["i"] == 0
    assert io(start, i=0, k=1, d=0) == 0 and io(status) == 0 and io["i"] == 1
    assert io(get, i=0, k=1) == 0 and io["words"][0] == 0  # nothing was kept
    for call in (put, get):
        for bad in ({"i": -1, "k": 1}, {"i": 4095, "k": 2}, {"i": 0, "k": 25}, {"i": 0, "k": 0}):
            assert io(call, **bad) == 7, (call, bad)
    for bad in ({"i": 0, "k": 0, "d": 0}, {"i": 1, "k": 4096, "d": 0}, {"i": 0, "k": 1, "d": 2}):
        assert io(start, **bad) == 7, bad


def test_mram_file_that_cannot_be_written(state, monkeypatch):
    (state / "state").write_text("a file where the folder should be")
    (state / "project").mkdir()
    io = Board(*MRAM, folder=state / "project")
    put, get, start, status, stop = MRAM
    assert io(start, i=0, k=1, d=1) == 0
    assert io(status) == 1 and io["i"] == 0


def test_mram_beside_plc_toml(tmp_path):
    assert mram.place(tmp_path / "plc.toml", ["x.st"]) == tmp_path / "mram.bin"
    assert mram.place(None, ["<text>"]) is None
    file = tmp_path / "mram.bin"
    mram.Mram(file).write(1, b"\x01\x02")
    assert mram.Mram(file).read(0, 3) == b"\0\0\x01\x02\0\0" and file.stat().st_size == mram.SIZE
    file.write_bytes(b"\x05")  # a file that is too short: the rest is 0
    assert mram.Mram(file).read(0, 2) == b"\x05\0\0\0"

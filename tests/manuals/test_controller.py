"""Examples 4-1, 8-1, 9-1, 11-1 to 11-4 of the iDEABOX 3 manual as printed."""

from pathlib import Path

import pytest

from plcruntime import PLC

LISTINGS = Path(__file__).parents[3] / "shared/manuals/listings/ideabox3"
pytestmark = pytest.mark.skipif(not LISTINGS.is_dir(), reason="the manuals' listings are not beside this checkout")

START = 10  # ms, when the operator sets xStart
POSITIVE, ENABLED, MOVING, IN_POSITION = (1 << n for n in (5, 9, 10, 11))


def load(name: str, **options) -> PLC:
    return PLC.load(LISTINGS / name, interval="1ms", **options)


@pytest.fixture(autouse=True)
def own_memory(monkeypatch, tmp_path):
    """No test leaves anything in the MRAM of the machine that it runs on."""
    monkeypatch.setenv("SCANCYCLE_STATE", str(tmp_path))


def test_4_1_counts_encoder_1_the_other_way():
    plc = load("03_enc_sns.st")
    plc.scan(3)
    assert plc["PLC_PRG.rtn"] == 0
    assert [plc.axes[n].encGain for n in range(1, 13)] == [-1.0] + [1.0] * 11


def test_8_1_reads_eight_encoders():
    plc = load("22_read_encoders.st")
    for n in range(1, 9):
        plc[f"SIM.Axis[{n}].offset"] = 100.0 * n
    plc.scan(2)
    assert plc["PLC_PRG.rtn"] == 0
    plc.scan()
    assert plc["PLC_PRG.enc"] == [100.0 * n for n in range(1, 9)] and plc["PLC_PRG.vel"] == [0.0] * 8


def test_9_1_soft_limit():
    plc = load("23_soft_limit.st")
    plc.schedule("PLC_PRG.xStart", True, f"#{START}")
    plc.run("20s")
    axis = plc.axes[1]
    assert axis.status & (POSITIVE | MOVING | ENABLED) == POSITIVE | ENABLED
    assert 20000 < axis.prfPos < 20000 + 2 * 100


def test_11_1_version_through_a_pointer_to_the_pointer():
    plc = load("42_firmware_version.st")
    plc.scan()
    first, date, second, other = plc["PLC_PRG.firmwareVersion"].split(" ")
    assert [len(x) for x in (first, date, second, other)] == [3, 6, 3, 6]
    assert (first + date + second + other).isdigit()


def test_11_2_y_starts_when_x_is_in_position():
    """X: 10000 pulses at 10 pulse/ms, ramps of 10 and 20 ms: 1015 ms; the motor lags 2 ms (servo.cfg). xStart comes
    with the first scan."""
    plc = load("43_in_position.st")
    plc["PLC_PRG.xStart"] = True
    names = ["SIM.Axis[1].status", "SIM.Axis[1].prfPos", "SIM.Axis[1].encPos", "SIM.Axis[2].prfVel"]
    trace = plc.trace(*names)
    plc.run("4s")
    status, x, encoder, vel = ([float(v) for v in trace[n]] for n in names)
    stopped = next(k for k in range(4000) if not int(status[k]) & MOVING)
    assert stopped == 1014 and x[stopped] == 10000.0
    inside = next(k for k in range(stopped, 4000) if abs(x[k] - encoder[k]) <= 20)
    reached = next(k for k in range(4000) if int(status[k]) & IN_POSITION)
    assert reached == inside + 2  # 5 * 250 us inside the band: the first scan that is not before 1.25 ms
    assert next(k for k in range(4000) if vel[k] > 0) == reached + 2  # the program reads the status at its end
    assert plc["PLC_PRG.lrPrfPosY"] == 20000.0
    assert plc["PLC_PRG.stsX"] & plc["PLC_PRG.stsY"] & IN_POSITION


def test_11_2_started_later_moves_both_at_once():
    """By then X rests in position, and the program looks at what it read of X before it started X."""
    plc = load("43_in_position.st")
    plc.schedule("PLC_PRG.xStart", True, f"#{START}")
    plc.scan(START + 1)
    assert plc.axes[1].moving and plc.axes[2].moving


def test_11_3_and_11_4_memory_over_two_programs(tmp_path):
    """Both listings stand in the same folder: one controller. The words survive the program that wrote them."""
    writer = load("44_mram_write.st")
    writer["PLC_PRG.xWriteMRAM"] = True
    writer.scan(10)
    assert not writer["PLC_PRG.xWriteMRAM"] and writer["PLC_PRG.MramSts"] == 1 and writer["PLC_PRG.rtn"] == 0
    reader = load("45_mram_read.st")
    reader["PLC_PRG.xReadMRAM"] = True
    reader.scan()
    assert reader["PLC_PRG.xReadMRAM"] and reader["PLC_PRG.MramSts"] == 0
    reader.scan(10)
    assert not reader["PLC_PRG.xReadMRAM"]
    # the printed initial value is one number for the array: 12345 for all, or for the first
    assert reader["PLC_PRG.ReadMramBuf"] == writer["PLC_PRG.WriteMramBuf"]
    assert reader["PLC_PRG.ReadMramBuf"][0][0] == 12345
    assert [f.stat().st_size for f in tmp_path.rglob("*.bin")] == [8192]

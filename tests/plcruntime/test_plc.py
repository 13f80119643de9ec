import os
import signal
import struct
import threading
import time

import pytest
from fake_machine import FakeMachine, program

from plcruntime.errors import ConditionTimeout
from plcruntime.plc import PLC
from stcore.faults import Fault
from stcore.paths import PathError
from stcore.program import INTERVAL, TASK_RATIOS, TaskSpec


def test_scans_and_time(plc):
    plc.scan()
    plc.scan(9)
    assert (plc.scans, plc.time, plc["counter"]) == (10, 0.01, 10)
    assert plc["t"] == 0.009  # the tenth scan saw 9 ms
    plc.run("90ms")
    assert plc.scans == 100
    plc.run("#5")
    assert plc.scans == 105
    plc.run(0.005)
    assert plc.scans == 110


def test_interval():
    plc = PLC(program(), interval="T#4ms", machine=FakeMachine)
    plc.run("10ms")
    assert (plc.scans, plc.time, plc.interval) == (3, 0.012, 0.004)
    for wrong in ("0ms", "fast", -1):
        with pytest.raises(ValueError):
            PLC(program(), interval=wrong, machine=FakeMachine)


def test_tasks_run_every_so_many_scans():
    p = program()
    p.tasks = [TaskSpec("A", [], 4_000_000), TaskSpec("B", [], 6_000_000), TaskSpec("C", [])]
    plc = PLC(p, interval="10ms", machine=FakeMachine)
    memory = plc._machine.memory
    assert struct.unpack_from("<q", memory, INTERVAL)[0] == 2_000_000
    assert struct.unpack_from("<3i", memory, TASK_RATIOS) == (2, 3, 5)


def test_real_time(plc):
    plc.run("20ms", realtime=True)
    assert plc.scans == 20
    assert plc.run_until(lambda: plc["counter"] == 25, realtime=True) == 0.025
    assert repr(plc) == "<PLC PLC: 25 scans, 0.025 s>"


def test_run_until_a_python_condition(plc):
    assert plc.run_until(lambda p: p["counter"] >= 7) == 0.007
    assert plc.run_until(lambda: plc["counter"] == 9) == 0.009
    with pytest.raises(ConditionTimeout, match="never.*within 5 ms"):

        def never():
            return False

        plc.run_until(never, timeout="5ms")
    assert plc.scans == 14


def test_the_module_ends_a_run_itself(plc):
    assert plc._engine.advance(1000, until=lambda m: m._get("i", "COUNTER") == 77)
    assert plc.scans == 77
    assert not plc._engine.advance(10, until=lambda m: False)


def test_a_timeout_names_the_values_it_saw():
    error = ConditionTimeout("x > 3", "1 s", {"PLC_PRG.x": "2"})
    assert str(error) == "'x > 3' was not reached within 1 s; now PLC_PRG.x = 2"
    assert isinstance(error, TimeoutError)


def test_force_holds_against_the_program(plc):
    plc.force("counter", 40)
    assert plc["counter"] == 40
    plc.scan(3)
    assert plc["counter"] == 40
    plc.force("arr", [1, 2, 3, 4])
    plc.force("%IX0.3", True)
    plc["%IB0"] = 0
    plc.scan()
    assert plc["%IX0.3"] is True and plc["arr"] == [1, 2, 3, 4]
    assert plc.forced == ["PLC_PRG.counter", "PLC_PRG.arr", "%IX0.3"]
    plc.unforce("counter")
    plc.scan()
    assert plc["counter"] == 41
    with pytest.raises(PathError, match="not forced"):
        plc.unforce("counter")
    plc.unforce()
    plc["%IB0"] = 0
    plc.scan()
    assert not plc.forced and plc["%IX0.3"] is False


def test_schedule_is_applied_before_the_scan_that_starts_then(plc):
    trace = plc.trace("PLC_PRG.position")
    plc.schedule("run", True, at="10ms")
    plc.schedule("velocity", 2.0, at="15ms")
    plc.schedule("run", False, at="#20")
    plc.schedule("counter", 5, at="30ms", force=True)
    plc.run("40ms")
    position = trace["position"]
    assert position[9] == 0 and position[10] == 0.5 and position[14] == 2.5 and position[15] == 4.5
    assert position[19] == position[-1] == 12.5
    assert plc["counter"] == 5
    with pytest.raises(TypeError):
        plc.schedule("counter", "x", at="50ms")


def test_trace(plc):
    plc["run"] = True
    trace = plc.trace("PLC_PRG.position", "run", "status.3", "t", "mode", "name")
    plc["name"], plc["mode"] = "abc", 5
    plc.scan(3)
    plc["status.3"] = True
    plc.run("2ms")
    assert len(trace) == 5
    assert trace.time.tolist() == [0.0, 0.001, 0.002, 0.003, 0.004]
    assert trace["position"].tolist() == [0.5, 1.0, 1.5, 2.0, 2.5]
    assert trace["plc_prg.RUN"].tolist() == [True] * 5
    assert trace["PLC_PRG.status.3"].tolist() == [False] * 3 + [True] * 2
    assert trace["t"].tolist() == [0.0, 0.001, 0.002, 0.003, 0.004]
    assert trace["mode"].tolist() == [5] * 5
    assert trace["name"].tolist() == ["abc"] * 5
    assert list(trace.rows())[3] == (0.003, 2.0, True, True, 0.003, 5, "abc")
    with pytest.raises(PathError, match="not traced"):
        trace["velocity"]
    plc.stop_trace(trace)
    plc.scan()
    assert len(trace) == 5


def test_two_traces_and_more_rows_than_the_buffer_holds(plc, monkeypatch):
    from plcruntime import recorder

    monkeypatch.setattr(recorder, "BUFFER", 64)
    first = plc.trace("counter")
    plc.scan(10)
    second = plc.trace("counter", "t")
    plc.scan(100)
    assert first["counter"].tolist() == list(range(1, 111))
    assert second["counter"].tolist() == list(range(11, 111))
    assert second.time[0] == 0.01


def test_trace_through_a_pointer(plc):
    trace = plc.trace("p^.acc")
    plc.scan()
    plc["trap.acc"] = 0.25
    plc["p"] = plc.place("trap").address
    plc.scan(2)
    assert trace["acc"].tolist() == [0.0, 0.25, 0.25]


def test_trace_without_names_takes_the_users_scalars(plc):
    names = plc.trace().names
    assert "PLC_PRG.counter" in names and "GVL.gain" in names and "door" in names
    assert "PLC_PRG.arr" not in names and not any(n.startswith("SIM") for n in names)


def test_files_of_a_trace(plc, tmp_path):
    plc["run"] = True
    trace = plc.trace("PLC_PRG.position", "run", "name")
    plc["name"] = "a,b"
    plc.scan(2)
    trace.to_csv(tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text() == (
        'time,PLC_PRG.position,PLC_PRG.run,PLC_PRG.name\n0.0,0.5,1,"a,b"\n0.001,1.0,1,"a,b"\n'
    )
    trace.to_npz(tmp_path / "t.npz")
    np = pytest.importorskip("numpy")
    with np.load(tmp_path / "t.npz") as data:
        assert data["time"].tolist() == [0.0, 0.001]
        assert data["PLC_PRG.position"].tolist() == [0.5, 1.0]
        assert data["PLC_PRG.name"].tolist() == ["a,b", "a,b"]


def test_a_model_in_python(plc):
    calls = []

    @plc.on_scan
    def plant(p):
        calls.append(p.scans)
        p["GVL.gain"] = p["counter"] * 2.0

    plc.on_scan(lambda: None)
    plc.scan(3)
    assert calls == [1, 2, 3] and plc["gain"] == 6.0
    plc.on_scan(lambda p: p.scan())
    with pytest.raises(RuntimeError, match="between scans"):
        plc.scan()


def test_snapshot_and_restore(plc):
    plc["run"] = True
    trace = plc.trace("counter")
    plc.scan(10)
    plc.force("velocity", 3.0)
    snap = plc.snapshot()
    plc.unforce()
    plc.scan(10)
    plc.restore(snap)
    assert (plc.scans, plc.time, plc["counter"]) == (10, 0.01, 10)
    assert plc.forced == ["PLC_PRG.velocity"]
    plc.scan()
    assert plc["PLC_PRG.position"] == 8.0
    assert trace["counter"].tolist() == list(range(1, 12))
    other = program()
    other.image += b"x"
    with pytest.raises(ValueError, match="another program"):
        PLC(other, machine=FakeMachine).restore(snap)


def history_of(plc, scans):
    """(scan, image) before every scan, while the plc is stimulated from everywhere."""
    images = {}
    plc.schedule("run", True, at="#5")
    plc.schedule("counter", 1000, at="#60", force=True)
    plc.on_scan(lambda p: p.__setitem__("GVL.gain", p["PLC_PRG.position"] / 2) if p.scans % 7 == 0 else None)
    for k in range(scans):
        if k == 20:
            plc["velocity"] = 4.0
        if k == 40:
            plc.force("velocity", 1.0)
        if k == 70:
            plc.unforce()
        plc.scan()
        images[plc.scans] = state(plc)
    return images


def state(plc):
    return bytes(plc._machine.memory[1024 : plc.program.image_end])


def test_going_back_gives_the_same_bytes(plc, monkeypatch):
    from plcruntime import snapshot

    monkeypatch.setattr(snapshot, "FRAME_SECONDS", 0.0)
    monkeypatch.setattr(snapshot, "FRAMES", 8)
    images = history_of(plc, 100)
    for count in (1, 3, 20, 30):
        goal = plc.scans - count
        plc.back(count)
        assert plc.scans == goal and state(plc) == images[goal], goal
    plc._engine.after_scan.clear()
    plc.back(1)
    plc.run("#3")
    assert plc.scans == 48


def test_going_back_from_one_keyframe(plc):
    images = history_of(plc, 90)
    assert len(plc._engine.history.frames) >= 1
    trace = plc.trace("counter")
    plc.scan(5)
    plc.back(15)
    assert state(plc) == images[80] and len(trace) == 0
    plc.back(0)
    assert plc.scans == 80
    plc.back(80)
    assert plc.scans == 0
    with pytest.raises(ValueError, match="can't go back by 1 scan; remembered: 0"):
        plc.back(1)


def test_the_journal_stays_bounded(plc, monkeypatch):
    from plcruntime import snapshot

    monkeypatch.setattr(snapshot, "JOURNAL", 400)
    plc.on_scan(lambda p: p.__setitem__("GVL.gain", p.time))
    images = {}
    for _ in range(3000):
        plc.scan()
        images[plc.scans] = state(plc)
    assert len(plc._engine.history.journal) <= 401
    plc.back(20)
    assert state(plc) == images[2980]


def test_power(plc):
    for kind, kept, saved in (("warm", 5, 6), ("cold", 0, 6), ("origin", 0, 0)):
        plc["kept"], plc["saved"], plc["velocity"] = 5, 6, 9.0
        plc.force("run", True)
        plc.scan(3)
        plc.reset(kind)
        assert (plc["kept"], plc["saved"], plc["velocity"], plc["counter"]) == (kept, saved, 0.5, 0)
        assert plc.scans == 0 and plc.time == 0.0 and not plc.forced
        plc.scan(2)
        assert plc.time == 0.002
    plc["kept"] = 5
    plc.power_cycle()
    assert plc["kept"] == 5
    with pytest.raises(ValueError, match="warm, cold and origin"):
        plc.reset("hot")


def test_a_fault_stops_the_plc_and_leaves_the_image(plc):
    plc.scan(4)
    plc.schedule("divide", True, at="#6")
    with pytest.raises(Fault):
        plc.scan(10)
    assert plc.fault.code == "F0102" and plc.fault.scan == 6
    assert plc.scans == 6 and plc["counter"] == 7
    with pytest.raises(Fault):
        plc.scan()
    plc.back(1)
    assert plc.fault is None and plc.scans == 6 and plc["counter"] == 6
    plc["divide"] = False
    plc.scan()
    assert plc.scans == 7
    plc["divide"] = True
    with pytest.raises(Fault):
        plc.run_until(lambda: False)
    plc.reset("origin")
    plc.scan()
    assert plc.fault is None and plc.scans == 1


def test_the_watchdog_ends_an_endless_loop():
    plc = PLC(program(), watchdog=0.3, machine=FakeMachine)
    plc["endless"] = True
    with pytest.raises(Fault) as caught:
        plc.scan()
    assert caught.value.code == "F0108"


@pytest.fixture
def ctrl_c():
    """A shell lets what it starts in the background ignore Ctrl-C: here it counts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def press_ctrl_c_when(condition):
    def wait():
        while not condition():
            time.sleep(0.005)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=wait, daemon=True).start()


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_in_an_endless_loop(plc):
    plc.scan(3)
    plc["endless"] = True
    press_ctrl_c_when(lambda: plc._engine.guard._busy)
    with pytest.raises(KeyboardInterrupt):
        plc.run("10s")
    assert plc.fault.code == "F0108"
    plc.back(1)
    plc["endless"] = False
    plc.scan()
    assert plc.scans == 4
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_in_a_run_stops_at_a_boundary(plc):
    press_ctrl_c_when(lambda: plc.scans > 100)
    with pytest.raises(KeyboardInterrupt):
        plc.run("100000s")
    assert plc.fault is None
    before = plc.scans
    plc.scan()
    assert plc.scans == before + 1


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_in_a_model(plc):
    @plc.on_scan
    def hang():
        press_ctrl_c_when(lambda: True)
        for _ in range(3000):
            time.sleep(0.01)

    with pytest.raises(KeyboardInterrupt):
        plc.run("10s")
    assert plc.scans == 1


def test_axes(plc):
    assert len(plc.axes) == 2
    axis = plc.axes[1]
    plc["SIM.Axis[1].prfPos"] = 12.5
    assert axis.prfPos == axis.PRFPOS == 12.5 and axis.prfVel == 0.0
    axis.drive.alarm = True
    assert plc["SIM.Axis[1].drive.alarm"] is True
    assert "prfPos" in dir(axis)
    with pytest.raises(AttributeError, match="nope"):
        print(axis.nope)
    with pytest.raises(AttributeError):
        axis.nope = 3
    with pytest.raises(PathError, match="1..2"):
        plc.axes[3]
    assert [a.prfPos for a in plc.axes] == [12.5, 0.0]

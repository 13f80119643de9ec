import json
import re

import pytest
from fake_machine import FakeMachine, program

from plcruntime.errors import UsageError
from plcruntime.picture import axis_names, compose
from plcruntime.plc import PLC
from plcruntime.plot import draw, intervals, thinned

np = pytest.importorskip("numpy")
WATCHED = ["PLC_PRG.status", "PLC_PRG.run", "PLC_PRG.counter", "PLC_PRG.mode"]


@pytest.fixture
def moved():
    """(plc, trace) of a move of axis 1 with trapezoidal velocity; axis 2 stays."""
    plc = PLC(program(), machine=FakeMachine)

    @plc.on_scan
    def model(p):
        acceleration = 0.5 if p.scans <= 20 else 0.0 if p.scans <= 40 else -0.25 if p.scans <= 80 else 0.0
        velocity = p["SIM.Axis[1].prfVel"] + acceleration
        position = p["SIM.Axis[1].prfPos"] + velocity
        p["SIM.Axis[1]"] = {"prfAcc": acceleration, "prfVel": velocity, "prfPos": position}
        p["SIM.Axis[1].drive.alarm"] = 30 < p.scans < 35
        p["status"] = 0x600 if p.scans < 80 else 0x200
        p["run"] = p.scans < 10
        p["mode"] = 5 if p.scans < 50 else 0

    plc["status"] = 0x600
    trace = plc.trace(*axis_names(plc, 100), *WATCHED)
    plc.scan(100)
    return plc, trace


def test_what_the_picture_shows(moved):
    plc, trace = moved
    picture = compose(plc, trace, "title", WATCHED)
    titles = [p.title for p in picture.panels]
    assert titles == ["Position (pulse)", "Velocity (pulse/ms)", "Acceleration (pulse/ms²)", "counter", "mode"]
    assert [c.label for p in picture.panels[:3] for c in p.curves] == ["axis 1"] * 3  # axis 2 did not move
    assert picture.panels[1].curves[0].values.max() == 10.0
    assert picture.panels[4].names == {0: "idle", 5: "moving"}
    assert [label for label, _ in picture.lanes] == ["status.9", "status.10", "run"]


def test_without_named_variables(moved):
    plc, trace = moved
    picture = compose(plc, trace, "")
    assert [p.title for p in picture.panels] == ["Position (pulse)", "Velocity (pulse/ms)", "Acceleration (pulse/ms²)"]
    assert [label for label, _ in picture.lanes] == ["axis 1 alarm", "status.9", "status.10", "run"]


def test_without_axes(plc):
    plc["run"] = True
    trace = plc.trace()
    plc.scan(5)
    picture = compose(None, trace, "")
    assert [p.title for p in picture.panels] == ["counter", "position", "t (s)"]
    assert picture.lanes == []


@pytest.mark.parametrize("suffix, start", [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".html", b"<!doctype html>")])
def test_files(moved, tmp_path, suffix, start):
    pytest.importorskip("matplotlib")
    plc, trace = moved
    path = tmp_path / f"p{suffix}"
    draw(trace, path, plc=plc, title="a < b", watched=WATCHED)
    data = path.read_bytes()
    assert data.startswith(start) and len(data) > 5000
    if suffix != ".png":
        text = data.decode()
        for word in ("Velocity (pulse/ms)", "max 10 pulse/ms", "min -0.25 pulse/ms²", "status.10"):
            assert word in text
    if suffix == ".html":
        assert "<title>a &lt; b</title>" in text
        assert not re.search(r"(src|href)=\"https?:", text), "the page would load something"
        values = json.loads(re.search(r'<script id="data"[^>]*>(.*?)</script>', text, re.S)[1])
        assert len(values["time"]) == 100
        assert [c["label"] for c in values["columns"]][1] == "axis 1 velocity"
        assert values["columns"][-1]["values"][:2] == ["FALSE", "TRUE"]


def test_the_same_run_gives_the_same_picture(moved, tmp_path):
    pytest.importorskip("matplotlib")
    plc, trace = moved
    for name in ("a.svg", "b.svg"):
        draw(trace, tmp_path / name, plc=plc)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_more_than_fits_is_said(moved, monkeypatch):
    from plcruntime import picture

    monkeypatch.setattr(picture, "MAX_LANES", 1)
    plc, trace = moved
    assert compose(plc, trace, "x", WATCHED).title == "x (2 more values are not shown)"


def test_nothing_to_draw(plc, tmp_path):
    trace = plc.trace("run")
    with pytest.raises(UsageError, match="nothing to draw"):
        draw(trace, tmp_path / "p.png")
    with pytest.raises(UsageError, match="must end with"):
        draw(trace, tmp_path / "p.gif")


def test_stretches_of_true():
    time = np.arange(6) * 0.001
    assert intervals(time, np.array([1, 0, 0, 1, 1, 0], bool)) == [(0.0, 0.001), (0.003, pytest.approx(0.002))]
    assert intervals(time, np.zeros(6, bool)) == []
    assert intervals(time, np.ones(6, bool)) == [(0.0, pytest.approx(0.006))]


def test_thinning_keeps_the_peaks():
    time = np.arange(100_001) * 0.001
    values = np.sin(time)
    values[54_321], values[77_777] = 9.0, -9.0
    t, v = thinned(time, values)
    assert len(v) < 12_000 and v.max() == 9.0 and v.min() == -9.0 and t[-1] == time[-1]
    assert (np.diff(t) >= 0).all()

"""The HTML report: what is in it, and that a real browser shows it and answers to clicks."""

import base64
import json
import re
import shutil
import struct
import sys
import tempfile

import pytest

from plcruntime import PLC, Fault, PathError, UsageError
from plcruntime.cli import main

pytest.importorskip("plotly", reason="the report is drawn by plotly")

PROGRAM = """(* Two axes that move,
   and mistakes *)
PROGRAM PLC_PRG
VAR
  x, y : AXIS_REF_SM3; px, py : MC_Power; mx, my : MC_MoveAbsolute; bad : MC_MoveVelocity; rtn : INT; start : BOOL;
  n : DINT; zero : DINT; note : STRING := '</script><b>';
END_VAR
px(Axis := x, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
py(Axis := y, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
mx(Axis := x, Execute := start, Position := 100, Velocity := 200, Acceleration := 1000, Deceleration := 1000);
my(Axis := y, Execute := start, Position := 40, Velocity := 200, Acceleration := 500, Deceleration := 500);
IF n >= 50 AND n < 60 THEN rtn := GT_SetVel(99, 10.0); END_IF
bad(Axis := x, Execute := mx.Done, Velocity := -10, Acceleration := -1, Deceleration := 100);
n := n + 1;
IF n = 1500 THEN n := n / zero; END_IF
END_PROGRAM
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("report")


@pytest.fixture(scope="module")
def file(folder):
    """A report with an overlay."""
    (folder / "prog.st").write_text(PROGRAM)
    plc = PLC.load(folder / "prog.st")
    recording = plc.record()
    plc.schedule("start", True, "100ms")
    plc.schedule("Axis[2].drive.alarm", True, "1200ms")
    with pytest.raises(Fault):
        plc.run("2s")
    recording.trace.to_npz(folder / "other.npz")
    recording.to_html(folder / "r.html", title="a < b", overlay=folder / "other.npz", stopped="fault")
    return folder / "r.html"


def data_of(path) -> dict:
    text = path.read_text(encoding="utf-8")
    return json.loads(re.search(r'<script id="data"[^>]*>(.*?)</script>', text, re.S)[1])


def numbers(packed: str) -> list[float]:
    raw = base64.b64decode(packed)
    return list(struct.unpack(f"<{len(raw) // 8}d", raw))


def test_what_is_in_it(file):
    text = file.read_text(encoding="utf-8")
    assert "<title>a &lt; b</title>" in text and not re.search(r"<(script|link|img)[^>]+(src|href)=", text)
    data = data_of(file)
    assert [p["title"] for p in data["panels"]] == ["Position (u)", "Velocity (u/s)", "Acceleration (u/s²)"]
    labels = [c["label"] for c in data["panels"][0]["curves"]]
    assert labels == ["axis 1", "axis 2", "axis 1 (other)", "axis 2 (other)"]
    assert max(numbers(data["panels"][0]["curves"][0]["v"])) == 100.0
    assert max(numbers(data["panels"][1]["curves"][0]["v"])) == pytest.approx(200.0)
    states = {s["label"]: [state for _, _, state in s["spans"]] for s in data["states"]}
    assert states["axis 1"][-2:] == ["discrete_motion", "standstill"] and states["axis 2"][-1] == "errorstop"
    assert "PLC_PRG.n" in [p["title"] for p in data["others"]]


def test_events(file):
    data = data_of(file)
    events = [(e["kind"], e["text"]) for e in data["events"]]
    line = PROGRAM.splitlines().index(next(x for x in PROGRAM.splitlines() if "GT_SetVel" in x)) + 1
    command = next(e for e in data["events"] if e["kind"] == "command")
    assert command["text"].startswith("GT_SetVel(99) returned 7: ") and "(10 times until 0.059 s)" in command["text"]
    assert command["time"] == 0.05 and command["lines"] == [[0, line]]
    block = next(e for e in data["events"] if e["kind"] == "block")
    assert block["text"].startswith("PLC_PRG.bad (MC_MoveVelocity) reports an error: SMC_")
    assert ("stimulus", "PLC_PRG.start := TRUE") in events
    assert ("axis", "axis 2: the drive reports an alarm") in events
    assert events[-1][0] == "fault" and "F0102" in events[-1][1] and data["events"][-1]["lines"]
    assert [e["time"] for e in data["events"]] == sorted(e["time"] for e in data["events"])
    lines = data["files"][0]["html"]
    assert lines[0] == '<i class="c">(* Two axes that move,</i>' and lines[1] == '<i class="c">   and mistakes *)</i>'
    assert any("&lt;/script&gt;" in x for x in lines)


def test_named_variables_and_programs_without_axes(folder):
    plc = PLC.load("PROGRAM PLC_PRG VAR n : DINT; on : BOOL; m : DINT; END_VAR n := n + 1; on := n.3; END_PROGRAM\n")
    recording = plc.record("n", "on")
    plc.scan(100_000)
    recording.to_html(folder / "small.html")
    data = data_of(folder / "small.html")
    assert [p["title"] for p in data["panels"]] == ["n"] and [lane["label"] for lane in data["lanes"]] == ["on"]
    assert data["events"] == [] and data["files"][0]["name"] == "<text>"
    assert len(numbers(data["panels"][0]["curves"][0]["v"])) == 100_000
    with pytest.raises(PathError):
        plc.record("nope")


def test_a_missing_extra_is_told_before_anything_runs(folder, monkeypatch, capsys):
    (folder / "p.st").write_text("PROGRAM PLC_PRG VAR n : INT; END_VAR n := n + 1; END_PROGRAM\n")
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    assert main(["run", str(folder / "p.st"), "--report", str(folder / "no.html")]) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and "pip install 'scancycle[report]'" in printed.err and not (folder / "no.html").exists()


def test_overlays_that_are_none(folder, file):
    plc = PLC.load("PROGRAM PLC_PRG VAR n : INT; END_VAR n := n + 1; END_PROGRAM\n")
    recording = plc.record()
    plc.scan(10)
    (folder / "text.npz").write_text("no")
    for overlay, words in (("no.npz", "can't read"), ("text.npz", "is no trace"), ("far.npz", "none of the variables")):
        if overlay == "far.npz":
            other = PLC.load("PROGRAM Other VAR k : INT; END_VAR k := k + 1; END_PROGRAM\n")
            trace = other.trace()
            other.scan(5)
            trace.to_npz(folder / overlay)
        with pytest.raises(UsageError, match=words):
            recording.to_html(folder / "o.html", overlay=folder / overlay)


# ------------------------------------------------------------------------------------------- in a browser

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --window-size=1600,1000 --host-resolver-rules=MAP*~NOTFOUND"
)


@pytest.fixture(scope="module")
def browser():
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium drives the browser")
    if not CHROMIUM or not DRIVER:
        pytest.skip("no Chromium with its driver: apt-get install chromium chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    with tempfile.TemporaryDirectory() as profile:
        for flag in (*FLAGS.split(), f"--user-data-dir={profile}"):
            options.add_argument(flag.replace("MAP*~", "MAP * ~"))
        driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
        yield driver
        driver.quit()


@pytest.fixture
def page(browser, file):
    """The report, drawn."""
    from selenium.webdriver.support.ui import WebDriverWait

    browser.get(f"file://{file}")
    WebDriverWait(browser, 60).until(lambda b: b.execute_script("return document.body.dataset.ready"))
    return browser


def find(page, selector: str):
    return page.find_elements("css selector", selector)


def drag(page, first: float, last: float) -> None:
    """Press at a part of the width of the first panel, release at another."""
    from selenium.webdriver.common.action_chains import ActionBuilder

    left, width, top = page.execute_script(
        "const p = document.getElementById('time'), s = p._fullLayout._size, b = p.getBoundingClientRect();"
        "return [b.left + s.l, s.w, b.top + s.t];"
    )
    actions = ActionBuilder(page)
    pointer = actions.pointer_action
    pointer.move_to_location(round(left + width * first), round(top + 40)).pointer_down()
    if first != last:
        pointer.move_to_location(round(left + width * (first + last) / 2), round(top + 44))
        pointer.move_to_location(round(left + width * last), round(top + 44))
    pointer.pointer_up()
    actions.perform()


def click_plot(page, part: float) -> None:
    drag(page, part, part)


def test_it_opens_without_network_and_without_errors(page, folder):
    assert [e for e in page.get_log("browser") if e["level"] == "SEVERE"] == []
    assert page.execute_script("return performance.getEntriesByType('resource').length") == 0
    assert len(find(page, "#time .scatterlayer .trace")) == 12 and len(find(page, "#time .barlayer .trace")) >= 4
    hidden = "const p = document.getElementById('plots'); return p.scrollHeight - p.clientHeight;"
    assert page.execute_script(hidden) <= 0  # the time axis is in the window
    assert page.save_screenshot(str(folder / "report.png")) and (folder / "report.png").stat().st_size > 20_000


def test_cursors(page):
    click_plot(page, 0.2)
    find(page, "[data-cursor='1']")[0].click()
    click_plot(page, 0.9)
    rows = {row.text.split(" axis")[0].split()[0]: row.text for row in find(page, "#cursors tbody tr")}
    assert set(rows) >= {"time", "Position,", "Velocity,"}
    numbers = [float(x) for x in re.findall(r"[\d.]+(?= s)", rows["time"])]
    assert 0.2 < numbers[0] < 0.4 and 1.2 < numbers[1] < 1.5 and numbers[2] == pytest.approx(numbers[1] - numbers[0])
    from selenium.webdriver.common.keys import Keys

    page.switch_to.active_element.send_keys(Keys.ARROW_RIGHT)
    after = float(re.findall(r"[\d.]+(?= s)", find(page, "#cursors tr.time")[0].text)[1])
    assert after == pytest.approx(numbers[1] + 0.001)
    find(page, "#clear")[0].click()
    assert find(page, "#cursors tr.time")[0].text == "time"


def test_an_event_shows_its_line(page):
    event = find(page, "#events li.command")[0]
    event.click()
    marked = find(page, "#program code.on")
    assert ["GT_SetVel" in m.text for m in marked] == [True]
    assert "0.05 s" in find(page, "#cursors tr.time")[0].text
    assert len(find(page, "#program code.error")) >= 3


def test_zoom_more_variables_and_xy(page):
    from selenium.webdriver.support.ui import Select, WebDriverWait

    drag(page, 0.4, 0.6)
    asked = "return document.getElementById('time')._fullLayout.xaxis.range"
    WebDriverWait(page, 20).until(lambda b: b.execute_script(asked)[0] > 0)
    low, high = page.execute_script(asked)
    assert 0.55 < low < 0.65 and 0.85 < high < 0.95
    assert find(page, "#cursors tr.time")[0].text == "time"  # a drag sets no cursor
    Select(find(page, "#add")[0]).select_by_visible_text("PLC_PRG.n")
    assert len(find(page, "#time .scatterlayer .trace")) == 14
    assert page.execute_script(asked) == [low, high]
    find(page, "#events li.command")[0].click()  # at 0.05 s, outside of what is shown
    assert page.execute_script(asked) == pytest.approx([0, high - low])
    find(page, "[data-view='xy']")[0].click()
    assert len(find(page, "#xy .scatterlayer .trace")) == 2
    assert find(page, "#x")[0].get_attribute("value") == "0"
    Select(find(page, "#y")[0]).select_by_visible_text("Velocity, axis 1")
    first = "document.getElementById('xy').data[0]"
    titles = [find(page, f"#xy .{axis}title")[0].text for axis in "xy"]
    assert titles[1] == "Velocity, axis 1 (u/s)" and titles[0].endswith("axis 1 (u)")
    ends = page.execute_script(f"return [Math.max(...{first}.x), Math.max(...{first}.y)]")
    assert ends == pytest.approx([100.0, 200.0])

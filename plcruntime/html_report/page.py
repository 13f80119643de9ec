"""Puts a report together: data as JSON, the page's own style and script, and plotly's script inside the file."""

from __future__ import annotations

import base64
import html
import json
import re
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from plcruntime import durations, report
from plcruntime.axes import ROOT
from plcruntime.errors import UsageError
from plcruntime.html_report import events
from plcruntime.html_report.overlay import Overlay
from plcruntime.picture import Curve, Panel, axis_label, compose, value_panel
from plcruntime.plot import thinned
from stcore import paths

if TYPE_CHECKING:
    from plcruntime.html_report.recording import Recording

INSTALL = "a report needs plotly: pip install 'scancycle[report]'"
OTHERS = 400  # variables that can be added to the plot


def write(recording: Recording, path: Path, title: str, overlay: Path | None, stopped: str) -> None:
    """Write the page. Raises UsageError, OSError."""
    script = plotly_script()
    other = Overlay(overlay, recording.trace.places) if overlay else None
    data = _data(recording, title, other, stopped)
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("</", "<\\/")
    parts = resources.files("plcruntime") / "html_report"
    page = (parts / "page.html").read_text(encoding="utf-8")
    fill = {
        "TITLE": html.escape(title or "scancycle"), "STYLE": (parts / "page.css").read_text(encoding="utf-8"),
        "PLOTLY": script, "DATA": text, "SCRIPT": (parts / "page.js").read_text(encoding="utf-8"),
    }  # fmt: skip
    path.write_text(re.sub(r"@@(\w+)@@", lambda m: fill[m[1]], page), encoding="utf-8")


def plotly_script() -> str:
    """The script that draws. Raises UsageError when plotly is not installed."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise UsageError(INSTALL) from None
    return get_plotlyjs().replace("</script", "<\\/script")


def _data(recording: Recording, title: str, other: Overlay | None, stopped: str) -> dict:
    plc, trace = recording.plc, recording.trace
    picture = compose(plc, trace if recording.names else _Own(trace, plc), title, recording.names)
    behind = compose(plc, other, "", recording.names or trace.names) if other else None
    panels = [_panel(panel, picture.time, _same(behind, panel), other) for panel in picture.panels]
    shown = {c.label for p in picture.panels for c in p.curves} | {label for label, _ in picture.lanes}
    sources = events.sources_of(plc)
    found = events.collect(recording, sources)
    return {
        "title": title, "interval": plc.interval, "end": plc.time, "panels": panels,
        "others": _others(recording, shown, other), "lanes": _lanes(picture),
        "states": _states(recording), "overlay": other.path.name if other else None,
        "events": [{"time": e.time, "kind": e.kind, "text": e.text, "lines": e.lines} for e in found],
        "files": [{"name": Path(p).name, "html": _marked(text)} for p, text in sources],
        "facts": _facts(recording, stopped),
    }  # fmt: skip


class _Own:
    """A trace without the members of structures and instances: they can be added, but are too many at first."""

    def __init__(self, trace, plc) -> None:
        own = {p.name for p in paths.user_places(plc.program)}
        self.places = [p for p in trace.places if p.name in own or p.name.startswith(ROOT)]
        self.names = [p.name for p in self.places]
        self.time, self._trace = trace.time, trace

    def __getitem__(self, name: str):
        return self._trace[name]

    def __len__(self) -> int:
        return len(self._trace)


def _facts(recording: Recording, stopped: str) -> list[list[str]]:
    plc = recording.plc
    facts = [
        ["virtual time", f"{plc.time:.9g} s"],
        ["scans", f"{plc.scans} of {durations.text(round(plc.interval * 1e9))}"],
    ]
    facts += [["stopped", stopped]] if stopped else []
    facts += [["fault", report.fault_text(plc.fault, plc.time).split("\n")[0]]] if plc.fault else []
    return facts


# ------------------------------------------------------------------------------------------------- curves


def _panel(panel: Panel, time, behind: Panel | None, other: Overlay | None) -> dict:
    curves = [_curve(c, time) for c in panel.curves]
    for curve in behind.curves if behind else []:
        curves.append({**_curve(curve, other.time), "label": f"{curve.label} ({other.path.stem})", "overlay": True})
    return {"title": panel.title, "curves": curves, "names": {str(k): v for k, v in panel.names.items()}}


def _same(picture, panel: Panel) -> Panel | None:
    """The panel of another picture with the same title, with those curves that this one has."""
    labels = {c.label for c in panel.curves}
    for candidate in picture.panels if picture else []:
        if candidate.title == panel.title:
            return Panel(panel.title, [c for c in candidate.curves if c.label in labels])
    return None


def _curve(curve: Curve, time) -> dict:
    """Only the ends of stretches without change, and the extremes of a curve with very many points."""
    import numpy as np

    values = np.asarray(curve.values)
    ends = np.concatenate(([True], values[1:] != values[:-1], [True]))[: len(values) + 1]
    at = np.flatnonzero(ends[:-1] | ends[1:])
    t, v = thinned(time[at], values[at]) if not curve.stepped else (time[at], values[at])
    return {"label": curve.label, "unit": curve.unit, "stepped": curve.stepped, "t": _packed(t), "v": _packed(v)}


def _packed(values) -> str:
    """Numbers as the bytes of doubles: exact, and short enough."""
    import numpy as np

    return base64.b64encode(np.asarray(values, "<f8").tobytes()).decode("ascii")


def _others(recording: Recording, shown: set[str], other: Overlay | None) -> list[dict]:
    """Panels for variables that changed and are not drawn at first."""
    trace = recording.trace
    panels = []
    for place in trace.places:
        if len(panels) == OTHERS:
            break
        hidden = place.name.startswith(ROOT) or place.name.split(".", 1)[-1] in shown
        if hidden or not paths.is_scalar(place) or not len(trace):
            continue
        column = trace[place.name]
        if column.dtype == object or not (column != column[0]).any():
            continue
        panel = value_panel(place, column)
        panel.title = panel.title.replace(panel.curves[0].label, place.name)
        panel.curves[0].label = place.name
        behind = None
        if other and place.name in other.names:
            behind = value_panel(place, other[place.name])
            behind.curves[0].label = place.name
        panels.append(_panel(panel, trace.time, behind, other))
    return panels


def _lanes(picture) -> list[dict]:
    from plcruntime.plot import intervals

    return [{"label": label, "spans": intervals(picture.time, values)} for label, values in picture.lanes]


def _states(recording: Recording) -> list[dict]:
    """For each axis that was ever switched on: (start, length, state) of every stretch."""
    import numpy as np

    trace, plc = recording.trace, recording.plc
    known, found = set(trace.names), []
    for number, name in zip(plc.axes.numbers, recording.state_names, strict=False):
        column = trace[name] if name in known else np.empty(0)
        if not len(column) or not (column != column[0]).any() and not column[0]:
            continue
        labels = {v: n for n, v in plc.place(name).type.values.items()}
        edges = np.flatnonzero(np.concatenate(([True], column[1:] != column[:-1])))
        ends = np.append(edges[1:], len(column))
        spans = [
            [float(trace.time[a]), float((b - a) * plc.interval), labels.get(int(column[a]), str(column[a]))]
            for a, b in zip(edges, ends, strict=True)
        ]
        found.append({"label": axis_label(plc, number), "spans": spans})
    return found


# ------------------------------------------------------------------------------------------------ program

_WORDS = (
    "PROGRAM|FUNCTION_BLOCK|FUNCTION|END_\\w+|VAR\\w*|CONSTANT|RETAIN|PERSISTENT|TYPE|STRUCT|UNION|IF|THEN|ELSIF|ELSE|CASE|"
    "OF|FOR|TO|BY|DO|WHILE|REPEAT|UNTIL|EXIT|CONTINUE|RETURN|ARRAY|POINTER|REFERENCE|AT|AND|OR|XOR|NOT|MOD|TRUE|FALSE"
)
_MARKS = re.compile(
    rf"(?P<c>//[^\n]*|\(\*.*?(?:\*\)|\Z))|(?P<s>'[^'\n]*'|\"[^\"\n]*\")|\b(?P<k>{_WORDS})\b", re.IGNORECASE | re.DOTALL
)


def _marked(text: str) -> list[str]:
    """The lines of ST as HTML, with comments, texts and keywords marked."""
    out, at = [], 0
    for m in _MARKS.finditer(text):
        marked = "\n".join(f'<i class="{m.lastgroup}">{html.escape(part)}</i>' for part in m[0].split("\n"))
        out += [html.escape(text[at : m.start()]), marked]
        at = m.end()
    return "".join([*out, html.escape(text[at:])]).rstrip("\n").split("\n")

"""A plot as one HTML file: the SVG drawing, the data, and a cursor that reads the values; needs no network."""

from __future__ import annotations

import html
import json

from plcruntime.picture import Picture
from plcruntime.plot import render

MAX_POINTS = 20_000  # rows of data kept for the cursor

_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<style>
body {{ margin: 1.5rem auto; max-width: 78rem; font: 14px/1.4 system-ui, sans-serif; color: #22303c; background: #fff }}
main {{ display: grid; grid-template-columns: minmax(0, 1fr) 16rem; gap: 1rem; align-items: start }}
svg {{ width: 100%; height: auto; cursor: crosshair }}
svg text {{ font-family: "DejaVu Sans", Verdana, system-ui, sans-serif !important }}
table {{ border-collapse: collapse; width: 100%; font-size: 13px }}
td {{ padding: 2px 4px; border-bottom: 1px solid #e6eaed }}
td + td {{ text-align: right; font-variant-numeric: tabular-nums }}
caption {{ text-align: left; font-weight: 600; padding: 4px }}
p {{ color: #66727c; font-size: 12px }}
</style></head><body>
<main><div id="plot" tabindex="0">{svg}</div>
<div><table><caption id="time">time</caption><tbody id="values"></tbody></table>
<p>Move the pointer over the plot; the arrow keys step by one scan.</p></div></main>
<script id="data" type="application/json">{data}</script>
<script>
const data = JSON.parse(document.getElementById("data").textContent);
const plot = document.getElementById("plot"), svg = plot.querySelector("svg"), box = svg.viewBox.baseVal;
const left = data.box[0] * box.width, width = data.box[2] * box.width;
const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
const fixed = {{ y1: data.top * box.height, y2: data.bottom * box.height, stroke: "#c8502d", "stroke-width": 0.8 }};
for (const [k, v] of Object.entries(fixed)) line.setAttribute(k, v);
svg.appendChild(line);
const first = data.time[0], last = data.end, body = document.getElementById("values");
const cells = data.columns.map(c => {{
  const row = body.insertRow();
  row.insertCell().textContent = c.label;
  return row.insertCell();
}});
let at = 0;
function show(i) {{
  at = Math.max(0, Math.min(data.time.length - 1, i));
  const x = left + (data.time[at] - first) / (last - first) * width;
  line.setAttribute("x1", x); line.setAttribute("x2", x);
  document.getElementById("time").textContent = "time " + data.time[at] + " s";
  data.columns.forEach((c, k) => {{ cells[k].textContent = c.values[at] + (c.unit ? " " + c.unit : ""); }});
}}
function find(t) {{
  let a = 0, b = data.time.length;
  while (b - a > 1) {{ const m = (a + b) >> 1; if (data.time[m] <= t) a = m; else b = m; }}
  return a;
}}
svg.addEventListener("mousemove", e => {{
  const p = new DOMPoint(e.clientX, e.clientY).matrixTransform(svg.getScreenCTM().inverse());
  show(find(first + (p.x - left) / width * (last - first)));
}});
plot.addEventListener("keydown", e => {{
  const by = {{ ArrowLeft: -1, ArrowRight: 1 }}[e.key];
  if (by) {{ show(at + by); e.preventDefault(); }}
}});
show(0);
</script></body></html>
"""


def page(picture: Picture) -> str:
    """The HTML text of a picture."""
    image, boxes = render(picture, "svg")
    svg = image.decode("utf-8")
    svg = svg[svg.index("<svg") :]
    stride = -(-len(picture.time) // MAX_POINTS) or 1
    columns = [
        {"label": f"{c.label} {p.title.split(' (')[0].lower()}" if p.limits else c.label, "unit": c.unit,
         "values": [_number(v) for v in c.values[::stride].tolist()]}
        for p in picture.panels for c in p.curves
    ]  # fmt: skip
    columns += [
        {"label": label, "unit": "", "values": ["TRUE" if v else "FALSE" for v in values[::stride].tolist()]}
        for label, values in picture.lanes
    ]
    time = picture.time[::stride].tolist()
    step = picture.time[1] - picture.time[0] if len(picture.time) > 1 else 0.001
    data = {
        "time": [_number(t) for t in time], "end": float(picture.time[-1] + step), "columns": columns, "box": boxes[0],
        "top": 1 - boxes[0][1] - boxes[0][3], "bottom": 1 - boxes[-1][1],
    }  # fmt: skip
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("</", "<\\/")
    return _PAGE.format(title=html.escape(picture.title or "scancycle"), svg=svg, data=text)


def _number(value):
    """A number short enough to read; one that JSON can't hold as text."""
    if isinstance(value, float):
        return float(f"{value:.9g}") if value - value == 0 else str(value)
    return value

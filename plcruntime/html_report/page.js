"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const $ = id => document.getElementById(id);
const COLOURS = ["#1f5fa8", "#c8502d", "#2f8f57", "#8a4fa3", "#b8860b", "#3a9aa8", "#a83a5c", "#5c6670"];
const CONFIG = { responsive: true, displaylogo: false,
  modeBarButtons: [["toImage", "zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d"]] };
const CURSORS = ["#1f5fa8", "#c8502d"];
const STATES = { power_off: "#c9d1d8", errorstop: "#d64535", stopping: "#e8a33d", standstill: "#8fb8de",
  discrete_motion: "#2f8f57", continuous_motion: "#3a9aa8", synchronized_motion: "#8a4fa3", homing: "#b8860b" };

function numbers(text) {
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  return new Float64Array(bytes.buffer);
}
for (const panel of [...data.panels, ...data.others])
  for (const curve of panel.curves) { curve.t = numbers(curve.t); curve.v = numbers(curve.v); curve.panel = panel; }

/* The value of a curve at a time: held between scans, or on the line between two points. */
function valueAt(curve, time) {
  const t = curve.t, n = t.length;
  if (!n || time < t[0] - 1e-12) return NaN;
  let a = 0, b = n;
  while (b - a > 1) { const m = (a + b) >> 1; if (t[m] <= time + 1e-12) a = m; else b = m; }
  if (curve.stepped || a === n - 1 || t[a + 1] === t[a]) return curve.v[a];
  return curve.v[a] + (curve.v[a + 1] - curve.v[a]) * (time - t[a]) / (t[a + 1] - t[a]);
}

/* ---------------------------------------------------------------------------------- the plot over time */

let panels = [...data.panels];
const cursors = [null, null];
let active = 0, range = null;

function draw() {
  const lanes = data.lanes.length + data.states.length;
  const gap = 34, top = 44, bottom = 46, timelines = lanes ? 24 * lanes + 14 + gap : 0;
  const room = ($("plots").clientHeight - top - bottom - timelines + gap) / Math.max(1, panels.length) - gap;
  const fair = Math.max(100, Math.min(260, Math.floor(room)));  // the time axis stays in the window where that can be
  const heights = panels.map(p => Object.keys(p.names || {}).length ? Math.min(110, fair) : fair);
  if (lanes) heights.push(24 * lanes + 14);
  const total = heights.reduce((a, b) => a + b, 0) + gap * Math.max(0, heights.length - 1);
  const traces = [], layout = {
    height: Math.max(total + top + bottom, 200), margin: { l: 128, r: 16, t: top, b: bottom }, showlegend: false,
    hovermode: "x", dragmode: "zoom", shapes: [], annotations: [], font: { size: 11, color: "#22303c" },
    xaxis: { title: { text: "time (s)" }, anchor: "free", position: 0, gridcolor: "#eef1f3", zeroline: false,
      range: range || [0, data.end || 1], autorange: false, showspikes: true, spikemode: "across", spikethickness: 1 },
  };
  let at = total;
  heights.forEach((height, k) => {
    const name = k ? "yaxis" + (k + 1) : "yaxis", ref = k ? "y" + (k + 1) : "y";
    const domain = [(at - height) / total, at / total];
    at -= height + gap;
    const axis = layout[name] = { domain: domain.map(d => Math.max(0, Math.min(1, d))), gridcolor: "#eef1f3",
      zerolinecolor: "#cdd5db" };
    const panel = panels[k];
    if (!panel) { timeline(traces, layout, axis, ref); return; }
    axis.title = { text: panel.title.length > 24 ? "…" + panel.title.slice(-23) : panel.title, standoff: 4 };
    const labels = Object.entries(panel.names || {});
    if (labels.length) { axis.tickvals = labels.map(l => +l[0]); axis.ticktext = labels.map(l => l[1]); }
    panel.curves.forEach((curve, i) => traces.push({
      x: curve.t, y: curve.v, yaxis: ref, name: curve.label, type: "scatter", mode: "lines",
      line: { color: curve.overlay ? "#9aa5ae" : COLOURS[i % COLOURS.length], width: 1.6, dash: curve.overlay ? "dash" : "solid",
        shape: curve.stepped ? "hv" : "linear", simplify: false },
      hovertemplate: "%{y} " + curve.unit + "<extra>" + curve.label + "</extra>",
    }));
    if (panel.curves.length > 1) legend(layout, panel, domain[1]);
  });
  layout.shapes.push(...cursorShapes());
  return Plotly.react("time", traces, layout, CONFIG);
}

/* The names of a panel's curves above it, in their colours. */
function legend(layout, panel, y) {
  const parts = panel.curves.map((c, i) =>
    `<span style="color:${c.overlay ? "#7c8791" : COLOURS[i % COLOURS.length]}">${c.overlay ? "┅" : "━"} ${c.label}</span>`);
  layout.annotations.push({ xref: "paper", yref: "paper", x: 1, y, xanchor: "right", yanchor: "bottom", showarrow: false,
    text: parts.join("   "), font: { size: 10 } });
}

function timeline(traces, layout, axis, ref) {
  const rows = [...data.states, ...data.lanes], count = rows.length, bars = {};
  rows.forEach((row, k) => row.spans.forEach(([start, length, state]) => {
    const key = state || "TRUE";
    const bar = bars[key] = bars[key] || { base: [], x: [], y: [], text: [] };
    bar.base.push(start); bar.x.push(length); bar.y.push(count - 1 - k);
    bar.text.push(`${row.label}: ${key}<br>${start.toPrecision(6)} s to ${(start + length).toPrecision(6)} s`);
  }));
  for (const [key, bar] of Object.entries(bars)) traces.push({
    type: "bar", orientation: "h", base: bar.base, x: bar.x, y: bar.y, yaxis: ref, name: key, width: 0.62, hovertext: bar.text,
    text: bar.x.map(x => key !== "TRUE" && x > data.end / 14 ? key : ""), textposition: "inside", insidetextanchor: "middle",
    textfont: { size: 10 }, hoverinfo: "text", marker: { color: STATES[key] || "#4a7fb5" },
  });
  Object.assign(axis, { range: [-0.6, count - 0.4], tickvals: rows.map((_, k) => count - 1 - k), fixedrange: true,
    ticktext: rows.map(r => r.label.length > 20 ? "…" + r.label.slice(-19) : r.label), showgrid: false, zeroline: false });
  layout.barmode = "overlay";
}

function cursorShapes() {
  return cursors.flatMap((t, k) => t === null ? [] : [{ type: "line", xref: "x", yref: "paper", x0: t, x1: t, y0: 0, y1: 1,
    line: { color: CURSORS[k], width: 1.2, dash: k ? "dot" : "solid" } }]);
}

/* ------------------------------------------------------------------------------------------- cursors */

/* Moves what is shown so that a time lies inside, when it does not. */
function bringIntoView(time) {
  const [low, high] = $("time")._fullLayout.xaxis.range, width = high - low;
  if (time >= low && time <= high) return;
  const start = Math.max(0, Math.min(data.end - width, time - width / 2));
  Plotly.relayout("time", { "xaxis.range": [start, start + width] });
}

function setCursor(k, time) {
  cursors[k] = time === null ? null : Math.max(0, Math.min(data.end, Math.round(time / data.interval) * data.interval));
  Plotly.relayout("time", { shapes: cursorShapes() });
  table();
}

function text(value, panel) {
  if (Number.isNaN(value)) return "";
  const label = panel && panel.names && panel.names[value];
  return label || String(+value.toPrecision(8));
}

function table() {
  const [a, b] = cursors, body = document.querySelector("#cursors tbody"), rows = [];
  const cell = v => v === null ? "" : v;
  const time = [a, b, a !== null && b !== null ? b - a : null].map(t => t === null ? "" : +t.toPrecision(9) + " s");
  rows.push(["time", ...time, "time"]);
  for (const panel of panels) for (const curve of panel.curves) {
    const va = a === null ? NaN : valueAt(curve, a), vb = b === null ? NaN : valueAt(curve, b);
    const unit = curve.unit ? " " + curve.unit : "";
    const name = panel.title.startsWith(curve.label) ? panel.title : panel.title.split(" (")[0] + ", " + curve.label;
    rows.push([name, text(va, panel) && text(va, panel) + unit, text(vb, panel) && text(vb, panel) + unit,
      text(vb - va) && text(vb - va) + unit, ""]);
  }
  body.replaceChildren(...rows.map(row => {
    const tr = document.createElement("tr");
    tr.className = row[4];
    tr.append(...row.slice(0, 4).map(value => {
      const td = document.createElement("td");
      td.textContent = cell(value);
      td.title = td.textContent;
      return td;
    }));
    return tr;
  }));
}

function chooseCursor(k) {
  active = k;
  document.querySelectorAll("[data-cursor]").forEach(b => b.classList.toggle("on", +b.dataset.cursor === k));
}
document.querySelectorAll("[data-cursor]").forEach(b => b.onclick = () => chooseCursor(+b.dataset.cursor));
$("clear").onclick = () => { setCursor(0, null); setCursor(1, null); chooseCursor(0); };
$("reset").onclick = () => Plotly.relayout("time", { "xaxis.range": [0, data.end || 1] });
document.addEventListener("keydown", e => {
  const by = { ArrowLeft: -1, ArrowRight: 1 }[e.key];
  if (!by || cursors[active] === null || e.target.tagName === "SELECT") return;
  setCursor(active, cursors[active] + by * data.interval);
  bringIntoView(cursors[active]);
  e.preventDefault();
});

/* A click that was no drag sets the cursor where the pointer is, on a curve or beside it. */
let pressed = null;
$("time").addEventListener("mousedown", e => { pressed = [e.clientX, e.clientY]; }, true);
document.addEventListener("mouseup", e => {
  const from = pressed;
  pressed = null;
  if (!from || Math.hypot(e.clientX - from[0], e.clientY - from[1]) > 3 || e.target.closest(".modebar")) return;
  const layout = $("time")._fullLayout, box = $("time").getBoundingClientRect();
  const x = e.clientX - box.left - layout._size.l;
  if (x >= 0 && x <= layout._size.w) setCursor(e.shiftKey ? 1 : active, layout.xaxis.p2d(x));
}, true);

/* -------------------------------------------------------------------------------- events and program */

let file = 0;
function showFile(k) {
  file = k;
  document.querySelectorAll("#tabs button").forEach((b, i) => b.classList.toggle("on", i === k));
  const source = data.files[k], marked = new Set(), bad = document.querySelector("#program pre");
  data.events.filter(e => e.kind !== "stimulus").forEach(e => e.lines.forEach(([f, n]) => f === k && marked.add(n)));
  bad.replaceChildren(...source.html.map((line, i) => {
    const code = document.createElement("code");
    code.innerHTML = line || " ";
    code.classList.toggle("error", marked.has(i + 1));
    return code;
  }));
}
function showLines(lines) {
  if (lines.length && lines[0][0] !== file) showFile(lines[0][0]);
  const codes = document.querySelectorAll("#program pre code");
  codes.forEach(c => c.classList.remove("on"));
  lines.filter(l => l[0] === file).forEach(([, n], i) => {
    if (!codes[n - 1]) return;
    codes[n - 1].classList.add("on");
    if (!i) codes[n - 1].scrollIntoView({ block: "center" });
  });
}
data.files.forEach((f, k) => {
  const button = document.createElement("button");
  button.textContent = f.name;
  button.onclick = () => showFile(k);
  $("tabs").append(button);
});
if (data.files.length) showFile(0);

data.events.forEach(event => {
  const li = document.createElement("li"), time = document.createElement("time"), span = document.createElement("span");
  li.className = event.kind;
  time.textContent = +event.time.toPrecision(9) + " s";
  span.textContent = event.text;
  li.append(time, span);
  li.onclick = () => {
    document.querySelectorAll("#events li").forEach(other => other.classList.toggle("on", other === li));
    setCursor(active, event.time);
    bringIntoView(event.time);
    showLines(event.lines);
  };
  document.querySelector("#events ol").append(li);
});
if (!data.events.length) document.querySelector("#events ol").textContent = "none";

data.facts.forEach(([name, value]) => {
  const div = document.createElement("div"), dt = document.createElement("dt"), dd = document.createElement("dd");
  dt.textContent = name;
  dd.textContent = value;
  div.append(dt, dd);
  $("facts").append(div);
});

/* --------------------------------------------------------------------------------- more variables, XY */

data.others.forEach((panel, k) => $("add").add(new Option(panel.title, k)));
$("add").onchange = () => {
  if ($("add").value === "") return;
  const panel = data.others[+$("add").value];
  panels = panels.includes(panel) ? panels.filter(p => p !== panel) : [panel, ...panels];
  $("add").value = "";
  range = $("time")._fullLayout.xaxis.range.slice();
  draw();
  table();
  $("plots").scrollTop = 0;
};

const curves = [...data.panels, ...data.others].flatMap(panel => panel.curves.filter(c => !c.overlay).map(curve => ({
  curve, panel, over: panel.curves.find(c => c.overlay && c.label.startsWith(curve.label + " (")),
  name: panel.title.startsWith(curve.label) ? panel.title : panel.title.split(" (")[0] + ", " + curve.label,
})));
curves.forEach((c, k) => { $("x").add(new Option(c.name, k)); $("y").add(new Option(c.name, k)); });
if (curves.length > 1) {
  const positions = curves.map((c, k) => [c, k]).filter(([c]) => c.panel.title.startsWith("Position")).map(([, k]) => k);
  $("x").value = positions.length > 1 ? positions[0] : 0;
  $("y").value = positions.length > 1 ? positions[1] : 1;
}

function pair(cx, cy, name, colour, dash) {
  const times = cx.t.length >= cy.t.length ? cx.t : cy.t;
  return { x: Array.from(times, t => valueAt(cx, t)), y: Array.from(times, t => valueAt(cy, t)), name, type: "scatter",
    mode: "lines", line: { color: colour, width: 1.6, dash, simplify: false },
    text: Array.from(times, t => t.toPrecision(6) + " s"),
    hovertemplate: "%{x}, %{y}<br>%{text}<extra></extra>" };
}
function drawXY() {
  const x = curves[+$("x").value], y = curves[+$("y").value];
  if (!x || !y) return;
  const traces = [pair(x.curve, y.curve, "this run", COLOURS[0], "solid")];
  if (x.over && y.over) traces.push(pair(x.over, y.over, data.overlay, "#9aa5ae", "dash"));
  const unit = curve => curve.unit ? ` (${curve.unit})` : "";
  const same = x.curve.unit && x.curve.unit === y.curve.unit;
  Plotly.react("xy", traces, { height: 640, margin: { l: 80, r: 16, t: 24, b: 50 }, showlegend: traces.length > 1,
    hovermode: "closest", font: { size: 11, color: "#22303c" },
    xaxis: { title: { text: x.name + unit(x.curve) }, gridcolor: "#eef1f3" },
    yaxis: { title: { text: y.name + unit(y.curve) }, gridcolor: "#eef1f3", scaleanchor: same ? "x" : undefined } },
    CONFIG);
}
$("x").onchange = $("y").onchange = drawXY;
document.querySelectorAll("[data-view]").forEach(button => button.onclick = () => {
  const xy = button.dataset.view === "xy";
  document.querySelectorAll("[data-view]").forEach(b => b.classList.toggle("on", b === button));
  $("time").classList.toggle("hidden", xy);
  $("xy").classList.toggle("hidden", !xy);
  $("xytools").classList.toggle("hidden", !xy);
  if (xy) drawXY(); else draw();
});

draw();
table();
document.body.dataset.ready = "yes";

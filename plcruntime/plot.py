"""Draws pictures with matplotlib: PNG, SVG and, with plot_html, self-contained HTML."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

from plcruntime.errors import UsageError
from plcruntime.picture import Curve, Panel, Picture, compose

if TYPE_CHECKING:
    from plcruntime.plc import PLC
    from plcruntime.trace import Trace

SUFFIXES = (".png", ".svg", ".html")
COLOURS = ("#1f5fa8", "#c8502d", "#2f8f57", "#8a4fa3", "#b8860b", "#3a9aa8", "#a83a5c", "#5c6670")
INK, FAINT, TRUE = "#22303c", "#9aa5ae", "#4a7fb5"
BINS = 3000  # a curve with more points is drawn by the extremes of that many stretches
WIDTH = 10.0  # inches


def draw(trace: Trace, path, *, plc: PLC | None = None, title: str = "", watched: list[str] | None = None) -> None:
    """Draw a trace into a .png, .svg or .html file. Raises UsageError (suffix, nothing to draw), OSError."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise UsageError(f"can't draw into {path}: the name must end with {', '.join(SUFFIXES)}")
    picture = compose(plc, trace, title, watched)
    if not picture.panels and not picture.lanes:
        raise UsageError(f"nothing to draw into {path}: no axis moved and no variable changed; name some with --watch")
    if path.suffix.lower() == ".html":
        from plcruntime.plot_html import page

        path.write_text(page(picture), encoding="utf-8")
    else:
        path.write_bytes(render(picture, path.suffix.lower()[1:])[0])


def render(picture: Picture, form: str) -> tuple[bytes, list[tuple[float, float, float, float]]]:
    """The file's bytes, and where each plot lies in it: (left, bottom, width, height) as parts of the whole."""
    try:
        import matplotlib
    except ImportError:
        raise UsageError("drawing needs matplotlib: pip install matplotlib") from None
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    heights = [2.1 if p.limits else 1.3 for p in picture.panels]
    if picture.lanes:
        heights.append(0.35 + 0.24 * len(picture.lanes))
    style = {
        "font.family": "DejaVu Sans", "font.size": 9, "svg.fonttype": "none", "svg.hashsalt": "scancycle",
        "axes.edgecolor": FAINT, "axes.labelcolor": INK, "text.color": INK, "xtick.color": INK, "ytick.color": INK,
    }  # fmt: skip
    with matplotlib.rc_context(style):
        figure = Figure(figsize=(WIDTH, sum(heights) + 1.0), dpi=130, layout="constrained", facecolor="white")
        FigureCanvasAgg(figure)
        plots = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
        if picture.title:
            figure.suptitle(picture.title, fontsize=12, fontweight="bold", x=0.012, ha="left")
        for panel, ax in zip(picture.panels, plots, strict=False):
            _panel(ax, panel, picture.time)
        if picture.lanes:
            _lanes(plots[-1], picture)
        for ax in plots:
            _dress(ax)
        if len(picture.time):
            step = picture.time[1] - picture.time[0] if len(picture.time) > 1 else 0.001
            plots[-1].set_xlim(picture.time[0], picture.time[-1] + step)
        plots[-1].set_xlabel("time (s)")
        figure.align_ylabels(plots)
        out = io.BytesIO()
        figure.savefig(out, format=form, metadata={"Date": None} if form == "svg" else None)
        boxes = [tuple(float(v) for v in ax.get_position().bounds) for ax in plots]
    return out.getvalue(), boxes


def _dress(ax) -> None:
    ax.grid(True, axis="x", color="#e6eaed", linewidth=0.7)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    ax.set_axisbelow(True)
    ax.tick_params(length=3, color=FAINT)


def _panel(ax, panel: Panel, time) -> None:
    for k, curve in enumerate(panel.curves):
        t, v = thinned(time, curve.values)
        colour = COLOURS[k % len(COLOURS)]
        ax.plot(
            t, v, color=colour, linewidth=1.5, drawstyle="steps-post" if curve.stepped else "default", label=curve.label
        )
    ax.set_ylabel(panel.title)
    ax.grid(True, axis="y", color="#eef1f3", linewidth=0.7)
    ax.margins(y=0.16 if panel.limits else 0.1)
    if not panel.limits:
        low, high = ax.get_ylim()
        if high - low < 1e-9:
            ax.set_ylim(low - 1, high + 1)
    if panel.names:
        used = sorted(set(panel.curves[0].values.tolist()) & set(panel.names))
        ax.set_yticks(used, [panel.names[v] for v in used])
    if panel.limits and len(panel.curves) == 1:
        if panel.title.startswith("Position"):
            ax.set_title(panel.curves[0].label, loc="left", fontsize=9, color=COLOURS[0], pad=3)
        _extremes(ax, panel.curves[0], panel.title.startswith("Position"))
    elif len(panel.curves) > 1:
        for k, curve in enumerate(panel.curves):
            ax.lines[k].set_label(f"{curve.label}: {_range_text(curve, panel.title.startswith('Position'))}")
        # above the plot: no curve runs there
        above = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.1, "frameon": False}
        ax.legend(fontsize=8, ncols=min(4, len(panel.curves)), **above)


def _extremes(ax, curve: Curve, position: bool) -> None:
    """A dotted line with its value at the highest and the lowest point; for a position at its end."""
    values = curve.values
    high, low = float(values.max()), float(values.min())
    least = 1e-6 * max(abs(high), abs(low))  # what rounding leaves of a zero is no limit
    marks = [float(values[-1])] if position else sorted(v for v in {high, low} if abs(v) > least)
    for mark in marks:
        ax.axhline(mark, color=COLOURS[1], linewidth=0.8, linestyle=(0, (2, 3)))
        what = "end" if position else "max" if mark > 0 else "min"
        up = mark >= 0
        ax.annotate(
            f"{what} {mark:.7g} {curve.unit}", (1.0, mark), xycoords=("axes fraction", "data"), ha="right",
            xytext=(-4, 3 if up else -3), textcoords="offset points", va="bottom" if up else "top", fontsize=8,
            color=COLOURS[1],
        )  # fmt: skip
    if not position:
        ax.axhline(0, color=FAINT, linewidth=0.6)


def _range_text(curve: Curve, position: bool) -> str:
    if position:
        return f"end {float(curve.values[-1]):.7g}"
    return f"max {float(abs(curve.values).max()):.6g}"


def _lanes(ax, picture: Picture) -> None:
    """TRUE as a bar, one line for each BOOL."""
    count = len(picture.lanes)
    for k, (_, values) in enumerate(picture.lanes):
        y = count - 1 - k
        ax.axhline(y, color="#eef1f3", linewidth=0.8, zorder=0)
        ax.broken_barh(intervals(picture.time, values), (y - 0.32, 0.64), facecolors=TRUE, zorder=2)
    ax.set_ylim(-0.6, count - 0.4)
    ax.set_yticks(range(count), [label for label, _ in reversed(picture.lanes)])
    ax.tick_params(axis="y", length=0, labelsize=8)
    ax.spines["left"].set_visible(False)


def intervals(time, values) -> list[tuple[float, float]]:
    """(start, length) in s of each stretch of TRUE; a value holds until the next scan."""
    import numpy as np

    if not len(values):
        return []
    step = time[1] - time[0] if len(time) > 1 else 0.001
    edges = np.flatnonzero(np.diff(np.concatenate(([False], values, [False])).astype(np.int8)))
    ends = np.append(time, time[-1] + step)
    return [(float(ends[a]), float(ends[b] - ends[a])) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def thinned(time, values):
    """time and values, or their extremes in BINS stretches when there are too many points to draw."""
    import numpy as np

    size = len(values) // BINS
    if size < 3:
        return time, values
    rows = np.asarray(values[: size * BINS]).reshape(BINS, size)
    base = np.arange(BINS) * size
    at = np.sort(np.concatenate((base + rows.argmin(axis=1), base + rows.argmax(axis=1), base, [len(values) - 1])))
    return time[at], np.asarray(values)[at]

"""The timing chart of a block, from a run of its example: inputs and outputs over time, velocity, position, state."""

from __future__ import annotations

import contextlib
import io
import shlex
import tempfile
from dataclasses import dataclass
from pathlib import Path

import examples
import library
import numpy as np
from examples import Example

from plcruntime.cli import main
from plcruntime.plot import COLOURS, FAINT, INK, thinned
from stcore import syntax
from stcore.parser import parse
from stcore.source import Source

WIDTH, DPI = 8.3, 110
OFF = 0.2  # seconds of the axis for a time without power
ALWAYS = ("Execute", "bExecute", "Enable", "bEnable", "Done", "bDone", "Busy", "bBusy", "CommandAborted",
          "bCommandAborted", "Error", "bError", "Valid", "Enabled", "InOperation")  # fmt: skip
UNITS = {"u/s": "u/s", "u/s2": "u/s²", "u/s3": "u/s³"}


@dataclass(slots=True)
class Run:
    """What an example did. stretches: (time, columns by path) from power on to power off, times going on."""

    example: Example
    types: dict[str, str]  # type of each variable of the program
    stretches: list[tuple[np.ndarray, dict[str, np.ndarray]]]

    def ever(self, path: str) -> bool:
        """It changed."""
        first = self.stretches[0][1][path][0]
        return any((c[path] != first).any() for _, c in self.stretches)


def draw(block: library.Block, path: Path) -> None:
    run = record(block)
    path.write_bytes(_render(block, run))


def record(block: library.Block) -> Run:
    """Run the example as its first comment says and keep what the chart may show."""
    example = examples.read(library.example(block.name))
    types = _variables(example)
    instances = [name for name, type_ in types.items() if type_ == block.name]
    paths = [f"{name}.{m.name}" for name in instances for m in block.members if m.type == "BOOL"]
    for name, type_ in types.items():
        if type_ in library.AXES:
            paths += [f"{name}.fSetPosition", f"{name}.fSetVelocity", f"{name}.nAxisState"]
    paths += [p.split(" ")[0] for p in example.picture if not p.startswith("-")]
    stretches, start = [], 0.0
    with tempfile.TemporaryDirectory() as folder:
        for options in filter(None, (example.run, example.again)):
            out = Path(folder) / "run.npz"
            keep = ["--retain", str(Path(folder) / "kept")] if example.again else []
            watch = ",".join(_full(p) for p in dict.fromkeys(paths))
            with contextlib.redirect_stdout(io.StringIO()) as said, contextlib.redirect_stderr(said):
                command = [
                    "run",
                    str(example.path),
                    *shlex.split(options),
                    *keep,
                    "--watch",
                    watch,
                    "--trace",
                    str(out),
                ]
                if main(command) != 0:
                    raise SystemExit(f"{example.path.name}: {said.getvalue()}")
            with np.load(out, allow_pickle=False) as data:
                columns = {p: data[_full(p)] for p in dict.fromkeys(paths)}
                time = data["time"] + start
            # a value holds until the next scan, the last one too
            end = 2 * time[-1] - time[-2]
            stretches.append((np.append(time, end), {p: np.append(c, c[-1]) for p, c in columns.items()}))
            start = end + OFF
    return Run(example, types, stretches)


def _full(path: str) -> str:
    return f"SIM.{path}" if path.startswith("Axis[") else f"PLC_PRG.{path}"


def _variables(example: Example) -> dict[str, str]:
    tree = parse(Source(example.text, str(example.path)))
    (pou,) = (u for u in tree.units if isinstance(u, syntax.Pou))
    decls = (d for section in pou.sections for d in section.decls)
    return {d.name: example.text[d.type.start : d.type.end] for d in decls}


def _lanes(block: library.Block, run: Run) -> list[list[tuple[str, str]]]:
    """Groups of (path, colour): what stands under picture, then each instance of the block."""
    groups = []
    own = [p for p in run.example.picture if " " not in p and not p.startswith("-")]
    others = [p for p in own if _dtype(run, p) == np.bool_]
    if others:
        groups.append([(p, FAINT) for p in others])
    for name, type_ in run.types.items():
        if type_ == block.name:
            members = [m for m in block.members if m.type == "BOOL"]
            shown = [m for m in members if m.name in ALWAYS or run.ever(f"{name}.{m.name}")]
            shown.sort(key=lambda m: m.kind)  # input before output
            groups.append([(f"{name}.{m.name}", INK if m.kind == "input" else COLOURS[0]) for m in shown])
    return groups


def _dtype(run: Run, path: str):
    return run.stretches[0][1][path].dtype


def _panels(block: library.Block, run: Run) -> list[tuple[str, list[str], bool]]:
    """(title, paths, stepped) of each panel of curves."""
    axes = [n for n, t in run.types.items() if t in library.AXES]
    own = {n for n, t in run.types.items() if t == block.name}
    velocity = [f"{n}.fSetVelocity" for n in axes if "-velocity" not in run.example.picture]
    position = [f"{n}.fSetPosition" for n in axes if "-position" not in run.example.picture]
    panels = [("velocity (u/s)", velocity, False), ("position (u)", position, False)]
    extra = []
    for picture in run.example.picture:
        path, _, unit = picture.partition(" ")
        if path.startswith("-") or _dtype(run, path) == np.bool_:
            continue
        if path.split(".")[0] in own and unit in ("u/s", "u") and panels[unit == "u"][1]:
            panels[unit == "u"][1].append(path)
        else:
            label = path.removeprefix(f"{axes[0]}.") if len(axes) == 1 else path
            extra.append(
                (f"{label} ({UNITS.get(unit, unit)})" if unit else label, [path], _dtype(run, path).kind != "f")
            )
    return [p for p in extra + panels if p[1]]


def _render(block: library.Block, run: Run) -> bytes:
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    groups, panels = _lanes(block, run), _panels(block, run)
    states = [n for n, t in run.types.items() if t in library.AXES]
    lanes = sum(map(len, groups)) + 0.4 * (len(groups) - 1)
    heights = [0.23 * lanes + 0.1, *([1.15] * len(panels)), *([0.24 * len(states) + 0.05] if states else [])]
    style = {"font.family": "DejaVu Sans", "font.size": 8.5, "axes.edgecolor": FAINT, "axes.labelcolor": INK,
             "text.color": INK, "xtick.color": INK, "ytick.color": INK}  # fmt: skip
    scale, unit = (1000, "ms") if run.stretches[-1][0][-1] < 0.1 else (1, "s")
    with rc_context(style):
        figure = Figure(figsize=(WIDTH, sum(heights) + 0.55), dpi=DPI, layout="constrained", facecolor="white")
        FigureCanvasAgg(figure)
        plots = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
        _draw_lanes(plots[0], groups, run, scale)
        for ax, (title, paths, stepped) in zip(plots[1:], panels, strict=False):
            _draw_panel(ax, title, paths, stepped, run, scale)
        if states:
            _draw_states(plots[-1], states, run, scale)
        for ax in plots:
            ax.grid(True, axis="x", color="#e3e7ea", linewidth=0.6)
            ax.set_axisbelow(True)
            ax.tick_params(axis="y", length=0)
            ax.tick_params(axis="x", length=3 if ax is plots[-1] else 0, color=FAINT)
            for side in ("top", "right"):
                ax.spines[side].set_visible(False)
            for (a, _), (b, _) in zip(run.stretches, run.stretches[1:], strict=False):
                ax.axvspan(
                    a[-1] * scale, b[0] * scale, facecolor="#eceff1", hatch="///", edgecolor="#cfd6da", linewidth=0
                )
        plots[-1].set_xlim(0, run.stretches[-1][0][-1] * scale)
        plots[-1].set_xlabel(f"time ({unit})" + (", power off where it is hatched" if run.example.again else ""))
        out = io.BytesIO()
        figure.savefig(out, format="png")
    return _smaller(out)


def _smaller(png: io.BytesIO) -> bytes:
    """The same picture with a palette: a third of the bytes."""
    from PIL import Image

    out = io.BytesIO()
    Image.open(png).convert("RGB").quantize(48, dither=Image.Dither.NONE).save(out, "png", optimize=True)
    return out.getvalue()


def _draw_lanes(ax, groups, run: Run, scale: float) -> None:
    y, ticks = 0.0, []
    for k, group in enumerate(groups):
        y -= 0.4 if k else 0
        for path, colour in group:
            y -= 1
            for time, columns in run.stretches:
                high = y + 0.66 * columns[path]
                ax.step(time * scale, high, where="post", color=colour, linewidth=1.1)
                ax.fill_between(time * scale, y, high, step="post", color=colour, alpha=0.16, linewidth=0)
            ticks.append((y + 0.3, path, INK if colour == FAINT else colour))
    ax.set_ylim(y - 0.25, 0.05)
    ax.set_yticks([t[0] for t in ticks], [t[1] for t in ticks], fontsize=8)
    for label, (_, _, colour) in zip(ax.get_yticklabels(), ticks, strict=True):
        label.set_color(colour)
    ax.spines["left"].set_visible(False)


def _draw_panel(ax, title: str, paths: list[str], stepped: bool, run: Run, scale: float) -> None:
    for k, path in enumerate(paths):
        for time, columns in run.stretches:
            t, v = thinned(time * scale, columns[path].astype(float))
            label = path if time is run.stretches[0][0] else None
            ax.plot(
                t, v, color=COLOURS[k], linewidth=1.3, drawstyle="steps-post" if stepped else "default", label=label
            )
    ax.set_ylabel(title, rotation=0, ha="right", va="center")
    ax.grid(True, axis="y", color="#eef1f3", linewidth=0.6)
    ax.margins(y=0.12)
    low, high = ax.get_ylim()
    if max(columns[p].astype(float).max() - columns[p].min() for _, columns in run.stretches for p in paths) < 1e-9:
        ax.set_ylim(low - 1, high + 1)
    if len(paths) > 1:
        ax.legend(
            fontsize=7.5, ncols=4, loc="lower right", bbox_to_anchor=(1.0, 0.97), borderaxespad=0.1, frameon=False
        )


def _draw_states(ax, axes: list[str], run: Run, scale: float) -> None:
    """A band an axis with the name of each state; a state too short for its name is a bare stretch."""
    names = {n: label for label, n in library.labels("SMC_AXIS_STATE").items()}
    whole = run.stretches[-1][0][-1] * scale
    for k, axis in enumerate(axes):
        for time, columns in run.stretches:
            values = columns[f"{axis}.nAxisState"]
            cuts = np.flatnonzero(np.diff(values)) + 1
            ends = time * scale
            for a, b in zip([0, *cuts], [*cuts, len(values) - 1], strict=True):
                state = int(values[a])
                ax.barh(
                    -k,
                    ends[b] - ends[a],
                    left=ends[a],
                    height=0.8,
                    color=_STATE[state],
                    edgecolor="white",
                    linewidth=0.8,
                )
                if ends[b] - ends[a] > 0.0125 * len(names[state]) * whole:
                    ax.text((ends[a] + ends[b]) / 2, -k, names[state], ha="center", va="center_baseline", fontsize=7.5)
    ax.set_ylim(-len(axes) + 0.5, 0.5)
    ax.set_yticks(
        [-k for k in range(len(axes))], ["state"] if len(axes) == 1 else [f"{a}: state" for a in axes], fontsize=8
    )
    ax.spines["left"].set_visible(False)


_STATE = ("#dfe4e7", "#f0b7a4", "#f3d9a0", "#eef1f3", "#bcd3ea", "#bfe0cb", "#d9c7e6", "#f3e6b8")  # by number

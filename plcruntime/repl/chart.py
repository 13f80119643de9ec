"""A curve in the terminal, drawn with braille dots: 2 x 4 of them in one character."""

from __future__ import annotations

from collections.abc import Sequence

WIDTH, HEIGHT = 64, 10  # characters
_DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # by row and column within a character


def draw(time: Sequence[float], values: Sequence[float], name: str, width: int = WIDTH, height: int = HEIGHT):
    """The lines of a picture: title, curve with its scale, time axis. values: numbers or BOOLs, one a scan."""
    import numpy as np

    numbers = np.asarray(values, dtype=float)
    finite = numbers[np.isfinite(numbers)]
    if not len(finite):
        return [f"{name}: nothing to draw"]
    low, high = float(finite.min()), float(finite.max())
    boolean = np.asarray(values).dtype.kind == "b"
    height = 2 if boolean else height
    lines = [f"{name}   last {_text(numbers[-1], boolean)}, least {_text(low, boolean)}, most {_text(high, boolean)}"]
    if boolean:
        low, high = 0.0, 1.0
    elif low == high:
        low, high = low - 1, high + 1
    rows = _raster(numbers, low, high, width, height)
    labels = {0: _text(high, boolean), height - 1: _text(low, boolean)}
    margin = max(len(x) for x in labels.values())
    for i, row in enumerate(rows):
        lines.append(f"{labels.get(i, '').rjust(margin)} ┤{row}")
    begin, end = f"{time[0]:.6g} s", f"{time[-1]:.6g} s"
    lines.append(" " * (margin + 1) + "└" + "─" * width)
    lines.append(" " * (margin + 2) + begin + end.rjust(width - len(begin)))
    return lines


def _raster(numbers, low: float, high: float, width: int, height: int) -> list[str]:
    """Each column of dots shows the range of the values that fall into it, so that no peak is lost."""
    import numpy as np

    columns, levels = 2 * width, 4 * height
    cells = [[0] * width for _ in range(height)]
    edges = np.linspace(0, len(numbers), columns + 1).astype(int)
    before = None
    for x in range(columns):
        part = numbers[edges[x] : max(edges[x] + 1, edges[x + 1])]
        part = part[np.isfinite(part)]
        if not len(part):
            before = None
            continue
        bounds = [_level(v, low, high, levels) for v in (float(part.min()), float(part.max()))]
        if before is not None:
            # joined to the column before
            bounds = [min(bounds[0], before), max(bounds[1], before)]
        before = _level(float(part[-1]), low, high, levels)
        for level in range(bounds[0], bounds[1] + 1):
            y = levels - 1 - level
            cells[y // 4][x // 2] |= _DOTS[y % 4][x % 2]
    return ["".join(chr(0x2800 + dots) for dots in row).rstrip("\u2800") for row in cells]


def _level(value: float, low: float, high: float, levels: int) -> int:
    return round((value - low) / (high - low) * (levels - 1))


def _text(value: float, boolean: bool) -> str:
    if boolean:
        return "TRUE" if value else "FALSE"
    return f"{value:.6g}"

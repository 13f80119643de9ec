"""Configuration files of GT_LoadConfig (docs/config_files.md)."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from stcore.near import near

SHIPPED = Path(__file__).parent / "config"
AXES = 12  # of the GT_ controller
LONGEST = 125  # characters of a file's name (iDEABOX 3, 13 command 83)


class Setting(NamedTuple):
    """key: of GtConfigure.st. low, high: the values that it takes. whole: no fractions."""

    key: int
    low: float
    high: float
    whole: bool = False


SMALLEST = 1e-9  # stands for 'more than 0'
SETTINGS = {
    "alarm": Setting(1, 1, AXES, True),
    "limit_positive": Setting(2, 1, AXES, True),
    "limit_negative": Setting(3, 1, AXES, True),
    "profile_alpha": Setting(4, -32766, 32766, True),
    "profile_beta": Setting(5, -32766, 32766, True),
    "encoder_alpha": Setting(6, -32766, 32766, True),
    "encoder_beta": Setting(7, -32766, 32766, True),
    "stop_smooth": Setting(8, SMALLEST, 32767),
    "stop_abrupt": Setting(9, SMALLEST, 32767),
    "following_error": Setting(10, 1, 2147483647, True),
    "lag": Setting(11, 0, 1e6),
    "resolution": Setting(12, 0, 1e9),
    "soft_positive": Setting(13, -2147483648, 2147483647),
    "soft_negative": Setting(14, -2147483648, 2147483647),
    "drive_speed": Setting(15, SMALLEST, 1e6),
    "drive_drift": Setting(16, -32767, 32767, True),
    "pulse_type": Setting(17, 0, 2, True),
}
SIGNALS = ("alarm", "limit_positive", "limit_negative")
SCALES = ("profile_alpha", "profile_beta", "encoder_alpha", "encoder_beta")
# two settings of one axis that go together: (first, second, what must hold, in words)
PAIRS = (
    ("profile_alpha", "profile_beta", lambda a, b: abs(a) >= abs(b), "is not smaller than"),
    ("encoder_alpha", "encoder_beta", lambda a, b: abs(a) >= abs(b), "is not smaller than"),
    ("soft_positive", "soft_negative", lambda a, b: a > b, "is greater than"),
)


class ConfigError(ValueError):
    """A line of a configuration file that is wrong. line: its number, from 1."""

    def __init__(self, line: int, problem: str) -> None:
        super().__init__(f"line {line}: {problem}")
        self.line = line


def find(name: str, folders: list[Path]) -> Path | None:
    """The file of a configuration: as named when absolute, else in the folders, the working folder, our examples."""
    if not name:
        return None
    for folder in (*folders, Path.cwd(), SHIPPED):
        file = folder / name
        if file.is_file():
            return file
    return None


def parse(text: str) -> list[tuple[int, int, float]]:
    """(key, axis, value) of every setting; of one that is made twice the last. Raises ConfigError."""
    found: dict[tuple[str, int], tuple[float, int]] = {}  # (setting, axis) -> value, line
    axes: range | None = None
    for number, line in enumerate(text.splitlines(), 1):
        line = line.split("#")[0].split(";")[0].strip().lower()
        if not line:
            continue
        if line.startswith("["):
            axes = _section(line, number)
            continue
        name, equals, value = (part.strip() for part in line.partition("="))
        if not equals:
            raise ConfigError(number, "a setting is written 'name = value'")
        if axes is None:
            raise ConfigError(number, "a setting stands below a section [axis N] or [axis *]")
        if name not in SETTINGS:
            meant = near(name, SETTINGS)
            raise ConfigError(number, f"there is no setting '{name}'" + (f": {meant}" if meant else ""))
        setting = _value(name, value, number)
        for axis in axes:
            found[name, axis] = (setting, number)
    for first, second, holds, words in PAIRS:
        for axis in range(1, AXES + 1):
            a, b = found.get((first, axis)), found.get((second, axis))
            if a and b and not holds(a[0], b[0]):
                raise ConfigError(max(a[1], b[1]), f"{first} {words} {second}")
    return [(SETTINGS[name].key, axis, value) for (name, axis), (value, _) in found.items()]


def _section(line: str, number: int) -> range:
    words = line.strip("[]").split()
    if len(words) == 2 and words[0] == "axis":
        if words[1] == "*":
            return range(1, AXES + 1)
        if words[1].isdigit() and 1 <= int(words[1]) <= AXES:
            return range(int(words[1]), int(words[1]) + 1)
    raise ConfigError(number, f"a section is [axis *] or [axis 1] ... [axis {AXES}]")


def _value(name: str, text: str, line: int) -> float:
    setting = SETTINGS[name]
    if name in SIGNALS and text == "none":
        return -1.0
    try:
        value = float(text)
    except ValueError:
        raise ConfigError(line, f"'{text}' is not a number") from None
    if not setting.low <= value <= setting.high or name in SCALES and value == 0:
        low = f"from {setting.low:g}" if setting.low != SMALLEST else "from more than 0"
        zero = ", without 0" if name in SCALES else ""
        raise ConfigError(line, f"{name} goes {low} to {setting.high:.10g}{zero}")
    if setting.whole and value != int(value):
        raise ConfigError(line, f"{name} is a whole number")
    return value

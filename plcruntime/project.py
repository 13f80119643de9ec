"""plc.toml: which files, tasks and axes make up a project. docs/plc_toml.md describes every key.

A key that is not in the tables below is an error with the nearest known key: a misspelt limit must not go unnoticed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from plcruntime import durations
from plcruntime.errors import UsageError
from stcore.program import TaskSpec
from stcore.source import Source

NAME = "plc.toml"

# section -> key -> what it holds
KEYS: dict[str, dict[str, str]] = {
    "": {"project": "table", "task": "tables", "axis": "tables", "ecat": "table"},
    "project": {
        "files": "list of texts", "interval": "duration", "libraries": "list of texts", "watchdog": "duration",
        "strict": "TRUE or FALSE", "dialect": "text", "retain": "text", "retain_every": "duration", "stimuli": "text",
    },
    "task": {
        "name": "text", "program": "text", "programs": "list of texts", "interval": "duration",
        "priority": "whole number",
    },
    "axis": {
        "number": "whole number", "name": "text", "kind": "text", "lag": "duration", "resolution": "number",
        "inertia": "number",
        "soft_positive": "number", "soft_negative": "number", "following_error": "whole number",
        "stop_smooth": "number", "stop_abrupt": "number", "pulses_per_unit": "number", "modulo": "number",
        "max_velocity": "number", "max_acceleration": "number", "max_deceleration": "number", "max_jerk": "number",
        "limit_positive": "number", "limit_negative": "number", "home_from": "number", "home_to": "number",
        "index_period": "number", "index_at": "number",
    },
    # the simulated EtherCAT bus; mclib/ecat knows the values, docs/ecat.md the meaning
    "ecat": {"eni": "text", "startup": "duration", "slave": "tables", "fault": "tables"},
    "slave": {
        "kind": "text", "name": "text", "count": "whole number", "axis": "whole number", "wired": "TRUE or FALSE",
        "outputs": "list of texts", "inputs": "list of texts", "modules": "list of texts", "objects": "list of texts",
        "vendor": "whole number", "product": "whole number", "revision": "whole number",
    },
    "fault": {"slave": "whole number", "at": "duration", "until": "duration"},
}  # fmt: skip

# key of an axis -> members of the simulator's axis (mclib/library/sim/SimAxis.st); ref^ is the program's AXIS_REF_SM3
MEMBERS: dict[str, str] = {
    "lag": "drive.lag", "resolution": "drive.resolution", "inertia": "drive.inertia",
    "soft_positive": "softPositive", "soft_negative": "softNegative", "following_error": "posErr",
    "stop_smooth": "decSmooth", "stop_abrupt": "decAbrupt", "pulses_per_unit": "ref^.fScalefactor",
    "modulo": "ref^.fPositionPeriod", "max_velocity": "ref^.fSWMaxVelocity",
    "max_acceleration": "ref^.fSWMaxAcceleration", "max_deceleration": "ref^.fSWMaxDeceleration",
    "max_jerk": "ref^.fSWMaxJerk", "limit_positive": "places.positive", "limit_negative": "places.negative",
    "home_from": "places.homeFrom", "home_to": "places.homeTo", "index_period": "places.indexPeriod",
    "index_at": "places.index",
}  # fmt: skip

# kind of an axis that plc.toml declares -> its type in the program
KINDS = {
    "pulse": "AXIS_REF_SM3", "ethercat": "AXIS_REF_SM3", "virtual": "AXIS_REF_VIRTUAL_SM3",
    "logical": "AXIS_REF_LOGICAL_SM3",
}  # fmt: skip
LIST = "Axes"  # list of global variables that holds the axes declared in plc.toml
PLACES = {"limit_positive", "limit_negative", "home_from", "home_to"}  # keys that place a switch


@dataclass(slots=True)
class Axis:
    """An axis of the configuration. members: path below the simulator's axis -> first value; keys: their names.

    kind: as KINDS; the axis then is a global variable of the program, '' where the program declares it itself."""

    number: int
    name: str = ""
    members: dict[str, Any] = field(default_factory=dict)
    keys: dict[str, str] = field(default_factory=dict)
    kind: str = ""


@dataclass(slots=True)
class Project:
    """A project's settings; the defaults are those of a program without plc.toml. interval is ns; watchdog and
    retain_every are s."""

    path: Path | None = None
    files: list[Path] = field(default_factory=list)
    libraries: list[Path] = field(default_factory=list)
    interval: int | None = None
    tasks: list[TaskSpec] | None = None
    axes: list[Axis] = field(default_factory=list)
    watchdog: float | None = None
    strict: bool = False
    dialect: str = "codesys"
    retain: Path | None = None
    retain_every: float | None = None
    stimuli: Path | None = None
    ecat: Any = None  # the simulated EtherCAT bus, an mclib.ecat.Bus


def load(path: str | Path) -> Project:
    """Read a plc.toml. Raises UsageError for anything that is not as docs/plc_toml.md has it."""
    import tomllib

    path = Path(path)
    try:
        with open(path, "rb") as file:
            data = tomllib.load(file)
    except OSError as error:
        raise UsageError(f"can't read {path}: {error.strerror}") from None
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"{path} is not TOML: {error}") from None
    except UnicodeDecodeError:
        raise UsageError(f"{path} is not TOML: it is not UTF-8") from None
    _check(path, "", data)
    head = data.get("project", {})
    axes = _axes(path, data.get("axis", []))
    return Project(
        path=path,
        files=[path.parent / f for f in head.get("files", ["."])],
        libraries=[path.parent / f for f in head.get("libraries", [])],
        interval=_duration(path, "project.interval", head.get("interval")),
        tasks=[_task(path, i, t) for i, t in enumerate(data["task"])] if "task" in data else None,
        axes=axes,
        watchdog=_seconds(path, head, "watchdog"),
        strict=head.get("strict", False),
        dialect=_dialect(path, head.get("dialect", "codesys")),
        ecat=_bus(path, data, axes),
        retain=path.parent / head["retain"] if "retain" in head else None,
        retain_every=_seconds(path, head, "retain_every"),
        stimuli=path.parent / head["stimuli"] if "stimuli" in head else None,
    )


def _check(path: Path, section: str, data: dict) -> None:
    """Every key known, every value of its kind."""
    keys = KEYS[section]
    for key, value in data.items():
        where = f"{section}.{key}" if section else key
        if key not in keys:
            raise UsageError(f"{path}: unknown key {where}{_near(key, keys)}; known here: {', '.join(keys)}")
        kind = keys[key]
        if not _fits(kind, value):
            raise UsageError(f"{path}: {where} takes {_article(kind)}, not {value!r}")
        if section == "" and kind == "table":
            _check(path, key, value)
        elif kind == "tables":
            for entry in value:
                _check(path, key, entry)


def _fits(kind: str, value: Any) -> bool:
    if kind == "tables":
        return isinstance(value, list) and all(isinstance(v, dict) for v in value)
    if kind == "list of texts":
        return isinstance(value, list) and all(isinstance(v, str) for v in value)
    if kind == "whole number":
        return isinstance(value, int) and not isinstance(value, bool)
    if kind == "number":
        return isinstance(value, int | float) and not isinstance(value, bool)
    wanted = {"table": dict, "text": str, "duration": str | int | float, "TRUE or FALSE": bool}[kind]
    return isinstance(value, wanted) and not (kind == "duration" and isinstance(value, bool))


def _article(kind: str) -> str:
    forms = {
        "tables": "tables, each under [[...]]", "table": "a table", "duration": 'a duration such as "1ms"',
        "TRUE or FALSE": "true or false",
    }  # fmt: skip
    return forms.get(kind, f"a {kind}")


def _near(key: str, known) -> str:
    from stcore.near import near

    hint = near(key, known)
    return f"; {hint}" if hint else ""


def _duration(path: Path, where: str, value, least: int = 1) -> int | None:
    if value is None:
        return None
    try:
        ns = durations.nanoseconds(value)
    except ValueError as error:
        raise UsageError(f"{path}: {where}: {error}") from None
    if ns < least:
        raise UsageError(f"{path}: {where} must be longer than 0")
    return ns


def _seconds(path: Path, head: dict, key: str) -> float | None:
    return (_duration(path, f"project.{key}", head[key], 0) or 0) / 1e9 if key in head else None


def _dialect(path: Path, name: str) -> str:
    import mclib

    if name.lower() not in mclib.DIALECTS:
        known = ", ".join(f'"{d}"' for d in mclib.DIALECTS)
        raise UsageError(f"{path}: project.dialect is one of {known}, not {name!r}{_near(name, mclib.DIALECTS)}")
    return name.lower()


def _task(path: Path, i: int, table: dict) -> TaskSpec:
    name = table.get("name", f"Task{i + 1}")
    programs = table.get("programs", []) + ([table["program"]] if "program" in table else [])
    if not programs:
        raise UsageError(f'{path}: task {name} has no program; write program = "PLC_PRG"')
    interval = _duration(path, f"task {name}: interval", table.get("interval"))
    return TaskSpec(name, programs, interval, table.get("priority", 0))


def _axes(path: Path, tables: list[dict]) -> list[Axis]:
    axes: list[Axis] = []
    for table in tables:
        number = table.get("number", len(axes) + 1)
        if number < 1 or any(a.number == number for a in axes):
            problem = "is there twice" if number > 0 else "is not 1 or more"
            raise UsageError(f"{path}: axis number {number} {problem}")
        axis = Axis(number, table.get("name", ""), kind=_kind(path, number, table))
        for key, member in MEMBERS.items():
            if key in table:
                axis.members[member] = _in_ms(path, number, table[key]) if key == "lag" else table[key]
                axis.keys[member] = key
        if "modulo" in table:
            axis.members["ref^.iMovementType"] = 0
            axis.keys["ref^.iMovementType"] = "modulo"
        if "home_to" in table and "home_from" not in table:
            axis.members["places.homeFrom"] = -1e299  # triggered everywhere below
            axis.keys["places.homeFrom"] = "home_to"
        if PLACES & table.keys():
            axis.members["places.placed"] = True
            axis.keys["places.placed"] = "home_from"
        axes.append(axis)
    return axes


def _kind(path: Path, number: int, table: dict) -> str:
    """The kind of an axis, whose name then has to be one of ST."""
    kind, name = table.get("kind", "").lower(), table.get("name", "")
    if "kind" in table and kind not in KINDS:
        known = ", ".join(f'"{k}"' for k in KINDS)
        raise UsageError(f"{path}: axis {number}: kind is one of {known}, not {table['kind']!r}{_near(kind, KINDS)}")
    if kind and not (name.isidentifier() and name.isascii()):
        raise UsageError(f"{path}: axis {number}: with a kind it is a variable of the program and needs a name for it")
    return kind


def declarations(project: Project) -> list[Source]:
    """What the configuration adds to the program: the axes that it declares, and the bus."""
    declared = "".join(f"    {a.name} : {KINDS[a.kind]};\n" for a in project.axes if a.kind)
    bus = "{attribute 'needs' := 'EcatTick'}\n" if project.ecat else ""
    text = f"{bus}VAR_GLOBAL\n{declared}END_VAR\n"
    return [Source(text, f"{project.path}/{LIST}")] if declared or bus else []


def _bus(path: Path, data: dict, axes: list[Axis]):
    """The bus of [ecat]; without that one of the axes that are on a bus, None where there is none."""
    drives = [{"kind": "drive", "axis": a.number} for a in axes if a.kind == "ethercat"]
    if "ecat" in data:
        return _ecat(path, data["ecat"])
    return _ecat(path, {"slave": drives}) if drives else None


def _ecat(path: Path, table: dict):
    from mclib import ecat

    try:
        return ecat.read(table, path.parent, durations.nanoseconds)
    except ecat.BusError as error:
        raise UsageError(f"{path}: ecat: {error}") from None


def _in_ms(path: Path, number: int, value) -> float:
    return (_duration(path, f"axis {number}: lag", value, 0) or 0) / 1e6

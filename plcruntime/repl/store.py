"""Snapshots by name, kept in the folder for state beside others of the same program."""

from __future__ import annotations

import hashlib
import json
import re
import zlib
from pathlib import Path

from plcruntime.errors import UsageError
from plcruntime.plc import PLC
from plcruntime.snapshot import Snapshot
from stcore import cache

_MAGIC = b"scancycle snapshot 1\n"


def _folder(plc: PLC) -> Path:
    """Of one program: a changed one does not see the snapshots of what it was."""
    variables = repr([(v.path, v.type.name, v.address) for v in plc.program.variables.values()])
    return cache.state_dir() / "snapshots" / cache.digest(plc.program.image, variables.encode())[:32]


def _file(plc: PLC, name: str) -> Path:
    if not re.fullmatch(r"[\w.-]{1,64}", name) or name.startswith("."):
        raise UsageError(f"'{name}' is no name for a snapshot: letters, digits, - and _")
    return _folder(plc) / name


def names(plc: PLC) -> list[str]:
    folder = _folder(plc)
    return sorted(p.name for p in folder.iterdir() if not p.name.endswith(".part")) if folder.is_dir() else []


def save(plc: PLC, name: str) -> None:
    """Raises UsageError for a name that can't be, OSError."""
    file = _file(plc, name)
    taken = plc.snapshot()
    forces = {path: [[at, v.hex(), m.hex()] for at, v, m in pieces] for path, pieces in taken.forces.items()}
    head = {
        "scans": taken.scans,
        "now": taken.now,
        "forces": forces,
    }
    body = json.dumps(head).encode() + b"\n" + zlib.compress(taken.image, 1)
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_name(file.name + ".part")
    part.write_bytes(_MAGIC + hashlib.sha256(body).digest() + body)
    part.replace(file)


def load(plc: PLC, name: str) -> Snapshot:
    """Raises UsageError: unknown or damaged."""
    file = _file(plc, name)
    try:
        data = file.read_bytes()
    except OSError:
        raise UsageError(f"there is no snapshot {name}; kept: {', '.join(names(plc)) or 'none'}") from None
    start = len(_MAGIC) + 32
    body = data[start:]
    if not data.startswith(_MAGIC) or hashlib.sha256(body).digest() != data[len(_MAGIC) : start]:
        raise UsageError(f"the snapshot {name} is damaged ({file}); nothing was changed")
    line, _, packed = body.partition(b"\n")
    head = json.loads(line)
    unhex = bytes.fromhex
    forces = {p: tuple((at, unhex(v), unhex(m)) for at, v, m in pieces) for p, pieces in head["forces"].items()}
    return Snapshot(plc.program, zlib.decompress(packed), head["scans"], head["now"], forces)

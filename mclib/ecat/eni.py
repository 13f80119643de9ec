"""Slaves from an EtherCAT Network Information file (ETG.2100)."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

from mclib.ecat.bus import DRIVE_PROFILE, IO_PROFILE, BusError, Entry, Slave


def read_eni(file: Path) -> list[Slave]:
    """The slaves of a file: identity and mapped objects. Raises BusError."""
    try:
        root = ET.parse(file).getroot()
    except ET.ParseError as error:
        raise BusError(f"{file} is not XML: {error}") from None
    slaves = []
    for number, node in enumerate(root.iterfind("./Config/Slave")):
        info = node.find("Info")
        text = lambda tag, info=info: (info.findtext(tag) or "0") if info is not None else "0"  # noqa: E731
        entries = []
        for tag, is_input in (("RxPdo", False), ("TxPdo", True)):
            for pdo in node.iterfind(f"./ProcessData/{tag}"):
                # a PDO that is offered but not assigned to a sync manager carries nothing
                if pdo.get("Sm") is None:
                    continue
                for entry in pdo.iterfind("Entry"):
                    index, subindex = _number(entry, "Index"), _number(entry, "SubIndex")
                    bits = _number(entry, "BitLen")
                    while bits > 0:  # padding may be longer than a number
                        part = bits if bits <= 32 or bits == 64 else 32
                        entries.append(Entry(index, subindex, is_input, part))
                        bits -= part
        drive = {0x6040, 0x6041} <= {e.index for e in entries}
        identity = tuple(_eni_int(text(tag)) for tag in ("VendorId", "ProductCode", "RevisionNo", "SerialNo"))
        name = info.findtext("Name") if info is not None else None
        slaves.append(
            Slave((name or f"slave{number}")[:31], entries, -1 if drive else 0,
                  DRIVE_PROFILE if drive else IO_PROFILE, identity)
        )  # fmt: skip
    if not slaves:
        raise BusError(f"{file} has no Config/Slave")
    return slaves


def _number(node, tag: str) -> int:
    return _eni_int(node.findtext(tag) or "0")


def _eni_int(text: str) -> int:
    """A number of an ENI file: 12, #x1A, 0x1A."""
    text = text.strip().lower()
    try:
        return int(text[2:], 16) if text.startswith(("#x", "0x")) else int(text)
    except ValueError:
        raise BusError(f"'{text}' in the ENI file is not a number") from None

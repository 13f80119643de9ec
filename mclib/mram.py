"""The memory of the controller that keeps its data without power (iDEABOX 3, 11.8): 4096 words in a file.

The file is mram.bin beside a project's plc.toml. Programs without one share a file with the other programs of their
folder, in $SCANCYCLE_STATE, else the platform's folder for what programs keep. A program that is not in a file has a
memory that lasts as long as its PLC. The file is written whole or not at all.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from stcore.cache import state_dir

WORDS = 4096
SIZE = 2 * WORDS  # bytes, words low byte first


class Mram:
    """file: where the words are kept, None to keep them in this object only."""

    def __init__(self, file: Path | None) -> None:
        self.file = file
        self.problem = ""  # why the file could not be read or written last
        self._data = bytearray(SIZE)

    def read(self, address: int, count: int) -> bytes:
        """The words from an address on. What was never written is 0."""
        self._load()
        return bytes(self._data[2 * address : 2 * (address + count)])

    def write(self, address: int, words: bytes) -> None:
        """Keep words from an address on. Raises OSError."""
        self._load()
        self._data[2 * address : 2 * address + len(words)] = words
        if self.file is None:
            return
        self.file.parent.mkdir(parents=True, exist_ok=True)
        part = self.file.with_name(f"{self.file.name}.{os.getpid()}.part")
        try:
            with open(part, "wb") as out:
                out.write(self._data)
                out.flush()
                os.fsync(out.fileno())
            os.replace(part, self.file)
        except OSError:
            part.unlink(missing_ok=True)
            raise

    def _load(self) -> None:
        """What another process has written counts, too."""
        if self.file is None:
            return
        try:
            data = self.file.read_bytes()
        except FileNotFoundError:
            data = b""
        self._data[:] = data[:SIZE].ljust(SIZE, b"\0")


def place(config: Path | None, files: list[str]) -> Path | None:
    """The file for a project: config is its plc.toml or None, files are those of the program."""
    if config is not None:
        return Path(config).parent / "mram.bin"
    if files and Path(files[0]).is_file():
        folder = str(Path(files[0]).resolve().parent)
        return state_dir() / "mram" / f"{hashlib.sha256(folder.encode()).hexdigest()[:32]}.bin"
    return None

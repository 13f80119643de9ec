"""The trace of another run, from the .npz file that it wrote, to be drawn behind this one."""

from __future__ import annotations

import zipfile
from pathlib import Path

from plcruntime.errors import UsageError
from stcore.paths import Place


class Overlay:
    """Columns as a trace has them, of those variables that this program has too."""

    def __init__(self, path: Path, places: list[Place]) -> None:
        """Raises UsageError for a file that can't be read or is no trace."""
        import numpy as np

        self.path = path
        try:
            with np.load(path, allow_pickle=False) as data:
                columns = {name: data[name] for name in data.files}
        except OSError as error:
            raise UsageError(f"can't read the overlay {path}: {error.strerror or error}") from None
        except (ValueError, zipfile.BadZipFile, EOFError):
            raise UsageError(f"the overlay {path} is no trace: write one with --trace run.npz") from None
        self.time = columns.pop("time", None)
        if self.time is None or any(len(c) != len(self.time) for c in columns.values()):
            raise UsageError(f"the overlay {path} is no trace: write one with --trace run.npz")
        self._columns = columns
        self.places = [p for p in places if p.name in columns]
        if not self.places:
            raise UsageError(f"the overlay {path} has none of the variables of this run")

    @property
    def names(self) -> list[str]:
        return [p.name for p in self.places]

    def __getitem__(self, name: str):
        return self._columns[name]

    def __len__(self) -> int:
        return len(self.time)

"""The machine as the soft PLC needs it: stcore's, with a look at the condition between two calls."""

from __future__ import annotations

from stcore.machine import Machine


class SoftMachine(Machine):
    """Runs a Program."""

    def until_holds(self) -> bool:
        """Whether the condition of `set_until` holds now: a run that ends with its last scan does not tell."""
        return bool(self._hooks.get(self._store, 0)(self._store))

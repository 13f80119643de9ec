"""What a process keeps of what it has made, so that it need not make it again."""

from __future__ import annotations

from typing import Generic, TypeVar

K, V = TypeVar("K"), TypeVar("V")


class Recent(Generic[K, V]):
    """The last `most` values by their keys; what was asked for longest ago is forgotten first. Threads may share it."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._values: dict[K, V] = {}

    def __contains__(self, key: K) -> bool:
        return key in self._values

    def get(self, key: K) -> V | None:
        """The value, the newest from now on."""
        value = self._values.pop(key, None)
        if value is not None:
            self._values[key] = value
        return value

    def keep(self, key: K, value: V) -> V:
        self._values.pop(key, None)
        self._values[key] = value
        if len(self._values) > self._most:
            self._values.pop(list(self._values)[0], None)  # one step, where next(iter()) could meet another thread
        return value

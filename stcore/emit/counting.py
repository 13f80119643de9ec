"""The counter of a FOR loop: when it goes on."""

from __future__ import annotations

from dataclasses import dataclass

from stcore import types as t
from stcore.emit.values import number


@dataclass(slots=True)
class Counting:
    """counter, end, by: instructions for the counter, the end value and the step. step: its value, None if not known.

    The counter is wider than its variable, so that it can pass the end value. A variable of 64 bits has no wider one:
    there the loop looks whether another step fits before it is taken.
    """

    kind: t.Elementary
    wasm: str
    counter: str
    end: str
    by: str
    step: int | None

    @property
    def tight(self) -> bool:
        return self.kind.size == 8

    def inside(self) -> str:
        """The counter has not passed the end."""
        sign = "s" if self.kind.signed or not self.tight else "u"
        return self._either(*(f"({self.wasm}.{op}_{sign} {self.counter} {self.end})" for op in ("le", "ge")))

    def fits(self) -> str:
        """The counter has not passed the end, and won't after another step."""
        up = f"(i64.ge_u (i64.sub {self.end} {self.counter}) {self.by})"
        down = f"(i64.ge_u (i64.sub {self.counter} {self.end}) (i64.sub (i64.const 0) {self.by}))"
        return f"(i32.and {self.inside()} {self._either(up, down)})"

    def next(self) -> str:
        return f"({self.wasm}.add {self.counter} {self.by})"

    def _either(self, up: str, down: str) -> str:
        if self.step is not None:
            return up if self.step > 0 else down
        return f"(select {up} {down} ({self.wasm}.ge_s {self.by} {number(0, self.wasm)}))"

"""Running a PLC: scans, virtual time, conditions, models in Python, stimuli."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from plcruntime import durations
from plcruntime.durations import Time
from plcruntime.engine import Engine
from plcruntime.errors import ConditionTimeout, UsageError
from plcruntime.stimuli import Stimulus, scan_of
from stcore import values
from stcore.paths import PathError

if TYPE_CHECKING:
    from plcruntime.plc import PLC


class Running:
    """The part of PLC that lets time pass."""

    _engine: Engine

    @property
    def scans(self) -> int:
        """Scans finished."""
        return self._engine.scans

    @property
    def interval(self) -> float:
        """The length of a scan in s."""
        return self._engine.interval / 1e9

    @property
    def time(self) -> float:
        """Virtual time in s: scans * interval."""
        return self.scans * self._engine.interval / 1e9

    @property
    def run_seconds(self) -> float:
        """Wall clock spent inside the program so far, in s."""
        return self._engine.run_s

    def scan(self, count: int = 1) -> None:
        """Run scans. Raises stcore.machine.Fault when the program fails, and again until reset, restore or back."""
        if count < 0:
            raise ValueError(f"can't run {count} scans")
        self._engine.advance(count)

    def run(self, duration: Time, *, realtime: bool = False) -> None:
        """Run for a virtual time ('2s', 2.5, '#120'), rounded up to whole scans. realtime: keep the wall clock's pace.

        Raises Fault as `scan` does; KeyboardInterrupt at a scan's boundary, with the PLC fit to go on.
        """
        try:
            self._engine.advance(self._count(duration), realtime=realtime)
        finally:
            self.save_retain()

    def run_until(self, condition: str | Callable, timeout: Time = "10s", *, realtime: bool = False) -> float:
        """Run until a condition holds at the end of a scan; gives the virtual time in s.

        condition: an ST expression ("PLC_PRG.done AND x > 3"), asked inside the module, or a Python function, called
        with the PLC or without arguments after every scan. Raises ConditionTimeout (a TimeoutError) after `timeout` of
        virtual time, stcore.CompileError for a wrong expression, Fault as `scan` does.
        """
        count = self._count(timeout)
        test = until = None
        if callable(condition):
            test = _with_plc(condition, self)
        else:
            from stcore.compiler import compile_condition

            until = compile_condition(self.program, condition)
        try:
            reached = self._engine.advance(count, until=until, test=test, realtime=realtime)
        finally:
            self.save_retain()
        if not reached:
            text = condition if isinstance(condition, str) else getattr(condition, "__name__", repr(condition))
            raise ConditionTimeout(text, durations.text(count * self._engine.interval), self._read_by(condition))
        return self.time

    def _count(self, duration: Time) -> int:
        return durations.scans(duration, self._engine.interval)

    def _read_by(self, condition) -> dict[str, str]:
        """The variables that an ST condition names, with their values."""
        found = {}
        if isinstance(condition, str):
            for path in re.findall(r"%?[^\W\d][\w.]*(?:\[[^\]]*\][\w.]*)*", condition):
                try:
                    found[self.place(path).name] = self.show(path)
                except PathError:  # a keyword, a function, a literal's prefix: not a variable
                    continue
        return found

    def on_scan(self, function: Callable) -> Callable:
        """Call a Python function after every scan, with the PLC or without arguments: a plant model. Gives it back."""
        self._engine.after_scan.append(_with_plc(function, self))
        return function

    def on_progress(self, function: Callable[[int, int], None] | None) -> None:
        """Call a function (scans done, scans wanted) some twenty times a second of wall clock during long runs."""
        self._engine.between_calls = function

    def schedule(self, path: str, value, at: Time, *, force: bool = False) -> None:
        """Write or force a variable before the scan that starts at a virtual time. Raises as writing does."""
        self.check_value(path, value)  # a wrong value is an error now, not in the middle of a run
        action = (lambda: self.force(path, value)) if force else (lambda: self.__setitem__(path, value))
        self._schedule(at, action, f"{self.place(path).name} {'forced to' if force else ':='} {_st(value)}")

    def schedule_release(self, path: str, at: Time) -> None:
        """Release a variable, if it is forced then, before the scan that starts at a virtual time."""
        name = self.place(path).name
        self._schedule(at, lambda: self.unforce(name) if name in self.forced else None, f"{name} released")

    def _schedule(self, at: Time, action: Callable[[], None], text: str) -> None:
        self._engine.schedule.add(self._count(at), action, self.scans)
        self.scheduled.append((self._count(at), text))

    def stimuli(self, path: str | Path) -> int:
        """Schedule the stimuli of a .csv or .toml file (plcruntime.stimulus_file tells the form); how many there are.

        Raises UsageError for a name, value or time that is wrong, naming its line; then none is scheduled."""
        from plcruntime import stimulus_file

        return stimulus_file.schedule(self, path)

    def stimulate(self, stimulus: Stimulus, *, force: bool = False) -> None:
        """Schedule ``VAR=VALUE@TIME``, VALUE as ST writes it. Raises UsageError."""
        scan = scan_of(stimulus, self._engine.interval)
        try:
            value = self.parse_value(stimulus.path, stimulus.value)
            self.schedule(stimulus.path, value, f"#{scan}", force=force)
        except (PathError, TypeError, ValueError) as error:
            raise UsageError(f"'{stimulus.text}': {error}") from None


def _st(value) -> str:
    """A value as text, as ST would write it where that is easy."""
    if isinstance(value, values.Nanoseconds):
        return durations.text(value)
    return str(value).upper() if isinstance(value, bool) else repr(value) if isinstance(value, str) else str(value)


def _with_plc(function: Callable, plc: PLC) -> Callable[[], object]:
    """The function as one without arguments."""
    import inspect

    try:
        wants = any(
            p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)
            and p.default is p.empty
            or p.kind == p.VAR_POSITIONAL
            for p in inspect.signature(function).parameters.values()
        )
    except ValueError:  # some built-in callables have no signature
        wants = False
    return (lambda: function(plc)) if wants else function

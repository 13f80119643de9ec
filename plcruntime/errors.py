"""What can go wrong between the user and a soft PLC, apart from errors of the source and faults of a program."""

from __future__ import annotations


class UsageError(Exception):
    """What was asked for can't be done: one clear sentence. The command line ends with exit code 2."""


class ConditionTimeout(TimeoutError):
    """`run_until` did not reach its condition. condition: its text; values: what it reads, by path, at the end."""

    def __init__(self, condition: str, limit: str, values: dict[str, str]) -> None:
        self.condition, self.values = condition, values
        now = ", ".join(f"{path} = {value}" for path, value in values.items())
        super().__init__(f"'{condition}' was not reached within {limit}" + (f"; now {now}" if now else ""))

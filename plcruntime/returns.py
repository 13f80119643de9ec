"""The log of commands that did not return 0: when, from where, and why in words."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from stcore.faults import instance_path

if TYPE_CHECKING:
    from plcruntime.plc import PLC

LOGGED, RING = "SIM.logged", "SIM.refused"
MOST = 200_000  # refusals kept; of more only the number is known


@dataclass(frozen=True, slots=True)
class Call:
    """A call that was refused. argument: axis, mask, file's line or what else the command is called with first.

    file, line, column: of the call in the user's text, "" and 0 where none is (typed at the prompt)."""

    command: str
    argument: int
    code: int
    why: str
    file: str
    line: int
    column: int
    instance: str

    @property
    def place(self) -> str:
        return f"{self.file}:{self.line}" if self.file else ""


@dataclass(slots=True)
class Return:
    """The same call refused in one run of its task after the other. scan, last: the first and the last time."""

    call: Call
    scan: int
    last: int
    times: int = 1

    def words(self, interval: float) -> str:
        """What was called, what it returned and why; how often, if more than once. interval: of a scan, in s."""
        call = self.call
        again = f" ({self.times} times until {self.last * interval:.9g} s)" if self.times > 1 else ""
        return f"{call.command}({call.argument}) returned {call.code}: {call.why}{again}"


class ReturnLog:
    """Every refusal from now on, of a PLC that has the GT_ library. lost: how many were too many to keep."""

    def __init__(self, plc: PLC) -> None:
        self.plc = plc
        self.lost = 0
        self._calls: dict[Call, Call] = {}
        self._first: int | None = None
        self._noted: list[tuple[int, Call]] = []

    def begin(self) -> None:
        """Have the module tell; anew after the memory was set up anew. Nothing where the program has no axis."""
        if LOGGED.upper() in self.plc.program.variables:
            self.plc[LOGGED] = True

    def note(self, number: int) -> None:
        """The module has refused a command, its number-th (from 0) since the start."""
        if self._first is None or number < self._first:
            self._first = number
        if number - self._first < len(self._noted):  # the PLC went back: that future is gone
            del self._noted[number - self._first :]
            self.lost = 0
        if len(self._noted) >= MOST:
            self.lost += 1
            return
        call = self._call(self.plc[f"{RING}[{number % 32}]"])
        self._noted.append((self.plc.scans, self._calls.setdefault(call, call)))

    def _call(self, entry: dict) -> Call:
        sites = self.plc._machine.calls_under_way()
        own = next((k for k, site in enumerate(sites) if not _ours(site.file)), None)
        if own is not None:
            site = sites[own]
            place = (site.file, site.line, site.column, instance_path(sites[own:]))
        elif any(site.pou == "GtMotionStep" for site in sites):
            thread = self.plc["GtMotion.turn"]
            source = Path(self.plc["GtMotion.loaded"]).with_suffix(".c")
            place = (str(source), self.plc[f"GtMotion.thread[{thread}].line"], 0, f"thread {thread}")
        else:
            place = ("", 0, 0, "")
        return Call(entry["command"], entry["axis"], entry["code"], entry["why"], *place)

    @property
    def entries(self) -> list[Return]:
        """In the order of time; the same call refused again in the next run of its task is the same entry."""
        slowest = max((task.interval or 0 for task in self.plc.program.timed), default=0)
        patience = max(1, round(slowest / (self.plc.interval * 1e9)))
        running: dict[Call, Return] = {}
        found = []
        for scan, call in self._noted:
            entry = running.get(call)
            if entry and scan - entry.last <= patience:
                entry.last, entry.times = scan, entry.times + 1
            else:
                entry = running[call] = Return(call, scan, scan)
                found.append(entry)
        return found

    def as_json(self) -> dict:
        """For `run --json`: the entries, and how many refusals are not among them."""
        interval = self.plc.interval
        entries = [
            {
                "scan": e.scan, "time": e.scan * interval, **asdict(e.call), "times": e.times,
                "last_time": e.last * interval,
            }
            for e in self.entries
        ]  # fmt: skip
        return {"entries": entries, "lost": self.lost}


@cache
def _ours(file: str) -> bool:
    """Whether a file is of the libraries that come with scancycle."""
    import mclib
    import stcore.compiler

    return any(Path(file).resolve().is_relative_to(f.resolve()) for f in (stcore.compiler.LIBRARY, mclib.LIBRARY))

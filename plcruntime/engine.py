"""The engine of a soft PLC: runs scans in calls that are neither too short nor too long, with all that goes with it.

Between two calls into the module the engine applies scheduled stimuli, drains traces, keeps keyframes, calls the
user's Python models, keeps real time and looks at Ctrl-C. Where nobody looks between scans, a call lasts some 50 ms.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Callable, Sequence
from math import gcd

from plcruntime import kept
from plcruntime.forces import Forces, Piece
from plcruntime.guard import Guard
from plcruntime.recorder import Recorder
from plcruntime.snapshot import History, Snapshot, put_back, take
from plcruntime.stimuli import Schedule
from stcore.faults import Fault
from stcore.program import ALONE, INTERRUPT, INTERVAL, NOW, NULL_PAGE, SCAN, TASK_RATIOS, Program

CALL_SECONDS = 0.05
REALTIME_STEP = 10_000_000  # ns of virtual time between two looks at the wall clock


class Engine:
    """Runs one program on one machine. interval: default length of a scan in ns. watchdog: s, 0 for none.

    fault: what stopped the PLC, None while it is well. run_s: seconds spent inside the module.
    """

    def __init__(self, program: Program, machine, interval: int, watchdog: float) -> None:
        self.program, self.machine = program, machine
        self.interval, self._ratios = _scan_times(program, interval)
        self.forces = Forces(machine)
        self.recorder = Recorder(machine)
        self.history = History()
        self.schedule = Schedule()
        self.guard = Guard(machine, watchdog)
        self.after_scan: list[Callable[[], None]] = []
        self.after_call: list[Callable[[], None]] = []  # whoever looks now and then, some 20 times a second
        self.between_calls: Callable[[int, int], None] | None = None  # (scans done, scans wanted), for progress
        self.fault: Fault | None = None
        self.run_s = 0.0
        self._chunk = 16
        self._busy = False
        self._ending = False  # the run under way ends after its present scan
        self._until = None
        self._waiting: list = []  # traces whose trigger the module looks at
        self._begin()

    # ---------------------------------------------------------------------------------------------- state

    @property
    def scans(self) -> int:
        """Scans finished."""
        return int.from_bytes(self.machine.memory[SCAN : SCAN + 8], "little")

    def restart(self, kind: str) -> None:
        """First image, clock at 0. kind: 'warm' keeps RETAIN and PERSISTENT, 'cold' PERSISTENT, 'origin' nothing."""
        remembered = kept.remember(self.program, self.machine.memory, kind)
        self.fault = None
        self.machine.initialise()
        kept.put_back(remembered, self.machine.memory)
        self._begin()

    def _begin(self) -> None:
        """What the host keeps in the memory of a machine that was initialised."""
        memory = self.machine.memory
        struct.pack_into("<q", memory, INTERVAL, self.interval)
        struct.pack_into(f"<{len(self._ratios)}i", memory, TASK_RATIOS, *self._ratios)
        self.forces.set_state({})
        self.recorder.forget_from(0)
        self.recorder.arrange()
        self.history.clear()
        self.schedule = Schedule()

    def write(self, pieces: Sequence[Piece]) -> None:
        """Write to the image, and remember it for going back."""
        self._put(pieces)
        self.history.log(self.scans, lambda: self._put(pieces))

    def _put(self, pieces: Sequence[Piece]) -> None:
        memory = self.machine.memory
        for address, data in pieces:
            memory[address : address + len(data)] = data

    def change_forces(self, change: Callable[[Forces], None]) -> None:
        """Force or release variables, and remember it for going back."""
        change(self.forces)
        self.forces.write_table()
        state = self.forces.state()
        self.history.log(self.scans, lambda: self.forces.set_state(state))

    # -------------------------------------------------------------------------------------------- running

    def advance(
        self, count: int, *, until=None, test: Callable[[], bool] | None = None, realtime: bool = False
    ) -> bool:
        """Run `count` scans, fewer when a condition holds; True when it did.

        until: a condition that the module knows; test: one in Python, asked after every scan. Raises Fault, and
        KeyboardInterrupt at a scan's boundary.
        """
        if self.fault:
            raise self.fault
        if self._busy:
            raise RuntimeError("the PLC is running: a function called between scans can't run it")
        goal = self.scans + count
        self._busy, self._ending = True, False
        self._until = until
        self._set_conditions()
        try:
            with self.guard.run():
                return self._loop(goal, test, _Clock(self.interval) if realtime else None)
        finally:
            self._until = None
            self.machine.set_until()
            self.recorder.drain(self.scans)
            self._busy = False

    def end_after_scan(self) -> None:
        """To be called while a scan is under way: `advance` ends at its boundary."""
        if not self._ending:
            self._ending = True
            self.machine.end_after_scan()

    def _loop(self, goal: int, test, clock) -> bool:
        first = scans = self.scans
        if self.history.due(self.run_s):
            self._keyframe()
        while scans < goal:
            self.schedule.run_due(scans)
            reached = self._call(self._step(goal - scans, scans, bool(test), clock))
            scans = self.scans
            if self.history.due(self.run_s):
                self._keyframe()
            if self.after_scan or test:
                with self.guard.users_code():
                    for function in self.after_scan:
                        function()
                    reached = reached or bool(test and test())
            for function in self.after_call:
                function()
            if reached or self._ending:
                return reached
            if self.between_calls:
                self.between_calls(scans - first, goal - first)
            if clock:
                clock.wait(scans - first, self.guard)
            if self.guard.stopped:
                raise KeyboardInterrupt
        return False

    def _step(self, left: int, scans: int, tested: bool, clock) -> int:
        """How many scans the next call may run."""
        if tested or self.after_scan or self.recorder.dynamic:
            step = 1
        else:
            step = min(left, self._chunk, self.schedule.scans_until_next(scans) or left)
        if clock:
            step = min(step, clock.step)
        return step

    def _call(self, step: int) -> bool:
        """One call into the module. True when it stopped because its condition holds."""
        if self.recorder.active and self.recorder.full:
            self.recorder.drain(self.scans)
        if self.recorder.dynamic:
            self.recorder.follow_pointers()
        began = time.perf_counter()
        try:
            with self.guard.call():
                done = self.machine.run(step)
        except Fault as fault:
            self.fault = fault
            if self.guard.stopped:
                raise KeyboardInterrupt from fault
            raise
        finally:
            seconds = time.perf_counter() - began
            self.run_s += seconds
        if done >= self._chunk:
            # towards CALL_SECONDS, at most eightfold at a time: the first scans are not like the others
            self._chunk = max(1, min(self._chunk * 8, int(done * CALL_SECONDS / max(seconds, 1e-7))))
        return self._look_at_conditions()

    def _set_conditions(self) -> None:
        """Have the module look at what may end the run, and at the triggers of traces."""
        self._waiting = self.recorder.waiting
        self.machine.set_until(*(t.trigger.module for t in self._waiting), self._until)

    def _look_at_conditions(self) -> bool:
        """Note the triggers that have fired; whether the condition of the run holds."""
        fired = [t for slot, t in enumerate(self._waiting) if self.machine.until_holds(slot)]
        reached = self._until is not None and self.machine.until_holds(len(self._waiting))
        if fired:
            for trace in fired:
                trace.trigger.scan = self.scans - 1
            self._set_conditions()
        return reached

    def choose_test(self, number: int) -> None:
        """Run that test of the program in every scan, 0 for none; until the next restart."""
        struct.pack_into("<i", self.machine.memory, ALONE, number)

    def start_history(self) -> None:
        """What was before can't be repeated: going back ends here."""
        self.history.clear()
        self._keyframe()

    def _keyframe(self) -> None:
        self.history.mark(self.snapshot(), self.run_s)

    # ------------------------------------------------------------------------------------------ snapshots

    def snapshot(self) -> Snapshot:
        return take(self.program, self.machine.memory, self.forces.state(), self.fault)

    def restore(self, snapshot: Snapshot) -> None:
        """Raises ValueError for the snapshot of another program."""
        if snapshot.program is not self.program and snapshot.program.image != self.program.image:
            raise ValueError("the snapshot is of another program")
        self._restore(snapshot)
        self.history.clear()
        self.recorder.forget_from(snapshot.scans)
        self.recorder.arrange()
        self.schedule.rewind(snapshot.scans)

    def _restore(self, snapshot: Snapshot) -> None:
        put_back(snapshot, self.machine.memory)
        self.forces.set_state(snapshot.forces)
        self.fault = snapshot.fault

    def back(self, count: int) -> None:
        """Go back by scans; a scan that ended in a fault counts as one. Raises ValueError beyond what is remembered."""
        self.recorder.drain(self.scans)
        goal = self.scans - count + (1 if self.fault else 0)
        reach = self.history.reach
        if goal == self.scans and not self.fault:
            return
        if count < 0 or reach is None or goal < reach:
            behind = 0 if reach is None else self.scans - reach
            raise ValueError(f"can't go back by {count} scan{'s' if count != 1 else ''}; remembered: {behind}")
        self.go_to(goal)

    def go_to(self, goal: int) -> None:
        """The state after `goal` scans, from the last keyframe before it. A scan left in the middle is undone."""
        snapshot, actions = self.history.path_to(goal)
        self._restore(snapshot)
        self.recorder.pause()
        try:
            for scan, action in actions:
                self._replay(scan)
                action()
            self._replay(goal)
        finally:
            self.recorder.forget_from(self.scans)
            self.recorder.arrange()
        self.schedule.rewind(goal + 1)  # what was due at the goal is in the journal

    def record_again(self, trace, first: int) -> None:
        """Fill a trace with scans that are over, from scan `first` or the oldest that is remembered: run them again."""
        self.recorder.drain(self.scans)
        goal, before = self.scans, self.snapshot()
        snapshot, actions = self.history.path_from(first)
        self._restore(snapshot)
        others = self.recorder.swap([trace])
        try:
            for scan, action in actions:
                self._replay(scan)
                action()
            self._replay(goal)
            self.recorder.drain(self.scans)
        finally:
            self.recorder.swap(others)
            self._restore(before)

    def use(self, machine) -> None:
        """Go on with another build of the same program, at a scan's boundary: their variables lie alike."""
        self.recorder.drain(self.scans)
        old, new, end = self.machine.memory, machine.memory, self.program.state_end
        words = TASK_RATIOS + 4 * len(self._ratios)
        new[NOW:INTERRUPT], new[TASK_RATIOS:words] = old[NOW:INTERRUPT], old[TASK_RATIOS:words]
        new[NULL_PAGE:end] = old[NULL_PAGE:end]
        self.machine = self.guard.machine = machine
        self.forces.move_to(machine)
        self.recorder.move_to(machine)

    def _replay(self, goal: int) -> None:
        """Run to a scan that was reached before; its causes are in the journal, so nobody is called."""
        while (left := goal - self.scans) > 0:
            step = 1 if self.recorder.active and self.recorder.dynamic else left
            with self.guard.run():
                self._call(step)


class _Clock:
    """Keeps virtual time from running ahead of the wall clock."""

    def __init__(self, interval: int) -> None:
        self.interval = interval
        self.step = max(1, REALTIME_STEP // interval)
        self._began = time.monotonic()

    def wait(self, scans: int, guard: Guard) -> None:
        """Sleep until the wall clock has caught up with `scans` scans, or Ctrl-C."""
        end = self._began + scans * self.interval / 1e9
        while (left := end - time.monotonic()) > 0 and not guard.stopped:
            time.sleep(min(left, 0.05))


def _scan_times(program: Program, interval: int) -> tuple[int, list[int]]:
    """The length of a scan in ns, and for each task after how many scans it runs."""
    intervals = [task.interval or interval for task in program.timed]
    scan = gcd(*intervals) if intervals else interval
    return scan, [i // scan for i in intervals]

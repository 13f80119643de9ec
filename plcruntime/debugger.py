"""Breakpoints and statement steps: the scan runs in a thread of its own and waits there while the user looks.

The PLC changes to a probed build of the same program (stcore/emit/probes.wat) at a scan's boundary. A probe that
stops calls the host in the middle of the scan; that call does not return until the user goes on. What is typed
meanwhile runs in that same thread, since a call into a module that is suspended must come from its own thread.
"""

from __future__ import annotations

import queue
import struct
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from plcruntime.breakpoints import Breakpoint, Breakpoints
from plcruntime.builds import Builds
from plcruntime.typed import Result
from stcore.faults import Fault
from stcore.known import Scene
from stcore.paths import instance_at
from stcore.program import ASKING, DEPTH, HOOK_SLOTS, STOP, STOP_DEPTH, Body, Program, Site
from stcore.side import condition

if TYPE_CHECKING:
    from plcruntime.plc import PLC

ANY_DEPTH = 1 << 30
PATIENCE = 1.0  # s after Ctrl-C until a statement that does not end is broken off
TICK = 0.1
MANY = 20_000  # scans after which it is worth to wait for the fast build
OTHERS = 8192  # bytes for the constants of the condition of `until`, before those of breakpoints


class Abandoned(Exception):
    """The scan that waits is given up."""


@dataclass(slots=True)
class Stop:
    """Where a scan waits. breakpoint: its number, None after a step. depth: POUs that are under way."""

    site: Site
    body: Body
    this: int
    frame: int
    depth: int
    instance: str
    breakpoint: int | None = None
    note: str = ""

    @property
    def scene(self) -> Scene:
        """The names that are known here."""
        return _scene(self.body)


def _scene(body: Body) -> Scene:
    return Scene(body.pou, body.block, body.locals)


def _instance(program: Program, body: Body, this: int) -> str:
    """The path of the instance whose code runs; of a function its name."""
    if body.block is None:
        return body.pou
    if body.block.kind == "PROGRAM":
        found = (v.path for v in program.programs() if v.type is body.block and v.address == body.address)
        return next(found, body.pou)
    return instance_at(program, body.block, this) or body.pou


@dataclass(slots=True)
class Outcome:
    """How a run ended. stop: in the middle of a scan, None at a boundary. reached: the condition of `until` held."""

    stop: Stop | None = None
    reached: bool = False


@dataclass(slots=True)
class _Check:
    """A breakpoint's condition in one body, linked. flag: the slot where the module asks it, 1 if the host has to.
    safe: it can't fail."""

    holds: Callable[[int, int], int]
    flag: int
    safe: bool


@dataclass(slots=True)
class _Order:
    """What the thread shall do: scans still to run, the condition that ends it, how to stop on the way."""

    left: int
    until: bytes | None = None
    mode: int = 0
    depth: int = 0
    realtime: bool = False
    events: queue.SimpleQueue = field(default_factory=queue.SimpleQueue)


class Debugger:
    """Runs a PLC's scans with breakpoints. `stop` tells where the scan waits, None between two scans."""

    def __init__(self, plc: PLC) -> None:
        self._plc = plc
        self._engine = plc._engine
        self._builds = Builds(plc)
        self._requests: queue.SimpleQueue = queue.SimpleQueue()
        self._order: _Order | None = None
        self._thread: threading.Thread | None = None
        self._deaf = False  # probes are passed over: typed text runs
        self._checks: dict[tuple[int, int], _Check] = {}  # conditions, by breakpoint and body
        self._checks_size = OTHERS
        self._touched = False  # the user wrote in the middle of the scan: it can't be repeated
        self.breakpoints = Breakpoints(plc)
        self.stop: Stop | None = None

    # ----------------------------------------------------------------------------------------- two builds

    @property
    def active(self) -> bool:
        """True while the probed build runs."""
        return self._builds.probed

    def prepare(self) -> None:
        """Have the build that is not loaded compiled in the background."""
        self._builds.prepare()

    def attach(self) -> None:
        """Change to the probed build. Raises UsageError when the source is no longer what was loaded."""
        machine = self._builds.with_probes()
        if self.breakpoints.program is None:
            machine.on_probe = self._on_probe
            self.breakpoints.program = machine.program

    def detach(self, *, wait: bool = False) -> None:
        """Back to the fast build, when nothing needs the probes any more. wait: until it is there."""
        if self.active and self.stop is None and not self.breakpoints.active:
            self._builds.without_probes(wait=wait)

    # -------------------------------------------------------------------------------------------- running

    def run(self, scans: int, until: bytes | None = None, *, realtime: bool = False) -> Outcome:
        """Run scans, the waiting one included; stops at breakpoints. realtime: keep the wall clock's pace.

        Raises Fault, KeyboardInterrupt at a boundary."""
        if self.breakpoints.active:
            self.attach()
            return self._go(_Order(scans, until, realtime=realtime))
        if self.stop is not None:
            outcome = self._go(_Order(1, until))  # only Ctrl-C stops it on the way
            if outcome.stop is not None or outcome.reached:
                return outcome
            scans -= 1
        self.detach()
        if self.active and scans > MANY:  # the fast build is not there yet
            if self._engine.advance(MANY, until=until, realtime=realtime):
                return Outcome(reached=True)
            scans -= MANY
            self.detach(wait=True)
        return Outcome(reached=self._engine.advance(scans, until=until, realtime=realtime))

    def step(self, how: str) -> Outcome:
        """'next', 'into' or 'out': to the next statement, at the end of the scan to its boundary."""
        self.attach()
        depth = {"into": ANY_DEPTH, "next": self.stop.depth if self.stop else 1}.get(how)
        if depth is None:
            depth = self.stop.depth - 1 if self.stop else 0
        return self._go(_Order(1, mode=2, depth=depth))

    def finish(self) -> Outcome:
        """Let the waiting scan run to its end, past all breakpoints."""
        if self.stop is None:
            return Outcome()
        return self._go(_Order(1, mode=-1))

    def abandon(self) -> None:
        """Undo the waiting scan: back to its beginning."""
        if self.stop is None:
            return
        self.stop = None
        self._requests.put(Abandoned())
        self._thread.join()
        self._quiet()
        self._touched = False
        self._engine.go_to(self._engine.scans)

    def call(self, function: Callable[[], object]) -> object:
        """Run a function in the thread of the waiting scan; what does not end is broken off as an endless loop."""
        self._requests.put(function)
        kind, value = self._wait(self._engine.guard.seconds)
        self._engine.machine.clear_interrupt()  # the waiting scan shall go on
        if kind == "error":
            raise value
        return value

    def evaluate(self, text: str) -> Result:
        """Typed ST, understood where the scan waits, or between two scans. Raises as Typed.run does."""
        stop = self.stop
        if stop is None:
            return self._plc.typed.run(text)
        result, changed = self.call(lambda: self._plc.typed.run_inside(text, stop.scene, stop.this, stop.frame))
        self._touched |= changed
        return result

    def touch(self) -> None:
        """Something was changed in the middle of the scan."""
        self._touched |= self.stop is not None

    def forget(self) -> None:
        """The memory was initialised: conditions have to be linked again."""
        self._checks.clear()
        self._checks_size = OTHERS

    def _go(self, order: _Order) -> Outcome:
        if self.stop is None:
            self._arm(order)
            self._order = order
            self._thread = threading.Thread(target=self._work, name="scancycle scans", daemon=True)
            self._thread.start()
        else:
            self.stop = None
            self._requests.put(order)
        kind, value = self._wait()
        if kind == "stop":
            self.stop = value
            return Outcome(value)
        self._thread.join()
        self._quiet()
        if kind == "error":
            raise value
        return Outcome(reached=value)

    def _quiet(self) -> None:
        """No probe stops while nobody waits for it."""
        self._order = None
        struct.pack_into("<i", self._engine.machine.memory, STOP, 0)

    def _wait(self, limit: float = 0.0) -> tuple[str, object]:
        """What the thread has to say next. Ctrl-C stops it at the next statement. limit: s it may take, 0 for ever."""
        events, waited, hurry = self._order.events, 0.0, 0.0
        interrupted = False
        while True:
            try:
                return events.get(timeout=TICK)
            except queue.Empty:
                waited += TICK
                hurry += TICK if interrupted else 0
                if hurry > PATIENCE or limit and waited > limit:
                    self._engine.machine.interrupt()
            except KeyboardInterrupt:
                interrupted = True
                struct.pack_into("<i", self._engine.machine.memory, STOP, 2)
                struct.pack_into("<i", self._engine.machine.memory, STOP_DEPTH, ANY_DEPTH)

    # ------------------------------------------------------------------------------------- in the thread

    def _arm(self, order: _Order, *, careful: bool = False) -> None:
        """Tell the probes where to stop. careful: the host asks the conditions that might fail."""
        memory = self._engine.machine.memory
        if self.breakpoints.program is not None:
            self.breakpoints.write_flags(memory, lambda point, body: self._flag(point, body, careful))
        mode = order.mode or (1 if self.breakpoints.active else 0)
        struct.pack_into("<i", memory, STOP, max(mode, 0))
        struct.pack_into("<i", memory, STOP_DEPTH, order.depth)

    def _work(self) -> None:
        order = self._order
        events = order.events
        struct.pack_into("<i", self._engine.machine.memory, DEPTH, 0)
        try:
            reached = again = False
            while order.left > 0 and not reached:
                before = self._engine.scans
                # what is recorded can't be taken out in the middle of a scan: nothing may be left of scans before
                count = 1 if self._engine.recorder.active or again else order.left
                try:
                    reached = self._engine.advance(count, until=order.until, realtime=order.realtime)
                    careful, again = again, False
                except Fault:
                    if not self._undo_failed_condition():
                        raise
                    careful, again = False, True  # the host asks, and finds the place
                if self._touched:
                    self._touched = False
                    self._engine.start_history()
                # after a scan that waited there may be another order, and the run has ended at its boundary
                order.left -= self._engine.scans - before if order is self._order else 0
                if order is not self._order:
                    order, careful = self._order, True
                    order.left -= 1
                if careful or again:
                    self._arm(order, careful=again)
            events.put(("done", reached))
        except Abandoned:
            events.put(("done", False))
        except BaseException as error:
            events.put(("error", error))

    def _undo_failed_condition(self) -> bool:
        """Whether the fault is that of a breakpoint's condition, asked inside the module: then the scan is undone."""
        memory = self._engine.machine.memory
        if not struct.unpack_from("<i", memory, ASKING)[0]:
            return False
        struct.pack_into("<i", memory, ASKING, 0)
        struct.pack_into("<i", memory, STOP, 0)
        struct.pack_into("<i", memory, DEPTH, 0)
        self._engine.go_to(self._engine.scans)
        return True

    def _on_probe(self, site: int, body: int, this: int, frame: int) -> None:
        if self._deaf or self._order is None:
            return
        program, memory = self.breakpoints.program, self._engine.machine.memory
        depth = struct.unpack_from("<i", memory, DEPTH)[0]
        where = program.bodies[body]
        stepping = struct.unpack_from("<i", memory, STOP)[0] == 2
        path = _instance(program, where, this)
        stop = Stop(program.sites[site], where, this, frame, depth, path)
        point = next((p for p in self.breakpoints.at(site) if self._holds(p, stop)), None)
        if point is not None:
            stop.breakpoint = point.number
            point.hits += 1
        else:
            # the axes move after the tasks: nobody who steps through his program wants to be led there
            if not stepping or depth > struct.unpack_from("<i", memory, STOP_DEPTH)[0]:
                return
            if where.hook and depth == 1 and self._order.depth != ANY_DEPTH:
                return
        self._suspend(stop)

    def _holds(self, point: Breakpoint, stop: Stop) -> bool:
        """Whether a breakpoint's condition holds; one that fails stops too, and says why."""
        if point.condition is None:
            return True
        self._deaf = True
        try:
            return bool(self._check(point, stop.body).holds(stop.this, stop.frame))
        except Exception as error:  # whatever the condition does wrong, the user shall see it at its place
            why = f"{error.message} ({error.code})" if isinstance(error, Fault) else str(error)
            stop.note = f"the condition failed: {why}"
            return True
        finally:
            self._deaf = False

    def validate(self, point: Breakpoint) -> None:
        """Compile the condition of a breakpoint. Raises CompileError, PathError, SideError for a wrong one."""
        program = self.breakpoints.program
        body = program.bodies[program.probed[point.site]]
        condition(self._plc.typed.names(program), point.condition, _scene(body))

    def _flag(self, point: Breakpoint, body: Body, careful: bool) -> int:
        """What the module finds at a breakpoint: 1, or where it can ask the condition by itself."""
        if point.condition is None:
            return 1
        try:
            check = self._check(point, body)
        except Exception:  # told by _holds, where it stops
            return 1
        return 1 if careful and not check.safe else check.flag

    def _check(self, point: Breakpoint, body: Body) -> _Check:
        """The condition of a breakpoint, linked once. The module asks it, while there is room in the table of hooks."""
        mark = (point.number, id(body))
        if mark not in self._checks:
            machine = self._engine.machine
            side = self._plc.typed.condition(point.condition, _scene(body), self._checks_size)
            self._checks_size += (side.size + 15) // 16 * 16
            free = set(HOOK_SLOTS) - {c.flag for (n, _), c in self._checks.items() if n in self.breakpoints.points}
            flag = machine.hook(min(free), side) if free else 1
            self._checks[mark] = _Check(machine.side(side), flag, side.simple)
        return self._checks[mark]

    def _suspend(self, stop: Stop) -> None:
        """Wait in the middle of the scan; run meanwhile what the other thread asks for. The run ends after this scan,
        for another order may follow."""
        self._engine.end_after_scan()
        self._order.events.put(("stop", stop))
        with self._engine.guard.paused():
            self._serve()

    def _serve(self) -> None:
        while True:
            request = self._requests.get()
            if isinstance(request, Abandoned):
                raise request
            if isinstance(request, _Order):
                request.events = self._order.events
                self._order = request
                self._arm(request, careful=True)  # a scan that has waited is not undone
                return
            self._deaf = True
            try:
                answer = ("answer", request())
            except BaseException as error:
                answer = ("error", error)
            finally:
                self._deaf = False
            self._order.events.put(answer)

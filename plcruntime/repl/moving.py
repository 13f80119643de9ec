"""Commands that let the PLC move: scans, statements, breakpoints, back, reset, snapshots."""

from __future__ import annotations

import re

from plcruntime import durations
from plcruntime.cli.output import Progress
from plcruntime.debugger import Outcome
from plcruntime.errors import UsageError
from plcruntime.repl import store
from stcore.side import condition

UNTIL_LIMIT = "60s"
ENDLESS = 1 << 40


class Moving:
    """See COMMANDS for what each does."""

    def _ns(self) -> int:
        return round(self.plc.interval * 1e9)

    def _scans(self, text: str) -> int:
        try:
            return durations.scans(text, self._ns())
        except ValueError as error:
            raise UsageError(f"{error}, or #100 for scans") from None

    @staticmethod
    def _count(rest: str, command: str) -> int:
        if rest and not rest.isdecimal():
            raise UsageError(f"{command} takes a number of scans, not '{rest}'")
        return int(rest or 1)

    def _run(self, scans: int, until: bytes | None = None) -> Outcome:
        self.session.begin()
        progress = Progress(self.plc.interval)
        self.plc.on_progress(progress)
        try:
            return self.debugger.run(scans, until)
        finally:
            self.plc.on_progress(None)
            progress.end()

    def do_step(self, rest: str) -> None:
        count = self._count(rest, "step")
        if count == 0:
            raise UsageError("step takes a number of scans, 1 at least")
        if self.debugger.stop is not None and count == 1:
            self.session.begin()
            self.session.show(self.debugger.finish())
            return
        self.session.show(self._run(count))

    def do_run(self, rest: str) -> None:
        if not rest:
            raise UsageError("run takes a time: run 2s, run 500ms, run #100 (scans)")
        self.session.show(self._run(self._scans(rest)))

    def do_continue(self, rest: str) -> None:
        if rest:
            raise UsageError("continue takes no arguments; run 2s runs for a time")
        if not self.debugger.breakpoints.active and not self.session.interactive:
            raise UsageError("nothing would stop it: set a breakpoint, or use run 2s or until EXPR")
        self.session.show(self._run(ENDLESS))

    def do_until(self, rest: str) -> None:
        match = re.fullmatch(r"(.*?)(?:\s+for\s+(\S+))?", rest, re.S | re.I)
        text, limit = match[1].strip(), match[2] or UNTIL_LIMIT
        if not text:
            raise UsageError("until takes an ST condition: until PLC_PRG.done AND x > 3")
        scans = self._scans(limit)
        names = self.plc.typed.names(self.plc._machine.program)
        outcome = self._run(scans, condition(names, text).wasm)
        if outcome.stop is None and not outcome.reached:
            self.session.show(outcome, f"'{text}' was not reached within {limit}")
        else:
            self.session.show(outcome)

    def do_back(self, rest: str) -> None:
        count = self._count(rest, "back")
        self.session.begin()
        if self.debugger.stop is not None:
            self.debugger.abandon()
            count -= 1
        if count:
            self.plc.back(count)
        self.session.show(Outcome())

    def do_reset(self, rest: str) -> None:
        kind = rest.lower() or "warm"
        if kind not in ("warm", "cold", "origin"):
            raise UsageError(f"'{rest}' is no reset; there are warm, cold and origin")
        self.debugger.abandon()
        self.session.begin()
        self.plc.reset(kind)
        self.debugger.forget()
        self.session.show(Outcome(), f"{kind} reset")

    # ---------------------------------------------------------------------------------------- statements

    def _statement(self, how: str) -> None:
        self.session.begin()
        self.session.show(self.debugger.step(how))

    def do_next(self, rest: str) -> None:
        self._statement("next")

    def do_into(self, rest: str) -> None:
        self._statement("into")

    def do_out(self, rest: str) -> None:
        self._statement("out")

    def do_break(self, rest: str) -> None:
        points = self.debugger.breakpoints
        if not rest:
            if not points.points:
                self.session.say("no breakpoints; break POU:LINE sets one")
            for p in points.points.values():
                extra = f" if {p.condition}" if p.condition else ""
                self.session.say(f"{p.number}: {p.pou}:{p.line}{extra}, hit {p.hits} time{'s' if p.hits != 1 else ''}")
            return
        match = re.fullmatch(r"([^:\s]+)?\s*:?\s*(\d+)?(?:\s+if\s+(.+))?", rest, re.S | re.I)
        if not match or not (match[1] or match[2]):
            raise UsageError(f"'{rest}' is no place; write break POU:LINE or break POU:LINE if EXPR")
        pou, line = match[1], int(match[2] or 1)
        if pou is not None and pou.isdecimal():
            pou, line = None, int(pou)
        self._prepare()
        if pou is None:
            pou = self._current_pou()
        text = match[3].strip() if match[3] else None
        point = points.add(pou, line, text)
        if text:
            self._check_condition(point)
        place = self.debugger.breakpoints.program.sites[point.site]
        self.session.say(f"breakpoint {point.number}: {point.pou}:{point.line}")
        self.session.show_lines([self.session.source_line(place.file, place.line)])

    def _prepare(self) -> None:
        """Breakpoints need the probed build."""
        if self.debugger.breakpoints.program is None:
            self.debugger.attach()
            self.debugger.detach()

    def _current_pou(self) -> str:
        if self.debugger.stop is not None:
            return self.debugger.stop.site.pou
        programs = self.plc.program.programs()
        running = [name for task in self.plc.program.tasks for name in task.programs]
        return running[0] if running else programs[0].name

    def _check_condition(self, point) -> None:
        """A wrong condition is an error now, not when it is first asked."""
        try:
            self.debugger.validate(point)
        except Exception:
            self.debugger.breakpoints.remove(point.number)
            raise

    def do_delete(self, rest: str) -> None:
        if rest and not rest.isdecimal():
            raise UsageError(f"delete takes the number of a breakpoint, not '{rest}'")
        self.debugger.breakpoints.remove(int(rest) if rest else None)
        self.debugger.detach()

    # ----------------------------------------------------------------------------------------- snapshots

    def do_save(self, rest: str) -> None:
        if not rest:
            names = store.names(self.plc)
            self.session.say("snapshots: " + ", ".join(names) if names else "no snapshots; save NAME keeps one")
            return
        if self.debugger.stop is not None:
            raise UsageError("a snapshot is taken between two scans; step ends this one")
        if self.plc.fault:
            raise UsageError("a PLC in its exception state is not kept; back leads to the scan before")
        store.save(self.plc, rest)
        self.session.say(f"saved {rest}: {self.session.progress()}")

    def do_load(self, rest: str) -> None:
        if not rest:
            raise UsageError(f"load takes a name; kept: {', '.join(store.names(self.plc)) or 'none'}")
        snapshot = store.load(self.plc, rest)
        self.debugger.abandon()
        self.session.begin()
        self.plc.restore(snapshot)
        self.session.show(Outcome(), f"loaded {rest}")

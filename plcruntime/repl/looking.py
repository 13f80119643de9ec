"""Commands that show and change variables: print, watch, set, force, diff, axes, list, plot, trace."""

from __future__ import annotations

import fnmatch
import re
from pathlib import Path

from plcruntime import layout
from plcruntime.debugger import Outcome
from plcruntime.errors import UsageError
from plcruntime.repl import axis_table, chart
from plcruntime.repl.moving import ENDLESS
from plcruntime.repl.session import counted
from stcore import paths
from stcore.paths import PathError
from stcore.types import Block

AROUND = 5  # lines above and below
KEPT = 200_000  # scans that a plot repeats at most
_TRIGGERED = re.compile(r"(.+?)(?:\s+if\s+(.+?)(?:\s+pre\s+(\S+))?(?:\s+post\s+(\S+))?)?", re.S | re.I)


class Looking:
    """See COMMANDS for what each does."""

    def do_print(self, rest: str) -> None:
        if not rest:
            raise UsageError("print takes an ST expression")
        self.session.say(self.session.evaluate_text(rest))

    def do_where(self, rest: str) -> None:
        stop = self.debugger.stop
        if stop is None:
            state = "in its exception state, " if self.plc.fault else ""
            self.session.say(f"{state}between two scans: {self.session.progress()}")
            return
        self.session.say(f"{stop.instance}, {stop.site.file}:{stop.site.line}, call depth {stop.depth}")
        self.session.say(f"in scan {self.plc.scans}, {self.session.time()}")

    def do_vars(self, rest: str) -> None:
        pattern = (rest or "*").upper().replace("[", "[[]")
        rows = []
        for place in paths.user_places(self.plc.program):
            name = place.name.upper()
            if fnmatch.fnmatchcase(name, pattern) or fnmatch.fnmatchcase(name, f"*.{pattern}"):
                rows.append((place.name, self.session.value_text(place.name), str(place.type)))
        if not rows:
            raise UsageError(f"no variable is called {rest}")
        self.session.table(("variable", "value", "type"), rows)

    def do_watch(self, rest: str) -> None:
        if not rest:
            if not self.session.watched:
                self.session.say("nothing is watched; watch EXPR adds something")
            self.session.show_watched()
            return
        value = self.session.evaluate_text(rest)  # what can't be evaluated is not watched
        if rest not in self.session.watched:
            self.session.watched.append(rest)
        self.session.say(f"  {rest} = {self.session.short(value)}")

    def do_unwatch(self, rest: str) -> None:
        if not rest:
            self.session.watched.clear()
        elif rest in self.session.watched:
            self.session.watched.remove(rest)
        else:
            raise UsageError(f"{rest} is not watched; watched: {', '.join(self.session.watched) or 'nothing'}")

    # --------------------------------------------------------------------------------------- set and force

    @staticmethod
    def _assignment(rest: str, command: str) -> tuple[str, str]:
        match = re.fullmatch(r"(.+?)\s*:?=\s*(.+?);?", rest, re.S)
        if not match:
            raise UsageError(f"write {command} VAR := VALUE")
        return match[1], match[2]

    def do_set(self, rest: str) -> None:
        name, value = self._assignment(rest, "set")
        several = re.match(r"\[|\(\s*\w+\s*:=", value)  # no ST outside of declarations
        if several or self.debugger.stop is None:
            path = self.session.place(name).name if self.debugger.stop else name
            self.plc.place(path)
            try:
                parsed = self.plc.parse_value(path, value)
            except (TypeError, ValueError, PathError):
                if several:
                    raise
                # not a literal of that type: an expression
            else:
                self.plc[path] = parsed
                self.debugger.touch()
                return
        self.debugger.evaluate(f"{name} := {value};")

    def do_force(self, rest: str) -> None:
        if not rest:
            forced = [(name, self.plc.show(name)) for name in self.plc.forced]
            self.session.table(("forced", "value"), forced) if forced else self.session.say("nothing is forced")
            return
        name, text = self._assignment(rest, "force")
        place = self.plc.place(name)
        try:
            value = self.plc.parse_value(name, text)
        except (TypeError, ValueError, PathError) as error:
            try:
                value = self.debugger.evaluate(text).value
            except Exception:
                raise error from None
        self.plc.force(name, value)
        self.debugger.touch()
        self.session.say(f"forced: {place.name} = {self.plc.show(place.name)}")

    def do_unforce(self, rest: str) -> None:
        self.plc.unforce(rest or None)
        self.debugger.touch()

    def do_diff(self, rest: str) -> None:
        if rest.lower() not in ("", "all"):
            raise UsageError(f"'{rest}' is no diff; there are diff and diff all")
        rows = self.session.changes(bool(rest))
        if rows:
            self.session.table(("variable", "before", "now"), [tuple(map(self.session.short, r)) for r in rows])
        else:
            inside = not rest and self.session.changes(True)
            more = "outside of library blocks has changed; diff all shows what has inside"
            self.session.say(f"nothing {more}" if inside else "nothing has changed")

    # ----------------------------------------------------------------------------------------------- axes

    def do_axes(self, rest: str) -> None:
        if rest:
            self._run_and_show_axes(rest)
            return
        lines = axis_table.lines(self.plc, layout.width())
        self.session.show_lines(lines)
        if not lines:
            self.session.say("the program uses no axis" if not len(self.plc.axes) else "no axis is in use yet")

    def _run_and_show_axes(self, rest: str) -> None:
        endless = rest.lower() == "live"
        if not len(self.plc.axes):
            raise UsageError("the program uses no axis")
        if endless and not self.session.interactive:
            raise UsageError("axes live needs a terminal; axes 2s runs 2 s and shows the axes then")
        scans = ENDLESS if endless else self._scans(rest)
        if self.session.interactive:
            self._live(scans)
        else:
            self.session.show(self._run(scans))
            self.do_axes("")

    def _live(self, scans: int) -> None:
        from plcruntime.repl.live import KeyPressed, live_axes

        self.session.begin()
        outcome = Outcome()
        try:
            with live_axes(self.plc) as display:
                self.plc.on_progress(display)
                outcome = self.debugger.run(scans, realtime=True)
        except KeyPressed:
            pass  # that is how it is meant to end
        finally:
            self.plc.on_progress(None)
        self.session.show(outcome)

    # --------------------------------------------------------------------------------------------- source

    def do_list(self, rest: str) -> None:
        stop = self.debugger.stop
        file, line, current = "", 0, 0
        match = re.fullmatch(r"([^\W\d][\w.]*)?:?(\d+)?", rest)
        if not match:
            raise UsageError(f"'{rest}' is no place; write list POU, list POU:LINE or list LINE")
        if stop is not None:
            file, line, current = stop.site.file, stop.site.line, stop.site.line
        if match[1] or stop is None:
            file, line = self._pou_place(match[1])
            current = current if stop is not None and stop.site.file == file else 0
            line += AROUND
        if match[2]:
            line = int(match[2])
        lines = self.session.lines_of(file)
        if not lines:
            raise UsageError(f"the source of {file or 'this program'} is not in a file")
        if line - AROUND > len(lines):
            raise UsageError(f"{Path(file).name} has {len(lines)} lines")
        marked = {p.line for p in self.debugger.breakpoints.points.values() if self._file_of(p) == file}
        for number in range(max(1, line - AROUND), min(len(lines), line + AROUND) + 1):
            mark = ">" if number == current else "*" if number in marked else " "
            self.session.show_lines([self.session.source_line(file, number, mark)])

    def _file_of(self, point) -> str:
        return self.debugger.breakpoints.program.sites[point.site].file

    def _pou_place(self, name: str | None) -> tuple[str, int]:
        if name is None:
            name = self._current_pou()
        routine = self.plc.program.routines.get(name.upper())
        if routine is None:
            variable = self.plc.program.variables.get(name.upper())
            if variable is None or not isinstance(variable.type, Block):
                raise UsageError(f"no POU {name} is in this program")
            return variable.file, variable.line
        return routine.file, routine.line

    # ------------------------------------------------------------------------------------- plot and trace

    def do_plot(self, rest: str) -> None:
        match = re.fullmatch(r"(.*?)(?:\s+to\s+(\S+))?", rest, re.S | re.I)
        names, file = match[1].replace(",", " ").split(), match[2]
        if not names:
            raise UsageError("plot takes variables: plot PLC_PRG.x, plot PLC_PRG.x to x.png")
        trace = self._recorded(names)
        if file is None:
            for name in trace.names:
                self.session.show_lines(chart.draw(trace.time, trace[name], name))
            return
        if Path(file).suffix.lower() not in (".png", ".svg", ".html"):
            raise UsageError(f"{file}: the name must end with .png, .svg or .html")
        from plcruntime.plot import draw

        draw(trace, file, plc=self.plc, watched=trace.names)
        self.session.say(f"wrote {file}")

    def _recorded(self, names: list[str]):
        """The scans so far, run once more with a recorder."""
        from plcruntime.trace import Trace

        places = [leaf for n in names for leaf in paths.leaves(self.plc.place(n))]
        for place in places:
            if not paths.is_scalar(place):
                raise UsageError(f"{place.name} is {place.type}: only numbers, BOOL and times can be drawn")
        if self.debugger.stop is not None:
            raise UsageError("a plot shows whole scans; step ends this one")
        if self.plc.scans == 0:
            raise UsageError("nothing has run yet; run 1s, then plot")
        trace = Trace(places, round(self.plc.interval * 1e9))
        self.plc._engine.record_again(trace, max(0, self.plc.scans - KEPT))
        return trace

    def do_trace(self, rest: str) -> None:
        trace = self.session.trace
        if not rest:
            rows = f"{counted(len(trace))} of {', '.join(trace.names)}" if trace else "nothing; trace VAR... begins"
            self.session.say(f"recorded: {rows}{self._trigger_text(trace)}")
        elif rest.lower() == "off":
            if trace is None:
                raise UsageError("nothing is recorded")
            self.plc.stop_trace(trace)
            self.session.trace = None
        elif match := re.fullmatch(r"to\s+(\S+)", rest, re.I):
            self._write_trace(match[1])
        else:
            match = _TRIGGERED.fullmatch(rest)
            names, condition, pre, post = match.groups()
            around = {"trigger": condition, "pre": pre or "50ms", "post": post or "200ms"} if condition else {}
            started = self.plc.trace(*names.replace(",", " ").split(), **around)
            if trace is not None:
                self.plc.stop_trace(trace)
            self.session.trace = started
            self.session.say(f"recording {', '.join(started.names)}{self._trigger_text(started)}")

    @staticmethod
    def _trigger_text(trace) -> str:
        """What a trace with a trigger waits for, or when that came."""
        if trace is None or trace.trigger is None:
            return ""
        when = "not yet" if trace.trigger.scan is None else f"in scan {trace.trigger.scan}"
        return f"; '{trace.trigger.text}' came true: {when}"

    def _write_trace(self, file: str) -> None:
        trace = self.session.trace
        if trace is None:
            raise UsageError("nothing is recorded; trace VAR... begins")
        suffix = Path(file).suffix.lower()
        if suffix not in (".csv", ".npz"):
            raise UsageError(f"{file}: the name must end with .csv or .npz")
        (trace.to_csv if suffix == ".csv" else trace.to_npz)(file)
        self.session.say(f"wrote {file}: {counted(len(trace))}{self._trigger_text(trace)}")

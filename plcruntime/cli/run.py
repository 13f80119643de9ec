"""``scancycle run``: everything is checked before the first scan, so that nothing is half-run."""

from __future__ import annotations

import argparse
import os
import sys
import time
from dataclasses import asdict
from pathlib import Path

from plcruntime import durations, report, stimuli
from plcruntime.cli import DONE, FAILED, INTERRUPTED, NOT_REACHED, USAGE, output
from plcruntime.errors import ConditionTimeout, UsageError
from stcore.diagnostics import CompileError
from stcore.paths import PathError

DURATION, UNTIL_LIMIT = "5s", "60s"
TRACES, PLOTS, REPORTS = (".csv", ".npz", ".html"), (".png", ".svg", ".html"), (".html",)
EVERYTHING = "*"
SHOWN = 60  # characters of a value in the table


def execute(arguments: argparse.Namespace) -> int:
    _check_arguments(arguments)
    began = time.perf_counter()
    try:
        with output.working("compiling"):
            plc = _load(arguments)
    except CompileError as error:
        return _not_compiled(arguments, error)
    run = Run(plc, arguments, time.perf_counter() - began)
    return run.execute()


def _check_arguments(arguments: argparse.Namespace) -> None:
    """What can be seen to be wrong before anything is read."""
    if arguments.scans is not None and arguments.duration:
        raise UsageError("--for and --scans both say how long to run; give one")
    if arguments.scans is not None and arguments.scans < 0:
        raise UsageError("--scans takes a number that is not negative")
    if arguments.trigger and not (arguments.trace or arguments.plot):
        raise UsageError("--trigger is for --trace and --plot; give one of them")
    if arguments.overlay and not arguments.report:
        raise UsageError("--overlay is for --report; give it too")
    for option in ("task_interval", "duration", "watchdog", "pre", "post"):
        text = getattr(arguments, option)
        name = "--for" if option == "duration" else "--" + option.replace("_", "-")
        if text is not None and not (option in ("duration", "pre", "post") and text.startswith("#")):
            ns = _duration(name, text)
            if option == "task_interval" and ns <= 0:
                raise UsageError(f"{name}: an interval must be longer than 0")
    for option, suffixes in (("trace", TRACES), ("plot", PLOTS), ("report", REPORTS)):
        path = getattr(arguments, option)
        if path:
            _check_output(f"--{option}", Path(path), suffixes)
    if arguments.report:
        from plcruntime.html_report.page import plotly_script

        plotly_script()


def _duration(name: str, text: str) -> int:
    try:
        return durations.nanoseconds(text)
    except ValueError as error:
        raise UsageError(f"{name}: {error}") from None


def _check_output(option: str, path: Path, suffixes: tuple[str, ...]) -> None:
    if path.suffix.lower() not in suffixes:
        raise UsageError(f"{option} {path}: the name must end with {', '.join(suffixes)}")
    folder = path.parent
    if not folder.is_dir():
        raise UsageError(f"{option} {path}: there is no folder {folder}")
    if path.is_dir() or not os.access(path if path.exists() else folder, os.W_OK):
        raise UsageError(f"{option} {path}: can't be written")


def _load(arguments: argparse.Namespace):
    from plcruntime.plc import PLC

    watchdog = durations.nanoseconds(arguments.watchdog) / 1e9 if arguments.watchdog else None
    return PLC.load(
        arguments.files,
        interval=arguments.task_interval,
        config=arguments.config,
        strict=arguments.strict,
        watchdog=watchdog,
        retain=arguments.retain,
    )


def _not_compiled(arguments: argparse.Namespace, error: CompileError) -> int:
    if not arguments.json:
        output.print_diagnostics(error.diagnostics)
    print(f"{output.summary(error.diagnostics)}; nothing was run", file=sys.stderr)
    if arguments.json:
        result = {
            "scans": 0,
            "time": 0.0,
            "stopped": "error",
            "fault": None,
            "diagnostics": _as_objects(error.diagnostics),
        }
        print(output.to_json({**result, "vars": {}, "timing": None}))
    return FAILED


def _as_objects(diagnostics) -> list[dict]:
    return [asdict(d) for d in diagnostics]


def split_names(options: list[str]) -> list[str]:
    """The names of ``--watch a,b[1,2] --watch c``: commas inside brackets do not divide."""
    names, depth, start = [], 0, 0
    text = ",".join(options)
    for i, c in enumerate(text + ","):
        depth += (c == "[") - (c == "]")
        if c == "," and depth <= 0:
            names.append(text[start:i].strip())
            start = i + 1
    return [n for n in names if n]


class Run:
    """One run of the command, from the loaded PLC to the exit code."""

    def __init__(self, plc, arguments: argparse.Namespace, compile_s: float) -> None:
        self.plc, self.arguments, self.compile_s = plc, arguments, compile_s
        self.stopped = "for"
        self.retain_problem = ""
        self.returns = plc.log_returns() if arguments.log_returns else None
        try:
            names = split_names(arguments.watch)
            self.everything = EVERYTHING in names
            self.watched = [plc.place(name).name for name in names if name != EVERYTHING]
        except PathError as error:
            raise UsageError(f"--watch: {error}") from None
        for option in ("set", "force"):
            for text in getattr(arguments, option):
                plc.stimulate(stimuli.parse(text), force=option == "force")
        for file in (*([plc.project.stimuli] if plc.project.stimuli else []), *arguments.stimuli):
            plc.stimuli(file)
        self.count = self._scans_to_run()
        self.trace, self.picture, self.recording = self._record()

    def _scans_to_run(self) -> int:
        if self.arguments.scans is not None:
            return self.arguments.scans
        text = self.arguments.duration or (UNTIL_LIMIT if self.arguments.until else DURATION)
        try:
            return durations.scans(text, round(self.plc.interval * 1e9))
        except ValueError as error:
            raise UsageError(f"--for: {error}") from None

    def _record(self):
        """(what goes into the trace file, what is drawn, what the report shows)"""
        trace = picture = recording = None
        arguments, plc = self.arguments, self.plc
        around = {"trigger": arguments.trigger, "pre": arguments.pre, "post": arguments.post}
        try:
            if arguments.trace:
                names = self._with_axes() if Path(arguments.trace).suffix.lower() == ".npz" else self._names()
                trace = plc.trace(*names, **around)
                if trace.left_out:
                    self._say(f"large arrays are not traced unless they are named: {', '.join(trace.left_out)}")
            if arguments.plot:
                from plcruntime.picture import axis_names

                names = [*axis_names(plc, self.count), *(self.watched or self._scalars())]
                picture = plc.trace(*names, **around)
            if arguments.report:
                from plcruntime.html_report.overlay import Overlay
                from plcruntime.html_report.recording import Recording

                recording = Recording(plc, self.watched, self.count)
                if arguments.overlay:
                    Overlay(Path(arguments.overlay), recording.trace.places)  # one that is none is told now
        except (ValueError, PathError) as error:
            raise UsageError(str(error)) from None
        except CompileError as error:
            output.print_diagnostics(error.diagnostics)
            raise UsageError(f"--trigger: '{arguments.trigger}' is not a condition of this program") from None
        return trace, picture, recording

    def _names(self) -> list[str]:
        """What is traced; none for all scalars."""
        return [EVERYTHING] if self.everything else self.watched

    def _with_axes(self) -> list[str]:
        """For a file that a later report may draw behind its own run: without --watch the axes' curves too."""
        from plcruntime.picture import axis_names

        curves = axis_names(self.plc, self.count)
        return self._names() if self.watched or self.everything or not curves else [*self._scalars(), *curves]

    def _scalars(self) -> list[str]:
        from stcore.paths import is_scalar, user_places

        return [p.name for p in user_places(self.plc.program) if is_scalar(p)]

    def execute(self) -> int:
        if not self.arguments.json:
            output.print_diagnostics(self.plc.diagnostics)
        if self.plc.retain:
            for sentence in self.plc.retain.report.sentences():
                self._say(f"retain file {self.plc.retain.path}: {sentence}")
        progress = output.Progress(self.plc.interval)
        self.plc.on_progress(progress)
        code = DONE
        try:
            self._run()
        except ConditionTimeout as error:
            self.stopped, code = "until not reached", NOT_REACHED
            self._say(str(error))
        except KeyboardInterrupt:
            self.stopped, code = "interrupt", INTERRUPTED
        except CompileError as error:
            return self._wrong_condition(error)
        finally:
            progress.end()
        if self.plc.fault and self.stopped != "interrupt":
            self.stopped, code = "fault", FAILED
        if self.stopped in ("for", "scans"):
            self._tell_late_stimuli()
        if self.retain_problem:
            self._say(self.retain_problem)
            code = code or USAGE
        if code == DONE and self._untriggered():
            self._say(f"the trigger '{self.arguments.trigger}' never came true, so there is nothing to write")
            code = NOT_REACHED
        self._show()
        return self._write_files(code)

    def _tell_late_stimuli(self) -> None:
        """A value at a time that the run did not reach is most often a slip in the time."""
        late = sorted(x for x in self.plc.scheduled if x[0] >= self.plc.scans)
        if late:
            at, first = late[0]
            others = f" and {len(late) - 1} more" if len(late) > 1 else ""
            self._say(f"the run ended before {first} at {at * self.plc.interval:.9g} s{others}")

    def _untriggered(self) -> bool:
        traces = [t for t in (self.trace, self.picture) if t is not None and t.trigger]
        return any(t.triggered is None for t in traces)

    def _run(self) -> None:
        from stcore.faults import Fault

        try:
            if self.arguments.until:
                self.plc.run_until(self.arguments.until, f"#{self.count}", realtime=self.arguments.realtime)
                self.stopped = "until"
            else:
                self.plc.run(f"#{self.count}", realtime=self.arguments.realtime)
                self.stopped = "scans" if self.arguments.scans is not None else "for"
        except Fault:
            return  # plc.fault tells it; the image, traces and plots are shown all the same
        except UsageError as error:  # the retain file, at the end of the run: what was run is shown all the same
            self.retain_problem = str(error)

    def _wrong_condition(self, error: CompileError) -> int:
        output.print_diagnostics(error.diagnostics)
        raise UsageError(f"--until: '{self.arguments.until}' is not a condition of this program")

    def _say(self, text: str) -> None:
        print(f"scancycle: {text}", file=sys.stderr)

    # ------------------------------------------------------------------------------------------ results

    def _show(self) -> None:
        plc = self.plc
        if not self.arguments.json:
            output.print_diagnostics(plc.warnings)
        if plc.fault:
            print(report.fault_text(plc.fault, plc.time), file=sys.stderr)
        if self.stopped == "interrupt":
            self._say(f"interrupted after {plc.scans} scans, at {plc.time:.9g} s")
        if self.arguments.json:
            print(output.to_json(self._result()))
        else:
            self._print_values()
            if self.returns:
                self._print_returns()
            self._print_summary()

    def _result(self) -> dict:
        plc = self.plc
        speed = plc.time / plc.run_seconds if plc.run_seconds else None
        returns = {"returns": self.returns.as_json()} if self.returns else {}
        return {
            "scans": plc.scans, "time": plc.time, "stopped": self.stopped,
            "fault": report.fault_json(plc.fault, plc.time) if plc.fault else None,
            "diagnostics": _as_objects(plc.diagnostics), "vars": self._values(),
            "timing": {"compile_s": self.compile_s, "run_s": plc.run_seconds, "real_time_factor": speed}, **returns,
        }  # fmt: skip

    def _values(self) -> dict:
        if not self.watched:
            return self.plc.variables()
        return {name: self._value(name) for name in self.watched}

    def _value(self, name: str):
        try:
            return self.plc[name]
        except PathError:  # behind a pointer that is NULL at the end
            return None

    def _print_values(self) -> None:
        from stcore import paths
        from stcore.show import show

        rows = []
        for name in self.watched or [place.name for place in paths.user_places(self.plc.program)]:
            value, kind = self._value(name), self.plc.place(name).type
            shown = "NULL" if value is None else show(kind, value)
            rows.append((name, shown if len(shown) <= SHOWN or self.watched else shown[: SHOWN - 3] + "...", str(kind)))
        if rows:
            output.print_table(("variable", "value", "type"), rows)

    def _print_returns(self) -> None:
        """The log of --log-returns, a line a call; the same call again and again is one line."""
        interval = self.plc.interval
        entries = self.returns.entries
        for entry in entries:
            call = entry.call
            inside = f" in {call.instance}" if call.instance else ""
            print(f"{entry.scan * interval:.9g} s  {call.place or '(typed)'}{inside}: {entry.words(interval)}")
        if not entries:
            print("every command returned 0")
        if self.returns.lost:
            print(f"{self.returns.lost} more commands did not return 0: too many to note them")

    def _print_summary(self) -> None:
        from plcruntime import layout

        plc = self.plc
        seconds = plc.run_seconds
        speed = f", {plc.time / seconds:,.0f} times real time" if seconds and not self.arguments.realtime else ""
        text = (
            f"{plc.scans} scans of {durations.text(round(plc.interval * 1e9))}: {plc.time:.9g} s of virtual time "
            f"in {seconds:.3g} s{speed}; stopped: {self.stopped}"
        )
        print("\n".join(layout.broken(text, layout.width())))

    def _write_files(self, code: int) -> int:
        """Gives the exit code: a file that can't be written changes it, unless something worse happened."""
        title = ", ".join(Path(f).name for f in self.arguments.files)
        arguments = self.arguments
        results = (
            (self.trace, arguments.trace), (self.picture, arguments.plot), (self.recording, arguments.report)
        )  # fmt: skip
        for result, path in results:
            if result is None or getattr(result, "trigger", None) and result.triggered is None:
                continue
            try:
                if result is self.recording:
                    result.to_html(path, title=title, overlay=arguments.overlay, stopped=self.stopped)
                else:
                    self._write(result, path, title)
            except (OSError, UsageError) as error:
                problem = f"can't write {path}: {error.strerror or error}" if isinstance(error, OSError) else str(error)
                self._say(problem)
                code = code or USAGE
                continue
            if not self.arguments.json:
                print(f"wrote {path}")
        return code

    def _write(self, trace, path: str, title: str) -> None:
        suffix = Path(path).suffix.lower()
        if trace is self.trace and suffix == ".csv":
            trace.to_csv(path)
        elif trace is self.trace and suffix == ".npz":
            trace.to_npz(path)
        else:
            from plcruntime.plot import draw

            draw(trace, path, plc=self.plc, title=title, watched=self.watched or None)

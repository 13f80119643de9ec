"""PLC: a soft PLC in virtual time, as a Python object.

    plc = PLC.load("prog.st", interval="1ms")
    plc["PLC_PRG.xStart"] = True
    plc.run_until("PLC_PRG.axisDone", timeout="10s")
    print(plc["PLC_PRG.lrPrfPos"], plc.time)

Times are virtual: scan number k (from 0) sees k * interval, and nothing depends on the wall clock.
"""

from __future__ import annotations

import atexit
import weakref
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from plcruntime import durations, sources
from plcruntime.axes import ROOT, Axes
from plcruntime.durations import Time
from plcruntime.engine import Engine
from plcruntime.errors import UsageError
from plcruntime.project import Project
from plcruntime.running import Running
from plcruntime.snapshot import Snapshot
from plcruntime.variables import Variables
from stcore import paths
from stcore.diagnostics import Diagnostic
from stcore.faults import Fault
from stcore.paths import PathError, Place
from stcore.program import Program

if TYPE_CHECKING:
    from plcruntime.html_report.recording import Recording
    from plcruntime.retain import RetainFile
    from plcruntime.returns import ReturnLog
    from plcruntime.trace import Trace
    from plcruntime.trigger import Trigger
    from plcruntime.typed import Typed
    from plcruntime.warnings import RunWarning

INTERVAL = 1_000_000  # ns, of a scan where nothing says otherwise
WATCHDOG = 2.0  # s of wall clock for one scan
MAX_COLUMNS = 5000  # of a trace
MAX_ELEMENTS = 1000  # of an array in a trace of every variable
FOREVER = 1 << 62  # scans


class PLC(Variables, Running):
    """A loaded program with its memory image, its clock and its simulated axes.

    Read and write variables by path: ``plc["PLC_PRG.trap.acc"]``, ``plc["%QX0.3"] = True``. BOOL is bool, integers are
    int, REAL and LREAL float, TIME and dates seconds, strings str, arrays lists, structures and instances dicts (a
    dict that is written may name only some members).
    """

    def __init__(
        self, program: Program, *, interval: Time | None = None, project: Project | None = None,
        watchdog: float | None = None, machine: Callable | None = None, retain: str | Path | None = None,
    ) -> None:  # fmt: skip
        """program: as stcore.compile gives it. interval: of a scan, 1 ms if None. watchdog: s of wall clock that one
        scan may take, 0 for no limit. machine: what runs the program, wasmtime if None. retain: the file that RETAIN
        and PERSISTENT variables are read from and kept in, see `save_retain`.

        Raises ValueError for a bad interval, Fault when an initial value can't be worked out, UsageError for a retain
        file that can't be used."""
        self.program = program
        self.project = project or Project()
        limit = watchdog if watchdog is not None else self.project.watchdog
        ns = durations.nanoseconds(interval) if interval is not None else self.project.interval or INTERVAL
        if ns <= 0:
            raise ValueError(f"an interval of {interval} is not longer than 0")
        self.axes = Axes(self)
        self._places: dict[str, Place] = {}
        host = _motion_host(program)
        if machine is None:
            from stcore.machine import Machine as machine
        self._make_machine = machine
        self._functions = host.functions(self) if host else {}
        self._typed: Typed | None = None
        self.scheduled: list[tuple[int, str]] = []  # scan and text of every stimulus, for reports
        self.assertion: Exception | None = None  # of an ST test, the one that failed
        self.origin: dict | None = None  # what `build` was told, for another build of the same program
        self.returns: ReturnLog | None = None  # see `log_returns`
        self._machine = self.new_machine(program)
        self._engine = Engine(program, self._machine, ns, WATCHDOG if limit is None else limit)
        self._bind = host.bind_axes if host else None
        self.retain: RetainFile | None = None  # its `report` tells what became of the values that it held
        if retain := retain or self.project.retain:
            self._open_retain(retain)
        self._configure()

    @classmethod
    def load(
        cls, source: str | Path | Sequence[str | Path], interval: Time | None = None, config: str | Path | None = None,
        *, strict: bool = False, watchdog: float | None = None, retain: str | Path | None = None, probes: bool = False,
    ) -> PLC:  # fmt: skip
        """Compile and load, ready before the first scan.

        source: a file, a folder, a plc.toml, the text of a program, or a list of files. interval: of a scan ('1ms').
        config: a plc.toml beside the source. strict: a mended misprint is an error. retain: the retain file, else that
        of the plc.toml, else none. probes: the build that can stop at every statement, slower: for the prompt.
        Raises stcore.CompileError with .diagnostics (a file that can't be read too), UsageError (a wrong plc.toml, a
        retain file that can't be used).
        """
        program, project = build(source, config, strict=strict, probes=probes)
        plc = cls(program, interval=interval, project=project, watchdog=watchdog, retain=retain)
        plc.origin = {"source": source, "config": config, "strict": strict}
        return plc

    def new_machine(self, program: Program):
        """A machine for this program or another build of it, with the functions that the host provides."""
        functions = self._functions | _test_host(self, program)
        spelled = {e.name: functions[e.name.upper()] for e in program.externals if e.name.upper() in functions}
        return self._make_machine(program, spelled)

    # ------------------------------------------------------------------------------------------- typed ST

    def evaluate(self, text: str):
        """The value of an ST expression over the program's variables and functions: ``plc.evaluate("Twice(n) + 1")``.

        Raises stcore.CompileError, PathError, stcore.side.SideError, Fault (the PLC stays as it is).
        """
        return self.typed.run(text).value

    def execute(self, text: str) -> None:
        """Run ST statements now, between two scans: ``plc.execute("n := 5; timer(IN := TRUE);")``.

        Raises as `evaluate` does."""
        self.typed.run(text)

    @property
    def typed(self) -> Typed:
        """What evaluates and executes typed text."""
        if self._typed is None:
            from plcruntime.typed import Typed

            self._typed = Typed(self)
        return self._typed

    def __repr__(self) -> str:
        name = Path(self.program.files[0]).name if self.program.files else "PLC"
        state = f", fault {self.fault.code}" if self.fault else ""
        return f"<PLC {name}: {self.scans} scans, {self.time:.9g} s{state}>"

    # ------------------------------------------------------------------------------------- what went wrong

    @property
    def fault(self) -> Fault | None:
        """What put the PLC into its exception state: code, message, file, line, column, instance, scan, hint."""
        return self._engine.fault

    @property
    def diagnostics(self) -> list[Diagnostic]:
        """The compiler's warnings, then those of the running program (`warnings`)."""
        return [*self.program.diagnostics, *self.warnings]

    @property
    def warnings(self) -> list[RunWarning]:
        """What the program did wrong with its motion blocks so far: codes W08.., each with the block's instance path,
        scan and time; once for each block and code. ``scancycle explain W0801`` has the page of a code."""
        from plcruntime import warnings

        return warnings.of(self)

    # ------------------------------------------------------------------------------------------ recording

    def trace(self, *names: str, trigger: str | None = None, pre: Time = 0, post: Time | None = None) -> Trace:
        """Record variables at the end of every scan from now on; arrays and structures become a column an element.

        Without names: every scalar variable of the user; "*": every variable, members of instances and elements of
        arrays of up to MAX_ELEMENTS too. trigger: an ST condition; only the scans from `pre` before to `post` after the
        scan in which it first holds are kept (times as in `run`; post None: all that follow).
        Raises PathError, ValueError for more than MAX_COLUMNS, stcore.CompileError and UsageError for the trigger.
        """
        from plcruntime.trace import Trace

        left_out = []
        if names == ("*",):
            small, left_out = paths.small_places(self.program, MAX_ELEMENTS)
            places = [leaf for place in small for leaf in paths.leaves(place)]
        elif names:
            places = [leaf for name in names for leaf in paths.leaves(self.place(name))]
        else:
            places = [p for p in paths.user_places(self.program) if paths.is_scalar(p)]
        if len(places) > MAX_COLUMNS:
            raise ValueError(f"{len(places)} columns are too many for a trace; name some of them")
        waits = self._trigger(trigger, pre, post) if trigger is not None else None
        unique = {p.name: p for p in places}
        trace = Trace(list(unique.values()), self._engine.interval, waits)
        trace.left_out = left_out
        self._engine.recorder.add(trace, self.scans)
        return trace

    def _trigger(self, text: str, pre: Time, post: Time | None) -> Trigger:
        from plcruntime.trigger import compile_trigger

        others = [t.trigger for t in self._engine.recorder.waiting]
        after = FOREVER if post is None else self._count(post)
        return compile_trigger(self.program, text, self._count(pre), after, others)

    def record(self, *names: str) -> Recording:
        """Record what a report of the run shows, from now on: ``recording.to_html("report.html")`` writes it.

        names: the variables that it shows first; without, those that change. Raises PathError, ValueError."""
        from plcruntime.html_report.recording import Recording

        return Recording(self, list(names))

    def log_returns(self) -> ReturnLog:
        """Note from now on every command that doesn't return 0, with time, place and reason: ``.entries``."""
        from plcruntime.returns import ReturnLog

        if self.returns is None:
            self.returns = ReturnLog(self)
            self.returns.begin()
        return self.returns

    def stop_trace(self, trace) -> None:
        """Stop recording; the rows stay."""
        self._engine.recorder.remove(trace, self.scans)

    # -------------------------------------------------------------------------------- going back, restarting

    def snapshot(self) -> Snapshot:
        """The whole state at this scan boundary, for `restore`."""
        return self._engine.snapshot()

    def restore(self, snapshot: Snapshot) -> None:
        """Return to a snapshot: variables, clock, forces, fault. Raises ValueError for another program's."""
        self._engine.restore(snapshot)
        if self.returns:
            self.returns.begin()

    def back(self, scans: int = 1) -> None:
        """Go back by scans; the scan in which the program failed counts as one. Raises ValueError beyond the memory."""
        self._engine.back(scans)

    def power_cycle(self) -> None:
        """Off and on: RETAIN and PERSISTENT variables keep their values, all else starts anew, the clock too."""
        self.reset("warm")

    def reset(self, kind: str = "warm") -> None:
        """'warm' keeps RETAIN and PERSISTENT, 'cold' only PERSISTENT, 'origin' nothing. Forces are released.

        The retain file, where there is one, then holds what was kept. Raises UsageError when it can't be written."""
        if kind not in ("warm", "cold", "origin"):
            raise ValueError(f"'{kind}' is no reset; there are warm, cold and origin")
        self._engine.restart(kind)
        self.scheduled.clear()
        self._configure()
        self.save_retain()

    def save_retain(self) -> None:
        """Write the retain file now; without one nothing happens. Raises UsageError when it can't be written.

        It is written besides at the end of `run` and `run_until`, by power_cycle and reset, while scans are run every
        second of wall clock (retain_every in plc.toml), when the PLC is closed, and when Python ends."""
        if self.retain:
            self.retain.save()

    def close(self) -> None:
        """Save the retain file, as at the end of ``with PLC.load(...) as plc:``. The PLC can be used further."""
        self.save_retain()

    def __enter__(self) -> PLC:
        return self

    def __exit__(self, *_exception) -> None:
        self.close()

    def _open_retain(self, path: str | Path) -> None:
        from plcruntime.retain import EVERY, RetainFile

        every = self.project.retain_every
        self.retain = RetainFile(path, self.program, lambda: self._machine.memory, EVERY if every is None else every)
        self.retain.load()
        self._engine.after_call.append(self.retain.poll)
        at_exit = weakref.ref(self)
        atexit.register(lambda: (plc := at_exit()) and plc.close())

    def _configure(self) -> None:
        """What the configuration says of the axes, and which axis of the program is which of the simulator."""
        if self.returns:
            self.returns.begin()
        if self._bind:
            try:
                self._bind(self)
            except ValueError as error:  # more axes than the simulator has
                raise UsageError(str(error)) from None
        if "ECAT.SLAVE" in self.program.variables:
            from mclib import ecat

            ecat.configure(self, self.project.ecat)
        if not len(self.axes):
            return
        for axis in self.project.axes:
            for member, value in axis.members.items():
                try:
                    self[f"{ROOT}[{axis.number}].{member}"] = value
                except PathError as error:
                    needs = f"{self.project.path}: axis {axis.number}: {axis.keys[member]}"
                    if member.startswith("ref^"):
                        raise UsageError(f"{needs} needs an AXIS_REF_SM3 in the program for it") from error
                    raise UsageError(f"{needs}: {error}") from error
                except (TypeError, ValueError) as error:
                    raise UsageError(f"{self.project.path}: {error}") from error


def build(
    source: str | Path | Sequence[str | Path], config: str | Path | None = None, *, strict: bool = False,
    probes: bool = False, beside: Path | None = None,
) -> tuple[Program, Project]:  # fmt: skip
    """Compile what the user names, with the project's settings. probes: able to stop at every statement. beside: the
    folder where POUs are looked for that a text does not define.

    Raises as `PLC.load` does."""
    import mclib
    from stcore.compiler import compile

    files, project = sources.gather(source, config, beside)
    libraries = [*project.libraries, *mclib.libraries(project.dialect)]
    program = compile(files, tasks=project.tasks, libraries=libraries, strict=strict or project.strict, probes=probes)
    return program, project


def _test_host(plc: PLC, program: Program) -> dict[str, Callable]:
    """What the assertions of ST tests need of the host, for a program that uses them."""
    if not any(e.name.upper().startswith("HOSTTEST") for e in program.externals):
        return {}
    from plcruntime.st_tests import functions

    return functions(plc, program.externals)


def _motion_host(program: Program):
    """mclib.host when the program uses something that the host provides, or the simulated axes."""
    if not program.externals and "SIM.AXIS" not in program.variables:
        return None
    import mclib.host

    return mclib.host

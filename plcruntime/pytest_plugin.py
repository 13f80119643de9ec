"""The pytest plugin: the fixture ``plc``, tests in ST files, golden traces, coverage. Loaded by pytest itself.

    def test_counts(plc):
        p = plc("prog.st")                  # relative to the test's folder; compiled once a session
        p.run("2s")
        assert p["PLC_PRG.count"] == 20

Nothing of the compiler is imported before a test asks for it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from plcruntime.plc import PLC
    from plcruntime.trace import Trace

LAST = 8  # scans that a report shows
COLUMNS = 6
OURS = ("plcruntime", "mclib", "stcore")


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("scancycle", "tests of PLC programs")
    group.addoption("--plc-trace-on-fail", metavar="FOLDER", help="write the traces of failing tests there, as .csv")
    group.addoption("--plc-record", action="store_true", help="write golden traces instead of comparing with them")
    group.addoption("--plc-cov", action="store_true", help="show which statements and branches of the ST files ran")
    group.addoption("--plc-lcov", metavar="FILE", help="write that as LCOV")
    group.addoption("--plc-cobertura", metavar="FILE", help="write that as Cobertura XML")


# -------------------------------------------------------------------------------------------------- coverage

_COVERAGE = pytest.StashKey["Coverage | None"]()


def pytest_configure(config: pytest.Config) -> None:
    files = {option: config.getoption(option) for option in ("--plc-lcov", "--plc-cobertura")}
    config.stash[_COVERAGE] = None
    if not config.getoption("--plc-cov") and not any(files.values()):
        return
    from plcruntime.coverage import Coverage, check_output
    from plcruntime.errors import UsageError

    for option, file in files.items():
        if file:
            try:
                check_output(option, file)
            except UsageError as error:
                raise pytest.UsageError(str(error)) from None
    config.stash[_COVERAGE] = Coverage()


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node, error) -> None:
    """A process of pytest-xdist has ended."""
    coverage = node.config.stash[_COVERAGE]
    if coverage is not None:
        coverage.merge(getattr(node, "workeroutput", {}).get("plc_coverage", {}))


def pytest_sessionfinish(session: pytest.Session) -> None:
    config = session.config
    coverage = config.stash[_COVERAGE]
    if coverage is not None and hasattr(config, "workeroutput"):
        config.workeroutput["plc_coverage"] = coverage.data()


def pytest_terminal_summary(terminalreporter, config: pytest.Config) -> None:
    coverage = config.stash[_COVERAGE]
    if coverage is None:
        return
    from plcruntime.cli import output
    from plcruntime.coverage import HEADS

    terminalreporter.section("coverage of ST")
    terminalreporter.flush()
    output.print_table(HEADS, coverage.table())
    try:
        coverage.write(config.getoption("--plc-lcov"), config.getoption("--plc-cobertura"))
    except OSError as error:
        terminalreporter.write_line(f"the coverage can't be written: {error.strerror}", red=True)


# ----------------------------------------------------------------------------------------------- tests in ST


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.File | None:
    if file_path.suffix.lower() == ".st" and file_path.name.startswith("test_"):
        return StFile.from_parent(parent, path=file_path)
    return None


class StFile(pytest.File):
    """An ST file with tests."""

    def collect(self) -> Iterator[pytest.Item]:
        from plcruntime.st_tests import TestFile
        from stcore.diagnostics import CompileError

        try:
            tests = TestFile(self.path, probes=self.config.stash[_COVERAGE] is not None)
        except CompileError as error:
            raise self.CollectError(str(error)) from None
        for test in tests.tests:
            yield StItem.from_parent(self, name=test.name, tests=tests, test=test)


class StFailed(Exception):
    """An ST test that did not pass. result: plcruntime.st_tests.Result."""

    def __init__(self, result) -> None:
        self.result = result
        super().__init__(result.message)


class StItem(pytest.Item):
    """One test of an ST file."""

    def __init__(self, *, tests, test, **others) -> None:
        super().__init__(**others)
        self.tests, self.test = tests, test

    def runtest(self) -> None:
        result = self.tests.run(self.test)
        coverage = self.config.stash[_COVERAGE]
        if coverage is not None:
            coverage.add(self.tests.program, self.tests.plc._machine.memory)
        if not result.passed:
            raise StFailed(result)

    def repr_failure(self, excinfo: pytest.ExceptionInfo, style=None):
        from plcruntime.st_tests import report

        if isinstance(excinfo.value, StFailed):
            return report(excinfo.value.result)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int, str]:
        return self.path, self.test.line - 1, self.name


# -------------------------------------------------------------------------------------------------- the fixture


class _Programs:
    """Programs compiled in this session: what was named -> (stamps of its files, program, project)."""

    def __init__(self, probes: bool) -> None:
        self._kept: dict = {}
        self._probes = probes

    def load(self, **origin):
        """origin: as for plcruntime.plc.build."""
        from plcruntime.plc import build

        key = str(origin)
        kept = self._kept.get(key)
        if kept is None or kept[0] != _stamps(kept[1].files):
            program, project = build(**origin, probes=self._probes)
            kept = self._kept[key] = (_stamps(program.files), program, project)
        return kept[1:]


def _stamps(files: list[str]) -> list[tuple]:
    return [(f, Path(f).stat().st_mtime_ns) for f in files if Path(f).is_file()]


class Loader:
    """The fixture ``plc``: call it with a file, a folder, a plc.toml or the text of a program."""

    def __init__(self, programs: _Programs, folder: Path, record: bool) -> None:
        self._programs, self._folder, self._record = programs, folder, record
        self.loaded: list[tuple[str, PLC]] = []

    def __call__(self, source, interval=None, config=None, *, strict: bool = False, watchdog=None) -> PLC:
        """A fresh PLC before its first scan; arguments as for PLC.load, files relative to the test's folder; so are the
        POUs that a text does not define."""
        from stcore.diagnostics import CompileError

        source = [self._found(x) for x in source] if isinstance(source, list | tuple) else self._found(source)
        config = self._found(config) if config is not None else None
        __tracebackhide__ = True
        try:
            origin = {"source": source, "config": config, "strict": strict, "beside": self._folder}
            program, project = self._programs.load(**origin)
        except CompileError as error:  # the place in the ST text tells more than ours in the compiler
            raise error.with_traceback(None) from None
        plc = _watched_plc()(program, interval=interval, project=project, watchdog=watchdog)
        plc.origin, plc.found = origin, self._found
        first = source[0] if isinstance(source, list) else source
        self.loaded.append((Path(first).name if isinstance(first, Path) else "<text>", plc))
        return plc

    def _found(self, item):
        from plcruntime.sources import is_text

        if is_text(item):
            return item
        path = Path(item)
        beside = self._folder / path
        return beside if not path.is_absolute() and beside.exists() else path

    def golden(self, trace: Trace, path: str | Path, tolerance: float = 0.0, tolerances: dict | None = None) -> None:
        """Compare a trace with the one that was recorded in a file (.csv) beside the test; fails with the difference.

        tolerance: for all columns; tolerances: for single ones, by path. With --plc-record the file is written.
        """
        from plcruntime import golden

        file = self._folder / path
        if self._record:
            file.parent.mkdir(parents=True, exist_ok=True)
            trace.to_csv(file)
            return
        __tracebackhide__ = True
        golden.compare(trace, file, tolerance, tolerances)


def _watched_plc():
    """A PLC that remembers what the test read."""
    global _WATCHED
    if _WATCHED is None:
        from plcruntime.plc import PLC

        class WatchedPLC(PLC):
            def __init__(self, *arguments, **options) -> None:
                self.read_paths: dict[str, None] = {}
                self.found = Path  # where a file lies that the test names
                super().__init__(*arguments, **options)

            def __getitem__(self, path: str):
                self.read_paths[path] = None
                return super().__getitem__(path)

            def stimuli(self, path: str | Path) -> int:
                return super().stimuli(self.found(path))

            def run_until(self, condition, timeout="10s", *, realtime: bool = False) -> float:
                if isinstance(condition, str):
                    names = re.findall(r"[^\W\d][\w.]*(?:\[[^\]]*\][\w.]*)*", condition)
                    self.read_paths |= dict.fromkeys(names)
                return super().run_until(condition, timeout, realtime=realtime)

        _WATCHED = WatchedPLC
    return _WATCHED


_WATCHED: type | None = None


@pytest.fixture(scope="session")
def _plc_programs(request: pytest.FixtureRequest) -> _Programs:
    return _Programs(probes=request.config.stash[_COVERAGE] is not None)


@pytest.fixture
def plc(request: pytest.FixtureRequest, _plc_programs: _Programs) -> Iterator[Loader]:
    """``plc("prog.st")`` loads a fresh PLC; ``plc.golden(trace, "file.csv")`` compares with a recorded trace."""
    loader = Loader(_plc_programs, request.path.parent, request.config.getoption("plc_record"))
    request.node._plc_loader = loader
    yield loader
    coverage = request.config.stash[_COVERAGE]
    if coverage is not None:
        for _, loaded in loader.loaded:
            coverage.add(loaded.program, loaded._machine.memory)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo):
    if call.excinfo is not None and hasattr(item, "_plc_loader") and not item.config.option.fulltrace:
        _cut(call.excinfo.value)
    outcome = yield
    report = outcome.get_result()
    loader = getattr(item, "_plc_loader", None)
    if report.when != "call" or not report.failed or loader is None:
        return
    folder = item.config.getoption("plc_trace_on_fail")
    for number, (name, plc) in enumerate(loader.loaded):
        text, trace = _last_scans(plc)
        report.sections.append((f"plc {name}", text))
        if folder and trace is not None and len(trace):
            file = Path(folder) / f"{re.sub(r'[^A-Za-z0-9_.-]+', '_', item.nodeid)}{f'_{number}' if number else ''}.csv"
            file.parent.mkdir(parents=True, exist_ok=True)
            trace.to_csv(file)
            report.sections.append((f"plc {name} trace", f"wrote {file}"))


def _cut(error: BaseException) -> None:
    """A test that uses the PLC wrongly, or waits in vain, is shown down to its own line: not the way of the error
    through scancycle. Whoever looks for a mistake there has --full-trace."""
    from plcruntime.errors import ConditionTimeout, UsageError
    from stcore.diagnostics import CompileError
    from stcore.faults import Fault
    from stcore.paths import PathError
    from stcore.side import SideError

    told = (UsageError, ConditionTimeout, CompileError, Fault, PathError, SideError, ValueError, TypeError)
    steps = []
    at = error.__traceback__
    while at is not None:
        steps.append(at)
        at = at.tb_next
    ours = [step.tb_frame.f_globals.get("__name__", "").split(".")[0] in OURS for step in steps]
    if isinstance(error, told) and ours[-1] and not ours[0]:
        steps[ours.index(True) - 1].tb_next = None


def _last_scans(plc: PLC) -> tuple[str, Trace | None]:
    """A table of the last scans of what the test read, and the whole trace of it."""
    from plcruntime.report import fault_text
    from plcruntime.st_tests import cells
    from plcruntime.trace import Trace
    from stcore import paths
    from stcore.paths import PathError

    places = {}
    for path in plc.read_paths:
        try:
            place = plc.place(path)
        except PathError:
            continue  # a misspelt name, or a keyword of a condition
        if paths.is_scalar(place) and not place.hops:
            places[place.name] = place
    head = f"{plc.scans} scans, {plc.time:.9g} s"
    if plc.fault is not None:
        head += "\n" + fault_text(plc.fault, plc.time)
    if not places:
        return head, None
    now = ["now", *(plc.show(n) for n in places)]
    trace = Trace(list(places.values()), round(plc.interval * 1e9))
    if plc.scans:
        plc._engine.record_again(trace, 0)
    kept = trace.tail(LAST)
    rows = [["time", *places], *(cells(trace, row) for row in kept), now]
    rows = [row[: COLUMNS + 1] for row in rows]
    widths = [max(len(r[i]) for r in rows) for i in range(len(rows[0]))]
    lines = ["  ".join(c.rjust(w) for c, w in zip(row, widths, strict=True)) for row in rows]
    return "\n".join([head, *lines]), trace


"""Tests written in ST: found by their attribute, each run on a fresh PLC, with what a report needs to say.

A FUNCTION with ``{attribute 'test'}`` is called once, and so is a METHOD of a FUNCTION_BLOCK, on an instance of its
own. A PROGRAM is scanned until it calls TEST_DONE() or its time-out is over (``{attribute 'timeout' := '30s'}``, 10 s
of virtual time else), with the stimuli of a file beside it when ``{attribute 'stimuli' := 'presses.csv'}`` names one.
Assertions are functions of the library (stcore/library/testing); one that fails ends the test.
"""

from __future__ import annotations

import re
import struct
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

from plcruntime import durations
from plcruntime.errors import UsageError
from stcore import syntax as s
from stcore import values
from stcore.cache import parse_cached
from stcore.diagnostics import Reporter
from stcore.faults import ASSERTIONS, Fault
from stcore.paths import PathError
from stcore.program import External, Program, Routine, TaskSpec
from stcore.show import show
from stcore.source import Source, read
from stcore.types import Array, Block, Elementary, String, Struct, Type, base_of, is_aggregate

if TYPE_CHECKING:
    from plcruntime.trace import Trace

TIMEOUT = "10s"
PATTERN = "test_*.st"
KINDS = {1: "ASSERT", 3: "ASSERT_NEAR"}
LAST = 8  # scans that a report shows
COLUMNS = 6  # variables that a report shows
SHOWN = 3  # parts of an array or a structure that differ


class AssertionFailed(Exception):
    """What a failing assertion told the host. differing: (path, expected, actual) of the parts of an array or a
    structure; expected and actual are then those of the first."""

    def __init__(
        self, kind: str, expected: str, actual: str, text: str, differing: Sequence[tuple[str, str, str]] = ()
    ) -> None:
        self.kind, self.expected, self.actual, self.text, self.differing = kind, expected, actual, text, differing
        found = [f"{path}: expected {e}, actual {a}" for path, e, a in differing[:SHOWN]]
        if not found and kind != "ASSERT":
            found = [f"expected {expected}, actual {actual}"]
        if len(differing) > SHOWN:
            found.append(f"{len(differing) - SHOWN} more differ")
        super().__init__(": ".join(x for x in (f"{kind} failed", text, "; ".join(found)) if x))


def functions(plc, externals: Sequence[External]) -> dict[str, Callable]:
    """The external functions of the assertions that a program uses, by upper-case name, for one PLC."""

    def text_at(address: int) -> str:
        return values.decode(plc._engine.machine.memory, String(255), address)

    def fail(kind: int, *addresses: int) -> int:
        plc.assertion = AssertionFailed(KINDS.get(kind, "ASSERT"), *map(text_at, addresses))
        raise plc.assertion

    def equal(kind: Type, expected: int | float, actual: int | float, text: int) -> int:
        if isinstance(kind, Array | Struct):
            memory = plc._engine.machine.memory
            parts = list(differing(memory, kind, expected, actual))
            if not parts:
                return 1
            plc.assertion = AssertionFailed("ASSERT_EQ", *parts[0][1:], text_at(text), parts)
        else:
            pair = [_value(plc._engine.machine.memory, kind, given) for given in (expected, actual)]
            if pair[0] == pair[1]:
                return 1
            plc.assertion = AssertionFailed("ASSERT_EQ", *_texts(kind, *pair), text_at(text))
        raise plc.assertion

    typed = [e for e in externals if e.name.upper().startswith("HOSTTESTEQUAL")]
    return {"HOSTTESTFAIL": fail} | {e.name.upper(): partial(equal, e.parameters[0][1]) for e in typed}


def differing(memory, kind: Type, expected: int, actual: int, path: str = "") -> Iterator[tuple[str, str, str]]:
    """(path, expected, actual) of every part that differs of two values of a type, at two addresses."""
    if memory[expected : expected + kind.size] == memory[actual : actual + kind.size]:
        return
    if isinstance(kind, Array):
        places = product(*(range(low, high + 1) for low, high in kind.bounds))
        for k, place in enumerate(places):
            at = k * kind.element.size
            index = f"{path}[{', '.join(map(str, place))}]"
            yield from differing(memory, kind.element, expected + at, actual + at, index)
    elif isinstance(kind, Struct | Block):
        for f in kind.members.values():
            if f.section not in ("VAR_STAT", "VAR_TEMP", "VAR_IN_OUT"):  # they do not lie in the instance
                name = f"{path}.{f.name}" if path else f.name
                yield from differing(memory, f.type, expected + f.offset, actual + f.offset, name)
    else:
        pair = [values.decode(memory, kind, address) for address in (expected, actual)]
        if pair[0] != pair[1]:
            yield path, *_texts(kind, *pair)


def _texts(kind: Type, expected: object, actual: object) -> tuple[str, str]:
    """Two values that differ, so that one sees it."""
    shown = show(kind, expected), show(kind, actual)
    return shown if shown[0] != shown[1] else (repr(expected), repr(actual))


def _value(memory, kind: Type, given: int | float) -> object:
    """A value as the module hands it to the host: a number, or the address of a text."""
    if isinstance(kind, String):
        return values.decode(memory, kind, given)
    base = base_of(kind)
    code = {"i32": "i", "i64": "q", "f32": "f", "f64": "d"}[base.wasm if isinstance(base, Elementary) else "i32"]
    return values.decode(struct.pack(f"<{code}", given), kind, 0)


@dataclass(slots=True)
class Test:
    """One test of a file. place: file and line where it begins."""

    name: str
    kind: str
    export: str
    file: str
    line: int
    attributes: dict

    @property
    def id(self) -> str:
        return f"{self.file}::{self.name}"


@dataclass(slots=True)
class Result:
    """message: '' when the test passed. file, line: of the assertion, or what went wrong. seconds: wall clock.

    rows: the last scans of the variables that the failing statement reads, as text under `heads`.
    """

    test: Test
    message: str = ""
    file: str = ""
    line: int = 0
    assertion: AssertionFailed | None = None
    scans: int = 0
    time: float = 0.0
    seconds: float = 0.0
    heads: list[str] = field(default_factory=list)
    rows: list[list[str]] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        return not self.message


def find(named: list[str]) -> list[Path]:
    """The files to look for tests in: those named, and all ``test_*.st`` below the folders named. Raises UsageError."""
    found: dict[Path, None] = {}
    for item in named or ["."]:
        path = Path(item)
        if path.is_dir():
            found |= dict.fromkeys(sorted(path.rglob(PATTERN)))
        elif path.is_file():
            found[path] = None
        else:
            raise UsageError(f"there is no file or folder {item}")
    return list(found)


class TestFile:
    """The tests of one ST file, compiled together. Raises CompileError, OSError."""

    __test__ = False  # for pytest: this is no test itself

    def __init__(self, path: Path, *, probes: bool = False) -> None:
        import mclib
        from plcruntime.plc import PLC
        from stcore.compiler import compile

        self.path = path
        source = read(path)
        programs = _test_programs(source)
        tasks = [TaskSpec(name, [name], test=True) for name in programs] or [TaskSpec("none", [], test=True)]
        self.program: Program = compile([source], tasks=tasks, libraries=[mclib.LIBRARY], probes=probes)
        self.plc = PLC(self.program)
        self._task = {name.upper(): i for i, name in enumerate(programs, 1)}
        self.tests = sorted(self._tests(), key=lambda t: t.line)
        self._until: bytes | None = None
        if "TESTING.DONE" in self.program.variables and programs:
            from stcore.side import condition

            self._until = condition(self.plc.typed.names(self.program), "TESTING.Done").wasm

    def _tests(self) -> Iterator[Test]:
        for routine in self.program.routines.values():
            if "test" in routine.attributes and not routine.library:
                export = routine.test if routine.kind == "METHOD" else routine.export
                if export or routine.kind != "METHOD":  # the method of an ABSTRACT block runs in those that extend it
                    yield Test(routine.name, routine.kind, export, str(self.path), routine.line, routine.attributes)

    def run(self, test: Test) -> Result:
        """Run one test on a fresh PLC. Never raises for what the test does."""
        began = time.perf_counter()
        result = Result(test)
        self._try(test, result)
        result.scans, result.time = self.plc.scans, self.plc.time
        if not result.passed and test.kind == "PROGRAM":
            self._look_back(test, result)
        result.seconds = time.perf_counter() - began
        return result

    def _try(self, test: Test, result: Result, scans: int | None = None) -> None:
        plc = self.plc
        plc.assertion = None
        try:
            plc.reset("origin")
            plc._engine.choose_test(self._task.get(test.name.upper(), 0))
            if "stimuli" in test.attributes:
                self._schedule(test)
            if test.kind in ("FUNCTION", "METHOD"):
                routine: Routine = self.program.routines[test.name.upper()]
                if routine.parameters:
                    raise UsageError("a test takes no parameters")
                if test.kind == "METHOD" and routine.result is not None and is_aggregate(routine.result):
                    raise UsageError(f"a test does not return {routine.result}")
                with plc._engine.guard.run(), plc._engine.guard.call():
                    plc._machine.call(test.export)
            elif test.kind == "PROGRAM":
                self._scan(test, result, scans)
            else:
                raise UsageError(f"a {test.kind} can't be a test; PROGRAM, FUNCTION and METHOD can")
        except Fault as fault:
            self._failed(result, fault)
        except (UsageError, ValueError) as error:
            result.message, result.file, result.line = str(error), test.file, test.line

    def _schedule(self, test: Test) -> None:
        from plcruntime import stimulus_file

        if test.kind != "PROGRAM":
            raise UsageError(f"stimuli come at times, and a {test.kind} is called once: make the test a PROGRAM")
        stimulus_file.schedule(self.plc, self.path.parent / test.attributes["stimuli"], test.name)

    def _scan(self, test: Test, result: Result, scans: int | None) -> None:
        plc = self.plc
        limit = test.attributes.get("timeout") or TIMEOUT
        count = durations.scans(limit, plc._engine.interval) if scans is None else scans
        reached = plc._engine.advance(count, until=self._until)
        if not reached and scans is None:
            missing = "" if self._until else "; it never calls TEST_DONE()"
            result.message = f"time-out after {limit} of virtual time{missing}"
            result.file, result.line = test.file, test.line

    def _failed(self, result: Result, fault: Fault) -> None:
        result.assertion = self.plc.assertion
        result.message = str(result.assertion) if result.assertion else f"fault {fault.code}: {fault.message}"
        own = next((x for x in fault.stack if Path(x.file).parent != ASSERTIONS), None)
        result.file, result.line = (own.file, own.line) if own else (result.test.file, result.test.line)

    def _look_back(self, test: Test, result: Result) -> None:
        """Run it again with a recorder: the last scans of the variables that the failing statement names."""
        names = self._named_at(test, result)
        if not names:
            return
        plc, scans = self.plc, result.scans
        failing = [plc.show(n) for n in names] if result.line and result.assertion else None
        trace = plc.trace(*names)
        self._try(test, Result(test), scans)
        plc.stop_trace(trace)
        kept = list(trace.rows())[-LAST:]
        result.heads = ["time", *trace.names]
        result.rows = [cells(trace, row) for row in kept]
        if failing is not None:
            result.rows.append(["failed", *failing])

    def _named_at(self, test: Test, result: Result) -> list[str]:
        """Scalars of the test that the failing statement names, else all its scalars."""
        from stcore.paths import is_scalar, user_places

        words = set()
        if Path(result.file).is_file() and result.line != test.line:
            text = read(result.file).text.splitlines()[result.line - 1]
            words = {w.upper() for w in re.findall(r"[^\W\d]\w*", text)}
        own = [p for p in user_places(self.program) if p.name.upper().startswith(test.name.upper() + ".")]
        scalars = [p.name for p in own if is_scalar(p)]
        named = [n for n in scalars if n.rpartition(".")[2].upper() in words]
        for path in re.findall(r"[^\W\d]\w*(?:\.[^\W\d]\w*)+", text if words else ""):
            try:
                place = self.plc.place(f"{test.name}.{path}")
            except PathError:
                continue  # a name of something else
            if is_scalar(place):
                named.append(place.name)
        return list(dict.fromkeys(named or scalars))[:COLUMNS]


def _test_programs(source: Source) -> list[str]:
    """Names of the PROGRAMs of a text that are tests: tasks have to be known before it is compiled."""
    tree = parse_cached(source, Reporter())
    return [u.name for u in tree.units if isinstance(u, s.Pou) and u.kind == "PROGRAM" and "test" in u.attributes]


def cells(trace: Trace, row: tuple) -> list[str]:
    """A row of a trace for reading: time, then values; names of enumerations, reals with nine digits."""
    return [f"{row[0]:.6g} s", *(_cell(p.type, value) for p, value in zip(trace.places, row[1:], strict=True))]


def _cell(kind: Type, value) -> str:
    return f"{value:.9g}" if isinstance(value, float) else show(kind, value)


def report(result: Result) -> str:
    """A failed test for reading: place, statement, expected and actual, the last scans."""
    lines = [f"{result.file}:{result.line}: {result.test.name}: {result.message}"]
    if Path(result.file).is_file() and result.line:
        source = read(result.file).text.splitlines()
        for number in range(max(1, result.line - 2), min(len(source), result.line + 1) + 1):
            lines.append(f"{'>' if number == result.line else ' '}{number:5} | {source[number - 1]}")
    if result.assertion is not None and result.assertion.differing:
        parts = result.assertion.differing
        width = max(len(path) for path, *_ in parts[:SHOWN])
        lines += [f"  {path.ljust(width)}  expected {e}, actual {a}" for path, e, a in parts[:SHOWN]]
        lines += [f"  {len(parts) - SHOWN} more differ"] if len(parts) > SHOWN else []
    elif result.assertion is not None and result.assertion.kind != "ASSERT":
        lines += [f"  expected  {result.assertion.expected}", f"  actual    {result.assertion.actual}"]
    if result.test.kind == "PROGRAM":
        lines.append(f"  in scan {result.scans}, at {result.time:.9g} s")
    if result.rows:
        table = [result.heads, *result.rows]
        widths = [max(len(r[i]) for r in table) for i in range(len(result.heads))]
        lines.append("  the last scans:")
        lines += ["    " + "  ".join(c.rjust(w) for c, w in zip(row, widths, strict=True)) for row in table]
    return "\n".join(lines)

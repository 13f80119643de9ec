"""``scancycle test``: the ST tests of files and folders, without pytest's start-up."""

from __future__ import annotations

import argparse
import re
import sys
import time
from pathlib import Path

from plcruntime import st_tests
from plcruntime.cli import DONE, FAILED, USAGE
from plcruntime.errors import UsageError
from plcruntime.st_tests import Result, Test, TestFile
from stcore.diagnostics import CompileError
from stcore.source import read

STIMULI = ("*.csv", "*.toml")
LOOK = 0.3  # s between two looks at the files, with --watch


def execute(arguments: argparse.Namespace) -> int:
    chosen = Selection(arguments.k)
    for option in ("junit", "lcov", "cobertura"):
        if getattr(arguments, option):
            from plcruntime.coverage import check_output

            check_output(f"--{option}", getattr(arguments, option))
    if not arguments.watch:
        return _once(arguments, chosen)
    stamps: dict[Path, int] = {}
    while True:
        try:
            now = _stamps(arguments.paths)
        except (UsageError, OSError):
            if not stamps:
                raise
            now = stamps  # an editor is about to write the file again
        if now != stamps:
            stamps = now
            _once(arguments, chosen)
            print("watching; Ctrl-C ends", flush=True)
        time.sleep(LOOK)


def _stamps(paths: list[str]) -> dict[Path, int]:
    """Every ST and stimulus file of the folders concerned, with its time: a test may fail because of another file."""
    folders = {p.parent for p in st_tests.find(paths)} | {Path(p) for p in paths or ["."] if Path(p).is_dir()}
    files = {f for folder in folders for pattern in ("*.st", *STIMULI) for f in folder.rglob(pattern)}
    return {f: f.stat().st_mtime_ns for f in sorted(files) if f.exists()}


class Selection:
    """-k as pytest has it: parts of names with and, or, not and parentheses. Raises UsageError."""

    def __init__(self, expression: str | None) -> None:
        self._code = None
        if not expression:
            return
        words = re.findall(r"[()]|[^\s()]+", expression)
        parts = [w if w in ("and", "or", "not", "(", ")") else f"has({w!r})" for w in words]
        try:
            self._code = compile(" ".join(parts), "-k", "eval")
        except SyntaxError:
            raise UsageError(f"-k {expression}: write parts of names with and, or, not") from None

    def __contains__(self, test: Test) -> bool:
        name = test.id.lower()
        return self._code is None or eval(self._code, {"__builtins__": {}, "has": lambda w: w.lower() in name})


def _once(arguments: argparse.Namespace, chosen: Selection) -> int:
    began = time.perf_counter()
    results: list[Result] = []
    broken: list[tuple[Path, str]] = []
    coverage = None
    if arguments.coverage or arguments.lcov or arguments.cobertura:
        from plcruntime.coverage import Coverage

        coverage = Coverage()
    for path in st_tests.find(arguments.paths):
        if not _file(path, chosen, arguments, results, broken, coverage):
            break
    for result in results:
        if not result.passed:
            print(f"\n{st_tests.report(result)}")
    for path, text in broken:
        print(f"\n{path}: can't be compiled\n{text}")
    failed = sum(not r.passed for r in results)
    counts = [f"{failed} failed"] if failed else []
    counts += [f"{len(broken)} file{'s' if len(broken) > 1 else ''} with errors"] if broken else []
    counts += [f"{len(results) - failed} passed"]
    print(f"\n{', '.join(counts)} in {time.perf_counter() - began:.2f} s", flush=True)
    try:
        if coverage is not None:
            _show_coverage(coverage, arguments)
        if arguments.junit:
            from plcruntime import junit

            junit.write(Path(arguments.junit), results, broken)
    except OSError as error:  # no room, for one; whether there is a place for them was looked at before
        raise UsageError(f"the results can't be written: {error.strerror}") from None
    if not results and not broken:
        found = "a test is a PROGRAM, FUNCTION or METHOD with {attribute 'test'}, by default in test_*.st files"
        print(f"no test matches -k {arguments.k}" if arguments.k else f"no test found: {found}")
        return USAGE
    return FAILED if failed or broken else DONE


def _show_coverage(coverage, arguments: argparse.Namespace) -> None:
    from plcruntime.cli import output
    from plcruntime.coverage import HEADS

    output.print_table(HEADS, coverage.table())
    coverage.write(arguments.lcov, arguments.cobertura)


def _file(path: Path, chosen: Selection, arguments, results: list[Result], broken: list, coverage) -> bool:
    """The tests of one file; False when no other shall follow."""
    if "'test'" not in read(path).text.lower():
        return True
    try:
        file = TestFile(path, probes=coverage is not None)
    except CompileError as error:
        broken.append((path, str(error)))
        return not arguments.x
    except OSError as error:
        broken.append((path, error.strerror or str(error)))
        return not arguments.x
    tests = [t for t in file.tests if t in chosen]
    if tests:
        print(f"{path} ", end="")
    for test in tests:
        result = file.run(test)
        results.append(result)
        if coverage is not None:
            coverage.add(file.program, file.plc._machine.memory)
        print("." if result.passed else "F", end="", flush=sys.stdout.isatty())
        if arguments.x and not result.passed:
            print()
            return False
    if tests:
        print()
    return True

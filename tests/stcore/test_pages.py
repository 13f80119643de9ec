"""The page of every code: its wrong example gives that code, its right one does not."""

import re
import threading
from pathlib import Path

import pytest

import stcore
from stcore.codes import CODES
from stcore.machine import Machine
from stcore.source import Source

PAGES = sorted((Path(stcore.__file__).parent / "pages").glob("*.md"))
# codes that no example of a few lines can show
WITHOUT_EXAMPLE = {"E0118", "E0119", "E0123", "E0127", "E0702", "E0704", "E0705", "F0106", "F0107"}
# codes W08 show while motion runs: tests/mclib/mc/test_warnings.py
WITHOUT_EXAMPLE |= {"W0109", "W0112", "W0113", "W0114", "W0133"}  # their tests read the manuals' listings


def examples(page: Path) -> dict[str, str]:
    """'Wrong' and 'Right' -> the program."""
    parts = re.findall(r"^## (Wrong|Right)\n\n```iecst\n(.*?)\n```", page.read_text(encoding="utf-8"), re.M | re.S)
    return dict(parts)


def codes_of(text: str) -> set[str]:
    """Every code that building and running a program gives."""
    try:
        program = stcore.compile([Source(text + "\n", "page.st")])
    except stcore.CompileError as error:
        return {d.code for d in error.diagnostics}
    found = {d.code for d in program.diagnostics}
    machine = Machine(program)
    watchdog = threading.Timer(0.5, machine.interrupt)
    watchdog.start()
    try:
        machine.run(3)
    except stcore.Fault as fault:
        found.add(fault.code)
    finally:
        watchdog.cancel()
    return found


@pytest.mark.parametrize("page", [p for p in PAGES if p.stem[:3] != "W08"], ids=lambda p: p.stem)
def test_page(page):
    shown = examples(page)
    assert page.stem in CODES
    assert page.stem in codes_of(shown["Wrong"])
    assert page.stem not in codes_of(shown["Right"])


def test_every_code_has_a_page():
    missing = set(CODES) - {p.stem for p in PAGES} - WITHOUT_EXAMPLE
    assert not missing

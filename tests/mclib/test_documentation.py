"""What ``scancycle list 'GT_*'`` shows: each GT_ function, structure and constant says units, ranges and its source."""

import re
from pathlib import Path

import pytest

import mclib
from plcruntime import catalogue
from plcruntime.cli import main

FOLDERS = ("gt", "ecat", "motion")
ENTRIES = [e for e in catalogue.entries([mclib.LIBRARY]) if Path(e.file).parent.name in FOLDERS]
FUNCTIONS = [e for e in ENTRIES if e.kind == "function"]
OTHERS = [e for e in ENTRIES if e.kind != "function"]
SOURCE = re.compile(r"(iDEABOX 3, (chapter )?\d|GUC-ECAT advanced, \d|gts\.h)")


def named(entries):
    return [pytest.param(e, id=e.name) for e in entries]


def inputs(entry) -> list[tuple[str, str]]:
    inside = re.fullmatch(r"\w+(?:<.*>)?\((.*)\): INT", entry.signature)[1]
    return [tuple(p.split(": ", 1)) for p in inside.split("; ") if p]


@pytest.mark.parametrize("entry", named(FUNCTIONS))
def test_functions(entry):
    assert entry.summary and entry.units and entry.ranges and SOURCE.match(entry.source)
    assert entry.returns.startswith("0 ") or entry.returns == "0"
    said = f"{entry.units}; {entry.ranges}"
    for name, declared in inputs(entry):
        # of a pointer without a word of its own it is said that pointers are not NULL
        general = r"|\bpointers?\b" if "POINTER" in declared else ""
        assert re.search(rf"\b{name}\b|\b{name[1:]}\b{general}", said, re.IGNORECASE), f"{name} is not explained"


@pytest.mark.parametrize("entry", named(OTHERS))
def test_structures_and_constants(entry):
    assert entry.summary and SOURCE.match(entry.source) and entry.members
    for member in entry.members:
        assert " - " in member, f"{member} is not explained"


def test_constants_are_found_by_their_own_names(capsys):
    assert main(["list", "PT_MODE_STATIC"]) == 0
    shown = capsys.readouterr().out
    assert "PT_MODE_STATIC: INT := 0 - one FIFO runs, its data stay" in shown and "iDEABOX 3, 7.4.2" in shown


def test_members_of_structures_are_shown(capsys):
    assert main(["list", "TTrapPrm"]) == 0
    shown = capsys.readouterr().out
    assert "acc: LREAL - pulse/ms2, > 0" in shown and "smoothTime: INT" in shown


def test_values_of_enums_are_shown(capsys):
    assert main(["list", "MC_DIRECTION"]) == 0
    assert "negative := -1" in capsys.readouterr().out

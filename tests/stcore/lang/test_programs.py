"""The programs of the folder `programs`: after one scan, each variable has the value that is written beside it."""

from functools import cache
from pathlib import Path

import pytest
from running import Run, expectations, meant

FILES = sorted((Path(__file__).parent / "programs").glob("*.st"))


@cache
def after_one_scan(file: Path) -> Run:
    return Run(file.read_text(encoding="utf-8"), str(file)).scan()


@pytest.mark.parametrize(
    ("file", "path", "value"),
    [
        pytest.param(f, path, value, id=f"{f.stem}:{line}:{path}")
        for f in FILES
        for line, path, value in expectations(f)
    ],
)
def test_expectation(file, path, value):
    got = after_one_scan(file)[path]
    wanted = meant(value)
    assert got == wanted and type(got) is type(wanted) or got != got and wanted != wanted

"""What all tests share."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))  # for sample.py: the tests are no package


@pytest.fixture(scope="session")
def manuals() -> Path:
    """The folder of the vendor manuals' texts and listings, which is not part of the project."""
    folder = ROOT.parent / "shared" / "manuals"
    if not folder.is_dir():
        pytest.skip("the manuals (../shared/manuals) are not on this machine")
    return folder


def pytest_addoption(parser):
    parser.addoption("--all-typos", action="store_true", help="every change of tests/stcore/test_typos.py")

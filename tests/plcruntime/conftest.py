import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # for fake_machine: the tests are no package

from fake_machine import FakeMachine, program  # noqa: E402

from plcruntime.plc import PLC  # noqa: E402


@pytest.fixture
def plc() -> PLC:
    """The fake program, before its first scan."""
    return PLC(program(), machine=FakeMachine)

"""Motion: the axis simulator and the GT_, MC_ and SMC_ libraries, written in ST (mclib/library).

mclib.host holds the little that needs the host.
"""

from pathlib import Path

LIBRARY = Path(__file__).parent / "library"
# dialect -> folders whose files go before those of the library
DIALECTS = {"codesys": [], "plcopen": [Path(__file__).parent / "plcopen"]}


def libraries(dialect: str = "codesys") -> list[Path]:
    """The folders of the library in the order in which names are looked up."""
    return [*DIALECTS[dialect], LIBRARY]

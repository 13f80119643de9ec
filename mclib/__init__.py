"""Motion: the axis simulator and the GT_, MC_ and SMC_ libraries, written in ST (mclib/library).

mclib.host holds the little that needs the host.
"""

from pathlib import Path

LIBRARY = Path(__file__).parent / "library"

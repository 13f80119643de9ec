"""The pages of docs/blocks and docs/compliance.md are what docs/make writes from the library and the examples."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_pages_are_up_to_date():
    """Also: each input and output has its unit, range and meaning, each block its chart and its example."""
    done = subprocess.run([sys.executable, "docs/make", "--check"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_charts_are_small_pictures():
    for chart in (ROOT / "docs" / "blocks").glob("*.png"):
        start = chart.read_bytes()[:24]
        assert start.startswith(b"\x89PNG"), chart.name
        assert int.from_bytes(start[16:20], "big") > 800, f"{chart.name} is too narrow to read"
        assert chart.stat().st_size < 60_000, chart.name

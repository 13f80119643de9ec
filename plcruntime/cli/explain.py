"""``scancycle explain CODE``: the page of a code, or its line in the table."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from plcruntime.cli import DONE, output
from plcruntime.errors import UsageError


def execute(arguments: argparse.Namespace) -> int:
    import stcore
    from stcore.codes import CODES

    code = arguments.code.strip().upper()
    page = Path(stcore.__file__).parent / "pages" / f"{code}.md"
    if re.fullmatch(r"\w+", code) and page.is_file():
        _show(page.read_text(encoding="utf-8"))
    elif code in CODES:
        entry = CODES[code]
        print(f"{code}: {entry.message}")
        if entry.hint:
            print(f"hint: {entry.hint}")
    else:
        near = [c for c in CODES if c[:2] == code[:2]] or [c for c in CODES if c[:1] == code[:1]]
        raise UsageError(
            f"there is no code {arguments.code}" + (f"; there are {', '.join(near[:8])} and more" if near else "")
        )
    return DONE


def _show(markdown: str) -> None:
    if not sys.stdout.isatty():
        print(markdown)
        return
    from rich.markdown import Markdown

    output.console(sys.stdout).print(Markdown(markdown))

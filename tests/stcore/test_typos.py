"""One typo, one diagnostic: tokens of real programs are deleted, doubled and misspelt, one at a time.

Never a crash; in nine of ten cases at most two errors. A sample with a fixed seed runs by default; all changes of all
programs with ``--all-typos`` (some minutes).
"""

import random
import re
from pathlib import Path

import pytest
from sample import EXAMPLES, some_examples

import mclib
import stcore
from stcore.source import Source

TOKEN = re.compile(r"\(\*.*?\*\)|//[^\n]*|'[^'\n]*'|\w+(?:#[\w.:#-]+)?|:=|=>|<>|<=|>=|\.\.|\*\*|[^\s\w]", re.S)
PER_PROGRAM = 45


def changes(text: str) -> list[tuple[str, str]]:
    """(what was done, the changed text) for every token and kind of mistake."""
    made = []
    for match in TOKEN.finditer(text):
        token = match[0]
        if token.startswith(("(*", "//")):
            continue
        before, after = text[: match.start()], text[match.end() :]
        made.append((f"deleted {token!r}", before + after))
        made.append((f"doubled {token!r}", f"{before}{token} {token}{after}"))
        if re.fullmatch(r"[A-Za-z_]\w{2,}", token):
            swapped = token[0] + token[2] + token[1] + token[3:]
            if swapped != token:
                made.append((f"misspelt {token!r}", before + swapped + after))
    return made


def errors_of(path: Path, text: str) -> int:
    diagnostics = stcore.diagnose([Source(text, str(path))], libraries=[mclib.LIBRARY])
    return sum(d.severity == "error" for d in diagnostics)


def pytest_generate_tests(metafunc):
    paths = EXAMPLES if metafunc.config.getoption("--all-typos") else some_examples()
    metafunc.parametrize("path", paths, ids=lambda p: p.stem)


def test_typos(path, request):
    text = path.read_text(encoding="utf-8")
    if errors_of(path, text):
        pytest.skip("shows mistakes on purpose")
    cases = changes(text)
    if not request.config.getoption("--all-typos"):
        cases = random.Random(path.stem).sample(cases, min(PER_PROGRAM, len(cases)))
    counts = {what + f" ({i})": errors_of(path, changed) for i, (what, changed) in enumerate(cases)}
    many = {what: n for what, n in counts.items() if n > 2}
    assert len(many) * 10 <= len(counts), many

"""Every file of the standard library: named after what it defines, documented in the fixed form, and it compiles."""

import re
from pathlib import Path

import pytest

import stcore
from stcore.compiler import compile
from stcore.source import Source

FOLDER = Path(stcore.__file__).parent / "library"
FILES = sorted(FOLDER.rglob("*.st"))
COMMENT = re.compile(r"\(\* (\w+): (.*?) ?\*\)\n", re.S)
POU = re.compile(r"^(?:FUNCTION_BLOCK|FUNCTION|PROGRAM|TYPE) (\w+)", re.M)
FIELDS = ("units", "ranges", "returns", "source")


def test_no_name_twice():
    names = [f.stem.upper() for f in FILES]
    assert sorted(set(names)) == sorted(names)


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.stem)
def test_form(file):
    text = file.read_text(encoding="utf-8")
    comment = COMMENT.match(text)
    assert comment, "the file begins with its documentation"
    named = POU.search(text)
    assert comment[1] == file.stem == (named[1] if named else file.stem)  # a list of globals has its file's name
    fields = re.findall(r"^   (\w+): ", comment[2], re.M)
    assert all(f in FIELDS for f in fields)
    hidden = "{attribute 'hidden'}" in text
    assert hidden == file.stem.startswith(("__", "Host"))
    assert hidden or not named or "source" in fields
    assert max(map(len, text.splitlines())) <= 120


def test_all_blocks_check():
    """All blocks in one program, without a message."""
    blocks = [f.stem for f in FILES if re.search(r"^FUNCTION_BLOCK", f.read_text(encoding="utf-8"), re.M)]
    declared = "".join(f"  b{i} : {name};\n" for i, name in enumerate(blocks))
    text = f"PROGRAM PLC_PRG\nVAR\n{declared}END_VAR\nEND_PROGRAM\n"
    assert compile([Source(text, "all.st")]).diagnostics == []


def test_all_functions_check():
    """A call of every function with variables of its inputs' types, generic ones with STRING and with WSTRING."""
    declared, calls = [], []
    for file in FILES:
        text = COMMENT.sub("", file.read_text(encoding="utf-8"))
        head = re.search(r"^FUNCTION (\w+)( <T: ANY_STRING>)?(?: : (\w+))?", text, re.M)
        if not head or file.stem.startswith("__") or file.parent.name == "testing":
            continue
        name, generic, result = head.groups()
        inputs = "".join(re.findall(r"VAR_IN(?:PUT|_OUT)(.*?)END_VAR", text, re.S))
        pairs = re.findall(r"^  (\w+(?:, \w+)*) : ([\w()]+);", inputs, re.M)
        kinds = [kind for names, kind in pairs for _ in names.split(",")]
        for t in ("STRING", "WSTRING") if generic and not name.startswith(("STRING", "WSTRING")) else (None,):
            t = t or ("WSTRING" if name.startswith("W") else "STRING")
            actual = [t if k == "T" else k for k in kinds]
            args = [f"v{len(declared) + i}" for i in range(len(actual))]
            declared += [f"  {a} : {k};" for a, k in zip(args, actual, strict=True)]
            call = f"{name}({', '.join(args)})"
            if result:
                declared.append(f"  v{len(declared)} : {t if result == 'T' else result};")
                call = f"v{len(declared) - 1} := {call}"
            calls.append(call + ";")
    lines = ["PROGRAM PLC_PRG", "VAR", *declared, "END_VAR", *calls, "END_PROGRAM"]
    assert len(calls) > 150
    assert [str(d) for d in compile([Source("\n".join(lines), "all.st")]).diagnostics] == []

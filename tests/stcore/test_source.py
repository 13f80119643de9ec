"""Files as they come: encodings, bytes that are no text, names and signs that a terminal can't show."""

from pathlib import Path

import pytest

import stcore
from stcore.diagnostics import CompileError, Diagnostic, text
from stcore.source import Source, read

PROGRAM = "PROGRAM p\nVAR s : STRING := '计数'; END_VAR\nEND_PROGRAM\n"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "gb18030", "utf-16"])
def test_encodings(tmp_path, encoding):
    file = tmp_path / "p.st"
    file.write_bytes(PROGRAM.replace("\n", "\r\n").encode(encoding))
    assert read(file).text == PROGRAM


@pytest.mark.parametrize("data", [bytes(range(256)) * 4, b"\0\0", b"PROGRAM p\n" + bytes(40)])
def test_what_is_no_text_is_one_error(tmp_path, data):
    file = tmp_path / "p.st"
    file.write_bytes(data)
    with pytest.raises(CompileError) as caught:
        stcore.compile([file])
    assert [(d.code, d.file) for d in caught.value.diagnostics] == [("E0704", str(file))]


def test_a_sibling_that_is_no_text_is_passed_over(tmp_path):
    (tmp_path / "data.st").write_bytes(bytes(1000))
    (tmp_path / "p.st").write_text("PROGRAM p\nVAR x : INT; END_VAR\nx := Twice(2);\nEND_PROGRAM\n")
    twice = "FUNCTION Twice : INT\nVAR_INPUT a : INT; END_VAR\nTwice := 2 * a;\nEND_FUNCTION\n"
    (tmp_path / "Twice.st").write_text(twice)
    assert not stcore.compile([tmp_path / "p.st"]).diagnostics


def test_a_file_given_twice_is_one(tmp_path):
    file = tmp_path / "p.st"
    file.write_text(PROGRAM, encoding="utf-8")
    assert not stcore.compile([file, tmp_path, Path(f"{tmp_path}/../{tmp_path.name}/p.st")]).diagnostics


def test_a_path_that_is_no_unicode(tmp_path):
    assert stcore.compile([Source(PROGRAM, f"{tmp_path}/\udcfc.st")])


def test_a_caret_stands_under_what_a_terminal_shows():
    d = Diagnostic("E0301", "error", "m", "f.st", 1, 4, 6, "", "\t计x你a\x1b[31m")
    line, marks = text(d).splitlines()[1:]
    assert line == "    1 | \t计x你a\N{REPLACEMENT CHARACTER}[31m"
    assert marks == "      | \t   ^^^"


def test_a_sign_that_does_not_show_is_named():
    (d,) = [d for d in stcore.diagnose([Source("PROGRAM p\n\x1b\nEND_PROGRAM\n")]) if d.code == "E0105"]
    assert "U+001B" in d.message

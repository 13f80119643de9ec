"""Every program of examples_st runs as its first comment says; the form is described in examples_st/README.md."""

import json
import re
import shlex
from pathlib import Path

import pytest

from plcruntime.cli import main

FOLDER = Path(__file__).resolve().parents[2] / "examples_st"
ALL = sorted(FOLDER.glob("*.st"))
FILES = [f for f in ALL if not f.stem.startswith("test_")]  # those are tests themselves
KEYS = ("run", "again", "picture", "expect", "fault", "errors")


def directives(text: str) -> dict[str, str]:
    """The `key: value` lines of the first comment; a line without a key goes on with the one before."""
    comment = re.match(r"\(\*(.*?)\*\)", text, re.S)
    assert comment, "no first comment"
    found, key = {"shows": ""}, "shows"
    for line in comment[1].splitlines():
        start = re.match(rf"\s*({'|'.join(KEYS)}):(.*)", line)
        if start:
            key, line = start[1], start[2]
        found[key] = f"{found.get(key, '')} {line.strip()}".strip()
    return found


def expectations(text: str) -> list[tuple[str, object, float]]:
    """'a.b = 5; c = 0.5 +- 0.1' -> (path, value, tolerance) of each."""
    found = []
    for part in re.findall(r"(?:'(?:\$.|[^'$])*'|[^;'])+", text):
        path, value, tolerance = re.fullmatch(r"\s*(\S+) = (.*?)(?: \+- (\S+))?\s*", part).groups()
        found.append((path, literal(value), float(tolerance or 0)))
    return found


def literal(text: str) -> object:
    if text.startswith("["):
        return [literal(x.strip()) for x in text[1:-1].split(",")]
    if text.startswith("'"):
        escapes = {"N": "\n", "T": "\t", "R": "\r", "$": "$", "'": "'"}
        return re.sub(r"\$(.)", lambda m: escapes[m[1].upper()], text[1:-1])
    if text.upper() in ("TRUE", "FALSE"):
        return text.upper() == "TRUE"
    if "#" in text:
        base, digits = text.split("#")
        return int(digits, int(base))
    return float(text) if re.search(r"[.eE]", text) else int(text)


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.stem)
def test_example(file, capsys, tmp_path):
    wanted = directives(file.read_text(encoding="utf-8"))
    assert wanted["shows"], "the first comment does not say what the program shows"
    if "errors" in wanted:
        assert main(["check", str(file), "--format", "json"]) == 1
        found = json.loads(capsys.readouterr().out)["diagnostics"]
        assert [f"{d['code']} in line {d['line']}" for d in found] == wanted["errors"].split("; ")
        return
    expected = expectations(wanted.get("expect", ""))
    watch = ["--watch", ",".join(path for path, _, _ in expected)] if expected else []

    options = [*watch, "--json"]
    if "again" in wanted:
        options += ["--retain", str(tmp_path / "kept")]
        assert main(["run", str(file), *shlex.split(wanted["run"]), *options]) == 0
        capsys.readouterr()
    code = main(["run", str(file), *shlex.split(wanted.get("again", wanted["run"])), *options])

    result = json.loads(capsys.readouterr().out)
    fault = result["fault"] and f"{result['fault']['code']} in line {result['fault']['line']}"
    assert fault == wanted.get("fault"), result["fault"]
    assert code == (1 if fault else 0)
    assert result["diagnostics"] == []
    values = {path.lower(): value for path, value in result["vars"].items()}
    for path, value, tolerance in expected:
        actual = values[path.lower()]
        if tolerance:
            assert actual == pytest.approx(value, abs=tolerance), path
        else:
            assert actual == value and isinstance(actual, bool) == isinstance(value, bool), (path, actual)


def test_readme_lists_every_example():
    listed = re.findall(r"^\| `([^`]+)`", (FOLDER / "README.md").read_text(encoding="utf-8"), re.M)
    covered = {file for pattern in listed for file in FOLDER.glob(pattern)}
    assert covered == set(ALL)
    assert all(list(FOLDER.glob(pattern)) for pattern in listed)

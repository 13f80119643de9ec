"""What is installed, and what README promises: its commands run and print what it shows."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PACKAGES = ("stcore", "mclib", "plcruntime")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    builder = pytest.importorskip("hatchling.builders.wheel").WheelBuilder(str(ROOT))
    folder = tmp_path_factory.mktemp("wheel")
    with zipfile.ZipFile(next(builder.build(directory=str(folder), versions=["standard"]))) as archive:
        yield archive


def test_wheel_holds_every_file_of_the_packages(wheel):
    there = {
        str(file.relative_to(ROOT))
        for package in PACKAGES
        for file in (ROOT / package).rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    }
    packed = {name for name in wheel.namelist() if ".dist-info" not in name}
    assert packed == there


def test_wheel_has_both_commands_and_the_licence(wheel):
    info = f"scancycle-{PROJECT['version']}.dist-info"
    entry_points = wheel.read(f"{info}/entry_points.txt").decode()
    assert "scancycle = plcruntime.cli:main" in entry_points
    assert "scy = plcruntime.cli:main" in entry_points
    assert "Apache License" in wheel.read(f"{info}/licenses/LICENSE").decode()


def test_lock_satisfies_the_dependencies():
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    locked = dict(re.findall(r"^([\w.-]+)==(\S+) \\$", lock, re.M))
    assert lock.count("--hash=sha256:") >= len(locked)
    extras = PROJECT["optional-dependencies"]
    for text in PROJECT["dependencies"] + extras["test"] + extras["lint"]:
        requirement = Requirement(text)
        name = requirement.name.replace("_", "-")
        assert name in locked and requirement.specifier.contains(locked[name]), text


def test_readme_opens_with_the_two_commands():
    first_block = re.search(r"```console\n(.*?)```", README, re.S)[1]
    assert [line.split("#")[0].strip() for line in first_block.splitlines()] == ["$ make demo", "$ make test"]
    assert README.index(first_block) < 600


def test_ci_runs_the_test_command_of_the_readme():
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    assert script.read_text().splitlines()[-1] == "make test"


def test_every_file_that_the_documents_link_to_exists():
    for document in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), ROOT / "examples_st" / "README.md"]:
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", document.read_text(encoding="utf-8")):
            assert (document.parent / target).exists(), f"{document.name}: {target}"


def commands(text):
    """(command, exit code, lines printed) of each `$ ` line in the console blocks. '# exit code 1' names the code."""
    for block in re.findall(r"```console\n(.*?)```", text, re.S):
        for part in re.split(r"^\$ ", block, flags=re.M)[1:]:
            command, *output = part.replace("\\\n", " ").splitlines()
            code = re.search(r"# exit code (\d)", command)
            yield command.split(" #")[0].strip(), int(code[1]) if code else 0, output


TOUR = re.search(r"^## From the first command.*?(?=^## )", README, re.S | re.M)[0]  # its commands need its files
COMMANDS = [case for case in commands(README.replace(TOUR, "")) if case[0].split()[0] in ("scancycle", "scy")]


def plain(text):
    """Words only: the lines of a table and the width of its columns are not what a reader looks for."""
    return re.sub(r"[\s─-╿]+", " ", text).strip()


def run(command, folder, **more):
    """A command of the README in a shell, with ours in the path."""
    env = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}", "COLUMNS": "110"}
    env.pop("PYTEST_ADDOPTS", None)
    return subprocess.run(
        command, shell=True, cwd=folder, env=env, capture_output=True, text=True, timeout=100, **more
    )  # fmt: skip


def check_command(command, code, output, folder):
    result = run(command, folder)
    printed = plain(result.stdout + result.stderr)
    assert result.returncode == code, printed
    for line in output:
        if line.strip() not in ("", "..."):
            assert plain(line.removesuffix(" ...")) in printed


@pytest.mark.parametrize("case", COMMANDS, ids=lambda case: case[0][:60])
def test_command_of_the_readme(case, tmp_path):
    command, code, output = case
    (tmp_path / "examples_st").symlink_to(ROOT / "examples_st")
    shutil.copy(ROOT / "examples_st" / "blinker.st", tmp_path / "my.st")
    check_command(command, code, output, tmp_path)


def test_tour_of_the_readme(tmp_path):
    """From the first command to a test that fails and then passes: its files, commands and prompts, in order."""
    ran = []
    for kind, block in re.findall(r"```(\w+)\n(.*?)```", TOUR, re.S):
        ran.append(kind)
        if kind == "iecst":
            (tmp_path / re.match(r"// (\S+)", block)[1]).write_text(block)
        elif kind == "console":
            for command, code, output in commands(f"```console\n{block}```"):
                check_command(command, code, output, tmp_path)
        else:
            lines = block.splitlines()
            typed = [line.partition("> ")[2] for line in lines if re.match(r"[\w:]+> ", line)]
            shown = [line for line in lines if not re.match(r"[\w:]+> ", line)]
            result = run("scancycle repl pump.st", tmp_path, input="\n".join(typed))
            assert result.stdout.splitlines()[1:] == shown
    assert ran == ["iecst", "console", "text", "iecst", "console", "iecst", "console"]


def test_the_readme_names_every_command():
    from plcruntime.cli import _parser

    choices = next(a.choices for a in _parser()._actions if a.choices)
    assert [name for name in choices if f"scancycle {name}" not in README] == []


@pytest.mark.parametrize("block", re.findall(r"```python\n(.*?)```", README, re.S))
def test_python_of_the_readme(block, tmp_path, monkeypatch):
    (tmp_path / "examples_st").symlink_to(ROOT / "examples_st")
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "README.md", "exec"), {})

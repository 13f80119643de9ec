"""The cache on disk: parse table, syntax trees, whole builds. Everything in it can be made anew.

The folder is ``$SCANCYCLE_CACHE``, else the platform's folder for caches. Where it can't be written, everything works
without, only slower; `problem` tells why, for ``scancycle doctor``. Files are written whole or not at all; one that
can't be read back is made anew.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import pickle
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from stcore import depth

if TYPE_CHECKING:
    from stcore.diagnostics import Reporter
    from stcore.source import Source
    from stcore.syntax import File

# the files whose change makes stored trees worthless
_PARSER = (
    "lexer", "pragmas", "tables", "parser", "build", "build_statements", "literals", "mend", "repair", "repair_search",
    "blocks", "words", "soft_words", "typeset", "syntax", "codes", "cache", "depth",
)  # fmt: skip

_problem = ""


def cache_dir() -> Path:
    """The folder of the cache; it may not exist yet."""
    return user_folder("SCANCYCLE_CACHE", mac="~/Library/Caches", xdg="XDG_CACHE_HOME", unix="~/.cache")


def state_dir() -> Path:
    """The folder for what is kept and can't be made anew; it may not exist yet."""
    return user_folder(
        "SCANCYCLE_STATE", mac="~/Library/Application Support", xdg="XDG_STATE_HOME", unix="~/.local/state"
    )


def user_folder(variable: str, *, mac: str, xdg: str, unix: str) -> Path:
    """A folder of this user: what the environment variable names, else the platform's place for such things."""
    if named := os.environ.get(variable):
        return Path(named)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or "~/AppData/Local"
    elif sys.platform == "darwin":
        base = mac
    else:
        base = os.environ.get(xdg) or unix
    return Path(os.path.expanduser(base)) / "scancycle"


def problem() -> str:
    """Why the cache could not be written, or '' while it could."""
    return _problem


def digest(*parts: bytes) -> str:
    """A file name for what these bytes say."""
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def fingerprint(files: Iterable[Path]) -> bytes:
    """Bytes that change when one of the files does (its time or size), or the version of Python."""
    stamps = []
    for file in files:
        stat = file.stat()
        stamps.append(f"{file.name} {stat.st_mtime_ns} {stat.st_size}")
    return "\n".join((sys.version, *stamps)).encode()


def _path(kind: str, key: str) -> Path:
    return cache_dir() / kind / key[:2] / key


def load(kind: str, key: str) -> bytes | None:
    """What was stored, or None."""
    try:
        return _path(kind, key).read_bytes()
    except OSError:
        return None


def store(kind: str, key: str, data: bytes) -> None:
    """Keep bytes for the next run. Where that is not possible nothing happens; `problem` then knows why."""
    global _problem
    path = _path(kind, key)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_name(f"{key}.{os.getpid()}.part")
        part.write_bytes(data)
        os.replace(part, path)
        _prune_once()
    except OSError as error:
        _problem = f"the cache folder {path.parents[2]} can't be written: {error.strerror or error}"


@functools.cache
def _prune_once() -> None:
    """The first time that this process stores something."""
    from stcore.prune import prune_daily

    prune_daily(cache_dir())


# -------------------------------------------------------------------------------------------------- syntax trees


@functools.cache
def _parser_stamp() -> bytes:
    """Changes with each file that has a part in making a tree."""
    folder = Path(__file__).parent
    names = [folder / f"{name}.py" for name in _PARSER]
    return fingerprint([folder / "grammar.lark", *(f for f in names if f.exists())])


def parse_cached(source: Source, reporter: Reporter) -> File:
    """`stcore.parser.parse`, or the tree of the same text from an earlier run, with the warnings it gave then.

    A file with errors is parsed each time.
    """
    key = digest(_parser_stamp(), source.text.encode("utf-8", "surrogatepass"))
    stored = load("tree", key)
    if stored is not None:
        try:
            tree, calls = pickle.loads(stored)
            for code, start, end, hint, fields in calls:
                reporter.add(code, source, start, end, hint=hint, **fields)
            return tree
        except Exception:  # a broken cache file may raise anything; it is written anew below
            pass
    from stcore.parser import parse

    recorder = _Recorder(reporter)
    tree = parse(source, recorder)
    if all(code[0] == "W" for code, *_ in recorder.calls):
        with contextlib.suppress(RecursionError):  # too deep to be worth keeping
            store("tree", key, _pickled((tree, recorder.calls)))
    return tree


def _pickled(tree: object) -> bytes:
    """Pickling goes down the levels of a tree."""
    with depth.room():
        return pickle.dumps(tree, 5)


class _Recorder:
    """Passes diagnostics on and notes them, to be given again when the tree comes from the cache."""

    def __init__(self, reporter: Reporter) -> None:
        self.reporter = reporter
        self.strict = reporter.strict
        self.calls: list[tuple] = []

    def add(self, code: str, source: Source, start: int, end: int | None = None, /, hint: str = "", **fields) -> None:
        self.calls.append((code, start, end, hint, fields))
        self.reporter.add(code, source, start, end, hint=hint, **fields)

"""The cache is kept small."""

import os

import pytest

from stcore import cache, library, prune, tables


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("SCANCYCLE_CACHE", str(tmp_path))
    cache._prune_once.cache_clear()
    yield tmp_path
    cache._prune_once.cache_clear()


def age(path, seconds, now):
    os.utime(path, (now - seconds, now - seconds))


def test_what_was_stored_is_loaded(folder):
    cache.store("tree", "abcd", b"data")
    assert cache.load("tree", "abcd") == b"data"
    assert cache.load("tree", "dcba") is None
    assert (folder / prune.STAMP).exists()
    assert not list(folder.rglob("*.part"))


def test_what_is_unused_goes_once_a_day(folder):
    cache.store("tree", "old", b"1")
    old = cache._path("tree", "old")
    now = (folder / prune.STAMP).stat().st_mtime
    age(old, prune.UNUSED + 60, now)
    prune.prune_daily(folder)
    assert old.exists()  # the last look is not a day ago
    age(folder / prune.STAMP, prune.DAY + 60, now)
    cache.store("tree", "new", b"2")  # this process has looked already
    assert old.exists()
    cache._prune_once.cache_clear()
    cache.store("tree", "newer", b"3")
    assert not old.exists()
    assert cache.load("tree", "new") == b"2"


def test_the_oldest_goes_first(folder, monkeypatch):
    monkeypatch.setattr(prune, "LIMIT", 1000)
    now = 1_000_000_000.0
    for i in range(11):
        cache.store("build", f"b{i}", bytes(100))
        age(cache._path("build", f"b{i}"), 100 * i, now)
    prune.prune(folder, now)
    left = sorted(p.name for p in folder.rglob("b*") if p.is_file())
    assert left == [f"b{i}" for i in range(5)]


def test_the_parse_table_is_read_without_lark(folder):
    """Importing Lark takes as long as parsing a thousand lines."""
    made = tables.load()
    (stored,) = (folder / "table").rglob("*/*")
    assert b"lark" not in stored.read_bytes()
    assert tables.load() == made


def test_an_index_reads_only_what_has_changed(folder, tmp_path_factory, monkeypatch):
    texts = tmp_path_factory.mktemp("texts")
    first, second = texts / "a.st", texts / "b.st"
    first.write_text("VAR_GLOBAL one : INT; END_VAR")
    second.write_text("TYPE Two : INT; END_TYPE")
    read, taken = library.read, []
    monkeypatch.setattr(library, "read", lambda path: taken.append(path) or read(path))
    here = {"A": str(first), "ONE": str(first), "B": str(second), "TWO": str(second)}
    assert library.index([texts], recursive=False) == here and len(taken) == 2
    library._index.cache_clear()
    assert library.index([texts], recursive=False) == here and len(taken) == 2
    second.write_text("FUNCTION Three : INT END_FUNCTION")
    here["THREE"] = here.pop("TWO")
    assert library.index([texts], recursive=False) == here and taken[2:] == [str(second)]
    kept = next((folder / "index").rglob("*/*"))
    kept.write_bytes(kept.read_bytes()[:9])  # damaged
    library._index.cache_clear()
    assert library.index([texts], recursive=False) == here and len(taken) == 5

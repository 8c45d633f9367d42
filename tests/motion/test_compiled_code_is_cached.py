"""The cache of compiled code gives back what was put there, or nothing."""

import os
from concurrent.futures import ThreadPoolExecutor

import pytest

from heyoka_bike.motion.fast import compiled_cache
from heyoka_bike.motion.fast.compiled_cache import cache_folder, cached

pytest.importorskip("heyoka")


class Builder:
    """Counts how often it is asked to build."""

    def __init__(self, what="built"):
        self.what, self.calls = what, 0

    def __call__(self):
        self.calls += 1
        return self.what


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("HEYOKA_BIKE_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def the_file(folder):
    (path,) = folder.iterdir()
    return path


def test_what_was_built_is_found_again():
    build = Builder(["some", "object"])
    assert cached({"order": 5}, build) == cached({"order": 5}, build) == ["some", "object"]
    assert build.calls == 1
    assert cached({"order": 6}, build) == ["some", "object"]
    assert build.calls == 2


@pytest.mark.parametrize("place", ["head", "checksum", "body"])
def test_a_damaged_file_is_built_again(folder, place):
    cached({}, Builder())
    path = the_file(folder)
    data = bytearray(path.read_bytes())
    where = {"head": 3, "checksum": len(compiled_cache._HEAD) + 5, "body": len(data) - 3}
    data[where[place]] ^= 1
    path.write_bytes(data)
    build = Builder()
    assert cached({}, build) == "built"
    assert build.calls == 1
    # ... and replaced by one that is whole.
    assert cached({}, build) == "built"
    assert build.calls == 1


@pytest.mark.parametrize("kept", [0, 10, 200])
def test_a_file_cut_short_is_built_again(folder, kept):
    cached({}, Builder())
    path = the_file(folder)
    path.write_bytes(path.read_bytes()[:kept])
    build = Builder()
    assert cached({}, build) == "built"
    assert build.calls == 1


def test_nothing_is_unpickled_before_it_is_checked(folder, monkeypatch):
    cached({}, Builder())
    path = the_file(folder)
    path.write_bytes(path.read_bytes()[:-1] + b"!")
    monkeypatch.setattr(compiled_cache.pickle, "loads", lambda _: pytest.fail("was unpickled"))
    assert cached({}, Builder()) == "built"


def test_a_file_of_another_key_is_not_believed(folder):
    # As if two descriptions had the same hash.
    cached({"order": 5}, Builder("five"))
    five = the_file(folder)
    data = five.read_bytes()
    five.unlink()
    cached({"order": 6}, Builder("six"))
    the_file(folder).write_bytes(data)
    assert cached({"order": 6}, Builder("six again")) == "six again"


@pytest.mark.parametrize("changed", ["heyoka", "package", "processor", "equations"])
def test_code_of_another_version_is_not_used(changed, monkeypatch, tmp_path):
    import heyoka

    cached({}, Builder("old"))
    if changed == "heyoka":
        monkeypatch.setattr(heyoka, "__version__", "0.0.0")
    elif changed == "package":
        monkeypatch.setattr(compiled_cache, "__version__", "0.0.0")
    elif changed == "processor":
        monkeypatch.setattr(compiled_cache, "_processor", lambda: ["z80", ""])
    else:
        monkeypatch.setattr(compiled_cache, "_SOURCES", compiled_cache._SOURCES[1:])
    assert cached({}, Builder("new")) == "new"


def test_a_file_of_another_user_is_not_believed(monkeypatch):
    cached({}, Builder("theirs"))
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    assert cached({}, Builder("mine")) == "mine"


def test_a_folder_that_cannot_be_written_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("HEYOKA_BIKE_CACHE", str(tmp_path / "file" / "cache"))
    build = Builder()
    assert cached({}, build) == cached({}, build) == "built"
    assert build.calls == 2


def test_a_disk_that_fills_up_leaves_nothing(folder, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    assert cached({}, Builder()) == "built"
    assert list(folder.iterdir()) == []


def test_old_files_go(folder, monkeypatch):
    monkeypatch.setattr(compiled_cache, "_MOST_FILES", 3)
    for i in range(5):
        cached({"order": i}, Builder())
        for age, path in enumerate(sorted(folder.iterdir(), key=lambda x: x.stat().st_mtime_ns)):
            os.utime(path, (1000 * i + age, 1000 * i + age))
    assert len(list(folder.iterdir())) == 3
    assert cached({"order": 4}, Builder("again")) == "built"


def test_many_at_the_same_time_do_no_harm(folder):
    large = "x" * 1_000_000

    def use(i):
        return cached({"order": i % 3}, Builder(f"{i % 3}{large}"))

    with ThreadPoolExecutor(8) as pool:
        for i, found in enumerate(pool.map(use, range(120))):
            assert found == f"{i % 3}{large}"
    assert len(list(folder.glob("*.code"))) == len(list(folder.iterdir())) == 3


def test_where_the_cache_is(tmp_path, monkeypatch):
    assert cache_folder() == tmp_path / "cache"
    monkeypatch.setenv("HEYOKA_BIKE_CACHE", "")
    assert cache_folder() is None
    build = Builder()
    assert cached({}, build) == cached({}, build) == "built"
    assert build.calls == 2
    monkeypatch.delenv("HEYOKA_BIKE_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "xdg" / "heyoka_bike"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert cache_folder() == tmp_path / "home" / ".cache" / "heyoka_bike"

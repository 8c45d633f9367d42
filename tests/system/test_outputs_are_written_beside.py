"""Temporary outputs are safe: no link is followed, and concurrent writers do not collide."""

import os
from concurrent.futures import ThreadPoolExecutor

import pytest

from heyoka_bike.system import files
from heyoka_bike.system.files import replace_file, write_output


@pytest.mark.parametrize("write", [write_output, replace_file])
def test_a_link_of_a_likely_name_is_not_followed(tmp_path, write):
    other = tmp_path / "other"
    other.write_bytes(b"kept")
    for name in ("x.part", ".x.part", "x.tmp"):
        (tmp_path / name).symlink_to(other)
    write(tmp_path / "x", b"new")
    assert (tmp_path / "x").read_bytes() == b"new"
    assert other.read_bytes() == b"kept"


def test_a_name_that_is_taken_is_refused_and_kept(tmp_path, monkeypatch):
    other = tmp_path / "other"
    other.write_bytes(b"kept")
    monkeypatch.setattr(files, "token_hex", lambda n: "taken")
    (tmp_path / ".taken.part").symlink_to(other)
    with pytest.raises(OSError, match="exists"):
        replace_file(tmp_path / "x", b"new")
    assert other.read_bytes() == b"kept"
    assert (tmp_path / ".taken.part").is_symlink()


def test_writers_of_one_output_do_not_meet(tmp_path):
    data = [bytes([65 + i]) * 10**6 for i in range(4)]
    with ThreadPoolExecutor(4) as crowd:
        for future in [crowd.submit(write_output, tmp_path / "x", d) for d in data * 8]:
            future.result()
    assert (tmp_path / "x").read_bytes() in data
    assert os.listdir(tmp_path) == ["x"]


def test_permissions_are_those_of_any_new_file(tmp_path):
    (tmp_path / "plain").touch()
    write_output(tmp_path / "x", b"")
    assert (tmp_path / "x").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_long_name_has_room(tmp_path):
    write_output(tmp_path / ("n" * 255), b"1")
    assert (tmp_path / ("n" * 255)).read_bytes() == b"1"

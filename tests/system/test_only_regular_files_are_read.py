"""A pipe, a socket, a folder or a device is refused unopened, and a long file is not read."""

import os
import socket

import pytest

from heyoka_bike.system.files import open_regular, path_inside, read_regular


def test_a_regular_file_is_read(tmp_path):
    path = tmp_path / "x"
    path.write_bytes(b"12345")
    assert read_regular(path, 5) == b"12345"
    with open_regular(path) as file:
        assert file.read() == b"12345"
    with pytest.raises(OSError, match="it is longer than 4 bytes"):
        read_regular(path, 4)


@pytest.mark.timeout(20)
@pytest.mark.skipif(os.name != "posix", reason="pipes and devices have names on POSIX")
def test_what_would_wait_or_never_end_is_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("/dev/zero")
    with socket.socket(socket.AF_UNIX) as listening:
        # The name of a socket is limited in length, so the socket is made in the current folder.
        here = os.getcwd()
        os.chdir(tmp_path)
        try:
            listening.bind("socket")
        finally:
            os.chdir(here)
        for name, kind in (
            ("pipe", "pipe"), ("link", "device"), ("socket", "socket"), (".", "folder"),
        ):  # fmt: skip
            with pytest.raises(OSError, match=f"it is a {kind}, expected a regular file"):
                read_regular(tmp_path / name, 100)


@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="needs Linux")
def test_a_file_that_states_no_size_is_limited(tmp_path):
    with pytest.raises(OSError, match="it is longer than 10 bytes"):
        read_regular("/proc/self/status", 10)


def test_a_link_that_leads_out_of_a_folder_is_not_followed(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "own").write_text("1")
    (folder / "near").symlink_to("own")
    (tmp_path / "other").write_text("2")
    (folder / "far").symlink_to(tmp_path / "other")
    (folder / "up").symlink_to("..")
    for name in ("own", "near"):
        assert path_inside(folder, name).read_text() == "1"
    for name in ("far", "up/other", "../other", tmp_path / "other"):
        with pytest.raises(ValueError, match="a link to a file outside the folder"):
            path_inside(folder, name)

"""``heyoka-bike serve`` starts, answers, ends when it is told to, and leaves nothing behind."""

import os
import re
import signal
import socket
import subprocess
import sys
import urllib.request

import pytest

from heyoka_bike.cli import main


def started(tmp_path, *options):
    return subprocess.Popen(
        [sys.executable, "-m", "heyoka_bike", "serve", "--port", "0", *options],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"TMPDIR": str(tmp_path)},
    )  # fmt: skip


@pytest.mark.timeout(60)
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_it_answers_until_it_is_told_to_end(tmp_path, how):
    with started(tmp_path) as server:
        line = server.stdout.readline()
        address = re.search(r"http://127\.0\.0\.1:\d+/", line)[0]
        assert "Ctrl-C ends it" in line
        with urllib.request.urlopen(address, timeout=30) as answer:
            assert b"How wrong is your bicycle?" in answer.read()
        server.send_signal(how)
        _, log = server.communicate()
        assert server.returncode == 0
    assert re.fullmatch(r"[-\d]+ [:\d]+ GET / 200 \d+ B \d+ ms\n", log), log
    assert not list(tmp_path.iterdir())


def test_a_port_that_is_taken_is_said(capsys):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["serve", "--port", str(port)]) == 1
    said = capsys.readouterr().err
    assert said.startswith(f"heyoka-bike: 127.0.0.1, port {port}: cannot be listened on (")
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--port", "70000"], "--port: found 70000, expected 0 to 65535"),
        (["--keep", "0"], "--keep: found 0, expected more than zero"),
        (["--max-size", "-1"], "--max-size: found -1, expected more than zero"),
        (["--host", "0.0.0.0"], "--host: found 0.0.0.0, expected --name too"),
        (["--leaderboard", "nowhere"], "nowhere"),
    ],
)
def test_options_that_cannot_be_are_said(capsys, options, said):
    assert main(["serve", *options]) == 1
    found = capsys.readouterr().err
    assert said in found
    assert found.count("\n") == 1


def test_without_its_packages_it_says_what_installs_them(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    assert main(["serve"]) == 1
    assert "pip install 'heyoka_bike[serve]'" in capsys.readouterr().err

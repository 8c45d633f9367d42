"""``heyoka-bike serve`` starts, answers, ends on request, and leaves no files behind."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager

import pytest

pytest.importorskip("uvicorn")


from heyoka_bike.cli import main
from heyoka_bike.system.resources import data_folder


@contextmanager
def started(tmp_path, *options):
    """Start a server that ends with the test in any case."""
    with subprocess.Popen(
        [sys.executable, "-m", "heyoka_bike", "serve", "--port", "0", *options],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"TMPDIR": str(tmp_path)},
    ) as server:  # fmt: skip
        try:
            yield server
        finally:
            server.kill()


@pytest.mark.proof
@pytest.mark.timeout(300)
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


@pytest.mark.proof
@pytest.mark.timeout(300)
@pytest.mark.parametrize("share", [0.5, 1.0])
def test_a_client_that_vanishes_leaves_nothing(tmp_path, share):
    body = (data_folder() / "peers" / "exudyn-h0.01.txt").read_bytes()
    head = f"POST /score HTTP/1.1\r\nHost: localhost\r\nContent-Length: {len(body)}\r\n\r\n"
    with started(tmp_path) as server:
        port = int(re.search(r":(\d+)/", server.stdout.readline())[1])
        for _ in range(3):
            with socket.create_connection(("127.0.0.1", port)) as client:
                client.sendall(head.encode() + body[: int(share * len(body))])
        # A client that stays connected is answered. Soon afterwards, nothing remains of the clients
        # that vanished.
        address = f"http://127.0.0.1:{port}/"
        asked = urllib.request.Request(f"{address}score", body, {"Content-Type": "text/plain"})
        with urllib.request.urlopen(asked, timeout=30) as answer:
            assert json.load(answer)["maneuvers"]
        end = time.monotonic() + 20
        while any(tmp_path.glob("heyoka-bike-serve-*/results/*")):
            assert time.monotonic() < end
            time.sleep(0.05)
        server.terminate()
        _, log = server.communicate()
    assert log.count("POST /score") == 4, log
    assert "Traceback" not in log


@pytest.mark.proof
@pytest.mark.timeout(300)
def test_what_a_killed_server_kept_is_removed_by_the_next(tmp_path):
    with started(tmp_path) as killed, started(tmp_path) as living:
        killed.stdout.readline(), living.stdout.readline()
        killed.kill()
        killed.communicate()
        left = sorted(tmp_path.glob("heyoka-bike-serve-*"))
        assert len(left) == 2
        for folder in left:
            os.utime(folder, (0, 0))
        with started(tmp_path) as following:
            following.stdout.readline()
            # Two folders remain: one belongs to the new server, and one to the older server that is
            # still alive.
            assert len(set(tmp_path.glob("heyoka-bike-serve-*")) - set(left)) == 1
            assert len(set(tmp_path.glob("heyoka-bike-serve-*")) & set(left)) == 1
            following.terminate()
            following.communicate()
        living.terminate()
        living.communicate()
    assert not list(tmp_path.glob("heyoka-bike-serve-*"))


@pytest.mark.timeout(120)
def test_what_others_put_in_its_place_is_left_alone(tmp_path):
    running = pytest.importorskip("heyoka_bike.workbench.serving.running")
    kept = tmp_path / "others" / "file"
    kept.parent.mkdir()
    kept.touch()
    # Opening the pipe as a file would wait for a writer.
    os.mkfifo(tmp_path / "heyoka-bike-serve-pipe")
    (tmp_path / "heyoka-bike-serve-link").symlink_to(kept.parent)
    for name, processes in (("old", "pymp-1"), ("odd", "others"), ("off", "../pymp-2")):
        (tmp_path / f"heyoka-bike-serve-{name}").mkdir()
        (tmp_path / f"heyoka-bike-serve-{name}" / "processes").write_text(processes)
    for name in ("pymp-1", "pymp-2"):
        (tmp_path / name).mkdir()
    running.sweep(tmp_path, new=-1.0)
    assert kept.exists()
    # The folder of the killed server is removed. The other folder remains, because its owner is
    # unknown.
    assert sorted(p.name for p in tmp_path.glob("pymp-*")) == ["pymp-2"]
    left = sorted(p.name for p in tmp_path.glob("heyoka*"))
    assert left == ["heyoka-bike-serve-link", "heyoka-bike-serve-pipe"]


@pytest.mark.proof
@pytest.mark.timeout(300)
def test_on_every_address_it_tells_its_name(tmp_path):
    with started(tmp_path, "--host", "0.0.0.0", "--name", "bicycle.example.org") as server:
        assert " on http://bicycle.example.org:" in server.stdout.readline()
        server.terminate()
        server.communicate()


@pytest.mark.timeout(300)
def test_a_port_that_is_taken_is_said(capsys):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["serve", "--port", str(port)]) == 1
    said = capsys.readouterr().err
    assert said.startswith(f"heyoka-bike: cannot listen on 127.0.0.1, port {port} (")
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--port", "70000"], "--port: found 70000, expected 0 to 65535"),
        (["--keep", "0"], "--keep: found 0, expected more than zero"),
        (["--max-size", "-1"], "--max-size: found -1, expected more than zero"),
        (["--host", "0.0.0.0"], "--host 0.0.0.0 needs --name"),
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

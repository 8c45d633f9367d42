"""The load test that users can run counts lost answers, killed processes and memory."""

import json
import os
import socket
import sys

import pytest

pytest.importorskip("uvicorn")


import serving_load

pytestmark = pytest.mark.proof


@pytest.mark.skipif(sys.platform != "linux", reason="processes are found in /proc")
def test_a_soak_with_kills_loses_none(monkeypatch, capsys):
    words = "--clients 3 --minutes 0.1 --kill-every 0.5"
    monkeypatch.setattr(sys, "argv", ["serving_load", *words.split()])
    serving_load.main()
    said = json.loads(capsys.readouterr().out)
    assert said["answers lost"] == 0
    assert said["answers"]["200"] > 0
    # A process that is killed may already have sent its answer.
    assert said["processes killed"] > 0
    assert sum(said["answers"].values()) - said["answers"]["200"] <= said["processes killed"]
    assert all(size > 10 for size in said["MB, median of each tenth of the time"])
    assert said["folders left"] == 0


def test_answers_that_do_not_come_are_counted():
    with socket.socket() as bound:
        bound.bind(("127.0.0.1", 0))
        load = serving_load._Load(bound.getsockname()[1], b"", os.getpid())
        load.put(2, 5, None, None)
    assert load.said()["answers lost"] == 5
    assert load.said()["answers"] == {}

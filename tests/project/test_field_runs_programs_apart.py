"""The field is run program by program: what hangs, crashes or is absent is one line."""

import json
import os
import subprocess
import sys
import time

import pytest
from support.peers import PEERS, apart, measured, on_path

FIELD = PEERS / "field.py"


@pytest.fixture(autouse=True)
def _modules_are_found():
    with on_path():
        yield


def maker(what):
    """A function that behaves as it is told to."""
    if what == "absent":
        raise ImportError("no module that is called so")
    return behave


def behave(what):
    if what == "hangs":
        subprocess.run([sys.executable, "-c", "import time; time.sleep(600)"], check=True)
    if what == "crashes":
        os._exit(7)
    if what == "raises":
        raise ZeroDivisionError("by nothing")
    return what, os.getpid()


def test_a_call_that_fails_leaves_the_next_one_whole():
    with apart.Apart(20, maker, "there") as called:
        first = called("first")
        assert first[0] == "first"
        assert first[1] != os.getpid()
        assert called("second")[1] == first[1]
        for what, word in (("raises", "ZeroDivisionError: by nothing"), ("crashes", "code 7")):
            with pytest.raises(apart.FailedError, match=word):
                called(what)
        called.start()
        called.limit = 1
        with pytest.raises(apart.FailedError, match="no end after 1 s"):
            called("hangs")
        called.limit = 20
        assert called("last")[0] == "last"


def test_what_is_not_here_says_so():
    with (
        apart.Apart(20, maker, "absent") as called,
        pytest.raises(apart.AbsentError, match="called so"),
    ):
        called("first")


def test_orders_are_those_between_neighbours_of_a_family():
    def run(digits, **setting):
        same = measured.family(
            {"measure": "step", "follows": "stiffness", "beside": ["newton"]}, setting
        )
        return {"setting": setting, "digits": digits, "failure": None, "family": same}

    runs = [
        run(2.0, step=0.1, stiffness="0.2 1"),
        run(6.0, step=0.001, stiffness="0.002 1", newton=1e-12),
        run(4.0, step=0.01, stiffness="0.02 1"),
        run(5.0, step=0.01, stiffness="0.2 1"),
        run(1.0, step=0.01, method="other"),
        run(0.0, step=0.01, stiffness="0.02 1") | {"failure": "crashed"},
    ]
    found = measured.orders(runs, "step")
    assert [(x["from"], x["to"], x["order"]) for x in found] == [(0.1, 0.01, 2), (0.01, 0.001, 2)]


def test_what_is_written_down_is_kept_while_it_holds(tmp_path):
    path = tmp_path / "field.json"
    entry = {"measure": "step", "default": {"step": 1}, "sweep": [{"step": 1}, {"step": 2}]}
    assert measured.settings(entry) == [("default", {"step": 1}), ("sweep", {"step": 2})]
    document = measured.Document.of(path, "here", "peer", ["b", "a"])
    line, failed = (
        measured.named(entry, kind, setting)
        | {"started": document.started, "made_of": "made of this", "failure": failure}
        for (kind, setting), failure in zip(
            measured.settings(entry), (None, "crashed"), strict=True
        )
    )
    document.keep("a", {"runs": [line, failed]})
    document.keep("b", {"runs": []})
    assert list(json.loads(path.read_text())["programs"]) == ["b", "a"]
    again = measured.Document.of(path, "here", "peer", ["b", "a"])
    assert again.line("a", "default", "made of this") == line
    again.keep("a", {"runs": []})
    assert again.line("a", "default", "made of this") == line, "runs that follow are kept too"
    assert again.line("a", "default", "made of that") is None
    assert again.line("a", "sweep", "made of this") is None
    assert (
        measured.Document.of(path, "elsewhere", "peer", []).line("a", "default", "made of this")
        is None
    )


def test_versions_are_those_that_are_installed():
    line = "apt-get install not-there; pip install numpy==0.1 'pytest<90' && pip install -U no==1"
    found = measured.installed(line)
    assert list(found) == ["numpy", "pytest"]
    assert found["numpy"] != "0.1"
    assert measured.pinned(line) == {"numpy": "0.1", "no": "1"}
    assert measured.lacking(line) == ["no"]


def field(*arguments):
    done = subprocess.run(
        [sys.executable, FIELD, *map(str, arguments)], capture_output=True, text=True, check=False,
        timeout=300,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@pytest.mark.proof
def test_a_program_is_run_scored_and_kept(tmp_path):
    pytest.importorskip("heyoka")
    path = tmp_path / "field.json"
    code, out, err = field("linear", "-o", path)
    assert (code, err) == (0, "")
    assert "-0.57 digits" in out
    (run,) = json.loads(path.read_text())["programs"]["linear"]["runs"]
    assert run["performance"][1] == pytest.approx(0.87, rel=0.01)
    assert run["ratio"] == pytest.approx(run["cpu"] / run["peer"], rel=0.01)
    before = path.read_text()
    time.sleep(0.01)
    assert field("linear", "-o", path)[0] == 0
    assert path.read_text() == before


def test_an_unknown_program_is_one_line():
    code, _, err = field("mujocco")
    assert code == 2
    assert "found 'mujocco', expected some of mujoco" in err.splitlines()[-1]

"""Datasets are identical to the byte for any executor and after any interruption."""

import base64
import hashlib
import io
import json
import pickle
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import heyoka_bike
from heyoka_bike.cli import main
from heyoka_bike.errors import InputError
from heyoka_bike.reference import making as module
from heyoka_bike.system.jobs import Job
from heyoka_bike.system.parallel import carry_out, using
from heyoka_bike.system.unfinished import SUFFIX, Unfinished, unfinished
from support.clusters import HEARS, started, wait_for

pytest.importorskip("heyoka")
pytest.importorskip("distributed")
pytestmark = pytest.mark.proof

# A maneuver of two rows for two bicycles: about ten seconds of a processor, in ten parts.
MANEUVER = """
[[maneuver]]
name = "short"
speed = "5"
roll_rate = "0.1"
duration = "0.01"
spacing = "0.01"
"""


@pytest.fixture(scope="module")
def sets(tmp_path_factory):
    """The words of the command, without the folder."""
    file = tmp_path_factory.mktemp("maneuver") / "short.toml"
    file.write_text(MANEUVER)
    return ["generate", "--bicycle", "pista", "silver", "--maneuvers", str(file), "--out"]


def content(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def expected(tmp_path_factory, sets):
    """The files made by a single process."""
    folder = tmp_path_factory.mktemp("one")
    assert main([*sets, str(folder / "sets"), "--workers", "1"]) == 0
    return content(folder / "sets")


def begun(*words):
    """Start the command in a process of its own."""
    script = f"{HEARS}import sys\nfrom heyoka_bike.cli import main\nsys.exit(main(sys.argv[1:]))"
    words = [sys.executable, "-c", script, *map(str, words)]
    return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def kept(folder):
    return sorted(p for p in folder.glob(f"*{SUFFIX}/*") if p.name != "lock")


def test_a_killed_worker_and_a_killed_scheduler_cost_only_what_they_did(expected, sets, tmp_path):
    """The scheduler is killed midway; with a new one the same command continues."""
    made = tmp_path / "sets"
    with started(tmp_path) as processes:
        run = begun(*sets, made, "--cluster", processes.address)
        wait_for(lambda: len(kept(made)) >= 2, 600)
        processes.all[1].kill()
        wait_for(lambda: len(kept(made)) >= 5, 600)
        processes.all[0].kill()
        _, said = run.communicate(timeout=120)
    assert run.returncode == 70
    *where, last = said.splitlines()
    assert re.search("the scheduler at .* ended", last)
    # A worker may join shortly after the command starts.
    usual = ("finished parts are kept in", "yet: waiting for one", "of processor time in all")
    assert [line for line in where if not any(part in line for part in usual)] == [], said
    before = {p: p.stat().st_mtime_ns for p in kept(made)}
    assert len(before) >= 5
    (tmp_path / "again").mkdir()
    with started(tmp_path / "again", workers=1) as processes:
        run = begun(*sets, made, "--cluster", processes.address)
        wait_for(lambda: len(kept(made)) > len(before), 600)
        # Stored parts are not computed again.
        now = {p: p.stat().st_mtime_ns for p in kept(made)}
        assert {p: now.get(p) for p in before} == before
        run.communicate(timeout=600)
    assert run.returncode == 0
    assert content(made) == expected


def test_a_run_that_is_killed_and_interrupted_goes_on(expected, sets, tmp_path):
    made = tmp_path / "sets"
    run = begun(*sets, made, "--workers", "2")
    wait_for(lambda: len(kept(made)) >= 2, 600)
    run.kill()
    run.communicate(timeout=120)
    before = {p: p.stat().st_mtime_ns for p in kept(made)}
    assert len(before) >= 2
    run = begun(*sets, made, "--workers", "2")
    wait_for(lambda: len(kept(made)) >= len(before) + 2, 600)
    # Parts are unchanged, or deleted because their dataset is complete.
    now = {p: p.stat().st_mtime_ns for p in kept(made)}
    assert all(now.get(p, written) == written for p, written in before.items())
    run.send_signal(signal.SIGINT)
    _, said = run.communicate(timeout=120)
    assert run.returncode == 130
    # One of the two datasets may be complete by then.
    assert re.search(r"finished parts are kept in (pista|silver)\.unfinished beside it", said)
    assert content(made).keys() != expected.keys()
    assert main([*sets, str(made)]) == 0
    assert content(made) == expected


def test_two_runs_cannot_write_one_folder(tmp_path):
    with unfinished(tmp_path / "set"), pytest.raises(InputError, match="found another run"):
        heyoka_bike.generate(tmp_path / "set", until="1/50")
    assert not (tmp_path / "set").exists()


def test_what_is_damaged_or_of_other_code_is_made_again(tmp_path, monkeypatch):
    def there(*parts):
        return Job(print, (), cache=Unfinished(tmp_path).at(*parts)).load()

    first = Job(print, (), cache=Unfinished(tmp_path).at("stage", {"mass": "2"}, 70))
    first.store(module.Outcome((1, 2, 3)))
    assert there("stage", {"mass": "2"}, 70).value == (1, 2, 3)
    for other in (("stage", {"mass": "3"}, 70), ("stage", {"mass": "2"}, 90)):
        assert there(*other) is None
    monkeypatch.setattr("heyoka_bike.system.unfinished.versions", lambda: {"heyoka": "other"})
    assert there("stage", {"mass": "2"}, 70) is None
    whole = first.cache.file.read_bytes()
    for damaged in (whole[:-1], whole[:40] + b"x" + whole[41:], b""):
        first.cache.file.write_bytes(damaged)
        assert first.load() is None


def test_what_somebody_else_put_there_is_no_code(tmp_path):
    """The stored files have correct hashes: pickles, arrays of objects, classes of other kinds."""

    class Harmful:
        def __reduce__(self):
            return Path.touch, (tmp_path / "harmed",)

    file = io.BytesIO()
    np.save(file, np.array([Harmful()]), allow_pickle=True)
    objects = {"array": {"npy": base64.b64encode(file.getvalue()).decode()}}
    part = Unfinished(tmp_path).at("stage")
    for data in (
        pickle.dumps(Harmful()),
        json.dumps(objects).encode(),
        b'{"Path": {}}', b'{"eval": {"": "1"}}', b'{"fraction": {}, "array": {}}', b"[" * 10**5,
        b'{"fraction": []}', b'{"fraction": {"numerator": 1, "denominator": 0}}',
        b'{"array": {"npy": ""}}',
    ):  # fmt: skip
        part.file.write_bytes(hashlib.sha256(data).digest() + data)
        assert part.load() is None
    assert not (tmp_path / "harmed").exists()
    # The first of these would have done the harm.
    pickle.loads(pickle.dumps(Harmful()))
    assert (tmp_path / "harmed").exists()


def test_two_processes_make_the_same_bytes_beside_a_set_that_fails(
    expected, sets, tmp_path, capsys
):
    bad = tmp_path / "bad.toml"
    bad.write_text("name = 1\n")
    asked = [*sets, str(tmp_path / "sets"), "--workers", "2"]
    asked[2:4] = ["silver", str(bad), "pista"]
    assert main(asked) == 1
    assert re.search(
        r"heyoka-bike: \S*/sets/bad: not written: \S*bad.toml", capsys.readouterr().err
    )
    assert content(tmp_path / "sets") == expected


def test_a_part_that_fails_is_named_and_the_other_sets_are_made(
    expected, sets, tmp_path, monkeypatch
):
    def fails(*_):
        raise ArithmeticError("by nothing")

    def breaking(jobs, *how):
        varied = [job for job in jobs if job.stages == ("vary",)]
        for job in varied[:1]:
            object.__setattr__(job, "work", fails)
        carry_out(jobs, *how)

    monkeypatch.setattr(module, "carry_out", breaking)
    made = []
    with using(workers=1):
        failed = module.generate_sets(
            {tmp_path / "pista": "pista", tmp_path / "silver": "silver"}, maneuvers=sets[5],
            digits=70, until=None, force=False, say=lambda text: None, progress=None,
            made=made.append,
        )  # fmt: skip
    assert [x.folder.name for x in made] == ["silver"]
    (error,) = failed.values()
    assert isinstance(error, ArithmeticError)
    assert re.match("in fails of .*, short", error.__notes__[0])
    assert len(kept(tmp_path)) == 4
    assert {p for p in expected if p.parts[0] == "silver"} == {
        p for p in content(tmp_path) if p.parts[0] == "silver"
    }

"""Datasets are identical to the byte for any executor and after any interruption."""

import re
import signal
import subprocess
import sys

import pytest

from heyoka_bike.cli import main
from heyoka_bike.errors import Exit
from heyoka_bike.reference import making as module
from heyoka_bike.system.parallel import carry_out, using
from support.clusters import HEARS, started

pytest.importorskip("heyoka")
pytest.importorskip("distributed")
pytestmark = pytest.mark.proof

# The input is a maneuver of two rows for two bicycles. It takes about ten seconds of processor
# time, in ten parts.
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


def wait_for_jobs(run, count):
    """Read a command's log until this many jobs are done."""
    lines = []
    while sum(" done, " in line for line in lines) < count:
        lines.append(run.stderr.readline())
        assert lines[-1], "".join(lines)


def test_a_killed_worker_of_a_cluster_costs_only_its_job(expected, sets, tmp_path):
    made = tmp_path / "sets"
    with started(tmp_path) as processes:
        run = begun(*sets, made, "--cluster", processes.address, "-v")
        wait_for_jobs(run, 2)
        processes.all[1].kill()
        _, said = run.communicate(timeout=600)
    assert run.returncode == 0, said
    assert content(made) == expected


def test_a_killed_scheduler_ends_the_run_with_one_line(sets, tmp_path):
    with started(tmp_path) as processes:
        run = begun(*sets, tmp_path / "sets", "--cluster", processes.address, "-v")
        wait_for_jobs(run, 2)
        processes.all[0].kill()
        _, said = run.communicate(timeout=120)
    assert run.returncode == Exit.INPUT
    assert re.search("the scheduler at .* ended", said.splitlines()[-1])


def test_an_interrupted_run_is_repaired_by_the_next(expected, sets, tmp_path):
    made = tmp_path / "sets"
    run = begun(*sets, made, "--workers", "2", "-v")
    wait_for_jobs(run, 3)
    run.send_signal(signal.SIGINT)
    run.communicate(timeout=120)
    assert run.returncode == 130
    assert content(made).keys() != expected.keys()
    assert main([*sets, str(made)]) == 0
    assert content(made) == expected


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
    assert {p for p in expected if p.parts[0] == "silver"} == {
        p for p in content(tmp_path) if p.parts[0] == "silver"
    }

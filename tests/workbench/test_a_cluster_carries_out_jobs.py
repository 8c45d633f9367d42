"""A Dask cluster gives the same results; lost, wrong or missing parts are reported in a line."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from heyoka_bike.cli import main
from heyoka_bike.errors import Exit, InputError, VersionsDifferError, WorkerLostError
from heyoka_bike.system.cluster import check_versions
from heyoka_bike.system.jobs import Job
from heyoka_bike.system.machine import versions
from heyoka_bike.system.parallel import carry_out, side_by_side, using
from support import jobs
from support.clusters import HEARS, TESTS, started, wait_for

pytest.importorskip("distributed")

pytestmark = pytest.mark.proof

MANY = [(i, 1) for i in range(20)]


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with started(tmp_path_factory.mktemp("cluster")) as processes:
        yield processes


def test_results_and_progress_come_from_the_workers(cluster, tmp_path):
    told = []
    with using(cluster=cluster.address):
        assert side_by_side(jobs.add, MANY) == list(range(1, 21))
        found = side_by_side(
            jobs.begin, [(str(tmp_path), 1.0)] * 4, [(name, 1.0) for name in "abcd"],
            lambda *x: told.append(x),
        )  # fmt: skip
    assert {p.pid for p in cluster.all[1:]} == set(found)
    assert {name for name, stage, _ in told if stage == "integrate"} == set("abcd")


def test_errors_of_jobs_come_back(cluster):
    with using(cluster=cluster.address), pytest.raises(ZeroDivisionError, match="by nothing"):
        side_by_side(jobs.fail, [(), ()])


def test_one_job_at_a_time_in_a_worker_of_many_threads(tmp_path, capsys):
    with started(tmp_path, workers=0) as processes:
        processes.worker(threads=4)
        bits = [(53 + 40 * (i % 3),) for i in range(9)]
        with using(cluster=processes.address):
            found = side_by_side(jobs.precise, bits)
            # The first use may not mention a worker that joins after the check, so the cluster is
            # used once more.
        assert found == found[:3] * 3
        with using(cluster=processes.address):
            pass
    assert "has 4 threads and does one job at a time" in capsys.readouterr().err


def test_work_waits_for_a_worker_and_outlives_one(tmp_path, capsys):
    flag = tmp_path / "flag"
    with started(tmp_path, workers=0) as processes, using(cluster=processes.address):
        assert "no worker at" in capsys.readouterr().err
        for _ in range(2):
            processes.worker()
        # One of the two workers is killed with its job, and the other worker does all jobs.
        assert side_by_side(jobs.die_once, [(str(flag),)] * 4) == ["done"] * 4
        assert sum(p.poll() is None for p in processes.all) == 2


def test_a_job_that_ends_every_worker_is_given_up(tmp_path):
    with started(tmp_path, workers=4) as processes, using(cluster=processes.address):
        processes.start(
            "worker", "--scheduler-file", processes.address, "--no-dashboard", "--nthreads", "1"
        )
        with pytest.raises(WorkerLostError, match="die of deadly: its process ended every time"):
            carry_out([Job(jobs.die, (), "deadly")], lambda job, outcome: outcome.get())


def test_a_scheduler_that_ends_is_said(tmp_path):
    with started(tmp_path) as processes, using(cluster=processes.address):
        told = []

        def end(*_):
            if not told:
                processes.all[0].kill()
            told.append(1)

        with pytest.raises(WorkerLostError, match=r"the scheduler at .* ended") as caught:
            side_by_side(jobs.begin, [(str(tmp_path), 600.0)], [("a", 1.0)], end)
    # The exit code is the code for bad input, and the message says what the user can do.
    assert caught.value.exit_code == Exit.INPUT
    assert "start it and its workers again, then repeat the command" in str(caught.value)


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_who_asked_ends_what_runs_on_workers(cluster, tmp_path, how):
    """Ctrl-C or a killed client ends the jobs, but the workers remain for others."""
    script = (
        f"{HEARS}from support import jobs\nfrom heyoka_bike.system.parallel import *\n"
        f"with using(cluster={cluster.address!r}):\n"
        f"  side_by_side(jobs.begin, [({str(tmp_path)!r}, 600.0)] * 3)\n"
    )
    run = subprocess.Popen(
        [sys.executable, "-c", script], stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": str(TESTS)},
    )  # fmt: skip
    wait_for(lambda: len(list(tmp_path.iterdir())) == 2)
    run.send_signal(how)
    assert run.wait(60) != 0
    told = {}

    def stands_still():
        before, now = told.copy(), {p: p.read_text() for p in tmp_path.iterdir()}
        told.update(now)
        return before == now

    wait_for(stands_still, every=1.0)
    with using(cluster=cluster.address):
        assert side_by_side(jobs.add, [(1, 2)]) == [3]


def test_other_versions_are_refused_by_name(tmp_path):
    """One worker is connected at the start, and one joins later."""
    other = tmp_path / "other"
    package = other / "heyoka_bike"
    package.parent.mkdir()
    package.symlink_to(Path(__file__).parents[2] / "heyoka_bike")
    site = other / "sitecustomize.py"
    site.write_text("import numpy; numpy.__version__ = '0.1'\n")
    here = versions()
    with pytest.raises(VersionsDifferError, match=r"w: found numpy 0\.1, expected .* as in this"):
        check_versions(here, {**here, "numpy": "0.1"}, "w")
    late = (
        "from heyoka_bike.system import machine as v; there = {**v.versions(), 'numpy': '0.1'}; "
        "v.versions.cache_clear(); v.installed = lambda name: there.get(name)"
    )
    site.write_text(late)
    paths = os.pathsep.join([str(other), str(TESTS)])
    with started(tmp_path, workers=0) as processes:
        with using(cluster=processes.address):
            processes.worker(PYTHONPATH=paths)
            with pytest.raises(VersionsDifferError, match=r"found numpy 0\.1, expected"):
                side_by_side(jobs.add, [(1, 2)])
        with (
            pytest.raises(VersionsDifferError, match=r"found numpy 0\.1, expected"),
            using(cluster=processes.address),
        ):
            pass


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nowhere", "http://127.0.0.1:9", ""])
def test_an_address_that_does_not_answer_is_one_line(address, capsys):
    assert main(["verify", "--cluster", address]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"heyoka-bike: --cluster: found no Dask scheduler at {address}")


def test_a_file_that_says_nothing_is_no_scheduler(tmp_path):
    (tmp_path / "s.json").write_text("{}")
    with (
        pytest.raises(InputError, match="found no Dask scheduler"),
        using(cluster=str(tmp_path / "s.json")),
    ):
        pass

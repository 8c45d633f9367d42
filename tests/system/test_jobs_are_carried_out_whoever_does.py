"""Jobs give the same results in any executor, survive a lost process, and end with the caller."""

import multiprocessing
import os
import signal
import subprocess
import sys
from concurrent.futures import BrokenExecutor, CancelledError, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import pytest

from heyoka_bike.errors import InputError, WorkerLostError
from heyoka_bike.system.jobs import Job, ProcessExecutor, ProcessLimits, RemoteError
from heyoka_bike.system.parallel import WAITING, carry_out, side_by_side, using
from support import jobs
from support.clusters import HEARS, TESTS, wait_for

MANY = [(i, 1) for i in range(7)]


@contextmanager
def threads():
    with ThreadPoolExecutor(3) as pool, using(executor=pool):
        yield


@pytest.fixture(params=["here", "processes", "threads"])
def executor(request):
    made = {"here": lambda: using(1), "processes": lambda: using(2), "threads": threads}
    with made[request.param]():
        yield request.param


def outcomes(made):
    """Return the endings of jobs in order, by name."""
    found = {}

    def ended(job, outcome):
        found[job.name] = outcome
        return ()

    carry_out(made, ended)
    return found


def test_results_come_in_the_order_of_the_jobs(executor):
    assert side_by_side(jobs.add, MANY) == [1, 2, 3, 4, 5, 6, 7]


def test_a_job_gets_the_results_of_others(executor):
    first = Job(jobs.add, (1, 2), "first")
    second = Job(jobs.add, (first, 10), "second")
    third = Job(jobs.add, (second, first), "third")
    found = outcomes([third, second, first])
    assert list(found) == ["first", "second", "third"]
    assert [x.value for x in found.values()] == [3, 13, 16]


def test_what_fails_ends_what_needs_it_and_nothing_else(executor):
    bad = Job(jobs.fail, (), "bad")
    found = outcomes([Job(jobs.add, (bad, 1), "needs it"), bad, Job(jobs.add, (1, 1), "other")])
    assert found["other"].value == 2
    for name in ("bad", "needs it"):
        with pytest.raises(ZeroDivisionError) as caught:
            found[name].get()
        assert caught.value.__notes__ == ["in fail of bad"]


def test_jobs_may_ask_for_more(executor):
    found = []

    def ended(job, outcome):
        found.append(outcome.value)
        return [Job(jobs.add, (outcome.value, 1))] if outcome.value < 4 else []

    carry_out([Job(jobs.add, (0, 1))], ended)
    assert found == [1, 2, 3, 4]


def test_precision_is_of_one_job_at_a_time(executor):
    """Precision is a setting of the whole process, which threads would take from each other."""
    bits = [(53 + 40 * (i % 3),) for i in range(9)]
    found = side_by_side(jobs.precise, bits)
    assert found == found[:3] * 3
    assert len(set(found)) == 3


@pytest.mark.proof
def test_progress_is_told_from_elsewhere(tmp_path):
    told = []
    with using(2):
        side_by_side(
            jobs.begin, [(str(tmp_path), 1.0)] * 2, [("a", 2.0), ("b", 1.0)],
            lambda *x: told.append(x),
        )  # fmt: skip
    assert told[:2] == [("a", WAITING, 0.0), ("b", WAITING, 0.0)]
    assert {(name, stage) for name, stage, _ in told[2:]} == {
        ("a", "integrate"), ("b", "integrate"),
    }  # fmt: skip
    assert max(share for name, _, share in told if name == "a") <= 0.5


def test_a_lost_process_has_its_job_done_again(tmp_path):
    with using(2):
        found = outcomes([
            Job(jobs.die_once, (str(tmp_path / "flag"),), "dies"),
            *(Job(jobs.add, x, f"other {x[0]}") for x in MANY),
        ])  # fmt: skip
    assert found["dies"].value == "done"
    assert [found[f"other {i}"].value for i in range(7)] == [1, 2, 3, 4, 5, 6, 7]


@pytest.mark.proof
def test_a_job_that_always_ends_its_process_is_given_up_and_named():
    with using(2):
        found = outcomes([Job(jobs.die, (), "deadly"), Job(jobs.add, (1, 2), "other")])
    assert found["other"].value == 3
    with pytest.raises(WorkerLostError, match="die of deadly: its process ended every time"):
        found["deadly"].get()


@pytest.mark.proof
def test_a_script_that_begins_processes_as_it_is_read_is_told_so(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "from support import jobs\nfrom heyoka_bike.system.jobs import Job\n"
        "from heyoka_bike.system.parallel import all_of, using\n"
        "with using(2):\n    all_of([Job(jobs.add, (1, 2), ''), Job(jobs.add, (3, 4), '')])\n"
    )
    run = subprocess.run(
        [sys.executable, str(script)], env=os.environ | {"PYTHONPATH": str(TESTS)},
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert run.stderr.count("Traceback") == 1, "only the first process may print one"
    assert 'lacks the guard if __name__ == "__main__"' in run.stderr.splitlines()[-1]


@pytest.mark.proof
def test_calls_with_limits_have_processes_of_their_own(tmp_path):
    with ProcessExecutor(2, ProcessLimits(60.0, 2_000_000_000)) as pool:
        calls = [pool.submit(jobs.imported, "sys") for _ in range(2)]
        assert len({call.result()[0] for call in calls} | {os.getpid()}) == 3
        assert pool.submit(jobs.memory_limit).result() == 2_000_000_000
        # If the process of a call dies, the call is not started again.
        with pytest.raises(BrokenExecutor):
            pool.submit(jobs.die_once, str(tmp_path / "flag"), jobs.nothing).result()
        # A remote error contains neither text nor objects, because these may come from an untrusted
        # file.
        with pytest.raises(RemoteError, match=r"^ZeroDivisionError at jobs\.py:\d+$"):
            pool.submit(jobs.fail, jobs.nothing).result()
        with pytest.raises(RemoteError, match="TypeError at"):
            pool.submit(object).result()


def test_a_call_ends_at_its_limit(tmp_path):
    with ProcessExecutor(1, ProcessLimits(0.5, 2_000_000_000)) as pool:
        with pytest.raises(TimeoutError):
            pool.submit(jobs.begin, str(tmp_path), 600.0, jobs.nothing).result()
        assert not multiprocessing.active_children()


@pytest.mark.proof
def test_processes_are_forked_from_one_that_has_imported_modules(tmp_path):
    """Run in a new process, because all executors share one preloaded process."""
    script = tmp_path / "script.py"
    script.write_text(
        "from support import jobs\nfrom heyoka_bike.system.jobs import *\n"
        "if __name__ == '__main__':\n"
        "  with ProcessExecutor(1, ProcessLimits(60.0, 2_000_000_000), ['colorsys']) as pool:\n"
        "    print(pool.submit(jobs.imported, 'colorsys').result()[1])\n"
    )
    run = subprocess.run(
        [sys.executable, str(script)], env=os.environ | {"PYTHONPATH": str(TESTS)},
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    forks = "forkserver" in multiprocessing.get_all_start_methods()
    assert run.stdout == f"{forks}\n", run.stderr


def test_what_is_cancelled_ends_whether_it_runs_or_waits(tmp_path):
    with ProcessExecutor(1) as pool:
        runs, waits = (pool.submit(jobs.begin, str(tmp_path), 600.0, jobs.nothing) for _ in "ab")
        wait_for(lambda: numbered(tmp_path))
        pool.shutdown(cancel_futures=True)
    for call in (runs, waits):
        with pytest.raises(CancelledError):
            call.result()
    assert len(numbered(tmp_path)) == 1
    assert_all_ended(tmp_path)


def test_the_first_exception_ends_the_others(tmp_path):
    both = [Job(jobs.begin, (str(tmp_path), 600.0)), Job(jobs.fail, ())]
    with using(2), pytest.raises(ZeroDivisionError):
        carry_out(both, lambda job, outcome: outcome.get())
    assert_all_ended(tmp_path)


@pytest.mark.proof
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_who_asked_ends_what_runs(tmp_path, how):
    """The process is ended by Ctrl-C, or killed."""
    script = (
        f"{HEARS}from support import jobs\nfrom heyoka_bike.system.parallel import *\n"
        "if __name__ == '__main__':\n with using(2):\n"
        f"  side_by_side(jobs.begin, [({str(tmp_path)!r}, 600.0)] * 2)\n"
    )
    (tmp_path / "script.py").write_text(script)
    run = subprocess.Popen(
        [sys.executable, str(tmp_path / "script.py")], stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": str(TESTS)},
    )  # fmt: skip
    wait_for(lambda: len(numbered(tmp_path)) == 2)
    run.send_signal(how)
    assert run.wait(60) != 0
    assert_all_ended(tmp_path)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"workers": 0}, "--workers: found 0, expected 1 or more"),
        ({"workers": 2, "cluster": "tcp://x:1"}, "found two of --workers, --cluster"),
    ],
)
def test_what_cannot_be_is_refused(given, said):
    with pytest.raises(InputError, match=said), using(**given):
        pass


def numbered(folder):
    """Return files that processes have written, by their numbers."""
    return [p for p in folder.iterdir() if p.name.isdigit()]


def assert_all_ended(folder):
    def is_there(file):
        try:
            os.kill(int(file.name), 0)
        except ProcessLookupError:
            return False
        return "\nState:\tZ" not in Path(f"/proc/{file.name}/status").read_text()

    wait_for(lambda: not any(map(is_there, numbered(folder))))

"""Long work as jobs, for processes of this machine, a cluster, or any other executor.

`using` selects the executor of jobs; by default there are as many processes as processors. The
results are identical to the bit for every executor, because each process runs one job at a time.
"""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from functools import partial
from queue import Empty, SimpleQueue
from threading import Lock
from typing import Any, TypeVar

from heyoka_bike.errors import InputError, WorkerLostError
from heyoka_bike.system.jobs import Job, Outcome, ProcessExecutor, ProgressFuture, reporting

T = TypeVar("T")
Progress = Callable[[str, str, float], None]
"""Called with the name of a motion, a stage of the work, and the completed fraction of that stage,
0 to 1."""

WAITING = "waiting"
"""Stage of a motion before any of its jobs has started."""

_SECONDS_BETWEEN_LOOKS = 0.1  # [s], time between two checks of whether a job is done
_log = logging.getLogger(__name__)
_one_at_a_time = Lock()

# The executor chosen by the caller, or the number of processes on this machine.
_chosen: ContextVar[Executor | int | None] = ContextVar("chosen", default=None)


@contextmanager
def using(
    workers: int | None = None, *, cluster: str | None = None, executor: Executor | None = None
) -> Iterator[None]:
    """Select the executor of long work inside the ``with``.

    Results do not depend on it. A script that uses more than one process needs the guard
    ``if __name__ == "__main__"``.

    Parameters
    ----------
    workers
        Number of processes of this machine.
    cluster
        Address of a Dask scheduler, such as ``tcp://node7:8786``, or a file with the address
        (``dask scheduler --scheduler-file``). Needs ``heyoka_bike[cluster]``.
    executor : concurrent.futures.Executor
        Any other executor. A thread pool runs one job at a time.

    Returns
    -------
    context manager
        Context manager; threads that are started inside are not affected.

    Raises
    ------
    InputError
        More than one argument is given, or no scheduler answers.
    VersionsDifferError
        A worker of the cluster has other versions than this process.
    MissingPackageError
        Dask is not installed.
    """
    given = [x for x in (workers, cluster, executor) if x is not None]
    if len(given) > 1:
        raise InputError("found two of --workers, --cluster and an executor, expected one")
    if workers is not None and workers < 1:
        raise InputError(f"--workers: found {workers}, expected 1 or more")
    connection: AbstractContextManager[Executor | None] = nullcontext(executor)
    if cluster is not None:
        from heyoka_bike.system.cluster import connected

        connection = connected(cluster)
    with connection as found:
        token = _chosen.set(workers if found is None else found)
        try:
            yield
        finally:
            _chosen.reset(token)


def run_job(work: Callable[..., Any], arguments: tuple[Any, ...]) -> Outcome:
    """Run a job, one at a time per process, because precision is a setting of the process."""
    with _one_at_a_time:
        start = time.process_time()
        value = work(*arguments, reporting.get())
        return Outcome(value, time.process_time() - start)


class InlineExecutor(Executor):
    """Executor that runs each call in the submitting process, during submission."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run a call at once."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as e:
            future.set_exception(e)
        return future


def _executor(count: int) -> AbstractContextManager[Executor]:
    """Return an executor for this many jobs; on this machine a single job runs in this process."""
    chosen = _chosen.get()
    if chosen is not None and not isinstance(chosen, int):
        return nullcontext(chosen)
    workers = min(chosen or processors(), count)
    return ProcessExecutor(workers) if workers > 1 else InlineExecutor()


def processors() -> int:
    """Return the number of processors that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


def side_by_side(
    work: Callable[..., T],
    jobs: Sequence[tuple[Any, ...]],
    motions: Sequence[tuple[str, float]] = (),
    progress: Progress | None = None,
    done: Callable[[int], None] = lambda count: None,
) -> list[T]:
    """Return ``[work(*job, report) for job in jobs]``, run in parallel.

    The first exception of a job ends the others and is raised.

    Parameters
    ----------
    work
        Called with a `OnStage` after its own arguments.
    motions
        Name and duration [s] of the motion of each job, if progress is reported.
    done
        Called with the number of ended jobs after each one.
    """
    named = motions or [("", 1.0)] * len(jobs)
    made = [Job(work, job, *motion) for job, motion in zip(jobs, named, strict=True)]
    found = all_of(made, progress if motions else None, done)
    return [found[job].value for job in made]


def all_of(
    jobs: Iterable[Job],
    progress: Progress | None = None,
    done: Callable[[int], None] = lambda count: None,
) -> dict[Job, Outcome]:
    """Return outcomes of jobs that must all succeed; see `carry_out` and `side_by_side`."""
    found: dict[Job, Outcome] = {}

    def ended(job: Job, outcome: Outcome) -> Iterable[Job]:
        outcome.get()
        found[job] = outcome
        done(len(found))
        return ()

    carry_out(jobs, ended, progress)
    return found


def carry_out(
    jobs: Iterable[Job],
    ended: Callable[[Job, Outcome], Iterable[Job]],
    progress: Progress | None = None,
    is_wanted: Callable[[Job], bool] = lambda job: True,
) -> None:
    """Run jobs, each as soon as the jobs that it needs have ended.

    Parameters
    ----------
    jobs
        Jobs in order of priority.
    ended
        Called with each job as it ends. Jobs that it returns are run too; an exception that it
        raises ends all jobs. An exception in a job becomes the outcome of that job and of those
        that need it.
    is_wanted
        Called before a job is started; unwanted jobs are skipped.
    """
    work = _Schedule(jobs, ended, progress, is_wanted)
    with _executor(len(work.waiting)) as executor:
        try:
            while work.waiting or work.running:
                work.begin(executor)
                if work.running:
                    work.wait()
        finally:
            for future in work.running:
                future.cancel()


class _Schedule:
    """Waiting jobs, running jobs, and outcomes that other jobs still need."""

    def __init__(
        self, jobs: Iterable[Job], ended: Callable[[Job, Outcome], Iterable[Job]],
        progress: Progress | None, is_wanted: Callable[[Job], bool],
    ) -> None:  # fmt: skip
        self.tell_ended, self.progress, self.is_wanted = ended, progress, is_wanted
        self.names: set[str] = set()
        self.waiting: list[Job] = []
        self.running: dict[Future[Outcome], Job] = {}
        # A queue is used because an interrupt inside `concurrent.futures.wait` would leave futures
        # locked.
        self.done: SimpleQueue[Future[Outcome]] = SimpleQueue()
        self.outcomes: dict[Job, Outcome] = {}
        self.add(jobs)

    def add(self, jobs: Iterable[Job]) -> None:
        for job in jobs:
            self.waiting.append(job)
            if job.name not in self.names:
                self.report(job, WAITING, 0.0)
            self.names.add(job.name)

    def report(self, job: Job, stage: str, t: float) -> None:
        if self.progress is not None:
            self.progress(job.name, stage, min(t / job.duration, 1.0))

    def begin(self, executor: Executor) -> None:
        """Start the jobs that can start, in order of priority."""
        self.waiting = list(filter(self.is_wanted, self.waiting))
        for job in list(self.waiting):
            needed = [x for x in job.arguments if isinstance(x, Job)]
            if any(x not in self.outcomes for x in needed):
                continue
            self.waiting.remove(job)
            failed = (self.outcomes[x] for x in needed if self.outcomes[x].error is not None)
            if (found := next(failed, None)) is not None:
                _log.info("%s: not started, because a job that it needs has failed", job.words)
                self.end(job, found)
            elif self.submit(executor, job).done():
                # The executor has already run this job. Handle its outcome before starting the next
                # job.
                return

    def submit(self, executor: Executor, job: Job) -> Future[Outcome]:
        arguments = tuple(
            self.outcomes[x].value if isinstance(x, Job) else x for x in job.arguments
        )
        _log.info("%s: started", job.words)
        token = reporting.set(partial(self.report, job))
        try:
            future = executor.submit(run_job, job.work, arguments)
        finally:
            reporting.reset(token)
        self.running[future] = job
        future.add_done_callback(self.done.put)
        return future

    def wait(self) -> None:
        """Wait for the end of a job, but only for a short time; forward progress."""
        try:
            over = self.done.get(timeout=_SECONDS_BETWEEN_LOOKS)
        except Empty:
            over = None
        for future, job in self.running.items():
            if isinstance(future, ProgressFuture) and future.progress is not None:
                progress, future.progress = future.progress, None
                self.report(job, *progress)
        if over is not None:
            self.finish(over)

    def finish(self, future: Future[Outcome]) -> None:
        job = self.running.pop(future)
        try:
            outcome = future.result()
        except BrokenExecutor:
            said = (
                f"{job.words}: its process ended every time: it ran out of memory, was killed, or "
                'the script lacks the guard if __name__ == "__main__"'
            )
            outcome = Outcome(None, error=WorkerLostError(said))
        except WorkerLostError:
            # If no worker could be started for this job, none can be started for another job.
            raise
        except Exception as e:
            e.add_note(f"in {job.words}")
            outcome = Outcome(None, error=e)
        how = "failed" if outcome.error else f"done, {outcome.seconds:.2f} s of processor time"
        _log.info("%s: %s", job.words, how)
        self.end(job, outcome)

    def end(self, job: Job, outcome: Outcome) -> None:
        self.outcomes[job] = outcome
        if outcome.error is None:
            for stage in job.stages:
                self.report(job, stage, job.duration)
        self.add(self.tell_ended(job, outcome))
        # Drop outcomes that no job needs any more.
        needed = {x for job in self.waiting for x in job.arguments if isinstance(x, Job)}
        self.outcomes = {x: o for x, o in self.outcomes.items() if x in needed}

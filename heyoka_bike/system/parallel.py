"""Long work as jobs, for processes of this machine, a cluster, or any other executor.

`using` says who carries jobs out; without it there are as many processes as processors. The results
are the same to the bit whoever does: one job at a time runs in a process.
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
"""Called with the name of a motion, a stage of the work, and the share of that stage that is done,
0 to 1."""

WAITING = "waiting"
"""Stage of a motion of which no job has begun."""

_SECONDS_BETWEEN_LOOKS = 0.1  # [s]
_log = logging.getLogger(__name__)
_one_at_a_time = Lock()

# An executor, or how many processes of this machine.
_chosen: ContextVar[Executor | int | None] = ContextVar("chosen", default=None)


@contextmanager
def using(
    workers: int | None = None, *, cluster: str | None = None, executor: Executor | None = None
) -> Iterator[None]:
    """Say who carries out long work inside the ``with``.

    Results do not depend on it. A script that uses more than one process has to guard itself by
    ``if __name__ == "__main__"``.

    Parameters
    ----------
    workers
        So many processes of this machine.
    cluster
        Address of a Dask scheduler, such as ``tcp://node7:8786``, or a file that says it
        (``dask scheduler --scheduler-file``). Needs ``heyoka_bike[cluster]``.
    executor : concurrent.futures.Executor
        Any other. Of a thread pool one job runs at a time.

    Returns
    -------
    context manager
        Threads that are started inside do not know of it.

    Raises
    ------
    InputError
        More than one of them is given, or no scheduler answers.
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
    """Carry out a job: precision is a setting of the whole process, so one at a time."""
    with _one_at_a_time:
        start = time.process_time()
        value = work(*arguments, reporting.get())
        return Outcome(value, time.process_time() - start)


class InlineExecutor(Executor):
    """Calls in the process that submits them: one is over when it is submitted."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Carry out a call."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as e:
            future.set_exception(e)
        return future


def _executor(count: int) -> AbstractContextManager[Executor]:
    """Who carries out so many jobs: of this machine, a single one runs in this process."""
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
    """``[work(*job, report) for job in jobs]``.

    The first exception of a job ends the others and is raised.

    Parameters
    ----------
    work
        Gets a `TellStage` after its own arguments.
    motions
        Name and duration [s] of the motion of each job, if its progress is asked for.
    done
        Called with how many have ended, as each one does.
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
    """Return outcomes of jobs that all have to succeed; see `carry_out` and `side_by_side`."""
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
    """Carry out jobs, each as soon as those that it needs have ended.

    Parameters
    ----------
    jobs
        The first ones first.
    ended
        Called with each job as it ends. What it returns is carried out too; an exception that it
        raises ends all. One that a job raised is its outcome, and of those that need it.
    is_wanted
        Asked before a job is begun; one that is not wanted any more is left out.
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
    """Jobs that wait, those that run, and outcomes that others still need."""

    def __init__(
        self, jobs: Iterable[Job], ended: Callable[[Job, Outcome], Iterable[Job]],
        progress: Progress | None, is_wanted: Callable[[Job], bool],
    ) -> None:  # fmt: skip
        self.tell_ended, self.progress, self.is_wanted = ended, progress, is_wanted
        self.names: set[str] = set()
        self.waiting: list[Job] = []
        self.running: dict[Future[Outcome], Job] = {}
        # Not `concurrent.futures.wait`: an interrupt in the middle of it leaves futures locked.
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
        """Begin what can begin, the first ones first."""
        self.waiting = list(filter(self.is_wanted, self.waiting))
        for job in list(self.waiting):
            needed = [x for x in job.arguments if isinstance(x, Job)]
            if any(x not in self.outcomes for x in needed):
                continue
            self.waiting.remove(job)
            failed = (self.outcomes[x] for x in needed if self.outcomes[x].error is not None)
            if (found := next(failed, None)) is not None:
                _log.info("%s: cannot be, as a job that it needs has failed", job.words)
                self.end(job, found)
            elif self.submit(executor, job).done():
                # An executor that works at once has ended it before the next is begun.
                return

    def submit(self, executor: Executor, job: Job) -> Future[Outcome]:
        arguments = tuple(
            self.outcomes[x].value if isinstance(x, Job) else x for x in job.arguments
        )
        _log.info("%s: begins", job.words)
        token = reporting.set(partial(self.report, job))
        try:
            future = executor.submit(run_job, job.work, arguments)
        finally:
            reporting.reset(token)
        self.running[future] = job
        future.add_done_callback(self.done.put)
        return future

    def wait(self) -> None:
        """Until a job is over, or for a moment; progress is passed on."""
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
                f"{job.words}: its process ended every time, out of memory, from outside, or "
                'as it read a script that begins this outside of: if __name__ == "__main__"'
            )
            outcome = Outcome(None, error=WorkerLostError(said))
        except WorkerLostError:
            # No other job has workers either.
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
        # Outcomes that no job needs any more are let go.
        needed = {x for job in self.waiting for x in job.arguments if isinstance(x, Job)}
        self.outcomes = {x: o for x, o in self.outcomes.items() if x in needed}

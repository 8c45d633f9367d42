"""Long work as jobs, for processes of this machine, a cluster, or any other executor.

`using` says who carries jobs out; without it there are as many processes as processors. The results
are the same to the bit whoever does: one job at a time runs in a process.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from typing import Any, TypeVar

from heyoka_bike.errors import InputError, WorkerLostError
from heyoka_bike.system.jobs import Crew, Hands, Job, Outcome
from heyoka_bike.system.processes import Given, Processes

T = TypeVar("T")
Progress = Callable[[str, str, float], None]
"""Called with the name of a motion, a stage of the work, and the share of that stage that is done,
0 to 1."""

WAITING = "waiting"
"""Stage of a motion of which no job has begun."""

_LOOK = 0.1  # [s]
_log = logging.getLogger(__name__)

_crew: ContextVar[Crew | None] = ContextVar("crew", default=None)


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
    crew: AbstractContextManager[Crew | None]
    if cluster is not None:
        from heyoka_bike.system.cluster import connected

        crew = connected(cluster)
    elif executor is not None:
        crew = nullcontext(Given(executor))
    else:
        crew = nullcontext(Processes(workers) if workers else None)
    with crew as chosen:
        token = _crew.set(chosen)
        try:
            yield
        finally:
            _crew.reset(token)


def processors() -> int:
    """How many this process may use."""
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
        Gets a `Report` after its own arguments.
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
    """What jobs gave that all have to succeed: see `carry_out` and `side_by_side`."""
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
) -> None:
    """Carry out jobs, each as soon as those that it needs have ended.

    Parameters
    ----------
    jobs
        The first ones first.
    ended
        Called with each job as it ends. What it returns is carried out too; an exception that it
        raises ends all. One that a job raised is its outcome, and of those that need it.
    """
    crew = _crew.get() or Processes(processors())
    work = _Work(jobs, ended, progress)
    with crew.at_work(len(work.jobs), work.told) as hands:
        while work.waiting or work.running:
            work.begin(hands)
            done, _ = wait(work.running, timeout=_LOOK, return_when=FIRST_COMPLETED)
            hands.look()
            for future in done:
                work.finish(hands, future)


class _Work:
    """What is left to do, what runs, and what has ended and is needed still."""

    def __init__(
        self, jobs: Iterable[Job], ended: Callable[[Job, Outcome], Iterable[Job]],
        progress: Progress | None,
    ) -> None:  # fmt: skip
        self.tell_ended, self.progress = ended, progress
        self.jobs: list[Job] = []
        self.names: set[str] = set()
        self.tries: list[int] = []
        self.waiting: list[int] = []
        self.running: dict[Future[Any], int] = {}
        self.outcomes: dict[Job, Outcome] = {}
        self.add(jobs)

    def add(self, jobs: Iterable[Job]) -> None:
        for job in jobs:
            self.waiting.append(len(self.jobs))
            self.jobs.append(job)
            self.tries.append(0)
            if self.progress is not None and job.name not in self.names:
                self.progress(job.name, WAITING, 0.0)
            self.names.add(job.name)

    def told(self, i: int, stage: str, t: float) -> None:
        if self.progress is not None:
            job = self.jobs[i]
            self.progress(job.name, stage, min(t / job.duration, 1.0))

    def begin(self, hands: Hands) -> None:
        """Begin what can begin, the first ones first."""
        for i in list(self.waiting):
            if not hands.free():
                return
            job = self.jobs[i]
            needed = [x for x in job.arguments if isinstance(x, Job)]
            if any(x not in self.outcomes for x in needed):
                continue
            self.waiting.remove(i)
            failed = (self.outcomes[x] for x in needed if self.outcomes[x].error is not None)
            found = next(failed, None)
            if found is None and job.kept is not None:
                found = job.kept.get()
            if found is None:
                self.submit(hands, i)
            else:
                _log.info("%s: is there from before, or cannot be", job.words)
                self.end(job, found)

    def submit(self, hands: Hands, i: int) -> None:
        job = self.jobs[i]
        arguments = tuple(
            self.outcomes[x].value if isinstance(x, Job) else x for x in job.arguments
        )
        self.tries[i] += 1
        _log.info("%s: begins", job.words)
        self.running[hands.submit(i, job.work, arguments)] = i

    def finish(self, hands: Hands, future: Future[Any]) -> None:
        i = self.running.pop(future)
        job = self.jobs[i]
        try:
            outcome: Outcome = future.result()
        except Exception as e:
            if not hands.is_lost(e):
                e.add_note(f"in {job.words}")
                outcome = Outcome(None, error=e)
            elif self.tries[i] < hands.tries:
                _log.info("%s: its process ended", job.words)
                self.submit(hands, i)
                return
            else:
                said = (
                    f"{job.words}: its process ended every time, out of memory, from outside, or "
                    'as it read a script that begins this outside of: if __name__ == "__main__"'
                )
                outcome = Outcome(None, error=WorkerLostError(said))
        if outcome.error is None and job.kept is not None:
            job.kept.put(outcome)
        how = "failed" if outcome.error else f"done, {outcome.seconds:.2f} s of processor time"
        _log.info("%s: %s", job.words, how)
        self.end(job, outcome)

    def end(self, job: Job, outcome: Outcome) -> None:
        self.outcomes[job] = outcome
        if self.progress is not None and outcome.error is None:
            for stage in job.stages:
                self.progress(job.name, stage, 1.0)
        self.add(self.tell_ended(job, outcome))
        # What nothing needs any more is let go, but for what is resubmitted if it is lost.
        left = (*self.waiting, *self.running.values())
        needed = {x for i in left for x in self.jobs[i].arguments if isinstance(x, Job)}
        self.outcomes = {x: o for x, o in self.outcomes.items() if x in needed}

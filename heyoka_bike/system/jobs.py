"""Jobs, and who may carry them out."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import AbstractContextManager
from dataclasses import dataclass
from threading import Lock
from typing import Any, Protocol

Report = Callable[[str, float], None]
"""Called by a job with its stage, and the time that it has reached in the motion [s]."""

Told = Callable[[int, str, float], None]
"""Called with the number of a job, its stage and the time that it has reached [s]."""

_one_at_a_time = Lock()


class Kept(Protocol):
    """A place for the result of one job, which outlives the run."""

    def get(self) -> Outcome | None:
        """What is there, if anything is."""

    def put(self, outcome: Outcome) -> None:
        """Keep it."""


@dataclass(frozen=True, eq=False, slots=True)
class Job:
    """A piece of work that depends on nothing but its arguments.

    Attributes
    ----------
    work
        A function of a module. It gets a `Report` after its own arguments.
    arguments
        Another job among them stands for its result.
    name
        Of the motion that it is about.
    duration
        Of that motion [s], for its progress.
    stages
        Those that are over when it is.
    kept : Kept or None
        Where its result is looked for, and put.
    """

    work: Callable[..., Any]
    arguments: tuple[Any, ...]
    name: str = ""
    duration: float = 1.0
    stages: tuple[str, ...] = ()
    kept: Kept | None = None

    @property
    def words(self) -> str:
        """The job in words."""
        name = self.work.__name__.lstrip("_").replace("_", " ")
        return f"{name} of {self.name}" if self.name else name


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a job ended.

    Attributes
    ----------
    value
        What it gave.
    seconds : float
        Processor time that it took [s].
    error : Exception or None
        Why there is no value.
    """

    value: Any
    seconds: float = 0.0
    error: Exception | None = None

    def get(self) -> Any:
        """The value; raises the error instead, if there is one."""
        if self.error is not None:
            raise self.error
        return self.value


class Hands(Protocol):
    """Where jobs run now.

    Attributes
    ----------
    tries : int
        How often a job is begun whose worker is lost.
    """

    tries: int

    def free(self) -> bool:
        """Whether one more job can be taken."""

    def submit(self, i: int, work: Callable[..., Any], arguments: tuple[Any, ...]) -> Future[Any]:
        """Begin job number `i`, as `carried_out` does it."""

    def look(self) -> None:
        """Pass on what jobs have told since, and see which have ended."""

    def is_lost(self, error: Exception) -> bool:
        """Whether this says that a worker ended, and nothing about its job."""


class Crew(Protocol):
    """Who carries out jobs."""

    def at_work(self, count: int, told: Told) -> AbstractContextManager[Hands]:
        """For so many jobs; where an exception is raised, what was begun is ended."""


def carried_out(work: Callable[..., Any], arguments: tuple[Any, ...], report: Report) -> Outcome:
    """A job, where it runs: precision is a setting of the whole process, so one at a time."""
    with _one_at_a_time:
        start = time.process_time()
        value = work(*arguments, report)
        return Outcome(value, time.process_time() - start)

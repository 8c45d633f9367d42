"""Jobs: work that depends on its arguments alone, for any executor of `concurrent.futures`."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass
from threading import Lock
from typing import Any

from heyoka_bike.system.unfinished import KeptResult

Report = Callable[[str, float], None]
"""Called by a job with its stage, and the time that it has reached in the motion [s]."""

reporting: ContextVar[Report] = ContextVar("reporting", default=lambda stage, t: None)
"""Receiver of a job's progress; an executor that can pass it on sets it in its workers."""

_INTERVAL = 0.1  # [s]
_one_at_a_time = Lock()


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
    cache : KeptResult or None
        Where its result is kept, which outlives the run.
    """

    work: Callable[..., Any]
    arguments: tuple[Any, ...]
    name: str = ""
    duration: float = 1.0
    stages: tuple[str, ...] = ()
    cache: KeptResult | None = None

    @property
    def words(self) -> str:
        """The job in words."""
        name = self.work.__name__.lstrip("_").replace("_", " ")
        return f"{name} of {self.name}" if self.name else name

    def load(self) -> Outcome | None:
        """The result that was kept, if there is one."""
        kept = None if self.cache is None else self.cache.load()
        return None if kept is None else Outcome(*kept)

    def store(self, outcome: Outcome) -> None:
        """Keep a result."""
        if self.cache is not None:
            self.cache.store((outcome.value, outcome.seconds))


@dataclass(frozen=True, slots=True)
class Outcome:
    """End of a job: its value or its error.

    Attributes
    ----------
    value
        The result.
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


def run_job(work: Callable[..., Any], arguments: tuple[Any, ...]) -> Outcome:
    """Carry out a job: precision is a setting of the whole process, so one at a time."""
    with _one_at_a_time:
        start = time.process_time()
        value = work(*arguments, reporting.get())
        return Outcome(value, time.process_time() - start)


class Throttle:
    """A report that passes on each new stage, and ten times a second at most how far it is."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._last, self._at = "", 0.0

    def __call__(self, stage: str, t: float) -> None:
        now = time.monotonic()
        if stage != self._last or now > self._at + _INTERVAL:
            self._last, self._at = stage, now
            self._report(stage, t)

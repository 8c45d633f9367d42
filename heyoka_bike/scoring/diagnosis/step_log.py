"""Logging of the steps of a diagnosis, for `heyoka-bike diagnose -v`."""

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import e, log10

from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis

_log = logging.getLogger(__name__)
# Factor that converts natural to decimal logarithms.
_DECADES = log10(e)


@dataclass(frozen=True, slots=True)
class Step:
    """A step of a diagnosis.

    Attributes
    ----------
    name
    question
        The question that the step answers.
    """

    name: str
    question: str


@dataclass(slots=True)
class StepLog:
    """The log entry of a step in progress.

    Attributes
    ----------
    found : callable
        Returns the result in a few words. It is called at the end of the step, if logging is on.
    """

    found: Callable[[], str] = lambda: "nothing"


@contextmanager
def logged(step: Step) -> Iterator[StepLog]:
    """Log the question, the result and the duration of a step, even if it ends early."""
    begun, entry = time.process_time(), StepLog()
    try:
        yield entry
    finally:
        if _log.isEnabledFor(logging.INFO):
            seconds = time.process_time() - begun
            _log.info("%s: %s %s (%.2f s)", step.name, step.question, entry.found(), seconds)


def in_words(h: Hypothesis | None) -> str:
    """Describe the likeliest cause, its odds, and the largest error that it leaves, in scales."""
    if h is None:
        return "no likely cause"
    left, where = max(((x, place) for place, x in h.after.items()), default=(0.0, (0, "")))
    return (
        f"likeliest {' and '.join(h.codes)}, odds 10^{h.log_odds * _DECADES:.0f}, "
        f"largest remaining error {left:.1e} in {where[0]}.{where[1]}"
    )

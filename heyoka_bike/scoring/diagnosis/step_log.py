"""What each step of a diagnosis did, told to those who follow it with `heyoka-bike diagnose -v`."""

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import e, log10

from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis

_log = logging.getLogger(__name__)
# Decimal logarithms in a natural one.
_DECADES = log10(e)


@dataclass(frozen=True, slots=True)
class Step:
    """A step of a diagnosis.

    Attributes
    ----------
    name
    question
        What it asks.
    """

    name: str
    question: str


@dataclass(slots=True)
class StepLog:
    """A step that is being logged.

    Attributes
    ----------
    found : callable
        What it found, in a few words; asked for at its end, if somebody follows.
    """

    found: Callable[[], str] = lambda: "nothing"


@contextmanager
def logged(step: Step) -> Iterator[StepLog]:
    """Tell what a step asks and finds and how long it takes, also one that is ended early."""
    begun, told = time.process_time(), StepLog()
    try:
        yield told
    finally:
        if _log.isEnabledFor(logging.INFO):
            seconds = time.process_time() - begun
            _log.info("%s: %s %s (%.2f s)", step.name, step.question, told.found(), seconds)


def in_words(h: Hypothesis | None) -> str:
    """The likeliest cause, its odds against none and what it leaves at most, in scales."""
    if h is None:
        return "none is likelier than none of them"
    left, where = max(((x, place) for place, x in h.after.items()), default=(0.0, (0, "")))
    return (
        f"likeliest {' and '.join(h.codes)}, odds 10^{h.log_odds * _DECADES:.0f}, "
        f"leaves {left:.1e} of {where[0]}.{where[1]}"
    )

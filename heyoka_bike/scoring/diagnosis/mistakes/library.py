"""The library of usual mistakes, each as a change of a program.

Each mistake changes a `Program`: the bicycle's parameters, the initial conditions, or the output.
`apply` makes several mistakes together. Mistakes that are read off a file, such as columns in
another order, are in `proposals`.
"""

from collections.abc import Sequence

import numpy as np

from heyoka_bike.bicycle.parameters import benchmark
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.mistakes.in_axes import AXES_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.in_model import MODEL_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.in_output import OUTPUT_MISTAKES, misspaced
from heyoka_bike.scoring.diagnosis.mistakes.in_start import START_MISTAKES, misplaced
from heyoka_bike.scoring.diagnosis.mistakes.linearised import LINEAR_PROGRAMS
from heyoka_bike.scoring.diagnosis.programs.program import Cause, Mistake, Program, apply

__all__ = ["MISTAKES", "Mistake", "Program", "apply", "in_order", "mistakes_of"]

KINDS = ("model", "start", "output")
MANEUVERS = len(benchmark()[1])
"""Number of maneuvers of the benchmark."""

_OF_ANY_BENCHMARK: tuple[Mistake, ...] = (
    *MODEL_MISTAKES, *AXES_MISTAKES, *START_MISTAKES, *OUTPUT_MISTAKES, *LINEAR_PROGRAMS,
)  # fmt: skip


def mistakes_of(numbers: tuple[int, ...], times: Array, duration: float) -> tuple[Mistake, ...]:
    """Return the library for maneuvers with these numbers, times of rows, and duration [s]."""
    return (*_OF_ANY_BENCHMARK, *misplaced(numbers), *misspaced(times, duration))


def _of_the_benchmark() -> tuple[Mistake, ...]:
    _, maneuvers = benchmark()
    numbers = tuple(range(1, len(maneuvers) + 1))
    steps, duration = maneuvers[0].rows - 1, float(maneuvers[0].duration)
    times = np.arange(steps + 1) * duration / steps
    # Add the mistakes that files without the last row may contain.
    return (*mistakes_of(numbers, times, duration), *misspaced(times[:-1], duration))


MISTAKES: tuple[Mistake, ...] = _of_the_benchmark()
"""The library for the maneuvers of the benchmark, in no particular order."""

_PLACE_IN_LIBRARY = {m.code: i for i, m in enumerate(MISTAKES)}


def in_order(mistakes: Sequence[Cause]) -> tuple[Cause, ...]:
    """Sort the causes of one program: first the model, then initial conditions, then output."""
    return tuple(
        sorted(mistakes, key=lambda m: (KINDS.index(m.kind), _PLACE_IN_LIBRARY.get(m.code, 0)))
    )

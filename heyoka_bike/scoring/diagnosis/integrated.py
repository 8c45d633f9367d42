"""Which integrator makes a file's error: usual ones are run, and what they leave is compared.

A method leaves an error that grows with its step h as h^p, as long as it is small. So each method
is run once, with a step from row to row, and the factor by which its error has to be multiplied
tells the step. With that step it is run again. The state is that of the reduced equations: roll,
steer, their rates and the rolling rate. In other coordinates the same method leaves another error,
and is not recognised.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil

import numpy as np

from heyoka_bike.numbers.double import SMALL_STEP, Array
from heyoka_bike.scoring.diagnosis.budget import Deadline
from heyoka_bike.scoring.diagnosis.programs.integrators import METHODS, Carried, FixedStep
from heyoka_bike.scoring.diagnosis.programs.program import Columns, NumericalMethod
from heyoka_bike.scoring.diagnosis.programs.simulator import AskedMotion, Simulator
from heyoka_bike.scoring.diagnosis.residual.fits import SPLIT
from heyoka_bike.scoring.diagnosis.residual.linear_fits import blocks, solve
from heyoka_bike.scoring.diagnosis.residual.methods import step_of_rows
from heyoka_bike.scoring.ratios import BY_FAR

CARRIED = 1e-12
"""What a thousand carried errors are good to, in sizes of columns: each is to 1e-13."""

# Errors are carried from row to row over times not longer than this [s], by one step of RK4: the
# fastest mode of the benchmark falls by e^-0.4 in it, which that has to 1e-4.
_LONGEST = 0.02
# Rows of a maneuver at which errors are carried; between them they lie on lines.
ROWS_FOLLOWED = 2001
# Rows are those of equal steps if they are off by less than this part of one.
_EQUAL = 1e-6
# Steps from row to row that are made: with more, the method's error is that of a few, scaled.
_MOST_STEPS = 10
# Methods that are run again with the step that was found.
_RUN_AGAIN = 3


@dataclass(frozen=True, eq=False)
class Run:
    """A maneuver as integrators follow it.

    Attributes
    ----------
    simulator : Simulator
    motion : AskedMotion
        The right one, at the rows that are compared.
    spacing
        Of the file's rows [s].
    errors : mapping of str to ndarray, shape (m,)
        By name of the column, of the rows that are compared [SI].
    sizes : mapping of str to float
        Of the columns [SI].
    floors : mapping of str to float
        What cannot be seen of their errors, in parts of the size.
    """

    simulator: Simulator
    motion: AskedMotion
    spacing: float
    errors: Columns
    sizes: Mapping[str, float]
    floors: Mapping[str, float]

    @cached_property
    def carried(self) -> Carried:
        """Errors of methods along the right motion, at rows not too far apart and not too many."""
        count = round(float(self.motion.time[-1]) / self.spacing)
        each = ceil(self.spacing / _LONGEST) if self.spacing > _LONGEST else 1
        together = ceil(count / ROWS_FOLLOWED)
        grid = self.spacing / each * together
        time = np.arange(ceil(count * each / together) + 1) * grid
        end = float(self.motion.time[-1])
        return Carried(*self.simulator.followed(self.motion, np.minimum(time, end)), grid)

    @cached_property
    def _slopes(self) -> Columns:
        """Derivatives of the columns by the state, shape (7, m), by name."""
        size = len(self.motion.time)
        each = [np.repeat(SMALL_STEP * np.eye(7)[:, [k]], size, axis=1) for k in range(7)]
        found = self.simulator.differences(self.motion, each)
        return {name: np.array([x[name] / SMALL_STEP for x in found]) for name in self.errors}

    def _errors(self, method: FixedStep, steps: int) -> Array:
        """What so many steps from one carried row to the next leave, at the rows compared."""
        errors = self.carried.errors(method, steps)
        time = np.arange(errors.shape[1]) * self.carried.spacing
        return np.array([np.interp(self.motion.time, time, e) for e in errors])

    def terms(self, method: FixedStep, steps: int) -> Columns:
        """The same of the columns whose errors are known, to first order [SI]."""
        errors = self._errors(method, steps)
        return {name: np.sum(slopes * errors, axis=0) for name, slopes in self._slopes.items()}

    def off(self, method: FixedStep, steps: int, factor: float) -> Columns:
        """The same times a factor, of all columns, by name [SI]."""
        (found,) = self.simulator.differences(self.motion, [factor * self._errors(method, steps)])
        return found


@dataclass(frozen=True, eq=False, slots=True)
class Integrated:
    """A method that leaves the error.

    Attributes
    ----------
    cause : NumericalMethod
    off : tuple of mapping of str to ndarray
        The columns of each run, less the right ones [SI].
    """

    cause: NumericalMethod
    off: tuple[Columns, ...]


def are_equal_steps(time: Array, spacing: float) -> bool:
    """True of rows that are a whole number of times some spacing from the start [s]."""
    if spacing <= 0.0:
        return False
    steps = time / spacing
    return bool(np.max(np.abs(steps - np.round(steps)), initial=0.0) < _EQUAL * len(time))


def integrated(runs: Sequence[Run], deadline: Deadline) -> Iterator[Integrated]:
    """Yield methods that leave the errors of all runs, with their steps.

    Raises
    ------
    BudgetSpentError
        The time is spent.
    """
    first = []
    for method in METHODS:
        deadline.check()
        factor, gain = _fit(runs, method, 1)
        if factor > 0.0 and np.isfinite(factor):
            first.append((gain, method, factor))
    first.sort(key=lambda x: -x[0])
    for _, method, factor in first[:_RUN_AGAIN]:
        deadline.check()
        steps = min(max(round(factor ** (-1.0 / method.order)), 1), _MOST_STEPS)
        factor, gain = _fit(runs, method, steps)
        if gain < BY_FAR or factor <= 0.0:
            continue
        step = step_of_rows(
            runs[0].carried.spacing / steps * factor ** (1.0 / method.order),
            runs[0].spacing,
            gain,
        )
        if step is None:
            # No program takes steps between which its rows lie.
            continue
        says = f"{method.says} with a step of {step:.3g} s"
        code = f"integrator_{method.code}"
        cause = NumericalMethod(code, says, "the step", "method", lambda p: p, method.says, step)
        yield Integrated(cause, tuple(run.off(method, steps, factor) for run in runs))


def _fit(runs: Sequence[Run], method: FixedStep, steps: int) -> tuple[float, float]:
    """The factor of a method's error that leaves least, and by how much that lets it fall."""
    errors, terms, floors = [], [], []
    for run in runs:
        off = run.terms(method, steps)
        for name, written in run.errors.items():
            split = min(SPLIT, len(written))
            errors += np.array_split(written / run.sizes[name], split)
            terms += np.array_split(off[name] / run.sizes[name], split)
            floors += [run.floors[name]] * split
    if not all(np.isfinite(x).all() for x in terms):
        return 0.0, 1.0
    b = blocks(errors, [t[:, None] for t in terms], floors)
    changes, gains = solve(b, np.array([[0]]))
    return float(changes[0, 0]), float(gains[0])

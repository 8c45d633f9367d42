"""Which integrator makes a file's error: usual ones are run, and what they leave is compared.

A method leaves an error that grows with its step h as h^p, as long as it is small. So the error of
each method with a step from row to row is carried along the right motion, and the factor by which
it has to be multiplied tells the step. Of the nearest methods the error with that step is carried,
and where rows and steps agree they are run from the start. The state is that of the reduced
equations: roll, steer, their rates and the rolling rate. In other coordinates the same method
leaves another error, and is recognised less well.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from math import ceil, log
from statistics import fmean

import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.double import SMALL_STEP, Array
from heyoka_bike.scoring.diagnosis.budget import Deadline
from heyoka_bike.scoring.diagnosis.programs.integrators import (
    METHODS,
    Carried,
    FixedStep,
    evaluations,
    steps_made,
)
from heyoka_bike.scoring.diagnosis.programs.program import NumericalMethod
from heyoka_bike.scoring.diagnosis.programs.simulator import MotionRequest, Simulator
from heyoka_bike.scoring.diagnosis.residual.linear_fits import best_multiple, blocks
from heyoka_bike.scoring.diagnosis.residual.methods import step_of_rows
from heyoka_bike.scoring.grades import TOLERANCE
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.recognition import FASTEST_MODE
from heyoka_bike.scoring.rows.edits import Columns

CARRIED = 1e-12
"""What a thousand carried errors are good to, in sizes of columns: each is to 1e-13."""

# Errors are carried from row to row over times not longer than this [s], by one step of RK4: the
# fastest mode of the benchmark falls by e^-0.5 in it, which that has to 3e-4.
_LONGEST = FASTEST_MODE / 2
# Rows of a maneuver at which errors are carried; between them they lie on lines.
ROWS_FOLLOWED = 2001
# Steps from row to row, or rows from step to step: with more, the method's error is that of a few,
# scaled.
_MOST_STEPS = 10
# Methods that are run from the start, each with at most so many evaluations of the equations.
_RUN, _EVALUATIONS = 3, 12000


@dataclass(frozen=True, eq=False)
class Run:
    """A maneuver as integrators follow it.

    Attributes
    ----------
    simulator : Simulator
    motion : MotionRequest
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
    motion: MotionRequest
    spacing: float
    errors: Columns
    sizes: Mapping[str, float]
    floors: Mapping[str, float]

    @property
    def rows(self) -> int:
        """Carried rows from one row of the file to the next."""
        return ceil(self.spacing / _LONGEST - TOLERANCE)

    @cached_property
    def carried(self) -> Carried:
        """Errors of methods along the right motion, at rows not too far apart and not too many."""
        count = round(float(self.motion.time[-1]) / self.spacing)
        together = ceil(count / ROWS_FOLLOWED)
        grid = self.spacing / self.rows * together
        time = np.arange(ceil(count * self.rows / together) + 1) * grid
        end = float(self.motion.time[-1])
        return Carried(*self.simulator.followed(self.motion, np.minimum(time, end)), grid)

    @cached_property
    def _slopes(self) -> Columns:
        """Derivatives of the columns by the state, shape (7, m), by name."""
        size = len(self.motion.time)
        each = [np.repeat(SMALL_STEP * np.eye(7)[:, [k]], size, axis=1) for k in range(7)]
        found = self.simulator.differences(self.motion, each)
        return {name: np.array([x[name] / SMALL_STEP for x in found]) for name in self.errors}

    def _errors(self, method: FixedStep, steps: int, rows: int) -> Array:
        """What so many steps over so many carried rows leave, at the rows compared."""
        return self._at_rows(self.carried.errors(method, steps, rows), self.carried.spacing)

    def _at_rows(self, errors: Array, spacing: float) -> Array:
        time = np.arange(errors.shape[1]) * spacing
        return np.array([np.interp(self.motion.time, time, e) for e in errors])

    def terms(self, method: FixedStep, steps: int, rows: int) -> Columns:
        """The same of the columns whose errors are known, to first order [SI]."""
        errors = self._errors(method, steps, rows)
        return {name: np.sum(slopes * errors, axis=0) for name, slopes in self._slopes.items()}

    def off(self, method: FixedStep, steps: int, rows: int, factor: float) -> Columns:
        """The same times a factor, of all columns, by name [SI]."""
        return self._columns(factor * self._errors(method, steps, rows))

    def of_states(self, states: Array, step: float) -> Columns:
        """What states after each step, shape (7, n), differ in from the right ones, by name."""
        time = np.arange(states.shape[1]) * step
        inside = time < float(self.motion.time[-1]) + step
        end = np.minimum(time[inside], float(self.motion.time[-1]))
        _, right = self.simulator.followed(self.motion, end)
        return self._columns(self._at_rows(states[:, inside] - right, step))

    def start(self) -> tuple[Equations, Array]:
        """The equations and the state at the start, shape (7, 1)."""
        return self.simulator.followed(self.motion, np.zeros(1))

    def _columns(self, errors: Array) -> Columns:
        (found,) = self.simulator.differences(self.motion, [errors])
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


@dataclass(frozen=True, slots=True)
class _Fit:
    """A method whose error, times a factor, is nearest to a file's.

    Attributes
    ----------
    method : FixedStep
    steps, rows
        So many steps are made over so many carried rows.
    factor
        Zero if none is.
    gain
        By so much the error falls with it.
    step
        That makes an error larger by the factor [s].
    """

    method: FixedStep
    steps: int
    rows: int
    factor: float
    gain: float
    step: float


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
        first.append(_fit(runs, method, 1, runs[0].rows))
    nearest = _likeliest(first)[:_RUN]
    found = _likeliest([_fit(runs, x.method, *_steps_over_rows(runs[0], x.step)) for x in nearest])
    for fit in found:
        deadline.check()
        step = step_of_rows(fit.step, runs[0].spacing, fit.gain)
        # No program takes steps between which its rows lie.
        if step is None or fit.gain < max(CLEARLY, found[0].gain / CLEARLY):
            continue
        method = fit.method
        says = f"{method.says} with a step of {step:.3g} s"
        code = f"integrator_{method.code}"
        cause = NumericalMethod(code, says, "the step", "method", lambda p: p, method.says, step)
        carried = tuple(run.off(method, fit.steps, fit.rows, fit.factor) for run in runs)
        made = _made(runs, method, step)
        nearer = min(filter(None, (carried, made)), key=partial(_left, runs))
        yield Integrated(cause, nearer)


def _likeliest(fits: Iterable[_Fit]) -> list[_Fit]:
    """Those that are of some step, the likeliest first."""
    return sorted((x for x in fits if x.factor > 0.0), key=lambda x: -x.gain)


def _steps_over_rows(run: Run, step: float) -> tuple[int, int]:
    """How many steps are nearest to one over how many carried rows; one of both is one."""
    apart = run.carried.spacing / step
    steps, rows = (min(max(round(x), 1), _MOST_STEPS) for x in (apart, 1.0 / apart))
    return steps, rows


def _made(runs: Sequence[Run], method: FixedStep, step: float) -> tuple[Columns, ...]:
    """What the method leaves that is run from the start, by name [SI]; empty if that is long."""
    starts = [run.start() for run in runs]
    equations, start = starts[0][0], np.concatenate([y for _, y in starts], axis=1)
    count = ceil(max(float(run.motion.time[-1]) for run in runs) / step - TOLERANCE)
    if count * evaluations(method, equations, start, step) > _EVALUATIONS:
        return ()
    states = steps_made(method, equations, start, step, count)
    return tuple(run.of_states(y, step) for run, y in zip(runs, states.swapaxes(0, 1), strict=True))


def _left(runs: Sequence[Run], off: Sequence[Columns]) -> float:
    """Mean of the logarithms of what such differences leave of the errors."""
    logs = [
        log(max(rms(written - made[name]) / run.sizes[name], run.floors[name]))
        for run, made in zip(runs, off, strict=True)
        for name, written in run.errors.items()
    ]
    return fmean(logs)


def _fit(runs: Sequence[Run], method: FixedStep, steps: int, rows: int) -> _Fit:
    """The multiple of a method's error that leaves least."""
    errors, terms, floors = [], [], []
    for run in runs:
        off = run.terms(method, steps, rows)
        for name, written in run.errors.items():
            errors.append(written / run.sizes[name])
            terms.append(off[name] / run.sizes[name])
            floors.append(run.floors[name])
    # Of a method that blows up squares overflow.
    with np.errstate(over="ignore", invalid="ignore"):
        made = blocks(errors, [t[:, None] for t in terms], floors)
    if not np.isfinite(made.products).all():
        return _Fit(method, steps, rows, 0.0, 1.0, 0.0)
    factor, gain = best_multiple(made)
    length = runs[0].carried.spacing * rows / steps * max(factor, 0.0) ** (1.0 / method.order)
    return _Fit(method, steps, rows, factor, gain, length)

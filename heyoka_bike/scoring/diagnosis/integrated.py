"""Recognise the integrator by its error: usual methods are run, and their errors are compared.

A small error of a method of order p grows with its step h as h^p. So the error of each method, with
a step from row to row, is propagated along the exact motion. The factor that fits it to the file's
error gives the step of the file. For the nearest methods the error with that step is propagated; if
it is large and this takes few evaluations, they are also run from the start. If nothing explains a
larger error, methods of low order are run from the start with a step from row to row.

The state is that of the reduced equations: roll, steer, their rates and the rolling rate. In other
coordinates the same method makes a different error, and is recognised less reliably.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
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
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, TOLERANCE
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.recognition import FASTEST_MODE
from heyoka_bike.scoring.rows.edits import Columns

CARRIED = 1e-12
"""Accuracy of a thousand propagated errors, relative to the size of the column; each adds 1e-13."""

# Longest time over which one step of RK4 propagates an error [s]. In this time the fastest mode of
# the benchmark decays to e^-0.5 of its size. One step computes this decay with an error of 3e-4.
_LONGEST = FASTEST_MODE / 2
# Maximum number of rows of a maneuver at which errors are propagated. Between these rows the errors
# are interpolated linearly.
ROWS_FOLLOWED = 2001
# Maximum number of steps per row, or of rows per step. With more steps or rows, the error has the
# same shape.
_MOST_STEPS = 10
# Number of methods that are run from the initial conditions, and maximum number of evaluations of
# the equations for each method.
_RUN, _EVALUATIONS = 3, 12000
# Highest order of the methods that are run with a step from row to row, and maximum number of
# evaluations for each. With the same step, methods of higher order make errors that are small
# enough to be propagated. Implicit methods are run if rows are far apart.
_LOW_ORDER, _EVALUATIONS_OF_ROWS = 2, 3000
# The nonlinear part of a method's error is at most this many times the square of the error, if both
# are relative to the motion: 9.3 for six methods with steps of 0.5 to 20 ms in all maneuvers.
_NONLINEAR = 10.0
# The beginning of a run is this part of it.
_PARTS_OF_RUN = 4


@dataclass(frozen=True, eq=False)
class Run:
    """A maneuver, with the errors of the file, for the comparison with integrators.

    Attributes
    ----------
    simulator : Simulator
    motion : MotionRequest
        The exact motion, at the rows that are compared.
    spacing
        Distance of the file's rows [s].
    errors : mapping of str to ndarray, shape (m,)
        Errors of the file at these rows, by name of the column [SI].
    sizes : mapping of str to float
        Scales of the columns [SI].
    floors : mapping of str to float
        Resolution limits of the errors, relative to the scales.
    """

    simulator: Simulator
    motion: MotionRequest
    spacing: float
    errors: Columns
    sizes: Mapping[str, float]
    floors: Mapping[str, float]

    def until(self, end: float) -> Run:
        """Return the run up to a time [s]."""
        rows = self.motion.time <= end
        errors = {name: error[rows] for name, error in self.errors.items()}
        return replace(
            self, motion=replace(self.motion, time=self.motion.time[rows]), errors=errors
        )

    @property
    def rows(self) -> int:
        """Number of propagation steps from one row of the file to the next, at least 1."""
        return max(ceil(self.spacing / _LONGEST - TOLERANCE), 1)

    @cached_property
    def carried(self) -> Carried:
        """Propagation of errors along the exact motion, at a suitable number of rows."""
        count = round(float(self.motion.time[-1]) / self.spacing)
        together = ceil(count / ROWS_FOLLOWED)
        grid = self.spacing / self.rows * together
        time = np.arange(ceil(count * self.rows / together) + 1) * grid
        end = float(self.motion.time[-1])
        return Carried(*self.simulator.followed(self.motion, np.minimum(time, end)), grid)

    @cached_property
    def _slopes(self) -> Columns:
        """Derivatives of the columns with respect to the state, shape (7, m), by name."""
        size = len(self.motion.time)
        each = [np.repeat(SMALL_STEP * np.eye(7)[:, [k]], size, axis=1) for k in range(7)]
        found = self.simulator.differences(self.motion, each)
        return {name: np.array([x[name] / SMALL_STEP for x in found]) for name in self.errors}

    def _errors(self, method: FixedStep, steps: int, rows: int) -> Array:
        """Return the error of the state with `steps` steps per `rows` rows, at compared rows."""
        return self._at_rows(self.carried.errors(method, steps, rows), self.carried.spacing)

    def _at_rows(self, errors: Array, spacing: float) -> Array:
        time = np.arange(errors.shape[1]) * spacing
        return np.array([np.interp(self.motion.time, time, e) for e in errors])

    def terms(self, method: FixedStep, steps: int, rows: int) -> Columns:
        """Return the errors of a method in the compared columns, to first order [SI]."""
        errors = self._errors(method, steps, rows)
        return {name: np.sum(slopes * errors, axis=0) for name, slopes in self._slopes.items()}

    def off(self, method: FixedStep, steps: int, rows: int, factor: float) -> Columns:
        """Return the errors of a method, times a factor, in all columns, by name [SI]."""
        return self._columns(factor * self._errors(method, steps, rows))

    def of_states(self, states: Array, step: float) -> Columns:
        """Return the errors of all columns, by name, from the states after each step (7, n)."""
        time = np.arange(states.shape[1]) * step
        inside = time < float(self.motion.time[-1]) + step
        end = np.minimum(time[inside], float(self.motion.time[-1]))
        _, right = self.simulator.followed(self.motion, end)
        return self._columns(self._at_rows(states[:, inside] - right, step))

    def start(self) -> tuple[Equations, Array]:
        """Return the equations of the exact motion and its initial state, shape (7, 1)."""
        return self.simulator.followed(self.motion, np.zeros(1))

    def _columns(self, errors: Array) -> Columns:
        (found,) = self.simulator.differences(self.motion, [errors])
        return found


@dataclass(frozen=True, eq=False, slots=True)
class Integrated:
    """An integration method whose error resembles the error of the file.

    Attributes
    ----------
    cause : NumericalMethod
    off : tuple of mapping of str to ndarray
        Errors of the columns with this method, for each run [SI].
    """

    cause: NumericalMethod
    off: tuple[Columns, ...]


@dataclass(frozen=True, slots=True)
class _Fit:
    """The error of a method, scaled to fit the file's error.

    Attributes
    ----------
    method : FixedStep
    steps, rows
        The method makes `steps` steps per `rows` propagation rows.
    factor
        Factor of the error; zero if no factor fits.
    gain
        Factor by which the file's error falls if the scaled error is subtracted.
    step
        Step with which the method makes the scaled error [s].
    """

    method: FixedStep
    steps: int
    rows: int
    factor: float
    gain: float
    step: float


def integrated(runs: Sequence[Run], deadline: Deadline) -> Iterator[Integrated]:
    """Yield methods, with their steps, whose errors resemble those of all runs.

    Raises
    ------
    BudgetSpentError
        The time limit is reached.
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
        # The row distance must be a multiple or a fraction of the step. Otherwise the program would
        # have to interpolate its rows, and no program interpolates in the way assumed here.
        if step is None or fit.gain < max(CLEARLY, found[0].gain / CLEARLY):
            continue
        carried = tuple(run.off(fit.method, fit.steps, fit.rows, fit.factor) for run in runs)
        made = () if _is_of_first_order(runs, fit.gain) else _made(runs, fit.method, step)
        nearer = min(filter(None, (carried, made)), key=partial(_left, runs))
        yield Integrated(_cause(fit.method, step), nearer)


def with_steps_of_rows(runs: Sequence[Run], deadline: Deadline) -> Iterator[Integrated]:
    """Yield methods of low order whose runs, with a step from row to row, resemble the file.

    They are run from the start. The error of a large step grows faster than a power of the step, so
    `integrated` does not recognise it. A method that explains the run also explains its beginning,
    so only such methods are run to the end.

    Raises
    ------
    BudgetSpentError
        The time limit is reached.
    """
    step = runs[0].spacing
    begun = [run.until(float(run.motion.time[-1]) / _PARTS_OF_RUN) for run in runs]
    if any(len(run.motion.time) < MIN_ROWS_FOR_SHAPE for run in begun):
        # The beginnings have too few rows, so use all of them.
        begun = [*runs]
    low, most = [x for x in METHODS if x.order <= _LOW_ORDER], _EVALUATIONS_OF_ROWS
    methods = [x for _, x, _ in _resembling(begun, low, most // _PARTS_OF_RUN, deadline)]
    found = _resembling(runs, methods, most, deadline)
    least = max([log(CLEARLY), *(gain - log(CLEARLY) for gain, *_ in found)])
    for gain, method, made in sorted(found, key=lambda x: -x[0]):
        if gain > least:
            yield Integrated(_cause(method, step), made)


def _resembling(
    runs: Sequence[Run], methods: Iterable[FixedStep], most: int, deadline: Deadline
) -> list[tuple[float, FixedStep, tuple[Columns, ...]]]:
    """Run methods with a step from row to row; return those that reduce the error tenfold.

    The result has the logarithm of this factor, the method and its errors for each run [SI]. `most`
    is the largest number of evaluations of the equations for each method.
    """
    before = _left(runs, [{name: np.zeros(1) for name in run.errors} for run in runs])
    found = []
    for method in methods:
        deadline.check()
        made = _made(runs, method, runs[0].spacing, most)
        if made and (gain := before - _left(runs, made)) > log(CLEARLY):
            found.append((gain, method, made))
    return found


def _cause(method: FixedStep, step: float) -> NumericalMethod:
    """Return the cause that a program integrates by a method with a step [s]."""
    says = f"{method.says} with a step of {step:.3g} s"
    code = f"integrator_{method.code}"
    return NumericalMethod(code, says, "the step", "method", lambda p: p, method.says, step)


def _likeliest(fits: Iterable[_Fit]) -> list[_Fit]:
    """Return the fits with a positive factor, best first."""
    return sorted((x for x in fits if x.factor > 0.0), key=lambda x: -x.gain)


def _steps_over_rows(run: Run, step: float) -> tuple[int, int]:
    """Return a number of steps and a number of propagation rows that take about the same time.

    One of both numbers is 1; `step` is the length of a step [s].
    """
    apart = run.carried.spacing / step
    steps, rows = (min(max(round(x), 1), _MOST_STEPS) for x in (apart, 1.0 / apart))
    return steps, rows


def _made(
    runs: Sequence[Run], method: FixedStep, step: float, most: int = _EVALUATIONS
) -> tuple[Columns, ...]:
    """Return the errors of a method run from the start [SI]; empty if the run takes too long.

    `most` is the largest number of evaluations of the equations.
    """
    starts = [run.start() for run in runs]
    equations, start = starts[0][0], np.concatenate([y for _, y in starts], axis=1)
    count = ceil(max(float(run.motion.time[-1]) for run in runs) / step - TOLERANCE)
    if count * evaluations(method, equations, start, step) > most:
        return ()
    states = steps_made(method, equations, start, step, count)
    return tuple(run.of_states(y, step) for run, y in zip(runs, states.swapaxes(0, 1), strict=True))


def _is_of_first_order(runs: Sequence[Run], gain: float) -> bool:
    """True if a run of a method would show nothing that its error of first order does not show.

    This is so if the first-order error leaves far more of the file's error than the nonlinear part
    of the method's error could explain. `gain` is the factor by which it reduces the file's error.
    """
    error = max(rms(x) / run.sizes[name] for run in runs for name, x in run.errors.items())
    return CLEARLY * _NONLINEAR * error < 1.0 / gain


def _left(runs: Sequence[Run], off: Sequence[Columns]) -> float:
    """Return the mean logarithm of the file's errors after those of the method are subtracted."""
    logs = [
        log(max(rms(written - made[name]) / run.sizes[name], run.floors[name]))
        for run, made in zip(runs, off, strict=True)
        for name, written in run.errors.items()
    ]
    return fmean(logs)


def _fit(runs: Sequence[Run], method: FixedStep, steps: int, rows: int) -> _Fit:
    """Fit a multiple of a method's error to the file's error."""
    errors, terms, floors = [], [], []
    for run in runs:
        off = run.terms(method, steps, rows)
        for name, written in run.errors.items():
            errors.append(written / run.sizes[name])
            terms.append(off[name] / run.sizes[name])
            floors.append(run.floors[name])
    # If a method becomes unstable, the squares of its errors overflow.
    with np.errstate(over="ignore", invalid="ignore"):
        made = blocks(errors, [t[:, None] for t in terms], floors)
    if not np.isfinite(made.products).all():
        return _Fit(method, steps, rows, 0.0, 1.0, 0.0)
    factor, gain = best_multiple(made)
    length = runs[0].carried.spacing * rows / steps * max(factor, 0.0) ** (1.0 / method.order)
    return _Fit(method, steps, rows, factor, gain, length)

"""Simulate the benchmark as fast as possible in binary64, including all columns.

``simulate()`` returns the 25 columns of the three maneuvers, ``simulate(2)`` the nine of one. One
compiled function takes the steps and evaluates dense output and columns, see `step_code`. For
accuracies beyond binary64 use `integrate`, which also makes the reference.

The accuracies were measured on the three maneuvers and on 20 other starts of the benchmark bicycle,
see ``docs/speed.md``; for other bicycles they are an indication.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, partial
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver, benchmark
from heyoka_bike.errors import InputError, SingularMotionError, unknown_word
from heyoka_bike.motion.integrate import LEAST_TRAIL, TrailTooSmallError
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.double import Array, with_usual_errors
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.workbench.fast.step_code import RUN, run_source
from heyoka_bike.workbench.fast.vector_code import (
    ADDRESS,
    COUNT,
    MOST_STEPS,
    NUMBER,
    STATE_SIZE,
    function,
)

Maneuvers = int | Maneuver | Sequence[Maneuver] | None
_Parameters = tuple[tuple[str, Exact], ...]  # parameters of a bicycle: their symbols and values

ACCURACIES: Mapping[str | float, float] = {
    "eq1": 3e-5,
    1e-4: 1e-5,
    1e-6: 1e-7,
    1e-8: 2e-9,
    1e-10: 5e-12,
    1e-12: 1e-13,
    1e-13: 3e-14,
    "roundoff": 3e-15,
}
"""Step tolerance that achieves each accuracy in the three maneuvers and 20 other starts. ``eq1``
means eq. (1) below 1e-3 percent; a number is the largest error of roll and steer angle [rad], their
rates [rad/s] and the speed [m/s] over 10 s."""

_BITS_OF_START = 256  # number of bits in which the initial state is computed
_Byte, _Report = ctypes.c_char, ctypes.c_double * 5
_ARGUMENTS_OF_RUN = COUNT, ADDRESS, COUNT, ADDRESS, NUMBER, COUNT, ADDRESS, ADDRESS, ADDRESS
_LEAST_ROWS, _MOST_ROWS_OF_RUN = 2, 1_000_001
_RUNS_KEPT = 32  # maximum number of prepared runs in the cache
# The relative drift of the energy may be at most the larger of `_LARGEST_DRIFT` times the tolerance
# and `_ROUNDING`. If the drift is larger, the tolerance is multiplied by `_SHARPER`, but not below
# `_LEAST_TOLERANCE`. The usual drift is 0.2 times the tolerance, plus roundoff. A step over a
# singularity changes the energy by a large fraction.
_LARGEST_DRIFT, _ROUNDING, _SHARPER, _LEAST_TOLERANCE = 10.0, 1e-11, 1e-2, 1e-13


@dataclass(frozen=True, slots=True)
class Solution:
    """The columns of a motion at its rows, and facts about its integration.

    Attributes
    ----------
    columns : ndarray, shape (8, rows)
        The columns of the benchmark, SI units.
    steps
        Number of steps; negative for a motion that cannot be continued.
    time
        The time reached [s].
    least_trail, largest_trail
        Extremes over the rows of the mechanical trail / front wheel radius.
    least_energy, largest_energy
        Extremes over the rows of the mechanical energy [J].
    """

    columns: Array
    steps: int
    time: float
    least_trail: float
    largest_trail: float
    least_energy: float
    largest_energy: float


def _motion(run: Any, start: Array, times: Array, tolerance: float) -> Callable[..., Solution]:
    """Return a function that integrates a motion from time 0 through ascending times.

    Parameters
    ----------
    run
        Compiled function, see `_code`.
    start : ndarray, shape (6,)
    times : ndarray, shape (rows,)
        [s]
    tolerance
        Tolerance of a step: about the error of the state within it.

    Returns
    -------
    callable
        It returns a `Solution`; its optional argument, shape (6, rows), receives the states.
    """
    # A run takes about ten microseconds, and `ndarray.ctypes` takes one microsecond to return an
    # address. So the addresses of fixed arrays are read only once, and the address of the result
    # comes from its buffer.
    given = start.ctypes.data, len(times), times.ctypes.data, tolerance, MOST_STEPS
    return partial(_carry_out, run, (start, times), given)


def _carry_out(
    run: Any, arrays: tuple[Array, Array], given: tuple[Any, ...], states: Array | None = None
) -> Solution:
    columns, report = np.empty((len(BENCHMARK_COLUMNS), len(arrays[1]))), _Report()
    steps = run(
        *given, ctypes.byref(_Byte.from_buffer(columns.data)),
        None if states is None else states.ctypes.data, report,
    )  # fmt: skip
    return Solution(columns, steps, *report)


@dataclass(frozen=True, repr=False, slots=True)
class Simulation:
    """The rows that were computed for one or several maneuvers.

    Attributes
    ----------
    time : ndarray, shape (rows,)
        Times of the rows [s].
    values : ndarray, shape (maneuvers, 8, rows)
        The columns of `columns.BENCHMARK_COLUMNS`, SI units.
    """

    time: Array
    values: Array

    def __repr__(self) -> str:
        count = f"{len(self.values)} maneuver{'s' if len(self.values) != 1 else ''}"
        return f"<simulation of {count}: {len(self.time)} rows to {self.time[-1]:g} s>"

    def _repr_html_(self) -> str:
        """Show the first and last rows of each maneuver in notebooks; fold several maneuvers."""
        from heyoka_bike.reference.values import Values
        from heyoka_bike.showing.document import Block, Chapter, head
        from heyoka_bike.showing.document.html import piece
        from heyoka_bike.showing.views import table

        shown: list[Block] = list(head(repr(self).strip("<>")))
        for i, columns in enumerate(self.values, start=1):
            values = Values(dict(zip(BENCHMARK_COLUMNS, columns, strict=True)), {}, time=self.time)
            rows = table(values, len(BENCHMARK_COLUMNS), "Rows")
            is_one = len(self.values) == 1
            shown.append(rows if is_one else Chapter(f"Maneuver {i}", (rows,), is_folded=True))
        return piece(shown)

    def __getitem__(self, name: str) -> Array:
        """Return a column by name: shape (rows,) for one maneuver, else (maneuvers, rows)."""
        if name not in BENCHMARK_COLUMNS:
            raise KeyError(unknown_word(name, BENCHMARK_COLUMNS, "column "))
        found: Array = self.values[:, BENCHMARK_COLUMNS.index(name)]
        return found[0] if len(found) == 1 else found

    def table(self) -> Array:
        """Return the benchmark's result file, shape (rows, 1 + 8 maneuvers): time first."""
        return np.vstack([self.time, *self.values]).T


@with_usual_errors
def simulate(
    maneuvers: Maneuvers = None, *, bicycle: Bicycle | None = None,
    accuracy: str | float = 1e-12, rows: int | None = None,
    spacing: Fraction | float | str | None = None,
) -> Simulation:  # fmt: skip
    """Compute the columns of one or several maneuvers, fast.

    Parameters
    ----------
    maneuvers
        One maneuver, several of equal duration, or the number of one of the benchmark's; by default
        the benchmark's three.
    bicycle : Bicycle
        The bicycle; by default the benchmark's.
    accuracy
        The largest error wanted (at least 1e-13), ``roundoff``, or ``eq1``, which is fastest and
        just satisfies eq. (1); see `ACCURACIES`.
    rows, spacing
        Number of rows, or time between them [s]; by default those of the maneuvers.

    Returns
    -------
    Simulation
        SI units; angles and rates are positive to the right, see `columns`.

    Raises
    ------
    InputError
        Something given cannot be used.
    SingularMotionError
        A motion meets a singularity before its end.
    MissingPackageError
        llvmlite is not installed.
    """
    values = None if bicycle is None else tuple(bicycle.values.items())
    chosen = tuple(maneuvers) if isinstance(maneuvers, Sequence) else maneuvers
    return _prepared(chosen, values, accuracy, rows, spacing)()


@lru_cache(_RUNS_KEPT)
def _prepared(
    maneuvers: Maneuvers, values: _Parameters | None, accuracy: str | float, rows: int | None,
    spacing: Fraction | float | str | None,
) -> Prepared:  # fmt: skip
    bicycle = None if values is None else Bicycle("bicycle", dict(values))
    return prepare(maneuvers, bicycle=bicycle, accuracy=accuracy, rows=rows, spacing=spacing)


def prepare(
    maneuvers: Maneuvers = None, *, bicycle: Bicycle | None = None,
    accuracy: str | float = 1e-12, rows: int | None = None,
    spacing: Fraction | float | str | None = None, tolerance: float | None = None,
) -> Prepared:  # fmt: skip
    """Return a simulation to be called repeatedly; see `simulate` for the parameters.

    This compiles the code and computes the initial states. `tolerance`, if given, replaces the step
    tolerance of the accuracy.
    """
    chosen = _maneuvers(maneuvers)
    times = _times(chosen, rows, spacing)
    tolerance = tolerance or ACCURACIES[choose(accuracy, ACCURACIES)]
    return Prepared(bicycle or benchmark()[0], chosen, tolerance, times)


class Prepared:
    """Compiled code and initial states of maneuvers; a call integrates them.

    Attributes
    ----------
    times : ndarray, shape (rows,)
        Times of the rows [s].
    steps
        Number of steps of each motion in the last call.
    """

    def __init__(
        self, bicycle: Bicycle, maneuvers: Sequence[Maneuver], tolerance: float, times: Array
    ) -> None:
        self.bicycle, self.maneuvers = bicycle, maneuvers
        self.tolerance, self.times = tolerance, times
        self.steps: tuple[int, ...] = ()
        self._prepare(is_regular=False)

    def __call__(self) -> Simulation:
        """Integrate all maneuvers, and return their columns."""
        try:
            found = self._solutions()
        except TrailTooSmallError:
            self._prepare(is_regular=True)
            found = self._solutions()
        self.steps = tuple(x.steps for x in found)
        # A single maneuver needs no copy of its columns.
        columns = [x.columns for x in found]
        return Simulation(self.times, columns[0][None] if len(found) == 1 else np.array(columns))

    def states(self) -> Array:
        """Return the states at the rows, shape (maneuvers, rows, 6).

        Their variables are those of the form of the equations that the last call used.
        """
        found = np.empty((len(self._motions), STATE_SIZE, len(self.times)))
        for motion, states in zip(self._motions, found, strict=True):
            motion(states)
        return found.transpose(0, 2, 1)

    def _prepare(self, *, is_regular: bool) -> None:
        self._is_regular = is_regular
        self._run = _code(tuple(self.bicycle.values.items()), is_regular)
        equations = Equations.of(self.bicycle, Balls(_BITS_OF_START), is_regular=is_regular)
        states = [initial_state(equations, m)[:STATE_SIZE] for m in self.maneuvers]
        self._starts = [np.array([float(x.mid()) for x in state]) for state in states]
        self._motions = [_motion(self._run, x, self.times, self.tolerance) for x in self._starts]

    def _solutions(self) -> list[Solution]:
        found = []
        for motion, start in zip(self._motions, self._starts, strict=True):
            x, tolerance = motion(), self.tolerance
            # If the energy changes, the motion has stepped over a singularity. Repeat it with a
            # smaller tolerance.
            while x.largest_energy - x.least_energy > x.largest_energy * max(
                _LARGEST_DRIFT * tolerance, _ROUNDING
            ):
                tolerance *= _SHARPER
                if tolerance < _LEAST_TOLERANCE:
                    raise _singular("before", x)
                x = _motion(self._run, start, self.times, tolerance)()
            # The equations with few products divide by the mechanical trail. If it is small or
            # changes its sign, the regular form has to be used.
            is_clear = x.least_trail > LEAST_TRAIL or x.largest_trail < -LEAST_TRAIL
            if not self._is_regular and not (x.steps > 0 and is_clear):
                raise TrailTooSmallError
            if x.steps < 0:
                raise _singular("at", x)
            found.append(x)
        return found


def _singular(place: str, x: Solution) -> SingularMotionError:
    return SingularMotionError(f"the motion meets a singularity {place} t = {x.time:.9g} s", x.time)


@lru_cache(_RUNS_KEPT)
def _code(values: _Parameters, is_regular: bool) -> Any:
    """Return compiled code for motions of a bicycle, see `step_code`; threads may share it."""
    equations = Equations.binary64(Bicycle("bicycle", dict(values)), is_regular=is_regular)
    return function(run_source(equations), RUN, *_ARGUMENTS_OF_RUN)


def _maneuvers(given: Maneuvers) -> tuple[Maneuver, ...]:
    if isinstance(given, Maneuver):
        return (given,)
    if isinstance(given, Sequence):
        if not given:
            raise InputError("found no maneuver, expected one or more")
        return tuple(given)
    published = benchmark()[1]
    if given is None:
        return published
    if not 1 <= given <= len(published):
        raise InputError(f"found maneuver {given}, expected 1 to {len(published)}")
    return (published[given - 1],)


def _times(
    maneuvers: Sequence[Maneuver], rows: int | None, spacing: Fraction | float | str | None
) -> Array:
    """Return the times of the rows, correctly rounded [s]."""
    duration = maneuvers[0].duration
    if any(m.duration != duration for m in maneuvers):
        raise InputError("found maneuvers of different durations, expected equal durations")
    if rows is not None and spacing is not None:
        raise InputError("found both rows and spacing, expected one of them")
    if rows is not None:
        if rows < _LEAST_ROWS:
            raise InputError(f"found {rows} rows, expected {_LEAST_ROWS} or more")
        step = duration / (rows - 1)
    elif spacing is not None:
        step = Fraction(str(spacing))
        if not 0 < step <= duration:
            raise InputError(f"found spacing {spacing} s, expected more than 0, up to {duration} s")
    else:
        step = maneuvers[0].spacing
        if any(m.spacing != step for m in maneuvers):
            raise InputError(
                "found maneuvers of different spacings, expected equal spacings, or the argument "
                "rows"
            )
    count = int(duration / step) + 1
    if count > _MOST_ROWS_OF_RUN:
        raise InputError(f"found {count} rows, expected {_MOST_ROWS_OF_RUN} or fewer")
    times = np.array([i * step.numerator / step.denominator for i in range(count)])
    times.flags.writeable = False
    return times


def choose(accuracy: str | float, measured: Iterable[str | float]) -> str | float:
    """Return the loosest of the measured accuracies that is at least as accurate as requested.

    Raises
    ------
    InputError
        No measured accuracy is small enough.
    """
    known = list(measured)
    if accuracy in known:
        return accuracy
    if not isinstance(accuracy, str):
        passing = [x for x in known if not isinstance(x, str) and x <= accuracy]
        if passing:
            return max(passing)
    raise InputError(
        f"found accuracy {accuracy}, expected 'eq1', 'roundoff' or a number of 1e-13 or more; for "
        "smaller errors, use integrate()"
    )

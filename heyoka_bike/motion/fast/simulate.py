"""The benchmark as fast as possible in binary64, all columns included.

``simulate()`` gives the 25 columns of the three maneuvers, ``simulate(2)`` the nine of one. Code is
compiled for the bicycle once and kept on the disk (see `compiled_cache`); the maneuvers are stepped
together, each in its own part of the processor's vectors. `integrate` is what the reference is made
with, and for accuracies beyond binary64.

How accurate a run is was measured on the three maneuvers and on 20 other starts of the benchmark
bicycle, see ``docs/speed.md``; for other bicycles it is an indication.
"""

from __future__ import annotations

import io
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, lru_cache
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.initial import start_state
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver, read_bicycle, read_maneuvers
from heyoka_bike.errors import InputError, SingularMotionError
from heyoka_bike.motion.expressions import require_heyoka
from heyoka_bike.motion.fast.taylor_code import (
    CLOCK,
    NORM,
    STATE,
    TICK,
    Form,
    TaylorCode,
    taylor_code,
)
from heyoka_bike.numbers.double import Array
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers

Maneuvers = int | Maneuver | Sequence[Maneuver] | None


@dataclass(frozen=True, slots=True)
class Plan:
    """Order and norm of the Taylor steps, see `taylor_code`; the norm is no less than the speed."""

    order: int
    norm: float


ACCURACIES: Mapping[str | float, Plan] = {
    "eq1": Plan(6, 16.0),
    1e-4: Plan(8, 100.0),
    1e-6: Plan(10, 50.0),
    1e-8: Plan(12, 28.0),
    1e-10: Plan(15, 28.0),
    1e-12: Plan(17, 16.0),
    1e-13: Plan(19, 16.0),
    "roundoff": Plan(19, 16.0),
}
"""For each accuracy the fastest plan found that keeps it in the three maneuvers and 20 other
starts: ``eq1`` means eq. (1) under 1e-3 percent, a number the largest error of roll and steer angle
[rad], their rates [rad/s] and the speed [m/s] over 10 s."""

_BITS = 256  # for the initial state
_MOST_STEPS = 200_000  # of one run; the coefficients of a step take up to a kilobyte
_LEAST_ROWS, _MOST_ROWS = 2, 1_000_001
_KEPT = 32  # prepared runs
_LANES = 4  # the three maneuvers and one idle
_CHUNK = 2048  # rows evaluated at once; their coefficients stay in the second level of the cache
# Of the front wheel radius; below it the regular form takes over, as in `integration`.
_MIN_TRAIL = 0.02


@dataclass(frozen=True, slots=True)
class Simulation:
    """Rows of one maneuver or several.

    Attributes
    ----------
    time : ndarray, shape (rows,)
        [s]
    values : ndarray, shape (maneuvers, 8, rows)
        The columns of `columns.BENCHMARK_COLUMNS`, SI units.
    """

    time: Array
    values: Array

    def __getitem__(self, name: str) -> Array:
        """A column by name: shape (rows,) for one maneuver, else (maneuvers, rows)."""
        found: Array = self.values[:, BENCHMARK_COLUMNS.index(name)]
        return found[0] if len(found) == 1 else found

    def table(self) -> Array:
        """As in the benchmark's result file, shape (rows, 1 + 8 maneuvers): the time goes first."""
        return np.vstack([self.time, *self.values]).T


def simulate(
    maneuvers: Maneuvers = None, *, bicycle: Bicycle | None = None,
    accuracy: str | float = "eq1", rows: int | None = None,
    spacing: Fraction | float | str | None = None,
) -> Simulation:  # fmt: skip
    """The columns of one maneuver or several, fast.

    Parameters
    ----------
    maneuvers
        One, several of equal duration, or the number of one of the benchmark's; by default its
        three.
    bicycle : Bicycle
        By default the benchmark's.
    accuracy
        ``eq1``, ``roundoff`` or the largest error wanted, 1e-13 or more; see `ACCURACIES`.
    rows, spacing
        Number of rows, or time between them [s]; by default as the maneuvers say.

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
        heyoka is not installed.
    """
    values = None if bicycle is None else tuple(bicycle.values.items())
    chosen = tuple(maneuvers) if isinstance(maneuvers, Sequence) else maneuvers
    key = (chosen, values, accuracy, rows, spacing)
    run = _PREPARED.pop(key, None)
    if run is None:
        run = prepare(maneuvers, bicycle=bicycle, accuracy=accuracy, rows=rows, spacing=spacing)
    # The last one used is the last one to go.
    _PREPARED[key] = run
    while len(_PREPARED) > _KEPT:
        _PREPARED.pop(next(iter(_PREPARED)), None)
    return run()


_PREPARED: dict[Hashable, Prepared] = {}


def prepare(
    maneuvers: Maneuvers = None, *, bicycle: Bicycle | None = None,
    accuracy: str | float | Plan = "eq1", rows: int | None = None,
    spacing: Fraction | float | str | None = None,
) -> Prepared:  # fmt: skip
    """A run that is ready to be called, again and again; see `simulate` for the parameters.

    Compiles, and finds the initial states. A `Plan` for an accuracy is taken as it is.
    """
    chosen = _maneuvers(maneuvers)
    times = _times(chosen, rows, spacing)
    return Prepared(bicycle or _benchmark()[0], chosen, choose_plan(accuracy), times)


class Prepared:
    """Motions from their start to their end.

    Attributes
    ----------
    times : ndarray, shape (rows,)
        [s]
    """

    def __init__(
        self, bicycle: Bicycle, maneuvers: Sequence[Maneuver], plan: Plan, times: Array
    ) -> None:
        self.bicycle, self.maneuvers, self.plan, self.times = bicycle, maneuvers, plan, times
        self._taken: list[_Steps] = []
        self._prepare(is_regular=False)

    def __call__(self) -> Simulation:
        """Integrate and evaluate the columns."""
        try:
            found = self._rows()
        except _TrailTooSmallError:
            self._prepare(is_regular=True)
            found = self._rows()
        return Simulation(self.times, found)

    @property
    def steps(self) -> tuple[int, ...]:
        """How many each motion took, in the last call."""
        return tuple(x.count for x in self._taken)

    def states(self) -> Array:
        """States at the rows in the variables of the form used, shape (maneuvers, rows, 6)."""
        found = []
        for group in self._groups:
            for steps in self._integrate(group):
                local = steps.at(self.times)
                width = self.plan.order + 1
                coefficients, s = local[:-1].reshape(STATE, width, -1), local[-1]
                value = coefficients[:, -1]
                for j in range(width - 2, -1, -1):
                    value = value * s + coefficients[:, j]
                found.append(value.T)
        return np.array(found)

    def _prepare(self, *, is_regular: bool) -> None:
        starts = np.array([_start(self.bicycle, m, is_regular) for m in self.maneuvers])
        lanes = 1 if len(starts) == 1 else _LANES
        form = Form(self.plan.order, lanes, is_regular)
        self._code = _code(_Values(self.bicycle), form)
        self._groups = [starts[i : i + lanes] for i in range(0, len(starts), lanes)]

    def _rows(self) -> Array:
        """Columns of all motions, shape (maneuvers, 8, rows)."""
        n = len(self.times)
        found: list[Array] = []
        taken: list[_Steps] = []
        for group in self._groups:
            for steps in self._integrate(group):
                parts = [
                    self._code.columns(steps.at(self.times[begin : begin + _CHUNK]))
                    for begin in range(0, n, _CHUNK)
                ]
                rows = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
                self._check_trail(rows[-1])
                found.append(rows[:-1])
                taken.append(steps)
        self._taken = taken
        return found[0][None] if len(found) == 1 else np.array(found)

    def _integrate(self, starts: Array) -> list[_Steps]:
        """Steps of a group of motions."""
        code, end = self._code, float(self.times[-1])
        ta, lanes = code.integrator, code.form.lanes
        kept = io.BytesIO()
        write = kept.write
        with code.lock:
            _set(ta, starts, self.plan.norm, lanes)
            tc = ta.tc
            # What is written is more than zero bytes, which tells heyoka to go on.
            outcome = ta.propagate_until(
                end, write_tc=True, callback=lambda _: write(tc), max_steps=_MOST_STEPS
            )
            results = [outcome] if lanes == 1 else ta.propagate_res
            for lane, result in enumerate(results[: len(starts)]):
                if result[0] != _time_limit():
                    raise self._stopped(lane)
        shape = (-1, STATE + 2, code.form.order + 1, lanes)
        coefficients = np.frombuffer(kept.getbuffer()).reshape(shape)
        return [_Steps(coefficients[..., lane]) for lane in range(len(starts))]

    def _check_trail(self, trail: Array) -> None:
        """Leave the few-product form where the mechanical trail is small or changes sign."""
        is_small = not (trail.min() > _MIN_TRAIL or trail.max() < -_MIN_TRAIL)
        if is_small and not self._code.form.is_regular:
            raise _TrailTooSmallError

    def _stopped(self, lane: int) -> Exception:
        """Why a motion did not get to its end."""
        code = self._code
        if not code.form.is_regular:
            return _TrailTooSmallError()
        time = float(np.atleast_1d(code.integrator.time)[lane])
        return SingularMotionError(f"the motion meets a singularity at t = {time:.9g} s", time)


@dataclass(frozen=True, slots=True)
class _Steps:
    """The steps of a motion: coefficients, shape (steps, variables, order + 1)."""

    coefficients: Array

    @property
    def count(self) -> int:
        """How many there are; lanes that are done are stepped on by nothing."""
        begins = self.coefficients[:, CLOCK, 0]
        return 1 + int(np.count_nonzero(begins[1:] > begins[:-1]))

    def at(self, times: Array) -> Array:
        """For each time the coefficients of its step, and the time since that step began."""
        steps, _, width = self.coefficients.shape
        table = np.empty((STATE * width + 1, steps))
        table[:-1] = self.coefficients[:, :STATE].reshape(steps, -1).T
        table[-1] = begins = self.coefficients[:, CLOCK, 0] * TICK
        first = times.searchsorted(begins)
        counts = np.empty_like(first)
        np.subtract(first[1:], first[:-1], out=counts[:-1])
        counts[-1] = len(times) - first[-1]
        found: Array = table.repeat(counts, axis=1)
        np.subtract(times, found[-1], out=found[-1])
        return found


class _TrailTooSmallError(Exception):
    """Raised to leave the few-product form."""


def _set(ta: Any, starts: Array, norm: float, lanes: int) -> None:
    """Put motions at their starts; idle lanes follow the first."""
    state = ta.state
    if lanes == 1:
        ta.time = 0.0
        state[:STATE] = starts[0]
    else:
        ta.set_time(0.0)
        state[:STATE, : len(starts)] = starts.T
        state[:STATE, len(starts) :] = starts[:1].T
    state[CLOCK] = 0.0
    state[NORM] = norm


def _start(bicycle: Bicycle, maneuver: Maneuver, is_regular: bool) -> list[float]:
    state = start_state(bicycle, maneuver, _BITS, is_regular=is_regular)
    return [float(x.mid()) for x in state]


class _Values:
    """A bicycle that is equal to another of the same parameters."""

    def __init__(self, bicycle: Bicycle) -> None:
        self.bicycle = bicycle
        self.values = tuple(sorted((s, str(x)) for s, x in bicycle.values.items()))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Values) and self.values == other.values

    def __hash__(self) -> int:
        return hash(self.values)


@lru_cache(_KEPT)
def _code(values: _Values, form: Form) -> TaylorCode:
    return taylor_code(values.bicycle, form)


@cache
def _time_limit() -> Any:
    """What heyoka returns of a motion that got to its end."""
    return require_heyoka().taylor_outcome.time_limit


@cache
def _benchmark() -> tuple[Bicycle, tuple[Maneuver, ...]]:
    return read_bicycle(benchmark_bicycle()), read_maneuvers(benchmark_maneuvers())


def _maneuvers(given: Maneuvers) -> tuple[Maneuver, ...]:
    if isinstance(given, Maneuver):
        return (given,)
    if isinstance(given, Sequence):
        if not given:
            raise InputError("found no maneuver, expected one or more")
        return tuple(given)
    published = _benchmark()[1]
    if given is None:
        return published
    if not 1 <= given <= len(published):
        raise InputError(f"found maneuver {given}, expected 1 to {len(published)}")
    return (published[given - 1],)


def choose_plan(accuracy: str | float | Plan) -> Plan:
    """The plan of an accuracy, see `ACCURACIES`."""
    if isinstance(accuracy, Plan):
        return accuracy
    if accuracy in ACCURACIES:
        return ACCURACIES[accuracy]
    if not isinstance(accuracy, str):
        passing = [x for x in ACCURACIES if not isinstance(x, str) and x <= accuracy]
        if passing:
            return ACCURACIES[max(passing, key=float)]
    raise InputError(
        f"found accuracy {accuracy}, expected 'eq1', 'roundoff' or a number of 1e-13 or more; "
        "integrate() goes further"
    )


def _times(
    maneuvers: Sequence[Maneuver], rows: int | None, spacing: Fraction | float | str | None
) -> Array:
    """Times of the rows, correctly rounded [s]."""
    duration = maneuvers[0].duration
    if any(m.duration != duration for m in maneuvers):
        raise InputError("found maneuvers of different durations, expected equal ones")
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
            raise InputError("found maneuvers of different spacings, expected equal ones or rows")
    count = int(duration / step) + 1
    if count > _MOST_ROWS:
        raise InputError(f"found {count} rows, expected {_MOST_ROWS} or fewer")
    times = np.array([i * step.numerator / step.denominator for i in range(count)])
    times.flags.writeable = False
    return times

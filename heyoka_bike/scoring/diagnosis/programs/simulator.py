"""Simulation of any bicycle in binary64, for many programs at once, with NumPy only.

On each of many equal intervals the state is a polynomial that satisfies the equations at Gauss
points (collocation). The order is twice as high at the ends of the intervals. Fast modes are
damped, so no small steps are needed. Each variable, and each constant of the equations, is an array
with an entry for each motion. The state of the regular form is roll, pitch, steer, roll rate, steer
rate, the rear wheel's rolling rate and yaw.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, lru_cache

import numpy as np
from numpy.polynomial.chebyshev import chebint, chebvander
from numpy.polynomial.legendre import leggauss

from heyoka_bike.bicycle.equations.bodies import Points
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, read_bicycle
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.numbers.double import SMALL_STEP, Array
from heyoka_bike.numbers.vectors import plus
from heyoka_bike.reference.following import following
from heyoka_bike.scoring.diagnosis.budget import NEVER, Deadline
from heyoka_bike.scoring.diagnosis.programs.forces import TENSORS, Moving, dot, rates_altered
from heyoka_bike.scoring.diagnosis.programs.program import (
    NAMES,
    ParameterValues,
    Program,
    beginning,
    equations_of,
)
from heyoka_bike.system.resources import benchmark_bicycle

# Length of an interval [s].
_INTERVAL = 0.2
# If the last Newton iteration changes a motion by more than this many times the settled change, the
# motion has met a singularity.
_LOST = 1e3
# An extrapolated first guess is used only if the motion changes in it by less than this many times
# its change in the last interval.
_FARTHER = 3.0
_STATE_LENGTH = 7


@dataclass(frozen=True, slots=True)
class Accuracy:
    """Accuracy of a simulation.

    Attributes
    ----------
    error
        Typical error relative to the size of a column.
    points
        Number of Gauss points per interval.
    parts : tuple of int
        Numbers of parts into which an interval is split. The second number is for motions that do
        not converge with the first: a steer axis may swing round within a few hundredths of a
        second.
    iterations
        Maximum number of Newton iterations on an interval.
    settled
        Relative change at which these iterations end. A further iteration would change the motion
        by only a millionth of that change.
    together
        Number of motions that are simulated together. The processor's cache limits this number.
    """

    error: float
    points: int
    parts: tuple[int, ...]
    iterations: int
    settled: float
    together: int


FINE = Accuracy(1e-13, 16, (1, 2), 7, 1e-9, 48)
"""For programs that are compared with the file. Intervals of half the length with 12 points have
the same error, but take twice the time."""

COARSE = Accuracy(1e-4, 6, (1,), 4, 1e-6, 144)
"""For the choice of causes that are worth an accurate simulation. A coarse simulation takes a fifth
of the time of an accurate one."""


@dataclass(frozen=True, eq=False, slots=True)
class MotionRequest:
    """A request to simulate a motion.

    Attributes
    ----------
    bicycle : Bicycle
        Any parameters, plausible or not.
    start : (roll, pitch, steer, roll rate, steer rate, speed)
        Initial state at t = 0 [rad, rad/s, m/s]; the speed is that of the rear hub along the
        heading.
    time : ndarray, shape (n,)
        Times of the rows, from 0 on [s].
    amounts
        Coefficients of `forces.FORCES` and `forces.TENSORS` [SI].
    """

    bicycle: Bicycle
    start: Sequence[float]
    time: Array
    amounts: Mapping[str, float] = field(default_factory=dict)


def requested(program: Program, maneuver: int, time: Array) -> MotionRequest:
    """Return the request for the motion of a program in a maneuver, at some times [s]."""
    motion = program.motion
    return MotionRequest(motion.bicycle, beginning(program, maneuver), time, dict(motion.amounts))


_Constants = tuple[Array, float]
"""Constants of the equations, and the unit of length [m]."""


class Simulator:
    """Simulator of motions; states that were computed are kept for later requests."""

    def __init__(self, accuracy: Accuracy = FINE) -> None:
        self._accuracy = accuracy
        # Equations that serve as a template: their constants are replaced with those of other
        # bicycles.
        self._any = Equations.of(read_bicycle(benchmark_bicycle()), Arrays())
        self._known: dict[object, Array] = {}

    def run(
        self, bicycle: Bicycle, start: Sequence[float], time: Array,
        amounts: Mapping[str, float] | None = None,
    ) -> dict[str, Array]:  # fmt: skip
        """Simulate a motion and return its columns; see `MotionRequest` for the parameters.

        Returns
        -------
        dict of str to ndarray, shape (n,)
            Every column of `columns.COLUMNS` and `FOLLOWING`, and parts of the energies [J]:
            ``spin_energy`` (rotation of the wheels about their axles, also for each wheel),
            ``rotation_energy`` (rotation of all bodies, of both wheels, and of each body, including
            spin), and the kinetic and potential energy of each body. The values are NaN after the
            motion meets a singularity, or everywhere if the bicycle has no motion.
        """
        return self.run_all([MotionRequest(bicycle, start, time, amounts or {})])[0]

    def run_all(
        self, motions: Sequence[MotionRequest], deadline: Deadline = NEVER
    ) -> list[dict[str, Array]]:
        """Simulate several motions together, which is faster; see `run`.

        Raises
        ------
        BudgetSpentError
            The time limit is reached before all motions are simulated.
        """
        constants = self._integrate(motions, deadline)
        return [self._columns_at(m, c, m.time) for m, c in zip(motions, constants, strict=True)]

    def _integrate(
        self, motions: Sequence[MotionRequest], deadline: Deadline
    ) -> list[_Constants | None]:
        """Compute and store the states of motions; return the constants of their equations."""
        constants = [_constants(tuple(m.bicycle.values.items())) for m in motions]
        keys = [_key(m) for m in motions]
        new: dict[object, tuple[MotionRequest, _Constants]] = {}
        for key, m, c in zip(keys, motions, constants, strict=True):
            if c is not None and key not in self._known:
                new[key] = m, c
        # Simulate equations of the same kind together, because the kinds take different times:
        # equations with additional forces take longer than those without, and equations with
        # tensors that do not turn take longest.
        kinds = {
            k: bool(m.amounts) + any(x in TENSORS for x in m.amounts) for k, (m, _) in new.items()
        }
        for kind in range(3):
            chosen = [k for k in new if kinds[k] == kind]
            many = self._accuracy.together
            for i in range(0, len(chosen), many):
                lost = chosen[i : i + many]
                for parts in self._accuracy.parts:
                    if not lost:
                        break
                    made = self._nodes([new[k] for k in lost], parts, deadline)
                    self._known.update(zip(lost, made, strict=True))
                    lost = [k for k in lost if np.isnan(self._known[k]).any()]
        return constants

    def _states(self, motion: MotionRequest, time: Array) -> Array:
        """Return the states of a simulated motion at some times up to its end [s], shape (7, n)."""
        return _at(self._known[_key(motion)], time, _intervals(motion))

    def run_near(
        self, groups: Sequence[Sequence[MotionRequest]], deadline: Deadline = NEVER
    ) -> list[list[dict[str, Array]]]:
        """Simulate the first motion of each group, and the others of the group, which are near it.

        The others must hardly differ from the first. They are computed to first order in the
        difference, in a small fraction of the time.

        Raises
        ------
        BudgetSpentError
            As in `run_all`.
        """
        first = self.run_all([motion for motion, *_ in groups], deadline)
        return [
            [columns, *self._near(columns, *group, deadline=deadline)]
            for columns, group in zip(first, groups, strict=True)
        ]

    def at(self, motion: MotionRequest, time: Array) -> dict[str, Array]:
        """Return the columns of a motion at times up to its end [s], as `run` does."""
        (constants,) = self._integrate([motion], NEVER)
        return self._columns_at(motion, constants, time)

    def followed(self, motion: MotionRequest, time: Array) -> tuple[Equations, Array]:
        """Return the equations of a motion, and its states at times up to its end [s], (7, n)."""
        (constants,) = self._integrate([motion], NEVER)
        assert constants is not None
        return self._with(constants[0]), self._states(motion, time)

    def differences(self, motion: MotionRequest, each: Iterable[Array]) -> list[dict[str, Array]]:
        """Return the changes of a motion's columns for each change of its states, shape (7, n)."""
        (constants,) = self._integrate([motion], NEVER)
        assert constants is not None
        states = self._states(motion, motion.time)
        right = self._columns(motion, constants[0], states)
        others = (self._columns(motion, constants[0], states + off) for off in each)
        return [{name: made[name] - v for name, v in right.items()} for made in others]

    def _near(
        self,
        columns: Mapping[str, Array],
        motion: MotionRequest,
        *others: MotionRequest,
        deadline: Deadline,
    ) -> Iterator[dict[str, Array]]:
        """Compute the columns of motions near a simulated one."""
        values = [tuple(m.bicycle.values.items()) for m in (motion, *others)]
        constants = [c for c in map(_constants, values) if c is not None]
        if len(constants) <= len(others):
            yield from ({name: np.nan * v for name, v in columns.items()} for _ in others)
            return
        asked = list(zip((motion, *others), constants, strict=True))
        equations, amounts, starts = self._side_by_side(asked)
        apart, duration = starts[:, 1:] - starts[:, :1], _INTERVAL * _intervals(motion)
        deadline.check()
        nodes = _nodes_nearby(equations, amounts, apart, self._known[_key(motion)], duration)
        for k, (m, (found, _)) in enumerate(asked[1:]):
            deadline.check()
            yield self._columns(m, found, _at(nodes[..., k], m.time, _intervals(m)))

    def _nodes(
        self, asked: Sequence[tuple[MotionRequest, _Constants]], parts: int, deadline: Deadline
    ) -> Iterator[Array]:
        """Compute the states of motions, see `_nodal_states`."""
        counts = [parts * _intervals(m) for m, _ in asked]
        nodes = _nodal_states(
            *self._side_by_side(asked), max(counts), _INTERVAL / parts, self._accuracy, deadline
        )
        for k, count in enumerate(counts):
            yield nodes[:count, ..., k]

    def _side_by_side(
        self, asked: Sequence[tuple[MotionRequest, _Constants]]
    ) -> tuple[Equations, dict[str, Array], Array]:
        """Return equations, coefficients and initial states (7, motions) of several motions."""
        names = sorted({name for m, _ in asked for name in m.amounts})
        amounts = {name: np.array([m.amounts.get(name, 0.0) for m, _ in asked]) for name in names}
        starts = [[*m.start[:-1], m.start[-1] / unit, 0.0] for m, (_, unit) in asked]
        equations = self._with(np.array([values for _, (values, _) in asked]).T)
        return equations, amounts, np.array(starts).T

    def _columns_at(
        self, motion: MotionRequest, constants: _Constants | None, time: Array
    ) -> dict[str, Array]:
        """Return a simulated motion's columns at some times; NaN if the bicycle has no motion."""
        if constants is None or not len(time):
            return {name: np.full(len(time), np.nan) for name in NAMES}
        return self._columns(motion, constants[0], self._states(motion, time))

    def _columns(self, motion: MotionRequest, values: Array, states: Array) -> dict[str, Array]:
        equations = self._with(values)
        p = {s: float(x) for s, x in motion.bicycle.values.items()}
        # A motion near a singularity may become so fast that numbers overflow.
        with np.errstate(all="ignore"):
            made = dict(equations.columns(list(states)))
            return made | following(made, p) | _energies(equations, states)

    def _with(self, constants: Array) -> Equations:
        """Return the equations with these constants, each a number or an array."""
        left = iter(constants)
        return self._any.convert(lambda _: next(left), Arrays())


def _key(m: MotionRequest) -> object:
    values = tuple(m.bicycle.values.items())
    return values, tuple(m.start), tuple(sorted(m.amounts.items())), _intervals(m)


@lru_cache(512)
def _constants(values: ParameterValues) -> _Constants | None:
    """Return the constants of the equations and the unit of length [m]; None without a motion."""
    found: list[float] = []
    try:
        equations = equations_of(values)
    except ZeroDivisionError:
        # This exception occurs if the rear or the front assembly has neither mass nor inertia.
        return None
    equations.convert(lambda x: found.append(float(x)), equations.a)
    return np.array(found), float(equations.k.length)


@cache
def _points(count: int) -> tuple[Array, ...]:
    """Return Gauss points, and integrals of their Lagrange polynomials from 0 to each and to 1."""
    x = np.asarray(leggauss(count)[0], np.float64)
    basis = np.linalg.inv(chebvander(x, count - 1))
    integrals = chebint(np.eye(count), lbnd=-1, scl=0.5)
    within = chebvander(x, count) @ integrals @ basis
    whole = np.ones(count + 1) @ integrals @ basis
    return tuple(np.asarray(m, np.float64) for m in ((x + 1) / 2, within, whole))


@cache
def _through(count: int) -> Array:
    """Return the matrix from values at 0 and the Gauss points to Chebyshev coefficients."""
    inverse = np.linalg.inv(_basis(np.concatenate([[0.0], _points(count)[0]]), count))
    return np.asarray(inverse, np.float64)


def _basis(place: Array, count: int) -> Array:
    """Evaluate the Chebyshev polynomials up to a degree at places of an interval, 0 to 1."""
    return np.asarray(chebvander(2 * place - 1, count), np.float64)


def _intervals(motion: MotionRequest) -> int:
    """Return the number of intervals of length `_INTERVAL` up to the end of a motion."""
    return max(1, int(np.ceil(float(np.max(motion.time, initial=0.0)) / _INTERVAL - 1e-9)))


def _nodal_states(
    equations: Equations, amounts: Mapping[str, Array], start: Array, count: int, h: float,
    accuracy: Accuracy, deadline: Deadline,
) -> Array:  # fmt: skip
    """Simulate motions; return states at the beginning and the Gauss points of each interval.

    The shape is (intervals, 1 + points, 7, motions).
    """
    points, n = accuracy.points, start.shape[1]
    x, integral, whole = _points(points)
    found = np.full((count, points + 1, _STATE_LENGTH, n), np.nan)
    ahead = _basis(1.0 + x, points) @ _through(points)
    identity = np.eye(points * _STATE_LENGTH)
    y, guess = start, np.repeat(start[None], points, axis=0)
    with np.errstate(all="ignore"):
        for i in range(count):
            deadline.check()
            for _ in range(accuracy.iterations):
                f, slopes = _rates(equations, amounts, guess)
                left = guess - y - h * np.tensordot(integral, f, 1)
                matrix = identity - h * np.einsum("ij,jabn->niajb", integral, slopes).reshape(
                    n, len(identity), len(identity)
                )
                # Leave a motion unchanged if its equations are not finite.
                good = np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(left).all(axis=(0, 1))
                matrix[~good] = identity
                change = _solved(matrix, left.reshape(-1, n))
                change = np.where(good, change, 0.0).reshape(guess.shape)
                guess = guess - change
                error = np.where(good, np.max(np.abs(change) / (1 + np.abs(guess)), (0, 1)), 0.0)
                if np.max(error) < accuracy.settled:
                    break
            is_lost = ~good | ~(error < _LOST * accuracy.settled)
            guess[..., is_lost] = np.nan
            if is_lost.all():
                break
            found[i] = np.concatenate([y[None], guess])
            # Correct the derivatives at the Gauss points for the last change of the state, to first
            # order.
            f = f - np.einsum("jabn,jbn->jan", slopes, change)
            y = np.asarray(y + h * np.tensordot(whole, f, 1), np.float64)
            guess = np.tensordot(ahead, found[i], 1)
            # Do not use an extrapolation that goes too far: the polynomial of a motion with kinks
            # may extrapolate to any value.
            change, before = (np.max(np.abs(x - y), (0, 1)) for x in (guess, found[i]))
            guess = np.where(change < _FARTHER * before, guess, y)
    return found


def _nodes_nearby(
    equations: Equations, amounts: Mapping[str, Array], starts: Array, nodes: Array, duration: float
) -> Array:
    """Compute states of nearby motions to first order, shape (intervals, 1 + points, 7, motions).

    `equations` and `amounts` are those of the motion with the states `nodes`, then those of the
    motions nearby. `starts` has the differences of their initial states, shape (7, motions).
    """
    points = nodes.shape[1] - 1
    _, integral, whole = _points(points)
    count, h = len(nodes), duration / len(nodes)
    found = np.full((*nodes.shape, starts.shape[1]), np.nan)
    y = list(nodes[:, 1:].reshape(-1, _STATE_LENGTH).T[..., None])
    with np.errstate(all="ignore"):
        made = rates_altered(equations, y, amounts) if amounts else equations.rates_with_yaw(y)
        rates = np.array(np.broadcast_arrays(*made)).reshape(_STATE_LENGTH, count, points, -1)
        off = np.moveaxis(rates[..., 1:] - rates[..., :1], 0, 2)
        one = equations.convert(lambda x: x[:1] if np.ndim(x) else x, equations.a)
        first = {name: x[:1] for name, x in amounts.items()}
        slopes = _rates(one, first, nodes[:, 1:].reshape(-1, _STATE_LENGTH, 1))[1][..., 0]
    slopes = slopes.reshape(count, points, _STATE_LENGTH, _STATE_LENGTH)
    for i in range(count):
        if not (np.isfinite(slopes[i]).all() and np.isfinite(off[i]).all()):
            break
        matrix = np.eye(points * _STATE_LENGTH) - h * np.einsum(
            "ij,jab->iajb", integral, slopes[i]
        ).reshape(points * _STATE_LENGTH, -1)
        right = starts + h * np.tensordot(integral, off[i], 1)
        apart = np.linalg.solve(matrix, right.reshape(len(matrix), -1)).reshape(right.shape)
        found[i] = nodes[i][..., None] + np.concatenate([starts[None], apart])
        change = np.einsum("jab,jbk->jak", slopes[i], apart) + off[i]
        starts = starts + h * np.tensordot(whole, change, 1)
    return found


def _solved(matrix: Array, right: Array) -> Array:
    """Solve a system for each motion, shape (unknowns, motions); NaN for singular matrices."""
    try:
        found = np.asarray(np.linalg.solve(matrix, right.T[..., None])[..., 0].T, np.float64)
    except np.linalg.LinAlgError:
        if len(matrix) == 1:
            return np.full_like(right, np.nan)
        half = len(matrix) // 2
        parts = (slice(None, half), slice(half, None))
        found = np.concatenate([_solved(matrix[p], right[:, p]) for p in parts], axis=1)
    return found


def _rates(
    equations: Equations, amounts: Mapping[str, Array], states: Array
) -> tuple[Array, Array]:
    """Return rates of states, shape (points, 7, motions), and their Jacobian matrices."""
    # The derivatives with respect to the yaw are needed only for forces in ground axes, and for
    # inertia that keeps its initial direction.
    shifts = SMALL_STEP * np.concatenate(
        [np.zeros((_STATE_LENGTH, 1)), np.eye(_STATE_LENGTH)], axis=1
    )
    y = list(np.moveaxis(states, 1, 0)[:, None] + shifts[:, :, None, None])
    made = rates_altered(equations, y, amounts) if amounts else equations.rates_with_yaw(y)
    f = np.array([np.broadcast_to(r, y[0].shape) for r in made])
    # Axes: point, component of the derivative, component of the state, motion.
    slopes = ((f[:, 1:] - f[:, :1]) / SMALL_STEP).transpose(2, 0, 1, 3)
    return np.moveaxis(f[:, 0], 0, 1), slopes


def _at(nodes: Array, time: Array, refinement: int) -> Array:
    """Interpolate states at some times, shape (7, times), from (intervals, points, 7)."""
    points = nodes.shape[1] - 1
    place = time / (_INTERVAL * refinement) * len(nodes)
    i = np.clip(place.astype(int), 0, len(nodes) - 1)
    weights = _basis(place - i, points) @ _through(points)
    found: Array = np.einsum("tp,tps->st", weights, nodes[i])
    return found


def _energies(equations: Equations, states: Array) -> dict[str, Array]:
    """Compute the parts of the energies [J]."""
    m = Moving(equations, list(states))
    points, rear, front = Points.of(m.b, m.axes), m.b.rear, m.b.front
    centres = {
        "R": points.rear_hub,
        "B": plus(points.rear_hub, m.axes.from_rear((rear.x, 0.0, rear.z))),
        "H": plus(points.front_hub, m.axes.from_front((front.x, 0.0, front.z))),
        "F": points.front_hub,
    }
    turning = {b: dot(m.now[f"w_{b}"], m.inertia(b, m.now[f"w_{b}"])) / 2 for b in m.masses}
    spins = {w: m.now[f"w_{w}"][1] * m.inertia(w, m.now[f"w_{w}"])[1] / 2 for w in "RF"}
    return {
        "spin_energy": spins["R"] + spins["F"],
        "spin_energy_R": spins["R"],
        "spin_energy_F": spins["F"],
        "rotation_energy": sum(turning.values()),
        "rotation_energy_of_wheels": turning["R"] + turning["F"],
        **{f"rotation_energy_of_{b}": energy for b, energy in turning.items()},
        **{
            f"kinetic_energy_of_{b}": turning[b] + mass * dot(m.now[f"v_{b}"], m.now[f"v_{b}"]) / 2
            for b, mass in m.masses.items()
        },
        **{
            f"potential_energy_of_{b}": -mass * m.b.g * centres[b][2]
            for b, mass in m.masses.items()
        },
    }

"""A computed motion as exact piecewise polynomials.

Between two breaks every state variable is a polynomial in s = (t - t0) / (t1 - t0), 0 <= s <= 1,
with coefficients that are integers times 2^-grid. A trajectory is thus a finite list of exact
numbers: every later statement about it (a value, an error bound) is about those numbers, not about
the run that produced them. An `Evaluator` computes its columns in ball arithmetic.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, reduce
from typing import ClassVar, NamedTuple

import flint

from heyoka_bike.bicycle.equations.kinematics import front_contact_height, state_names
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import NonnegativeRoots
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.display import Displayed
from heyoka_bike.numbers.analytic import Samples, array
from heyoka_bike.numbers.arithmetic import Balls, Number, exact_ball, span_ball, upper_fraction
from heyoka_bike.numbers.rounding import decimal_above, upward_ball
from heyoka_bike.numbers.working import working_bits

OnTime = Callable[[float], None]
"""Called with the time reached [s]."""


@dataclass(frozen=True, repr=False)
class Trajectory(Displayed):
    """The motion of one maneuver.

    Attributes
    ----------
    bicycle, maneuver
        The bicycle and the maneuver that were integrated.
    precision : str
        Name of the precision of the run.
    bits : int
        Bits of its significand.
    is_regular : bool
        True for the regular form of the equations (see `equations.model`).
    order : int
        Taylor order.
    grid : int
        Coefficients are integers times 2^-grid.
    breaks : tuple of Fraction
        Times of the piece ends [s], dyadic, P + 1 of them, from 0 to at least the duration.
    pieces : tuple
        Integers by piece, state variable (with the yaw last) and power of s.
    """

    bicycle: Bicycle
    maneuver: Maneuver
    precision: str
    bits: int
    is_regular: bool
    order: int
    grid: int
    breaks: tuple[Fraction, ...]
    pieces: tuple[tuple[tuple[int, ...], ...], ...]

    _view: ClassVar[str] = "trajectory"

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the state variables."""
        return (*state_names(self.is_regular), "yaw")

    @property
    def steps(self) -> int:
        return len(self.pieces)

    @property
    def words(self) -> tuple[str, str]:
        """Two texts: bicycle and maneuver, and the method of the run."""
        form = "regular" if self.is_regular else "with few products"
        return (
            f"trajectory of {self.bicycle.name}, {self.maneuver.name}",
            f"{self.steps} steps of order {self.order} in {self.precision} ({self.bits} bits), "
            f"{float(self.breaks[-1]):.6g} s, equations {form}",
        )

    def __repr__(self) -> str:
        return f"<{': '.join(self.words)}>"

    @property
    def evaluation_bits(self) -> int:
        """Working precision of evaluations [bits]: 64 more than that of the run."""
        return self.bits + 64

    def equations(self, balls: Balls) -> Equations:
        """Return the equations of the run's bicycle, in the run's form."""
        return Equations.of(self.bicycle, balls, is_regular=self.is_regular)

    def piece(self, i: int) -> Piece:
        """Return the piece with index i."""
        return Piece(self, i, self.breaks[i], self.breaks[i + 1], self.grid, self.pieces[i])

    def piece_at(self, t: Fraction) -> int:
        """Return the index of the piece with `t`; a break belongs to the piece on its right."""
        return min(max(bisect_right(self.breaks, t) - 1, 0), len(self.pieces) - 1)

    def state(self, t: Fraction | flint.arb, piece: int | None = None) -> list[flint.arb]:
        """Return the state at `t` [s] as balls at flint's current precision.

        `piece` must be given when `t` is a ball.
        """
        if piece is None:
            if not isinstance(t, Fraction):
                raise TypeError("a time that is a ball needs its piece")
            piece = self.piece_at(t)
        s, unit = self._place(t, piece), flint.arb(2) ** -self.grid
        return [p(s) * unit for p in self._piece(piece)]

    def around(
        self, piece: int, t: Fraction, scale: flint.arb, terms: int
    ) -> list[list[flint.arb]]:
        """Return the state's first Taylor coefficients at `t` [s], in powers of time / `scale`."""
        unit, h = (
            flint.arb(2) ** -self.grid,
            exact_ball(self.breaks[piece + 1] - self.breaks[piece]),
        )
        line = flint.arb_poly([self._place(t, piece), scale / h])
        return [[c * unit for c in p(line).coeffs()[:terms]] for p in self._piece(piece)]

    def _place(self, t: Fraction | flint.arb, piece: int) -> flint.arb:
        """Return the position of a time in a piece: 0 at its beginning, 1 at its end."""
        a, b = self.breaks[piece], self.breaks[piece + 1]
        if isinstance(t, Fraction):
            return exact_ball((t - a) / (b - a))
        return (t - exact_ball(a)) / exact_ball(b - a)

    def _piece(self, piece: int) -> list[flint.arb_poly]:
        return _polynomials(self.pieces[piece], self.evaluation_bits)


@lru_cache(maxsize=256)
def _polynomials(rows: tuple[tuple[int, ...], ...], bits: int) -> list[flint.arb_poly]:
    """Convert integers to balls: exact if they fit in this many bits, else rounded outward."""
    with working_bits(bits):
        return [flint.arb_poly(list(row)) for row in rows]


@dataclass(frozen=True)
class Piece:
    """A piece of a trajectory, or an exact part of one.

    Attributes
    ----------
    run : Trajectory
    step : int
        Index of the piece in the trajectory.
    t0, t1 : Fraction
        Its ends [s].
    grid : int
        The coefficients in s = (t - t0) / (t1 - t0) are integers times 2^-grid.
    rows : tuple
        These integers, by state variable and power.
    """

    run: Trajectory
    step: int
    t0: Fraction
    t1: Fraction
    grid: int
    rows: tuple[tuple[int, ...], ...]

    @property
    def h(self) -> Fraction:
        return self.t1 - self.t0

    def samples(self, a: Samples) -> list[Number]:
        """Return the state variables at the complex points s of `a`, in its precision."""
        unit = flint.arb(2) ** -self.grid
        return a.polynomials([[c * unit for c in row] for row in self.rows])

    def at(self, points: Sequence[flint.arb]) -> list[Number]:
        """Return the state variables at several s, in flint's precision."""
        unit = flint.arb(2) ** -self.grid
        polynomials = [flint.arb_poly([c * unit for c in row]) for row in self.rows]
        return [array(map(p, points)) for p in polynomials]

    def halves(self) -> tuple[Piece, Piece]:
        """Return the two halves: exactly the same polynomials, each in its own variable."""
        degree = max(len(row) for row in self.rows) - 1
        middle = (self.t0 + self.t1) / 2
        left = [[c << (degree - m) for m, c in enumerate(row)] for row in self.rows]
        shift = flint.fmpz_poly([1, 1])
        right = [[int(c) for c in flint.fmpz_poly(row)(shift).coeffs()] or [0] for row in left]
        first, second = (tuple(map(tuple, rows)) for rows in (left, right))
        grid = self.grid + degree
        return (
            Piece(self.run, self.step, self.t0, middle, grid, first),
            Piece(self.run, self.step, middle, self.t1, grid, second),
        )


class Stretch(NamedTuple):
    """A piece, with bounds on the distance of the exact motion from each of its polynomials."""

    piece: Piece
    bounds: tuple[Fraction, ...]


def row_times(maneuver: Maneuver) -> Iterator[Fraction]:
    """Yield the exact times of the rows [s]."""
    return (maneuver.time(i) for i in range(maneuver.rows))


@dataclass(frozen=True)
class Certificate:
    """Bounds on abs(exact - candidate), state by state.

    Attributes
    ----------
    states : tuple of str
        Names of the state variables, rad and rad/s.
    pieces : tuple of tuple of Fraction
        Bound over each piece of the candidate.
    end : tuple of Fraction
        Bound at the end of the last piece.
    """

    states: tuple[str, ...]
    pieces: tuple[tuple[Fraction, ...], ...]
    end: tuple[Fraction, ...]

    def along(self, run: Trajectory) -> Iterator[Stretch]:
        """Yield the pieces of the candidate with their bounds."""
        return (Stretch(run.piece(i), bounds) for i, bounds in enumerate(self.pieces))

    @property
    def claimed(self) -> Certificate:
        """The bounds as certificate.json states them: over the whole run, as short decimals."""
        worst = [max(column) for column in zip(*self.pieces, strict=True)]
        bounds = tuple(Fraction(decimal_above(x)) for x in worst)
        return Certificate(self.states, (bounds,) * len(self.pieces), self.end)

    @property
    def worst(self) -> Fraction:
        """The largest bound over all pieces and states."""
        return max(x for piece in self.pieces for x in piece)


@dataclass(frozen=True)
class Drift:
    """Largest drift, over the rows, of quantities that the exact motion conserves, rounded up.

    Attributes
    ----------
    energy : float
        max abs(E - E0) / E0, in units of 2^-p.
    contact : float
        max abs height of the front wheel above the floor [m].
    performance : float
        The benchmark's eq. (1): 100 (max E - min E) / E0 [%].
    """

    energy: float
    contact: float
    performance: float


def evaluator(
    trajectory: Trajectory, bits: int | None = None, certificate: Certificate | None = None
) -> Evaluator:
    """Return an evaluator of columns in ball arithmetic of `bits` (default: more than the run).

    With a certificate the columns enclose those of the exact motion, without one those of the
    candidate.
    """
    balls = NonnegativeRoots(bits or trajectory.evaluation_bits)
    return Evaluator(trajectory, balls, trajectory.equations(balls), certificate)


@dataclass(frozen=True)
class Evaluator:
    """Evaluates columns along a trajectory; use it inside ``with evaluator.balls.precision()``.

    Attributes
    ----------
    trajectory
        The trajectory that is evaluated.
    balls, equations
        The number type, and the equations of the bicycle in it.
    certificate
        Bounds on the distance of the exact motion; if given, the columns enclose the exact ones.
    """

    trajectory: Trajectory
    balls: Balls
    equations: Equations
    certificate: Certificate | None = None

    def columns(self, t: Fraction | flint.arb, piece: int | None = None) -> dict[str, flint.arb]:
        """Return every column by name at time `t`, see `state`."""
        return dict(self.equations.columns(self.state(t, piece)))

    def state(self, t: Fraction | flint.arb, piece: int | None = None) -> list[flint.arb]:
        """Return the state at time `t`; without `piece`, a ball may extend over several pieces."""
        if piece is None:
            if not isinstance(t, Fraction):
                return self._across(t)
            piece = self.trajectory.piece_at(t)
        state = self.trajectory.state(t, piece)
        if self.certificate is not None:
            bounds = self.certificate.pieces[piece]
            state = [flint.arb(x, _arb(b)) for x, b in zip(state, bounds, strict=True)]
        return state

    def _across(self, t: flint.arb) -> list[flint.arb]:
        run, low, high = self.trajectory, -upper_fraction(-t), upper_fraction(t)
        # Evaluate each piece only on its own time interval, because its bounds are valid only
        # there.
        parts = [
            self.state(span_ball(max(low, run.breaks[i]), min(high, run.breaks[i + 1])), i)
            for i in range(run.piece_at(low), run.piece_at(high) + 1)
        ]
        return [reduce(flint.arb.union, values) for values in zip(*parts, strict=True)]

    def drift(self) -> Drift:
        """Return the drift of energy and contact over the rows of the maneuver."""
        k, a, run = self.equations.k, self.balls, self.trajectory
        values = []
        contact = flint.arb(0)
        with a.precision():
            for t in row_times(run.maneuver):
                state = run.state(t)
                e = self.equations.energies(state)
                values.append(e.potential + e.kinetic)
                gap = abs(front_contact_height(k, a, state[0], state[1], state[2]))
                contact = gap.max(contact)
            start = values[0]
            high, low = values[0], values[0]
            for value in values:
                high, low = high.max(value), low.min(value)
            worst = (high - start).max(start - low) / start
            return Drift(
                energy=upward_ball(worst * flint.arb(2) ** run.bits),
                contact=upward_ball(contact),
                performance=upward_ball(100 * (high - low) / start),
            )


def _arb(value: Fraction) -> flint.arb:
    """Convert a dyadic number to a ball, of radius zero if it fits."""
    return exact_ball(value).upper()

"""A computed motion as exact piecewise polynomials.

Between two breaks every state variable is a polynomial in s = (t - t0) / (t1 - t0), 0 <= s <= 1,
with coefficients that are integers times 2^-grid. A trajectory is thus a finite list of exact
numbers: whatever is said about it later (a value, an error bound) is about those numbers, not about
the run that produced them.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, ClassVar

import flint

from heyoka_bike.bicycle.equations.kinematics import state_names
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.display import Displayed
from heyoka_bike.numbers.arithmetic import Number, exact_ball
from heyoka_bike.numbers.samples import Samples, array


@dataclass(frozen=True, repr=False)
class Trajectory(Displayed):
    """The motion of one maneuver.

    Attributes
    ----------
    bicycle, maneuver
        What was integrated.
    precision : str
        Name of the precision of the run.
    bits : int
        Bits of its significand.
    is_regular : bool
        Which form of the equations (see `model`).
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
    _polynomials: dict[int, list[flint.arb_poly]] = field(
        default_factory=dict, init=False, compare=False
    )

    _view: ClassVar[str] = "trajectory"

    def __getstate__(self) -> dict[str, Any]:
        """For pickling: all but the polynomials in flint's form, which are made again when used."""
        return {k: v for k, v in self.__dict__.items() if k != "_polynomials"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.__dict__["_polynomials"] = {}

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the state variables."""
        return (*state_names(self.is_regular), "yaw")

    @property
    def steps(self) -> int:
        return len(self.pieces)

    @property
    def words(self) -> tuple[str, str]:
        """Bicycle and maneuver, and the method of the run."""
        form = "regular" if self.is_regular else "with few products"
        return (
            f"trajectory of {self.bicycle.name}, {self.maneuver.name}",
            f"{self.steps} steps of order {self.order} in {self.precision} ({self.bits} bits), "
            f"{float(self.breaks[-1]):.6g} s, equations {form}",
        )

    def __repr__(self) -> str:
        return f"<{': '.join(self.words)}>"

    def piece(self, i: int) -> Piece:
        """Piece i."""
        return Piece(self, i, self.breaks[i], self.breaks[i + 1], self.grid, self.pieces[i])

    def piece_at(self, t: Fraction) -> int:
        """Index of the piece that holds `t` (a break belongs to the piece on its right)."""
        return min(max(bisect_right(self.breaks, t) - 1, 0), len(self.pieces) - 1)

    def state(self, t: Fraction | flint.arb, piece: int | None = None) -> list[flint.arb]:
        """State at `t` [s] as balls at flint's current precision.

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
        """The first Taylor coefficients of the state at `t` [s], by powers of time over `scale`."""
        unit, h = (
            flint.arb(2) ** -self.grid,
            exact_ball(self.breaks[piece + 1] - self.breaks[piece]),
        )
        line = flint.arb_poly([self._place(t, piece), scale / h])
        return [[c * unit for c in p(line).coeffs()[:terms]] for p in self._piece(piece)]

    def _place(self, t: Fraction | flint.arb, piece: int) -> flint.arb:
        """Return the place of a time in a piece: 0 at its begin, 1 at its end."""
        a, b = self.breaks[piece], self.breaks[piece + 1]
        if isinstance(t, Fraction):
            return exact_ball((t - a) / (b - a))
        return (t - exact_ball(a)) / exact_ball(b - a)

    def _piece(self, piece: int) -> list[flint.arb_poly]:
        # Integers as balls: exact as long as they fit in flint's precision, else rounded outward.
        found = self._polynomials.get(piece)
        if found is None:
            with flint.ctx.workprec(self.bits + 64):
                found = [flint.arb_poly(list(c)) for c in self.pieces[piece]]
            self._polynomials[piece] = found
        return found


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
        """The state variables at the points of `a` in the plane of s, in its precision."""
        unit = flint.arb(2) ** -self.grid
        return a.polynomials([[c * unit for c in row] for row in self.rows])

    def at(self, points: Sequence[flint.arb]) -> list[Number]:
        """The state variables at some s, in flint's precision."""
        unit = flint.arb(2) ** -self.grid
        polynomials = [flint.arb_poly([c * unit for c in row]) for row in self.rows]
        return [array(map(p, points)) for p in polynomials]

    def halves(self) -> tuple[Piece, Piece]:
        """The two halves; the same polynomials exactly, in variables of their own."""
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


def row_times(maneuver: Maneuver) -> Iterator[Fraction]:
    """Times of the rows [s], exactly."""
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

    @property
    def worst(self) -> Fraction:
        """The largest bound over all pieces and states."""
        return max(x for piece in self.pieces for x in piece)

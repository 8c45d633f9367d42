"""The whole motion of a maneuver: every column of motion.h5 with its certified bounds.

Place and wheel angles along a candidate, as polynomials with certified bounds.

They are integrals of functions g of the state. On each piece of the candidate p the Taylor
coefficients of h g(p(s)) (see `analytic`) are integrated in balls, and those of the integral
rounded to the candidate's grid: a polynomial q. Its distance from the exact integral grows over a
piece by at most

- ``q' - h g(p)``: the coefficients' absolute values, and beyond these Cauchy's estimate on a circle
  (see `cauchy`);
- ``h g(x) - h g(p)`` for the exact state x, which the certificate keeps near p: its distance times
  the derivatives of g, bounded on the polydisc around p.

A piece on which no circle works is halved, exactly.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, log2

import flint

from heyoka_bike.bicycle.columns import DENSE_COLUMNS, MOTION_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import (
    INTEGRALS,
    NonnegativeRoots,
    dense_columns,
    motion_columns,
    rates_of_integrals,
)
from heyoka_bike.errors import UndecidedError
from heyoka_bike.motion.trajectory import Certificate, Piece, Trajectory, row_times
from heyoka_bike.numbers.analytic import Samples
from heyoka_bike.numbers.arithmetic import Balls, exact_ball, to_grid, upper_fraction
from heyoka_bike.numbers.rounding import Enclosure, few_bits, hi_lo
from heyoka_bike.reference.proof import cauchy
from heyoka_bike.reference.proof.dense import (
    BITS,
    Expanded,
    Expansion,
    bound_pieces,
    expansions,
    interpolate,
)
from heyoka_bike.reference.proof.rows import EVALUATION_BITS, distance, round_columns
from heyoka_bike.reference.values import Dense, Values

_GUARD_BITS = 64


@dataclass(frozen=True)
class Stretch:
    """A piece of a candidate with the integrals, and how far the exact motion may be from it.

    Attributes
    ----------
    piece : Piece
        Rows of the state, the yaw last, and then of `INTEGRALS`.
    bounds : tuple of Fraction
        Over the piece, row by row.
    """

    piece: Piece
    bounds: tuple[Fraction, ...]


def with_integrals(run: Trajectory, certificate: Certificate) -> Iterator[Stretch]:
    """The candidate piece by piece, with the integrals from the start of the motion.

    Raises
    ------
    NotCertifiedError
        A piece inside of which the integrands are not shown to be analytic.
    """
    integrator = _Integrator(run)
    for i, bounds in enumerate(certificate.pieces):
        yield from integrator.stretches(run.piece(i), bounds)


class _Integrator:
    """Carries the integrals, exact numbers, and the bounds on their errors."""

    def __init__(self, run: Trajectory) -> None:
        self.bits = run.grid + _GUARD_BITS
        self.circles = cauchy.circle_equations(run)
        self.equations = Equations.of(run.bicycle, Balls(self.bits), is_regular=run.is_regular)
        self.at = [Fraction(0)] * len(INTEGRALS)
        self.error = [Fraction(0)] * len(INTEGRALS)

    def stretches(self, piece: Piece, bounds: tuple[Fraction, ...]) -> Iterator[Stretch]:
        """A piece with its integrals, in parts where no circle works for the whole."""

        def around(part: Piece, _: int) -> tuple[Piece, cauchy.Circle, flint.arb]:
            circle = cauchy.circle_bound(part, rates_of_integrals, self.circles)
            with flint.ctx.workprec(self.bits):
                return part, circle, cauchy.moved(bounds, circle.rho)

        for part, circle, apart in cauchy.in_parts(piece, around):
            yield self._stretch(part, bounds, circle, apart)

    def _stretch(
        self, piece: Piece, bounds: tuple[Fraction, ...], circle: cauchy.Circle, apart: flint.arb
    ) -> Stretch:
        # To where Cauchy's estimate is below the grid.
        length = max(ceil(self.bits / log2(circle.radius)), len(piece.rows[0]))
        a = Samples.of(self.bits, length, circle.radius)
        with a.precision():
            step, unit = exact_ball(piece.h), flint.arb(2) ** -piece.grid
            values = rates_of_integrals(self.equations.convert(flint.acb, a), piece.samples(a))
            integrands = a.coefficients([step * x for x in values])
            rows = [self._row(piece, i, c) for i, c in enumerate(integrands)]
            for i, (row, integrand) in enumerate(zip(rows, integrands, strict=True)):
                rest = step * circle.values[i] * (a.left_out + apart)
                off = cauchy.defect([c * unit for c in row], integrand)
                self.error[i] += upper_fraction(off + rest)
                self.at[i] = Fraction(sum(row), 2**piece.grid)
        return Stretch(
            replace(piece, rows=piece.rows + tuple(map(tuple, rows))), bounds + tuple(self.error)
        )

    def _row(self, piece: Piece, i: int, integrand: Sequence[flint.arb]) -> list[int]:
        """Integers of an integral's polynomial; where it begins may have to be rounded."""
        first = round(self.at[i] * 2**piece.grid)
        self.error[i] += abs(self.at[i] - Fraction(first, 2**piece.grid))
        powers = range(1, len(piece.rows[0]))
        return [first, *(to_grid(integrand[m - 1] / m, piece.grid) for m in powers)]


Progress = Callable[[float], None]

_NOTHING_BITS = 166
"""An enclosure of zero is published as zero where it is narrower than 2^-166 = 1e-50."""

_SMALLEST_SCALE = 2.0**-40
"""Of the dense columns, so that one that vanishes (the longitudinal force on a rear wheel without
inertia, say) has coefficients of zero: its grid of 2^-152 is far above the width of its balls."""


def tabulate_motion(
    run: Trajectory, certificate: Certificate, progress: Progress = lambda _: None
) -> tuple[Values, Dense]:
    """The whole motion along a certified candidate: rows, and dense output where there is.

    Raises
    ------
    NotCertifiedError
        A column is not shown to be analytic.
    UndecidedError
        Enclosures that do not decide a rounding, named.
    """
    stretches = list(with_integrals(run, certificate))
    rows = round_motion(run, stretches, progress)
    parts = list(motion_expansions(stretches))
    scales = {name: max(rows.scale(name), _SMALLEST_SCALE) for name in DENSE_COLUMNS}
    dense = interpolate(_Source(parts, Balls(BITS)), scales, {})
    return rows, bound_motion(run, parts, dense)


def motion_expansions(stretches: Sequence[Stretch]) -> Iterator[Expansion]:
    """Expansions of the dense columns along all pieces."""
    along = Expanded.of(stretches[0].piece.run, dense_columns)
    for stretch in stretches:
        yield from expansions(stretch.piece, stretch.bounds, along)


def bound_motion(run: Trajectory, parts: Sequence[Expansion], dense: Dense) -> Dense:
    """The dense output of a motion with its certified bounds."""
    return bound_pieces(run, parts, dense, DENSE_COLUMNS, {})


def round_motion(
    run: Trajectory, stretches: Sequence[Stretch], progress: Progress = lambda _: None
) -> Values:
    """The rows of `MOTION_COLUMNS`, rounded.

    hi and lo are zero where the enclosure holds zero, and is so narrow that the bound says all
    there is to know.
    """
    names = [c.name for c in MOTION_COLUMNS]
    rows = _enclosed(run, stretches, progress)
    return Values(*round_columns(run.maneuver, names, rows, _rounded))


def _enclosed(
    run: Trajectory, stretches: Sequence[Stretch], progress: Progress
) -> Iterator[dict[str, flint.arb]]:
    """Enclosures of all columns at the rows."""
    balls = NonnegativeRoots(run.bits + EVALUATION_BITS)
    starts = [s.piece.t0 for s in stretches]
    at, polynomials = -1, [flint.arb_poly()]
    equations = Equations.of(run.bicycle, balls, is_regular=run.is_regular)
    with balls.precision():
        for t in row_times(run.maneuver):
            if (i := bisect_right(starts, t) - 1) != at:
                at, polynomials = i, [flint.arb_poly(list(row)) for row in stretches[i].piece.rows]
            piece = stretches[i].piece
            s, unit = exact_ball((t - piece.t0) / piece.h), flint.arb(2) ** -piece.grid
            state = [
                flint.arb(p(s) * unit, exact_ball(bound).upper())
                for p, bound in zip(polynomials, stretches[i].bounds, strict=True)
            ]
            if t == 0:
                # The integrals begin at zero, exactly, and the yaw with them.
                state[6:] = [balls.number(0)] * len(state[6:])
            yield motion_columns(equations, state)
            progress(float(t))


def _rounded(x: flint.arb, name: str) -> tuple[float, float, float]:
    """hi, lo and bound."""
    if not x.is_finite():
        raise UndecidedError(f"{name}: the digits at hand do not enclose it")
    enclosed = Enclosure.of(x)
    hi, lo = 0.0, 0.0
    if not _is_nothing(enclosed):
        nearest = enclosed.binary64()
        if nearest is not None and _is_nothing(enclosed.minus(nearest)):
            hi = nearest
        else:
            hi, lo = hi_lo(enclosed, name)
    return hi, lo, few_bits(distance(enclosed, hi, lo))


def _is_nothing(x: Enclosure) -> bool:
    """True if an enclosure holds zero and is narrow."""
    return x.low <= 0 <= x.high and (x.high - x.low) << _NOTHING_BITS <= 1 << x.grid


class _Source:
    """The expansions as something to interpolate."""

    def __init__(self, parts: Sequence[Expansion], balls: Balls) -> None:
        self.parts, self.balls = parts, balls
        self.end = parts[-1].t1
        self._starts = [part.t0 for part in parts]

    def near(self, t: flint.arb, about: Fraction) -> dict[str, flint.arb]:
        part = self.parts[max(bisect_right(self._starts, about) - 1, 0)]
        s = (t - exact_ball(part.t0)) / exact_ball(part.h)
        return {name: p(s) for name, p in zip(DENSE_COLUMNS, part.polynomials, strict=True)}

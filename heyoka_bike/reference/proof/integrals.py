"""Place and wheel angles along a candidate, as polynomials with certified bounds.

They are integrals of functions g of the state. On each piece of the candidate p the Taylor
coefficients of h g(p(s)) (see `samples`) are integrated in balls, and those of the integral rounded
to the candidate's grid: a polynomial q. Its distance from the exact integral grows over a piece by
at most

- ``q' - h g(p)``: the coefficients' absolute values, and beyond these Cauchy's estimate on a circle
  (see `cauchy`);
- ``h g(x) - h g(p)`` for the exact state x, which the certificate keeps near p: its distance times
  the derivatives of g, bounded on the polydisc around p.

A piece on which no circle works is halved, exactly.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, log2

import flint

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import INTEGRALS, rates_of_integrals
from heyoka_bike.motion.trajectory import Certificate, Piece, Trajectory
from heyoka_bike.numbers.arithmetic import Balls, exact_ball, to_grid, upper_fraction
from heyoka_bike.numbers.ball_matrices import total
from heyoka_bike.numbers.samples import Samples
from heyoka_bike.reference.proof.cauchy import (
    Circle,
    circle_bound,
    circle_equations,
    in_parts,
    moved,
)

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
        self.circles = circle_equations(run)
        self.equations = Equations.of(run.bicycle, Balls(self.bits), is_regular=run.is_regular)
        self.at = [Fraction(0)] * len(INTEGRALS)
        self.error = [Fraction(0)] * len(INTEGRALS)

    def stretches(self, piece: Piece, bounds: tuple[Fraction, ...]) -> Iterator[Stretch]:
        """A piece with its integrals, in parts where no circle works for the whole."""

        def around(part: Piece, _: int) -> tuple[Piece, Circle, flint.arb]:
            circle = circle_bound(part, rates_of_integrals, self.circles)
            with flint.ctx.workprec(self.bits):
                return part, circle, moved(bounds, circle.rho)

        for part, circle, apart in in_parts(piece, around):
            yield self._stretch(part, bounds, circle, apart)

    def _stretch(
        self, piece: Piece, bounds: tuple[Fraction, ...], circle: Circle, apart: flint.arb
    ) -> Stretch:
        # To where Cauchy's estimate is below the grid.
        length = max(ceil(self.bits / log2(circle.radius)), len(piece.rows[0]))
        a = Samples.of(self.bits, length, circle.radius)
        with a.precision():
            step = exact_ball(piece.h)
            values = rates_of_integrals(self.equations.convert(flint.acb, a), piece.samples(a))
            integrands = a.coefficients([step * x for x in values])
            rows = [self._row(piece, i, c) for i, c in enumerate(integrands)]
            for i, (row, integrand) in enumerate(zip(rows, integrands, strict=True)):
                rest = step * circle.values[i] * (a.left_out + apart)
                self.error[i] += upper_fraction(_defect(piece, row, integrand) + rest)
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


def _defect(piece: Piece, row: Sequence[int], integrand: Sequence[flint.arb]) -> flint.arb:
    """Sum of the absolute coefficients of q' - h g, as far as they were found."""
    unit = flint.arb(2) ** -piece.grid
    slopes = [m * c * unit for m, c in enumerate(row)][1:]
    slopes += [flint.arb(0)] * (len(integrand) - len(slopes))
    return total(abs(x - c) for x, c in zip(slopes, integrand, strict=True))

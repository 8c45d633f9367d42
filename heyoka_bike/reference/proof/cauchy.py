"""Bounds of analytic functions of the state on a circle around a piece of a candidate.

With s = (t - t0) / h, the candidate p(s) is a polynomial and makes sense for complex s. A function
F of the state (the equations of motion, the columns) is evaluated for abs(s) = R and for all states
within rho_j of p(s) in variable j. What is found there bounds F inside, its Taylor
coefficients in s, and, by Cauchy's estimate in the state, its derivatives: on the polydisc of half
the radii the derivative by variable j is at most M / (rho_j / 2), at its centre M / rho_j.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeVar

import flint
import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.trajectory import Piece, Trajectory
from heyoka_bike.numbers.analytic import NotAnalyticError, Rim, array
from heyoka_bike.numbers.arithmetic import Balls, Number, exact_ball
from heyoka_bike.numbers.ball_matrices import largest, total

SIZE = 7
"""State variables, the yaw included."""

RADII = (4, 3, 2)
"""Circles tried on a piece, in its lengths, the largest first."""

RHO = tuple(Fraction(1, 2**k) for k in (8, 8, 8, 6, 6, 6, 8, 8, 8, 8, 8))
"""Radii of the polydisc around the candidate's state: rad for angles, rad/s for rates; then, where
they are carried along, m and rad for the integrals (see `whole_motion`)."""

SMALLER = (1, 64)
"""The radii over these are tried in turn: where a bicycle is about to fall the formulas' own
overestimation takes the first for a divisor that vanishes."""

SMALLER_STILL = (64**2, 64**3, 64**4)
"""Of these the first that is small enough is tried besides, where those are not. A part of a piece
has no smaller polydisc than the whole, so halving does not help there: a mechanical trail near
zero, of which squares are taken, makes a divisor of a few millimetres one of nothing."""

_MARGIN = 4
"""A polydisc is small enough if one so many times larger is enclosed around a single state."""

DEPTH = 6
"""Largest number of halvings of a piece where something cannot be shown on the whole of it."""

_BITS_OF_ARCS = 64
_FIRST_ARCS, _PROBED_ARCS, _MOST_ARCS = 8, 16, 1024
# Parts of it.
_HALF_CIRCLE = [
    (Fraction(j, _FIRST_ARCS), Fraction(j + 1, _FIRST_ARCS)) for j in range(_FIRST_ARCS)
]

Function = Callable[[Equations, Sequence[Number]], list[Number]]
"""Of a bicycle and a state of its form."""


_Found = TypeVar("_Found")


class TooLongError(Exception):
    """A piece over which the proof does not work, and why; its halves may do."""


@dataclass(frozen=True)
class Circle:
    """A circle inside of which F is analytic, and bounds on abs(F_i) on it and on the polydisc.

    Attributes
    ----------
    radius : int
        R, in lengths of the piece.
    rho : list of arb
        Radii of the polydisc.
    values : list of arb
    """

    radius: int
    rho: list[flint.arb]
    values: list[flint.arb]


def circle_equations(run: Trajectory) -> Equations:
    """The equations of a run in the precision of circles."""
    return run.equations(Balls(_BITS_OF_ARCS))


def circle_bound(
    piece: Piece, function: Function, equations: Equations, radii: Sequence[int] = RADII
) -> Circle:
    """Bound a function on the first of some circles inside of which it is shown analytic.

    `equations` are those of `circle_equations`.

    Raises
    ------
    NotAnalyticError
        On no circle tried.
    """
    reason = ""
    for polydisc in _polydiscs(piece, function, equations):
        for radius in radii:
            try:
                values = _values(piece, function, equations, radius, polydisc)
                return Circle(radius, polydisc, values)
            except NotAnalyticError as e:
                reason = str(e)
    raise NotAnalyticError(f"no analyticity shown for abs(s) <= {radii[-1]}: {reason}")


def _polydiscs(piece: Piece, function: Function, equations: Equations) -> Iterator[list[flint.arb]]:
    """Radii of the polydiscs to be tried in turn, each where the one before has failed."""
    first = rho(len(piece.rows))
    for smaller in SMALLER:
        last = [x / smaller for x in first]
        yield last
    if _is_small(piece, function, equations, last):
        return
    for smaller in SMALLER_STILL:
        last = [x / smaller for x in first]
        if _is_small(piece, function, equations, last):
            yield last
            return


def rho(variables: int = SIZE) -> list[flint.arb]:
    """The first of `RHO` as numbers of flint's; exact at any precision."""
    return [exact_ball(x) for x in RHO[:variables]]


def moved(bounds: Sequence[Fraction], polydisc: Sequence[flint.arb]) -> flint.arb:
    """Bound on the change of a function from the candidate to the exact state, over M.

    Derivatives by the state are at most M / (rho / 2) where the state is within rho / 2 of the
    candidate, which is checked: it must be so near.

    Raises
    ------
    NotAnalyticError
        It may be farther.
    """
    shares = [exact_ball(b) / x for b, x in zip(bounds, polydisc, strict=True)]
    if not all(2 * share <= 1 for share in shares):
        raise NotAnalyticError("the exact motion may leave half the polydisc around the candidate")
    return 2 * total(shares)


def defect(row: Sequence[flint.arb], rates: Sequence[flint.arb]) -> flint.arb:
    """Sum of the absolute coefficients of p' - f: at most so large it is for abs(s) <= 1.

    Coefficients of p and of f by power.
    """
    difference = flint.arb_poly(row).derivative() - flint.arb_poly(rates)
    return total(map(abs, difference.coeffs()))


def refused(piece: Piece, why: str) -> NotCertifiedError:
    """The error for a piece that is not certified."""
    run = piece.run
    return NotCertifiedError(
        f"{run.maneuver.name}: step {piece.step + 1} of {run.steps}, t = {float(piece.t0):g} to "
        f"{float(piece.t1):g} s, is not certified: {why}"
    )


def in_parts(
    piece: Piece, attempt: Callable[[Piece, int], _Found], depth: int = 0
) -> Iterator[_Found]:
    """Yield what `attempt` finds on a piece, or on its halves where it fails, in order of time.

    Parameters
    ----------
    piece : Piece
    attempt
        Told a part, and how often it was halved.

    Raises
    ------
    NotCertifiedError
        It fails on the smallest parts.
    """
    try:
        found = attempt(piece, depth)
    except (TooLongError, NotAnalyticError) as e:
        if depth == DEPTH:
            raise refused(piece, str(e)) from None
        for half in piece.halves():
            yield from in_parts(half, attempt, depth + 1)
        return
    yield found


def _values(
    piece: Piece, function: Function, equations: Equations, radius: int,
    polydisc: Sequence[flint.arb],
) -> list[flint.arb]:  # fmt: skip
    a = Rim(_BITS_OF_ARCS)
    on_rim = equations.over(a)
    with equations.precision():
        unit = flint.arb(2) ** -piece.grid
        rows = [[flint.arb(c) * unit for c in row] for row in piece.rows]
        polynomials = [flint.acb_poly([flint.acb(c) for c in row]) for row in rows]
        slopes = [_slope_bound(row, radius) for row in rows]
        # Real polynomials take conjugate values at conjugate points: half a circle is enough.
        arcs, biggest = _HALF_CIRCLE, list[flint.arb]()
        while arcs:
            a.start(len(arcs))
            parts = [_arc(polynomials, slopes, polydisc, radius, *arc) for arc in arcs]
            state = [a.value(array(x)) for x in zip(*parts, strict=True)]
            values = [_complex(x, len(arcs)) for x in function(on_rim, state)]
            is_done = [
                clear and all(x.is_finite() for x in on_arc)
                for clear, *on_arc in zip(a.clear, *values, strict=True)
            ]
            sizes = [_largest(value, is_done) for value in values]
            biggest = [m.max(x) for m, x in zip(biggest, sizes, strict=True)] if biggest else sizes
            left = [arc for arc, done in zip(arcs, is_done, strict=True) if not done]
            arcs = [part for arc in left for part in _parts(*arc, a.reason)]
        return biggest


def _is_small(
    piece: Piece, function: Function, equations: Equations, polydisc: Sequence[flint.arb]
) -> bool:
    """Tell whether F is enclosed on a polydisc some times larger, around the middle of a piece."""
    a = Rim(_BITS_OF_ARCS)
    with equations.precision():
        a.start(1)
        unit, middle = flint.arb(2) ** -piece.grid, flint.arb(1) / 2
        state = []
        for row, margin in zip(piece.rows, polydisc, strict=True):
            wide = flint.arb(0, (_MARGIN * margin).upper())
            p = flint.arb_poly([flint.arb(c) * unit for c in row])(middle)
            state.append(a.value(array([flint.acb(p + wide, wide)])))
        values = [_complex(x, 1) for x in function(equations.over(a), state)]
    return bool(a.clear.all()) and all(x.is_finite() for (x,) in values)


def _largest(values: Sequence[flint.acb], is_done: Sequence[bool]) -> flint.arb:
    """The largest size on the arcs that are done, exact: of balls it would be a wider ball."""
    return largest(abs(x).upper() for x, done in zip(values, is_done, strict=True) if done)


def _slope_bound(row: Sequence[flint.arb], radius: int) -> flint.arb:
    """A bound of abs(p') on the disc, by its coefficients."""
    return total(m * abs(c) * flint.arb(radius) ** (m - 1) for m, c in enumerate(row) if m)


def _parts(low: Fraction, high: Fraction, reason: str) -> list[tuple[Fraction, Fraction]]:
    """The halves of an arc that is not the smallest, and of some a smallest part.

    Where that is refused, so is the circle, and soon.
    """
    if (high - low) * _MOST_ARCS <= 1:
        raise NotAnalyticError(reason or "a value is not finite")
    middle = (low + high) / 2
    halves = [(low, middle), (middle, high)]
    is_probed = (high - low) * _PROBED_ARCS == 1
    return [*halves, (middle, middle + Fraction(1, _MOST_ARCS))] if is_probed else halves


def _arc(
    polynomials: Sequence[flint.acb_poly], slopes: Sequence[flint.arb],
    polydisc: Sequence[flint.arb], radius: int, low: Fraction, high: Fraction,
) -> list[flint.acb]:  # fmt: skip
    """States on an arc, angles in units of pi, each a ball that holds the arc and the polydisc."""
    middle, half = (low + high) / 2, (high - low) / 2
    q = flint.fmpq(middle.numerator, middle.denominator)
    centre = flint.acb(flint.arb.cos_pi_fmpq(q), flint.arb.sin_pi_fmpq(q)) * radius
    reach = radius * flint.arb.pi() * flint.fmpq(half.numerator, half.denominator)
    state = []
    for p, slope, margin in zip(polynomials, slopes, polydisc, strict=True):
        wide = flint.arb(0, (slope * reach + margin).upper())
        state.append(p(centre) + flint.acb(wide, wide))
    return state


def _complex(x: Number, arcs: int) -> list[flint.acb]:
    """The values on all arcs."""
    found = x.x if hasattr(x, "rim") else flint.acb(x)
    return list(found) if isinstance(found, np.ndarray) else [found] * arcs

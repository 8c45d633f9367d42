"""Bounds of analytic functions of the state on a circle around a piece of a candidate.

With s = (t - t0) / h, the candidate p(s) is a polynomial and makes sense for complex s. A function
F of the state (the equations of motion, the columns) is evaluated for abs(s) = R and for all states
within rho_j of p(s) in variable j. The bound M found there also bounds F inside the circle and its
Taylor coefficients in s. By Cauchy's estimate in the state it bounds the derivatives of F with
respect to variable j: they are at most M / (rho_j / 2) on the polydisc of half the radii, and at
most M / rho_j at its centre.
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
"""Number of state variables, including the yaw."""

RADII = (4, 3, 2)
"""Radii of the circles tried on a piece, in lengths of the piece, the largest first."""

RHO = tuple(Fraction(1, 2**k) for k in (8, 8, 8, 6, 6, 6, 8, 8, 8, 8, 8))
"""Radii of the polydisc around the candidate's state: rad for angles and rad/s for rates, followed
by m and rad for the integrals if they are part of the state (see `whole_motion`)."""

SMALLER = (1, 64)
"""Divisors of the radii, tried in turn. For a bicycle about to fall, the formulas overestimate so
much that a divisor could vanish in the first polydisc."""

SMALLER_STILL = (64**2, 64**3, 64**4)
"""Further divisors, of which the first that makes the polydisc small enough is tried as well.
Halving a piece does not help there, as its parts have no smaller polydisc: if the mechanical trail
is near zero, its square makes a divisor of a few millimetres nearly zero."""

_MARGIN = 4
"""A polydisc is small enough if one larger by this factor is enclosed around a single state."""

DEPTH = 6
"""Maximum number of halvings of a piece on which something cannot be proved as a whole."""

_BITS_OF_ARCS = 64
_FIRST_ARCS, _PROBED_ARCS, _MOST_ARCS = 8, 16, 1024
# Arcs that cover the half circle: the angles of their ends, in units of pi.
_HALF_CIRCLE = [
    (Fraction(j, _FIRST_ARCS), Fraction(j + 1, _FIRST_ARCS)) for j in range(_FIRST_ARCS)
]

Function = Callable[[Equations, Sequence[Number]], list[Number]]
"""A function of the equations of a bicycle and a state in their number type."""


_Found = TypeVar("_Found")


class TooLongError(Exception):
    """The proof fails over a piece, for a stated reason; it may succeed over its halves."""


@dataclass(frozen=True)
class Circle:
    """A circle inside of which F is analytic, with bounds on abs(F_i) on it and on the polydisc.

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
    """Return the equations of a run, with the working precision that is used on circles."""
    return run.equations(Balls(_BITS_OF_ARCS))


def circle_bound(
    piece: Piece, function: Function, equations: Equations, radii: Sequence[int] = RADII
) -> Circle:
    """Bound a function on the first circle inside of which it is shown to be analytic.

    `equations` are the result of `circle_equations`.

    Raises
    ------
    NotAnalyticError
        The function is not shown to be analytic inside any of the circles.
    """
    reason = ""
    for polydisc in _polydiscs(piece, function, equations):
        for radius in radii:
            try:
                values = _values(piece, function, equations, radius, polydisc)
                return Circle(radius, polydisc, values)
            except NotAnalyticError as e:
                reason = str(e)
    raise NotAnalyticError(f"analyticity is not shown for abs(s) <= {radii[-1]}: {reason}")


def _polydiscs(piece: Piece, function: Function, equations: Equations) -> Iterator[list[flint.arb]]:
    """Yield the radii of the polydiscs to try in turn, each after the previous one has failed."""
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
    """Return the first radii of `RHO` as balls that are exact at any precision."""
    return [exact_ball(x) for x in RHO[:variables]]


def moved(bounds: Sequence[Fraction], polydisc: Sequence[flint.arb]) -> flint.arb:
    """Bound a function's change from the candidate to the exact state, divided by its bound M.

    Derivatives with respect to the state are at most M / (rho / 2) if the state is within rho / 2
    of the candidate. This function checks that it is.

    Raises
    ------
    NotAnalyticError
        The exact state may be farther from the candidate.
    """
    shares = [exact_ball(b) / x for b, x in zip(bounds, polydisc, strict=True)]
    if not all(2 * share <= 1 for share in shares):
        raise NotAnalyticError("the exact motion may leave half the polydisc around the candidate")
    return 2 * total(shares)


def defect(row: Sequence[flint.arb], rates: Sequence[flint.arb]) -> flint.arb:
    """Bound abs(p' - f) for abs(s) <= 1 by the sum of the absolute coefficients.

    The arguments are the coefficients of p and of f, lowest power first.
    """
    difference = flint.arb_poly(row).derivative() - flint.arb_poly(rates)
    return total(map(abs, difference.coeffs()))


def refused(piece: Piece, why: str) -> NotCertifiedError:
    """Return the error that reports a piece that could not be certified."""
    run = piece.run
    return NotCertifiedError(
        f"{run.maneuver.name}: step {piece.step + 1} of {run.steps}, t = {float(piece.t0):g} to "
        f"{float(piece.t1):g} s, is not certified: {why}"
    )


def in_parts(
    piece: Piece, attempt: Callable[[Piece, int], _Found], depth: int = 0
) -> Iterator[_Found]:
    """Yield the result of `attempt` on a piece, or on its halves where it fails, in order of time.

    Parameters
    ----------
    piece : Piece
    attempt
        Called with a part and the number of halvings that led to it.

    Raises
    ------
    NotCertifiedError
        `attempt` fails on one of the smallest parts.
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
        # Real polynomials have complex conjugate values at conjugate points, so it is enough to
        # bound the function on half of the circle.
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
    """True if F can be enclosed around a piece's middle, on a polydisc `_MARGIN` times larger."""
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
    """Return the largest absolute value on the finished arcs, as an exact number, not as a ball."""
    return largest(abs(x).upper() for x, done in zip(values, is_done, strict=True) if done)


def _slope_bound(row: Sequence[flint.arb], radius: int) -> flint.arb:
    """Bound abs(p') on the disc, by the absolute coefficients of p."""
    return total(m * abs(c) * flint.arb(radius) ** (m - 1) for m, c in enumerate(row) if m)


def _parts(low: Fraction, high: Fraction, reason: str) -> list[tuple[Fraction, Fraction]]:
    """Return the halves of an arc; at one level of halving add a smallest part as a probe.

    If the probe fails, the circle fails early instead of after all halvings.
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
    """Return balls that contain the states on an arc (in units of pi) and their polydiscs."""
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
    """Return the value of a function on each arc; a constant is repeated."""
    found = x.x if hasattr(x, "rim") else flint.acb(x)
    return list(found) if isinstance(found, np.ndarray) else [found] * arcs

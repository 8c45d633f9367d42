"""Adaptive Taylor integration with heyoka, at any precision, behind one call.

heyoka supplies the Taylor coefficients and the step size. The step is then cut back to a dyadic
number of few bits, so that breaks are exact in binary64, and the state is carried from step to step
as exact integers with 16 bits more than the run's precision. The increments of a step are rounded,
but not their sum (compensated summation), so roundoff does not grow with the number of steps.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import flint

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.kinematics import posture, turn_divisor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.errors import InputError, SingularMotionError
from heyoka_bike.motion.heyoka_adapter import (
    Expressions,
    NativeNumbers,
    Outcome,
    TaylorIntegrator,
    constant,
    variables,
)
from heyoka_bike.motion.trajectory import OnTime, Trajectory
from heyoka_bike.numbers.arithmetic import Arrays, Balls, midpoint, to_grid
from heyoka_bike.numbers.double import with_usual_errors
from heyoka_bike.numbers.precision import Precision

GUARD_BITS = 16
_BREAK_BITS = 6  # the rounding of its end shortens a step by at most 2^-6 of its length
# Minimum length of a step [s]. A Taylor step is a fixed fraction of the distance to the nearest
# singularity, so a shorter step indicates that a singularity is near.
_MIN_STEP = 2.0**-30
LEAST_TRAIL = 0.02
"""Mechanical trail, in radii of the front wheel, below which the regular form is used."""

_log = logging.getLogger(__name__)


def right_hand_side(
    bicycle: Bicycle, precision: Precision, *, is_regular: bool = False, with_yaw: bool = True
) -> list[tuple[Any, Any]]:
    """Return the equations as heyoka expressions: pairs of variable and time derivative.

    Every constant is the exact value, correctly rounded to the precision.
    """
    native = NativeNumbers(precision)
    exact = Equations.of(bicycle, Balls(2 * precision.bits + 64), is_regular=is_regular)
    with exact.precision():
        equations = exact.convert(
            lambda x: constant(native.from_integer(*_mantissa(x, precision.bits))), Expressions()
        )
    state = variables(equations.states)
    rates = equations.rates_with_yaw(state)
    count = len(state) if with_yaw else len(state) - 1
    return list(zip(state[:count], rates[:count], strict=True))


@with_usual_errors
def integrate(
    bicycle: Bicycle,
    maneuver: Maneuver,
    precision: Precision | str | int = "binary64",
    *,
    tolerance: float | None = None,
    is_regular: bool | None = None,
    least_trail: float = LEAST_TRAIL,
    progress: OnTime | None = None,
) -> Trajectory:
    """Integrate a maneuver from 0 to its duration.

    Parameters
    ----------
    bicycle, maneuver
        The bicycle and the maneuver to integrate.
    precision
        See `Precision.of`.
    tolerance : float, optional
        Relative tolerance of heyoka's step; by default a quarter of the precision's epsilon over
        the largest state.
    is_regular : bool, optional
        Form of the equations; by default the few-product form, or the regular one if the mechanical
        trail comes near zero.
    least_trail : float, optional
        Mechanical trail below which the regular form is used [radii of the front wheel].
    progress : callable, optional
        Called with the time reached [s].

    Returns
    -------
    Trajectory
        Piecewise polynomials in time, of all state variables.

    Raises
    ------
    InputError
        The initial state is unreachable, or the tolerance is not usable.
    SingularMotionError
        The motion meets a singularity before its end.
    MissingPackageError
        heyoka is not installed.
    """
    p = precision if isinstance(precision, Precision) else Precision.of(precision)
    if is_regular is None:
        try:
            return _integrate(bicycle, maneuver, p, tolerance, False, least_trail, progress)
        except TrailTooSmallError:
            is_regular = True
    return _integrate(bicycle, maneuver, p, tolerance, is_regular, least_trail, progress)


class TrailTooSmallError(Exception):
    """The mechanical trail has become too small for the few-product form of the equations."""


def _integrate(
    bicycle: Bicycle, maneuver: Maneuver, precision: Precision, tolerance: float | None,
    is_regular: bool, least_trail: float, progress: OnTime | None,
) -> Trajectory:  # fmt: skip
    native = NativeNumbers(precision)
    grid = precision.bits + GUARD_BITS
    equations = Equations.of(bicycle, Balls(precision.bits + 64), is_regular=is_regular)
    with equations.precision():
        start = initial_state(equations, maneuver)
        watch = _Watch(equations, least_trail)
        watch.check([float(x.mid()) for x in start], 0.0)
        state = [to_grid(x, grid) for x in start]
    end = _dyadic_above(maneuver.duration)
    adaptive = _adaptive(bicycle, precision, native, state, grid, tolerance, is_regular)
    breaks, pieces = [Fraction(0)], []
    while breaks[-1] < end:
        t = breaks[-1]
        adaptive.begin(native.from_integer(0, 0), [native.from_integer(x, grid) for x in state])
        # The natural step of a steady motion is infinite, so the step is limited to the rest of the
        # run.
        rest = native.from_integer((end - t).numerator, (end - t).denominator.bit_length() - 1)
        step = adaptive.step(rest)
        natural = step.length
        is_lost = step.outcome == Outcome.NOT_FINITE or not math.isfinite(natural)
        if is_lost or natural < _MIN_STEP:
            raise watch.singular([x / 2**grid for x in state], float(t))
        h = end - t if natural >= float(rest) else _dyadic_below(natural)
        piece = _piece(native, step.coefficients, state, h, grid)
        pieces.append(piece)
        breaks.append(t + h)
        state = [sum(c) for c in piece]
        watch.check([x / 2**grid for x in state], float(t + h))
        if progress is not None:
            progress(float(min(t + h, maneuver.duration)))
    _log.info(
        "%s: %d steps of order %d to %g s, %s, %s form", maneuver.name, len(pieces), adaptive.order,
        float(breaks[-1]), precision.name, "regular" if is_regular else "few-product",
    )  # fmt: skip
    return Trajectory(
        bicycle=bicycle, maneuver=maneuver, precision=precision.name, bits=precision.bits,
        is_regular=is_regular, order=adaptive.order, grid=grid,
        breaks=tuple(breaks), pieces=tuple(pieces),
    )  # fmt: skip


def _adaptive(
    bicycle: Bicycle, precision: Precision, native: NativeNumbers, state: Sequence[int], grid: int,
    tolerance: float | None, is_regular: bool,
) -> TaylorIntegrator:  # fmt: skip
    if tolerance is None:
        tol = native.from_integer(1, precision.bits + 5)
    elif 2.0**-precision.bits / 64 <= tolerance < 1:
        exact = Fraction(tolerance)
        tol = native.from_integer(exact.numerator, exact.denominator.bit_length() - 1)
    else:
        raise InputError(
            f"found tolerance {tolerance:g}, expected between {2.0**-precision.bits / 64:g} and 1"
        )
    # Code for MPFR is not optimised, because a step spends its time in MPFR itself. Optimising
    # would take a second, five times as long as compiling, and change no digit.
    return TaylorIntegrator(
        right_hand_side(bicycle, precision, is_regular=is_regular),
        [native.from_integer(x, grid) for x in state],
        native.type,
        bits=precision.bits if native.is_mpfr else None,
        tolerance=tol,
        is_optimised=not native.is_mpfr,
    )


def _piece(
    native: NativeNumbers, coefficients: Any, state: Sequence[int], h: Fraction, grid: int
) -> tuple[tuple[int, ...], ...]:
    """Return polynomials in s = t / h as integers times 2^-grid; the state is the constant term."""
    halvings = h.denominator.bit_length() - 1
    piece = []
    for x0, row in zip(state, coefficients, strict=True):
        out, power = [x0], 1
        for order, c in enumerate(row[1:], start=1):
            power *= h.numerator
            # Integer nearest to c h^order 2^grid. If a step is longer than 1 s, the conversion
            # keeps more bits.
            shift = grid + max(power.bit_length() - order * halvings, 0)
            scaled = native.to_integer(c, shift) * power
            drop = shift - grid + order * halvings
            out.append((scaled + ((1 << drop) >> 1)) >> drop)
        piece.append(tuple(out))
    return tuple(piece)


class _Watch:
    """Watches divisors of the equations, which become zero at singularities."""

    def __init__(self, equations: Equations, least_trail: float) -> None:
        self.least_trail = least_trail
        self.k = equations.k.convert(lambda x: float(x.mid()))
        self.is_regular = equations.is_regular
        self.side: bool | None = None

    def check(self, state: Sequence[float], t: float) -> None:
        """Leave the few-product form if the mechanical trail is small or changes sign."""
        o = posture(self.k, Arrays(), state[0], state[1], state[2])
        if self.is_regular:
            return
        trail = o.trail / self.k.front.r
        side = trail > 0
        if abs(trail) < self.least_trail or (self.side is not None and side != self.side):
            raise TrailTooSmallError
        self.side = side

    def singular(self, state: Sequence[float], t: float) -> SingularMotionError:
        """Return the error for a motion that cannot be continued past `t`."""
        roll, pitch, steer = state[:3]
        o = posture(self.k, Arrays(), roll, pitch, steer)
        candidates = {
            "the rear wheel lies on the floor": abs(o.cos_roll),
            "the front wheel lies on the floor": abs(o.cos_roll * o.kappa),
            "the front wheel's heading is across the steer plane": abs(o.cb_f),
            "the rolling conditions of the wheels become dependent": abs(o.den),
        }
        if self.is_regular:
            # The motion itself can continue, but the state variables of the regular form no longer
            # describe it; see `rear_rates`.
            turn = "roll and steer rate no longer give the turn rate"
            candidates[turn] = abs(turn_divisor(o))
        what = min(candidates, key=candidates.__getitem__)
        if candidates[what] > 1e-2:
            what = "the accelerations grow without bound"
        return SingularMotionError(
            f"the motion meets a singularity at t = {t:.9g} s: {what} "
            f"(roll {roll:.4g} rad, pitch {pitch:.4g} rad, steer {steer:.4g} rad)",
            t,
        )


def _mantissa(x: flint.arb, bits: int) -> tuple[int, int]:
    """Return the midpoint of a ball as n 2^-grid; the ball must determine `bits` bits."""
    if not x.is_exact() and x.rel_accuracy_bits() < bits + 8:
        raise ArithmeticError(f"constant {x} is not known to {bits} bits")
    return midpoint(x)


def _dyadic_below(h: float) -> Fraction:
    """Return the largest dyadic number of few bits that is not above h."""
    mantissa, exponent = math.frexp(h)
    return Fraction(math.floor(mantissa * 2**_BREAK_BITS)) * Fraction(2) ** (exponent - _BREAK_BITS)


def _dyadic_above(t: Fraction) -> Fraction:
    """Return the smallest multiple of 2^-20 that is not below t."""
    return Fraction(math.ceil(t * 2**20), 2**20)

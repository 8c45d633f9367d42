"""An integrator that is independent of the one behind the published motion, without heyoka.

It takes the equations in their regular form, expands the motion in its own Taylor series in ball
arithmetic, and chooses its own steps. It shares with the published run the constants and kinematics
of the bicycle, the initial state, and the format of the result, so that
`heyoka_bike.reference.proof.enclose.enclose` can bound its error too.

The series of one step follows from Newton's method for x' = f(x). A few coefficients are found one
by one, by Picard's iteration, and with them the Jacobian J of f along the motion, to a length of m.
When p has n right coefficients, the rest e of the motion obeys e' = f(p) - p' + J e up to terms of
higher order, a linear recurrence for m + 1 more coefficients.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import flint

from heyoka_bike.bicycle.equations.constants import Constants, constants
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.kinematics import unfold
from heyoka_bike.bicycle.equations.model import regular
from heyoka_bike.bicycle.equations.outputs import yaw_rate
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.dual import Dual, Duals
from oracles.power_series import PowerSeries

Coefficients = list[list[flint.arb]]
"""Taylor coefficients in time, by state variable and power."""

ORDER = 50
_GUARD_BITS = 16  # additional bits of the stored coefficients, beyond the precision
_WORKING_BITS = 32  # additional bits of the balls, beyond the stored coefficients
_FIRST = 12  # number of coefficients that are found one by one, and number of terms of the Jacobian
_TOLERANCE_BITS = 4  # the last terms are this many bits below the precision
_RASTER = 2**10  # steps are multiples of 1 s / _RASTER
_LAST_TERMS = 3  # number of last terms whose size limits the step
_VARIABLES = 6  # number of state variables without the yaw


def integrate(
    bicycle: Bicycle, maneuver: Maneuver, bits: int = 160, order: int = ORDER
) -> Trajectory:
    """Integrate a maneuver from 0 to its duration, without a bound on the error."""
    grid = bits + _GUARD_BITS
    expansion = _Expansion(bicycle, grid + _WORKING_BITS, order)
    balls = Balls(expansion.bits)
    with balls.precision():
        start = initial_state(Equations.of(bicycle, balls), maneuver)
        state = [_to_grid(x, grid) for x in start]
    end = Fraction(math.ceil(maneuver.duration * _RASTER), _RASTER)
    breaks, pieces = [Fraction(0)], []
    while breaks[-1] < end:
        with balls.precision():
            coefficients = expansion.coefficients([flint.arb(n) / 2**grid for n in state])
            h = _step(coefficients, 2.0 ** -(bits + _TOLERANCE_BITS), end - breaks[-1])
            step = flint.arb(h.numerator) / h.denominator
            # The first coefficient is the state itself. Adding the other coefficients, which are
            # rounded, is exact.
            piece = tuple(
                tuple(_to_grid(c * step**power, grid) for power, c in enumerate(row))
                for row in coefficients
            )
        pieces.append(piece)
        breaks.append(breaks[-1] + h)
        state = [sum(row) for row in piece]
    return Trajectory(
        bicycle=bicycle,
        maneuver=maneuver,
        precision=f"{bits} bits",
        bits=bits,
        is_regular=True,
        order=order,
        grid=grid,
        breaks=tuple(breaks),
        pieces=tuple(pieces),
    )


class _Expansion:
    """Taylor coefficients of the motion from a state.

    The radii of the balls are dropped, because they would grow from coefficient to coefficient.
    """

    def __init__(self, bicycle: Bicycle, bits: int, order: int) -> None:
        self.bits, self.order = bits, order
        balls = Balls(bits)
        with balls.precision():
            self.k: Constants = constants(bicycle, balls).convert(lambda x: x.mid())

    def coefficients(self, state: Sequence[flint.arb]) -> Coefficients:
        """Return coefficients of all seven variables, including the yaw, up to the order."""
        *start, yaw = state
        known = [[x] for x in start]
        for n in range(1, _FIRST):
            for row, rate in zip(known, self._rates(known, n), strict=True):
                row.append(rate[n - 1] / n)
        jacobian = self._jacobian(known)
        while len(known[0]) <= self.order:
            self._extend(known, jacobian)

        # The yaw is an integral, and no other variable depends on it.
        a = PowerSeries(self.bits, self.order)
        with a.precision():
            o, u = unfold(self.k, a, [a.series(row[:-1]) for row in known], is_regular=True)
            turn = a.coefficients(yaw_rate(o, u))
            known.append([yaw, *(c.mid() / power for power, c in enumerate(turn, start=1))])
        return [[c.mid() for c in row] for row in known]

    def _extend(self, known: Coefficients, jacobian: Sequence[flint.arb_mat]) -> None:
        """Append as many coefficients by a Newton step as the Jacobian's length allows."""
        n = len(known[0])
        length = min(n + len(jacobian) + 1, self.order + 1)
        # The derivative p' has no terms of order n - 1 or higher. So in these orders, the terms of
        # f(p) - p' are those of f(p).
        defect = self._rates(known, length - 1)
        added: list[flint.arb_mat] = []
        for power in range(n, length):
            total = flint.arb_mat([[row[power - 1]] for row in defect])
            for j, e in enumerate(reversed(added)):
                total += jacobian[j] * e
            added.append((total / power).mid())
        for i, row in enumerate(known):
            row += [e[i, 0] for e in added]

    def _rates(self, known: Coefficients, length: int) -> Coefficients:
        """Return coefficients of f(p) up to a length, with p continued by zeros."""
        a = PowerSeries(self.bits, length)
        with a.precision():
            values = regular(self.k, a, [a.series(row[:length]) for row in known])
            return [[c.mid() for c in a.coefficients(x)] for x in values]

    def _jacobian(self, known: Coefficients) -> list[flint.arb_mat]:
        """Return coefficients of the Jacobian of f along p."""
        length = len(known[0])
        a = PowerSeries(self.bits, length)
        with a.precision():
            duals = Duals(a)
            values = regular(self.k, duals, duals.variables([a.series(row) for row in known]))
            slopes = [[a.coefficients(x) for x in _slopes(value)] for value in values]
        return [
            flint.arb_mat([[entry[m].mid() for entry in row] for row in slopes])
            for m in range(length)
        ]


def _slopes(value: Any) -> Sequence[Any]:
    return value.slopes if isinstance(value, Dual) else (0,) * _VARIABLES


def _step(coefficients: Coefficients, tolerance: float, rest: Fraction) -> Fraction:
    """Return the largest step on the raster with last terms below the tolerance [rad, rad/s]."""
    order = len(coefficients[0]) - 1
    longest = float(rest)
    for power in range(order - _LAST_TERMS + 1, order + 1):
        size = max(abs(float(row[power])) for row in coefficients)
        if size > 0:
            longest = min(longest, (tolerance / size) ** (1 / power))
    step = Fraction(math.floor(longest * _RASTER), _RASTER)
    if step == 0:
        raise ArithmeticError(f"a step of {longest:.3g} s is too short")
    return step


def _to_grid(x: flint.arb, grid: int) -> int:
    """Return the integer multiple of 2^-grid that is nearest to the middle of a ball."""
    mantissa, exponent = x.mid().man_exp()
    return round(Fraction(int(mantissa)) * Fraction(2) ** (int(exponent) + grid))

"""Recognise methods of integration and their steps by their modified equations.

To leading order, a method of order p with a step h follows the exact motion of another equation,
y' = f(y) + h^p d(y), where d is a sum of derivatives of f that only the method determines. So the
exact equations along the file's own motion have the residual h^p d, in the rates of the angles as
well as in the accelerations. A force has none in the rates. The coefficient h^p is fitted like that
of any force.

References
----------
E. Hairer, Ch. Lubich, G. Wanner (2006), Geometric Numerical Integration, chapter IX.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.double import STEP_OF_SECOND, Array
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS
from heyoka_bike.scoring.diagnosis.programs.integrators import METHODS
from heyoka_bike.scoring.diagnosis.residual.linear_fits import best_subsets, blocks
from heyoka_bike.scoring.diagnosis.residual.observed import Observed, state_vector
from heyoka_bike.scoring.ratios import CLEARLY

# Indices in the state: those of the roll and steer angle, and those of the roll rate, steer rate
# and rolling rate.
_ANGLES, _PLACES_OF_SPEEDS = [0, 2], [3, 4, 5]


CLOCK = "times on another scale"
"""Name of an error of the time scale, which is found like a method. Its step is the scale - 1."""

PARTS = ("first", "second", "of_angles", "bend", "chain")


class Scheme(NamedTuple):
    """A method of integration.

    Attributes
    ----------
    says
        Name of the method in messages.
    order
    angles
        Residual of the equations with a step of 1: coefficients of the derivatives in `PARTS`.
    speeds
        Residual of the equations of the speeds, if it has other coefficients.
    """

    says: str
    order: int
    angles: Mapping[str, float]
    speeds: Mapping[str, float] | None = None


def _of(
    code: str, angles: Mapping[str, float], speeds: Mapping[str, float] | None = None
) -> Scheme:
    """Make a scheme for one of the methods in `METHODS`, which can also be run."""
    (method,) = (m for m in METHODS if m.code == code)
    return Scheme(method.says, method.order, angles, speeds)


SCHEMES = (
    _of("explicit_euler", {"second": -1 / 2}),
    _of("implicit_euler", {"second": 1 / 2}),
    _of("semi_implicit_euler", {"second": 1 / 2}, {"second": -1 / 2}),
    Scheme(
        "semi-implicit Euler, positions first",
        1,
        {"second": -1 / 2},
        {"of_angles": 1.0, "second": -1 / 2},
    ),
    _of("heun_2", {"bend": 1 / 12, "chain": -1 / 6}),
    _of("explicit_midpoint", {"bend": -1 / 24, "chain": -1 / 6}),
    _of("trapezoidal", {"bend": 1 / 12, "chain": 1 / 12}),
    _of("implicit_midpoint", {"bend": -1 / 24, "chain": 1 / 12}),
    _of("adams_bashforth_2", {"bend": -5 / 12, "chain": -5 / 12}),
    Scheme("BDF2", 2, {"bend": 1 / 3, "chain": 1 / 3}),
    Scheme(CLOCK, 1, {"first": 1.0}),
)
"""Methods whose first error term is known, and an error of the time scale. The latter makes all
rates too large by the same factor."""


class Method(NamedTuple):
    """A method of integration that explains the residual.

    Attributes
    ----------
    says
        Name of the method in messages.
    order
    step
        [s]
    is_of_rows
        True if the distance of rows is a whole number of steps, or a step a whole number of rows,
        within the accuracy of the step.
    relief
        Factor by which the residual falls, a geometric mean.
    log_odds
        Log odds against none of the methods.
    """

    says: str
    order: int
    step: float
    is_of_rows: bool
    relief: float
    log_odds: float


def _derivatives(equations: Equations, y: Array) -> Array:
    """Compute the derivatives of the state that `PARTS` names, at given states, shape (5, 6, n).

    ``first`` is f, ``second`` f'f, ``of_angles`` the part of f'f from the angles, and ``bend`` and
    ``chain`` are the two parts f''(f, f) and f'f'f of the third derivative.
    """

    def f(y: Array) -> Array:
        return np.array(equations.rates(list(y)))

    def along(v: Array) -> Array:
        return (f(y + STEP_OF_SECOND * v) - f(y - STEP_OF_SECOND * v)) / (2 * STEP_OF_SECOND)

    first = f(y)
    second, of_angles = along(first), along(np.concatenate([first[:3], 0 * first[3:]]))
    bend = (
        f(y + STEP_OF_SECOND * first) - 2 * first + f(y - STEP_OF_SECOND * first)
    ) / STEP_OF_SECOND**2
    return np.array([first, second, of_angles, bend, along(second)])


def find_methods(equations: Equations, motions: Sequence[Observed]) -> tuple[Method, ...]:
    """Return the methods that explain the residual equally well; empty if none explains it."""
    kinds = [s.angles for s in SCHEMES], [s.speeds or s.angles for s in SCHEMES]
    table = [np.array([[by.get(name, 0.0) for name in PARTS] for by in each]) for each in kinds]
    rest, floors, terms = [], [], []
    for m in motions:
        y = np.array(state_vector(equations, m.state.__getitem__)[:6])
        parts = _derivatives(equations, y)
        parts[:, 5] *= equations.k.length
        speeds = _PLACES_OF_SPEEDS[: len(m.accelerations)]
        rest += [*m.kinematic, *(m.accelerations - parts[0, speeds] @ m.windows.T)]
        floors += [*m.kinematic_uncertain, *m.uncertain]
        for rows, factors in zip((_ANGLES, speeds), table, strict=True):
            each = np.tensordot(factors, parts[:, rows], 1) @ m.windows.T
            terms += list(np.moveaxis(each, 0, -1))
    b = blocks(rest, terms, [float(np.median(x)) for x in floors])
    fits = best_subsets(b, 1, len(SCHEMES))
    found = []
    for (i,), (size,), gain in zip(fits.members, fits.changes, fits.gains, strict=True):
        left = b.squares - 2 * size * b.moments[:, i] + size**2 * b.products[:, i, i]
        # Rounding may make this mean square negative.
        left = np.maximum(left, 0.0) + b.floors
        falls = np.log((b.squares + b.floors) / left).reshape(len(motions), -1) / 2
        # Integrators leave a residual in the equations of the angles. Forces and drifting
        # constraints do not. So compute the factor by which the method reduces this residual.
        of_angles = float(np.exp(np.mean(falls[:, : len(_ANGLES)])))
        # Assume that an equation of an angle's rate has as many independent values as an equation
        # of motion.
        seen = (
            THRESHOLDS.independent_values / len(_PLACES_OF_SPEEDS) * len(rest) * float(np.log(gain))
        )
        odds = seen - THRESHOLDS.value_cost - float(np.log(len(SCHEMES)))
        scheme, is_clock = SCHEMES[i], SCHEMES[i].says == CLOCK
        if of_angles > THRESHOLDS.explained_factor and (is_clock or size > 0.0):
            step = float(size) if is_clock else float(size) ** (1 / scheme.order)
            spacing = float(np.median(np.diff(motions[0].time)))
            near = None if is_clock else step_of_rows(step, spacing, float(gain))
            found.append(
                Method(scheme.says, scheme.order, near or step, near is not None, float(gain), odds)
            )
    # Methods whose first error terms are multiples of each other, such as those of BDF2, remain in
    # the order of `SCHEMES`.
    order = [s.says for s in SCHEMES]
    found.sort(key=lambda m: (-round(m.log_odds, 3), order.index(m.says)))
    least = max((m.log_odds for m in found), default=0.0) - THRESHOLDS.report_log_odds
    found = [m for m in found if m.log_odds > max(least, THRESHOLDS.report_log_odds)]
    # Prefer methods whose step fits the rows, because hardly any program interpolates its rows.
    return tuple([m for m in found if m.is_of_rows] or found)


def step_of_rows(step: float, spacing: float, relief: float) -> float | None:
    """Find a nearby step of which the row distance is a multiple or a fraction [s], or None.

    If a method reduces the error by a factor, the relative error of its step is about the inverse
    of that factor.
    """
    near = spacing / round(spacing / step) if step < spacing else spacing * round(step / spacing)
    # Rounding to nine digits removes the roundoff of the times from the step.
    is_near = abs(step - near) < near / max(relief, CLEARLY)
    return float(f"{near:.9g}") if is_near else None

"""Methods of integration and their steps, found by their modified equations.

A method of order p with a step h follows the exact motion of another equation, to its first term
y' = f(y) + h^p d(y), where d is a sum of derivatives of f that the method alone determines. So the
file's own motion leaves h^p d in the exact equations: in the rates of the angles as well as in the
accelerations, which no force does. The coefficient is found as that of any force, and is h^p.

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

# Places of the angles whose rates are in the file, and of their accelerations and the rolling rate.
_ANGLES, _PLACES_OF_SPEEDS = [0, 2], [3, 4, 5]


CLOCK = "times on another scale"
"""No method, but found in the same way: its step is the scale of the times, less one."""

PARTS = ("first", "second", "of_angles", "bend", "chain")


class Scheme(NamedTuple):
    """A method of integration.

    Attributes
    ----------
    says
    order
    angles
        The residual of the equations with a step of one: factors of the derivatives of `PARTS`.
    speeds
        The same in the equations of the speeds, where these are other ones.
    """

    says: str
    order: int
    angles: Mapping[str, float]
    speeds: Mapping[str, float] | None = None


def _of(
    code: str, angles: Mapping[str, float], speeds: Mapping[str, float] | None = None
) -> Scheme:
    """One of the methods that are run, too."""
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
"""Methods of known first term, and times on another scale: all rates are as much too large."""


class Method(NamedTuple):
    """A method of integration that explains what remains.

    Attributes
    ----------
    says
    order
    step
        [s]
    is_of_rows
        True if rows are a whole number of steps apart, or steps of rows, as nearly as is known.
    relief
        Factor by which what remains falls, a geometric mean.
    log_odds
        Against none.
    """

    says: str
    order: int
    step: float
    is_of_rows: bool
    relief: float
    log_odds: float


def _derivatives(equations: Equations, y: Array) -> Array:
    """Derivatives of the state over time at states, shape (5, 6, n), as `PARTS` has them.

    ``first`` is f, ``second`` f'f, ``of_angles`` the part of it that comes with the angles, and
    ``bend`` and ``chain`` the two parts f''(f, f) and f'f'f of the third.
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
    """Return methods that explain the residual and cannot be told apart; empty if none does."""
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
        # Rounding may leave less than nothing.
        left = np.maximum(left, 0.0) + b.floors
        falls = np.log((b.squares + b.floors) / left).reshape(len(motions), -1) / 2
        # A force, or constraints that drift, leave nothing of an integrator in these.
        of_angles = float(np.exp(np.mean(falls[:, : len(_ANGLES)])))
        # As much as an equation of motion tells, each rate of an angle does, too.
        seen = THRESHOLDS.values / len(_PLACES_OF_SPEEDS) * len(rest) * float(np.log(gain))
        odds = seen - THRESHOLDS.fitted - float(np.log(len(SCHEMES)))
        scheme, is_clock = SCHEMES[i], SCHEMES[i].says == CLOCK
        if of_angles > THRESHOLDS.explains and (is_clock or size > 0.0):
            step = float(size) if is_clock else float(size) ** (1 / scheme.order)
            spacing = float(np.median(np.diff(motions[0].time)))
            near = None if is_clock else step_of_rows(step, spacing, float(gain))
            found.append(
                Method(scheme.says, scheme.order, near or step, near is not None, float(gain), odds)
            )
    # First terms that are multiples of one another, such as of BDF2, are in the order of `SCHEMES`.
    order = [s.says for s in SCHEMES]
    found.sort(key=lambda m: (-round(m.log_odds, 3), order.index(m.says)))
    least = max((m.log_odds for m in found), default=0.0) - THRESHOLDS.report_log_odds
    found = [m for m in found if m.log_odds > max(least, THRESHOLDS.report_log_odds)]
    # No program takes steps between which its rows lie.
    return tuple([m for m in found if m.is_of_rows] or found)


def step_of_rows(step: float, spacing: float, relief: float) -> float | None:
    """The step near one of which rows are a multiple or a part; None if it is not near [s].

    A method that lets an error fall by some factor tells its step to about this part of it.
    """
    near = spacing / round(spacing / step) if step < spacing else spacing * round(step / spacing)
    # Times are sums of steps, or their binary64 numbers.
    is_near = abs(step - near) < near / max(relief, CLEARLY)
    return float(f"{near:.9g}") if is_near else None

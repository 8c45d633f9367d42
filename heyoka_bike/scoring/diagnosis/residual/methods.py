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

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.evidence import WEIGHTS
from heyoka_bike.scoring.diagnosis.residual.linear_fits import best_subsets, blocks
from heyoka_bike.scoring.diagnosis.residual.observed import Observed, state_vector

# For derivatives by central differences over the time that a step takes [s]: their error is its
# square, and that of rounding is 1e-16 over it.
_SHIFT = 1e-4
# Places of the angles whose rates are in the file, and of their accelerations and the rolling rate.
_ANGLES, _SPEEDS = [0, 2], [3, 4, 5]
# A step is so near to rows, or rows to steps, that it is said to be that.
_NEAR = 0.03


@dataclass(frozen=True, eq=False, slots=True)
class _Derivatives:
    """Derivatives of the state over time along a motion, and parts of them; shape (6, n).

    Attributes
    ----------
    first
        f.
    second
        f'f.
    of_angles
        The part of it that comes with the angles.
    bend, chain
        The two parts of the third: f''(f, f) and f'f'f.
    """

    first: Array
    second: Array
    of_angles: Array
    bend: Array
    chain: Array

    @classmethod
    def of(cls, equations: Equations, y: Array) -> _Derivatives:
        """At states, shape (6, n)."""

        def f(y: Array) -> Array:
            return np.array(equations.rates(list(y)))

        def along(v: Array) -> Array:
            return (f(y + _SHIFT * v) - f(y - _SHIFT * v)) / (2 * _SHIFT)

        here = f(y)
        second = along(here)
        bend = (f(y + _SHIFT * here) - 2 * here + f(y - _SHIFT * here)) / _SHIFT**2
        return cls(here, second, along(_parts(here, 0 * here)), bend, along(second))


def _parts(angles: Array, speeds: Array) -> Array:
    """The angles of one and the speeds of another."""
    return np.concatenate([angles[:3], speeds[3:]])


@dataclass(frozen=True, slots=True)
class Scheme:
    """A method of integration.

    Attributes
    ----------
    says
    order
    leaves
        The residual of the equations with a step of one.
    """

    says: str
    order: int
    leaves: Callable[[_Derivatives], Array]


CLOCK = "times on another scale"
"""No method, but found in the same way: its step is the scale of the times, less one."""

SCHEMES = (
    Scheme("explicit Euler", 1, lambda d: -d.second / 2),
    Scheme("implicit Euler", 1, lambda d: d.second / 2),
    Scheme("semi-implicit Euler", 1, lambda d: _parts(d.second, -d.second) / 2),
    Scheme(
        "semi-implicit Euler, positions first",
        1,
        lambda d: _parts(-d.second / 2, d.of_angles - d.second / 2),
    ),
    Scheme("Heun's method", 2, lambda d: d.bend / 12 - d.chain / 6),
    Scheme("the explicit midpoint rule", 2, lambda d: -d.bend / 24 - d.chain / 6),
    Scheme("the trapezoidal rule", 2, lambda d: (d.bend + d.chain) / 12),
    Scheme("the implicit midpoint rule", 2, lambda d: d.chain / 12 - d.bend / 24),
    Scheme("Adams and Bashforth's method of order 2", 2, lambda d: -5 / 12 * (d.bend + d.chain)),
    Scheme("BDF2", 2, lambda d: (d.bend + d.chain) / 3),
    Scheme(CLOCK, 1, lambda d: d.first),
)
"""Those whose first term is known, and times on another scale: all rates are as much too large."""


@dataclass(frozen=True, slots=True)
class Method:
    """A method of integration that explains what remains.

    Attributes
    ----------
    says
    step
        [s]
    relief
        Factor by which what remains falls, a geometric mean.
    log_odds
        Against none.
    """

    says: str
    step: float
    relief: float
    log_odds: float


def find_methods(equations: Equations, motions: Sequence[Observed]) -> tuple[Method, ...]:
    """Those that explain what remains, and cannot be told apart; empty if none does."""
    rest, floors, terms = [], [], []
    for m in motions:
        y = np.array(state_vector(equations, m.state.__getitem__)[:6])
        d = _Derivatives.of(equations, y)
        right = np.array(equations.rates(list(y)))[_SPEEDS]
        right[2] *= equations.k.length
        rest += [*m.kinematic, *(m.accelerations - right @ m.windows.T)]
        floors += [*m.kinematic_uncertain, *m.uncertain]
        each = np.array([scheme.leaves(d)[_ANGLES + _SPEEDS] for scheme in SCHEMES])
        each[:, 4] *= equations.k.length
        terms += list(np.moveaxis(each @ m.windows.T, 0, -1))
    b = blocks(rest, terms, [float(np.median(x)) for x in floors])
    fits = best_subsets(b, 1, len(SCHEMES))
    found = []
    for (i,), (size,), gain in zip(fits.members, fits.changes, fits.gains, strict=True):
        left = b.squares - 2 * size * b.moments[:, i] + size**2 * b.products[:, i, i] + b.floors
        falls = np.log((b.squares + b.floors) / left).reshape(len(motions), -1) / 2
        # A force, or constraints that drift, leave nothing of an integrator in these.
        of_angles = float(np.exp(np.mean(falls[:, : len(_ANGLES)])))
        # As much as an equation of motion tells, each rate of an angle does, too.
        seen = WEIGHTS.values / len(_SPEEDS) * len(rest) * float(np.log(gain))
        odds = seen - WEIGHTS.fitted - float(np.log(len(SCHEMES)))
        scheme, is_clock = SCHEMES[i], SCHEMES[i].says == CLOCK
        if of_angles > WEIGHTS.explains and (is_clock or size > 0.0):
            step = float(size) if is_clock else float(size) ** (1 / scheme.order)
            near = step if is_clock else _usual(step, motions[0].time)
            found.append(Method(scheme.says, near, float(gain), odds))
    least = max((m.log_odds for m in found), default=0.0) - WEIGHTS.said
    return tuple(m for m in found if m.log_odds > max(least, WEIGHTS.said))


def _usual(step: float, time: Array) -> float:
    """The step, or the one near it of which rows are a multiple or a part."""
    spacing = float(np.median(np.diff(time)))
    near = spacing / round(spacing / step) if step < spacing else spacing * round(step / spacing)
    # Times are sums of steps, or their binary64 numbers.
    return float(f"{near:.9g}") if abs(step - near) < _NEAR * near else step

"""Row 0 in exact arithmetic.

At t = 0 many values are rational (a speed of 4 m/s, an energy), and no ball around them, however
small, would tell how an exactly representable number rounds. Here the columns of the initial state
are evaluated over a field: rational functions in the half-angle tangents of the tilt and of the
initial roll, taken as independent unknowns. A value in which the unknowns cancel is rational for
every tilt and roll, so for the given ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from math import isqrt
from typing import Any

import flint

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS, START, Bicycle, Maneuver
from heyoka_bike.numbers.arithmetic import Arithmetic
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.proof.unknowns import COUNT, Varied, slope

_RING = flint.fmpz_mpoly_ctx.get([("t", 2)], flint.Ordering.lex)
_ONE = _RING.constant(1)


_STARTS = {
    "roll_angle": "roll",
    "roll_rate": "roll_rate",
    "forward_speed": "speed",
    "steer_angle": "steer",
    "steer_rate": "steer_rate",
    "forward_speed_hub_global_x": "speed",  # at zero yaw the heading is the x axis
}
"""Columns that begin as the maneuver says."""


def exact_columns(bicycle: Bicycle, maneuver: Maneuver) -> dict[str, Fraction]:
    """Columns of the initial state that are rational, by name.

    A value that is missing is irrational, or not recognised as rational; with an initial steer
    angle only the inputs themselves are recognised.
    """
    known = {name: getattr(maneuver, key) for name, key in _STARTS.items()}
    found = {name: x.rational for name, x in known.items() if x.is_rational} | {"yaw": Fraction(0)}
    if not maneuver.steer.is_zero:
        return found
    a = RationalFunctions()
    equations = Equations.of(bicycle, a)
    zero = a.number(0)
    state = [
        a.number(maneuver.roll), zero, zero,
        a.number(maneuver.roll_rate), a.number(maneuver.steer_rate),
        a.number(maneuver.speed) / equations.k.length, zero,
    ]  # fmt: skip
    values = equations.columns(state)
    found |= {name: x for name, v in values.items() if (x := v.rational()) is not None}
    return found


def exact_derivatives(
    bicycle: Bicycle, maneuver: Maneuver
) -> Mapping[str, Sequence[Fraction | None]]:
    """Derivatives of columns of the initial state by the unknowns; None is not seen as rational.

    With an initial steer angle only those of the inputs themselves are known.
    """
    place = {key: len(PARAMETERS) + i for i, key in enumerate(START)}
    found: dict[str, Sequence[Fraction | None]] = {
        name: [Fraction(int(i == place[key])) for i in range(COUNT)]
        for name, key in _STARTS.items()
    }
    found["yaw"] = [Fraction(0)] * COUNT
    if not maneuver.steer.is_zero:
        return found
    a = RationalFunctions()
    varied = Varied.of(bicycle, maneuver, a.number(0), a, is_regular=True)
    columns = varied.columns(Equations.of(bicycle, a))
    return {
        name: [_element(slope(x, i)).rational() for i in range(COUNT)]
        for name, x in columns.items()
    } | found


class Element:
    """A rational function, or an angle known only by its exact value, or something unknown."""

    __slots__ = ("angle", "den", "num")

    def __init__(self, num: Any, den: Any = _ONE, angle: Exact | None = None) -> None:
        self.num, self.den, self.angle = num, den, angle
        if num is not None and den != _ONE:
            common = num.gcd(den)
            self.num, self.den = num // common, den // common
            if self.den.leading_coefficient() < 0:
                self.num, self.den = -self.num, -self.den

    def rational(self) -> Fraction | None:
        """The value, if it is a rational number."""
        if self.num is None:
            is_known = self.angle is not None and self.angle.is_rational
            return self.angle.rational if is_known and self.angle is not None else None
        if not (self.num.is_constant() and self.den.is_constant()):
            return None
        return Fraction(int(_constant(self.num)), int(_constant(self.den)))

    @property
    def is_zero(self) -> bool:
        return self.num is not None and self.num == 0

    def __add__(self, other: Element | int) -> Element:
        if not isinstance(other, Element | int):
            return NotImplemented
        x = _element(other)
        if self.is_zero or x.is_zero:
            return x if self.is_zero else self
        if self.num is None or x.num is None:
            return _UNKNOWN
        return Element(self.num * x.den + x.num * self.den, self.den * x.den)

    def __mul__(self, other: Element | int) -> Element:
        if not isinstance(other, Element | int):
            return NotImplemented
        x = _element(other)
        if self.is_zero or x.is_zero:
            return _ZERO
        if self.num is None or x.num is None:
            return _UNKNOWN
        return Element(self.num * x.num, self.den * x.den)

    def __neg__(self) -> Element:
        return self * -1

    def __sub__(self, other: Element | int) -> Element:
        return self + -other

    def __rsub__(self, other: int) -> Element:
        return _element(other) - self

    def __truediv__(self, other: Element | int) -> Element:
        if not isinstance(other, Element | int):
            return NotImplemented
        x = _element(other)
        if self.is_zero and not x.is_zero:
            return _ZERO
        if self.num is None or x.num is None or x.is_zero:
            return _UNKNOWN
        return Element(self.num * x.den, self.den * x.num)

    def __rtruediv__(self, other: int) -> Element:
        return _element(other) / self

    __radd__ = __add__
    __rmul__ = __mul__


_UNKNOWN = Element(None)
_ZERO = Element(_RING.constant(0))


def _element(x: Element | int) -> Element:
    return x if isinstance(x, Element) else Element(_RING.constant(x))


def _constant(polynomial: Any) -> Any:
    return polynomial.leading_coefficient() if polynomial != 0 else 0


class RationalFunctions(Arithmetic):
    """The arithmetic of `Element`; sines and cosines of at most two different angles."""

    def __init__(self) -> None:
        self._angles: list[Exact] = []

    def number(self, value: Exact | Fraction | int) -> Element:
        exact = value if isinstance(value, Exact) else Exact(Fraction(value))
        if not exact.is_rational:
            return Element(None, angle=exact)
        num, den = exact.rational.numerator, exact.rational.denominator
        return Element(_RING.constant(num), _RING.constant(den))

    def sin(self, x: Element) -> Element:
        t = self._half_tangent(x)
        return _UNKNOWN if t is None else Element(2 * t, 1 + t * t)

    def cos(self, x: Element) -> Element:
        t = self._half_tangent(x)
        return _UNKNOWN if t is None else Element(1 - t * t, 1 + t * t)

    def sqrt(self, x: Element) -> Element:
        value = x.rational()
        if value is None or value < 0:
            return _UNKNOWN
        num, den = isqrt(value.numerator), isqrt(value.denominator)
        if num * num != value.numerator or den * den != value.denominator:
            return _UNKNOWN
        return self.number(Fraction(num, den))

    def atan2(self, y: Element, x: Element) -> Element:
        """Recognises zero, and an angle that is already known."""
        if y.num is None or x.num is None:
            return _UNKNOWN
        if y.is_zero and (r := x.rational()) is not None and r > 0:
            return _ZERO
        for angle in self._angles:
            e = self.number(angle)
            sine, cosine = self.sin(e), self.cos(e)
            factor = (x / cosine).rational()
            if (y * cosine - x * sine).is_zero and factor is not None and factor > 0:
                return e
        return _UNKNOWN

    def sum(self, terms: Iterable[Element | int]) -> Element:
        total = _ZERO
        for term in terms:
            total = total + term
        return total

    def _half_tangent(self, x: Element) -> Any:
        rational = x.rational()
        value = x.angle if rational is None else Exact(rational)
        if value is None:
            return None
        if value.is_zero:
            return _RING.constant(0)
        if value not in self._angles:
            if len(self._angles) == 2:
                return None
            self._angles.append(value)
        return _RING.gens()[self._angles.index(value)]

"""Dual numbers: a value with its first derivatives, over any number type.

Derivatives that are structurally zero are kept as the integer 0 and cost nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar

from heyoka_bike.numbers.arithmetic import Arithmetic, Differentiated, Number
from heyoka_bike.numbers.exact import Exact


@dataclass(frozen=True, slots=True)
class Dual(Differentiated):
    """A number with its derivatives by some variables."""

    # An array times a dual number is a dual number of arrays, not an array of dual numbers.
    __array_ufunc__: ClassVar[None] = None

    value: Number
    slopes: tuple[Number, ...]

    def __add__(self, other: Number) -> Dual:
        if isinstance(other, Dual):
            pairs = zip(self.slopes, other.slopes, strict=True)
            return Dual(self.value + other.value, tuple([_plus(p, q) for p, q in pairs]))
        return Dual(self.value + other, self.slopes)

    def __neg__(self) -> Dual:
        return Dual(-self.value, tuple([-p for p in self.slopes]))

    def __sub__(self, other: Number) -> Dual:
        return self.__add__(-other)

    def __rsub__(self, other: Number) -> Dual:
        return self.__neg__().__add__(other)

    def __mul__(self, other: Number) -> Dual:
        if isinstance(other, Dual):
            x, y = self.value, other.value
            pairs = zip(self.slopes, other.slopes, strict=True)
            return Dual(x * y, tuple([_plus(_times(p, y), _times(q, x)) for p, q in pairs]))
        return self.chain(self.value * other, other)

    def __truediv__(self, other: Number) -> Dual:
        if isinstance(other, Dual):
            quotient = self.value / other.value
            pairs = zip(self.slopes, other.slopes, strict=True)
            slopes = (_plus(p, _times(-quotient, q)) for p, q in pairs)
            return Dual(quotient, tuple(_over(p, other.value) for p in slopes))
        return Dual(self.value / other, tuple(_over(p, other) for p in self.slopes))

    def __rtruediv__(self, other: Number) -> Dual:
        quotient = other / self.value
        return self.chain(quotient, -quotient / self.value)

    __radd__ = __add__
    __rmul__ = __mul__

    def chain(self, value: Number, slope: Number) -> Dual:
        """A function of this number, from its value and its derivative."""
        return Dual(value, tuple([_times(p, slope) for p in self.slopes]))


class Duals(Arithmetic):
    """Dual numbers over the numbers of another arithmetic."""

    def __init__(self, inner: Arithmetic) -> None:
        self.inner = inner

    def variables(self, values: Sequence[Number]) -> list[Dual]:
        """The values as independent variables."""
        n = len(values)
        return [Dual(x, tuple(1 if i == j else 0 for j in range(n))) for i, x in enumerate(values)]

    def number(self, value: Exact | Fraction | int | Dual) -> Number:
        """A number without derivatives, or a dual number of fractions."""
        if isinstance(value, Dual):
            make = self.inner.number
            return Dual(
                make(value.value), tuple(0 if _is_zero(p) else make(p) for p in value.slopes)
            )
        return self.inner.number(value)

    def elementary(self, name: str, x: Number) -> Number:
        a = self.inner
        if not isinstance(x, Dual):
            return getattr(a, name)(x)
        value = getattr(a, name)(x.value)
        if name == "sqrt":
            return x.chain(value, 1 / (2 * value))
        return x.chain(value, a.cos(x.value) if name == "sin" else -a.sin(x.value))

    def atan2(self, y: Number, x: Number) -> Number:
        if not isinstance(x, Dual) or not isinstance(y, Dual):
            raise TypeError("atan2: expected two dual numbers")
        square = x.value * x.value + y.value * y.value
        by_y = y.chain(self.inner.atan2(y.value, x.value), x.value / square)
        return by_y + x.chain(0 * x.value, -y.value / square)


# Proofs take tens of millions of these, so that calls of functions count.


def _is_zero(x: Number) -> bool:
    return type(x) is int and x == 0


def _plus(x: Number, y: Number) -> Number:
    if type(x) is int and x == 0:
        return y
    return x if type(y) is int and y == 0 else x + y


def _times(x: Number, y: Number) -> Number:
    if type(x) is int:
        if x == 0:
            return 0
        if x == 1:
            return y
    return 0 if type(y) is int and y == 0 else x * y


def _over(x: Number, y: Number) -> Number:
    if isinstance(x, int) and isinstance(y, int) and x:
        raise TypeError("a quotient of two integers would be a float")
    return 0 if _is_zero(x) else x / y

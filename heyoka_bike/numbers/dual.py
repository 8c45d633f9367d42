"""Dual numbers: a value with its first derivatives, over any number type; and traced numbers.

A `Dual` carries its derivatives with respect to every variable through every operation. Derivatives
that are structurally zero are the integer 0 and cost nothing.

A `Traced` number records its operands, for derivatives of a few numbers with respect to many
variables. After the last operation, `gradient` follows the operands of a result back to the
variables. An operation then costs two products for each *result* that it enters.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from heapq import heappop, heappush
from itertools import count
from typing import ClassVar

from heyoka_bike.numbers.arithmetic import Arithmetic, Differentiated, Number
from heyoka_bike.numbers.exact import Exact


@dataclass(frozen=True, slots=True)
class Dual(Differentiated):
    """A number with its derivatives with respect to some variables."""

    # Without this, an array times a dual number would be an array of dual numbers instead of a dual
    # number of arrays.
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
        """Return a function of this number, given the value and the derivative of the function."""
        return Dual(value, tuple([_times(p, slope) for p in self.slopes]))


class Duals(Arithmetic):
    """Dual numbers over the numbers of another arithmetic."""

    def __init__(self, inner: Arithmetic) -> None:
        self.inner = inner

    def variables(self, values: Sequence[Number]) -> list[Dual]:
        """Return dual numbers of independent variables with these values."""
        n = len(values)
        return [Dual(x, tuple(1 if i == j else 0 for j in range(n))) for i, x in enumerate(values)]

    def number(self, value: Exact | Fraction | int | Dual) -> Number:
        """Return a number without derivatives, or convert a dual number of fractions."""
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


# Proofs create tens of millions of dual numbers, so the cost of function calls matters.


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


Share = Callable[[Number], Number]
"""A function that converts the derivative with respect to a result into the contribution to the
derivative with respect to an operand."""

_places = count()


class Traced:
    """A number that stores its operands, and the contribution of each to derivatives.

    Attributes
    ----------
    value
        The number itself.
    sources : tuple
    place : int
        Position in the order of operations, larger than those of its sources.
    """

    __slots__ = ("place", "sources", "value")

    # Without this, an array times a traced number would be an array of traced numbers instead of a
    # traced number of arrays.
    __array_ufunc__: ClassVar[None] = None

    def __init__(self, value: Number, *sources: tuple[Traced, Share]) -> None:
        self.value, self.sources, self.place = value, sources, next(_places)

    def __add__(self, other: Number) -> Traced:
        if isinstance(other, Traced):
            return Traced(self.value + other.value, (self, _all), (other, _all))
        return Traced(self.value + other, (self, _all))

    def __neg__(self) -> Traced:
        return Traced(-self.value, (self, _minus))

    def __sub__(self, other: Number) -> Traced:
        if isinstance(other, Traced):
            return Traced(self.value - other.value, (self, _all), (other, _minus))
        return Traced(self.value - other, (self, _all))

    def __rsub__(self, other: Number) -> Traced:
        return Traced(other - self.value, (self, _minus))

    def __mul__(self, other: Number) -> Number:
        if isinstance(other, Traced):
            x, y = self.value, other.value
            return Traced(x * y, (self, lambda s: s * y), (other, lambda s: s * x))
        if isinstance(other, int) and other in (0, 1):
            return self if other else 0
        return Traced(self.value * other, (self, lambda s: s * other))

    def __truediv__(self, other: Number) -> Traced:
        if isinstance(other, Traced):
            x, y = self.value / other.value, other.value
            return Traced(x, (self, lambda s: s / y), (other, lambda s: -(s * x) / y))
        return Traced(self.value / other, (self, lambda s: s / other))

    def __rtruediv__(self, other: Number) -> Traced:
        x, y = other / self.value, self.value
        return Traced(x, (self, lambda s: -(s * x) / y))

    __radd__ = __add__
    __rmul__ = __mul__


class Traces(Arithmetic):
    """Traced numbers over the numbers of another arithmetic."""

    def __init__(self, inner: Arithmetic) -> None:
        self.inner = inner

    def number(self, value: Exact | Fraction | int) -> Number:
        return self.inner.number(value)

    def elementary(self, name: str, x: Number) -> Number:
        a = self.inner
        if not isinstance(x, Traced):
            return getattr(a, name)(x)
        value = getattr(a, name)(x.value)
        shares: dict[str, Share] = {
            "sin": lambda s: s * a.cos(x.value),
            "cos": lambda s: -(s * a.sin(x.value)),
            "sqrt": lambda s: s / (2 * value),
        }
        return Traced(value, (x, shares[name]))

    def atan2(self, y: Number, x: Number) -> Number:
        if not isinstance(x, Traced) or not isinstance(y, Traced):
            raise TypeError("atan2: expected two traced numbers")
        u, v = x.value, y.value
        square = u * u + v * v
        return Traced(
            self.inner.atan2(v, u),
            (y, lambda s: s * u / square),
            (x, lambda s: -(s * v) / square),
        )

    def gradient(self, x: Number, variables: Sequence[Number]) -> list[Number]:
        """Return the derivatives of a number with respect to variables; 0 if it is independent."""
        found: dict[int, Number] = {}
        waiting: list[tuple[int, Traced]] = []

        def give(to: Traced, share: Number) -> None:
            if to.place in found:
                # Do not add in place, because the array may also be the contribution to another
                # derivative.
                found[to.place] = found[to.place] + share
            else:
                found[to.place] = share
                heappush(waiting, (-to.place, to))

        if isinstance(x, Traced):
            give(x, self.inner.number(1))
        while waiting:
            _, at = heappop(waiting)
            for source, share in at.sources:
                give(source, share(found[at.place]))
        return [found.get(v.place, 0) if isinstance(v, Traced) else 0 for v in variables]


def _all(share: Number) -> Number:
    return share


def _minus(share: Number) -> Number:
    return -share

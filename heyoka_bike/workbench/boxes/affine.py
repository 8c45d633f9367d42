"""Affine numbers: a ball plus multiples of variables that are each anywhere in [-1, 1].

A ball forgets where its width comes from, so that x - x is as wide as 2 x. An affine number keeps
what is of first order in each variable; only the rest, of second order, goes into the ball.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

import flint

from heyoka_bike.numbers.arithmetic import Arithmetic, Balls, Number
from heyoka_bike.numbers.exact import Exact


@dataclass(frozen=True, slots=True)
class Affine:
    """``rest + sum of terms[i] * variable i``, with balls for all coefficients."""

    rest: flint.arb
    terms: Mapping[int, flint.arb]

    @property
    def spread(self) -> flint.arb:
        """The largest sum of the terms."""
        return sum((abs(t) for t in self.terms.values()), flint.arb(0))

    @property
    def ball(self) -> flint.arb:
        """All values that it can have."""
        return self.rest + _around_zero(self.spread)

    def __add__(self, other: Number) -> Affine:
        if not isinstance(other, Affine):
            return Affine(self.rest + other, self.terms)
        terms = dict(self.terms)
        for i, t in other.terms.items():
            terms[i] = terms[i] + t if i in terms else t
        return Affine(self.rest + other.rest, terms)

    def __neg__(self) -> Affine:
        return Affine(-self.rest, {i: -t for i, t in self.terms.items()})

    def __sub__(self, other: Number) -> Affine:
        return self.__add__(-other)

    def __rsub__(self, other: Number) -> Affine:
        return self.__neg__().__add__(other)

    def __mul__(self, other: Number) -> Affine:
        if not isinstance(other, Affine):
            return Affine(self.rest * other, {i: t * other for i, t in self.terms.items()})
        x, y = self.rest, other.rest
        terms = {i: t * y for i, t in self.terms.items()}
        for i, t in other.terms.items():
            terms[i] = terms[i] + t * x if i in terms else t * x
        return Affine(x * y + _around_zero(self.spread * other.spread), terms)

    def __truediv__(self, other: Number) -> Affine:
        inverse = other.inverse() if isinstance(other, Affine) else 1 / flint.arb(other)
        return self.__mul__(inverse)

    def __rtruediv__(self, other: Number) -> Affine:
        return self.inverse().__mul__(other)

    __radd__ = __add__
    __rmul__ = __mul__

    def inverse(self) -> Affine:
        """Its reciprocal; not finite where that may be infinite."""
        return self.chain(1 / self.rest, -1 / self.rest**2, 1 / self.ball**3)

    def chain(self, value: flint.arb, slope: flint.arb, curve: flint.arb) -> Affine:
        """A function of it: value and slope at `rest`, half the second derivative everywhere."""
        beyond = curve * self.spread**2
        return Affine(
            value + beyond.union(flint.arb(0)), {i: slope * t for i, t in self.terms.items()}
        )


class Affines(Arithmetic):
    """Arithmetic of affine numbers; what has no variables stays a ball."""

    def __init__(self, balls: Balls) -> None:
        self.balls = balls

    def variables(self, balls: Iterable[flint.arb]) -> list[Affine]:
        """Variables that are each anywhere in one of the balls."""
        return [Affine(x.mid(), {i: x.rad()}) for i, x in enumerate(balls)]

    def number(self, value: Exact | Fraction | int) -> flint.arb:
        return self.balls.number(value)

    def sin(self, x: Number) -> Number:
        if not isinstance(x, Affine):
            return self.balls.sin(x)
        return x.chain(self.balls.sin(x.rest), self.balls.cos(x.rest), -self.balls.sin(x.ball) / 2)

    def cos(self, x: Number) -> Number:
        if not isinstance(x, Affine):
            return self.balls.cos(x)
        return x.chain(self.balls.cos(x.rest), -self.balls.sin(x.rest), -self.balls.cos(x.ball) / 2)

    def sqrt(self, x: Number) -> Number:
        if not isinstance(x, Affine):
            return self.balls.sqrt(x)
        root, whole = self.balls.sqrt(x.rest), x.ball
        return x.chain(root, 1 / (2 * root), -1 / (8 * whole * self.balls.sqrt(whole)))

    def sum(self, terms: Iterable[Number]) -> Number:
        return sum(terms, flint.arb(0))


def enclosure(x: Number) -> flint.arb:
    """All values of an affine number, a ball or an integer."""
    return x.ball if isinstance(x, Affine) else flint.arb(x)


def _around_zero(radius: flint.arb) -> flint.arb:
    return radius.union(-radius)

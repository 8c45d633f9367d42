"""Prove the sign of a function over a box of its variables, in ball arithmetic.

The function and its derivatives are evaluated over the box in affine numbers. Where a derivative
keeps its sign, the function is extreme at one end of that variable, so a face replaces the box. If
all derivatives keep their signs, the extreme value is that at a corner, exact up to roundoff. The
mean value theorem bounds the function over what remains, which is halved until the bound meets a
value that is attained.

An affine number is a ball plus multiples of variables that are each anywhere in [-1, 1]. A ball
forgets where its width comes from, so x - x is as wide as 2 x. An affine number keeps the first
order in each variable; only the rest, of second order, goes into the ball.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import count
from math import inf

import flint

from heyoka_bike.numbers.arithmetic import Arithmetic, Balls, Number, upper_fraction
from heyoka_bike.numbers.dual import Dual, Duals
from heyoka_bike.numbers.exact import Exact


@dataclass(frozen=True, slots=True)
class Affine:
    """``rest + sum of terms[i] * variable i``, with balls for all coefficients."""

    rest: flint.arb
    terms: Mapping[int, flint.arb]

    @property
    def spread(self) -> flint.arb:
        """The largest magnitude of the sum of the terms."""
        return sum((abs(t) for t in self.terms.values()), flint.arb(0))

    @property
    def ball(self) -> flint.arb:
        """A ball that encloses all values of the affine number."""
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
        """Return the reciprocal; its coefficients are not finite if the number may be zero."""
        return self.chain(1 / self.rest, -1 / self.rest**2, 1 / self.ball**3)

    def chain(self, value: flint.arb, slope: flint.arb, curve: flint.arb) -> Affine:
        """Apply a function, given by value and slope at `rest`, and half its second derivative.

        `curve` encloses half the second derivative over all values of the number.
        """
        beyond = curve * self.spread**2
        return Affine(
            value + beyond.union(flint.arb(0)), {i: slope * t for i, t in self.terms.items()}
        )


class Affines(Arithmetic):
    """Arithmetic of affine numbers; numbers that depend on no variable remain balls."""

    def __init__(self, balls: Balls) -> None:
        self.balls = balls

    def variables(self, balls: Iterable[flint.arb]) -> list[Affine]:
        """Return an affine number for each ball; its value may be anywhere in the ball."""
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
    """Enclose all values of an affine number, a ball or an integer."""
    return x.ball if isinstance(x, Affine) else flint.arb(x)


def _around_zero(radius: flint.arb) -> flint.arb:
    return radius.union(-radius)


Side = tuple[flint.arb, flint.arb]
"""Both ends of a variable; equal if it is fixed."""
Function = Callable[[Sequence[Number]], Number]
"""A function of balls, affine numbers and dual numbers over either, in any mixture."""

# Maximum number of parts into which the box is divided. One part costs about 0.1 s with 26
# variables. Boxes of one standard deviation about measured bicycles need one part.
_MAX_PARTS = 12


def corner(f: Function, box: Sequence[Side], balls: Balls) -> tuple[flint.arb, ...]:
    """Return the corner of the box where a function is probably largest; this is not proved."""
    return _examine(f, tuple(box), balls).point


def is_negative(f: Function, box: Sequence[Side], balls: Balls) -> bool:
    """True if a function is proved to be negative in the whole box."""
    order = count()
    part = _examine(f, tuple(box), balls)
    if part.attained is not None and part.attained >= 0:
        return False
    heap = [(part.rank, next(order), part)]
    for _ in range(_MAX_PARTS):
        worst = heap[0][2]
        if worst.bound is not None and worst.bound < 0:
            return True
        if worst.split is None:
            return False
        heapq.heappop(heap)
        for half in _halves(worst.sides, worst.split):
            part = _examine(f, half, balls)
            if part.attained is not None and part.attained >= 0:
                return False
            heapq.heappush(heap, (part.rank, next(order), part))
    return False


def sign_over(f: Function, box: Sequence[Side], balls: Balls) -> int | None:
    """Return the sign of a function in the whole box; None if no sign is proved."""
    quick = _over(f, tuple(box), balls, with_slopes=False)[0]
    if quick > 0 or quick < 0:
        return 1 if quick > 0 else -1
    middle = f([_middle(side) for side in box])
    sign = 1 if middle > 0 else -1
    return sign if is_negative(lambda x: -sign * f(x), box, balls) else None


def slopes(f: Function, point: Sequence[flint.arb], balls: Balls) -> list[flint.arb]:
    """Return the derivatives of a function at a point with respect to each variable."""
    found: Dual = f(Duals(balls).variables(point))
    # Convert each derivative to a ball, because a derivative that is zero by the structure of the
    # formula is the integer 0.
    return [flint.arb(s) for s in found.slopes]


@dataclass(frozen=True, slots=True)
class _BoxPart:
    """A part of the box, an upper bound of the function in it, and a value at a point of it.

    `attained` is a lower bound of the function at `point`. `split` is the index of the variable to
    halve; None if halving cannot improve the bound.
    """

    sides: tuple[Side, ...]
    bound: Fraction | None
    attained: Fraction | None
    point: tuple[flint.arb, ...]
    split: int | None

    @property
    def rank(self) -> tuple[int, Fraction]:
        """Sort key of parts: the part with the largest bound has the smallest rank."""
        return (0, Fraction(0)) if self.bound is None else (1, -self.bound)


def _examine(f: Function, sides: tuple[Side, ...], balls: Balls) -> _BoxPart:
    """Reduce a box to the face where the function is largest, and bound it on that face."""
    while True:
        value, rates = _over(f, sides, balls)
        if not rates:
            point = tuple(low for low, _ in sides)
            return _BoxPart(sides, _upper(value), _lower(value), point, None)
        ends = {i: int(s >= 0) for i, s in rates.items() if s >= 0 or s <= 0}
        if not ends:
            break
        sides = tuple(
            (side[ends[i]], side[ends[i]]) if i in ends else side for i, side in enumerate(sides)
        )
    centre = [_middle(side) for side in sides]
    # Distance from the middle to the farther end of each side. The middle is rounded, so the
    # distances to the two ends differ.
    reach = {i: (sides[i][1] - centre[i]).max(centre[i] - sides[i][0]) for i in rates}
    shares = {i: abs(s) * reach[i] for i, s in rates.items()}
    bounds = [_upper(value), _upper(f(centre) + sum(shares.values()))]
    point = tuple(side[i in rates and rates[i].mid() > 0] for i, side in enumerate(sides))
    return _BoxPart(
        sides,
        min((x for x in bounds if x is not None), default=None),
        _lower(f(point)),
        point,
        max(rates, key=lambda i: float(shares[i].upper()) if shares[i].is_finite() else inf),
    )


def _over(
    f: Function, sides: tuple[Side, ...], balls: Balls, *, with_slopes: bool = True
) -> tuple[flint.arb, dict[int, flint.arb]]:
    """Enclose the function and its derivatives with respect to the free variables over a box."""
    free = [i for i, (low, high) in enumerate(sides) if low is not high]
    affines = Affines(balls)
    whole: Sequence[Number] = affines.variables([sides[i][0].union(sides[i][1]) for i in free])
    if with_slopes:
        whole = Duals(affines).variables(whole)
    variables = dict(zip(free, whole, strict=True))
    found = f([variables.get(i, low) for i, (low, _) in enumerate(sides)])
    if not isinstance(found, Dual):
        return enclosure(found), {}
    rates = {i: enclosure(s) for i, s in zip(free, found.slopes, strict=True)}
    return enclosure(found.value), rates


def _halves(sides: tuple[Side, ...], i: int) -> list[tuple[Side, ...]]:
    low, high = sides[i]
    middle = _middle(sides[i])
    return [(*sides[:i], half, *sides[i + 1 :]) for half in ((low, middle), (middle, high))]


def _middle(side: Side) -> flint.arb:
    low, high = side
    return low if low is high else ((low + high) / 2).mid()


def _upper(x: flint.arb) -> Fraction | None:
    return upper_fraction(x) if x.is_finite() else None


def _lower(x: flint.arb) -> Fraction | None:
    return -upper_fraction(-x) if x.is_finite() else None

"""Random points with counted degrees, which decide whether an equation is an identity.

A rational function that is not identically zero vanishes at few points. `RandomField` gives every
unknown a random value in a prime field and evaluates any formula there exactly. It also counts the
degree and the coefficients of the polynomials whose quotient is the result. If a result is zero
although its formula is not identically zero, then

- all coefficients of its numerator are divisible by the prime, which was drawn from all primes of
  `bits` bits: a coefficient below 2^h has at most h / (bits - 1) such divisors, and there are more
  than 3/5 x / log x primes between x and 2 x (Rosser and Schoenfeld 1962,
  doi:10.1215/ijm/1255631807, corollary 3); or
- the point is a zero of a polynomial of degree d that is not identically zero; at most the fraction
  d / p of all points are zeros (J. T. Schwartz 1980, doi:10.1145/322217.322225, lemma 1).

`missed` adds the two up. Angles are rational too: the unknown is the tangent of a quarter of the
angle. One square root may be adjoined: numbers are then u + v root, and zero only if u and v are. A
formula is then an identity with either sign of the root.
"""

from __future__ import annotations

import math
import secrets
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint

Divisors = dict[int, int]
"""Powers of the polynomials in `RandomField.divisors`, by their index."""


@dataclass(frozen=True, slots=True)
class Size:
    """The size of a polynomial with integer coefficients.

    Attributes
    ----------
    degree
        Upper bound of the total degree.
    bits
        Upper bound of the binary logarithm of the sum of the coefficients' magnitudes.
    """

    degree: int
    bits: int

    def __mul__(self, other: Size) -> Size:
        return Size(self.degree + other.degree, self.bits + other.bits)

    def __pow__(self, n: int) -> Size:
        return Size(self.degree * n, self.bits * n)

    def __or__(self, other: Size) -> Size:
        """Return the size of a sum."""
        return Size(max(self.degree, other.degree), max(self.bits, other.bits) + 1)


ONE = Size(0, 0)


@dataclass(frozen=True, slots=True, eq=False)
class Element:
    """A formula's value at the point, and the sizes of its numerator and its divisors.

    Attributes
    ----------
    field
    value
        u and v of u + v root, modulo the prime.
    top
        Size of the numerator P + Q R, where R is the root times its divisors and the size counts R
        with its own.
    below
    pure
        True if the formula does not contain the root.
    """

    field: RandomField
    value: tuple[int, int]
    top: Size
    below: Divisors
    pure: bool

    @property
    def is_zero(self) -> bool:
        return self.value == (0, 0)

    def __add__(self, other: Any) -> Any:
        if (y := self.field.element(other)) is None:
            return NotImplemented
        f, (a, b), (c, d) = self.field, self.value, y.value
        below = {i: max(self.below.get(i, 0), y.below.get(i, 0)) for i in self.below | y.below}
        top = f.over(self, below) | f.over(y, below)
        value = ((a + c) % f.prime, (b + d) % f.prime)
        return Element(f, value, top, below, self.pure and y.pure)

    def __mul__(self, other: Any) -> Any:
        if (y := self.field.element(other)) is None:
            return NotImplemented
        f = self.field
        below = {i: self.below.get(i, 0) + y.below.get(i, 0) for i in self.below | y.below}
        value = f.times(self.value, y.value)
        return Element(f, value, self.top * y.top, below, self.pure and y.pure)

    def __neg__(self) -> Element:
        a, b = self.value
        value = (-a % self.field.prime, -b % self.field.prime)
        return Element(self.field, value, self.top, self.below, self.pure)

    def __sub__(self, other: Any) -> Any:
        return self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __truediv__(self, other: Any) -> Any:
        if (y := self.field.element(other)) is None:
            return NotImplemented
        return self * self.field.inverse(y)

    def __rtruediv__(self, other: Any) -> Any:
        return self.field.inverse(self) * other

    def __pow__(self, n: int) -> Element:
        return math.prod([self] * (n - 1), start=self)

    __radd__ = __add__
    __rmul__ = __mul__


@dataclass(frozen=True, slots=True)
class Angle:
    """An angle: its sine and cosine, and its half if it has one."""

    sin: Element
    cos: Element
    half: Angle | None = None

    def __add__(self, other: Any) -> Any:
        if not isinstance(other, Angle):
            return NotImplemented
        return Angle(
            self.sin * other.cos + self.cos * other.sin, self.cos * other.cos - self.sin * other.sin
        )

    def __neg__(self) -> Angle:
        return Angle(-self.sin, self.cos)

    def __sub__(self, other: Any) -> Any:
        return self + -other

    def __truediv__(self, two: int) -> Angle:
        if two != 2 or self.half is None:
            raise ValueError("only given angles are halved")
        return self.half


@dataclass(frozen=True, slots=True)
class Direction:
    """The unevaluated atan2 of two numbers."""

    y: Any
    x: Any


@dataclass(frozen=True, slots=True)
class Root:
    """The square root of a number, if it is not a known one; it may have either sign."""

    square: Element

    def __truediv__(self, other: Element) -> Root:
        return Root(self.square / (other * other))

    def __rmul__(self, other: Element) -> Root:
        return Root(other * other * self.square)

    def _refuse(self, other: object = None) -> Element:
        raise UnknownRootError("a root that is not known, where a number is needed")

    __neg__ = __radd__ = __rtruediv__ = _refuse


class UnknownRootError(ArithmeticError):
    """Raised for an unknown root; in a correct formula the root would be a known one."""


class RandomField:
    """The arithmetic at a random point, modulo a random prime.

    It can be used as an `Arithmetic` of the package and as one of the oracles.
    """

    def __init__(self, bits: int = 512) -> None:
        self.bits, self.prime = bits, 0
        while not flint.fmpz(self.prime).is_prime():
            self.prime = secrets.randbits(bits - 1) | 1 << (bits - 1)
        self.divisors: list[Size] = []
        self.roots: list[Element] = []
        self.assumed: list[Element] = []
        """Elements that are zero here, and must be identically zero for the assumed roots to be
        right."""
        self._of_divisor: dict[int, tuple[Element, int]] = {}
        self._integers: dict[int, Element] = {}
        self._adjoined: int | None = None

    # Operations that are used in formulas

    def element(self, x: Any) -> Element | None:
        """Return the number as an element; None if it is not a number of the field."""
        if isinstance(x, Element):
            return x
        if isinstance(x, int):
            if x not in self._integers:
                size = Size(0, abs(x).bit_length())
                self._integers[x] = Element(self, (x % self.prime, 0), size, {}, True)
            return self._integers[x]
        if isinstance(x, Fraction):
            return self.element(x.numerator) / x.denominator
        return None

    def number(self, x: Any) -> Any:
        """Convert a number; an `Exact` without pi, or its substitute, may contain others."""
        x = getattr(x, "rational", x)
        return x if isinstance(x, Angle) else self.element(x)

    exact = number

    def working(self) -> AbstractContextManager[object]:
        return nullcontext()

    def sin(self, x: Angle) -> Element:
        return x.sin

    def cos(self, x: Angle) -> Element:
        return x.cos

    def atan2(self, y: Any, x: Any) -> Direction:
        return Direction(y, x)

    def sum(self, terms: Iterable[Any]) -> Any:
        return sum(terms)

    def sqrt(self, x: Element) -> Any:
        """Return the known root with this square, or a root by name."""
        for root in self.roots:
            if (difference := x - root * root).is_zero:
                self.assumed.append(difference)
                return root
        return Root(x)

    def solve(self, matrix: list[list[Element]], rhs: list[Element]) -> list[Element]:
        """Solve linear equations by elimination; sizes are those of Cramer's rule."""
        rows = [[*row, y] for row, y in zip(matrix, rhs, strict=True)]
        pure, size = all(x.pure for row in rows for x in row), ONE
        for row in rows:
            below: Divisors = {}
            for x in row:
                below = {i: max(below.get(i, 0), x.below.get(i, 0)) for i in below | x.below}
            tops = [self.over(x, below) for x in row]
            # A determinant is at most the product, over its rows, of the sum of the magnitudes in
            # the row.
            bits = max(top.bits for top in tops) + len(row).bit_length()
            size *= Size(max(top.degree for top in tops), bits)
        place = self._divisor(size if pure else size**2)
        top = size if pure else size**2
        return [
            Element(self, value, top, {place: 1}, pure)
            for value in self._eliminate([[x.value for x in row] for row in rows])
        ]

    # Operations that define a point

    def unknown(self) -> Element:
        """Return an unknown with a random value."""
        return Element(self, (secrets.randbelow(self.prime), 0), Size(1, 0), {}, True)

    def angle(self) -> Angle:
        """Return an unknown angle, from the tangent of a quarter of it."""
        t = self.unknown()
        norm = 1 + t * t
        half = Angle(2 * t / norm, (1 - t * t) / norm)
        whole = half + half
        return Angle(whole.sin, whole.cos, half)

    def zero_angle(self) -> Angle:
        """Return the angle zero."""
        nought, one = self.number(0), self.number(1)
        return Angle(nought, one, Angle(nought, one))

    def adjoin_root(self, x: Element) -> Element:
        """Adjoin the square root of a number that contains no adjoined root, and return it."""
        if self._adjoined is not None or not x.pure:
            raise ValueError("only one root can be adjoined")
        below = {i: -(-power // 2) for i, power in x.below.items()}
        square = self.over(x, {i: 2 * power for i, power in below.items()})
        self._adjoined = x.value[0]
        size = Size(-(-square.degree // 2), -(-square.bits // 2))
        return Element(self, (0, 1), size, below, False)

    # Computation of the sizes of numerators and divisors

    def over(self, x: Element, below: Divisors) -> Size:
        """Return the size of the numerator after the divisors are extended to these."""
        size = x.top
        for i, power in below.items():
            size *= self.divisors[i] ** (power - x.below.get(i, 0))
        return size

    def times(self, x: tuple[int, int], y: tuple[int, int]) -> tuple[int, int]:
        (a, b), (c, d), p = x, y, self.prime
        if b == d == 0:
            return a * c % p, 0
        return (a * c + b * d * (self._adjoined or 0)) % p, (a * d + b * c) % p

    def inverse(self, x: Element) -> Element:
        """Return 1 / x, extended by the conjugate if there is a root."""
        if id(x) not in self._of_divisor:
            self._of_divisor[id(x)] = (x, self._divisor(x.top if x.pure else x.top**2))
        place = self._of_divisor[id(x)][1]
        top = ONE if x.pure else x.top
        for i, power in x.below.items():
            top *= self.divisors[i] ** power
        return Element(self, self._inverse(x.value), top, {place: 1}, x.pure)

    def missed(self, x: Element) -> Fraction:
        """Bound the probability that the formula is not identically zero but zero here."""
        least, log2 = 1 << (self.bits - 1), self.bits - 1
        # At least 3/5 x / log x primes lie between x and 2 x, which is more than half of x / log2
        # x.
        primes = Fraction(least, 2 * log2)
        return Fraction(x.top.bits, log2) / primes + Fraction(x.top.degree, least)

    def _divisor(self, size: Size) -> int:
        self.divisors.append(size)
        return len(self.divisors) - 1

    def _inverse(self, x: tuple[int, int]) -> tuple[int, int]:
        (a, b), p = x, self.prime
        norm = (a * a - b * b * (self._adjoined or 0)) % p
        if norm == 0:
            raise ZeroDivisionError("a divisor is zero at the point")
        over = pow(norm, -1, p)
        return a * over % p, -b * over % p

    def _eliminate(self, rows: list[list[tuple[int, int]]]) -> list[tuple[int, int]]:
        n, p = len(rows), self.prime
        for k in range(n):
            pivot = next((r for r in range(k, n) if rows[r][k] != (0, 0)), None)
            if pivot is None:
                raise ZeroDivisionError("the equations are singular at the point")
            rows[k], rows[pivot] = rows[pivot], rows[k]
            over = self._inverse(rows[k][k])
            rows[k] = [self.times(over, x) for x in rows[k]]
            for r in range(n):
                if r != k and (factor := rows[r][k]) != (0, 0):
                    rows[r] = [
                        ((x[0] - y[0]) % p, (x[1] - y[1]) % p)
                        for x, y in zip(
                            rows[r], (self.times(factor, y) for y in rows[k]), strict=True
                        )
                    ]
        return [row[n] for row in rows]


def differences(found: Any, expected: Any) -> Sequence[Element]:
    """Return elements that are zero if two numbers, angles, directions or roots are equal."""
    if isinstance(expected, Direction):
        return [*differences(found.y, expected.y), *differences(found.x, expected.x)]
    if isinstance(expected, Angle):
        return [found.sin - expected.sin, found.cos - expected.cos]
    if isinstance(expected, Root):
        return [found.square - expected.square]
    return [found - expected]

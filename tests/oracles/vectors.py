"""Vectors and rotations in numbers of a chosen precision, for the oracles.

There are two independent arithmetics: balls of python-flint, which enclose the exact result, and
floating-point numbers of mpmath.
"""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol

import flint
import mpmath

from heyoka_bike.numbers.exact import Exact

Number = Any
"""A number of the arithmetic: an `arb` or an `mpf`."""
Given = Exact | Fraction | int
"""An exact number, never a float."""

_GUARD = 25
_BITS_PER_DIGIT = Fraction(10, 3)


class Arithmetic(Protocol):
    """Numbers of a chosen precision."""

    def working(self) -> AbstractContextManager[object]: ...
    def exact(self, x: Given) -> Number: ...
    def sin(self, x: Number) -> Number: ...
    def cos(self, x: Number) -> Number: ...
    def sqrt(self, x: Number) -> Number: ...
    def middle(self, x: Number) -> Number: ...
    def solve(self, matrix: list[list[Number]], rhs: list[Number]) -> list[Number]: ...


class Balls:
    """Ball arithmetic of python-flint: every result encloses the exact one for its input."""

    def __init__(self, digits: int) -> None:
        self.bits = int((digits + _GUARD) * _BITS_PER_DIGIT) + 1

    def working(self) -> AbstractContextManager[object]:
        manager: AbstractContextManager[object] = flint.ctx.workprec(self.bits)
        return manager

    def exact(self, x: Given) -> Number:
        if isinstance(x, Exact):
            return self.exact(x.rational) + self.exact(x.pi_multiple) * flint.arb.pi()
        x = Fraction(x)
        return flint.arb(flint.fmpq(x.numerator, x.denominator))

    def sin(self, x: Number) -> Number:
        return x.sin()

    def cos(self, x: Number) -> Number:
        return x.cos()

    def sqrt(self, x: Number) -> Number:
        return x.sqrt()

    def middle(self, x: Number) -> Number:
        return x.mid()

    def solve(self, matrix: list[list[Number]], rhs: list[Number]) -> list[Number]:
        solution = flint.arb_mat(matrix).solve(flint.arb_mat([[x] for x in rhs]))
        return list(solution.entries())


class Multiprecision:
    """Floating-point arithmetic of mpmath; slower, and an independent implementation."""

    def __init__(self, digits: int) -> None:
        self.mp = mpmath.mp.clone()
        self.mp.dps = digits + _GUARD

    def working(self) -> AbstractContextManager[object]:
        return nullcontext()

    def exact(self, x: Given) -> Number:
        if isinstance(x, Exact):
            return self.exact(x.rational) + self.exact(x.pi_multiple) * self.mp.pi
        x = Fraction(x)
        return self.mp.mpf(x.numerator) / x.denominator

    def sin(self, x: Number) -> Number:
        return self.mp.sin(x)

    def cos(self, x: Number) -> Number:
        return self.mp.cos(x)

    def sqrt(self, x: Number) -> Number:
        return self.mp.sqrt(x)

    def middle(self, x: Number) -> Number:
        return x

    def solve(self, matrix: list[list[Number]], rhs: list[Number]) -> list[Number]:
        return list(self.mp.lu_solve(self.mp.matrix(matrix), self.mp.matrix(rhs)))


class Vector(tuple[Number, Number, Number]):
    """Three components, with the sums and products of vectors."""

    __slots__ = ()

    def __add__(self, other: Any) -> Vector:
        return Vector(a + b for a, b in zip(self, other, strict=True))

    def __sub__(self, other: Any) -> Vector:
        return Vector(a - b for a, b in zip(self, other, strict=True))

    def __neg__(self) -> Vector:
        return Vector(-a for a in self)

    def __rmul__(self, factor: Any) -> Vector:
        return Vector(factor * a for a in self)

    def dot(self, other: Vector) -> Number:
        return self[0] * other[0] + self[1] * other[1] + self[2] * other[2]

    def cross(self, other: Vector) -> Vector:
        (a, b, c), (x, y, z) = self, other
        return Vector((b * z - c * y, c * x - a * z, a * y - b * x))


@dataclass(frozen=True)
class Matrix:
    """A 3 by 3 matrix by its rows; calling it with a vector returns the product."""

    rows: tuple[Vector, Vector, Vector]

    def __call__(self, v: Vector) -> Vector:
        return Vector(row.dot(v) for row in self.rows)

    def transposed(self, v: Vector) -> Vector:
        """Return the product of the transpose and a vector."""
        a, b, c = self.rows
        total: Vector = v[0] * a + v[1] * b + v[2] * c
        return total


def zero(number: Arithmetic) -> Vector:
    return Vector((number.exact(0),) * 3)


def axes(number: Arithmetic) -> tuple[Vector, Vector, Vector]:
    """Return unit vectors along x, y and z."""
    i, o = number.exact(1), number.exact(0)
    return Vector((i, o, o)), Vector((o, i, o)), Vector((o, o, i))


def rotation(number: Arithmetic, axis: Vector, angle: Number) -> Matrix:
    """Return the rotation about a unit vector, by Rodrigues' formula."""
    s, c = number.sin(angle), number.cos(angle)
    # Row i of the matrix is axis i, rotated in the opposite direction.
    x, y, z = (c * e - s * axis.cross(e) + ((1 - c) * axis.dot(e)) * axis for e in axes(number))
    return Matrix((x, y, z))


def product(second: Matrix, first: Matrix) -> Matrix:
    a, b, c = (first.transposed(row) for row in second.rows)
    return Matrix((a, b, c))

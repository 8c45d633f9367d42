"""Vectors of three numbers of any type, rotations of their axes, and quaternions."""

from heyoka_bike.numbers.arithmetic import Number

Vector = tuple[Number, Number, Number]
Quaternion = tuple[Number, Number, Number, Number]
"""Four numbers, the scalar first."""


def plus(u: Vector, v: Vector) -> Vector:
    """Return u + v."""
    return u[0] + v[0], u[1] + v[1], u[2] + v[2]


def minus(u: Vector, v: Vector) -> Vector:
    """Return u - v."""
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


def scaled(factor: Number, v: Vector) -> Vector:
    """Return the vector multiplied by the factor."""
    return factor * v[0], factor * v[1], factor * v[2]


def cross(u: Vector, v: Vector) -> Vector:
    """Return the cross product."""
    return (
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    )


def from_turned(axis: str, sine: Number, cosine: Number, v: Vector) -> Vector:
    """Transform a vector from axes rotated about one axis to the axes before the rotation.

    The opposite sine gives the inverse transformation.
    """
    x, y, z = v
    if axis == "x":
        return x, cosine * y - sine * z, sine * y + cosine * z
    if axis == "y":
        return cosine * x + sine * z, y, cosine * z - sine * x
    return cosine * x - sine * y, sine * x + cosine * y, z


def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return the product of quaternions: rotation q followed by p, both about fixed axes."""
    (a, *_), (b, *_) = p, q
    u, v = p[1:], q[1:]
    scalar = a * b - (u[0] * v[0] + u[1] * v[1] + u[2] * v[2])
    x, y, z = plus(plus(scaled(a, v), scaled(b, u)), cross(u, v))
    return scalar, x, y, z

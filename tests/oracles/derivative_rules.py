"""Every operation's value and derivatives, as identities in random elements of a field."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from oracles.random_field import RandomField

Kind = Callable[[RandomField, Sequence[Any]], tuple[Any, Sequence[Any], Callable[[Any], list[Any]]]]
"""A function from a field and values to the arithmetic, to numbers with these values for
differentiation, and to a function for the derivatives of a result."""


def all_hold(kind: Kind) -> bool:
    """Check the value and the slopes (by x, y and an angle) of a formula for each operation."""
    field = RandomField(128)
    root, y, c = (field.unknown() for _ in range(3))
    field.roots.append(root)
    x, angle = root * root, field.angle()
    sin, cos = angle.sin, angle.cos
    field.atan2 = lambda *_: c  # any number would do, because the derivatives do not depend on it
    a, (u, v, turn), slopes = kind(field, [x, y, angle])
    w = u * v
    cases = [
        (u + v + c, x + y + c, 1, 1, 0),
        (c + u - v, c + x - y, 1, -1, 0),
        (c - u, c - x, -1, 0, 0),
        (1 - u, 1 - x, -1, 0, 0),
        (u - c, x - c, 1, 0, 0),
        (c * u * v, c * x * y, c * y, c * x, 0),
        (u * u, x * x, 2 * x, 0, 0),
        (w * u + w, x * y * (x + 1), y * (2 * x + 1), x * (x + 1), 0),
        (u / v, x / y, 1 / y, -x / (y * y), 0),
        (u / c, x / c, 1 / c, 0, 0),
        (c / v, c / y, 0, -c / (y * y), 0),
        (-w, -x * y, -y, -x, 0),
        (1 * u + 0 * v, x, 1, 0, 0),
        (a.sqrt(u), root, 1 / (2 * root), 0, 0),
        (a.sin(turn), sin, 0, 0, cos),
        (a.cos(turn), cos, 0, 0, -sin),
        (a.atan2(u, v), c, y / (x * x + y * y), -x / (x * x + y * y), 0),
    ]
    differences = [
        field.number(0) + p - q
        for found, *expected in cases
        for p, q in zip((found.value, *slopes(found)), expected, strict=True)
    ]
    return all(d.is_zero for d in differences)

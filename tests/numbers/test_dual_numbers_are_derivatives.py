"""Dual numbers have the values of the numbers, and their slopes are derivatives, identically."""

from __future__ import annotations

from typing import Any

import pytest
from oracles.random_field import RandomField
from support.sign_flips import flips

from heyoka_bike.numbers import dual
from heyoka_bike.numbers.dual import Duals


def all_hold() -> bool:
    """Whether one formula for each operation has its value and its slopes by x, y and an angle."""
    field = RandomField(128)
    root, y, c = (field.unknown() for _ in range(3))
    field.roots.append(root)
    x, angle = root * root, field.angle()
    sin, cos = angle.sin, angle.cos
    duals = Duals(field)
    u, v, turn = duals.variables([x, y, angle])
    cases = [
        (u + v + c, x + y + c, 1, 1, 0),
        (c + u - v, c + x - y, 1, -1, 0),
        (c - u, c - x, -1, 0, 0),
        (u - c, x - c, 1, 0, 0),
        (c * u * v, c * x * y, c * y, c * x, 0),
        (u * u, x * x, 2 * x, 0, 0),
        (u / v, x / y, 1 / y, -x / (y * y), 0),
        (u / c, x / c, 1 / c, 0, 0),
        (c / v, c / y, 0, -c / (y * y), 0),
        (-(u * v), -x * y, -y, -x, 0),
        (duals.sqrt(u), root, 1 / (2 * root), 0, 0),
        (duals.sin(turn), sin, 0, 0, cos),
        (duals.cos(turn), cos, 0, 0, -sin),
    ]
    differences = [
        field.number(0) + a - b
        for found, *expected in cases
        for a, b in zip((found.value, *found.slopes), expected, strict=True)
    ]
    return all(x.is_zero for x in differences)


def test_values_and_slopes() -> None:
    assert all_hold()


@pytest.mark.parametrize("flip", list(flips(dual)), ids=lambda flip: flip.text)
def test_every_sign_matters(flip: Any) -> None:
    with flip.applied():
        assert not all_hold()

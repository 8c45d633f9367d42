"""Traced numbers have the values of numbers, and their gradients are derivatives, identically."""

from __future__ import annotations

from typing import Any

import pytest
from oracles.random_field import RandomField
from support.sign_flips import flips

from heyoka_bike.numbers import traced
from heyoka_bike.numbers.traced import Traced, Traces


def all_hold() -> bool:
    """Whether one formula for each operation has its value and its slopes by x, y and an angle."""
    field = RandomField(128)
    root, y, c = (field.unknown() for _ in range(3))
    field.roots.append(root)
    x, angle = root * root, field.angle()
    sin, cos = angle.sin, angle.cos
    field.atan2 = lambda *_: c  # any number: its slopes do not depend on it
    a = Traces(field)
    u, v, turn = (Traced(value) for value in (x, y, angle))
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
        for p, q in zip((found.value, *a.gradient(found, [u, v, turn])), expected, strict=True)
    ]
    return all(d.is_zero for d in differences)


def test_values_and_gradients() -> None:
    assert all_hold()


def test_a_number_without_variables_has_no_gradient() -> None:
    field = RandomField(128)
    assert Traces(field).gradient(field.unknown(), [Traced(field.unknown()), 1]) == [0, 0]


@pytest.mark.parametrize("flip", list(flips(traced)), ids=lambda flip: flip.text)
def test_every_sign_matters(flip: Any) -> None:
    with flip.applied():
        assert not all_hold()

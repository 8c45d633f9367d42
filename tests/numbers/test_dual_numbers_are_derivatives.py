"""Dual numbers have the values of the numbers, and their slopes are derivatives, identically."""

from __future__ import annotations

from typing import Any

import pytest
from oracles.random_field import RandomField
from support.derivative_rules import all_hold
from support.sign_flips import flips

from heyoka_bike.numbers import dual
from heyoka_bike.numbers.dual import Duals


def duals(field: RandomField, values: Any) -> Any:
    a = Duals(field)
    return a, a.variables(values), lambda found: list(found.slopes)


def test_values_and_slopes() -> None:
    assert all_hold(duals)


@pytest.mark.parametrize("flip", list(flips(dual)), ids=lambda flip: flip.text)
def test_every_sign_matters(flip: Any) -> None:
    with flip.applied():
        assert not all_hold(duals)

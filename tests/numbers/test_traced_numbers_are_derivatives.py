"""Traced numbers have the values of numbers, and their gradients are derivatives, identically."""

from __future__ import annotations

from typing import Any

import pytest
from oracles.random_field import RandomField
from support.derivative_rules import all_hold
from support.sign_flips import flips

from heyoka_bike.numbers import traced
from heyoka_bike.numbers.traced import Traced, Traces


def traces(field: RandomField, values: Any) -> Any:
    a, variables = Traces(field), [Traced(x) for x in values]
    return a, variables, lambda found: a.gradient(found, variables)


def test_values_and_gradients() -> None:
    assert all_hold(traces)


def test_a_number_without_variables_has_no_gradient() -> None:
    field = RandomField(128)
    assert Traces(field).gradient(field.unknown(), [Traced(field.unknown()), 1]) == [0, 0]


@pytest.mark.parametrize("flip", list(flips(traced)), ids=lambda flip: flip.text)
def test_every_sign_matters(flip: Any) -> None:
    with flip.applied():
        assert not all_hold(traces)

"""Dual and traced numbers have the right values, and their derivatives are right identically."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from generators.sign_flips import flips
from heyoka_bike.numbers import dual
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.numbers.dual import Duals, Traced, Traces
from oracles.derivative_rules import all_hold
from oracles.random_field import RandomField


def duals(field: RandomField, values: Any) -> Any:
    a = Duals(field)
    return a, a.variables(values), lambda found: list(found.slopes)


def traces(field: RandomField, values: Any) -> Any:
    a, variables = Traces(field), [Traced(x) for x in values]
    return a, variables, lambda found: a.gradient(found, variables)


@pytest.mark.parametrize("numbers", [duals, traces])
def test_values_and_slopes(numbers: Any) -> None:
    assert all_hold(numbers)


def test_a_number_without_variables_has_no_gradient() -> None:
    field = RandomField(128)
    assert Traces(field).gradient(field.unknown(), [Traced(field.unknown()), 1]) == [0, 0]


def test_an_array_that_is_the_share_of_two_stays_what_it_is() -> None:
    x, y = (Traced(np.array([1.0, 2.0])) for _ in range(2))
    factor = np.array([3.0, 4.0])
    by_x, by_y = Traces(Arrays()).gradient(((x + y) + x) * factor, [x, y])
    assert by_x.tolist() == [6.0, 8.0]
    assert by_y.tolist() == [3.0, 4.0]


@pytest.mark.parametrize("flip", list(flips(dual)), ids=lambda flip: flip.text)
def test_every_sign_matters(flip: Any) -> None:
    with flip.applied():
        assert not (all_hold(duals) and all_hold(traces))

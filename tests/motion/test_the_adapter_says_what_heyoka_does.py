"""The adapter's formula for the order and its step outcomes agree with heyoka itself."""

import heyoka
import pytest

from heyoka_bike.motion.heyoka_adapter import (
    Outcome,
    TaylorIntegrator,
    order_of,
    tolerance_of,
    variables,
)


def pendulum(start=(0.1, 0.0), **options):
    x, v = variables(["x", "v"])
    return TaylorIntegrator([(x, v), (v, -heyoka.sin(x))], start, float, **options)


@pytest.mark.parametrize("bits", [10, 20, 33.3, 52, 80, 300])
def test_the_order_for_a_tolerance(bits):
    found = pendulum(tolerance=2.0**-bits)
    assert found.order == max(order_of(bits), 2)
    assert found.tolerance == 2.0**-bits


@pytest.mark.parametrize("order", range(4, 40))
def test_the_tolerance_for_an_order(order):
    assert pendulum(tolerance=tolerance_of(order)).order == order


def test_the_outcome_of_a_step():
    free, limited = pendulum().step(1e9), pendulum().step(1e-3)
    assert (free.outcome, limited.outcome) == (Outcome.TAKEN, Outcome.LIMITED)
    assert limited.length == 1e-3 < free.length < 1e9
    assert pendulum(start=(float("nan"), 0.0)).step(1.0).outcome is Outcome.NOT_FINITE

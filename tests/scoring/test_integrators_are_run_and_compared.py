"""The error of a common method with a fixed step is recognised by running this method."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("heyoka")


from generators.fixed_steps import Equations as Discretised
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.programs.integrators import METHODS, Carried


@pytest.fixture(scope="module")
def reduced(reference):
    """A program in roll, pitch, steer, their rates and the rolling rate."""
    return Discretised(reference, is_regular=True)


def integrator(results, reference):
    found = diagnose(results, reference).diagnosis
    return [x for x in found if x.code == "integrator"]


@pytest.mark.proof
@pytest.mark.parametrize(
    ("method", "step", "says"),
    [
        ("rk4", 0.01, "the classical Runge-Kutta method of order 4 (RK4)"),
        ("three_eighths", 0.005, "Kutta's 3/8 rule of order 4"),
        ("kutta3", 0.01, "Kutta's method of order 3"),
        ("ssp3", 0.005, "Shu and Osher's method of order 3"),
        ("heun", 0.002, "Heun's method"),
    ],
)
def test_the_method_and_its_step_are_named(reference, reduced, method, step, says):
    (found,) = integrator(reduced.run(reduced.explicit(method), step), reference)
    assert found.evidence["methods"] == [{"method": says, "step": step}]
    assert found.message.startswith(f"The error is that of {says} with a step of {step:g} s. ")
    assert found.message.count("No other error is visible") == 1


@pytest.mark.proof
def test_angles_alone_show_it(reference, reduced):
    results = reduced.run(reduced.explicit("rk4"), 0.01)
    angles = {}
    for n, m in enumerate(results.maneuvers, 1):
        angles |= {f"{key}_{n}": m.values[key] for key in ("roll_angle", "steer_angle")}
    table = {"time": np.arange(1001) / 100, **angles}
    (found,) = integrator(table, reference)
    assert found.evidence["methods"][0]["method"].endswith("(RK4)")
    assert found.evidence["methods"][0]["step"] == 0.01


@pytest.mark.proof
@pytest.mark.parametrize(("method", "step"), [("rk4", 0.05), ("heun", 0.04)])
def test_rows_far_apart_show_steps_as_long(reference, reduced, method, step):
    """The rows are too far apart to carry an error from one row to the next in a single step."""
    explicit, states = reduced.explicit(method), [reduced.start]
    for _ in range(round(10.0 / step)):
        states.append(explicit(states[-1], step, None))
    made = np.stack(states, axis=2)
    table = {"time": np.arange(len(states)) * step}
    for i, n in enumerate(reference):
        values = zip(BENCHMARK_COLUMNS, reduced.outputs(made[:, i]), strict=True)
        table |= {f"{key}_{n}": x for key, x in values}
    (found,) = integrator(table, reference)
    assert found.evidence["methods"][0]["step"] == step


@pytest.mark.proof
def test_a_large_error_is_followed_by_steps_from_the_start(reference, reduced):
    """Explicit Euler has an error of 0.01. An approximation to first order would be wrong by
    1e-4."""
    results = reduced.run(reduced.explicit("euler"), 0.001)
    few = tuple(replace(m, values={"roll_rate": m.values["roll_rate"]}) for m in results.maneuvers)
    (found,) = integrator(replace(results, maneuvers=few), reference)
    assert found.evidence["methods"] == [{"method": "explicit Euler", "step": 0.001}]
    assert found.evidence["relief"] > 1e6


@pytest.mark.parametrize(
    ("method", "says"), [("euler", "explicit Euler"), ("symplectic", "semi-implicit Euler")]
)
def test_a_step_as_long_as_the_rows_is_named_from_one_column(reference, reduced, method, says):
    """The error is half as large as the column, so a propagated error does not resemble it."""
    step = reduced.symplectic_euler if method == "symplectic" else reduced.explicit(method)
    results = reduced.run(step, 0.01)
    one = replace(
        results.maneuvers[0], values={"roll_rate": results.maneuvers[0].values["roll_rate"]}
    )
    (found,) = integrator(replace(results, maneuvers=(one,)), reference)
    assert found.evidence["methods"] == [{"method": says, "step": pytest.approx(0.01)}]


@pytest.mark.proof
def test_other_weights_are_another_method(reference, reduced):
    """RK4 with the weights 1, 2, 1, 2 has order 1, and is not one of the methods in the list."""
    results = reduced.run(reduced.explicit("rk4_other_weights"), 0.01)
    for found in integrator(results, reference):
        assert not found.message.startswith("The error is that of")


@pytest.mark.parametrize("method", METHODS, ids=lambda m: m.says)
def test_a_method_has_its_order(reference, method):
    """With half the step, the error of a motion that rolls and steers is 2^p times smaller."""
    equations = Equations.binary64(Bicycle.parse(reference.bicycle, reference.parameters))
    start = np.array([[0.1], [0.0], [0.05], [0.2], [-0.3], [15.0], [0.0]])

    def rates(y):
        made = equations.rates_with_yaw(list(y))
        return np.array([np.broadcast_to(r, y[0].shape) for r in made])

    def missed(h):
        right = start
        rk4 = next(m for m in METHODS if m.says.endswith("(RK4)"))
        for _ in range(64):
            right = rk4.step(rates, right, h / 64)
        return float(np.max(np.abs(method.step(rates, start, h) - right)))

    assert np.log2(missed(0.01) / missed(0.005)) == pytest.approx(method.order + 1, abs=0.3)


def test_errors_are_carried_as_the_method_makes_them(reference, reduced):
    """A second implementation, compiled by heyoka, takes every step."""
    rk4 = next(m for m in METHODS if m.says.endswith("(RK4)"))
    equations = Equations.binary64(Bicycle.parse(reference.bicycle, reference.parameters))
    exact = [reduced.start]
    fine, coarse = reduced.explicit("rk4"), [reduced.start]
    for _ in range(200):
        y = exact[-1]
        for _ in range(16):
            y = fine(y, 0.01 / 16, None)
        exact.append(y)
        coarse.append(fine(coarse[-1], 0.01, None))
    states, made = (np.stack(x, axis=2)[:, 1] for x in (exact, coarse))
    carried = Carried(equations, states, 0.01).errors(rk4, 1)
    left = np.abs(carried - (made - states)).max(axis=1)
    assert np.all(left < 1e-5 * np.abs(made - states).max(axis=1) + 1e-15)

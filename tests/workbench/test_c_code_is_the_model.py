"""The C code generated from the model computes its values, and its integrators converge."""

import random

import flint
import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.constants import constants
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.kinematics import unfold
from heyoka_bike.bicycle.equations.model import few_products
from heyoka_bike.bicycle.equations.outputs import columns
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.straight_line import StraightLine
from heyoka_bike.workbench.bench.batches import floor
from heyoka_bike.workbench.bench.compiled import (
    CompiledPeers,
    NoCompilerError,
    operations,
    slope_source,
)
from speed_page import floor_seconds

pytestmark = pytest.mark.proof

BITS = 200


@pytest.fixture(scope="module")
def balls():
    return Balls(BITS)


@pytest.fixture(scope="module")
def peers(bicycle):
    try:
        return CompiledPeers(bicycle)
    except NoCompilerError as e:
        pytest.skip(str(e))


@pytest.fixture(scope="module")
def start(bicycle, maneuvers, balls):
    """The start of maneuver 2."""
    with balls.precision():
        state = initial_state(Equations.of(bicycle, balls, is_regular=False), maneuvers[1])
        return np.array([float(x.mid()) for x in state[:6]])


def test_rates_and_columns_are_the_models(bicycle, balls, peers):
    random.seed(3)
    for _ in range(50):
        state = np.array([
            *(random.uniform(-0.4, 0.4) for _ in range(3)),
            *(random.uniform(-2, 2) for _ in range(2)), random.uniform(5, 30),
        ])  # fmt: skip
        rates, found = peers.evaluate(state)
        with balls.precision():
            k = constants(bicycle, balls)
            exact = [flint.arb(float(x)) for x in state]
            right = [float(x.mid()) for x in few_products(k, balls, exact)]
            o, u = unfold(k, balls, exact, is_regular=False)
            every = columns(k, balls, o, u, *exact[:3], flint.arb(0))
            right_columns = [float(every[c].mid()) for c in BENCHMARK_COLUMNS]
        # The values result from a few hundred operations, some of which are differences. The limit
        # is 1e4 units of roundoff of the largest value.
        assert np.abs(rates - right).max() < 1e-12 * np.abs(right).max()
        assert np.allclose(found, right_columns, rtol=1e-13, atol=1e-13)


def test_every_operation_is_written_once(bicycle):
    lines = [x.strip() for x in slope_source(bicycle).splitlines() if " = " in x]
    right = [x.partition(" = ")[2] for x in lines if x.startswith("const")]
    assert len(right) == len(set(right)) == sum(operations(bicycle).values())
    # docs/model.md states that heyoka's decomposition has 437 variables, including the six states.
    assert 400 < len(right) < 500
    assert operations(bicycle)["sin"] == operations(bicycle)["cos"] == 3


def test_signs_and_literals_are_worked_out():
    code = StraightLine()
    x, y = code.variable("x"), code.variable("y")
    two = code.literal(2.0)
    assert (two * 3 + 1).value == 7
    assert (-x * y).text == "-" + (x * y).text
    assert (x * -y).text == (-(x * y)).text
    assert (x - (-y)).text == (x + y).text == (y + x).text
    assert (x * 1).text == (x + 0).text == (x / 1).text == "x"
    assert (0 * x).value == 0
    assert (1 - x).text == code.operation("-", code.literal(1.0), x).text
    assert (-x + y).text == (y - x).text
    assert list(code.statements.values()) == ["x * y", "x + y", "1.0 - x", "y - x"]


@pytest.mark.parametrize(
    ("method", "tolerances", "least"),
    # Each case: the method, two tolerances or steps, and the factor by which the error must fall.
    # The factor is at least 10 for an adaptive method, and about 2^4 for RK4.
    [("DOPRI5", (1e-7, 1e-9), 10), ("DOP853", (1e-8, 1e-10), 10), ("RK4", (0.02, 0.01), 12)],
)
def test_integrators_converge_to_the_reference(peers, start, reference, method, tolerances, least):
    times = np.asarray(reference.times)
    right = np.array([reference[2].rows.hi[c] for c in BENCHMARK_COLUMNS])
    errors = []
    for tolerance in tolerances:
        states, found, calls = peers.solve(method, start, times, tolerance)
        assert calls > 100
        assert np.array_equal(states[:, 0], start)
        errors.append(np.abs(found - right).max())
        assert np.array_equal(states[0], found[0])
    assert errors[1] < errors[0] / least
    assert errors[1] < 1e-4


@pytest.mark.parametrize(("method", "name"), [("DOPRI5", "RK45"), ("DOP853", "DOP853")])
def test_errors_are_those_of_scipy(peers, start, method, name):
    # The code has the same formulas and dense output as SciPy's DOP853, at the same tolerance. Only
    # the step size control differs.
    scipy = pytest.importorskip("scipy.integrate")
    times = np.linspace(0, 2, 201)
    right, _, _ = peers.solve("DOP853", start, times, 1e-14)
    found, _, calls = peers.solve(method, start, times, 1e-8)
    other = scipy.solve_ivp(
        lambda _, y: peers.evaluate(np.ascontiguousarray(y))[0], (0, 2), start,
        method=name, t_eval=times, rtol=1e-8, atol=1e-8,
    )  # fmt: skip
    ours, theirs = np.abs(found - right).max(), np.abs(other.y - right).max()
    assert theirs / 10 < ours < theirs * 10
    assert other.nfev / 2 < calls < other.nfev * 2


def test_a_run_that_fails_is_told(peers, start):
    state = start.copy()
    state[0] = np.nan
    assert peers.solve("DOPRI5", state, np.linspace(0, 1, 11), 1e-6)[2] == -1


def test_without_a_compiler(bicycle, monkeypatch, tmp_path):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(NoCompilerError, match="no C compiler"):
        CompiledPeers(bicycle)
    monkeypatch.setenv("CC", "/bin/false")
    with pytest.raises(NoCompilerError, match="does not compile"):
        CompiledPeers(bicycle)


def test_the_floor_counts_products(bicycle):
    # At order 1, a product of two variables needs three products, and a product with a constant
    # needs two.
    given = {"products_per_second": 1e9, "products": 10, "scales": 5}
    assert floor_seconds(order=1, steps=2, **given) == pytest.approx(80e-9)
    count = operations(bicycle)
    assert count["scale"] > 50
    found = floor(bicycle)
    assert (found["products"], found["scales"]) == (count["*"] + count["/"] + 6, count["scale"])
    assert 1e8 < found["products_per_second"] < 1e12

"""The equations that `export` writes, in each language, reproduce the model and its motion.

A solver of the language integrates maneuver 2 with them; languages that are not installed are
skipped.
"""

import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import whole_rates
from heyoka_bike.bicycle.parameters import read_bicycle
from heyoka_bike.numbers.arithmetic import Multiprecision
from heyoka_bike.system.resources import collection, find_input
from support import equation_programs
from support.equation_programs import SOMEWHERE, export

pytestmark = pytest.mark.proof

# Number of half seconds that are integrated in each language. Octave takes a millisecond for each
# call of its rates.
HALVES = {"python": 20, "c": 20, "fortran": 20, "matlab": 1, "rust": 20}
# Number of digits that the solvers reach at their tolerances, relative to each column's largest
# value.
DIGITS = 12


@pytest.fixture(scope="module")
def right(bicycle):
    """Rates, Jacobian (by differences) and columns from the model with 60 digits."""
    a = Multiprecision(60)
    exact = Equations.of(bicycle, a)
    y, h = [a.context.mpf(x) for x in SOMEWHERE], a.context.mpf("1e-20")

    def rates(shift):
        return np.array(whole_rates(exact, [x + d for x, d in zip(y, shift, strict=True)]))

    steps = h * np.eye(len(y), dtype=int)
    jacobian = np.transpose([(rates(step) - rates(-step)) / (2 * h) for step in steps])
    columns = exact.columns(y)
    found = rates(0 * steps[0]), jacobian, [columns[name] for name in BENCHMARK_COLUMNS]
    return [np.array(x, float) for x in found]


@pytest.mark.parametrize("language", HALVES)
def test_numbers_and_motion(language, tmp_path, right, reference):
    export(tmp_path, language)
    halves = HALVES[language]
    *found, motion = getattr(equation_programs, f"{language}_numbers")(tmp_path, halves)
    for values, expected in zip(found, right, strict=True):
        # The values result from a few hundred operations. The limit is 1e4 units of roundoff of the
        # largest value.
        assert np.abs(values - expected).max() < 1e-12 * np.abs(expected).max()
    rows = [50 * i for i in range(halves + 1)]
    exact = np.array([reference[2].rows.hi[c] for c in BENCHMARK_COLUMNS])
    error = np.abs(motion.T - exact[:, rows]).max(1) / np.abs(exact).max(1)
    assert -np.log10(error.max()) > DIGITS, dict(zip(BENCHMARK_COLUMNS, error, strict=True))


@pytest.mark.parametrize("name", collection("bicycles"))
def test_every_bicycle_has_its_equations(name, tmp_path):
    export(tmp_path, "python", "--bicycle", name)
    module = {}
    exec(compile((tmp_path / "bicycle.py").read_text(), name, "exec"), module)
    a = Multiprecision(40)
    exact = Equations.of(read_bicycle(find_input("bicycles", name)), a)
    right = np.array(whole_rates(exact, [a.context.mpf(x) for x in SOMEWHERE]), float)
    found = np.array(module["rates"](0.0, SOMEWHERE))
    assert np.abs(found - right).max() < 1e-12 * np.abs(right).max()
    # At the start the residuals of both forms are zero. They are sums of forces of a few hundred
    # newtons.
    start = module["descriptor_start_1"](), module["descriptor_start_rates_1"]()
    for residual in (module["residual_2"], module["residual_3"]):
        assert np.abs(residual(0.0, *start)).max() < 1e-10

"""Each precision reproduces the published solution to its own last digits."""

import flint
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import evaluator


@pytest.mark.parametrize("number", [1, 2, 3])
@pytest.mark.parametrize(
    "precision", ["binary64", "longdouble", pytest.param("binary128", marks=pytest.mark.proof)]
)
def test_digits_of_a_format(reference, bicycle, maneuvers, precision, number):
    """Each step rounds once, to 2^-p of the state, and the motion magnifies errors at most by 2.7.

    (The derivative of the state at 10 s with respect to the speed at the start; along the way the
    sensitivities of the scaled columns are no larger.) So the limit is 3 x 2^-p of the scale for
    each step.
    """
    maneuver, published = maneuvers[number - 1], reference[number]
    run = integrate(bicycle, maneuver, precision)
    at = evaluator(run, run.bits + 64)
    worst = 0.0
    with at.balls.precision():
        for i in range(0, maneuver.rows, 20):
            found = at.columns(maneuver.time(i))
            for key in BENCHMARK_COLUMNS:
                hi, lo = published.rows.hi[key][i], published.rows.lo[key][i]
                error = abs(found[key] - flint.arb(float(hi)) - flint.arb(float(lo)))
                worst = max(worst, float(error.upper()) / published.scale(key))
    assert worst < 3 * run.steps * 2.0**-run.bits
    # The error must not be much smaller than one unit of roundoff either. Otherwise the run would
    # have used a higher precision than requested.
    assert worst > 2.0**-run.bits / 4


@pytest.mark.parametrize(
    "number",
    [
        pytest.param(1, marks=pytest.mark.slow),
        pytest.param(2, marks=pytest.mark.slow),
        pytest.param(3, marks=pytest.mark.proof),
    ],
)
def test_the_published_run_is_repeated_bit_by_bit(bicycle, maneuvers, candidate, number):
    """At 70 digits all arithmetic is MPFR's, correctly rounded, so all machines agree."""
    published = candidate[number - 1]
    run = integrate(bicycle, maneuvers[number - 1], 70)
    assert run.breaks == published.breaks
    assert run.pieces == published.pieces

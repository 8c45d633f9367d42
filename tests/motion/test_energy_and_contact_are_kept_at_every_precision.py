"""A run of any precision p conserves energy to 16 x 2^-p and keeps the front wheel on the floor."""

import pytest

from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import evaluator
from support.tiers import ONE_MANEUVER

PRECISIONS = ["binary64", "longdouble", "binary128", 30, 70]


@pytest.mark.parametrize("number", ONE_MANEUVER)
@pytest.mark.parametrize("precision", PRECISIONS)
def test_drift(bicycle, maneuvers, candidate, precision, number):
    if precision == 70:
        # At 70 digits, test the published run instead of a new one.
        run = candidate[number - 1]
        assert run.precision == "70 digits"
    else:
        run = integrate(bicycle, maneuvers[number - 1], precision)
    drift = evaluator(run, run.bits + 64).drift()
    # The error comes from rounding the state to p bits: the energy has an error of up to about 2 x
    # 2^-p. The state is carried exactly from step to step, so the number of steps does not multiply
    # the error.
    assert drift.energy <= 16
    # Pitch, roll and steer are below 1 rad, and the wheel base is 1.02 m. So errors of the contact
    # have a scale of about 1.
    assert drift.contact <= 16 * 2.0**-run.bits
    assert drift.performance < 100 * 32 * 2.0**-run.bits


@pytest.mark.proof
def test_both_forms_give_the_same_motion(bicycle, maneuvers, candidate):
    few = candidate[1]
    assert not few.is_regular
    regular = integrate(bicycle, maneuvers[1], 40, is_regular=True)
    at = evaluator(few, 200), evaluator(regular, 200)
    with at[0].balls.precision():
        for row in range(0, 1001, 50):
            t = maneuvers[1].time(row)
            a, b = at[0].columns(t), at[1].columns(t)
            for name in a:
                # Both runs have 40 digits and 4 additional bits. The energy is below 2000 J, and
                # the condition number is below 3.
                assert abs(a[name] - b[name]) < 1e-36, (name, row)


@pytest.mark.proof
def test_a_looser_tolerance_is_seen(bicycle, maneuvers):
    tight = integrate(bicycle, maneuvers[1])
    loose = integrate(bicycle, maneuvers[1], tolerance=1e-6)
    assert loose.steps < tight.steps
    assert evaluator(loose, 128).drift().energy > 1e3

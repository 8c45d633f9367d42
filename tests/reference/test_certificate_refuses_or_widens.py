"""A damaged candidate is rejected by name, or its bound grows by the size of the damage.

Each case damages a certified candidate of maneuver 2 (113 bits, half a second) in one way. The true
effect of the damage is known or measured against the undamaged candidate. The bound must cover it
without being absurdly larger.
"""

from dataclasses import replace
from fractions import Fraction

import flint
import pytest

from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import evaluator
from heyoka_bike.numbers.analytic import NotAnalyticError
from heyoka_bike.numbers.arithmetic import exact_ball, upper_fraction
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.proof.cauchy import moved, rho
from heyoka_bike.reference.proof.enclose import enclose
from heyoka_bike.reference.proof.rows import constant_columns, enclose_rows

pytestmark = pytest.mark.proof


@pytest.fixture(scope="module")
def run(bicycle, maneuvers):
    return integrate(bicycle, replace(maneuvers[1], duration=Fraction(1, 2)), "binary128")


@pytest.fixture(scope="module")
def exact(bicycle, run):
    """The same motion with 60 digits."""
    return integrate(bicycle, run.maneuver, 60)


@pytest.fixture(scope="module")
def sound(run):
    return float(enclose(run).worst)


def damaged(run, piece, change):
    """Return the candidate with ``change(rows)`` applied to the coefficients of one segment."""
    pieces = [[list(row) for row in p] for p in run.pieces]
    change(pieces[piece])
    return replace(run, pieces=tuple(tuple(map(tuple, p)) for p in pieces))


def test_a_sound_candidate_is_certified_near_its_roundoff(run, sound):
    # The state is stored to 2^-129, and increments of up to 20 rad/s are rounded to 2^-113. This is
    # an error of 1e-33.
    assert 1e-34 < sound < 1e-27


def test_a_dropped_step(run):
    gap = replace(
        run, breaks=run.breaks[:2] + run.breaks[3:], pieces=run.pieces[:2] + run.pieces[3:]
    )
    # The segments after the gap are stretched over it, so they are far from any solution.
    with pytest.raises(NotCertifiedError, match=r"step 2 of \d+, t = .* is not certified"):
        enclose(gap)
    missing = replace(run, pieces=run.pieces[:-1])
    with pytest.raises(NotCertifiedError, match="incomplete"):
        enclose(missing)
    short = replace(run, breaks=run.breaks[:-1], pieces=run.pieces[:-1])
    with pytest.raises(NotCertifiedError, match=r"expected 0 to 0\.5 s"):
        enclose(short)


def test_a_piece_cut_to_degree_19(run, sound):
    def cut(rows):
        rows[:] = [row[:20] for row in rows]

    # heyoka's order is 42 here. The cut removes the terms of order 20 and higher, which carry about
    # half of the digits.
    bound = float(enclose(damaged(run, 2, cut)).worst)
    lost = max(abs(c) for row in run.pieces[2] for c in row[20:]) / 2**run.grid
    assert bound > lost > 1e6 * sound


def test_a_state_jump(run, sound):
    def jump(rows):
        rows[0][0] += round(Fraction(1, 10**15) * 2**run.grid)

    bound = float(enclose(damaged(run, 3, jump)).worst)
    assert 1e-15 <= bound < 1e-12


def test_a_coefficient_off_by_1e_22(run, sound):
    def nudge(rows):
        rows[2][3] += round(Fraction(1, 10**22) * 2**run.grid)

    bound = float(enclose(damaged(run, 3, nudge)).worst)
    assert 1e-22 <= bound < 1e-18


def test_gravity_off_by_1e_24(run, sound):
    """The candidate solves another problem; the distance of the two solutions is of order 1e-24."""
    heavier = run.bicycle.replace(g=Exact(Fraction(981, 100) + Fraction(1, 10**24)))
    bound = float(enclose(replace(run, bicycle=heavier)).worst)
    true = distance(run, integrate(heavier, run.maneuver, "binary128"))
    assert 1e-26 < true <= bound < 1e3 * true


def test_an_inertia_sign_flipped(run):
    flipped = run.bicycle.replace(IBxz=Exact(Fraction(-24, 10)))
    with pytest.raises(NotCertifiedError, match="expected less than"):
        enclose(replace(run, bicycle=flipped))


def test_a_roll_rate_wrong_in_the_25th_digit(run, sound):
    rate = Exact(run.maneuver.roll_rate.rational + Fraction(1, 10**25))
    other = replace(run.maneuver, roll_rate=rate)
    bound = float(enclose(replace(run, maneuver=other)).worst)
    true = distance(run, integrate(run.bicycle, other, "binary128"))
    assert 1e-26 < true <= bound < 1e4 * true


def test_a_candidate_that_is_too_coarse(run, bicycle):
    coarse = integrate(bicycle, run.maneuver, "binary64", tolerance=1e-3)
    with pytest.raises(NotCertifiedError):
        enclose(coarse)


@pytest.mark.parametrize("precision", ["binary64", "longdouble", "binary128"])
def test_the_bound_covers_the_true_error_of_every_precision(bicycle, run, exact, precision):
    other = integrate(bicycle, run.maneuver, precision)
    bound = float(enclose(other).worst)
    true = distance(other, exact)
    # A bound on roundoff assumes the worst case. It may be too large by some digits, but never too
    # small.
    assert true <= bound < 1e7 * true


def test_an_energy_that_does_not_meet_its_constant_is_refused(run):
    at = evaluator(run, certificate=enclose(run))
    constant = constant_columns(run)
    assert len(enclose_rows(at, {}, constant)) == run.maneuver.rows
    with at.balls.precision():
        off = {name: exact_ball(x) + flint.arb("1e-24") for name, x in constant.items()}
    with pytest.raises(
        NotCertifiedError,
        match=r"mechanical_energy, row 0: .* but the value that should be constant is",
    ):
        enclose_rows(at, {}, off)


def test_derivatives_on_half_the_polydisc_bound_no_state_beyond_it():
    polydisc = rho(2)
    half = upper_fraction(polydisc[0]) / 2
    assert moved([half / 2, half / 2], polydisc) == 1
    with pytest.raises(NotAnalyticError, match="half the polydisc"):
        moved([half, half * (1 + Fraction(1, 10**9))], polydisc)


def test_both_forms_are_certified(bicycle, run):
    other = integrate(bicycle, run.maneuver, "binary128", is_regular=True)
    assert float(enclose(other).worst) < 1e-25


def test_a_start_with_steer_is_certified(bicycle, run):
    turned = replace(run.maneuver, roll=Exact(Fraction(1, 10)), steer=Exact(Fraction(-1, 10)))
    assert float(enclose(integrate(bicycle, turned, "binary128")).worst) < 1e-25


def distance(a, b):
    """Return the largest distance of two candidates' states at 300 times."""
    import flint

    worst = 0.0
    with flint.ctx.workprec(300):
        for i in range(301):
            t = Fraction(i, 300) * a.maneuver.duration
            pairs = zip(a.state(t), b.state(t), strict=True)
            worst = max(worst, *(abs(float((x - y).mid())) for x, y in pairs))
    return worst

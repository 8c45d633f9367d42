"""Events agree with the known zeros of polynomials, and with heyoka's own event detection."""

import random
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise, product

import flint
import numpy as np
import pytest

from heyoka_bike.errors import InputError
from heyoka_bike.motion.events import (
    FRONT_LIFT,
    GREATEST_LEAN,
    KINDS,
    LEAST_LEAN,
    REAR_LIFT,
    UPRIGHT,
    events,
    first_event,
    follow,
    zeros,
)
from heyoka_bike.motion.integrate import integrate, right_hand_side
from heyoka_bike.motion.trajectory import Certificate, Trajectory, evaluator
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.precision import Precision

GRID = 120


def made(bicycle, maneuver, roots, breaks=(0, 1, 2), shift=0):
    """Return a trajectory whose roll is the product of (t - root) over the roots, plus a shift.

    The roll rate is the derivative of the roll, and all else is zero. So the trajectory satisfies
    the first equation of motion, which suffices for events of the roll angle.
    """
    pieces = []
    for a, b in pairwise(breaks):
        roll = polynomial(1)
        for root in roots:
            roll *= polynomial(a - root, b - a)
        roll += polynomial(shift)
        rate = roll.derivative() * (1 / polynomial(b - a)[0])
        pieces.append((on_grid(roll), (0,), (0,), on_grid(rate), (0,), (0,), (0,)))
    return Trajectory(
        bicycle=bicycle, maneuver=replace(maneuver, duration=Fraction(breaks[-1])),
        precision="100 bits", bits=100, is_regular=True, order=20, grid=GRID,
        breaks=tuple(map(Fraction, breaks)), pieces=tuple(pieces),
    )  # fmt: skip


def polynomial(*coefficients):
    return flint.fmpq_poly(
        [flint.fmpq(x.numerator, x.denominator) for x in map(Fraction, coefficients)]
    )


def on_grid(p):
    return tuple(round(Fraction(int(c.p), int(c.q)) * 2**GRID) for c in p.coeffs()) or (0,)


def proof_of(run, *bounds):
    """Return a certificate of the trajectory, with one bound, or one for each segment."""
    by_piece = bounds if len(bounds) > 1 else bounds * run.steps
    return Certificate(run.states, tuple((b,) * 7 for b in by_piece), (by_piece[-1],) * 7)


def holds(time, exact):
    with flint.ctx.workprec(300):
        return time.contains(flint.arb(flint.fmpq(exact.numerator, exact.denominator)))


def test_zeros_of_polynomials_are_enclosed_to_the_last_bits(bicycle, maneuvers):
    roots = [Fraction(1, 3), Fraction(2, 3), Fraction(1, 3) + Fraction(1, 10**4), Fraction(17, 9)]
    found = zeros(made(bicycle, maneuvers[0], roots), KINDS[UPRIGHT], UPRIGHT)
    assert len(found) == 4
    for event, root in zip(found, sorted(roots), strict=True):
        # The coefficients are integers times 2^-GRID. So the accuracy of the root is limited to
        # 2^-GRID divided by the slope.
        with flint.ctx.workprec(300):
            off = abs(event.time.mid() - flint.arb(flint.fmpq(root.numerator, root.denominator)))
        assert off < 2.0**-GRID * 1e6
        assert event.time.rad() < 2.0**-95
    assert [e.rises for e in found] == [False, True, False, True]


def test_an_event_at_a_break_is_found_once(bicycle, maneuvers):
    (event,) = zeros(made(bicycle, maneuvers[0], [Fraction(1)]), KINDS[UPRIGHT], UPRIGHT)
    assert holds(event.time, Fraction(1))


@pytest.mark.parametrize("is_certified", [False, True])
def test_the_start_is_no_event_and_a_zero_without_a_change_of_sign_is_undecided(
    bicycle, maneuvers, is_certified
):
    run = made(bicycle, maneuvers[0], [Fraction(0), Fraction(1, 2), Fraction(1, 2)])
    bound = Fraction(1, 2**80)
    proof = proof_of(run, bound) if is_certified else None
    (event,) = zeros(run, KINDS[UPRIGHT], UPRIGHT, proof)
    assert event.rises is None
    assert not event.is_single
    assert holds(event.time, Fraction(1, 2))
    # With a certificate, the radius is the width of the region where t (t - 1/2)^2 is below the
    # bound, plus the error of bisection. Without a certificate, it is the width of the region where
    # t (t - 1/2)^2 is below the last bits of the balls.
    assert float(event.time.rad()) < (8 * 2.0**-40 if is_certified else 2.0**-75)


def test_a_zero_at_the_end_may_be_beyond_it(bicycle, maneuvers):
    run = made(bicycle, maneuvers[0], [Fraction(2)])
    for proof in (None, proof_of(run, Fraction(1, 2**90))):
        (event,) = zeros(run, KINDS[UPRIGHT], UPRIGHT, proof)
        assert event.rises is None
        assert holds(event.time, Fraction(2))


def test_a_bound_that_reaches_zero_counts_however_far_the_polynomial_is(bicycle, maneuvers):
    """Binary64 alone would find no event."""
    half = Fraction(1, 2)
    run = made(bicycle, maneuvers[0], [half, half], breaks=(0, 1), shift=Fraction(1, 4))
    assert zeros(run, KINDS[UPRIGHT], UPRIGHT) == []
    (event,) = zeros(run, KINDS[UPRIGHT], UPRIGHT, proof_of(run, Fraction(3, 8)))
    assert event.rises is None


def test_what_only_the_bound_keeps_from_zero_is_undecided(bicycle, maneuvers):
    half, gap = Fraction(1, 2), Fraction(1, 2**30)
    run = made(bicycle, maneuvers[0], [half, half], shift=gap)
    assert zeros(run, KINDS[UPRIGHT], UPRIGHT, proof_of(run, gap * Fraction(9, 10))) == []
    (event,) = zeros(run, KINDS[UPRIGHT], UPRIGHT, proof_of(run, gap * Fraction(11, 10)))
    assert event.rises is None
    run = made(bicycle, maneuvers[0], [half, half], shift=-gap)
    two = zeros(run, KINDS[UPRIGHT], UPRIGHT, proof_of(run, gap * Fraction(9, 10)))
    assert [(e.rises, e.is_single) for e in two] == [(False, True), (True, True)]


def test_a_change_of_sign_with_a_slope_of_zero_may_be_more_than_one_zero(bicycle, maneuvers):
    run = made(bicycle, maneuvers[0], [Fraction(1, 2)] * 3)
    (event,) = zeros(run, KINDS[UPRIGHT], UPRIGHT, proof_of(run, Fraction(1, 2**40)))
    assert event.rises
    assert not event.is_single


def test_a_certificate_widens_the_enclosure_by_its_bound_over_the_slope(bicycle, maneuvers):
    run = made(bicycle, maneuvers[0], [Fraction(1, 4)])
    bound = Fraction(1, 2**40)
    (event,) = zeros(run, KINDS[UPRIGHT], UPRIGHT, proof_of(run, bound))
    assert event.is_single
    assert 2.0**-40 < float(event.time.rad()) < 2.0**-38
    assert holds(event.time, Fraction(1, 4) + bound)
    assert holds(event.time, Fraction(1, 4) - bound)


def test_a_piece_is_looked_at_inside_its_own_interval_only(bicycle, maneuvers):
    """The first segment would cross zero just after its end, where its bound does not apply.

    At the break its polynomial is 2^-60, and the second segment starts there and rises. The exact
    motion within both bounds is never zero.
    """
    tiny = Fraction(1, 2**60)
    falling = made(bicycle, maneuvers[0], [1 + tiny], breaks=(0, 1))
    (first,) = falling.pieces
    down = tuple(tuple(-c for c in row) for row in first)
    up = made(bicycle, maneuvers[0], [1 - tiny], breaks=(1, 2)).pieces[0]
    run = replace(falling, breaks=tuple(map(Fraction, (0, 1, 2))), pieces=(down, up))
    proof = proof_of(run, tiny / 2)
    assert zeros(run, KINDS[UPRIGHT], UPRIGHT, proof) == []
    # If the bounds of the values include zero, it is undecided whether there is a crossing.
    (event,) = zeros(run, KINDS[UPRIGHT], UPRIGHT, proof_of(run, 2 * tiny))
    assert event.rises is None
    assert holds(event.time, Fraction(1))


@pytest.mark.parametrize("wide", [0, 1])
def test_a_crossing_at_a_break_is_one_event_however_wide_the_bound_of_either_piece(
    bicycle, maneuvers, wide
):
    run = made(bicycle, maneuvers[0], [Fraction(1)])
    bounds = [Fraction(1, 2**90), Fraction(1, 2**90)]
    bounds[wide] = Fraction(1, 2**30)
    (event,) = zeros(run, KINDS[UPRIGHT], UPRIGHT, proof_of(run, *bounds))
    assert event.rises
    assert event.is_single
    assert holds(event.time, Fraction(1))


@pytest.mark.parametrize("is_certified", [False, True])
@pytest.mark.parametrize("apart", [Fraction(1, 10**7), Fraction(1, 10**12), Fraction(1, 10**15)])
def test_crossings_close_together_are_all_found(bicycle, maneuvers, apart, is_certified):
    roots = [Fraction(1, 3), Fraction(1, 3) + apart, Fraction(3, 2)]
    run = made(bicycle, maneuvers[0], roots)
    proof = proof_of(run, apart**2 / 100) if is_certified else None
    found = zeros(run, KINDS[UPRIGHT], UPRIGHT, proof)
    assert [(e.rises, e.is_single) for e in found] == [(True, True), (False, True), (True, True)]
    assert float(found[1].time - found[0].time) == pytest.approx(float(apart), rel=0.1)


def grazing(run, certificate, apart):
    """Return roll minus a threshold just below its first maximum, crossed twice within `apart`."""
    lean = next(events(run, (GREATEST_LEAN,), certificate))
    at = evaluator(run, run.bits + 64, certificate)
    with at.balls.precision():
        top, near = (at.state(lean.time + shift)[0] for shift in (0, 1e-6))
        c = (top + (near - top) * (apart / 2e-6) ** 2).mid()
    return lambda equations, state: state[0] - c


@pytest.mark.proof
def test_a_roll_angle_that_just_passes_a_threshold_crosses_it_twice(candidate):
    run = candidate[0]
    # The published bound is 8e-66. `enclose` would take minutes to prove it, so a larger bound is
    # used.
    proof = proof_of(run, Fraction(1, 10**50))
    for certificate, apart in product((None, proof), (1e-6, 1e-20)):
        found = zeros(run, grazing(run, certificate, apart), "threshold", certificate)
        first, second = found[:2]
        assert (first.rises, second.rises) == (True, False)
        assert first.is_single
        assert second.is_single
        assert float(second.time - first.time) == pytest.approx(apart, rel=1e-3)
    # The threshold is now so near to the maximum that the bound does not decide whether the motion
    # reaches it.
    event = zeros(run, grazing(run, proof, 1e-26), "threshold", proof)[0]
    assert event.rises is None


def counted(p, low, high):
    """Count the roots of a polynomial without double roots in an interval, by Sturm's theorem."""
    chain = [p, p.derivative()]
    while chain[-1].degree() > 0:
        chain.append(-(chain[-2] % chain[-1]))

    def changes(t):
        signs = [q(t) for q in chain if q(t) != 0]
        return sum(a * b < 0 for a, b in pairwise(signs))

    return changes(low) - changes(high)


@pytest.mark.parametrize("seed", range(9))
def test_as_many_crossings_are_found_as_sturm_counts(bicycle, maneuvers, seed):
    """Random polynomials over three segments, some with roots that nearly meet, or at a break."""
    rng = random.Random(seed)
    roots = [Fraction(rng.randrange(1, 3000), 1000) for _ in range(rng.randrange(2, 8))]
    roots.append(roots[0] + Fraction(1, 10 ** rng.randrange(5, 12)))
    if seed % 3 == 0:
        roots.append(Fraction(rng.randrange(1, 3)))
    # Add a constant of about the size of the gaps between close roots, which separates or joins
    # these roots.
    shift = Fraction(rng.randrange(-100, 100), 10 ** rng.randrange(8, 24))
    run = made(bicycle, maneuvers[0], roots, breaks=(0, 1, 2, 3), shift=shift)
    p = polynomial(1)
    for root in roots:
        p *= polynomial(-root, 1)
    p += polynomial(shift)
    if p.gcd(p.derivative()).degree() > 0 or p(flint.fmpq(0)) == 0:
        pytest.skip("a double root, or one at the start")
    count = counted(p, flint.fmpq(0), flint.fmpq(3))
    for proof in (None, proof_of(run, Fraction(1, 2**110))):
        found = zeros(run, KINDS[UPRIGHT], UPRIGHT, proof)
        assert all(e.is_single for e in found)
        assert len(found) == count
        signs = [e.rises for e in found]
        assert all(a != b for a, b in pairwise(signs))
        assert (len(found) % 2 == 0) == (p(flint.fmpq(0)) * p(flint.fmpq(3)) > 0)


def test_a_motion_crosses_any_threshold_as_often_as_its_samples_do(bicycle, maneuvers):
    """Random thresholds for the roll angle of maneuver 1, half of them just inside an extreme."""
    run = integrate(bicycle, maneuvers[0], is_regular=True)
    proof = proof_of(run, Fraction(1, 10**11))
    at = evaluator(run, run.bits + 64)
    with at.balls.precision():
        leans = [float(at.state(e.time)[0].mid()) for e in events(run, (GREATEST_LEAN,), proof)]
        times = [Fraction(i, 500) for i in range(5001)]
        rolls = np.array([float(run.state(t)[0].mid()) for t in times])
    rng = random.Random(17)
    thresholds = [rng.uniform(min(leans), max(leans)) for _ in range(6)]
    # These thresholds are so far below an extreme that the two crossings around it are at least 5
    # ms apart.
    thresholds += [lean * (1 - 10 ** rng.uniform(-4, -2)) for lean in rng.sample(leans, 6)]
    for c in thresholds:
        above = rolls > c
        found = zeros(run, lambda equations, state, c=c: state[0] - c, "threshold", proof)
        assert all(e.is_single for e in found)
        assert [e.rises for e in found] == [bool(b) for a, b in pairwise(above) if a != b]


def test_a_lean_is_greatest_or_least_by_what_the_roll_angle_does(bicycle, maneuvers):
    """The roll angle oscillates above zero: t^3 / 3 - t^2 + 3 t / 4 + 1 / 10."""
    coefficients = [Fraction(x) for x in ("1/10", "3/4", "-1", "1/3")]
    roll = polynomial(*coefficients)
    run = made(bicycle, maneuvers[0], [], breaks=(0, 2))
    in_s = roll(polynomial(0, 2))
    pieces = ((on_grid(in_s), (0,), (0,), on_grid(in_s.derivative() * polynomial("1/2")), (0,),
               (0,), (0,)),)  # fmt: skip
    run = replace(run, pieces=pieces)
    (greatest,) = events(run, (GREATEST_LEAN,))
    (least,) = events(run, (LEAST_LEAN,))
    assert holds(greatest.time, Fraction(1, 2))
    assert holds(least.time, Fraction(3, 2))
    both = list(events(run, (LEAST_LEAN, GREATEST_LEAN)))
    assert [e.what for e in both] == [GREATEST_LEAN, LEAST_LEAN]
    mirrored = tuple(tuple(-c for c in row) for row in pieces[0])
    assert [e.what for e in events(replace(run, pieces=(mirrored,)))][:1] == [GREATEST_LEAN]


@pytest.mark.proof
def test_upright_and_greatest_lean_are_where_heyoka_detects_them(bicycle, maneuvers):
    hy = pytest.importorskip("heyoka")
    system = right_hand_side(bicycle, Precision.of("binary64"), is_regular=True)
    variables = {str(v): v for v, _ in system}
    times = {UPRIGHT: [], GREATEST_LEAN: []}
    detected = [
        hy.nt_event(variables[name], lambda ta, t, sign, kind=kind: times[kind].append(t))
        for kind, name in ((UPRIGHT, "roll"), (GREATEST_LEAN, "roll_rate"))
    ]
    run = integrate(bicycle, maneuvers[0], is_regular=True)
    start = [piece[0] / 2**run.grid for piece in run.pieces[0]]
    integrator = hy.taylor_adaptive(system, start, compact_mode=True, nt_events=detected)
    integrator.propagate_until(10.0)
    for kind, expected in times.items():
        found = [float(e.time) for e in events(run, (kind,))]
        expected = [t for t in expected if t > 1e-6]
        assert len(found) > 8
        # Both results come from integrations in binary64, each accurate to 1e-13.
        assert np.allclose(found, expected, rtol=0, atol=1e-11)


@pytest.mark.proof
def test_times_agree_at_two_precisions_to_the_digits_of_the_lesser(bicycle, maneuvers):
    short = replace(maneuvers[1], duration=Fraction(1))
    first, second = (next(events(integrate(bicycle, short, p), (GREATEST_LEAN,))) for p in (30, 40))
    with flint.ctx.workprec(200):
        assert abs(first.time - second.time) < 1e-29
        assert abs(first.time - second.time) > 1e-36


@pytest.mark.proof
def test_the_rear_wheel_of_maneuver_3_leaves_the_floor_first(bicycle, maneuvers):
    """docs/after-ten-seconds.md has all certified digits."""
    followed = follow(bicycle, maneuvers[2])
    assert followed.event.what == REAR_LIFT
    assert not followed.event.rises
    assert abs(float(followed.event.time) - 44.43042627) < 1e-7
    assert 0 < float(followed.run.breaks[-1]) - float(followed.event.time) < 1e-4
    at = evaluator(followed.run, 128)
    with at.balls.precision():
        roll = float(at.columns(followed.event.time)["roll_angle"].mid())
    assert 1.2 < roll < 1.25


def test_maneuver_2_never_falls(bicycle, maneuvers):
    assert first_event(bicycle, maneuvers[1], longest=Fraction(50)) is None


def test_a_wheel_that_is_pulled_down_at_the_start_is_bad_input(bicycle, maneuvers):
    fast = replace(maneuvers[0], roll_rate=Exact(Fraction(10)))
    with pytest.raises(InputError, match=r"normal force of -.* N on the .* wheel at the start"):
        follow(bicycle, fast)
    # Searches for other events do not check the normal forces at the start, so they do not refuse
    # this start.
    assert first_event(bicycle, fast, until=UPRIGHT, longest=Fraction(1, 10)) is None


def test_an_unknown_event_is_named(bicycle, maneuvers):
    with pytest.raises(InputError, match="found event 'crash', expected one of fall, upright"):
        first_event(bicycle, maneuvers[0], until="crash")


@pytest.mark.parametrize("kind", [REAR_LIFT, FRONT_LIFT])
def test_normal_forces_change_their_sign_at_a_lift(bicycle, maneuvers, kind):
    run = integrate(bicycle, replace(maneuvers[2], duration=Fraction("44.449")))
    found = [float(e.time) for e in events(run, (kind,))]
    at = evaluator(run, 128)
    times = np.linspace(44.4, 44.449, 200)
    with at.balls.precision():
        signs = [float(KINDS[kind](at.equations, run.state(Fraction(t)))) > 0 for t in times]
    changes = [(times[i], times[i + 1]) for i in range(199) if signs[i] != signs[i + 1]]
    assert len(changes) == len(found) >= 1
    assert all(low < t < high for (low, high), t in zip(changes, found, strict=True))

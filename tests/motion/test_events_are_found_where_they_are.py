"""Events: against polynomials whose zeros are known, and heyoka's own event detection."""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import flint
import numpy as np
import pytest

from heyoka_bike.errors import InputError
from heyoka_bike.motion.evaluator import evaluator
from heyoka_bike.motion.events import (
    FRONT_LIFT,
    GREATEST_LEAN,
    KINDS,
    REAR_LIFT,
    UPRIGHT,
    events,
    first_event,
    follow,
    zeros,
)
from heyoka_bike.motion.expressions import require_heyoka
from heyoka_bike.motion.integrate import integrate, right_hand_side
from heyoka_bike.motion.trajectory import Certificate, Trajectory
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.precision import Precision

GRID = 120


def made(bicycle, maneuver, roots, breaks=(0, 1, 2)):
    """A trajectory whose roll is the product of t - root; all else is zero."""
    pieces = []
    for a, b in pairwise(breaks):
        roll = flint.fmpq_poly([1])
        for root in roots:
            numerator = [a - root, Fraction(b - a)]
            roll *= flint.fmpq_poly([flint.fmpq(x.numerator, x.denominator) for x in numerator])
        integers = [round(Fraction(int(c.p), int(c.q)) * 2**GRID) for c in roll.coeffs()]
        pieces.append((tuple(integers), *((0,) for _ in range(6))))
    return Trajectory(
        bicycle=bicycle, maneuver=replace(maneuver, duration=Fraction(breaks[-1])),
        precision="100 bits", bits=100, is_regular=True, order=20, grid=GRID,
        breaks=tuple(map(Fraction, breaks)), pieces=tuple(pieces),
    )  # fmt: skip


def holds(time, exact):
    with flint.ctx.workprec(300):
        return time.contains(flint.arb(flint.fmpq(exact.numerator, exact.denominator)))


def test_zeros_of_polynomials_are_enclosed_to_the_last_bits(bicycle, maneuvers):
    roots = [Fraction(1, 3), Fraction(2, 3), Fraction(1, 3) + Fraction(1, 10**4), Fraction(17, 9)]
    found = zeros(made(bicycle, maneuvers[0], roots), KINDS[UPRIGHT], UPRIGHT)
    assert len(found) == 4
    for event, root in zip(found, sorted(roots), strict=True):
        # What the integers of the polynomial leave of the root: 2^-GRID over the slope.
        with flint.ctx.workprec(300):
            off = abs(event.time.mid() - flint.arb(flint.fmpq(root.numerator, root.denominator)))
        assert off < 2.0**-GRID * 1e6
        assert event.time.rad() < 2.0**-95
    assert [e.rises for e in found] == [False, True, False, True]


def test_an_event_at_a_break_is_found_once(bicycle, maneuvers):
    (event,) = zeros(made(bicycle, maneuvers[0], [Fraction(1)]), KINDS[UPRIGHT], UPRIGHT)
    assert holds(event.time, Fraction(1))


def test_neither_the_start_nor_a_zero_without_a_change_of_sign_is_an_event(bicycle, maneuvers):
    run = made(bicycle, maneuvers[0], [Fraction(0), Fraction(1, 2), Fraction(1, 2)])
    assert zeros(run, KINDS[UPRIGHT], UPRIGHT) == []


def test_a_certificate_widens_the_enclosure_by_its_bound_over_the_slope(bicycle, maneuvers):
    run = made(bicycle, maneuvers[0], [Fraction(1, 4)])
    bound = Fraction(1, 2**40)
    proof = Certificate(run.states, ((bound,) * 7,) * 2, (bound,) * 7)
    (event,) = zeros(run, KINDS[UPRIGHT], UPRIGHT, proof)
    assert 2.0**-40 < float(event.time.rad()) < 2.0**-38
    assert holds(event.time, Fraction(1, 4) + bound)
    assert holds(event.time, Fraction(1, 4) - bound)


def test_upright_and_greatest_lean_are_where_heyoka_detects_them(bicycle, maneuvers):
    hy = require_heyoka()
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
        # Two integrations in binary64, each good to 1e-13.
        assert np.allclose(found, expected, rtol=0, atol=1e-11)


def test_times_agree_at_two_precisions_to_the_digits_of_the_lesser(bicycle, maneuvers):
    short = replace(maneuvers[1], duration=Fraction(1))
    first, second = (next(events(integrate(bicycle, short, p), (GREATEST_LEAN,))) for p in (30, 40))
    with flint.ctx.workprec(200):
        assert abs(first.time - second.time) < 1e-29
        assert abs(first.time - second.time) > 1e-36


def test_the_rear_wheel_of_maneuver_3_leaves_the_floor_first(bicycle, maneuvers):
    """The full digits, certified, are in docs/after-ten-seconds.md."""
    followed = follow(bicycle, maneuvers[2])
    assert followed.event.what == REAR_LIFT
    assert not followed.event.rises
    assert abs(float(followed.event.time) - 44.43042627) < 1e-7
    assert 0 < float(followed.run.breaks[-1]) - float(followed.event.time) < 1e-4
    at = evaluator(followed.run, 128)
    with at.balls.precision():
        roll = float(at.columns(followed.event.time, followed.event.piece)["roll_angle"].mid())
    assert 1.2 < roll < 1.25


def test_maneuver_2_never_falls(bicycle, maneuvers):
    assert first_event(bicycle, maneuvers[1], longest=Fraction(50)) is None


def test_a_wheel_that_is_pulled_down_at_the_start_is_bad_input(bicycle, maneuvers):
    fast = replace(maneuvers[0], roll_rate=Exact(Fraction(10)))
    with pytest.raises(InputError, match=r"normal force of -.* N on the .* wheel at the start"):
        follow(bicycle, fast)
    # Other events do not ask.
    assert first_event(bicycle, fast, until=UPRIGHT, longest=Fraction(1, 10)) is None


def test_an_unknown_event_is_named(bicycle, maneuvers):
    with pytest.raises(InputError, match="found event 'crash', expected fall, upright"):
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

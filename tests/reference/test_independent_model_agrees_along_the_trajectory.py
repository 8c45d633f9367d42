"""The published motion obeys Newton's and Euler's equations at random times.

The published polynomials are exact numbers, and so are their derivatives. Their first and second
derivatives are the rates and accelerations of the published motion, without any equations of
motion. From the angles and rates, the oracle must find the same accelerations, and the pitch that
keeps both wheels on the floor.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import flint
import pytest

from heyoka_bike.bicycle.equations.kinematics import unfold
from heyoka_bike.bicycle.equations.model import regular
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.motion.trajectory import Trajectory, evaluator
from heyoka_bike.numbers.exact import Exact
from oracles.newton_euler import Motion, move, solve_pitch

pytestmark = pytest.mark.proof

TIMES = 20
DIGITS = 80
BITS = 400
# The coefficients are integers times 2^-253, which is 1e-76. For a polynomial of order N on a step
# h, the second derivative multiplies their rounding error, and the first omitted term, by up to N^2
# / h^2. This is 7e6 for N = 85 on the shortest step. The measured error is below 1e-68.
TOLERANCE = "1e-65"

Pairs = dict[str, tuple[Any, Any]]


@dataclass(frozen=True)
class Moment:
    """One time of a published motion: its state, and the oracle's result.

    The state and its two derivatives are exact and in the variables of the trajectory.
    """

    run: Trajectory
    t: Fraction
    state: list[Fraction]
    rate: dict[str, Fraction]
    acceleration: dict[str, Fraction]
    oracle: Motion

    @classmethod
    def of(cls, run: Trajectory, t: Fraction, bicycle: Bicycle | None = None) -> Moment:
        """Construct the oracle from roll, steer, speed, and derivatives of roll and steer."""
        bicycle = run.bicycle if bicycle is None else bicycle
        state, rates, accelerations = (derivative(run, t, n) for n in range(3))
        at, rate = by_name(run, state), by_name(run, rates)
        oracle = move(
            bicycle,
            at["roll"],
            solve_pitch(bicycle, at["roll"], at["steer"], DIGITS),
            at["steer"],
            roll_rate=rate["roll"],
            steer_rate=rate["steer"],
            speed=run.bicycle["rR"].rational * at["spin"],
            digits=DIGITS,
        )
        return cls(run, t, state, rate, by_name(run, accelerations), oracle)


def derivative(run: Trajectory, t: Fraction, times: int) -> list[Fraction]:
    """Return the exact derivative of the state with respect to time, of the given order."""
    i = run.piece_at(t)
    start, h = run.breaks[i], run.breaks[i + 1] - run.breaks[i]
    s = (t - start) / h
    values = []
    for row in run.pieces[i]:
        polynomial = flint.fmpq_poly(list(row))
        for _ in range(times):
            polynomial = polynomial.derivative()
        x = polynomial(flint.fmpq(s.numerator, s.denominator))
        values.append(Fraction(int(x.p), int(x.q)) / 2**run.grid / h**times)
    return values


def by_name(run: Trajectory, values: Sequence[Fraction]) -> dict[str, Fraction]:
    return dict(zip(run.states, values, strict=True))


def random_times(run: Trajectory, number: int) -> list[Fraction]:
    rng = random.Random(f"along maneuver {number}")
    end = run.maneuver.duration
    return [end * Fraction(rng.randrange(2**20), 2**20) for _ in range(TIMES)]


@pytest.fixture(autouse=True)
def _working_precision() -> Iterator[None]:
    with flint.ctx.workprec(BITS):
        yield


@pytest.fixture(scope="module", params=[1, 2, 3])
def moments(request: pytest.FixtureRequest, candidate: tuple[Trajectory, ...]) -> list[Moment]:
    run = candidate[request.param - 1]
    return [Moment.of(run, t) for t in random_times(run, request.param)]


def from_the_polynomials(moment: Moment) -> Pairs:
    """Return pairs of derivatives of the published polynomials and values of the oracle."""
    m, rate, acceleration = moment.oracle, moment.rate, moment.acceleration
    radius = moment.run.bicycle["rR"].rational
    return {
        "pitch": (by_name(moment.run, moment.state)["pitch"], m.pitch),
        "pitch rate": (rate["pitch"], m.pitch_rate),
        "yaw rate": (rate["yaw"], m.yaw_rate),
        "roll acceleration": (acceleration["roll"], m.roll_acc),
        "pitch acceleration": (acceleration["pitch"], m.pitch_acc),
        "steer acceleration": (acceleration["steer"], m.steer_acc),
        "yaw acceleration": (acceleration["yaw"], m.yaw_acc),
        "hub acceleration along the heading": (radius * rate["spin"], m.speed_acc),
    }


def from_the_reduced_model(moment: Moment) -> Pairs:
    """Return pairs of the package's values at the published state and those of the oracle."""
    m, run = moment.oracle, moment.run
    at = evaluator(run, BITS)
    k, balls = at.equations.k, at.balls
    state = [balls.number(x) for x in moment.state]
    _, u = unfold(k, balls, state, is_regular=run.is_regular)
    roll, pitch, steer, *_, spin, _ = state
    rates = regular(k, balls, [roll, pitch, steer, u.p, u.steer_rate, spin])
    columns = at.equations.columns(state)
    return {
        "roll rate": (rates[0], m.roll_rate),
        "pitch rate": (rates[1], m.pitch_rate),
        "steer rate": (rates[2], m.steer_rate),
        "roll acceleration": (rates[3], m.roll_acc),
        "steer acceleration": (rates[4], m.steer_acc),
        "hub acceleration along the heading": (rates[5] * k.length, m.speed_acc),
        "column roll_rate": (columns["roll_rate"], m.roll_rate),
        "column steer_rate": (columns["steer_rate"], m.steer_rate),
        "column yaw_rate": (columns["yaw_rate"], m.yaw_rate),
        "column forward_speed": (columns["forward_speed"], m.speed),
        "column potential_energy": (columns["potential_energy"], m.potential_energy),
        "column kinetic_energy": (columns["kinetic_energy"], m.kinetic_energy),
        "column mechanical_energy": (
            columns["mechanical_energy"],
            m.potential_energy + m.kinetic_energy,
        ),
    }


def compare(pairs: Pairs, t: Fraction) -> None:
    limit = flint.arb(TOLERANCE)
    for name, (found, expected) in pairs.items():
        if isinstance(found, Fraction):
            found = flint.arb(flint.fmpq(found.numerator, found.denominator))
        # A comparison of balls is true only if it is certain. It is false if one of the balls is
        # NaN.
        assert abs(found - expected) <= limit * abs(expected).max(flint.arb(1)), (
            f"{name}, t = {float(t)}"
        )


def test_the_published_polynomials_obey_newton_and_euler(moments: list[Moment]) -> None:
    assert len(moments) == TIMES
    for moment in moments:
        compare(from_the_polynomials(moment), moment.t)


def test_the_reduced_model_agrees_at_the_published_states(moments: list[Moment]) -> None:
    for moment in moments:
        compare(from_the_reduced_model(moment), moment.t)


def test_the_floor_only_ever_pushes(moments: list[Moment]) -> None:
    """The bicycle never needs a floor that pulls its wheels down."""
    for moment in moments:
        assert moment.oracle.rear_contact.normal > 0
        assert moment.oracle.front_contact.normal > 0


@pytest.mark.parametrize("variable", ["roll", "pitch", "steer", "spin", "yaw"])
def test_a_coefficient_off_by_1e_60_is_noticed(
    candidate: tuple[Trajectory, ...], variable: str
) -> None:
    run = candidate[1]
    t = random_times(run, 2)[0]
    i, j = run.piece_at(t), run.states.index(variable)
    pieces = [[list(row) for row in piece] for piece in run.pieces]
    pieces[i][j][2] += round(Fraction(2**run.grid, 10**60))
    wrong = replace(run, pieces=tuple(tuple(tuple(row) for row in piece) for piece in pieces))
    with pytest.raises(AssertionError):
        compare(from_the_polynomials(Moment.of(wrong, t)), t)


@pytest.mark.parametrize("symbol", ["g", "lam", "c", "IHxz", "IFyy", "mB"])
def test_another_bicycle_is_noticed(candidate: tuple[Trajectory, ...], symbol: str) -> None:
    run = candidate[1]
    t, x, factor = random_times(run, 2)[0], run.bicycle[symbol], 1 + Fraction(1, 10**50)
    other = run.bicycle.replace(**{symbol: Exact(factor * x.rational, factor * x.pi_multiple)})
    with pytest.raises(AssertionError):
        compare(from_the_polynomials(Moment.of(run, t, other)), t)

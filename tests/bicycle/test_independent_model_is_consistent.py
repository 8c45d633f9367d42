"""The Newton-Euler oracle agrees with itself.

Its accelerations are the derivatives of its velocities, energy is conserved, and two independent
arithmetics give the same result.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from fractions import Fraction
from typing import Any, NamedTuple

import flint
import pytest

from heyoka_bike.bicycle.parameters import read_bicycle
from heyoka_bike.system.resources import benchmark_bicycle
from oracles import multibody
from oracles.newton_euler import Motion, move
from oracles.vectors import Multiprecision

BICYCLE = read_bicycle(benchmark_bicycle())
DIGITS = 70
STEP = Fraction(1, 10**25)
# The central difference has an error of the squared step times a third derivative below 1e6, plus
# the rounding error divided by the step.
DIFFERENCE_TOLERANCE = "1e-40"


class State(NamedTuple):
    roll: Fraction
    steer: Fraction
    roll_rate: Fraction
    steer_rate: Fraction
    speed: Fraction


def random_states(count: int) -> list[State]:
    rng = random.Random(20070813)
    bounds = ((-1, 1), (-1, 1), (-3, 3), (-3, 3), (-3, 10))
    return [
        State(*(Fraction(rng.randint(1000 * low, 1000 * high), 1000) for low, high in bounds))
        for _ in range(count)
    ]


STATES = random_states(8)


@pytest.fixture(autouse=True)
def _enough_digits() -> Iterator[None]:
    with flint.ctx.workprec(500):
        yield


def motion(state: State, **options: Any) -> Motion:
    return move(
        BICYCLE,
        state.roll,
        None,
        state.steer,
        roll_rate=state.roll_rate,
        steer_rate=state.steer_rate,
        speed=state.speed,
        digits=DIGITS,
        **options,
    )


def fraction(x: Any) -> Fraction:
    mantissa, exponent = x.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def after(state: State, time: Fraction) -> Motion:
    """Return the motion a short time later, to first order in the state."""
    m = motion(state)
    return motion(
        State(
            state.roll + time * state.roll_rate,
            state.steer + time * state.steer_rate,
            state.roll_rate + time * fraction(m.roll_acc),
            state.steer_rate + time * fraction(m.steer_acc),
            state.speed + time * fraction(m.speed_acc),
        )
    )


def difference_errors(state: State) -> dict[str, Any]:
    """Return the differences of derivatives from central differences."""
    now, before, later = motion(state), after(state, -STEP), after(state, STEP)

    def rate(of: Any) -> Any:
        return (of(later) - of(before)) / (2 * flint.arb(flint.fmpq(1, STEP.denominator)))

    v = now.rear_hub_velocity
    return {
        "pitch rate": rate(lambda m: m.pitch) - now.pitch_rate,
        "pitch": rate(lambda m: m.pitch_rate) - now.pitch_acc,
        "yaw": rate(lambda m: m.yaw_rate) - now.yaw_acc,
        "rear wheel": rate(lambda m: m.rear_wheel_rate) - now.rear_wheel_acc,
        "front wheel": rate(lambda m: m.front_wheel_rate) - now.front_wheel_acc,
        "hub height rate": rate(lambda m: m.rear_hub_position[2]) - v[2],
        "hub height": rate(lambda m: m.rear_hub_velocity[2]) - now.rear_hub_acceleration[2],
        # The yaw is zero in these states, but the components of the velocity turn with the bicycle,
        # hence the terms with the yaw rate.
        "hub forward": rate(lambda m: m.rear_hub_velocity[0])
        - now.yaw_rate * v[1]
        - now.rear_hub_acceleration[0],
        "hub aside": rate(lambda m: m.rear_hub_velocity[1])
        + now.yaw_rate * v[0]
        - now.rear_hub_acceleration[1],
        "energy": rate(lambda m: m.kinetic_energy + m.potential_energy),
        "kinetic power": rate(lambda m: m.kinetic_energy) - now.kinetic_power,
        "gravity power": rate(lambda m: m.potential_energy) + now.gravity_power,
    }


@pytest.mark.parametrize("state", STATES, ids=lambda s: f"roll {float(s.roll)}")
def test_accelerations_are_derivatives_and_energy_is_conserved(state: State) -> None:
    for name, error in difference_errors(state).items():
        assert abs(error) < flint.arb(DIFFERENCE_TOLERANCE), name


@pytest.mark.parametrize("state", STATES, ids=lambda s: f"roll {float(s.roll)}")
def test_joints_and_floor_do_no_work(state: State) -> None:
    # The powers that cancel are a few hundred watts each.
    assert abs(motion(state).power_residual) < flint.arb("1e-65")


def test_a_wrong_contact_acceleration_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    def wrong(self: Any, velocities: Any) -> Any:
        omega = velocities[self.wheel].angular
        return omega.cross(omega.cross(multibody.to_rim(self.number, self.axle, self.radius)))

    monkeypatch.setattr(multibody.Rolling, "rest", wrong)
    errors = difference_errors(STATES[0])
    assert abs(errors["yaw"]) > flint.arb("1e-3")
    assert abs(errors["energy"]) > flint.arb("1e-3")


def test_both_arithmetics_agree() -> None:
    balls, floats = motion(STATES[0]), motion(STATES[0], arithmetic=Multiprecision)

    def same(a: Any, b: Any) -> bool:
        return bool(abs(a - flint.arb(b.context.nstr(b, DIGITS + 20))) < flint.arb("1e-65"))

    for name, a in vars(balls).items():
        b = vars(floats)[name]
        if isinstance(a, flint.arb):
            assert same(a, b), name
    for contact in ("rear_contact", "front_contact"):
        a, b = getattr(balls, contact), getattr(floats, contact)
        assert all(map(same, a.vector, b.vector)), contact
    for joint, a in balls.joints.items():
        b = floats.joints[joint]
        assert all(map(same, (*a.force, *a.torque), (*b.force, *b.torque))), joint
    for body in balls.bodies:
        a, b = balls.accelerations[body], floats.accelerations[body]
        assert all(map(same, (*a.linear, *a.angular), (*b.linear, *b.angular))), body

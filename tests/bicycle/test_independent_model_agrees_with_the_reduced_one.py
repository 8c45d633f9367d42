"""The equations of the package and the Newton-Euler oracle describe the same bicycle.

Both forms of the reduced equations, the energies and the stored columns are compared at random
states with both wheels on the floor, far from upright, for the benchmark bicycle and for others.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import flint
import pytest
from oracles import vectors
from oracles.newton_euler import Motion, move, solve_pitch
from oracles.vectors import Vector, axes, rotation

from heyoka_bike.bicycle.equations.constants import Constants, constants
from heyoka_bike.bicycle.equations.kinematics import posture, rear_rates
from heyoka_bike.bicycle.equations.model import few_products, regular
from heyoka_bike.bicycle.equations.outputs import columns, energies, unfold, yaw_rate
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle, read_bicycle
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.resources import benchmark_bicycle

BENCHMARK = read_bicycle(benchmark_bicycle())
DIGITS = 80
# 80 digits, of which cancellation and a small mechanical trail take some.
TOLERANCE = "1e-60"
BALLS = Balls(400)
ORACLE_BALLS = vectors.Balls(100)


@dataclass(frozen=True)
class Case:
    """A bicycle and its state."""

    seed: int
    bicycle: Bicycle
    roll: Fraction
    steer: Fraction
    roll_rate: Fraction
    steer_rate: Fraction
    speed: Fraction
    yaw: Fraction

    @classmethod
    def random(cls, seed: int) -> Case:
        rng = random.Random(seed)
        return cls(
            seed,
            BENCHMARK,
            roll=_between(rng, -1, 1),
            steer=_between(rng, -1, 1),
            roll_rate=_between(rng, -3, 3),
            steer_rate=_between(rng, -3, 3),
            speed=_between(rng, -3, 10),
            yaw=_between(rng, -3, 3),
        )

    def with_another_bicycle(self) -> Case:
        """Every parameter changed, by up to a quarter, and the trail's sign too."""
        rng = random.Random(f"bicycle {self.seed}")
        changes = {}
        for symbol in PARAMETERS:
            factor, x = 1 + _between(rng, -1, 1) / 4, BENCHMARK[symbol]
            changes[symbol] = Exact(factor * x.rational, factor * x.pi_multiple)
        if rng.random() < Fraction(1, 2):
            changes["c"] = Exact(-changes["c"].rational)
        return replace(self, bicycle=BENCHMARK.replace(**changes))


def _between(rng: random.Random, low: int, high: int) -> Fraction:
    return Fraction(rng.randint(low * 10**6, high * 10**6), 10**6)


@dataclass(frozen=True)
class Both:
    """One state in the oracle and in the variables of the package."""

    case: Case
    oracle: Motion
    k: Constants
    regular_state: list[Any]
    few_product_state: list[Any]

    @classmethod
    def of(cls, case: Case) -> Both:
        pitch = solve_pitch(case.bicycle, case.roll, case.steer, DIGITS)
        oracle = move(
            case.bicycle,
            case.roll,
            pitch,
            case.steer,
            roll_rate=case.roll_rate,
            steer_rate=case.steer_rate,
            speed=case.speed,
            digits=DIGITS,
        )
        k = constants(case.bicycle, BALLS)
        spin = BALLS.number(case.speed) / k.length
        roll, steer, roll_rate, steer_rate = (
            BALLS.number(x) for x in (case.roll, case.steer, case.roll_rate, case.steer_rate)
        )
        o = posture(k, BALLS, roll, pitch, steer)
        w1, w3, _ = rear_rates(o, k.rear.r * spin, roll_rate, steer_rate)
        return cls(
            case,
            oracle,
            k,
            [roll, pitch, steer, roll_rate, steer_rate, spin],
            [roll, pitch, steer, w1, w3, spin],
        )


@pytest.fixture(autouse=True)
def _working_precision() -> Iterator[None]:
    with BALLS.precision():
        yield


def from_the_regular_form(both: Both) -> dict[str, tuple[Any, Any]]:
    """Found by the package and expected by the oracle, by name."""
    m, k = both.oracle, both.k
    found = regular(k, BALLS, both.regular_state)
    o, u = unfold(k, BALLS, both.regular_state, is_regular=True)
    e = energies(k, o, u)
    return {
        "roll rate": (found[0], m.roll_rate),
        "pitch rate": (found[1], m.pitch_rate),
        "steer rate": (found[2], m.steer_rate),
        "roll acceleration": (found[3], m.roll_acc),
        "steer acceleration": (found[4], m.steer_acc),
        "hub acceleration along the heading": (found[5] * k.length, m.speed_acc),
        "yaw rate": (yaw_rate(o, u), m.yaw_rate),
        "rear wheel rate": (-u.v / k.rear.r - u.q, m.rear_wheel_rate),
        "front wheel rate": (-u.v_f / k.front.r - u.q_f, m.front_wheel_rate),
        "kinetic energy": (e.kinetic, m.kinetic_energy),
        "potential energy": (e.potential, m.potential_energy),
    }


def from_the_few_product_form(both: Both) -> dict[str, tuple[Any, Any]]:
    m, k = both.oracle, both.k
    found = few_products(k, BALLS, both.few_product_state)
    o, u = unfold(k, BALLS, both.few_product_state, is_regular=False)
    e = energies(k, o, u)
    # w1 and w3 are along directions fixed in the frame: their rates are parts of the angular
    # acceleration.
    x, _, z = m.bodies["B"].attitude.transposed(m.accelerations["B"].angular)
    tilt = BALLS.number(both.case.bicycle["lam"])
    sin, cos = tilt.sin(), tilt.cos()
    return {
        "roll rate": (found[0], m.roll_rate),
        "pitch rate": (found[1], m.pitch_rate),
        "steer rate": (found[2], m.steer_rate),
        "w1 rate": (found[3], cos * x - sin * z),
        "w3 rate": (found[4], sin * x + cos * z),
        "hub acceleration along the heading": (found[5] * k.length, m.speed_acc),
        "yaw rate": (yaw_rate(o, u), m.yaw_rate),
        "kinetic energy": (e.kinetic, m.kinetic_energy),
        "potential energy": (e.potential, m.potential_energy),
    }


def from_the_columns(both: Both) -> dict[str, tuple[Any, Any]]:
    """Every stored column, after a turn of the oracle's motion by the yaw."""
    m, k, yaw = both.oracle, both.k, BALLS.number(both.case.yaw)
    roll, pitch, steer = both.regular_state[:3]
    o, u = unfold(k, BALLS, both.regular_state, is_regular=True)
    found = columns(k, BALLS, o, u, roll, pitch, steer, yaw)

    turn = rotation(ORACLE_BALLS, axes(ORACLE_BALLS)[2], yaw)
    omega = turn(m.velocities["B"].angular)
    ahead, aside, down = (turn(m.bodies["B"].attitude(e)) for e in axes(ORACLE_BALLS))
    hub = turn(m.rear_hub_velocity)
    masses = {letter: body.mass for letter, body in m.bodies.items()}
    momentum = turn(
        Vector([sum(masses[b] * v.linear[i] for b, v in m.velocities.items()) for i in range(3)])
    )
    mass = sum(masses.values())
    radius, front_radius = (BALLS.number(both.case.bicycle[r]) for r in ("rR", "rF"))
    tilt = BALLS.number(both.case.bicycle["lam"])
    heading = turn(axes(ORACLE_BALLS)[0])
    down_the_steer_axis = tilt.sin() * ahead + tilt.cos() * down
    across_the_steer_axis = tilt.cos() * ahead - tilt.sin() * down

    # The front wheel touches the floor at the end of its steepest radius, s / |s|.
    front_hub = turn(m.velocities["F"].linear)
    vertical = axes(ORACLE_BALLS)[2]
    axle = turn(m.bodies["H"].attitude(axes(ORACLE_BALLS)[1]))
    axle_rate = turn(m.velocities["H"].angular).cross(axle)
    s = vertical - vertical.dot(axle) * axle
    s_rate = -(vertical.dot(axle_rate) * axle + vertical.dot(axle) * axle_rate)
    length = s.dot(s).sqrt()
    front_contact = front_hub + (front_radius / length) * (s_rate - s.dot(s_rate) / s.dot(s) * s)
    track = axle.cross(vertical)
    front_spin = turn(m.velocities["F"].angular).dot(axle)
    rear_contact = m.speed + radius * m.roll.sin() * m.yaw_rate

    def angle_and_rate(y: Any, x: Any, y_rate: Any, x_rate: Any) -> tuple[Any, Any]:
        return flint.arb.atan2(y, x), (y_rate * x - y * x_rate) / (x * x + y * y)

    # The elements of the attitude: R23 and R33 in its third column, R32 in its second.
    aside_rate, down_rate = omega.cross(aside), omega.cross(down)
    xyz, xyz_rate = angle_and_rate(-down[1], down[2], -down_rate[1], down_rate[2])
    zyx, zyx_rate = angle_and_rate(aside[2], down[2], aside_rate[2], down_rate[2])
    expected = {
        "roll_angle": m.roll,
        "roll_angle_tait_bryan_xyz": xyz,
        "roll_angle_zyx": zyx,
        "roll_rate": m.roll_rate,
        "roll_rate_body_x": omega.dot(ahead),
        "roll_rate_tait_bryan_xyz_rate": xyz_rate,
        "roll_rate_zyx_rate": zyx_rate,
        "roll_rate_steer_axes_x": omega.dot(across_the_steer_axis),
        "forward_speed": m.speed,
        "forward_speed_hub_body_x": hub.dot(ahead),
        "forward_speed_wheel_spin": -radius * m.rear_wheel_rate,
        # The contact point of a wheel leaned to the right is to the left of the hub.
        "forward_speed_contact": rear_contact,
        "forward_speed_hub_norm": hub.dot(hub).sqrt(),
        "forward_speed_com_norm": momentum.dot(momentum).sqrt() / mass,
        "forward_speed_hub_global_x": hub[0],
        "forward_speed_contact_global_x": rear_contact * heading[0],
        "forward_speed_com_heading": momentum.dot(heading) / mass,
        "forward_speed_com_global_x": momentum[0] / mass,
        "forward_speed_front_hub_heading": front_hub.dot(heading),
        "forward_speed_front_hub_norm": front_hub.dot(front_hub).sqrt(),
        "forward_speed_front_hub_global_x": front_hub[0],
        "forward_speed_front_contact": front_contact.dot(track) / track.dot(track).sqrt(),
        "forward_speed_front_contact_heading": front_contact.dot(heading),
        "forward_speed_front_contact_global_x": front_contact[0],
        "forward_speed_front_wheel_heading": -front_radius * front_spin,
        "forward_speed_front_wheel_spin": -front_radius * m.front_wheel_rate,
        "potential_energy": m.potential_energy,
        "kinetic_energy": m.kinetic_energy,
        "mechanical_energy": m.potential_energy + m.kinetic_energy,
        "steer_angle": m.steer,
        "steer_rate": m.steer_rate,
        "pitch": m.pitch,
        "pitch_zyx": (-ahead[2]).asin(),
        "pitch_steer_axes": m.pitch + tilt,
        "yaw": yaw,
        "yaw_rate": m.yaw_rate,
        "yaw_rate_body_z": omega.dot(down),
        "yaw_rate_steer_axes_z": omega.dot(down_the_steer_axis),
    }
    assert expected.keys() == found.keys()
    return {name: (found[name], x) for name, x in expected.items()}


def compare(pairs: dict[str, tuple[Any, Any]], seed: int) -> None:
    limit = flint.arb(TOLERANCE)
    for name, (found, expected) in pairs.items():
        # Balls compare as less only when that is certain, and never when one is not a number.
        assert abs(found - expected) <= limit * abs(expected), f"{name}, seed {seed}"


def compare_all(case: Case) -> None:
    both = Both.of(case)
    compare(from_the_regular_form(both), case.seed)
    compare(from_the_few_product_form(both), case.seed)
    compare(from_the_columns(both), case.seed)


@pytest.mark.parametrize("hundred", range(10))
def test_at_a_thousand_random_states_of_the_benchmark(hundred: int) -> None:
    for seed in range(100 * hundred, 100 * (hundred + 1)):
        compare_all(Case.random(seed))


@pytest.mark.parametrize("seed", range(1000, 1060))
def test_at_random_states_of_other_bicycles(seed: int) -> None:
    compare_all(Case.random(seed).with_another_bicycle())


@pytest.mark.slow
def test_at_many_random_states_of_the_benchmark_and_of_other_bicycles() -> None:
    for seed in range(10_000, 15_000):
        compare_all(Case.random(seed))
        compare_all(Case.random(seed + 10_000).with_another_bicycle())


@pytest.mark.parametrize("symbol", sorted(PARAMETERS))
def test_a_parameter_off_by_1e_50_is_noticed(symbol: str) -> None:
    case = Case.random(1)
    both, x = Both.of(case), case.bicycle[symbol]
    factor = 1 + Fraction(1, 10**50)
    other = case.bicycle.replace(**{symbol: Exact(factor * x.rational, factor * x.pi_multiple)})
    wrong = replace(both, k=constants(other, BALLS))
    with pytest.raises(AssertionError):
        compare(from_the_regular_form(wrong), case.seed)

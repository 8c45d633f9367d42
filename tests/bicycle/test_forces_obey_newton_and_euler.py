"""Every column of the whole motion against the Newton-Euler oracle, at random states.

The oracle solves for all accelerations and the 21 reactions at once; it shares no line with
`forces` and `configuration`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
from oracles.vectors import Vector, axes, rotation
from test_independent_model_agrees_with_the_reduced_one import (
    BALLS,
    ORACLE_BALLS,
    Both,
    Case,
    compare,
)

from heyoka_bike.bicycle.equations.bodies import Bodies, bodies
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import motion_columns
from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS
from heyoka_bike.bicycle.parameters import PARAMETERS
from heyoka_bike.numbers.exact import Exact

PLACE = (Fraction(12), Fraction(-5, 3))
ANGLES = (Fraction(-77), Fraction(-81))
"""Where the rear wheel is, and how far both wheels have turned."""


@pytest.fixture(autouse=True)
def _working_precision() -> Iterator[None]:
    with BALLS.precision():
        yield


def found(both: Both, *, is_regular: bool, b: Bodies | None = None) -> dict[str, Any]:
    state = both.regular_state if is_regular else both.few_product_state
    rest = [BALLS.number(x) for x in (both.case.yaw, *PLACE, *ANGLES)]
    equations = Equations.of(both.case.bicycle, BALLS, is_regular=is_regular)
    return motion_columns(replace(equations, b=b or equations.b), [*state, *rest])


def named(name: str, v: Vector) -> dict[str, Any]:
    return dict(zip((f"{name}_x", f"{name}_y", f"{name}_z"), v, strict=True))


def expected(both: Both) -> dict[str, Any]:
    """All columns from the oracle, its motion turned by the yaw and moved to the place."""
    m, p = both.oracle, both.case.bicycle
    x, y, z = axes(ORACLE_BALLS)
    turn = rotation(ORACLE_BALLS, z, BALLS.number(both.case.yaw))
    rear, front = m.bodies["B"].attitude, m.bodies["H"].attitude
    place = Vector([BALLS.number(c) for c in (*PLACE, 0)])

    def lowest(hub: Vector, axle: Vector, radius: Fraction) -> Vector:
        across = z - z.dot(axle) * axle
        return hub + (BALLS.number(radius) / across.dot(across).sqrt()) * across

    centres = {letter: body.centre for letter, body in m.bodies.items()}
    total = sum(body.mass for body in m.bodies.values())
    centre = (1 / total) * sum((body.mass * body.centre for body in m.bodies.values()), start=0 * x)
    contact = lowest(centres["F"], front(y), p["rF"].rational)
    tilt = BALLS.number(p["lam"])
    steer_axis = rear(Vector([tilt.sin(), BALLS.number(0), tilt.cos()]))
    along = (front(y).cross(steer_axis), front(y), steer_axis)
    values = dict(zip(("rear_contact_x", "rear_contact_y"), place, strict=False))
    values |= dict(
        zip(("rear_wheel_angle", "front_wheel_angle"), map(BALLS.number, ANGLES), strict=True)
    )
    for name, v in (
        ("front_contact", contact), ("rear_hub", centres["R"]), ("front_hub", centres["F"]),
        ("rear_frame_com", centres["B"]), ("front_frame_com", centres["H"]), ("com", centre),
    ):  # fmt: skip
        values |= named(name, place + turn(v))
    for end, attitude, frame, wheel in (("rear", rear, "B", "R"), ("front", front, "H", "F")):
        omega = m.velocities[frame].angular
        values |= named(f"{end}_frame_omega", attitude.transposed(omega))
        values[f"{end}_wheel_omega_y"] = m.velocities[wheel].angular.dot(attitude(y))
        for j, e in enumerate((x, y, z), start=1):
            for i, c in enumerate(turn(attitude(e)), start=1):
                values[f"{end}_frame_r{i}{j}"] = c
        floor = m.rear_contact if end == "rear" else m.front_contact
        values[f"{end}_normal_force"] = floor.normal
        values[f"{end}_longitudinal_force"] = floor.longitudinal
        values[f"{end}_lateral_force"] = floor.lateral
        tangential = floor.vector - floor.vector.dot(z) * z
        values[f"{end}_friction"] = tangential.dot(tangential).sqrt() / floor.normal
        hub = m.joints[f"{end} hub"]
        values |= named(f"{end}_axle_force", attitude.transposed(hub.force))
        values |= named(f"{end}_axle_moment", attitude.transposed(hub.torque))
    joint = m.joints["steer"]
    values |= named("steer_joint_force", Vector([joint.force.dot(e) for e in along]))
    values |= named("steer_joint_moment", Vector([joint.torque.dot(e) for e in along]))
    return values


def pairs(both: Both, values: dict[str, Any]) -> dict[str, tuple[Any, Any]]:
    """Found and expected; of the quaternions what they say of the rotation matrix."""
    wanted = expected(both)
    result = {}
    for end in ("rear", "front"):
        a, b, c, d = (values[f"{end}_frame_q{i}"] for i in range(4))
        # Euler and Rodrigues: the matrix of a unit quaternion.
        matrix = (
            (a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)),
            (2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)),
            (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d),
        )
        result |= {
            f"{end} quaternion, r{i + 1}{j + 1}": (
                matrix[i][j],
                wanted[f"{end}_frame_r{i + 1}{j + 1}"],
            )
            for i in range(3)
            for j in range(3)
        }
        result[f"{end} norm"] = (a * a + b * b + c * c + d * d, BALLS.number(1))
    return result | {name: (values[name], x) for name, x in wanted.items() if name in values}


def compare_all(case: Case) -> None:
    both = Both.of(case)
    for is_regular in (True, False):
        compare(pairs(both, found(both, is_regular=is_regular)), case.seed)


def test_every_column_is_compared() -> None:
    both = Both.of(Case.random(0))
    names = {c.name for c in MOTION_COLUMNS}
    quaternions = {f"{end}_frame_q{i}" for end in ("rear", "front") for i in range(4)}
    assert set(found(both, is_regular=True)) == names
    assert names - quaternions <= set(expected(both))


@pytest.mark.parametrize("hundred", range(2))
def test_at_random_states_of_the_benchmark(hundred: int) -> None:
    for seed in range(50 * hundred, 50 * (hundred + 1)):
        compare_all(Case.random(seed))


@pytest.mark.parametrize("seed", range(1000, 1030))
def test_at_random_states_of_other_bicycles(seed: int) -> None:
    compare_all(Case.random(seed).with_another_bicycle())


@pytest.mark.parametrize("symbol", sorted(PARAMETERS))
def test_a_parameter_off_by_1e_50_is_noticed(symbol: str) -> None:
    """In the bodies alone: the equations of motion keep the right one."""
    case = Case.random(1)
    both, x = Both.of(case), case.bicycle[symbol]
    factor = 1 + Fraction(1, 10**50)
    other = case.bicycle.replace(**{symbol: Exact(factor * x.rational, factor * x.pi_multiple)})
    with pytest.raises(AssertionError):
        compare(pairs(both, found(both, is_regular=True, b=bodies(other, BALLS))), case.seed)

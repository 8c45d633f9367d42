"""One state in the package's equations and in the Newton-Euler oracle, in any number type.

Each function returns pairs by name: the value from the package and the value expected by the
oracle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from heyoka_bike.bicycle.equations.bodies import Bodies
from heyoka_bike.bicycle.equations.constants import Constants, constants
from heyoka_bike.bicycle.equations.kinematics import posture, rear_rates, unfold
from heyoka_bike.bicycle.equations.model import few_products, regular
from heyoka_bike.bicycle.equations.outputs import columns, energies, yaw_rate
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import (
    INTEGRALS,
    motion_columns,
    rates_of_integrals,
    track_speeds,
)
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Arithmetic
from oracles import vectors
from oracles.newton_euler import Motion, move
from oracles.vectors import Vector, axes, rotation

Pairs = dict[str, tuple[Any, Any]]
PLACE = (Fraction(12), Fraction(-5, 3))
ANGLES = (Fraction(-77), Fraction(-81))
"""Position of the rear wheel, and rotation angles of both wheels."""


@dataclass(frozen=True)
class Both:
    """One state in the oracle and in the variables of the package.

    Attributes
    ----------
    bicycle
    a, number
        The arithmetic of the package and that of the oracle, of one number type.
    oracle
        Model at zero yaw.
    k
    yaw
    regular_state, few_product_state
        States without the yaw.
    """

    bicycle: Bicycle
    a: Arithmetic
    number: vectors.Arithmetic
    oracle: Motion
    k: Constants
    yaw: Any
    regular_state: list[Any]
    few_product_state: list[Any]

    @classmethod
    def of(
        cls, bicycle: Bicycle, a: Arithmetic, number: vectors.Arithmetic, yaw: Any, *,
        roll: Any, pitch: Any, steer: Any, roll_rate: Any, steer_rate: Any, speed: Any,
    ) -> Both:  # fmt: skip
        """Construct from numbers or exact numbers; the pitch must put both wheels on the floor."""
        oracle = move(
            bicycle, roll, pitch, steer, roll_rate=roll_rate, steer_rate=steer_rate, speed=speed,
            arithmetic=lambda _: number,
        )  # fmt: skip
        k = constants(bicycle, a)
        spin = a.number(speed) / k.length
        angles = [a.number(roll), pitch, a.number(steer)]
        rates = [a.number(roll_rate), a.number(steer_rate)]
        w1, w3 = rear_rates(posture(k, a, *angles), k.rear.r * spin, *rates)
        return cls(
            bicycle, a, number, oracle, k, a.number(yaw),
            [*angles, *rates, spin], [*angles, w1, w3, spin],
        )  # fmt: skip


def from_the_regular_form(both: Both) -> Pairs:
    """Return rates of the state, speeds of all kinds, and energies."""
    m, k = both.oracle, both.k
    found = regular(k, both.a, both.regular_state)
    o, u = unfold(k, both.a, both.regular_state, is_regular=True)
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


def from_the_few_product_form(both: Both) -> Pairs:
    """Return the same quantities in the few-product form."""
    m, k, a = both.oracle, both.k, both.a
    found = few_products(k, a, both.few_product_state)
    o, u = unfold(k, a, both.few_product_state, is_regular=False)
    e = energies(k, o, u)
    # The rates w1 and w3 are components along directions fixed in the frame. So their derivatives
    # are components of the angular acceleration.
    x, _, z = m.bodies["B"].attitude.transposed(m.accelerations["B"].angular)
    tilt = a.number(both.bicycle["lam"])
    sin, cos = a.sin(tilt), a.cos(tilt)
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


def from_the_columns(both: Both) -> Pairs:
    """Return every stored column, after the oracle's motion is rotated by the yaw."""
    m, k, a, number, yaw = both.oracle, both.k, both.a, both.number, both.yaw
    roll, pitch, steer = both.regular_state[:3]
    o, u = unfold(k, a, both.regular_state, is_regular=True)
    found = columns(k, a, o, u, roll, pitch, steer, yaw)

    turn = rotation(number, axes(number)[2], yaw)
    omega = turn(m.velocities["B"].angular)
    ahead, aside, down = (turn(m.bodies["B"].attitude(e)) for e in axes(number))
    hub = turn(m.rear_hub_velocity)
    masses = {letter: body.mass for letter, body in m.bodies.items()}
    momentum = turn(
        Vector([sum(masses[b] * v.linear[i] for b, v in m.velocities.items()) for i in range(3)])
    )
    mass = sum(masses.values())
    radius, front_radius = (a.number(both.bicycle[r]) for r in ("rR", "rF"))
    tilt = a.number(both.bicycle["lam"])
    heading = turn(axes(number)[0])
    down_the_steer_axis = a.sin(tilt) * ahead + a.cos(tilt) * down
    across_the_steer_axis = a.cos(tilt) * ahead - a.sin(tilt) * down

    front_hub = turn(m.velocities["F"].linear)
    vertical = axes(number)[2]
    axle = turn(m.bodies["H"].attitude(axes(number)[1]))
    front_contact = turn(contact_velocity(both, "F"))
    track = axle.cross(vertical)
    front_spin = turn(m.velocities["F"].angular).dot(axle)
    rear_contact = m.speed + radius * a.sin(m.roll) * m.yaw_rate

    def angle_and_rate(y: Any, x: Any, y_rate: Any, x_rate: Any) -> tuple[Any, Any]:
        return a.atan2(y, x), (y_rate * x - y * x_rate) / (x * x + y * y)

    # These are elements of the attitude matrix: R23 and R33 in its third column, R32 in its second.
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
        # The contact point of a wheel that leans to the right is to the left of the hub.
        "forward_speed_contact": rear_contact,
        "forward_speed_hub_norm": a.sqrt(hub.dot(hub)),
        "forward_speed_com_norm": a.sqrt(momentum.dot(momentum)) / mass,
        "forward_speed_hub_global_x": hub[0],
        "forward_speed_contact_global_x": rear_contact * heading[0],
        "forward_speed_com_heading": momentum.dot(heading) / mass,
        "forward_speed_com_global_x": momentum[0] / mass,
        "forward_speed_front_hub_heading": front_hub.dot(heading),
        "forward_speed_front_hub_norm": a.sqrt(front_hub.dot(front_hub)),
        "forward_speed_front_hub_global_x": front_hub[0],
        "forward_speed_front_contact": front_contact.dot(track) / a.sqrt(track.dot(track)),
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
        "pitch_zyx": a.atan2(-ahead[2], a.sqrt(ahead[0] * ahead[0] + ahead[1] * ahead[1])),
        "pitch_steer_axes": m.pitch + tilt,
        "yaw": yaw,
        "yaw_rate": m.yaw_rate,
        "yaw_rate_body_z": omega.dot(down),
        "yaw_rate_steer_axes_z": omega.dot(down_the_steer_axis),
    }
    assert expected.keys() == found.keys()
    return {name: (found[name], x) for name, x in expected.items()}


def contact_velocity(both: Both, wheel: str) -> Vector:
    """Return the velocity of a wheel's contact point, at zero yaw.

    The contact point is at the end of the wheel's steepest radius, along s / |s|.
    """
    m, a = both.oracle, both.a
    _, aside, vertical = axes(both.number)
    axle = m.bodies[wheel].attitude(aside)
    # The spin about the axle does not move the axle.
    axle_rate = m.velocities[wheel].angular.cross(axle)
    s = vertical - vertical.dot(axle) * axle
    s_rate = -(vertical.dot(axle_rate) * axle + vertical.dot(axle) * axle_rate)
    factor = a.number(both.bicycle[f"r{wheel}"]) / a.sqrt(s.dot(s))
    change: Vector = factor * (s_rate - s.dot(s_rate) / s.dot(s) * s)
    return m.velocities[wheel].linear + change


def from_the_integrals(both: Both) -> Pairs:
    """Return rates of position and wheel angles, and the speed of the front contact point."""
    m, number = both.oracle, both.number
    equations = Equations.of(both.bicycle, both.a)
    state = [*both.regular_state, both.yaw]
    rear = rotation(number, axes(number)[2], both.yaw)(contact_velocity(both, "R"))
    _, front = track_speeds(equations.k, equations.unfold(state)[1])
    _, aside, vertical = axes(number)
    track = m.bodies["F"].attitude(aside).cross(vertical)
    along = contact_velocity(both, "F").dot(track) / both.a.sqrt(track.dot(track))
    values = rear[0], rear[1], m.rear_wheel_rate, m.front_wheel_rate
    found = rates_of_integrals(equations, state)
    return {
        **{name: (x, y) for name, x, y in zip(INTEGRALS, found, values, strict=True)},
        "front contact's speed": (front, along),
    }


def found_motion(both: Both, *, is_regular: bool, b: Bodies | None = None) -> dict[str, Any]:
    """Return all columns of motion.h5 from the package."""
    state = both.regular_state if is_regular else both.few_product_state
    rest = [both.yaw, *(both.a.number(x) for x in (*PLACE, *ANGLES))]
    equations = Equations.of(both.bicycle, both.a, is_regular=is_regular)
    return motion_columns(replace(equations, b=b or equations.b), [*state, *rest])


def named(name: str, v: Vector) -> dict[str, Any]:
    return dict(zip((f"{name}_x", f"{name}_y", f"{name}_z"), v, strict=True))


def whole_motion(both: Both) -> dict[str, Any]:
    """Return all columns of motion.h5 from the oracle, rotated by the yaw and moved."""
    m, p, a, number = both.oracle, both.bicycle, both.a, both.number
    x, y, z = axes(number)
    turn = rotation(number, z, both.yaw)
    rear, front = m.bodies["B"].attitude, m.bodies["H"].attitude
    place = Vector([a.number(c) for c in (*PLACE, 0)])

    def lowest(hub: Vector, axle: Vector, radius: Any) -> Vector:
        across = z - z.dot(axle) * axle
        return hub + (a.number(radius) / a.sqrt(across.dot(across))) * across

    centres = {letter: body.centre for letter, body in m.bodies.items()}
    total = sum(body.mass for body in m.bodies.values())
    centre = (1 / total) * sum((body.mass * body.centre for body in m.bodies.values()), start=0 * x)
    contact = lowest(centres["F"], front(y), p["rF"].rational)
    tilt = a.number(p["lam"])
    steer_axis = rear(Vector([a.sin(tilt), a.number(0), a.cos(tilt)]))
    along = (front(y).cross(steer_axis), front(y), steer_axis)
    values = dict(zip(("rear_contact_x", "rear_contact_y"), place, strict=False))
    values |= dict(
        zip(("rear_wheel_angle", "front_wheel_angle"), map(a.number, ANGLES), strict=True)
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
        values[f"{end}_friction"] = a.sqrt(tangential.dot(tangential)) / floor.normal
        hub = m.joints[f"{end} hub"]
        values |= named(f"{end}_axle_force", attitude.transposed(hub.force))
        values |= named(f"{end}_axle_moment", attitude.transposed(hub.torque))
    joint = m.joints["steer"]
    values |= named("steer_joint_force", Vector([joint.force.dot(e) for e in along]))
    values |= named("steer_joint_moment", Vector([joint.torque.dot(e) for e in along]))
    return values


def from_the_whole_motion(both: Both, *, is_regular: bool, b: Bodies | None = None) -> Pairs:
    """Return pairs of every column of motion.h5; quaternions as rotation matrices.

    The bodies may differ from those in the equations.
    """
    values, wanted = found_motion(both, is_regular=is_regular, b=b), whole_motion(both)
    result = {}
    for end in ("rear", "front"):
        p, q, r, s = (values[f"{end}_frame_q{i}"] for i in range(4))
        # The Euler-Rodrigues formula gives the matrix of a unit quaternion.
        matrix = (
            (p * p + q * q - r * r - s * s, 2 * (q * r - p * s), 2 * (q * s + p * r)),
            (2 * (q * r + p * s), p * p - q * q + r * r - s * s, 2 * (r * s - p * q)),
            (2 * (q * s - p * r), 2 * (r * s + p * q), p * p - q * q - r * r + s * s),
        )
        result |= {
            f"{end} quaternion, r{i + 1}{j + 1}": (
                matrix[i][j],
                wanted[f"{end}_frame_r{i + 1}{j + 1}"],
            )
            for i in range(3)
            for j in range(3)
        }
        result[f"{end} norm"] = (p * p + q * q + r * r + s * s, both.a.number(1))
    return result | {name: (values[name], x) for name, x in wanted.items() if name in values}

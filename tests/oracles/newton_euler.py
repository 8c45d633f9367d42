"""The Carvallo-Whipple bicycle by Newton's and Euler's equations, in redundant coordinates.

This is an oracle for any other formulation of the same bicycle, without elimination by hand: the
four bodies have 24 accelerations, the hubs and the steer bearing are revolute joints (5 conditions
each), each wheel rolls without slip (3 conditions), and the accelerations and the 21 reactions
solve one linear system. The velocities are solved likewise, from the same conditions and from the
three rates that are given.

Axes: x forward, y to the right, z down, g along +z. Rear frame attitude Rz(yaw) Rx(roll) Ry(pitch),
at yaw = 0; pitch is zero in the reference position, upright and straight. The steer axis passes
through (w + c, 0, 0) of that position along (sin lam, 0, cos lam), and steer is positive about it.
The parameters, and inertia values as matrix elements, are those of Meijaard, Papadopoulos, Ruina
and Schwab (2007), doi:10.1098/rspa.2007.1857.

The bodies are R, the rear wheel; B, the rear frame with rider; H, the front fork and handlebar; F,
the front wheel.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.exact import Exact
from oracles.multibody import (
    Body,
    Constraint,
    Parts,
    Rolling,
    SameAxis,
    SamePoint,
    Twists,
    solve_accelerations,
    solve_velocities,
    to_rim,
)
from oracles.vectors import (
    Arithmetic,
    Balls,
    Given,
    Matrix,
    Multiprecision,
    Number,
    Vector,
    axes,
    product,
    rotation,
    zero,
)


@dataclass(frozen=True)
class ContactForce:
    """Force of the floor on a wheel [N].

    Attributes
    ----------
    vector
        In the inertial frame.
    normal
        Upward component, positive when the floor pushes.
    longitudinal, lateral
        Along the wheel's heading, where its plane meets the floor, and to the right of it.
    """

    vector: Vector
    normal: Number
    longitudinal: Number
    lateral: Number


@dataclass(frozen=True)
class JointReaction:
    """Force [N] at a joint's point and torque [N m] about it, in the inertial frame.

    They act on the wheel at a hub and on the front frame at the steer bearing; the other body feels
    the opposite. The point is the hub, or the rear frame's point that is on the floor at
    (w + c, 0, 0) in the reference position.
    """

    force: Vector
    torque: Vector


@dataclass(frozen=True)
class Motion:
    """Velocities, accelerations, forces and energies of one state at yaw = 0, SI units.

    Wheel rates and accelerations are relative to the frame that holds the wheel, positive about
    the axle to the right: a wheel that rolls forward has a negative rate. The potential energy is
    zero on the floor. The powers are those of the inertia forces and of gravity; they agree because
    the joints and the floor do no work. Bodies and their velocities and accelerations are by
    letter, the attitudes of the wheels without their spin.
    """

    roll: Number
    pitch: Number
    steer: Number
    yaw_rate: Number
    roll_rate: Number
    pitch_rate: Number
    steer_rate: Number
    rear_wheel_rate: Number
    front_wheel_rate: Number
    speed: Number
    yaw_acc: Number
    roll_acc: Number
    pitch_acc: Number
    steer_acc: Number
    rear_wheel_acc: Number
    front_wheel_acc: Number
    speed_acc: Number
    rear_hub_position: Vector
    rear_hub_velocity: Vector
    rear_hub_acceleration: Vector
    rear_contact: ContactForce
    front_contact: ContactForce
    joints: Mapping[str, JointReaction]
    kinetic_energy: Number
    potential_energy: Number
    kinetic_power: Number
    gravity_power: Number
    bodies: Mapping[str, Body]
    velocities: Twists
    accelerations: Twists

    @property
    def power_residual(self) -> Number:
        """Rate of change of the total energy [W], which is zero except for rounding."""
        return self.kinetic_power - self.gravity_power


def solve_pitch(
    bicycle: Bicycle,
    roll: Given,
    steer: Given,
    digits: int = 60,
    arithmetic: type[Balls] | type[Multiprecision] = Balls,
) -> Number:
    """Return the pitch [rad] with both wheels on the floor, followed from upright and straight.

    The result is good to `digits` digits, and is not an enclosure.

    Raises
    ------
    ValueError
        The pitch cannot be followed to this roll and steer.
    """
    coarse = arithmetic(20)
    with coarse.working():
        p, pitch = _numbers(coarse, bicycle), coarse.exact(0)
        done, step = Fraction(0), Fraction(1, 2)
        while done < 1:
            to = min(done + step, Fraction(1))
            part = coarse.exact(to)
            lean, turn = part * coarse.exact(roll), part * coarse.exact(steer)
            found = _newton(coarse, p, lean, pitch, turn, 20)
            if found is not None:
                pitch, done = found, to
            elif step < Fraction(1, 500):
                raise ValueError("found no pitch that puts both wheels on the floor")
            else:
                step /= 2
    fine = arithmetic(digits)
    with fine.working():
        p, start = _numbers(fine, bicycle), fine.exact(0) + pitch
        found = _newton(fine, p, fine.exact(roll), start, fine.exact(steer), digits + 10)
        if found is None:
            raise ValueError("found no pitch to this many digits")
        return found


def move(
    bicycle: Bicycle,
    roll: Given,
    pitch: Number | None,
    steer: Given,
    *,
    roll_rate: Given,
    steer_rate: Given,
    speed: Given | None = None,
    rear_wheel_rate: Given | None = None,
    digits: int = 60,
    arithmetic: type[Balls] | type[Multiprecision] = Balls,
) -> Motion:
    """Compute velocities, accelerations and forces of the bicycle in one state.

    Parameters
    ----------
    bicycle
    roll, pitch, steer
        Angles [rad]. A pitch of None is solved for; one that is given must put both wheels on the
        floor, which is not checked.
    roll_rate, steer_rate
        [rad/s].
    speed, rear_wheel_rate
        One of the two: the rear hub's speed along the heading [m/s], which is the line where the
        rear wheel plane meets the floor, or the spin rate relative to the rear frame [rad/s].
    digits
        Decimal digits wanted; a few more are carried.
    arithmetic
        `Balls` or `Multiprecision`.
    """
    if pitch is None:
        pitch = solve_pitch(bicycle, roll, steer, digits, arithmetic)
    number = arithmetic(digits)
    with number.working():
        if isinstance(pitch, Exact | Fraction | int):
            pitch = number.exact(pitch)
        p = _numbers(number, bicycle)
        pose = _pose(number, p, number.exact(roll), pitch, number.exact(steer))
        bodies = _bodies(number, p, pose)
        none = zero(number)
        given: list[tuple[Parts, Number]] = [
            ({"B": (none, pose.heading)}, number.exact(roll_rate)),
            (
                {"H": (none, pose.steer_axis), "B": (none, -pose.steer_axis)},
                number.exact(steer_rate),
            ),
        ]
        if speed is not None:
            given += [({"R": (pose.heading, none)}, number.exact(speed))]
        if rear_wheel_rate is not None:
            spin = {"R": (none, pose.rear_axle), "B": (none, -pose.rear_axle)}
            given += [(spin, number.exact(rear_wheel_rate))]
        if len(given) != 3:
            raise ValueError("expected either speed or rear_wheel_rate")
        constraints = _constraints(number, pose)
        velocities = solve_velocities(number, tuple(bodies), constraints, given)
        accelerations, reactions = solve_accelerations(number, bodies, constraints, velocities)
        joints = {}
        for bearing in constraints:
            if isinstance(bearing, SameAxis):
                name = bearing.name.removesuffix(" torque")
                (a, b), (s, t) = reactions[bearing.name], bearing.directions
                force = Vector(reactions[f"{name} force"])
                joints[name] = JointReaction(force=force, torque=a * s + b * t)
        return _motion(number, pose, bodies, velocities, accelerations, reactions, joints)


@dataclass(frozen=True)
class _Pose:
    """Positions and attitudes in the inertial frame; `pivot` is the point of the steer bearing."""

    roll: Number
    pitch: Number
    steer: Number
    attitudes: Mapping[str, Matrix]
    centres: Mapping[str, Vector]
    pivot: Vector
    steer_axis: Vector
    heading: Vector
    front_heading: Vector
    rear_axle: Vector
    front_axle: Vector
    rear_radius: Number
    front_radius: Number


def _numbers(number: Arithmetic, bicycle: Bicycle) -> dict[str, Number]:
    return {symbol: number.exact(x) for symbol, x in bicycle.values.items()}


def _pose(
    number: Arithmetic, p: Mapping[str, Number], roll: Number, pitch: Number, steer: Number
) -> _Pose:
    x, y, z = axes(number)
    nought = number.exact(0)
    axis = Vector((number.sin(p["lam"]), nought, number.cos(p["lam"])))
    on_axis = Vector((p["w"] + p["c"], nought, nought))
    reference = {
        "R": Vector((nought, nought, -p["rR"])),
        "B": Vector((p["xB"], nought, p["zB"])),
        "H": Vector((p["xH"], nought, p["zH"])),
        "F": Vector((p["w"], nought, -p["rF"])),
    }

    rear = product(rotation(number, x, roll), rotation(number, y, pitch))
    front = product(rear, rotation(number, axis, steer))
    rear_axle, front_axle = rear(y), front(y)
    # The rear wheel stands on the origin of the coordinates.
    hub = -to_rim(number, rear_axle, p["rR"])
    pivot = hub + rear(on_axis - reference["R"])
    across = front_axle.cross(z)
    return _Pose(
        roll=roll,
        pitch=pitch,
        steer=steer,
        # The angle of a wheel about its axle does not matter, so a wheel has the attitude of its
        # frame.
        attitudes={"R": rear, "B": rear, "H": front, "F": front},
        centres={
            "R": hub,
            "B": hub + rear(reference["B"] - reference["R"]),
            "H": pivot + front(reference["H"] - on_axis),
            "F": pivot + front(reference["F"] - on_axis),
        },
        pivot=pivot,
        steer_axis=rear(axis),
        heading=x,
        front_heading=(1 / number.sqrt(across.dot(across))) * across,
        rear_axle=rear_axle,
        front_axle=front_axle,
        rear_radius=p["rR"],
        front_radius=p["rF"],
    )


def _bodies(number: Arithmetic, p: Mapping[str, Number], pose: _Pose) -> dict[str, Body]:
    bodies = {}
    nought, down = number.exact(0), axes(number)[2]
    for letter, centre in pose.centres.items():
        mass, xx, yy = p[f"m{letter}"], p[f"I{letter}xx"], p[f"I{letter}yy"]
        zz, xz = (xx, nought) if letter in "RF" else (p[f"I{letter}zz"], p[f"I{letter}xz"])
        bodies[letter] = Body(
            mass=mass,
            inertia=Matrix(
                (Vector((xx, nought, xz)), Vector((nought, yy, nought)), Vector((xz, nought, zz)))
            ),
            attitude=pose.attitudes[letter],
            centre=centre,
            weight=(mass * p["g"]) * down,
        )
    return bodies


def _constraints(number: Arithmetic, pose: _Pose) -> list[Constraint]:
    """Return the 21 conditions."""
    x, _, z = axes(number)
    rear, front, at, none = pose.attitudes["B"], pose.attitudes["H"], pose.centres, zero(number)
    across_steer = (pose.rear_axle, pose.rear_axle.cross(pose.steer_axis))
    arms = pose.pivot - at["B"], pose.pivot - at["H"]
    return [
        SamePoint(number, "rear hub force", "B", "R", at["R"] - at["B"], none),
        SameAxis(number, "rear hub torque", "B", "R", (rear(x), rear(z))),
        SamePoint(number, "steer force", "B", "H", *arms),
        SameAxis(number, "steer torque", "B", "H", across_steer),
        SamePoint(number, "front hub force", "H", "F", at["F"] - at["H"], none),
        SameAxis(number, "front hub torque", "H", "F", (front(x), front(z))),
        Rolling(number, "rear contact", "R", pose.rear_axle, pose.rear_radius),
        Rolling(number, "front contact", "F", pose.front_axle, pose.front_radius),
    ]


def _newton(
    number: Arithmetic,
    p: Mapping[str, Number],
    roll: Number,
    pitch: Number,
    steer: Number,
    digits: int,
) -> Number | None:
    """Find the pitch at which the front wheel touches the floor, by Newton's iteration."""
    end, far = number.exact(Fraction(1, 10**digits)), number.exact(Fraction(1, 4))
    down = axes(number)[2]
    for _ in range(30):
        pose = _pose(number, p, roll, pitch, steer)
        hub, n = pose.centres["F"], pose.front_axle
        height = (hub + to_rim(number, n, pose.front_radius)).dot(down)
        # Everything except the rear wheel turns about the rear axle. The lowest point of the front
        # rim is radius sqrt(1 - tilt^2) below the front hub.
        turned = pose.rear_axle.cross(hub - pose.centres["R"]).dot(down)
        tilt, tilted = n.dot(down), pose.rear_axle.cross(n).dot(down)
        slope = turned - pose.front_radius * tilt * tilted / number.sqrt(1 - tilt * tilt)
        step = number.middle(height / slope)
        if not abs(step) < far:
            return None
        pitch = number.middle(pitch - step)
        if abs(step) < end:
            return pitch
    return None


def _yaw_and_pitch(number: Arithmetic, pose: _Pose, angular: Vector) -> tuple[Number, Number]:
    """Return a vector's components along the vertical and the rear axle, from its projection."""
    down = axes(number)[2]
    upright = pose.heading.cross(pose.rear_axle)
    yaw = angular.dot(upright) / down.dot(upright)
    return yaw, angular.dot(pose.rear_axle) - yaw * down.dot(pose.rear_axle)


def _contact(number: Arithmetic, heading: Vector, force: Sequence[Number]) -> ContactForce:
    down, vector = axes(number)[2], Vector(force)
    return ContactForce(
        vector=vector,
        normal=-vector.dot(down),
        longitudinal=vector.dot(heading),
        lateral=vector.dot(down.cross(heading)),
    )


def _motion(
    number: Arithmetic,
    pose: _Pose,
    bodies: Mapping[str, Body],
    velocities: Twists,
    accelerations: Twists,
    reactions: Mapping[str, Sequence[Number]],
    joints: Mapping[str, JointReaction],
) -> Motion:
    down = axes(number)[2]
    omega, alpha = velocities["B"].angular, accelerations["B"].angular
    hub = velocities["R"].linear

    roll_rate = omega.dot(pose.heading)
    yaw_rate, pitch_rate = _yaw_and_pitch(number, pose, omega)
    # The angular velocity is omega = yaw' k + roll' h + pitch' n. The vector h turns with the yaw,
    # and n turns with the frame.
    heading_dot = yaw_rate * down.cross(pose.heading)
    turning = alpha - roll_rate * heading_dot - pitch_rate * omega.cross(pose.rear_axle)
    yaw_acc, pitch_acc = _yaw_and_pitch(number, pose, turning)

    def relative(twists: Twists, inner: str, outer: str, axis: Vector) -> Number:
        # The formula is also valid for accelerations. The relative angular velocity is along the
        # axis, so the motion of the axis adds nothing along it.
        return (twists[outer].angular - twists[inner].angular).dot(axis)

    kinetic, potential = number.exact(0), number.exact(0)
    kinetic_power, gravity_power = number.exact(0), number.exact(0)
    for letter, body in bodies.items():
        v, a = velocities[letter], accelerations[letter]
        momentum = body.momentum(v.angular)
        kinetic += (body.mass * v.linear.dot(v.linear) + v.angular.dot(momentum)) / 2
        potential -= body.weight.dot(body.centre)
        kinetic_power += body.mass * v.linear.dot(a.linear) + momentum.dot(a.angular)
        gravity_power += body.weight.dot(v.linear)

    return Motion(
        roll=pose.roll,
        pitch=pose.pitch,
        steer=pose.steer,
        yaw_rate=yaw_rate,
        roll_rate=roll_rate,
        pitch_rate=pitch_rate,
        steer_rate=relative(velocities, "B", "H", pose.steer_axis),
        rear_wheel_rate=relative(velocities, "B", "R", pose.rear_axle),
        front_wheel_rate=relative(velocities, "H", "F", pose.front_axle),
        speed=hub.dot(pose.heading),
        yaw_acc=yaw_acc,
        roll_acc=turning.dot(pose.heading),
        pitch_acc=pitch_acc,
        steer_acc=relative(accelerations, "B", "H", pose.steer_axis),
        rear_wheel_acc=relative(accelerations, "B", "R", pose.rear_axle),
        front_wheel_acc=relative(accelerations, "H", "F", pose.front_axle),
        speed_acc=accelerations["R"].linear.dot(pose.heading) + hub.dot(heading_dot),
        rear_hub_position=pose.centres["R"],
        rear_hub_velocity=hub,
        rear_hub_acceleration=accelerations["R"].linear,
        rear_contact=_contact(number, pose.heading, reactions["rear contact"]),
        front_contact=_contact(number, pose.front_heading, reactions["front contact"]),
        joints=joints,
        kinetic_energy=kinetic,
        potential_energy=potential,
        kinetic_power=kinetic_power,
        gravity_power=gravity_power,
        bodies=bodies,
        velocities=velocities,
        accelerations=accelerations,
    )

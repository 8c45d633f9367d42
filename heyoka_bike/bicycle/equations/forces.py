"""Forces of the floor on the wheels and in the joints, from Newton's and Euler's laws.

The motion is known: the state, and its rates from the equations of motion. Every speed is a dual
number whose slope is its rate of change, so the code for the speeds of all bodies also gives their
accelerations, and these give the force and moment on each body. Then

- only the floor exerts a moment on a wheel about its axle: this gives the longitudinal force;
- apart from gravity, only the front contact exerts a moment on the whole bicycle about the rear
  contact point: this gives the front normal force, and the horizontal force across the line of the
  contact points;
- the rear contact carries the rest of the bicycle's weight and inertia, the axles carry those of
  their wheels, and the steer bearing those of the front assembly.

There are 24 conditions for 21 reactions. The remaining three are the equations of motion: the
moments of the bearings about their own axes vanish.

With NumPy arrays::

    state = roll, pitch, steer, roll_rate, steer_rate, forward_speed / rR
    forces(Equations.binary64(bicycle), state).front.normal  # ndarray [N]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from heyoka_bike.bicycle.equations.bodies import Axes, Bodies, Half, Points
from heyoka_bike.bicycle.equations.kinematics import posture
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.arithmetic import Arithmetic, Number
from heyoka_bike.numbers.dual import Dual, Duals
from heyoka_bike.numbers.vectors import Vector, cross, minus, plus, scaled


@dataclass(frozen=True, slots=True)
class Contact:
    """Force of the floor on a wheel [N].

    Attributes
    ----------
    normal
        Upward; the wheel stays on the floor as long as it is positive.
    longitudinal, lateral
        Along the wheel's heading, where its plane meets the floor, and to the right of it.
    """

    normal: Number
    longitudinal: Number
    lateral: Number

    def friction(self, a: Arithmetic) -> Number:
        """Return the friction coefficient that rolling needs: tangential over normal force."""
        along, across = self.longitudinal, self.lateral
        return a.sqrt(along * along + across * across) / self.normal


@dataclass(frozen=True, slots=True)
class Wrench:
    """A force [N], and a moment [N m] about a point.

    The moment in a bearing about its own axis is zero, by the equations of motion.
    """

    force: Vector
    moment: Vector

    def __add__(self, other: Wrench) -> Wrench:
        return Wrench(plus(self.force, other.force), plus(self.moment, other.moment))

    def __sub__(self, other: Wrench) -> Wrench:
        return Wrench(minus(self.force, other.force), minus(self.moment, other.moment))


@dataclass(frozen=True, slots=True)
class Forces:
    """Forces on the wheels and in the joints; those in the joints are computed on first use.

    A joint supplies the force that the motion of the parts beyond it needs, less the contact forces
    on them.

    Attributes
    ----------
    rear, front : Contact
    """

    rear: Contact
    front: Contact
    _bodies: Bodies
    _axes: Axes
    _on_rear: Vector
    _on_front: Vector
    _rear_wheel: Wrench
    _front_wheel: Wrench
    _front_frame: Wrench

    @property
    def rear_axle(self) -> Wrench:
        """Wrench on the rear wheel at its hub, along the rear frame's axes; y is the axle."""
        axes = self._axes
        at_wheel = axes.to_rear(self._on_rear)
        arm = scaled(self._bodies.rear.wheel_r, axes.to_rear(axes.rear_down))
        return self._rear_wheel - Wrench(at_wheel, cross(arm, at_wheel))

    @property
    def front_axle(self) -> Wrench:
        """Wrench on the front wheel at its hub, along the fork's axes; y is the axle."""
        return self._front_wheel - self._floor_on_front

    @property
    def steer(self) -> Wrench:
        """Wrench on the fork at the pivot (see `bodies`).

        The axes are z down the steer axis, y right along the front axle, and x forward across both.
        """
        part = self._bodies.front
        push = self._front_frame + self._front_wheel - self._floor_on_front
        turn = minus(push.moment, cross((part.pivot_x, 0, part.pivot_z), push.force))
        return Wrench(*(self._axes.across_tilt(v, back=True) for v in (push.force, turn)))

    @property
    def _floor_on_front(self) -> Wrench:
        """Wrench of the floor on the front wheel, about its hub, in front axes."""
        axes = self._axes
        at_wheel = axes.to_front(self._on_front)
        arm = scaled(self._bodies.front.wheel_r, axes.to_front(axes.front_down))
        return Wrench(at_wheel, cross(arm, at_wheel))


def forces(equations: Equations, state: Sequence[Number]) -> Forces:
    """Compute the reactions in a state; a seventh entry, the yaw, is ignored.

    Parameters
    ----------
    equations : Equations
    state
        State in the form of the equations [rad, rad/s], see `kinematics`.
    """
    k, b, a = equations.k, equations.b, equations.a
    rates = equations.rates(state)
    moving = [Dual(x, (rate,)) for x, rate in zip(state[:6], rates, strict=True)]
    o, u = equations.over(Duals(a)).unfold(moving)
    at_rest = posture(k, a, *state[:3])
    axes = Axes.of(b, at_rest)
    weight = (0, 0, -b.g)
    v, v_f, p_f = k.length * u.v, k.length * u.v_f, o.cb_f * u.w1_f + o.sb_f * u.w3_f
    frame, wheel = _loads(
        b.rear, axes, (u.w1, u.q, u.w3), (v * o.cb, b.rear.wheel_r * u.p, v * o.sb), v,
        axes.to_rear(weight),
    )  # fmt: skip
    frame_f, wheel_f = _loads(
        b.front, axes, (u.w1_f, u.q_f, u.w3_f),
        (v_f * o.cb_f, b.front.wheel_r * p_f, v_f * o.sb_f), v_f, axes.to_front(weight),
    )  # fmt: skip
    # The contact forces balance the inertia and weight of the whole bicycle.
    points = Points.of(b, axes)
    x, y, _ = points.front_contact  # The z component is not needed, as the floor is level.
    whole, whole_f = frame + wheel, frame_f + wheel_f
    force, force_f = axes.from_rear(whole.force), axes.from_front(whole_f.force)
    about_rear = plus(
        plus(axes.from_rear(whole.moment), cross(points.rear_hub, force)),
        plus(axes.from_front(whole_f.moment), cross(points.front_hub, force_f)),
    )
    ahead, aside, _ = axes.front_heading
    # Three conditions determine the two horizontal components of the front contact force: one along
    # each heading, and one for turning about the rear contact point. The conditions are consistent,
    # so the least-squares solution satisfies all of them. It is regular if any two conditions are
    # independent.
    spin = wheel.moment[1] / b.rear.wheel_r
    spin_f = wheel_f.moment[1] / b.front.wheel_r
    rest = force[0] + force_f[0] - spin
    b_x = ahead * spin_f - y * about_rear[2] + rest
    b_y = aside * spin_f + x * about_rear[2]
    a_xx, a_xy, a_yy = 1 + ahead * ahead + y * y, ahead * aside - x * y, aside * aside + x * x
    along = x * ahead + y * aside
    determinant = along * along + a_yy
    on_front = (
        (a_yy * b_x - a_xy * b_y) / determinant,
        (a_xx * b_y - a_xy * b_x) / determinant,
        (about_rear[0] * y - about_rear[1] * x) / (x * x + y * y),
    )
    on_rear = minus(plus(force, force_f), on_front)
    return Forces(
        rear=Contact(normal=-on_rear[2], longitudinal=on_rear[0], lateral=on_rear[1]),
        front=Contact(
            normal=-on_front[2],
            longitudinal=ahead * on_front[0] + aside * on_front[1],
            lateral=ahead * on_front[1] - aside * on_front[0],
        ),
        _bodies=b, _axes=axes, _on_rear=on_rear, _on_front=on_front,
        _rear_wheel=wheel, _front_wheel=wheel_f, _front_frame=frame_f,
    )  # fmt: skip


def _loads(
    part: Half, axes: Axes, turning: Vector, hub: Vector, v: Dual, lift: Vector
) -> tuple[Wrench, Wrench]:
    """Return the wrenches on a frame and its wheel that their motion needs beyond their weights.

    The moment is about the hub. Newton's and Euler's laws are applied in the frame's axes.

    Parameters
    ----------
    turning, hub
        Angular velocity and velocity of the hub along axes turned by the tilt, dual numbers.
    v
        Speed of the hub along the wheel's heading.
    lift
        Minus gravity, in the frame's axes.
    """
    omega, velocity = (axes.across_tilt(_values(x)) for x in (turning, hub))
    alpha, change = (axes.across_tilt(_slopes(x)) for x in (turning, hub))
    acceleration = plus(lift, plus(change, cross(omega, velocity)))
    arm = (part.x, 0, part.z)
    swing = plus(cross(alpha, arm), cross(omega, cross(omega, arm)))
    force = scaled(part.m, plus(acceleration, swing))
    moment = plus(part.inertia_times(alpha), cross(omega, part.inertia_times(omega)))
    spin, spin_rate = (-(x / part.wheel_r) for x in (v.value, v.slopes[0]))
    rim = part.wheel_inertia_times((omega[0], spin, omega[2]))
    rim_rate = part.wheel_inertia_times((alpha[0], spin_rate, alpha[2]))
    return (
        Wrench(force, plus(moment, cross(arm, force))),
        Wrench(scaled(part.wheel_m, acceleration), plus(rim_rate, cross(omega, rim))),
    )


def _values(v: Vector) -> Vector:
    return v[0].value, v[1].value, v[2].value


def _slopes(v: Vector) -> Vector:
    return v[0].slopes[0], v[1].slopes[0], v[2].slopes[0]

"""The columns of the benchmark, in every definition, as functions of the state.

The module `columns` lists the meaning of each column.

The rear frame has attitude R = Rz(yaw) Rx(roll) Ry(pitch); z is down, so a positive roll leans to
the right and a positive yaw turns to the right.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from heyoka_bike.bicycle.equations.constants import Assembly, Constants
from heyoka_bike.bicycle.equations.kinematics import Posture, Speeds
from heyoka_bike.numbers.arithmetic import Arithmetic, Number
from heyoka_bike.numbers.vectors import Vector


@dataclass(frozen=True, slots=True)
class Energies:
    """Potential and kinetic energy [J]; the potential energy is zero at the floor."""

    potential: Number
    kinetic: Number

    @property
    def total(self) -> Number:
        """The mechanical energy, which the motion conserves."""
        return self.potential + self.kinetic


def yaw_rate(o: Posture, u: Speeds) -> Number:
    """Return the yaw rate of the rear heading [rad/s]; the front heading turns at another rate."""
    return u.n / o.cos_roll


def energies(k: Constants, o: Posture, u: Speeds) -> Energies:
    """Return the energies of the whole bicycle."""
    rear, front = k.rear, k.front
    height = o.cos_roll * (rear.r + rear.l1 * o.sb - rear.l3 * o.cb)
    height_f = o.cos_roll * (front.r * o.kappa + front.l1 * o.y - front.l3 * o.cb)
    weight = k.g * (rear.m * height + front.m * height_f)
    velocity, velocity_f = _centre_velocity(k, o, u)
    kinetic2 = _kinetic2(rear, velocity, u.w1, u.q, u.w3, u.v)
    kinetic2 += _kinetic2(front, velocity_f, u.w1_f, u.q_f, u.w3_f, u.v_f)
    joule = k.mass * k.length * k.length
    return Energies(potential=joule * weight, kinetic=joule * kinetic2 / 2)


def _kinetic2(
    b: Assembly, velocity: Vector, w1: Number, q: Number, w3: Number, v: Number
) -> Number:
    """Return twice the kinetic energy of one assembly."""
    x, y, z = velocity
    turning = b.i11 * w1 * w1 + 2 * b.i13 * w1 * w3 + b.i33 * w3 * w3 + b.i22 * q * q
    return b.m * (x * x + y * y + z * z) + turning + b.spin / b.r * (v * v)


def _centre_velocity(k: Constants, o: Posture, u: Speeds) -> tuple[Vector, Vector]:
    """Return the velocity of each assembly's centre of mass, in the axes of that assembly."""
    rear, front = k.rear, k.front
    p_f = o.cb_f * u.w1_f + o.sb_f * u.w3_f
    return (
        (
            u.v * o.cb + u.q * rear.l3,
            rear.r * u.p + rear.l1 * u.w3 - rear.l3 * u.w1,
            u.v * o.sb - u.q * rear.l1,
        ),
        (
            u.v_f * o.cb_f + u.q_f * front.l3,
            front.r * p_f + front.l1 * u.w3_f - front.l3 * u.w1_f,
            u.v_f * o.sb_f - u.q_f * front.l1,
        ),
    )


def columns(
    k: Constants, a: Arithmetic, o: Posture, u: Speeds, roll: Number, pitch: Number,
    steer: Number, yaw: Number, *, is_smooth: bool = False,
) -> Mapping[str, Number]:  # fmt: skip
    """Return every column of `columns.COLUMNS` by name, SI units; without `NORMS` if smooth."""
    sp, cp = o.sin_roll, o.cos_roll
    s_pitch, c_pitch = a.sin(pitch), a.cos(pitch)
    s_yaw, c_yaw = a.sin(yaw), a.cos(yaw)
    yaw_dot = yaw_rate(o, u)
    pitch_dot = u.q - u.nu
    hub_y = k.rear.r * u.p

    # Because R = Rx(first) Ry Rz, the y and z components of the frame's z axis are in the ratio of
    # -sin(first) to cos(first). The first angle follows from this ratio.
    num = c_yaw * sp * c_pitch - s_yaw * s_pitch
    num_dot = (
        u.p * c_yaw * cp * c_pitch
        - yaw_dot * (s_yaw * sp * c_pitch + c_yaw * s_pitch)
        - pitch_dot * (c_yaw * sp * s_pitch + s_yaw * c_pitch)
    )
    den = cp * c_pitch
    den_dot = -(u.p * sp * c_pitch) - pitch_dot * cp * s_pitch

    (a1, a2, a3), (b1, b2, b3) = _centre_velocity(k, o, u)
    rear_m, front_m = k.rear.m, k.front.m
    # Mean of the velocities of the two centres of mass, weighted by mass, in the axes of the rear
    # assembly.
    mean = (
        rear_m * a1 + front_m * (o.c * b1 - o.s * b2),
        rear_m * a2 + front_m * (o.s * b1 + o.c * b2),
        rear_m * a3 + front_m * b3,
    )
    mass = rear_m + front_m

    def heading(x: Number, z: Number) -> Number:
        """Return the component along the rear heading of a vector x e1 + z e3."""
        return x * o.cb + z * o.sb

    def global_x(x: Number, y: Number, z: Number) -> Number:
        aside = y * cp - (z * o.cb - x * o.sb) * sp
        return heading(x, z) * c_yaw - aside * s_yaw

    def from_the_front(x: Number, y: Number, z: Number) -> Vector:
        return (o.c * x - o.s * y, o.s * x + o.c * y, z)

    contact = u.v + k.rear.r * u.nu
    front_hub_y = k.front.r * (o.cb_f * u.w1_f + o.sb_f * u.w3_f)
    front_hub = from_the_front(u.v_f * o.cb_f, front_hub_y, u.v_f * o.sb_f)
    track = u.v_f + k.front.r * u.nu_f
    front_contact = from_the_front(track * o.cb_f, 0 * track, track * o.sb_f)
    e = energies(k, o, u)
    speed = {
        "forward_speed": u.v,
        "forward_speed_hub_body_x": u.v * c_pitch,
        "forward_speed_wheel_spin": u.v + k.rear.r * u.q,
        "forward_speed_contact": contact,
        "forward_speed_hub_global_x": u.v * c_yaw - hub_y * cp * s_yaw,
        "forward_speed_contact_global_x": contact * c_yaw,
        "forward_speed_com_heading": heading(mean[0], mean[2]) / mass,
        "forward_speed_com_global_x": global_x(*mean) / mass,
        "forward_speed_front_hub_heading": heading(front_hub[0], front_hub[2]),
        "forward_speed_front_hub_global_x": global_x(*front_hub),
        "forward_speed_front_contact": track,
        "forward_speed_front_contact_heading": heading(front_contact[0], front_contact[2]),
        "forward_speed_front_contact_global_x": global_x(*front_contact),
        "forward_speed_front_wheel_heading": u.v_f,
        "forward_speed_front_wheel_spin": u.v_f + k.front.r * u.q_f,
    }
    if not is_smooth:
        speed |= {
            "forward_speed_hub_norm": a.sqrt(u.v * u.v + hub_y * hub_y),
            "forward_speed_com_norm": a.sqrt(a.sum([x * x for x in mean])) / mass,
            "forward_speed_front_hub_norm": a.sqrt(u.v_f * u.v_f + front_hub_y * front_hub_y),
        }
    return {
        "roll_angle": roll,
        "roll_rate": u.p,
        "potential_energy": e.potential,
        "kinetic_energy": e.kinetic,
        "mechanical_energy": e.potential + e.kinetic,
        "steer_angle": steer,
        "steer_rate": u.steer_rate,
        "roll_angle_tait_bryan_xyz": a.atan2(num, den),
        "roll_angle_zyx": a.atan2(sp, den),
        "roll_rate_body_x": u.p * c_pitch - u.n * s_pitch,
        "roll_rate_tait_bryan_xyz_rate": (num_dot * den - num * den_dot) / (num * num + den * den),
        "roll_rate_zyx_rate": (u.p * cp * den - sp * den_dot) / (sp * sp + den * den),
        "roll_rate_steer_axes_x": u.w1,
        **{name: k.length * x for name, x in speed.items()},
        "pitch": pitch,
        "pitch_zyx": a.atan2(
            cp * s_pitch, a.sqrt(c_pitch * c_pitch + sp * s_pitch * (sp * s_pitch))
        ),
        "pitch_steer_axes": pitch + k.tilt,
        "yaw": yaw,
        "yaw_rate": yaw_dot,
        "yaw_rate_body_z": u.n * c_pitch + u.p * s_pitch,
        "yaw_rate_steer_axes_z": u.w3,
    }

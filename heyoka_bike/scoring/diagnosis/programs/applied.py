"""Forces that a program applies beside gravity: dampers, springs, drag and friction.

The benchmark has none. Simulators bring some by default, and models of bicycles have others. Each
is linear in its coefficient, and enters by the power that it has at unit independent speeds (roll
rate, steer rate, rolling rate): a force f at a point of velocity v as f . v, a torque likewise.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from heyoka_bike.bicycle.equations.kinematics import Speeds
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.arithmetic import Number
from heyoka_bike.numbers.vectors import Vector, cross, from_turned_y, plus, scaled

_STEER, _STEER_RATE = 2, 4
_INDEPENDENT = slice(3, 6)


@dataclass(frozen=True, slots=True)
class Force:
    """A force with a coefficient that the correct program has as zero.

    Attributes
    ----------
    says
        What the coefficient is of.
    unit
    size
        A small one [SI].
    """

    says: str
    unit: str
    size: float


STEER_DAMPING, STEER_STIFFNESS = "steer_damping", "steer_stiffness"
AIR_DRAG, WHEEL_FRICTION = "air_drag", "wheel_friction"
ROLLING_RESISTANCE, VELOCITY_DAMPING = "rolling_resistance", "velocity_damping"

FORCES: Mapping[str, Force] = {
    STEER_DAMPING: Force("damping of the steer axis", "N m s", 0.1),
    STEER_STIFFNESS: Force("stiffness of a spring on the steer axis", "N m", 1.0),
    AIR_DRAG: Force("drag over speed squared at the rear frame's centre of mass", "kg m-1", 0.1),
    WHEEL_FRICTION: Force("viscous friction of each wheel's axle", "N m s", 0.01),
    ROLLING_RESISTANCE: Force("constant torque that brakes each wheel", "N m", 0.1),
    VELOCITY_DAMPING: Force("rate at which all velocities are damped", "s-1", 0.01),
}
"""The forces by name."""


def powers(
    equations: Equations, state: Sequence[Number], units: Sequence[Sequence[Number]],
    mass: Sequence[Sequence[Number]], amounts: Mapping[str, Number],
) -> list[Number]:  # fmt: skip
    """Power of all forces at each unit speed [N m].

    Parameters
    ----------
    equations
        Of the regular form.
    state
        Its variables.
    units
        States of the same posture, with one of the independent speeds 1 and the others 0.
    mass
        Mass matrix of the independent speeds [kg m^2].
    amounts
        Coefficients of `FORCES`.
    """
    a = equations.a
    now = equations.unfold(state)[1]
    rear, front = _relative_spins(equations, now)
    through_air = _centre_velocity(equations, state)
    speed = a.sqrt(a.sum([x * x for x in through_air]))
    steer = amounts[STEER_DAMPING] * state[_STEER_RATE] + amounts[STEER_STIFFNESS] * state[_STEER]
    found = []
    for unit, row in zip(units, mass, strict=True):
        by_rear, by_front = _relative_spins(equations, equations.unfold(unit)[1])
        by_centre = _centre_velocity(equations, unit)
        momentum = a.sum([m * u for m, u in zip(row, state[_INDEPENDENT], strict=True)])
        # Wheels roll forward: their rates are negative.
        friction = amounts[WHEEL_FRICTION] * (rear * by_rear + front * by_front)
        resistance = -(amounts[ROLLING_RESISTANCE] * (by_rear + by_front))
        along = a.sum([x * y for x, y in zip(through_air, by_centre, strict=True)])
        found.append(
            -a.sum([
                steer * unit[_STEER_RATE], friction, resistance,
                amounts[AIR_DRAG] * speed * along, amounts[VELOCITY_DAMPING] * momentum,
            ])
        )  # fmt: skip
    return found


def _relative_spins(equations: Equations, u: Speeds) -> tuple[Number, Number]:
    """Rates of the wheels about their axles, relative to their frames [rad/s]."""
    k = equations.k
    return -(u.v / k.rear.r) - u.q, -(u.v_f / k.front.r) - u.q_f


def _centre_velocity(equations: Equations, state: Sequence[Number]) -> Vector:
    """Velocity of the rear frame's centre of mass, in the frame's axes [m/s]."""
    o, u = equations.unfold(state)
    b, k = equations.b, equations.k

    def in_frame(along_steer: Vector) -> Vector:
        return from_turned_y(b.sin_tilt, b.cos_tilt, along_steer)

    # Speeds are in rear wheel radii.
    hub = scaled(b.rear.wheel_r / k.rear.r, in_frame((u.v * o.cb, k.rear.r * u.p, u.v * o.sb)))
    return plus(hub, cross(in_frame((u.w1, u.q, u.w3)), (b.rear.x, 0.0, b.rear.z)))

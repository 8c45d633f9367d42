"""Equations of motion without a term of Newton's and Euler's, or with a force more.

No parameter of the bicycle makes such a mistake. A torque or a weight that is missing is one that
is added and cancels it; a tensor that does not turn with its body is another tensor. With the
Jacobians J of the angular velocities w over the independent speeds u (roll rate, steer rate,
rolling rate), w' = J u' + b, the mass matrix M, what is added t and the surplus S of the tensors,

    (M - sum J^T S J) u' = M u'_right + sum J^T (t + S b + w x S w).

Forces are added likewise, see `applied`.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import reduce

from heyoka_bike.bicycle.equations.axes import Axes
from heyoka_bike.bicycle.equations.kinematics import Speeds
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.arithmetic import Number
from heyoka_bike.numbers.dual import Dual, Duals
from heyoka_bike.numbers.vectors import (
    Vector,
    cross,
    from_turned_y,
    from_turned_z,
    minus,
    plus,
    scaled,
)
from heyoka_bike.scoring.diagnosis.programs.applied import powers

FRAMES_GYROSCOPIC = "frames_gyroscopic"
WHEELS_GYROSCOPIC = "wheels_gyroscopic"
WHEELS_WEIGHT = "wheels_weight"
TENSORS_TURNING = "tensors_turning"
TERMS = (FRAMES_GYROSCOPIC, WHEELS_GYROSCOPIC, WHEELS_WEIGHT, TENSORS_TURNING)
"""What can be left out: w x I w of the frames or of the wheels, the weight of the wheels, and that
the tensors of the frames turn with them."""

_INDEPENDENT = range(3)


def rates_altered(
    equations: Equations, state: Sequence[Number], amounts: Mapping[str, Number]
) -> list[Number]:
    """Time derivatives of the regular form's state, the yaw included.

    Parameters
    ----------
    equations
        Of the regular form, in any number type.
    state
        Its variables, with the yaw.
    amounts
        Of each of `TERMS`, 1 where it is left out and 0 where it is not; of each of
        `applied.FORCES`, its coefficient [SI].
    """
    units = _units(state)
    rates = equations.rates_with_yaw(state)
    o, u = equations.unfold(state)
    axes = Axes.of(equations.b, o)
    now = _turning(equations, u)
    # How these change with the angles alone.
    biases = _slopes(_turning(*_moving(equations, state, rates)))
    by_speed = [_turning(equations, equations.unfold(unit)[1]) for unit in units]
    mass = _mass(equations, units)
    force = [
        x + y
        for x, y in zip(
            _lifting(equations, state, units, amounts[WHEELS_WEIGHT]),
            powers(equations, state, units, mass, amounts),
            strict=True,
        )
    ]
    lost: list[list[Number]] = [[0.0] * 3 for _ in _INDEPENDENT]
    for body, w in now.items():
        is_wheel, half = body in "RF", equations.b.rear if body in "BR" else equations.b.front
        own = half.wheel_inertia_times if is_wheel else half.inertia_times
        is_missing = amounts[WHEELS_GYROSCOPIC if is_wheel else FRAMES_GYROSCOPIC]
        torque = scaled(is_missing, cross(w, own(w)))
        columns = [found[body] for found in by_speed]
        if not is_wheel:
            surplus = _surplus(equations, axes, state[6], body, own, amounts[TENSORS_TURNING])
            torque = _sum((torque, surplus(biases[body]), cross(w, surplus(w))))
            for k in _INDEPENDENT:
                along = surplus(columns[k])
                for i in _INDEPENDENT:
                    lost[i][k] = lost[i][k] + _dot(columns[i], along)
        force = [f + _dot(column, torque) for f, column in zip(force, columns, strict=True)]
    right = rates[3:6]
    kept = [[mass[i][k] - lost[i][k] for k in _INDEPENDENT] for i in _INDEPENDENT]
    change = _solved(kept, [f + _dot(row, right) for f, row in zip(force, lost, strict=True)])
    return [*rates[:3], *(x + y for x, y in zip(right, change, strict=True)), rates[6]]


def rates_by_force(
    equations: Equations, state: Sequence[Number], amounts: Mapping[str, Number]
) -> list[Number]:
    """What forces add to the rates of the independent speeds; see `rates_altered`."""
    units = _units(state)
    mass = _mass(equations, units)
    return _solved(mass, powers(equations, state, units, mass, amounts))


def _units(state: Sequence[Number]) -> list[list[Number]]:
    """The posture of a state with one of the independent speeds 1 and the others 0."""
    still = 0.0 * state[0]
    return [
        [*state[:3], *(still + float(i == j) for j in _INDEPENDENT), state[6]] for i in _INDEPENDENT
    ]


def _turning(equations: Equations, u: Speeds) -> dict[str, Vector]:
    """Angular velocities of the bodies, each in the axes of the frame that it is in."""
    k, b = equations.k, equations.b
    found: dict[str, Vector] = {}
    for frame, wheel, (w1, q, w3), spin in (
        ("B", "R", (u.w1, u.q, u.w3), u.v / k.rear.r),
        ("H", "F", (u.w1_f, u.q_f, u.w3_f), u.v_f / k.front.r),
    ):
        x, _, z = from_turned_y(b.sin_tilt, b.cos_tilt, (w1, 0.0, w3))
        found |= {frame: (x, q, z), wheel: (x, -spin, z)}
    return found


def _moving(
    equations: Equations, state: Sequence[Number], rates: Sequence[Number]
) -> tuple[Equations, Speeds]:
    """Speeds in a posture, with their derivatives as its angles turn at these rates."""
    dual = equations.over(Duals(equations.a))
    angles = [Dual(q, (rate,)) for q, rate in zip(state[:3], rates[:3], strict=True)]
    return dual, dual.unfold([*angles, *state[3:]])[1]


def _slopes(turning: Mapping[str, Vector]) -> dict[str, Vector]:
    return {body: (_slope(w[0]), _slope(w[1]), _slope(w[2])) for body, w in turning.items()}


def _slope(x: Number) -> Number:
    return x.slopes[0] if isinstance(x, Dual) else 0.0


def _surplus(
    equations: Equations, axes: Axes, yaw: Number, body: str, own: Callable[[Vector], Vector],
    missing: Number,
) -> Callable[[Vector], Vector]:  # fmt: skip
    """The tensor that turns with the body, less that which stays as it is at the start."""
    s, c = equations.a.sin(yaw), equations.a.cos(yaw)
    out, back = (axes.from_rear, axes.to_rear) if body == "B" else (axes.from_front, axes.to_front)

    def apply(w: Vector) -> Vector:
        stays = own(from_turned_z(s, c, out(w)))
        return scaled(missing, minus(own(w), back(from_turned_z(-s, c, stays))))

    return apply


def _lifting(
    equations: Equations, state: Sequence[Number], units: Sequence[Sequence[Number]],
    missing: Number,
) -> list[Number]:  # fmt: skip
    """By how much the potential energy of the wheels grows at unit speeds [W]."""
    b = equations.b
    rear, front = (half.wheel_m * half.wheel_r for half in (b.rear, b.front))
    found = []
    for unit in units:
        dual = equations.over(Duals(equations.a))
        rates = equations.rates(unit)[:3]
        angles = [Dual(q, (rate,)) for q, rate in zip(state[:3], rates, strict=True)]
        o = dual.unfold([*angles, *state[3:]])[0]
        found.append(_slope(missing * b.g * o.cos_roll * (rear + front * o.kappa)))
    return found


def _mass(equations: Equations, units: Sequence[Sequence[Number]]) -> list[list[Number]]:
    """The mass matrix, from the kinetic energies of unit speeds and of their sums [kg m^2]."""

    def kinetic(speeds: Sequence[Number]) -> Number:
        return equations.energies(speeds).kinetic

    alone = [kinetic(unit) for unit in units]
    angles, yaw = units[0][:3], units[0][6]
    mass: list[list[Number]] = [[2.0 * alone[i]] * 3 for i in _INDEPENDENT]
    for i in _INDEPENDENT:
        for k in range(i):
            both = [float(m in (i, k)) for m in _INDEPENDENT]
            mass[i][k] = mass[k][i] = kinetic([*angles, *both, yaw]) - alone[i] - alone[k]
    return mass


def _solved(m: Sequence[Sequence[Number]], right: Sequence[Number]) -> list[Number]:
    """Of three linear equations, by Cramer's rule."""
    rows: list[Vector] = [(row[0], row[1], row[2]) for row in m]
    across = [cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])]
    determinant = _dot(rows[0], across[0])
    return [
        sum(x * a[i] for x, a in zip(right, across, strict=True)) / determinant
        for i in _INDEPENDENT
    ]


def _dot(u: Sequence[Number], v: Sequence[Number]) -> Number:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def _sum(vectors: Iterable[Vector]) -> Vector:
    return reduce(plus, vectors)

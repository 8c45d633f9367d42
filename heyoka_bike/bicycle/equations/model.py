"""The equations of motion of the four-body bicycle, reduced to six first-order equations.

This is the Carvallo-Whipple bicycle of Meijaard, Papadopoulos, Ruina and Schwab (2007),
doi:10.1098/rspa.2007.1857, without linearisation. State, frames and symbols: see `kinematics`.

The method is Kane's. The accelerations and the angular momentum of each assembly are written in its
own speeds (w1, q, w3, v). Velocity and acceleration of the joint give the dependent speeds and
their rates. Squares are completed in the front's speeds so that their mass matrix is diagonal; what
remains is a sum of weighted squares of rows, a 3 by 3 system, solved by LDL^T. The cost of a Taylor
step is the number of products times the square of the order, so this form has few products.

Two choices of independent speeds give the same motion. `few_products` has (spin, w1, w3) and
divides by the mechanical trail; `regular` has (spin, roll rate, steer rate), is regular where the
trail crosses zero, and costs more.
"""

from collections import namedtuple
from collections.abc import Callable, Sequence

from heyoka_bike.bicycle.equations.constants import Assembly, Constants
from heyoka_bike.bicycle.equations.kinematics import (
    MatrixRow,
    Posture,
    Speeds,
    lateral_condition,
    turn_divisor,
    turn_row,
    unfold,
)
from heyoka_bike.numbers.arithmetic import Arithmetic, Number


def few_products(k: Constants, a: Arithmetic, state: Sequence[Number]) -> list[Number]:
    """Return the time derivatives of (roll, pitch, steer, w1, w3, spin).

    Singular where the mechanical trail is zero; see `regular`.
    """
    return few_product_rates(k, a, *unfold(k, a, state, is_regular=False))


def few_product_rates(k: Constants, a: Arithmetic, o: Posture, u: Speeds) -> list[Number]:
    """Return the rates of the few-product form, from the posture and the speeds of a state."""
    rates = _dependent_rates(k, a, o, u)
    w3_f = (rates.lateral - o.g1 * rates.w1_f) / o.trail
    w1_f_row = (o.s * o.q[0], o.c + o.s * o.q[1], o.s * o.q[2])
    w3_f_row = _row(lambda i: (o.y_f[i] - o.g1 * w1_f_row[i]) / o.trail)
    basis = _Basis(w1=(0, 1, 0), w3=(0, 0, 1), w3_f=w3_f_row, w1_rate=0, w3_rate=0, w3_f_rate=w3_f)
    v_rate, w1_rate, w3_rate = _accelerations(k, a, o, u, rates, basis)
    return [u.p, u.q - u.nu, u.steer_rate, w1_rate, w3_rate, v_rate / k.rear.r]


def regular(k: Constants, a: Arithmetic, state: Sequence[Number]) -> list[Number]:
    """Return the time derivatives of (roll, pitch, steer, roll_rate, steer_rate, spin)."""
    return regular_rates(k, a, *unfold(k, a, state, is_regular=True), state[3])


def regular_rates(
    k: Constants, a: Arithmetic, o: Posture, u: Speeds, roll_rate: Number
) -> list[Number]:
    """Return the rates of the regular form from posture, speeds and roll rate of a state."""
    rates = _dependent_rates(k, a, o, u)
    # w1 = cos(beta) p - sin(beta) n and w3 = sin(beta) p + cos(beta) n. Even if v, p and steer_rate
    # are constant, w1 and w3 change: the frame turns, and n changes to satisfy (C2).
    beta_rate = u.q - u.nu
    turn1, turn3 = -(beta_rate * u.w3), beta_rate * u.w1
    _, c1, c3 = lateral_condition(o)
    divisor, n_row = turn_divisor(o), turn_row(o)
    n_rate = -(c1 * turn1 + c3 * turn3 + rates.lateral - o.g1 * rates.w1_f) / divisor
    w1_rate, w3_rate = turn1 - o.sb * n_rate, turn3 + o.cb * n_rate
    w1_row = (-(o.sb * n_row[0]), o.cb - o.sb * n_row[1], -(o.sb * n_row[2]))
    w3_row = (o.cb * n_row[0], o.sb + o.cb * n_row[1], o.cb * n_row[2])
    basis = _Basis(
        w1=w1_row, w3=w3_row, w3_f=(w3_row[0], w3_row[1], w3_row[2] + 1),
        w1_rate=w1_rate, w3_rate=w3_rate, w3_f_rate=w3_rate,
    )  # fmt: skip
    v_rate, roll_acc, steer_acc = _accelerations(k, a, o, u, rates, basis)
    return [roll_rate, beta_rate, u.steer_rate, roll_acc, steer_acc, v_rate / k.rear.r]


class _Basis(namedtuple("_Basis", "w1 w3 w3_f w1_rate w3_rate w3_f_rate")):
    """Coefficients of w1, w3, w3_f by independent speed, and their rates at constant speeds.

    v is independent in both forms: its row is (1, 0, 0) and its rate zero.
    """

    __slots__ = ()


class _DependentRates(namedtuple("_DependentRates", "q w1_f q_f v_f lateral")):
    """Rates of the dependent speeds when (v, w1, w3) are constant.

    ``lateral`` is the difference of the joint's accelerations, computed from the rear and from the
    front, along e2 of the front.
    """

    __slots__ = ()


def _dependent_rates(k: Constants, a: Arithmetic, o: Posture, u: Speeds) -> _DependentRates:
    """Differentiate the joint conditions (C1) to (C3), as accelerations of one point."""
    pull, pull_f = u.v * u.nu, u.v_f * u.nu_f
    q2, q2_f = u.q * u.q, u.q_f * u.q_f
    a1 = a.sum([pull * o.sb, -k.d1 * q2, -(u.w3 * u.y)])
    a2 = u.n * (u.v + k.rear.r * (u.q - u.nu)) + k.d1 * (u.q * u.w1)
    a3 = u.w1 * u.y - pull * o.cb
    a1_f = a.sum([pull_f * o.sb_f, k.d3 * q2_f, -(u.w3_f * u.y_f)])
    a2_f = u.n_f * (u.v_f + k.front.r * (u.q_f - u.nu_f)) - u.q_f * (k.d2 * u.w3_f + k.d3 * u.w1_f)
    a3_f = a.sum([k.d2 * q2_f, u.w1_f * u.y_f, -(pull_f * o.cb_f)])
    along = a.sum([o.c * a1, o.s * a2, -a1_f])
    turn = u.steer_rate * u.w1_f
    q = a.sum([o.cb * (a3 - a3_f), -(o.y * along), o.e * turn]) / o.den
    q_f = o.c * q - turn
    return _DependentRates(
        q=q,
        w1_f=o.s * q + u.steer_rate * u.q_f,
        q_f=q_f,
        v_f=(along + k.d2 * q_f) / o.cb_f,
        lateral=a.sum([o.c * a2, -(o.s * a1), -a2_f]),
    )


class _Loads(namedtuple("_Loads", "side q v w1 w3")):
    """Generalised forces on one assembly at constant speeds, including gravity."""

    __slots__ = ()


def _loads(
    a: Arithmetic, b: Assembly, g: Number, ahead: Number, side_speed: Number, sin_lean: Number,
    cos_lean: Number, w1: Number, q: Number, w3: Number, v: Number, n: Number, nu: Number,
) -> _Loads:  # fmt: skip
    """Return the inertia forces of one assembly at constant speeds, minus its weight.

    `ahead` is the mass times the distance of the centre of mass ahead of the hub, `side_speed` the
    velocity of the centre of mass along the axle.
    """
    along = b.l3 * w3 + b.l1 * w1
    h1 = b.i11 * w1 + b.i13 * w3
    h2 = b.i22 * q - b.spin * v
    h3 = b.i13 * w1 + b.i33 * w3
    push = b.m * side_speed
    return _Loads(
        side=b.m * a.sum([n * (v + b.r * (q - nu)), q * along, -g * sin_lean]),
        q=a.sum([ahead * (v * nu + g * cos_lean), -(push * along), w3 * h1, -(w1 * h3)]),
        v=-(ahead * (q * q) + push * n),
        w1=q * h3 - w3 * h2,
        w3=w1 * h2 - q * h1,
    )


def _accelerations(
    k: Constants, a: Arithmetic, o: Posture, u: Speeds, rates: _DependentRates, basis: _Basis
) -> tuple[Number, Number, Number]:
    """Solve Kane's equations for the accelerations: rates of the three independent speeds.

    In the few-product form the basis is the identity; its products with 0 and 1 vanish when the
    expressions are built.
    """
    rear, front = k.rear, k.front
    w1, w3, w3_f = basis.w1, basis.w3, basis.w3_f

    def dependent(row: MatrixRow) -> MatrixRow:
        return _row(lambda i: row[0] * (1 if i == 0 else 0) + row[1] * w1[i] + row[2] * w3[i])

    def extra(row: MatrixRow) -> Number:
        return row[1] * basis.w1_rate + row[2] * basis.w3_rate

    # Each of these rows contains the coefficients of a dependent speed in terms of the independent
    # speeds.
    q, x_f, y_f = dependent(o.q), dependent(o.x_f), dependent(o.y_f)
    w1_f = _row(lambda i: o.c * w1[i] + o.s * q[i])
    q_f = _row(lambda i: o.c * q[i] - o.s * w1[i])
    v_f = _row(lambda i: (x_f[i] + k.d2 * q_f[i]) / o.cb_f)
    height_f = front.m * (front.l3 * o.cb_f - front.l1 * o.sb_f)
    shift = height_f / front.mass_v
    side = _row(lambda i: a.sum([y_f[i], k.lever3 * w3_f[i], -k.lever1 * w1_f[i]]))
    zeta = _row(lambda i: w3_f[i] + front.skew * w1_f[i])
    eta = _row(lambda i: v_f[i] + shift * q_f[i])
    # Masses that multiply w1_f^2 and q_f^2 after the squares of side, zeta and eta are separated.
    # Since w1_f^2 + q_f^2 = w1^2 + q^2, the common part `shared` of both masses is counted at the
    # rear speeds w1 and q.
    shared = front.rest
    q_f_mass = (front.mass_q - shared) - shift * height_f

    # Time derivatives of the dependent speeds if the independent speeds are constant.
    q_extra = extra(o.q)
    q_rate = rates.q + q_extra
    w1_f_rate = a.sum([rates.w1_f, o.c * basis.w1_rate, o.s * q_extra])
    q_f_extra = o.c * q_extra - o.s * basis.w1_rate
    q_f_rate = rates.q_f + q_f_extra
    v_f_rate = rates.v_f + (extra(o.x_f) + k.d2 * q_f_extra) / o.cb_f
    y_f_rate = rates.lateral + extra(o.y_f)

    # Forces on the rear assembly, then on the front assembly.
    height = rear.m * (rear.l3 * o.cb - rear.l1 * o.sb)
    ahead = rear.m * (rear.l1 * o.cb + rear.l3 * o.sb)
    arm1, arm3 = rear.r * o.cb - rear.l3, rear.r * o.sb + rear.l1
    side_speed = a.sum([rear.r * u.p, rear.l1 * u.w3, -rear.l3 * u.w1])
    f = _loads(
        a, rear, k.g, ahead, side_speed, o.sin_roll, o.cos_roll,
        u.w1, u.q, u.w3, u.v, u.n, u.nu,
    )  # fmt: skip
    ahead_f = front.m * (front.l1 * o.cb_f + front.l3 * o.sb_f)
    side_speed_f = a.sum([u.y_f, k.lever3 * u.w3_f, -k.lever1 * u.w1_f])
    f_f = _loads(
        a, front, k.g, ahead_f, side_speed_f, o.cos_roll * o.tau, o.cos_roll * o.kappa,
        u.w1_f, u.q_f, u.w3_f, u.v_f, u.n_f, u.nu_f,
    )  # fmt: skip
    on_side = a.sum(
        [
            f_f.side,
            front.m * y_f_rate,
            front.m * k.lever3 * basis.w3_f_rate,
            -(front.m * k.lever1 * w1_f_rate),
        ]
    )
    on_zeta = a.sum([f_f.w3, front.i33 * basis.w3_f_rate, front.i13 * w1_f_rate])
    on_eta = a.sum([f_f.v, front.mass_v * v_f_rate, height_f * q_f_rate])
    on_w1_f = a.sum([f_f.w1, -front.skew * f_f.w3, shared * w1_f_rate])
    on_q_f = a.sum([f_f.q, -(shift * f_f.v), (q_f_mass + shared) * q_f_rate])

    # Mass coefficients of w1 and w3, and the total forces on v, w1, w3 and q.
    m11 = rear.m * (arm1 * arm1) + rear.i11
    m13 = rear.m * (arm1 * arm3) + rear.i13
    m33 = rear.m * (arm3 * arm3) + rear.i33
    own1 = m11 * basis.w1_rate + m13 * basis.w3_rate
    own3 = m13 * basis.w1_rate + m33 * basis.w3_rate
    on_v = f.v + height * q_rate
    on_w1 = a.sum([f.w1, arm1 * f.side, o.c * on_w1_f, -(o.s * on_q_f), own1])
    on_w3 = a.sum([f.w3, arm3 * f.side, own3])
    on_q = a.sum([f.q, o.s * on_w1_f, o.c * on_q_f, rear.mass_q * q_rate])

    force = _row(
        lambda i: a.sum(
            [
                on_v if i == 0 else 0 * k.g, w1[i] * on_w1, w3[i] * on_w3, q[i] * on_q,
                side[i] * on_side, zeta[i] * on_zeta, eta[i] * on_eta,
            ]
        )
    )  # fmt: skip
    squares = [
        (x, _scaled(weight, x))
        for weight, x in (
            (front.m, side), (front.i33, zeta), (front.mass_v, eta),
            (rear.mass_q + shared, q), (q_f_mass, q_f),
        )
    ]  # fmt: skip

    def mass(i: int, j: int) -> Number:
        terms = [
            (m11 + shared) * w1[i] * w1[j],
            m13 * (w1[i] * w3[j] + w3[i] * w1[j]),
            m33 * w3[i] * w3[j],
            *(x[i] * weighted[j] for x, weighted in squares),
        ]
        if i == 0:
            terms.append(height * q[j] if j else rear.mass_v + 2 * (height * q[0]))
        return a.sum(terms)

    return _solve(a, mass, force)


def _row(entry: Callable[[int], Number]) -> MatrixRow:
    return entry(0), entry(1), entry(2)


def _scaled(weight: Number, row: MatrixRow) -> MatrixRow:
    return weight * row[0], weight * row[1], weight * row[2]


def _solve(a: Arithmetic, m: Callable[[int, int], Number], force: MatrixRow) -> MatrixRow:
    """Solve ``m x + force = 0`` for x by LDL^T; m is symmetric and positive definite."""
    m00, m01, m02 = m(0, 0), m(0, 1), m(0, 2)
    l10, l20 = m01 / m00, m02 / m00
    d1 = m(1, 1) - l10 * m01
    m12 = m(1, 2) - l10 * m02
    l21 = m12 / d1
    d2 = a.sum([m(2, 2), -(l20 * m02), -(l21 * m12)])
    z0 = force[0]
    z1 = force[1] - l10 * z0
    z2 = a.sum([force[2], -(l20 * z0), -(l21 * z1)])
    x2 = -(z2 / d2)
    x1 = -(z1 / d1 + l21 * x2)
    x0 = -a.sum([z0 / m00, l10 * x1, l20 * x2])
    return x0, x1, x2

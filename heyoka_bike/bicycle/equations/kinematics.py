"""Angles and speeds of the bicycle, which follow from three independent speeds.

Frames. The *roll frame* of an assembly has x along the heading of its wheel (where the wheel plane
meets the floor), y along its axle, z = x cross y. The assembly frame e is the roll frame turned
about the axle by ``beta``, the angle of the steer axis from the roll frame's z axis, so that e3
lies down the steer axis and e2 along the axle. Quantities of the front assembly end in ``_f``; its
frame is e turned by the steer angle about e3.

State [rad, rad/s], autonomous:

====== ==================================================================================
roll   lean of the rear wheel plane from the vertical, right positive
pitch  rotation of the rear frame about the axle, zero upright; beta = pitch + tilt
steer  steer angle, right positive
w1     angular velocity of the rear frame along e1 (in its plane, across the steer axis)
w3     angular velocity of the rear frame along e3 (down the steer axis)
spin   speed of the rear hub along the heading over the rear wheel radius; this is not the
       wheel's rate relative to the frame, it is minus its absolute rate about the axle
====== ==================================================================================

A knife-edge wheel of radius r that rolls gives its hub the velocity (v, r p, 0) in the roll frame,
where p is the roll rate. The two assemblies share the velocity of the *joint*, the point of the
steer axis nearest to the rear hub:

- (C1) ``c x + s y = v_f cos(beta_f) - d2 q_f``
- (C2) ``c y - s x = g1 w1_f + trail w3_f``
- (C3) ``v sin(beta) - d1 q = v_f sin(beta_f) + d3 q_f``

with s, c the sine and cosine of steer, ``x = v cos(beta)``, ``y = r p + d1 w3``. Eliminating v_f
from (C1) and (C3) gives the rate q of the rear frame about its axle.
"""

from collections import namedtuple
from collections.abc import Sequence

from heyoka_bike.bicycle.equations.constants import Constants
from heyoka_bike.numbers.arithmetic import Arithmetic, Number

MatrixRow = tuple[Number, Number, Number]
"""Coefficients of a dependent speed with respect to the three independent speeds."""


class Posture(
    namedtuple(
        "Posture",
        "sin_roll cos_roll t sb cb s c kappa y tau sb_f cb_f t_f e den trail g1 q x_f y_f",
    )
):
    """Functions of roll, pitch and steer: sines, cosines, and coefficients of velocities.

    Attributes
    ----------
    sin_roll, cos_roll, t
        Sine, cosine and tangent of the roll.
    sb, cb
        Sine and cosine of beta.
    s, c
        Sine and cosine of the steer.
    kappa
        cos(front lean) / cos(roll), taken from the contact of the front wheel, where it is linear.
    y, tau
        kappa times sin(beta_f), and kappa times tan(front lean).
    sb_f, cb_f, t_f
        Sine and cosine of beta_f, tangent of the front lean.
    e, den
        Coefficients of w1 sin(steer) and of q after v_f is eliminated.
    trail, g1
        Mechanical trail, and its counterpart up the axis.
    q, x_f, y_f
        Rear axle rate, and joint velocity along e1 and e2 of the front, per (v, w1, w3).
    """

    __slots__ = ()


def posture(k: Constants, a: Arithmetic, roll: Number, pitch: Number, steer: Number) -> Posture:
    """Compute sines and cosines of the angles, and the coefficients of velocities."""
    beta = pitch + k.tilt
    sin_roll, cos_roll = a.sin(roll), a.cos(roll)
    sb, cb = a.sin(beta), a.cos(beta)
    s, c = a.sin(steer), a.cos(steer)
    t = sin_roll / cos_roll
    y = c * sb - s * t
    tau = s * sb + c * t
    kappa = a.sum([k.h0, k.h1 * sb, -k.h2 * cb, k.h3 * y])
    sb_f, cb_f = y / kappa, cb / kappa
    e = k.d2 * y + k.d3 * cb
    den = k.d1 * cb + c * e
    h = s / den
    y1, y3 = k.rear.r * cb, k.rear.r * sb + k.d1
    return Posture(
        sin_roll=sin_roll, cos_roll=cos_roll, t=t, sb=sb, cb=cb, s=s, c=c,
        kappa=kappa, y=y, tau=tau, sb_f=sb_f, cb_f=cb_f, t_f=tau / kappa, e=e, den=den,
        trail=k.front.r * sb_f - k.d3, g1=k.front.r * cb_f + k.d2,
        q=(h * (cb * tau), h * (e - y * y1), -(h * (y * y3))),
        x_f=(c * cb, s * y1, s * y3), y_f=(-(s * cb), c * y1, c * y3),
    )  # fmt: skip


class Speeds(namedtuple("Speeds", "v w1 q w3 p n nu y v_f w1_f q_f w3_f n_f nu_f y_f steer_rate")):
    """Velocities of the bicycle [rad/s and rear wheel radii per s].

    Attributes
    ----------
    v
        Hub speed along the heading.
    w1, q, w3
        Angular velocity of the assembly along e1, e2, e3.
    p
        Roll rate.
    n, nu
        Turn rate along z of the roll frame, and yaw rate times sin(lean).
    y
        Velocity of the joint along e2.
    v_f, w1_f, q_f, w3_f, n_f, nu_f, y_f
        The same speeds of the front assembly, in its own frames.
    steer_rate
        Rate of the steer angle.
    """

    __slots__ = ()


def speeds(
    k: Constants, o: Posture, v: Number, w1: Number, w3: Number, steer_rate: Number | None = None
) -> Speeds:
    """Compute all speeds from (v, w1, w3).

    Without `steer_rate`, (C2) gives the front's w3 after a division by the mechanical trail. No
    division by the trail is needed with a `steer_rate` from a state that satisfies (C2).
    """
    p = o.cb * w1 + o.sb * w3
    n = o.cb * w3 - o.sb * w1
    x = v * o.cb
    y = k.rear.r * p + k.d1 * w3
    q = o.q[0] * v + o.q[1] * w1 + o.q[2] * w3
    w1_f = o.c * w1 + o.s * q
    q_f = o.c * q - o.s * w1
    y_f = o.c * y - o.s * x
    if steer_rate is None:
        w3_f = (y_f - o.g1 * w1_f) / o.trail
        steer_rate = w3_f - w3
    else:
        w3_f = w3 + steer_rate
    v_f = (o.c * x + o.s * y + k.d2 * q_f) / o.cb_f
    n_f = o.cb_f * w3_f - o.sb_f * w1_f
    return Speeds(
        v=v, w1=w1, q=q, w3=w3, p=p, n=n, nu=n * o.t, y=y,
        v_f=v_f, w1_f=w1_f, q_f=q_f, w3_f=w3_f, n_f=n_f, nu_f=n_f * o.t_f, y_f=y_f,
        steer_rate=steer_rate,
    )  # fmt: skip


def lateral_condition(o: Posture) -> MatrixRow:
    """Return the row of the joint condition (C2): ``row . (v, w1, w3) = trail steer_rate``."""
    return (
        o.y_f[0] - o.g1 * (o.s * o.q[0]),
        o.y_f[1] - o.g1 * (o.c + o.s * o.q[1]),
        o.y_f[2] - o.g1 * (o.s * o.q[2]) - o.trail,
    )


def turn_divisor(o: Posture) -> Number:
    """Return the divisor in the formula of `turn_row` for the turn rate.

    In the upright, straight position it is the wheel base in rear wheel radii. If it is zero, roll
    and steer rate do not determine the turn rate.
    """
    _, c1, c3 = lateral_condition(o)
    return c3 * o.cb - c1 * o.sb


def turn_row(o: Posture) -> MatrixRow:
    """Return the coefficients of v, roll_rate and steer_rate in the turn rate n."""
    cv, c1, c3 = lateral_condition(o)
    divisor = turn_divisor(o)
    return -cv / divisor, -(c1 * o.cb + c3 * o.sb) / divisor, o.trail / divisor


def rear_rates(
    o: Posture, v: Number, roll_rate: Number, steer_rate: Number
) -> tuple[Number, Number]:
    """Return w1 and w3 from roll and steer rate, by formulas that are regular at zero trail."""
    row = turn_row(o)
    n = row[0] * v + row[1] * roll_rate + row[2] * steer_rate
    return o.cb * roll_rate - o.sb * n, o.sb * roll_rate + o.cb * n


def front_contact_height(
    k: Constants, a: Arithmetic, roll: Number, pitch: Number, steer: Number
) -> Number:
    """Return the height of the front wheel's lowest point [m]; zero for a state of the model.

    It uses the true lean of the front wheel, not the linear relation in the equations.
    """
    o = posture(k, a, roll, pitch, steer)
    hub = o.cos_roll * o.kappa * k.front.r
    sin_lean = o.cos_roll * o.tau
    return k.length * (hub - k.front.r * a.sqrt(1 - sin_lean * sin_lean))


def state_names(regular: bool) -> Sequence[str]:
    """Return the names of the state variables of the few-product or the regular form."""
    rates = ("roll_rate", "steer_rate") if regular else ("w1", "w3")
    return ("roll", "pitch", "steer", *rates, "spin")


def unfold(
    k: Constants, a: Arithmetic, state: Sequence[Number], *, is_regular: bool
) -> tuple[Posture, Speeds]:
    """Return posture and speeds of a state in either form; a seventh entry, the yaw, is ignored."""
    roll, pitch, steer, rate1, rate3, spin = state[:6]
    o = posture(k, a, roll, pitch, steer)
    v = k.rear.r * spin
    if not is_regular:
        return o, speeds(k, o, v, rate1, rate3)
    w1, w3 = rear_rates(o, v, rate1, rate3)
    return o, speeds(k, o, v, w1, w3, rate3)

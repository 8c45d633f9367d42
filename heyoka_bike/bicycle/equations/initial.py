"""From a maneuver to the initial state: the pitch, and the rates that rolling requires."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from math import pi
from typing import TYPE_CHECKING, Any

import flint
import numpy as np

from heyoka_bike.bicycle.equations.constants import Constants
from heyoka_bike.bicycle.equations.kinematics import front_contact_height, posture, rear_rates
from heyoka_bike.bicycle.equations.model import regular
from heyoka_bike.bicycle.parameters import START, Maneuver
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.arithmetic import Arithmetic, Arrays, Number, value_of
from heyoka_bike.numbers.double import ROUNDS_OF_NEWTON, SMALL_STEP
from heyoka_bike.numbers.dual import Dual, Duals

if TYPE_CHECKING:
    from heyoka_bike.bicycle.equations.reduced import Equations

_CONTINUATION_STEPS = 24
# Maximum distance of the front wheel from the floor that counts as contact [m]: about a thousand
# times the roundoff.
_LARGEST_GAP = 1e-12


def initial_state(equations: Equations, maneuver: Maneuver) -> list[flint.arb]:
    """Return the state at t = 0, with the yaw: seven balls, rad and rad/s.

    Parameters
    ----------
    equations : Equations
        Equations over `Balls`; the state is in their form.
    maneuver : Maneuver

    Raises
    ------
    InputError
        No pitch puts both wheels on the floor, or the reduced mass matrix is singular there.
    """
    k, balls = equations.k, equations.a
    with equations.precision():
        start = {key: balls.number(getattr(maneuver, key)) for key in START}
        state = _regular_state(k, balls, start, pitch_at_start(equations, maneuver))
        if not all(x.is_finite() for x in regular(k, balls, state[:6])):
            raise InputError(
                f"{maneuver.name}: the reduced mass matrix is singular at the initial state, "
                "expected inertia that resists roll, steer and rolling"
            )
        return state if equations.is_regular else few_product_state(k, balls, state)


def varied_state(
    k: Constants, a: Duals, start: Mapping[str, Dual], pitch: Number, *, is_regular: bool
) -> list[Number]:
    """Return the state at t = 0 as dual numbers in the parameters and initial values.

    The pitch is passed as a number. Its derivatives with respect to roll, steer and the constants
    follow from the implicit function theorem, because it is a root.
    """
    inner, still = a.inner, (0,) * len(start["roll"].slopes)
    roll, steer = start["roll"], start["steer"]
    height = front_contact_height(k, a, roll, Dual(pitch, still), steer)
    (root,) = Duals(inner).variables([pitch])
    by_pitch = front_contact_height(
        k.convert(value_of), Duals(inner), roll.value, root, steer.value
    ).slopes[0]
    state = _regular_state(k, inner, start, height.chain(pitch, inner.number(-1) / by_pitch))
    state[-1] = Dual(state[-1], still)
    return state if is_regular else few_product_state(k, a, state)


def _regular_state(
    k: Constants, a: Arithmetic, start: Mapping[str, Number], pitch: Number
) -> list[Number]:
    roll, steer, roll_rate, steer_rate, speed = (start[key] for key in START)
    return [roll, pitch, steer, roll_rate, steer_rate, speed / k.length, a.number(0)]


def few_product_state(k: Constants, a: Arithmetic, state: Sequence[Number]) -> list[Number]:
    """Convert a state of the regular form to the variables of the few-product form."""
    roll, pitch, steer, roll_rate, steer_rate, spin, yaw = state
    o = posture(k, a, roll, pitch, steer)
    w1, w3 = rear_rates(o, k.rear.r * spin, roll_rate, steer_rate)
    return [roll, pitch, steer, w1, w3, spin, yaw]


def pitch_at_start(equations: Equations, maneuver: Maneuver) -> Number:
    """Return an enclosure of the pitch that puts the front wheel on the floor.

    With zero steer the frames of front and rear coincide and the pitch is zero at any roll. This
    function follows that root while the steer angle grows.
    """
    k, balls = equations.k, equations.a
    if maneuver.steer.is_zero:
        return balls.number(0)
    unreachable = InputError(
        f"{maneuver.name}: no pitch puts both wheels on the floor at roll "
        f"{float(maneuver.roll):g} rad and steer {float(maneuver.steer):g} rad"
    )
    near = _followed(
        k.convert(lambda x: float(x.mid())), float(maneuver.roll), float(maneuver.steer)
    )
    if near is None:
        raise unreachable
    roll, steer = balls.number(maneuver.roll), balls.number(maneuver.steer)

    def height(pitch: flint.arb) -> Dual:
        """Return the height of the front wheel, with its derivative with respect to the pitch."""
        (x,) = Duals(balls).variables([pitch])
        found: Dual = front_contact_height(k, Duals(balls), roll, x, steer)
        return found

    # A sign change over a tiny interval proves that there is a root.
    centre, radius = _root(height, near), balls.number(Fraction(2) ** (16 - flint.ctx.prec))
    below, above = (height(centre + side * radius).value for side in (-1, 1))
    if not ((below > 0 and above < 0) or (below < 0 and above > 0)):
        raise unreachable
    enclosed = flint.arb(centre, radius)
    # A slope that does not vanish in the interval proves that the root is the only one.
    slope = height(enclosed).slopes[0]
    if not abs(slope) > 0:
        raise unreachable
    return enclosed


def _root(function: Callable[[flint.arb], Dual], near: float) -> flint.arb:
    """Return the root near `near` in flint's precision; each Newton step doubles the digits."""
    x = flint.arb(near)
    for _ in range(flint.ctx.prec.bit_length()):
        there = function(x)
        x = (x - there.value / there.slopes[0]).mid()
    return x


def _followed(k: Constants, roll: float, steer: float) -> float | None:
    """Follow the root from zero steer to `steer` in binary64; None if it ends on the way."""
    pitch = 0.0
    with np.errstate(all="ignore"):
        for step in range(1, _CONTINUATION_STEPS + 1):
            part = steer * step / _CONTINUATION_STEPS
            pitch = float(pitch_on_the_floor(k, roll, pitch, part))
            gap = front_contact_height(k, Arrays(), roll, pitch, part)
            if not (abs(gap) <= _LARGEST_GAP and abs(pitch) <= pi / 2):
                return None
    return pitch


def pitch_on_the_floor(k: Constants, roll: Any, pitch: Any, steer: Any) -> Any:
    """Return the pitch with both wheels on the floor [rad], near the initial guess `pitch`.

    All arguments may be floats or arrays. The pitch is a few hundredths, so a few Newton iterations
    from zero suffice.
    """
    a = Arrays()
    for _ in range(ROUNDS_OF_NEWTON):
        gap = front_contact_height(k, a, roll, pitch, steer)
        slope = front_contact_height(k, a, roll, pitch + SMALL_STEP, steer) - gap
        pitch = pitch - gap * SMALL_STEP / slope
    return pitch

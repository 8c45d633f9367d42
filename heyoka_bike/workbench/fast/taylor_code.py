"""Taylor steps of several motions at once, compiled by heyoka: those of an atlas.

heyoka's step law takes the order from a tolerance, and the step from the two last coefficients x
of the state: it is about e^-2 times the smaller of ``(norm / |x|)^(1 / order)``, where ``norm`` is
the largest variable of the state. To choose both freely, the state is given a constant more, the
norm: the error of a step is about e^(-2 order) of it. Another variable counts the time.

The code is unrolled, and multiplications and additions are contracted (``fast_math``): each is then
rounded once. No sum of the equations depends on the order of its terms.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.arithmetic import Number

STATE = 6
CLOCK, NORM = STATE, STATE + 1
"""Places in the state of the compiled step of the time, over `TICK`, and of the norm."""
TICK = 1024.0
"""A power of two, which keeps the clock exact and small against the norm in long runs."""


@dataclass(frozen=True, slots=True)
class Plan:
    """Order and norm of the Taylor steps; the norm is no less than the speed."""

    order: int
    norm: float


PLANS: Mapping[str | float, Plan] = {1e-10: Plan(15, 28.0), "roundoff": Plan(19, 16.0)}
"""For the largest error of roll and steer angle [rad], their rates [rad/s] and the speed [m/s] over
10 s the fastest plan found that keeps it in the three maneuvers and 20 other starts."""


@dataclass(frozen=True, slots=True)
class Form:
    """What is compiled.

    Attributes
    ----------
    order
        Of the Taylor step, 3 or more.
    lanes
        How many motions are stepped at once, by the processor's vector instructions.
    is_regular
        The form of the equations, see `model`.
    """

    order: int
    lanes: int
    is_regular: bool = False


def taylor_step(hy: Any, equations: Equations, form: Form, ends: Sequence[Number] = ()) -> Any:
    """The integrator of the state with clock and norm, the equations being expressions.

    It stops where one of the expressions `ends` passes zero.
    """
    state = list(hy.make_vars(*equations.states))[:STATE]
    clock, norm = hy.make_vars("clock", "norm")
    system = [
        *zip(state, equations.rates(state), strict=True),
        (clock, hy.expression(1 / TICK)),
        (norm, hy.expression(0.0)),
    ]
    start = [[1.0] * form.lanes for _ in system]
    return hy.taylor_adaptive_batch(
        system,
        start,
        # heyoka takes ceil(1 - log(tol) / 2) as the order.
        tol=math.exp(-2 * (form.order - 1.5)),
        compact_mode=False,
        fast_math=True,
        t_events=[hy.t_event_batch(x) for x in ends],
    )

"""Compiled code of the fast runs: a Taylor step, and the columns from the polynomials of the steps.

heyoka's step law takes the order from a tolerance, and the step from the two last coefficients x
of the state: it is about e^-2 times the smaller of ``(norm / |x|)^(1 / order)``, where ``norm`` is
the largest variable of the state. To choose both freely, the state is given a constant more, the
norm: the error of a step is about e^(-2 order) of it. Another variable counts the time, so that the
coefficients of a step, kept by a callback, say when the step began.

The code is unrolled, and multiplications and additions are contracted (``fast_math``): each is then
rounded once. No sum of the equations depends on the order of its terms.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from threading import Lock
from typing import Any

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.motion.expressions import Expressions, require_heyoka
from heyoka_bike.numbers.arithmetic import Number

STATE = 6
CLOCK, NORM = STATE, STATE + 1
"""Places in the state of the compiled step of the time, over `TICK`, and of the norm."""
TICK = 1024.0
"""A power of two, which keeps the clock exact and small against the norm in long runs."""

_VECTORISED_ORDER = 12  # from here on it pays for the compiler to join neighbouring operations


@dataclass(frozen=True, slots=True)
class Plan:
    """Order and norm of the Taylor steps; the norm is no less than the speed."""

    order: int
    norm: float


PLANS: Mapping[str | float, Plan] = {
    "eq1": Plan(6, 16.0),
    1e-4: Plan(8, 100.0),
    1e-6: Plan(10, 50.0),
    1e-8: Plan(12, 28.0),
    1e-10: Plan(15, 28.0),
    1e-12: Plan(17, 16.0),
    1e-13: Plan(19, 16.0),
    "roundoff": Plan(19, 16.0),
}
"""For each accuracy of `simulate` the fastest plan found that keeps it in the three maneuvers and
20 other starts."""


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
    lanes: int = 1
    is_regular: bool = False


@dataclass(frozen=True, slots=True)
class TaylorCode:
    """Compiled code of a form.

    Attributes
    ----------
    form
        Order of the steps, and how many motions go side by side.
    integrator
        heyoka's, of the state with clock and norm; ``taylor_adaptive_batch`` for several lanes.
    columns
        From the coefficients of the six state variables, one variable after the other, and the
        time since the step began: the benchmark's columns, and the mechanical trail over the front
        wheel's radius.
    lock
        To be held while the integrator is used.
    """

    form: Form
    integrator: Any
    columns: Any
    lock: Any


def taylor_code(bicycle: Bicycle, form: Form) -> TaylorCode:
    """Compiled code, which takes from half a second to half a minute the first time.

    heyoka keeps what it compiles on the disk; in a new process it is there after a tenth of a
    second.

    Raises
    ------
    MissingPackageError
        heyoka is not installed.
    """
    hy = require_heyoka()
    exact = Equations.binary64(bicycle, is_regular=form.is_regular)
    equations = exact.convert(hy.expression, Expressions())
    return TaylorCode(form, taylor_step(hy, equations, form), _columns(hy, equations, form), Lock())


def taylor_step(hy: Any, equations: Equations, form: Form, ends: Sequence[Number] = ()) -> Any:
    """The integrator of the state with clock and norm, the equations being expressions.

    Of several lanes it stops where one of the expressions `ends` passes zero.
    """
    state = list(hy.make_vars(*equations.states))[:STATE]
    clock, norm = hy.make_vars("clock", "norm")
    system = [
        *zip(state, equations.rates(state), strict=True),
        (clock, hy.expression(1 / TICK)),
        (norm, hy.expression(0.0)),
    ]
    options = {
        # heyoka takes ceil(1 - log(tol) / 2) as the order.
        "tol": math.exp(-2 * (form.order - 1.5)),
        "compact_mode": False,
        "fast_math": True,
        "slp_vectorize": form.lanes == 1 and form.order >= _VECTORISED_ORDER,
    }
    if form.lanes == 1:
        return hy.taylor_adaptive(system, [1.0] * len(system), **options)
    start = [[1.0] * form.lanes for _ in system]
    events = [hy.t_event_batch(x) for x in ends]
    return hy.taylor_adaptive_batch(system, start, t_events=events, **options)


def _columns(hy: Any, equations: Equations, form: Form) -> Any:
    s = hy.make_vars("s")
    coefficients = [
        [hy.make_vars(f"c{i}_{j}") for j in range(form.order + 1)] for i in range(STATE)
    ]
    state = [_polynomial(c, s) for c in coefficients]
    # The yaw is in none of these columns.
    found = equations.columns([*state, hy.expression(0.0)])
    o, _ = equations.unfold(state)
    results = [*(found[name] for name in BENCHMARK_COLUMNS), o.trail / equations.k.front.r]
    return hy.cfunc(results, [*(x for c in coefficients for x in c), s], fast_math=True)


def _polynomial(coefficients: Sequence[Number], s: Number) -> Number:
    """By Horner's rule."""
    value = coefficients[-1]
    for c in coefficients[-2::-1]:
        value = value * s + c
    return value

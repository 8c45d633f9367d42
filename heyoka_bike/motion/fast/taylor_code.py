"""Compiled code of the fast runs: a Taylor step, and the columns from the polynomials of the steps.

heyoka's step law takes the order from a tolerance, and the step from the two last coefficients x
of the state: it is about e^-2 times the smaller of ``(norm / |x|)^(1 / order)``, where ``norm`` is
the largest variable of the state. To choose both freely, the state is given a constant more, the
norm: the error of a step is about e^(-2 order) of it. Another variable counts the time, so that the
coefficients of a step, kept by a callback, say when the step began.

The code is unrolled, and multiplications and additions are contracted (``fast_math``): each is then
rounded once. No sum of the equations depends on the order of its terms.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from threading import Lock
from typing import Any

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.constants import Constants, constants
from heyoka_bike.bicycle.equations.kinematics import state_names
from heyoka_bike.bicycle.equations.model import few_products, regular
from heyoka_bike.bicycle.equations.outputs import columns, unfold
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.motion.expressions import Expressions, require_heyoka
from heyoka_bike.motion.fast.compiled_cache import cached
from heyoka_bike.numbers.arithmetic import Balls, Number

STATE = 6
CLOCK, NORM = STATE, STATE + 1
"""Places in the state of the compiled step of the time, over `TICK`, and of the norm."""
TICK = 1024.0
"""A power of two, which keeps the clock exact and small against the norm in long runs."""

_BITS = 256  # constants are exact ones, rounded once
_VECTORISED_ORDER = 12  # from here on it pays for the compiler to join neighbouring operations


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
    """Compiled code, from the cache or built, which takes from half a second to half a minute.

    Raises
    ------
    MissingPackageError
        heyoka is not installed.
    """
    description = {
        "kind": "step",
        "bicycle": {symbol: str(value) for symbol, value in bicycle.values.items()},
        "form": [form.order, form.lanes, form.is_regular],
    }
    integrator, outputs = cached(description, lambda: _build(bicycle, form))
    return TaylorCode(form, integrator, outputs, Lock())


def _build(bicycle: Bicycle, form: Form) -> tuple[Any, Any]:
    hy = require_heyoka()
    balls = Balls(_BITS)
    with balls.precision():
        k = constants(bicycle, balls).convert(lambda x: hy.expression(float(x.mid())))
    return _step(hy, k, form), _columns(hy, k, form)


def _step(hy: Any, k: Constants, form: Form) -> Any:
    state = list(hy.make_vars(*state_names(form.is_regular)))
    rates = (regular if form.is_regular else few_products)(k, Expressions(), state)
    clock, norm = hy.make_vars("clock", "norm")
    equations = [
        *zip(state, rates, strict=True),
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
        return hy.taylor_adaptive(equations, [1.0] * len(equations), **options)
    start = [[1.0] * form.lanes for _ in equations]
    return hy.taylor_adaptive_batch(equations, start, **options)


def _columns(hy: Any, k: Constants, form: Form) -> Any:
    s = hy.make_vars("s")
    coefficients = [
        [hy.make_vars(f"c{i}_{j}") for j in range(form.order + 1)] for i in range(STATE)
    ]
    state = [_polynomial(c, s) for c in coefficients]
    a = Expressions()
    o, u = unfold(k, a, state, is_regular=form.is_regular)
    # The yaw is in none of these columns.
    found = columns(k, a, o, u, state[0], state[1], state[2], hy.expression(0.0))
    results = [*(found[name] for name in BENCHMARK_COLUMNS), o.trail / k.front.r]
    return hy.cfunc(results, [*(x for c in coefficients for x in c), s], fast_math=True)


def _polynomial(coefficients: Sequence[Number], s: Number) -> Number:
    """By Horner's rule."""
    value = coefficients[-1]
    for c in coefficients[-2::-1]:
        value = value * s + c
    return value

"""Many motions as code: eight at once, each with its own explicit steps.

Dormand, Prince and Hairer's method of order 8 with its two estimates of the error, of orders 5 and
3, as in dop853.f of E. Hairer, S. P. Norsett and G. Wanner, Solving Ordinary Differential Equations
I, 2nd edition, Springer 1993. A vector is full of motions here, and a step of a motion costs twelve
eighths of an evaluation of the equations; those that got to their end wait for the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.workbench.fast import vector_code as v
from heyoka_bike.workbench.fast.dormand_prince import FIFTH, STAGES, STEP, THIRD, Row
from heyoka_bike.workbench.fast.model_code import ENERGY, call_rates, columns_and_trail, rates_code

ENDS = "ends"
"""Name of the function, see `ends_source`."""

_LAST = len(STAGES)  # the evaluation at the end of a step
_SAFETY, _LEAST, _MOST = 0.9, 1 / 3, 6.0  # of a change of the step
_SHORTEST = 2.0**-30  # [s]
_FIRST = 0.1  # [s], of the tolerance's root: the first step
# Of the energy: ten times what is usual at a tolerance, and at the least ones.
_DRIFT, _ROUNDING = 100.0, 1e-11
_NAN = float("nan")


def ends_source(equations: Equations) -> str:
    """The module of function ``ends``, for equations with constants in binary64.

    ``void ends(states, stride, begin, end, duration, tolerance, most, columns)`` carries out the
    motions ``begin`` to ``end``, whole vectors of them. ``states`` and ``columns`` hold ``stride``
    motions, one variable after the other. A motion that cannot be continued, or takes more than
    ``most`` steps, is NaN.
    """
    c = v.Code(f"void @{ENDS}(ptr, i64, i64, i64, double, double, i64, ptr)")
    states, stride, begin, end, duration, tolerance, most, columns = c.arguments
    y, after, stage, lost = (c.memory() for _ in range(4))
    k = [c.memory() for _ in range(_LAST + 1)]
    over, until = (1.0 / tolerance).spread(), duration.spread()
    first = (v.eighth_root(tolerance) * _FIRST).spread()
    group = c.variable(begin)
    with v.Loop(c) as groups:
        groups.leave(group[0] >= end)
        places = [stride * i + group[0] for i in range(len(BENCHMARK_COLUMNS))]
        y.store(states.vectors(x)[0] for x in places[: v.STATE])
        lost.store([0.0] * v.STATE)
        call_rates(y, k[0])
        energy = columns_and_trail(equations, y.load())[ENERGY]
        t, wish, steps = c.variable(c.vector([0.0] * v.POINTS)), c.variable(first), c.variable(0)
        with v.Loop(c) as run:
            run.leave((t[0].over_places("fmin") >= duration) | (steps[0] >= most))
            now, is_ended = t[0], t[0] >= until
            # The step is what the clock goes on by; none where the end is reached.
            to = (wish[0] >= until - now).choose(until, now + wish[0])
            h = to - now
            for number, row in enumerate(STAGES, start=1):
                stage.store(v.fused(h, _slopes(k, row), y.load()))
                call_rates(stage, k[number])
            before, x = y.load(), v.fused(h, _slopes(k, STEP), lost.load())
            after.store(before + x)
            # The rounding error is added with the next step.
            rests = x - (after.load() - before)
            fifth, third = (_square(_slopes(k, row) * over) for row in (FIFTH, THIRD))
            both = v.fused(third, 0.01, fifth).at_least(1e-300)
            error = h * fifth * v.STATE**-0.5 / both.sqrt()
            is_good = error <= 1.0
            change = (_SAFETY / v.eighth_root(error)).at_most(_MOST).at_least(_LEAST)
            # Of what is no number the least change is made.
            scaled = h * (error <= error).choose(change, _LEAST)
            call_rates(after, k[_LAST])
            is_lost = ~is_good & (scaled < _SHORTEST) & ~is_ended
            new = v.choose(is_good, after.load(), before)
            y.store(v.choose(is_lost, _NAN, new))
            lost.store(v.choose(is_good, rests, lost.load()))
            k[0].store(v.choose(is_good, k[_LAST].load(), k[0].load()))
            t[0] = is_lost.choose(until, is_good.choose(to, now))
            # Motions that wait keep a step that is no zero.
            wish[0] = is_ended.choose(first, scaled)
            steps[0] += 1
        *found, _ = columns_and_trail(equations, v.choose(t[0] >= until, y.load(), _NAN))
        # A motion that has stepped over a singularity does not keep its energy.
        allowed = energy * (tolerance * _DRIFT).at_least(_ROUNDING)
        is_kept = abs(found[ENERGY] - energy) <= allowed
        for place, value in zip(places, v.choose(is_kept, found, _NAN), strict=True):
            columns.vectors(place)[0] = value
        group[0] += v.POINTS
    c.do("ret void")
    return v.module(rates_code(equations), c)


def _slopes(k: Sequence[v.Memory], row: Row) -> Any:
    """Those of each variable, weighted."""
    return v.weighted([k[stage].load() for stage in row], list(row.values()))


def _square(errors: v.Registers) -> Any:
    """Of the length of a vector of errors."""
    first, *rest = errors
    return reduce(lambda found, x: v.fused(x, x, found), rest, first * first)

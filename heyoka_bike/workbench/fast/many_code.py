"""Source of many motions as LLVM's assembly: eight at once, each with its own explicit steps.

Dormand, Prince and Hairer's method of order 8 with its two estimates of the error, of orders 5 and
3, as in dop853.f of E. Hairer, S. P. Norsett and G. Wanner, Solving Ordinary Differential Equations
I, 2nd edition, Springer 1993. A vector is full of motions here, and a step of a motion costs twelve
eighths of an evaluation of the equations; those that got to their end wait for the others.
"""

from __future__ import annotations

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.motion.dormand_prince import FIFTH, STAGES, STEP, THIRD, Row
from heyoka_bike.workbench.fast.collocation import POINTS
from heyoka_bike.workbench.fast.model_code import STATE, column_values, rates_source
from heyoka_bike.workbench.fast.vector_code import (
    DECLARATIONS,
    ONE,
    WHOLE,
    Code,
    constant,
    function,
    literal,
)

ENDS = "ends"
"""Name of the function, see `ends_source`."""

_CALLS = len(STAGES) + 1
_SAFETY, _LEAST, _MOST = 0.9, 1 / 3, 6.0  # of a change of the step
_SHORTEST = 2.0**-30  # [s]
_FIRST = 0.1  # [s], of the tolerance's root: the first step
# Of the energy: ten times what is usual at a tolerance, and at the least ones.
_DRIFT, _ROUNDING = 100.0, 1e-11
_ENERGY = BENCHMARK_COLUMNS.index("mechanical_energy")
_MASK = f"<{POINTS} x i1>"


def ends_source(equations: Equations) -> str:
    """The module of function ``ends``, for equations with constants in binary64.

    ``void ends(states, stride, begin, end, duration, tolerance, most, columns)`` carries out the
    motions ``begin`` to ``end``, whole vectors of them. ``states`` and ``columns`` hold ``stride``
    motions, one variable after the other. A motion that cannot be continued, or takes more than
    ``most`` steps, is NaN.
    """
    return "\n".join([rates_source(equations), _ends(equations), DECLARATIONS])


def _ends(equations: Equations) -> str:
    c = Code()
    y, end, stage = (c.array(WHOLE, STATE) for _ in range(3))
    k = c.array(WHOLE, STATE * _CALLS)
    rest = c.array(WHOLE, STATE)
    duration = c.spread("%duration")
    over = c.spread(c.operation("/", literal(1.0), "%tolerance", ONE))
    first = c.call("sqrt", ONE, c.call("sqrt", ONE, c.call("sqrt", ONE, "%tolerance")))
    first = c.spread(c.operation("*", first, literal(_FIRST), ONE))
    c.do("br label %group")
    c.label("group")
    c.lines.append("  %g = phi i64 [ %begin, %0 ], [ %g.next, %finish ]")
    for i in range(STATE):
        c.store(c.load(_place(c, "%states", i), 0), y, i)
        c.store(constant(WHOLE, 0.0), rest, i)
    c.do(f"call void @rates(ptr {y}, ptr {k})")
    energy = column_values(c, equations, [c.load(y, i) for i in range(STATE)])[_ENERGY]
    c.do("br label %step")
    c.label("step")
    c.lines += [
        f"  %t = phi {WHOLE} [ {constant(WHOLE, 0.0)}, %group ], [ %t.next, %step ]",
        f"  %wish = phi {WHOLE} [ {first}, %group ], [ %wish.next, %step ]",
        "  %count = phi i64 [ 1, %group ], [ %count.next, %step ]",
    ]
    left = c.operation("-", duration, "%t")
    is_last = c.assign(f"fcmp oge {WHOLE} %wish, {left}")
    to = _select(c, is_last, duration, c.operation("+", "%t", "%wish"))
    # The step is what the clock goes on by; none where the end is reached.
    h = c.operation("-", to, "%t")
    for number, row in enumerate(STAGES, start=1):
        for i in range(STATE):
            c.store(c.fused(h, _combined(c, k, row, i), c.load(y, i)), stage, i)
        c.do(f"call void @rates(ptr {stage}, ptr {c.at(k, STATE * number, WHOLE)})")
    fifth = third = constant(WHOLE, 0.0)
    rests = []
    for i in range(STATE):
        before = c.load(y, i)
        x = c.fused(h, _combined(c, k, STEP, i), c.load(rest, i))
        after = c.operation("+", before, x)
        # What rounding takes is added with the next step.
        rests.append(c.operation("-", x, c.operation("-", after, before)))
        c.store(after, end, i)
        e5 = c.operation("*", _combined(c, k, FIFTH, i), over)
        e3 = c.operation("*", _combined(c, k, THIRD, i), over)
        fifth, third = c.fused(e5, e5, fifth), c.fused(e3, e3, third)
    both = c.fused(third, constant(WHOLE, 0.01), fifth)
    size = c.operation("*", c.operation("*", h, fifth), constant(WHOLE, STATE**-0.5))
    root = c.call("sqrt", WHOLE, c.call("maxnum", WHOLE, both, constant(WHOLE, 1e-300)))
    error = c.operation("/", size, root)
    good = c.assign(f"fcmp ole {WHOLE} {error}, {constant(WHOLE, 1.0)}")
    eighth = error
    for _ in range(3):
        eighth = c.call("sqrt", WHOLE, eighth)
    change = c.operation("/", constant(WHOLE, _SAFETY), eighth)
    # Of what is no number the least change is made.
    change = c.call(
        "maxnum",
        WHOLE,
        c.call("minnum", WHOLE, change, constant(WHOLE, _MOST)),
        constant(WHOLE, _LEAST),
    )
    is_number = c.assign(f"fcmp ord {WHOLE} {error}, {error}")
    change = _select(c, is_number, change, constant(WHOLE, _LEAST))
    scaled = c.operation("*", h, change)
    c.do(f"call void @rates(ptr {end}, ptr {c.at(k, STATE * (_CALLS - 1), WHOLE)})")
    short = c.assign(f"fcmp ogt {WHOLE} {constant(WHOLE, _SHORTEST)}, {scaled}")
    ended = c.assign(f"fcmp oge {WHOLE} %t, {duration}")
    bad = c.assign(f"xor {_MASK} {good}, {_ones()}")
    lost = c.assign(
        f"and {_MASK} {c.assign(f'and {_MASK} {bad}, {short}')}, "
        f"{c.assign(f'xor {_MASK} {ended}, {_ones()}')}"
    )
    for i in range(STATE):
        kept = _select(c, good, c.load(end, i), c.load(y, i))
        c.store(_select(c, lost, constant(WHOLE, float("nan")), kept), y, i)
        c.store(_select(c, good, rests[i], c.load(rest, i)), rest, i)
        slope = c.load(k, STATE * (_CALLS - 1) + i)
        c.store(_select(c, good, slope, c.load(k, i)), k, i)
    reached = _select(c, good, to, "%t")
    c.lines.append(f"  %t.next = select {_MASK} {lost}, {WHOLE} {duration}, {WHOLE} {reached}")
    # Motions that wait keep a step that is no zero.
    c.lines.append(f"  %wish.next = select {_MASK} {ended}, {WHOLE} {first}, {WHOLE} {scaled}")
    c.lines.append("  %count.next = add i64 %count, 1")
    least = c.assign(f"call double @llvm.vector.reduce.fmin.v{POINTS}f64({WHOLE} %t.next)")
    under_way = c.assign(f"fcmp ogt double %duration, {least}")
    few = c.assign("icmp slt i64 %count, %most")
    again = c.assign(f"and i1 {under_way}, {few}")
    c.do(f"br i1 {again}, label %step, label %finish")
    c.label("finish")
    ended = c.assign(f"fcmp oge {WHOLE} %t.next, {duration}")
    values = [_select(c, ended, c.load(y, i), constant(WHOLE, float("nan"))) for i in range(STATE)]
    found = column_values(c, equations, values)
    # A motion that has stepped over a singularity does not keep its energy.
    drift = c.call("fabs", WHOLE, c.operation("-", found[_ENERGY], energy))
    allowed = c.operation("*", "%tolerance", literal(_DRIFT), ONE)
    allowed = c.spread(c.call("maxnum", ONE, allowed, literal(_ROUNDING)))
    kept = c.assign(f"fcmp ole {WHOLE} {drift}, {c.operation('*', energy, allowed)}")
    for i in range(len(BENCHMARK_COLUMNS)):
        value = _select(c, kept, found[i], constant(WHOLE, float("nan")))
        c.store(value, _place(c, "%columns", i))
    c.lines.append(f"  %g.next = add i64 %g, {POINTS}")
    going = c.assign("icmp slt i64 %g.next, %end")
    c.do(f"br i1 {going}, label %group, label %out")
    c.label("out")
    c.do("ret void")
    head = (
        f"void @{ENDS}(ptr noalias %states, i64 %stride, i64 %begin, i64 %end, double %duration, "
        "double %tolerance, i64 %most, ptr noalias %columns)"
    )
    return function(head, c.lines)


def _place(c: Code, array: str, i: int) -> str:
    """Address of eight motions' variable in an array of all motions."""
    first = c.assign(f"mul i64 %stride, {i}")
    return c.at(array, c.assign(f"add i64 {first}, %g"), ONE)


def _combined(c: Code, k: str, row: Row, i: int) -> str:
    """Slopes of a variable, weighted: two sums, which do not wait for each other."""
    found = ["", ""]
    for j, (stage, weight) in enumerate(row.items()):
        x, factor, half = c.load(k, STATE * stage + i), constant(WHOLE, weight), found[j % 2]
        found[j % 2] = c.fused(x, factor, half) if half else c.operation("*", x, factor)
    return c.operation("+", *found) if found[1] else found[0]


def _select(c: Code, mask: str, x: str, y: str) -> str:
    return c.assign(f"select {_MASK} {mask}, {WHOLE} {x}, {WHOLE} {y}")


def _ones() -> str:
    return "<" + ", ".join(["i1 true"] * POINTS) + ">"

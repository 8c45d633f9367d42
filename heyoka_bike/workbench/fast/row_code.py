"""Source of rows as LLVM's assembly: eight rows at once, from the series of their step."""

from __future__ import annotations

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.workbench.fast.collocation import POINTS
from heyoka_bike.workbench.fast.model_code import STATE, column_values
from heyoka_bike.workbench.fast.vector_code import ONE, WHOLE, Code, constant, function

_BETTER = "minnum", "maxnum"


def rows_source(equations: Equations) -> str:
    """Function ``rows(...)``: the rows `begin` to `end` from the series of a step."""
    c = Code()
    # Least and largest of mechanical trail and energy.
    extremes = c.array(WHOLE, 4)
    for i in range(4):
        c.store(c.spread(c.load("%report", i + 1, ONE)), extremes, i)
    length = c.spread("%rate")
    middle = c.spread("%middle")
    zeroth = [c.load("%zeroth", i, ONE) for i in range(STATE)]
    c.do("br label %block")
    c.label("block")
    c.lines.append("  %r = phi i64 [ %begin, %0 ], [ %next, %done ]")
    left = c.assign("sub i64 %end, %r")
    integers = f"<{POINTS} x i64>"
    one = c.assign(f"insertelement {integers} poison, i64 {left}, i32 0")
    places = f"<{POINTS} x i32> zeroinitializer"
    limit = c.assign(f"shufflevector {integers} {one}, {integers} poison, {places}")
    numbers = "<" + ", ".join(f"i64 {i}" for i in range(POINTS)) + ">"
    mask = c.assign(f"icmp slt {integers} {numbers}, {limit}")
    masks = f"<{POINTS} x i1>"
    place = c.at("%times", "%r", ONE)
    time = c.assign(
        f"call {WHOLE} @llvm.masked.load.v{POINTS}f64.p0(ptr {place}, i32 8, {masks} {mask}, "
        f"{WHOLE} {middle})"
    )
    x = c.operation("*", c.operation("-", time, middle), length)
    x = c.call("minnum", WHOLE, x, constant(WHOLE, 1.0))
    twice = c.operation("+", x, x)
    values = [_clenshaw(c, x, twice, zeroth[i], i) for i in range(STATE)]
    found = column_values(c, equations, values)

    def put(pointer: str, i: int, value: str) -> None:
        first = c.assign(f"mul i64 %n, {i}")
        place = c.at(pointer, c.assign(f"add i64 {first}, %r"), ONE)
        c.do(
            f"call void @llvm.masked.store.v{POINTS}f64.p0({WHOLE} {value}, ptr {place}, i32 8, "
            f"{masks} {mask})"
        )

    for i, value in enumerate(found[:-1]):
        put("%columns", i, value)
    energy = found[BENCHMARK_COLUMNS.index("mechanical_energy")]
    for i, value in enumerate((found[-1], found[-1], energy, energy)):
        better = c.call(_BETTER[i % 2], WHOLE, c.load(extremes, i), value)
        c.store(better, extremes, i)
    wants = c.assign("icmp eq ptr %states, null")
    c.do(f"br i1 {wants}, label %done, label %more")
    c.label("more")
    for i, value in enumerate(values):
        put("%states", i, value)
    c.do("br label %done")
    c.label("done")
    c.lines.append(f"  %next = add i64 %r, {POINTS}")
    again = c.assign("icmp slt i64 %next, %end")
    c.do(f"br i1 {again}, label %block, label %out")
    c.label("out")
    for i in range(4):
        name, value = ("fmin", "fmax")[i % 2], c.load(extremes, i)
        best = c.assign(f"call double @llvm.vector.reduce.{name}.v{POINTS}f64({WHOLE} {value})")
        c.store(best, "%report", i + 1, ONE)
    c.do("ret void")
    head = (
        "internal void @rows(ptr noalias %series, ptr noalias %zeroth, double %middle, "
        "double %rate, i64 %begin, i64 %end, i64 %n, ptr noalias %times, ptr noalias %columns, "
        "ptr noalias %states, ptr noalias %report)"
    )
    return function(head, c.lines)


def _clenshaw(c: Code, x: str, twice: str, zeroth: str, i: int) -> str:
    """Chebyshev series of a variable, whose coefficients 1 to 8 lie in an array."""
    coefficient = [c.spread(c.load("%series", POINTS * i + j, ONE)) for j in range(POINTS)]
    before, value = coefficient[-1], c.fused(twice, coefficient[-1], coefficient[-2])
    for b in coefficient[-3::-1]:
        rest = c.operation("-", b, before)
        before, value = value, c.fused(twice, value, rest)
    return c.fused(x, value, c.operation("-", c.spread(zeroth), before))

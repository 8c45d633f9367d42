"""Source of a whole run as LLVM's assembly: steps, dense output, rows and columns in one function.

The eight points of a collocation step lie in the eight places of a vector, so that one evaluation
of the equations serves them all, in little more than the time of a single one. Its system is
solved by Newton's iteration with the Jacobian of the step's beginning (differences in the places of
a vector, too), in modes, where it falls into four complex systems of six equations.

The step is chosen by the last coefficient of its Chebyshev series, which is about the error of the
dense output times the rate at which the coefficients fall.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.double import Array
from heyoka_bike.workbench.fast.collocation import POINTS, collocation
from heyoka_bike.workbench.fast.complex_code import Pair, factor, solve
from heyoka_bike.workbench.fast.model_code import STATE, rates_source
from heyoka_bike.workbench.fast.row_code import rows_source
from heyoka_bike.workbench.fast.vector_code import (
    DECLARATIONS,
    HALF,
    ONE,
    WHOLE,
    Code,
    constant,
    function,
    literal,
)

RUN = "run"
"""Name of the function, see `run_source`."""

_DIFFERENCE = 2.0**-24  # of the state, for the Jacobian: half of the digits
_MOST_ITERATIONS = 12
_DIVERGING = 0.5  # an iteration that reduces the error by less is given up
_CLOSE = 0.02  # of the tolerance: what is left of Newton's iteration
_SAFETY, _LEAST, _MOST = 0.9, 0.25, 2.5  # of a change of the step
_MOST_ERROR = 4.0  # of the tolerance; a step beyond is repeated
_SHORTEST = 2.0**-30  # [s]
_FIRST = 0.25  # of the tolerance's root, over the rate of the fastest variable: the first step


def run_source(equations: Equations) -> str:
    """The module of function ``run``, for equations with constants in binary64.

    ``long run(start, rows, times, tolerance, most, columns, states, report)`` integrates from
    ``start`` (6 numbers) at time 0 through ascending ``times``, and writes eight columns, and six
    states unless that pointer is null, of so many rows, one variable after the other. It gives the
    number of steps, or -1 for a motion that cannot be continued, and -2 for more than ``most``
    steps. ``report`` gets the time reached, and of the rows the least and the largest of the
    mechanical trail over the front wheel's radius, and of the mechanical energy.
    """
    return "\n".join([rates_source(equations), rows_source(equations), _run(), DECLARATIONS])


@dataclass(frozen=True, slots=True)
class _Room:
    """Arrays of a run: names of their addresses.

    Attributes
    ----------
    y, z, f
        Vectors of the points: states, increments since the beginning, derivatives.
    series
        Coefficients 1 to 8 of the step's Chebyshev series.
    start, rest, zeroth
        Of each variable: at the beginning, what rounding took from it, coefficient 0.
    """

    y: str
    z: str
    f: str
    series: str
    start: str
    rest: str
    zeroth: str


@dataclass(frozen=True, slots=True)
class _Beginning:
    """A step's beginning: each variable in all places, derivatives, Jacobian, the step wished."""

    base: Sequence[str]
    slopes: Sequence[str]
    jacobian: Sequence[Sequence[str]]
    wish: str


@dataclass(frozen=True, slots=True)
class _Attempt:
    """A step of a length, which with its inverse is in all places, too.

    Its matrices are in factors; `right` is the right side of the first iteration.
    """

    h: str
    everywhere: str
    inverse: str
    matrix: Sequence[Sequence[Pair]]
    inverses: Sequence[Pair]
    right: Sequence[str]


def _run() -> str:
    c = Code()
    vectors, numbers = (
        [c.array(WHOLE, STATE) for _ in range(4)],
        [c.array(ONE, POINTS) for _ in range(3)],
    )
    room = _Room(*vectors, *numbers)
    end = _start(c, room)
    beginning = _begin(c, room)
    attempt = _attempt(c, room, beginning, end)
    _iterate(c, room, attempt)
    _again(c, room, beginning, attempt)
    _judge(c, room, attempt)
    _accept(c, room)
    _write(c, room, attempt)
    head = (
        f"i64 @{RUN}(ptr noalias %start, i64 %n, ptr noalias %times, double %tolerance, "
        "i64 %most, ptr noalias %columns, ptr noalias %states, ptr noalias %report)"
    )
    return function(head, c.lines)


def _start(c: Code, room: _Room) -> str:
    """The run's beginning; gives its end."""
    for i in range(STATE):
        c.store(c.load("%start", i, ONE), room.start, i, ONE)
        c.store(literal(0.0), room.rest, i, ONE)
    for i in range(4):
        c.store(literal(float("-inf" if i % 2 else "inf")), "%report", i + 1, ONE)
    last_row = c.assign("sub i64 %n, 1")
    end = c.load("%times", last_row, ONE)
    c.do("br label %begin")
    return end


def _begin(c: Code, room: _Room) -> _Beginning:
    """The first evaluation of a step: derivatives and Jacobian, by differences in the places."""
    c.label("begin")
    c.lines += [
        "  %t = phi double [ 0.0, %0 ], [ %t.next, %advance ]",
        "  %row = phi i64 [ 0, %0 ], [ %row.next, %advance ]",
        "  %steps = phi i64 [ 0, %0 ], [ %steps.next, %advance ]",
        "  %wish = phi double [ 0.0, %0 ], [ %wish.next, %advance ]",
    ]
    c.store("%t", "%report", 0, ONE)
    c.lines.append("  %too.many = icmp sge i64 %steps, %most")
    c.do("br i1 %too.many, label %many, label %slope")
    c.label("slope")
    base, units = [], []
    for i in range(STATE):
        value = c.load(room.start, i, ONE)
        size = c.call("maxnum", ONE, c.call("fabs", ONE, value), literal(1.0))
        unit = c.operation("*", size, literal(_DIFFERENCE), ONE)
        # What is really added, after rounding.
        unit = c.assign(f"fsub double {c.assign(f'fadd double {value}, {unit}')}, {value}")
        base.append(c.spread(value))
        units.append(unit)
        only = [float(j == i + 1) for j in range(POINTS)]
        c.store(c.fused(c.spread(unit), constant(WHOLE, only), base[i]), room.y, i)
    c.do(f"call void @rates(ptr {room.y}, ptr {room.f})")
    slopes = [c.load(room.f, POINTS * k, ONE) for k in range(STATE)]
    jacobian = [
        [
            c.operation(
                "/", c.operation("-", c.load(room.f, POINTS * k + i + 1, ONE), slopes[k], ONE),
                units[i], ONE,
            )
            for i in range(STATE)
        ]
        for k in range(STATE)
    ]  # fmt: skip
    fastest = literal(0.0)
    for row in jacobian:
        for x in row:
            fastest = c.call("maxnum", ONE, fastest, c.call("fabs", ONE, x))
    root = "%tolerance"
    for _ in range(3):
        root = c.call("sqrt", ONE, root)
    first = c.operation("/", c.operation("*", root, literal(_FIRST * POINTS), ONE), fastest, ONE)
    is_first = c.assign("fcmp oeq double %wish, 0.0")
    wish = c.assign(f"select i1 {is_first}, double {first}, double %wish")
    c.do("br label %attempt")
    return _Beginning(base, slopes, jacobian, wish)


def _attempt(c: Code, room: _Room, beginning: _Beginning, end: str) -> _Attempt:
    """A step of a length: four complex matrices in factors."""
    m = collocation()
    c.label("attempt")
    c.lines.append(f"  %length = phi double [ {beginning.wish}, %slope ], [ %shorter, %reject ]")
    left = c.assign(f"fsub double {end}, %t")
    # A last step much shorter than the one before is joined to it.
    reach = c.operation("*", "%length", literal(1.01), ONE)
    is_last = c.assign(f"fcmp oge double {reach}, {left}")
    chosen = c.assign(f"select i1 {is_last}, double {left}, double %length")
    # The step is what the clock goes on by: else the clock would drift from the motion.
    c.lines.append(f"  %sum = fadd double %t, {chosen}")
    c.lines.append(f"  %t.next = select i1 {is_last}, double {end}, double %sum")
    h = c.assign("fsub double %t.next, %t")
    is_short = c.assign(f"fcmp uge double {h}, {literal(_SHORTEST)}")
    c.do(f"br i1 {is_short}, label %factor, label %lost")
    c.label("factor")
    inverse = c.operation("/", literal(1.0), h, ONE)
    inverse4, inverse8 = c.spread(inverse, HALF), c.spread(inverse)
    h8 = c.spread(h)
    diagonal = (
        c.operation("*", inverse4, constant(HALF, m.eigenvalues.real), HALF),
        c.operation("*", inverse4, constant(HALF, m.eigenvalues.imag), HALF),
    )
    zero = constant(HALF, 0.0)
    matrix: list[list[Pair]] = []
    for i, row in enumerate(beginning.jacobian):
        entries = []
        for j, x in enumerate(row):
            minus = c.spread(c.negative(x, ONE), HALF)
            entries.append(
                (c.operation("+", minus, diagonal[0], HALF), diagonal[1])
                if i == j
                else (minus, zero)
            )
        matrix.append(entries)
    inverses = factor(c, matrix)
    # The first iteration, from increments of zero: the derivatives are those of the beginning.
    weights = _from_rest() @ m.points
    first_right = [
        c.operation("*", c.spread(s), constant(WHOLE, weights)) for s in beginning.slopes
    ]
    for i in range(STATE):
        c.store(constant(WHOLE, 0.0), room.z, i)
    c.do("br label %iterate")
    return _Attempt(h, h8, inverse8, matrix, inverses, first_right)


def _iterate(c: Code, room: _Room, attempt: _Attempt) -> None:
    """One change of Newton's iteration, and whether it was the last one."""
    m = collocation()
    c.label("iterate")
    phi = []
    for i in range(STATE):
        phi.append(f"%right{i}")
        c.lines.append(
            f"  %right{i} = phi {WHOLE} [ {attempt.right[i]}, %factor ], [ %right.next{i}, %again ]"
        )
    c.lines += [
        "  %iteration = phi i64 [ 1, %factor ], [ %iteration.next, %again ]",
        f"  %size.before = phi double [ {literal(float('inf'))}, %factor ], [ %size, %again ]",
    ]
    change = solve(c, attempt.matrix, attempt.inverses, [c.halves(x) for x in phi])
    for i, (re, im) in enumerate(change):
        c.store(c.joined(re, im), room.f, i)
    size = constant(WHOLE, 0.0)
    for i in range(STATE):
        dz = c.product(m.from_modes, room.f, i)
        c.store(c.operation("+", c.load(room.z, i), dz), room.z, i)
        size = c.call("maxnum", WHOLE, size, c.call("fabs", WHOLE, dz))
    found = c.assign(f"call double @llvm.vector.reduce.fmax.v{POINTS}f64({WHOLE} {size})")
    c.lines.append(f"  %size = fadd double {found}, 0.0")
    # The next change is about as much smaller as this one is; of the first one nothing is known.
    ratio = c.operation("/", "%size", "%size.before", ONE)
    expected = c.operation("*", "%size", ratio, ONE)
    goal = c.operation("*", "%tolerance", literal(_CLOSE), ONE)
    is_first = c.assign("icmp eq i64 %iteration, 1")
    close = c.assign(f"fcmp ole double {expected}, {goal}")
    tiny = c.assign(f"fcmp ole double %size, {goal}")
    unknown = c.assign(f"select i1 {is_first}, i1 {tiny}, i1 {close}")
    c.do(f"br i1 {unknown}, label %converged, label %judge")
    c.label("judge")
    slow = c.assign(f"fcmp ult double {ratio}, {literal(_DIVERGING)}")
    few = c.assign(f"icmp slt i64 %iteration, {_MOST_ITERATIONS}")
    goes = c.assign(f"and i1 {slow}, {few}")
    c.do(f"br i1 {goes}, label %again, label %halve")


def _again(c: Code, room: _Room, beginning: _Beginning, attempt: _Attempt) -> None:
    """What is left of the equations after a change; or half of a step that does not converge."""
    m, from_rest = collocation(), _from_rest()
    c.label("again")
    for i in range(STATE):
        c.store(c.operation("+", beginning.base[i], c.load(room.z, i)), room.y, i)
    c.do(f"call void @rates(ptr {room.y}, ptr {room.f})")
    # What is left of the equations: increments from the derivatives, minus those there are.
    for i in range(STATE):
        lack = c.fused(
            attempt.everywhere, c.product(m.integral, room.f, i), c.negative(c.load(room.z, i))
        )
        c.store(lack, room.y, i)
    for i in range(STATE):
        value = c.operation("*", c.product(from_rest, room.y, i), attempt.inverse)
        c.lines.append(f"  %right.next{i} = fadd {WHOLE} {value}, {constant(WHOLE, -0.0)}")
    c.lines.append("  %iteration.next = add i64 %iteration, 1")
    c.do("br label %iterate")

    c.label("halve")
    c.lines.append(f"  %halved = fmul double {attempt.h}, {literal(0.5)}")
    c.do("br label %reject")


def _judge(c: Code, room: _Room, attempt: _Attempt) -> None:
    """The series of a step, and by its last coefficient the length of the next one."""
    m = collocation()
    c.label("converged")
    error = literal(0.0)
    for i in range(STATE):
        coefficients = c.product(m.series, room.z, i)
        c.store(coefficients, room.series, i)
        error = c.call(
            "maxnum", ONE, error, c.call("fabs", ONE, c.element(coefficients, POINTS - 1))
        )
    ratio = c.operation("/", "%tolerance", error, ONE)
    for _ in range(3):
        ratio = c.call("sqrt", ONE, ratio)
    scale = c.operation("*", ratio, literal(_SAFETY), ONE)
    scale = c.call("maxnum", ONE, literal(_LEAST), c.call("minnum", ONE, literal(_MOST), scale))
    # Greatest values pass over what is no number; a sum does not.
    total = literal(0.0)
    for i in range(STATE):
        total = c.operation("+", total, c.load(room.z, POINTS * i + POINTS - 1, ONE), ONE)
    is_number = c.assign(f"fcmp ord double {total}, {error}")
    scale = c.assign(f"select i1 {is_number}, double {scale}, double {literal(_LEAST)}")
    c.lines.append(f"  %wish.next = fmul double {attempt.h}, {scale}")
    most = c.operation("*", "%tolerance", literal(_MOST_ERROR), ONE)
    small = c.assign(f"fcmp ole double {error}, {most}")
    good = c.assign(f"and i1 {small}, {is_number}")
    c.do(f"br i1 {good}, label %accept, label %reject")
    c.label("reject")
    c.lines.append("  %shorter = phi double [ %halved, %halve ], [ %wish.next, %converged ]")
    c.do("br label %attempt")


def _accept(c: Code, room: _Room) -> None:
    """The state at a step's end."""
    c.label("accept")
    # The polynomial begins at the state: this gives its constant coefficient.
    signs = constant(WHOLE, [1.0 if j % 2 == 0 else -1.0 for j in range(POINTS)])
    for i in range(STATE):
        terms = c.operation("*", c.load(room.series, i), signs)
        rise = c.assign(
            f"call reassoc double @llvm.vector.reduce.fadd.v{POINTS}f64(double -0.0, "
            f"{WHOLE} {terms})"
        )
        value = c.load(room.start, i, ONE)
        c.store(c.operation("+", value, rise, ONE), room.zeroth, i, ONE)
        c.accumulate(room.start, room.rest, i, c.load(room.z, POINTS * i + POINTS - 1, ONE))


def _write(c: Code, room: _Room, attempt: _Attempt) -> None:
    """The rows of a step, and on to the next one."""
    half = c.operation("*", attempt.h, literal(0.5), ONE)
    middle = c.operation("+", "%t", half, ONE)
    rate = c.operation("/", literal(1.0), half, ONE)
    c.do("br label %count")
    c.label("count")
    c.lines.append("  %stop = phi i64 [ %row, %accept ], [ %stop.more, %inside ]")
    beyond = c.assign("icmp sge i64 %stop, %n")
    c.do(f"br i1 {beyond}, label %counted, label %look")
    c.label("look")
    later = c.assign(f"fcmp ogt double {c.load('%times', '%stop', ONE)}, %t.next")
    c.do(f"br i1 {later}, label %counted, label %inside")
    c.label("inside")
    c.lines.append("  %stop.more = add i64 %stop, 1")
    c.do("br label %count")
    c.label("counted")
    some = c.assign("icmp sgt i64 %stop, %row")
    c.do(f"br i1 {some}, label %write, label %advance")
    c.label("write")
    c.do(
        f"call void @rows(ptr {room.series}, ptr {room.zeroth}, double {middle}, double {rate}, "
        "i64 %row, i64 %stop, i64 %n, ptr %times, ptr %columns, ptr %states, ptr %report)"
    )
    c.do("br label %advance")
    c.label("advance")
    c.lines += ["  %row.next = add i64 %stop, 0", "  %steps.next = add i64 %steps, 1"]
    going = c.assign("icmp slt i64 %row.next, %n")
    c.do(f"br i1 {going}, label %begin, label %finish")
    c.label("finish")
    c.store("%t.next", "%report", 0, ONE)
    c.do("ret i64 %steps.next")
    c.label("lost")
    c.do("ret i64 -1")
    c.label("many")
    c.do("ret i64 -2")


def _from_rest() -> Array:
    """From what is left at the points to the right side in modes, over the step's length."""
    m = collocation()
    found: Array = m.to_modes @ np.linalg.inv(m.integral)
    return found

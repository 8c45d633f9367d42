"""Time codes beyond binary64: heyoka, mpmath's `odefun`, Taylor series of balls, and C.

All integrate the same equations from the same initial state, without rows. A run that would take
minutes is measured over the first part of the maneuver. Its time is then scaled to the whole
maneuver by the fraction of heyoka's steps in that part; the result states the measured time span.
"""

import contextlib
import time
from collections.abc import Sequence
from fractions import Fraction
from functools import partial

import flint

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.motion.heyoka_adapter import NativeNumbers, TaylorIntegrator, order_of
from heyoka_bike.motion.integrate import integrate, right_hand_side
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.numbers.analytic import AtPoints
from heyoka_bike.numbers.arithmetic import Balls, Multiprecision, midpoint
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.workbench.bench.compiled import NoCompilerError, QuadruplePeer
from heyoka_bike.workbench.bench.problem import Measured, seconds

PRECISIONS: Sequence[str | int] = ("binary128", 70)
"""Precisions at which the codes are compared."""
DIGITS: Sequence[str | int] = ("binary64", "longdouble", 25, "binary128", 64, 125, 250, 500, 1000)
"""Precisions whose cost is measured with heyoka only."""

_TOLERANCE_BITS = 5  # number of bits of the tolerance beyond the precision, as in `integrate`
_GUARD_BITS_OF_CONSTANTS = 64  # number of bits of the constants beyond those of the run
# Number of columns and tolerance of the extrapolation method in C. Of 8 to 16 columns, 8 are the
# fastest for an error of 1e-30, and the weights of more columns lose digits.
_COLUMNS_OF_EXTRAPOLATION, _TOLERANCE_OF_EXTRAPOLATION = 8, 1e-29
_QUADRUPLE = "binary128"  # name of the number format of libquadmath
# A Taylor step in ball arithmetic keeps its truncation error this many bits below the precision.
_SAFETY_BITS = 8
_LONG_STEP = 60.0  # [s]; if the first step takes longer than this, it is the step that is timed


def precise(
    published: Trajectory, precisions: Sequence[str | int] = PRECISIONS, *,
    runs: int = 3, mpmath_span: Fraction = Fraction(1, 20),
) -> list[Measured]:  # fmt: skip
    """Time the codes at each precision, on the maneuver of a published run.

    The shortest run counts; mpmath, which takes seconds for the usual span [s], runs only once.

    In the results ``seconds`` is the time for the whole maneuver without building, scaled if only
    the span ``measured_over`` [s] was integrated. The ``error`` is the largest difference of the
    state at the end of the span from the published run of 70 digits, in the variables of the
    few-product form.
    """
    found = []
    for name in precisions:
        p = Precision.of(name)
        found.append(_heyoka(published, p, runs))
        found.append(_mpmath(published, p, mpmath_span))
        found.append(_balls(published, p))
        if name == _QUADRUPLE:
            # If there is no compiler, the code in C is left out.
            with contextlib.suppress(NoCompilerError):
                found.append(_extrapolated(published, p, runs))
    return found


def costs(
    published: Trajectory, precisions: Sequence[str | int] = DIGITS, *, longest: float = 5.0
) -> list[Measured]:
    """Measure the cost of each precision with heyoka, on the maneuver of a published run.

    The runs include the yaw and exact accumulation, as in `integrate`. ``steps`` is the number of
    timed steps: all but the first, or as many as `longest` [s] allows, at least one. ``seconds`` is
    the time for the whole maneuver. If not all steps were timed, it uses the number of steps of the
    published run, which hardly depends on the digits.
    """
    return [_cost(published, Precision.of(name), longest) for name in precisions]


def _heyoka(published: Trajectory, p: Precision, runs: int) -> Measured:
    native = NativeNumbers(p)
    duration = published.maneuver.duration
    start = [native.from_integer(*midpoint(x)) for x in _start(published, p)]
    zero, one = native.from_integer(0, 0), native.from_integer(duration.denominator, 0)
    end = native.from_integer(duration.numerator, 0) / one
    integrator = TaylorIntegrator(
        right_hand_side(published.bicycle, p, with_yaw=False), start, native.type,
        bits=p.bits if native.is_mpfr else None,
    )  # fmt: skip

    def run() -> None:
        integrator.begin(zero, start)
        integrator.until(end)

    took = min(seconds(run) for _ in range(runs))
    return _result("heyoka", p, published, took, duration, [str(x) for x in integrator.state])


def _mpmath(published: Trajectory, p: Precision, span: Fraction) -> Measured:
    a = Multiprecision(round(p.digits))
    mp = a.context
    equations = Equations.of(published.bicycle, a, is_regular=False)
    start = [mp.mpf(x.str(a.context.dps + 5, radius=False)) for x in _start(published, p)]
    begin = time.perf_counter()
    solution = mp.odefun(lambda _, y: equations.rates(list(y)), 0, start)
    state = solution(mp.mpf(span.numerator) / span.denominator)
    took = time.perf_counter() - begin
    text = [mp.nstr(x, mp.dps + 5) for x in state]
    return _result("mpmath odefun", p, published, took, span, text)


def _balls(published: Trajectory, p: Precision) -> Measured:
    """Time one Taylor step in ball arithmetic, which evaluates the equations once per order."""
    balls, order, longest = AtPoints(p.bits), order_of(p.bits), flint.ctx.cap
    equations = Equations.of(published.bicycle, balls, is_regular=False)
    y = [[x] for x in _start(published, p)]
    begin = time.perf_counter()
    for n in range(1, order + 1):
        # This global variable of flint limits the length of all series. Only n terms are needed.
        flint.ctx.cap = n
        with balls.precision():
            rates = equations.rates([flint.arb_series(c, n) for c in y])
            for c, rate in zip(y, rates, strict=True):
                c.append(rate[n - 1] / n)
    flint.ctx.cap = longest
    # Choose the step so that the last term of the series is below the precision.
    last = max(abs(float(c[-1].mid())) for c in y)
    h = Fraction((last * 2.0 ** (p.bits + _SAFETY_BITS)) ** (-1 / order)).limit_denominator(1000)
    with balls.precision():
        state = [flint.arb_poly(c)(flint.arb(h.numerator) / h.denominator) for c in y]
    took = time.perf_counter() - begin
    text = [x.mid().str(round(p.digits) + 5, radius=False) for x in state]
    return _result("Taylor in balls", p, published, took, h, text)


def _extrapolated(published: Trajectory, p: Precision, runs: int) -> Measured:
    peer, duration = QuadruplePeer(published.bicycle), published.maneuver.duration
    digits = round(p.digits) + 5
    start = [x.mid().str(digits, radius=False) for x in _start(published, p)]
    run = partial(
        peer.end,
        _COLUMNS_OF_EXTRAPOLATION,
        start,
        str(float(duration)),
        _TOLERANCE_OF_EXTRAPOLATION,
    )
    took = min(seconds(run) for _ in range(runs))
    return _result("C extrapolation", p, published, took, duration, run()[0])


def _start(published: Trajectory, p: Precision) -> list[flint.arb]:
    """Return the initial state (without yaw) in the variables of `few_products`."""
    equations = Equations.of(
        published.bicycle, Balls(p.bits + _GUARD_BITS_OF_CONSTANTS), is_regular=False
    )
    return initial_state(equations, published.maneuver)[:6]


def _result(
    code: str, p: Precision, published: Trajectory, took: float, span: Fraction,
    state: Sequence[str],
) -> Measured:  # fmt: skip
    with Balls(published.bits + _GUARD_BITS_OF_CONSTANTS).precision():
        pairs = zip(state, published.state(span), strict=False)
        error = max(abs(float((flint.arb(x) - y).mid())) for x, y in pairs)
    return {
        "code": code, "digits": p.digits, "seconds": took / _part(published, span),
        "measured_over": float(span), "error": error,
    }  # fmt: skip


def _part(published: Trajectory, span: Fraction) -> float:
    """Return the fraction of the steps of the published run that lie before the time `span`."""
    i = published.piece_at(span)
    begin, end = published.breaks[i], published.breaks[i + 1]
    whole = published.piece_at(published.maneuver.duration) + 1
    return float(i + (span - begin) / (end - begin)) / whole if span < end else 1.0


def _cost(published: Trajectory, p: Precision, longest: float) -> Measured:
    marks: list[float] = []
    begin = time.perf_counter()

    def step(_: float) -> None:
        marks.append(time.perf_counter())
        if len(marks) == 1 and marks[0] - begin > _LONG_STEP:
            # Building the code takes only a hundredth of the time of the first step, so it is timed
            # together with this step.
            marks.insert(0, begin)
            raise _EnoughError
        if len(marks) > 1 and marks[-1] - marks[0] > longest:
            raise _EnoughError

    count = published.steps
    with contextlib.suppress(_EnoughError):
        count = integrate(published.bicycle, published.maneuver, p, progress=step).steps
    # A short first step is not timed, because its time includes building the code.
    timed = len(marks) - 1
    per_step = (marks[-1] - marks[0]) / timed
    return {
        "digits": p.digits, "order": order_of(p.bits + _TOLERANCE_BITS), "steps": timed,
        "seconds_per_step": per_step, "seconds": per_step * count,
    }  # fmt: skip


class _EnoughError(Exception):
    """Raised to stop a run after the cost of a step is known."""

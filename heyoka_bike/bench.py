"""How long a maneuver takes, at equal accuracy, with heyoka and with integrators of SciPy.

The task is the same for every code: the state at the rows of a maneuver, from the same initial
state and the same right-hand side (heyoka differentiates its expressions, SciPy calls them compiled
by ``heyoka.cfunc``). Codes are compared in three classes, see `CLASSES`. In the first two the
tolerance of each code is searched on a grid of four values a decade for one that passes while the
next looser one fails. Building is timed apart, with heyoka's caches of compiled code off.

Accuracy is measured outside of the timing, from the rows, in ball arithmetic. The state error is
the largest abs(value - reference) over the rows of roll and steer angle [rad], their rates [rad/s]
and forward speed [m/s], with the reference taken at the very times of the rows.
"""

from __future__ import annotations

import gc
import math
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Any

import flint
import numpy as np

from heyoka_bike.arithmetic import Balls
from heyoka_bike.constants import Constants, constants
from heyoka_bike.initial import few_product_state, initial_state
from heyoka_bike.integration import require_heyoka, right_hand_side
from heyoka_bike.outputs import energies, unfold
from heyoka_bike.parameters import Bicycle, Maneuver
from heyoka_bike.precision import Precision
from heyoka_bike.reference import ReferenceManeuver, Values

PERFORMANCE_LIMIT = 1e-3
"""Of the benchmark's eq. (1) [%], in the first class."""
ERROR_LIMIT = 1e-12
"""Of the state error, in the second class."""

CLASSES: Mapping[str, str] = {
    "performance": "(a) loosest tolerance with eq. (1) under 1e-3 %",
    "state_error": "(b) loosest tolerance with a state error under 1e-12",
    "roundoff": "(c) roundoff: heyoka's default tolerance, the best that SciPy reaches",
}
"""What the codes of a class have in common."""

Array = np.ndarray[Any, Any]
Rows = tuple[Array, int]
"""States, shape (rows, 6), and how many steps or calls of the right-hand side they took."""
Progress = Callable[[str, float], None]
"""Called with what is being done and the part done of the whole, 0 to 1."""

_BITS = 256
_STATE_COLUMNS = ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
_MIDDLE, _NEAR_ROUNDOFF, _TIGHTEST = 16, 52, 64  # indices of the tolerances 1e-4, 1e-13, 1e-16
_MIN_RTOL = 100 * float(np.finfo(np.float64).eps)  # SciPy goes no lower
_SECONDS, _MIN_RUNS = 10.0, 3  # a slow code is run less often


@dataclass(frozen=True)
class Problem:
    """What is integrated, and the reference it is compared with."""

    bicycle: Bicycle
    maneuver: Maneuver
    reference: ReferenceManeuver

    def start(self, number: Callable[[str], Any]) -> Array:
        """Initial state, without the yaw, in the number type that `number` makes from decimals."""
        k, balls = self._constants, self._balls
        with balls.precision():
            start = initial_state(self.bicycle, self.maneuver, k, balls)
            state = few_product_state(k, balls, start)[:6]
            return np.array([number(x.str(60, radius=False)) for x in state])

    @cached_property
    def times(self) -> Array:
        """Times of the rows [s], rounded to binary64."""
        return np.array([float(self.maneuver.time(i)) for i in range(self.maneuver.rows)])

    @cached_property
    def expected(self) -> Values:
        """Reference at `times`, which are not exactly those of its rows."""
        return self.reference.evaluate(self.times, _STATE_COLUMNS)

    @cached_property
    def slope(self) -> tuple[Callable[[float, Array], Array], float]:
        """The right-hand side, called with time and state, and the time of building it [s]."""
        begin = time.perf_counter()
        equations = right_hand_side(self.bicycle, Precision.of("binary64"), with_yaw=False)
        compiled = require_heyoka().cfunc(
            [rate for _, rate in equations], [x for x, _ in equations]
        )

        def slope(_: float, y: Array) -> Any:
            return compiled(np.ascontiguousarray(y))

        return slope, time.perf_counter() - begin

    def measure(self, rows: Array, expected: Values) -> tuple[float, float]:
        """Eq. (1) [%] and state error of rows; both infinite for a run that did not get through."""
        if len(rows) < self.maneuver.rows:
            return math.inf, math.inf
        k, balls = self._constants, self._balls
        total, worst = [], flint.arb(0)
        with balls.precision():
            for i, row in enumerate(rows):
                state = [flint.arb(x if isinstance(x, float) else str(x)) for x in row]
                o, u = unfold(k, balls, state, is_regular=False)
                e = energies(k, o, u)
                total.append(e.potential + e.kinetic)
                found = (state[0], state[2], u.p, u.steer_rate, u.v * k.length)
                for name, value in zip(_STATE_COLUMNS, found, strict=True):
                    right = flint.arb(expected.hi[name][i]) + flint.arb(expected.lo[name][i])
                    worst = worst.max(abs(value - right))
            high, low = total[0], total[0]
            for value in total:
                high, low = high.max(value), low.min(value)
            performance, error = float((100 * (high - low) / total[0]).mid()), float(worst.mid())
        return (performance, error) if math.isfinite(performance + error) else (math.inf, math.inf)

    @cached_property
    def _balls(self) -> Balls:
        return Balls(_BITS)

    @cached_property
    def _constants(self) -> Constants:
        with self._balls.precision():
            return constants(self.bicycle, self._balls)


class Unavailable(Exception):  # noqa: N818
    """A code that does not run here; its text says why, in a few words."""


@dataclass(frozen=True)
class Trial:
    """A code at a tolerance, built and measured.

    Attributes
    ----------
    run
        Runs it once.
    tolerance
        In the code's own sense.
    build
        Time of building it [s].
    count
        Steps, or calls of the right-hand side.
    performance, error
        Eq. (1) [%] and state error.
    order
        Taylor order, the only thing that heyoka takes from the tolerance.
    """

    run: Callable[[], Rows]
    tolerance: float
    build: float
    count: int
    performance: float
    error: float
    order: int | None = None


@dataclass(eq=False)
class Heyoka:
    """heyoka's adaptive Taylor integrator; compact mode is its loops rolled."""

    name: str
    precision: str
    problem: Problem
    is_compact: bool = True
    counts: str = "steps"
    _build: dict[int, float] = field(default_factory=dict, init=False, repr=False)

    def at(self, tolerance: float | None) -> Trial:
        """Build and measure at a tolerance, None for heyoka's default.

        Raises
        ------
        Unavailable
            This heyoka has no binary128.
        """
        hy, problem = require_heyoka(), self.problem
        number, times, expected = float, problem.times, problem.expected
        if self.precision == "binary128":
            if not hasattr(hy, "real128"):
                raise Unavailable("not in this heyoka")
            number, expected = hy.real128, problem.reference.rows
            exact = [problem.maneuver.time(i) for i in range(problem.maneuver.rows)]
            times = np.array([number(t.numerator) / number(t.denominator) for t in exact])
        start = problem.start(number)
        begin = time.perf_counter()
        integrator = hy.taylor_adaptive(
            right_hand_side(problem.bicycle, Precision.of(self.precision), with_yaw=False),
            start,
            fp_type=number,
            compact_mode=self.is_compact,
            **({} if tolerance is None else {"tol": number(tolerance)}),
        )
        # What is compiled depends on the order only, and is kept: the first build of each counts.
        build = self._build.setdefault(integrator.order, time.perf_counter() - begin)

        def run() -> Rows:
            integrator.time = times[0]
            integrator.state[:] = start
            _, _, _, steps, _, rows = integrator.propagate_grid(times)
            return rows, steps

        rows, steps = run()
        return Trial(
            run, float(integrator.tol), build, steps, *problem.measure(rows, expected),
            order=integrator.order,
        )  # fmt: skip


@dataclass(eq=False)
class SciPy:
    """A method of ``scipy.integrate.solve_ivp``, at rtol = atol; rtol stops at 2.2e-14."""

    name: str
    problem: Problem
    precision: str = "binary64"
    counts: str = "rhs_calls"

    def at(self, tolerance: float | None) -> Trial:
        """Build and measure at a tolerance; by default the one of the smallest state error.

        Raises
        ------
        Unavailable
            SciPy is not installed.
        """
        try:
            from scipy.integrate import solve_ivp
        except ImportError:
            raise Unavailable("not installed") from None
        if tolerance is None:
            tried = [self.at(_tolerance(i)) for i in range(_NEAR_ROUNDOFF, _TIGHTEST + 1)]
            return min(tried, key=lambda x: x.error)
        problem, atol = self.problem, tolerance
        start, times, method = problem.start(float), problem.times, self.name.split()[-1]
        slope, build = problem.slope

        def run() -> Rows:
            found = solve_ivp(
                slope, (times[0], times[-1]), start, method=method, t_eval=times,
                rtol=max(atol, _MIN_RTOL), atol=atol,
            )  # fmt: skip
            return found.y.T, found.nfev

        rows, calls = run()
        return Trial(run, atol, build, calls, *problem.measure(rows, problem.expected))


@dataclass(eq=False)
class Line:
    """A code in a class (key of `CLASSES`) with its times [s]; `status` says why if it has none."""

    accuracy_class: str
    code: Heyoka | SciPy
    status: str = "ok"
    trial: Trial | None = None
    times: list[float] = field(default_factory=list)


def bench(
    problem: Problem, runs: int, *, is_quick: bool = False, progress: Progress | None = None
) -> list[Line]:
    """Time every code in every class, the codes of a class in turns.

    Parameters
    ----------
    runs
        Timed runs of each code; fewer (but 3) of one that would take longer than 10 s.
    is_quick
        Leave out the unrolled form of heyoka, which takes long to build.

    Raises
    ------
    MissingPackageError
        heyoka is not installed; the right-hand side comes from it too.
    """
    report = progress or (lambda what, done: None)
    heyoka = Heyoka("heyoka", "binary64", problem)
    unrolled = Heyoka("heyoka unrolled", "binary64", problem, is_compact=False)
    wide = Heyoka("heyoka", "binary128", problem)
    codes = (heyoka, unrolled, wide, SciPy("SciPy DOP853", problem), SciPy("SciPy LSODA", problem))
    trials = [cache(code.at) for code in codes]
    lines = []
    with _caches_off(), warnings.catch_warnings(), np.errstate(all="ignore"):
        # Far from their limits the peers overflow, or complain that they cannot go on.
        warnings.simplefilter("ignore")
        for i, accuracy_class in enumerate(CLASSES):
            group = [Line(accuracy_class, code) for code in codes]
            lines += group
            passed = 0
            for j, line in enumerate(group):
                done = (i + j / len(group) / 2) / len(CLASSES)
                report(f"{accuracy_class}: preparing {line.code.name}", done)
                if is_quick and line.code is unrolled:
                    line.status = "left out"
                    continue
                # The other forms of heyoka have its truncation error: they start where it passed.
                _prepare(line, trials[j], passed if line.code in (unrolled, wide) else None)
                if line.code is heyoka and line.trial is not None:
                    passed = round(-4 * math.log10(line.trial.tolerance))

            def timed(part: float, i: int = i, name: str = accuracy_class) -> None:
                report(f"{name}: timing", (i + (1 + part) / 2) / len(CLASSES))

            _race([x for x in group if x.trial is not None], runs, timed)
    return lines


def _prepare(line: Line, at: Callable[[float | None], Trial], first: int | None) -> None:
    """Choose the tolerance of a code in its class, no looser than that of index `first`."""

    def excess(i: int) -> float:
        """Logarithm of the error over its limit."""
        trial = at(_tolerance(i))
        if line.accuracy_class == "performance":
            ratio = trial.performance / PERFORMANCE_LIMIT
        else:
            ratio = trial.error / ERROR_LIMIT
        return math.log10(min(max(ratio, 1e-99), 1e99))

    try:
        if line.accuracy_class == "roundoff":
            line.trial = at(None)
        else:
            found = _loosest(excess) if first is None else _first(excess, first)
            line.trial = None if found is None else at(_tolerance(found))
    except Unavailable as e:
        line.status = str(e)
        return
    if line.trial is None or math.isinf(line.trial.error):
        line.status, line.trial = "not reached", None


def _loosest(excess: Callable[[int], float]) -> int | None:
    """Index of a tolerance that passes while the next looser one fails; None if there is none."""
    # Errors are about proportional to tolerances: one trial says where to look.
    i = min(max(_MIDDLE + round(4 * excess(_MIDDLE)), 0), _TIGHTEST)
    if excess(i) >= 0:
        return _first(excess, i + 1)
    while i > 0 and excess(i - 1) < 0:
        i -= 1
    return i


def _first(excess: Callable[[int], float], start: int) -> int | None:
    return next((i for i in range(start, _TIGHTEST + 1) if excess(i) < 0), None)


def _tolerance(index: int) -> float:
    return float(10 ** (-index / 4))


def _race(lines: Sequence[Line], runs: int, progress: Callable[[float], None]) -> None:
    """Time the codes in turns, after one run of each that is not counted."""
    counts = [min(runs, max(_MIN_RUNS, int(_SECONDS / _time(line)))) for line in lines]
    gc.collect()
    gc.disable()
    try:
        for turn in range(max(counts, default=0)):
            for line, count in zip(lines, counts, strict=True):
                if turn < count:
                    line.times.append(_time(line))
            progress((turn + 1) / max(counts))
    finally:
        gc.enable()


def _time(line: Line) -> float:
    assert line.trial is not None
    begin = time.perf_counter()
    line.trial.run()
    return time.perf_counter() - begin


@contextmanager
def _caches_off() -> Iterator[None]:
    """Without compiled code of earlier runs, so that building is timed as the first time."""
    state = require_heyoka().llvm_state
    was_enabled = state.get_diskcache_enabled()
    state.set_diskcache_enabled(False)
    state.clear_memcache()
    try:
        yield
    finally:
        state.set_diskcache_enabled(was_enabled)

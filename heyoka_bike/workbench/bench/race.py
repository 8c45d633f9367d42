"""Computing time of a maneuver at equal accuracy, with heyoka and other integrators.

The task is the same for every code: all eight columns at the rows of a maneuver, from the same
initial state and the same equations. Each code is built and measured at a tolerance in its own
sense. Several maneuvers run one after the other, or at once in the fast path of this package.

Codes are compared in three classes, see `CLASSES`. In the first two each code gets the tolerance,
from a grid of eight values per decade, that passes while the next looser one fails. Building is
timed separately, without heyoka's caches of compiled code. The codes of a class run in turns on one
processor: *warm*, after an uncounted run of the same code, and a few times *cold*, after other data
has filled the processor's caches.
"""

from __future__ import annotations

import gc
import importlib.util
import math
import os
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, cached_property
from types import ModuleType

import numpy as np

from heyoka_bike.motion.heyoka_adapter import (
    NativeNumbers,
    TaylorIntegrator,
    caches_off,
    has_binary128,
)
from heyoka_bike.motion.integrate import right_hand_side
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.bench.compiled import CompiledPeers, NoCompilerError
from heyoka_bike.workbench.bench.problem import (
    ERROR_LIMIT,
    Array,
    Measured,
    ReferenceProblem,
    Trial,
    Unavailable,
    performance_limit,
    seconds,
)
from heyoka_bike.workbench.fast.simulate import ACCURACIES, prepare

PER_DECADE = 8
"""Number of tolerances per decade of the grid."""
MIDDLE, NEAR_ROUNDOFF, TIGHTEST = 4 * PER_DECADE, 13 * PER_DECADE, 16 * PER_DECADE
"""Grid indices of the tolerances 1e-4, 1e-13, 1e-16."""

_Run = Callable[[], tuple[Array, int, Array]]
"""Returns states, calls of the right-hand side, and columns."""

_MIN_RTOL = 100 * float(np.finfo(np.float64).eps)  # the smallest rtol that SciPy accepts


def tolerance_of(index: int) -> float:
    """Return the tolerance with this index in the grid of tolerances."""
    return float(10 ** (-index / PER_DECADE))


@dataclass(eq=False)
class TimedCode:
    """A code to be timed on one maneuver, or on several at the same tolerance.

    Attributes
    ----------
    name
        Name in the table.
    problems
        Problems to integrate.
    precision
        Precision of the code's numbers, as in the table.
    counts
        Description of what `Trial.count` counts.
    """

    name: str
    problems: Sequence[ReferenceProblem]
    precision: str = "binary64"
    counts: str = "rhs_calls"

    def at(self, tolerance: float | None) -> Trial:
        """Build and measure the code; None means the most accurate tolerance of each maneuver.

        Raises
        ------
        Unavailable
            The code does not run here.
        """
        trials = [self._trial(problem, tolerance) for problem in self.problems]
        if len(trials) == 1:
            return trials[0]

        def run() -> None:
            for trial in trials:
                trial.run()

        return Trial(
            run,
            max(x.tolerance for x in trials),
            max(x.build for x in trials),
            sum(x.count for x in trials),
            max(x.performance for x in trials),
            max(x.error for x in trials),
            order=trials[0].order,
        )

    def _trial(self, problem: ReferenceProblem, tolerance: float | None) -> Trial:
        """Build and measure the code on one maneuver; None means the most accurate tolerance."""
        if tolerance is None:
            indices = range(NEAR_ROUNDOFF, TIGHTEST + 1)
            tried = [self._trial(problem, tolerance_of(i)) for i in indices]
            return min(tried, key=lambda x: x.error)
        run, chosen, build = self._built(problem, tolerance)
        rows, calls, _ = run()
        return Trial(run, chosen, build, calls, *problem.measure(rows, problem.expected))

    def _built(self, problem: ReferenceProblem, tolerance: float) -> tuple[_Run, float, float]:
        """Return a function that runs the code, the code's tolerance, and the building time [s]."""
        raise NotImplementedError


@dataclass(eq=False)
class Heyoka(TimedCode):
    """heyoka's adaptive Taylor integrator.

    Attributes
    ----------
    counts
        See `TimedCode`.
    is_compact
        True if the loops are rolled.
    """

    counts: str = "steps"
    is_compact: bool = True
    _build: dict[int, float] = field(default_factory=dict, init=False, repr=False)

    def _trial(self, problem: ReferenceProblem, tolerance: float | None) -> Trial:
        times, expected = problem.times, problem.expected
        if self.precision == "binary128" and not has_binary128():
            raise Unavailable("not in this version of heyoka")
        number = NativeNumbers(Precision.of(self.precision)).type
        if self.precision == "binary128":
            expected = problem.reference.rows
            exact = [problem.maneuver.time(i) for i in range(problem.maneuver.rows)]
            times = np.array([number(t.numerator) / number(t.denominator) for t in exact])
        start = problem.start(number)
        begin = time.perf_counter()
        integrator = TaylorIntegrator(
            right_hand_side(problem.bicycle, Precision.of(self.precision), with_yaw=False),
            start,
            number,
            is_compact=self.is_compact,
            tolerance=None if tolerance is None else number(tolerance),
        )
        # heyoka compiles once for each order; integrators that are made later reuse the code. So
        # the building time is that of the first integrator of this order.
        build = self._build.setdefault(integrator.order, time.perf_counter() - begin)

        columns = problem.columns(number)

        def run() -> tuple[Array, int, Array]:
            integrator.begin(times[0], start)
            rows, steps = integrator.over(times)
            return rows, steps, columns(rows)

        rows, steps, _ = run()
        return Trial(
            run, integrator.tolerance, build, steps, *problem.measure(rows, expected),
            order=integrator.order,
        )  # fmt: skip


@dataclass(eq=False)
class Tuned(TimedCode):
    """The fast simulation of this package, at a tolerance per step; all maneuvers run at once."""

    counts: str = "steps"
    _build: float = field(default=0.0, init=False, repr=False)

    def at(self, tolerance: float | None) -> Trial:
        """Build and measure the code; None means the tolerance of `simulate` for roundoff."""
        if tolerance is None:
            tolerance = ACCURACIES["roundoff"]
        problems = self.problems
        begin = time.perf_counter()
        run = prepare(
            [x.maneuver for x in problems], bicycle=problems[0].bicycle, tolerance=tolerance
        )
        # All tolerances use the same compiled code, so the time for building it is measured only
        # once.
        build = self._build = self._build or time.perf_counter() - begin
        run()
        states = run.states()
        measured = [p.measure(x, p.expected) for p, x in zip(problems, states, strict=True)]
        performance, error = (max(x) for x in zip(*measured, strict=True))
        return Trial(run, tolerance, build, sum(run.steps), performance, error)


class SciPy(TimedCode):
    """A method of ``scipy.integrate.solve_ivp`` with rtol = atol, but rtol at least 2.2e-14."""

    def _built(self, problem: ReferenceProblem, tolerance: float) -> tuple[_Run, float, float]:
        solve_ivp = _import("scipy.integrate").solve_ivp
        start, times, method = problem.start(float), problem.times, self.name.split()[-1]
        (slope, build), columns = problem.slope, problem.columns()

        def run() -> tuple[Array, int, Array]:
            found = solve_ivp(
                slope, (times[0], times[-1]), start, method=method, t_eval=times,
                rtol=max(tolerance, _MIN_RTOL), atol=tolerance,
            )  # fmt: skip
            return found.y.T, found.nfev, columns(found.y.T)

        return run, tolerance, build


class Compiled(TimedCode):
    """A Runge-Kutta method with right-hand side and columns in C; see `compiled`."""

    @cached_property
    def _peers(self) -> tuple[CompiledPeers, float]:
        begin = time.perf_counter()
        try:
            peers = CompiledPeers(self.problems[0].bicycle)
        except NoCompilerError as e:
            raise Unavailable(str(e)) from None
        return peers, time.perf_counter() - begin

    def _built(self, problem: ReferenceProblem, tolerance: float) -> tuple[_Run, float, float]:
        peers, build = self._peers
        start, times = problem.start(float), problem.times
        method = self.name.split()[-1]
        # RK4 has a fixed step. Its error is proportional to the fourth power of the step, so use
        # the fourth root of the tolerance as the step.
        chosen = tolerance**0.25 if method == "RK4" else tolerance

        def run() -> tuple[Array, int, Array]:
            states, columns, calls = peers.solve(method, start, times, chosen)
            return states.T if calls > 0 else states.T[:0], calls, columns

        return run, chosen, build


class Sundials(TimedCode):
    """CVODE of SUNDIALS with its Adams methods and rtol = atol, through scikit-sundae."""

    def _built(self, problem: ReferenceProblem, tolerance: float) -> tuple[_Run, float, float]:
        cvode = _import("sksundae.cvode").CVODE
        columns, start, times = problem.columns(), problem.start(float), problem.times
        slope, build = problem.slope

        def rates(t: float, y: Array, out: Array) -> None:
            out[:] = slope(t, y)

        solver = cvode(rates, method="Adams", rtol=tolerance, atol=tolerance)

        def run() -> tuple[Array, int, Array]:
            found = solver.solve(times, start)
            return found.y, found.nfev, columns(found.y)

        return run, tolerance, build


@dataclass(eq=False)
class Exudyn(TimedCode):
    """The four-body model in Exudyn (``data/peers``), which has a fixed step.

    Some of its columns have other definitions, see `_EXUDYN`.
    """

    counts: str = "steps"
    # Numbers of steps per row to try, coarsest first. The method is of second order, so reaching
    # smaller errors would take too long.
    steps_per_row: tuple[int, ...] = (1, 2, 4, 8)

    @cached_property
    def _model(self) -> ModuleType:
        _import("exudyn")
        path = data_folder() / "peers" / "exudyn_bicycle.py"
        spec = importlib.util.spec_from_file_location("exudyn_bicycle", path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        # The module defines dataclasses, and a dataclass looks up its module in sys.modules.
        sys.modules[spec.name] = module
        spec.loader.exec_module(module)
        return module

    def _trial(self, problem: ReferenceProblem, tolerance: float | None) -> Trial:
        """Measure with the largest step that meets the limit of eq. (1); ignore the tolerance.

        Raises
        ------
        Unavailable
            Exudyn is not installed, or the maneuver starts leaning or steered, which its model does
            not support.
        """
        peer, m = self._model, problem.maneuver
        if not (m.roll.is_zero and m.steer.is_zero and m.steer_rate.is_zero):
            raise Unavailable("starts upright")
        p = {symbol: float(x) for symbol, x in problem.bicycle.values.items()}
        maneuver = peer.Maneuver(
            float(m.speed), float(m.roll_rate), float(m.duration), float(m.spacing)
        )
        for count in self.steps_per_row:
            step = maneuver.spacing / count

            def run(step: float = step) -> Array:
                found: Array = peer.run(p, maneuver, step)[0]
                return found

            performance, error = problem.measure_columns(run().T, _EXUDYN)
            if performance < performance_limit():
                break
        return Trial(run, step, 0.0, round(maneuver.duration / step), performance, error)


_EXUDYN = {
    "roll_angle": "roll_angle_tait_bryan_xyz",
    "roll_rate": "roll_rate_body_x",
    "forward_speed": "forward_speed_hub_body_x",
}
"""Definitions of Exudyn's columns, see ``data/peers/README.md``."""


def _import(module: str) -> ModuleType:
    try:
        return importlib.import_module(module)
    except ImportError:
        raise Unavailable("not installed") from None


def codes(problems: Sequence[ReferenceProblem]) -> list[TimedCode]:
    """Return all codes that are compared, including those that are not installed."""
    return [
        Tuned("heyoka_bike simulate", problems),
        Heyoka("heyoka", problems),
        Heyoka("heyoka unrolled", problems, is_compact=False),
        Heyoka("heyoka", problems, "binary128"),
        Compiled("C DOPRI5", problems),
        Compiled("C DOP853", problems),
        Compiled("C RK4", problems),
        SciPy("SciPy DOP853", problems),
        SciPy("SciPy LSODA", problems),
        Sundials("SUNDIALS CVODE", problems),
        Exudyn("Exudyn", problems),
    ]


CLASSES: Mapping[str, str] = {
    "performance": "(a) loosest tolerance with eq. (1) under 1e-3 %",
    "state_error": "(b) loosest tolerance with a state error under 1e-12",
    "roundoff": "(c) roundoff: heyoka's default tolerance, the best that the others reach",
}
"""The common property of the codes of each class."""

OnPart = Callable[[str, float], None]
"""Called with a description of the current work and the completed fraction, 0 to 1."""

# Total time for all runs of a code [s], and minimum number of runs. A slow code has fewer runs, but
# at least this many.
_SECONDS, _MIN_RUNS = 3.0, 3
_WARM = 0.003  # duration of the untimed warm-up runs [s]; a longer run warms up by itself
_COLD_RUNS = 5
_BYTES_PAST_CACHES = 64 * 2**20  # [bytes], more than the processor's caches can store
# Tolerances of the work-precision figure, as indices of the grid of tolerances. There are two per
# decade.
_TOLERANCES_SWEPT = range(2 * PER_DECADE, TIGHTEST, PER_DECADE // 2)
_SWEEP_RUNS, _SWEEP_SECONDS = 10, 0.5


@dataclass(eq=False)
class Timing:
    """A code in a class of `CLASSES`, and its computing times.

    Attributes
    ----------
    accuracy_class
        Key of `CLASSES`.
    code
        The code that is timed.
    status
        ``ok``, or the reason why there are no times.
    trial
        The code at its tolerance in this class.
    times, cold
        Times of the runs [s], warm and cold.
    """

    accuracy_class: str
    code: TimedCode
    status: str = "ok"
    trial: Trial | None = None
    times: list[float] = field(default_factory=list)
    cold: list[float] = field(default_factory=list)


def bench(
    problems: Sequence[ReferenceProblem],
    runs: int,
    *,
    is_quick: bool = False,
    progress: OnPart | None = None,
) -> list[Timing]:
    """Time every code in every class of accuracy; the codes of a class take turns.

    Parameters
    ----------
    problems
        One maneuver or several; a run covers all of them, and the largest error counts.
    runs
        Timed runs of each code; fewer (at least 3) if they would take longer than 3 s.
    is_quick
        Leave out the unrolled form of heyoka, which takes long to build.

    Raises
    ------
    MissingPackageError
        heyoka is not installed; it also provides the right-hand side.
    """
    report = progress or (lambda what, done: None)
    every = codes(problems)
    trials = [cache(code.at) for code in every]
    lines: list[Timing] = []
    with _quiet():
        for i, accuracy_class in enumerate(CLASSES):
            group = [Timing(accuracy_class, code) for code in every]
            lines += group
            passed = 0
            for j, line in enumerate(group):
                done = (i + j / len(group) / 2) / len(CLASSES)
                report(f"{accuracy_class}: preparing {line.code.name}", done)
                if is_quick and line.code.name == "heyoka unrolled":
                    line.status = "left out"
                    continue
                # Unrolled code and binary128 have the same truncation error as compact code in
                # binary64. So their trials begin with the tolerance found for the compact code in
                # binary64.
                is_form = isinstance(line.code, Heyoka) and passed > 0
                _prepare(line, trials[j], passed if is_form else None)
                if isinstance(line.code, Heyoka) and line.trial is not None and not passed:
                    passed = round(-PER_DECADE * math.log10(line.trial.tolerance))

            def timed(part: float, i: int = i, name: str = accuracy_class) -> None:
                report(f"{name}: timing", (i + (1 + part) / 2) / len(CLASSES))

            _race([x for x in group if x.trial is not None], runs, timed)
    return lines


def work_precision(problem: ReferenceProblem, progress: OnPart | None = None) -> list[Measured]:
    """Measure each available code at many tolerances, except compact heyoka and Exudyn.

    The tolerance is in the code's own sense; ``min_ms`` is the time of the shortest run [ms].
    """
    points = []
    chosen = [
        x
        for x in codes([problem])
        if not isinstance(x, Heyoka | Exudyn) or x.name == "heyoka unrolled"
    ]
    with _quiet(), _pinned():
        for j, code in enumerate(chosen):
            for k, i in enumerate(_TOLERANCES_SWEPT):
                if progress is not None:
                    part = (j + k / len(_TOLERANCES_SWEPT)) / len(chosen)
                    progress(f"work and precision: {code.name}", part)
                try:
                    trial = code.at(tolerance_of(i))
                except Unavailable:
                    break
                if not math.isfinite(trial.error):
                    continue
                once = seconds(trial.run)
                count = min(_SWEEP_RUNS, int(_SWEEP_SECONDS / once))
                shortest = min([once, *(seconds(trial.run) for _ in range(count))])
                points.append({
                    "code": code.name, "precision": code.precision, "tolerance": trial.tolerance,
                    "min_ms": 1e3 * shortest, "performance_percent": trial.performance,
                    "max_state_error": trial.error,
                })  # fmt: skip
    return points


def _prepare(line: Timing, at: Callable[[float | None], Trial], first: int | None) -> None:
    """Choose the tolerance of a code in its class; try none that is looser than index `first`."""

    def excess_of(trial: Trial) -> float:
        """Return the logarithm of the ratio of the error to its limit."""
        if line.accuracy_class == "performance":
            ratio = trial.performance / performance_limit()
        else:
            ratio = trial.error / ERROR_LIMIT
        return math.log10(min(max(ratio, 1e-99), 1e99))

    def excess(i: int) -> float:
        return excess_of(at(tolerance_of(i)))

    try:
        if isinstance(line.code, Exudyn):
            # `Exudyn` ignores the tolerance: it uses the largest step that meets the limit of eq.
            # (1). So it takes part only in the class "performance".
            line.trial = at(None)
            if line.accuracy_class != "performance" or excess_of(line.trial) >= 0:
                line.trial = None
        elif line.accuracy_class == "roundoff":
            line.trial = at(None)
        else:
            found = _loosest(excess) if first is None else _first(excess, first)
            line.trial = None if found is None else at(tolerance_of(found))
    except Unavailable as e:
        line.status = str(e)
        return
    if line.trial is None or math.isinf(line.trial.error):
        line.status, line.trial = "not reached", None


def _loosest(excess: Callable[[int], float]) -> int | None:
    """Return the index of the loosest tolerance that meets the limit; None if none does."""
    # The error is about proportional to the tolerance, so one trial gives an estimate of the
    # tolerance needed.
    i = min(max(MIDDLE + round(PER_DECADE * excess(MIDDLE)), 0), TIGHTEST)
    if excess(i) >= 0:
        return _first(excess, i + 1)
    while i > 0 and excess(i - 1) < 0:
        i -= 1
    return i


def _first(excess: Callable[[int], float], start: int) -> int | None:
    return next((i for i in range(start, TIGHTEST + 1) if excess(i) < 0), None)


def _race(lines: Sequence[Timing], runs: int, progress: Callable[[float], None]) -> None:
    """Time the codes in turns on one processor: first warm, then cold."""
    trials = [line.trial for line in lines if line.trial is not None]
    with _pinned():
        counts = [min(runs, max(_MIN_RUNS, int(_SECONDS / seconds(trial.run)))) for trial in trials]
        gc.collect()
        gc.disable()
        try:
            for turn in range(max(counts, default=0)):
                for line, trial, count in zip(lines, trials, counts, strict=True):
                    if turn < count:
                        line.times.append(_warm_time(trial))
                progress((turn + 1) / max(counts))
            other = np.zeros(_BYTES_PAST_CACHES, dtype=np.uint8)
            for turn in range(_COLD_RUNS):
                for line, trial, count in zip(lines, trials, counts, strict=True):
                    if turn < count:
                        other += 1
                        line.cold.append(seconds(trial.run))
        finally:
            gc.enable()


def _warm_time(trial: Trial) -> float:
    """Return the time of a run that directly follows other runs of the same code."""
    took = spent = seconds(trial.run)
    while spent < _WARM:
        took = seconds(trial.run)
        spent += took
    return took


@contextmanager
def _pinned() -> Iterator[None]:
    """Keep the process on one processor in this context, if the system supports this."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(before)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


@contextmanager
def _quiet() -> Iterator[None]:
    """Switch off warnings, and the caches of heyoka, which would make later builds faster."""
    with caches_off(), warnings.catch_warnings(), np.errstate(all="ignore"):
        # At very loose and very tight tolerances, some codes overflow or warn that they cannot
        # continue.
        warnings.simplefilter("ignore")
        yield

"""The codes that are compared; each is built and measured at a tolerance in its own sense.

Each carries the maneuvers out one after the other, or, the fast path of this package, at once.
"""

from __future__ import annotations

import importlib.util
import sys
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import ModuleType

import numpy as np

from heyoka_bike.motion.expressions import require_heyoka
from heyoka_bike.motion.integrate import right_hand_side
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.bench.compiled import CompiledPeers, NoCompilerError
from heyoka_bike.workbench.bench.problem import (
    PERFORMANCE_LIMIT,
    Array,
    ReferenceProblem,
    Trial,
    Unavailable,
)
from heyoka_bike.workbench.fast.simulate import ACCURACIES, prepare

PER_DECADE = 8
"""Number of tolerances of the grid in a decade."""
MIDDLE, NEAR_ROUNDOFF, TIGHTEST = 4 * PER_DECADE, 13 * PER_DECADE, 16 * PER_DECADE
"""Indices of the tolerances 1e-4, 1e-13, 1e-16."""

_Run = Callable[[], tuple[Array, int, Array]]
"""Gives states, calls of the right-hand side, and columns."""

_MIN_RTOL = 100 * float(np.finfo(np.float64).eps)  # SciPy goes no lower


def tolerance_of(index: int) -> float:
    """The grid on which tolerances are searched."""
    return float(10 ** (-index / PER_DECADE))


@dataclass(eq=False)
class TimedCode:
    """A code for one maneuver or several, one after the other at the same tolerance.

    Attributes
    ----------
    name
        As shown in the table.
    problems
        What is integrated.
    precision
        Of its numbers, as shown in the table.
    counts
        What `Trial.count` counts.
    """

    name: str
    problems: Sequence[ReferenceProblem]
    precision: str = "binary64"
    counts: str = "rhs_calls"

    def at(self, tolerance: float | None) -> Trial:
        """Build and measure; without a tolerance each maneuver has its own, the largest is told.

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
        """Build and measure on one maneuver, None for the code's tolerance for roundoff."""
        raise NotImplementedError


@dataclass(eq=False)
class Heyoka(TimedCode):
    """heyoka's adaptive Taylor integrator.

    Attributes
    ----------
    counts
        See `TimedCode`.
    is_compact
        Whether its loops are rolled.
    """

    counts: str = "steps"
    is_compact: bool = True
    _build: dict[int, float] = field(default_factory=dict, init=False, repr=False)

    def _trial(self, problem: ReferenceProblem, tolerance: float | None) -> Trial:
        hy = require_heyoka()
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
        # The compiled code depends on the order only and is reused: the first build counts.
        build = self._build.setdefault(integrator.order, time.perf_counter() - begin)

        columns = problem.columns(number)

        def run() -> tuple[Array, int, Array]:
            integrator.time = times[0]
            integrator.state[:] = start
            _, _, _, steps, _, rows = integrator.propagate_grid(times)
            return rows, steps, columns(rows)

        rows, steps, _ = run()
        return Trial(
            run, float(integrator.tol), build, steps, *problem.measure(rows, expected),
            order=integrator.order,
        )  # fmt: skip


@dataclass(eq=False)
class Tuned(TimedCode):
    """The fast path of this package, by the tolerance of its steps; all maneuvers at once."""

    counts: str = "steps"
    _build: float = field(default=0.0, init=False, repr=False)

    def at(self, tolerance: float | None) -> Trial:
        """Build and measure at a tolerance, None for the one of `simulate` for roundoff."""
        if tolerance is None:
            tolerance = ACCURACIES["roundoff"]
        problems = self.problems
        begin = time.perf_counter()
        run = prepare(
            [x.maneuver for x in problems], bicycle=problems[0].bicycle, tolerance=tolerance
        )
        # The compiled code serves all tolerances: the first build counts.
        build = self._build = self._build or time.perf_counter() - begin
        run()
        states = run.states()
        measured = [p.measure(x, p.expected) for p, x in zip(problems, states, strict=True)]
        performance, error = (max(x) for x in zip(*measured, strict=True))
        return Trial(run, tolerance, build, sum(run.steps), performance, error)


class _Peer(TimedCode, ABC):
    """A code whose steps are chosen by a tolerance; that of roundoff is of the smallest error."""

    def _trial(self, problem: ReferenceProblem, tolerance: float | None) -> Trial:
        if tolerance is None:
            indices = range(NEAR_ROUNDOFF, TIGHTEST + 1)
            tried = [self._trial(problem, tolerance_of(i)) for i in indices]
            return min(tried, key=lambda x: x.error)
        run, chosen, build = self._built(problem, tolerance)
        rows, calls, _ = run()
        return Trial(run, chosen, build, calls, *problem.measure(rows, problem.expected))

    @abstractmethod
    def _built(self, problem: ReferenceProblem, tolerance: float) -> tuple[_Run, float, float]:
        """A run, the tolerance in the code's own sense, and the time of building it [s]."""


class SciPy(_Peer):
    """A method of ``scipy.integrate.solve_ivp``, at rtol = atol; rtol stops at 2.2e-14."""

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


class Compiled(_Peer):
    """A Runge-Kutta method in C with the right-hand side and columns in C, see `compiled`."""

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
        # The error of RK4 goes with the fourth power of the step.
        chosen = tolerance**0.25 if method == "RK4" else tolerance

        def run() -> tuple[Array, int, Array]:
            states, columns, calls = peers.solve(method, start, times, chosen)
            return states.T if calls > 0 else states.T[:0], calls, columns

        return run, chosen, build


class Sundials(_Peer):
    """CVODE of SUNDIALS by its Adams methods, through scikit-sundae, at rtol = atol."""

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
    """The four-body model in Exudyn of ``data/peers``, at a fixed step; its own definitions."""

    counts: str = "steps"
    # A row needs a step; of second order, it does not get to small errors in any time.
    steps_per_row: tuple[int, ...] = (1, 2, 4, 8)

    @cached_property
    def _model(self) -> ModuleType:
        _import("exudyn")
        path = data_folder() / "peers" / "exudyn_bicycle.py"
        spec = importlib.util.spec_from_file_location("exudyn_bicycle", path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        # A dataclass looks up the module it is in.
        sys.modules[spec.name] = module
        spec.loader.exec_module(module)
        return module

    def _trial(self, problem: ReferenceProblem, tolerance: float | None) -> Trial:
        """Measure at the largest step that keeps eq. (1), for any tolerance.

        Raises
        ------
        Unavailable
            Exudyn is not installed, or starts leaning or steered, which its model does not.
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
            if performance < PERFORMANCE_LIMIT:
                break
        return Trial(run, step, 0.0, round(maneuver.duration / step), performance, error)


_EXUDYN = {
    "roll_angle": "roll_angle_tait_bryan_xyz",
    "roll_rate": "roll_rate_body_x",
    "forward_speed": "forward_speed_hub_body_x",
}
"""Definitions of its columns, see ``data/peers/README.md``."""


def _import(module: str) -> ModuleType:
    try:
        return importlib.import_module(module)
    except ImportError:
        raise Unavailable("not installed") from None


def codes(problems: Sequence[ReferenceProblem]) -> list[TimedCode]:
    """Every code there is, installed or not, for one maneuver or several."""
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

"""Time of a maneuver at equal accuracy, with heyoka and with other integrators.

The task is the same for every code: all eight columns at the rows of a maneuver, from the same
initial state and the same equations. Codes are compared in three classes, see `CLASSES`. In the
first two the tolerance of each code is searched on a grid of eight values a decade for one that
passes while the next looser one fails. Building is timed apart, with heyoka's caches of compiled
code off. The codes of a class run in turns on one processor: *warm*, after a run of their own that
is not counted, and a few times *cold*, after the processor's caches were filled with something
else.
"""

import gc
import math
import os
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from heyoka_bike.motion.expressions import require_heyoka
from heyoka_bike.workbench.bench import codes
from heyoka_bike.workbench.bench.problem import (
    ERROR_LIMIT,
    PERFORMANCE_LIMIT,
    ReferenceProblem,
    Trial,
    Unavailable,
    seconds,
)

CLASSES: Mapping[str, str] = {
    "performance": "(a) loosest tolerance with eq. (1) under 1e-3 %",
    "state_error": "(b) loosest tolerance with a state error under 1e-12",
    "roundoff": "(c) roundoff: heyoka's default tolerance, the best that the others reach",
}
"""The common properties of the codes of a class."""

Progress = Callable[[str, float], None]
"""Called with what is being done and the part done of the whole, 0 to 1."""

_SECONDS, _MIN_RUNS = 3.0, 3  # a slow code is run less often
_WARM = 0.003  # [s] of runs that are not counted; a run that takes longer warms up by itself
_COLD_RUNS = 5
_CACHE = 64 * 2**20  # bytes; the processor's caches are smaller
# Tolerances of the work-precision figure, as indices of the grid: two a decade.
_SWEEP = range(2 * codes.PER_DECADE, codes.TIGHTEST, codes.PER_DECADE // 2)
_SWEEP_RUNS, _SWEEP_SECONDS = 10, 0.5


@dataclass(eq=False)
class Timing:
    """A code in a class, with its times.

    Attributes
    ----------
    accuracy_class
        Key of `CLASSES`.
    code
        What is timed.
    status
        ``ok``, or why it has no times.
    trial
        The code at the tolerance that was found for it.
    times, cold
        Of the runs [s], warm and cold.
    """

    accuracy_class: str
    code: codes.TimedCode
    status: str = "ok"
    trial: Trial | None = None
    times: list[float] = field(default_factory=list)
    cold: list[float] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Point:
    """A code at a tolerance.

    Attributes
    ----------
    code, precision
        Its name and number type.
    tolerance
        In the code's own sense.
    min_ms
        Shortest of the runs [ms].
    performance_percent, max_state_error
        Eq. (1) [%] and state error.
    """

    code: str
    precision: str
    tolerance: float
    min_ms: float
    performance_percent: float
    max_state_error: float


def bench(
    problems: Sequence[ReferenceProblem],
    runs: int,
    *,
    is_quick: bool = False,
    progress: Progress | None = None,
) -> list[Timing]:
    """Time every code in every class, the codes of a class in turns.

    Parameters
    ----------
    problems
        One maneuver, or several: then a run is all of them, and the largest error counts.
    runs
        Timed runs of each code; fewer (but 3) of one that would take longer than 3 s.
    is_quick
        Leave out what takes long to build: the unrolled form of heyoka.

    Raises
    ------
    MissingPackageError
        heyoka is not installed; the right-hand side comes from it too.
    """
    report = progress or (lambda what, done: None)
    every = codes.codes(problems)
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
                # The other forms of heyoka have its truncation error: they start where it passed.
                is_form = isinstance(line.code, codes.Heyoka) and passed > 0
                _prepare(line, trials[j], passed if is_form else None)
                if isinstance(line.code, codes.Heyoka) and line.trial is not None and not passed:
                    passed = round(-codes.PER_DECADE * math.log10(line.trial.tolerance))

            def timed(part: float, i: int = i, name: str = accuracy_class) -> None:
                report(f"{name}: timing", (i + (1 + part) / 2) / len(CLASSES))

            _race([x for x in group if x.trial is not None], runs, timed)
    return lines


def work_precision(problem: ReferenceProblem, progress: Progress | None = None) -> list[Point]:
    """Each code that is there at many tolerances; heyoka in compact mode and Exudyn not."""
    points = []
    chosen = [
        x
        for x in codes.codes([problem])
        if not isinstance(x, codes.Heyoka | codes.Exudyn) or x.name == "heyoka unrolled"
    ]
    with _quiet(), _pinned():
        for j, code in enumerate(chosen):
            for k, i in enumerate(_SWEEP):
                if progress is not None:
                    part = (j + k / len(_SWEEP)) / len(chosen)
                    progress(f"work and precision: {code.name}", part)
                try:
                    trial = code.at(codes.tolerance_of(i))
                except Unavailable:
                    break
                if not math.isfinite(trial.error):
                    continue
                once = seconds(trial.run)
                count = min(_SWEEP_RUNS, int(_SWEEP_SECONDS / once))
                shortest = min([once, *(seconds(trial.run) for _ in range(count))])
                measured = trial.tolerance, 1e3 * shortest, trial.performance, trial.error
                points.append(Point(code.name, code.precision, *measured))
    return points


def _prepare(line: Timing, at: Callable[[float | None], Trial], first: int | None) -> None:
    """Choose the tolerance of a code in its class, no looser than that of index `first`."""

    def excess_of(trial: Trial) -> float:
        """Logarithm of the error over its limit."""
        if line.accuracy_class == "performance":
            ratio = trial.performance / PERFORMANCE_LIMIT
        else:
            ratio = trial.error / ERROR_LIMIT
        return math.log10(min(max(ratio, 1e-99), 1e99))

    def excess(i: int) -> float:
        return excess_of(at(codes.tolerance_of(i)))

    try:
        if isinstance(line.code, codes.Exudyn):
            # Its steps are chosen by itself, for the first class.
            line.trial = at(None)
            if line.accuracy_class != "performance" or excess_of(line.trial) >= 0:
                line.trial = None
        elif line.accuracy_class == "roundoff":
            line.trial = at(None)
        else:
            found = _loosest(excess) if first is None else _first(excess, first)
            line.trial = None if found is None else at(codes.tolerance_of(found))
    except Unavailable as e:
        line.status = str(e)
        return
    if line.trial is None or math.isinf(line.trial.error):
        line.status, line.trial = "not reached", None


def _loosest(excess: Callable[[int], float]) -> int | None:
    """Index of a tolerance that passes while the next looser one fails; None if there is none."""
    # Errors are about proportional to tolerances: one trial says where to look.
    i = min(max(codes.MIDDLE + round(codes.PER_DECADE * excess(codes.MIDDLE)), 0), codes.TIGHTEST)
    if excess(i) >= 0:
        return _first(excess, i + 1)
    while i > 0 and excess(i - 1) < 0:
        i -= 1
    return i


def _first(excess: Callable[[int], float], start: int) -> int | None:
    return next((i for i in range(start, codes.TIGHTEST + 1) if excess(i) < 0), None)


def _race(lines: Sequence[Timing], runs: int, progress: Callable[[float], None]) -> None:
    """Time the codes in turns, after one run of each that is not counted."""
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
            other = np.zeros(_CACHE, dtype=np.uint8)
            for turn in range(_COLD_RUNS):
                for line, trial, count in zip(lines, trials, counts, strict=True):
                    if turn < count:
                        other += 1
                        line.cold.append(seconds(trial.run))
        finally:
            gc.enable()


def _warm_time(trial: Trial) -> float:
    """Time of a run after others of the same code."""
    took = spent = seconds(trial.run)
    while spent < _WARM:
        took = seconds(trial.run)
        spent += took
    return took


@contextmanager
def _pinned() -> Iterator[None]:
    """On one processor, where the system lets a process choose."""
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
    """Heyoka's own caches off, so that building is timed as the first time, and no warnings."""
    state: Any = require_heyoka().llvm_state
    was_enabled = state.get_diskcache_enabled()
    state.set_diskcache_enabled(False)
    state.clear_memcache()
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        # Far from their limits the peers overflow, or complain that they cannot go on.
        warnings.simplefilter("ignore")
        try:
            yield
        finally:
            state.set_diskcache_enabled(was_enabled)

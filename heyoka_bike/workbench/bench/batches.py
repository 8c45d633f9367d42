"""Measure the fast simulation in batches, in long runs, at the first call, and its limit.

The `floor` is the time that a processor needs for only the products of Taylor steps. A step of
order n has (n + 1) (n + 2) / 2 products of numbers for each product of two variables of the
decomposition, each quotient, sine and cosine, and n + 1 for each product with a constant. The peak
rate is measured with independent fused products and sums of whole vectors.
"""

import ctypes
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from statistics import median

import numpy as np

from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.workbench.bench.compiled import operations
from heyoka_bike.workbench.bench.problem import Measured, seconds
from heyoka_bike.workbench.fast.ensemble import Ensemble
from heyoka_bike.workbench.fast.simulate import prepare
from heyoka_bike.workbench.fast.vector_code import LANES, Code, Loop, function, fused, module

_CHAINS = 12  # number of independent chains; it exceeds the latency of a product in cycles
_LOOPS, _TURNS, _RUNS_OF_BATCHES = 5_000, 40, 20
_COUNTED_OPERATIONS = ("*", "/", "sin", "cos")


def floor(bicycle: Bicycle) -> Measured:
    """Count the products of a Taylor step, and measure how many a processor makes per second.

    The result has the peak rate (binary64 products with a sum, per second). For each step it has
    the number of products of two variables of the decomposition (including quotients, sines and
    cosines), and of products with a constant.
    """
    count = operations(bicycle)
    products = sum(count.get(x, 0) for x in _COUNTED_OPERATIONS)
    return {"products_per_second": _peak(), "products": products, "scales": count["scale"]}


def _peak() -> float:
    c = Code("void @peak(ptr)")
    (memory,) = c.arguments
    loops = c.variable(0)
    with Loop(c) as loop:
        loop.leave(loops[0] >= _LOOPS)
        values = memory.vectors().load(_CHAINS)
        # Each product waits only for the previous product of its own chain, and `_TURNS` products
        # follow without access to memory. So the products alone determine the time.
        for _ in range(_TURNS):
            values = fused(values, 0.5, values)
        memory.vectors().store(values)
        loops[0] += 1
    c.do("ret void")
    run = function(module(c), "peak", None, ctypes.c_void_p)
    numbers = (ctypes.c_double * (LANES * _CHAINS))()
    shortest = min(seconds(lambda: run(numbers)) for _ in range(_RUNS_OF_BATCHES))
    return _LOOPS * _TURNS * _CHAINS * LANES / shortest


ENSEMBLES = (1e-6, "roundoff")
"""Accuracies of the ensembles."""

DURATIONS = (10, 100, 1000, 10_000)
"""Durations of the long runs [s]."""
LONG = ("eq1", 1e-12, "roundoff")
"""Accuracies of the long runs; each has the meaning that it has for 10 s."""

_LONG_ROWS, _LONG_SECONDS = 1001, 1.0
_MOTIONS = 4000
_SECONDS_OF_MOTION = 10.0  # [s]
_ENSEMBLE_TURNS, _STARTS_COMPARED = 7, 5
# Ranges of the initial conditions of the benchmark's maneuvers. Within these ranges the motion
# stays upright.
_RANGE_OF_SPEEDS, _ROLL_RATES, _STEER_RATES = (4.3, 9.0), (-0.5, 0.5), (-0.4, 0.4)
_SEED = 1

_FIRST_RESULT = """
import time
begin = time.perf_counter()
import numpy
imported = time.perf_counter()
from heyoka_bike import simulate
simulate(2)
print(imported - begin, time.perf_counter() - imported)
"""


def throughput() -> list[Measured]:
    """Measure how many motions of 10 s an `Ensemble` computes per second, by threads.

    Runs with one thread and with two take turns; only the ends of the motions are computed.

    The result has the motions per second for each accuracy and number of threads, from the shortest
    time.
    """
    random = np.random.default_rng(_SEED)
    starts = np.zeros((_MOTIONS, 5))
    for column, limits in ((2, _ROLL_RATES), (3, _STEER_RATES), (4, _RANGE_OF_SPEEDS)):
        starts[:, column] = random.uniform(*limits, _MOTIONS)
    counts = [n for n in (1, 2) if n <= (os.cpu_count() or 1)]
    found = []
    for accuracy in ENSEMBLES:
        ensembles = [Ensemble(accuracy=accuracy, threads=n) for n in counts]
        runs = [partial(e.ends, starts, _SECONDS_OF_MOTION) for e in ensembles]
        times = _in_turns(runs, _ENSEMBLE_TURNS)
        for n, x in zip(counts, times, strict=True):
            rate = _MOTIONS / min(x)
            found.append({"accuracy": accuracy, "threads": n, "motions_per_second": rate})
    return found


def long_runs(
    bicycle: Bicycle, maneuver: Maneuver, durations: Sequence[int] = DURATIONS,
    accuracies: Sequence[float | str] = LONG, *, most_turns: int = 30,
) -> list[Measured]:  # fmt: skip
    """Measure a maneuver at each duration [s] and each accuracy, always with 1001 rows.

    In each result ``time`` is the shortest of the runs [s] and ``performance`` is eq. (1) [%].
    ``error`` is that of the last state, in the variables of the few-product form, compared with a
    run in 80-bit long double.
    """
    found = []
    for duration in durations:
        m = replace(maneuver, duration=Fraction(duration), spacing=Fraction(duration))
        right = integrate(bicycle, m, "longdouble").state(m.duration)
        for accuracy in accuracies:
            run = prepare(m, bicycle=bicycle, accuracy=accuracy, rows=_LONG_ROWS)
            turns = min(most_turns, 1 + int(_LONG_SECONDS / seconds(run)))
            (times,) = _in_turns([run], turns)
            pairs = zip(run.states()[0][-1], right, strict=False)
            error = float(max(abs(x - float(y.mid())) for x, y in pairs))
            energy = run()["mechanical_energy"]
            performance = float(100 * np.ptp(energy) / energy[0])
            found.append({
                "accuracy": accuracy, "duration": duration, "steps": run.steps[0],
                "time": min(times), "performance": performance, "error": error,
            })  # fmt: skip
    return found


def first_result() -> Measured:
    """Time maneuver 2 in new processes, without cached compiled code.

    The result has the median times [s] of importing NumPy, and of the first result after it.
    """
    command = [sys.executable, "-c", _FIRST_RESULT]
    found = [subprocess.check_output(command).split() for _ in range(_STARTS_COMPARED)]
    imported, took = (median(map(float, x)) for x in zip(*found, strict=True))
    return {"import_numpy_s": imported, "result_s": took}


def _in_turns(runs: Sequence[Callable[[], object]], turns: int) -> list[list[float]]:
    """Time each run once per turn, after an untimed run of the same function."""
    times: list[list[float]] = [[] for _ in runs]
    for _ in range(turns):
        for run, found in zip(runs, times, strict=True):
            run()
            found.append(seconds(run))
    return times

"""The code with which processor times are compared, measured right after each run."""

import time

import numpy as np

from heyoka_bike import load_reference
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.parameters import read_bicycle, read_maneuvers
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers
from heyoka_bike.workbench.bench.compiled import CompiledPeers
from heyoka_bike.workbench.bench.problem import ReferenceProblem

NAME = "Runge-Kutta 4 in C, h = 0.001 s"
STEP = 1e-3  # [s]
# The shortest counts: something else may have had the processor in the others.
RUNS = 20


class Peer:
    """The method of `heyoka-bike bench` on this project's equations, compiled here."""

    def __init__(self):
        reference, bicycle = load_reference(), read_bicycle(benchmark_bicycle())
        maneuvers = read_maneuvers(benchmark_maneuvers())
        self._seconds = float(sum(m.duration for m in maneuvers))
        numbered = enumerate(maneuvers, start=1)
        self._problems = [ReferenceProblem(bicycle, m, reference[i]) for i, m in numbered]
        self._starts = [p.start(float) for p in self._problems]
        self._compiled = CompiledPeers(bicycle)

    def said(self):
        """Its name, and the correct digits of its worst value."""
        return {"name": NAME, "digits": round(float(min(self._digits())), 1)}

    def time(self):
        """Processor time of the three maneuvers, all columns included [s]."""
        times = []
        for _ in range(RUNS):
            begin = time.process_time()
            self._columns()
            times.append(time.process_time() - begin)
        return min(times)

    def beside(self, cpu, seconds):
        """Its time, and that of a run over its own for as many seconds of motion.

        Its steps are all of one size: its time grows as the motion does.
        """
        beside = self.time()
        ratio = cpu / beside * self._seconds / seconds
        return {"peer": round(beside, 5), "ratio": float(f"{ratio:.3g}")}

    def _columns(self):
        return [
            self._compiled.solve("RK4", start, problem.times, STEP)[1]
            for problem, start in zip(self._problems, self._starts, strict=True)
        ]

    def _digits(self):
        for problem, found in zip(self._problems, self._columns(), strict=True):
            for name, column in zip(BENCHMARK_COLUMNS, found, strict=True):
                right = problem.reference.rows.hi[name]
                yield -np.log10(np.abs(column - right).max() / np.abs(right).max())

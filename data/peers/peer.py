"""The code beside which processor times are given: the classical Runge-Kutta method in C."""

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

    def __init__(self, number):
        reference, bicycle = load_reference(), read_bicycle(benchmark_bicycle())
        maneuver = read_maneuvers(benchmark_maneuvers())[number - 1]
        self._problem = ReferenceProblem(bicycle, maneuver, reference[number])
        self._start = self._problem.start(float)
        self._compiled = CompiledPeers(bicycle)

    def time(self):
        """Processor time of the maneuver, all columns included [s]."""
        times = []
        for _ in range(RUNS):
            begin = time.process_time()
            self._columns()
            times.append(time.process_time() - begin)
        return min(times)

    def digits(self):
        """The correct digits of its worst value."""
        rows = self._problem.reference.rows.hi
        return min(
            round(float(-np.log10(np.abs(found - rows[name]).max() / np.abs(rows[name]).max())), 1)
            for name, found in zip(BENCHMARK_COLUMNS, self._columns(), strict=True)
        )

    def _columns(self):
        return self._compiled.solve("RK4", self._start, self._problem.times, STEP)[1]

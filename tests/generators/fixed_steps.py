"""Result files of fixed-step integrators.

They use the few-product form of the equations with the variables (roll, pitch, steer, w1, w3, spin,
yaw), not those in which error shapes are computed, or optionally the regular form.
"""

from fractions import Fraction

import heyoka as hy
import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.constants import constants
from heyoka_bike.bicycle.equations.kinematics import unfold
from heyoka_bike.bicycle.equations.outputs import columns
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.motion.heyoka_adapter import Expressions
from heyoka_bike.motion.integrate import right_hand_side
from heyoka_bike.numbers.arithmetic import Multiprecision
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.scoring.reading.results import Quantum, Results, Rows

SPACING = 0.01
VELOCITIES = [3, 4, 5]

TABLEAUX = {
    "euler": ([[]], [1]),
    "heun": ([[], [1]], [1 / 2, 1 / 2]),
    "midpoint": ([[], [1 / 2]], [0, 1]),
    "kutta3": ([[], [1 / 2], [-1, 2]], [1 / 6, 2 / 3, 1 / 6]),
    "ssp3": ([[], [1], [1 / 4, 1 / 4]], [1 / 6, 1 / 6, 2 / 3]),
    "rk4": ([[], [1 / 2], [0, 1 / 2], [0, 0, 1]], [1 / 6, 1 / 3, 1 / 3, 1 / 6]),
    "rk4_other_weights": ([[], [1 / 2], [0, 1 / 2], [0, 0, 1]], [1 / 6, 2 / 6, 1 / 6, 2 / 6]),
    "three_eighths": ([[], [1 / 3], [-1 / 3, 1], [1, -1, 1]], [1 / 8, 3 / 8, 3 / 8, 1 / 8]),
}


class Equations:
    """Compiled right-hand side, outputs and initial states of a reference's bicycle."""

    def __init__(self, reference, is_regular=False):
        self.reference = reference
        values = {s: Exact.parse(x) for s, x in reference.parameters.items()}
        bicycle = Bicycle(reference.bicycle, values)
        equations = right_hand_side(bicycle, Precision.of("binary64"), is_regular=is_regular)
        state = [x for x, _ in equations]
        self._slope = hy.cfunc([rate for _, rate in equations], state)
        k = constants(bicycle, Multiprecision(25)).convert(float)
        o, u = unfold(k, Expressions(), state, is_regular=is_regular)
        found = columns(k, Expressions(), o, u, state[0], state[1], state[2], state[6])
        self._outputs = hy.cfunc([found[name] for name in BENCHMARK_COLUMNS], state)
        tilt = float(values["lam"])
        starts = []
        for n in reference:
            speed, rate = (float(Fraction(reference[n].inputs[x])) for x in ("speed", "roll_rate"))
            # The bicycle is upright and straight with zero yaw rate. The roll rate is resolved
            # along axes that are tilted like the steer axis.
            spin = speed / float(values["rR"])
            rates = [rate, 0] if is_regular else [rate * np.cos(tilt), rate * np.sin(tilt)]
            starts.append([0, 0, 0, *rates, spin, 0])
        self.start = np.array(starts).T

    def slope(self, y):
        return self._slope(np.ascontiguousarray(y))

    def outputs(self, y):
        return self._outputs(np.ascontiguousarray(y))

    def results(self, states):
        """Return results from states of shape (7, maneuvers, rows)."""
        parts = []
        for i, n in enumerate(self.reference):
            m = self.reference[n]
            values = dict(zip(BENCHMARK_COLUMNS, self.outputs(states[:, i]), strict=True))
            quantum = dict.fromkeys(values, Quantum(2, 53))
            parts.append(Rows(n, m.time, m.time_lo, values, quantum=quantum))
        return Results("fixed steps", "text", tuple(parts), 16)

    def run(self, step, h, memory=None):
        """Return results of a step function (state, h, memory) with constant h."""
        y, rows, inner = self.start, [self.start], round(SPACING / h)
        memory = {} if memory is None else memory
        for _ in range(1000):
            for _ in range(inner):
                y = step(y, h, memory)
            rows.append(y)
        return self.results(np.stack(rows, axis=2))

    def explicit(self, name):
        a, b = TABLEAUX[name]

        def step(y, h, _):
            stages = []
            for row in a:
                inner = sum((x * k for x, k in zip(row, stages, strict=True)), 0 * y)
                stages.append(self.slope(y + h * inner))
            return y + h * sum(x * k for x, k in zip(b, stages, strict=True))

        return step

    def solve(self, known, weight, guess):
        """Return the z with z = known + weight f(z)."""
        z = guess
        for _ in range(60):
            z, before = known + weight * self.slope(z), z
            if np.max(np.abs(z - before)) < 1e-15:
                break
        return z

    def implicit(self, theta):
        """Return a step of the trapezoidal rule (theta = 1/2) or of implicit Euler (theta = 1)."""
        return lambda y, h, _: self.solve(y + (1 - theta) * h * self.slope(y), theta * h, y)

    def bdf2(self, y, h, memory):
        before = memory.get("y")
        memory["y"] = y
        if before is None:
            return self.implicit(0.5)(y, h, memory)
        return self.solve((4 * y - before) / 3, 2 / 3 * h, y)

    def adams_bashforth2(self, y, h, memory):
        before, now = memory.get("f"), self.slope(y)
        memory["f"] = now
        if before is None:
            return self.implicit(0.5)(y, h, memory)
        return y + h * (1.5 * now - 0.5 * before)

    def symplectic_euler(self, y, h, _):
        z = y.copy()
        z[VELOCITIES] += h * self.slope(y)[VELOCITIES]
        rates = self.slope(z)
        rates[VELOCITIES] = 0.0
        return z + h * rates

"""Newton's and Euler's equations of the four bodies as a DAE of index 2, by SUNDIALS IDA.

``simulate`` is what `../field.py` calls. Unknowns: places (12), quaternions (16), velocities (12),
angular velocities (12) of the bodies in global axes, and 21 reactions of three hinges and two
rolling wheels, whose constraints are those of the velocities.
"""

import time

import numpy as np
from equations.bodies import DOWN, Bodies, attitudes, turning
from sksundae.ida import IDA


def parts(y):
    """Places, quaternions, velocities and angular velocities of the unknowns."""
    shapes = zip((0, 12, 28, 40), (12, 28, 40, 52), (3, 4, 3, 3), strict=True)
    return [y[i:j].reshape(4, n) for i, j, n in shapes]


class Dae(Bodies):
    """The residual, and how often it was called."""

    calls = 0

    def residual(self, _, y, rates, out):
        """Zero of the DAE."""
        self.calls += 1
        _, q, _, w = parts(y)
        a = attitudes(q)
        rows = self.rows(a)
        tensors = a @ self.tensors @ a.transpose(0, 2, 1)
        spin = np.einsum("bij,bj->bi", tensors, w)
        out[:12] = rates[:12] - y[28:40]
        out[12:28] = rates[12:28] - turning(q, w).ravel()
        force = self.mass[:, None] * (rates[28:40].reshape(4, 3) - self.p["g"] * DOWN)
        torque = np.einsum("bij,bj->bi", tensors, rates[40:52].reshape(4, 3)) + np.cross(w, spin)
        out[28:52] = np.concatenate([force.ravel(), torque.ravel()]) - rows.T @ y[52:]
        out[52:] = rows @ y[28:52]

    def unknowns(self, speed, roll_rate):
        """Unknowns at the start, and their rates."""
        y, rates = np.zeros(73), np.zeros(73)
        _, q, v, w = start = self.start(speed, roll_rate)
        y[:52] = np.concatenate([x.ravel() for x in start])
        rates[:28] = np.concatenate([v.ravel(), turning(q, w).ravel()])
        rates[28:52], y[52:] = self.accelerations(q, v, w)
        return y, rates


def simulate(p, speed, roll_rate, tolerance, absolute=None, rate=100):
    """Rows of the eight columns, `rate` a second; processor time [s]; calls of the residual."""
    bicycle = Dae(p)
    # The reactions are not tested for errors: their tolerance is a large one.
    absolute = tolerance if absolute is None else absolute
    solver = IDA(
        bicycle.residual, rtol=tolerance, atol=np.repeat([absolute, 1e6], [52, 21]),
        algebraic_idx=list(range(52, 73)), max_num_steps=100000,
    )  # fmt: skip
    start = bicycle.unknowns(speed, roll_rate)
    begin = time.process_time()
    found = solver.solve(np.arange(1001) / rate, *start)
    cpu = time.process_time() - begin
    if len(found.y) != 1001:
        raise RuntimeError(found.message)
    rows = [bicycle.columns(*parts(y)) for y in found.y]
    return np.array(rows), cpu, {"calls": bicycle.calls}

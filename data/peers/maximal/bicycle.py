"""Four free bodies with Lagrange multipliers, by the classical Runge-Kutta method in NumPy.

``simulate`` is what `../field.py` calls. This is what a textbook tells to write first: the
accelerations follow from the constraints differentiated once more, places and attitudes are not
brought back to the constraints; ``project`` brings the velocities back after each step.
"""

import time

import numpy as np
from equations.bodies import Bodies, attitudes, turning


def simulate(p, speed, roll_rate, step, project=False, rate=100):
    """Rows of the eight columns, `rate` a second, and the processor time of the simulation [s]."""
    bicycle = Bodies(p)

    def rates(state):
        _, q, v, w = state
        accelerations, _ = bicycle.accelerations(q, v, w)
        return [v, turning(q, w), *accelerations.reshape(2, 4, 3)]

    def ahead(state, slope, h):
        return [x + h * k for x, k in zip(state, slope, strict=True)]

    def one_step(state, h):
        k1 = rates(state)
        k2 = rates(ahead(state, k1, h / 2))
        k3 = rates(ahead(state, k2, h / 2))
        k4 = rates(ahead(state, k3, h))
        slope = [(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)]
        places, q, v, w = ahead(state, slope, h)
        q /= np.linalg.norm(q, axis=1, keepdims=True)
        if project:
            rows, u = bicycle.rows(attitudes(q)), np.concatenate([v.ravel(), w.ravel()])
            v, w = (u - np.linalg.pinv(rows) @ (rows @ u)).reshape(2, 4, 3)
        return [places, q, v, w]

    state, found, cpu = bicycle.start(speed, roll_rate), [], 0.0
    for row in range(1001):
        begin = time.process_time()
        for _ in range(round(1 / rate / step) if row else 0):
            state = one_step(state, step)
        cpu += time.process_time() - begin
        found.append(bicycle.columns(*state))
    return np.array(found), cpu

"""Newton's and Euler's equations of the four bodies as a DAE of index 2, by SUNDIALS IDA.

``simulate`` is what `../field.py` calls. Unknowns: places (12), quaternions (16), velocities (12),
angular velocities (12) of the bodies in global axes, and 21 reactions of three hinges and two
rolling wheels, whose constraints are those of the velocities. z is down, y to the right.
"""

import time

import numpy as np
from sksundae.ida import IDA

DOWN, AXLE = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
BODIES, B, H, R, F = "BHRF", 0, 1, 2, 3


def cross_matrices(a):
    """Of vectors (..., 3), the matrices (..., 3, 3) that multiply as their cross products do."""
    x, y, z = np.moveaxis(a, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def attitudes(q):
    """Matrices of the bodies' quaternions, which need not be of length one."""
    q = q / np.linalg.norm(q, axis=1, keepdims=True)
    w, k = q[:, 0, None, None], cross_matrices(q[:, 1:])
    return np.eye(3) + 2 * w * k + 2 * k @ k


class Bicycle:
    """Mass, force and constraints at a state."""

    def __init__(self, p):
        self.p, self.calls = p, 0
        self.mass = np.array([p[f"m{b}"] for b in BODIES])
        self.tensors = np.zeros((4, 3, 3))
        for tensor, b in zip(self.tensors, BODIES, strict=True):
            xx, xz = p[f"I{b}xx"], p.get(f"I{b}xz", 0.0)
            tensor[:] = [[xx, 0, xz], [0, p[f"I{b}yy"], 0], [xz, 0, p.get(f"I{b}zz", xx)]]
        self.centres = np.array([
            [p["xB"], 0, p["zB"]], [p["xH"], 0, p["zH"]], [0, 0, -p["rR"]], [p["w"], 0, -p["rF"]]
        ])  # fmt: skip
        self.steer = np.array([np.sin(p["lam"]), 0, np.cos(p["lam"])])
        foot = np.array([p["w"] + p["c"], 0, 0])
        along_x, across = np.array([1.0, 0, 0]), np.cross(self.steer, AXLE)
        self.hinges = (
            (B, R, self.centres[R], AXLE, (along_x, DOWN)),
            (H, F, self.centres[F], AXLE, (along_x, DOWN)),
            (B, H, foot, self.steer, (AXLE, across)),
        )

    def rows(self, a):
        """The constraints of velocities and angular velocities, shape (21, 24)."""
        found = np.zeros((21, 8, 3))
        for i, (one, other, point, axis, acrosses) in enumerate(self.hinges):
            row = found[5 * i : 5 * i + 5]
            row[:3, one], row[:3, other] = np.eye(3), -np.eye(3)
            row[:3, 4 + one] = -cross_matrices(a[one] @ (point - self.centres[one]))
            row[:3, 4 + other] = cross_matrices(a[other] @ (point - self.centres[other]))
            for j, across in enumerate(acrosses):
                normal = np.cross(a[one] @ across, a[other] @ axis)
                row[3 + j, 4 + one], row[3 + j, 4 + other] = normal, -normal
        for i, (wheel, radius) in enumerate(((R, self.p["rR"]), (F, self.p["rF"]))):
            axle = a[wheel] @ AXLE
            to = DOWN - axle[2] * axle
            row = found[15 + 3 * i : 18 + 3 * i]
            row[:, wheel] = np.eye(3)
            row[:, 4 + wheel] = -cross_matrices(radius * to / np.linalg.norm(to))
        return found.reshape(21, 24)

    def residual(self, _, y, rates, out):
        """Zero of the DAE."""
        self.calls += 1
        q, w = y[12:28].reshape(4, 4), y[40:52].reshape(4, 3)
        a = attitudes(q)
        rows = self.rows(a)
        tensors = a @ self.tensors @ a.transpose(0, 2, 1)
        spin = np.einsum("bij,bj->bi", tensors, w)
        out[:12] = rates[:12] - y[28:40]
        turning = np.empty((4, 4))
        turning[:, 0] = -np.sum(w * q[:, 1:], axis=1) / 2
        turning[:, 1:] = (q[:, :1] * w + np.cross(w, q[:, 1:])) / 2
        out[12:28] = rates[12:28] - turning.ravel()
        force = self.mass[:, None] * (rates[28:40].reshape(4, 3) - self.p["g"] * DOWN)
        torque = np.einsum("bij,bj->bi", tensors, rates[40:52].reshape(4, 3)) + np.cross(w, spin)
        out[28:52] = np.concatenate([force.ravel(), torque.ravel()]) - rows.T @ y[52:]
        out[52:] = rows @ y[28:52]

    def start(self, speed, roll_rate):
        """Unknowns and their rates; the constraints' change is that of a short way ahead."""
        roll = np.array([roll_rate, 0, 0])
        y, rates = np.zeros(73), np.zeros(73)
        y[:12], y[12:28:4] = self.centres.ravel(), 1.0
        y[28:40] = (np.array([speed, 0, 0]) + np.cross(roll, self.centres)).ravel()
        spins = np.tile(roll, (4, 1))
        spins[R] -= speed / self.p["rR"] * AXLE
        spins[F] -= speed / self.p["rF"] * AXLE
        y[40:52] = spins.ravel()
        out = np.zeros(73)
        self.residual(0, y, rates, out)
        rates[:28] = -out[:28]
        ahead = attitudes((y[12:28] + 1e-6 * rates[12:28]).reshape(4, 4))
        behind = attitudes((y[12:28] - 1e-6 * rates[12:28]).reshape(4, 4))
        drift = (self.rows(ahead) - self.rows(behind)) @ y[28:52] / 2e-6
        rows, system = self.rows(attitudes(y[12:28].reshape(4, 4))), np.zeros((45, 45))
        system[:12, :12] = np.diag(np.repeat(self.mass, 3))
        for i in range(4):
            system[12 + 3 * i : 15 + 3 * i, 12 + 3 * i : 15 + 3 * i] = self.tensors[i]
        system[:24, 24:], system[24:, :24] = -rows.T, rows
        found = np.linalg.solve(system, np.concatenate([-out[28:52], -drift]))
        rates[28:52], y[52:] = found[:24], found[24:]
        return y, rates

    def columns(self, y):
        """Lean and its rate, speed of the rear hub along its heading, energies, steer."""
        a, v, w = attitudes(y[12:28].reshape(4, 4)), y[28:40].reshape(4, 3), y[40:52].reshape(4, 3)
        own = np.einsum("bji,bj->bi", a, w)
        potential = -self.p["g"] * self.mass @ y[2:12:3]
        kinetic = (
            self.mass @ np.sum(v * v, axis=1) + np.einsum("bi,bij,bj", own, self.tensors, own)
        ) / 2
        left, turned, axis = a[B] @ AXLE, a[H] @ AXLE, a[B] @ self.steer
        heading = np.cross(left, DOWN) / np.hypot(left[0], left[1])
        steer = np.arctan2(np.cross(left, turned) @ axis, left @ turned)
        return [
            np.arcsin(left[2]), w[B] @ heading, v[R] @ heading, potential, kinetic,
            potential + kinetic, steer, (w[H] - w[B]) @ axis,
        ]  # fmt: skip


def simulate(p, speed, roll_rate, tolerance, rate=100):
    """Rows of the eight columns, `rate` a second; processor time [s]; calls of the residual."""
    bicycle = Bicycle(p)
    # The reactions are not tested for errors: their tolerance is a large one.
    absolute = np.concatenate([np.full(52, tolerance), np.full(21, 1e6)])
    solver = IDA(
        bicycle.residual, rtol=tolerance, atol=absolute, algebraic_idx=list(range(52, 73)),
        max_num_steps=100000,
    )  # fmt: skip
    start = bicycle.start(speed, roll_rate)
    begin, bicycle.calls = time.process_time(), 0
    found = solver.solve(np.arange(1001) / rate, *start)
    cpu = time.process_time() - begin
    if len(found.y) != 1001:
        raise RuntimeError(found.message)
    return np.array([bicycle.columns(y) for y in found.y]), cpu, {"calls": bicycle.calls}

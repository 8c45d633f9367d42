"""Newton's and Euler's equations of the four bodies, with the 21 constraints of their velocities.

Three hinges and two rolling wheels. Places and velocities are in global axes; z is down, y to the
right. `../ida/bicycle.py` gives them to a solver of DAEs, `../maximal/bicycle.py` steps them.
"""

import numpy as np

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


def turning(q, w):
    """Rates of quaternions from angular velocities in global axes."""
    found = np.empty((4, 4))
    found[:, 0] = -np.sum(w * q[:, 1:], axis=1) / 2
    found[:, 1:] = (q[:, :1] * w + np.cross(w, q[:, 1:])) / 2
    return found


class Bodies:
    """Masses, forces and constraints of four bodies that are free but for hinges and wheels."""

    def __init__(self, p):
        self.p = p
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

    def drift(self, a, v, w):
        """How the constraints of the velocities change while these stay what they are, (21,)."""
        found = np.zeros(21)
        for i, (one, other, point, axis, acrosses) in enumerate(self.hinges):
            arms = [(b, a[b] @ (point - self.centres[b])) for b in (one, other)]
            first, second = (np.cross(w[b], np.cross(w[b], arm)) for b, arm in arms)
            found[5 * i : 5 * i + 3] = first - second
            for j, across in enumerate(acrosses):
                left, right = a[one] @ across, a[other] @ axis
                change = np.cross(np.cross(w[one], left), right)
                change += np.cross(left, np.cross(w[other], right))
                found[5 * i + 3 + j] = change @ (w[one] - w[other])
        for i, (wheel, radius) in enumerate(((R, self.p["rR"]), (F, self.p["rF"]))):
            axle = a[wheel] @ AXLE
            turning = np.cross(w[wheel], axle)
            to = DOWN - axle[2] * axle
            change, length = -turning[2] * axle - axle[2] * turning, np.linalg.norm(to)
            moving = radius * (change / length - to * (to @ change) / length**3)
            found[15 + 3 * i : 18 + 3 * i] = np.cross(w[wheel], moving)
        return found

    def accelerations(self, q, v, w):
        """Of places and angles in global axes, (24,), and the 21 reactions; by multipliers."""
        a = attitudes(q)
        rows, system = self.rows(a), np.zeros((45, 45))
        tensors = a @ self.tensors @ a.transpose(0, 2, 1)
        system[:12, :12] = np.diag(np.repeat(self.mass, 3))
        for i in range(4):
            system[12 + 3 * i : 15 + 3 * i, 12 + 3 * i : 15 + 3 * i] = tensors[i]
        system[:24, 24:], system[24:, :24] = -rows.T, rows
        weight = self.p["g"] * self.mass[:, None] * DOWN
        torque = -np.cross(w, np.einsum("bij,bj->bi", tensors, w))
        right = np.concatenate([weight.ravel(), torque.ravel(), -self.drift(a, v, w)])
        found = np.linalg.solve(system, right)
        return found[:24], found[24:]

    def start(self, speed, roll_rate):
        """Places, quaternions, velocities, angular velocities: upright, straight on."""
        roll = np.array([roll_rate, 0, 0])
        quaternions, spins = np.zeros((4, 4)), np.tile(roll, (4, 1))
        quaternions[:, 0] = 1.0
        spins[R] -= speed / self.p["rR"] * AXLE
        spins[F] -= speed / self.p["rF"] * AXLE
        velocities = np.array([speed, 0, 0]) + np.cross(roll, self.centres)
        return self.centres.copy(), quaternions, velocities, spins

    def columns(self, places, q, v, w):
        """Lean and its rate, speed of the rear hub along its heading, energies, steer."""
        a = attitudes(q)
        own = np.einsum("bji,bj->bi", a, w)
        potential = -self.p["g"] * self.mass @ places[:, 2]
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

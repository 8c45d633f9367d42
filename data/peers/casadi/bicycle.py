"""The four bodies of the uncontrolled bicycle in CasADi's symbols, integrated by its IDAS.

``simulate`` is what `../field.py` calls. States: places, quaternions, velocities in global axes and
angular velocities in the bodies' own. CasADi's integrators take algebraic equations of index 1, so
the constraints of the velocities are differentiated once, by CasADi; accelerations and multipliers
are the algebraic unknowns. Nothing brings the constraints back. z is down, y to the right.
"""

import time

import casadi as ca
import numpy as np

DOWN, AXLE = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
BODIES = "BHRF"


def attitude(q):
    """Matrix of a quaternion, which need not be of length one."""
    w, k = q[0], ca.skew(q[1:])
    return ca.SX.eye(3) + 2 * (w * k + k @ k) / ca.dot(q, q)


class Model:
    """States and rates as symbols; the equations, and the columns of a state."""

    def __init__(self, p):
        self.p = p
        centres = {
            "B": [p["xB"], 0, p["zB"]], "H": [p["xH"], 0, p["zH"]],
            "R": [0, 0, -p["rR"]], "F": [p["w"], 0, -p["rF"]],
        }  # fmt: skip
        self.centres = {b: np.array(x) for b, x in centres.items()}
        self.steer = np.array([np.sin(p["lam"]), 0, np.cos(p["lam"])])
        places, q, v, w = (
            {b: ca.SX.sym(f"{name}{b}", n) for b in BODIES}
            for name, n in (("x", 3), ("q", 4), ("v", 3), ("w", 3))
        )
        a = {b: attitude(q[b]) for b in BODIES}
        self.state = ca.vertcat(*(part[b] for part in (places, q, v, w) for b in BODIES))
        self.speeds = ca.vertcat(*(part[b] for part in (v, w) for b in BODIES))
        turning = {
            b: ca.vertcat(-ca.dot(q[b][1:], w[b]), q[b][0] * w[b] + ca.cross(q[b][1:], w[b])) / 2
            for b in BODIES
        }
        slopes = ca.vertcat(*(v[b] for b in BODIES), *(turning[b] for b in BODIES))
        constraints = ca.vertcat(
            self.hinge(a, v, w, "B", "R", self.centres["R"], AXLE),
            self.hinge(a, v, w, "H", "F", self.centres["F"], AXLE),
            self.hinge(a, v, w, "B", "H", np.array([p["w"] + p["c"], 0, 0]), self.steer),
            *(self.rolling(a, v, w, b) for b in "RF"),
        )
        rows = ca.jacobian(constraints, self.speeds)
        positions = self.state[: slopes.numel()]
        drift = ca.jtimes(constraints, positions, slopes)
        self.accelerations = ca.SX.sym("a", 24)
        multipliers = ca.SX.sym("m", constraints.numel())
        forces = rows.T @ multipliers
        motion = [
            p[f"m{b}"] * (self.accelerations[3 * i : 3 * i + 3] - p["g"] * DOWN)
            for i, b in enumerate(BODIES)
        ]
        motion += [
            tensor @ self.accelerations[12 + 3 * i : 15 + 3 * i] + ca.cross(w[b], tensor @ w[b])
            for i, b in enumerate(BODIES)
            for tensor in [self.tensor(b)]
        ]
        self.equations = {
            "x": self.state,
            "z": ca.vertcat(self.accelerations, multipliers),
            "ode": ca.vertcat(slopes, self.accelerations),
            "alg": ca.vertcat(ca.vertcat(*motion) - forces, rows @ self.accelerations + drift),
        }
        self.columns = ca.Function("columns", [self.state], [self.shown(places, a, v, w)])

    def tensor(self, b):
        """Inertia in a body's own axes."""
        xx, xz = self.p[f"I{b}xx"], self.p.get(f"I{b}xz", 0.0)
        zz = self.p.get(f"I{b}zz", xx)
        return np.array([[xx, 0, xz], [0, self.p[f"I{b}yy"], 0], [xz, 0, zz]])

    def hinge(self, a, v, w, one, other, point, axis):
        """Five velocities that vanish; the hinge is where the point is at the start."""
        at = [v[b] + a[b] @ ca.cross(w[b], point - self.centres[b]) for b in (one, other)]
        apart = a[one].T @ (a[other] @ w[other]) - w[one]
        across = ca.nullspace(ca.DM(axis).T)
        return ca.vertcat(at[0] - at[1], across.T @ apart)

    def rolling(self, a, v, w, b):
        """The velocity of a wheel's lowest point."""
        axle = a[b] @ AXLE
        to = DOWN - axle[2] * axle
        return v[b] + ca.cross(a[b] @ w[b], self.p[f"r{b}"] * to / ca.norm_2(to))

    def shown(self, places, a, v, w):
        """The eight columns."""
        left, turned, axis = a["B"] @ AXLE, a["H"] @ AXLE, a["B"] @ self.steer
        heading = ca.cross(left, DOWN) / ca.norm_2(left[:2])
        spins = {b: a[b] @ w[b] for b in BODIES}
        potential = -sum(self.p["g"] * self.p[f"m{b}"] * places[b][2] for b in BODIES)
        kinetic = sum(
            (self.p[f"m{b}"] * ca.dot(v[b], v[b]) + w[b].T @ self.tensor(b) @ w[b]) / 2
            for b in BODIES
        )
        return ca.vertcat(
            ca.asin(left[2]), ca.dot(spins["B"], heading), ca.dot(v["R"], heading), potential,
            kinetic, potential + kinetic,
            ca.atan2(ca.dot(ca.cross(left, turned), axis), ca.dot(left, turned)),
            ca.dot(spins["H"] - spins["B"], axis),
        )  # fmt: skip

    def start(self, speed, roll_rate):
        """State of the upright bicycle that goes straight on."""
        roll = np.array([roll_rate, 0, 0])
        spins = dict.fromkeys(BODIES, roll)
        spins |= {b: roll - speed / self.p[f"r{b}"] * AXLE for b in "RF"}
        velocities = [np.array([speed, 0, 0]) + np.cross(roll, self.centres[b]) for b in BODIES]
        places = [self.centres[b] for b in BODIES]
        return np.concatenate([*places, *[np.eye(4)[0]] * 4, *velocities, *spins.values()])


def simulate(p, speed, roll_rate, tolerance, absolute=None, rate=100):
    """Rows of the eight columns, `rate` a second; processor time [s]; steps."""
    model, times = Model(p), np.arange(1001) / rate
    asked = {
        "reltol": tolerance, "abstol": tolerance if absolute is None else absolute,
        "max_num_steps": 1000000,
    }  # fmt: skip
    integrator = ca.integrator("bicycle", "idas", model.equations, 0, times[1:], asked)
    start = model.start(speed, roll_rate)
    begin = time.process_time()
    found = integrator(x0=start)["xf"].full()
    cpu = time.process_time() - begin
    states = np.column_stack([start, found])
    rows = np.array([model.columns(y).full()[:, 0] for y in states.T])
    return rows, cpu, {"steps": int(integrator.stats()["nsteps"])}

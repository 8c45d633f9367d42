"""The uncontrolled bicycle in Pinocchio: its tree of joints, rolling added by hand.

``simulate`` is what `../field.py` calls. Each wheel gives three rows: the material point of its rim
that is lowest stands still. They are the constraints of the accelerations, solved with the mass
matrix of Pinocchio; Runge-Kutta 4 with `pin.integrate`, or SciPy's DOP853 in each step's
chart. Axes: x forward, y left, z up.
"""

import time

import exported
import numpy as np
import pinocchio as pin
from outside import one_step

UP, AXLE = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])


def build(p):
    """The exported model, and the joints of the wheels with their radii; frames start parallel."""
    text = exported.model(p, "urdf", 0.0)
    model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    model.gravity.linear = -p["g"] * UP
    wheels = (("rear_axle", p["rR"]), ("front_axle", p["rF"]))
    return model, tuple((model.getJointId(name), radius) for name, radius in wheels)


def rolling(model, data, wheels):
    """Rows of the constraints, and what their accelerations are without those of the joints."""
    rows, right = [], []
    for joint, radius in wheels:
        axle = data.oMi[joint].rotation @ AXLE
        velocity = pin.getVelocity(model, data, joint, pin.LOCAL_WORLD_ALIGNED)
        drift = pin.getClassicalAcceleration(model, data, joint, pin.LOCAL_WORLD_ALIGNED)
        # From the hub to the lowest point, and how this arm changes.
        turning = np.cross(velocity.angular, axle)
        down, change = axle * axle[2] - UP, turning * axle[2] + axle * turning[2]
        length = np.linalg.norm(down)
        arm = radius * down / length
        moving = radius * (change / length - down * (down @ change) / length**3)
        jacobian = pin.getJointJacobian(model, data, joint, pin.LOCAL_WORLD_ALIGNED)
        rows.append(jacobian[:3] - pin.skew(arm) @ jacobian[3:])
        right.append(
            drift.linear + np.cross(drift.angular, arm) + np.cross(velocity.angular, moving)
        )
    return np.vstack(rows), np.concatenate(right)


def simulate(p, speed, roll_rate, step, method="rk4", chart=True, rate=100):
    """Rows of the eight columns, `rate` a second, and the processor time of the simulation [s].

    Speeds are not the rates of a quaternion's displacement: without ``chart``, which many leave
    out, Runge-Kutta 4 is of order 2. With the ``method`` dop853 each step is one of SciPy's DOP853.
    """
    model, wheels = build(p)
    data, n = model.createData(), model.nv

    def acceleration(q, v):
        bias = pin.nonLinearEffects(model, data, q, v)
        mass = pin.crba(model, data, q)
        pin.computeJointJacobians(model, data, q)
        pin.forwardKinematics(model, data, q, v, np.zeros(n))
        rows, drift = rolling(model, data, wheels)
        zero = np.zeros((len(rows), len(rows)))
        system = np.block([[mass, rows.T], [rows, zero]])
        return np.linalg.solve(system, np.concatenate([-bias, -drift]))[:n]

    def slope(q, u, v):
        """Rates of the displacement ``u`` from ``q`` and of the speeds."""
        a = acceleration(pin.integrate(model, q, u), v)
        return (np.linalg.solve(pin.dIntegrate(model, q, u, pin.ARG1), v) if chart else v), a

    def in_chart(q, v, h):
        def rates(y):
            return np.concatenate(slope(q, y[:n], y[n:]))

        y = one_step(rates, np.concatenate([np.zeros(n), v]), h)
        return pin.integrate(model, q, y[:n]), y[n:]

    def advance(q, v, h):
        if method == "dop853":
            return in_chart(q, v, h)
        if method == "euler":  # semi-implicit
            v = v + h * acceleration(q, v)
            return pin.integrate(model, q, h * v), v
        u1, a1 = slope(q, np.zeros(n), v)
        u2, a2 = slope(q, h / 2 * u1, v + h / 2 * a1)
        u3, a3 = slope(q, h / 2 * u2, v + h / 2 * a2)
        u4, a4 = slope(q, h * u3, v + h * a3)
        u = h / 6 * (u1 + 2 * u2 + 2 * u3 + u4)
        return pin.integrate(model, q, u), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)

    q = pin.neutral(model)
    rear, front = speed / p["rR"], speed / p["rF"]
    v = np.array([speed, 0, 0, roll_rate, 0, 0, rear, 0, front])
    found, cpu = [], 0.0
    for row in range(1001):
        begin = time.process_time()
        for _ in range(round(1 / rate / step) if row else 0):
            q, v = advance(q, v, step)
        cpu += time.process_time() - begin
        kinetic = pin.computeKineticEnergy(model, data, q, v)
        potential = pin.computePotentialEnergy(model, data, q)
        roll = pin.rpy.matrixToRpy(pin.Quaternion(q[3:7]).matrix())[0]
        steer = np.arctan2(q[10], q[9])
        hub = v[0] + v[4] * p["rR"]
        found.append([roll, v[3], hub, potential, kinetic, potential + kinetic, steer, v[7]])
    return np.array(found), cpu

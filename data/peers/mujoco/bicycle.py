"""The uncontrolled bicycle in MuJoCo: a free body, three hinges, two ellipsoids on a plane.

``simulate`` is what `../field.py` calls. MuJoCo has no rolling constraint: the wheels are thin
ellipsoids, held up and driven by its soft contact and friction. Axes: x forward, y left, z up.
"""

import time

import exported
import mujoco
import numpy as np

INTEGRATORS = {"Euler": "EULER", "implicit": "IMPLICIT", "RK4": "RK4"}
"""MuJoCo's names of its integrators, by those of its files."""


def build(p, thin):
    """The exported model as a specification; the origin of the base is moved to the rear hub.

    MuJoCo's steps depend on where it is: a free body moves with the velocity of its origin.
    """
    spec = mujoco.MjSpec.from_string(exported.model(p, "mjcf", 2 * thin))
    base, hub = spec.body("B"), np.array([0, 0, p["rR"]])
    base.pos += hub
    base.ipos -= hub
    for body in base.bodies:
        body.pos -= hub
    return spec


def simulate(
    p, speed, roll_rate, step, integrator="Euler", stiffness="0.02 1", impedance="0.9 0.95 0.001",
    cone="pyramidal", impratio=1, friction=1, tolerance=1e-8, thin=0.001, settle=0.0,
    softness=None, solver="Newton", rate=100,
):  # fmt: skip
    """Rows of the eight columns, `rate` a second, and the processor time of the simulation [s].

    Values by default are MuJoCo's own. ``softness`` is the time constant of the contact in steps,
    in place of the stiffness; ``settle`` [s] lets the standing bicycle sink into the floor before
    it starts.
    """
    if softness:
        stiffness = f"{softness * step} 1"
    spec = build(p, thin)
    option = spec.option
    option.timestep, option.impratio, option.tolerance = step, impratio, tolerance
    option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{INTEGRATORS[integrator]}")
    option.cone = getattr(mujoco.mjtCone, f"mjCONE_{cone.upper()}")
    option.solver = getattr(mujoco.mjtSolver, f"mjSOL_{solver.upper()}")
    option.iterations = 100
    option.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    for touching in spec.geoms:
        touching.friction[0] = friction
        touching.solref = [float(x) for x in stiffness.split()]
        touching.solimp[:3] = [float(x) for x in impedance.split()]
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, round(settle / step))
    data.time = 0.0
    # Velocity of the rear hub, angular velocity of the frame, rates of the three hinges.
    rear, front = speed / p["rR"], speed / p["rF"]
    data.qvel[:] = [speed, -roll_rate * p["rR"], 0, roll_rate, 0, 0, rear, 0, front]
    rows, cpu, each = [], 0.0, round(1 / rate / step)
    for row in range(1001):
        begin = time.process_time()
        if row:
            mujoco.mj_step(model, data, each)
        cpu += time.process_time() - begin
        mujoco.mj_forward(model, data)
        w, x, y, z = data.qpos[3:7]
        roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        along = data.body("B").xmat.reshape(3, 3)[:, 0]
        potential, kinetic = data.energy
        steer = data.joint("steer_axis")
        rows.append([
            roll, data.qvel[3], along @ data.qvel[:3], potential, kinetic, potential + kinetic,
            steer.qpos[0], steer.qvel[0],
        ])  # fmt: skip
    return np.array(rows), cpu

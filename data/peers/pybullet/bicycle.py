"""The uncontrolled bicycle in PyBullet: four links, two thin cylinders on a plane.

``simulate`` is what `../field.py` calls. Bullet has no rolling constraint: the wheels are cylinders
that its contact and friction hold. Axes: x forward, y left, z up.
"""

import tempfile
import time
from pathlib import Path

import exported
import numpy as np
import pybullet as bullet

LENGTHS = {"w": 1, "c": 1, "x": 1, "z": 1, "r": 1, "g": 1, "I": 2, "m": 0, "l": 0}
"""Power of the length in a parameter's unit, by its first letter."""


def simulate(
    p, speed, roll_rate, step, friction=0.5, width=0.002, damping=0.04, iterations=50, erp=0.2,
    breaking=0.02, residual=1e-7, scale=1, slop=1e-5, polygon=True, rate=100,
):  # fmt: skip
    """Rows of the eight columns, `rate` a second, and the processor time of the simulation [s].

    Values by default are Bullet's own, but for the width of the wheels [m].
    """
    p = {name: value * scale ** LENGTHS[name[0]] for name, value in p.items()}
    speed *= scale
    bullet.connect(bullet.DIRECT)
    bullet.setGravity(0, 0, -p["g"])
    bullet.setPhysicsEngineParameter(
        fixedTimeStep=step,
        numSolverIterations=iterations,
        contactERP=erp,
        contactBreakingThreshold=breaking,
        contactSlop=slop,
        solverResidualThreshold=residual,
    )
    plane = bullet.createMultiBody(0, bullet.createCollisionShape(bullet.GEOM_PLANE))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bicycle.urdf"
        path.write_text(exported.model(p, "urdf", width), encoding="utf-8")
        # Else Bullet takes the inertia of the shapes, and cylinders as polygons of 32 corners.
        flags = bullet.URDF_USE_INERTIA_FROM_FILE
        flags |= 0 if polygon else bullet.URDF_USE_IMPLICIT_CYLINDER
        bike = bullet.loadURDF(str(path), flags=flags)
    joint = {bullet.getJointInfo(bike, i)[1].decode(): i for i in range(3)}
    for body, number in ((plane, -1), *((bike, i) for i in range(-1, 3))):
        bullet.changeDynamics(
            body,
            number,
            lateralFriction=friction,
            linearDamping=damping,
            angularDamping=damping,
            maxJointVelocity=1e9,
        )
    for i in range(3):  # no motor, which has friction of its own
        bullet.setJointMotorControl2(bike, i, bullet.VELOCITY_CONTROL, force=0)
    rows, cpu, each = [], 0.0, round(1 / rate / step)
    height = -p["zB"]
    bullet.resetBaseVelocity(bike, [speed, -roll_rate * height, 0], [roll_rate, 0, 0])
    bullet.resetJointState(bike, joint["rear_axle"], 0, speed / p["rR"])
    bullet.resetJointState(bike, joint["front_axle"], 0, speed / p["rF"])
    for row in range(1001):
        begin = time.process_time()
        for _ in range(each if row else 0):
            bullet.stepSimulation()
        cpu += time.process_time() - begin
        rows.append(columns(p, bike, joint))
    bullet.disconnect()
    found = np.array(rows)
    found[:, 2] /= scale
    found[:, 3:6] /= scale**2
    return found, cpu


def columns(p, bike, joint):
    """What Bullet says of its bodies; roll of yaw-pitch-roll, rates and speed along the frame."""
    place, attitude = bullet.getBasePositionAndOrientation(bike)
    velocity, spin = bullet.getBaseVelocity(bike)
    _, turned = bullet.multiplyTransforms(
        [0, 0, 0], attitude, *bullet.invertTransform([0, 0, 0], bullet.getDynamicsInfo(bike, -1)[4])
    )
    frame = np.reshape(bullet.getMatrixFromQuaternion(turned), (3, 3))
    hub = np.array(velocity) + np.cross(spin, frame @ [-p["xB"], 0, p["rR"] + p["zB"]])
    states = [(p["mB"], place, velocity, attitude, spin, bullet.getDynamicsInfo(bike, -1)[2])]
    for name, body in (("rear_axle", "R"), ("steer_axis", "H"), ("front_axle", "F")):
        link = bullet.getLinkState(bike, joint[name], computeLinkVelocity=1)
        tensor = bullet.getDynamicsInfo(bike, joint[name])[2]
        states.append((p[f"m{body}"], link[0], link[6], link[1], link[7], tensor))
    potential = kinetic = 0.0
    for mass, centre, v, quaternion, w, tensor in states:
        own = np.reshape(bullet.getMatrixFromQuaternion(quaternion), (3, 3)).T @ w
        potential += mass * p["g"] * centre[2]
        kinetic += (mass * np.dot(v, v) + own @ (tensor * own)) / 2
    steer, steer_rate = bullet.getJointState(bike, joint["steer_axis"])[:2]
    roll = bullet.getEulerFromQuaternion(turned)[0]
    return [
        roll, frame[:, 0] @ spin, frame[:, 0] @ hub, potential, kinetic, potential + kinetic,
        steer, steer_rate,
    ]  # fmt: skip

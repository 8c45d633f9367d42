"""The uncontrolled bicycle in DART: a free body, three hinges, two wheels on a plane.

``simulate`` is what `../field.py` calls. DART has no rolling constraint: contact and friction are
impulses that the step's complementarity problem finds. Axes: x forward, y left, z up.
"""

import time

import dartpy as dart
import numpy as np

AXLE = np.array([0.0, 1.0, 0.0])


def placed(place, rotation=None):
    """Transformation of a frame at a place."""
    found = np.eye(4)
    found[:3, 3] = place
    if rotation is not None:
        found[:3, :3] = rotation
    return dart.math.Isometry3(found)


def bicycle(p, shape, thin, friction):
    """Skeleton with its bodies and hinges; frames are parallel at the start."""
    skeleton = dart.dynamics.Skeleton("bicycle")
    foot = np.array([p["w"] + p["c"], 0.0, -p["rR"]])  # steer axis on the floor, from the rear hub
    front = np.array([p["w"], 0.0, p["rF"] - p["rR"]]) - foot
    centres = {
        "B": np.array([p["xB"], 0, -p["zB"] - p["rR"]]), "R": np.zeros(3),
        "H": np.array([p["xH"], 0, -p["zH"] - p["rR"]]) - foot, "F": np.zeros(3),
    }  # fmt: skip
    bodies, hinges = {}, {}
    _, bodies["B"] = skeleton.createFreeJointAndBodyNodePair()
    steer = np.array([np.sin(p["lam"]), 0.0, -np.cos(p["lam"])])
    for parent, body, place, axis in (
        ("B", "R", np.zeros(3), AXLE), ("B", "H", foot, steer), ("H", "F", front, AXLE),
    ):  # fmt: skip
        joint, bodies[body] = skeleton.createRevoluteJointAndBodyNodePair(bodies[parent])
        joint.setAxis(axis)
        joint.setTransformFromParentBodyNode(placed(place))
        hinges[body] = joint
    for body, node in bodies.items():
        xx, xz = p[f"I{body}xx"], -p.get(f"I{body}xz", 0.0)  # z up changes the sign of the products
        tensor = [[xx, 0, xz], [0, p[f"I{body}yy"], 0], [xz, 0, p.get(f"I{body}zz", xx)]]
        node.setInertia(dart.dynamics.Inertia(p[f"m{body}"], centres[body], tensor))
    for wheel in ("R", "F"):
        r = p[f"r{wheel}"]
        if shape == "ellipsoid":
            touching = bodies[wheel].createShapeNode(
                dart.dynamics.EllipsoidShape([2 * r, thin, 2 * r])
            )
        else:  # its axis is z
            touching = bodies[wheel].createShapeNode(dart.dynamics.CylinderShape(r, thin))
            sideways = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
            touching.setRelativeTransform(placed(np.zeros(3), sideways))
        touching.createCollisionAspect()
        touching.createDynamicsAspect()
        touching.getDynamicsAspect().setFrictionCoeff(friction)
    return skeleton, bodies, hinges


def simulate(
    p, speed, roll_rate, step, detector="FCL", shape="ellipsoid", thin=0.002, friction=1.0,
    split=False, rate=100,
):  # fmt: skip
    """Rows of the eight columns, `rate` a second, and the processor time of the simulation [s].

    ``detector`` is DART's name of a collision detector, ``thin`` the width of the wheels [m].
    """
    world = dart.simulation.World()
    world.setTimeStep(step)
    world.setGravity([0, 0, -p["g"]])
    world.setCollisionDetector(getattr(dart.simulation.CollisionDetectorType, detector))
    floor = dart.dynamics.Skeleton("floor")
    _, ground = floor.createWeldJointAndBodyNodePair()
    plane = ground.createShapeNode(dart.dynamics.PlaneShape([0, 0, 1], 0))
    plane.createCollisionAspect()
    plane.createDynamicsAspect()
    plane.getDynamicsAspect().setFrictionCoeff(friction)
    skeleton, bodies, hinges = bicycle(p, shape, thin, friction)
    world.addSkeleton(floor)
    world.addSkeleton(skeleton)
    world.getConstraintSolver().setSplitImpulseEnabled(split)

    root = skeleton.getRootJoint()
    root.setPositions([0, 0, 0, 0, 0, p["rR"]])
    root.setVelocities([roll_rate, 0, 0, speed, -roll_rate * p["rR"], 0])
    hinges["R"].setVelocity(0, speed / p["rR"])
    hinges["F"].setVelocity(0, speed / p["rF"])
    rows, cpu, each = [], 0.0, round(1 / rate / step)
    for row in range(1001):
        begin = time.process_time()
        for _ in range(each if row else 0):
            world.step()
        cpu += time.process_time() - begin
        rotation = bodies["B"].getWorldTransform().rotation()
        spin, hub = bodies["B"].getAngularVelocity(), bodies["B"].getLinearVelocity()
        potential, kinetic = skeleton.computePotentialEnergy(), skeleton.computeKineticEnergy()
        rows.append([
            np.arctan2(rotation[2, 1], rotation[2, 2]), rotation[:, 0] @ spin,
            rotation[:, 0] @ hub, potential, kinetic, potential + kinetic,
            hinges["H"].getPosition(0), hinges["H"].getVelocity(0),
        ])  # fmt: skip
    return np.array(rows), cpu

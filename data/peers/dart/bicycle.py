"""The uncontrolled bicycle in DART: a free body, three hinges, two wheels on a plane.

``simulate`` is what `../field.py` calls. DART has no rolling constraint: contact and friction are
impulses that the step's complementarity problem finds. Axes: x forward, y left, z up.
"""

import tempfile
import time
from pathlib import Path
from xml.etree import ElementTree

import dartpy as dart
import exported
import numpy as np


def model(p, width):
    """The exported model; the origin of the base is moved to the rear hub.

    DART's steps depend on where it is: a free body moves with the velocity of its origin.
    """
    world = ElementTree.fromstring(exported.model(p, "sdf", width))
    base = world.find(".//link[@name='B']")
    for place, up in (("pose", p["rR"]), ("inertial/pose", -p["rR"])):
        x, y, z, *turned = base.findtext(place).split()
        base.find(place).text = " ".join([x, y, repr(float(z) + up), *turned])
    return ElementTree.tostring(world, "unicode")


def build(p, shape, thin, friction):
    """The skeleton of the model; its wheels are ellipsoids where they are asked for.

    DART reads no ellipsoid from SDFormat.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bicycle.sdf"
        path.write_text(model(p, thin), encoding="utf-8")
        skeleton = dart.utils.SdfParser.readWorld(str(path)).getSkeleton("bicycle")
    for wheel in ("R", "F"):
        (touching,) = skeleton.getBodyNode(wheel).getShapeNodes()
        touching.getDynamicsAspect().setFrictionCoeff(friction)
        if shape == "ellipsoid":
            r = p[f"r{wheel}"]
            touching.setShape(dart.dynamics.EllipsoidShape([2 * r, thin, 2 * r]))
            touching.setRelativeTransform(dart.math.Isometry3())
    return skeleton


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
    skeleton = build(p, shape, thin, friction)
    world.addSkeleton(floor)
    world.addSkeleton(skeleton)
    world.getConstraintSolver().setSplitImpulseEnabled(split)

    frame = skeleton.getBodyNode("B")
    rear, steer, front = (
        skeleton.getJoint(name) for name in ("rear_axle", "steer_axis", "front_axle")
    )
    skeleton.getRootJoint().setVelocities([roll_rate, 0, 0, speed, -roll_rate * p["rR"], 0])
    rear.setVelocity(0, speed / p["rR"])
    front.setVelocity(0, speed / p["rF"])
    rows, cpu, each = [], 0.0, round(1 / rate / step)
    for row in range(1001):
        begin = time.process_time()
        for _ in range(each if row else 0):
            world.step()
        cpu += time.process_time() - begin
        rotation = frame.getWorldTransform().rotation()
        spin, hub = frame.getAngularVelocity(), frame.getLinearVelocity()
        potential, kinetic = skeleton.computePotentialEnergy(), skeleton.computeKineticEnergy()
        rows.append([
            np.arctan2(rotation[2, 1], rotation[2, 2]), rotation[:, 0] @ spin,
            rotation[:, 0] @ hub, potential, kinetic, potential + kinetic,
            steer.getPosition(0), steer.getVelocity(0),
        ])  # fmt: skip
    return np.array(rows), cpu

"""The uncontrolled bicycle in OpenSim: a free body, three pin joints, two ellipsoids on a floor.

``simulate`` is what `../field.py` calls. OpenSim gives the speeds of Simbody no constraint of the
user's own, so the wheels are thin ellipsoids on its Hunt-Crossley contact. Axes: x forward, y left,
z up.
"""

import time

import numpy as np
import opensim

opensim.Logger.setLevelString("Off")


def vector(x):
    """OpenSim's form of three numbers."""
    return opensim.Vec3(*(float(value) for value in x))


def build(p, thin, stiffness, dissipation, friction, transition):
    """Model with bodies, joints and contact; frames are parallel at the start."""
    model = opensim.Model()
    model.setGravity(vector([0, 0, -p["g"]]))
    foot = np.array([p["w"] + p["c"], 0, -p["rR"]])  # steer axis on the floor, from the rear hub
    front = np.array([p["w"], 0, p["rF"] - p["rR"]]) - foot
    centres = {
        "B": [p["xB"], 0, -p["zB"] - p["rR"]], "R": [0, 0, 0],
        "H": np.array([p["xH"], 0, -p["zH"] - p["rR"]]) - foot, "F": [0, 0, 0],
    }  # fmt: skip
    bodies = {}
    for b, centre in centres.items():
        xx, xz = p[f"I{b}xx"], -p.get(f"I{b}xz", 0.0)  # z up changes the sign of the products
        tensor = opensim.Inertia(xx, p[f"I{b}yy"], p.get(f"I{b}zz", xx), 0, xz, 0)
        bodies[b] = opensim.Body(b, p[f"m{b}"], vector(centre), tensor)
        model.addBody(bodies[b])
    model.addJoint(opensim.FreeJoint("free", model.getGround(), bodies["B"]))
    axle, axis = [-np.pi / 2, 0, 0], [0, np.pi - p["lam"], 0]  # turn z to the axis of the joint
    for name, one, other, place, turn in (
        ("rear", "B", "R", [0, 0, 0], axle), ("steer", "B", "H", foot, axis),
        ("front", "H", "F", front, axle),
    ):  # fmt: skip
        at = vector(place), vector(turn), bodies[other], vector([0, 0, 0]), vector(turn)
        model.addJoint(opensim.PinJoint(name, bodies[one], *at))
    down = vector([0, np.pi / 2, 0])  # a half space is where its x is positive
    floor = opensim.ContactHalfSpace(vector([0, 0, 0]), down, model.getGround(), "floor")
    model.addContactGeometry(floor)
    for wheel in ("R", "F"):
        radii = vector([p[f"r{wheel}"], thin / 2, p[f"r{wheel}"]])
        shape = opensim.ContactEllipsoid(
            radii, vector([0, 0, 0]), vector([0, 0, 0]), bodies[wheel], wheel
        )
        model.addContactGeometry(shape)
        force = opensim.HuntCrossleyForce()
        force.addGeometry("floor")
        force.addGeometry(wheel)
        force.setStiffness(stiffness)
        force.setDissipation(dissipation)
        force.setStaticFriction(friction)
        force.setDynamicFriction(friction)
        force.setTransitionVelocity(transition)
        model.addForce(force)
    model.finalizeConnections()
    return model


def simulate(
    p, speed, roll_rate, accuracy=1e-3, thin=0.002, stiffness=1e8, dissipation=1.0, friction=1.0,
    transition=0.01, method="RungeKuttaMerson",
    rate=100,
):  # fmt: skip
    """Rows of the eight columns, `rate` a second, and the processor time of the simulation [s].

    ``stiffness`` [N/m^2], ``dissipation`` [s/m] and ``transition`` [m/s] are those of OpenSim's
    Hunt-Crossley force.
    """
    model = build(p, thin, stiffness, dissipation, friction, transition)
    state = model.initSystem()
    joint = {x: model.getJointSet().get(x) for x in ("free", "rear", "steer", "front")}
    free = [joint["free"].get_coordinates(i) for i in range(6)]
    free[5].setValue(state, p["rR"])
    for coordinate, initial in zip(
        free, (roll_rate, 0, 0, speed, -roll_rate * p["rR"], 0), strict=True
    ):
        coordinate.setSpeedValue(state, float(initial))
    for wheel in ("rear", "front"):
        radius = p["rR" if wheel == "rear" else "rF"]
        joint[wheel].get_coordinates(0).setSpeedValue(state, speed / radius)
    manager = opensim.Manager(model)
    manager.setIntegratorMethod(getattr(opensim.Manager, f"IntegratorMethod_{method}"))
    manager.setIntegratorAccuracy(accuracy)
    manager.setWriteToStorage(False)
    manager.initialize(state)
    frame, steer = model.getBodySet().get("B"), joint["steer"].get_coordinates(0)
    weight, rows, cpu = model.getTotalMass(state) * p["g"], [], 0.0
    for row in range(1001):
        begin = time.process_time()
        if row:
            state = manager.integrate(row / rate)
        cpu += time.process_time() - begin
        model.realizeVelocity(state)
        rotation = frame.getTransformInGround(state).R()
        turned = np.array([[rotation.get(i, j) for j in range(3)] for i in range(3)])
        moving = frame.getVelocityInGround(state)
        spin, hub = (np.array([moving.get(k).get(i) for i in range(3)]) for k in (0, 1))
        potential = weight * model.calcMassCenterPosition(state).get(2)
        kinetic = model.calcKineticEnergy(state)
        rows.append([
            np.arctan2(turned[2, 1], turned[2, 2]), turned[:, 0] @ spin, turned[:, 0] @ hub,
            potential, kinetic, potential + kinetic,
            steer.getValue(state), steer.getSpeedValue(state),
        ])  # fmt: skip
    return np.array(rows), cpu

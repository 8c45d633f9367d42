"""The uncontrolled bicycle in Exudyn: discs that roll as a constraint, or on a contact that yields.

``simulate`` is what `../field.py` calls. Rolling as a constraint is the model of
`../exudyn_bicycle.py`, four bodies with Euler parameters, for Exudyn's implicit solvers. With
``contact`` the bodies are a kinematic tree on penalties, an ordinary differential equation that
the explicit solvers take as well. Axes: x forward, y left, z up.
"""

import sys
import time
from pathlib import Path

import exudyn as exu
import numpy as np
from exudyn import itemInterface

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import exudyn_bicycle as rolling

AXLE = [0, 1, 0]
LINKS = {"B": 5, "R": 6, "H": 7, "F": 8}  # links 0 to 4 have no mass


def contact_model(p, speed, roll_rate, stiffness, damping, friction, zone):
    """A kinematic tree: its container (which keeps it alive), system, sensors and tensors.

    Its coordinates are place, yaw, lean and pitch of the rear frame, and three hinge angles.
    """
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    along = np.array([np.sin(p["lam"]), 0, -np.cos(p["lam"])])
    turn = np.column_stack([np.cross(AXLE, along), AXLE, along])  # z of the fork is its axis
    foot = np.array([p["w"] + p["c"], 0, -p["rR"]])  # steer axis on the floor, from the rear hub
    frames = {"B": np.eye(3), "R": np.eye(3), "H": turn, "F": np.eye(3)}
    centres = {
        "B": [p["xB"], 0, -p["zB"] - p["rR"]], "R": [0, 0, 0],
        "H": turn.T @ (np.array([p["xH"], 0, -p["zH"] - p["rR"]]) - foot), "F": [0, 0, 0],
    }  # fmt: skip
    tensors = {b: frames[b].T @ rolling.inertia(p, b).InertiaCOM() @ frames[b] for b in LINKS}
    kinds, none = exu.JointType, np.zeros(3)
    front = turn.T @ (np.array([p["w"], 0, p["rF"] - p["rR"]]) - foot)
    rates = [speed, -roll_rate * p["rR"], 0, 0, roll_rate, 0, speed / p["rR"], 0, speed / p["rF"]]
    tree = mbs.AddObject(
        itemInterface.ObjectKinematicTree(
            nodeNumber=mbs.AddNode(
                itemInterface.NodeGenericODE2(
                    numberOfODE2Coordinates=9, referenceCoordinates=[0] * 9,
                    initialCoordinates=[0] * 9, initialCoordinates_t=rates,
                )
            ),
            gravity=[0, 0, -p["g"]],
            baseOffset=[0, 0, p["rR"]],
            jointTypes=[
                kinds.PrismaticX, kinds.PrismaticY, kinds.PrismaticZ, kinds.RevoluteZ,
                kinds.RevoluteX, kinds.RevoluteY, kinds.RevoluteY, kinds.RevoluteZ, kinds.RevoluteY,
            ],
            linkParents=[-1, 0, 1, 2, 3, 4, 5, 5, 7],
            jointTransformations=exu.Matrix3DList([np.eye(3)] * 7 + [turn, turn.T]),
            jointOffsets=exu.Vector3DList([none] * 7 + [foot, front]),
            linkInertiasCOM=exu.Matrix3DList([np.zeros((3, 3))] * 5 + list(tensors.values())),
            linkCOMs=exu.Vector3DList([none] * 5 + list(centres.values())),
            linkMasses=[0] * 5 + [p[f"m{b}"] for b in LINKS],
        )
    )  # fmt: skip
    floor = mbs.AddMarker(itemInterface.MarkerBodyRigid(bodyNumber=mbs.CreateGround()))
    for wheel in ("R", "F"):
        hub = itemInterface.MarkerKinematicTreeRigid(
            objectNumber=tree, linkNumber=LINKS[wheel], localPosition=none
        )
        state = itemInterface.NodeGenericData(initialCoordinates=[0] * 3, numberOfDataCoordinates=3)
        mbs.AddObject(
            itemInterface.ObjectConnectorRollingDiscPenalty(
                markerNumbers=[floor, mbs.AddMarker(hub)], nodeNumber=mbs.AddNode(state),
                discRadius=p[f"r{wheel}"], discAxis=AXLE, contactStiffness=stiffness,
                contactDamping=damping, dryFriction=[friction] * 2,
                dryFrictionProportionalZone=zone, useLinearProportionalZone=True,
            )
        )  # fmt: skip

    out = exu.OutputVariableType

    def sensor(link, what, place=none):
        return mbs.AddSensor(
            itemInterface.SensorKinematicTree(
                objectNumber=tree, linkNumber=link, localPosition=place, outputVariableType=what,
                storeInternal=True,
            )
        )  # fmt: skip

    def coordinates(what):
        return mbs.AddSensor(
            itemInterface.SensorNode(nodeNumber=0, outputVariableType=what, storeInternal=True)
        )

    sensors = {
        "angles": coordinates(out.Coordinates),
        "rates": coordinates(out.Coordinates_t),
        "B": sensor(5, out.RotationMatrix),
        "hub": sensor(5, out.Velocity),
    }
    for b, link in LINKS.items():
        sensors[f"place {b}"] = sensor(link, out.Position, centres[b])
        sensors[f"velocity {b}"] = sensor(link, out.Velocity, centres[b])
        sensors[f"spin {b}"] = sensor(link, out.AngularVelocityLocal)
    mbs.Assemble()
    return container, mbs, sensors, tensors


def contact_columns(p, mbs, sensors, tensors):
    """Eight columns of a finished run; the roll angle is that of the tree, after the yaw."""
    data = {name: mbs.GetSensorStoredData(s)[:, 1:] for name, s in sensors.items()}
    ahead = data["B"].reshape(-1, 3, 3)[:, :, 0]
    potential = sum(p[f"m{b}"] * p["g"] * data[f"place {b}"][:, 2] for b in LINKS)
    kinetic = 0.0
    for b in LINKS:
        v, spin = data[f"velocity {b}"], data[f"spin {b}"]
        turning = np.einsum("ti,ij,tj->t", spin, tensors[b], spin)
        kinetic = kinetic + (p[f"m{b}"] * (v**2).sum(axis=1) + turning) / 2
    speed = (ahead * data["hub"]).sum(axis=1)
    return np.column_stack([
        data["angles"][:, 4], data["spin B"][:, 0], speed, potential, kinetic, potential + kinetic,
        data["angles"][:, 7], data["rates"][:, 7],
    ])  # fmt: skip


def simulate(
    p, speed, roll_rate, step, solver="GeneralizedAlpha", newton=(1e-8, 1e-10), radius=0.9,
    adaptive=False, contact=False, stiffness=1e5, damping=2e3, friction=1.0, zone=1e-2,
    rate=100,
):  # fmt: skip
    """Rows of the eight columns, `rate` a second, and the processor time of the solver [s].

    The solver, its Newton tolerances (relative, absolute) and its spectral radius by default are
    Exudyn's own; stiffness [N/m] and damping [N s/m] those of its example of a rolling disc.
    ``adaptive`` shortens steps that fail.
    ``zone`` [m/s] is the velocity of slip at which friction is full.
    """
    start = rolling.Maneuver(speed, roll_rate, 1000 / rate, 1 / rate)
    if contact:
        penalty = stiffness, damping, friction, zone
        tree = contact_model(p, speed, roll_rate, *penalty)
        mbs = tree[1]
    else:
        model = rolling.build(p, start)
        mbs = model.mbs
    chosen = rolling.settings(start, step, newton)
    chosen.timeIntegration.generalizedAlpha.spectralRadius = radius
    chosen.timeIntegration.adaptiveStep = adaptive
    begin = time.process_time()
    mbs.SolveDynamic(chosen, solverType=getattr(exu.DynamicSolverType, solver))
    cpu = time.process_time() - begin
    found = contact_columns(p, *tree[1:]) if contact else rolling.columns(model)
    if len(found) != start.rows:
        raise RuntimeError(f"found {len(found)} rows, expected {start.rows}")
    return found, cpu

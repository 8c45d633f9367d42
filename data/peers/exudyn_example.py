"""Maneuver 2 as Exudyn's own example has it, whose comments quote two figures.

Run with ``python data/peers/exudyn_example.py``; it prints a line for each of `PUBLISHED`. The
example is ``main/pythonDev/Examples/bicycleIftommBenchmark.py`` of
https://github.com/jgerstmayr/EXUDYN: wheels turned so that they spin about x, generic joints, P2 as
the benchmark's Table 1 prints it, the trapezoidal rule of index 2 with a modified Newton iteration,
twenty seconds. What it calls performance is the largest less the least energy over the first.
"""

import time

import exudyn as exu
import numpy as np
from exudyn.itemInterface import GenericJoint, MarkerBodyRigid, ObjectGround, ObjectJointRollingDisc
from exudyn.utilities import (
    AddRigidBody,
    RigidBodyInertia,
    RotationMatrixY,
    RotationMatrixZ,
    SensorBody,
)
from exudyn_bicycle import (
    BICYCLE,
    BODIES,
    MANEUVERS,
    centres,
    inertia,
    read_bicycle,
    read_maneuvers,
)

PUBLISHED = {0.001: (6.423e-6, 5.5935), 0.014: (9.15e-4, 0.596)}
"""Performance [%] and time [s] of an Intel Core i9-7940X, by step [s]."""

P2 = np.array([0.82188470506, 0.0, 0.85595086466])
SECONDS = 20.0


def build(p, maneuver):
    """The system, and the sensors of height and kinetic energy, with the weight [N], by body."""
    mbs = exu.SystemContainer().AddSystem()
    turned, tilted, centre = RotationMatrixZ(np.pi / 2), RotationMatrixY(-p["lam"]), centres(p)
    gravity, rolls, bodies = [0.0, 0.0, -p["g"]], maneuver.roll_rate, {}
    for name in BODIES:
        body, spins, about = inertia(p, name), {}, 0.0
        if name in ("R", "F"):
            spins = {"rotationMatrix": turned}
            about = maneuver.speed / p[f"r{name}"]
            xx, yy = p[f"I{name}xx"], p[f"I{name}yy"]
            body = RigidBodyInertia(p[f"m{name}"], np.diag([yy, xx, xx]))
        _, bodies[name] = AddRigidBody(
            mainSys=mbs,
            inertia=body,
            nodeType=exu.NodeType.RotationEulerParameters,
            position=centre[name],
            velocity=[maneuver.speed, -rolls * centre[name][2], 0.0],
            angularVelocity=[rolls, about, 0.0],
            gravity=gravity,
            **spins,
        )

    def marker(body, place=(0.0, 0.0, 0.0)):
        return mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=place))

    floor = marker(mbs.AddObject(ObjectGround()))
    for wheel, frame in (("R", "B"), ("F", "H")):
        of_wheel = marker(bodies[wheel])
        of_frame = marker(bodies[frame], centre[wheel] - centre[frame])
        mbs.AddObject(
            GenericJoint(
                markerNumbers=[of_wheel, of_frame],
                constrainedAxes=[1, 1, 1, 1, 0, 1],
                rotationMarker0=turned,
            )
        )
        mbs.AddObject(
            ObjectJointRollingDisc(markerNumbers=[floor, of_wheel], discRadius=p[f"r{wheel}"])
        )
    mbs.AddObject(
        GenericJoint(
            markerNumbers=[marker(bodies[x], P2 - centre[x]) for x in ("B", "H")],
            constrainedAxes=[1, 1, 1, 1, 1, 0],
            rotationMarker0=tilted,
            rotationMarker1=tilted,
        )
    )
    output = exu.OutputVariableType
    sensors = [
        [
            mbs.AddSensor(SensorBody(bodyNumber=body, outputVariableType=x, storeInternal=True))
            for x in (output.Position, output.KineticEnergy)
        ]
        + [p["g"] * p[f"m{name}"]]
        for name, body in bodies.items()
    ]
    mbs.Assemble()
    return mbs, sensors


def performance(p, maneuver, step):
    """Largest less least energy over the first [%], and processor time of the solver [s]."""
    mbs, sensors = build(p, maneuver)
    s = exu.SimulationSettings()
    s.timeIntegration.endTime = SECONDS
    s.timeIntegration.numberOfSteps = int(SECONDS / step)
    s.timeIntegration.verboseMode = 0
    s.timeIntegration.generalizedAlpha.spectralRadius = 0.7
    s.timeIntegration.generalizedAlpha.computeInitialAccelerations = True
    s.timeIntegration.newton.useModifiedNewton = True
    s.solution.file.write = False
    s.solution.sensors.writePeriod = 0.01
    begin = time.process_time()
    mbs.SolveDynamic(s, solverType=exu.DynamicSolverType.TrapezoidalIndex2)
    cpu = time.process_time() - begin
    energy = sum(
        weight * mbs.GetSensorStoredData(place)[:, 3] + mbs.GetSensorStoredData(kinetic)[:, 1]
        for place, kinetic, weight in sensors
    )
    return 100 * (energy.max() - energy.min()) / energy[0], cpu


def main():
    """Print what is found beside what is published."""
    p, maneuver = read_bicycle(BICYCLE), read_maneuvers(MANEUVERS)[1]
    for step, (quoted, seconds) in PUBLISHED.items():
        found, cpu = performance(p, maneuver, step)
        print(
            f"step {step} s: {found:.4g} % in {cpu:.2f} s; published {quoted:.4g} % in {seconds} s"
        )


if __name__ == "__main__":
    main()

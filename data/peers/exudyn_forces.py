"""Forces and places of the uncontrolled bicycle in Exudyn, maneuver 2, by two integrators.

Run from the root of the repository with ``python data/peers/exudyn_forces.py``. It integrates the
model of `exudyn_bicycle` with the implicit trapezoidal rule (index 2) and the generalized-alpha
method (spectral radius 0.6, index 3), both with steps of 0.001 s, and writes
``exudyn-forces-<integrator>.txt`` beside itself: a line of column names, then 1001 rows.

The numbers are those of Exudyn's sensors in its axes, y to the left and z up. Forces are those on
the wheels: of the floor in heading axes, of the frame in axes of the axle.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import exudyn as exu
import numpy as np
from exudyn.utilities import SensorBody, SensorObject
from exudyn_bicycle import (
    BICYCLE,
    BODIES,
    HERE,
    MANEUVERS,
    Array,
    add_bodies,
    add_joints,
    read_bicycle,
    read_maneuvers,
    settings,
    write_whole,
)

INTEGRATORS = {
    "trapezoidal": exu.DynamicSolverType.TrapezoidalIndex2,
    "alpha": exu.DynamicSolverType.GeneralizedAlpha,
}

_SPECTRAL_RADIUS = 0.6
_ENDS = {"rear": "R", "front": "F"}
_Output = exu.OutputVariableType


def add_sensors(mbs: Any, bodies: Mapping[str, Any], joints: Mapping[str, Any]) -> dict[str, Any]:
    """Sensors of places and forces, by name."""
    sensors = {
        f"position {name}": mbs.AddSensor(
            SensorBody(bodyNumber=body, outputVariableType=_Output.Position, storeInternal=True)
        )
        for name, body in bodies.items()
    }
    sensors["omega"] = mbs.AddSensor(
        SensorBody(
            bodyNumber=bodies["B"],
            outputVariableType=_Output.AngularVelocityLocal,
            storeInternal=True,
        )
    )
    for wheel in _ENDS.values():
        for name, joint, what in (
            (f"contact {wheel}", f"floor {wheel}", _Output.Position),
            (f"floor {wheel}", f"floor {wheel}", _Output.ForceLocal),
            (f"axle {wheel}", f"axle {wheel}", _Output.ForceLocal),
        ):
            sensors[name] = mbs.AddSensor(
                SensorObject(
                    objectNumber=joints[joint], outputVariableType=what, storeInternal=True
                )
            )
    return sensors


def columns(p: Mapping[str, float], data: Mapping[str, Array]) -> dict[str, Array]:
    """Columns by name, from the data of the sensors."""
    mass = sum(p[f"m{body}"] for body in BODIES)
    com = sum(p[f"m{body}"] / mass * data[f"position {body}"] for body in BODIES)
    found = {f"com_{axis}": com[:, i] for i, axis in enumerate("xyz")}
    found |= {f"rear_frame_omega_{axis}": data["omega"][:, i] for i, axis in enumerate("xyz")}
    for end, wheel in _ENDS.items():
        contact = data[f"contact {wheel}"]
        found |= {f"{end}_contact_{axis}": contact[:, i] for i, axis in enumerate("xy")}
    for end, wheel in _ENDS.items():
        floor, axle = data[f"floor {wheel}"], data[f"axle {wheel}"]
        # The sensor of a rolling disc has the lateral force first; that of an axle is about the
        # axle's own axes, with the direction of the axle last and the vertical one first.
        found |= {
            f"{end}_normal_force": floor[:, 2],
            f"{end}_longitudinal_force": floor[:, 1],
            f"{end}_lateral_force": floor[:, 0],
            f"{end}_axle_force_x": axle[:, 1],
            f"{end}_axle_force_y": axle[:, 2],
            f"{end}_axle_force_z": axle[:, 0],
        }
    return found


def run(integrator: Any, step: float) -> dict[str, Array]:
    """Columns of maneuver 2, with steps of so many seconds."""
    p, maneuver = read_bicycle(BICYCLE), read_maneuvers(MANEUVERS)[1]
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    bodies = add_bodies(mbs, p, maneuver)
    sensors = add_sensors(mbs, bodies, add_joints(mbs, p, bodies))
    mbs.Assemble()
    chosen = settings(maneuver, step)
    chosen.timeIntegration.generalizedAlpha.spectralRadius = _SPECTRAL_RADIUS
    mbs.SolveDynamic(chosen, solverType=integrator)
    # The first column of stored data is the time.
    return columns(p, {k: mbs.GetSensorStoredData(s)[:, 1:] for k, s in sensors.items()})


def main() -> None:
    """Integrate and write the files."""
    maneuver = read_maneuvers(MANEUVERS)[1]
    for name, integrator in INTEGRATORS.items():
        found = run(integrator, step=0.001)
        table = np.column_stack(list(found.values())) + 0.0  # not -0 in the first row
        if len(table) != maneuver.rows:
            raise RuntimeError(f"found {len(table)} rows, expected {maneuver.rows}")
        lines = [" ".join(["time", *found])]
        for i, row in enumerate(table):
            lines.append(" ".join([f"{i * maneuver.spacing:.12g}", *(f"{x:.10g}" for x in row)]))
        write_whole(HERE / f"exudyn-forces-{name}.txt", "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()

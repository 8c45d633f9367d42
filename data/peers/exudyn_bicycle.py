"""The uncontrolled bicycle in Exudyn: four rigid bodies, three hinges, two rolling discs.

Run from the root of the repository with ``python data/peers/exudyn_bicycle.py``. It integrates the
three maneuvers with the implicit trapezoidal rule (index 2) at each step size of `STEPS` and
writes ``exudyn-h<step>.txt`` and ``exudyn.toml`` beside itself; and once with a Newton iteration
that stops early, as ``exudyn-loose-newton.txt``. With the argument ``loose`` only the latter.

Axes of the model: x forward, y to the left, z up, the floor is z = 0; rotations about x are the
same as with z down, those about y and z change sign. The files have roll and steer positive to
the right.
"""

from __future__ import annotations

import math
import os
import sys
import time
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import exudyn as exu
import numpy as np
from exudyn.utilities import RigidBodyInertia, SensorBody, SensorObject

HERE = Path(__file__).resolve().parent
BICYCLE = HERE.parent / "bicycles" / "benchmark.toml"
MANEUVERS = HERE.parent / "maneuvers" / "benchmark.toml"

STEPS = ("0.01", "0.001")
"""Step sizes [s]."""

NEWTON = (1e-10, 1e-12)
"""Relative and absolute tolerance: tighter ones change the errors by about one percent."""

LOOSE = (3e-5, 1e-10)
"""Steps of 0.001 s end with errors of the iteration, not of the rule, the largest in maneuver 3."""

BODIES = ("B", "H", "R", "F")
"""Rear frame with rider, front fork and handlebar, rear wheel, front wheel."""

_AXLE = [0.0, 1.0, 0.0]
_Output = exu.OutputVariableType
Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class Maneuver:
    """Initial state, length and spacing of the rows of a run; SI units."""

    speed: float
    roll_rate: float
    duration: float
    spacing: float

    @property
    def rows(self) -> int:
        return round(self.duration / self.spacing) + 1


@dataclass(frozen=True)
class Model:
    """An assembled bicycle.

    Attributes
    ----------
    container
        Exudyn's owner of the system, kept so that the system lives on.
    mbs
        The system.
    sensors
        Numbers of the sensors, by name.
    weights
        Weight of each body [N].
    """

    container: Any
    mbs: Any
    sensors: Mapping[str, Any]
    weights: Mapping[str, float]


def number(text: str) -> float:
    """Value of a decimal, or of a quotient with pi on top, such as ``pi/10``."""
    top, _, bottom = text.partition("/")
    return (math.pi if top.strip() == "pi" else float(top)) / float(bottom or 1)


def read_bicycle(path: Path) -> dict[str, float]:
    """Parameters by symbol, in the axes of the file (z down)."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))["parameters"]
    return {symbol: number(entry["value"]) for symbol, entry in table.items()}


def read_maneuvers(path: Path) -> list[Maneuver]:
    """The maneuvers, in order."""
    names = ("speed", "roll_rate", "duration", "spacing")
    tables = tomllib.loads(path.read_text(encoding="utf-8"))["maneuver"]
    return [Maneuver(**{name: number(t[name]["value"]) for name in names}) for t in tables]


def inertia(p: Mapping[str, float], body: str) -> RigidBodyInertia:
    """Mass and inertia of a body about its centre of mass, in axes with z up."""
    xx, yy = p[f"I{body}xx"], p[f"I{body}yy"]
    zz = p.get(f"I{body}zz", xx)  # a wheel has no entry: it is the diametral one
    # The file's matrix element is for z down; turning y and z over changes its sign.
    xz = -p.get(f"I{body}xz", 0.0)
    return RigidBodyInertia(
        mass=p[f"m{body}"],
        inertiaTensor=np.array([[xx, 0, xz], [0, yy, 0], [xz, 0, zz]]),
        inertiaTensorAtCOM=True,
    )


def centres(p: Mapping[str, float]) -> dict[str, Array]:
    """Centres of mass of the upright, straight bicycle; the rear contact point is the origin."""
    return {
        "B": np.array([p["xB"], 0.0, -p["zB"]]),
        "H": np.array([p["xH"], 0.0, -p["zH"]]),
        "R": np.array([0.0, 0.0, p["rR"]]),
        "F": np.array([p["w"], 0.0, p["rF"]]),
    }


def steer_axis(p: Mapping[str, float]) -> tuple[Array, Array]:
    """A point of the steer axis, and its direction, downwards so that right is positive.

    The axis meets the floor the trail in front of the front contact point. The point taken is the
    one at the height of the handlebar's centre of mass.
    """
    height = -p["zH"]
    point = np.array([p["w"] + p["c"] - height * math.tan(p["lam"]), 0.0, height])
    return point, np.array([math.sin(p["lam"]), 0.0, -math.cos(p["lam"])])


def add_bodies(mbs: Any, p: Mapping[str, float], maneuver: Maneuver) -> dict[str, Any]:
    """The four bodies, with the velocities of rolling straight while falling over.

    The whole bicycle turns about the line of the contact points; the wheels spin on top of that.
    """
    roll = np.array([maneuver.roll_rate, 0.0, 0.0])
    bodies = {}
    for body, centre in centres(p).items():
        spin = maneuver.speed / p[f"r{body}"] if body in ("R", "F") else 0.0
        bodies[body] = mbs.CreateRigidBody(
            name=body,
            inertia=inertia(p, body),
            referencePosition=centre,
            initialVelocity=np.array([maneuver.speed, 0.0, 0.0]) + np.cross(roll, centre),
            initialAngularVelocity=roll + spin * np.array(_AXLE),
            gravity=[0.0, 0.0, -p["g"]],
            nodeType=exu.NodeType.RotationEulerParameters,
        )
    return bodies


def add_joints(mbs: Any, p: Mapping[str, float], bodies: Mapping[str, Any]) -> dict[str, Any]:
    """The steer axis, two axles and two wheels on the floor, by name."""
    point, axis = steer_axis(p)
    joints = {
        "steer": mbs.CreateRevoluteJoint(
            itemNumbers=[bodies["B"], bodies["H"]], position=point, axis=axis, useGlobalFrame=True
        )
    }
    floor = mbs.CreateGround()
    for frame, wheel in (("B", "R"), ("H", "F")):
        joints[f"axle {wheel}"] = mbs.CreateRevoluteJoint(
            itemNumbers=[bodies[frame], bodies[wheel]],
            position=centres(p)[wheel],
            axis=_AXLE,
            useGlobalFrame=True,
        )
        joints[f"floor {wheel}"] = mbs.CreateRollingDisc(
            bodyNumbers=[floor, bodies[wheel]],
            axisPosition=[0.0, 0.0, 0.0],
            axisVector=_AXLE,
            discRadius=p[f"r{wheel}"],
            planePosition=[0.0, 0.0, 0.0],
            planeNormal=[0.0, 0.0, 1.0],
        )
    return joints


def add_sensors(
    mbs: Any, p: Mapping[str, float], bodies: Mapping[str, Any], steer: Any
) -> dict[str, Any]:
    """Sensors of everything that the file needs, by name."""
    frame, hub = bodies["B"], centres(p)["R"] - centres(p)["B"]

    def of_body(body: Any, what: Any, position: Sequence[float] | Array = (0.0, 0.0, 0.0)) -> Any:
        return mbs.AddSensor(
            SensorBody(
                bodyNumber=body,
                localPosition=position,
                outputVariableType=what,
                storeInternal=True,
            )
        )

    def of_joint(what: Any) -> Any:
        return mbs.AddSensor(
            SensorObject(objectNumber=steer, outputVariableType=what, storeInternal=True)
        )

    sensors = {
        "attitude": of_body(frame, _Output.Rotation),
        "rate": of_body(frame, _Output.AngularVelocityLocal),
        "hub": of_body(frame, _Output.VelocityLocal, hub),
        "steer": of_joint(_Output.Rotation),
        "steer rate": of_joint(_Output.AngularVelocityLocal),
    }
    for name, body in bodies.items():
        sensors[f"position {name}"] = of_body(body, _Output.Position)
        sensors[f"kinetic {name}"] = of_body(body, _Output.KineticEnergy)
    return sensors


def build(p: Mapping[str, float], maneuver: Maneuver) -> Model:
    """The bicycle at the start of a maneuver."""
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    bodies = add_bodies(mbs, p, maneuver)
    joints = add_joints(mbs, p, bodies)
    sensors = add_sensors(mbs, p, bodies, joints["steer"])
    mbs.Assemble()
    return Model(container, mbs, sensors, {body: p["g"] * p[f"m{body}"] for body in BODIES})


def settings(maneuver: Maneuver, step: float, newton: tuple[float, float]) -> Any:
    """Settings of a run at a fixed step, with nothing written to files."""
    s = exu.SimulationSettings()
    s.timeIntegration.endTime = maneuver.duration
    s.timeIntegration.numberOfSteps = round(maneuver.duration / step)
    s.timeIntegration.adaptiveStep = False
    s.timeIntegration.verboseMode = 0
    s.timeIntegration.newton.relativeTolerance, s.timeIntegration.newton.absoluteTolerance = newton
    s.solution.file.write = False
    s.solution.sensors.writePeriod = maneuver.spacing
    return s


def columns(model: Model) -> Array:
    """Eight columns of a finished run, in the order of the benchmark's file."""
    # The first column of stored data is the time.
    data = {k: model.mbs.GetSensorStoredData(s)[:, 1:] for k, s in model.sensors.items()}
    potential = sum(w * data[f"position {b}"][:, 2] for b, w in model.weights.items())
    kinetic = sum(data[f"kinetic {b}"][:, 0] for b in model.weights)
    found = [
        data["attitude"][:, 0],
        data["rate"][:, 0],
        data["hub"][:, 0],
        potential,
        kinetic,
        potential + kinetic,
        data["steer"][:, 2],
        data["steer rate"][:, 2],
    ]
    return np.column_stack(found) + 0.0  # not -0 in the first row


def run(
    p: Mapping[str, float], maneuver: Maneuver, step: float,
    newton: tuple[float, float] = NEWTON,
) -> tuple[Array, float]:  # fmt: skip
    """Columns of a maneuver, and the CPU time of the solver [s]."""
    model = build(p, maneuver)
    chosen = settings(maneuver, step, newton)
    begin = time.process_time()
    done = model.mbs.SolveDynamic(chosen, solverType=exu.DynamicSolverType.TrapezoidalIndex2)
    cpu = time.process_time() - begin
    found = columns(model)
    if not done or len(found) != maneuver.rows:
        raise RuntimeError(f"found {len(found)} rows, expected {maneuver.rows}")
    return found, cpu


def write_whole(path: Path, text: str) -> None:
    """Write a file so that it is never seen half written."""
    part = path.with_name(path.name + ".part")
    part.write_text(text, encoding="utf-8", newline="\n")
    os.replace(part, path)


def file_text(times: Sequence[str], values: Array) -> str:
    """One line for each time."""
    lines = (
        " ".join([t, *(f"{x:.12g}" for x in row)]) for t, row in zip(times, values, strict=True)
    )
    return "\n".join(lines) + "\n"


def main() -> None:
    """Integrate everything and write the files."""
    p, maneuvers = read_bicycle(BICYCLE), read_maneuvers(MANEUVERS)
    times = [f"{i * maneuvers[0].spacing:.12g}" for i in range(maneuvers[0].rows)]
    runs = [run(p, maneuver, 0.001, LOOSE) for maneuver in maneuvers]
    values = np.hstack([values for values, _ in runs])
    write_whole(HERE / "exudyn-loose-newton.txt", file_text(times, values))
    if sys.argv[1:] == ["loose"]:
        return
    entries = []
    for step in STEPS:
        runs = [run(p, maneuver, float(step)) for maneuver in maneuvers]
        name, cpu = f"exudyn-h{step}.txt", sum(seconds for _, seconds in runs)
        write_whole(HERE / name, file_text(times, np.hstack([values for values, _ in runs])))
        entries.append(f'[[run]]\nfile = "{name}"\nstep = "{step}"\ncpu = "{cpu:.2f}"\n')
        print(f"{name}: {cpu:.2f} s")
    write_whole(HERE / "exudyn.toml", "\n".join(entries))


if __name__ == "__main__":
    main()

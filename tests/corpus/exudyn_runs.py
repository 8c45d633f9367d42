"""Runs with Exudyn: correct ones with its solvers and settings, and mistakes that users make.

Axes of the model: x forward, y to the left, z up. The product of inertia xz therefore has the
opposite sign.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import exudyn as exu
import numpy as np
from exudyn.utilities import RigidBodyInertia, SensorBody, SensorObject

from corpus.benchmark import MANEUVERS, TABLE_1, Array, Columns, Run, changed

_Output, _Solver = exu.OutputVariableType, exu.DynamicSolverType
_AXLE = np.array([0.0, 1.0, 0.0])
_LETTERS = "BHRF"


@dataclass(frozen=True)
class Model:
    """A model as a user of Exudyn writes it; the defaults are correct.

    Attributes
    ----------
    p
        Parameters of Table 1, with z down.
    step
        [s].
    solver
    newton
        Relative and absolute tolerance; None for Exudyn's own.
    damping
        Spectral radius of the generalized-alpha method.
    turned_over
        Frames whose product of inertia changes its sign with the axes.
    axes
        Axis of each wheel's spin inertia: 1 is the axle.
    rolls, spins, falls
        Initial velocities: whether the bodies have the roll rate, which wheels turn, and whether
        the centres of mass move sideways.
    through_hub
        Whether the steer axis goes through the front hub.
    """

    p: Mapping[str, float] = field(default_factory=lambda: TABLE_1)
    step: float = 0.001
    solver: Any = _Solver.TrapezoidalIndex2
    newton: tuple[float, float] | None = (1e-10, 1e-12)
    damping: float | None = None
    turned_over: str = "BH"
    axes: int = 1
    rolls: bool = True
    spins: str = "RF"
    falls: bool = True
    through_hub: bool = False

    def compute(self, maneuver: int) -> Columns:
        container = exu.SystemContainer()
        mbs = container.AddSystem()
        bodies = self._bodies(mbs, *MANEUVERS[maneuver])
        steer = self._joints(mbs, bodies)
        sensors = self._sensors(mbs, bodies, steer)
        mbs.Assemble()
        if not mbs.SolveDynamic(self._settings(), solverType=self.solver):
            raise RuntimeError("the solver stopped")
        return self._columns({k: mbs.GetSensorStoredData(s)[:, 1:] for k, s in sensors.items()})

    def _centres(self) -> dict[str, Array]:
        p = self.p
        return {
            "B": np.array([p["xB"], 0, -p["zB"]]), "H": np.array([p["xH"], 0, -p["zH"]]),
            "R": np.array([0, 0, p["rR"]]), "F": np.array([p["w"], 0, p["rF"]]),
        }  # fmt: skip

    def _inertia(self, body: str) -> RigidBodyInertia:
        p = self.p
        if body in "BH":
            xz = p[f"I{body}xz"] * (-1 if body in self.turned_over else 1)
            xx, yy, zz = (p[f"I{body}{a}{a}"] for a in "xyz")
        else:
            around, across = p[f"I{body}yy"], p[f"I{body}xx"]
            xx, yy, zz = (around if i == self.axes else across for i in range(3))
            xz = 0.0
        tensor = np.array([[xx, 0, xz], [0, yy, 0], [xz, 0, zz]])
        return RigidBodyInertia(mass=p[f"m{body}"], inertiaTensor=tensor)

    def _bodies(self, mbs: Any, v: float, roll_rate: float) -> dict[str, Any]:
        roll = np.array([roll_rate if self.rolls else 0.0, 0.0, 0.0])
        made = {}
        for body, centre in self._centres().items():
            spin = v / self.p[f"r{body}"] if body in self.spins else 0.0
            fall = np.cross(roll, centre) if self.falls else 0.0
            made[body] = mbs.CreateRigidBody(
                inertia=self._inertia(body), referencePosition=centre,
                initialVelocity=np.array([v, 0, 0]) + fall,
                initialAngularVelocity=roll + spin * _AXLE, gravity=[0, 0, -self.p["g"]],
                nodeType=exu.NodeType.RotationEulerParameters)  # fmt: skip
        return made

    def _joints(self, mbs: Any, bodies: Mapping[str, Any]) -> Any:
        p, centres = self.p, self._centres()
        on_axis = centres["F"] if self.through_hub else np.array([p["w"] + p["c"], 0, 0])
        axis = np.array([np.sin(p["lam"]), 0, -np.cos(p["lam"])])
        steer = mbs.CreateRevoluteJoint(
            itemNumbers=[bodies["B"], bodies["H"]], position=on_axis, axis=axis,
            useGlobalFrame=True)  # fmt: skip
        ground = mbs.CreateGround()
        for frame, wheel in zip("BH", "RF", strict=True):
            mbs.CreateRevoluteJoint(
                itemNumbers=[bodies[frame], bodies[wheel]], position=centres[wheel], axis=_AXLE,
                useGlobalFrame=True)  # fmt: skip
            mbs.CreateRollingDisc(
                bodyNumbers=[ground, bodies[wheel]], axisPosition=[0, 0, 0], axisVector=_AXLE,
                discRadius=p[f"r{wheel}"], planePosition=[0, 0, 0], planeNormal=[0, 0, 1],
            )  # fmt: skip
        return steer

    def _sensors(self, mbs: Any, bodies: Mapping[str, Any], steer: Any) -> dict[str, Any]:
        frame, hub = bodies["B"], self._centres()["R"] - self._centres()["B"]
        contact = -self._centres()["B"]

        def of(body: Any, what: Any, at: Any = (0.0, 0.0, 0.0)) -> Any:
            return mbs.AddSensor(SensorBody(
                bodyNumber=body, localPosition=at, outputVariableType=what, storeInternal=True
            ))  # fmt: skip

        def of_joint(what: Any) -> Any:
            return mbs.AddSensor(
                SensorObject(objectNumber=steer, outputVariableType=what, storeInternal=True)
            )

        made = {
            "attitude": of(frame, _Output.Rotation),
            "rate": of(frame, _Output.AngularVelocityLocal),
            "global rate": of(frame, _Output.AngularVelocity),
            "hub": of(frame, _Output.VelocityLocal, hub),
            "global hub": of(frame, _Output.Velocity, hub),
            "foot": of(frame, _Output.VelocityLocal, contact),
            "rider": of(frame, _Output.VelocityLocal),
            "wheel rate": of(bodies["R"], _Output.AngularVelocityLocal),
            "steer": of_joint(_Output.Rotation),
            "steer rate": of_joint(_Output.AngularVelocityLocal),
        }
        for name, body in bodies.items():
            made[f"position {name}"] = of(body, _Output.Position)
            made[f"kinetic {name}"] = of(body, _Output.KineticEnergy)
        return made

    def _settings(self) -> Any:
        s = exu.SimulationSettings()
        s.timeIntegration.endTime = 10.0
        s.timeIntegration.numberOfSteps = round(10.0 / self.step)
        s.timeIntegration.verboseMode = 0
        if self.newton is not None:
            s.timeIntegration.newton.relativeTolerance = self.newton[0]
            s.timeIntegration.newton.absoluteTolerance = self.newton[1]
        if self.damping is not None:
            s.timeIntegration.generalizedAlpha.spectralRadius = self.damping
        s.solution.file.write = False
        s.solution.sensors.writePeriod = 0.01
        return s

    def _columns(self, data: Mapping[str, Array]) -> Columns:
        potential = sum(
            self.p["g"] * self.p[f"m{b}"] * data[f"position {b}"][:, 2] for b in _LETTERS
        )
        return {
            "roll": data["attitude"][:, 0],
            "roll_rate": data["rate"][:, 0],
            "speed": data["hub"][:, 0],
            "potential": np.asarray(potential),
            "kinetic": sum((data[f"kinetic {b}"][:, 0] for b in _LETTERS), np.zeros(1001)),
            "steer": data["steer"][:, 2],
            "steer_rate": data["steer rate"][:, 2],
            "rate_global_x": data["global rate"][:, 0],
            "speed_hub_global_x": data["global hub"][:, 0],
            "speed_hub_norm": np.linalg.norm(data["hub"], axis=1),
            "speed_foot": data["foot"][:, 0],
            "speed_rider": data["rider"][:, 0],
            "speed_rear_spin": self.p["rR"] * data["wheel rate"][:, 1],
        }  # fmt: skip


_P = TABLE_1
_ALPHA = _Solver.GeneralizedAlpha

_CORRECT = (
    ("trapezoidal-0.01", "trapezoidal rule, h = 0.01", Model(step=0.01)),
    ("trapezoidal-0.005", "trapezoidal rule, h = 0.005", Model(step=0.005)),
    ("trapezoidal-0.001", "trapezoidal rule, h = 0.001", Model()),
    ("trapezoidal-0.001-newton", "trapezoidal rule, h = 0.001, Newton tolerances by default",
     Model(newton=None)),
    ("trapezoidal-0.01-newton", "trapezoidal rule, h = 0.01, Newton tolerances by default",
     Model(step=0.01, newton=None)),
    ("alpha-0.001", "generalized alpha, h = 0.001, defaults", Model(solver=_ALPHA, newton=None)),
    ("alpha-0.001-0.6", "generalized alpha, h = 0.001, spectral radius 0.6",
     Model(solver=_ALPHA, damping=0.6)),
    ("alpha-0.005-0.9", "generalized alpha, h = 0.005, spectral radius 0.9",
     Model(solver=_ALPHA, step=0.005, damping=0.9)),
    ("alpha-0.01-0.5", "generalized alpha, h = 0.01, spectral radius 0.5",
     Model(solver=_ALPHA, step=0.01, damping=0.5)),
)  # fmt: skip

_MISTAKES = (
    ("product-signs", "rear frame and fork product of inertia with the other sign",
     "products of inertia as in Table 1, although z is up", Model(turned_over="")),
    ("rear-product-sign", "rear frame product of inertia with the other sign",
     "I_Bxz as in Table 1, although z is up", Model(turned_over="H")),
    ("fork-product-sign", "fork product of inertia with the other sign",
     "I_Hxz as in Table 1, although z is up", Model(turned_over="B")),
    ("wheel-axes", "wheels' Ixx and Iyy exchanged",
     "wheels with their spin inertia about x", Model(axes=0)),
    ("wheels-at-rest", "wheels not turning at the start",
     "initial angular velocity of the wheels forgotten", Model(spins="")),
    ("front-wheel-at-rest", "front wheel not turning at the start",
     "initial angular velocity of the front wheel forgotten", Model(spins="R")),
    ("no-fall-at-start", "velocities at the start without the roll",
     "roll rate as angular velocity only, centres of mass start straight on", Model(falls=False)),
    ("no-roll-rate", "no roll rate at the start", "bodies start without a roll rate",
     Model(rolls=False)),
    ("axis-through-hub", "no fork offset", "steer axis through the front hub",
     Model(through_hub=True)),
    ("gravity-9.80665", "gravity 9.80665", "g = 9.80665", Model(p=changed(g=9.80665))),
    ("gravity-9.8", "gravity 9.8", "g = 9.8", Model(p=changed(g=9.8))),
    ("tilt-20", "another steer axis tilt", "tilt of 20 degrees",
     Model(p=changed(lam=np.deg2rad(20)))),
    ("rider-height", "another centre of mass of the rear frame", "z_B = -0.8 instead of -0.9",
     Model(p=changed(zB=-0.8))),
    ("wheel-masses-swapped", "wheel masses exchanged", "masses of the wheels exchanged",
     Model(p=changed(mR=_P["mF"], mF=_P["mR"]))),
    ("fork-mass", "another mass of the fork", "m_H = 2.4 instead of 4", Model(p=changed(mH=2.4))),
)  # fmt: skip

_PROGRAM = f"Exudyn {exu.GetVersionString()}"

RUNS = (
    *(
        Run(f"exudyn-{name}", f"{_PROGRAM}, {words}", "", "correct", model.compute)
        for name, words, model in _CORRECT
    ),
    *(
        Run(f"exudyn-{name}", f"{_PROGRAM}, trapezoidal rule, h = 0.001", did, expected,
            model.compute)
        for name, expected, did, model in _MISTAKES
    ),
)  # fmt: skip

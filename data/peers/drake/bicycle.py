"""The uncontrolled bicycle in Drake: its contact, or rolling added by hand as constraints.

``simulate`` is what `../field.py` calls. With ``contact`` the wheels are thin ellipsoids on a half
space, in a plant of discrete steps. Without it each wheel gives three rows (its lowest material
point stands still) to the equations of a continuous plant, for an integrator of Drake with fixed
steps, or steps of SciPy's DOP853. Axes: x forward, y left, z up.
"""

import time

import exported
import numpy as np
from outside import one_step
from pydrake import all as drake

UP, AXLE = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])


def build(plant, p, thin=0.0):
    """Add the exported model; its base is at the rear contact. Its shapes touch in a scene."""
    drake.Parser(plant).AddModelsFromString(exported.model(p, "mjcf", 2 * thin), "xml")
    plant.mutable_gravity_field().set_gravity_vector(-p["g"] * UP)
    plant.Finalize()


class Rolling(drake.LeafSystem):
    """The motion of a plant whose wheels R and F roll: state q, v."""

    def __init__(self, plant, p):
        super().__init__()
        self.plant, self.context = plant, plant.CreateDefaultContext()
        self.wheels = [(plant.GetBodyByName(x).body_frame(), p[f"r{x}"]) for x in ("R", "F")]
        self.DeclareContinuousState(plant.num_positions(), plant.num_velocities(), 0)

    def DoCalcTimeDerivatives(self, context, derivatives):  # noqa: N802
        state = context.get_continuous_state_vector().CopyToVector()
        derivatives.SetFromVector(self.rates(state))

    def rates(self, state):
        """How q and v change."""
        plant, own, n = self.plant, self.context, self.plant.num_velocities()
        plant.SetPositionsAndVelocities(own, state)
        v = plant.GetVelocities(own)
        rows, drift = (np.concatenate(x) for x in zip(*map(self.rows, self.wheels), strict=True))
        zero = np.zeros((len(rows), len(rows)))
        system = np.block([[plant.CalcMassMatrix(own), rows.T], [rows, zero]])
        force = plant.CalcGravityGeneralizedForces(own) - plant.CalcBiasTerm(own)
        a = np.linalg.solve(system, np.concatenate([force, -drift]))[:n]
        return np.concatenate([plant.MapVelocityToQDot(own, v), a])

    def rows(self, wheel):
        """Rows of a wheel's constraints, and what they are without accelerations of the joints."""
        (frame, radius), plant, own = wheel, self.plant, self.context
        world, hub, by = plant.world_frame(), np.zeros(3), drake.JacobianWrtVariable.kV
        axle = frame.CalcRotationMatrixInWorld(own) @ AXLE
        spin = frame.CalcSpatialVelocityInWorld(own).rotational()
        drift = plant.CalcBiasSpatialAcceleration(own, by, frame, hub, world, world)
        # From the hub to the lowest point, and how this arm changes.
        turning = np.cross(spin, axle)
        down, change = axle * axle[2] - UP, turning * axle[2] + axle * turning[2]
        length = np.linalg.norm(down)
        arm = radius * down / length
        moving = radius * (change / length - down * (down @ change) / length**3)
        jacobian = plant.CalcJacobianSpatialVelocity(own, by, frame, hub, world, world)
        return (
            jacobian[3:] + np.cross(jacobian[:3].T, arm).T,
            drift.translational() + np.cross(drift.rotational(), arm) + np.cross(spin, moving),
        )


def simulate(p, speed, roll_rate, step, contact=None, thin=0.001, scheme="runge_kutta3", rate=100):
    """Rows of the eight columns, `rate` a second, and the processor time of the simulation [s].

    ``contact`` is Drake's name of a discrete contact approximation, ``scheme`` that of an
    integrator, for rolling as constraints, or dop853.
    """
    if contact:
        builder = drake.DiagramBuilder()
        config = drake.MultibodyPlantConfig(time_step=step, discrete_contact_approximation=contact)
        plant, _ = drake.AddMultibodyPlant(config, builder)
        build(plant, p, thin)
        simulator = drake.Simulator(builder.Build())
        own = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    else:
        plant = drake.MultibodyPlant(time_step=0)
        build(plant, p)
        rolling = Rolling(plant, p)
        simulator = drake.Simulator(rolling)
        if scheme != "dop853":
            drake.ApplySimulatorConfig(
                drake.SimulatorConfig(
                    integration_scheme=scheme, max_step_size=step, use_error_control=False
                ),
                simulator,
            )
        own = plant.CreateDefaultContext()
    frame, hinge = plant.GetBodyByName("B"), plant.GetJointByName
    plant.SetFreeBodyPose(own, frame, drake.RigidTransform())
    velocity = drake.SpatialVelocity([roll_rate, 0, 0], [speed, 0, 0])
    plant.SetFreeBodySpatialVelocity(context=own, body=frame, V_JpJc=velocity)
    hinge("rear_axle").set_angular_rate(own, speed / p["rR"])
    hinge("front_axle").set_angular_rate(own, speed / p["rF"])
    if not contact:
        state = plant.GetPositionsAndVelocities(own)
        simulator.get_mutable_context().SetContinuousState(state)
    simulator.Initialize()
    found, cpu = [], 0.0
    for row in range(1001):
        begin = time.process_time()
        if scheme == "dop853":
            for _ in range(round(1 / rate / step) if row else 0):
                state = one_step(rolling.rates, state, step)
        else:
            simulator.AdvanceTo(row * (1 / rate))
        cpu += time.process_time() - begin
        if not contact:
            if scheme != "dop853":
                state = simulator.get_context().get_continuous_state_vector().CopyToVector()
            plant.SetPositionsAndVelocities(own, state)
        rotation = frame.EvalPoseInWorld(own).rotation()
        moving = frame.EvalSpatialVelocityInWorld(own)
        along = rotation.matrix()[:, 0]
        hub = moving.Shift(rotation.matrix() @ [0, 0, p["rR"]]).translational()
        potential, kinetic = plant.CalcPotentialEnergy(own), plant.CalcKineticEnergy(own)
        found.append([
            drake.RollPitchYaw(rotation).roll_angle(), along @ moving.rotational(),
            along @ hub, potential, kinetic, potential + kinetic,
            hinge("steer_axis").get_angle(own), hinge("steer_axis").get_angular_rate(own),
        ])  # fmt: skip
    return np.array(found), cpu

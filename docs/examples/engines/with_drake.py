"""The bicycle of ``heyoka-bike export --model sdf`` in Drake, by its contact; see `bicycle`."""

import numpy as np
from pydrake import all as drake

from bicycle import UP, Body, State, main, parameter

CONTACT, STIFFNESS = "sap", 1e8
"""Drake's contact approximation, and its stiffness [N/m]."""


class Engine:
    """Drake's plant of discrete steps."""

    STEP = 0.001

    def __init__(self, file, step=STEP):
        builder = drake.DiagramBuilder()
        config = drake.MultibodyPlantConfig(time_step=step, discrete_contact_approximation=CONTACT)
        self.plant, scene = drake.AddMultibodyPlant(config, builder)
        drake.Parser(self.plant).AddModels(file)
        self.harden(scene)
        # Drake does not read the gravity of a world; its default is 9.81 m/s^2.
        field = self.plant.mutable_gravity_field()
        self.gravity = parameter(file, "g")
        field.set_gravity_vector(-self.gravity * UP)
        self.plant.Finalize()
        self.simulator = drake.Simulator(builder.Build())
        self.context = self.plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        self.links = {letter: self.plant.GetBodyByName(letter) for letter in "BRHF"}
        self.joints = [
            self.plant.GetJointByName(x) for x in ("rear_axle", "steer_axis", "front_axle")
        ]
        self.radii = [parameter(file, "rR"), parameter(file, "rF")]

    def harden(self, scene):
        """Set stiffness and damping of the contact, as no model format states all of them."""
        source, inspector = self.plant.get_source_id(), scene.model_inspector()
        for shape in inspector.GetAllGeometryIds(drake.Role.kProximity):
            found = drake.ProximityProperties(inspector.GetProximityProperties(shape))
            found.UpdateProperty("material", "point_contact_stiffness", STIFFNESS)
            found.UpdateProperty("material", "relaxation_time", 0.0)
            scene.AssignRole(source, shape, found, drake.RoleAssign.kReplace)

    def set(self, state):
        base, attitude = self.links["B"], drake.Quaternion(state.attitude)
        pose = drake.RigidTransform(attitude, state.place)
        self.plant.SetFreeBodyPose(self.context, base, pose)
        velocity = drake.SpatialVelocity(state.turning, state.velocity)
        self.plant.SetFreeBodySpatialVelocity(context=self.context, body=base, V_JpJc=velocity)
        for joint, angle, rate in zip(self.joints, state.angles, state.rates, strict=True):
            joint.set_angle(self.context, angle)
            joint.set_angular_rate(self.context, rate)

    def state(self):
        pose = self.links["B"].EvalPoseInWorld(self.context)
        moving = self.links["B"].EvalSpatialVelocityInWorld(self.context)
        return State(
            pose.translation(), pose.rotation().ToQuaternion().wxyz(),
            np.array([joint.get_angle(self.context) for joint in self.joints]),
            moving.translational(), moving.rotational(),
            np.array([joint.get_angular_rate(self.context) for joint in self.joints]),
        )  # fmt: skip

    def bodies(self):
        found = {}
        for letter, link in self.links.items():
            pose, moving = (
                link.EvalPoseInWorld(self.context), link.EvalSpatialVelocityInWorld(self.context)
            )  # fmt: skip
            axes = pose.rotation().matrix()
            arm = axes @ link.CalcCenterOfMassInBodyFrame(self.context)
            turning = moving.rotational()
            found[letter] = Body(
                link.get_mass(self.context), pose.translation() + arm,
                moving.translational() + np.cross(turning, arm), axes, turning,
            )  # fmt: skip
        return found

    def energies(self):
        return (
            self.plant.CalcPotentialEnergy(self.context), self.plant.CalcKineticEnergy(self.context)
        )  # fmt: skip

    def mass_matrix(self):
        plant, context = self.plant, self.context
        own = self.own_order()
        return own.T @ plant.CalcMassMatrix(context) @ own

    def own_order(self):
        """Matrix from our velocities to Drake's, which begin with the angular velocity."""
        own = np.zeros((9, 9))
        first = self.links["B"].floating_velocities_start_in_v()
        own[first : first + 3, 3:6] = own[first + 3 : first + 6, :3] = np.eye(3)
        for i, joint in enumerate(self.joints):
            own[joint.velocity_start(), 6 + i] = 1
        return own

    def bias(self):
        plant, context = self.plant, self.context
        force = plant.CalcBiasTerm(context) - plant.CalcGravityGeneralizedForces(context)
        return self.own_order().T @ force

    def step(self, seconds):
        self.simulator.AdvanceTo(self.simulator.get_context().get_time() + seconds)


if __name__ == "__main__":
    main(Engine)

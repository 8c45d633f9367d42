"""The bicycle of ``heyoka-bike export --model urdf`` in Pinocchio; see `bicycle`.

Pinocchio moves no wheels on floors: that the lowest point of each wheel stands still is added here
to the equations of its tree, and they are integrated by Runge-Kutta 4.
"""

import numpy as np
import pinocchio as pin

from bicycle import UP, Body, State, cross_matrix, lowest, lowest_rate, main, parameter, rotation

AXES = pin.LOCAL_WORLD_ALIGNED


class Engine:
    """Pinocchio's tree of joints."""

    STEP = 0.005

    def __init__(self, file, step=STEP):
        self.step_size = step
        # Without the free joint B would be fixed to the ground, and its mass ignored.
        self.model = pin.buildModelFromUrdf(file, pin.JointModelFreeFlyer())
        self.data = self.model.createData()
        joints = ("root_joint", "rear_axle", "steer_axis", "front_axle")
        self.joints = dict(zip("BRHF", map(self.model.getJointId, joints), strict=True))
        # URDF has no gravity.
        self.gravity = parameter(file, "g")
        self.model.gravity.linear = -self.gravity * UP
        self.radii = [parameter(file, "rR"), parameter(file, "rF")]
        self.q, self.v = pin.neutral(self.model), np.zeros(self.model.nv)

    def set(self, state):
        w, *along = state.attitude
        # In q a joint without limits is its cosine and its sine.
        circles = np.ravel([[np.cos(x), np.sin(x)] for x in state.angles])
        self.q = np.concatenate([state.place, along, [w], circles])
        back = rotation(state.attitude).T
        self.v = np.concatenate([back @ state.velocity, back @ state.turning, state.rates])

    def state(self):
        x, y, z, w = self.q[3:7]
        axes = rotation([w, x, y, z])
        angles = np.arctan2(self.q[8::2], self.q[7::2])
        return State(
            self.q[:3], np.array([w, x, y, z]), angles,
            axes @ self.v[:3], axes @ self.v[3:6], self.v[6:],
        )  # fmt: skip

    def bodies(self):
        pin.forwardKinematics(self.model, self.data, self.q, self.v)
        found = {}
        for letter, joint in self.joints.items():
            inertia, place = self.model.inertias[joint], self.data.oMi[joint]
            both = pin.getVelocity(self.model, self.data, joint, AXES)
            arm = place.rotation @ inertia.lever
            found[letter] = Body(
                inertia.mass, place.translation + arm, both.linear + np.cross(both.angular, arm),
                place.rotation.copy(), both.angular,
            )  # fmt: skip
        return found

    def energies(self):
        return (
            pin.computePotentialEnergy(self.model, self.data, self.q),
            pin.computeKineticEnergy(self.model, self.data, self.q, self.v),
        )

    def mass_matrix(self):
        own, back = np.eye(9), self.state().attitude
        own[:3, :3] = own[3:6, 3:6] = rotation(back).T
        return own.T @ pin.crba(self.model, self.data, self.q) @ own

    def bias(self):
        """Convert from Pinocchio's velocities of the base, which are along its rotating axes."""
        state, own = self.state(), np.eye(9)
        own[:3, :3] = own[3:6, 3:6] = rotation(state.attitude).T
        turned = np.zeros(9)
        turned[:3] = -np.cross(self.v[3:6], self.v[:3])
        matrix = pin.crba(self.model, self.data, self.q)
        return own.T @ (
            pin.nonLinearEffects(self.model, self.data, self.q, self.v) + matrix @ turned
        )

    def accelerations(self, q, v):
        """Accelerations with the floor's forces, which keep both wheels' lowest points at rest."""
        model, data = self.model, self.data
        bias, mass = pin.nonLinearEffects(model, data, q, v), pin.crba(model, data, q)
        pin.computeJointJacobians(model, data, q)
        pin.forwardKinematics(model, data, q, v, np.zeros(9))
        rows, drifts = [], []
        for wheel, radius in zip("RF", self.radii, strict=True):
            joint = self.joints[wheel]
            axes = data.oMi[joint].rotation
            velocity = pin.getVelocity(model, data, joint, AXES)
            drift = pin.getClassicalAcceleration(model, data, joint, AXES)
            arm = lowest(Body(0, 0, 0, axes, 0), radius)
            moving = lowest_rate(Body(0, 0, 0, axes, velocity.angular), radius)
            jacobian = pin.getJointJacobian(model, data, joint, AXES)
            rows.append(jacobian[:3] - cross_matrix(arm) @ jacobian[3:])
            drifts.append(
                drift.linear + np.cross(drift.angular, arm) + np.cross(velocity.angular, moving)
            )
        rows, drifts = np.vstack(rows), np.concatenate(drifts)
        system = np.block([[mass, rows.T], [rows, np.zeros((6, 6))]])
        return np.linalg.solve(system, np.concatenate([-bias, -drifts]))[:9]

    def step(self, seconds):
        for _ in range(round(seconds / self.step_size)):
            self.q, self.v = self.runge_kutta(self.q, self.v, self.step_size)

    def runge_kutta(self, q, v, h):
        """Step in the chart of displacements from q, whose rates differ from the speeds."""

        def slope(u, v):
            there = pin.integrate(self.model, q, u)
            turned = pin.dIntegrate(self.model, q, u, pin.ARG1)
            return np.linalg.solve(turned, v), self.accelerations(there, v)

        u1, a1 = slope(np.zeros(9), v)
        u2, a2 = slope(h / 2 * u1, v + h / 2 * a1)
        u3, a3 = slope(h / 2 * u2, v + h / 2 * a2)
        u4, a4 = slope(h * u3, v + h * a3)
        u = h / 6 * (u1 + 2 * u2 + 2 * u3 + u4)
        return pin.integrate(self.model, q, u), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)


if __name__ == "__main__":
    main(Engine)

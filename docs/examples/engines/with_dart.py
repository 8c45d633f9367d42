"""The bicycle of ``heyoka-bike export --model sdf`` in DART; see `bicycle`."""

from pathlib import Path

import dartpy as dart
import numpy as np

from bicycle import Body, State, main, parameter

WIDTH = 1e-6
"""Width of the wheels' contact shapes [m]."""


def rotation_vector(quaternion):
    """Axis of a rotation times its angle plus a full turn.

    Below 1e-3 rad DART replaces the angle by its sine. With a full turn added it is accurate.
    """
    scalar, along = quaternion[0], np.array(quaternion[1:])
    half = np.linalg.norm(along)
    return 2 * (np.arctan2(half, scalar) + np.pi) / half * along if half else along


class Engine:
    """DART's skeleton; contact and friction are impulses."""

    STEP = 0.001

    def __init__(self, file, step=STEP):
        self.step_size = step
        self.world = dart.utils.SdfParser.readWorld(str(Path(file).resolve()))
        self.world.setTimeStep(step)
        self.gravity = -self.world.getGravity()[2]
        self.skeleton = self.world.getSkeleton("bicycle")
        self.links = {letter: self.skeleton.getBodyNode(letter) for letter in "BRHF"}
        self.joints = [self.skeleton.getJoint(x) for x in ("rear_axle", "steer_axis", "front_axle")]
        self.radii = [parameter(file, "rR"), parameter(file, "rF")]
        self.sharpen()

    def sharpen(self):
        """Replace contact shapes: DART reads the floor as a box, and does not read ellipsoids.

        A leaning cylinder touches with the rim of one side. An ellipsoid touches where the knife
        edge does, if the floor is a plane and the contact is found by FCL, DART's default.
        """
        floor = self.world.getSkeleton("floor").getBodyNode(0)
        shapes = [(floor, dart.dynamics.PlaneShape([0, 0, 1], 0))]
        for letter, radius in zip("RF", self.radii, strict=True):
            size = [2 * radius, WIDTH, 2 * radius]
            shapes.append((self.links[letter], dart.dynamics.EllipsoidShape(size)))
        for body, shape in shapes:
            (touching,) = (x for x in body.getShapeNodes() if x.hasCollisionAspect())
            touching.setShape(shape)
            touching.setRelativeTransform(dart.math.Isometry3())

    def set(self, state):
        root = self.skeleton.getRootJoint()
        root.setPositions([*rotation_vector(state.attitude), *state.place])
        for joint, angle, rate in zip(self.joints, state.angles, state.rates, strict=True):
            joint.setPosition(0, angle)
            joint.setVelocity(0, rate)
        root.setLinearVelocity(state.velocity)
        root.setAngularVelocity(state.turning)

    def state(self):
        base = self.links["B"]
        pose = base.getWorldTransform()
        return State(
            pose.translation(), pose.quaternion().wxyz(),
            np.array([joint.getPosition(0) for joint in self.joints]),
            base.getLinearVelocity(), base.getAngularVelocity(),
            np.array([joint.getVelocity(0) for joint in self.joints]),
        )  # fmt: skip

    def bodies(self):
        return {
            letter: Body(
                link.getMass(), link.getCOM(), link.getCOMLinearVelocity(),
                link.getWorldTransform().rotation(), link.getAngularVelocity(),
            )
            for letter, link in self.links.items()
        }  # fmt: skip

    def energies(self):
        return self.skeleton.computePotentialEnergy(), self.skeleton.computeKineticEnergy()

    def mass_matrix(self):
        own = self.own_order()
        return own.T @ self.skeleton.getMassMatrix() @ own

    def own_order(self):
        """Matrix from our velocities to DART's, which begin with the angular velocity."""
        now, own = self.state(), np.zeros((9, 9))
        for i, unit in enumerate(np.eye(9)):
            self.set(now._replace(velocity=unit[:3], turning=unit[3:6], rates=unit[6:]))
            own[:, i] = self.skeleton.getVelocities()
        self.set(now)
        return own

    def bias(self):
        return self.own_order().T @ self.skeleton.getCoriolisAndGravityForces()

    def step(self, seconds):
        for _ in range(round(seconds / self.step_size)):
            self.world.step()


if __name__ == "__main__":
    main(Engine)

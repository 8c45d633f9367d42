"""The bicycle of ``heyoka-bike export --model urdf`` in PyBullet; see `bicycle`."""

import sys

import numpy as np
import pybullet as bullet

from bicycle import (
    CAMERAS,
    HEIGHT,
    MIDDLE,
    UP,
    WIDTH,
    Body,
    State,
    cross_matrix,
    drifts,
    main,
    parameter,
    product,
    rotation,
    velocities,
)

UNIT = 0.001
"""Unit of length in which Bullet moves the bicycle [m].

Bullet rounds the rims of wheels by a fixed number of units, so rims are sharper in millimetres.
The mass matrix is computed in metres: in other units rounding fails Bullet's check of symmetry.
"""

JOINTS = ("rear_axle", "steer_axis", "front_axle")


class Engine:
    """Bullet's multibody; contact and friction are impulses."""

    STEP = 0.001

    def __init__(self, file, step=None):
        self.step_size = step or self.STEP
        self.unit = UNIT if step else 1.0
        bullet.connect(bullet.GUI if "--view" in sys.argv else bullet.DIRECT)
        # URDF has no gravity.
        self.gravity = parameter(file, "g")
        bullet.setGravity(0, 0, -self.gravity / self.unit)
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=self.step_size, solverResidualThreshold=0, contactSlop=0
        )  # fmt: skip
        # Without these flags Bullet computes inertias from shapes, and cylinders have 32 corners.
        flags = bullet.URDF_USE_INERTIA_FROM_FILE | bullet.URDF_USE_IMPLICIT_CYLINDER
        self.bike = bullet.loadURDF(str(file), flags=flags, globalScaling=1 / self.unit)
        box = bullet.createVisualShape(
            bullet.GEOM_BOX, halfExtents=[100 / self.unit, 100 / self.unit, 0.01 / self.unit],
            rgbaColor=[0.85, 0.86, 0.86, 1], visualFramePosition=[0, 0, -0.01 / self.unit],
        )  # fmt: skip
        floor = bullet.createMultiBody(
            0, bullet.createCollisionShape(bullet.GEOM_PLANE), box
        )  # fmt: skip
        names = {bullet.getJointInfo(self.bike, i)[1].decode(): i for i in range(3)}
        self.joints = [names[name] for name in JOINTS]
        self.links = dict(zip("BRHF", [-1, *self.joints], strict=True))
        # Switch off the default damping and motors, and set a friction that prevents slip.
        for body, link in ((floor, -1), *((self.bike, link) for link in self.links.values())):
            bullet.changeDynamics(
                body, link, lateralFriction=1, linearDamping=0, angularDamping=0, jointDamping=0,
                maxJointVelocity=1e9,
            )  # fmt: skip
        for joint in self.joints:
            bullet.setJointMotorControl2(self.bike, joint, bullet.VELOCITY_CONTROL, force=0)
        self.info = {
            letter: bullet.getDynamicsInfo(self.bike, link) for letter, link in self.links.items()
        }
        # Bullet scales places and shapes, but not the moments of inertia.
        for letter, link in self.links.items():
            moments = np.array(self.info[letter][2]) / self.unit**2
            bullet.changeDynamics(self.bike, link, localInertiaDiagonal=list(moments))
        # The base frame is at the centre of mass of the link B, along principal axes. NumPy rotates
        # it here, because multiplyTransforms has only the digits of binary32.
        self.centre = np.array(self.info["B"][3]) * self.unit
        self.principal = np.roll(self.info["B"][4], 1)
        self.radii = [parameter(file, "rR"), parameter(file, "rF")]

    def set(self, state):
        arm = rotation(state.attitude) @ self.centre
        x, y, z, w = np.roll(product(state.attitude, self.principal), -1)
        place = (state.place + arm) / self.unit
        bullet.resetBasePositionAndOrientation(self.bike, place, [x, y, z, w])
        velocity = (state.velocity + np.cross(state.turning, arm)) / self.unit
        bullet.resetBaseVelocity(self.bike, velocity, state.turning)
        for joint, angle, rate in zip(self.joints, state.angles, state.rates, strict=True):
            bullet.resetJointState(self.bike, joint, angle, rate)

    def state(self):
        centre, turned = bullet.getBasePositionAndOrientation(self.bike)
        attitude = product(np.roll(turned, 1), self.principal * [1, -1, -1, -1])
        velocity, turning = map(np.array, bullet.getBaseVelocity(self.bike))
        arm = rotation(attitude) @ self.centre
        joints = [bullet.getJointState(self.bike, joint)[:2] for joint in self.joints]
        angles, rates = np.array(joints).T
        return State(
            np.array(centre) * self.unit - arm, attitude, angles,
            velocity * self.unit - np.cross(turning, arm), turning, rates,
        )  # fmt: skip

    def bodies(self):
        base = self.state()
        arm = rotation(base.attitude) @ self.centre
        found = {
            "B": Body(
                self.info["B"][0], base.place + arm, base.velocity + np.cross(base.turning, arm),
                rotation(base.attitude), base.turning,
            )
        }  # fmt: skip
        for letter, joint in zip("RHF", self.joints, strict=True):
            link = bullet.getLinkState(self.bike, joint, True, True)
            centre, velocity, turning = (np.array(link[i]) for i in (0, 6, 7))
            # Use the inertial frame's attitude: that of the link has only the digits of binary32.
            principal = rotation(np.roll(self.info[letter][4], 1))
            axes = rotation(np.roll(link[1], 1)) @ principal.T
            found[letter] = Body(
                self.info[letter][0], centre * self.unit, velocity * self.unit, axes, turning
            )  # fmt: skip
        return found

    def tensors(self):
        """Inertia of each body along the ground's axes, from Bullet's principal moments."""
        found = {}
        for letter, body in self.bodies().items():
            principal = body.axes @ rotation(np.roll(self.info[letter][4], 1))
            found[letter] = principal @ np.diag(self.info[letter][2]) @ principal.T
        return found

    def bias(self):
        """Sum the forces over the bodies, because Bullet returns none for a free base."""
        per, bodies, tensors = velocities(self, self.state()), self.bodies(), self.tensors()
        found = np.zeros(9)
        for letter, (linear, angular) in drifts(bodies, per).items():
            body, tensor = bodies[letter], tensors[letter]
            force = body.mass * (linear + self.gravity * UP)
            moment = tensor @ angular + np.cross(body.turning, tensor @ body.turning)
            found += per[letter].T @ np.concatenate([force, moment])
        return found

    def energies(self):
        """Sum the energies over the bodies, because Bullet returns none."""
        potential = kinetic = 0.0
        tensors = self.tensors()
        for letter, body in self.bodies().items():
            potential += body.mass * self.gravity * body.centre[2]
            kinetic += body.mass * (body.velocity @ body.velocity) / 2
            kinetic += body.turning @ tensors[letter] @ body.turning / 2
        return potential, kinetic

    def mass_matrix(self):
        """Reorder Bullet's matrix: its angular velocity is first, in the axes of the base."""
        state = self.state()
        axes = rotation(state.attitude)
        back, own = (axes @ rotation(self.principal)).T, np.eye(9)
        own[:3, :3], own[:3, 3:6] = 0, back
        own[3:6, :3], own[3:6, 3:6] = back, -back @ cross_matrix(axes @ self.centre)
        own[3:6] /= self.unit
        found = np.array(bullet.calculateMassMatrix(self.bike, list(state.angles)))
        return self.unit**2 * own.T @ found @ own

    def step(self, seconds):
        for _ in range(round(seconds / self.step_size)):
            bullet.stepSimulation()

    def picture(self, camera):
        away, up = CAMERAS[camera]
        middle = (self.state().place * [1, 1, 0] + MIDDLE) / self.unit
        eye = middle + np.array(away) / self.unit
        seen = bullet.computeViewMatrix(list(eye), list(middle), up)
        field = bullet.computeProjectionMatrixFOV(
            45, WIDTH / HEIGHT, 0.1 / self.unit, 30 / self.unit
        )
        _, _, pixels, *_ = bullet.getCameraImage(
            WIDTH, HEIGHT, seen, field, [2, -3, 5], renderer=bullet.ER_TINY_RENDERER
        )  # fmt: skip
        return np.reshape(pixels, (HEIGHT, WIDTH, 4))[:, :, :3].astype(np.uint8)

    def view(self):
        def show():
            middle = (self.state().place * [1, 1, 0] + MIDDLE) / self.unit
            bullet.resetDebugVisualizerCamera(3.2 / self.unit, -45, -15, list(middle))

        return show


if __name__ == "__main__":
    main(Engine)

"""The bicycle of ``heyoka-bike export --model mjcf`` in MuJoCo; see `bicycle`."""

import os
import sys

import numpy as np

from bicycle import HEIGHT, WIDTH, Body, State, main, parameter, rotation

# Without a window MuJoCo draws by EGL or OSMesa, to be chosen before MuJoCo is imported.
if sys.platform == "linux" and {"--movie", "--strip"} & set(sys.argv):
    os.environ.setdefault("MUJOCO_GL", "egl")

import mujoco


class Engine:
    """MuJoCo's model with the settings of the file; contact and friction are soft."""

    STEP = None  # the step of the file

    def __init__(self, file, step=STEP):
        self.model = mujoco.MjModel.from_xml_path(file)
        self.model.opt.timestep = step or self.model.opt.timestep
        self.model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
        self.data = mujoco.MjData(self.model)
        self.gravity = parameter(file, "g")
        self.radii = [parameter(file, "rR"), parameter(file, "rF")]
        self.renderer = None

    def set(self, state):
        self.data.qpos[:] = *state.place, *state.attitude, *state.angles
        # The angular velocity of a free body is along its own axes.
        turning = rotation(state.attitude).T @ state.turning
        self.data.qvel[:] = *state.velocity, *turning, *state.rates
        mujoco.mj_forward(self.model, self.data)

    def state(self):
        q, v = self.data.qpos, self.data.qvel
        turning = rotation(q[3:7]) @ v[3:6]
        return State(*(x.copy() for x in (q[:3], q[3:7], q[7:], v[:3], turning, v[6:])))

    def bodies(self):
        found, centre = {}, mujoco.mjtObj.mjOBJ_BODY
        for letter in "BRHF":
            body, both = self.data.body(letter), np.zeros(6)
            mujoco.mj_objectVelocity(self.model, self.data, centre, body.id, both, 0)
            found[letter] = Body(
                self.model.body(letter).mass[0], body.xipos.copy(), both[3:],
                body.xmat.reshape(3, 3).copy(), both[:3],
            )  # fmt: skip
        return found

    def energies(self):
        mujoco.mj_energyPos(self.model, self.data)
        mujoco.mj_energyVel(self.model, self.data)
        return tuple(self.data.energy)

    def mass_matrix(self):
        full = np.zeros((9, 9))
        mujoco.mj_fullM(self.model, self.data, full)
        own = self.own_axes()
        return own.T @ full @ own

    def own_axes(self):
        """Matrix from our velocities to MuJoCo's, with the angular velocity in the base's axes."""
        own = np.eye(9)
        own[3:6, 3:6] = rotation(self.data.qpos[3:7]).T
        return own

    def bias(self):
        return self.own_axes().T @ self.data.qfrc_bias

    def step(self, seconds):
        mujoco.mj_step(self.model, self.data, round(seconds / self.model.opt.timestep))
        mujoco.mj_forward(self.model, self.data)

    def picture(self, camera):
        if self.renderer is None:
            self.renderer = mujoco.Renderer(self.model, HEIGHT, WIDTH)
        self.renderer.update_scene(self.data, camera)
        return self.renderer.render()

    def view(self):
        from mujoco import viewer

        window = viewer.launch_passive(self.model, self.data)
        window.cam.type = mujoco.mjtCamera.mjCAMERA_FIXED
        window.cam.fixedcamid = self.model.camera("follow").id
        return window.sync


if __name__ == "__main__":
    main(Engine)

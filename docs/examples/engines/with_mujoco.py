"""The bicycle of ``heyoka-bike export --model mjcf`` in MuJoCo; see `bicycle`."""

import mujoco
import numpy as np

from bicycle import Body, State, main, parameter, rotation

STEP = 0.001
"""Of the time [s]."""


class Engine:
    """MuJoCo's model: its wheels are held by soft contact and friction."""

    def __init__(self, file):
        self.model = mujoco.MjModel.from_xml_path(file)
        self.model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
        self.model.opt.timestep = STEP
        self.data = mujoco.MjData(self.model)
        self.radii = [parameter(file, "rR"), parameter(file, "rF")]

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
        own = np.eye(9)
        own[3:6, 3:6] = rotation(self.data.qpos[3:7]).T
        return own.T @ full @ own

    def step(self, seconds):
        mujoco.mj_step(self.model, self.data, round(seconds / STEP))
        mujoco.mj_forward(self.model, self.data)


if __name__ == "__main__":
    main(Engine)

"""The uncontrolled bicycle in MuJoCo: a free body, three hinges, two ellipsoids on a plane.

``simulate`` is what `../field.py` calls. MuJoCo has no rolling constraint: the wheels are thin
ellipsoids, held up and driven by its soft contact and friction. Axes: x forward, y left, z up.
"""

import time

import mujoco
import numpy as np

MODEL = """
<mujoco>
  <option timestep="{step}" integrator="{integrator}" gravity="0 0 -{g}" cone="{cone}"
          impratio="{impratio}" solver="{solver}" iterations="100" tolerance="{tolerance}">
    <flag energy="enable"/>
  </option>
  <default>
    <geom type="ellipsoid" mass="0" contype="1" conaffinity="2" condim="3" friction="{friction}"
          solref="{stiffness}" solimp="{impedance}"/>
  </default>
  <worldbody>
    <geom type="plane" size="0 0 1" contype="2" conaffinity="1"/>
    <body name="B" pos="0 0 {rR}">
      <freejoint/>
      <inertial pos="{xB} 0 {up_B}" mass="{mB}" fullinertia="{IBxx} {IByy} {IBzz} 0 {over_B} 0"/>
      <site name="hub"/>
      <body name="R">
        <joint name="R" axis="0 1 0"/>
        <inertial pos="0 0 0" mass="{mR}" diaginertia="{IRxx} {IRyy} {IRxx}"/>
        <geom size="{rR} {thin} {rR}"/>
      </body>
      <body name="H" pos="{w} 0 {up_F}">
        <joint name="steer" axis="{axis_x} 0 {axis_z}" pos="{trail} 0 -{rF}"/>
        <inertial pos="{ahead_H} 0 {up_H}" mass="{mH}"
                  fullinertia="{IHxx} {IHyy} {IHzz} 0 {over_H} 0"/>
        <body name="F">
          <joint name="F" axis="0 1 0"/>
          <inertial pos="0 0 0" mass="{mF}" diaginertia="{IFxx} {IFyy} {IFxx}"/>
          <geom size="{rF} {thin} {rF}"/>
        </body>
      </body>
    </body>
  </worldbody>
  <sensor><gyro site="hub"/><velocimeter site="hub"/></sensor>
</mujoco>
"""


def simulate(
    p, speed, roll_rate, step, integrator="Euler", stiffness="0.02 1", impedance="0.9 0.95 0.001",
    cone="pyramidal", impratio=1, friction=1, tolerance=1e-8, thin=0.001, settle=0.0,
    softness=None, solver="Newton", rate=100,
):  # fmt: skip
    """Rows of the eight columns, `rate` a second, and the processor time of the simulation [s].

    Values by default are MuJoCo's own. ``softness`` is the time constant of the contact in steps,
    in place of the stiffness; ``settle`` [s] lets the standing bicycle sink into the floor before
    it starts.
    """
    if softness:
        stiffness = f"{softness * step} 1"
    text = MODEL.format(
        **p, step=step, integrator=integrator, stiffness=stiffness, impedance=impedance,
        cone=cone, impratio=impratio, friction=friction, tolerance=tolerance, thin=thin,
        solver=solver,
        up_B=-p["zB"] - p["rR"], up_F=p["rF"] - p["rR"], up_H=-p["zH"] - p["rF"],
        ahead_H=p["xH"] - p["w"], trail=p["c"], over_B=-p["IBxz"], over_H=-p["IHxz"],
        axis_x=np.sin(p["lam"]), axis_z=-np.cos(p["lam"]),
    )  # fmt: skip
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, round(settle / step))
    data.time = 0.0
    # Velocity of the rear hub, angular velocity of the frame, rates of the three hinges.
    rear, front = speed / p["rR"], speed / p["rF"]
    data.qvel[:] = [speed, -roll_rate * p["rR"], 0, roll_rate, 0, 0, rear, 0, front]
    rows, cpu, each = [], 0.0, round(1 / rate / step)
    for row in range(1001):
        begin = time.process_time()
        if row:
            mujoco.mj_step(model, data, each)
        cpu += time.process_time() - begin
        mujoco.mj_forward(model, data)
        w, x, y, z = data.qpos[3:7]
        roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        potential, kinetic = data.energy
        rows.append([
            roll, data.sensordata[0], data.sensordata[3], potential, kinetic, potential + kinetic,
            data.joint("steer").qpos[0], data.joint("steer").qvel[0],
        ])  # fmt: skip
    return np.array(rows), cpu

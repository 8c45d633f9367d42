// The uncontrolled bicycle in Rapier: four bodies, three revolute joints, two cylinders on a half
// space. Axes: x forward, y left, z up.
//
// Reads lines "name value" (parameters, speed, roll_rate, step, width of the wheels, iterations,
// recentre), writes the eight columns every 0.01 s, and the processor time of the simulation [s] as an
// error message. This package computes in binary32.

import RAPIER from "@dimforge/rapier3d-compat";
import { readFileSync } from "node:fs";

const given = readFileSync(0, "utf8").trim().split("\n").map((line) => line.split(" "));
const p = Object.fromEntries(given.map(([name, value]) => [name, Number(value)]));
const vector = (x, y, z) => ({ x, y, z });
const minus = (a, b) => vector(a.x - b.x, a.y - b.y, a.z - b.z);
const dot = (a, b) => a.x * b.x + a.y * b.y + a.z * b.z;
const cross = (a, b) =>
  vector(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
// A vector turned by a quaternion.
const turned = (q, a) => {
  const half = cross(q, a), twice = cross(q, half);
  return vector(
    a.x + 2 * (q.w * half.x + twice.x), a.y + 2 * (q.w * half.y + twice.y),
    a.z + 2 * (q.w * half.z + twice.z),
  );
};
const inverse = (q) => ({ x: -q.x, y: -q.y, z: -q.z, w: q.w });

await RAPIER.init();
const world = new RAPIER.World(vector(0, 0, -p.g));
world.timestep = p.step;
if (p.iterations) world.integrationParameters.numSolverIterations = p.iterations;

// Origins of the frames: rear hub, steer axis on the floor, front hub; centres of mass from there.
const hubs = { R: vector(0, 0, p.rR), F: vector(p.w, 0, p.rF) };
const foot = vector(p.w + p.c, 0, 0);
const origins = { B: hubs.R, R: hubs.R, H: foot, F: hubs.F };
const centres = {
  B: minus(vector(p.xB, 0, -p.zB), hubs.R), R: vector(0, 0, 0),
  H: minus(vector(p.xH, 0, -p.zH), foot), F: vector(0, 0, 0),
};
const bodies = {}, tensors = {};
for (const [b, at] of Object.entries(origins)) {
  const xx = p[`I${b}xx`], zz = p[`I${b}zz`] ?? xx, xz = -(p[`I${b}xz`] ?? 0); // z up
  tensors[b] = { xx, yy: p[`I${b}yy`], zz, xz };
  // Principal axes: turn by an angle about y.
  const angle = Math.atan2(-2 * xz, xx - zz) / 2, mean = (xx + zz) / 2;
  const apart = Math.hypot((xx - zz) / 2, xz);
  const principal = vector(mean + apart, p[`I${b}yy`], mean - apart);
  const frame = { x: 0, y: Math.sin(angle / 2), z: 0, w: Math.cos(angle / 2) };
  const spin = b in hubs ? p.speed / p[`r${b}`] : 0;
  const body = world.createRigidBody(
    RAPIER.RigidBodyDesc.dynamic().setTranslation(at.x, at.y, at.z).setCanSleep(false)
      .setAdditionalMassProperties(p[`m${b}`], centres[b], principal, frame),
  );
  bodies[b] = body;
  if (b in hubs) {
    const wheel = RAPIER.ColliderDesc.cylinder((p.width ?? 0.002) / 2, p[`r${b}`]);
    world.createCollider(wheel.setDensity(0).setFriction(1), body);
  }
  // The whole bicycle turns about the line of the contact points.
  const height = at.z + centres[b].z;
  body.setLinvel(vector(p.speed, -p.roll_rate * height, 0), true);
  body.setAngvel(vector(p.roll_rate, spin, 0), true);
}
const floor = new RAPIER.ColliderDesc(new RAPIER.HalfSpace(vector(0, 0, 1)));
world.createCollider(floor.setFriction(1));
const hinge = (one, other, at, axis) => {
  const joint = RAPIER.JointData.revolute(minus(at, origins[one]), minus(at, origins[other]), axis);
  world.createImpulseJoint(joint, bodies[one], bodies[other], true);
};
const steer = vector(Math.sin(p.lam), 0, -Math.cos(p.lam));
hinge("B", "R", hubs.R, vector(0, 1, 0));
hinge("B", "H", foot, steer);
hinge("H", "F", hubs.F, vector(0, 1, 0));

const each = Math.round(0.01 / p.step);
let cpu = 0;
for (let row = 0; row <= 1000; ++row) {
  if (p.recentre && row) { // far from the origin binary32 has few digits left
    const { x, y } = bodies.B.translation();
    for (const body of Object.values(bodies)) {
      const at = body.translation();
      body.setTranslation(vector(at.x - x, at.y - y, at.z), true);
    }
  }
  const begin = process.cpuUsage();
  for (let i = 0; row && i < each; ++i) world.step();
  const used = process.cpuUsage(begin);
  cpu += (used.user + used.system) / 1e6;
  let potential = 0, kinetic = 0;
  for (const [b, body] of Object.entries(bodies)) {
    const v = body.linvel(), I = tensors[b], m = p[`m${b}`];
    const w = turned(inverse(body.rotation()), body.angvel());
    const turning = I.xx * w.x ** 2 + I.yy * w.y ** 2 + I.zz * w.z ** 2 + 2 * I.xz * w.x * w.z;
    potential += m * p.g * (body.translation().z + turned(body.rotation(), centres[b]).z);
    kinetic += (m * dot(v, v) + turning) / 2;
  }
  const q = bodies.B.rotation(), spin = bodies.B.angvel();
  const ahead = turned(q, vector(1, 0, 0)), left = turned(q, vector(0, 1, 0));
  // About the steer axis from the rear frame's left to the fork's.
  const axis = turned(q, steer), other = turned(bodies.H.rotation(), vector(0, 1, 0));
  const angle = Math.atan2(dot(cross(left, other), axis), dot(left, other));
  const rate = dot(minus(bodies.H.angvel(), spin), axis);
  const columns = [
    Math.asin(left.z), dot(spin, ahead), dot(bodies.R.linvel(), ahead), potential, kinetic,
    potential + kinetic, angle, rate,
  ];
  console.log(columns.join(" "));
}
console.error(cpu);

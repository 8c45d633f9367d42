// The uncontrolled bicycle in cannon-es: four bodies, three hinge constraints, and a contact with
// friction at the lowest point of each wheel, placed by this script. Axes: x forward, y left, z up.
//
// Reads lines "name value" (parameters, speed, roll_rate, step, iterations, damping, gyroscopic,
// stiffness), writes the eight columns every 0.01 s, and the processor time of the simulation [s] as
// an error message. Values that are not given are cannon-es' own.

import * as CANNON from "cannon-es";
import { readFileSync } from "node:fs";

const given = readFileSync(0, "utf8").trim().split("\n").map((line) => line.split(" "));
const p = Object.fromEntries(given.map(([name, value]) => [name, Number(value)]));
const vector = (x, y, z) => new CANNON.Vec3(x, y, z);
const AXLE = vector(0, 1, 0), steer = vector(Math.sin(p.lam), 0, -Math.cos(p.lam));

const solver = new CANNON.GSSolver();
if (p.iterations) Object.assign(solver, { iterations: p.iterations, tolerance: 0 });
const world = new CANNON.World({ gravity: vector(0, 0, -p.g), solver });
const floor = new CANNON.Body({ mass: 0 });
world.addBody(floor);

const hubs = { R: vector(0, 0, p.rR), F: vector(p.w, 0, p.rF) };
const centres = { B: vector(p.xB, 0, -p.zB), H: vector(p.xH, 0, -p.zH), ...hubs };
const bodies = {}, frames = {}, tensors = {};
for (const [b, at] of Object.entries(centres)) {
  const xx = p[`I${b}xx`], zz = p[`I${b}zz`] ?? xx, xz = -(p[`I${b}xz`] ?? 0); // z up
  // Principal axes: turn by an angle about y.
  const angle = Math.atan2(-2 * xz, xx - zz) / 2, mean = (xx + zz) / 2;
  const apart = Math.hypot((xx - zz) / 2, xz);
  const body = new CANNON.Body({ mass: p[`m${b}`], position: at });
  if (p.damping !== undefined) body.linearDamping = body.angularDamping = p.damping;
  tensors[b] = vector(mean + apart, p[`I${b}yy`], mean - apart);
  body.updateMassProperties = () => {}; // those of shapes, of which there are none
  body.inertia.copy(tensors[b]);
  body.invInertia.set(1 / tensors[b].x, 1 / tensors[b].y, 1 / tensors[b].z);
  body.quaternion.setFromAxisAngle(AXLE, angle);
  frames[b] = body.quaternion.inverse();
  // The whole bicycle turns about the line of the contact points.
  body.velocity.set(p.speed, -p.roll_rate * at.z, 0);
  body.angularVelocity.set(p.roll_rate, b in hubs ? p.speed / p[`r${b}`] : 0, 0);
  body.updateInertiaWorld(true);
  world.addBody(body);
  bodies[b] = body;
}
// A direction of the upright bicycle, and its place in a body, where the body is now.
const along = (b, a) => bodies[b].quaternion.vmult(frames[b].vmult(a));
const hinge = (one, other, at, axis) => {
  const side = (b) => [frames[b].vmult(at.vsub(centres[b])), frames[b].vmult(axis)];
  const [pivotA, axisA] = side(one), [pivotB, axisB] = side(other);
  const options = { pivotA, axisA, pivotB, axisB, maxForce: 1e9 };
  world.addConstraint(new CANNON.HingeConstraint(bodies[one], bodies[other], options));
};
hinge("B", "R", hubs.R, AXLE);
hinge("H", "F", hubs.F, AXLE);
hinge("B", "H", vector(p.w + p.c, 0, 0), steer);

class Touch extends CANNON.Constraint {
  constructor(wheel) {
    super(bodies[wheel], floor);
    this.wheel = wheel;
    this.normal = new CANNON.ContactEquation(bodies[wheel], floor, 1e9);
    this.frictions = [0, 1].map(() => new CANNON.FrictionEquation(bodies[wheel], floor, 1e9));
    this.frictions[0].t.set(1, 0, 0);
    this.frictions[1].t.set(0, 1, 0);
    this.equations.push(this.normal, ...this.frictions);
    this.normal.ni.set(0, 0, -1);
  }
  update() {
    // The lowest point of the rim: down, less its part along the axle.
    const axle = along(this.wheel, AXLE), r = p[`r${this.wheel}`];
    const length = Math.sqrt(1 - axle.z * axle.z), hub = bodies[this.wheel].position;
    const arm = vector(axle.z * axle.x, axle.z * axle.y, axle.z * axle.z - 1).scale(r / length);
    for (const equation of this.equations) {
      equation.ri.copy(arm);
      equation.rj.set(hub.x + arm.x, hub.y + arm.y, 0);
    }
  }
}
for (const wheel of ["R", "F"]) world.addConstraint(new Touch(wheel));
if (p.stiffness) // with the relaxation that it has by itself
  for (const { equations } of world.constraints)
    for (const equation of equations) equation.setSpookParams(p.stiffness, 4, p.step);

const each = Math.round(0.01 / p.step);
let cpu = 0;
for (let row = 0; row <= 1000; ++row) {
  const begin = process.cpuUsage();
  for (let i = 0; row && i < each; ++i) {
    if (p.gyroscopic)
      for (const [b, body] of Object.entries(bodies)) {
        const w = body.quaternion.inverse().vmult(body.angularVelocity);
        const torque = tensors[b].vmul(w).cross(w);
        body.torque.vadd(body.quaternion.vmult(torque), body.torque);
      }
    world.step(p.step);
  }
  const used = process.cpuUsage(begin);
  cpu += (used.user + used.system) / 1e6;
  let potential = 0, kinetic = 0;
  for (const [b, body] of Object.entries(bodies)) {
    const w = body.quaternion.inverse().vmult(body.angularVelocity);
    potential += body.mass * p.g * body.position.z;
    kinetic += (body.mass * body.velocity.lengthSquared() + w.dot(tensors[b].vmul(w))) / 2;
  }
  const ahead = along("B", vector(1, 0, 0)), left = along("B", AXLE), spin = bodies.B.angularVelocity;
  const axis = along("B", steer), other = along("H", AXLE);
  const columns = [
    Math.asin(left.z), spin.dot(ahead), bodies.R.velocity.dot(ahead), potential, kinetic,
    potential + kinetic, Math.atan2(left.cross(other).dot(axis), left.dot(other)),
    bodies.H.angularVelocity.vsub(spin).dot(axis),
  ];
  console.log(columns.join(" "));
}
console.error(cpu);

// The uncontrolled bicycle in Jolt: four bodies at their centres of mass, three hinges, two cylinders
// on a plane. Axes: x forward, y left, z up.
//
// Reads lines "name value" (parameters, speed, roll_rate, step, width of the wheels, gyroscopic,
// damping, velocity_steps, baumgarte, cache, recentre), writes the eight columns every 0.01 s, and the
// processor time of the simulation [s] as an error message. This package computes in binary32.

import initialise from "jolt-physics";
import { readFileSync } from "node:fs";

const given = readFileSync(0, "utf8").trim().split("\n").map((line) => line.split(" "));
const p = Object.fromEntries(given.map(([name, value]) => [name, Number(value)]));
const vector = (x, y, z) => ({ x, y, z });
const minus = (a, b) => vector(a.x - b.x, a.y - b.y, a.z - b.z);
const plus = (a, b) => vector(a.x + b.x, a.y + b.y, a.z + b.z);
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

const jolt = await initialise();
const read = (v) => vector(v.GetX(), v.GetY(), v.GetZ());
const attitude = (body) => {
  const q = body.GetRotation();
  return { x: q.GetX(), y: q.GetY(), z: q.GetZ(), w: q.GetW() };
};
const vec3 = ({ x, y, z }) => new jolt.Vec3(x, y, z);
const rvec3 = ({ x, y, z }) => new jolt.RVec3(x, y, z);

// The floor is in layer 0, the bicycle in 1; its bodies do not touch each other.
const settings = new jolt.JoltSettings();
const pairs = new jolt.ObjectLayerPairFilterTable(2);
pairs.EnableCollision(0, 1);
const layers = new jolt.BroadPhaseLayerInterfaceTable(2, 2);
for (const layer of [0, 1]) layers.MapObjectToBroadPhaseLayer(layer, new jolt.BroadPhaseLayer(layer));
settings.mObjectLayerPairFilter = pairs;
settings.mBroadPhaseLayerInterface = layers;
settings.mObjectVsBroadPhaseLayerFilter = new jolt.ObjectVsBroadPhaseLayerFilterTable(
  layers, 2, pairs, 2,
);
const world = new jolt.JoltInterface(settings), system = world.GetPhysicsSystem();
system.SetGravity(new jolt.Vec3(0, 0, -p.g));
const physics = system.GetPhysicsSettings();
physics.mAllowSleeping = false;
if (p.velocity_steps) physics.mNumVelocitySteps = p.velocity_steps;
if (p.baumgarte) physics.mBaumgarte = p.baumgarte;
if (p.cache !== undefined) physics.mUseBodyPairContactCache = Boolean(p.cache);
system.SetPhysicsSettings(physics);
const builder = system.GetBodyInterface(), upright = new jolt.Quat(0, 0, 0, 1);
const create = (shape, at, kind, layer, change) => {
  const said = new jolt.BodyCreationSettings(shape, rvec3(at), upright, kind, layer);
  said.mFriction = 1;
  change(said);
  const body = builder.CreateBody(said);
  builder.AddBody(body.GetID(), jolt.EActivation_Activate);
  return body;
};
const plane = new jolt.PlaneShape(new jolt.Plane(new jolt.Vec3(0, 0, 1), 0), null, 1000);
create(plane, vector(0, 0, 0), jolt.EMotionType_Static, 0, () => {});

const hubs = { R: vector(0, 0, p.rR), F: vector(p.w, 0, p.rF) };
const origins = { B: vector(p.xB, 0, -p.zB), H: vector(p.xH, 0, -p.zH), ...hubs };
const bodies = {}, tensors = {};
for (const [b, at] of Object.entries(origins)) {
  const xx = p[`I${b}xx`], zz = p[`I${b}zz`] ?? xx, xz = -(p[`I${b}xz`] ?? 0); // z up
  tensors[b] = { xx, yy: p[`I${b}yy`], zz, xz };
  const half = (p.width ?? 0.002) / 2;
  const shape = b in hubs
    ? new jolt.CylinderShape(half, p[`r${b}`], 0, null)
    : new jolt.EmptyShapeSettings().Create().Get();
  bodies[b] = create(shape, at, jolt.EMotionType_Dynamic, 1, (said) => {
    said.mOverrideMassProperties = jolt.EOverrideMassProperties_MassAndInertiaProvided;
    const mass = said.mMassPropertiesOverride, inertia = new jolt.Mat44();
    mass.mMass = p[`m${b}`];
    inertia.SetColumn4(0, new jolt.Vec4(xx, 0, xz, 0));
    inertia.SetColumn4(1, new jolt.Vec4(0, p[`I${b}yy`], 0, 0));
    inertia.SetColumn4(2, new jolt.Vec4(xz, 0, zz, 0));
    inertia.SetColumn4(3, new jolt.Vec4(0, 0, 0, 1));
    mass.mInertia = inertia;
    said.mApplyGyroscopicForce = Boolean(p.gyroscopic);
    if (p.damping !== undefined) said.mLinearDamping = said.mAngularDamping = p.damping;
    said.mAllowSleeping = false;
    // The whole bicycle turns about the line of the contact points.
    said.mLinearVelocity = new jolt.Vec3(p.speed, -p.roll_rate * at.z, 0);
    const spin = b in hubs ? p.speed / p[`r${b}`] : 0;
    said.mAngularVelocity = new jolt.Vec3(p.roll_rate, spin, 0);
  });
}
const hinge = (one, other, at, axis, normal) => {
  const said = new jolt.HingeConstraintSettings();
  said.mPoint1 = said.mPoint2 = rvec3(at);
  said.mHingeAxis1 = said.mHingeAxis2 = vec3(axis);
  said.mNormalAxis1 = said.mNormalAxis2 = vec3(normal);
  system.AddConstraint(said.Create(bodies[one], bodies[other]));
};
const steer = vector(Math.sin(p.lam), 0, -Math.cos(p.lam)), left = vector(0, 1, 0);
hinge("B", "R", hubs.R, left, vector(1, 0, 0));
hinge("B", "H", vector(p.w + p.c, 0, 0), steer, left);
hinge("H", "F", hubs.F, left, vector(1, 0, 0));

const each = Math.round(0.01 / p.step);
let cpu = 0;
for (let row = 0; row <= 1000; ++row) {
  if (p.recentre && row) { // far from the origin binary32 has few digits left
    const { x, y } = read(bodies.B.GetPosition());
    for (const body of Object.values(bodies)) {
      const at = rvec3(minus(read(body.GetPosition()), vector(x, y, 0)));
      builder.SetPosition(body.GetID(), at, jolt.EActivation_Activate);
      jolt.destroy(at);
    }
  }
  const begin = process.cpuUsage();
  for (let i = 0; row && i < each; ++i) world.Step(p.step, 1);
  const used = process.cpuUsage(begin);
  cpu += (used.user + used.system) / 1e6;
  let potential = 0, kinetic = 0;
  for (const [b, body] of Object.entries(bodies)) {
    const v = read(body.GetLinearVelocity()), I = tensors[b], m = p[`m${b}`];
    const w = turned(inverse(attitude(body)), read(body.GetAngularVelocity()));
    const turning = I.xx * w.x ** 2 + I.yy * w.y ** 2 + I.zz * w.z ** 2 + 2 * I.xz * w.x * w.z;
    potential += m * p.g * read(body.GetPosition()).z;
    kinetic += (m * dot(v, v) + turning) / 2;
  }
  const q = attitude(bodies.B), spin = read(bodies.B.GetAngularVelocity());
  const ahead = turned(q, vector(1, 0, 0)), beside = turned(q, left), axis = turned(q, steer);
  // About the steer axis from the rear frame's left to the fork's.
  const other = turned(attitude(bodies.H), left);
  const angle = Math.atan2(dot(cross(beside, other), axis), dot(beside, other));
  const rate = dot(minus(read(bodies.H.GetAngularVelocity()), spin), axis);
  const hub = plus(
    read(bodies.B.GetLinearVelocity()), cross(spin, turned(q, minus(hubs.R, origins.B))),
  );
  const columns = [
    Math.asin(beside.z), dot(spin, ahead), dot(hub, ahead), potential, kinetic,
    potential + kinetic, angle, rate,
  ];
  console.log(columns.join(" "));
}
console.error(cpu);

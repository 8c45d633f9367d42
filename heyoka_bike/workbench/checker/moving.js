/* Scenes of the replay: the exact motion, and next to it the motion of a file, derived as in `animate`.
   `kinematics` is generated from the model. Names and limits are those of scenes.py. */

const MOVING = data.replay.states.map((key) => keys.indexOf(key));
const STEPS = 2;  // integration steps per frame: positions of the exact motion are accurate to 1e-7 m
const COUNTED = ["rear_wheel", "front_wheel", "track"];

// Returns a motion in frames, up to the last one in which the bicycle stands on its wheels. `state` returns the
// columns of `MOVING` at a time. Positions are integrated by Simpson's rule in steps of each frame.
function followed(state, times, start) {
  const { fallen, smallestGap } = data.replay;
  const at = (t, near) => {
    const [roll, steer, rollRate, steerRate, speed] = state(t), pitch = pitchOnTheFloor(kinematics.floorGap, roll, steer, near, smallestGap);
    if (!(Math.abs(roll) < fallen && Math.abs(steer) < fallen && Number.isFinite(pitch))) return null;
    const f = new Array(6).fill(0);
    kinematics.rolling([roll, pitch, steer, rollRate, steerRate, speed], f);
    return f.every(Number.isFinite) ? { roll, pitch, steer, speed, turning: f[0], rates: [f[1], f[2], f[3]], ahead: f[4], aside: f[5] } : null;
  };
  const names = ["roll", "pitch", "steer", "speed", "yaw", "x", "y", "front_x", "front_y", ...COUNTED];
  const found = Object.fromEntries(names.map((name) => [name, []]));
  let { x, y, yaw } = start, counted = [0, 0, 0], here = at(times[0], 0);
  const step = (h, a, b, c) => {
    const simpson = (u, v, w) => (h / 6) * (u + 4 * v + w), way = [a, b, c].map((p) => p.rates[2]);
    const yaws = [yaw, yaw + (h / 24) * (5 * a.turning + 8 * b.turning - c.turning), yaw + simpson(a.turning, b.turning, c.turning)];
    x += simpson(...way.map((v, j) => v * Math.cos(yaws[j])));
    y += simpson(...way.map((v, j) => v * Math.sin(yaws[j])));
    counted = counted.map((v, j) => v + simpson(a.rates[j], b.rates[j], c.rates[j]));
    [, , yaw] = yaws;
  };
  for (let i = 0; here; i++) {
    const c = Math.cos(yaw), s = Math.sin(yaw);
    const now = { ...here, yaw, x, y, front_x: x + c * here.ahead - s * here.aside, front_y: y + s * here.ahead + c * here.aside };
    COUNTED.forEach((name, j) => { now[name] = counted[j]; });
    for (const name of names) found[name].push(now[name]);
    if (i + 1 >= times.length) break;
    const h = (times[i + 1] - times[i]) / STEPS;
    for (let k = 0; k < STEPS && here; k++) {
      const t = times[i] + k * h, middle = at(t + h / 2, here.pitch), next = middle && at(k + 1 < STEPS ? t + h : times[i + 1], middle.pitch);
      if (next) step(h, here, middle, next);
      here = next;
    }
  }
  return found;
}

function exactScenes() {
  return MANEUVERS.map((number) => {
    const duration = judge.end(number), count = Math.max(Math.round(duration * data.replay.rate), data.replay.leastFrames);
    const times = Array.from({ length: count + 1 }, (_, i) => (duration * i) / count);
    const columns = followed((t) => MOVING.map((k) => judge.exact(number, k, t)), times, { x: 0, y: 0, yaw: 0 });
    return { number, duration, times, columns, result: null };
  });
}

// Returns each scene with the result's motion and notes on its sources, or with a note why there is no motion.
const scenesBeside = (result, exactly) => exactly.map((scene) => {
  const found = besideOf(scene, result);
  return typeof found === "string" ? { scene, notes: [found] } : { scene: { ...scene, result: found.result }, notes: found.notes };
});

// Returns values interpolated linearly between rows, and constant before the first and after the last row.
function interpolated(times, values, t) {
  let low = 0, high = times.length - 1;
  if (t <= times[0]) return values[0];
  if (t >= times[high]) return values[high];
  while (high - low > 1) {
    const i = (low + high) >> 1;
    if (times[i] <= t) low = i; else high = i;
  }
  return values[low] + ((values[high] - values[low]) * (t - times[low])) / (times[high] - times[low]);
}

// Returns times and errors of the file's columns of the motion, up to the first row with a missing number.
function differencesOf(number, cells, { numbers, width, columns, rows }) {
  const t = [], errors = cells.map(() => []);
  for (let i = 0; i < rows.length; i++) {
    const time = numbers[i * width + columns.time];
    if (!Number.isFinite(judge.exact(number, 0, time))) continue;
    const found = cells.map((c) => c.sign * c.factor * value(numbers[i * width + c.at]) - c.offset - judge.exact(number, c.column, time));
    if (!found.every(Number.isFinite)) return { t, errors, isCut: true };
    t.push(time);
    found.forEach((x, j) => errors[j].push(x));
  }
  return { t, errors, isCut: false };
}

const listed = (items) => (items.length > 1 ? `${items.slice(0, -1).join(", ")} and ${items[items.length - 1]}` : items.join(""));

// Returns the resolution of roll, steer and speed in the file: half a unit in the last digit of the largest value
// [SI]; 0 if the file lacks the column.
function resolutionOf(given, { numbers, width, rows, written }) {
  const of = (key) => {
    const c = given[data.replay.states.indexOf(key)];
    if (!c) return 0;
    const largest = rows.reduce((most, _, i) => Math.max(most, Math.abs(value(numbers[i * width + c.at])) || 0), 0);
    return c.factor * halfDigit(largest, written[c.at]);
  };
  return { roll: of("roll_angle"), steer: of("steer_angle"), speed: of("forward_speed") };
}

function besideOf({ number, times, columns }, { cells, file }) {
  const { states, labels, outOfSight } = data.replay;
  const held = cells.filter((c) => c.maneuver === number);
  if (!held.length) return `The file does not contain maneuver ${number}.`;
  const given = MOVING.map((k) => held.find((c) => c.key === k && c.rows));
  const mine = given.filter(Boolean);
  if (!mine.length) return `The file has no usable column of the motion in maneuver ${number} (found none of ${listed(labels)}).`;
  const { t, errors, isCut } = differencesOf(number, mine, file);
  if (!t.length) return `The first row of maneuver ${number} in the file has no usable number.`;
  const last = t[t.length - 1], inside = times.filter((x) => x >= t[0] && x <= last * (1 + 1e-12)), first = times.indexOf(inside[0]);
  if (inside.length < 2) return `The rows of maneuver ${number} in the file span less than two frames.`;
  const error = given.map((c) => errors[mine.indexOf(c)]);
  const state = (time) => MOVING.map((k, j) => judge.exact(number, k, time) + (error[j] ? interpolated(t, error[j], time) : 0));
  const start = { x: columns.x[first], y: columns.y[first], yaw: columns.yaw[first] };
  const found = followed(state, inside, start), stood = found.x.length;
  const far = found.x.findIndex((x, i) => !(Math.hypot(x - columns.x[first + i], found.y[i] - columns.y[first + i]) < outOfSight));
  const count = far < 0 ? stood : far;
  if (count < 2) return `The bicycle of maneuver ${number} in the file does not stand on its wheels.`;
  const differences = {};
  for (const name in found) {
    if (name === "speed" && !given[states.indexOf("forward_speed")]) continue;
    // Wheel angles and tracks are counted from the first frame of each motion.
    const from = COUNTED.includes(name) ? columns[name][first] : 0;
    differences[name] = found[name].slice(0, count).map((x, i) => x - (columns[name][first + i] - from));
  }
  const until = inside[count - 1].toFixed(2);
  let end = "";
  if (count < stood) end = `The result is not shown after ${until} s: its bicycle has left the scene.`;
  else if (stood < inside.length) end = `The result is not shown after ${until} s: its bicycle has fallen.`;
  else if (first + inside.length < times.length) end = isCut ? `The result is not shown after ${until} s: the next row has no usable number.` : `The rows of the file end at ${Number(last.toPrecision(4))} s.`;
  return { result: { first, differences, resolution: resolutionOf(given, file) }, notes: notesOf(given, labels, inside[0], end) };
}

function notesOf(given, labels, start, end) {
  const of = (isGiven) => labels.filter((_, j) => Boolean(given[j]) === isGiven);
  const taken = given.flatMap((c, j) => {
    if (!c) return [];
    const how = [...(c.column === c.key ? [] : [c.definition]), ...(c.sign < 0 ? ["with the opposite sign"] : []), ...(c.unit === units[c.key] ? [] : [`in ${unitText(c.unit)}`])];
    return how.length ? [`${labels[j]} taken as ${how.join(", ")}`] : [];
  });
  const notes = [`From the file: ${listed(of(true))}${taken.length ? `; ${taken.join("; ")} ${data.replay.brought}` : ""}.`];
  if (of(false).length) notes.push(`The file has no usable ${listed(of(false))}: the values of the reference are used instead.`);
  if (start > 0) notes.push(`The rows of the file begin at ${Number(start.toPrecision(4))} s; the motion starts there at the position of the reference.`);
  notes.push(data.replay.derived);
  return end ? [...notes, end] : notes;
}

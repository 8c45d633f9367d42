// Integrates a motion by the formulas of Dormand and Prince (1980) of orders 5 and 4,
// doi:10.1016/0771-050X(80)90013-3. `rates`, `observe` and `floorGap` are generated from the model.
const FRAME = 0.02;       // time between two frames [s]
const TOLERANCE = 1e-10;  // error limit of a step, relative to 1 + abs(y) for each state variable y
const MOST_STEPS = 1e6;   // the motion ends after this many steps
const SHORTEST = 1e-9;    // smallest step [s]; only a singularity requires smaller ones
const SMALLEST_GAP = 1e-9; // largest gap below the front wheel for a valid pitch [m]
const FLAT = Math.PI / 2; // limit of roll and steer [rad]: the bicycle lies, or its handlebar is crosswise
const NODES = [
  [1 / 5],
  [3 / 40, 9 / 40],
  [44 / 45, -56 / 15, 32 / 9],
  [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
  [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
  [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
];
const DIFFERENCE = [71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40];

// Returns a motion in frames, or null if no posture has both wheels on the floor. `start` contains roll, steer,
// roll_rate, steer_rate [rad, rad/s], speed [m/s], and the bicycle's free parameters.
const follow = (start, duration) => {
  for (const name in P) P[name] = start[name];
  const size = STATE.length, made = () => new Float64Array(size);
  let y = made(), next = made();
  const k = Array.from({ length: 7 }, () => new Float64Array(size + DIVISORS)), seen = new Float64Array(OBSERVED.length);
  STATE.forEach((name, i) => { y[i] = start[name] || 0; });
  y[STATE.indexOf("pitch")] = pitchOnTheFloor(floorGap, start.roll, start.steer, 0, SMALLEST_GAP);
  spinOf([start.speed], seen);
  y[STATE.indexOf("spin")] = seen[0];
  const columns = Object.fromEntries([...STATE, ...OBSERVED].map((name) => [name, []]));
  const keep = () => {
    observe(y, seen);
    STATE.forEach((name, i) => columns[name].push(y[i]));
    OBSERVED.forEach((name, i) => columns[name].push(seen[i]));
  };
  // Computes a step and returns its error relative to the limit.
  const tried = (h) => {
    NODES.forEach((weights, stage) => {
      for (let i = 0; i < size; i++) {
        let sum = 0;
        for (let j = 0; j < weights.length; j++) sum += weights[j] * k[j][i];
        next[i] = y[i] + h * sum;
      }
      rates(next, k[stage + 1]);
    });
    let worst = 0;
    for (let i = 0; i < size; i++) {
      let sum = 0;
      for (let j = 0; j < 7; j++) sum += DIFFERENCE[j] * k[j][i];
      const error = Math.abs(h * sum) / (TOLERANCE * (1 + Math.abs(y[i])));
      worst = Math.max(worst, Number.isFinite(error) ? error : 1e9);
    }
    return worst;
  };
  const isUp = () => Math.abs(y[0]) < FLAT && Math.abs(y[2]) < FLAT;
  // True if a divisor of the equations has changed sign during a step.
  const isAcross = () => k[0].subarray(size).some((x, i) => x * k[6][size + i] <= 0);
  let h = 1e-3, steps = 0;
  const toFrame = () => {
    for (let t = 0; t < FRAME; steps++) {
      const step = Math.min(h, FRAME - t), error = tried(step);
      if (error <= 1) {
        [y, next] = [next, y];
        [k[0], k[6]] = [k[6], k[0]];  // the last slope is the first of the next step
        t = step < h ? FRAME : t + step;
        if (!isUp() || isAcross()) return false;
      }
      const factor = Math.min(5, Math.max(0.2, 0.9 * (error + 1e-12) ** -0.2));
      if (error > 1 || step === h) h = step * factor;
      if (!(h > SHORTEST)) return false;
    }
    return true;
  };
  rates(y, k[0]);
  if (!isUp() || !k[0].every(Number.isFinite)) return null;
  keep();
  const frames = Math.round(duration / FRAME);
  let stands = true;
  for (let i = 0; i < frames && stands && steps < MOST_STEPS; i++) {
    stands = toFrame();
    if (stands) keep();
  }
  return { columns, duration: (columns.roll.length - 1) * FRAME, falls: !stands };
};

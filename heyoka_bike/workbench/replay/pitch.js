// Returns the pitch with both wheels on the floor, by Newton's method from the guess `near`; NaN if the gap below
// the front wheel [m] remains above `smallest`. `floorGap` is generated from the model.
const pitchOnTheFloor = (floorGap, roll, steer, near, smallest) => {
  const found = [0], shift = 1e-6;
  const gap = (pitch) => { floorGap([roll, pitch, steer], found); return found[0]; };
  let pitch = near;
  for (let i = 0; i < 8; i++) {
    const here = gap(pitch);
    pitch -= here * shift / (gap(pitch + shift) - here || 1);
  }
  return Math.abs(gap(pitch)) < smallest ? pitch : NaN;
};

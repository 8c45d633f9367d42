/* Recognises the maneuver of rows that do not name it, with the method of heyoka-bike score: scoring/recognition.py gives
   the reasons. `data.recognition` contains the limits of that module. */

const RULES = data.recognition;

class NoManeuver extends Unreadable {}

// Returns the nearest maneuver, and its rivals: the others that cannot be excluded, the nearest first.
function recognised(file) {
  const near = new Map(MANEUVERS.map((n) => [n, nearness(file, n)]).filter(([, columns]) => columns.size));
  const apart = (n) => Math.exp(mean([...near.get(n).values()].flatMap((c) => c.spans)));
  const far = new Map([...near].map(([n, columns]) => [n, [...columns.values()].reduce((s, c) => s + c.cost, 0)]));
  // Without rows to compare, any maneuver will do: the caller then reports that no row is within the run.
  if (!near.size) return { maneuver: MANEUVERS[0], rivals: [] };
  const [maneuver, ...others] = [...near.keys()].sort((a, b) => far.get(a) - far.get(b));
  if (apart(maneuver) >= RULES.farthest) {
    const distances = [...near.keys()].map((n) => `${apart(n).toPrecision(2)} from maneuver ${n}`).join(", ");
    throw new NoManeuver(`${file.name}: found columns unlike every maneuver (they typically differ by ${distances}, relative to the largest values), expected those of one: choose the maneuver below`);
  }
  return { maneuver, rivals: others.filter((n) => !isExcluded(near.get(maneuver), near.get(n), maneuver, n)) };
}

const mean = (x) => x.reduce((a, b) => a + b, 0) / x.length;
const median = (x) => {
  const sorted = [...x].sort((a, b) => a - b);
  return (sorted[(sorted.length - 1) >> 1] + sorted[sorted.length >> 1]) / 2;
};

// True if rows near one maneuver cannot be rows of the other maneuver.
function isExcluded(near, far, maneuver, other) {
  const { exact, far: distant, clearly, near: close } = RULES, both = [...near.keys()].filter((k) => far.has(k));
  const starts = both.filter((k) => startsApart(k, maneuver, other)).map((k) => [near.get(k).atStart, far.get(k).atStart]).filter(([a, b]) => a !== null && b !== null);
  const runs = both.filter((k) => RULES.varies[maneuver - 1][k]).map((k) => [near.get(k).largest, far.get(k).largest]);
  const shows = starts.some(([a, b]) => clearly * a <= b && (a <= exact || b >= distant)) || runs.some(([a, b]) => a <= close && b >= clearly * close);
  const contradicts = starts.some(([a, b]) => clearly * b <= a) || runs.some(([a, b]) => b <= close && a >= clearly * close);
  return shows && !contradicts;
}

// True if the initial conditions of two maneuvers differ in a column, or in its rate.
function startsApart(key, one, other) {
  return [key, RULES.rates[key]].some((k) => k !== null && Math.abs(judge.exact(one, k, 0) - judge.exact(other, k, 0)) > RULES.exact * Math.max(judge.scale(one, k), judge.scale(other, k)));
}

// Nearness of each column to a maneuver, by the key of the column; empty if fewer than half of the rows are within the run.
function nearness(file, maneuver) {
  const { numbers, width, columns, rows } = file, found = new Map();
  const time = (i) => numbers[i * width + columns.time];
  const within = rows.map((_, i) => i).filter((i) => Number.isFinite(judge.exact(maneuver, 0, time(i))));
  if (2 * within.length < rows.length) return found;
  const spans = spansOf(within, time);
  for (const c of columns.of) {
    const scale = judge.scale(maneuver, c.key), middle = RULES.middles[maneuver - 1][c.key];
    const read = spans.map((span) => span.map((i) => {
      const x = numbers[i * width + c.at], size = Math.abs(x);
      return { t: time(i), x: size > MOST_VALUE ? NaN : size < 1 / MOST_VALUE ? 0 : x, y: judge.exact(maneuver, c.key, time(i)), half: halfDigit(x, file.written[c.at]) };
    }).filter((row) => Number.isFinite(row.x) && Number.isFinite(row.y)));
    const all = read.flat(), [first] = all;
    if (!first) continue;
    let start = all.filter((row) => row.t <= RULES.fastest);
    // An angle that starts at zero shows its rate in the next rows.
    const isAngle = RULES.rates[c.key] !== null && Math.abs(judge.exact(maneuver, c.key, 0)) <= RULES.roundoff * scale;
    start = isAngle ? start.filter((row) => row.t > 0) : start.slice(0, 1);
    const ways = waysOf(c).map((way) => compare(read, start, first, way, middle, scale));
    found.set(c.key, ways.reduce((a, b) => (b.cost < a.cost ? b : a)));
  }
  return found;
}

// Half a unit in the last written digit of a number.
function halfDigit(x, { digits, places }) {
  if (places >= 0) return 10 ** -places / 2;
  return x && Number.isFinite(x) ? 10 ** (Math.floor(Math.log10(Math.abs(x))) + 1 - (digits || 17)) / 2 : 0;
}

// Indices of rows in each time span: first the rows at the start, then spans that double in length. Long spans are thinned.
function spansOf(rows, time) {
  const spans = new Map();
  for (const i of rows) {
    const t = time(i), which = t > 0 ? Math.ceil(Math.log2(t)) : -Infinity;
    if (!spans.has(which)) spans.set(which, []);
    spans.get(which).push(i);
  }
  return [...spans.values()].map((span) => {
    const few = Math.min(span.length, RULES.mostRows), step = (span.length - 1) / Math.max(few - 1, 1);
    return Array.from({ length: few }, (_, i) => span[i + 1 < few ? Math.floor(i * step) : Math.floor((few - 1) * step + 0.5)]);
  });
}

// Possible units, signs and zeros of a column; the cost is the logarithm of the odds against each combination.
function waysOf({ key, unit }) {
  const written = unit || units[key], isEnergy = units[key] === "J";
  return Object.entries(RULES.factors[key]).flatMap(([name, factor]) => (isEnergy ? [1] : [1, -1]).flatMap((sign) =>
    (RULES.zeroed.includes(key) ? [false, true] : [false]).map((isMoved) => ({ times: sign * factor, isMoved, cost: RULES.logOdds * ((name !== written) + (sign < 0) + isMoved) }))));
}

function compare(read, start, first, { times, isMoved, cost }, middle, scale) {
  const [x0, y0] = isMoved ? [times * first.x, first.y] : [middle, middle];
  const difference = (row) => {
    const x = times * row.x - x0, y = row.y - y0, floor = Math.abs(times) * row.half + RULES.roundoff * scale + Number.MIN_VALUE;
    const apart = Math.abs(x - y) + floor;
    return { apart, beyond: Math.max(apart - 2 * floor, 0), size: Math.abs(x) + Math.abs(y) + floor };
  };
  // Medians, because a few rows may contain arbitrary values.
  const typical = (rows) => {
    const found = rows.map(difference), size = median(found.map((d) => d.size));
    return { apart: median(found.map((d) => d.apart)) / size, beyond: median(found.map((d) => d.beyond)) / size };
  };
  const all = read.map((rows) => (rows.length ? typical(rows) : { apart: 1, beyond: 0 }));
  const spans = all.map((d) => Math.log(d.apart));
  return { spans, largest: Math.max(...all.map((d) => d.beyond)), atStart: start.length ? typical(start).apart : null, cost: cost + spans.reduce((a, b) => a + b, 0) };
}

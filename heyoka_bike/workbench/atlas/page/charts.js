// Charts of a motion over time, as on the pages of motions, with functions that the map uses, too.
// Returns at most about `most` round numbers between `low` and `high`, and the decimal places that they need.
const nice = (low, high, most) => {
  const raw = (high - low) / most, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw);
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(i * step);
  return { found, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
};
const minus = (text) => text.replace("-", "−");
const made = (tag, parent, text = "", name = "") => {
  const x = document.createElement(tag);
  x.textContent = text;
  if (name) x.className = name;
  return parent.appendChild(x);
};
const capital = (text) => text[0].toUpperCase() + text.slice(1);

const CHARTS = [
  ["roll", "rad", [["roll", "mine", "roll"]]], ["steer", "rad", [["steer", "mine", "steer"]]],
  ["forward speed", "m/s", [["speed", "mine", "forward speed"]]],
  ["normal forces", "N", [["rear_normal", "s1", "rear"], ["front_normal", "s3", "front"]]],
];
// Returns the range of an axis. It excludes the last instants of a fall, which would flatten the rest.
const ends = (motion, lines) => {
  const count = motion.columns.roll.length, kept = motion.falls ? Math.max(count - 15, count >> 1) : count;
  const values = lines.flatMap(([name]) => motion.columns[name].slice(0, kept));
  const low = values.reduce((a, b) => Math.min(a, b)), high = values.reduce((a, b) => Math.max(a, b));
  const room = 0.06 * (high - low) || 0.5;
  return [low - room, high + room];
};
// Draws the charts into `plots`, replacing its content.
const drawCharts = (plots, motion) => {
  const HEIGHT = 84, SVG = "http://www.w3.org/2000/svg";
  plots.textContent = "";
  const group = made("div", plots, "", "group current");
  group.dataset.maneuver = "1";
  const node = (parent, tag, attributes, text = "") => {
    const x = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) x.setAttribute(name, value);
    x.textContent = text;
    return parent.appendChild(x);
  };
  for (const [title, unit, lines] of CHARTS) {
    const figure = made("figure", group), plot = made("div", figure, "", "plot");
    const [low, high] = ends(motion, lines);
    const svg = node(plot, "svg", { role: "img", "aria-label": `${capital(title)} over time`, width: "100%", height: HEIGHT });
    const grid = node(svg, "g", { class: "grid" });
    const time = nice(0, motion.duration, 5), y = nice(low, high, 4);
    const across = (t) => `${100 * t / motion.duration}%`, down = (v) => HEIGHT * (high - v) / (high - low);
    for (const t of time.found) node(grid, "line", { x1: across(t), x2: across(t), y1: 0, y2: HEIGHT });
    for (const v of y.found) node(grid, "line", { x1: 0, x2: "100%", y1: down(v), y2: down(v) });
    node(svg, "path", { class: "frame", d: `M0 0V${HEIGHT}` });
    node(svg, "line", { class: "frame", x1: 0, x2: "100%", y1: HEIGHT, y2: HEIGHT });
    for (const t of time.found) node(svg, "text", { x: across(t), y: HEIGHT + 16, "text-anchor": "middle" }, t.toFixed(time.digits));
    for (const v of y.found) node(svg, "text", { x: -7, y: down(v) + 4, "text-anchor": "end" }, minus(v.toFixed(y.digits)));
    node(svg, "text", { class: "title", x: 0, y: -13 }, `${title} [${unit}]`);
    const inner = node(svg, "svg", { class: "lines", width: "100%", height: HEIGHT, viewBox: "0 0 4000 2000", preserveAspectRatio: "none" });
    for (const [name, look] of lines) {
      const list = motion.columns[name], last = list.length - 1, every = Math.ceil(last / 4000);
      const kept = list.map((v, i) => [i, v]).filter(([i]) => i % every === 0 || i === last);
      const d = kept.map(([i, v]) => `${(4000 * i / last).toFixed(0)} ${(2000 * (high - v) / (high - low)).toFixed(0)}`).join("L");
      node(inner, "path", { class: look, d: `M${d}` });
    }
    if (lines.length < 2) continue;
    const list = made("ul", figure, "", "legend");
    for (const [, look, name] of lines) {
      const item = made("li", list), swatch = node(item, "svg", { class: "key", width: 26, height: 8 });
      node(swatch, "path", { class: look, d: "M0 4h26" });
      item.append(` ${name}`);
    }
  }
};

"use strict";

const data = JSON.parse(document.getElementById("data").textContent);
const { keys, units, words, signs, styles, meanings, phrases } = data;
const GIVEN = { log: Math.log, log10: Math.log10, sin: Math.sin, cos: Math.cos, atan2: Math.atan2, pow: Math.pow };
const bytes = Uint8Array.from(atob(data.wasm), (c) => c.charCodeAt(0));
const judge = new WebAssembly.Instance(new WebAssembly.Module(bytes), { env: GIVEN }).exports;
const MANEUVERS = Array.from({ length: judge.maneuvers() }, (_, i) => i + 1);
// In the order of `number` of checker.c.
const MEASURES = ["rows", "digits", "mescd", "max_error", "time_of_max", "rms_error", "column", "sign", "factor", "offset", "grade", "never_filled"];
const EXPECTED = "expected 9 or 25";
const NAMED = /^(?:m(?:aneuver)?[ _]?(\d)[ _.])?(\w+?)\s*(?:[[(].*)?$/i;
const MOST_IN_LINK = 8000;
const POINTS = 700;

const at = (id) => document.getElementById(id);

function make(tag, attributes = {}, ...children) {
  const found = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) found.setAttribute(name, value);
  found.append(...children);
  return found;
}

function svg(tag, attributes = {}, ...children) {
  const found = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) found.setAttribute(name, value);
  found.append(...children);
  return found;
}

function string(address) {
  const memory = new Uint8Array(judge.memory.buffer);
  return new TextDecoder().decode(memory.subarray(address, memory.indexOf(0, address)));
}

/* ---- Reading ---- */

const cells = (line) => line.trim().replace(/[,;]\s*$/, "").split(/\s*[,;\t]\s*|\s+/);
const isNumber = (text) => /^[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?$|^[+-]?(nan|inf(inity)?)$/i.test(text);
const number = (text) => (/n/i.test(text) ? NaN : Number(text.replace(/d/i, "e")));

class Unreadable extends Error {}

// The rows of numbers of a text, or an `Unreadable` with the line that heyoka-bike score gives.
function read(text, name) {
  const stop = (where, said) => { throw new Unreadable(`${name}${where}: ${said}`); };
  if (text.includes("\0")) stop("", "found a file that is no text, expected rows of numbers");
  if (!text.trim()) stop("", "found an empty file, expected rows of numbers");
  let heading = null, width = 0;
  const lines = [], numbers = [], rows = [];
  for (const [i, line] of text.split(/\r\n|\n|\r/).entries()) {
    const plain = line.replace(/[#%!].*$|\/\/.*$/, "");
    if (!plain.trim()) { if (!rows.length && line.trim()) heading = cells(line.replace(/^\s*[#%!/]+/, "")); continue; }
    const found = cells(plain);
    if (!found.every(isNumber)) {
      if (rows.length || found.some(isNumber)) stop(`:${i + 1}`, `found ${JSON.stringify(found.find((x) => !isNumber(x)))}, expected a number`);
      heading = /[,;\t]/.test(plain) ? plain.split(/[,;\t]/).map((x) => x.trim()) : found;
      continue;
    }
    width = width || found.length;
    if (found.length !== width) stop(`:${i + 1}:${Math.min(found.length, width) + 1}`, `found ${found.length} values, expected ${width}`);
    lines.push(i);
    rows.push(found);
    for (const x of found) numbers.push(number(x));
  }
  if (!rows.length) stop("", `found no row of numbers, ${EXPECTED} columns of numbers`);
  const columns = named(heading, width) || placed(width);
  if (!columns) stop(`:${lines[0] + 1}`, `found ${width} columns, ${EXPECTED}, or a line of column names such as time, roll_angle, roll_rate`);
  return { name, rows, width, numbers: Float64Array.from(numbers), columns, isNamed: !!named(heading, width), heading };
}

// By their headings: the column of the time, and maneuver (0: not said) and key of each other one.
function named(heading, width) {
  if (!heading || heading.length !== width) return null;
  const found = heading.map((x) => {
    const [, maneuver, key] = x.replace(/["']/g, "").match(NAMED) || [];
    const place = keys.indexOf((key || "").toLowerCase());
    return { maneuver: Number(maneuver || 0), key: place, isTime: /^(t|time)$/i.test(key || "") };
  });
  const time = found.findIndex((x) => x.isTime);
  if (time < 0 || found.some((x, i) => i !== time && x.key < 0)) return null;
  const pairs = new Set(found.map((x) => `${x.maneuver} ${x.key}`));
  return pairs.size < width ? null : { time, of: found.map((x, i) => ({ ...x, at: i })).filter((x) => !x.isTime) };
}

function placed(width) {
  if (width !== 9 && width !== 1 + 8 * MANEUVERS.length) return null;
  const of = Array.from({ length: width - 1 }, (_, i) => ({ maneuver: width === 9 ? 0 : 1 + Math.floor(i / 8), key: i % 8, at: i + 1 }));
  return { time: 0, of };
}

// How finely a column is written: significant digits, and places after the point if all have as many.
function written(file, column) {
  let digits = 0, fewest = Infinity, most = -1, largest = 0;
  for (const row of file.rows) {
    const [mantissa, exponent] = row[column].toLowerCase().split(/[ed]/);
    if (/n/.test(mantissa)) continue;
    const places = exponent === undefined ? (mantissa.split(".")[1] || "").length : -1;
    digits = Math.max(digits, mantissa.replace(/^[-+0.]+/, "").replace(".", "").length);
    fewest = Math.min(fewest, places);
    most = Math.max(most, places);
    largest = Math.max(largest, Math.abs(number(row[column])));
  }
  const isFixed = fewest === most && most >= 0 && 10 ** -most >= largest * 2 ** -52;
  const isConstant = new Set(file.rows.map((row) => number(row[column]))).size < 2;
  return { digits: digits < 17 ? digits : 0, places: isFixed ? most : -1, count: digits, isConstant };
}

// A constant does not tell its digits: it has those of the most finely written column.
function evened(columns, time) {
  const finest = columns.filter((c, i) => i !== time && !c.isConstant).sort((a, b) => b.count - a.count)[0];
  return columns.map((c) => c.isConstant && finest ? finest : c);
}

/* ---- Judging ---- */

function judged(file, maneuver) {
  const { rows, width, numbers, columns } = file;
  const room = judge.room(numbers.length);
  new Float64Array(judge.memory.buffer, room, numbers.length).set(numbers);
  judge.begin();
  for (const c of columns.of)
    judge.give(c.maneuver || maneuver, c.key, rows.length, room + 8 * columns.time, room + 8 * c.at, width, file.written[c.at].digits, file.written[c.at].places);
  const grade = judge.judge();
  const found = [];
  for (const c of columns.of) {
    const m = c.maneuver || maneuver, cell = { maneuver: m, key: c.key, at: c.at };
    MEASURES.forEach((name, i) => { cell[name] = judge.number(m, c.key, i); });
    cell.also = [];
    for (let i = 0; i < judge.count_columns(); i++) if (judge.fits(m, c.key, i)) cell.also.push(string(judge.definition(i)));
    cell.definition = string(judge.definition(cell.column));
    cell.unit = cell.rows ? string(judge.unit(m, c.key)) : "";
    if (cell.rows || cell.never_filled) found.push(cell);
  }
  const isRight = judge.is_right();
  return { name: file.name, line: string(judge.line()), style: grade === 1 && !isRight ? "close" : styles[grade], cells: found, rows: rows.length };
}

// The maneuver of a file of one: that whose columns have the most digits.
function recognised(file) {
  const told = (n) => judged(file, n).cells.reduce((sum, c) => sum + c.digits, 0);
  return MANEUVERS.map((n) => [told(n), n]).sort((a, b) => b[0] - a[0])[0][1];
}

let shown = null;

function judgeText(text, name, chosen = 0) {
  at("problem").textContent = "";
  at("result").hidden = true;
  try {
    const file = read(text, name);
    file.text = text;
    file.written = evened(Array.from({ length: file.width }, (_, i) => written(file, i)), file.columns.time);
    const isOne = file.columns.of.some((c) => !c.maneuver);
    const maneuver = isOne ? chosen || recognised(file) : 0;
    at("which").hidden = !isOne;
    at("maneuver").value = String(maneuver);
    const result = judged(file, maneuver);
    const remarks = [`${result.rows} rows`];
    if (isOne) remarks.push(`maneuver ${maneuver}, ${chosen ? "as told" : "recognised by its values"}`);
    if (file.heading && file.heading.length === file.width && !file.isNamed) remarks.push("its headings are not read here: columns are taken in the benchmark's order");
    if (!result.cells.length) throw new Unreadable(`${name}: found no row within the run, expected times of 0 to ${judge.end(1)} s`);
    show({ ...result, remarks, file });
  } catch (problem) {
    if (!(problem instanceof Unreadable)) throw problem;
    at("problem").textContent = `${problem.message}. More formats, and why a result differs: heyoka-bike score ${name}`;
  }
}

/* ---- Showing ---- */

const oneDecimal = (x) => (x < 0 && x > -0.05 ? 0 : x).toFixed(1);
const unitText = (unit) => unit.replace(" s-1", "/s").replace(" h-1", "/h");
const label = (cell) => `${phrases.maneuver} ${cell.maneuver} ${keys[cell.key]}`;

function takenAs(c) {
  if (!c.rows) return "never filled in: one number in every row";
  const said = [c.definition + (c.column === c.key ? "" : ", not the default")];
  if (c.also.length) said.push(`may also be ${c.also.join(" or ")}`);
  if (c.sign < 0) said.push("sign -1");
  if (c.unit !== units[c.key]) said.push(unitText(c.unit));
  if (c.offset) said.push(`offset ${Number(c.offset.toPrecision(9))} J`);
  return said.join(", ");
}

function show(result) {
  shown = result;
  at("verdict").textContent = result.line;
  at("verdict").className = `verdict ${result.style}`;
  at("facts").textContent = `${result.name}: ${result.remarks.join("; ")}`;
  const present = MANEUVERS.filter((n) => result.cells.some((c) => c.maneuver === n));
  const head = make("tr", {}, make("th", { scope: "col" }, phrases.correct_digits), ...present.map((n) => make("th", { scope: "col" }, `${phrases.maneuver} ${n}`)), make("th", { scope: "col", class: "taken" }, "taken as"));
  const body = make("tbody");
  for (const [k, key] of keys.entries()) {
    const mine = result.cells.filter((c) => c.key === k);
    if (!mine.length) continue;
    const row = make("tr", {}, make("th", { scope: "row" }, key));
    for (const n of present) {
      const c = mine.find((x) => x.maneuver === n);
      if (!c || !c.rows) { row.append(make("td", { class: "unknown" }, "-")); continue; }
      const button = make("button", { type: "button", "aria-pressed": "false", "aria-label": `${label(c)}: ${oneDecimal(c.digits)} digits, ${words[c.grade]}` }, make("b", { "aria-hidden": "true" }, signs[c.grade]), ` ${oneDecimal(c.digits)}`);
      button.addEventListener("click", () => detail(c, button));
      row.append(make("td", { class: styles[c.grade] }, button));
    }
    row.append(make("td", { class: "taken" }, takenAs(mine.find((c) => c.rows) || mine[0])));
    body.append(row);
  }
  at("matrix").replaceChildren(make("thead", {}, head), body);
  const grades = [...new Set(result.cells.map((c) => c.grade))].filter((g) => words[g]).sort();
  at("signs").replaceChildren(...grades.map((g) => make("li", {}, make("b", { class: styles[g] }, signs[g]), ` ${meanings[g]}`)));
  at("more").replaceChildren("This page counts up to 14 digits, and looks for no cause. The whole report, and why a result differs: ", make("code", {}, `heyoka-bike score ${result.name}`), ", ", make("code", {}, `heyoka-bike diagnose ${result.name}`), ".");
  at("copied").textContent = "";
  at("result").hidden = false;
  const worst = result.cells.filter((c) => c.rows).sort((a, b) => a.digits - b.digits)[0];
  if (worst) {
    const buttons = [...at("matrix").querySelectorAll("button")];
    detail(worst, buttons.find((b) => b.getAttribute("aria-label").startsWith(`${label(worst)}:`)));
  }
  prepareReplay();
}

// Times, values in SI units as they are taken, and errors of a column.
function series(c) {
  if (!shown.file) return null;
  const { numbers, width, columns, rows } = shown.file;
  const found = { t: [], value: [], exact: [], error: [], row: [] };
  for (let i = 0; i < rows.length; i++) {
    const t = numbers[i * width + columns.time], x = c.sign * c.factor * numbers[i * width + c.at] - c.offset;
    const exact = judge.exact(c.maneuver, c.column, t);
    if (!Number.isFinite(x - exact)) continue;
    found.t.push(t); found.value.push(x); found.exact.push(exact); found.error.push(Math.abs(x - exact)); found.row.push(i);
  }
  return found;
}

function detail(c, button) {
  for (const other of at("matrix").querySelectorAll("button")) other.setAttribute("aria-pressed", String(other === button));
  const unit = unitText(units[c.key]), end = judge.end(c.maneuver), scale = judge.scale(c.maneuver, c.column);
  at("what").textContent = label(c);
  at("taken").textContent = `${takenAs(c)}; off by at most ${c.max_error.toPrecision(3)} ${unit}, at ${Number(c.time_of_max.toPrecision(6))} s`;
  const exact = Array.from({ length: POINTS + 1 }, (_, i) => (end * i) / POINTS);
  const lines = [{ style: "exact", t: exact, y: exact.map((t) => judge.exact(c.maneuver, c.column, t)) }];
  const mine = series(c);
  const least = scale * 1e-15;
  let errors = { t: [], y: [] };
  if (mine) {
    const every = Math.max(1, Math.floor(mine.t.length / POINTS));
    const pick = (x) => x.filter((_, i) => i % every === 0);
    lines.push({ style: "yours", t: pick(mine.t), y: pick(mine.value) });
    errors = largest(mine, POINTS);
  } else if (c.errors) errors = { t: c.errors.map((_, i) => (end * (i + 0.5)) / c.errors.length), y: c.errors.map((x) => (x === null ? NaN : 10 ** (x / 10))) };
  at("values").textContent = `[${unit}] over time [s]${mine ? "; exact grey, yours blue" : ""}`;
  at("errors").textContent = `[${unit}] over time [s], by powers of ten`;
  const texts = [`Exact curve${mine ? " and yours" : ""} of ${label(c)}`, `Error of ${label(c)}`];
  at("curve").replaceChildren(chart(lines, end, texts[0]));
  at("error").replaceChildren(chart([{ style: "off", t: errors.t, y: errors.y.map((x) => Math.log10(Math.max(x, least))) }], end, texts[1], true));
  at("rows").hidden = !mine;
  if (mine) worstRows(c, mine);
}

// The largest error in each of so many parts of the run.
function largest(mine, parts) {
  const end = mine.t[mine.t.length - 1] || 1, found = new Map();
  mine.t.forEach((t, i) => {
    const part = Math.min(parts - 1, Math.floor((parts * t) / end));
    if (!found.has(part) || found.get(part)[1] < mine.error[i]) found.set(part, [t, mine.error[i]]);
  });
  const pairs = [...found.values()].sort((a, b) => a[0] - b[0]);
  return { t: pairs.map((p) => p[0]), y: pairs.map((p) => p[1]) };
}

function chart(lines, end, title, isPower = false) {
  const width = 600, height = 220, left = 62, bottom = 26, top = 8;
  const finite = lines.flatMap((l) => l.y).filter(Number.isFinite);
  let low = Math.min(...finite), high = Math.max(...finite);
  if (isPower) { low = Math.floor(low); high = Math.max(Math.ceil(high), low + 1); }
  const size = Math.max(Math.abs(low), Math.abs(high));
  // What varies by roundoff alone is a straight line.
  if (!(high - low > 1e-6 * size)) { low -= 1e-6 * size || 1; high += 1e-6 * size || 1; }
  const raw = (high - low) / 4, power = 10 ** Math.floor(Math.log10(raw));
  const step = isPower ? Math.ceil(raw) : power * [1, 2, 5, 10].find((s) => s * power >= raw);
  if (!isPower) { low = step * Math.floor(low / step); high = step * Math.ceil(high / step); }
  const x = (t) => left + ((width - left - 8) * t) / end;
  const y = (v) => top + ((height - top - bottom) * (high - v)) / (high - low);
  const found = svg("svg", { class: "curve", viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": title });
  for (let v = low; v <= high + step / 1000; v += step) {
    const text = isPower ? `1e${v}` : String(Number((step * Math.round(v / step)).toPrecision(8)));
    found.append(svg("line", { x1: left, x2: width - 8, y1: y(v), y2: y(v) }), svg("text", { x: left - 6, y: y(v) + 4, "text-anchor": "end" }, text));
  }
  for (let t = 0; t <= end; t += end / 5) found.append(svg("text", { x: x(t), y: height - 6, "text-anchor": "middle" }, String(Number(t.toPrecision(3)))));
  for (const l of lines) {
    let d = "", pen = "M";
    l.t.forEach((t, i) => {
      if (!Number.isFinite(l.y[i])) { pen = "M"; return; }
      d += `${pen}${x(t).toFixed(1)} ${y(Math.max(low, Math.min(high, l.y[i]))).toFixed(1)}`;
      pen = "L";
    });
    found.append(svg("path", { class: l.style, d }));
  }
  return found;
}

// A number as a text of yours is written.
function alike(x, text) {
  const [mantissa, exponent] = text.toLowerCase().split(/[ed]/);
  const digits = mantissa.replace(/^[-+0.]+/, "").replace(".", "").length;
  if (exponent !== undefined) return x.toExponential(Math.min(16, Math.max(0, (mantissa.split(".")[1] || "").length)));
  const places = (mantissa.split(".")[1] || "").length;
  return digits > 17 ? x.toPrecision(17) : x.toFixed(Math.min(100, places));
}

// Two numbers, with what differs marked from the first digit on that does.
function compared(text, exact) {
  const parts = (x) => [x.split(/[.e]/i)[0].length, Number(x.split(/e/i)[1] || 0)].join();
  let i = 0;
  if (parts(text) === parts(exact)) while (i < text.length && text[i] === exact[i]) i++;
  const marked = (x) => make("td", {}, x.slice(0, i), ...(i < x.length ? [make("mark", {}, x.slice(i))] : []));
  return [marked(text), marked(exact)];
}

function worstRows(c, mine) {
  const order = mine.error.map((_, i) => i).sort((a, b) => mine.error[b] - mine.error[a]).slice(0, 10);
  const head = make("tr", {}, ...["time [s]", `yours [${unitText(c.unit)}]`, "exact", `error [${unitText(units[c.key])}]`].map((x) => make("th", { scope: "col" }, x)));
  const body = order.map((i) => {
    const row = shown.file.rows[mine.row[i]], text = row[c.at].replace(/^\+/, "");
    const exact = ((mine.exact[i] + c.offset) * c.sign) / c.factor;
    return make("tr", {}, make("td", {}, row[shown.file.columns.time]), ...compared(text, alike(exact, text)), make("td", {}, mine.error[i].toExponential(1)));
  });
  at("worst").replaceChildren(make("thead", {}, head), make("tbody", {}, ...body));
}

/* ---- Replay ---- */

let playing = 0;

// Roll and steer of a result over time, of the first maneuver that has both.
function prepareReplay() {
  const find = (m, key) => shown.cells.find((c) => c.maneuver === m && keys[c.key] === key && c.rows);
  const m = MANEUVERS.find((n) => find(n, "roll_angle") && find(n, "steer_angle"));
  at("replay").hidden = !m || !shown.file;
  stop();
  if (at("replay").hidden) return;
  shown.motion = { m, roll: find(m, "roll_angle"), steer: find(m, "steer_angle") };
  shown.motion.series = { roll: series(shown.motion.roll), steer: series(shown.motion.steer) };
  draw();
}

function valueAt(mine, t) {
  let i = mine.t.findIndex((x) => x >= t);
  if (i < 0) i = mine.t.length - 1;
  return mine.value[i];
}

function draw() {
  const { m, roll, steer, series: mine } = shown.motion, times = Number(at("times").value);
  const t = (judge.end(m) * Number(at("moment").value)) / 1000;
  at("clock").textContent = `${t.toFixed(2)} s, maneuver ${m}`;
  const stage = svg("svg", { class: "curve", viewBox: "0 0 600 230", role: "img", "aria-label": "The bicycle from behind" });
  stage.append(svg("line", { x1: 150, x2: 450, y1: 210, y2: 210 }));
  const both = [["exact", judge.exact(m, roll.column, t), judge.exact(m, steer.column, t)], ["yours", valueAt(mine.roll, t), valueAt(mine.steer, t)]];
  for (const [style, lean, turned] of both) {
    const angle = (lean * times * 180) / Math.PI, bar = 46 * Math.cos(turned * times), drop = 46 * Math.sin(turned * times) * 0.4;
    stage.append(svg("g", { class: `bicycle ${style}`, transform: `rotate(${angle.toFixed(2)} 300 210)` },
      svg("line", { x1: 300, x2: 300, y1: 210, y2: 70 }), svg("line", { x1: 300 - bar, x2: 300 + bar, y1: 80 + drop, y2: 80 - drop })));
  }
  at("stage").replaceChildren(stage);
}

function stop() {
  cancelAnimationFrame(playing);
  playing = 0;
  at("play").textContent = "Play";
}

function play() {
  if (playing) { stop(); return; }
  at("play").textContent = "Pause";
  if (Number(at("moment").value) >= 1000) at("moment").value = "0";
  const from = Number(at("moment").value), start = performance.now(), end = judge.end(shown.motion.m);
  const frame = (now) => {
    at("moment").value = String(from + now - start > 0 ? from + (now - start) / end : from);
    draw();
    if (Number(at("moment").value) >= 1000) stop();
    else playing = requestAnimationFrame(frame);
  };
  playing = requestAnimationFrame(frame);
}

/* ---- Links ---- */

async function through(stream, input) {
  const writer = stream.writable.getWriter();
  writer.write(input);
  writer.close();
  return new Uint8Array(await new Response(stream.readable).arrayBuffer());
}

async function packed(text) {
  const found = await through(new CompressionStream("deflate-raw"), new TextEncoder().encode(text));
  return btoa(found.reduce((s, x) => s + String.fromCharCode(x), "")).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

async function unpacked(text) {
  const input = Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
  return new TextDecoder().decode(await through(new DecompressionStream("deflate-raw"), input));
}

// The text itself if it is short, else the result: digits, and errors in 40 parts of the run.
async function link() {
  const own = location.href.split("#")[0];
  if (!shown.file) return location.href;
  const text = await packed(JSON.stringify({ name: shown.name, text: shown.file.text }));
  if (text.length <= MOST_IN_LINK) return `${own}#text=${text}`;
  const small = (x) => (typeof x === "number" ? Number(x.toPrecision(6)) : x);
  const cells = shown.cells.map((c) => {
    const found = Object.fromEntries(Object.entries(c).map(([name, x]) => [name, small(x)]));
    const mine = series(c), end = judge.end(c.maneuver), parts = new Array(40).fill(null);
    mine.t.forEach((t, i) => {
      const part = Math.min(39, Math.floor((40 * t) / end)), power = Math.round(10 * Math.log10(mine.error[i] || 1e-300));
      if (parts[part] === null || parts[part] < power) parts[part] = power;
    });
    return { ...found, errors: parts };
  });
  const { name, line, style, remarks } = shown;
  return `${own}#result=${await packed(JSON.stringify({ name, line, style, remarks, cells }))}`;
}

// What somebody wrote into a link is shown as text, and only what has the form of a result.
function isResult(found) {
  const isText = (x) => typeof x === "string";
  const isCell = (c) => MANEUVERS.includes(c.maneuver) && keys[c.key] !== undefined && MEASURES.every((name) => typeof c[name] === "number") &&
    Number.isInteger(c.column) && c.column >= 0 && c.column < judge.count_columns() && signs[c.grade] !== undefined && (!c.errors || (Array.isArray(c.errors) && c.errors.every((x) => x === null || typeof x === "number"))) && isText(c.unit) && isText(c.definition) && Array.isArray(c.also);
  return isText(found.name) && isText(found.line) && styles.includes(found.style) && Array.isArray(found.remarks) && Array.isArray(found.cells) && found.cells.every(isCell);
}

async function open() {
  const [, kind, text] = location.hash.match(/^#(text|result)=([\w-]+)$/) || [];
  if (!kind) return;
  let found;
  try {
    found = JSON.parse(await unpacked(text));
  } catch {
    found = {};
  }
  if (kind === "text" && typeof found.text === "string") judgeText(found.text, String(found.name));
  else if (kind === "result" && isResult(found)) show({ ...found, remarks: [...found.remarks, "from a link, which has the result and not the file"], file: null });
  else at("problem").textContent = "The link has no result, or not all of it.";
}

/* ---- What is done ---- */

async function take(file) {
  judgeText(await file.text(), file.name);
  at("verdict").focus();
}

function example() {
  const rows = [];
  for (let i = 0; i <= 1000; i++) {
    const t = i / 100, row = [t.toFixed(2)];
    for (const m of MANEUVERS) for (let k = 0; k < 8; k++) row.push((judge.exact(m, k, t) * (k === 0 || k === 6 ? 180 / Math.PI : 1) * (1 + 1e-6 * t)).toPrecision(12));
    rows.push(row.join(" "));
  }
  judgeText(rows.join("\n"), "example.txt");
  at("verdict").focus();
}

at("maneuver").append(...MANEUVERS.map((n) => make("option", { value: String(n) }, String(n))));
at("file").addEventListener("change", () => { if (at("file").files.length) take(at("file").files[0]); });
at("example").addEventListener("click", example);
at("judge").addEventListener("click", () => { judgeText(at("text").value, "pasted"); at("verdict").focus(); });
at("maneuver").addEventListener("change", () => judgeText(shown.file.text, shown.name, Number(at("maneuver").value)));
at("text").addEventListener("paste", () => setTimeout(() => judgeText(at("text").value, "pasted")));
at("play").addEventListener("click", play);
at("moment").addEventListener("input", () => { stop(); draw(); });
at("times").addEventListener("change", draw);
at("link").addEventListener("click", async () => {
  const found = await link();
  history.replaceState(null, "", `#${found.split("#")[1]}`);
  try {
    await navigator.clipboard.writeText(found);
    at("copied").textContent = `copied, ${found.length} letters`;
  } catch {
    at("copied").textContent = "it is in the address now: copy it there";
  }
});
for (const name of ["dragenter", "dragover", "dragleave", "drop"])
  document.addEventListener(name, (event) => {
    event.preventDefault();
    at("drop").classList.toggle("over", name === "dragenter" || name === "dragover");
    if (name === "drop" && event.dataTransfer.files.length) take(event.dataTransfer.files[0]);
  });
addEventListener("hashchange", open);
open();

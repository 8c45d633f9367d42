/* The page of the checker: display of results, and handling of input. */

const MOST_BYTES = 64e6;
const MOST_PASTED = 4e6;
const POINTS = 700;
const INVITATION = document.getElementById("invitation").textContent;

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

let shown = null;
let asked = 0;

// A new request replaces one that is still being read. The returned function is true until the next request.
function begun() {
  const mine = ++asked;
  return () => mine === asked;
}

function judgeText(text, name, chosen = 0) {
  begun();
  at("problem").textContent = "";
  hideResult();
  try {
    const result = judgedText(text, name, chosen);
    if (result.isOne) offerManeuvers(text, name, result.maneuver, result.guess ? guessText(result.maneuver, result.guess) : "");
    const times = result.file.numbers, { width, columns } = result.file, mine = result.cells.filter((c) => c.rows);
    const within = Array.from({ length: result.rows }, (_, i) => times[i * width + columns.time]).filter((t) => Number.isFinite(judge.exact(mine[0].maneuver, 0, t)));
    const remarks = [`${result.compared} of ${result.rows} rows compared, ${seconds(within[0])} to ${seconds(within[within.length - 1])} s of 0 to ${seconds(judge.end(mine[0].maneuver))} s`];
    if (result.isOne) remarks.push(`maneuver ${result.maneuver}, ${chosen ? "as chosen" : result.guess ? "a guess" : "recognised by its values"}`);
    if (result.file.skipped) remarks.push(result.file.skipped);
    show({ ...result, remarks });
  } catch (problem) {
    if (!(problem instanceof Unreadable)) throw problem;
    at("problem").textContent = `${problem.message}. More formats, and why a result differs: heyoka-bike score ${name}`;
    if (problem instanceof NoManeuver) offerManeuvers(text, name, 0, "");
  }
}

let offered = null;

// Shows the control for choosing the maneuver of a file that does not name it; maneuver 0 means that none is chosen yet.
function offerManeuvers(text, name, maneuver, guess) {
  offered = { text, name };
  at("guess").textContent = guess;
  at("which").hidden = false;
  at("which").classList.toggle("warned", Boolean(guess));
  at("maneuver").value = maneuver ? String(maneuver) : "";
}

const guessText = (maneuver, rivals) => `The file does not name its maneuver. It is compared with maneuver ${maneuver}, which is a guess: it may also be maneuver ${rivals.join(" or ")}. Choose it here:`;

/* ---- Showing ---- */

const seconds = (t) => String(Number(t.toPrecision(6)));
// Correct digits to one decimal, never rounded up to the limit of a better grade.
const oneDecimal = (x) => {
  const rounded = Number((x < 0 && x > -0.05 ? 0 : x).toFixed(1));
  return (limits.some((limit) => x < limit && limit <= rounded) ? Math.floor(10 * x) / 10 : rounded).toFixed(1);
};
const label = (cell) => `${keys[cell.key]} in ${phrases.maneuver} ${cell.maneuver}`;
const inWords = (key) => key.replaceAll("_", " ");
const title = (cell) => `${phrases.maneuver} ${cell.maneuver}, ${inWords(keys[cell.key])}`;
const capital = (text) => text[0].toUpperCase() + text.slice(1);

// Lists at most three alternatives, as the sentences of a report do.
function alternatives(names) {
  const shown = names.length > 3 ? [...names.slice(0, 2), `one of ${names.length - 2} others (see score --details)`] : names;
  return shown.length > 1 ? `${shown.slice(0, -1).join(", ")} or ${shown[shown.length - 1]}` : shown[0];
}

// Describes how a column differs from the default, and other definitions that fit it, in the words of a report; may be empty.
function takenAs(c) {
  if (!c.rows) return "never filled in: the same number in every row";
  const said = [], isDefault = c.column === c.key, usual = string(judge.definition(c.key));
  if (!isDefault || c.also.length) said.push(c.definition);
  if (!isDefault && !c.also.includes(usual)) said.push(`not the default ${usual}`);
  if (c.also.length) said.push(`may also be ${alternatives(c.also)}`);
  if (c.sign < 0) said.push("other sign");
  if (c.unit !== units[c.key]) said.push(`in ${unitText(c.unit)}`);
  if (c.offset) said.push(`zero at ${Number(c.offset.toPrecision(5))} ${units[c.key]}`);
  return said.join(", ");
}

function show(result) {
  shown = result;
  const verdict = `${capital(result.line)}.`;
  at("sign").textContent = result.file ? signs[Math.max(...result.cells.map((c) => c.grade))] : "";
  at("verdict").textContent = verdict;
  at("shown").className = `verdict ${result.style}`;
  at("facts").textContent = `${result.name}: ${result.remarks.join("; ")}`;
  const present = MANEUVERS.filter((n) => result.cells.some((c) => c.maneuver === n));
  const rows = keys.map((key, k) => [key, result.cells.filter((c) => c.key === k)]).filter(([, mine]) => mine.length);
  const taken = rows.map(([, mine]) => takenAs(mine.find((c) => c.rows) || mine[0])), isUsual = !taken.some(Boolean);
  const heading = (text, style) => make("th", style ? { scope: "col", class: style } : { scope: "col" }, text);
  const head = make("tr", {}, heading(capital(phrases.correct_digits)), ...present.map((n) => heading(`${phrases.maneuver} ${n}`)), ...(isUsual ? [] : [heading("taken as", "taken")]));
  const body = make("tbody");
  for (const [i, [key, mine]] of rows.entries()) {
    const row = make("tr", {}, make("th", { scope: "row" }, inWords(key)));
    for (const n of present) {
      const c = mine.find((x) => x.maneuver === n);
      if (!c || !c.rows) { row.append(make("td", { class: "unknown" }, "-")); continue; }
      const button = make("button", { type: "button", tabindex: "-1", "aria-pressed": "false", "aria-label": `${title(c)}: ${oneDecimal(c.digits)} digits, ${words[c.grade]}` }, make("b", { "aria-hidden": "true" }, signs[c.grade]), ` ${oneDecimal(c.digits)}`);
      button.addEventListener("click", () => detail(c, button));
      row.append(make("td", { class: styles[c.grade] }, button));
    }
    if (!isUsual) row.append(make("td", { class: "taken" }, taken[i]));
    body.append(row);
  }
  at("matrix").replaceChildren(make("thead", {}, head), body);
  const grades = [...new Set(result.cells.map((c) => c.grade))].filter((g) => words[g]).sort();
  at("signs").replaceChildren(...grades.map((g) => make("li", {}, make("b", { class: styles[g] }, signs[g]), ` ${meanings[g]}`)));
  at("more").replaceChildren(result.file ? "" : "None of this was computed here. ", "This page counts up to 14 digits and does not look for causes. The whole report, and why a result differs: ", make("code", {}, `heyoka-bike score ${result.name}`), ", ", make("code", {}, `heyoka-bike diagnose ${result.name}`), ".");
  at("copied").textContent = "";
  at("asked").hidden = true;
  at("result").hidden = false;
  invite(result.name);
  at("announced").textContent = [verdict, at("guess").textContent].filter(Boolean).join(" ");
  showMotion(result);
  const worst = result.cells.filter((c) => c.rows).sort((a, b) => a.digits - b.digits)[0];
  at("detail").hidden = at("rows").hidden = !worst;
  if (worst) {
    const buttons = [...at("matrix").querySelectorAll("button")];
    detail(worst, buttons.find((b) => b.getAttribute("aria-label").startsWith(`${title(worst)}:`)));
  }
  at("shown").scrollIntoView({ block: "nearest" });
}

// Makes the drop target name the judged file and invite another one; without a name it shows the first invitation again.
function invite(name) {
  at("drop").classList.toggle("has", Boolean(name));
  at("invitation").textContent = name ? `${name}: drop another file here, or click to choose one` : INVITATION;
}

const STEPS_OF_KEYS = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] };

// Arrow keys choose the next compared cell in their direction; Home and End choose the first and the last one of the row.
function moveInMatrix(event) {
  const cell = event.target.closest("td"), isEnd = event.key === "Home" || event.key === "End";
  if (!cell || !(isEnd || STEPS_OF_KEYS[event.key]) || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  const row = cell.parentElement, body = [...row.parentElement.rows];
  let button = null;
  if (isEnd) {
    const inRow = [...row.querySelectorAll("button")];
    button = inRow[event.key === "Home" ? 0 : inRow.length - 1];
  } else {
    const [down, across] = STEPS_OF_KEYS[event.key];
    let i = body.indexOf(row) + down, j = cell.cellIndex + across;
    for (; body[i]?.cells[j] && !button; i += down, j += across) button = body[i].cells[j].querySelector("button");
  }
  if (!button) return;
  button.click();
  button.focus();
}

const value = (x) => (Math.abs(x) <= MOST_VALUE ? x : NaN);

// Returns times, interpreted values in SI units, and errors of a column.
function series(c) {
  if (!shown.file) return null;
  const { numbers, width, columns, rows } = shown.file;
  const found = { t: [], value: [], exact: [], error: [], row: [] };
  for (let i = 0; i < rows.length; i++) {
    const t = numbers[i * width + columns.time], x = c.sign * c.factor * value(numbers[i * width + c.at]) - c.offset;
    const exact = judge.exact(c.maneuver, c.column, t);
    if (!Number.isFinite(x - exact)) continue;
    found.t.push(t); found.value.push(x); found.exact.push(exact); found.error.push(Math.abs(x - exact)); found.row.push(i);
  }
  return found;
}

function detail(c, button) {
  for (const other of at("matrix").querySelectorAll("button")) {
    other.setAttribute("aria-pressed", String(other === button));
    other.tabIndex = other === button ? 0 : -1;
  }
  const unit = unitText(units[c.key]), end = judge.end(c.maneuver), scale = judge.scale(c.maneuver, c.column);
  at("what").textContent = capital(title(c));
  at("taken").textContent = [`Off by ${c.max_error.toPrecision(2)} ${unit} at ${seconds(c.time_of_max)} s`, takenAs(c)].filter(Boolean).join("; taken as ");
  const exact = Array.from({ length: POINTS + 1 }, (_, i) => (end * i) / POINTS);
  const lines = [{ style: "reference", t: exact, y: exact.map((t) => judge.exact(c.maneuver, c.column, t)) }];
  const mine = series(c);
  const least = scale * 1e-15;
  let errors = { t: [], y: [] };
  if (mine) {
    const every = Math.max(1, Math.floor(mine.t.length / POINTS));
    const pick = (x) => x.filter((_, i) => i % every === 0);
    lines.push({ style: "result", t: pick(mine.t), y: pick(mine.value) });
    errors = largest(mine, POINTS);
  } else if (c.errors) errors = { t: c.errors.map((_, i) => (end * (i + 0.5)) / c.errors.length), y: c.errors.map((x) => (x === null ? NaN : 10 ** (x / 10))) };
  at("values").textContent = `[${unit}] over time [s]${mine ? "; reference grey, result blue" : ""}`;
  at("errors").textContent = `[${unit}] over time [s], by powers of ten`;
  const texts = [`${mine ? "Result and reference" : "Reference"}, ${title(c)}`, `Error of ${title(c)}`];
  at("curve").replaceChildren(chart(at("curve"), lines, c.maneuver, texts[0]));
  at("error").replaceChildren(chart(at("error"), [{ style: "error", t: errors.t, y: errors.y.map((x) => Math.log10(Math.max(x, least))) }], c.maneuver, texts[1], true));
  at("rows").hidden = !mine;
  if (mine) worstRows(c, mine);
  showMotions.goTo(c.maneuver);
}

// Returns the largest error in each of `parts` equal parts of the run.
function largest(mine, parts) {
  const end = mine.t[mine.t.length - 1] || 1, found = new Map();
  mine.t.forEach((t, i) => {
    const part = Math.min(parts - 1, Math.floor((parts * t) / end));
    if (!found.has(part) || found.get(part)[1] < mine.error[i]) found.set(part, [t, mine.error[i]]);
  });
  const pairs = [...found.values()].sort((a, b) => a[0] - b[0]);
  return { t: pairs.map((p) => p[0]), y: pairs.map((p) => p[1]) };
}

// Draws a chart that is as wide as the element `place`, which will contain it, so that all letters have one size.
function chart(place, lines, maneuver, title, isPower = false) {
  const end = judge.end(maneuver), width = Math.min(600, Math.max(280, place.clientWidth)), height = Math.round(120 + width / 6), bottom = 26, top = 8, right = 14;
  const values = lines.flatMap((l) => l.y).filter(Number.isFinite), finite = values.length ? values : [0];
  let low = Math.min(...finite), high = Math.max(...finite);
  if (isPower) { low = Math.floor(low); high = Math.max(Math.ceil(high), low + 1); }
  const size = Math.max(Math.abs(low), Math.abs(high));
  // Values that vary only by roundoff are drawn as a straight line.
  if (!(high - low > 1e-6 * size)) { low -= 1e-6 * size || 1; high += 1e-6 * size || 1; }
  const raw = (high - low) / 4, power = 10 ** Math.floor(Math.log10(raw));
  const step = isPower ? Math.ceil(raw) : power * [1, 2, 5, 10].find((s) => s * power >= raw);
  if (!isPower) { low = step * Math.floor(low / step); high = step * Math.ceil(high / step); }
  const marks = [];
  for (let v = low; v <= high + step / 1000; v += step) marks.push([v, isPower ? `1e${v}` : String(Number((step * Math.round(v / step)).toPrecision(8)))]);
  const left = 14 + 7.5 * Math.max(...marks.map(([, text]) => text.length));
  const x = (t) => left + ((width - left - right) * t) / end;
  const y = (v) => top + ((height - top - bottom) * (high - v)) / (high - low);
  const found = svg("svg", { class: "curve", viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": title });
  for (const [v, text] of marks) found.append(svg("line", { x1: left, x2: width - right, y1: y(v), y2: y(v) }), svg("text", { x: left - 6, y: y(v) + 4, "text-anchor": "end" }, text));
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
  found.append(svg("line", { class: "cursor", "data-maneuver": String(maneuver), "data-left": String(left), "data-width": String(width - left - right), y1: top, y2: height - bottom }));
  found.addEventListener("click", (event) => {
    const part = (((event.clientX - found.getBoundingClientRect().left) * width) / found.clientWidth - left) / (width - left - right);
    showMotions.goTo(maneuver, end * Math.min(Math.max(part, 0), 1));
  });
  return found;
}

// Writes a number in the format of a text from the file.
function alike(x, text) {
  const [mantissa, exponent] = text.toLowerCase().split(/[ed]/);
  const digits = mantissa.replace(/^[-+0.]+/, "").replace(".", "").length;
  if (exponent !== undefined) return x.toExponential(Math.min(16, Math.max(0, (mantissa.split(".")[1] || "").length)));
  const places = (mantissa.split(".")[1] || "").length;
  return digits > 17 ? x.toPrecision(17) : x.toFixed(Math.min(100, places));
}

// Returns two numbers, both marked from the first digit that differs.
function compared(text, exact) {
  const parts = (x) => [x.split(/[.e]/i)[0].length, Number(x.split(/e/i)[1] || 0)].join();
  let i = 0;
  if (parts(text) === parts(exact)) while (i < text.length && text[i] === exact[i]) i++;
  const marked = (x) => make("td", {}, x.slice(0, i), ...(i < x.length ? [make("mark", {}, x.slice(i))] : []));
  return [marked(text), marked(exact)];
}

function worstRows(c, mine) {
  const order = mine.error.map((_, i) => i).sort((a, b) => mine.error[b] - mine.error[a]).slice(0, 10);
  const head = make("tr", {}, ...["time [s]", `result [${unitText(c.unit)}]`, "reference", `error [${unitText(units[c.key])}]`].map((x) => make("th", { scope: "col" }, x)));
  const body = order.map((i) => {
    const row = shown.file.rows[mine.row[i]], text = row[c.at].replace(/^\+/, "");
    const exact = ((mine.exact[i] + c.offset) * c.sign) / c.factor;
    return make("tr", {}, make("td", {}, row[shown.file.columns.time]), ...compared(text, alike(exact, text)), make("td", {}, mine.error[i].toExponential(1)));
  });
  at("worst").replaceChildren(make("thead", {}, head), make("tbody", {}, ...body));
}

/* ---- Replay ---- */

const exactly = exactScenes();
const showMotions = replay({ bicycle: data.replay.bicycle, maneuvers: exactly, isPart: true, timeShown: moveCursors });

// Moves the cursors in the charts of a maneuver to the time of the replay, given as a fraction of the run; hides the others.
function moveCursors(maneuver, part) {
  for (const line of document.querySelectorAll(".curve .cursor")) {
    const x = Number(line.dataset.left) + part * Number(line.dataset.width), isHere = Number(line.dataset.maneuver) === maneuver;
    line.setAttribute("x1", x);
    line.setAttribute("x2", x);
    line.setAttribute("visibility", isHere ? "visible" : "hidden");
  }
}

// Shows the exact motion, and next to it the motion of a result, if there is one.
function showMotion(result) {
  const found = result && result.file ? scenesBeside(result, exactly) : exactly.map((scene) => ({ scene, notes: [] }));
  const notes = result && !result.file ? ["The link contains no rows, so only the exact motion is shown."] : null;
  document.querySelector(".replay").classList.toggle("compared", found.some(({ scene }) => scene.result));
  at("moving").replaceChildren(...found.filter((x) => notes || x.notes.length).map(({ scene, notes: own }) =>
    make("div", { class: "notes", "data-maneuver": String(scene.number) }, make("h3", {}, `Notes on the result, ${phrases.maneuver} ${scene.number}`), make("ul", {}, ...(notes || own).map((x) => make("li", {}, x))))));
  showMotions(found.map(({ scene }) => scene));
}

function hideResult() {
  at("which").hidden = true;
  at("guess").textContent = at("announced").textContent = "";
  invite("");
  if (at("result").hidden && !at("moving").firstChild) return;
  at("result").hidden = true;
  showMotion(null);
}

/* ---- Invitation ---- */

// Shows the exact motions with which a result will be compared.
function showAsked() {
  const k = keys.indexOf("roll_angle"), places = MANEUVERS.map(() => make("div"));
  at("motions").append(...MANEUVERS.map((n, i) => make("figure", {}, make("figcaption", {}, make("b", {}, `${phrases.maneuver} ${n}`), ` ${inWords(keys[k])} [${unitText(units[k])}] over time [s]`), places[i])));
  for (const [i, n] of MANEUVERS.entries()) {
    const end = judge.end(n), t = Array.from({ length: POINTS + 1 }, (_, j) => (end * j) / POINTS);
    places[i].append(chart(places[i], [{ style: "s0", t, y: t.map((x) => judge.exact(n, k, x)) }], n, `Exact ${inWords(keys[k])} of ${phrases.maneuver} ${n}`));
  }
}

/* ---- Input ---- */

function refuse(said) {
  begun();
  hideResult();
  at("problem").textContent = said;
}

async function take(file) {
  const isNewest = begun();
  if (file.size > MOST_BYTES) refuse(`${file.name}: found ${file.size} bytes, expected at most ${MOST_BYTES}: heyoka-bike score takes longer files.`);
  else {
    let text = null;
    try {
      text = await file.text();
    } catch {
      // A folder, or a file that is gone.
    }
    if (!isNewest()) return;
    if (text === null) refuse(`${file.name}: cannot be read, expected a file.`);
    else judgeText(text, file.name);
  }
}

function takePasted() {
  const { value } = at("text");
  if (value.length > MOST_PASTED) refuse(`found ${value.length} letters, expected at most ${MOST_PASTED}: drop the file.`);
  else judgeText(value, "pasted");
}

// Returns the text of an example file: in degrees, with a relative error that grows by a millionth per second.
function exampleText() {
  const names = MANEUVERS.flatMap((m) => keys.map((key, k) => `m${m}_${key} [${isAngle(k) ? "deg" : unitText(units[k])}]`));
  const rows = [["time [s]", ...names].join(",")];
  for (let i = 0; i <= 1000; i++) {
    const t = i / 100, row = [t.toFixed(2)];
    for (const m of MANEUVERS) for (let k = 0; k < 8; k++) row.push((judge.exact(m, k, t) * (isAngle(k) ? 180 / Math.PI : 1) * (1 + 1e-6 * t)).toPrecision(12));
    rows.push(row.join(","));
  }
  return `${rows.join("\n")}\n`;
}

const isAngle = (k) => units[k] === "rad";

function example() {
  judgeText(exampleText(), "example.csv");
}

at("maneuver").append(make("option", { value: "", hidden: "" }, "choose"), ...MANEUVERS.map((n) => make("option", { value: String(n) }, String(n))));
at("file").addEventListener("change", () => { if (at("file").files.length) take(at("file").files[0]); });
at("file").addEventListener("click", () => { at("file").value = ""; });  // the same file may be chosen again
at("matrix").addEventListener("keydown", moveInMatrix);
at("example").addEventListener("click", example);
at("save").addEventListener("click", () => {
  const saved = make("a", { download: "example.csv", href: URL.createObjectURL(new Blob([exampleText()], { type: "text/csv" })) });
  saved.click();
  URL.revokeObjectURL(saved.href);
});
at("wanted").textContent = keys.join(", ");
showAsked();
at("judge").addEventListener("click", takePasted);
at("maneuver").addEventListener("change", () => judgeText(offered.text, offered.name, Number(at("maneuver").value)));
at("text").addEventListener("paste", (event) => {
  // Showing a text of this length in the field would block the page.
  const text = event.clipboardData.getData("text");
  if (text.length > MOST_PASTED) {
    event.preventDefault();
    refuse(`found ${text.length} letters, expected at most ${MOST_PASTED}: drop the file.`);
  } else setTimeout(takePasted);
});
at("link").addEventListener("click", async () => {
  const found = await link();
  history.replaceState(null, "", `#${found.split("#")[1]}`);
  try {
    await navigator.clipboard.writeText(found);
    at("copied").textContent = `copied, ${found.length} letters`;
  } catch {
    at("copied").textContent = "the link is now in the address bar: copy it there";
  }
});
for (const name of ["dragenter", "dragover", "dragleave", "drop"])
  document.addEventListener(name, (event) => {
    event.preventDefault();
    // A dragleave event with a related target goes to another element of the page, so the file is still over the page.
    const isOver = name !== "drop" && (name !== "dragleave" || event.relatedTarget !== null);
    if (isOver !== at("drop").classList.contains("over")) showDrag(isOver);
    if (name === "drop" && event.dataTransfer.files.length) take(event.dataTransfer.files[0]);
  });

let invitation = "";

function showDrag(isOver) {
  at("drop").classList.toggle("over", isOver);
  if (isOver) invitation = at("invitation").textContent;
  at("invitation").textContent = isOver ? "Release the file to judge it" : invitation;
}

/* Links to results. A link contains a short text itself, or the result of a longer one. The content is
   checked before any of it is shown. The verdict is computed from the cells of the result. */

const MOST_IN_LINK = 8000;
const PARTS = 40;

async function through(stream, input, most = Infinity) {
  const writer = stream.writable.getWriter();
  // A damaged stream raises its error when it is read.
  writer.write(input).catch(() => {});
  writer.close().catch(() => {});
  const pieces = [];
  let size = 0;
  for (const reader = stream.readable.getReader(); ;) {
    const { done, value } = await reader.read();
    if (done) break;
    size += value.length;
    if (size > most) throw new Unreadable(`the link expands to more than ${most / 1e6} MB`);
    pieces.push(value);
  }
  return new Uint8Array(await new Blob(pieces).arrayBuffer());
}

async function packed(text) {
  const found = await through(new CompressionStream("deflate-raw"), new TextEncoder().encode(text));
  return btoa(found.reduce((s, x) => s + String.fromCharCode(x), "")).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

async function unpacked(text) {
  const input = Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
  return new TextDecoder().decode(await through(new DecompressionStream("deflate-raw"), input, MOST_BYTES));
}

// Returns a link with the text itself if it is short, else with the cells of the result: digits, and the largest
// error in each part of the run.
async function link() {
  const address = location.href.split("#")[0];
  if (!shown.file) return location.href;
  const text = await packed(JSON.stringify({ name: shown.name, text: shown.file.text }));
  if (text.length <= MOST_IN_LINK) return `${address}#text=${text}`;
  const small = (x) => (typeof x === "number" ? Number(x.toPrecision(6)) : x);
  const cells = shown.cells.filter((c) => c.rows).map((c) => {
    const found = Object.fromEntries(CELL.map((name) => [name, small(c[name])]));
    const mine = series(c), end = judge.end(c.maneuver), parts = new Array(PARTS).fill(null);
    mine.t.forEach((t, i) => {
      const part = Math.min(PARTS - 1, Math.floor((PARTS * t) / end)), power = Math.round(10 * Math.log10(mine.error[i] || 1e-300));
      if (parts[part] === null || parts[part] < power) parts[part] = power;
    });
    return { ...found, errors: parts };
  });
  return `${address}#result=${await packed(JSON.stringify({ name: shown.name, whole: shown.isWhole, cells }))}`;
}

const CELL = ["maneuver", "key", ...MEASURES];
const isText = (x) => typeof x === "string" && x.length <= 200;
const isCount = (x, most) => Number.isInteger(x) && x >= 0 && x <= most;
const hasOnly = (x, names) => typeof x === "object" && x !== null && !Array.isArray(x) && Object.keys(x).length === names.length && names.every((name) => Object.hasOwn(x, name));

// True if a cell has exactly the entries that the page shows.
function isCell(c) {
  return hasOnly(c, [...CELL, "errors"]) && MANEUVERS.includes(c.maneuver) && isCount(c.key, keys.length - 1) && MEASURES.every((name) => Number.isFinite(c[name])) &&
    isCount(c.column, judge.count_columns() - 1) && judge.of(c.column) === c.key && isCount(c.grade, words.length - 1) && c.grade > 0 && c.rows > 0 && c.max_error >= 0 &&
    Array.isArray(c.errors) && c.errors.length === PARTS && c.errors.every((x) => x === null || Number.isFinite(x));
}

// Returns the result in a link without the file; null if the content has another form.
function linked(found) {
  if (!hasOnly(found, ["name", "whole", "cells"]) || !isText(found.name) || typeof found.whole !== "boolean" || !Array.isArray(found.cells)) return null;
  const places = new Set(found.cells.map((c) => c && `${c.maneuver} ${c.key}`));
  if (!found.cells.length || places.size < found.cells.length || !found.cells.every(isCell)) return null;
  const cells = found.cells.map((c) => ({ ...c, also: [], definition: string(judge.definition(c.column)), unit: units[c.key] }));
  const worst = cells.reduce((a, b) => (b.digits < a.digits ? b : a)), grade = Math.max(...cells.map((c) => c.grade));
  const counts = MANEUVERS.map((n) => [cells.filter((c) => c.maneuver === n).length, n]).filter(([count]) => count);
  const [fewest, where] = counts.reduce((a, b) => (b[0] < a[0] ? b : a)), isComplete = fewest === keys.length;
  const place = counts.some(([count]) => count !== fewest) ? ` in ${phrases.maneuver} ${where}` : "";
  const columns = isComplete ? "" : ` (${fewest} ${phrases.of_all} ${keys.length} ${phrases.columns}${place})`;
  const isWhole = found.whole && isComplete;
  const how = grade < styles.indexOf("wrong") && !isWhole ? phrases.in_part + columns : "";
  const shown = oneDecimal(worst.digits);
  const digits = Number(shown) <= 0 ? phrases.no_digit : `${phrases.worst} ${shown} ${phrases.correct_digits}`;
  const line = `shared, not checked here: ${words[grade]}${how}; ${digits} (${label(worst)})`;
  return { name: found.name, line, style: "shared", cells, isWhole, remarks: ["this link contains a result, not the file: drop the file to judge it"], file: null };
}

async function open() {
  if (!location.hash) return;
  const [, kind, text] = location.hash.match(/^#(text|result)=([\w-]+)$/) || [];
  hideResult();
  const isNewest = begun();
  let problem = "the link contains no result, or only a part of one";
  try {
    const found = kind && JSON.parse(await unpacked(text));
    if (!isNewest()) return;
    if (kind === "text" && hasOnly(found, ["name", "text"]) && isText(found.name) && typeof found.text === "string") return judgeText(found.text, found.name);
    const result = kind === "result" && linked(found);
    if (result) {
      at("problem").textContent = "";
      return show(result);
    }
  } catch (e) {
    if (e instanceof Unreadable) problem = e.message;
  }
  if (!isNewest()) return;
  at("problem").textContent = `${problem}.`;
}

addEventListener("hashchange", open);
open();

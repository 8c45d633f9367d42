/* Reads a text as heyoka-bike score does, or rejects it with the reason. Nothing is guessed: every word of a heading
   must be known, and a text has one separator. */

const isNumber = (text) => /^[+-]?(\d+(\.\d*)?|\.\d+)([eEdD][+-]?\d+)?$|^[+-]?(nan|inf(inity)?)$/i.test(text);
const number = (text) => (/n/i.test(text) ? NaN : Number(text.replace(/d/i, "e")));
const SEPARATORS = ["\t", ";", ",", ""];
const FEWEST_COUNTED = 9;
const LONGEST_SHOWN = 40;
// At most this many skipped lines are quoted.
const MOST_SKIPPED = 3;
// Limit on the values that the repeat counts of one row may produce, see `expanded`.
const MOST_REPEATED = 100;
// A field that begins like a number and contains no letters except those of exponents.
const LIKE_A_NUMBER = /^["'([{]*[+-]?\.?\d[\d.,+*^-]*(?:[edq][\d.,+*^-]*)*[)\]}"']*$/i;
const FACTOR = /^\s*1\.?0*e[+-]?\d{1,2}\s*\*\s*$/i;
const COMMENT_SIGNS = /^[#%!/;*\s]+/;
// Longer headings are not tried, because the time of the patterns below grows with the square of the length.
const LONGEST_HEADING = 200;

class Unreadable extends Error {}

// Returns the rows of a text as texts and as numbers, its columns, and the unit that each heading names.
function read(text, name) {
  const stop = (line, column, said) => { throw new Unreadable(`${name}${line ? `:${line}` : ""}${column ? `:${column}` : ""}: ${said}`); };
  if (text.includes("\0")) stop(0, 0, "found a file that is no text, expected rows of numbers");
  if (!text.trim()) stop(0, 0, "found an empty file, expected rows of numbers");
  const lines = text.replace(/^\uFEFF/, "").replaceAll("\u2212", "-").replaceAll("\u00a0", " ").split(/\r\n|\n|\r/);
  const plain = lines.map((line) => line.replace(/([#%!]|\/\/)[^]*$/, "").trim());
  const dialect = dialectOf(plain);
  if (!dialect) stop(0, 0, `found no row of numbers, ${EXPECTED} columns of numbers`);
  let { first } = dialect;
  const width = fieldsOf(plain[first], dialect).length;
  const heading = headingAbove(lines.slice(0, first), dialect, width, stop);
  if (countsColumns(fieldsOf(plain[first], dialect))) first += 1;
  const rows = [], numbers = [], skipped = [];
  for (let i = 0; i < first; i++) {
    if (FACTOR.test(lines[i])) stop(i + 1, 0, `found ${shortened(lines[i].trim())}, MATLAB's common factor, expected the numbers themselves: use writematrix`);
    if (i !== heading?.line && looksLikeRow(lines[i], plain[i], dialect, width)) skipped.push(i);
  }
  for (let i = first; i < lines.length; i++) {
    if (!plain[i]) {
      if (lines[i] && looksLikeRow(lines[i], "", dialect, width)) skipped.push(i);
      continue;
    }
    const found = fieldsOf(plain[i], dialect).map((x) => decimal(x, dialect));
    const bad = found.findIndex((x) => !isNumber(x));
    if (bad >= 0 && bad < width) stop(i + 1, bad + 1, `found ${found[bad] ? shortened(found[bad]) : "no value between two separators"} as value ${bad + 1}, expected a number`);
    if (found.length !== width) stop(i + 1, Math.min(found.length, width) + 1, `found ${found.length} values, expected ${width}`);
    rows.push(found);
    for (const x of found) numbers.push(number(x));
  }
  if (!rows.length) stop(0, 0, `found no row of numbers, ${EXPECTED} columns of numbers`);
  const columns = heading || placed(width);
  if (!columns) stop(first + 1, 0, `found ${width} columns, ${EXPECTED}, or a line of column names such as time, roll_angle, roll_rate`);
  const file = { name, text, rows, width, numbers: Float64Array.from(numbers), columns, skipped: skippedText(skipped, lines) };
  timesOf(file, stop);
  return file;
}

// The separator and decimal sign of the first row of numbers, and its line; null without one.
function dialectOf(plain) {
  for (const [first, line] of plain.entries())
    for (const separator of SEPARATORS)
      for (const point of [".", ","]) {
        const dialect = { separator, point, first };
        if ((point === "," && (separator === "," || !line.includes(","))) || (separator && !line.includes(separator))) continue;
        const found = fieldsOf(line, dialect);
        if (found.length > 1 && found.every((x) => isNumber(decimal(x, dialect)))) return dialect;
      }
  return null;
}

function fieldsOf(line, { separator, point = "." }) {
  const found = separator ? line.split(separator) : line.split(/\s+/);
  if (separator && !found[found.length - 1].trim()) found.pop();
  const fields = found.map((x) => x.trim().replace(/^(["'])(.*)\1$/, "$2").trim());
  return line.includes("*") ? expanded(fields, point) : fields;
}

// Expands Fortran's repeat counts: 3*0.5 means three values.
function expanded(fields, point) {
  const each = fields.map((x) => x.match(/^([1-9]\d{0,2})\*([^*^].*)$/)).map((x) => (x && isNumber(decimal(x[2], { point })) ? x : null));
  if (each.reduce((sum, x) => sum + (x ? Number(x[1]) : 0), 0) > MOST_REPEATED) return fields;
  return fields.flatMap((x, i) => (each[i] ? Array(Number(each[i][1])).fill(each[i][2]) : [x]));
}

// True if a skipped line looks like a row: it has at least as many numbers as a row, or most of its
// fields are numbers. A comment needs as many numbers as a row, because it may list a few parameters.
function looksLikeRow(line, plain, dialect, width) {
  const text = (plain || line.replace(COMMENT_SIGNS, "")).trim();
  if (!text || (plain && countsColumns(fieldsOf(text, dialect)))) return false;
  return SEPARATORS.some((separator) => {
    const fields = fieldsOf(text, { separator }), numbers = fields.filter((x) => LIKE_A_NUMBER.test(x)), count = numbers.length;
    // If a line starts with a word and all of its numbers are integers, these are labels, not values.
    if (numbers[0] !== fields[0] && numbers.every((x) => /^\d+$/.test(x))) return false;
    return count >= width || (plain && count > 1 && 2 * count > fields.length);
  });
}

function skippedText(skipped, lines) {
  if (!skipped.length) return "";
  const shown = skipped.slice(0, MOST_SKIPPED).map((i) => `line ${i + 1}: ${shortened(lines[i].trim())}`).join(", ");
  const more = skipped.length > MOST_SKIPPED ? `, and ${skipped.length - MOST_SKIPPED} more` : "";
  return `${skipped.length === 1 ? "a line with numbers was" : `${skipped.length} lines with numbers were`} not read: ${shown}${more}`;
}

// The text of a field with a decimal point; empty if a file with decimal commas has a point in a number.
// Mathematica writes exponents as *^-18.
const decimal = (field, { point }) => (point === "." ? field : field.includes(".") ? "" : field.replace(",", ".")).replace("*^", "e");
const shortened = (text) => JSON.stringify(text.length > LONGEST_SHOWN ? `${text.slice(0, LONGEST_SHOWN)}...` : text);
const countsColumns = (fields) => fields.length >= FEWEST_COUNTED && [0, 1].some((start) => fields.every((x, i) => x === String(i + start)));

// Returns the columns that a heading names; null if none of the lines above the rows is a heading. A line that is
// nearly a heading is rejected, because ignoring it silently could change the meaning of the columns.
function headingAbove(above, dialect, width, stop) {
  for (let i = above.length - 1; i >= 0; i--) {
    const line = above[i].trim().replace(COMMENT_SIGNS, "").trim();
    if (!line) continue;
    const ways = [dialect, ...SEPARATORS.map((separator) => ({ separator }))].map((way) => {
      const names = fieldsOf(line, way);
      return { names, meant: names.map(meaning) };
    });
    const fitting = ways.filter((x) => x.names.length === width);
    const whole = fitting.find((x) => x.meant.every(Boolean) && x.meant.some((y) => y.isTime));
    if (whole) return together(whole, i + 1, stop);
    const [nearest] = fitting.sort((x, y) => known(y) - known(x));
    if (nearest) {
      const at = nearest.meant.findIndex((x) => !x);
      const found = at < 0 ? "a heading without a time" : `the heading ${shortened(nearest.names[at])}, which this page does not know`;
      stop(i + 1, at + 1, `found ${found}, expected names such as time, m2_roll_angle [deg], or no heading`);
    }
    if (ways.some((x) => known(x) > 1)) stop(i + 1, 0, `found a heading that does not fit ${width} columns, expected a name for each`);
  }
  return null;
}

const known = ({ meant }) => meant.filter(Boolean).length;

// Returns the column, maneuver (0 if not named) and unit that a heading means; null for an unknown heading.
function meaning(text) {
  if (text.length > LONGEST_HEADING) return null;
  const [, stem, unit = ""] = text.match(/^(.*?)\s*(?:[[(]([^\])]*)[\])])?$/);
  const word = stem.toLowerCase().replace(/[\s_.:/\\-]+/g, "_").replace(/^_|_$/g, "");
  const [, before = 0, rest = word] = word.match(/^(?:m|man|maneuver|manoeuvre)_?(\d)_(.+)$/) || [];
  const [, name = rest, behind = 0] = before ? [] : rest.match(/^(.+?)_?(?:(?:m|man|maneuver|manoeuvre)_?)?(\d)$/) || [];
  const key = own(headings, name.replaceAll("_", "")), maneuver = before || behind;
  if (key === undefined) return null;
  const named = own(key < 0 ? timeUnits : unitWords[key], unit.trim());
  if ((unit && named === undefined) || (key < 0 && maneuver)) return null;
  return { isTime: key < 0, key, maneuver: Number(maneuver), unit: unit ? named : "" };
}

const own = (object, name) => (Object.hasOwn(object, name) ? object[name] : undefined);

function together({ meant: found, names }, line, stop) {
  const seen = new Map();
  for (const [i, x] of found.entries()) {
    const what = x.isTime ? "time" : `${x.maneuver} ${x.key}`;
    if (seen.has(what)) stop(line, i + 1, `found ${shortened(names[seen.get(what)])} and ${shortened(names[i])}, expected one column of each`);
    if (x.maneuver > MANEUVERS.length) stop(line, i + 1, `found maneuver ${x.maneuver}, expected 1 to ${MANEUVERS.length}`);
    seen.set(what, i);
  }
  if (new Set(found.filter((x) => !x.isTime).map((x) => x.maneuver > 0)).size > 1) stop(line, 0, "found columns with a maneuver and without, expected the same of all");
  const time = found.findIndex((x) => x.isTime);
  return { line: line - 1, time, timeUnit: found[time].unit, of: found.map((x, i) => ({ ...x, at: i })).filter((x) => !x.isTime) };
}

function placed(width) {
  if (width !== 9 && width !== 1 + 8 * MANEUVERS.length) return null;
  const of = Array.from({ length: width - 1 }, (_, i) => ({ maneuver: width === 9 ? 0 : 1 + Math.floor(i / 8), key: i % 8, at: i + 1, unit: "" }));
  return { time: 0, timeUnit: "", of };
}

// Converts the times to seconds, and checks that they are finite and ascend.
function timesOf(file, stop) {
  const { numbers, width, rows, columns } = file, { time } = columns;
  for (let i = 0; i < rows.length; i++) {
    const at = i * width + time;
    if (columns.timeUnit === "ms") numbers[at] = inThousands(rows[i][time]);
    if (!Number.isFinite(numbers[at])) stop(0, 0, `row ${i + 1}: found ${rows[i][time]} as a time, expected a finite number`);
    if (i && !(numbers[at] > numbers[at - width])) stop(0, 0, `row ${i + 1}: found the time ${rows[i][time]} after ${rows[i - 1][time]}, expected ascending times`);
  }
}

// Divides a decimal by a thousand, correctly rounded, by changing its exponent.
function inThousands(text) {
  const [mantissa, exponent = "0"] = text.toLowerCase().split(/[ed]/);
  return Number(`${mantissa}e${Number(exponent) - 3}`);
}

// Returns the resolution of a column: significant digits, and decimal places if all numbers have the same number.
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

// A constant column does not show its resolution, so it gets that of the most finely written column.
function evened(columns, time) {
  const finest = columns.filter((c, i) => i !== time && !c.isConstant).sort((a, b) => b.count - a.count)[0];
  return columns.map((c) => c.isConstant && finest ? finest : c);
}

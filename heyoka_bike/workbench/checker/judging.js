/* Scores the columns of a text with the compiled functions of the header. */

const { keys, units, words, signs, styles, meanings, phrases, limits, headings, unitWords, timeUnits } = data;
const GIVEN = { log: Math.log, log10: Math.log10, sin: Math.sin, cos: Math.cos, atan2: Math.atan2, pow: Math.pow };
const bytes = Uint8Array.from(atob(data.wasm), (c) => c.charCodeAt(0));
const judge = new WebAssembly.Instance(new WebAssembly.Module(bytes), { env: GIVEN }).exports;
const MANEUVERS = Array.from({ length: judge.maneuvers() }, (_, i) => i + 1);
const EXPECTED = `expected 9 or ${1 + 8 * MANEUVERS.length}`;
// UB_LARGEST of the header: larger numbers count as missing.
const MOST_VALUE = 1e150;
// In the order of the function `number` in checker.c.
const MEASURES = ["rows", "digits", "mescd", "max_error", "time_of_max", "rms_error", "column", "sign", "factor", "offset", "grade", "never_filled"];

function string(address) {
  const memory = new Uint8Array(judge.memory.buffer);
  return new TextDecoder().decode(memory.subarray(address, memory.indexOf(0, address)));
}

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
  return { name: file.name, line: string(judge.line()), style: grade === 1 && !isRight ? "close" : styles[grade], isWhole: Boolean(judge.is_whole()), cells: found, rows: rows.length };
}

// Judges a text, or throws `Unreadable`. If the file names no maneuver and `chosen` is 0, the maneuver is recognised by the
// values; `guess` then lists other possible maneuvers, or is null.
function judgedText(text, name, chosen = 0) {
  const file = read(text, name);
  file.written = evened(Array.from({ length: file.width }, (_, i) => written(file, i)), file.columns.time);
  const isOne = file.columns.of.some((c) => !c.maneuver), found = isOne && !chosen ? recognised(file) : null;
  const maneuver = found ? found.maneuver : chosen, guess = found?.rivals.length ? found.rivals : null;
  const result = judged(file, maneuver);
  const compared = Math.max(0, ...result.cells.map((c) => c.rows));
  const stop = (said) => { throw new Unreadable(`${name}: ${said}`); };
  const last = file.numbers[(file.rows.length - 1) * file.width + file.columns.time], end = judge.end(1);
  if (file.columns.timeUnit === "ms" && last < end / 10 && 1000 * last > end / 10) stop(`found times in ms by their heading that span ${1000 * last}, as the run does in s, expected one of them`);
  if (2 * compared < file.rows.length) stop(`found ${compared} of ${file.rows.length} rows within the run, expected times of 0 to ${judge.end(1)} s`);
  for (const c of result.cells) {
    const named = file.columns.of.find((x) => x.at === c.at).unit;
    if (c.rows && named && c.unit !== named) stop(`found ${keys[c.key]} in ${unitText(named)} by its heading and in ${unitText(c.unit)} by its values, expected one of them`);
  }
  return { ...result, file, maneuver, isOne, guess, compared };
}

const unitText = (unit) => unit.replace(/ (s|h|min)-1/g, "/$1");

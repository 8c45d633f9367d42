// Draws the map, describes the behaviour of a chosen start, and replays its motion.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const one = (selector) => document.querySelector(selector);
  const canvas = one(".map canvas"), choose = one("form.choose"), start = one("form.start");
  const context = canvas.getContext("2d"), key = one(".colours"), under = one(".under"), said = one(".said");
  const HINT = "Point at the map to read the result there. Click to replay the motion from there.";
  const [across, along] = data.axes, columns = across.values.length, rows = along.values.length;

  // ---- data of the page
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const fate = bytes(data.fate), wheel = bytes(data.wheel);
  const LAST = 65534, NONE = 65535;
  const codesOf = (text) => {
    const view = new DataView(bytes(text).buffer);
    return Uint16Array.from({ length: view.byteLength / 2 }, (_, i) => view.getUint16(2 * i, true));
  };
  for (const q of Object.values(data.quantities)) {
    const codes = codesOf(q.codes);
    q.at = (i) => {
      if (codes[i] === NONE) return NaN;
      if (q.isLog && codes[i] === 0) return 0;
      const x = q.low + (q.high - q.low) * codes[i] / LAST;
      return q.isLog ? 10 ** x : x;
    };
  }

  // ---- the grid: a point's cell reaches half of the way to the next one
  const borders = (values) => {
    const n = values.length, middle = (i) => (values[i] + values[i + 1]) / 2;
    if (n === 1) return [values[0] - 0.5, values[0] + 0.5];
    return [2 * values[0] - middle(0), ...values.slice(1).map((_, i) => middle(i)), 2 * values[n - 1] - middle(n - 2)];
  };
  const edges = [across, along].map((axis) => borders(axis.values));
  const cell = (place, value) => {
    let low = 0, high = edges[place].length - 1;
    while (high - low > 1) { const m = (low + high) >> 1; if (edges[place][m] <= value) low = m; else high = m; }
    return low;
  };
  const whole = edges.map((e) => [e[0], e[e.length - 1]]);
  const point = (x, y) => cell(0, x) * rows + cell(1, y);

  // ---- colours
  const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
  // Cividis (Nunez, Anderton and Renslow 2018), which looks nearly the same with colour vision deficiency.
  const SCALE = ["#00224e", "#123570", "#3b496c", "#575d6d", "#707173", "#8a8678", "#a59c74", "#c3b369", "#e1cc55", "#fee838"].map(rgb);
  const scaled = (part) => {
    const at = Math.min(Math.max(part, 0), 1) * (SCALE.length - 1), i = Math.min(Math.floor(at), SCALE.length - 2);
    return mixed(SCALE[i], SCALE[i + 1], at - i);
  };
  let colours = {};
  const readColours = () => {
    colours = { fates: data.fates.map((_, i) => rgb(style(`--fate-${i}`))), none: rgb(style("--card")) };
    colours.falls = ["--fall-soon", "--fall-late"].map((name) => rgb(style(name)));
    for (const name of ["ink", "soft", "page", "rule"]) colours[name] = style(`--${name}`);
  };

  // ---- colour scales: the range of a quantity covers only the starts that do not fall
  let shown = "fate", range = [0, 1];
  const isTime = () => shown === "fate_time" || shown === "lift_time";
  const scale = (x) => data.quantities[shown].isLog ? Math.log10(x) : x;
  const findRange = () => {
    const q = data.quantities[shown];
    let low = Infinity, high = -Infinity;
    for (let i = 0; i < fate.length; i++) {
      const x = q.at(i);
      if (!(isTime() || fate[i] !== data.falls) || !(x > 0 || !q.isLog)) continue;
      low = Math.min(low, scale(x)); high = Math.max(high, scale(x));
    }
    range = low < high ? [low, high] : [low - 0.5, low + 0.5];
  };
  const mixed = (a, b, part) => a.map((c, j) => c + part * (b[j] - c));
  const SOONEST = 0.1;  // [s]
  const times = data.quantities.fate_time;
  const longest = times ? fate.reduce((most, _, i) => Math.max(most, times.at(i) || 0), SOONEST) : SOONEST;
  const colour = (i) => {
    if (shown === "fate" && fate[i] === data.falls && longest > SOONEST) {
      const part = Math.log(times.at(i) / SOONEST) / Math.log(longest / SOONEST);
      return mixed(...colours.falls, Math.min(Math.max(part, 0), 1));
    }
    if (shown === "fate") return colours.fates[fate[i]];
    if (fate[i] === data.falls && !isTime()) return colours.fates[fate[i]];
    const x = data.quantities[shown].at(i);
    if (Number.isNaN(x)) return colours.none;
    return scaled((scale(x) - range[0]) / (range[1] - range[0]));
  };

  // ---- places on the screen
  const ROOM = { left: 54, right: 14, top: 26, bottom: 42 };
  let view = whole.map((x) => [...x]), width = 0, height = 0, ratio = 1, picture = null;
  const size = () => [width - ROOM.left - ROOM.right, height - ROOM.top - ROOM.bottom];
  const toScreen = (x, y) => {
    const [w, h] = size();
    return [
      ROOM.left + w * (x - view[0][0]) / (view[0][1] - view[0][0]),
      ROOM.top + h * (view[1][1] - y) / (view[1][1] - view[1][0]),
    ];
  };
  const fromScreen = (px, py) => {
    const [w, h] = size();
    return [
      view[0][0] + (px - ROOM.left) / w * (view[0][1] - view[0][0]),
      view[1][1] - (py - ROOM.top) / h * (view[1][1] - view[1][0]),
    ];
  };
  const isInside = (x, y) => x >= view[0][0] && x <= view[0][1] && y >= view[1][0] && y <= view[1][1];

  const paint = () => {
    const [w, h] = size().map((x) => Math.max(Math.round(x * ratio), 1));
    picture = new ImageData(w, h);
    const ix = Array.from({ length: w }, (_, i) => cell(0, view[0][0] + (i + 0.5) / w * (view[0][1] - view[0][0])));
    const iy = Array.from({ length: h }, (_, j) => cell(1, view[1][1] - (j + 0.5) / h * (view[1][1] - view[1][0])));
    const palette = Array.from({ length: columns * rows });
    for (let j = 0, at = 0; j < h; j++) {
      for (let i = 0; i < w; i++, at += 4) {
        const c = palette[ix[i] * rows + iy[j]] ||= colour(ix[i] * rows + iy[j]);
        picture.data[at] = c[0]; picture.data[at + 1] = c[1]; picture.data[at + 2] = c[2]; picture.data[at + 3] = 255;
      }
    }
  };
  const halo = (text, x, y) => {
    context.lineJoin = "round"; context.lineWidth = 4; context.strokeStyle = colours.page;
    context.strokeText(text, x, y);
    context.fillStyle = colours.ink; context.fillText(text, x, y);
  };
  const line = (points, look, thick, dash = []) => {
    context.beginPath();
    points.forEach((p, i) => (i ? context.lineTo(...p) : context.moveTo(...p)));
    context.setLineDash(dash); context.strokeStyle = look; context.lineWidth = thick; context.stroke();
    context.setLineDash([]);
  };

  const drawAxes = () => {
    const [w, h] = size();
    context.strokeStyle = colours.soft; context.lineWidth = 1;
    context.strokeRect(ROOM.left, ROOM.top, w, h);
    context.fillStyle = colours.soft; context.textBaseline = "alphabetic";
    const x = nice(...view[0], w / 70), y = nice(...view[1], h / 50);
    context.textAlign = "center";
    for (const v of x.found) {
      const [px] = toScreen(v, 0);
      line([[px, ROOM.top + h], [px, ROOM.top + h + 4]], colours.soft, 1);
      context.fillText(minus(v.toFixed(x.digits)), px, ROOM.top + h + 17);
    }
    context.textAlign = "right";
    for (const v of y.found) {
      const [, py] = toScreen(0, v);
      line([[ROOM.left - 4, py], [ROOM.left, py]], colours.soft, 1);
      context.fillText(minus(v.toFixed(y.digits)), ROOM.left - 8, py + 4);
    }
    context.fillStyle = colours.ink;
    const titles = data.axes.map((a) => a.unit && a.unit !== "1" ? `${a.title} [${a.unit}]` : a.title);
    context.fillText(titles[0], ROOM.left + w, height - 6);
    context.textAlign = "left";
    context.fillText(titles[1], 2, 15);
  };

  // Join each point of the edge to the nearest point at the previous place that falls to the same side.
  const drawEdge = () => {
    const [at, stays, falls] = data.edge, places = [...new Set(at)];
    const byPlace = new Map(places.map((x) => [x, []]));
    at.forEach((x, i) => byPlace.get(x).push({ y: stays[i], isUp: falls[i] > stays[i] }));
    const reach = 0.03 * (whole[1][1] - whole[1][0]);
    for (const [look, thick] of [[colours.page, 3.6], [colours.ink, 1.6]]) {
      places.forEach((x, i) => {
        for (const p of byPlace.get(x)) {
          const others = i ? byPlace.get(places[i - 1]).filter((q) => q.isUp === p.isUp) : [];
          const near = others.sort((a, b) => Math.abs(a.y - p.y) - Math.abs(b.y - p.y))[0];
          const from = near && Math.abs(near.y - p.y) < reach ? toScreen(places[i - 1], near.y) : null;
          const [px, py] = toScreen(x, p.y);
          line([from || [px - 0.7, py], [px, py]], look, thick);
        }
      });
    }
  };
  const drawStable = () => {
    for (const curve of data.stable.curves) {
      const points = curve.map((p) => toScreen(...p));
      line(points, colours.page, 3.4); line(points, colours.ink, 1.2, [5, 4]);
    }
    for (const curve of data.energy) line(curve.map((p) => toScreen(...p)), colours.ink, 1.3, [1.3, 3.2]);
  };
  const nameStable = () => {
    const [w] = size(), [from, to] = view[0], text = "linearly stable";
    for (const [low, high] of data.stable.ranges) {
      const seen = [low, high === null ? Infinity : high].map((v) => Math.min(Math.max(v, from), to));
      if (seen[0] >= seen[1]) continue;
      const [a, b] = seen.map((v) => toScreen(v, 0)[0]), half = context.measureText(text).width / 2;
      line([[a, ROOM.top - 4], [b, ROOM.top - 4]], colours.ink, 2.2);
      context.textAlign = "center"; context.fillStyle = colours.ink; context.textBaseline = "alphabetic";
      context.fillText(text, Math.min(Math.max((a + b) / 2, ROOM.left + 130), ROOM.left + w - half), ROOM.top - 9);
    }
  };
  // A region is named where it is widest: the cell farthest from any other fate.
  const drawNames = () => {
    if (shown !== "fate") return;
    const [i0, i1] = view[0].map((v) => cell(0, v)), [j0, j1] = view[1].map((v) => cell(1, v));
    const w = i1 - i0 + 1, h = j1 - j0 + 1, [pw, ph] = size();
    const dx = pw / w, dy = ph / h, far = new Float64Array(w * h).fill(1e9);
    const own = (i, j) => fate[(i0 + i) * rows + j0 + j];
    const take = (i, j, a, b) => {
      const isOut = a < 0 || b < 0 || a >= w || b >= h;
      const step = Math.hypot((a - i) * dx, (b - j) * dy);
      const other = isOut || own(a, b) !== own(i, j) ? 0 : far[a * h + b];
      far[i * h + j] = Math.min(far[i * h + j], other + step);
    };
    const pass = (d) => {
      for (let a = 0; a < w; a++) {
        for (let b = 0; b < h; b++) {
          const i = d > 0 ? a : w - 1 - a, j = d > 0 ? b : h - 1 - b;
          take(i, j, i - d, j); take(i, j, i, j - d); take(i, j, i - d, j - d); take(i, j, i - d, j + d);
        }
      }
    };
    pass(1); pass(-1);
    data.fates.forEach((name, f) => {
      let best = -1;
      for (let at = 0; at < far.length; at++) {
        if (own(Math.floor(at / h), at % h) === f && (best < 0 || far[at] > far[best])) best = at;
      }
      context.textAlign = "center"; context.textBaseline = "middle";
      if (best < 0 || far[best] < 16) return;
      const half = context.measureText(name).width / 2;
      const x = ROOM.left + (Math.floor(best / h) + 0.5) * dx, y = ROOM.top + ph - (best % h + 0.5) * dy;
      if (half > 1.8 * far[best]) return;
      halo(name, Math.min(Math.max(x, ROOM.left + half + 3), ROOM.left + pw - half - 3), y);
    });
  };
  const drawMarks = () => {
    context.textBaseline = "middle"; context.textAlign = "center";
    const reach = 9;
    for (const m of data.marks) {
      if (!isInside(m.x, m.y)) continue;
      const [x, y] = toScreen(m.x, m.y);
      context.beginPath(); context.arc(x, y, reach, 0, 7);
      context.fillStyle = colours.page; context.fill();
      context.strokeStyle = colours.ink; context.lineWidth = 1.4; context.stroke();
      context.fillStyle = colours.ink; context.fillText(m.text, x, y + 0.5);
    }
  };
  const drawChosen = () => {
    if (!isInside(...chosen)) return;
    const [x, y] = toScreen(...chosen), [w, h] = size();
    for (const [look, thick] of [[colours.page, 3.4], [colours.ink, 1.4]]) {
      const gap = 13;
      line([[x, ROOM.top], [x, Math.max(y - gap, ROOM.top)]], look, thick);
      line([[x, Math.min(y + gap, ROOM.top + h)], [x, ROOM.top + h]], look, thick);
      line([[ROOM.left, y], [Math.max(x - gap, ROOM.left), y]], look, thick);
      line([[Math.min(x + gap, ROOM.left + w), y], [ROOM.left + w, y]], look, thick);
      context.beginPath(); context.arc(x, y, gap, 0, 7); context.stroke();
    }
  };
  const draw = () => {
    if (!width) return;
    if (!picture) paint();
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.putImageData(picture, Math.round(ROOM.left * ratio), Math.round(ROOM.top * ratio));
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.font = "12.5px system-ui, 'Liberation Sans', Arial, sans-serif";
    const [w, h] = size();
    context.save();
    context.beginPath(); context.rect(ROOM.left, ROOM.top, w, h); context.clip();
    drawEdge(); drawStable();
    context.restore();
    nameStable(); drawChosen(); drawNames(); drawMarks(); drawAxes();
  };
  let isWaiting = false;
  const ask = () => {
    if (isWaiting) return;
    isWaiting = true;
    requestAnimationFrame(() => { isWaiting = false; draw(); });
  };

  // ---- legend
  const css = (c) => `rgb(${c.map(Math.round).join(",")})`;
  const short = (x) => {
    if (x === 0) return "0";
    const isPlain = Math.abs(x) < 1e5 && Math.abs(x) >= 1e-4;
    return (isPlain ? String(Number(x.toPrecision(3))) : x.toExponential(1).replace("e+", "e")).replaceAll("-", "−");
  };
  const withUnit = (x, unit) => unit ? `${short(x)} ${unit}` : short(x);
  const drawKey = () => {
    drawColours();
    const named = (look, text) => {
      const item = made("li", key.querySelector("ul"));
      made("span", item, "", look);
      item.append(` ${text}`);
    };
    if (data.stable.curves.length && !data.stable.ranges.length) named("dashes", "ends of the linearly stable speeds");
    if (data.energy.length) named("dots", "energy of straight running at the ends of the stable range");
  };
  const drawColours = () => {
    key.textContent = "";
    if (shown === "fate") {
      const list = made("ul", key, "", "legend"), counts = data.fates.map(() => 0);
      for (const f of fate) counts[f]++;
      data.fates.forEach((name, i) => {
        if (!counts[i]) return;
        const item = made("li", list);
        const isFall = i === data.falls && longest > SOONEST, ends = colours.falls.map(css);
        made("span", item, "", isFall ? "patch wide" : "patch").style.background = isFall ? `linear-gradient(90deg, ${ends})` : css(colours.fates[i]);
        const part = 100 * counts[i] / fate.length;
        item.append(` ${name} `);
        made("i", item, `${part < 0.95 ? "<1" : part.toFixed(0)} %${isFall ? `, after ${SOONEST} to ${short(longest)} s` : ""}`);
      });
      return;
    }
    const q = data.quantities[shown], bar = made("canvas", key, "", "bar"), ends = made("div", key, "", "ends");
    bar.width = 256; bar.height = 1;
    bar.setAttribute("role", "img");
    bar.setAttribute("aria-label", `Colours of the ${q.title}`);
    const c = bar.getContext("2d");
    for (let i = 0; i < 256; i++) { c.fillStyle = css(scaled(i / 255)); c.fillRect(i, 0, 1, 1); }
    const value = (part) => { const x = range[0] + part * (range[1] - range[0]); return q.isLog ? 10 ** x : x; };
    for (const part of [0, 0.25, 0.5, 0.75, 1]) made("span", ends, short(value(part)));
    const list = made("ul", key, "", "legend");
    made("li", list, q.unit ? `${q.title} [${q.unit}]` : q.title);
    const patch = (c, text) => { const item = made("li", list); made("span", item, "", "patch").style.background = css(c); item.append(` ${text}`); };
    if (!isTime()) patch(colours.fates[data.falls], data.fates[data.falls]);
    else patch(colours.none, "none");
  };

  // ---- words
  const degrees = (x) => `${short(x)} rad (${short(x * 180 / Math.PI)}°)`;
  const WHEELS = ["", "rear", "front"];
  const placeWords = (x, y, digits = 4) => [[across, x], [along, y]].map(([a, v]) => `${minus(String(Number(v.toPrecision(digits))))} ${a.unit === "1" ? "" : a.unit}`.trim()).join(", ");
  const fateWords = (i) => {
    const at = (name) => data.quantities[name] ? data.quantities[name].at(i) : NaN, parts = [];
    const say = (name, text) => { const x = at(name); if (!Number.isNaN(x)) parts.push(text(x)); };
    say("final_speed", (x) => `final speed ${short(x)} m/s`);
    say("largest_lean", (x) => `largest lean ${degrees(x)}`);
    say("largest_steer", (x) => `largest steer ${degrees(x)}`);
    say("lift_time", (x) => `the ${WHEELS[wheel[i]] || "a"} wheel would lift after ${short(x)} s`);
    say("condition", (x) => `a small initial error grows at most ${short(x)}-fold within 10 s`);
    return parts.join("; ");
  };
  const headWords = (i) => {
    const time = data.quantities.fate_time ? data.quantities.fate_time.at(i) : NaN;
    return data.fates[fate[i]] + (Number.isNaN(time) ? "" : `${data.when[fate[i]]} ${short(time)} s`);
  };

  // ---- the chosen start, and its motion
  let chosen = [0, 0], show = null, seen = "";
  const nearest = (x, y) => [across.values[cell(0, x)], along.values[cell(1, y)]];
  const say = () => {
    const i = point(...chosen), near = nearest(...chosen);
    const isOn = chosen.every((v, k) => v === near[k]);
    said.textContent = "";
    if (isOn) {
      made("b", said, `${placeWords(...near)}: ${headWords(i)}. `);
      said.append(`${capital(fateWords(i))}. ${seen}`);
    } else {
      made("b", said, `${placeWords(...chosen, 8)}. `);
      said.append(seen);
      made("span", said, ` The nearest computed start, ${placeWords(...near)}: ${headWords(i)}; ${fateWords(i)}.`);
    }
  };
  // Limits on the duration of a replay [s]: without a fall SHORTEST to LONG; a fall is shown if it is before LONGEST.
  const SHORTEST = 10, LONG = 60, LONGEST = 1000;
  const motionOf = ([x, y]) => {
    const time = data.quantities.fate_time ? data.quantities.fate_time.at(point(x, y)) : NaN;
    const falls = fate[point(x, y)] === data.falls;
    // The chosen point may fall later than the nearest computed one.
    const wanted = falls ? 1.5 * time + 5 : time + 1, end = Math.min(Math.max(wanted || 0, SHORTEST), falls ? LONGEST : LONG);
    return follow({ ...data.start, [across.name]: x, [along.name]: y }, end);
  };
  // Interpolates linearly between two drawings of the bicycle.
  const between = (a, b, part) => {
    if (typeof a === "number") return a + part * (b - a);
    if (typeof a !== "object") return a;
    const found = Array.isArray(a) ? [] : {};
    for (const name in a) found[name] = between(a[name], b[name], part);
    return found;
  };
  const drawn = () => data.axes.reduce((shapes, axis, k) => {
    if (shapes.length === 1) return shapes[0];
    const { values } = axis, last = shapes.length - 1;
    const at = last * (chosen[k] - values[0]) / (values[values.length - 1] - values[0]), i = Math.min(Math.floor(at), last - 1);
    return between(shapes[i], shapes[i + 1], at - i);
  }, data.shapes);
  const NAMES = {
    yaw: "yaw", pitch: "pitch", roll: "roll", steer: "steer", speed: "speed", track: "track", x: "rear_contact_x", y: "rear_contact_y",
    front_x: "front_x", front_y: "front_y", rear_wheel: "rear_wheel_angle", front_wheel: "front_wheel_angle",
  };
  const replayed = () => {
    const motion = motionOf(chosen);
    if (!motion || motion.columns.roll.length < 2) {
      seen = "There is nothing to replay: the equations end at this start.";
      return null;
    }
    const c = motion.columns, largest = (values) => values.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
    const lifts = ["rear", "front"].map((w) => [w, c[`${w}_normal`].findIndex((force) => force < 0)]).filter(([, i]) => i >= 0);
    lifts.sort((a, b) => a[1] - b[1]);
    const time = (i) => (i * FRAME).toFixed(2);
    seen = `Replay of ${motion.duration.toFixed(2)} s, integrated here: largest lean ${degrees(largest(c.roll))}`;
    if (lifts.length) seen += `; the floor would have to pull the ${lifts[0][0]} wheel from ${time(lifts[0][1])} s on`;
    if (motion.falls) seen += `; it falls and ends with roll ${degrees(c.roll.at(-1))} and steer ${degrees(c.steer.at(-1))}`;
    seen += ".";
    drawCharts(one(".plots"), motion);
    const scene = { number: 1, duration: motion.duration, columns: {}, result: null };
    for (const name in NAMES) scene.columns[name] = c[NAMES[name]];
    return scene;
  };

  const select = ([x, y], isReplayed) => {
    chosen = [[x, 0], [y, 1]].map(([v, k]) => {
      const { values } = data.axes[k];
      return Math.min(Math.max(v, values[0]), values[values.length - 1]);
    });
    start.elements.x.value = String(Number(chosen[0].toPrecision(12)));
    start.elements.y.value = String(Number(chosen[1].toPrecision(12)));
    seen = "";
    if (isReplayed && one(".stage")) {
      const scene = replayed();
      if (scene && show) show([scene], drawn());
      else if (scene) show = replay({ bicycle: drawn(), maneuvers: [scene], heading: "value" });
      history.replaceState(null, "", `#at=${chosen.map(Number).join(",")}`);
    }
    say();
    ask();
  };
  const readAddress = () => {
    const found = (new URLSearchParams(location.hash.slice(1)).get("at") || "").split(",").map(Number);
    if (found.length !== 2 || !found.every(Number.isFinite)) return false;
    const hash = location.hash;
    select(found, true);
    history.replaceState(null, "", hash);
    return true;
  };

  // ---- input
  const place = (event) => { const box = canvas.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
  const isOnMap = ([px, py]) => { const [w, h] = size(); return px >= ROOM.left && px <= ROOM.left + w && py >= ROOM.top && py <= ROOM.top + h; };
  const hover = (event) => {
    const at = place(event);
    if (!isOnMap(at)) { under.textContent = HINT; return; }
    const [x, y] = fromScreen(...at), i = point(x, y), [a, b] = nearest(x, y);
    under.textContent = `${placeWords(a, b)}: ${headWords(i)}; ${fateWords(i)}`;
  };
  const setView = (next) => {
    view = next.map(([a, b], k) => {
      const [low, high] = whole[k], wide = Math.min(b - a, high - low);
      const from = Math.min(Math.max(a, low), high - wide);
      return [from, from + wide];
    });
    picture = null;
    ask();
  };
  const zoom = (by, [x, y]) => {
    const least = 4;  // smallest number of cells across the view
    if (by < 1 && (view[0][1] - view[0][0]) / (whole[0][1] - whole[0][0]) * columns * by < least) return;
    setView(by === 0 ? whole : [x, y].map((v, k) => view[k].map((end) => v + by * (end - v))));
  };
  // Returns the nearest computed start, or the exact position if cells are at least 10 px wide.
  const underPointer = (at) => {
    const [x, y] = fromScreen(...at), [w, h] = size();
    const wide = Math.min(w / columns * (whole[0][1] - whole[0][0]) / (view[0][1] - view[0][0]), h / rows * (whole[1][1] - whole[1][0]) / (view[1][1] - view[1][0]));
    return wide < 10 ? nearest(x, y) : [x, y].map((v) => Number(v.toPrecision(6)));
  };
  let grip = null;
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    grip = { at: place(event), view, isMoved: false };
    if (event.pointerType === "mouse") canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    hover(event);
    if (!grip) return;
    const [px, py] = place(event), [w, h] = size(), dx = px - grip.at[0], dy = py - grip.at[1];
    if (Math.hypot(dx, dy) > 5) grip.isMoved = true;
    if (!grip.isMoved) return;
    const [x, y] = grip.view, a = dx / w * (x[1] - x[0]), b = dy / h * (y[1] - y[0]);
    setView([[x[0] - a, x[1] - a], [y[0] + b, y[1] + b]]);
  });
  canvas.addEventListener("pointerup", (event) => {
    const at = place(event);
    if (grip && !grip.isMoved && isOnMap(at)) {
      const mark = data.marks.find((m) => Math.hypot(...toScreen(m.x, m.y).map((v, k) => v - at[k])) < 10);
      select(mark ? [mark.x, mark.y] : underPointer(at), true);
    }
    grip = null;
  });
  canvas.addEventListener("pointercancel", () => { grip = null; });
  under.textContent = HINT;
  canvas.addEventListener("pointerleave", () => { under.textContent = HINT; });
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey) return;  // without Ctrl the wheel scrolls the page
    event.preventDefault();
    zoom(event.deltaY > 0 ? 1.25 : 0.8, fromScreen(...place(event)));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const by = event.shiftKey ? 10 : 1;
    const step = { ArrowLeft: [-by, 0], ArrowRight: [by, 0], ArrowUp: [0, by], ArrowDown: [0, -by] }[event.key];
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (step) {
      const to = chosen.map((v, k) => {
        const { values } = data.axes[k];
        return values[Math.min(Math.max(cell(k, v) + step[k], 0), values.length - 1)];
      });
      select(to, false);
      if (!isInside(...chosen)) setView(view.map(([a, b], k) => [chosen[k] - (b - a) / 2, chosen[k] + (b - a) / 2]));
    } else if (event.key === "Enter") select(chosen, true);
    else if (event.key === "+" || event.key === "-") zoom(event.key === "+" ? 0.5 : 2, chosen);
    else if (event.key === "0") zoom(0, chosen);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  choose.addEventListener("change", () => { shown = choose.elements.shown.value; recolour(); });
  choose.addEventListener("submit", (event) => event.preventDefault());
  for (const button of choose.querySelectorAll("[data-zoom]")) {
    button.addEventListener("click", () => zoom(Number(button.dataset.zoom), isInside(...chosen) ? chosen : view.map(([a, b]) => (a + b) / 2)));
  }
  start.addEventListener("submit", (event) => {
    event.preventDefault();
    select([start.elements.x, start.elements.y].map((box) => Number(box.value)), true);
  });
  for (const button of start.querySelectorAll("[data-mark]")) {
    button.addEventListener("click", () => { const m = data.marks[Number(button.dataset.mark)]; select([m.x, m.y], true); });
  }

  // ---- start
  const recolour = () => { readColours(); if (shown !== "fate") findRange(); picture = null; drawKey(); ask(); };
  const resize = () => {
    const box = canvas.getBoundingClientRect();
    ratio = Math.min(devicePixelRatio || 1, 2);
    [width, height] = [box.width, box.height];
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    picture = null;
    ask();
  };
  addEventListener("resize", resize);
  addEventListener("hashchange", readAddress);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", recolour);
  recolour();
  resize();
  const first = data.marks[1] || data.marks[0];
  const middle = [across, along].map((a) => a.values[a.values.length >> 1]);
  if (!readAddress()) select(first ? [first.x, first.y] : middle, true);
  draw();
})();

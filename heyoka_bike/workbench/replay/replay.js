"use strict";
// Draws the scene and advances the time. World and body axes: x forward, y to the right, z down [m].
// Returns a function that replaces the given maneuvers with others; its `goTo` chooses a maneuver
// and a time. If `data.isPart` is true, the stage is a part of a page: it starts paused, ignores the
// address, and handles keys only inside the stage. `data.timeShown` is called with the maneuver and the
// fraction of its duration that are shown.
const replay = (data) => {
  let { points: P, radii, tilt, solids } = data.bicycle;
  const FAR_ANGLE = 1.15;  // limit of an exaggerated roll or steer [rad]
  const FAR_PLACE = 3;     // limit of a magnified difference [m, rad]
  const NEAR = 0.12;       // smallest depth that is drawn [m]
  const one = (selector) => document.querySelector(selector);
  const all = (selector) => [...document.querySelectorAll(selector)];
  const form = one("form.controls"), canvas = one(".view canvas"), slider = form.elements.t;
  const play = one(".play"), clock = one(".clock"), table = one(".values"), warning = one(".scale");
  const still = matchMedia("(prefers-reduced-motion: reduce)");

  // ---- vectors and attitudes (a matrix is an array of its three columns)
  const add = (a, b, k = 1) => [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => { const n = Math.hypot(...a); return a.map((x) => x / n); };
  const turned = (m, p) => [0, 1, 2].map((i) => m[0][i] * p[0] + m[1][i] * p[1] + m[2][i] * p[2]);
  const times = (m, n) => n.map((column) => turned(m, column));
  const turn = (axis, angle) => {
    const m = [[1, 0, 0], [0, 1, 0], [0, 0, 1]], i = (axis + 1) % 3, j = (axis + 2) % 3;
    m[i][i] = m[j][j] = Math.cos(angle); m[i][j] = Math.sin(angle); m[j][i] = -m[i][j];
    return m;
  };
  const lowest = (axle) => unit(add([0, 0, 1], axle, -axle[2]));

  // ---- the bicycle from its angles: rigid motion only
  const pose = (s) => {
    const heading = times(turn(2, s.yaw), turn(0, s.roll));
    const fork = times(turn(1, tilt), times(turn(2, s.steer), turn(1, -tilt)));
    const posed = (pitch) => {
      const rear = times(heading, turn(1, pitch));
      const front = times(rear, fork);
      const hub = add([s.x, s.y, 0], heading[2], -radii[0]);
      const at = add(hub, turned(rear, add(P.P2, P.P1, -1)));
      const frontHub = add(at, turned(front, add(P.P3, P.P2, -1)));
      return { rear, front, hub, frontHub, heading };
    };
    const gap = (b) => add(b.frontHub, lowest(b.front[1]), radii[1])[2];
    let pitch = s.pitch;
    if (s.isChanged) {  // both wheels on the floor
      for (let i = 0; i < 4; i++) {
        const here = gap(posed(pitch)), slope = (gap(posed(pitch + 1e-5)) - here) / 1e-5;
        pitch -= here / slope;
      }
    }
    const b = posed(pitch);
    b.state = s;
    b.place = (body, p) => body === "rear"
      ? add(b.hub, turned(b.rear, add(p, P.P1, -1)))
      : add(b.frontHub, turned(b.front, add(p, P.P3, -1)));
    b.contact = [s.x, s.y, 0];
    b.frontContact = add(b.frontHub, lowest(b.front[1]), radii[1]);
    return b;
  };

  // ---- values between frames: cubic interpolation through four frames
  const between = (values, at) => {
    const last = values.length - 1;
    const i = Math.min(Math.max(Math.floor(at), 0), Math.max(last - 1, 0)), u = at - i;
    const b = values[i], c = values[Math.min(i + 1, last)];
    const a = i > 0 ? values[i - 1] : 2 * b - c, d = i + 2 <= last ? values[i + 2] : 2 * c - b;
    return b + u * (c - a + u * (2 * a - 5 * b + 4 * c - d + u * (3 * (b - c) + d - a))) / 2;
  };
  const sampled = (columns, at) => {
    const found = {};
    for (const name in columns) found[name] = between(columns[name], at);
    return found;
  };

  // ---- what is shown
  let scene = data.maneuvers[0], t = 0, isPlaying = false, before = null;
  const frames = () => scene.columns.yaw.length - 1;
  const frame = () => t / scene.duration * frames();
  const chosen = (name) => form.elements[name] ? form.elements[name].value : "";
  const isShown = (name) => Boolean(form.elements[name] && form.elements[name].checked);
  const exaggerated = () => Number(chosen("exaggerate"));
  const magnified = () => Number(chosen("magnify") || 1);
  const largest = (values) => values.reduce((most, x) => Math.max(most, Math.abs(x)), 0);

  const resultAt = (exact) => {
    const r = scene.result;
    if (!r) return null;
    const at = frame() - r.first, last = r.differences.yaw.length - 1;
    if (at < -1e-9 || at > last + 1e-9) return null;
    return sampled(r.differences, at);
  };
  const exaggerate = (s, isChanged) => {
    const k = exaggerated();
    return { ...s, roll: k * s.roll, steer: k * s.steer, isChanged: isChanged || k !== 1 };
  };
  const moved = (exact, difference) => {
    const k = magnified(), found = { ...exact };
    for (const name in difference) found[name] += k * difference[name];
    return exaggerate(found, true);
  };

  // ---- colours
  let colours = {};
  const readColours = () => {
    const style = getComputedStyle(document.documentElement);
    for (const name of ["sky", "ground", "line", "tyre", "metal", "dark", "skin", "shirt", "shorts", "helmet",
      "mine", "blue", "ink", "soft", "page", "green", "link", "ghost"]) {
      colours[name] = style.getPropertyValue(`--${name}`).trim();
    }
    const named = (name) => name.startsWith("var(") ? style.getPropertyValue(name.slice(4, -1)).trim() : name;
    for (const name in colours) colours[name] = named(colours[name]);
    colours.frame = colours.mine;
  };
  const mixed = (colour, other, part) => {
    const hex = (c) => [1, 3, 5].map((i) => parseInt(c.slice(i, i + 2), 16));
    const a = hex(colour), b = hex(other);
    return `rgb(${a.map((x, i) => Math.round(x + part * (b[i] - x))).join(",")})`;
  };

  // ---- camera: orbits a point of the bicycle at the chosen angles and distance
  const CAMERAS = {
    follow: { turn: 2.2, lift: 0.22, far: 3.6 }, side: { turn: Math.PI / 2, lift: 0.06, far: 3.6 },
    behind: { turn: Math.PI, lift: 0.17, far: 3.6 }, above: { turn: Math.PI, lift: 1.45, far: 4.2 }, rider: { turn: 0, lift: 0.52, far: 0 },
  };
  const camera = { ...CAMERAS.follow };
  let width = 0, height = 0, context = canvas.getContext("2d");
  const ghost = document.createElement("canvas");
  let eye, right, up, ahead, focus, middle;

  const look = (b) => {
    middle = add(add(b.contact, b.frontContact), [0, 0, -1.58 * Math.max(P.B[2] / -0.9, 0.5)]).map((x) => x / 2);
    const isRider = chosen("camera") === "rider";
    if (isRider) {
      const c = Math.cos(camera.lift), s = Math.sin(camera.lift);
      const aside = [Math.cos(camera.turn), Math.sin(camera.turn)];
      eye = b.place("rear", P.eye);
      ahead = turned(b.rear, [c * aside[0], c * aside[1], s]);
      right = turned(b.rear, [-aside[1], aside[0], 0]);
    } else {
      const angle = b.state.yaw + camera.turn, c = Math.cos(camera.lift);
      const away = [c * Math.cos(angle), c * Math.sin(angle), -Math.sin(camera.lift)];
      eye = add(middle, away, camera.far);
      // Keep the camera above the ground.
      eye[2] = Math.min(eye[2], -0.08);
      ahead = unit(add(middle, eye, -1));
      right = [Math.sin(angle), -Math.cos(angle), 0];
    }
    up = cross(right, ahead);
    const opening = isRider ? 1.4 : 0.62;
    focus = Math.min(height, 0.86 * width) / 2 / Math.tan(opening / 2);
  };
  // `viewed` returns right, down and depth [m]; `seen` the position on the screen and pixels per metre there.
  const viewed = (p) => { const d = add(p, eye, -1); return [dot(d, right), -dot(d, up), dot(d, ahead)]; };
  const seen = (v) => { const k = focus / v[2]; return [width / 2 + k * v[0], height / 2 + k * v[1], k]; };

  // ---- drawing
  const CIRCLE = Array.from({ length: 14 }, (_, i) => [Math.cos(i * Math.PI / 7), Math.sin(i * Math.PI / 7)]);
  const hull = (found) => {
    found.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    const half = (list) => {
      const kept = [];
      for (const p of list) {
        while (kept.length > 1) {
          const [a, b] = kept.slice(-2);
          if ((b[0] - a[0]) * (p[1] - a[1]) > (b[1] - a[1]) * (p[0] - a[0])) break;
          kept.pop();
        }
        kept.push(p);
      }
      kept.pop();
      return kept;
    };
    return [...half(found), ...half(found.reverse())];
  };
  const outline = (c, corners) => {
    corners.forEach((p, i) => (i ? c.lineTo(p[0], p[1]) : c.moveTo(p[0], p[1])));
    c.closePath();
  };
  const clipped = (a, b) => {
    if (a[2] < NEAR && b[2] < NEAR) return null;
    const cut = (p, q) => {
      const k = (NEAR - p[2]) / (q[2] - p[2]);
      return [p[0] + k * (q[0] - p[0]), p[1] + k * (q[1] - p[1]), NEAR];
    };
    return [a[2] < NEAR ? cut(a, b) : a, b[2] < NEAR ? cut(b, a) : b];
  };
  const segment = (c, a, b) => {
    const ends = clipped(viewed(a), viewed(b));
    if (!ends) return;
    const [p, q] = ends.map(seen);
    c.moveTo(p[0], p[1]);
    c.lineTo(q[0], q[1]);
  };

  const drawGround = (c) => {
    c.fillStyle = colours.sky;
    c.fillRect(0, 0, width, height);
    const reach = 400, corners = [];
    const square = [[1, 1], [1, -1], [-1, -1], [-1, 1]].map(([x, y]) => viewed([eye[0] + reach * x, eye[1] + reach * y, 0]));
    square.forEach((a, i) => {
      const ends = clipped(a, square[(i + 1) % 4]);
      if (ends) corners.push(...ends.map(seen));
    });
    if (corners.length) {
      c.beginPath();
      outline(c, corners);
      c.fillStyle = colours.ground;
      c.fill();
    }
    // Lines 1 m apart that fade with the distance.
    const most = 24, chunk = 2, shades = 8, x0 = Math.round(middle[0]), y0 = Math.round(middle[1]);
    const paths = Array.from({ length: 2 * shades }, () => new Path2D());
    const lay = (a, b, isFifth) => {
      const away = Math.hypot((a[0] + b[0]) / 2 - middle[0], (a[1] + b[1]) / 2 - middle[1]);
      const shade = Math.floor(shades * (1 - away / most));
      if (shade >= 0) segment(paths[2 * Math.min(shade, shades - 1) + isFifth], a, b);
    };
    for (let i = -most; i <= most; i++) {
      for (let j = -most; j < most; j += chunk) {
        lay([x0 + i, y0 + j, 0], [x0 + i, y0 + j + chunk, 0], Number((x0 + i) % 5 === 0));
        lay([x0 + j, y0 + i, 0], [x0 + j + chunk, y0 + i, 0], Number((y0 + i) % 5 === 0));
      }
    }
    c.strokeStyle = colours.line;
    paths.forEach((path, i) => {
      c.globalAlpha = (Math.floor(i / 2) + 1) / shades;
      c.lineWidth = i % 2 ? 1.8 : 0.9;
      c.stroke(path);
    });
    c.globalAlpha = 1;
    c.beginPath();
    for (let x = Math.max(x0 - 15, -1); x < x0 + 18; x += 0.5) segment(c, [x, 0, 0], [x + 0.25, 0, 0]);
    c.strokeStyle = colours.soft;
    c.lineWidth = 1;
    c.stroke();
  };

  const drawTrack = (c, xs, ys, colour, dash, until, plus) => {
    const count = xs.length, step = scene.duration / frames();
    c.strokeStyle = colour;
    c.setLineDash(dash);
    const stretch = (from, to, alpha, thick) => {
      if (to - from < 1e-6) return;
      c.beginPath();
      let a = [plus(xs, from, 0), plus(ys, from, 1), 0];
      for (let i = Math.floor(from) + 1; i < to + 1; i++) {
        const b = [plus(xs, Math.min(i, to), 0), plus(ys, Math.min(i, to), 1), 0];
        if (Math.hypot(b[0] - middle[0], b[1] - middle[1]) < 40) segment(c, a, b);
        a = b;
      }
      c.globalAlpha = alpha;
      c.lineWidth = thick;
      c.stroke();
    };
    const now = Math.min(Math.max(until, 0), count - 1);
    stretch(0, now, 1, 1.8);
    stretch(now, count - 1, 0.28, 1.2);
    c.globalAlpha = 1;
    c.setLineDash([]);
  };

  // Returns a point on the rim of a wheel, at an angle in the wheel's plane.
  const rim = (centre, attitude, radius, angle) => add(
    add(centre, attitude[0], radius * Math.cos(angle)), attitude[2], -radius * Math.sin(angle));
  const SUN = unit([0.25, 0.45, 1]);
  const onGround = (p) => add(p, SUN, -p[2] / SUN[2]);

  const drawShadow = (c, b) => {
    c.beginPath();
    const dropped = (spheres) => {
      const corners = [];
      for (const [p, r] of spheres) {
        const q = onGround(p);
        for (const [x, y] of CIRCLE) {
          const v = viewed([q[0] + r * x, q[1] + r * y, 0]);
          if (v[2] < NEAR) return;
          corners.push(seen(v));
        }
      }
      outline(c, hull(corners));
    };
    for (const s of solids) {
      if (s.part !== "bicycle" && !isShown("rider")) continue;
      dropped(s.spheres.map(([x, y, z, r]) => [b.place(s.body, [x, y, z]), r]));
    }
    for (const [hub, attitude, radius] of [[b.hub, b.rear, radii[0]], [b.frontHub, b.front, radii[1]]]) {
      for (let i = 0; i < 40; i++) {
        dropped([0, 1].map((k) => [rim(hub, attitude, radius - 0.016, (i + k) * Math.PI / 20), 0.014]));
      }
    }
    c.fillStyle = "#000";
    c.globalAlpha = 0.2;
    c.fill();
    c.globalAlpha = 1;
  };

  const drawSolid = (c, found, colour) => {
    const corners = [];
    for (const [v, r] of found) {
      const [x, y, k] = seen(v), size = Math.max(k * r, 0.7);
      for (const [a, d] of CIRCLE) corners.push([x + size * a, y + size * d]);
    }
    c.beginPath();
    outline(c, hull(corners));
    // Shade from light above, across the line between the first and the last sphere.
    const [p, q] = [found[0], found[found.length - 1]].map(([v, r]) => [...seen(v), r]);
    let nx = q[1] - p[1], ny = p[0] - q[0];
    const long = Math.hypot(nx, ny);
    if (long < 1) { nx = 0.45; ny = 0.9; } else { nx /= long; ny /= long; }
    if (ny < 0 || (ny === 0 && nx < 0)) { nx = -nx; ny = -ny; }
    const size = Math.max(...found.map(([v, r]) => focus / v[2] * r)) * (found.length > 2 ? 1.8 : 1);
    const x = (p[0] + q[0]) / 2, y = (p[1] + q[1]) / 2;
    const shade = c.createLinearGradient(x - nx * size, y - ny * size, x + nx * size, y + ny * size);
    shade.addColorStop(0, mixed(colour, "#ffffff", 0.32));
    shade.addColorStop(0.45, mixed(colour, "#ffffff", 0));
    shade.addColorStop(1, mixed(colour, "#000000", 0.38));
    c.fillStyle = shade;
    c.fill();
  };

  const drawWheel = (c, hub, attitude, radius, angle, own) => {
    const ring = (r, count) => Array.from({ length: count }, (_, i) => viewed(rim(hub, attitude, r, i * 2 * Math.PI / count)));
    const spokes = (from, to, colour, thick, length) => {
      c.beginPath();
      for (const [i, side] of from) {
        const start = add(rim(hub, attitude, length[0], angle + i), attitude[1], 0.028 * side);
        segment(c, start, rim(hub, attitude, length[1], angle + i));
      }
      c.strokeStyle = colour; c.lineWidth = thick; c.stroke();
    };
    const depth = viewed(hub)[2];
    if (depth < NEAR) return;
    const k = focus / depth, N = 18;
    const places = Array.from({ length: N }, (_, i) => [i * 2 * Math.PI / N, i % 2 ? 1 : -1]);
    spokes(places, 1, own || colours.metal, Math.max(0.005 * k, 0.6), [0.02, radius - 0.035]);
    // Two reflectors show how the wheel turns.
    spokes([[0.17, 0], [0.17 + Math.PI, 0]], 1, own || colours.shirt, Math.max(0.022 * k, 1.5), [0.62 * radius, 0.78 * radius]);
    c.lineCap = "round";
    for (const [r, thick, colour] of [[radius - 0.034, 0.014, own || colours.metal], [radius - 0.016, 0.032, own || colours.tyre]]) {
      const corners = ring(r, 60), near = Math.min(...corners.map((v) => v[2])), far = Math.max(...corners.map((v) => v[2]));
      c.strokeStyle = colour;
      if (near > NEAR && far < 1.15 * near) {  // nearly equal depth: one line width suffices
        c.beginPath();
        outline(c, corners.map(seen));
        c.lineWidth = Math.max(thick * k, 1);
        c.stroke();
        continue;
      }
      corners.forEach((a, i) => {
        const b = corners[(i + 1) % corners.length], ends = clipped(a, b);
        if (!ends) return;
        const [p, q] = ends.map(seen);
        c.beginPath(); c.moveTo(p[0], p[1]); c.lineTo(q[0], q[1]);
        c.lineWidth = Math.max(thick * (p[2] + q[2]) / 2, 1); c.stroke();
      });
    }
    c.lineCap = "butt";
  };

  const drawBicycle = (c, b, own) => {
    const isRider = chosen("camera") === "rider";
    const items = [
      [viewed(b.hub)[2], () => drawWheel(c, b.hub, b.rear, radii[0], b.state.rear_wheel, own)],
      [viewed(b.frontHub)[2], () => drawWheel(c, b.frontHub, b.front, radii[1], b.state.front_wheel, own)],
    ];
    for (const s of solids) {
      if (s.part !== "bicycle" && !isShown("rider")) continue;
      if (isRider && s.part === "head") continue;
      const found = s.spheres.map(([x, y, z, r]) => [viewed(b.place(s.body, [x, y, z])), r]);
      if (found.some(([v, r]) => v[2] - r < NEAR)) continue;
      const depth = found.reduce((sum, [v]) => sum + v[2], 0) / found.length;
      items.push([depth, () => drawSolid(c, found, own || colours[s.colour])]);
    }
    items.sort((p, q) => q[0] - p[0]);
    for (const [, draw] of items) draw();
  };

  const drawPoints = (c, b) => {
    const boxes = [];
    const axis = [b.place("front", P.foot), b.place("front", P.top)];
    c.beginPath();
    segment(c, ...axis);
    c.strokeStyle = colours.ink; c.lineWidth = 1.2; c.setLineDash([9, 3, 2, 3]); c.stroke(); c.setLineDash([]);
    const placed = [];
    for (const [name, p] of [["P1", b.hub], ["P3", b.frontHub], ["P2", b.place("front", P.P2)], ["B", b.place("rear", P.B)],
      ["", b.contact], ["", b.frontContact]]) {
      const v = viewed(p);
      if (v[2] < NEAR) continue;
      placed.push([name, ...seen(v)]);
    }
    for (const [name, x, y] of placed) {
      boxes.push([x - 7, y - 7, x + 7, y + 7]);
      c.lineWidth = 1.5;
      if (name === "B") {  // symbol of a centre of mass
        for (let i = 0; i < 4; i++) {
          c.beginPath(); c.moveTo(x, y); c.arc(x, y, 7, i * Math.PI / 2, (i + 1) * Math.PI / 2); c.closePath();
          c.fillStyle = i % 2 ? "#111" : "#fff"; c.fill();
        }
        c.beginPath(); c.arc(x, y, 7, 0, 7); c.strokeStyle = "#111"; c.stroke();
      } else {
        c.beginPath(); c.arc(x, y, name ? 4 : 3, 0, 7);
        c.fillStyle = name ? "#fff" : colours.ink; c.fill();
        c.strokeStyle = name ? "#111" : colours.page; c.stroke();
      }
    }
    c.font = "600 13px system-ui, 'Liberation Sans', Arial, sans-serif";
    c.textBaseline = "middle";
    c.lineJoin = "round";
    for (const [name, x, y] of placed) {
      if (!name) continue;
      const wide = c.measureText(name).width, tries = [[12, -14], [-12 - wide, -14], [12, 16], [-12 - wide, 16], [14, 0], [-14 - wide, 0], [12, -32], [12, 34]];
      const box = ([dx, dy]) => [x + dx - 2, y + dy - 8, x + dx + wide + 2, y + dy + 8];
      const isFree = (a) => a[0] > 0 && a[2] < width && boxes.every((o) => a[2] < o[0] || a[0] > o[2] || a[3] < o[1] || a[1] > o[3]);
      const at = tries.find((d) => isFree(box(d)));
      if (!at) continue;
      boxes.push(box(at));
      c.lineWidth = 4; c.strokeStyle = colours.page; c.globalAlpha = 0.85;
      c.strokeText(name, x + at[0], y + at[1]);
      c.globalAlpha = 1; c.fillStyle = colours.ink;
      c.fillText(name, x + at[0], y + at[1]);
    }
  };

  // Cut stripes out of the drawing, so that result and reference differ even without colours.
  const hatch = (c) => {
    c.globalCompositeOperation = "destination-out";
    c.beginPath();
    for (let x = -height; x < width; x += 8) { c.moveTo(x, height); c.lineTo(x + height, 0); }
    c.lineWidth = 2.5;
    c.stroke();
    c.globalCompositeOperation = "source-over";
  };
  const draw = () => {
    const exact = sampled(scene.columns, frame()), difference = resultAt(exact);
    const b = pose(exaggerate(exact, false));
    look(b);
    const ratio = canvas.width / width, c = context;
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    drawGround(c);
    if (isShown("tracks")) {
      const plain = (values, at) => between(values, at);
      drawTrack(c, scene.columns.x, scene.columns.y, colours.mine, [], frame(), plain);
      drawTrack(c, scene.columns.front_x, scene.columns.front_y, mixed(colours.mine, colours.ground, 0.35), [], frame(), plain);
      const r = scene.result;
      if (r && isShown("result")) {
        const k = magnified(), exactly = scene.columns, d = r.differences;
        for (const [x, y] of [["x", "y"], ["front_x", "front_y"]]) {
          const plus = (values, at, which) => {
            const name = which ? y : x;
            return between(exactly[name], at + r.first) + k * between(d[name], at);
          };
          drawTrack(c, d[x], d[y], colours.blue, [6, 4], frame() - r.first, plus);
        }
      }
    }
    drawShadow(c, b);
    const other = difference && isShown("result") ? pose(moved(exact, difference)) : null;
    const overlay = (alpha) => {
      c.setTransform(1, 0, 0, 1, 0, 0);
      c.globalAlpha = alpha;
      c.drawImage(ghost, 0, 0);
      c.globalAlpha = 1;
      c.setTransform(ratio, 0, 0, ratio, 0, 0);
    };
    if (other) {
      const g = ghost.getContext("2d");
      if (ghost.width !== canvas.width || ghost.height !== canvas.height) { ghost.width = canvas.width; ghost.height = canvas.height; }
      g.setTransform(1, 0, 0, 1, 0, 0);
      g.clearRect(0, 0, ghost.width, ghost.height);
      g.setTransform(ratio, 0, 0, ratio, 0, 0);
      drawBicycle(g, other, colours.blue);
      hatch(g);
      overlay(0.6);
    }
    drawBicycle(c, b, null);
    // Faint on top of the reference, whose colours then dominate where the two agree.
    if (other) overlay(0.35);
    if (isShown("points")) drawPoints(c, b);
    write(exact, difference);
  };

  // ---- values in words
  const COLUMNS = [["roll", "roll", "rad", 4], ["steer", "steer", "rad", 4], ["yaw", "yaw", "rad", 4], ["speed", "speed", "m/s", 4], ["track", "track", "m", 2]];
  let cells = {};
  const makeTable = () => {
    const made = (tag, text, parent) => { const x = document.createElement(tag); x.textContent = text; return parent.appendChild(x); };
    table.textContent = "";
    cells = {};
    const head = made("tr", "", made("thead", "", table)), body = made("tbody", "", table);
    const hasResult = data.maneuvers.some((m) => m.result), kinds = hasResult ? ["reference", "result", "difference"] : ["reference"];
    const said = hasResult ? kinds : [data.heading || "reference"];
    made("td", "", head);
    for (const text of said) made("th", text, head).scope = "col";
    for (const kind of kinds) cells[kind] = [];
    for (const [, said, of] of COLUMNS) {
      const tr = made("tr", "", body);
      made("th", `${said} [${of}]`, tr).scope = "row";
      for (const kind of kinds) cells[kind].push(made("td", "", tr));
    }
  };
  const fixed = (x, digits) => x.toFixed(digits).replace(/^-(0\.?0*)$/, "$1").replace("-", "−");
  const short = (x) => x === 0 ? "0" : x.toExponential(1).replace("-", "−").replace("e-", "e−").replace("e+", "e");
  // A difference that the digits of the file cannot resolve is shown as zero. Yaw follows from the angles and
  // the track from the speed, so they have the resolution of these.
  const resolved = (name, d) => {
    const { roll = 0, steer = 0, speed = 0 } = scene.result.resolution;
    const least = { roll, steer, speed, yaw: Math.max(roll, steer), track: speed }[name];
    return Math.abs(d) <= least ? 0 : d;
  };
  const write = (exact, difference) => {
    COLUMNS.forEach(([name, , , digits], i) => {
      cells.reference[i].textContent = fixed(exact[name], digits);
      if (!cells.result) return;
      const d = difference ? difference[name] : undefined;
      const isThere = d !== undefined;
      cells.result[i].textContent = isThere ? fixed(exact[name] + d, digits) : "–";
      cells.difference[i].textContent = isThere ? short(resolved(name, d)) : "–";
    });
    clock.textContent = `${t.toFixed(2)} s`;
    if (document.activeElement !== slider || isPlaying) slider.value = t;
    slider.setAttribute("aria-valuetext", `${t.toFixed(2)} s`);
    const place = `${100 * t / scene.duration}%`;
    for (const line of cursors) { line.setAttribute("x1", place); line.setAttribute("x2", place); }
    if (data.timeShown) data.timeShown(scene.number, t / scene.duration);
    const said = [];
    if (exaggerated() !== 1) said.push(`roll and steer drawn ×${exaggerated()}`);
    if (magnified() !== 1 && isShown("result")) said.push(`difference drawn ×${magnified()}`);
    warning.textContent = said.join("; ");
    warning.hidden = !said.length;
  };

  // ---- time
  let isWaiting = false, cursors = [];
  const ask = () => { if (!isWaiting) { isWaiting = true; requestAnimationFrame(tick); } };
  const tick = (now) => {
    isWaiting = false;
    if (isPlaying) {
      // A page that was hidden continues where it stopped.
      if (before !== null) t += Math.min((now - before) / 1000, 0.1) * Number(chosen("speed"));
      before = now;
      if (t >= scene.duration) { t = scene.duration; setPlaying(false); }
    }
    draw();
    if (isPlaying) ask();
  };
  const setPlaying = (is) => {
    isPlaying = is;
    before = null;
    play.textContent = is ? "❚❚" : "▶";
    play.setAttribute("aria-label", is ? "Pause" : "Play");
  };
  const toggle = () => {
    if (!isPlaying && t >= scene.duration) t = 0;
    setPlaying(!isPlaying);
    ask();
  };
  const goTo = (time) => { t = Math.min(Math.max(time, 0), scene.duration); ask(); };
  const stepBy = (count) => {
    setPlaying(false);
    goTo((Math.round(frame()) + count) * scene.duration / frames());
  };

  const setManeuver = (number) => {
    const found = data.maneuvers.find((m) => m.number === number);
    if (!found) return;
    scene = found;
    t = 0;
    slider.max = scene.duration;
    form.elements.maneuver.value = String(number);
    for (const part of all("[data-maneuver]")) part.classList.toggle("current", Number(part.dataset.maneuver) === number);
    const most = Math.max(largest(scene.columns.roll), largest(scene.columns.steer));
    for (const radio of all('input[name="exaggerate"]')) {
      radio.disabled = radio.value !== "1" && Number(radio.value) * most > FAR_ANGLE;
      radio.parentElement.title = radio.disabled ? "more than the drawing can show here" : "";
      if (radio.disabled && radio.checked) form.elements.exaggerate.value = "1";
    }
    const menu = form.elements.magnify;
    if (menu) {
      const d = scene.result ? scene.result.differences : {};
      const far = ["x", "y", "yaw", "roll", "steer"].reduce((sum, name) => Math.max(sum, largest(d[name] || [])), 0);
      menu.textContent = "";
      for (let k = 1; k <= 1e9 && (k === 1 || k * far <= FAR_PLACE) && (far > 0 || k === 1); k *= 10) {
        const option = menu.appendChild(document.createElement("option"));
        option.value = String(k);
        option.textContent = k === 1 ? "as is" : `×${k}`;
      }
      menu.value = "1";
      menu.disabled = menu.options.length < 2;
    }
    cursors = [];
    for (const old of all(".plots .cursor")) old.remove();
    for (const chart of all(".group.current .plot > svg")) {
      const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
      line.setAttribute("class", "cursor");
      line.setAttribute("y1", "0");
      line.setAttribute("y2", chart.getAttribute("height"));
      cursors.push(chart.appendChild(line));
    }
    ask();
  };
  const setCamera = (name) => { Object.assign(camera, CAMERAS[name]); form.elements.camera.value = name; ask(); };

  const CHOICES = ["camera", "exaggerate", "speed", "magnify"];
  const readAddress = () => {
    const found = new URLSearchParams(location.hash.slice(1));
    if (found.has("maneuver")) setManeuver(Number(found.get("maneuver")));
    for (const name of CHOICES) {
      const options = all(`[name="${name}"][value], [name="${name}"] option`);
      const option = options.find((x) => x.value === found.get(name) && !x.disabled);
      if (!option) continue;
      form.elements[name].value = option.value;
      if (name === "camera") setCamera(option.value);
    }
    const time = Number(found.get("t"));
    if (found.has("t") && Number.isFinite(time)) goTo(time);
    setPlaying(found.get("play") === "1" || (!found.has("t") && !still.matches));
    ask();
  };

  // ---- input
  play.addEventListener("click", toggle);
  for (const button of all(".step")) button.addEventListener("click", () => stepBy(Number(button.dataset.step)));
  slider.addEventListener("input", () => { setPlaying(false); goTo(Number(slider.value)); });
  form.addEventListener("change", (event) => {
    if (event.target.name === "maneuver") setManeuver(Number(event.target.value));
    if (event.target.name === "camera") setCamera(event.target.value);
    ask();
  });
  form.addEventListener("submit", (event) => event.preventDefault());
  const plots = one(".plots");
  if (plots) plots.addEventListener("click", (event) => {
    const lines = event.target.closest(".plot") && event.target.closest(".plot").querySelector(".lines");
    if (!lines) return;
    const box = lines.getBoundingClientRect();
    setPlaying(false);
    goTo((event.clientX - box.left) / box.width * scene.duration);
  });
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (data.isPart && !one(".stage").contains(event.target)) return;
    const on = event.target.closest ? event.target.closest("input, select, button, summary, a") : null;
    const isOnScene = event.target === canvas, key = event.key;
    if (key === " " && (!on || (on.type === "range" || on.type === "radio"))) toggle();
    else if (on && on.type !== "checkbox" && on.tagName !== "BUTTON" && key !== "Escape" && !/^[1-9]$/.test(key)) return;
    else if (isOnScene && event.shiftKey && key.startsWith("Arrow")) {
      const by = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.06], ArrowDown: [0, -0.06] }[key];
      orbit(...by);
    } else if (key === "+" || key === "-") zoom(key === "+" ? 0.9 : 1 / 0.9);
    else if (key === "ArrowLeft" || key === "ArrowRight") {
      const by = key === "ArrowLeft" ? -1 : 1;
      if (event.shiftKey) { setPlaying(false); goTo(t + by); } else stepBy(by);
    } else if (key === "Home") goTo(0);
    else if (key === "End") goTo(scene.duration);
    else if (/^[1-9]$/.test(key) && !(on && on.tagName === "SELECT")) setManeuver(Number(key));
    else return;
    event.preventDefault();
  });

  const orbit = (across, lift) => {
    const isRider = chosen("camera") === "rider";
    camera.turn += isRider ? -across : across;
    camera.lift = Math.min(Math.max(camera.lift + (isRider ? -lift : lift), isRider ? -0.6 : 0.01), 1.5);
    ask();
  };
  const zoom = (by) => { camera.far = Math.min(Math.max(camera.far * by, 1.2), 30); ask(); };
  const fingers = new Map();
  canvas.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const here = [event.clientX, event.clientY];
    if (fingers.size === 1) orbit((last[0] - here[0]) * 0.008 * -1, (here[1] - last[1]) * 0.006);
    else {
      const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
      const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
      if (apart(here) > 1) zoom(apart(last) / apart(here));
    }
    fingers.set(event.pointerId, here);
  });
  for (const name of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(name, (event) => fingers.delete(event.pointerId));
  }
  canvas.addEventListener("wheel", (event) => {
    // If the stage is only a part of the page, the mouse wheel scrolls the page until the scene has the focus.
    if (data.isPart && document.activeElement !== canvas) return;
    event.preventDefault();
    zoom(Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.002));
  }, { passive: false });

  // ---- start
  const resize = () => {
    const box = canvas.getBoundingClientRect(), ratio = Math.min(devicePixelRatio || 1, 2);
    width = box.width;
    height = box.height;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    ask();
  };
  readColours();
  makeTable();
  const begin = () => {
    setManeuver((data.maneuvers.find((m) => m.result) || data.maneuvers[0]).number);
    resize();
  };
  begin();
  if (!data.isPart) {
    readAddress();
    addEventListener("hashchange", readAddress);
  }
  addEventListener("resize", resize);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readColours(); ask(); });
  draw();
  const show = (maneuvers, bicycle = data.bicycle) => {
    ({ points: P, radii, tilt, solids } = bicycle);
    data.maneuvers = maneuvers;
    makeTable();
    begin();
    setPlaying(!data.isPart && !still.matches);
  };
  // Pauses, and shows a maneuver at a time, by default the current one.
  show.goTo = (maneuver, time = t) => {
    setPlaying(false);
    if (maneuver !== scene.number) setManeuver(maneuver);
    goTo(time);
  };
  return show;
};

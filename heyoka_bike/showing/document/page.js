"use strict";
// Only comfort: values under the pointer, and lines that can be hidden. All else is in the page.
(() => {
  const WIDTH = 4000, HEIGHT = 2000;
  document.documentElement.classList.add("live");

  const axis = (text) => {
    const [low, high, isLog, offset] = text.split(" ").map(Number);
    return { low, high, isLog, offset };
  };
  // The points of a path: a start, then steps.
  const points = (path) => {
    if (!path.points) {
      const steps = path.getAttribute("d").match(/-?\d+/g).map(Number);
      const found = [];
      for (let i = 0, x = 0, y = 0; i + 1 < steps.length; i += 2) {
        found.push([x += steps[i], y += steps[i + 1]]);
      }
      path.points = found;
    }
    return path.points;
  };
  const nearest = (found, x) => {
    let low = 0, high = found.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (found[middle][0] < x) low = middle; else high = middle;
    }
    return Math.abs(found[low][0] - x) < Math.abs(found[high][0] - x) ? low : high;
  };
  const said = (a, part) => {
    const value = a.low + (a.high - a.low) * part;
    if (a.isLog) return (10 ** value).toExponential(1).replace(/e([-+])(\d)$/, "e$10$2");
    const digits = Math.max(0, 3 - Math.floor(Math.log10(a.high - a.low)));
    return (value + a.offset).toFixed(Math.min(digits, 15));
  };
  const seconds = (a, part) => a.isLog
    ? String(Number((10 ** (a.low + (a.high - a.low) * part)).toPrecision(3)))
    : (a.low + (a.high - a.low) * part).toPrecision(4);

  for (const figure of document.querySelectorAll("figure")) {
    const legend = figure.querySelector(".legend");
    if (!legend) continue;
    const charts = [...figure.querySelectorAll(".plot > svg")];
    const entries = new Map([...legend.children].map((li) => [li.dataset.name, li]));
    const at = legend.appendChild(document.createElement("li"));
    at.className = "at";
    const svg = (chart, tag, name, attributes) => {
      const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
      made.setAttribute("class", name);
      for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
      return chart.appendChild(made);
    };

    const clear = () => {
      at.textContent = "";
      for (const li of entries.values()) li.querySelector("output").textContent = "";
      for (const x of figure.querySelectorAll(".cursor, .readout")) x.remove();
    };
    const show = (event, under) => {
      const box = under.querySelector(".lines").getBoundingClientRect();
      const part = Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1);
      clear();
      for (const chart of charts) {
        const x = axis(chart.dataset.x), y = axis(chart.dataset.y);
        const height = Number(chart.getAttribute("height"));
        const place = `${100 * part}%`;
        svg(chart, "line", "cursor", { x1: place, x2: place, y1: 0, y2: height });
        const lines = [...chart.querySelectorAll("path[data-name]:not(.hidden)")];
        const values = lines.map((path) => {
          const found = points(path), down = found[nearest(found, part * WIDTH)][1];
          const value = said(y, 1 - Math.min(down, HEIGHT) / HEIGHT);
          return down > HEIGHT ? `<${value}` : value;
        });
        const when = `at ${seconds(x, part)} s`;
        if (lines.length > 2) {  // one of many: beside its name
          at.textContent = when;
          lines.forEach((path, i) => {
            entries.get(path.dataset.name).querySelector("output").textContent = values[i];
          });
        } else if (lines.length) {
          const listed = lines.map((path, i) => `${path.dataset.name} ${values[i]}`).join(", ");
          svg(chart, "text", "readout", { x: 0, y: height + 33 }).textContent =
            `${when}: ${listed} ${lines[0].dataset.unit}`;
        }
      }
    };
    for (const chart of charts) {
      const box = chart.parentElement;
      box.addEventListener("pointermove", (event) => show(event, chart));
      box.addEventListener("pointerleave", clear);
    }

    const drawn = (name) => [...figure.querySelectorAll("[data-name]")].filter(
      (x) => x.dataset.name === name && !legend.contains(x));
    for (const [name, li] of entries) {
      if (!drawn(name).length) continue;
      const button = document.createElement("button"), value = li.querySelector("output");
      button.type = "button";
      button.append(...li.childNodes);
      li.append(button, value);
      button.setAttribute("aria-pressed", "true");
      button.addEventListener("click", () => {
        const isShown = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", String(isShown));
        for (const x of drawn(name)) x.classList.toggle("hidden", !isShown);
      });
    }
  }
})();

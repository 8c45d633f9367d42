"use strict";
// Shows the value that the address asks for; all of them are in the text beside this page.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const at = (id) => document.getElementById(id);
  const table = fetch(data.text).then((answer) => {
    if (!answer.ok) throw new Error(`${data.text}: ${answer.status}`);
    return answer.text();
  }).then((text) => new Map(text.trim().split("\n").map((line) => {
    const cells = line.split(" ");
    return [cells[0], cells];
  })));
  // As the text has it: 7.310, +7.31 and 7,31 are 7.31; null if it is no such time.
  const plain = (time) => {
    const found = /^\+?0*(\d*)(?:[.,](\d*?)0*)?$/.exec(time.trim());
    if (!found || !/\d/.test(time)) return null;
    return (found[1] || "0") + (found[2] ? `.${found[2]}` : "");
  };
  const show = async ({ maneuver, column, time }) => {
    const name = `${maneuver}.${column}@${plain(time) ?? time}`;
    let rows;
    try {
      rows = await table;
    } catch {
      at("found").hidden = true;
      at("said").textContent = `${data.text} could not be loaded; a page that is opened from a folder may not load it.`;
      return;
    }
    const place = data.keys.indexOf(column), cells = rows.get(plain(time));
    const isKnown = place >= 0 && maneuver >= 1 && maneuver <= data.maneuvers;
    at("found").hidden = !(isKnown && cells);
    at("copied").textContent = "";
    if (!isKnown) {
      at("said").textContent = `No ${name} is there: expected a maneuver from 1 to ${data.maneuvers}, and a column of the list.`;
    } else if (!cells) {
      at("said").textContent = `The text has no row at ${time} s, but at every ${data.spacing} s from 0 to ${data.end} s. At any time: load_reference()[${maneuver}].evaluate("${time}") in Python.`;
    } else {
      at("said").textContent = "";
      at("value").textContent = cells[1 + data.keys.length * (maneuver - 1) + place];
      at("unit").textContent = data.units[place];
      at("cited").textContent = `${column} of maneuver ${maneuver} at ${plain(time)} s, dataset ${data.version}`;
      history.replaceState(null, "", `#${name}`);
    }
  };
  const asked = () => {
    show({ maneuver: Number(at("maneuver").value), column: at("column").value, time: at("time").value });
  };
  const fromAddress = () => {
    const found = /^#(\d+)\.(\w+)@(.+)$/.exec(decodeURIComponent(location.hash));
    if (!found) return;
    const [, maneuver, column, time] = found;
    at("maneuver").value = maneuver;
    at("column").value = column;
    at("time").value = time;
    show({ maneuver: Number(maneuver), column, time });
  };
  at("asked").addEventListener("input", asked);
  at("asked").addEventListener("submit", (event) => { event.preventDefault(); asked(); });
  addEventListener("hashchange", fromAddress);
  for (const button of document.querySelectorAll("[data-copies]")) {
    button.addEventListener("click", async () => {
      const text = button.dataset.copies === "value" ? at("value").textContent : location.href;
      try {
        await navigator.clipboard.writeText(text);
        at("copied").textContent = "Copied.";
      } catch {
        at("copied").textContent = "The browser did not allow it; the value can be marked and copied.";
      }
    });
  }
  fromAddress();
})();

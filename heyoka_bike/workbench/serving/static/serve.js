"use strict";
// The pages also work without this script. It adds drag and drop, a check of the size before sending, and progress.

const form = document.querySelector("form.upload");
if (form) upload(form);
const progress = document.querySelector("[data-state]");
if (progress) follow(progress);

function upload(form) {
  const area = form.querySelector(".target"), input = form.querySelector("input[type=file]");
  const list = area.querySelector(".chosen"), error = form.querySelector(".problem"), busy = form.querySelector(".busy");
  const most = Number(form.dataset.most), count = Number(form.dataset.files);

  const size = (bytes) => bytes < 1e6 ? `${Math.max(1, Math.round(bytes / 1e3))} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
  const complain = (text) => { error.textContent = text; if (text) error.focus(); };

  function check() {
    const files = [...input.files], all = files.reduce((sum, file) => sum + file.size, 0);
    list.replaceChildren(...files.map((file) => {
      const item = document.createElement("span");
      item.textContent = `${file.name}, ${size(file.size)}`;
      return item;
    }));
    complain(files.length > count ? `Found ${files.length} files, expected ${count} at most.`
      : all > most ? `Found ${size(all)}, expected ${size(most)} at most. Nothing was sent. Use fewer rows: 1001 are usual.` : "");
    return !error.textContent;
  }

  input.addEventListener("change", check);
  for (const name of ["dragenter", "dragover"]) {
    document.addEventListener(name, (event) => { event.preventDefault(); area.classList.add("over"); });
  }
  document.addEventListener("dragleave", (event) => { if (!event.relatedTarget) area.classList.remove("over"); });
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    area.classList.remove("over");
    if (!event.dataTransfer.files.length) return;
    input.files = event.dataTransfer.files;
    if (check()) form.requestSubmit();
  });

  form.addEventListener("submit", (event) => {
    event.preventDefault();
    if (!check()) return;
    if (!input.files.length && !form.elements.pasted.value.trim()) {
      complain("Choose a file or paste rows first.");
      return;
    }
    const button = form.querySelector("button.main");
    const bar = document.createElement("progress"), said = document.createElement("span"), much = document.createElement("span");
    const request = new XMLHttpRequest();
    const end = (text) => { busy.replaceChildren(); button.disabled = false; complain(text); };
    busy.replaceChildren(bar, " ", said, " ", much);
    button.disabled = true;
    said.textContent = "sending";
    bar.setAttribute("aria-label", "Sent");
    // Screen readers report the progress bar, so they need not read this text.
    much.setAttribute("aria-hidden", "true");
    request.upload.addEventListener("progress", (sent) => {
      if (!sent.lengthComputable) return;
      bar.max = sent.total;
      bar.value = sent.loaded;
      much.textContent = `${size(sent.loaded)} of ${size(sent.total)}`;
      if (sent.loaded < sent.total) return;
      said.textContent = "scoring";
      much.textContent = "";
      bar.removeAttribute("value");
    });
    request.addEventListener("load", () => {
      let found = {};
      try { found = JSON.parse(request.responseText); } catch { /* the answer is not from this server */ }
      if (found.location) location.assign(found.location);
      else end(found.error || `The server answered ${request.status}.`);
    });
    request.addEventListener("error", () => end("The connection failed, or the server rejected the size. Nothing was stored; try again."));
    request.open("POST", form.action);
    request.setRequestHeader("Accept", "application/json");
    request.send(new FormData(form));
  });
  // After going back, the browser may restore the chosen files and a disabled button.
  window.addEventListener("pageshow", () => { form.querySelector("button.main").disabled = false; busy.replaceChildren(); check(); });
}

function follow(place) {
  const bar = place.querySelector("progress"), said = place.querySelector(".share");
  const look = async () => {
    try {
      const found = await (await fetch(place.dataset.state, { headers: { Accept: "application/json" } })).json();
      if (!["waiting", "working"].includes(found.state)) { location.reload(); return; }
      if (found.progress > 0) { bar.value = found.progress; said.textContent = `${Math.round(100 * found.progress)} %`; }
    } catch { said.textContent = "no answer from the server, trying again"; }
    setTimeout(look, 500);
  };
  setTimeout(look, 500);
}

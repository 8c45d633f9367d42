"""The page of ``export --page`` has a message for every damaged or forged link or file.

For every input the page shows a result or a reason, and raises no error.
"""

import base64
import json
import re

import pytest

from generators.bad_links import CELL, bad_files, bad_links, packed
from generators.published_columns import published_table
from heyoka_bike.cli import main
from support.browser import browser

pytestmark = pytest.mark.proof

# Script that returns the page's result for each link or file, one after the other.
DRIVER = """
const raised = [];
addEventListener("error", (e) => raised.push(`${e.message} ${e.lineno}`));
addEventListener("unhandledrejection", (e) => raised.push(String(e.reason)));
const by = (id) => document.getElementById(id);
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
async function outcome(give) {
  by("problem").textContent = by("verdict").textContent = "";
  by("result").hidden = true;
  raised.length = 0;
  give();
  const isOver = () => by("problem").textContent || !by("result").hidden || raised.length;
  for (let i = 0; i < 6000 && !isOver(); i++) await pause(5);
  await pause(5);
  return {
    problem: by("problem").textContent, verdict: by("verdict").textContent,
    isShown: !by("result").hidden, style: by("shown").className, raised: [...raised],
    extra: Object.keys(Object.prototype).length + document.querySelectorAll("#result img").length,
  };
}
const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
const file = ([name, data]) => new File([bytesOf(data)], name);
function drop(given) {
  const all = new DataTransfer();
  all.items.add(given);
  document.dispatchEvent(new DragEvent("drop", { dataTransfer: all }));
}
function choose(given) {
  const all = new DataTransfer();
  all.items.add(given);
  by("file").files = all.files;
  by("file").dispatchEvent(new Event("change"));
}
async function tell(steps) {
  const found = [];
  for (const step of steps) found.push(await outcome(step));
  return found;
}
"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    assert main(["export", "--page", "-o", f"{folder}/"]) == 0
    return (folder / "uncontrolled_bicycle.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def rows(reference):
    return published_table(reference, (2,), every=50).tolist()


def outcomes(opened, page, steps):
    """Return the page after each step of a script in one window, and the script's errors."""
    # The test's script is not a script of the page, so the page's content security policy is
    # relaxed.
    allowed = "script-src 'unsafe-inline' 'wasm-unsafe-eval'"
    page = re.sub(r"script-src [^\"]*", allowed, page)
    shown = opened(page.replace("</body>", f"<script>{DRIVER}</script></body>"))
    shown.set_default_timeout(300_000)
    return shown.evaluate(f"async () => {{ {steps} }}"), shown.complaints


def check(found, given):
    assert len(found) == len(given)
    for outcome, one in zip(found, given, strict=True):
        told = f"{str(one)[:300]}: {outcome}"
        assert outcome["raised"] == [], told
        assert outcome["extra"] == 0, told
        # The page shows either a result, or the reason why there is none.
        assert outcome["isShown"] == bool(outcome["verdict"]), told
        assert outcome["isShown"] != bool(outcome["problem"]), told


@browser
@pytest.mark.parametrize("seed", range(2))
def test_links(page, rows, opened, seed):
    links = bad_links(rows, 250, seed)
    steps = f"""
        const links = {json.dumps(links)};
        return tell(links.map((link) => () => {{ location.hash = "#"; location.hash = link; }}));
    """
    found, complaints = outcomes(opened, page, steps)
    check(found, links)
    assert complaints == []
    for outcome, link in zip(found, links, strict=True):
        if outcome["isShown"] and link.startswith("#result="):
            assert outcome["verdict"].startswith("Shared, not checked here: "), link
            assert outcome["style"] == "verdict shared", link
    assert sum(x["isShown"] for x in found) > 20
    assert sum(not x["isShown"] for x in found) > 100


@browser
@pytest.mark.parametrize("way", ["drop", "choose"])
def test_files(page, rows, opened, way):
    files = bad_files(rows, 120, 7)
    given = [(name, base64.b64encode(data).decode()) for name, data in files]
    steps = f"return tell({json.dumps(given)}.map((one) => () => {way}(file(one))));"
    found, complaints = outcomes(opened, page, steps)
    check(found, given)
    assert complaints == []


@browser
def test_what_cannot_be_read_has_a_message(page, opened):
    """A dropped folder and a missing file count as files whose text cannot be read."""
    steps = """
        const gone = new File(["0 1"], "gone.txt");
        gone.text = () => Promise.reject(new DOMException("it is gone", "NotFoundError"));
        const dropped = new Event("drop");
        dropped.dataTransfer = { files: [gone] };
        return tell([() => document.dispatchEvent(dropped)]);
    """
    ((found,), complaints) = outcomes(opened, page, steps)
    assert found["raised"] == complaints == []
    assert found["problem"].startswith("gone.txt: cannot be read")


@browser
def test_the_last_of_two_links_is_shown(page, opened):
    long = packed("text", json.dumps({"name": "first", "text": "0 1\n" * 2_000_000}))
    last = packed("result", json.dumps({"name": "last", "whole": True, "cells": [CELL]}))
    steps = f"""
        return tell([async () => {{
            location.hash = {json.dumps(long)};
            await pause(0);
            location.hash = {json.dumps(last)};
        }}]);
    """
    ((found,), _) = outcomes(opened, page, steps)
    assert found["isShown"], found
    assert found["verdict"].startswith("Shared, not checked here: right"), found

"""The page of an atlas is self-contained, and choosing a start in it opens its replay."""

import base64
import re
from fractions import Fraction

import numpy as np
import pytest

from generators.sample_atlas import POSITIVE, made
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.workbench.atlas.data import FATES
from heyoka_bike.workbench.atlas.page.page import Packed, render
from support.browser import browser, widths
from support.pages import Page, assert_runs_alone, data


@pytest.fixture(scope="module")
def page(bicycle):
    return render(made(bicycle))


def test_the_page_stands_alone(page):
    assert_runs_alone(page)


def test_an_atlas_of_200_by_200_stays_small(bicycle):
    large = made(bicycle, ("speed", 1.0, 9.0, 200), ("roll_rate", 0.0, 4.0, 200))
    assert len(render(large).encode()) < 1_500_000


@pytest.mark.parametrize("is_log", [False, True])
def test_packed_numbers_are_as_precise_as_they_say(is_log):
    values = np.concatenate([[0.0, np.nan, np.inf], np.exp(np.linspace(-9, 6, 5000))])
    p = Packed.of(values, is_log=is_log)
    codes = np.frombuffer(base64.b64decode(p.text()), dtype="<u2")
    found = p.low + (p.high - p.low) * codes / 65534
    found = np.where(codes == 0, 0.0, 10**found) if is_log else found
    assert np.array_equal(codes == 65535, ~np.isfinite(values))
    there = np.isfinite(values) & (values > 0)
    error = np.abs(found - values)[there] / (values[there] if is_log else 1.0)
    assert error.max() <= p.precision * (1 + 1e-9)
    assert error.max() > p.precision / 4
    assert found[0] == 0.0


def test_the_data_are_the_atlas(bicycle, page):
    atlas, found = made(bicycle), data(page)
    assert [a["values"] for a in found["axes"]] == [a.values.tolist() for a in atlas.axes]
    fate = np.frombuffer(base64.b64decode(found["fate"]), np.uint8)
    assert np.array_equal(fate, atlas.variables["fate"].ravel())
    assert len(found["fates"]) == len(FATES) == len(found["when"])
    for name in (*POSITIVE, "final_speed"):
        q, exact = found["quantities"][name], atlas.variables[name].ravel()
        codes = np.frombuffer(base64.b64decode(q["codes"]), dtype="<u2").astype(float)
        codes[codes == 65535] = np.nan
        value = q["low"] + (q["high"] - q["low"]) * codes / 65534
        if q["isLog"]:
            value = np.where(codes == 0, 0.0, 10**value)
        np.testing.assert_allclose(value, exact, rtol=2e-4)
    assert [(m["x"], m["y"]) for m in found["marks"]] == [(4.0, 0.05), (4.6, 0.5), (8.0, 0.05)]
    weave, capsize = 4.29238253634110396, 6.02426201538835389
    assert found["stable"]["ranges"] == [pytest.approx([weave, capsize], abs=1e-12)]
    for curve, speed in zip(found["stable"]["curves"], (weave, capsize), strict=True):
        assert curve == [pytest.approx([speed, x], abs=1e-12) for x in (0.0, 4.0)]


def test_maneuvers_are_marked_where_they_are(bicycle):
    leaning = made(bicycle, ("speed", 1.0, 9.0, 5), ("roll", 0.1, 0.4, 5))
    assert data(render(leaning))["marks"] == []
    slow = made(bicycle, ("roll_rate", 0.0, 1.0, 5), ("speed", 1.0, 5.0, 5))
    found = data(render(slow))
    assert [(m["x"], m["y"]) for m in found["marks"]] == [(0.05, 4.0), (0.5, 4.6)]
    assert found["stable"]["curves"][0][0] == [0.0, pytest.approx(4.29238253634110396)]


def said(dom):
    return Page(re.search(r'<p class="said".*?</p>', dom, re.S)[0]).text


@browser
def test_the_address_opens_a_start(page, reference, opened):
    shown = opened(page, "#at=4.6,0.5&t=3.2")
    dom = shown.content()
    assert shown.complaints == []
    assert "4.6 m/s, 0.5 rad/s" in said(dom)
    # The page computes maneuver 2 itself.
    exact = reference[2].evaluate("3.2")
    assert re.search(r'<output class="clock">3.20 s<', dom)
    values = dict(re.findall(r'<tr><th scope="row">(\w+) \[.*?</th><td>(.*?)</td>', dom))
    for name, column in (("roll", "roll_angle"), ("speed", "forward_speed"), ("yaw", "yaw")):
        value = float(values[name].replace("−", "-"))
        assert value == pytest.approx(exact[column], abs=5.1e-5)
    assert dom.count('class="cursor"') == 4


HANDS = """
async () => {
const out = {}, soon = () => new Promise((done) =>
  requestAnimationFrame(() => requestAnimationFrame(done)));
const map = document.querySelector(".map canvas"), words = document.querySelector(".said");
const key = (key, more = {}) => map.dispatchEvent(
  new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more }));
const pointer = (type, x, y) => map.dispatchEvent(new PointerEvent(type,
  { clientX: x, clientY: y, pointerId: 1, pointerType: "touch", bubbles: true }));
const menu = document.querySelector('select[name="shown"]'), picture = () => map.toDataURL();
  await soon(); out.start = words.textContent.split(/[:.] /)[0];
  key("ArrowRight"); await soon(); out.right = words.textContent.split(": ")[0];
  out.quiet = words.textContent.includes("Replay");
  key("ArrowUp", { shiftKey: true }); await soon(); out.top = words.textContent.split(": ")[0];
  out.fate = words.querySelector("b").textContent.includes("falls after");
  key("Enter"); await soon(); out.replayed = words.textContent.includes("Replay of ");
  out.falls = words.textContent.includes("it falls");
  out.address = location.hash;
  const box = map.getBoundingClientRect(), x = box.left + 54 + 0.25 * (box.width - 68);
  const y = box.top + 26 + 0.9 * (box.height - 68);
  pointer("pointerdown", x, y); pointer("pointerup", x, y); await soon();
  out.tapped = words.textContent.split(". ")[0];
  pointer("pointermove", x, y);
  out.under = document.querySelector(".under").textContent.length > 20;
  const seen = [picture()];
  for (const name of [...menu.options].map((o) => o.value).slice(1)) {
    menu.value = name; menu.dispatchEvent(new Event("change", { bubbles: true })); await soon();
    seen.push(picture());
  }
  key("+"); await soon(); seen.push(picture());
  pointer("pointerdown", x, y); pointer("pointermove", x + 60, y - 40); pointer("pointerup", x, y);
  await soon(); seen.push(picture());
  out.pictures = new Set(seen).size;
  key("0"); key(" "); await soon();
  const [vx, vy] = document.querySelectorAll("form.start input");
  vx.value = "4.61803"; vy.value = "0.25";
  document.querySelector("form.start").requestSubmit(); await soon();
  out.typed = words.textContent.split(". ")[0];
  document.querySelector('[data-mark="2"]').click(); await soon();
  out.marked = words.textContent.split(". ")[0];
  return out;
}
"""


@pytest.mark.proof
@browser
def test_keys_pointer_and_boxes_do_what_they_say(page, opened):
    shown = opened(page, "#at=5,0.5")
    found = shown.evaluate(HANDS)
    assert shown.complaints == []
    assert found == {
        "start": "5 m/s, 0.5 rad/s", "right": "5.5 m/s, 0.5 rad/s", "quiet": False,
        "top": "5.5 m/s, 4 rad/s", "fate": True, "replayed": True, "falls": True,
        "address": "#at=5.5,4", "tapped": "2.875 m/s, 0.2 rad/s", "under": True, "pictures": 9,
        "typed": "4.61803 m/s, 0.25 rad/s", "marked": "8 m/s, 0.05 rad/s",
    }  # fmt: skip


@pytest.mark.proof
@browser
def test_errors_of_a_page_would_be_seen(page, opened):
    broken = page.replace("const drawEdge = () => {", "const drawEdge = () => { nothing();")
    assert opened(broken).complaints != []


@pytest.mark.proof
@browser
def test_nothing_is_wider_than_the_window(page, opened):
    for content, window in widths(opened, page, "#at=8,3"):
        assert window > 250
        assert content <= window


@pytest.mark.proof
@browser
def test_an_axis_may_change_the_bicycle(bicycle, opened):
    page = render(made(bicycle, ("w", 0.9, 1.3, 5), ("speed", 3.0, 7.0, 5)))
    shapes = data(page)["shapes"]
    assert [s[0]["points"]["P3"][0] for s in shapes] == pytest.approx(np.linspace(0.9, 1.3, 9))
    weave, capsize = data(page)["stable"]["curves"]
    # The curves have fewer than 25 points, because bicycles with the longest wheel bases of the
    # axis have no stable speed. The first bicycle, with 0.9 m, has a stable range.
    assert len(weave) == len(capsize) < 25
    ((low, high),) = linearise(bicycle.replace(w=Exact(Fraction(0.9))), 15).stable_ranges
    assert (weave[0], capsize[0]) == (
        [0.9, pytest.approx(float(low))],
        [0.9, pytest.approx(float(high))],
    )
    shown = opened(page, "#at=1.02,4.6&t=3.2")
    dom = shown.content()
    assert shown.complaints == []
    assert "1.02 m, 4.6 m/s. Replay of " in said(dom)
    assert "wheel base w" in Page(dom).text

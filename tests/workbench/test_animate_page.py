"""The replay is one self-contained page, which a browser shows without errors."""

import re
from io import BytesIO

import numpy as np
import pytest

from heyoka_bike import score
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.showing.formats.output import render as rendered
from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.replay.page import render
from heyoka_bike.workbench.replay.scenes import replay
from support.browser import browser, widths
from support.pages import Page, assert_runs_alone, data

RESULT = data_folder() / "peers" / "exudyn-h0.01.txt"
PAGES = ["plain", "compared"]


@pytest.fixture(scope="module")
def pages(reference):
    return {
        "plain": render(replay(reference)),
        "compared": render(replay(reference, read_results(RESULT, count=3)), str(RESULT)),
    }


@pytest.mark.parametrize("name", PAGES)
def test_the_page_stands_alone(pages, name):
    assert len(pages[name].encode()) < 3_000_000
    assert_runs_alone(pages[name])


def test_it_says_the_verdict_as_the_report_does(pages):
    said = Page(pages["compared"]).text
    assert "✗ Wrong; the worst column has 1.6 correct digits (steer_rate in maneuver 1)." in said
    report = Page(rendered(score(RESULT), "html", [])).text
    assert "✗ Wrong; the worst column has 1.6 correct digits (steer_rate in maneuver 1)." in report


def test_every_control_has_a_name(pages):
    page = Page(pages["compared"])
    named = re.findall(r"<label[^>]*>\s*(?:difference )?<(?:input|select)", pages["compared"])
    inputs = [a for a in page.all("input") if a["type"] != "range"] + page.all("select")
    assert len(named) == len(inputs) > 15
    assert all(a.get("aria-label") for a in page.all("input") if a["type"] == "range")
    assert all(a.get("aria-label") for a in page.all("button"))
    assert all(a.get("aria-label") for a in page.all("canvas"))
    assert pages["compared"].count("<fieldset") == pages["compared"].count("<legend>")


def test_the_data_are_the_motion(pages, reference):
    found = data(pages["compared"])
    scenes = replay(reference, read_results(RESULT, count=3)).scenes
    for m, scene in zip(found["maneuvers"], scenes, strict=True):
        exact, other = scene.reference.motion, scene.result.motion
        for name, one, two in (
            ("x", exact.rear_contact[:, 0], other.rear_contact[:, 0]),
            ("front_y", exact.front_contact[:, 1], other.front_contact[:, 1]),
            ("yaw", exact.yaw, other.yaw), ("roll", exact.roll, other.roll),
            ("front_wheel", exact.front_wheel, other.front_wheel),
        ):  # fmt: skip
            np.testing.assert_allclose(m["columns"][name], one, rtol=0, atol=5.1e-7)
            difference = m["result"]["differences"][name]
            np.testing.assert_allclose(difference, two - one, rtol=1e-4, atol=1e-13)
    assert data(pages["plain"])["maneuvers"][0]["result"] is None


def test_turns_of_a_late_file_are_counted_from_its_start(reference, tmp_path):
    path = tmp_path / "late.txt"
    np.savetxt(path, np.loadtxt(RESULT)[300:], fmt="%.12g")
    found = data(render(replay(reference, read_results(path, count=3)), "late.txt"))
    for m in found["maneuvers"]:
        assert m["result"]["first"] == 150
        for name in ("rear_wheel", "front_wheel", "track"):
            assert np.abs(m["result"]["differences"][name]).max() < 0.1


def test_derived_quantities_are_said(pages):
    text = Page(pages["compared"]).text
    assert text.count("Derived: the pitch from roll and steer") == 3
    assert "roll angle taken as tait_bryan_xyz" in text
    assert "Derived" not in Page(pages["plain"]).text


def test_hostile_names_stay_text(reference):
    name = '</script><b onclick="alert(1)">&\x1b[31m'
    text = render(replay(reference, read_results(RESULT, count=3)), name)
    page = Page(text)
    assert len(page.all("script")) == 2
    assert not any(key.startswith("on") for _, a in page.tags for key in a)
    assert not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f]", text)


def picture(page):
    """Return the colours of the scene, from 0 to 1, shape (rows, columns, 3)."""
    image = pytest.importorskip("matplotlib.image")
    return image.imread(BytesIO(page.screenshot()))[100:640, 25:880, :3]


def clock(dom):
    return float(re.search(r'<output class="clock">([\d.]+) s<', dom)[1])


def values(dom):
    rows = re.findall(r'<tr><th scope="row">(\w+) \[.*?</th>(.*?)</tr>', dom)
    return {
        name: [float(x.replace("−", "-")) for x in re.findall("<td>(.*?)</td>", cells)]
        for name, cells in rows
    }


@browser
@pytest.mark.parametrize("name", PAGES)
def test_the_address_opens_a_moment(pages, reference, opened, name):
    page = opened(pages[name], "#t=3.2&maneuver=2&camera=behind")
    dom = page.content()
    assert page.complaints == []
    assert clock(dom) == 3.2
    exact = reference[2].evaluate("3.2")
    found = values(dom)
    assert found["roll"][0] == pytest.approx(exact["roll_angle"], abs=5.1e-5)
    assert found["speed"][0] == pytest.approx(exact["forward_speed"], abs=5.1e-5)
    assert found["yaw"][0] == pytest.approx(exact["yaw"], abs=5.1e-5)
    assert re.findall(r'class="group current" data-maneuver="(\d)"', dom) == ["2"]
    if name == "compared":
        row = np.loadtxt(RESULT)[320]
        assert found["speed"][1] == pytest.approx(row[1 + 8 + 2], abs=2e-3)
        difference = row[1 + 8 + 6] - exact["steer_angle"]
        assert found["steer"][2] == pytest.approx(difference, rel=0.05)


@pytest.mark.proof
@browser
def test_it_plays_unless_motion_is_not_wanted(pages, opened):
    playing = opened(pages["plain"], is_stopped=True)
    playing.clock.run_for(2500)
    assert playing.complaints == []
    # The page draws in each browser frame, 60 times per second, beginning with the second frame.
    assert clock(playing.content()) == pytest.approx(2.5, abs=2.5 / 60)
    for within, options, time in (("", {"reduced_motion": "reduce"}, 0), ("#t=5", {}, 5)):
        resting = opened(pages["plain"], within, is_stopped=True, **options)
        resting.clock.run_for(2500)
        assert clock(resting.content()) == time


@pytest.mark.proof
@browser
def test_errors_of_a_page_would_be_seen(opened, pages):
    broken = pages["plain"].replace("const draw = () => {", "const draw = () => { nothing();")
    assert opened(broken).complaints != []


@pytest.mark.proof
@browser
def test_nothing_is_wider_than_the_window(pages, opened):
    found = widths(opened, pages["compared"], "#t=3&maneuver=3&exaggerate=20")
    for content, window in found:
        assert window > 250
        assert content <= window, found


@browser
@pytest.mark.parametrize(
    "camera",
    [
        "follow",
        *(pytest.param(x, marks=pytest.mark.proof) for x in ("side", "behind", "above", "rider")),
    ],
)
def test_the_scene_shows_a_bicycle(pages, opened, camera):
    for name, seen in (("plain", False), ("compared", True)):
        address = f"#t=4&maneuver=1&magnify=100&camera={camera}"
        page = opened(pages[name], address)
        assert page.complaints == []
        pixels = picture(page)
        red, green, blue = np.moveaxis(pixels, -1, 0)
        # Count the pixels of the orange frame, the black tyres, and the blue result.
        assert ((red > green + 0.3) & (green > blue + 0.1)).sum() > 150
        assert (pixels.max(axis=-1) < 0.25).sum() > 150
        is_blue = ((blue > red + 0.25) & (blue > green + 0.05)).sum() > 300
        assert is_blue == seen


HANDS = """
async () => {
const out = {}, clock = () => Number(document.querySelector(".clock").textContent.split(" ")[0]);
const key = (key, more = {}, on = document.body) =>
  on.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more }));
const soon = () => new Promise((done) =>
  requestAnimationFrame(() => requestAnimationFrame(done)));
const canvas = document.querySelector("canvas"), plot = () =>
  document.querySelector(".group.current .plot svg.lines");
const picture = () => canvas.toDataURL();
const pointer = (type, x, y, id = 1) => canvas.dispatchEvent(
  new PointerEvent(type, { clientX: x, clientY: y, pointerId: id, bubbles: true }));
canvas.setPointerCapture = () => {};
  await soon();
  out.start = clock();
  key("ArrowRight"); await soon(); out.right = clock();
  key("ArrowLeft", { shiftKey: true }); await soon(); out.back = clock();
  key("End"); await soon(); out.end = clock();
  key("Home"); await soon(); out.home = clock();
  key(" "); out.playing = document.querySelector(".play").getAttribute("aria-label");
  key(" "); out.paused = document.querySelector(".play").getAttribute("aria-label");
  key("3"); await soon();
  out.maneuver = document.querySelector(".group.current").dataset.maneuver;
  const box = plot().getBoundingClientRect();
  plot().dispatchEvent(new MouseEvent("click",
    { clientX: box.left + 0.25 * box.width, clientY: box.top + 5, bubbles: true }));
  await soon(); out.clicked = clock();
  const seen = [picture()], look = async () => { await soon(); seen.push(picture()); };
  pointer("pointerdown", 100, 100); pointer("pointermove", 160, 120);
  pointer("pointerup", 160, 120);
  await look();
  canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: 60, bubbles: true, cancelable: true }));
  await look();
  pointer("pointerdown", 100, 100); pointer("pointerdown", 200, 100, 2);
  pointer("pointermove", 260, 100, 2); pointer("pointerup", 0, 0); pointer("pointerup", 0, 0, 2);
  await look();
  key("ArrowLeft", { shiftKey: true }, canvas); await look();
  document.querySelector('[name="exaggerate"][value="20"]').click(); await look();
  out.scale = document.querySelector(".scale").textContent;
  document.querySelector('[name="rider"]').click(); await look();
  document.querySelector('[name="maneuver"][value="1"]').click(); await look();
  out.disabled = document.querySelector('[name="exaggerate"][value="20"]').disabled;
  out.hidden = document.querySelector(".scale").hidden;
  const turned = new Promise((done) => addEventListener("hashchange", done, { once: true }));
  location.hash = "#t=6.5&maneuver=2"; await turned; await soon();
  out.address = clock();
  out.pictures = new Set(seen).size;
  return out;
}
"""


@browser
def test_keys_pointer_and_address_do_what_they_say(pages, opened):
    page = opened(pages["plain"], "#t=3&maneuver=2")
    found = page.evaluate(HANDS)
    assert page.complaints == []
    # The pointer moves by whole pixels, so the time is approximate.
    assert found.pop("clicked") == pytest.approx(2.5, abs=0.05)
    assert found == {
        "start": 3, "right": 3.02, "back": 2.02, "end": 10, "home": 0, "playing": "Pause",
        "paused": "Play", "maneuver": "3", "scale": "roll and steer drawn ×20",
        "disabled": True, "hidden": True, "address": 6.5, "pictures": 8,
    }  # fmt: skip


@pytest.mark.proof
@browser
def test_the_result_is_hatched(pages, opened):
    def solid(text):
        """Return the fraction of blue pixels in runs longer than the stripes of the hatch."""
        pixels = picture(opened(text, "#t=4&maneuver=1&magnify=100"))
        red, green, blue = np.moveaxis(pixels, -1, 0)
        runs = [
            len(run)
            for row in (blue > red + 0.2) & (blue > green + 0.05)
            for run in "".join("x" if is_blue else " " for is_blue in row).split()
        ]
        return sum(n for n in runs if n > 9) / sum(runs)

    # The page's content security policy is relaxed so that the test's own script may run.
    page = re.sub(r"script-src [^\"]*", "script-src 'unsafe-inline'", pages["compared"])
    assert solid(page) < 0.5 * solid(page.replace("hatch(g);", ""))

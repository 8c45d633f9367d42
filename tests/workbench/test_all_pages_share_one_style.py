"""Report, series, leaderboard, replay, atlas and checker have one style sheet and one look.

Colours have enough contrast in light and dark mode. No page is wider than a telephone.
"""

import re
from itertools import product

import pytest

from generators import sample_reports
from generators.sample_atlas import made
from generators.submissions import copied
from heyoka_bike import animate, score
from heyoka_bike.cli import main
from heyoka_bike.showing.document.html import PAGE_STYLE
from heyoka_bike.showing.formats.output import render
from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.atlas.page.page import render as render_atlas
from heyoka_bike.workbench.checker.page import checker_page
from support.browser import DROP, browser, wait_until
from support.pages import Page

EXUDYN = data_folder() / "peers" / "exudyn-h0.01.txt"
SHEETS = sorted(PAGE_STYLE.parents[2].rglob("*.css"))
NAMES = ("report", "series", "programs", "board", "replay", "atlas", "checker")
TELEPHONE, SCREEN = 390, 1280  # widths of the tested windows [px]
# Pairs of a text colour and a background on which a page shows it.
PAIRS = [
    *product(("ink", "soft", "link", "good", "bad", "warn"), ("page", "card")),
    *product(("ink",), ("good-tint", "warn-tint", "bad-tint")),
    ("good", "good-tint"), ("warn", "warn-tint"), ("bad", "bad-tint"), ("link", "good-tint"),
    ("page", "ink"), ("page", "link"),
]  # fmt: skip
LEAST_CONTRAST = 4.5  # contrast of text, https://www.w3.org/TR/WCAG22/#contrast-minimum
# Script that returns the colours of all visible headings, including those of table columns.
HEADINGS = """() => [...new Set([...document.querySelectorAll("h1, h2, h3, h4, thead th")].filter(
  (x) => x.checkVisibility()).map((x) => getComputedStyle(x).color))]"""
# Script that returns the distances of the verdict's text from the left and the top of its box [px].
ROOM = """() => {
  const box = document.querySelector(".verdict"), text = document.createRange();
  text.selectNodeContents(box);
  const [a, b] = [box.getBoundingClientRect(), text.getBoundingClientRect()];
  return [b.left - a.left, b.top - a.top];
}"""
BOXES = """() => [".found .digits", ".found .detail"].map(
  (x) => { const b = document.querySelector(x).getBoundingClientRect(); return [b.x, b.y]; })"""

# Script that returns the focused element, and whether it has an outline. A hidden input shows its
# outline at the text next to it.
FOCUS = """() => {
  const x = document.activeElement, isHidden = getComputedStyle(x).opacity === "0";
  const { outlineStyle, outlineWidth } = getComputedStyle(isHidden ? x.nextElementSibling : x);
  return [x.outerHTML.slice(0, 80), outlineStyle === "solid" && parseFloat(outlineWidth) >= 2];
}"""
STEPS_OF_KEYS = 20


@pytest.fixture(scope="module")
def pages(tmp_path_factory, bicycle):
    folder = tmp_path_factory.mktemp("board")
    assert main(["leaderboard", str(copied(folder / "results")), "-o", f"{folder}/x.html"]) == 0
    return {
        "report": render(score(EXUDYN), "html", []),
        "series": render(sample_reports.series(), "html", []),
        "programs": render(sample_reports.programs(), "html", []),
        "board": (folder / "x.html").read_text(encoding="utf-8"),
        "replay": animate(EXUDYN, maneuver=1).html,
        "atlas": render_atlas(made(bicycle)),
        "checker": checker_page(),
    }


@pytest.fixture
def shown(pages, opened):
    """Opens a page by its name; the checker with a judged file."""

    def show(name, **how):
        page = opened(pages[name], **how)
        if name == "checker":
            page.evaluate(DROP, [EXUDYN.name, EXUDYN.read_text()])
            wait_until(page, '!document.getElementById("result").hidden')
        return page

    return show


@pytest.mark.parametrize("name", NAMES)
def test_each_page_has_the_one_style_sheet(pages, name):
    sheet = PAGE_STYLE.read_text(encoding="utf-8")
    assert pages[name].count(sheet) == 1
    assert '<p class="kicker">Uncontrolled bicycle' in pages[name]


def test_a_colour_or_a_look_is_defined_once():
    """Other sheets contain neither their own colours nor their own fonts, buttons and width."""
    defined = [x for file in SHEETS for x in set(re.findall("(--[a-z0-9-]+):", file.read_text()))]
    assert len(defined) == len(set(defined))
    for file in SHEETS:
        text = re.sub(r":root \{.*?\}", "", file.read_text(encoding="utf-8"), flags=re.S)
        assert not re.search("#[0-9a-f]{3,8}[; ]", text), file
        if file != PAGE_STYLE:
            assert not re.search(r"body \{[^}]*(?:max-width: \d|font)", text), file
            assert not re.search(r"^(?::focus-visible|button|select|h[1-4])\b[^{.]*\{", text, re.M)


def contrast(one, other):
    """Return the ratio of the luminances of two colours as WCAG 2 defines it."""

    def luminance(colour):
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    low, high = sorted(map(luminance, (one, other)))
    return (high + 0.05) / (low + 0.05)


def test_text_has_enough_contrast_in_light_and_dark_mode():
    sheet = PAGE_STYLE.read_text(encoding="utf-8")
    light, dark = (
        dict(re.findall(r"--([a-z-]+): (#[0-9a-f]{6})", part))
        for part in re.findall(r":root \{(.*?)\}", sheet, flags=re.S)
    )
    assert light.keys() == dark.keys()
    low = {
        (mode, *pair): contrast(palette[pair[0]], palette[pair[1]])
        for (mode, palette), pair in product((("light", light), ("dark", dark)), PAIRS)
        if contrast(palette[pair[0]], palette[pair[1]]) < LEAST_CONTRAST
    }
    assert low == {}


@browser
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", NAMES)
def test_no_page_is_wider_than_a_telephone_and_headings_have_one_colour(shown, name, scheme):
    page = shown(name, width=TELEPHONE, color_scheme=scheme)
    assert page.evaluate("document.documentElement.scrollWidth") == TELEPHONE
    assert len(page.evaluate(HEADINGS)) == 1
    assert page.complaints == []


@browser
@pytest.mark.parametrize("name", ["report", "series", "programs", "replay", "checker"])
def test_the_verdict_has_room_in_its_box(shown, name):
    for width in (TELEPHONE, SCREEN):
        left, top = shown(name, width=width).evaluate(ROOM)
        assert left > 12
        assert top > 5


@browser
@pytest.mark.parametrize("name", ["report", "programs", "checker"])
def test_charts_are_next_to_the_digits_where_there_is_room(shown, name):
    (left, top), (right, same) = shown(name, width=SCREEN).evaluate(BOXES)
    assert right > left + 200
    assert same == pytest.approx(top, abs=2)
    (left, top), (same, below) = shown(name, width=TELEPHONE).evaluate(BOXES)
    assert same == pytest.approx(left, abs=2)
    assert below > top + 100


@browser
def test_names_in_a_legend_stay_next_to_their_lines(shown):
    page = shown("report", width=SCREEN)
    heights = """() => [...document.querySelectorAll(".legend li[data-name]")].filter(
      (x) => x.checkVisibility()).map((x) => x.getBoundingClientRect().height)"""
    found = page.evaluate(heights)
    assert len(found) >= 3
    assert max(found) < 30


@browser
@pytest.mark.parametrize("name", NAMES)
def test_the_focus_of_the_keyboard_is_visible(shown, name):
    page = shown(name, width=SCREEN)
    found = {}
    for _ in range(STEPS_OF_KEYS):
        page.keyboard.press("Tab")
        element, is_visible = page.evaluate(FOCUS)
        if not element.startswith("<body"):
            found[element] = is_visible
    assert len(found) >= 3
    assert all(found.values()), found


def test_only_what_is_not_the_default_is_said_of_a_column(pages, reference):
    taken = re.findall('<td class="taken">(.*?)</td>', pages["report"])
    assert taken[0] == "tait_bryan_xyz, not the default lean"
    assert taken[3:] == [""] * 5
    assert "Taken as: the definition" in Page(pages["report"]).text
    named = {key: reference[2][key] for key in ("roll_angle", "steer_angle")}
    right = render(score(time=reference[2].time, maneuver=2, **named), "html", [])
    assert 'class="taken"' not in right
    assert "Taken as: " not in Page(right).text

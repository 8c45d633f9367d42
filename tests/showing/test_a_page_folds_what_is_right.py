"""Charts of a report: the worst column first, the others folded; the contents stay in sight."""

import re
from itertools import chain

import pytest

from generators import sample_reports
from heyoka_bike.scoring.grades import Grade
from heyoka_bike.showing.formats.output import render
from heyoka_bike.showing.wording.column_text import label
from heyoka_bike.showing.wording.grade_text import WORDS
from support.browser import browser

FOLDED = re.compile(r"<details><summary><h4>(.*?)</h4></summary>(.*?)</details>", re.S)


@pytest.fixture(scope="module", params=["sample", "rough", "perfect", "half"])
def report(request):
    return getattr(sample_reports, request.param)()


def chapters(report):
    """Charts of each maneuver, column by column: those that are open, those that are folded."""
    page = render(report, "html", [])
    for m in report.maneuvers:
        section = page.partition(f'<section id="maneuver-{m.maneuver}">')[2]
        each = section.partition("<h3>Column by column</h3>")[2].partition("</section>")[0]
        folded = {name: names(drawn) for name, drawn in FOLDED.findall(each)}
        yield m, names(FOLDED.sub("", each)), folded


def names(markup):
    return re.findall(r"<figcaption><b>(.*?)</b>", markup)


def test_the_worst_column_stands_first_and_open(report):
    for m, shown, _ in chapters(report):
        worst = max(c.grade for c in m.columns)
        fewest = min(c.scd for c in m.columns if c.grade == worst)
        assert shown[0] in {label(c.key) for c in m.columns if c.scd == fewest}


def test_only_wrong_columns_are_open_or_the_worst(report):
    for m, shown, folded in chapters(report):
        wrong = {label(c.key) for c in m.columns if c.grade == Grade.WRONG}
        assert {*shown} == wrong or (not wrong and len(shown) == 1)
        drawn = [*shown, *chain.from_iterable(folded.values())]
        assert sorted(drawn) == sorted(label(c.key) for c in m.columns)


def test_what_is_folded_is_named_with_its_grade(report):
    for m, _, folded in chapters(report):
        grades = {label(c.key): WORDS.get(c.grade, "not compared") for c in m.columns}
        for heading, inside in folded.items():
            said, _, listed = heading.partition(": ")
            assert listed.split(", ") == inside
            assert {grades[name] for name in inside} == {said[:1].lower() + said[1:]}


def test_definitions_are_folded():
    page = render(sample_reports.rough(), "html", [])
    assert "<h3>Which definition" in page
    assert page.count("<h3>Which definition") == page.count("<summary><h3>Which definition")


@browser
def test_the_contents_stay_in_sight_and_hide_no_heading(opened):
    page = opened(render(sample_reports.rough(), "html", []), reduced_motion="reduce")
    top, bottom, heading, scrolled = page.evaluate("""() => {
        document.querySelector("#maneuver-2").scrollIntoView({ behavior: "instant" });
        const bar = document.querySelector(".contents").getBoundingClientRect();
        const head = document.querySelector("#maneuver-2 h2").getBoundingClientRect();
        return [bar.top, bar.bottom, head.top, scrollY];
    }""")
    assert scrolled > 500
    assert top == 0
    assert heading >= bottom

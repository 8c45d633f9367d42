"""The HTML of a score is one valid, self-contained page, for every report."""

import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from generators import sample_reports
from heyoka_bike.showing.formats.output import render as rendered
from heyoka_bike.showing.wording.column_text import label
from heyoka_bike.version import __version__
from support.pages import Page

UNKNOWN: list[tuple[str, str]] = []
SAMPLES = (
    "sample", "perfect", "rough", "one_row", "half", "without_columns", "nothing", "no_maneuvers",
    "hostile", "series", "programs",
)  # fmt: skip
HEAVY = {"h5py", "heyoka", "flint", "mpmath", "scipy", "matplotlib", "rich", "plotly"}


def render(scored, made=UNKNOWN):
    return rendered(scored, "html", made)


@pytest.fixture(scope="module")
def pages():
    return {name: render(getattr(sample_reports, name)()) for name in SAMPLES}


@pytest.fixture(scope="module")
def parsed(pages):
    return {name: Page(text) for name, text in pages.items()}


@pytest.mark.parametrize("name", SAMPLES)
def test_tags_match_and_the_page_is_sound(pages, parsed, name):
    page = parsed[name]
    assert pages[name].startswith("<!DOCTYPE html>\n")
    assert page.all("html") == [{"lang": "en"}]
    assert {"name": "viewport", "content": "width=device-width, initial-scale=1"} in page.all(
        "meta"
    )
    ids = [a["id"] for _, a in page.tags if "id" in a]
    assert len(set(ids)) == len(ids)
    links = [a["href"] for a in page.all("a")]
    assert set(links) <= {f"#{i}" for i in ids}
    assert len(links) >= (1 if name != "no_maneuvers" else 0)
    levels = [int(tag[1]) for tag, _ in page.tags if re.fullmatch("h[1-6]", tag)]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert max(np.diff(levels), default=0) <= 1
    assert all(a.get("scope") in ("row", "col") for a in page.all("th"))
    assert all(a.get("aria-label") or a.get("aria-hidden") or "class" in a for a in page.all("svg"))
    assert len([a for a in page.all("svg") if a.get("role") == "img"]) == len(
        re.findall('<div class="plot">', pages[name])
    )
    assert len(page.all("figure")) == len(page.all("figcaption"))


@pytest.mark.parametrize("name", SAMPLES)
def test_nothing_is_loaded(pages, parsed, name):
    page = parsed[name]
    for tag, attributes in page.tags:
        for key, value in attributes.items():
            if key in ("src", "href", "xlink:href", "data", "srcset", "action", "style"):
                assert value.startswith(("#", "data:")), (tag, key, value)
    # The style and the script contain no addresses except the palette's source and the namespace of
    # SVG.
    urls = set(re.findall(r"https?://[^\s\"'<>)]+", pages[name]))
    assert urls <= {"https://jfly.uni-koeln.de/color/.", "http://www.w3.org/2000/svg"}
    assert not re.search(r"url\(|@import|\bfetch\b|XMLHttpRequest|\bimport\b", pages[name])
    policy = [a["content"] for a in page.all("meta") if "http-equiv" in a]
    assert policy[0].startswith("default-src 'none';")


@pytest.mark.parametrize("name", SAMPLES)
def test_no_number_is_missing_its_digits(parsed, name):
    page = parsed[name]
    assert not re.search(r"\bNone\b|(?i:\bnan\b|\binf\b|\binfinity\b)", page.text)
    for _, attributes in page.tags:
        for key, value in attributes.items():
            if key not in ("content", "aria-label", "title"):
                assert not re.search(r"\bNone\b|(?i:\bnan\b|\binf\b)", value or ""), (key, value)


def test_hostile_names_stay_text(pages, parsed):
    page = parsed["hostile"]
    assert len(page.all("script")) == 1
    assert not any(key.startswith("on") for _, a in page.tags for key in a)
    # The hostile text is in the path, the requirement and its message, the finding, each maneuver,
    # and the bicycle.
    assert page.text.count("</script><b onclick=alert(1)>&\"'\\x1b[31m\\x00\\udcff") >= 8
    pages["hostile"].encode()
    assert not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\ufffe]", pages["hostile"])


def test_the_verdict_is_in_words(parsed):
    text = {name: page.text for name, page in parsed.items()}
    assert (
        "≈ Close; the worst column has 4.1 correct digits (steer_rate in maneuver 1)."
        in text["sample"]
    )
    assert "✓ Both requirements are met" in text["sample"]
    assert "in maneuver 2. The file passes with 5.3e-06 % (limit 1e-3 %)" in text["sample"]
    assert "✗ 1 of 3 requirements FAILED" in text["rough"]
    assert "in maneuver 2. The file FAILS with 1.6 %" in text["rough"]
    assert "✗ Wrong; the worst column has no correct digits" in text["rough"]
    assert "≈ Close, compared only in part; the worst" in text["half"]
    assert "covers 50 % of each maneuver" in text["half"]
    assert "✓ Right; no column has an error." in text["perfect"]
    assert "Nothing could be compared." in text["nothing"]
    assert "Remark" not in text["nothing"]
    assert "observed order 4.0" in text["series"]
    assert "Fine is the best of 3 programs: right; the worst column" in text["programs"]


def test_true_error_leads_and_eq_1_is_a_remark(pages):
    for name, style in (("rough", "wrong"), ("sample", "close"), ("perfect", "right")):
        page = pages[name]
        order = (f'<p class="verdict {style}">', '<table class="matrix">', '<p class="remark">',
                 '<section id="findings">')  # fmt: skip
        places = [page.index(part) for part in order]
        assert places == sorted(places)
        # Colours show the true error and the requirements. No text about eq. (1) has a colour.
        colored = re.findall(r'<\w+ class="[^"]*(?:right|close|wrong|passed)[^"]*">[^<]*', page)
        assert colored
        assert not any("eq. (1)" in x.lower() for x in colored)


def test_right_in_part_is_not_shown_as_right():
    report = sample_reports.sample(1e-9)
    first, *rest = report.maneuvers
    assert '<p class="verdict right">' in render(report)
    for coverage, style in ((0.5, "close"), (0.995, "right")):
        short = (replace(first, coverage=coverage), *rest)
        assert f'<p class="verdict {style}">' in render(replace(report, maneuvers=short))


@pytest.mark.parametrize("name", SAMPLES)
def test_every_mark_is_explained_and_nothing_needs_a_pointer(pages, parsed, name):
    page = parsed[name]
    assert not any("title" in attributes for _, attributes in page.tags)
    # Each cell shows its grade by a sign and a word, not by colour alone. The signs are explained
    # below the table.
    for table in re.findall(r'<table class="matrix">.*?</ul>', pages[name], flags=re.S):
        cells = re.findall(r'<td class="(right|rounded|close|wrong)">(.*?)</td>', table)
        for style, cell in cells:
            sign = re.search(r'<b aria-hidden="true">(.)</b>', cell)[1]
            word = "right" if style == "rounded" else style
            assert f'<b class="{style}">{sign}</b> {word}' in table
            assert '<span class="spoken"> ' in cell
    for mark, meaning in (("*", "* is not the default"), ("~", "~ others fit as well")):
        for scores in re.findall(r'<table class="scores">.*?</p>', pages[name], flags=re.S):
            # The first cells of the table are those of the definitions.
            cells = re.findall(r"</th><td>([^<]*)", scores)
            assert (meaning in scores) == any(mark in cell for cell in cells)


def test_the_foot_says_where_a_page_comes_from(parsed):
    command = "heyoka-bike score 'a b.txt' -o <x>.html"
    made = [("made", "2026-11-22 09:30 UTC"), ("command", command)]
    report = sample_reports.sample()
    text = render(report, made)
    foot = Page(text[text.index("<footer>") : text.index("</footer>") + 9]).text
    version = f"heyoka_bike {__version__}"
    for part in ("2026-11-22 09:30 UTC", command, version, report.dataset_version):
        assert part in foot
    assert report.reference_sha256 in foot
    assert text == render(sample_reports.sample(), made)


def test_tables_hold_every_score(pages):
    report = sample_reports.sample()
    rows = re.findall(r'<tr><th scope="row">(.*?)</tr>', pages["sample"])
    rows = [row for row in rows if "<td class" not in row]
    columns = [c for m in report.maneuvers for c in m.columns]
    assert len(rows) == len(columns)
    for row, c in zip(rows, columns, strict=True):
        cells = re.findall("<td>(.*?)</td>", row)
        m = c.as_understood.measures
        assert row.startswith(c.key.replace("_", " "))
        assert cells[1] == f"{m.max_abs_error:.2e}"
        assert cells[3] == f"{m.rms_error:.2e}"
        assert cells[5] == f"{m.scd:.1f}"
        assert cells[8] == "never"
        assert cells[9] == f"{c.as_written.measures.max_abs_error:.1e}"


def test_findings_and_requirements_are_said(parsed):
    report = sample_reports.rough()
    text = parsed["rough"].text.lower()
    for finding in report.findings:
        assert finding.message.lower() in text
    assert text.index("warning 3 values are not finite") < text.index("info roll_angle")
    for requirement in report.requirements:
        assert f"{requirement.text} found {requirement.message}" in text


def figures(page):
    return re.findall("<figure.*?</figure>", page, flags=re.S)


def line(figure, name):
    """Return a line of a figure as values, from its path and the axes of its chart."""
    for part in figure.split('<div class="plot">')[1:]:
        found = re.search(rf'<path class="[^"]*" data-name="{name}"[^>]* d="M([^"]*)"', part)
        if found:
            ends = [re.search(rf'data-{k}="([^"]*)"', part)[1].split() for k in "xy"]
            points = np.array(re.findall(r"-?\d+", found[1]), dtype=float).reshape(-1, 2)
            x, y = points.cumsum(axis=0).T
            places = (x / 4000, 1 - y / 2000)
            values = []
            for (low, high, is_log, offset), at in zip(ends, places, strict=True):
                value = float(low) + (float(high) - float(low)) * at
                values.append(10**value if is_log == "1" else value + float(offset))
            return values
    return None


def test_each_column_is_drawn_with_its_reference_and_error(pages):
    report = sample_reports.sample()
    top, *drawn = [f for f in figures(pages["sample"]) if 'data-name="reference"' in f]
    assert len(drawn) == 24
    # The chart of the worst column of all maneuvers is also drawn at the top of the page, next to
    # the digits.
    assert top == drawn[[m.maneuver for m in report.maneuvers].index(report.worst.maneuver) * 8]
    assert pages["sample"].index(top) < pages["sample"].index("</header>")
    for i, figure in enumerate(drawn):
        # The first chart of a maneuver is that of its worst column.
        m = report.maneuvers[i // 8]
        called = re.search("<figcaption><b>(.*?)</b>", figure)[1]
        (c,) = (c for c in m.columns if label(c.key) == called)
        for name, expected in (("reference", c.trace.reference), ("result", c.trace.value)):
            t, value = line(figure, name)
            span = max(np.ptp(expected), 1e-5 * np.abs(expected).max())
            np.testing.assert_allclose(
                value, np.interp(t, c.trace.time, expected), atol=0.02 * span, rtol=0
            )
        t, error = line(figure, "error")
        largest = c.as_understood.measures
        assert error.max() == pytest.approx(largest.max_abs_error, rel=0.02)
        exact = np.interp(t, c.trace.time, np.abs(c.trace.error))
        far = exact > 0.05 * exact.max()  # only rows that are not near the zero crossing
        np.testing.assert_allclose(error[far], exact[far], rtol=0.05)
        assert f'<path class="floor" d="M0 {floor_place(figure, c.floor)}h4000"/>' in figure


def floor_place(figure, floor):
    low, high, *_ = re.findall('data-y="([^"]*)"', figure)[1].split()
    return round(2000 * (1 - (np.log10(floor) - float(low)) / (float(high) - float(low))))


def test_all_errors_are_drawn_relative_to_their_scale(pages):
    report = sample_reports.sample()
    drawn = [f for f in figures(pages["sample"]) if 'data-name="steer rate"' in f]
    assert len(drawn) == 3
    for figure, m in zip(drawn, report.maneuvers, strict=True):
        assert figure.count('class="tolerance"') == 1
        assert figure.count("<title>") == 8
        for c in m.columns:
            _, error = line(figure, c.key.replace("_", " "))
            assert error.max() == pytest.approx(c.as_understood.measures.max_rel_error, rel=0.02)


def test_every_definition_is_listed_with_its_error(pages):
    report = sample_reports.sample()
    text = pages["sample"]
    assert text.count('<table class="dots">') == 3 * 3
    assert text.count('<circle class="full"') == 9
    assert text.count('<circle class="open"') == sum(
        len(c.alternatives) for m in report.maneuvers for c in m.columns
    )
    for c in report.maneuvers[0].columns:
        for a in c.alternatives:
            assert f'<td class="n">{a.max_abs_error:.2e}</td>' in text


def test_no_error_is_said_and_not_drawn(pages, parsed):
    text = parsed["perfect"].text
    assert text.count("The error is exactly 0 in every row of every column.") == 3
    assert text.count("The error is exactly 0 in every row.") == 24
    assert 'data-name="result"' in pages["perfect"]


def test_one_row_is_drawn_as_points(pages):
    drawn = [f for f in figures(pages["one_row"]) if 'data-name="reference"' in f]
    assert len(drawn) == 24
    assert all(f.count("<circle") == 3 and "one row only" in f for f in drawn)


def test_what_cannot_be_compared_is_said(pages, parsed):
    assert parsed["without_columns"].text.count("Nothing could be compared.") >= 8 + 1 + 1
    assert 'data-name="result"' not in pages["nothing"]


def test_a_series_is_drawn_against_steps_and_times(pages):
    series = sample_reports.series()
    drawn = figures(pages["series"])
    by_step = [f for f in drawn if "step size [s]" in f]
    by_time = [f for f in drawn if "processor time [s]" in f]
    assert len(by_step) == len(by_time) == 3
    expected = [r.report.maneuvers[0].columns[0].as_understood.measures for r in series.runs]
    for figure, across in ((by_step[0], "step"), (by_time[0], "cpu")):
        x, y = line(figure, "roll angle")
        np.testing.assert_allclose(x, [getattr(r, across) for r in series.runs], rtol=2e-3)
        np.testing.assert_allclose(y, [m.max_rel_error for m in expected], rtol=0.02)
    assert re.findall(">(p = [0-9]+)<", by_step[0]) == ["p = 3", "p = 4", "p = 5"]
    slopes = [slope(g, by_step[0]) for g in re.findall('class="guide" d="([^"]*)"', by_step[0])]
    assert slopes == pytest.approx([3, 4, 5], rel=0.01)
    assert all(f.count('class="guide"') == 0 for f in by_time)
    plain = render(sample_reports.series(cpu=False, steps=False))
    assert not re.search(r"step size \[s\]|processor time \[s\]", plain)
    Page(plain)


def test_programs_are_drawn_side_by_side(pages, parsed):
    series = sample_reports.programs()
    drawn = [f for f in figures(pages["programs"]) if 'data-name="Fine"' in f]
    columns = [c for m in series.runs[0].report.maneuvers for c in m.columns]
    assert len(drawn) == len(columns) == 24
    for figure, c in zip(drawn, columns, strict=True):
        _, error = line(figure, "Fine")
        assert error.max() == pytest.approx(c.as_understood.measures.max_rel_error, rel=0.05)
        assert line(figure, "Rough") is not None
    assert "runs of one program" not in parsed["programs"].text
    assert "step" not in parsed["programs"].text


def slope(path, figure):
    """Return the decades of error per decade of step."""
    x1, y1, x2, y2 = (float(x) for x in re.findall(r"-?\d+", path))
    wide, high = (re.search(f'data-{k}="([^"]*)"', figure)[1].split() for k in "xy")
    across = (x2 - x1) / 4000 * (float(wide[1]) - float(wide[0]))
    return (y1 - y2) / 2000 * (float(high[1]) - float(high[0])) / across


def test_files_stay_small(pages):
    # The page is rendered first with the benchmark's 1001 rows of 24 columns, then with far more
    # rows than any user's file has.
    assert len(pages["sample"].encode()) < 700_000
    many = render(sample_reports.many_rows(200_000))
    assert len(many.encode()) < 700_000
    # A single bad row must remain visible in the chart.
    drawn = [f for f in figures(many) if 'data-name="reference"' in f]
    for figure in drawn:
        t, error = line(figure, "error")
        assert error.max() == pytest.approx(5.0, rel=0.02)
        assert t[np.argmax(error)] == pytest.approx(10 / 3, abs=0.01)


def test_all_renderers_need_numpy_only():
    code = f"""
import sys
from heyoka_bike.showing.document import html, text
from heyoka_bike.showing.formats import csv, json, junit, report_document, summary
print(sorted({{m.partition(".")[0] for m in sys.modules}} & {HEAVY}))
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert run.stdout == "[]\n", run.stderr


def test_the_same_report_gives_the_same_page(pages):
    assert render(sample_reports.sample()) == pages["sample"]

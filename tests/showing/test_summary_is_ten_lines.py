"""The summary of a score has at most ten lines for any report; the verdict is the first."""

import re
from dataclasses import replace

import pytest

from generators import sample_reports
from heyoka_bike.scoring.findings import Finding
from heyoka_bike.showing.formats import summary

SAMPLES = (
    "sample", "perfect", "rough", "one_row", "half", "without_columns", "nothing", "no_maneuvers",
    "hostile", "series", "programs",
)  # fmt: skip


def text_of(name, width=100, color=False):
    return summary.render(getattr(sample_reports, name)(), width, color)


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize("width", [60, 80, 100, 200])
def test_it_has_ten_lines_at_most_and_fits(name, width):
    lines = text_of(name, width).splitlines()
    assert len(lines) <= 10
    assert max(map(len, lines)) <= min(width, 100)
    assert text_of(name, width).isascii()


def test_nine_runs_have_no_more_lines():
    series = sample_reports.series()
    many = replace(series, runs=series.runs * 3)
    text = summary.render(many, 80, False)
    assert len(text.splitlines()) <= 10
    assert "and 9 more" in text


def test_it_answers_in_this_order():
    text = text_of("rough")
    names = ("digits", "worst", "conventions", "eq. (1)", "required", "warnings", "next")
    assert text.partition(": ")[2].startswith("wrong; the worst column")
    places = [text.index(f"\n  {name} ") for name in names]
    assert places == sorted(places)
    assert "maneuver 1: 0.0, maneuver 2: 0.0" in re.sub(r"-[0-9.]+", "0.0", text)
    assert "roll_angle tait_bryan_xyz, not the default lean" in text
    assert "1 of 3 requirements FAILED: scd >= 6" in text
    assert "1 warning: 3 values are not finite and were left out" in text
    assert "heyoka-bike diagnose runs/other-h0.001.txt" in text


@pytest.mark.parametrize(
    ("report", "says"),
    [
        (sample_reports.perfect, "to test this, add to this command: --require 'scd >= 12'"),
        (sample_reports.nothing, "nothing in it could be compared"),
        (lambda: sample_reports.sample(1e-9), "--require 'scd >= 8' --require 'coverage >= 1'"),
        (lambda: _part(sample_reports.sample(1e-9)), "write rows over the whole run"),
        (lambda: _gap(sample_reports.sample(1e-9)), "check why some values are not finite"),
        (lambda: _rounded(sample_reports.sample()), "write the values unrounded"),
        (lambda: _explained(sample_reports.rough()), "gravity is 9.8"),
        (sample_reports.series, "for the report of the finest run"),
        (sample_reports.programs, "for the report of the best program"),
    ],
)  # fmt: skip
def test_it_says_what_to_do_next(report, says):
    assert says in summary.render(report(), 100, False).splitlines()[-1]


def _part(report):
    return replace(report, maneuvers=tuple(replace(m, coverage=0.4) for m in report.maneuvers))


def _gap(report):
    first, *others = report.maneuvers
    column, *columns = first.columns
    columns = (replace(column, missing=1), *columns)
    return replace(report, maneuvers=(replace(first, columns=columns), *others))


def _rounded(report):
    """The report with no other error than the rounding of the digits written."""
    maneuvers = tuple(
        replace(m, columns=tuple(replace(c, unexplained=0.0, resolution=1e9) for c in m.columns))
        for m in report.maneuvers
    )
    return replace(report, maneuvers=maneuvers)


def _explained(report):
    return replace(report, diagnosis=(Finding("mistake", "gravity is 9.8"),))

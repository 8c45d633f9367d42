"""The table of a score fits its width, cuts no number, and reads well in a plain pipe."""

import re
from dataclasses import replace

import pytest
from support import sample_reports

from heyoka_bike.showing.formats import table

SAMPLES = (
    "sample", "perfect", "rough", "one_row", "half", "without_columns", "nothing", "no_maneuvers",
    "hostile", "series",
)  # fmt: skip


def text_of(name, width=100, color=False):
    return table.render(getattr(sample_reports, name)(), width, color)


def with_long_definitions(report):
    """Every column with the longest name of a definition, marked, and all notes."""
    maneuvers = []
    for m in report.maneuvers:
        columns = []
        for c in m.columns:
            reading = replace(
                c.as_understood, definition="tait_bryan_xyz_rate", sign=-1, unit="mm s-1",
                offset=-7.94e-300,
            )  # fmt: skip
            columns.append(replace(c, as_understood=reading))
        maneuvers.append(replace(m, columns=tuple(columns)))
    return replace(report, maneuvers=tuple(maneuvers))


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize("width", [80, 100, 137])
def test_lines_are_no_longer_than_the_width(name, width):
    assert max(map(len, text_of(name, width).split("\n"))) <= width


def test_all_columns_fit_into_100():
    for report in (sample_reports.rough(), with_long_definitions(sample_reports.sample())):
        text = table.render(report, 100, False)
        assert max(map(len, text.split("\n"))) <= 100
        for heading in ("rms", "rel.", "scd", "mescd", "floor", "1e-3 [s]"):
            assert re.search(rf"(?m)^.*{re.escape(heading)}(?: .*)?$", text), heading


@pytest.mark.parametrize("width", [1, 40, 60])
def test_a_narrow_terminal_leaves_columns_out_but_cuts_nothing(width):
    report = sample_reports.sample()
    text = table.render(report, width, False)
    assert "…" not in text
    for m in report.maneuvers:
        for c in m.columns:
            assert f"{c.key} [" in text
            assert f"{c.as_understood.measures.max_abs_error:.1e}" in text
    assert "mescd " not in text.partition("* is not")[0]


@pytest.mark.parametrize("name", SAMPLES)
def test_plain_text_has_no_colours_and_no_box_letters(name):
    text = text_of(name)
    assert text.isascii()
    assert "\x1b" not in text
    assert not re.search(r"(?m) $", text)


@pytest.mark.parametrize("name", SAMPLES)
def test_colours_change_nothing_else(name):
    colored = text_of(name, color=True)
    assert "\x1b[1" in colored
    stripped = re.sub(r"\x1b\[[0-9;]*m", "", colored)
    lines = [line.rstrip() for line in stripped.split("\n")]
    assert "\n".join(lines) == text_of(name)


def test_the_verdict_comes_first():
    text = " ".join(text_of("sample").split())
    assert text.startswith(
        "runs/other-h0.001.txt: 1001 rows, 0 to 10 s, 12 digits written; worst column 4.1 correct "
        "digits (maneuver 1 steer_rate); eq. (1) of maneuver 2: 5.3e-06 % (passes, below 1e-3 %); "
        "all 2 requirements met"
    )
    text = " ".join(text_of("rough").split())
    assert "worst column without a correct digit (maneuver 1 steer_rate, wrong by 23 times" in text
    assert "1.6 % (FAILS, not below 1e-3 %); 1 of 3 requirements FAILED" in text
    assert "covers 50 % of maneuver 1" in " ".join(text_of("half").split())
    assert "no error in any column" in text_of("perfect")
    assert "nothing could be compared" in text_of("nothing")


def test_what_is_not_complete_does_not_read_as_100_percent():
    report = sample_reports.sample()
    (first, *rest) = report.maneuvers
    short = replace(report, maneuvers=(replace(first, coverage=0.99996), *rest))
    text = table.render(short, 100, False)
    assert "covers 99.9 % of maneuver 1" in " ".join(text.split())
    assert "covers" not in text_of("sample")


def test_marks_say_how_a_column_was_understood():
    assert "* is not the default definition" in text_of("sample")
    lines = text_of("sample").split("\n")
    (first, *_) = [line for line in lines if line.startswith("roll_angle")]
    assert "tait_bryan_xyz*" in first
    assert first.endswith("never")
    assert any(line.strip() == "sign -1" for line in lines)
    assert any(line.strip() == "deg/s" for line in lines)
    assert any(line.strip() == "offset -794.12" for line in lines)
    assert not any("lean_rate*" in line for line in lines)


def test_unknown_is_a_dash():
    (line, *_) = [x for x in text_of("nothing").split("\n") if x.startswith("roll_angle")]
    assert line.split()[3:] == ["-"] * 7


def test_warnings_come_before_the_rest_and_requirements_last():
    text = text_of("rough")
    order = ["eq. (1) of the", "the file against itself", "WARNING", "info", "ok  ", "FAILED  "]
    places = [text.index(part) for part in order]
    assert places == sorted(places)


def test_a_series_shows_errors_orders_and_times():
    text = text_of("series")
    blocks = text.split("maneuver 1: largest errors, and observed orders between them\n")
    assert len(blocks) == 2
    rows = [line.split() for line in blocks[1].partition("\n\n")[0].split("\n")]
    assert [row[0] for row in rows[4:]] == [
        "0.01", "order", "0.005", "order", "0.0025", "order", "0.00125", "extrapol.", "floor",
    ]  # fmt: skip
    series = sample_reports.series()
    expected = [f"{c.errors[0]:.1e}" for c in series.convergence[:8]]
    assert rows[4] == ["0.01", "2", *expected]
    assert "4.0" in rows[5]


def test_a_series_without_steps_or_times_says_less():
    text = table.render(sample_reports.series(cpu=False, steps=False), 100, False)
    assert "CPU" not in text
    assert "order  " not in text
    assert "step [s]" not in text
    assert "the best one: worst column 7.7" in text

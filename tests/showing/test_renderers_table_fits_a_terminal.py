"""The table of a score fits its width, cuts no number, and reads well in a plain pipe."""

import re
from dataclasses import replace

import pytest

from generators import sample_reports
from heyoka_bike.showing.formats.output import render as rendered
from heyoka_bike.version import __version__

UNKNOWN = []
SAMPLES = (
    "sample", "perfect", "rough", "one_row", "half", "without_columns", "nothing", "no_maneuvers",
    "hostile", "series", "programs",
)  # fmt: skip


def render(scored, width, has_colors=False, made=UNKNOWN):
    return rendered(scored, "table", made, width=width, has_colors=has_colors)


def text_of(name, width=100, color=False):
    return render(getattr(sample_reports, name)(), width, color)


def with_long_definitions(report):
    """The report with the longest name of a definition in every column, with marks
    and all notes."""
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
        text = render(report, 100, False)
        assert max(map(len, text.split("\n"))) <= 100
        for heading in ("rms", "rel.", "scd", "mescd", "floor", "1e-3 [s]"):
            assert re.search(rf"(?m)^.*{re.escape(heading)}(?: .*)?$", text), heading


@pytest.mark.parametrize("width", [1, 40, 60])
def test_a_narrow_terminal_leaves_columns_out_but_cuts_nothing(width):
    report = sample_reports.sample()
    text = render(report, width, False)
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


def test_the_verdict_by_true_error_comes_first():
    text = " ".join(text_of("sample").split())
    assert text.startswith(
        "runs/other-h0.001.txt: close; the worst column has 4.1 correct digits (steer_rate in "
        "maneuver 1); both requirements are met 1001 rows, 0 to 10 s, 12 digits written, text "
        "file; 1 warning"
    )
    text = " ".join(text_of("rough").split())
    assert (
        "wrong; the worst column has no correct digits (steer_rate in maneuver 1, wrong by" in text
    )
    assert "1 of 3 requirements FAILED" in text
    assert "The file FAILS with 1.6 % (limit" in " ".join(text.split())
    assert "close, compared only in part; the worst" in " ".join(text_of("half").split())
    assert "covers 50 % of each maneuver" in " ".join(text_of("half").split())
    assert "right; no column has an error" in text_of("perfect")
    assert "nothing could be compared" in text_of("nothing")


def test_correct_digits_of_all_columns_and_maneuvers_follow_the_verdict():
    report = sample_reports.sample()
    text = text_of("sample")
    block = text.partition("\ncorrect digits")[2].partition("\n\n")[0].split("\n")
    rows = {line.split()[0]: line.split()[1:] for line in block[2:10]}
    for i, m in enumerate(report.maneuvers):
        for c in m.columns:
            scd = c.as_understood.measures.scd
            digits, sign = rows[c.key][2 * i : 2 * i + 2]
            assert digits == f"{scd:.1f}"
            assert sign == ("+" if scd >= 6 else "o" if scd >= 3 else "x")
    assert "+ right: 6 correct digits or more" in text
    assert "o close: 3 to 6 digits" in text
    assert "x wrong" not in text  # no cell of this table has this sign
    assert "x wrong: fewer than 3 digits" in text_of("rough")


def test_a_file_of_very_many_columns_shows_the_worst_of_them():
    report = sample_reports.sample()
    (m, *_) = report.maneuvers
    columns = tuple(replace(c, key=f"{c.key}_{i}") for i in range(9) for c in m.columns)
    text = render(replace(report, maneuvers=(replace(m, columns=columns),)), 100, False)
    assert "and 60 more columns, none with fewer digits" in text
    block = text.partition("\ncorrect digits")[2].partition("\n\n")[0]
    assert block.count("steer_rate_") == 9


def test_what_is_not_complete_does_not_read_as_100_percent():
    report = sample_reports.sample()
    (first, *rest) = report.maneuvers
    short = replace(report, maneuvers=(replace(first, coverage=0.99996), *rest))
    text = render(short, 100, False)
    assert "covers 99.9 % of maneuver 1" in " ".join(text.split())
    assert "covers" not in text_of("sample")


def test_marks_say_how_a_column_was_understood():
    lines = text_of("sample").split("\n")
    (taken, first, *_) = [line for line in lines if line.startswith("roll_angle")]
    assert taken.endswith("tait_bryan_xyz, not the default lean")
    assert "lean_rate, may also be zyx_rate, in deg/s" in text_of("sample")
    # The marks are explained below each table that uses them.
    marks = "* is not the default definition; ~ others fit as well: zyx_rate of roll rate"
    assert lines.count(marks) == 3
    assert "tait_bryan_xyz*" in first
    assert first.endswith("never")
    assert any(line.strip() == "sign -1" for line in lines)
    assert any(line.strip() == "deg/s" for line in lines)
    assert any(line.strip() == "offset -794.12" for line in lines)
    assert not any("lean_rate*" in line for line in lines)


def test_unknown_is_a_dash():
    (brief, line, *_) = [x for x in text_of("nothing").split("\n") if x.startswith("roll_angle")]
    assert brief.split()[1:3] == ["-", "-"]
    assert line.split()[3:] == ["-"] * 7


def test_what_matters_most_comes_first():
    text = text_of("rough")
    order = [
        "wrong; the worst", "correct digits", "remark: eq. (1)", "WARNING", "info", "ok  ",
        "FAILED  ", "maneuver 1: 1001 rows", "eq. (1), 100 (max E - min E) / E0",
        "potential + kinetic -", "by: ",
    ]  # fmt: skip
    places = [text.index(part) for part in order]
    assert places == sorted(places)


def test_the_foot_says_where_a_report_comes_from():
    made = [("made", "2026-11-22 09:30 UTC"), ("command", "heyoka-bike score a.txt")]
    report = sample_reports.sample()
    foot = render(report, 100, False, made)[-400:]
    version = f"heyoka_bike {__version__}"
    for part in (made[0][1], made[1][1], version, report.dataset_version):
        assert part in foot
    assert report.reference_sha256 in foot
    assert len(report.reference_sha256) == 64


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
    text = render(sample_reports.series(cpu=False, steps=False), 100, False)
    assert "CPU" not in text
    assert "order  " not in text
    assert "step [s]" not in text
    assert "the best one: right; the worst column has 7.7" in text


def test_programs_are_named_and_not_asked_for_steps():
    text = text_of("programs")
    assert text.startswith("Fine is the best of 3 programs: right; the worst column")
    assert "step" not in text.partition("\n\nfindings")[0]
    overview = text.partition("worst column  ")[2].partition("\n\n")[0]
    assert [line.split()[0] for line in overview.split("\n")[2:5:2]] == ["Fine", "Rough"]
    assert text.count(": correct digits\n") == 3

"""``--require`` takes the worst value over all that is not named; what is not compared cannot
pass."""

from dataclasses import fields, replace

import numpy as np
import pytest

from generators.made_results import codes, made, smooth_error
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.evidence.contradictions import CoveredInPart
from heyoka_bike.scoring.outcomes import NothingCompared
from heyoka_bike.scoring.reading.results import Results, Rows
from heyoka_bike.scoring.requirements import check, parse
from heyoka_bike.scoring.score import score
from heyoka_bike.scoring.scores import Measures

# Sizes of the largest errors by maneuver and column. Every other column is exact.
SIZES = {(1, "roll_angle"): 1e-6, (2, "roll_angle"): 1e-5, (2, "steer_rate"): 1e-4}


@pytest.fixture(scope="module")
def results(reference):
    def change(key, values, number):
        return values + smooth_error(reference, number, SIZES.get((number, key), 0.0))

    return made(reference, change)


@pytest.mark.parametrize(
    ("text", "met", "found"),
    [
        ("max_abs_error < 1.01e-4", True, 1e-4),
        ("max_abs_error < 0.99e-4", False, 1e-4),
        ("2.max_abs_error < 1.01e-4", True, 1e-4),
        ("1.max_abs_error < 1.01e-6", True, 1e-6),
        ("roll_angle.max_abs_error<=1.01E-5", True, 1e-5),
        ("1.roll_angle.max_abs_error <= 1.01e-6", True, 1e-6),
        ("maneuver_1.roll_angle.max_abs_error <= 0.99e-6", False, 1e-6),
        ("m1 . roll_angle . max_abs_error > 0.99e-6", True, 1e-6),
        ("time_to_tolerance >= 10", True, None),
        ("time_to_tolerance < 10", False, None),
        ("coverage >= 1", True, 1.0),
        ("performance < 1e-3", True, 0.0),
        ("performance > 0", False, 0.0),
    ],
)
def test_the_worst_decides(reference, results, text, met, found):
    report = score(results, reference, [text])
    (requirement,) = report.requirements
    assert requirement.text == text
    assert requirement.met is met
    assert report.passed is met
    if found is None:
        assert requirement.found is None
    else:
        assert requirement.found == pytest.approx(found, rel=1e-6)


def test_digits_are_those_of_the_worst_column(reference, results):
    found = score(results, reference, ["scd >= 0", "2.steer_rate.scd >= 0"]).requirements
    assert found[0].found == found[1].found
    digits = -np.log10(1e-4 / np.max(np.abs(reference[2].rows["steer_rate"])))
    assert found[0].found == pytest.approx(digits, rel=1e-9)
    assert found[0].message == f"{digits:.3g} (maneuver 2, steer_rate)"


def test_all_have_to_be_met(reference, results):
    report = score(results, reference, ["scd >= 1", "scd >= 20"])
    assert [r.met for r in report.requirements] == [True, False]
    assert not report.passed


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300])
def test_a_value_that_is_no_number_fails_whatever_the_rest(reference, bad):
    def change(key, values, number):
        if (number, key) == (3, "steer_angle"):
            values[700:] = bad
        return values

    report = score(made(reference, change), reference, ["scd >= 1", "3.steer_angle.scd >= -99"])
    assert [r.met for r in report.requirements] == [False, False]
    assert "301 of 1001 values not finite" in report.requirements[0].message
    report = score(made(reference, change), reference, ["1.roll_angle.scd >= 1", "1.scd >= 1"])
    assert report.passed


def test_a_run_that_ends_in_nan_does_not_pass_for_its_beginning(reference):
    def change(key, values, number):
        values[601:] = np.nan
        return values

    require = ["coverage >= 0.5", "performance < 1e-3", "2.performance < 1e-3"]
    report = score(made(reference, change), reference, require)
    assert not any(r.met for r in report.requirements)
    assert [(m.t_end, m.coverage) for m in report.maneuvers] == [(6.0, 0.6)] * 3
    assert "coverage" in codes(report)


def test_what_is_not_in_the_file_fails(reference):
    all_of_it = made(reference)
    part = all_of_it.maneuvers[0]
    without = {k: v for k, v in part.values.items() if "energy" not in k}
    only = Results("one", "text", (type(part)(1, part.time, part.time_lo, without),))
    report = score(only, reference, ["2.scd >= 1", "kinetic_energy.scd >= 1", "performance < 1"])
    assert [r.message for r in report.requirements] == [
        "no maneuver 2 in the file", "no kinetic_energy in the file",
        "no mechanical energy in maneuver 1",
    ]  # fmt: skip
    assert not any(r.met for r in report.requirements)
    assert codes(report) == []


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "expected [maneuver.][column.]metric op number"),
        ("scd", "expected [maneuver.]"),
        ("scd >= ", "expected [maneuver.]"),
        ("scd == 6", "expected [maneuver.]"),
        ("scd >= six", "expected [maneuver.]"),
        ("scd >= nan", "expected [maneuver.]"),
        ("scd >= 1e999", "expected a finite number"),
        ("scd >= ६", "expected [maneuver.]"),
        ("1.2.scd >= 6", "expected [maneuver.]"),
        ("accuracy >= 6", "expected one of scd, mescd"),
        ("roll.scd >= 6", "expected one of roll_angle, roll_rate"),
        ("roll_angle.performance < 1", "of a whole maneuver"),
        ("scd\n>=\x1b[31m6", "expected [maneuver.]"),
    ],
)
def test_others_are_refused_in_one_line(text, says):
    with pytest.raises(InputError) as raised:
        parse(text)
    message = str(raised.value)
    assert message.startswith("require: found")
    assert says in message
    assert message.isprintable()


@pytest.mark.parametrize("pair", [("roll_angle", "roll_rate"), ("steer_angle", "steer_rate")])
def test_signs_that_no_choice_of_axes_gives_fail(reference, pair):
    """Axes to the left flip both an angle and its rate. If only one of them is flipped, it is a
    mistake."""
    for turned, met in ((pair, True), (pair[:1], False), (pair[1:], False)):

        def change(key, values, number, turned=turned):
            return -values if key in turned else values

        report = score(made(reference, change), reference, ["scd >= 6", "forward_speed.scd >= 6"])
        assert [r.met for r in report.requirements] == [met, True]
        if not met:
            assert f"{pair[0]} and {pair[1]} have opposite" in report.requirements[0].message


@pytest.mark.parametrize(
    ("name", "rows", "gap"),
    [
        ("the ends", [0, 1000], 10.0),
        ("the first tenth of a second and the end", [*range(11), 1000], 9.9),
        ("the first second and the end", [*range(101), 1000], 9.0),
        ("the last nine seconds", range(100, 1001), 1.0),
        ("a hole of a second", [*range(401), *range(500, 1001)], 1.0),
    ],
)
def test_rows_that_leave_the_motion_unseen_cover_little(reference, name, rows, gap):
    whole = made(reference)
    few = Results("x", "text", tuple(chosen(m, list(rows)) for m in whole.maneuvers))
    report = score(
        few, reference, ["scd >= 6", "coverage >= 1", "gap < 0.9", f"gap <= {gap + 1e-9}"]
    )
    assert [r.met for r in report.requirements] == [True, False, False, True]
    assert all(m.gap == pytest.approx(gap) for m in report.maneuvers)
    assert "coverage" in codes(report)


def test_rows_of_every_quarter_of_a_second_cover_the_run(reference):
    whole = made(reference)
    few = Results("x", "text", tuple(chosen(m, range(0, 1001, 25)) for m in whole.maneuvers))
    report = score(few, reference, ["coverage >= 1", "gap <= 0.2500001"])
    assert report.passed
    assert report.is_right


@pytest.mark.parametrize("step", [26, 50, 100])
def test_rows_that_are_farther_apart_cover_nothing(reference, step):
    whole = made(reference)
    few = Results("x", "text", tuple(chosen(m, range(0, 1001, step)) for m in whole.maneuvers))
    report = score(few, reference, ["scd >= 6"])
    assert [m.coverage for m in report.maneuvers] == [0.0] * 3
    assert not report.is_right
    assert "add --require 'coverage >= 0'" in report.requirements[0].message


@pytest.mark.parametrize(("number", "key"), [(2, "forward_speed"), (3, "roll_rate")])
def test_rows_at_which_a_wrong_motion_is_right_do_not_cover_the_run(reference, number, key):
    """The rows are at the zeros of the fastest error that does not decay.

    They are 0.4 s apart in maneuver 2, where the speed oscillates twice as fast as the roll, and
    0.37 s apart in maneuver 3.
    """
    every = {2: 0.4, 3: 0.37}[number]
    rows = np.unique(np.round(np.arange(0.0, 10.0, every) * 100).astype(int))
    part = next(m for m in made(reference).maneuvers if m.maneuver == number)
    few = Results("x", "text", (chosen(part, rows),))
    report = score(few, reference, ["scd >= 6", f"{key}.scd >= 6"])
    assert not report.is_right
    assert not any(r.met for r in report.requirements)


def chosen(rows, pick):
    pick = list(pick)
    values = {key: v[pick] for key, v in rows.values.items()}
    return Rows(rows.maneuver, rows.time[pick], rows.time_lo[pick], values)


@pytest.mark.timeout(20)
def test_what_is_no_requirement_is_refused_at_once():
    # The time for parsing must not grow with the square of the number of digits, because a server
    # parses untrusted text.
    with pytest.raises(InputError, match="require: found 'scd>=1111"):
        parse("scd>=" + "1" * 200_000 + "x")


@pytest.mark.parametrize("metric", ["max_abs_error", "scd", "max_rel_error"])
def test_a_column_of_which_nothing_was_compared_fails(reference, results, metric):
    report = score(results, reference)
    nothing = Measures(*[None] * len(fields(Measures)))
    maneuver = report[2]
    columns = [
        replace(c, as_understood=replace(c.as_understood, measures=nothing), values=0)
        if c.key == "roll_angle"
        else c
        for c in maneuver.columns
    ]
    other = replace(maneuver, columns=tuple(columns))
    scored = replace(report, maneuvers=(report[1], other, report[3]))
    for bound in ("< 1e9", "> -1"):
        (found,) = check([f"2.roll_angle.{metric} {bound}"], scored)
        assert not found.met
        assert isinstance(found.outcome, NothingCompared)
        assert "roll_angle" in found.message


@pytest.mark.parametrize(("key", "text", "met"), [
    ("roll_angle", "2.performance < 1e-3", True), ("kinetic_energy", "2.performance < 1e-3", False),
    ("roll_angle", "2.coverage >= 0.5", False), ("kinetic_energy", "1.coverage >= 0.5", True),
])  # fmt: skip
def test_a_missing_value_fails_what_speaks_of_its_column(reference, key, text, met):
    def gap(k, values, number):
        values = values.copy()
        if (number, k) == (2, key):
            values[500] = np.nan
        return values

    assert score(made(reference, gap), reference, [text]).requirements[0].met is met


@pytest.mark.parametrize(("name", "kept", "has_holes"), [
    ("half", lambda t: t <= 5.0, False), ("later half", lambda t: t >= 5.0, False),
    ("hole", lambda t: (t <= 3.0) | (t >= 7.0), True),
    ("hole in a half", lambda t: (t <= 1.0) | ((t >= 4.0) & (t <= 5.0)), True),
])  # fmt: skip
def test_a_hole_is_told_from_an_end(reference, name, kept, has_holes):
    rows = np.flatnonzero(kept(reference[2].time))
    report = score(made(reference, keep=rows), reference)
    (found,) = [x for x in report.seen if isinstance(x, CoveredInPart)]
    assert (found.maneuvers, found.has_holes) == ((1, 2, 3), has_holes)


def test_a_single_row_has_no_distance_to_another(reference):
    report = score(made(reference, keep=slice(1, 2)), reference)
    (found,) = [x for x in report.seen if isinstance(x, CoveredInPart)]
    assert "apart" not in found.message()
    assert "0.01 s" in found.message()

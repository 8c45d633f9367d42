"""Faults in how a program edits its rows are detected in the numbers and undone.

The files are the published columns with one edit. The same object writes the edit and undoes it.
"""

import numpy as np
import pytest

from generators.mistaken_programs import correct, motion, with_changes
from generators.published_columns import side_by_side
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.scoring.diagnosis import visible_faults
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.rows_between import RowsBetween
from heyoka_bike.scoring.evidence.contradictions import SinglePrecision
from heyoka_bike.scoring.rows.deviating_columns import deviating_columns
from heyoka_bike.scoring.rows.edits import (
    Clock,
    Exchanged,
    Mirrored,
    Reversed,
    Rewritten,
    Stage,
    meant_times,
    written,
)
from heyoka_bike.scoring.rows.grids import HalfPrecision, coarse_grids, few_bits
from heyoka_bike.scoring.rows.maneuvers import RowsReversed, reversed_rows
from heyoka_bike.scoring.rows.other_columns import OtherColumn
from heyoka_bike.scoring.rows.rates import RateOfOtherRow, exchanged, shifted_rate
from heyoka_bike.scoring.rows.single_rows import SingleRows, single_rows
from heyoka_bike.scoring.rows.wrong_times import other_clocks, own_times
from heyoka_bike.scoring.score import score

TIME = np.arange(201) / 20
EXCHANGED = Exchanged({"roll_rate": "steer_rate", "steer_rate": "roll_rate"})
EDITS = (Clock(0.99, 0.01), Reversed(), Mirrored(), EXCHANGED)


def columns(reference, time=TIME):
    return {n: dict(reference[n].approximate(time, KEYS)) for n in reference}


def every_column(reference, change):
    return {n: {key: change(x) for key, x in c.items()} for n, c in columns(reference).items()}


def report_of(by_maneuver, reference, time=TIME):
    return score(side_by_side(by_maneuver, time), reference)


@pytest.mark.parametrize("edit", EDITS, ids=lambda e: type(e).__name__)
def test_an_edit_undoes_what_it_writes(edit, reference):
    meant = meant_times([edit], TIME, 1.0)
    held = {n: dict(written([edit], x, TIME)) for n, x in columns(reference, meant).items()}
    for m in report_of(held, reference).maneuvers:
        part = edit.undo(m.part)
        right = reference[m.maneuver].approximate(np.clip(part.time, 0.0, 10.0), KEYS)
        for key in KEYS:
            scale = reference[m.maneuver].scale(key)
            assert np.max(np.abs(part.values[key] - right[key])) < 1e-11 * scale, key


def test_edits_are_made_in_stages_whatever_their_order():
    """A column is computed before it is written in the place of another column."""
    doubled = Rewritten(lambda c, _: {**c, "a": 2.0 * c["a"]}, Stage.FROM_COLUMNS)
    moved = Rewritten(lambda c, _: {**c, "b": c["a"]}, Stage.PLACES)
    one = {"a": np.ones(2), "b": np.zeros(2)}
    for edits in ((doubled, moved), (moved, doubled)):
        assert written(edits, one, np.arange(2.0))["b"].tolist() == [2.0, 2.0]


@pytest.mark.parametrize("numbers", [(2,), (1, 3), (1, 2, 3)])
@pytest.mark.parametrize(
    "pair",
    [
        ("roll_angle", "roll_rate"),
        ("steer_angle", "steer_rate"),
        ("roll_angle", "steer_angle"),
        ("roll_rate", "steer_rate"),
    ],
)
def test_lateral_columns_are_exchanged_in_any_motion(pair, numbers, reference):
    """The motion is 1.2 times too far to the side, so it is wrong, but rates are still slopes."""
    time = np.linspace(0.0, 10.0, 1001)
    held = columns(reference, time)
    for n, each in held.items():
        each.update({key: 1.2 * each[key] for key in LATERAL})
        if n in numbers:
            one, other = pair
            each[one], each[other] = each[other], each[one]
    undone = exchanged(report_of(held, reference, time))
    (seen,) = undone.seen
    assert {seen.key, seen.other} == {*pair}
    assert (seen.maneuvers, seen.is_exchanged) == (numbers, True)
    for part in undone.parts:
        for key in LATERAL:
            right = reference[part.number].approximate(part.time, [key])[key]
            assert part.values[key] == pytest.approx(1.2 * right, abs=1e-9)


def test_no_lateral_column_is_exchanged_in_a_right_file(reference):
    time = np.linspace(0.0, 10.0, 1001)
    assert exchanged(report_of(columns(reference, time), reference, time)) is None


@pytest.mark.parametrize("numbers", [(2,), (1, 2, 3)])
def test_rows_from_the_last_to_the_first(numbers, reference):
    held = columns(reference)
    for n in numbers:
        held[n] = {key: x[::-1] for key, x in held[n].items()}
    undone = reversed_rows(report_of(held, reference))
    assert undone.seen == (RowsReversed(numbers),)
    assert all(np.all(np.diff(part.time) > 0.0) for part in undone.parts)
    (found,) = diagnose(side_by_side(held, TIME), reference).diagnosis
    assert found.code == "rows_reversed"


def test_no_right_file_is_reversed(reference):
    assert reversed_rows(report_of(columns(reference), reference)) is None


def test_single_rows_that_hold_the_row_before(reference):
    held, rng = columns(reference), np.random.default_rng(1)
    for n in held:
        rows = np.sort(rng.choice(np.arange(2, 198), 12, replace=False))
        steer = held[n]["steer_angle"]
        held[n]["steer_angle"] = np.where(np.isin(np.arange(201), rows), np.roll(steer, 1), steer)
    undone = single_rows(report_of(held, reference))
    (seen,) = undone.seen
    assert isinstance(seen, SingleRows)
    assert (seen.key, seen.maneuvers, seen.is_held) == ("steer_angle", (1, 2, 3), True)
    assert 30 <= seen.rows <= 36
    (found,) = diagnose(side_by_side(held, TIME), reference).diagnosis
    assert found.code == "single_rows"


def test_extrema_of_few_digits_hold_no_rows(reference):
    """Near an extremum two rounded rows are equal although the next one differs by much."""
    held = every_column(reference, lambda x: np.array([float(f"{v:.6g}") for v in x]))
    for n in held:
        held[n]["steer_angle"] = held[n]["steer_angle"] * 1.5
    assert single_rows(report_of(held, reference)) is None


def test_rows_between_those_of_large_steps_on_curves(reference):
    """Every fifth row is a step of the integrator. The rows between lie on cubics through the
    steps."""
    from scipy.interpolate import CubicHermiteSpline

    held = columns(reference)
    for n in held:
        knots = held[n]
        for angle, rate in (("roll_angle", "roll_rate"), ("steer_angle", "steer_rate")):
            curve = CubicHermiteSpline(TIME[::5], knots[angle][::5], knots[rate][::5])
            knots[angle], knots[rate] = curve(TIME), curve.derivative()(TIME)
    found = [
        x for x in visible_faults.shown(report_of(held, reference)) if isinstance(x, RowsBetween)
    ]
    assert {(n, x.order, x.every) for x in found for n in x.maneuvers} >= {(2, 2, 5)}


def test_a_column_of_another_maneuver(reference):
    held = columns(reference)
    held[3]["steer_angle"] = held[1]["steer_angle"].copy() * (1.0 + 1e-9)
    (seen,) = deviating_columns(report_of(held, reference)).seen
    assert seen == OtherColumn("steer_angle", (3,), "steer_angle", 1)


@pytest.mark.parametrize(
    ("kind", "seen", "code"),
    [
        (np.float16, HalfPrecision, "half_precision"),
        (np.float32, SinglePrecision, "single_precision"),
    ],
)
def test_numbers_of_few_bits_are_no_grid(kind, seen, code, reference):
    """The distance between such numbers within a binade identifies them."""
    held = every_column(reference, lambda x: x.astype(kind).astype(np.float64))
    undone = few_bits(report_of(held, reference))
    assert [type(x) for x in undone.seen] == [seen]
    assert {*LATERAL, "forward_speed"} <= {*undone.seen[0].keys}
    assert all(p.quantum["roll_angle"].base == 2 for p in undone.parts)
    first = diagnose(side_by_side(held, TIME), reference).diagnosis[0]
    assert first.code == code


def test_an_energy_that_is_one_number_in_half_precision_was_filled_in(reference):
    held = every_column(reference, lambda x: x.astype(np.float16).astype(np.float64))
    assert np.ptp(held[3]["potential_energy"]) == 0.0
    report = report_of(held, reference)
    assert not any(type(x).__name__ == "NeverFilled" for x in report.seen)


def test_a_motion_in_double_precision_has_all_bits(reference):
    assert few_bits(report_of(columns(reference), reference)) is None


def test_a_grid_that_hides_nothing_is_not_told(reference):
    """The speed is rounded to 2^-38, but its error of 1 % has another cause."""
    held = columns(reference)
    for n in held:
        held[n]["forward_speed"] = np.rint(2.0**38 * 1.01 * held[n]["forward_speed"]) / 2.0**38
    assert coarse_grids(report_of(held, reference)) is None


def test_one_clock_of_all_maneuvers(reference):
    """The rows are shifted by a fraction of their distance, which was once read as an initial roll
    and steer."""
    held = columns(reference, np.clip(TIME + 0.013, 0.0, 10.0))
    (seen,) = other_clocks(report_of(held, reference)).seen
    assert (seen.maneuver, seen.scale) == (None, pytest.approx(1.0))
    assert seen.shift == pytest.approx(0.013, rel=1e-6)


def test_a_rate_of_another_row_in_one_maneuver_is_seen(reference):
    """The error of an integrator shifts the rates of all maneuvers alike, but this only one."""
    late = columns(reference)
    rate = late[2]["steer_rate"]
    late[2]["steer_rate"] = np.r_[rate[0], rate[:-1]]
    undone = shifted_rate(report_of(late, reference))
    assert undone.seen == (RateOfOtherRow("steer_rate", 1.0, (2,)),)
    left = {part.number: "steer_rate" in part.values for part in undone.parts}
    assert left == {1: True, 2: False, 3: True}


FEW = [("roll_angle",), ("roll_angle", "steer_angle"), ("forward_speed",)]
EVERY_ROW = np.arange(201)
IN_ANOTHER_ORDER = {
    "reversed": (EVERY_ROW[::-1], "rows_reversed"),
    "one row is written again": (np.r_[:60, 59, 60:120, 119:199], "other_times"),
    "rows are lost in two places": (np.delete(EVERY_ROW, [50, 120]), "other_times"),
    "sorted as text": (np.array(sorted(EVERY_ROW, key=str)), "other_times"),
}


def few_columns(reference, keys, meant):
    return {2: dict(reference[2].approximate(meant, keys))}


@pytest.mark.parametrize("keys", FEW, ids="+".join)
@pytest.mark.parametrize(("scale", "shift"), [(1.0, 0.013), (0.99, 0.0), (0.99, 0.004)])
def test_few_columns_show_one_clock(scale, shift, keys, reference):
    """A clock is one or two values, and the rows of a single column are hundreds."""
    meant = scale * TIME[:-1] + shift
    report = report_of(few_columns(reference, keys, meant), reference, TIME[:-1])
    (seen,) = other_clocks(report).seen
    assert (seen.maneuver, seen.scale) == (None, pytest.approx(scale))
    assert seen.shift == pytest.approx(shift, abs=1e-6)


@pytest.mark.parametrize("keys", FEW[:2], ids="+".join)
@pytest.mark.parametrize("what", IN_ANOTHER_ORDER)
def test_few_columns_show_another_order_of_rows(what, keys, reference):
    """The rows of a column that changes fast are the exact ones only at the times of other rows."""
    rows, code = IN_ANOTHER_ORDER[what]
    time = TIME[: len(rows)]
    held = few_columns(reference, keys, TIME[rows])
    (found,) = diagnose(side_by_side(held, time), reference).diagnosis
    assert found.code == code
    if code == "other_times":
        meant = TIME[rows]
        # A row may also be right at its written time, where the column has an extremum.
        assert found.evidence["rows"]["2"] == pytest.approx(np.sum(meant != time), abs=2)


@pytest.mark.parametrize("keys", FEW, ids="+".join)
@pytest.mark.parametrize("digits", [3, 15])
def test_a_wrong_motion_of_few_columns_has_no_other_times(digits, keys, reference):
    """With an axial inertia of the rear wheel that is too small, a column resembles the exact one
    at scaled times: the error falls sixtyfold."""
    bicycle = with_changes(correct(reference).motion.bicycle, {"IRxx": "-0.05"})
    start = correct(reference).motion.starts[1]
    made = motion(bicycle, (0.0, 0.0, 0.0, start.roll_rate, 0.0, start.speed), TIME)
    held = {1: {key: np.array([float(f"{x:.{digits}g}") for x in made[key]]) for key in keys}}
    report = report_of(held, reference)
    for check in (reversed_rows, other_clocks, own_times):
        assert check(report) is None


def test_a_constant_column_does_not_show_another_order(reference):
    """It agrees with one row, the start of the motion."""
    held = {n: {"forward_speed": np.full(201, reference[n]["forward_speed"][0])} for n in (1, 2)}
    assert own_times(report_of(held, reference)) is None


@pytest.mark.parametrize("numbers", [(2,), (1, 2, 3)], ids=str)
def test_a_rate_of_differences_does_not_show_a_clock(numbers, reference):
    """It resembles the rate half a step later, in every maneuver."""
    step, held = 0.01, {}
    for n in numbers:
        here, there = (
            reference[n].approximate(x, ("roll_angle",))["roll_angle"]
            for x in (TIME[:-1], TIME[:-1] + step)
        )
        held[n] = {"roll_rate": (there - here) / step}
    assert other_clocks(report_of(held, reference, TIME[:-1])) is None


def test_few_digits_show_the_order_of_rows(reference):
    """Each column passes a value many times, and only one of these times is right in both."""
    rows = np.random.default_rng(1).permutation(1001)
    time = np.arange(1001) / 100
    held = few_columns(reference, ("roll_rate", "steer_rate"), time[rows])
    held[2] = {key: np.round(x, 6) for key, x in held[2].items()}
    (seen,) = own_times(report_of(held, reference, time)).seen
    assert seen.found[2].rows > 900


@pytest.mark.parametrize("key", ["roll_rate", "steer_rate"])
def test_a_wrong_motion_that_decays_early_does_not_repeat_its_rows(key, reference):
    """Its changes fall below the digits while the exact motion goes on."""
    held = {1: {key: np.round(reference[3].approximate(TIME, (key,))[key], 6)}}
    found = visible_faults.shown(report_of(held, reference))
    assert not any(isinstance(x, RowsBetween) for x in found)

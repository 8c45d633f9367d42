"""A cause is reported if the odds favour it and nothing in the file contradicts it."""

from dataclasses import replace

import pytest

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.scoring.diagnosis.claims import left_over
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis, log_odds_before
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS, log_ratio
from heyoka_bike.scoring.diagnosis.programs.program import FittedValue, FittedValues
from heyoka_bike.scoring.ratios import BY_FAR

BY_CODE = {m.code: m for m in MISTAKES}
MODEL, OUTPUT = BY_CODE["sign_IHxz"], BY_CODE["energy_difference"]
PLACES = [(n, key) for n in (1, 2, 3) for key in LATERAL]


def hypothesis(after, before=1e-2, mistakes=(MODEL,), changed=None):
    left = dict.fromkeys(PLACES, after) if isinstance(after, float) else after
    known = dict.fromkeys(left, before)
    return Hypothesis(mistakes, known, left, tuple(changed or left), {})


def test_three_maneuvers_tell_as_much_as_one_that_falls_by_the_cube():
    one = [p for p in PLACES if p[0] == 1]
    three = log_ratio(dict.fromkeys(PLACES, 2.0), dict.fromkeys(PLACES, 1.0), PLACES)
    assert three == pytest.approx(log_ratio(dict.fromkeys(one, 8.0), dict.fromkeys(one, 1.0), one))


def test_what_resembles_an_error_by_chance_is_not_said():
    """The best of 300 wrong mistakes reduces a correct program's error in one maneuver by a factor
    of up to 7."""
    one = {k: x for k, x in hypothesis(1e-2 / 7).after.items() if k[0] == 1}
    assert hypothesis(one).log_odds < THRESHOLDS.report_log_odds
    assert hypothesis(1e-2 / 7).log_odds > THRESHOLDS.report_log_odds


def test_values_that_are_fitted_and_second_mistakes_cost_more():
    found = FittedValue("g", None, 9.8, 9.81, 1e-3)
    fitted, two = (
        FittedValues("other", "", "", "model", lambda p: p, values)
        for values in ((found,), (found, found))
    )
    alone, pair = log_odds_before([MODEL]), log_odds_before([MODEL, OUTPUT])
    assert 0.0 == log_odds_before([]) > alone > log_odds_before([fitted]) > log_odds_before([two])
    assert pair < 2 * alone


def test_columns_that_a_mistake_does_not_change_say_nothing_of_it():
    rates = [p for p in PLACES if p[1].endswith("rate")]
    left = {k: 1e-5 if k in rates else 1e-2 for k in PLACES}
    assert hypothesis(left, changed=rates).log_odds == hypothesis(1e-5).log_odds
    assert hypothesis(left, changed=rates).relief == pytest.approx(1e3)
    assert hypothesis(left, changed=rates).gain < 100


def test_a_mistake_that_is_made_leaves_no_column_farther_off():
    left = dict.fromkeys(PLACES, 1e-5) | {(2, "steer_rate"): 3e-2}
    assert not hypothesis(left).is_possible
    assert hypothesis(1e-5).is_possible


def test_an_energy_that_is_written_otherwise_is_explained_as_well_as_the_motion():
    energy = (1, "mechanical_energy")
    left = dict.fromkeys(PLACES, 1e-9) | {energy: 1e-2}
    before = dict.fromkeys(PLACES, 1e-9) | {energy: 0.12}
    h = Hypothesis((OUTPUT,), before, left, (energy,), {})
    assert h.unexplained == energy
    assert replace(h, floors={energy: 1e-2}).unexplained is None
    assert replace(h, before=before | {energy: 40.0}).unexplained is None
    assert replace(h, after=left | {energy: 1e-9}).unexplained is None


def test_a_cause_that_leaves_only_the_resolution_limit_is_complete():
    h = hypothesis(dict.fromkeys(PLACES, 1e-5))
    assert not h.is_exhaustive
    assert replace(h, floors=dict.fromkeys(PLACES, 5e-6)).is_exhaustive


@pytest.mark.parametrize(("others", "is_told"), [(1e-9, True), (1e-4, False)])
def test_a_column_that_alone_stays_wrong_is_told_beside_a_cause(others, is_told):
    """For example, one rate is a row late. Integrator errors are nearly as large in all columns."""
    place = (2, "roll_rate")
    left = dict.fromkeys(PLACES, others) | {place: 2e-2}
    assert left_over(hypothesis(left, before=10.0), None) == (place if is_told else None)


@pytest.mark.parametrize(("before", "is_told"), [(0.5, True), (20.0, False)])
def test_a_maneuver_that_a_cause_hardly_explains_is_told_beside_it(before, is_told):
    """For example, the maneuver has other initial conditions: all its columns remain as far off as
    before."""
    third = [p for p in PLACES if p[0] == 3]
    h = hypothesis(dict.fromkeys(PLACES, 5e-4) | dict.fromkeys(third, 0.28), before=1.0)
    h = replace(h, before={**h.before, **dict.fromkeys(third, before)})
    assert h.relief > BY_FAR
    assert (left_over(h, None) in third) is is_told


@pytest.mark.parametrize(("others", "is_told"), [(1e-9, True), (1e-4, False)])
def test_a_maneuver_that_alone_stays_wrong_is_told_beside_a_cause(others, is_told):
    """For example, its rows are late. An integrator's error is in every maneuver."""
    third = [p for p in PLACES if p[0] == 3]
    left = dict.fromkeys(PLACES, others) | dict.fromkeys(third, 2e-2)
    assert (left_over(hypothesis(left, before=10.0), None) in third) is is_told


@pytest.mark.parametrize(("left", "is_told"), [(2e-3, True), (5e-4, False)])
def test_what_a_value_leaves_visible_in_few_columns_is_told_beside_it(left, is_told):
    """A file that does not show its equations fits several values, each with a part of its error.
    A known mistake has no value to adapt, so an integrator may leave as much."""
    place = (1, "steer_rate")
    h = Hypothesis((MODEL,), {place: 1.0}, {place: left}, (place,), {place: 1e-6})
    value = FittedValue("g", None, 9.0, 9.81, 1e-3)
    fitted = replace(h, mistakes=(FittedValues("other", "", "", "model", lambda p: p, (value,)),))
    assert left_over(h, None) is None
    assert left_over(fitted, None) == (place if is_told else None)

"""A column of another row is recognised, also as a part of the mechanical energy."""

from functools import partial

import numpy as np
import pytest

from generators.published_columns import side_by_side
from generators.simulated_tables import right_program, simulated
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES, apply
from heyoka_bike.scoring.rows.deviating_columns import deviating_columns
from heyoka_bike.scoring.rows.other_moments import OtherMoment, PartMultiplied
from heyoka_bike.scoring.rows.sums import own_sum
from heyoka_bike.scoring.score import score

TIME = np.arange(501) / 50
ENERGY, HEIGHT, MOTION = "mechanical_energy", "potential_energy", "kinetic_energy"
FEW = [(ENERGY,), (ENERGY, "roll_angle"), (ENERGY, MOTION), (ENERGY, HEIGHT, "steer_rate")]


def late(x):
    return np.concatenate([x[:1], x[:-1]])


def early(x):
    return np.concatenate([x[1:], x[-1:]])


def report_of(reference, change, keys, numbers=(1, 2, 3)):
    columns = {n: dict(reference[n].approximate(TIME, KEYS)) for n in numbers}
    changed = {n: c | change(c, n) for n, c in columns.items()}
    kept = {n: {key: c[key] for key in keys} for n, c in changed.items()}
    return score(side_by_side(kept, TIME), reference)


@pytest.mark.parametrize("keys", FEW)
@pytest.mark.parametrize("part", [HEIGHT, MOTION])
def test_a_sum_with_a_part_of_the_row_before(reference, keys, part):
    report = report_of(reference, lambda c, _: {ENERGY: c[ENERGY] - c[part] + late(c[part])}, keys)
    undone = deviating_columns(report)
    assert undone.seen == (OtherMoment(ENERGY, (1, 2, 3), part, pytest.approx(0.02), 1),)


@pytest.mark.parametrize("keys", FEW)
@pytest.mark.parametrize("numbers", [(2,), (1, 2, 3)])
def test_a_sum_with_the_first_height(reference, keys, numbers):
    report = report_of(reference, lambda c, _: {ENERGY: c[MOTION] + c[HEIGHT][0]}, keys, numbers)
    undone = deviating_columns(report)
    assert undone.seen == (OtherMoment(ENERGY, numbers, HEIGHT, None),)


def test_a_part_that_is_a_step_late(reference):
    """The step is a fifth of the distance of the rows."""

    def change(c, n):
        before = reference[n].approximate(np.maximum(TIME - 0.004, 0.0), [HEIGHT])[HEIGHT]
        return {ENERGY: c[MOTION] + before}

    (seen,) = deviating_columns(report_of(reference, change, (ENERGY, "steer_angle"))).seen
    assert (seen.part, seen.rows) == (HEIGHT, None)
    assert seen.delay == pytest.approx(0.004, rel=1e-4)


def test_a_part_that_is_multiplied(reference):
    report = report_of(reference, lambda c, _: {ENERGY: c[MOTION] + 2.0 * c[HEIGHT]}, FEW[1])
    (seen,) = deviating_columns(report).seen
    assert seen == PartMultiplied((1, 2, 3), HEIGHT, pytest.approx(2.0))


@pytest.mark.parametrize("key", [HEIGHT, "roll_angle"])
def test_a_column_of_the_row_before(reference, key):
    report = report_of(reference, lambda c, _: {key: late(c[key])}, KEYS)
    assert own_sum(report) is None
    (seen,) = deviating_columns(report).seen
    assert seen == OtherMoment(key, (1, 2, 3), None, pytest.approx(0.02), 1)


@pytest.fixture(scope="module")
def wrong_motion(simulator, bicycle, reference):
    (mistake,) = (m for m in MISTAKES if m.code == "sign_IHxz")
    return simulated(simulator, apply(right_program(bicycle, reference), (mistake,)), KEYS)


SUMS = {
    "right": (lambda v, t: v + t, None),
    "before": (
        lambda v, t: late(v) + t,
        OtherMoment(ENERGY, (1, 2, 3), HEIGHT, pytest.approx(0.01), 1),
    ),
    "after": (
        lambda v, t: v + early(t),
        OtherMoment(ENERGY, (1, 2, 3), MOTION, pytest.approx(-0.01), -1),
    ),
    "first": (lambda v, t: v[0] + t, OtherMoment(ENERGY, (1, 2, 3), HEIGHT, None)),
    "multiple": (
        lambda v, t: v + 3.0 * t,
        PartMultiplied((1, 2, 3), MOTION, pytest.approx(3.0)),
    ),
    "difference": (lambda v, t: v - t, None),
    "other force": (lambda v, t: v + t + 1e-4 * t**2, None),
    "two rows before": (lambda v, t: late(late(v)) + t, None),
}


@pytest.mark.parametrize("name", SUMS)
def test_the_sum_shows_it_in_any_motion(reference, wrong_motion, name):
    added, fault = SUMS[name]
    table = dict(wrong_motion)
    for n in reference:
        table[f"{ENERGY}_{n}"] = added(table[f"{HEIGHT}_{n}"], table[f"{MOTION}_{n}"])
    undone = own_sum(score(table, reference))
    if fault is None:
        assert undone is None
        return
    (seen,) = undone.seen
    assert seen == fault
    assert all(ENERGY not in part.values for part in undone.parts)


def test_a_sum_that_differs_between_maneuvers_has_no_common_fault(reference, wrong_motion):
    table = dict(wrong_motion)
    for n in reference:
        height, motion = table[f"{HEIGHT}_{n}"], table[f"{MOTION}_{n}"]
        table[f"{ENERGY}_{n}"] = motion + (late(height) if n < 3 else 2.0 * height)
    assert own_sum(score(table, reference)) is None


def test_a_sum_that_lacks_a_part_says_so():
    assert "lacks the potential energy" in PartMultiplied((1,), HEIGHT, 1e-16).message()


def test_a_slow_drift_is_no_delay(reference):
    """An energy alone may have an integrator's error, which resembles a delay of half a row."""

    def change(c, n):
        before = reference[n].approximate(np.maximum(TIME - 0.01, 0.0), [HEIGHT])[HEIGHT]
        return {ENERGY: c[MOTION] + before}

    assert deviating_columns(report_of(reference, change, (ENERGY,))) is None


def filtered(reference, _, n):
    """Return a mean of two moments, which is nearly the roll angle of the moment between them."""
    both = [reference[n].approximate(t, ["roll_angle"]) for t in (TIME, np.maximum(TIME - 1e-3, 0))]
    return {"roll_angle": np.mean([x["roll_angle"] for x in both], axis=0)}


def without_a_body(_, c, __):
    """Return an energy without that of a body, which is nearly a multiple of the whole energy."""
    return {ENERGY: c[ENERGY] - 30.0 * np.cos(c["roll_angle"])}


@pytest.mark.parametrize(("change", "keys"), [(filtered, KEYS), (without_a_body, (ENERGY,))])
def test_what_resembles_another_moment_or_a_multiple_is_none(reference, change, keys):
    """A single maneuver, so that no other one shows another delay or factor."""
    report = report_of(reference, partial(change, reference), keys, (1,))
    undone = deviating_columns(report)
    seen = () if undone is None else undone.seen
    assert not any(isinstance(x, OtherMoment | PartMultiplied) for x in seen), seen

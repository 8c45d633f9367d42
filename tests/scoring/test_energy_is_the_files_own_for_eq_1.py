"""Eq. (1) needs an energy that is the exact one or consistent with the file's own parts, with
enough digits."""

from dataclasses import replace

import numpy as np
import pytest

from generators.made_results import made
from heyoka_bike.scoring.score import score
from heyoka_bike.scoring.verdict import DoesNotCount, claim, meets_limit, performance
from heyoka_bike.showing.formats.output import render

ENERGY = "mechanical_energy"
LIMIT = "2.performance < 1e-3"
FEW = ["columns >= 1"]


def changed(reference, change, keys=None):
    """Score a correct file with a changed mechanical energy, perhaps without some columns."""
    results = made(reference, lambda k, v, n: change(v) if k == ENERGY else v)
    if keys is None:
        return score(results, reference, LIMIT)
    columns = {k: v for k, v in results.maneuvers[1].values.items() if k in keys}
    return score({"time": reference[2].time, **columns}, reference, [LIMIT, *FEW], maneuver=2)


def test_the_energy_of_a_right_file_meets_it(reference):
    report = changed(reference, lambda v: v)
    assert report.requirements[0].met
    assert report[2].meets_limit
    assert "passes" in render(report, "summary")


@pytest.mark.parametrize(
    "change",
    [lambda v: v + 1e6, lambda v: np.full_like(v, v[0] + 3100), lambda v: v + 1.0,
     lambda v: np.full_like(v, 1550.0), lambda v: 0 * v + 1e-3, lambda v: v + 1e-3],
)  # fmt: skip
def test_it_has_to_be_potential_plus_kinetic_energy(reference, change):
    report = changed(reference, change)
    assert not report.requirements[0].met
    assert "not the file's own potential plus kinetic energy" in report.requirements[0].message
    assert report[2].meets_limit is False
    assert "passes" not in render(report, "table")
    assert "does not count" in render(report, "summary")


@pytest.mark.parametrize("beside", [["kinetic_energy"], ["potential_energy"], ["roll_angle"]])
def test_it_has_to_be_the_true_one_without_its_parts(reference, beside):
    keys = [ENERGY, *beside]
    assert changed(reference, lambda v: v, keys).requirements[0].met
    for change in (lambda v: v + 1.0, lambda v: v + 1e6, lambda v: np.full_like(v, 1550.0)):
        report = changed(reference, change, keys)
        assert not report.requirements[0].met
        assert report[2].meets_limit is False


def test_its_digits_have_to_show_it(reference, tmp_path):
    m = reference[2]

    def of(form):
        keys = ("potential_energy", "kinetic_energy", ENERGY)
        table = np.column_stack([m.time, *(m.rows[k] for k in keys)])
        np.savetxt(tmp_path / "e.csv", table, form, ",", header=f"t,{','.join(keys)}", comments="")
        return score(tmp_path / "e.csv", reference, [LIMIT, *FEW], maneuver=2)

    assert of("%.9g").requirements[0].met
    few = of("%.3g")
    assert not few.requirements[0].met
    assert few[2].meets_limit is False


def test_a_limit_that_is_reached_is_not_met(reference):
    """Eq. (1) requires a value below the limit, not equal to it."""

    def drifting(key, values, number):
        drift = 1e-5 * reference[number][ENERGY][0] * np.linspace(0.0, 1.0, len(values))
        return values + drift if key in (ENERGY, "kinetic_energy") else values

    maneuver = score(made(reference, drifting), reference)[2]
    reached = claim(maneuver, np.inf).value
    assert meets_limit(replace(maneuver, performance_limit=reached)) is False
    more = float(np.nextafter(reached, np.inf))
    assert meets_limit(replace(maneuver, performance_limit=more)) is True


BEST = {"resolution": 0.0, "sum_error": 0.0, "true_error": 0.0, "start": 1.0}


@pytest.mark.parametrize(("change", "more", "value", "reason"), [
    (None, {}, np.inf, DoesNotCount.NO_ENERGY),
    (0.5, {}, 0.5, None),
    (3.0, {}, 3.0, None),
    (0.5, {"sum_error": 1e-9}, np.inf, DoesNotCount.NOT_ITS_SUM),
    # If no sum confirms that the file's energy belongs to its motion, the energy must be the exact
    # one.
    (0.5, {"sum_error": None, "true_error": 2.0}, 2.0, DoesNotCount.NOT_TRUE),
    (0.5, {"sum_error": None, "true_error": 1.0}, 1.0, DoesNotCount.NOT_TRUE),
    (0.5, {"sum_error": None, "true_error": 0.9}, 0.5, None),
    (3.0, {"sum_error": None, "true_error": 5.0}, 3.0, None),
    # `start` is the ratio of the file's initial energy to the exact one. The change of the energy
    # counts relative to the exact energy if only this makes it exceed the limit.
    (0.5, {"start": 3.0}, 1.5, DoesNotCount.ANOTHER_START),
    (0.5, {"start": 2.0}, 1.0, DoesNotCount.ANOTHER_START),
    (0.2, {"start": 3.0}, 0.2, None),
    (0.5, {"start": 0.1}, 0.5, None),
    (0.5, {"resolution": 1.5}, 1.5, DoesNotCount.FEW_DIGITS),
    (0.5, {"resolution": 0.9}, 0.5, None),
])  # fmt: skip
def test_a_change_of_energy_counts_only_if_the_energy_is_trusted(change, more, value, reason):
    """The limit is 1; all numbers are in percent."""
    claimed = performance(change, 1.0, **BEST | more)
    assert (claimed.value, claimed.reason) == (value, reason)

"""A diagnosis claims that a cause explains only what it does explain, and also names what
remains."""

from dataclasses import replace

import pytest

from generators.simulated_tables import TIME, right_program, simulated
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.scoring.diagnosis.beginnings import BeginsAs
from heyoka_bike.scoring.diagnosis.cause_words import count_words, inertia_words
from heyoka_bike.scoring.diagnosis.conclusions import Integrator
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.energies import EnergyKept
from heyoka_bike.scoring.diagnosis.programs.forces import FORCES, WITHOUT_POTENTIAL, is_plausible
from heyoka_bike.scoring.diagnosis.programs.program import FittedValue
from heyoka_bike.scoring.diagnosis.residual.methods import Method
from heyoka_bike.scoring.findings import info
from heyoka_bike.scoring.score import score
from heyoka_bike.showing.formats import summary

MOST_LINES = 12


@pytest.fixture(scope="module")
def right(bicycle, reference):
    return right_program(bicycle, reference)


def with_values(program, **values):
    exact = {name: Exact.parse(str(x)) for name, x in values.items()}
    old = program.motion.bicycle
    return program.moving(bicycle=Bicycle(old.name, {**old.values, **exact}))


def only(table, number, keys, every=5):
    return {"time": TIME[::every]} | {
        f"{k}_{number}": table[f"{k}_{number}"][::every] for k in keys
    }


@pytest.mark.parametrize("name", ["mB", "IBxx", "IFyy", "rR", "w", "g", "crown", "crown_R"])
def test_no_size_below_zero_is_a_cause(name):
    assert not is_plausible(name, -3e-4)
    assert is_plausible(name, 3e-4)


def test_places_and_products_have_either_sign():
    assert all(is_plausible(name, -0.1) for name in ("IBxz", "IHxz", "xB", "zB", "c", "lam"))


def test_forces_that_store_no_energy_leave_the_potential_energy_as_it_is():
    assert {"air_drag", "steer_damping", "no_spin_moment", "roll_by_roll_rate_speed"} <= (
        WITHOUT_POTENTIAL
    )
    stores = {"steer_stiffness", "roll_stiffness", "slope_along", "slope_across", "crown"}
    assert not stores & WITHOUT_POTENTIAL
    assert FORCES.keys() > WITHOUT_POTENTIAL


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["mB"], "one parameter explains"),
        (["mB", "crown"], "two parameters explain"),
        (["steer_damping"], "one force explains"),
        (["air_drag", "steer_by_steer_rate_steer_rate"], "two forces explain"),
        (["no_spin_moment_F"], "one term explains"),
        (["mB", "air_drag"], "two causes explain"),
        (["mB", "g", "w", "c"], "these explain"),
    ],
)
def test_a_force_is_not_called_a_parameter(names, said):
    assert count_words([FittedValue(name, None, 1.0, 0.0, 0.0) for name in names]) == said


@pytest.mark.parametrize(
    ("lost", "hint"),
    [
        # A part of 2 kg, moved by 0.1 m in x and 0.3 m in z.
        ({"xx": 0.18, "zz": 0.02, "xz": 0.06}, "moving them"),
        ({"xx": 0.18, "zz": 0.02, "xz": 0.10}, ""),
        ({"xx": 0.10, "zz": -0.10, "xz": 0.05}, "rotated"),
        ({"xx": 0.10, "zz": -0.05, "xz": 0.05}, ""),
    ],
)
def test_a_pattern_in_inertias_is_stated_only_if_masses_can_make_it(lost, hint):
    right = {"xx": 9.2, "zz": 2.8, "xz": 2.4}
    found = [FittedValue(f"IB{k}", None, right[k] - x, right[k], 0.0) for k, x in lost.items()]
    words = inertia_words(found)
    assert hint in words if hint else not words


def test_a_method_that_is_only_the_nearest_asks_for_no_smaller_step():
    method = Method("the implicit midpoint rule", 2, 0.01, True, 2.1, 20.0)
    nearest, sure = (Integrator((method,), x).message() for x in (False, True))
    assert "take a smaller step" not in nearest.lower()
    assert "Take a smaller step" in sure


@pytest.mark.parametrize("order", [1, 2, 3])
def test_how_an_error_begins_excludes_no_force(order):
    keys = ("roll_angle", "steer_angle")
    message = BeginsAs(keys, order, (1, 2)).message()
    assert "no force" not in message
    assert all(key in message for key in keys)


def test_an_energy_that_is_kept_names_no_parameters():
    message = EnergyKept(1e-9, {1: 2.0}).message()
    assert not any(word in message for word in ("masses", "lengths", "no work"))


def test_an_answer_without_a_cause_has_twelve_lines_at_most(reference):
    values = {"time": TIME} | {
        f"{k}_2": 1.01 * reference[2].approximate(TIME, [k])[k] for k in KEYS
    }
    report = score(values, reference)
    remark = "A remark of some length that says what the error looks like in this file. " * 3
    remarks = tuple(info(f"remark_{n}", remark) for n in range(9))
    found = replace(report, diagnosis=remarks)
    text = summary.diagnosis(found)
    assert sum(map(bool, text.splitlines())) <= MOST_LINES
    assert text.splitlines()[-1].endswith("more findings")
    assert len(summary.diagnosis(found, has_details=True).splitlines()) > MOST_LINES


@pytest.mark.proof
def test_an_inertia_is_named_whole(simulator, right, reference):
    """The wrong program adds up inertias of parts without shifting them to the common centre of
    mass."""
    # Two parts: the square of the missing xz is the product of the missing xx and zz.
    wrong = {"IBxx": 7.4, "IByy": 9.0, "IBzz": 2.6, "IBxz": 3.0}
    table = simulated(simulator, with_values(right, **wrong), KEYS)
    (found,) = diagnose(table, reference).diagnosis
    changes = {x["unknown"]: x["value"] for x in found.evidence["changes"][0]}
    assert changes == pytest.approx(wrong, rel=1e-4)
    assert "moving them to the common centre" in found.message


@pytest.mark.proof
def test_a_cubic_spring_is_named_from_two_columns_of_one_maneuver(simulator, right, reference):
    spring = {"steer_by_steer_angle_steer_angle_steer_angle": -30.0}
    table = simulated(simulator, right, ("roll_angle", "steer_angle"), **spring)
    found = diagnose(only(table, 1, ("roll_angle", "steer_angle")), reference).diagnosis[0]
    assert found.code == "parameters"
    assert [x["unknown"] for x in found.evidence["changes"][0]] == [*spring]


@pytest.mark.proof
def test_what_a_drag_does_not_explain_is_named(simulator, right, reference):
    """The potential energy is multiplied by a factor that grows with time. Air drag cannot explain
    it."""
    table = simulated(simulator, right, KEYS, air_drag=0.2)
    for n in reference:
        table[f"potential_energy_{n}"] = table[f"potential_energy_{n}"] * (1.0 + 1e-3 * TIME)
    first = diagnose(table, reference).diagnosis[0]
    assert first.code == "parameters"
    assert not first.evidence["is_all"]
    assert "potential_energy" in first.message


@pytest.mark.proof
def test_a_zero_of_a_column_is_found_beside_a_wrong_value(simulator, right, reference):
    keys = ("roll_angle", "roll_rate", "steer_angle", "steer_rate", "forward_speed")
    table = simulated(simulator, with_values(right, g=9.7), keys)
    for n in reference:
        table[f"steer_angle_{n}"] = table[f"steer_angle_{n}"] + 0.02
    ratio, value, *_ = diagnose(table, reference).diagnosis
    assert (ratio.code, ratio.evidence["column"]) == ("column_ratio", "steer_angle")
    assert ratio.evidence["offset"] == pytest.approx(0.02, rel=1e-5)
    assert [x["unknown"] for x in value.evidence["changes"][0]] == ["g"]

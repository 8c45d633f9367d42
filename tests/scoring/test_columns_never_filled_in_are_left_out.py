"""A column that is constant although the quantity varies was never filled in: it is named and left
out."""

import numpy as np
import pytest

from generators.made_results import codes, made
from generators.simulated_tables import right_program, simulated
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES, apply
from heyoka_bike.scoring.findings import Severity
from heyoka_bike.scoring.reading.results import Quantum, Results, Rows
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.rows.deviating_columns import deviating_columns
from heyoka_bike.scoring.score import score

ENERGIES = ("potential_energy", "kinetic_energy", "mechanical_energy")


def without(reference, keys, number=0.0, maneuvers=(1, 2, 3), **more):
    def change(key, values, m):
        return np.full_like(values, number) if key in keys and m in maneuvers else values

    return made(reference, change, **more)


def keys_of(report, number):
    return [c.key for c in next(m for m in report.maneuvers if m.maneuver == number).columns]


def test_zeros_are_named_and_do_not_count(reference):
    report = score(without(reference, ENERGIES), reference)
    assert codes(report) == ["never_filled"]
    (found,) = report.findings
    assert found.evidence["columns"] == [f"{n}.{key}" for n in (1, 2, 3) for key in ENERGIES]
    for m in report.maneuvers:
        assert not set(ENERGIES) & {c.key for c in m.columns}
        assert len(m.columns) == 5
        assert min(c.as_understood.measures.scd for c in m.columns) > 15
        assert m.coverage == 1.0


@pytest.mark.parametrize(("maneuvers", "where"), [
    ((1, 2, 3), ""), ((2,), " of maneuver 2"), ((1, 3), " of maneuvers 1 and 3"),
])  # fmt: skip
def test_the_verdict_names_columns_once_for_all_maneuvers(reference, maneuvers, where):
    results = without(reference, ENERGIES, maneuvers=maneuvers)
    said = ", ".join(f"{key}{where}" for key in ENERGIES)
    assert score(results, reference).verdict.endswith(f"; {said} are not compared")


def test_columns_that_are_left_out_are_not_called_exact(reference):
    results = without(reference, ENERGIES, maneuvers=(2,))
    said = [f.message for f in diagnose(results, reference).diagnosis]
    assert said == ["Every column that was compared is as exact as the digits written allow"]


@pytest.mark.parametrize("text", ["scd >= 1", "kinetic_energy.scd >= 1", "coverage >= 1",
                                  "2.performance < 1", "max_abs_error < 1e9"])  # fmt: skip
def test_a_requirement_that_asks_for_it_fails(reference, text):
    (r,) = score(without(reference, ENERGIES), reference, [text]).requirements
    assert not r.met
    assert "kinetic_energy" in r.message
    assert r.message.startswith("columns that were never filled in: ")


@pytest.mark.parametrize("text", ["roll_angle.scd >= 12", "1.scd >= 12"])
def test_a_requirement_that_does_not_is_met(reference, text):
    results = without(reference, ENERGIES, maneuvers=(2, 3))
    assert score(results, reference, [text, "columns >= 5"]).requirements[0].met


def test_fewer_columns_may_be_enough(reference):
    """Programs that write all 25 columns cannot omit the columns that they do not compute."""
    results = without(reference, ENERGIES)
    assert score(results, reference, ["scd >= 12", "columns >= 5"]).passed
    for require in (["scd >= 12"], ["scd >= 12", "columns >= 6"],
                    ["kinetic_energy.scd >= 1", "columns >= 5"]):  # fmt: skip
        assert not score(results, reference, require).passed


def test_a_maneuver_that_was_not_run_is_left_out(reference):
    results = without(reference, BENCHMARK_COLUMNS, maneuvers=(3,))
    report = score(results, reference, ["3.roll_angle.scd >= 1", "2.scd >= 12"])
    assert [m.maneuver for m in report.maneuvers] == [1, 2]
    assert [r.met for r in report.requirements] == [False, True]
    assert "never filled in" in report.requirements[0].message


def test_a_file_of_zeros_is_scored_as_it_is(reference):
    report = score(without(reference, BENCHMARK_COLUMNS), reference)
    assert "never_filled" not in codes(report)
    assert len(keys_of(report, 1)) == 8


def test_the_first_value_throughout_is_no_result_either(reference):
    first = float(reference[2].rows["kinetic_energy"][0])
    report = score(without(reference, ("kinetic_energy",), first, (2,)), reference)
    assert report.findings[0].evidence["columns"] == ["2.kinetic_energy"]
    assert f"{first:.9g}" in report.findings[0].message


@pytest.mark.parametrize(("key", "number"), [("mechanical_energy", 1837.0), ("forward_speed", 4.6)])
def test_what_may_be_constant_is_a_result(reference, key, number):
    """A constant energy is correct, and a constant speed is the result of linear equations."""
    assert key in keys_of(score(without(reference, (key,), number, (2,)), reference), 2)


def test_a_motion_that_stands_still_is_a_result(reference):
    """A constant lean with a zero rate is wrong, but it is a result."""

    def change(key, values, number):
        held = {"roll_angle": 0.2, "roll_rate": 0.0}
        return np.full_like(values, held[key]) if key in held else values

    assert {"roll_angle", "roll_rate"} <= set(keys_of(score(made(reference, change), reference), 1))


def test_rounding_to_one_number_is_a_result(reference):
    """The potential energy of maneuver 3 varies by 0.06 J, so three digits of it are always 794."""
    rows = reference[3].rows["potential_energy"]
    assert np.all(np.round(rows) == 794)
    quantum = {key: Quantum(10, digits=3) for key in BENCHMARK_COLUMNS}
    results = without(reference, ("potential_energy",), 794.0, (3,), quantum=quantum)
    assert "potential_energy" in keys_of(score(results, reference), 3)


def test_a_few_rows_may_be_alike(reference):
    report = score(without(reference, ("steer_angle",), keep=slice(0, 5)), reference)
    assert "never_filled" not in codes(report)


def test_eq_1_is_taken_in_the_digits_written(reference, tmp_path):
    """Two energies differ in the 30th digit, so the performance is 100 * 2e-28 / 1575."""
    path = tmp_path / "r.txt"
    e = "1575.1729024773809523809523809{}"
    lines = [f"{i / 100} {e.format('52' if i % 2 else '54')}" for i in range(20)]
    path.write_text("# t mechanical_energy\n" + "\n".join(lines) + "\n")
    (m,) = score(read_results(path, maneuver=1), reference).maneuvers
    assert m.performance == pytest.approx(100 * 2e-27 / 1575.17290248, rel=1e-3)


def test_eq_1_of_the_parts_is_taken_in_their_digits(reference):
    t = np.arange(20) / 100
    lo = np.where(np.arange(20) % 2, 3e-20, 0.0)
    values = {"potential_energy": np.full(20, 794.0) + t, "kinetic_energy": np.full(20, 781.0) - t}
    # The low parts in `rest` cancel the rounding errors of the energies, so the sum of the energies
    # varies only by `lo`.
    rest = {"potential_energy": lo - (values["potential_energy"] - 794.0 - t),
            "kinetic_energy": -(values["kinetic_energy"] - 781.0 + t)}  # fmt: skip
    rows = Rows(1, t, np.zeros(20), values, rest, {})
    (m,) = score(Results("x", "text", (rows,), 25), reference).maneuvers
    assert m.performance == pytest.approx(100 * 3e-20 / 1575.0, rel=1e-3)


def test_the_sum_of_empty_energies_is_empty_too(reference):
    held = {"potential_energy": 794.1195, "kinetic_energy": 0.0, "mechanical_energy": 794.1195}
    results = made(reference, lambda key, values, _: np.full_like(values, held.get(key, 0.0))
                   if key in held else values)  # fmt: skip
    (found,) = (f for f in score(results, reference).findings if f.code == "never_filled")
    assert set(found.evidence["columns"]) == {f"{n}.{key}" for n in (1, 2, 3) for key in held}


def test_a_bicycle_that_stays_upright_is_no_empty_file(reference):
    """Zero roll and steer with a constant speed and constant energies are a motion."""
    lateral = ("roll_angle", "roll_rate", "steer_angle", "steer_rate")
    results = made(reference, lambda key, values, _: np.full_like(
        values, 0.0 if key in lateral else values[0]))  # fmt: skip
    assert "never_filled" not in codes(score(results, reference))


def test_angles_of_zeros_alone_are_no_bicycle_that_stays_upright(reference):
    """Without a speed nothing shows that the bicycle moved."""
    keys = ("roll_angle", "steer_angle")
    report = score(without(reference, keys, maneuvers=(3,), names=keys), reference)
    assert "never_filled" in codes(report)
    assert [m.maneuver for m in report.maneuvers] == [1, 2]


@pytest.fixture(scope="module")
def weightless(simulator, bicycle, reference):
    """Return the table of a program without gravity: all energies are constant."""
    (mistake,) = (m for m in MISTAKES if m.code == "gravity_missing")
    program = apply(right_program(bicycle, reference), (mistake,))
    return simulated(simulator, program, BENCHMARK_COLUMNS)


@pytest.mark.parametrize(
    "keys",
    [BENCHMARK_COLUMNS, ("roll_angle", "steer_angle", "potential_energy", "kinetic_energy")],
)
def test_a_column_that_is_constant_with_the_cause_is_no_fault(reference, weightless, keys):
    table = {k: v for k, v in weightless.items() if k == "time" or k[:-2] in keys}
    report = diagnose(table, reference)
    assert "never_filled" not in codes(report)
    (found,) = (f for f in report.findings if f.code == "constant_in_motion")
    assert found.severity is Severity.INFO
    assert report.diagnosis[0].evidence["mistakes"] == ["gravity_missing"]
    assert {x.key for x in report.not_compared} == {"potential_energy"}


def test_another_number_is_still_no_result(reference, weightless):
    table = {k: np.zeros_like(v) if "energy" in k else v for k, v in weightless.items()}
    found = {f.code: f.evidence for f in diagnose(table, reference).findings}
    assert found["never_filled"]["columns"] == [f"{n}.kinetic_energy" for n in reference]


def test_a_constant_energy_is_no_multiple_of_the_exact_one(reference, weightless):
    """The kinetic energy varies by roundoff, which would fit a factor of 1e-14 and an offset."""
    table = {k: v for k, v in weightless.items() if k == "time" or k[:-2] in ENERGIES}
    assert deviating_columns(score(table, reference)) is None

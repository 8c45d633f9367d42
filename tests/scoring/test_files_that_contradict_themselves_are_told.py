"""Contradictions within a file are found: energies that do not add up, rates that are not
slopes."""

import numpy as np
import pytest

from generators.made_results import codes, column, made, smooth_error
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.evidence.contradictions import SinglePrecision
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.system.resources import data_folder


def test_energies_that_add_up_pass_whatever_their_error(reference):
    def change(key, values, number):
        error = smooth_error(reference, number, 1.0)
        return values + {"potential_energy": error, "kinetic_energy": error,
                         "mechanical_energy": 2 * error}.get(key, 0.0)  # fmt: skip

    report = score(made(reference, change), reference)
    assert codes(report) == []
    # The values are rounded twice: before and after the error is added.
    for m in report.maneuvers:
        assert m.consistency.energy_sum <= 2 * m.consistency.energy_sum_floor


@pytest.mark.parametrize("key", ["potential_energy", "kinetic_energy", "mechanical_energy"])
def test_energies_that_do_not_add_up_are_told(reference, key):
    def change(k, values, number):
        return values + (smooth_error(reference, number, 1e-9) if k == key else 0.0)

    report = score(made(reference, change), reference)
    assert codes(report) == ["energy_sum"]
    assert report.findings[0].evidence["maneuvers"] == [1, 2, 3]
    assert report.maneuvers[1].consistency.energy_sum == pytest.approx(1e-9, rel=1e-3)


def rate_from(angle, step=0.01):
    return np.diff(angle, append=2 * angle[-1] - angle[-2]) / step


@pytest.mark.parametrize("which", ["roll", "steer"])
def test_a_rate_by_forward_differences_is_told(reference, which):
    def change(key, values, number):
        if key != f"{which}_rate":
            return values
        return rate_from(reference[number].rows[f"{which}_angle"])

    report = score(made(reference, change), reference)
    assert "rate_is_not_the_derivative" in codes(report)
    told = {f.evidence["column"] for f in report.findings if "rate" in f.code}
    assert told == {f"{which}_rate"}


@pytest.mark.parametrize("size", [1e-9, 1e-3])
def test_an_error_shared_by_angle_and_rate_is_no_contradiction(reference, size):
    def change(key, values, number):
        t = reference[number].time
        error = {"angle": size * np.sin(2 * t), "rate": 2 * size * np.cos(2 * t)}
        return values + error.get(key.partition("_")[2], 0.0)

    report = score(made(reference, change), reference)
    assert "rate_is_not_the_derivative" not in codes(report)
    for m in report.maneuvers:
        # The trapezoidal rule has an error of size w^3 h^2 / 12, with w = 2/s and h = 0.01 s.
        # Rounding adds one unit of the last digit per step.
        assert m.consistency.steer_rate < size * 8e-4 / 12 + 2 * np.spacing(0.2) / 0.01
        # With a larger error the definitions of roll angle and rate are undecided, which is no
        # contradiction.
        assert (m.consistency.roll_rate is None) == (size == 1e-3)


@pytest.mark.parametrize(
    ("angle", "rate", "is_pair"),
    [
        ("roll_angle", "roll_rate", True),
        ("roll_angle_tait_bryan_xyz", "roll_rate_tait_bryan_xyz_rate", True),
        ("roll_angle_zyx", "roll_rate_zyx_rate", True),
        ("roll_angle_tait_bryan_xyz", "roll_rate_body_x", False),
        ("roll_angle", "roll_rate_body_x", False),
    ],
)
def test_only_pairs_are_held_against_each_other(reference, angle, rate, is_pair):
    report = score(made(reference, names=[angle, rate, *BENCHMARK_COLUMNS[2:]]), reference)
    found = [m.consistency.roll_rate for m in report.maneuvers]
    assert all((x is not None) == is_pair for x in found)
    assert "rate_is_not_the_derivative" not in codes(report)
    if is_pair:
        assert max(found) < 1e-13


@pytest.mark.parametrize("form", ["%.6f", "%.4f", "%.4g"])
def test_rounding_is_not_blamed_on_the_program(reference, folder, form, tmp_path):
    table = np.loadtxt(folder / "uncontrolled-bicycle.txt")
    file = tmp_path / "rounded.txt"
    np.savetxt(file, table, form)
    report = score(read_results(file), reference)
    assert set(codes(report)) <= {"digits_written"}


def test_single_precision_written_long_is_told_by_its_digits(reference, folder, tmp_path):
    table = np.loadtxt(folder / "uncontrolled-bicycle.txt").astype(np.float32)
    for form in ("%.9g", "%.15e"):
        file = tmp_path / "single.txt"
        np.savetxt(file, table, form)
        report = score(read_results(file), reference)
        assert report.file.significant_digits == 7
        assert "energy_sum" not in codes(report)


def test_an_integrators_error_is_no_contradiction(reference):
    """The steps of a method of low order are wide, and its angles and rates are wrong alike."""
    series = [read_results(data_folder() / "peers" / f"exudyn-h{h}.txt") for h in (0.01, 0.001)]
    for results in series:
        assert "rate_is_not_the_derivative" not in codes(score(results, reference))


@pytest.mark.parametrize(("part", "is_told"), [(0.5, False), (5.0, True)])
def test_a_rate_is_to_blame_where_the_error_of_its_angle_is_not_the_reason(
    reference, part, is_told
):
    """The angle is wrong, and the rate has an error beyond that of the angle, `part` times as
    large."""

    def change(key, values, number):
        t, size = reference[number].time, 1e-3 * np.max(np.abs(reference[number]["steer_rate"]))
        error = {
            "steer_angle": size / 2 * np.sin(2 * t),
            "steer_rate": size * (np.cos(2 * t) + part * np.cos(5 * t)),
        }
        return values + error.get(key, 0.0)

    report = score(made(reference, change), reference)
    told = [m.maneuver for m in report.maneuvers if "steer_rate" in m.consistency.contradicted]
    assert told == ([1, 2, 3] if is_told else [])


@pytest.mark.parametrize(("times", "is_told"), [(0.1, False), (1.0, True), (30.0, False)])
def test_noise_of_rounding_to_24_bits_on_the_way_is_told_by_its_size(reference, times, is_told):
    """Noise of half a bit of single precision is recognised; a tenth or many times as much is
    not."""
    random = np.random.default_rng(24)

    def change(key, values, number):
        # The noise has the largest relative rounding error of a value with 24 bits.
        noise = random.uniform(-1.0, 1.0, len(values)) * 2.0**-24
        return values + times * noise * np.sqrt(np.mean(values**2))

    report = score(made(reference, change), reference)
    found = [x for x in report.seen if isinstance(x, SinglePrecision)]
    assert [x.is_written for x in found] == ([False] if is_told else [])


@pytest.mark.parametrize(("times", "is_told"), [(1.6, False), (6.0, True)])
def test_a_rate_that_may_be_of_another_definition_is_not_blamed(reference, times, is_told):
    """The error of the rate is `times` the difference between its possible definitions."""

    def change(key, values, number):
        if key != "roll_rate":
            return values
        apart = np.sqrt(np.mean((values - reference[number]["roll_rate_body_x"]) ** 2))
        t = reference[number].time
        return values + times * apart * np.sqrt(2) * np.sin(5 * t + number)

    report = score(made(reference, change), reference)
    assert "body_x" in column(report, 2, "roll_rate").indistinguishable or is_told
    told = [m.maneuver for m in report.maneuvers if "roll_rate" in m.consistency.contradicted]
    assert told == ([1, 2, 3] if is_told else [])


@pytest.mark.parametrize(("count", "is_told"), [(3, False), (4, True), (8, True)])
def test_half_of_the_columns_in_single_precision_make_a_file_of_it(reference, count, is_told):
    single = BENCHMARK_COLUMNS[:count]

    def change(key, values, number):
        return values.astype(np.float32).astype(float) if key in single else values

    report = score(made(reference, change), reference)
    found = [x for x in report.seen if isinstance(x, SinglePrecision) and x.is_written]
    assert [x.are_all for x in found] == ([count == 8] if is_told else [])

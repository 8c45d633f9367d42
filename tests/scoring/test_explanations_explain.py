"""What is left must be an integrator's error, and the first row must not say the contrary."""

import numpy as np
import pytest
from support.made_results import made

from heyoka_bike.bicycle.columns import DEFINITIONS, LATERAL
from heyoka_bike.scoring.alignment import align
from heyoka_bike.scoring.definitions import understand
from heyoka_bike.scoring.diagnosis.mistakes.first_row import contradicted
from heyoka_bike.scoring.diagnosis.remainder import (
    energy_level,
    is_nothing,
    too_large,
    written_wrongly,
)

PLACES = [(n, key) for n in (1, 2, 3) for key in LATERAL]


def level_of(reference, change):
    parts = align(made(reference, change), reference).parts
    return energy_level(parts, understand(parts))


def test_an_exact_file_keeps_its_energy_to_rounding(reference):
    # 1e-15 of some thousand J, of an exchange of a hundredth of a J in maneuver 3.
    assert level_of(reference, lambda key, v, n: v) < 1e-8


def test_a_drift_of_the_energy_is_measured_in_the_exchange(reference):
    def drifting(key, v, number):
        size = np.std(reference[number].rows["potential_energy"])
        drift = 1e-3 * size * np.ones(len(v)) if key == "kinetic_energy" else 0.0
        return v + drift * (np.arange(len(v)) > 0)

    assert level_of(reference, drifting) == pytest.approx(1e-3, rel=0.01)


@pytest.mark.parametrize("value", [0.0, 700.0])
def test_energies_that_were_never_filled_in_tell_nothing(reference, value):
    def never(key, v, number):
        return np.full_like(v, value) if key == "potential_energy" else v

    assert level_of(reference, never) is None


def test_errors_of_one_size_are_an_integrators():
    left = dict.fromkeys(PLACES, 1e-4)
    assert too_large(left, {}, None) is None
    assert too_large(left, {}, 1e-5) is None


def test_what_the_energy_does_not_show_is_no_integrators_error():
    left = dict.fromkeys(PLACES, 1e-4) | {(2, "steer_rate"): 2e-4}
    assert too_large(left, {}, 1e-12) == (2, "steer_rate")
    # One maneuver alone may all but conserve it.
    alone = {(3, key): 1e-4 for key in LATERAL}
    assert too_large(alone, {}, 1e-7) is None
    assert too_large(left, {}, 1e-7) is not None


def test_one_column_far_worse_than_the_best_is_no_integrators_error():
    left = dict.fromkeys(PLACES, 1e-12) | {(1, "roll_angle"): 1e-3}
    assert too_large(left, {}, None) == (1, "roll_angle")
    # But for the digits written.
    assert too_large(left, {(1, "roll_angle"): 1e-3}, None) is None


def test_an_energy_that_is_written_otherwise_is_explained_as_well_as_the_motion():
    energy = (1, "mechanical_energy")
    left = dict.fromkeys(PLACES, 1e-9) | {energy: 1e-2}
    assert written_wrongly({energy: np.log(12)}, left, {}) == energy
    assert written_wrongly({energy: np.log(12)}, left, {energy: 1e-2}) is None
    assert written_wrongly({energy: np.log(4e3)}, left, {}) is None
    assert written_wrongly({energy: np.log(12)}, left | {energy: 1e-9}, {}) is None


def test_nothing_is_left_at_the_floor():
    assert is_nothing({(1, "roll_angle"): 1e-5}, {(1, "roll_angle"): 5e-6})
    assert not is_nothing({(1, "roll_angle"): 1e-5}, {})


def columns(first, second, rest=5):
    made_of = [first, second, *np.linspace(second, 2 * second, rest)]
    return {c.name: np.array(made_of) for c in DEFINITIONS["roll_rate"]}


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        # Right at the start and after it: a tiny motion scaled up, or linear equations.
        ((0.05, 0.0501), "roll_rate"),
        # Told 0.05, and then the program's own.
        ((0.05, 0.00088), None),
        # Neither.
        ((0.03, 0.0301), None),
        # As the mistake makes it.
        ((0.00087, 0.00088), None),
    ],
)
def test_a_first_row_contradicts_what_starts_otherwise(written, expected):
    time = np.arange(7) / 100
    right, wrong = columns(0.05, 0.0500), columns(0.00087, 0.00088)
    found = contradicted(time, columns(*written), right, wrong, {"roll_rate": 1e-9})
    assert found == expected
    # A file that begins later says nothing.
    assert contradicted(time + 1, columns(*written), right, wrong, {"roll_rate": 1e-9}) is None

"""T and V mean kinetic and potential energy if the file also has a time and a speed."""

import numpy as np
import pytest

from generators.made_results import is_right_in_part
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score

ROWS = np.arange(9.0)


def keys_of(names):
    """Return the recognised key of each column number. The first value of column j is j."""
    (rows,) = read_results({name: ROWS + j for j, name in enumerate(names)}).maneuvers
    return {int(values[0]): key for key, values in rows.values.items()}


@pytest.mark.parametrize(
    "names",
    [
        ["time", "roll", "rollRate", "speed", "V", "T", "E", "steer", "steerRate"],
        ["time", "roll", "rollRate", "velocity", "V", "T", "H", "steer", "steerRate"],
        ["t", "roll", "rollRate", "v", "V", "T", "E", "steer", "steerRate"],
    ],
)
def test_capitals_beside_other_energies(names):
    found = keys_of(names)
    assert (found[3], found[4], found[5]) == ("forward_speed", "potential_energy", "kinetic_energy")


def test_a_structure_of_matlab_is_read(tmp_path):
    scipy_io = pytest.importorskip("scipy.io")
    names = ["time", "roll", "speed", "V", "T", "E"]
    results = {name: ROWS + j for j, name in enumerate(names)}
    scipy_io.savemat(tmp_path / "r.mat", {"results": results})
    (rows,) = read_results(tmp_path / "r.mat").maneuvers
    assert (rows.values["potential_energy"][0], rows.values["kinetic_energy"][0]) == (3, 4)


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (["time", "roll", "V"], {1: "roll_angle", 2: "forward_speed"}),
        (["T", "roll", "V"], {1: "roll_angle", 2: "forward_speed"}),
        (["T", "roll", "E"], {1: "roll_angle", 2: "mechanical_energy"}),
        (["time", "V", "Epot", "Ekin"],
         {1: "forward_speed", 2: "potential_energy", 3: "kinetic_energy"}),
    ],
)  # fmt: skip
def test_capitals_alone_are_time_and_speed(names, found):
    assert keys_of(names) == found


@pytest.mark.parametrize("names", [["time", "speed", "V"], ["time", "speed", "V", "Epot", "Ekin"]])
def test_two_columns_of_one_meaning_are_refused_with_what_to_do(names):
    with pytest.raises(InputError, match=r"found 'speed' and 'V'.*; to name .* columns="):
        keys_of(names)


def test_a_v_that_is_a_speed_makes_no_energy_of_t():
    with pytest.raises(InputError, match="found 'time' and 'T', expected one column of time"):
        keys_of(["time", "roll", "V", "T"])


@pytest.mark.parametrize("key", ["forward_speed", "potential_energy"])
def test_a_v_beside_a_kinetic_energy_is_what_its_values_are(reference, key):
    m = reference[2]
    meant = {"roll": "roll_angle", "Ekin": "kinetic_energy", "V": key}
    named = {name: m.rows[k] for name, k in meant.items()}
    report = score({"time": m.time, **named}, maneuver=2)
    assert {*report[2]} == {*meant.values()}
    assert is_right_in_part(report)


def test_one_number_behind_letters_with_units_is_that_of_a_maneuver():
    names = ["t", "V_2 [J]", "T_2 [J]", "E_2 [J]"]
    (rows,) = read_results({name: ROWS + j for j, name in enumerate(names)}).maneuvers
    assert rows.maneuver == 2
    assert {*rows.values} == {"potential_energy", "kinetic_energy", "mechanical_energy"}


@pytest.mark.parametrize("names", [["V2"], ["V2", "T2", "E2"], ["V2 [J]"]])
def test_a_number_behind_a_letter_alone_may_be_of_anything(names):
    with pytest.raises(InputError, match="not understood"):
        read_results(dict.fromkeys(("t", *names), ROWS))

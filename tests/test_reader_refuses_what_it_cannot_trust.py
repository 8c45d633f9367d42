"""`load_reference` and `evaluate` name what is wrong instead of returning something."""

import shutil
from fractions import Fraction

import numpy as np
import pytest

from heyoka_bike.errors import DatasetError, InputError
from heyoka_bike.reference import load_reference


@pytest.fixture
def copy(folder, tmp_path):
    return shutil.copytree(folder, tmp_path / "reference")


def test_a_missing_folder_and_a_missing_file(tmp_path, copy):
    with pytest.raises(DatasetError, match=r"no manifest\.json"):
        load_reference(tmp_path / "nothing")
    (copy / "uncontrolled-bicycle.h5").unlink()
    with pytest.raises(DatasetError, match=r"uncontrolled-bicycle\.h5"):
        load_reference(copy)


def test_a_changed_byte(copy):
    path = copy / "uncontrolled-bicycle.h5"
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    with pytest.raises(DatasetError, match="damaged"):
        load_reference(copy)


@pytest.mark.parametrize(
    "text", ["", "{}", "[]", "null", '{"schema_version": 1}', "\x00", "[" * 9999]
)
def test_a_manifest_that_is_none(copy, text):
    (copy / "manifest.json").write_text(text)
    with pytest.raises(DatasetError):
        load_reference(copy)


def test_a_newer_schema(copy):
    path = copy / "manifest.json"
    path.write_text(path.read_text().replace('"schema_version": 1', '"schema_version": 2'))
    with pytest.raises(DatasetError, match="newer"):
        load_reference(copy)


@pytest.mark.parametrize(
    "t",
    [-1e-300, np.nextafter(10.0, 11.0), np.nan, np.inf, "10.0000000000000000000000001", "pi*4",
     Fraction(-1, 10**40), [1.0, 11.0], (10.0, 1e-25), "x", "", None, ["1", "y"], {}],
)  # fmt: skip
def test_times_outside_or_not_numbers(reference, t):
    with pytest.raises(InputError):
        reference[1].evaluate(t)


def test_unknown_names(reference):
    with pytest.raises(InputError, match="expected one of"):
        reference[1].evaluate(1.0, ["rol_angle"])
    with pytest.raises(KeyError, match="expected 1 to 3"):
        reference[4]
    with pytest.raises(KeyError):
        reference[0]


def test_forms_of_time_agree(reference):
    m = reference[2]
    exact = Fraction(7, 100)
    hi = float(exact)
    pair = (hi, float(exact - Fraction(hi)))
    values = [m.evaluate(t) for t in ("0.07", exact, pair, (0.0, 0.07))]
    for v in values[:3]:
        for name in m.columns:
            assert v[name] == m.rows.hi[name][7]
            assert v[name].shape == ()
    # A plain float is another time: the difference is visible.
    assert m.evaluate(0.07).lo["steer_rate"] != values[0].lo["steer_rate"]
    grid = np.array([[0.0, 1.0], [2.0, 10.0]])
    assert m.evaluate(grid)["yaw"].shape == (2, 2)
    assert m.evaluate([])["yaw"].shape == (0,)


def test_arrays_cannot_be_changed_by_accident(reference):
    with pytest.raises(ValueError, match="read-only"):
        reference[1].rows.hi["roll_angle"][0] = 1.0

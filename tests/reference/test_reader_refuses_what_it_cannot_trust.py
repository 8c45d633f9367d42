"""`load_reference` and `evaluate` report what is wrong instead of returning something."""

import shutil
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from heyoka_bike.errors import DatasetError, InputError
from heyoka_bike.reference.load import load_reference


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
     Fraction(-1, 10**40), [1.0, 11.0], (10.0, 1e-25), "x", "", None, ["1", "y"], {}, True,
     (0.07, 0.08), ("0.07", "0.08"), (Fraction(7, 100), 0), (np.zeros(2), np.zeros(3)),
     [[1.0], 2.0]],
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
    values = [m.evaluate(t) for t in ("0.07", exact, pair, Decimal("0.07"), b"0.07")]
    for v in values:
        for name in m.columns:
            assert v[name] == m.rows.hi[name][7]
            assert v[name].shape == ()
    for t in (["0.07"], np.array(["0.07"]), np.array([exact]), [exact, 1.0], [["0.07"]]):
        assert m.evaluate(t).lo["steer_rate"].flat[0] == m.rows.lo["steer_rate"][7]
    # The float 0.07 is not exactly 7/100 s, so the value differs from the row's in its low part.
    assert m.evaluate(0.07).lo["steer_rate"] != values[0].lo["steer_rate"]
    grid = np.array([[0.0, 1.0], [2.0, 10.0]])
    assert m.evaluate(grid)["yaw"].shape == (2, 2)
    assert m.evaluate([])["yaw"].shape == (0,)


def test_the_reference_is_short_to_look_at_and_comparable(reference):
    for x in (reference, reference[2], reference[2].rows):
        assert len(repr(x)) < 100
        assert x == x
        assert isinstance(hash(x), int)
    assert reference[1] != reference[2]
    assert reference[1].evaluate(1.0, "yaw")["yaw"] > 0
    with pytest.raises(KeyError, match="expected one of"):
        reference[1].rows["rollangle"]


def test_arrays_cannot_be_changed_by_accident(reference):
    with pytest.raises(ValueError, match="read-only"):
        reference[1].rows.hi["roll_angle"][0] = 1.0

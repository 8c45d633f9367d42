"""states.csv and states.h5 of a dataset are proved again from the decimals of the coordinates."""

import csv
import io
import json
import shutil

import h5py
import pytest

import heyoka_bike as hb
from generators.made_sets import accept, older
from heyoka_bike.bicycle.instant_columns import QUANTITIES
from heyoka_bike.cli import main
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.reference import hdf5
from heyoka_bike.reference.layout import STATES, STATES_HDF5
from heyoka_bike.reference.proof import instants
from heyoka_bike.reference.proof.certify import certify
from heyoka_bike.reference.proof.instants import as_csv, known_states, render_states, states_differ
from heyoka_bike.reference.verification.verify import verify


@pytest.fixture(scope="module")
def files(bicycle):
    """Files of four of the known states: one leans and is steered, one is near a maneuver."""
    few = [known_states()[n - 1] for n in (1, 14, 60, 100)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(instants, "known_states", lambda: few)
        inputs = {"bicycle": {"name": bicycle.name, "parameters": {}}}
        return render_states(bicycle, inputs, "2.0.0")


def changed(raw, change):
    """Return a file of states in which a function changed the lists or the open file."""
    if raw.startswith(b"state,"):
        rows = list(csv.reader(io.StringIO(raw.decode())))
        change(rows)
        return "".join(",".join(row) + "\n" for row in rows).encode()
    file = io.BytesIO(raw)
    with h5py.File(file, "r+") as f:
        change(f)
    return file.getvalue()


@pytest.mark.parametrize("name", [STATES, STATES_HDF5])
def test_what_is_made_is_proved_and_has_every_quantity(files, bicycle, name):
    assert list(states_differ(name, files[name], bicycle)) == []
    heading = files[STATES].decode().partition("\n")[0].split(",")
    assert heading == ["state", *(f"{c.name} [{c.unit}]" for c in QUANTITIES.values())]
    with hdf5.opened(files[STATES_HDF5]) as f:
        assert set(f) == {"state", *QUANTITIES}
        assert all(f[c.name].attrs["units"] == c.unit for c in QUANTITIES.values())


def off_by_one_digit(rows):
    value = float(rows[3][100])
    rows[3][100] = repr(value * (1 + 2**-52))
    assert float(rows[3][100]) != value


def off_in_hdf5(f):
    f["com_x"][2] *= 1 + 2**-52


def other_state(x):
    if isinstance(x, list):
        x[2][1] = "0.125"
    else:
        x["roll_angle"][1] = 0.125


def off_the_floor(rows):
    rows[2][1:3] = ["1.57", "1.5"]


def set_cell(row, column, text):
    def change(rows):
        rows[row][column] = text

    return change


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        (STATES, off_by_one_digit, "state 3: "),
        (STATES_HDF5, off_in_hdf5, "state 3: com_x: found "),
        # All quantities are computed again from the coordinates in the file, so a changed
        # coordinate shows in the next quantity.
        (STATES, other_state, "state 2: pitch"),
        (STATES_HDF5, other_state, "state 2: pitch"),
        (STATES, set_cell(1, 0, "2"), "state 1: state: found 2, proved 1"),
        (STATES, set_cell(1, 30, "x"), "found x, proved "),
        (STATES, set_cell(1, 30, "nan"), "found nan, proved "),
        (STATES, set_cell(2, 1, "1e400"), "the states cannot be used: state 2: found '1e400'"),
        (STATES, set_cell(2, 1, "1/3"), "the states cannot be used: state 2: found '1/3'"),
        (STATES, off_the_floor, "the states cannot be used: state 2: no pitch"),
        (STATES, set_cell(0, 20, "height [m]"), "found the columns state, roll_angle"),
        (STATES, set_cell(0, 20, "pitch [deg]"), "found the columns state, roll_angle"),
        (STATES_HDF5, lambda f: f.move("pitch", "height"), "found the columns state, roll_angle"),
    ],
)
def test_any_other_value_is_named(files, bicycle, name, change, said):
    found = list(states_differ(name, changed(files[name], change), bicycle))
    assert any(said in text for text in found), found


def test_the_states_of_another_bicycle_are_other_ones(files, bicycle):
    other = bicycle.replace(mB=hb.Exact.parse("85.00001"))
    found = list(states_differ(STATES, files[STATES], other))
    assert any(": com_x: found" in text for text in found)
    assert not any(": pitch: " in text for text in found)


@pytest.mark.proof
def test_a_set_has_them_and_verify_and_certify_look(small_set, tmp_path, bicycle, capsys):
    assert (small_set / STATES).read_bytes() == as_csv(bicycle, known_states())
    proved = json.loads((small_set / "certificate.json").read_text())["proved"]
    assert proved[STATES] == proved[STATES_HDF5] == list(QUANTITIES)
    assert main(["certify", str(small_set)]) == 0
    assert f"{STATES} (189 columns), {STATES_HDF5} (189 columns)" in capsys.readouterr().out
    copy = shutil.copytree(small_set, tmp_path / "copy")
    for name, change in ((STATES, off_by_one_digit), (STATES_HDF5, off_in_hdf5)):
        (copy / name).write_bytes(changed((copy / name).read_bytes(), change))
    accept(copy)
    failed = [c for c in verify(copy).checks if c.passed is False]
    assert [(c.check, c.file) for c in failed] == [("states", STATES), ("states", STATES_HDF5)]
    assert all(c.message.startswith("state 3: ") for c in failed)
    with pytest.raises(NotCertifiedError, match=r"states\.csv: state 3: "):
        certify(copy)


@pytest.mark.proof
def test_other_attributes_are_found(small_set, tmp_path):
    copy = shutil.copytree(small_set, tmp_path / "copy")
    with h5py.File(copy / STATES_HDF5, "r+") as f:
        f["pitch"].attrs["units"] = "deg"
        f.attrs["more"] = "anything"
    accept(copy)
    (failed,) = [c for c in verify(copy).checks if c.passed is False]
    assert (failed.check, failed.file) == ("states", STATES_HDF5)
    with pytest.raises(NotCertifiedError, match=r"states\.h5: found attribute more"):
        certify(copy)


@pytest.mark.proof
def test_a_set_without_them_is_what_it_was(small_set, tmp_path):
    """Version 1.5.0 has no states, and does not state the drift of the integration."""
    copy = shutil.copytree(small_set, tmp_path / "copy")
    older(copy, "1.5.0")
    assert {c.passed for c in verify(copy).checks} == {True}
    (proof,) = certify(copy)
    assert proof.bound < 1e-60
    # The certificate now claims a file that does not exist.
    document = json.loads((copy / "certificate.json").read_text())
    document["proved"][STATES] = list(QUANTITIES)
    (copy / "certificate.json").write_text(json.dumps(document, indent=2) + "\n")
    accept(copy)
    assert {c.file for c in verify(copy).checks if c.passed is False} == {"certificate.json"}
    with pytest.raises(NotCertifiedError, match="its 'proved' differs from the proved value"):
        certify(copy)


@pytest.mark.proof
def test_what_the_integration_keeps_is_in_the_certificate(small_set, tmp_path):
    path = small_set / "certificate.json"
    (said,) = (m["integration"] for m in json.loads(path.read_text())["maneuvers"])
    assert all(0 < float(x) < 1e-68 for x in said.values())
    (check,) = (c for c in verify(small_set).checks if c.check == "integration")
    assert check.evidence["largest"] == pytest.approx(float(said["performance_percent"]), rel=0.01)
    for key in said:
        copy = shutil.copytree(small_set, tmp_path / key)
        document = json.loads((copy / path.name).read_text())
        document["maneuvers"][0]["integration"][key] = "1e-90"
        (copy / path.name).write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n")
        accept(copy)
        failed = {c.check for c in verify(copy).checks if c.passed is False}
        assert failed == {"integration"}
    with pytest.raises(NotCertifiedError, match="integration, contact: published '1e-90'"):
        certify(copy)

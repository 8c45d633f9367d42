"""`heyoka-bike certify` proves the published dataset again, and names changes in a copy."""

import json
import shutil
import subprocess
import sys
from fractions import Fraction
from itertools import product

import h5py
import numpy as np
import pytest

from generators.made_sets import accept, manifest
from heyoka_bike.bicycle.motion_columns import DENSE_COLUMNS
from heyoka_bike.cli import main
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.reference.layout import content_sha256
from heyoka_bike.reference.manifest import MANIFEST
from heyoka_bike.reference.proof.certificate import compare_certificate
from heyoka_bike.reference.proof.certify import certify as prove

# The limit for the derivatives follows from the worst column and unknown, whose derivative is tiny.
# Nearly all other derivatives have a bound below 24 x 2^-50.
FIGURES = {"bound": 1e-60, "dense": 1e-25, "derivatives": 5e-12}


@pytest.mark.proof
def test_certificate_says_what_was_to_be_reached(folder, reference):
    document = json.loads((folder / "certificate.json").read_text())
    assert len(document["maneuvers"]) == 3
    for entry, maneuver in zip(document["maneuvers"], reference.values(), strict=True):
        assert entry["ambiguous"] == 0
        assert entry["entries"] == 1001 * 38
        assert entry["motion"]["entries"] == 1001 * 78
        assert entry["sensitivities"]["entries"] == 101 * 8 * 31
        assert entry["sensitivities"]["ambiguous"] == 0
        derivatives = entry["sensitivities"]["relative_bounds"]
        assert set(derivatives) == set(maneuver.columns)
        assert all(float(x) <= FIGURES["derivatives"] for x in derivatives.values())
        assert float(entry["bound"]) <= FIGURES["bound"]
        assert float(entry["bound_end"]) <= float(entry["bound"])
        assert set(entry["state_bounds"]) == {
            "roll", "pitch", "steer", "w1", "w3", "spin", "yaw",
        }  # fmt: skip
        worst = max(Fraction(b["interval"]) for b in entry["state_bounds"].values())
        assert worst == Fraction(entry["bound"])
        assert set(entry["dense_relative_bounds"]) == set(maneuver.columns)
        assert set(entry["motion"]["dense_relative_bounds"]) == set(DENSE_COLUMNS)
        for bounds in (entry, entry["motion"]):
            assert all(
                float(x) <= FIGURES["dense"] for x in bounds["dense_relative_bounds"].values()
            )


@pytest.mark.proof
def test_row_bounds_are_those_of_hi_plus_lo(reference):
    for maneuver in reference.values():
        for name in maneuver.columns:
            bound, lo = maneuver.rows.bound[name], maneuver.rows.lo[name]
            # The bound is half an ulp of lo, rounded up. The candidate's error of 1e-62 is smaller
            # than the bound.
            assert (bound <= abs(lo) * 2.0**-53 * (1 + 1e-9) + 1e-60).all(), name
            scale = abs(maneuver.rows.hi[name]).max()
            assert (maneuver.dense.bound[name] <= 1e-25 * scale).all(), name


@pytest.fixture
def copy(small_set, tmp_path):
    return shutil.copytree(small_set, tmp_path / "copy")


def certify(folder, capsys):
    code = main(["certify", str(folder), "--workers", "1"])
    error = capsys.readouterr().err
    assert error.count("\n") == (0 if code == 0 else 1)
    return code, error


@pytest.mark.proof
def test_a_whole_set_is_proved_without_heyoka_and_what_is_proved_is_said(small_set):
    """By default the proof runs in separate processes."""
    code = (
        "import sys; sys.modules['heyoka'] = None\n"
        f"from heyoka_bike.cli import main; sys.exit(main(['certify', {str(small_set)!r}]))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    *_, proved = run.stdout.splitlines()
    assert "proved: uncontrolled-bicycle.h5 (38 columns), motion.h5 (78 columns)" in proved
    assert "sensitivities.h5 (38 columns)" in proved


@pytest.mark.proof
def test_a_whole_set_is_proved_in_this_process(small_set, capsys):
    assert certify(small_set, capsys) == (0, "")


@pytest.mark.proof
def test_a_damaged_file_is_named(copy, capsys):
    path = copy / "candidate.h5"
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 4
    path.write_bytes(data)
    code, error = certify(copy, capsys)
    assert code == 1
    assert "candidate.h5" in error


@pytest.mark.proof
@pytest.mark.parametrize(
    ("dataset", "index", "factor", "fragment"),
    [
        ("roll_angle", 7, 1 + 2.0**-52, "roll_angle, row 7"),
        ("steer_rate_lo", 3, 1 + 2.0**-52, "steer_rate_lo, row 3"),
        ("yaw_bound", 5, 0.5, "yaw_bound, row 5"),
        ("dense/forward_speed_lo", (0, 2), -1.0, "dense forward_speed, piece 1"),
        ("dense/pitch_bound", 0, 1e-3, "dense pitch, piece 1"),
    ],
)
def test_a_changed_number_is_named(copy, capsys, dataset, index, factor, fragment):
    with h5py.File(copy / "uncontrolled-bicycle.h5", "r+") as f:
        item = f[f"maneuver_1/{dataset}"]
        item[index] = item[index] * factor
        f.attrs["content_sha256"] = content = content_sha256(f)
    accept(copy)
    manifest(copy, content_sha256=content)
    code, error = certify(copy, capsys)
    assert code == 3
    assert fragment in error


@pytest.mark.proof
@pytest.mark.parametrize(
    ("name", "fragment"),
    [("roll_angle_bound", "roll_angle_bound, row 0"), ("dense/yaw_bound", "dense yaw, piece 1")],
)
def test_a_bound_that_is_no_number_is_refused(copy, capsys, name, fragment):
    with h5py.File(copy / "uncontrolled-bicycle.h5", "r+") as f:
        f[f"maneuver_1/{name}"][...] = float("nan")
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    assert fragment in error


def replaced(group, name, data):
    del group[name]
    group.create_dataset(name, data=data)


@pytest.mark.proof
@pytest.mark.parametrize("breaks", [[0.0, 50.0], [50.0, 51.0], [0.0, 0.1], [0.0, float("nan")]])
def test_dense_pieces_off_the_time_of_the_motion_are_refused(copy, capsys, breaks):
    """Such segments would have no proved bound."""
    with h5py.File(copy / "uncontrolled-bicycle.h5", "r+") as f:
        dense = f["maneuver_1/dense"]
        for name in [n for n in dense if n not in ("breaks", "order", "piece")]:
            replaced(dense, name, dense[name][:1])
        replaced(dense, "breaks", breaks)
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    assert "content_sha256" in error or "incomplete" in error


@pytest.mark.proof
def test_dense_shape_is_checked_apart_from_the_hash(small_set):
    from dataclasses import replace

    from heyoka_bike.errors import NotCertifiedError
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.reference.proof.candidate import read_candidate
    from heyoka_bike.reference.proof.dense import bound_dense

    (run,) = read_candidate(small_set)
    dense = load_reference(small_set)[1].dense
    late = dense.breaks.copy()
    late[0] = 0.01
    thrice = [{name: x[[0, 0, 0]] for name, x in part.items()} for part in (dense.hi, dense.lo)]
    backward = replace(dense, hi=thrice[0], lo=thrice[1], breaks=np.array([0.0, 0.15, 0.1, 0.2]))
    off = (dense.breaks + 50.0, dense.breaks[::-1].copy(), dense.breaks * 0.5, late)
    for wrong in (*(replace(dense, breaks=breaks) for breaks in off), backward):
        with pytest.raises(NotCertifiedError, match="incomplete"):
            bound_dense(run, (), wrong, list(dense.hi), {})


@pytest.mark.proof
@pytest.mark.parametrize(
    ("name", "change"),
    [("time", lambda x: x + 1.0), ("roll_rate", lambda x: x.view("i8")), ("yaw", lambda x: x[:-1])],
)
def test_what_is_not_a_value_is_looked_at_too(copy, capsys, name, change):
    with h5py.File(copy / "uncontrolled-bicycle.h5", "r+") as f:
        group = f["maneuver_1"]
        replaced(group, name, change(group[name][:]))
        f.attrs["content_sha256"] = content = content_sha256(f)
    accept(copy)
    manifest(copy, content_sha256=content)
    code, error = certify(copy, capsys)
    assert code == 3
    assert f"{name}" in error


@pytest.mark.proof
def test_a_wrong_content_hash_is_named(copy, capsys):
    manifest(copy, content_sha256="0" * 64)
    code, error = certify(copy, capsys)
    assert code == 3
    assert "content_sha256" in error


@pytest.mark.proof
def test_a_changed_candidate_is_refused(copy, capsys):
    with h5py.File(copy / "candidate.h5", "r+") as f:
        item = f["maneuver_1/coefficients"]
        item[2, 0, 1, 20] = item[2, 0, 1, 20] ^ 1
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    # The message depends on the change: either the segments belong to a different motion, or
    # nothing is proved.
    said = ("is not certified", "proved", "decide", "breaks of the derivatives")
    assert any(words in error for words in said)


@pytest.mark.proof
def test_other_inputs_are_refused(copy, capsys):
    with h5py.File(copy / "candidate.h5", "r+") as f:
        parameters = json.loads(f.attrs["parameters"])
        f.attrs["parameters"] = json.dumps(parameters | {"g": "982/100"})
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    assert "inputs" in error


@pytest.mark.proof
def test_a_changed_text_is_named(copy, capsys):
    path = copy / "uncontrolled-bicycle-50digits.txt"
    text = path.read_text()
    path.write_text(text[:-2] + ("1" if text[-2] != "1" else "2") + "\n")
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    assert path.name in error


@pytest.fixture(scope="module")
def proofs(small_set):
    return prove(small_set)


@pytest.mark.proof
@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("maneuvers", 0, "state_bounds", "roll", "interval"), "1e-99"),
        (("maneuvers", 0, "bound"), "0"),
        (("maneuvers", 0, "dense_relative_bounds", "pitch"), "1e-99"),
        (("maneuvers", 0, "bound_end"), "nonsense"),
        (("maneuvers", 0, "ambiguous"), 1),
        (("statement",), "All is well."),
        (("maneuvers", 0, "motion", "dense_relative_bounds", "com_z"), "1e-99"),
        (("maneuvers", 0, "motion", "entries"), 1),
        (("maneuvers", 0, "sensitivities", "relative_bounds", "yaw"), "1e-99"),
    ],
)
def test_a_certificate_that_claims_something_else_is_named(small_set, proofs, path, value):
    raw = (small_set / "certificate.json").read_bytes()
    compare_certificate(raw, proofs)
    with pytest.raises(NotCertifiedError, match=r"certificate\.json"):
        compare_certificate(json.dumps(changed(json.loads(raw), path, value)).encode(), proofs)


@pytest.mark.proof
@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("maneuvers", 0, "bound"), "0"),
        (("proved", "sensitivities.h5"), ["roll_angle"]),
        (("computed",), {"motion.h5": "in binary64"}),
        (("limit_cycle",), {"bound": "1e-999"}),
    ],
)
def test_the_command_names_a_certificate_that_claims_something_else(copy, capsys, path, value):
    file = copy / "certificate.json"
    file.write_text(json.dumps(changed(json.loads(file.read_text()), path, value)))
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    assert "certificate.json" in error


def changed(document, path, value):
    entry = document
    for key in path[:-1]:
        entry = entry[key]
    entry[path[-1]] = value
    return document


@pytest.mark.proof
def test_a_maneuver_that_no_candidate_has_is_refused(copy, capsys):
    file = copy / "certificate.json"
    document = json.loads(file.read_text())
    more = json.loads(json.dumps(document["maneuvers"][0])) | {"bound": "1e-999"}
    document["maneuvers"].append(more)
    file.write_text(json.dumps(document))
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    assert "found 2 maneuvers, expected 1" in error


@pytest.mark.proof
@pytest.mark.parametrize(
    ("file", "place"),
    [
        *product(("uncontrolled-bicycle.h5", "motion.h5"), ("maneuver_1", "maneuver_1/dense", "")),
        ("sensitivities.h5", "maneuver_1/rows"),
        ("candidate.h5", "maneuver_1"),
    ],
)
def test_a_column_that_nobody_proves_is_refused(copy, capsys, file, place):
    name = f"{place}/rider_courage_bound".strip("/")
    with h5py.File(copy / file, "r+") as f:
        f[name] = np.full(5, 1e-300)
        if file == "uncontrolled-bicycle.h5" and place:
            manifest(copy, content_sha256=content_sha256(f))
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    assert f"{file}: found {name}, which the proof does not cover" in error


@pytest.mark.proof
@pytest.mark.parametrize(
    ("file", "place"),
    [
        ("candidate.h5", "/"),
        ("candidate.h5", "maneuver_1/breaks"),
        ("motion.h5", "maneuver_1"),
        ("uncontrolled-bicycle.h5", "maneuver_1/dense/yaw"),
        ("sensitivities.h5", "maneuver_1/rows/time"),
    ],
)
def test_an_attribute_that_nobody_proves_is_refused(copy, capsys, file, place):
    with h5py.File(copy / file, "r+") as f:
        f[place].attrs["certified_by"] = "somebody"
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    path = f"{place}/certified_by".strip("/")
    assert f"{file}: found attribute {path}, which the proof does not cover" in error


@pytest.mark.proof
@pytest.mark.parametrize(
    "file", ["motion.h5", "sensitivities.h5", "uncontrolled-bicycle.h5", "candidate.h5"]
)
def test_a_file_about_another_bicycle_is_refused(copy, capsys, file):
    with h5py.File(copy / file, "r+") as f:
        parameters = json.loads(f.attrs["parameters"])
        f.attrs["parameters"] = json.dumps(parameters | {"g": "982/100"})
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    assert "the inputs in " in error


@pytest.mark.proof
@pytest.mark.parametrize("name", ["roll_angle_bound", "dense/pitch_bound"])
def test_a_bound_that_is_infinite_is_refused(copy, capsys, name):
    with h5py.File(copy / "uncontrolled-bicycle.h5", "r+") as f:
        f[f"maneuver_1/{name}"][-1] = np.inf
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    assert "published inf, proved " in error


@pytest.mark.proof
@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ('"bound": "', '"bound": "1e-999", "bound": "', "bound"),
        ('"trusted": [', '"trusted": [], "trusted": [', "trusted"),
        ('"g": "', r'"g": "10", "\u0067": "', "g"),
    ],
)
def test_a_key_that_is_there_twice_is_named(copy, capsys, old, new, key):
    file = copy / "certificate.json"
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    assert f"certificate.json: found the key {key!r} twice" in error


@pytest.mark.proof
@pytest.mark.parametrize("last", [np.inf, np.nan])
def test_a_last_break_that_is_no_time_is_said_in_one_line(copy, capsys, last):
    with h5py.File(copy / "candidate.h5", "r+") as f:
        f["maneuver_1/breaks"][-1] = last
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 1
    assert "candidate.h5: is not a candidate file" in error


@pytest.mark.proof
@pytest.mark.parametrize("name", ["more.h5", "README.md"])
def test_a_file_that_nobody_proves_is_refused(copy, capsys, name):
    """Only the published dataset has a card, which `verify` compares with the manifest."""
    (copy / name).write_bytes(b"anything")
    path = copy / MANIFEST
    document = json.loads(path.read_text())
    document["files"].append(document["files"][0] | {"file": name})
    path.write_text(json.dumps(document))
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    assert f"{name}: listed in the manifest, but the proof does not cover it" in error


def next_up(x):
    """Return the next number away from zero, by one unit in the last place."""
    return np.nextafter(x, np.copysign(np.inf, x))


@pytest.mark.proof
@pytest.mark.parametrize(
    ("name", "place", "change", "fragment"),
    [
        ("roll_angle", ..., lambda x: 1.5 * x, "derivatives of roll_angle, row 0, 0,"),
        ("steer_rate", (0, 3, 2), next_up, "derivatives of steer_rate, row 0, 3, 2:"),
        ("yaw_bound", (0, 5), lambda x: x * 0.99, "bound of the derivatives of yaw, row 0, 5:"),
        ("pitch_zyx", (0, 0, 1), lambda _: np.nan, "derivatives of pitch_zyx, row 0, 0, 1:"),
        ("rows/roll_rate", (1, 0), next_up, "rows of derivatives of roll_rate, row 1, 0:"),
        (
            "rows/steer_angle_bound", (1, 2), lambda x: x * 0.99,
            "bound of the rows of derivatives of steer_angle, row 1, 2:",
        ),
    ],
)  # fmt: skip
def test_derivatives_that_are_not_the_proved_ones_are_refused(
    copy, capsys, name, place, change, fragment
):
    with h5py.File(copy / "sensitivities.h5", "r+") as f:
        item = f[f"maneuver_1/{name}"]
        item[place] = change(item[place])
        f.attrs["content_sha256"] = content_sha256(f)
    accept(copy)
    code, error = certify(copy, capsys)
    assert code == 3
    assert fragment in error


# Tests of motion.h5, the motion of every body


def change_motion(folder, dataset, index, factor, *, hashed=True):
    with h5py.File(folder / "motion.h5", "r+") as f:
        item = f[f"maneuver_1/{dataset}"]
        item[index] = item[index] * factor
        if hashed:
            f.attrs["content_sha256"] = content_sha256(f)
    accept(folder)


def verify(folder, capsys):
    """Return exit code and output on standard error."""
    return main(["verify", str(folder)]), capsys.readouterr().err


@pytest.mark.proof
@pytest.mark.parametrize(
    ("dataset", "index", "factor", "fragment"),
    [
        ("front_normal_force", 1, 1 + 2.0**-52, "front_normal_force, row 1"),
        ("rear_contact_x_lo", 2, 1 + 2.0**-52, "rear_contact_x_lo, row 2"),
        ("front_wheel_angle_bound", 2, 0.5, "front_wheel_angle_bound, row 2"),
        ("dense/rear_lateral_force", (0, 3), 1 + 1e-10, "dense rear_lateral_force, piece 1"),
        ("dense/com_z_bound", 0, 1e-3, "dense com_z, piece 1"),
    ],
)
def test_certify_names_a_changed_number_of_the_motion(
    copy, capsys, dataset, index, factor, fragment
):
    change_motion(copy, dataset, index, factor)
    code, error = certify(copy, capsys)
    assert code == 3
    assert fragment in error


@pytest.mark.proof
@pytest.mark.parametrize(
    ("dataset", "index", "factor", "check"),
    [
        (
            "steer_joint_moment_x",
            1,
            1 + 2.0**-40,
            "motion_state: short 1: steer_joint_moment_x, row 1",
        ),
        ("rear_frame_q1", 2, 1 + 2.0**-40, "motion_identities"),
        ("time", 1, 1.5, "motion_state: short 1: the times are not multiples of the spacing"),
        ("dense/rear_wheel_angle_lo", (0, 1), 2.0, "rolling"),
        ("dense/com_x_lo", (0, 0), 2.0, "dense_rows"),
        ("front_friction_bound", 0, -1.0, "schema"),
    ],
)
def test_verify_names_a_changed_number_of_the_motion(copy, capsys, dataset, index, factor, check):
    change_motion(copy, dataset, index, factor)
    code, error = verify(copy, capsys)
    assert code == 3
    assert check in error


@pytest.mark.proof
def test_verify_compares_the_hash_of_the_motions_numbers(copy, capsys):
    change_motion(copy, "com_z", 1, 1 + 2.0**-40, hashed=False)
    code, error = verify(copy, capsys)
    assert code == 3
    assert "content_sha256" in error


@pytest.mark.proof
def test_a_set_without_a_motion_is_not_what_its_certificate_says(copy, capsys):
    (copy / "motion.h5").unlink()
    document = json.loads((copy / MANIFEST).read_text())
    manifest(copy, files=[x for x in document["files"] if x["file"] != "motion.h5"])
    assert verify(copy, capsys)[0] == 0
    code, error = certify(copy, capsys)
    assert code == 3
    assert "motion.h5: missing in the manifest" in error


@pytest.mark.slow
def test_the_whole_published_set(folder, capsys):
    assert main(["certify", str(folder)]) == 0
    assert capsys.readouterr().err == ""

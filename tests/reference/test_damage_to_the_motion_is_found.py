"""A number of motion.h5 that was changed, its hashes brought in line, and who notices."""

import shutil

import h5py
import pytest
from support.made_sets import accept

from heyoka_bike.cli import main
from heyoka_bike.reference.layout import content_sha256

pytestmark = [pytest.mark.proof, pytest.mark.usefixtures("keep_proofs")]


@pytest.fixture
def copy(small_set, tmp_path):
    return shutil.copytree(small_set, tmp_path / "copy")


def change(folder, dataset, index, factor, *, hashed=True):
    with h5py.File(folder / "motion.h5", "r+") as f:
        item = f[f"maneuver_1/{dataset}"]
        item[index] = item[index] * factor
        if hashed:
            f.attrs["content_sha256"] = content_sha256(f)
    accept(folder)


def run(capsys, *arguments):
    """Exit code and what was said on standard error."""
    code = main([str(x) for x in arguments])
    return code, capsys.readouterr().err


def certify(capsys, folder):
    return run(capsys, "certify", folder, "--workers", "1")


def test_the_whole_set_is_proved(copy, capsys):
    assert certify(capsys, copy) == (0, "")


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
def test_certify_names_a_changed_number(copy, capsys, dataset, index, factor, fragment):
    change(copy, dataset, index, factor)
    code, error = certify(capsys, copy)
    assert code == 3
    assert fragment in error


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
        ("time", 1, 1.5, "motion_state: short 1: its times"),
        ("dense/rear_wheel_angle_lo", (0, 1), 2.0, "rolling"),
        ("dense/com_x_lo", (0, 0), 2.0, "dense_rows"),
        ("front_friction_bound", 0, -1.0, "schema"),
    ],
)
def test_verify_names_a_changed_number(copy, capsys, dataset, index, factor, check):
    change(copy, dataset, index, factor)
    code, error = run(capsys, "verify", copy)
    assert code == 3
    assert check in error


def test_verify_compares_the_hash_of_the_numbers(copy, capsys):
    change(copy, "com_z", 1, 1 + 2.0**-40, hashed=False)
    code, error = run(capsys, "verify", copy)
    assert code == 3
    assert "content_sha256" in error


def test_a_set_without_a_motion_is_not_what_its_certificate_says(copy, capsys):
    import json

    (copy / "motion.h5").unlink()
    path = copy / "manifest.json"
    document = json.loads(path.read_text())
    document["files"] = [x for x in document["files"] if x["file"] != "motion.h5"]
    path.write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n")
    assert run(capsys, "verify", copy)[0] == 0
    code, error = run(capsys, "certify", copy)
    assert code == 3
    assert "motion.h5: not in the manifest" in error

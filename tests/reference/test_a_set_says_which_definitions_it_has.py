"""Older datasets load and score with the definitions they have, also in newer packages."""

import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest

from generators.made_sets import accept, accept_numbers, older
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS, COMPARED, FOLLOWING
from heyoka_bike.cli import main
from heyoka_bike.errors import DatasetError, InputError
from heyoka_bike.reference.load import load_reference
from heyoka_bike.reference.verification.verify import verify
from heyoka_bike.scoring.score import score

pytestmark = pytest.mark.proof

HDF5 = "uncontrolled-bicycle.h5"
VERSIONS = ("1.2.0", "1.3.0", "1.4.0", "1.5.0", "2.0.0")


@pytest.fixture
def kind(small_set, tmp_path):
    """A copy of the small dataset in the form of a version."""

    def make(version):
        folder = shutil.copytree(small_set, tmp_path / version)
        if version < "2.0.0":
            older(folder, version)
        return folder

    return make


def rows_of(reference, names=BENCHMARK_COLUMNS):
    m = reference[1]
    keys = [next(k for k in COMPARED if name == k or name.startswith(f"{k}_")) for name in names]
    return {"time": m.time, **{k: m.rows[n] for k, n in zip(keys, names, strict=True)}}


@pytest.mark.parametrize("version", VERSIONS)
def test_sets_of_every_kind_load_and_score(kind, version, capsys):
    reference = load_reference(kind(version))
    definitions = reference[1].definitions
    count = 22 if version < "1.3.0" else len(COLUMNS)
    known = [c for of in definitions.values() for c in of]
    follow = [c for c in known if c in FOLLOWING]
    assert len(reference[1].columns) == len(known) - len(follow) == count
    # Since version 1.3.0, a dataset contains the columns that determine these definitions.
    assert follow if version < "1.3.0" else len(follow) == len(FOLLOWING)
    # If the dataset contains definitions other than the default, they are recognised.
    names = ["roll_angle_zyx", "roll_rate_body_x", "forward_speed_com_norm", *BENCHMARK_COLUMNS[3:]]
    report = score(rows_of(reference, names), reference, maneuver=1)
    for c in report[1].columns:
        assert c.as_understood.measures.scd > 10
        asked = {a.definition for a in c.alternatives} | {c.as_understood.definition}
        assert asked == {d.definition for d in definitions[c.key]}
    assert report[1]["roll_angle"].as_understood.definition == "zyx"
    assert len(reference.sensitivities[1].coefficients) == count
    assert len(reference.motion[1].columns) == 78


def test_only_sets_from_1_3_0_on_know_a_definition_of_that_version(kind):
    name = "forward_speed_front_hub_norm"
    newer = load_reference(kind("1.3.0"))
    names = [name if key == "forward_speed" else key for key in BENCHMARK_COLUMNS]
    results = rows_of(newer, names)
    taken = score(results, newer, maneuver=1)[1]["forward_speed"]
    assert taken.as_understood.definition == "front_hub_norm"
    found = score(results, load_reference(kind("1.2.0")), maneuver=1)[1]["forward_speed"]
    assert found.as_understood.definition != "front_hub_norm"
    assert found.as_understood.measures.scd < taken.as_understood.measures.scd - 5


def test_a_column_that_an_older_set_has_at_its_rows_only(kind):
    reference = load_reference(kind("1.2.0"))
    m = reference.motion[1]
    assert np.isfinite(m.rows["rear_hub_x"]).all()
    with pytest.raises(
        InputError, match="rear_hub_x: this dataset contains the column at the rows only"
    ):
        m.evaluate("0.01", "rear_hub_x")
    assert set(m.evaluate("0.01")) == m.at_any_time
    # The friction demand follows from the forces, which have dense output.
    assert {"rear_friction", "com_x"} <= m.at_any_time
    whole = reference.with_motion()
    results = rows_of(whole, (*BENCHMARK_COLUMNS, "rear_hub_x", "com_x"))
    report = score(results, reference, require="rear_hub_x.scd > 3", maneuver=1)
    (finding,) = [f for f in report.findings if f.code == "columns_without_reference"]
    assert finding.evidence["columns"] == ["rear_hub_x"]
    assert finding.message.endswith("has no such columns")
    assert "com_x" in report[1]
    (requirement,) = report.requirements
    assert not requirement.met
    assert "no rear_hub_x in the reference" in requirement.message


@pytest.mark.parametrize("name", ["steer_rate", "roll_angle", "yaw", "pitch"])
def test_a_set_without_a_default_definition_is_refused_in_one_line(kind, name, capsys, tmp_path):
    folder = kind("1.5.0")
    with h5py.File(folder / HDF5, "r+") as f:
        for group in (f["maneuver_1"], f["maneuver_1/dense"]):
            for tag in ("", "_lo", "_bound"):
                del group[name + tag]
        accept_numbers(folder, f)
    accept(folder)
    with pytest.raises(DatasetError, match=f"no {name}, which is the default definition"):
        load_reference(folder)
    (tmp_path / "r.txt").write_text("0 0\n")
    assert main(["score", str(tmp_path / "r.txt"), "--reference", str(folder)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert f"{HDF5}: is not a reference file (" in line


@pytest.mark.parametrize("tag", ["", "_lo", "_bound"])
def test_a_definition_of_which_a_part_is_missing_is_damage(kind, tag):
    folder = kind("1.5.0")
    with h5py.File(folder / HDF5, "r+") as f:
        del f[f"maneuver_1/roll_angle_zyx{tag}"]
        accept_numbers(folder, f)
    accept(folder)
    with pytest.raises(DatasetError, match=f"no dataset /maneuver_1/roll_angle_zyx{tag}'"):
        load_reference(folder)


UNCHECKED = {
    "1.2.0": {
        HDF5: "attributes of version 1.5.0, columns that it lacks (16)",
        "motion.h5": "attributes of version 1.5.0, dense output that it lacks",
        "sensitivities.h5": "attributes of version 1.5.0, columns that it lacks (16), bounds and "
        "rows of derivatives",
        "candidate.h5": "attributes of version 1.5.0",
        "certificate.json": "its sentences",
    },
    "1.3.0": {
        **dict.fromkeys((HDF5, "motion.h5", "candidate.h5"), "attributes of version 1.5.0"),
        "sensitivities.h5": "attributes of version 1.5.0, bounds and rows of derivatives",
        "certificate.json": "its sentences",
    },
    "1.4.0": dict.fromkeys(
        (HDF5, "motion.h5", "sensitivities.h5", "candidate.h5"), "attributes of version 1.5.0"
    ),
    "1.5.0": {},
    "2.0.0": {},
}


@pytest.mark.parametrize("version", VERSIONS)
def test_an_older_set_is_verified_as_far_as_it_goes_and_the_rest_is_said(kind, version):
    checks = verify(kind(version)).checks
    assert {c.message for c in checks if not c.passed} == set()
    says = {c.file: c.message for c in checks if c.check == "schema"}
    marked = "not checked in this older dataset: "
    unchecked = {name: x.partition(marked)[2] for name, x in says.items()}
    assert {name: x for name, x in unchecked.items() if x} == UNCHECKED[version]
    counted = {(c.check, c.file): c.evidence["values"] for c in checks}
    count = 22 if version < "1.3.0" else len(COLUMNS)
    for check in ("columns", "rounding", "row_bounds", "dense_rows"):
        assert counted[check, HDF5] == 11 * count
    assert counted["motion_state", "motion.h5"] == 11 * 78
    # In versions before 1.3.0, only 23 columns had dense output. In later versions all columns have
    # it, except the two friction demands.
    assert counted["dense_rows", "motion.h5"] == 11 * (23 if version < "1.3.0" else 76)


@pytest.mark.parametrize(
    ("name", "place", "check"),
    [
        (HDF5, "maneuver_1/yaw_rate_lo", "rounding"),
        ("motion.h5", "maneuver_1/rear_normal_force_lo", "motion_state"),
        ("motion.h5", "maneuver_1/dense/com_x_lo", "dense_rows"),
        ("sensitivities.h5", "maneuver_1/yaw", "schema"),
    ],
)
def test_a_wrong_number_of_an_older_set_is_found(kind, name, place, check):
    folder = kind("1.2.0")
    with h5py.File(folder / name, "r+") as f:
        f[place][-1] += 1e-12
        if name == HDF5:
            accept_numbers(folder, f)
    accept(folder)
    assert (check, name) in {(c.check, c.file) for c in verify(folder).checks if not c.passed}


def test_another_attribute_of_an_older_set_is_found(kind):
    folder = kind("1.2.0")
    with h5py.File(folder / HDF5, "r+") as f:
        f["maneuver_1/yaw"].attrs["units"] = "deg"
    accept(folder)
    (failed,) = (c for c in verify(folder).checks if c.passed is False)
    assert "yaw: attribute units: found 'deg'" in failed.message


_NEWER = """
import sys
from dataclasses import replace
from heyoka_bike.bicycle import aliases, columns

# Pretend that this version has two additional definitions, and an additional quantity.
speed = columns.DEFINITIONS["forward_speed"][1]
angle = replace(columns.DEFINITIONS["roll_angle"][1], definition="new")
height = replace(columns.COLUMNS[3], key="height")
columns.COLUMNS += (replace(speed, definition="hubs_mean"), angle, height)
every = columns._KNOWN = (*columns.COLUMNS, *columns.FOLLOWING, *columns.MOTION_COLUMNS)
columns.COMPARED = columns.definitions_among({c.name for c in every})
columns.DEFINITIONS = {k: columns.COMPARED[k] for k in columns.BENCHMARK_COLUMNS}
aliases.KEYS_BY_WORD = {**aliases.KEYS_BY_WORD, "height": "height"}
assert len(columns.DEFINITIONS["roll_angle"]) == 4

from heyoka_bike.cli import main

sys.exit(main(sys.argv[1:]))
"""


def newer(*arguments):
    """Run a command of a package that knows more definitions than the dataset has."""
    return subprocess.run(
        [sys.executable, "-c", _NEWER, *map(str, arguments)],
        capture_output=True, text=True, timeout=300,
    )  # fmt: skip


def test_a_package_of_more_definitions_scores_against_todays_set(tmp_path):
    reference = load_reference()
    table = [reference.times, *(reference[n][key] for n in reference for key in BENCHMARK_COLUMNS)]
    path = tmp_path / "r.txt"
    np.savetxt(path, np.transpose(table), fmt="%.9g")
    done = newer("score", path, "--require", "roll_angle.scd > 6")
    assert (done.returncode, done.stderr) == (0, "")
    assert "hubs_mean" not in done.stdout
    # A column that the dataset does not have is left out, and this is reported.
    text = ",".join(["time", "roll_angle", "steer_angle", "height"])
    named = np.transpose([reference.times, *(reference[2][k] for k in BENCHMARK_COLUMNS[0:7:3])])
    np.savetxt(tmp_path / "n.csv", named, fmt="%.17g", delimiter=",", header=text, comments="")
    done = newer("score", tmp_path / "n.csv", "--maneuver", "2")
    assert "height: not compared, because the reference in" in done.stdout


def test_a_package_of_more_definitions_verifies_a_set_without_them(kind):
    done = newer("verify", kind("1.5.0"))
    assert (done.returncode, done.stderr) == (0, "")
    assert "columns that it lacks (3)" in " ".join(done.stdout.replace("│", " ").split())


def test_an_older_set_is_certified_by_its_own_version(kind, capsys):
    """The proof of the derivatives depends on all columns together."""
    assert main(["certify", str(kind("1.3.0"))]) == 3
    (line,) = capsys.readouterr().err.splitlines()
    assert (
        "certificate.json: its 'statement' differs from the proved value; to certify an older"
        in line
    )

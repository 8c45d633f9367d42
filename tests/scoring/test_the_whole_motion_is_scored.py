"""`score` compares configuration and forces by column name, like the eight columns of the
benchmark."""

import json
import shutil

import numpy as np
import pytest

from generators.made_results import codes, column
from generators.made_sets import make, manifest
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED
from heyoka_bike.cli import main
from heyoka_bike.numbers.double import two_sum
from heyoka_bike.reference.layout import MOTION
from heyoka_bike.reference.load import load_motion, load_reference
from heyoka_bike.reference.manifest import MANIFEST
from heyoka_bike.scoring.alignment import align
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.reading.names.heading import parse_heading
from heyoka_bike.scoring.reading.results import Quantum, Results, Rows
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.scoring.series import score_series

BEYOND = [key for key in COMPARED if key not in BENCHMARK_COLUMNS]
SIGNED = [key for key in BEYOND if not key.endswith("_friction")]


@pytest.fixture(scope="module")
def motion():
    return load_motion()


@pytest.fixture(scope="module")
def exact(reference, motion):
    """Every column at the published rows, by maneuver number."""
    return {
        n: {key: motion[n][key] if key in motion[n].columns else reference[n].rows[key]
            for key in COMPARED}
        for n in reference
    }  # fmt: skip


def results(reference, exact, change=lambda key, values: values, keys=COMPARED):
    maneuvers = tuple(
        Rows(n, reference[n].time, reference[n].time_lo,
             {key: change(key, exact[n][key]) for key in keys},
             quantum={key: Quantum(2, 53) for key in keys})
        for n in reference
    )  # fmt: skip
    return Results("made.txt", "text", maneuvers, 16)


@pytest.mark.parametrize("key", COMPARED)
def test_every_column_has_its_name(key):
    words = key.replace("_", " ").capitalize()
    for name, number in ((key, None), (f"{key}_2", 2), (f"m3_{key}", 3), (f"{words} [x]", None)):
        assert parse_heading(name).meaning == (key, number)


def test_digits_in_a_name_are_no_maneuver():
    assert parse_heading("rear_frame_q0").meaning == ("rear_frame_q0", None)
    assert parse_heading("front_frame_r32_1").meaning == ("front_frame_r32", 1)
    assert parse_heading("rear_frame_q4").meaning is None


def test_a_file_of_all_columns_scores_at_its_floor(reference, exact, tmp_path):
    path = tmp_path / "all.txt"
    names = [f"{key}_{n}" for n in reference for key in COMPARED]
    values = np.column_stack([exact[n][key] for n in reference for key in COMPARED])
    times = [f"{i / 100:.2f}" for i in range(len(values))]
    rows = (
        " ".join([t, *(f"{x:.17g}" for x in row)]) for t, row in zip(times, values, strict=True)
    )
    path.write_text("\n".join([" ".join(["time", *names]), *rows]) + "\n")
    report = score(read_results(path), reference)
    assert codes(report) == []
    for m in report.maneuvers:
        assert [c.key for c in m.columns] == list(COMPARED)
        for c in m.columns:
            assert c.values == len(values)
            assert c.missing == 0
            assert c.as_understood is c.as_written
            assert 0 < c.as_understood.measures.max_abs_error <= c.floor, c.key


def test_an_error_is_seen_in_its_column_alone(reference, exact):
    wrong = ("com_z", "front_axle_moment_x", "rear_friction")
    size = {key: 1e-7 * np.max(np.abs(exact[2][key])) for key in wrong}

    def change(key, values):
        return values + size[key] if key in wrong else values

    report = score(results(reference, exact, change, BEYOND), reference)
    for c in report.maneuvers[1].columns:
        found = c.as_understood.measures
        if c.key in wrong:
            assert found.max_abs_error == pytest.approx(size[c.key], rel=1e-6)
            assert found.scd == pytest.approx(7.0, abs=1e-3)
        else:
            assert found.scd > 15.5


def test_the_other_sign_is_recognised(reference, exact):
    report = score(results(reference, exact, lambda _, v: -v, SIGNED), reference)
    signs, other = (
        [f.evidence.get("column") for f in report.findings[1:] if (f.code == "sign") == is_sign]
        for is_sign in (True, False)
    )
    assert report.findings[0].code == "conventions"
    assert signs == SIGNED
    # The quaternion -q is the same rotation as q, but the matrix -R is not a rotation.
    assert other == [None, None]
    assert codes(report).count("signs_disagree") == 2
    assert all(c.is_at_floor() for m in report.maneuvers for c in m.columns)


def test_friction_has_no_sign(reference, exact):
    report = score(results(reference, exact, lambda _, v: -v, ["rear_friction"]), reference)
    assert codes(report) == []
    assert column(report, 1, "rear_friction").as_understood.measures.scd < 0


@pytest.mark.parametrize(
    ("key", "unit", "times"),
    [
        ("rear_hub_z", "mm", 1000), ("front_normal_force", "kN", 1e-3), ("com_x", "mm", 1000),
        ("rear_axle_moment_z", "N mm", 1000), ("steer_joint_force_x", "mN", 1000),
        ("front_wheel_angle", "degree", 180 / np.pi), ("yaw_rate", "degree s-1", 180 / np.pi),
    ],
)  # fmt: skip
def test_other_units_are_recognised(reference, exact, key, unit, times):
    report = score(results(reference, exact, lambda _, v: v * times, [key]), reference)
    assert codes(report) == ["conventions", "unit"]
    for m in report.maneuvers:
        assert m.columns[0].as_understood.unit == unit
        # The value is rounded twice: when it is written, and when it is multiplied by the unit.
        assert m.columns[0].is_at_floor(3)


def test_the_maneuver_is_recognised_by_forces(reference, exact):
    keys = ("rear_lateral_force", "front_lateral_force", "rear_frame_r31")
    for n in reference:
        rows = Rows(None, reference[n].time, reference[n].time_lo, {k: exact[n][k] for k in keys})
        assert [m.maneuver for m in score(Results("x", "text", (rows,)), reference).maneuvers] == [
            n
        ]


def test_dense_columns_are_compared_at_any_time(reference, motion):
    # The segments of motion.h5 end at different times from the segments of the eight benchmark
    # columns.
    assert set(motion[1].breaks) != set(reference[1].breaks)
    t = np.sort(np.random.default_rng(7).uniform(0, 10, 500))
    keys = ("roll_angle", "rear_normal_force", "com_y", "front_frame_q2")
    whole = reference.with_motion()
    for n in reference:
        own = reference[n].evaluate(t, ["roll_angle"]), motion[n].evaluate(t, keys[1:])
        values = {k: (own[k != "roll_angle"])[k] for k in keys}
        rows = Rows(n, t, np.zeros_like(t), values)
        (m,) = score(Results("x", "text", (rows,)), reference).maneuvers
        assert all(c.as_understood.measures.scd > 15.5 for c in m.columns)
        # For long files, faster routines replace the exact ones.
        many = whole[n].evaluate_many((t, np.zeros_like(t)), keys)
        near = whole[n].approximate(t, keys)
        for k in keys:
            scale = whole[n].scale(k)
            exact = two_sum(values[k], own[k != "roll_angle"].lo[k])
            assert np.max(np.abs((many[k] - exact[0]) + (many.lo[k] - exact[1]))) < 1e-27 * scale
            assert np.max(np.abs(near[k] - values[k])) < 1e-15 * scale


def test_other_columns_are_compared_at_any_time(reference, motion):
    t = np.sort(np.random.default_rng(8).uniform(0, 10, 200))
    keys = ["rear_hub_y", "front_friction", "rear_frame_r13"]
    values = dict(motion[3].evaluate(t, keys).hi)
    lost = np.arange(200) % 7 == 0
    values["rear_hub_y"] = np.where(lost, np.nan, values["rear_hub_y"])
    report = score(Results("x", "text", (Rows(3, t, np.zeros_like(t), values),)), reference)
    for key in keys:
        c = column(report, 3, key)
        assert c.missing == (lost.sum() if key == "rear_hub_y" else 0)
        assert c.values + c.missing == len(t)
        assert c.as_understood.measures.scd > 15.5


@pytest.mark.parametrize("late", ["summed", 9e-10])
def test_times_near_a_row_mean_it(reference, motion, late):
    # The expected matrix follows from the quaternion at the same times. The summed times are sums
    # of 100,000 steps in binary64.
    t = np.concatenate([[0.0], np.cumsum(np.full(100_000, 1e-4))[99::100]])
    if late != "summed":
        t = motion[2].time + np.where(motion[2].time < 10, late, 0.0)
    t = np.minimum(t, 10.0)
    assert 1e-12 < np.max(np.abs(t - motion[2].time)) < 1e-9
    q = motion[2].evaluate(t, [f"front_frame_q{i}" for i in range(4)])
    q0, q1, q2, q3 = (q[f"front_frame_q{i}"] for i in range(4))
    values = {
        "front_frame_r31": 2 * (q1 * q3 - q0 * q2),
        "front_frame_r12": 2 * (q1 * q2 - q0 * q3),
    }
    (m,) = score(Results("x", "text", (Rows(2, t, np.zeros_like(t), values),)), reference).maneuvers
    for c in m.columns:
        # The column results from a few operations in binary64, so its error is a few units of
        # roundoff.
        assert c.values == len(t)
        assert c.as_understood.measures.max_abs_error < 4 * np.finfo(float).eps


def test_requirements_name_these_columns(reference, exact):
    wrong = results(reference, exact, lambda key, v: v * (1 + 1e-5 * (key == "rear_frame_q1")))
    met = ["rear_normal_force.scd >= 15", "2.rear_frame_q1.scd >= 4.9", "front_friction.scd > 15"]
    assert score(wrong, reference, met).passed
    for text in ("scd >= 6", "rear_frame_q1.scd >= 6"):
        (said,) = score(wrong, reference, [text]).requirements
        assert not said.met
        assert "rear_frame_q1" in said.message


@pytest.fixture
def older(folder, tmp_path):
    """A copy of the dataset without motion.h5."""
    out = tmp_path / "older"
    shutil.copytree(folder, out)
    files = json.loads((out / MANIFEST).read_text())["files"]
    manifest(out, files=[f for f in files if f["file"] != MOTION])
    (out / MOTION).unlink()
    return out


def test_a_set_without_them_says_so(older, exact, reference, tmp_path, capsys):
    path = tmp_path / "results.csv"
    rows = [
        f"{i / 100},{exact[2]['roll_angle'][i]:.17g},{exact[2]['com_y'][i]:.17g}"
        for i in range(1001)
    ]
    path.write_text("\n".join(["time,roll_angle,com_y", *rows]))
    more = ["--reference", str(older), "--maneuver", "2", "--require", "com_y.scd > 1"]
    assert main(["score", str(path), *more]) == 3
    out = capsys.readouterr().out
    assert "no com_y in the reference" in out
    assert "com_y: not compared" in out
    assert f"has no {MOTION}" in out.replace("\n          ", " ")
    path.write_text("\n".join(["time,com_y", *(r.split(",")[0] + ",1" for r in rows)]))
    assert main(["score", str(path), "--reference", str(older), "--maneuver", "2"]) == 2
    assert "com_y: not compared" in capsys.readouterr().err


@pytest.mark.proof
def test_mistakes_are_simulated_for_the_eight_only(reference, exact):
    # In this file all columns are exact except one force.
    keys = (*BENCHMARK_COLUMNS, "rear_normal_force")

    def change(key, values):
        return values * 1.01 if key == "rear_normal_force" else values

    wrong = results(reference, exact, change, keys)
    report = diagnose(wrong, reference)
    assert [f.code for f in report.diagnosis] == ["column_beside", "nothing_to_explain"]
    assert report.diagnosis[0].evidence["factor"] == pytest.approx(1.01)
    assert "Every column" not in report.diagnosis[1].message
    assert column(report, 2, "rear_normal_force").as_understood.measures.scd < 2.1


@pytest.mark.parametrize("value", ["nan", "absent"])
def test_without_the_eight_nothing_is_diagnosed(exact, tmp_path, capsys, value):
    path = tmp_path / "forces.csv"
    more = {"nan": ",nan", "absent": ""}[value]
    rows = [f"{i / 100},{exact[2]['rear_normal_force'][i]:.17g}{more}" for i in range(1001)]
    head = "time,rear_normal_force" + (",roll_angle" if more else "")
    path.write_text("\n".join([head, *rows]))
    assert main(["diagnose", str(path), "--maneuver", "2"]) == 2
    assert "and the file has none" in capsys.readouterr().err
    # The command still prints the score, although there is nothing to diagnose.
    assert main(["score", str(path), "--maneuver", "2", "--diagnose"]) == 0
    shown = capsys.readouterr().out
    assert "The diagnosis needs values of the benchmark's columns" in shown
    assert "rear_normal_force" in shown


def test_eight_columns_need_no_motion(reference, exact):
    aligned = align(results(reference, exact, keys=BENCHMARK_COLUMNS), reference)
    assert all(part.reference is reference[part.number] for part in aligned.parts)


def test_one_is_the_unit_of_what_has_no_dimension():
    assert (
        parse_heading("rear_friction [1]").meaning
        == parse_heading("Rear friction(1)").meaning
        == ("rear_friction", None)
    )
    assert parse_heading("front_frame_q1 [ 1 ]").meaning == ("front_frame_q1", None)
    assert parse_heading("rear_friction_2 [1]").meaning == ("rear_friction", 2)
    assert parse_heading("roll_angle[1]").meaning == ("roll_angle", 1)


def test_numbers_in_brackets_are_maneuvers_where_they_differ(tmp_path, exact):
    path = tmp_path / "f.csv"
    for heads in (
        "rear_friction[1],rear_friction[2],rear_friction[3]",
        "rear_friction,rear_friction.1,rear_friction.2",
        "rear_friction_0,rear_friction_1,rear_friction_2",
    ):
        rows = [
            ",".join([f"{i / 100}", *(f"{exact[n]['rear_friction'][i]:.17g}" for n in exact)])
            for i in range(1001)
        ]
        path.write_text("\n".join([f"time,{heads}", *rows]))
        read = read_results(path)
        assert [r.maneuver for r in read.maneuvers] == [1, 2, 3]
        assert min(m.columns[0].as_understood.measures.scd for m in score(read).maneuvers) > 15


def test_a_name_beyond_the_eight_tells_that_names_count(tmp_path, exact):
    keys = list(exact[2])[10:17]
    path = tmp_path / "f.csv"
    rows = [
        ",".join([f"{i / 100}", *(f"{exact[2][k][i]:.17g}" for k in keys), "12.6"])
        for i in range(1001)
    ]
    path.write_text("\n".join([",".join(["time", *keys, "battery"]), *rows]))
    read = read_results(path)
    assert set(read.maneuvers[0].values) == set(keys)
    assert [f.code for f in read.findings] == ["columns_left_out"]


@pytest.mark.parametrize("key", ["rear_axle_force_z", "front_friction"])
@pytest.mark.parametrize("wrong", [-99.0, 1e6])
def test_a_wrong_value_between_the_rows_is_seen(reference, motion, key, wrong):
    """All rows are exact except one wrong value, whose time lies between the published rows."""
    t, values = motion[2].time.copy(), motion[2][key].copy()
    t[999], values[999] = 9.995, wrong
    rows = Rows(2, t, np.zeros_like(t), {key: values})
    report = score(Results("x", "text", (rows,)), reference, [
        "scd >= 6", "coverage >= 0.9", "columns >= 0",
    ])  # fmt: skip
    assert [r.met for r in report.requirements] == [False, True, True]
    assert column(report, 2, key).as_understood.measures.max_abs_error > abs(wrong) / 2


def test_a_normal_force_turned_round_against_the_other_fails(reference, motion):
    keys = ("rear_normal_force", "front_normal_force")
    for signs, met in (((1, 1), True), ((-1, -1), True), ((-1, 1), False), ((1, -1), False)):
        values = {k: s * motion[2][k] for k, s in zip(keys, signs, strict=True)}
        rows = Rows(2, motion[2].time, motion[2].time_lo, values)
        report = score(Results("x", "text", (rows,)), reference, ["scd >= 6", "columns >= 0"])
        assert [r.met for r in report.requirements] == [met, True]


def test_maneuvers_are_told_apart_by_what_hardly_varies(reference, exact):
    def scored(told, n):
        values = {"rear_normal_force": exact[n]["rear_normal_force"]}
        rows = Rows(told, reference[n].time, reference[n].time_lo, values)
        return score(Results("x", "text", (rows,)), reference)

    for n in reference:
        assert scored(None, n).maneuvers[0].maneuver == n
    for n in (1, 2):
        # The rows of maneuver n are labelled as maneuver 3. That maneuver is nearly at rest, so a
        # difference of 1 % of the force is large there.
        (said,) = [f for f in scored(3, n).findings if f.code == "another_maneuver"]
        assert said.evidence["nearest"] == n


@pytest.mark.parametrize(
    ("key", "value"), [("com_z", 613.0), ("rear_hub_z", 200.0), ("front_frame_r33", -0.8)]
)
def test_no_sign_or_unit_is_claimed_of_a_wrong_constant(reference, key, value):
    t = reference[2].time
    rows = Rows(2, t, reference[2].time_lo, {key: np.full(len(t), value)})
    taken = column(score(Results("x", "text", (rows,)), reference), 2, key).as_understood
    assert (taken.sign, taken.unit) == (1, COMPARED[key][0].unit)


@pytest.mark.proof
def test_a_set_of_two_rows_is_enough(reference, tmp_path):
    out = make(tmp_path, ("0.02", "0.02"))
    x = load_motion(out)[1]["rear_hub_x"]
    path = tmp_path / "two.csv"
    path.write_text(
        f"time,rear_hub_x\n0,{x[0]!r}\n0.02,{float(x[1])!r}\n".replace("np.float64", "")
    )
    report = score(read_results(path, maneuver=1, count=1), load_reference(out))
    assert column(report, 1, "rear_hub_x").as_understood.measures.scd > 15


def test_files_without_a_common_column_are_no_series(reference, exact):
    files = [results(reference, exact, keys=[key]) for key in ("com_x", "roll_angle")]
    assert "no_shared_columns" in [f.code for f in score_series(files, reference).findings]


@pytest.mark.parametrize("q0", [1, -1])
@pytest.mark.parametrize("d", [(1, 1, 1), (1, -1, -1), (-1, -1, 1), (1, -1, 1), (-1, -1, -1)])
def test_an_attitude_in_other_axes_is_one(reference, exact, d, q0):
    # The vector part of a quaternion is a pseudovector, and -q is the same rotation as q.
    signs = {f"rear_frame_q{i}": q0 * int(np.prod(d)) * d[i - 1] for i in (1, 2, 3)}
    signs |= {f"rear_frame_r{i}{j}": d[i - 1] * d[j - 1] for i in (1, 2, 3) for j in (1, 2, 3)}
    signs |= {"rear_frame_q0": q0}
    turned = results(reference, exact, lambda key, v: v * signs[key], list(signs))
    assert set(codes(score(turned, reference))) <= {"conventions", "sign"}


def test_an_inverse_attitude_is_told(reference, exact):
    quaternion = [f"rear_frame_q{i}" for i in range(4)]
    matrix = [f"front_frame_r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]

    def inverse(key, values):
        return values if key == "rear_frame_q0" else -values

    inverted = results(reference, exact, inverse, [*quaternion, *matrix])
    report = score(inverted, reference, ["max_abs_error < 100"])
    said = [f.evidence["columns"] for f in report.findings if f.code == "signs_disagree"]
    assert said == [quaternion, matrix]
    assert not report.passed

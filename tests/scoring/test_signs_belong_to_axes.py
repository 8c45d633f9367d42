"""Any axes and senses of a program give signs that agree; a single flipped column does not."""

import numpy as np
import pytest

from games.files import MOTION
from games.honest_files import signs
from generators.made_results import exact_columns, made, rows
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, LATERAL
from heyoka_bike.scoring.evidence.column_meaning import (
    Conventions,
    SignContradiction,
    default_conventions,
)
from heyoka_bike.scoring.findings import Severity
from heyoka_bike.scoring.judge.signs import CHOICES, contradictions, opposed
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.score import score
from heyoka_bike.showing.formats.output import render
from heyoka_bike.showing.formats.summary import diagnosis

BEYOND = ("pitch", "yaw", "yaw_rate")
KEYS = ["roll_angle", "roll_rate", "forward_speed", "steer_angle", "steer_rate", *BEYOND, *MOTION]
# Columns whose sign does not depend on the sign of any other column
FREE = ("forward_speed", "pitch", "steer_joint_force_z")
UNSIGNED = ("rear_friction", "front_friction")


@pytest.mark.parametrize("number", range(40))
def test_axes_turned_as_vectors_and_turns_are_agree(number):
    random = np.random.default_rng(number)
    # Cases with an odd number contain quaternions. Cases with an even number contain axes of the
    # frames, and no quaternions.
    keys = KEYS if number % 2 else [k for k in KEYS if "_frame_q" not in k]
    assert contradictions(signs(random, keys)) == []


def test_a_column_turned_round_alone_contradicts_the_others():
    agreeing = dict.fromkeys(KEYS, 1)
    told = {key: contradictions({**agreeing, key: -1}) for key in KEYS}
    # The common sign of the components of a quaternion is free. The sign of q0 depends on how many
    # of the other components are flipped.
    assert [key for key, found in told.items() if not found] == [k for k in KEYS if k in FREE]
    assert all(any(key in c for c in found) for key, found in told.items() if found)


def test_only_those_that_are_tied_are_named():
    agreeing = dict.fromkeys(KEYS, 1)
    assert contradictions({**agreeing, "roll_rate": -1}) == [("roll_angle", "roll_rate")]
    pair = ("rear_normal_force", "front_normal_force")
    assert contradictions({**agreeing, pair[1]: -1}) == [pair]
    assert contradictions({"rear_hub_x": 1, "com_z": -1}) == []


@pytest.mark.parametrize("turned", [(1,), (2,), (3,), (1, 2, 3)])
def test_a_reflection_is_no_rotation(turned):
    """Flip an odd number of columns of the matrix. If two are flipped, it is a choice of the
    frame's axes."""
    matrix = [f"rear_frame_r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]
    reflected = {key: -1 if int(key[-1]) in turned else 1 for key in matrix}
    assert contradictions(reflected) == [tuple(matrix)]
    two = {key: -1 if key[-1] in "12" else 1 for key in matrix}
    assert contradictions(two) == []


def test_every_column_with_a_sign_is_known():
    assert set(KEYS) - set(UNSIGNED) == set(CHOICES)
    assert contradictions({"rear_friction": -1}) == [("rear_friction",)]


@pytest.mark.parametrize("forward", [1, -1])
@pytest.mark.parametrize("down", [1, -1])
def test_roll_alone_turned_round_needs_axes_backward_and_down(forward, down):
    """Lean and steer are right-handed rotations about axes with these directions."""
    told = {"roll_angle": forward, "roll_rate": forward, "steer_angle": down, "steer_rate": down}
    assert bool(opposed(told)) == ((forward, down) == (-1, 1))


def turned(*keys):
    return lambda key, values, number: -values if key in keys else values


def test_roll_alone_turned_round_is_warned_of_and_judged_as_before(reference):
    report = score(made(reference, turned("roll_angle", "roll_rate")), reference)
    (found,) = (f for f in report.findings if f.severity == Severity.WARNING)
    assert found.code == "senses_opposed"
    assert "see the warning" in report.verdict
    assert not any(f.code == "conventions" for f in report.findings)
    right = score(made(reference), reference)
    assert report.worst.scd == right.worst.scd
    assert score(made(reference, turned("roll_angle", "roll_rate")), reference, "scd >= 6").passed
    for text in ("summary", "html", "table"):
        assert "positive to the left, but steer to the right" in render(report, text)


@pytest.mark.parametrize("keys", [("steer_angle", "steer_rate"), LATERAL, ()])
def test_usual_axes_are_not_warned_of(reference, keys):
    report = score(made(reference, turned(*keys)), reference)
    assert not [f for f in report.findings if f.severity == Severity.WARNING]
    assert "senses" not in report.verdict


def test_signs_that_contradict_are_in_the_verdict(reference):
    report = score(made(reference, turned("roll_rate")), reference)
    assert "contradict each other; apart from the signs, " in report.verdict


def test_conventions_name_only_columns_of_the_file():
    assert default_conventions(BENCHMARK_COLUMNS) == (
        "Conventions: SI units, roll and steer positive to the right, potential energy zero on the "
        "floor"
    )
    only = default_conventions(["steer_angle"])
    assert only == "Conventions: SI units, steer positive to the right"


@pytest.mark.parametrize(("keys", "has_others"), [(["steer_angle"], False), (LATERAL, True)])
def test_nothing_else_is_said_of_a_single_column(reference, keys, has_others):
    table = {"time": reference[1].time} | {f"{key}_1": -reference[1][key] for key in keys}
    (found,) = (f for f in score(table, reference).findings if f.code == "conventions")
    assert ("Everything else" in found.message) is has_others


def test_a_diagnosis_does_not_say_that_signs_are_as_by_default(reference):
    report = score(made(reference, turned("roll_angle", "roll_rate")), reference)
    said = diagnosis(report)
    assert default_conventions(report.by_column()) not in " ".join(said.split())
    assert "has a sign error" in " ".join(said.split())


def wrong_motion(reference, *flipped, every=4, change=lambda x: x):
    """Return a motion that is soon wrong, with angles whose slopes are their rates."""
    parts = []
    for n, m in reference.items():
        columns = exact_columns(m)
        slow, slope = np.cos(1.5 * m.time), -1.5 * np.sin(1.5 * m.time)
        for angle, rate in (LATERAL[:2], LATERAL[2:]):
            columns[rate] = slow * columns[rate] + slope * columns[angle]
            columns[angle] = slow * columns[angle]
        columns |= {key: -columns[key] for key in flipped}
        kept = slice(None, None, every)
        parts.append(rows(reference, n, {k: change(x) for k, x in columns.items()}, keep=kept))
    return Results("wrong.txt", "text", tuple(parts), 16)


def contradicted(results, reference):
    seen = score(results, reference).seen
    turned = [key for x in seen if isinstance(x, Conventions) for key in x.turned]
    return [x.keys for x in seen if isinstance(x, SignContradiction)], turned


@pytest.mark.parametrize("key", LATERAL)
def test_a_wrong_motion_shows_the_sign_of_a_rate_by_the_slope_of_its_angle(key, reference):
    pair = LATERAL[:2] if key in LATERAL[:2] else LATERAL[2:]
    assert contradicted(wrong_motion(reference, key), reference) == ([pair], [])


def test_a_wrong_motion_with_both_rates_flipped_contradicts_both_angles(reference):
    flipped = wrong_motion(reference, "roll_rate", "steer_rate")
    assert contradicted(flipped, reference) == ([LATERAL[:2], LATERAL[2:]], [])


@pytest.mark.parametrize("flipped", [(), LATERAL[:2], LATERAL[2:], LATERAL])
def test_angles_of_a_wrong_motion_that_turn_with_their_rates_contradict_nothing(flipped, reference):
    assert not contradicted(wrong_motion(reference, *flipped), reference)[0]


def test_neither_rows_far_apart_nor_reversed_rows_show_a_sign(reference):
    far = wrong_motion(reference, "steer_rate", every=200)
    assert not contradicted(far, reference)[0]
    assert not contradicted(wrong_motion(reference, change=lambda x: x[::-1]), reference)[0]
    kept = wrong_motion(reference, change=lambda x: np.r_[x[:1], x[:0:-1]])
    assert not contradicted(kept, reference)[0]


def test_the_roll_angle_of_a_bicycle_that_has_fallen_shows_no_sign(reference):
    """It turns back at 90 degrees, although its rate continues."""
    fallen = wrong_motion(reference)
    for part in fallen.maneuvers:
        x = part.values["roll_angle"]
        limit = np.max(np.abs(x)) / 5.0
        part.values["roll_angle"] = np.where(np.abs(x) > limit, 2.0 * np.sign(x) * limit - x, x)
    assert not contradicted(fallen, reference)[0]

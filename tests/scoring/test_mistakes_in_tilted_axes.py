"""Inertias and lengths that are wrongly taken along the steer axis are rotations of the bodies."""

import numpy as np
import pytest

pytest.importorskip("heyoka")

from scipy.spatial.transform import Rotation

from generators.mistaken_programs import correct
from heyoka_bike.scoring.diagnosis.mistakes.in_axes import AXES_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.library import apply

BY_CODE = {m.code: m for m in AXES_MISTAKES}


def parameters(reference, *codes):
    program = apply(correct(reference), [BY_CODE[code] for code in codes])
    return {s: float(x) for s, x in program.motion.bicycle.values.items()}


def tensor(p, body):
    xx, yy, zz, xz = (p[f"I{body}{ij}"] for ij in ("xx", "yy", "zz", "xz"))
    return np.array([[xx, 0.0, xz], [0.0, yy, 0.0], [xz, 0.0, zz]])


def axes(tilt):
    """Rotation matrix whose columns are the tilted axes in global coordinates; z is the steer
    axis."""
    made = Rotation.from_rotvec([0.0, tilt, 0.0]).as_matrix()
    assert made[:, 2] == pytest.approx([np.sin(tilt), 0.0, np.cos(tilt)])
    return made


def test_table_1_in_steer_axes_is_this_global_tensor(reference):
    """These are the numbers with which SymBRiM computes if Table 1 is not converted."""
    p = parameters(reference, "inertia_H_rotated")
    found = p["IHxx"], p["IHxz"], p["IHzz"]
    assert found == pytest.approx((0.049526, -0.021352, 0.016474), abs=5e-7)


@pytest.mark.parametrize("bodies", ["B", "H", "BH"])
@pytest.mark.parametrize(
    ("code", "given"),
    [
        # For each mistake: its code, and the tensor that the program uses, as a function of the
        # correct tensor and the rotation.
        ("inertia_{}_rotated", lambda i, r: i),
        ("inertia_{}_rotated_wrong_way", lambda i, r: r @ i @ r.T),
        ("sign_I{}xz_along_steer", lambda i, r: np.array([[1, 1, -1]] * 2 + [[-1, 1, 1]])
         * (r.T @ i @ r)),
    ],
)  # fmt: skip
def test_inertia_is_what_was_given_in_tilted_axes(reference, bodies, code, given):
    known, p = parameters(reference), parameters(reference, code.format(bodies))
    r = axes(known["lam"])
    for body in "BH":
        expected = tensor(known, body)
        if body in bodies:
            expected = r @ given(expected, r) @ r.T
        # The tolerance is the rounding error of a tensor of 10 kg m^2.
        assert tensor(p, body) == pytest.approx(expected, abs=1e-14)


def test_inertia_turned_for_a_program_that_takes_global_axes(reference):
    known, p = parameters(reference), parameters(reference, "inertia_H_rotated_back")
    r = axes(known["lam"])
    assert tensor(p, "H") == pytest.approx(r.T @ tensor(known, "H") @ r, abs=1e-14)


def test_inertia_turned_by_the_head_angle(reference):
    known, p = parameters(reference), parameters(reference, "inertia_B_rotated_by_head_angle")
    head, tilted = axes(np.pi / 2 - known["lam"]), axes(known["lam"])
    expected = tilted @ head.T @ tensor(known, "B") @ head @ tilted.T
    assert tensor(p, "B") == pytest.approx(expected, abs=1e-13)


def places(p):
    """Positions (x, z) of hubs, centres of mass and a point of the steer axis, from the rear
    contact."""
    return {
        "R": np.array([0.0, -p["rR"]]),
        "F": np.array([p["w"], -p["rF"]]),
        "B": np.array([p["xB"], p["zB"]]),
        "H": np.array([p["xH"], p["zH"]]),
        "axis": np.array([p["w"] + p["c"], 0.0]),
    }


def across(p, point):
    """Distance of a hub from the steer axis, positive behind it."""
    along = np.array([np.sin(p["lam"]), np.cos(p["lam"])])
    x, z = places(p)["axis"] - places(p)[point]
    return x * along[1] - z * along[0]


@pytest.mark.parametrize(
    ("code", "rear", "front"),
    [
        ("offset_d1_by_front_radius", lambda p: p["rF"], lambda p: p["rF"]),
        ("offset_d3_by_rear_radius", lambda p: p["rR"], lambda p: p["rR"]),
    ],
)
def test_offsets_are_those_of_the_other_radius(reference, code, rear, front):
    known, p = parameters(reference), parameters(reference, code)
    s, c = np.sin(known["lam"]), np.cos(known["lam"])
    assert across(known, "R") == pytest.approx(c * (known["w"] + known["c"]) - s * known["rR"])
    assert across(p, "R") == pytest.approx(c * (known["w"] + known["c"]) - s * rear(known))
    assert across(p, "F") == pytest.approx(c * known["c"] - s * front(known))
    # Both the rear frame and the fork with the front hub keep their shape and are only pitched.
    pitch = p["lam"] - known["lam"]
    turn = axes(pitch)[np.ix_([0, 2], [0, 2])]
    for body, hub in (("B", "R"), ("H", "F")):
        before, after = (places(x)[body] - places(x)[hub] for x in (known, p))
        assert after == pytest.approx(turn @ before)
        r = axes(pitch)
        assert tensor(p, body) == pytest.approx(r @ tensor(known, body) @ r.T)


def test_a_fork_without_offset_has_its_axis_through_the_hub(reference):
    known = parameters(reference)
    assert across(parameters(reference, "no_offset"), "F") == pytest.approx(0.0, abs=1e-14)
    behind = across(parameters(reference, "offset_sign"), "F")
    assert behind == pytest.approx(-across(known, "F"))


def test_centres_of_mass_that_are_not_turned(reference):
    known, p = parameters(reference), parameters(reference, "centres_not_tilted")
    turn = axes(known["lam"])[np.ix_([0, 2], [0, 2])]
    for body, hub in (("B", "R"), ("H", "F")):
        before, after = (places(x)[body] - places(x)[hub] for x in (known, p))
        assert after == pytest.approx(turn @ before)

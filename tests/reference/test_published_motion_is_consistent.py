"""motion.h5 obeys mechanics, agrees with the replay, and reads back as published."""

from __future__ import annotations

import random
from fractions import Fraction
from pathlib import Path

import flint
import mpmath
import numpy as np
import pytest

from heyoka_bike.bicycle.columns import FOLLOWING
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.motion_columns import DENSE_COLUMNS, MOTION_COLUMNS
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.errors import DatasetError, InputError
from heyoka_bike.numbers.double import root
from heyoka_bike.reference.load import Motion, Reference, ReferenceManeuver, load_motion
from heyoka_bike.workbench.replay.motion_3d import motion_3d, reference_state
from support.without_packages import HEAVY, python

BITS = 256


@pytest.fixture(scope="module")
def motion() -> Motion:
    return load_motion()


@pytest.fixture(scope="module", params=[1, 2, 3])
def maneuver(request: pytest.FixtureRequest, motion: Motion) -> ReferenceManeuver:
    return motion[request.param]


def polynomial(m: ReferenceManeuver, name: str, piece: int) -> flint.arb_poly:
    """Return a dense segment in powers of its argument."""
    x = flint.arb_poly([0, 1])
    t = [flint.arb_poly([1]), x]
    hi, lo = m.dense.hi[name][piece], m.dense.lo[name][piece]
    while len(t) < len(hi):
        t.append(2 * x * t[-1] - t[-2])
    terms = zip(hi, lo, t, strict=True)
    return sum(((flint.arb(float(a)) + float(b)) * p for a, b, p in terms), flint.arb_poly([]))


def test_the_floor_carries_weight_and_acceleration(
    maneuver: ReferenceManeuver, bicycle: Bicycle
) -> None:
    """The contact forces are the mass times the second derivative of the published centre."""
    p = {symbol: x.rational for symbol, x in bicycle.values.items()}
    mass, weight = (float(sum(p[f"m{b}"] for b in "RBHF") * x) for x in (1, p["g"]))
    rng = random.Random(maneuver.name)
    with flint.ctx.workprec(BITS):
        for _ in range(40):
            piece = rng.randrange(len(maneuver.breaks) - 1)
            u, h = flint.arb(rng.uniform(-1, 1)), np.diff(maneuver.breaks)[piece]
            found = {n: polynomial(maneuver, n, piece)(u) for n in DENSE_COLUMNS}
            acceleration = [
                polynomial(maneuver, f"com_{x}", piece).derivative().derivative()(u) * 4 / h**2
                for x in "xyz"
            ]
            floor = [flint.arb(0)] * 3
            for end in ("rear", "front"):
                # The axle is the second column of the quaternion's rotation matrix, and the heading
                # is perpendicular to the axle.
                a, b, c, d = (found[f"{end}_frame_q{i}"] for i in range(4))
                axle = 2 * (b * c - a * d), a * a - b * b + c * c - d * d
                size = (axle[0] * axle[0] + axle[1] * axle[1]).sqrt()
                right = axle[0] / size, axle[1] / size
                ahead = right[1], -right[0]
                along, across = (found[f"{end}_{x}_force"] for x in ("longitudinal", "lateral"))
                floor[0] += along * ahead[0] + across * right[0]
                floor[1] += along * ahead[1] + across * right[1]
                floor[2] -= found[f"{end}_normal_force"]
            floor[2] += weight
            for force, x in zip(floor, acceleration, strict=True):
                # Positions of up to 100 m have an error of 1e-27 of this size in dense output. Two
                # derivatives on segments of at least 1/16 s amplify this error by 1e6 and by 4 /
                # h^2 = 1e3.
                assert abs(force - mass * x) < flint.arb("1e-13")


def test_the_wheels_never_leave_the_floor(maneuver: ReferenceManeuver) -> None:
    """The normal forces are positive at all times, and their extremes are those of the rows."""
    with flint.ctx.workprec(BITS):
        for end in ("rear", "front"):
            name = f"{end}_normal_force"
            least = maneuver[name].min()
            for piece in range(len(maneuver.breaks) - 1):
                p = polynomial(maneuver, name, piece)
                for j in range(64):
                    span = p(flint.arb((2 * j + 1) / 64 - 1, 1 / 64))
                    assert span > 0.99 * least - maneuver.dense.bound[name][piece]
            assert least > 290.0


@pytest.mark.parametrize(("number", "needed"), [(1, "0.2251"), (2, "0.1427"), (3, "0.0127")])
def test_friction_that_the_maneuvers_need(motion: Motion, number: int, needed: str) -> None:
    """The values are those of docs/motion.md, rounded up."""
    worst = max(motion[number][f"{end}_friction"].max() for end in ("rear", "front"))
    assert float(needed) - 1e-4 < worst < float(needed)


def test_the_replay_agrees(
    maneuver: ReferenceManeuver, reference: Reference, bicycle: Bicycle
) -> None:
    number = int(maneuver.name.split()[-1])
    found = motion_3d(
        Equations.binary64(bicycle), reference_state(reference[number]), maneuver.time
    )
    for name in ("rear_contact", "front_contact"):
        for i, axis in enumerate("xy"):
            off = getattr(found, name)[:, i] - maneuver[f"{name}_{axis}"]
            # The roundoff of binary64 adds up over about 1000 steps, at positions of up to 80 m.
            assert np.abs(off).max() < 1e-12, name
    for name in ("rear_wheel", "front_wheel"):
        assert np.abs(getattr(found, name) - maneuver[f"{name}_angle"]).max() < 1e-11


def test_rows_and_bounds_are_what_they_should_be(maneuver: ReferenceManeuver) -> None:
    for column in MOTION_COLUMNS:
        hi, lo = maneuver[column.name], maneuver.rows.lo[column.name]
        bound = maneuver.rows.bound[column.name]
        assert hi.shape == lo.shape == bound.shape == (1001,)
        assert (np.abs(lo) <= np.spacing(np.abs(hi)) / 2).all()
        # The bound is half an ulp of lo, rounded up by 1/128. An enclosure of zero is narrower than
        # 1e-55.
        assert (bound <= np.abs(lo) * 2.0**-53 * 1.01 + 1e-55).all(), column.name
        # Only the start contains short numbers, for which lo is zero.
        assert (lo[1:] != 0).all()
    for name in DENSE_COLUMNS:
        assert (maneuver.dense.bound[name] <= 1e-25 * maneuver.scale(name)).all(), name


def test_dense_output_is_that_of_the_rows(maneuver: ReferenceManeuver) -> None:
    times = [Fraction(i, 100) for i in (0, 1, 333, 1000)]
    found = maneuver.evaluate(times)
    assert tuple(found.hi) == tuple(c.name for c in MOTION_COLUMNS)
    for name in found.hi:
        exact = maneuver[name][[0, 1, 333, 1000]]
        assert np.abs(found[name] - exact).max() <= 1e-15 * maneuver.scale(name)
    alone = maneuver.evaluate("3.33", "com_z")
    assert alone["com_z"] == found["com_z"][2]


def test_friction_demands_follow_from_the_forces(maneuver: ReferenceManeuver) -> None:
    # At the rows, compare with the published values to the digits of hi + lo. At other times,
    # compare with values of mpmath.
    times = [Fraction(i, 100) for i in range(0, 1001, 37)]
    names = ["rear_friction", "front_friction"]
    found = maneuver.evaluate(times, names)
    for name in names:
        hi, lo = (part[name][::37] for part in (maneuver.rows.hi, maneuver.rows.lo))
        assert np.abs((found[name] - hi) + (found.lo[name] - lo)).max() < 1e-25
    parts = ("normal", "longitudinal", "lateral")
    forces = maneuver.evaluate("3.3333", [f"front_{part}_force" for part in parts])
    with mpmath.workdps(40):
        normal, ahead, aside = (
            mpmath.mpf(float(forces.hi[name])) + float(forces.lo[name]) for name in forces.hi
        )
        found = maneuver.evaluate("3.3333", "front_friction")
        demand = mpmath.mpf(float(found["front_friction"])) + float(found.lo["front_friction"])
        assert abs(demand - mpmath.hypot(ahead, aside) / normal) < 1e-31


def test_a_root_is_that_of_the_sum_of_hi_and_lo() -> None:
    zero, one = np.zeros(3), np.ones(3)
    hi, lo = root((zero, zero))
    assert not hi.any()
    assert not lo.any()
    hi, lo = root((2 * one, zero))
    with mpmath.workdps(40):
        assert abs(mpmath.mpf(float(hi[0])) + float(lo[0]) - mpmath.sqrt(2)) < 1e-31


def test_an_unknown_column_is_refused(maneuver: ReferenceManeuver) -> None:
    with pytest.raises(InputError, match="found column 'speed'"):
        maneuver.evaluate(1.0, ["speed"])
    with pytest.raises(KeyError, match="found column 'speed'"):
        maneuver["speed"]


def test_a_reference_has_the_motion_of_its_set(reference: Reference) -> None:
    assert reference.motion is reference.motion
    assert reference.motion.folder == reference.folder
    height = reference.motion[2].evaluate("0.5", "com_z")
    assert height["com_z"] == load_motion()[2].evaluate("0.5")["com_z"]
    # Evaluating other columns does not change the columns of the reference itself.
    columns = reference[2].columns
    assert len(columns) == 38
    assert list(reference[2].evaluate(0.5).hi) == [*columns, *(c.name for c in FOLLOWING)]


def test_maneuvers_are_numbered_from_one(motion: Motion) -> None:
    assert list(motion) == [1, 2, 3]
    with pytest.raises(KeyError, match="expected 1 to 3"):
        motion[0]


def test_a_folder_without_a_motion_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DatasetError):
        load_motion(tmp_path)


def test_a_netcdf_reader_opens_it(folder: Path) -> None:
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(folder / "motion.h5", group="maneuver_2", engine="h5netcdf") as data:
        assert data["rear_normal_force"].attrs["units"] == "N"
        assert data["rear_normal_force"].dims == ("time",)
        assert float(data["rear_normal_force"][0]) == pytest.approx(599.6905, abs=1e-12)


def test_reading_needs_numpy_and_h5py_only() -> None:
    code = "from heyoka_bike import load_motion; print(load_motion()[2].evaluate('0.5')['com_z'])"
    run = python(code, HEAVY)
    assert run.returncode == 0, run.stderr
    assert -0.9 < float(run.stdout) < -0.8

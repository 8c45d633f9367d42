"""The statements of docs/benchmark.md on the problem's text are true."""

from fractions import Fraction

import numpy as np
import pytest
from mpmath import mp, mpf

from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.motion.trajectory import evaluator
from heyoka_bike.reference.proof.candidate import read_candidate
from heyoka_bike.reference.proof.instants import of_known
from heyoka_bike.system.resources import reference_folder


@pytest.mark.parametrize(
    ("body", "tangent", "inertia"),
    [
        ("B", Fraction(1, 3), Fraction(10)), ("B", Fraction(-3), Fraction(2)),
        ("H", Fraction(-1, 7), Fraction("0.06")), ("H", Fraction(7), Fraction("0.006")),
    ],
)  # fmt: skip
def test_principal_inertias_have_rational_tangents(bicycle, body, tangent, inertia):
    xx, zz, xz = (bicycle[f"I{body}{ij}"].rational for ij in ("xx", "zz", "xz"))
    # Product of the inertia matrix with the vector (1, tangent) in the plane of x and z.
    assert (xx + xz * tangent, xz + zz * tangent) == (inertia, inertia * tangent)
    # With the other sign of the product of inertia, the vector is not an eigenvector.
    assert (xx - xz * tangent, -xz + zz * tangent) != (inertia, inertia * tangent)
    assert bicycle[f"I{body}yy"].rational == {"B": 11, "H": Fraction("0.06")}[body]


def test_p2_as_printed_is_off_the_axis(bicycle):
    with mp.workdps(30):
        s, c = mp.sin(mp.pi / 10), mp.cos(mp.pi / 10)
        foot = mpf("1.1")
        x, z = mpf("0.82188470506"), mpf("-0.85595086466")
        off = (x - foot) * c - z * s
        assert float(abs(off)) == pytest.approx(4.2e-12, abs=0.05e-12)
        assert float(abs(off) / c) == pytest.approx(4.4e-12, abs=0.05e-12)
        # The printed digits are truncated, not rounded.
        exact = -mpf("0.9") * c
        assert mp.nstr(abs(exact), 20).startswith("0.85595086466")
        assert abs(exact) - abs(z) > mpf("5e-12")


def test_the_printed_stable_range_is_off_in_its_last_digits(bicycle):
    ((low, high),) = linearise(bicycle, 30).stable_ranges
    with mp.workdps(30):
        assert float(mpf(low) - mpf("4.29238253634111")) == pytest.approx(-6.04e-15, abs=0.01e-15)
        assert float(mpf(high) - mpf("6.02426201538837")) == pytest.approx(-1.11e-14, abs=0.01e-14)


def test_all_bodies_start_about_the_line_of_the_contact_points(bicycle, maneuvers):
    at = of_known(bicycle, maneuvers)
    speed, rate = np.array([4.0, 4.6, 8.0]), np.array([0.05, 0.5, 0.05])
    heights = {"rear_hub": 0.3, "rear_frame_com": 0.9, "front_frame_com": 0.7, "front_hub": 0.35}
    for place, height in heights.items():
        found = [at[f"{place}_velocity_{axis}"] for axis in "xyz"]
        np.testing.assert_allclose(found, [speed, height * rate, 0 * speed], rtol=1e-15)
    for end, radius in (("rear", 0.3), ("front", 0.35)):
        np.testing.assert_allclose(at[f"{end}_wheel_omega_y"], -speed / radius, rtol=1e-15)
        np.testing.assert_allclose(
            [at[f"{end}_frame_omega_{axis}"] for axis in "xyz"], [rate, 0 * rate, 0 * rate],
            rtol=1e-15,
        )  # fmt: skip
    np.testing.assert_array_equal(at["potential_energy"], 794.1195)


@pytest.mark.proof
def test_the_integration_itself_keeps_the_energy():
    for run in read_candidate(reference_folder()):
        drift = evaluator(run, run.bits + 64).drift()
        # The drift of eq. (1) of the benchmark [%] corresponds to about 230 bits.
        assert 0 < drift.performance < 1e-69
        assert drift.contact < 1e-72


def test_the_path_of_maneuver_3_tightens(reference):
    from heyoka_bike.workbench.figures.motions import curvature

    bent = curvature(reference, 3, np.linspace(3.0, 10.0, 200))
    assert (bent > 0).all()
    assert (np.diff(bent) > 0).all()

"""Facts about the benchmark's motions that other work has published or measured."""

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import mpmath
import numpy as np
import pytest

from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import evaluator, row_times
from heyoka_bike.reference.proof.rows import exact_columns
from support.tiers import ONE_MANEUVER

ANCHORS = json.loads((Path(__file__).parents[1] / "anchors" / "benchmark.json").read_text())


@pytest.mark.parametrize("number", [1, 2, 3])
def test_initial_energies(bicycle, maneuvers, number):
    exact = exact_columns(bicycle, maneuvers[number - 1])
    for name, key in (("potential_energy", "V0"), ("kinetic_energy", "T0"),
                      ("mechanical_energy", "E0")):  # fmt: skip
        text = ANCHORS["energies_at_start"][str(number)][key]
        last_digit = Fraction(1, 10 ** len(text.partition(".")[2]))
        assert abs(exact[name] - Fraction(text)) <= last_digit, name


def test_maneuver_2_settles_to_straight_running(bicycle, maneuvers):
    """All energy above V0 ends up in the forward motion, whose energy is proportional to v^2."""
    exact = exact_columns(bicycle, maneuvers[1])
    straight = replace(maneuvers[1], roll_rate=maneuvers[1].roll)
    per_v2 = exact_columns(bicycle, straight)["kinetic_energy"] / Fraction(46, 10) ** 2
    mp = mpmath.mp.clone()
    mp.dps = 40
    kinetic = exact["mechanical_energy"] - exact["potential_energy"]
    ratio = kinetic / per_v2
    v = mp.sqrt(mp.mpf(ratio.numerator) / ratio.denominator)
    published = ANCHORS["maneuver_2_final_speed"]["value"]
    assert abs(v - mp.mpf(published)) < mp.mpf(10) ** -(len(published) - 2)
    # The motion comes near this speed within 60 s, because the slowest mode decays as exp(-0.378
    # t).
    slow = max(x.real for x in linearise(bicycle, 15).eigenvalues(mp.mpf("4.6")))
    assert -0.38 < slow < -0.37
    run = integrate(bicycle, replace(maneuvers[1], duration=Fraction(60)))
    at = evaluator(run, 128)
    with at.balls.precision():
        end = at.columns(Fraction(60))
        # The difference of the speeds is quadratic in the amplitude: exp(-2 x 0.378 x 60) = 2e-20.
        # So the tolerance of 1e-14 is only for roundoff.
        assert abs(float(end["forward_speed"].mid()) - float(v)) < 1e-14
        assert abs(float(end["roll_angle"].mid())) < 1e-9


@pytest.mark.parametrize("number", [1, 2, 3])
def test_nothing_falls_within_10_s(candidate, number):
    run = candidate[number - 1]
    at = evaluator(run, 300)
    with at.balls.precision():
        largest = max((abs(at.columns(t)["roll_angle"].mid()) for t in row_times(run.maneuver)),
                      key=float)  # fmt: skip
    printed = ANCHORS["largest_roll"][str(number)]
    assert abs(float(largest) - float(printed)) <= 0.5 * 10.0 ** -len(printed.partition(".")[2])


@pytest.mark.parametrize("definition", sorted(ANCHORS["distance_from_default"]))
def test_definitions_are_as_far_apart_as_measured(reference, definition):
    key = next(
        c.rpartition(f"_{definition}")[0] for c in reference[1].columns if c.endswith(definition)
    )
    for number, printed in zip((1, 2, 3), ANCHORS["distance_from_default"][definition],
                               strict=True):  # fmt: skip
        rows = reference[number].rows
        other = f"{key}_{definition}"
        distance = np.abs((rows.hi[other] - rows.hi[key]) + (rows.lo[other] - rows.lo[key])).max()
        mantissa, _, exponent = printed.partition("e")
        digits = len(mantissa.partition(".")[2])
        unit = 10.0 ** (int(exponent or 0) - digits)
        assert abs(distance - float(printed)) <= 0.51 * unit, (number, distance)


@pytest.mark.parametrize("number", ONE_MANEUVER)
def test_the_motion_depends_mildly_on_its_start(bicycle, maneuvers, candidate, number):
    """Forward in time |d state(10) / d v0| is at most 2.7, so tens of digits are attainable."""
    step = Fraction(1, 10**12)  # this step is far above the roundoff of binary128
    m, published = maneuvers[number - 1], candidate[number - 1]
    faster = replace(m, speed=replace(m.speed, rational=m.speed.rational + step))
    a, b = (evaluator(x, 200) for x in (published, integrate(bicycle, faster, "binary128")))
    with a.balls.precision():
        x, y = a.columns(Fraction(10)), b.columns(Fraction(10))
        rates = [
            abs(float(((y[n] - x[n]) * 10**12).mid()))
            for n in ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
        ]
    assert max(rates) < 2.75


@pytest.mark.parametrize("number", [1, 2, 3])
def test_derived_definitions_are_what_they_say(reference, number):
    """Compare contact speed and angle rates with differences of positions and angles."""
    h = 1e-4
    maneuver = reference[number]
    t = np.linspace(0.01, 9.99, 2001)
    before, now, after = (maneuver.evaluate(x) for x in (t - h, t, t + h))

    def rate(f):
        return (f(after) - f(before)) / (2 * h)

    # Central differences have an error of h^2 / 6 times the third derivatives (below 200 / s^3),
    # plus roundoff divided by h.
    tolerance = 1e-6
    for angle, name in (
        ("roll_angle", "roll_rate"),
        ("roll_angle_tait_bryan_xyz", "roll_rate_tait_bryan_xyz_rate"),
        ("roll_angle_zyx", "roll_rate_zyx_rate"),
        ("steer_angle", "steer_rate"),
        ("yaw", "yaw_rate"),
    ):
        assert np.abs(rate(lambda v, a=angle: v[a]) - now[name]).max() < tolerance, name
    # The contact point is at a distance of one wheel radius from the hub, downwards in the wheel
    # plane.
    heading = np.array([np.cos(now["yaw"]), np.sin(now["yaw"])])
    left = np.array([-heading[1], heading[0]])
    hub = now["forward_speed"] * heading + 0.3 * now["roll_rate"] * np.cos(now["roll_angle"]) * left
    offset = [
        rate(lambda v, f=f: -0.3 * np.sin(v["roll_angle"]) * f(v["yaw"]))
        for f in (lambda yaw: -np.sin(yaw), np.cos)
    ]
    contact = np.hypot(*(hub + offset))
    assert np.abs(contact - now["forward_speed_contact"]).max() < tolerance
    assert np.abs(np.hypot(*hub)**2 + (0.3 * now["roll_rate"] * np.sin(now["roll_angle"]))**2
                  - now["forward_speed_hub_norm"]**2).max() < 1e-12  # fmt: skip
    assert np.abs(hub[0] - now["forward_speed_hub_global_x"]).max() < 1e-14

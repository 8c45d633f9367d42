"""Another method reproduces each number in docs/after-ten-seconds.md."""

from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from after_ten_seconds import TABLES, agreed, certified, committed, number
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.motion.events import GREATEST_LEAN, REAR_LIFT, UPRIGHT, events, follow
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import evaluator
from heyoka_bike.workbench.after_ten_seconds.making import COLUMNS, MIRRORED, Section, settled


@pytest.fixture(scope="module")
def said():
    """Numbers of the page by table and quantity, as text. If a name occurs twice, the last one
    counts."""
    return {name: {row[0]: number(row[1]) for row in rows} for name, rows in committed().items()}


@pytest.fixture(scope="module")
def upright(said):
    """The cycle's point on the section, from the page."""
    return [float(x) for key, x in said["cycle"].items() if "upright" in key]


@pytest.mark.proof
def test_the_page_has_all_its_rows():
    rows = committed()
    assert [len(rows[name]) for name in TABLES] == [14, 6, 9]
    assert all(len(row) == 3 for table in rows.values() for row in table)
    certified = [row[0] for table in rows.values() for row in table if row[2] == "certified"]
    assert len(certified) == 14 + 1 + 8


@pytest.mark.proof
def test_what_the_page_calls_certified_is_in_the_file_that_is_proved(maneuvers):
    for maneuver, rows in zip(maneuvers, committed().values(), strict=True):
        said = {row[0]: number(row[1]) for row in rows if row[2] == "certified"}
        assert said == certified(maneuver)


@pytest.mark.proof
def test_the_cycle_closes_after_half_its_period_with_the_energy_of_maneuver_1(
    bicycle, maneuvers, said
):
    section = Section(bicycle, 30)
    mp = section.mp
    x = [mp.mpf(v) for key, v in said["cycle"].items() if "upright" in key]
    there, time, energy = section.half(x)
    assert max(abs(a - b) for a, b in zip(x, there, strict=True)) < 1e-27
    assert abs(2 * time - mp.mpf(said["cycle"]["period [s]"])) < 1e-27
    run = integrate(bicycle, replace(maneuvers[0], duration=maneuvers[0].spacing), 30)
    at = evaluator(run, 200)
    with at.balls.precision():
        wanted = section.number(at.columns(Fraction(0))["mechanical_energy"])
    assert abs(energy / wanted - 1) < 1e-27


@pytest.mark.proof
def test_maneuver_1_comes_to_the_cycle_at_the_rate_of_its_multiplier(
    bicycle, maneuvers, said, upright
):
    run = integrate(bicycle, replace(maneuvers[0], duration=Fraction(120)))
    at = evaluator(run, 128)
    with at.balls.precision():
        crossings = []
        for i, e in enumerate(events(run, (UPRIGHT,))):
            there = at.columns(e.time)
            # The first maximum after the start is to the left, so every second maximum is mirrored.
            signs = MIRRORED if i % 2 == 0 else (1,) * 4
            crossings.append([s * float(there[c]) for s, c in zip(signs, COLUMNS, strict=True)])
        leans = [
            abs(float(at.columns(e.time)["roll_angle"].mid()))
            for e in events(run, (GREATEST_LEAN,))
        ]
    away = np.linalg.norm(np.array(crossings) - upright, axis=1)
    rates = away[51:71] / away[50:70]
    # The next multiplier is half as large. Its relative contribution is below 1e-14 here, and that
    # of roundoff is 1e-4.
    assert np.allclose(rates, -float(said["cycle"]["half-period multiplier 1"]), rtol=3e-4)
    assert leans[-1] == pytest.approx(float(said["cycle"]["largest roll angle [rad]"]), abs=1e-10)
    assert settled(bicycle, maneuvers[0]) == pytest.approx(upright, abs=1e-11)


@pytest.mark.proof
def test_multipliers_of_a_period_are_squares_and_below_one(said):
    for i in (1, 2, 3):
        half, whole = (
            mpmath.mpf(said["cycle"][f"{name} multiplier {i}"])
            for name in ("half-period", "Floquet")
        )
        assert abs(half**2 / whole - 1) < 1e-13
        assert abs(whole) < 1


@pytest.mark.proof
def test_the_final_speed_of_maneuver_2_follows_from_masses_and_inertias(bicycle, said):
    """Compute the kinetic energy of the upright bicycle, rolling and leaning, with rationals."""
    p = {symbol: x.rational for symbol, x in bicycle.values.items()}
    rolling = sum(p[f"m{b}"] for b in "RBHF")
    rolling += p["IRyy"] / p["rR"] ** 2 + p["IFyy"] / p["rF"] ** 2
    heights = {"R": p["rR"], "F": p["rF"], "B": p["zB"], "H": p["zH"]}
    leaning = sum(p[f"I{b}xx"] + p[f"m{b}"] * z**2 for b, z in heights.items())
    square = Fraction("4.6") ** 2 + leaning / rolling * Fraction("0.5") ** 2
    with mpmath.workdps(50):
        exact = mpmath.sqrt(mpmath.mpf(square.numerator) / square.denominator)
        assert abs(mpmath.mpf(said["settling"]["final speed [m/s]"]) - exact) < 1e-29


@pytest.mark.proof
@pytest.mark.parametrize("name", ["caster", "capsize", "weave"])
def test_eigenvalues_are_those_of_the_linear_equations(bicycle, name):
    rows = {row[0]: row[1].replace("`", "") for row in committed()["settling"]}
    with mpmath.workdps(60):
        v = mpmath.mpf(rows["final speed [m/s]"])
        real, _, imaginary = rows[f"eigenvalue at the final speed, {name} [1/s]"].partition(" +- ")
        s = mpmath.mpc(real, imaginary.removesuffix(" i") or 0)
        k = linearise(bicycle, 50)
        a, b, c, d = (
            k.M[i][j] * s**2 + v * k.C1[i][j] * s + k.g * k.K0[i][j] + v**2 * k.K2[i][j]
            for i in (0, 1)
            for j in (0, 1)
        )
        assert abs(a * d - b * c) < 1e-27 * (abs(a * d) + abs(b * c))


@pytest.mark.proof
def test_maneuver_3_falls_when_the_page_says(bicycle, maneuvers, said):
    event = follow(bicycle, maneuvers[2], "longdouble").event
    assert event.what == REAR_LIFT
    key = "lift-off, time [s]"
    # Until the lift-off, errors grow by a factor of 1e8: to 1e-8 in binary64, and to 1e-11 in long
    # double.
    assert float(event.time) == pytest.approx(float(said["fall"][key]), abs=3e-10)


@pytest.mark.slow
@pytest.mark.parametrize("name", list(TABLES))
def test_the_tables_are_what_the_computation_gives(bicycle, maneuvers, name):
    maneuver = maneuvers[list(TABLES).index(name)]
    made = [tuple(map(str, row)) for row in TABLES[name](bicycle, maneuver)]
    assert made == committed()[name]


@pytest.mark.proof
def test_digits_that_agree_are_counted():
    assert agreed("1.23456", "1.23457") == ("1.2346", 5)
    assert agreed("2.5", "2.5")[1] == 30

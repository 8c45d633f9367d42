"""The projection of initial velocities has the published mass matrix and is idempotent."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.scoring.diagnosis.programs.forces import Moving
from heyoka_bike.scoring.diagnosis.programs.program import BODIES, Start, initial_state

LINEAR = json.loads((Path(__file__).parents[1] / "anchors" / "linear.json").read_text())
START = Start(4.6, 0.5)


@pytest.fixture(scope="module")
def parameters(bicycle):
    return {symbol: float(x) for symbol, x in bicycle.values.items()}


@pytest.fixture(scope="module")
def upright(bicycle):
    return Moving(Equations.of(bicycle, Arrays()), [np.zeros(())] * 7)


def published_mass_matrix():
    def find(node):
        if isinstance(node, dict):
            if "M" in node:
                return node["M"]["exact"]
            return next((f for f in map(find, node.values()) if f), None)
        return None

    return np.array(find(LINEAR), dtype=float)


def test_the_kinetic_energy_is_the_published_mass_matrix(upright):
    """The mass matrix M of Meijaard et al. (2007) belongs to roll rate and steer rate."""
    mass = np.array(upright.mass, dtype=float)
    assert mass[:2, :2] == pytest.approx(published_mass_matrix(), rel=1e-12)
    # Because of the symmetry of the bicycle, forward motion is not coupled to roll and steer.
    assert np.max(np.abs(mass[:2, 2])) < 1e-12


def test_an_admissible_start_stays_as_it_is(bicycle):
    found = initial_state(bicycle, START)
    assert found == pytest.approx((0.0, 0.0, 0.0, 0.5, 0.0, 4.6), abs=1e-13)


def heights(p):
    return {"R": -p["rR"], "B": p["zB"], "H": p["zH"], "F": -p["rF"]}


def height_of_centre(p):
    return sum(p[f"m{b}"] * z for b, z in heights(p).items()) / sum(p[f"m{b}"] for b in BODIES)


@pytest.mark.parametrize(
    "start",
    [
        replace(START, rolling=frozenset("B")),
        replace(START, rolling=frozenset("BH")),
        replace(START, turning=frozenset("BH")),
        replace(START, front_spin=0.0),
        replace(START, rear_spin=6 / 7),
        replace(START, about_centre=True),
    ],
)
def test_what_is_left_is_orthogonal_to_all_admissible_velocities(
    bicycle, parameters, upright, start
):
    """The given velocities minus the projected ones are orthogonal, in kinetic energy, to all
    admissible ones."""
    *_, roll_rate, steer_rate, speed = initial_state(bicycle, start)
    u = roll_rate, steer_rate, speed / float(upright.equations.k.length)
    spins = {"R": start.rear_spin, "F": start.front_spin}
    given = {}
    for b in BODIES:
        rate = start.roll_rate if b in start.rolling else 0.0
        height = height_of_centre(parameters) if start.about_centre else 0.0
        spin = -spins[b] * start.speed / parameters[f"r{b}"] if b in spins else 0.0
        given[f"v_{b}"] = np.array([start.speed, -rate * (heights(parameters)[b] - height), 0.0])
        given[f"w_{b}"] = np.array([rate if b in start.turning else 0.0, spin, 0.0])
    left = {
        name: v - sum(x * np.array(e[name], float) for x, e in zip(u, upright.units, strict=True))
        for name, v in given.items()
    }
    for e in upright.units:
        assert abs(upright.product(e, left)) < 1e-10
    assert upright.product(left, left) > 1e-3


def test_the_speed_of_the_centre_is_that(bicycle, parameters):
    speed = initial_state(bicycle, replace(START, speed_of_centre=True))[-1]
    assert np.hypot(speed, 0.5 * height_of_centre(parameters)) == pytest.approx(4.6, rel=1e-14)

"""The projection of a start: its mass matrix is the published one, and it is a projection."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from heyoka_bike.scoring.diagnosis.programs.start import (
    BODIES,
    Start,
    _admissible,
    _product,
    inertial_properties,
    initial_state,
)

LINEAR = json.loads((Path(__file__).parents[1] / "anchors" / "linear.json").read_text())
START = Start(4.6, 0.5)


@pytest.fixture(scope="module")
def parameters(bicycle):
    return {symbol: float(x) for symbol, x in bicycle.values.items()}


def published_mass_matrix():
    def find(node):
        if isinstance(node, dict):
            if "M" in node:
                return node["M"]["exact"]
            return next((f for f in map(find, node.values()) if f), None)
        return None

    return np.array(find(LINEAR), dtype=float)


def test_the_kinetic_energy_is_the_published_mass_matrix(parameters):
    """M of Meijaard et al. (2007), over roll rate and steer rate."""
    masses, places, inertias = inertial_properties(parameters)
    unit = _admissible(parameters, places)
    mass = np.array([[_product(masses, inertias, a, b) for b in unit] for a in unit])
    assert mass[:2, :2] == pytest.approx(published_mass_matrix(), rel=1e-12)
    # Symmetry keeps forward motion apart from roll and steer.
    assert np.max(np.abs(mass[:2, 2])) < 1e-12


def test_an_admissible_start_stays_as_it_is(parameters):
    found = initial_state(parameters, START)
    assert found == pytest.approx((0.0, 0.0, 0.0, 0.5, 0.0, 4.6), abs=1e-13)


@pytest.mark.parametrize(
    "start",
    [
        replace(START, rolling=frozenset("B")),
        replace(START, rolling=frozenset("BH")),
        replace(START, spinning=frozenset("R")),
        replace(START, about_centre=True),
    ],
)
def test_what_is_left_is_orthogonal_to_all_admissible_velocities(parameters, start):
    """The mistaken velocities minus the projected ones have no momentum along any of them."""
    masses, places, inertias = inertial_properties(parameters)
    unit = _admissible(parameters, places)
    u = initial_state(parameters, start)[3:]
    given = {}
    centre = sum(masses[b] * places[b] for b in BODIES)[2] / sum(masses.values())
    for b in BODIES:
        rate = start.roll_rate if b in start.rolling else 0.0
        height = centre if start.about_centre else 0.0
        spin = -start.speed / parameters[f"r{b}"] if b in start.spinning else 0.0
        given[b] = (
            np.array([start.speed, -rate * (places[b][2] - height), 0.0]),
            np.array([rate, spin, 0.0]),
        )
    left = {
        b: tuple(
            given[b][i] - sum(x * e[b][i] for x, e in zip(u, unit, strict=True)) for i in (0, 1)
        )
        for b in BODIES
    }
    for e in unit:
        assert abs(_product(masses, inertias, e, left)) < 1e-10
    assert _product(masses, inertias, left, left) > 1e-3


def test_the_speed_of_the_centre_is_that(parameters):
    masses, places, _ = inertial_properties(parameters)
    speed = initial_state(parameters, replace(START, speed_of_centre=True))[-1]
    height = sum(masses[b] * places[b] for b in BODIES)[2] / sum(masses.values())
    assert np.hypot(speed, 0.5 * height) == pytest.approx(4.6, rel=1e-14)

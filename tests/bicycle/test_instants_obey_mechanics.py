"""Quantities of single states agree with each other, with the motion, and with binary64."""

from fractions import Fraction
from math import cos, sin

import numpy as np
import pytest

from heyoka_bike.bicycle.instant_columns import COORDINATES, LEVELS
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle, Maneuver, read_bicycle
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.proof.instants import known_states, of_known
from heyoka_bike.scoring.instants.check import STATE_TOLERANCE, quantities_of_states
from heyoka_bike.system.resources import find_input


@pytest.fixture(scope="module")
def states():
    return known_states()


@pytest.fixture(scope="module")
def table(bicycle, states):
    return of_known(bicycle, states)


@pytest.fixture(scope="module")
def given(table):
    return {name: table[name] for name in COORDINATES}


def test_there_are_a_hundred_states_by_a_fixed_rule(states):
    import states as rule  # the module is in docs/_site

    assert len(states) >= 100
    assert rule.FILE.read_text(encoding="utf-8") == rule.text()


def test_binary64_leaves_a_thousandth_of_the_tolerance(bicycle, table, given):
    own = quantities_of_states(bicycle, given)
    assert set(own) - {"height"} <= set(table)
    for level in LEVELS:
        for c in level.columns:
            error = np.abs(own[c.name] - table[c.name]) / (1 + np.abs(table[c.name]))
            assert np.max(error) < STATE_TOLERANCE / 1000, c.name


def test_momenta_and_energies_follow_from_the_mass_matrix(table):
    u = {"roll": table["roll_rate"], "steer": table["steer_rate"], "speed": table["forward_speed"]}
    names = list(u)
    twice = sum(
        table[f"mass_{a}_{b}"] * u[a] * u[b] * (1 if a == b else 2)
        for i, a in enumerate(names) for b in names[i:]
    )  # fmt: skip
    np.testing.assert_allclose(twice / 2, table["kinetic_energy"], rtol=1e-12, atol=1e-12)
    for axis in "xyz":
        np.testing.assert_allclose(
            table[f"momentum_{axis}"], table["mass"] * table[f"com_velocity_{axis}"], atol=1e-12
        )


def test_upright_and_straight_the_floor_carries_the_weight(table):
    floor = table["rear_normal_force"] + table["front_normal_force"]
    still = np.flatnonzero(
        (table["roll_angle"] == 0) & (table["steer_angle"] == 0)
        & (table["roll_rate"] == 0) & (table["steer_rate"] == 0)
    )  # fmt: skip
    np.testing.assert_allclose(floor[still], 94 * 9.81, rtol=1e-14)


@pytest.fixture(scope="module")
def neighbours(bicycle, table, given):
    """Tables of the states moved by +h and by -h along their motion, and the interval 2 h [s]."""
    h = 1e-5
    rates = (
        "roll_rate",
        "steer_rate",
        *(f"{x}_acceleration" for x in ("roll", "steer", "forward")),
    )

    def moved(sign):
        pairs = zip(COORDINATES, rates, strict=True)
        states = {name: given[name] + sign * h * table[rate] for name, rate in pairs}
        states["yaw"] = sign * h * table["yaw_rate"]
        for axis in "xy":
            states[f"rear_contact_{axis}"] = sign * h * table[f"rear_contact_velocity_{axis}"]
        return quantities_of_states(bicycle, states, is_linear=False)

    return moved(1), moved(-1), 2 * h


def test_rates_are_those_of_neighbouring_states(table, neighbours):
    # Each pair consists of a velocity or acceleration and the position, angle or rate that it is
    # the derivative of.
    after, before, moment = neighbours
    pairs = {
        "pitch": "pitch_rate",
        "pitch_rate": "pitch_acceleration",
        "yaw_rate": "yaw_acceleration",
        "rear_wheel_rate": "rear_wheel_acceleration",
        "front_wheel_rate": "front_wheel_acceleration",
    }
    places = ("front_contact", "rear_hub", "front_hub", "rear_frame_com", "front_frame_com", "com")
    pairs |= {f"{p}_{a}": f"{p}_velocity_{a}" for p in places for a in "xyz" if f"{p}_{a}" in after}
    for name, rate in pairs.items():
        change = (after[name] - before[name]) / moment
        np.testing.assert_allclose(change, table[rate], rtol=1e-6, atol=1e-6, err_msg=name)
    energy = (after["mechanical_energy"] - before["mechanical_energy"]) / moment
    # The states are linear functions of time. So the only error is that of the difference quotient:
    # h^2 times a third derivative of 1e5.
    np.testing.assert_allclose(energy, 0, atol=1e-5)


def test_momenta_change_by_the_forces_of_the_floor(table, neighbours):
    after, before, moment = neighbours
    zero = 0 * table["mass"]

    def vector(name):
        return np.array([table.get(f"{name}_{axis}", zero) for axis in "xyz"])

    weight = np.array([zero, zero, 9.81 * table["mass"]])
    force, torque = weight, np.zeros_like(weight)
    for end in ("rear", "front"):
        axle = [table[f"{end}_frame_r{i}2"] for i in (1, 2)]
        ahead, aside = np.array([axle[1], -axle[0]]) / np.hypot(*axle)
        normal, along, across = (
            table[f"{end}_{x}_force"] for x in ("normal", "longitudinal", "lateral")
        )
        floor = np.array([along * ahead - across * aside, along * aside + across * ahead, -normal])
        force = force + floor
        torque = torque + np.cross(vector(f"{end}_contact") - vector("com"), floor, axis=0)
    for name, expected in (("momentum", force), ("angular_momentum", torque)):
        for axis, x in zip("xyz", expected, strict=True):
            change = (after[f"{name}_{axis}"] - before[f"{name}_{axis}"]) / moment
            # The tolerances allow for forces and torques of up to 1e5 N and N m.
            np.testing.assert_allclose(change, x, rtol=1e-6, atol=1e-4, err_msg=f"{name} {axis}")


def test_the_linear_bicycle_is_that_of_linearise(bicycle, table, states):
    linear = linearise(bicycle, 20)
    for i in (0, 5, len(states) - 1):
        found = [
            complex(table[f"eigenvalue_{n}_re"][i], table[f"eigenvalue_{n}_im"][i])
            for n in range(1, 5)
        ]
        expected = linear.eigenvalues(states[i].speed.fraction())
        np.testing.assert_allclose(found, [complex(z) for z in expected], rtol=1e-14)
    for name in ("M", "C1", "K0", "K2"):
        for i, row in enumerate(("roll", "steer")):
            for j, by in enumerate(("roll", "steer")):
                assert table[f"{name}_{row}_{by}"][0] == float(getattr(linear, name)[i][j])


def test_geometry_is_what_the_parameters_say(bicycle, table):
    p = {s: float(x) for s, x in bicycle.values.items()}
    s, c = sin(p["lam"]), cos(p["lam"])
    expected = {
        "steer_axis_down_x": s, "steer_axis_down_z": c, "steer_axis_floor_x": p["w"] + p["c"],
        "rear_hub_to_axis": (p["w"] + p["c"]) * c - p["rR"] * s,
        "hubs_along_axis": p["w"] * s + (p["rR"] - p["rF"]) * c,
        "axis_to_front_hub": p["rF"] * s - p["c"] * c, "mechanical_trail": p["c"] * c,
    }  # fmt: skip
    assert set(expected) == {x.name for x in LEVELS[0].columns}
    for name, x in expected.items():
        np.testing.assert_allclose(table[name], x, rtol=1e-14)


def test_a_level_depends_on_the_parameters_that_are_said(bicycle, given):
    few = {name: x[40:70:3] for name, x in given.items()}
    right = quantities_of_states(bicycle, few, is_linear=False)
    known, others = set(), {}
    for symbol in PARAMETERS:
        x = bicycle[symbol]
        other = {**bicycle.values, symbol: Exact(x.rational + Fraction(1, 1000), x.pi_multiple)}
        others[symbol] = quantities_of_states(Bicycle("", other), few, is_linear=False)
    for level in LEVELS[:-1]:
        known |= set(level.parameters)
        names = [c.name for c in level.columns]
        for symbol, made in others.items():
            acts = any(np.max(np.abs(made[n] - right[n])) > 1e-9 for n in names)
            if symbol in level.parameters:
                assert acts, (level.name, symbol)
            elif symbol not in known:
                assert not acts, (level.name, symbol)


def test_a_state_is_a_maneuver_to_go_on_from(states):
    assert all(isinstance(s, Maneuver) and s.duration == 1 for s in states)


@pytest.mark.parametrize("name", ["two-mass-skate", "adversarial/zero-mechanical-trail", ""])
def test_other_bicycles_have_all_that_is_defined(bicycle, states, name):
    # The last bicycle (empty name) is without gravity. It does not press on the floor, and at rest
    # two of its eigenvalues are zero.
    other = (
        read_bicycle(find_input("bicycles", name))
        if name
        else bicycle.replace(g=Exact(Fraction(0)))
    )
    exact = of_known(other, states[:40:13])
    own = quantities_of_states(other, {key: exact[key] for key in COORDINATES})
    for level in LEVELS:
        for c in level.columns:
            right = exact[c.name]
            is_defined = bool(name) or not (c.name.endswith("friction") or "eigenvalue" in c.name)
            assert np.isfinite(right).all() >= is_defined, c.name
            np.testing.assert_allclose(own[c.name], right, rtol=1e-11, atol=1e-11)

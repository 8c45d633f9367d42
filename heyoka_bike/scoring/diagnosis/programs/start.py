"""Initial velocities as programs set them, projected onto what rolling without slip allows.

A start that breaks the rolling constraints cannot be followed. Programs that enforce constraints at
velocity level replace it by the admissible velocities that are nearest in kinetic energy, as an
impulse of the constraint forces would: with the Jacobian J of the body velocities over roll rate,
steer rate and speed, u = (J^T M J)^-1 J^T M v. An admissible start is left as it is.

All of it at the upright straight position, axes x forward, y right, z down.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, sin

import numpy as np

from heyoka_bike.numbers.double import Array

BODIES = "RBHF"
"""Rear wheel, frame with rider, fork with handlebar, front wheel."""

STATE = ("roll", "pitch", "steer", "roll_rate", "steer_rate", "speed")
"""What `initial_state` returns."""


@dataclass(frozen=True, slots=True)
class Start:
    """Velocities given to the bodies at t = 0.

    Attributes
    ----------
    speed, roll_rate
        [m/s], [rad/s]
    rolling
        Bodies that get the roll rate.
    spinning
        Wheels that start rolling; others only move along.
    about_centre
        Whether the roll is about the line through the centre of mass, not on the ground.
    speed_of_centre
        Whether the speed is the magnitude of the centre of mass's velocity, not the hub's.
    falling
        Whether the centres of mass move sideways, as the roll makes them.
    steer_rate
        Of fork and front wheel against the rear frame, as rolling allows it [rad/s].
    added
        To the state that follows, as `STATE` has it: pairs of a place in it and a change [SI].
    """

    speed: float
    roll_rate: float
    rolling: frozenset[str] = frozenset(BODIES)
    spinning: frozenset[str] = frozenset("RF")
    about_centre: bool = False
    speed_of_centre: bool = False
    falling: bool = True
    steer_rate: float = 0.0
    added: tuple[tuple[int, float], ...] = ()


def initial_state(p: Mapping[str, float], start: Start) -> tuple[float, ...]:
    """Roll, pitch, steer, roll rate, steer rate [rad, rad/s] and speed [m/s] of a start.

    Parameters
    ----------
    p
        The parameters of `parameters.PARAMETERS`, SI.
    start : Start
    """
    masses, places, inertias = inertial_properties(p)
    centre = float(sum(masses[b] * places[b][2] for b in BODIES)) / sum(masses.values())
    lateral = -start.roll_rate * centre
    speed = start.speed
    if start.speed_of_centre:
        speed = float(np.sqrt(max(speed**2 - lateral**2, 0.0)))
    height = centre if start.about_centre else 0.0
    given = {}
    for b in BODIES:
        rate = start.roll_rate if b in start.rolling else 0.0
        spin = -speed / p[f"r{b}"] if b in start.spinning else 0.0
        sideways = -rate * (places[b][2] - height) if start.falling else 0.0
        velocity = np.array([speed, sideways, 0.0])
        given[b] = velocity, np.array([rate, spin, 0.0])
    admissible = _admissible(p, places)
    mass = np.array([[_product(masses, inertias, a, b) for b in admissible] for a in admissible])
    momentum = np.array([_product(masses, inertias, a, given) for a in admissible])
    roll_rate, steer_rate, forward = np.linalg.lstsq(mass, momentum, rcond=None)[0]
    state = [0.0, 0.0, 0.0, float(roll_rate), float(steer_rate) + start.steer_rate, float(forward)]
    for place, change in start.added:
        state[place] += change
    return tuple(state)


_Velocities = Mapping[str, tuple[Array, Array]]
"""Of each body: velocity of its centre of mass, and angular velocity."""


def inertial_properties(
    p: Mapping[str, float],
) -> tuple[dict[str, float], dict[str, Array], dict[str, Array]]:
    """Masses, centres of mass and inertia matrices."""
    masses = {b: p[f"m{b}"] for b in BODIES}
    places = {
        "R": np.array([0.0, 0.0, -p["rR"]]),
        "B": np.array([p["xB"], 0.0, p["zB"]]),
        "H": np.array([p["xH"], 0.0, p["zH"]]),
        "F": np.array([p["w"], 0.0, -p["rF"]]),
    }
    inertias = {b: np.diag([p[f"I{b}xx"], p[f"I{b}yy"], p[f"I{b}xx"]]) for b in "RF"}
    for b in "BH":
        xx, yy, zz, xz = (p[f"I{b}{ij}"] for ij in ("xx", "yy", "zz", "xz"))
        inertias[b] = np.array([[xx, 0.0, xz], [0.0, yy, 0.0], [xz, 0.0, zz]])
    return masses, places, inertias


def _admissible(p: Mapping[str, float], places: Mapping[str, Array]) -> list[_Velocities]:
    """Velocities of the bodies for unit roll rate, steer rate and speed, rolling without slip."""
    x, z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    nothing = np.zeros(3)
    roll = {b: (np.cross(x, places[b]), x) for b in BODIES}
    # The front wheel's track makes the frame yaw about the rear contact point.
    yaw = p["c"] * cos(p["lam"]) / p["w"] * z
    axis = np.array([sin(p["lam"]), 0.0, cos(p["lam"])])
    foot = np.array([p["w"] + p["c"], 0.0, 0.0])
    steer = {b: (np.cross(yaw, places[b]), yaw) for b in "RB"}
    for b in "HF":
        turn = yaw + axis
        steer[b] = np.cross(yaw, foot) + np.cross(turn, places[b] - foot), turn
    forward = dict.fromkeys("BH", (x, nothing))
    for b in "RF":
        forward[b] = x, np.array([0.0, -1.0 / p[f"r{b}"], 0.0])
    return [roll, steer, forward]


def _product(
    masses: Mapping[str, float], inertias: Mapping[str, Array], a: _Velocities, b: _Velocities
) -> float:
    """Twice the kinetic energy's bilinear form."""
    return float(
        sum(masses[k] * (a[k][0] @ b[k][0]) + a[k][1] @ inertias[k] @ b[k][1] for k in BODIES)
    )

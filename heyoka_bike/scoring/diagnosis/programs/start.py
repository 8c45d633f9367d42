"""Initial velocities as programs set them, projected onto what rolling without slip allows.

A start that breaks the rolling constraints cannot be followed. Programs that enforce constraints at
velocity level replace it by the admissible velocities that are nearest in kinetic energy, as an
impulse of the constraint forces would: with the Jacobian J of the body velocities over roll rate,
steer rate and speed, u = (J^T M J)^-1 J^T M v. An admissible start is left as it is.

All of it at the upright straight position, axes x forward, y right, z down.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.vectors import Vector
from heyoka_bike.scoring.diagnosis.programs.forces import Moving

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


def initial_state(bicycle: Bicycle, start: Start) -> tuple[float, ...]:
    """Roll, pitch, steer, roll rate, steer rate [rad, rad/s] and speed [m/s] of a start.

    Parameters
    ----------
    bicycle : Bicycle
        Any parameters, sensible or not.
    start : Start

    Raises
    ------
    ZeroDivisionError
        One half has neither mass nor inertia.
    """
    m, length = _upright(tuple(bicycle.values.items()))
    # Of a unit roll rate.
    sideways = {b: m.units[0][f"v_{b}"][1] for b in BODIES}
    centre = sum(m.masses[b] * sideways[b] for b in BODIES) / sum(m.masses.values())
    speed = start.speed
    if start.speed_of_centre:
        speed = float(np.sqrt(max(speed**2 - (start.roll_rate * centre) ** 2, 0.0)))
    given: dict[str, Vector] = {}
    for b in BODIES:
        rate = start.roll_rate if b in start.rolling else 0.0
        spin = -speed / float(bicycle[f"r{b}"]) if b in start.spinning else 0.0
        arm = sideways[b] - (centre if start.about_centre else 0.0)
        turn = m.axes.to_rear if b in "RB" else m.axes.to_front
        given[f"v_{b}"] = (speed, rate * arm if start.falling else 0.0, 0.0)
        given[f"w_{b}"] = turn((rate, spin, 0.0))
    momentum = [float(m.product(unit, given)) for unit in m.units]
    made = np.linalg.lstsq(np.array(m.mass, dtype=float), momentum, rcond=None)[0]
    roll_rate, steer_rate, forward = made.tolist()
    state = [0.0, 0.0, 0.0, roll_rate, steer_rate + start.steer_rate, forward * length]
    for place, change in start.added:
        state[place] += change
    return tuple(state)


@lru_cache(256)
def _upright(values: tuple[tuple[str, Exact], ...]) -> tuple[Moving, float]:
    """The bicycle upright and straight, and its unit of length [m]."""
    equations = Equations.of(Bicycle("", dict(values)), Arrays())
    with np.errstate(all="ignore"):
        return Moving(equations, [np.zeros(())] * 7), float(equations.k.length)

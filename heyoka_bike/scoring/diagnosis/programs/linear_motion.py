"""Motions of the linearised equations, and the columns that a program with these may write.

With q = (roll, steer), M q'' + v C1 q' + (g K0 + v^2 K2) q = 0 at constant speed v. Most people
write these equations first for this bicycle, and they are correct in themselves. To first order,
roll and its rate are the same in every definition. Energies are of second order and are computed in
several ways, so they are not compared.
"""

from collections.abc import Mapping, Sequence
from math import cos
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import DEFINITIONS
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.bicycle.stability.linear import closed_form
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.programs.program import NAMES, Terms


def linear_columns(
    bicycle: Bicycle, start: Sequence[float], time: Array, terms: Terms | None = None
) -> dict[str, Array]:
    """Compute the columns of a linear motion.

    Parameters
    ----------
    bicycle : Bicycle
        Any parameters, plausible or not.
    start : (roll, pitch, steer, roll rate, steer rate, speed)
        Initial state at t = 0 [rad, rad/s, m/s].
    time : ndarray, shape (n,)
        Ascending, from 0 on [s].
    terms : Terms
        Terms of the equations; by default the correct ones.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        The columns of `Simulator.run`. Energies, and columns that cannot be computed, are NaN.
    """
    p = {s: float(x) for s, x in bicycle.values.items()}
    roll, _, steer, roll_rate, steer_rate, speed = start
    found = {name: np.full(len(time), np.nan) for name in NAMES}
    try:
        m = closed_form(p, Arrays())
        a = _first_order(m, p, speed, terms or Terms())
        q = _propagate(a, np.array([roll, steer, roll_rate, steer_rate, 0.0]), time)
    except (ZeroDivisionError, np.linalg.LinAlgError):
        return found
    for key, values in zip(
        ("roll_angle", "steer_angle", "roll_rate", "steer_rate"), q, strict=False
    ):
        found |= {c.name: values for c in DEFINITIONS[key]}
    v = np.where(np.isfinite(q[0]), speed, np.nan)
    found |= {c.name: v for c in DEFINITIONS["forward_speed"]}
    found |= {"pitch": 0.0 * v, "yaw": q[4], "yaw_rate": _yaw(p, speed) @ q[:4]}
    return found


def _yaw(p: Mapping[str, float], speed: float) -> Array:
    """Return the coefficients of roll, steer and their rates in the yaw rate."""
    per_steer = cos(p["lam"]) / p["w"]
    return np.array([0.0, speed * per_steer, 0.0, p["c"] * per_steer])


def _first_order(m: Sequence[Any], p: Mapping[str, float], speed: float, terms: Terms) -> Array:
    """Return the matrix of the first-order system in roll, steer, their rates and yaw."""
    mass, c1, k0, k2 = (np.array(x, dtype=float) for x in m)
    c1, k0, k2 = (
        np.zeros((2, 2)) if power is None else base**power * x
        for x, base, power in (
            (c1, speed, terms.c1), (k0, p["g"], terms.k0), (k2, speed, terms.k2)
        )
    )  # fmt: skip
    a = np.zeros((5, 5))
    a[:2, 2:4] = np.eye(2)
    a[2:4, :2] = -np.linalg.solve(mass, k0 + k2)
    a[2:4, 2:4] = -np.linalg.solve(mass, c1)
    a[4, :4] = _yaw(p, speed)
    return a


def _propagate(a: Array, start: Array, time: Array) -> Array:
    """Compute the states at some times, shape (5, n), from the eigenvectors of the matrix.

    Rounding makes all eigenvalues distinct, so the matrix has enough eigenvectors.
    """
    values, vectors = np.linalg.eig(a)
    with np.errstate(over="ignore", invalid="ignore"):
        modes = np.linalg.solve(vectors, start)[:, None] * np.exp(values[:, None] * time)
        made: Array = np.real(vectors @ modes)
    return np.where(np.isfinite(made), made, np.nan)

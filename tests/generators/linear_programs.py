"""Result files of correct programs for the linearised equations: published matrices, SciPy."""

import json
import warnings
from fractions import Fraction
from itertools import product
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from generators.correct_programs import SOLVERS
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.reading.results import Quantum, Results, Rows

TOLERANCES = (1e-3, 1e-4, 1e-6, 1e-8, 1e-11)
ENERGIES = ("second order", "constant", "lateral", "zero", "none")
LATERAL = ("roll_angle", "steer_angle", "roll_rate", "steer_rate")

_ANCHORS = Path(__file__).parents[1] / "anchors" / "linear.json"
_PUBLISHED = json.loads(_ANCHORS.read_text(encoding="utf-8"))["matrices"]
M, C1, K0, K2 = (np.array(_PUBLISHED[name]["exact"], float) for name in ("M", "C1", "K0", "K2"))
G = 9.81


def run(reference, number, solver, tolerance):
    """Return speed, and roll, steer and their rates at the reference's rows."""
    v, rate = (float(Fraction(reference[number].inputs[k])) for k in ("speed", "roll_rate"))
    inverse, time = np.linalg.inv(M), reference[number].time

    def slope(_, y):
        return [*y[2:], *(-inverse @ (v * C1 @ y[2:] + (G * K0 + v * v * K2) @ y[:2]))]

    with warnings.catch_warnings():
        # LSODA prints a warning when it repeats a step.
        warnings.simplefilter("ignore")
        found = solve_ivp(slope, (0.0, time[-1]), [0.0, 0.0, rate, 0.0], solver, t_eval=time,
                          rtol=tolerance, atol=1e-3 * tolerance)  # fmt: skip
    return v, found.y


def columns(reference, number, solver, tolerance, energies):
    """Return the columns that such a program writes for a maneuver."""
    v, y = run(reference, number, solver, tolerance)
    found = dict(zip(LATERAL, y, strict=True)) | {"forward_speed": np.full(y.shape[1], v)}
    p = {s: float(Fraction(x)) for s, x in reference.parameters.items() if "pi" not in x}
    weight = p["mR"] * p["rR"] + p["mF"] * p["rF"] - p["mB"] * p["zB"] - p["mH"] * p["zH"]
    spin = p["IRyy"] / p["rR"] ** 2 + p["IFyy"] / p["rF"] ** 2
    ahead = (sum(p[f"m{b}"] for b in "RBHF") + spin) * v**2 / 2 + np.zeros(y.shape[1])
    upright = G * weight + np.zeros(y.shape[1])
    lifted = G * np.einsum("it,ij,jt->t", y[:2], K0, y[:2]) / 2
    swing = np.einsum("it,ij,jt->t", y[2:], M, y[2:]) / 2
    potential, kinetic = {
        "second order": (upright + lifted, ahead + swing),
        "constant": (upright, ahead),
        "lateral": (lifted, swing),
        "zero": (0 * upright, 0 * upright),
        "none": (None, None),
    }[energies]
    if potential is not None:
        found |= {"potential_energy": potential, "kinetic_energy": kinetic}
        found["mechanical_energy"] = potential + kinetic
    return {key: found[key] for key in BENCHMARK_COLUMNS if key in found}


def linear_run(reference, solver="DOP853", tolerance=1e-11, energies="second order"):
    """Return results of all maneuvers."""
    parts = []
    for n in reference:
        values = columns(reference, n, solver, tolerance, energies)
        m = reference[n]
        quantum = dict.fromkeys(values, Quantum(2, 53))
        parts.append(Rows(n, m.time, m.time_lo, values, quantum=quantum))
    return Results("linear", "text", tuple(parts), 16)


def linear_runs(reference):
    """Yield every solver at every tolerance, cycling through the kinds of energies."""
    for i, (solver, tolerance) in enumerate(product(SOLVERS, TOLERANCES)):
        energies = ENERGIES[i % len(ENERGIES)]
        name = f"linear, {solver} {tolerance}, energies {energies}"
        yield name, linear_run(reference, solver, tolerance, energies)
    for energies in ENERGIES:
        yield f"linear, energies {energies}", linear_run(reference, energies=energies)

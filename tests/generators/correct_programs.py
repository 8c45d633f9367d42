"""Result files of correct programs with other integration methods, steps and tolerances."""

import warnings

import numpy as np
from scipy.integrate import solve_ivp

# Spectral radius at infinity of the generalised-alpha method. This value is usual in multibody
# programs.
RHO = 0.8
SOLVERS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-8)
STEPS = (0.01, 0.005, 0.002, 0.001)


def implicit_midpoint(equations):
    return lambda y, h, _: 2 * equations.solve(y, h / 2, y) - y


def generalised_alpha(equations):
    """Integrate by generalised alpha for first-order systems, with the rate as a variable."""
    a_m, a_f = 0.5 * (3 - RHO) / (1 + RHO), 1 / (1 + RHO)
    gamma = 0.5 + a_m - a_f

    def step(y, h, memory):
        rate = memory.get("rate", equations.slope(y))
        # Solve for the state inside the step. The slope at this state determines the new rate.
        known = y + a_f * h * (1 - gamma / a_m) * rate
        inner = equations.solve(known, a_f * h * gamma / a_m, y)
        memory["rate"] = (equations.slope(inner) - (1 - a_m) * rate) / a_m
        return y + h * ((1 - gamma) * rate + gamma * memory["rate"])

    return step


METHODS = {
    "explicit Euler": lambda e: e.explicit("euler"),
    "semi-implicit Euler": lambda e: e.symplectic_euler,
    "implicit Euler": lambda e: e.implicit(1.0),
    "Heun": lambda e: e.explicit("heun"),
    "RK4": lambda e: e.explicit("rk4"),
    "trapezoidal": lambda e: e.implicit(0.5),
    "implicit midpoint": implicit_midpoint,
    "generalised alpha": generalised_alpha,
}


def fixed_step(equations, method, h):
    return equations.run(METHODS[method](equations), h)


def adaptive(equations, solver, tolerance):
    """Integrate by a method of `solve_ivp`, with interpolated rows."""
    states = []
    for i, n in enumerate(equations.reference):
        time = equations.reference[n].time
        with warnings.catch_warnings():
            # LSODA prints a warning when it repeats a step.
            warnings.simplefilter("ignore")
            run = solve_ivp(
                lambda t, y: equations.slope(y), (0.0, time[-1]), equations.start[:, i], solver,
                t_eval=time, rtol=tolerance, atol=1e-2 * tolerance,
            )  # fmt: skip
        states.append(run.y)
    return equations.results(np.stack(states, axis=1))

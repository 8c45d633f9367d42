"""Runs with the linearised equations, as written from the paper's appendix.

Meijaard, Papadopoulos, Ruina, Schwab (2007), doi:10.1098/rspa.2007.1857, appendix A: M q'' + v C1
q' + (g K0 + v^2 K2) q = 0 with q = (roll, steer), at a constant speed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from corpus import methods as by
from corpus.benchmark import MANEUVERS, TABLE_1, Array, Columns, Run
from corpus.methods import Lean, Method


@dataclass(frozen=True)
class Linear:
    """Matrices of the linearised bicycle, and the total mass."""

    mass: Array
    damping: Array
    gravity: Array
    speed: Array
    total: float


def linear(p: Mapping[str, float]) -> Linear:
    """The paper's appendix A, line by line; its I_Axz etc. are matrix elements, as in Table 1."""
    w, c, lam, r_r, r_f = p["w"], p["c"], p["lam"], p["rR"], p["rF"]
    m_r, m_b, m_h, m_f = p["mR"], p["mB"], p["mH"], p["mF"]
    x_b, z_b, x_h, z_h = p["xB"], p["zB"], p["xH"], p["zH"]
    m_t = m_r + m_b + m_h + m_f
    x_t = (x_b * m_b + x_h * m_h + w * m_f) / m_t
    z_t = (-r_r * m_r + z_b * m_b + z_h * m_h - r_f * m_f) / m_t
    t_xx = (p["IRxx"] + p["IBxx"] + p["IHxx"] + p["IFxx"] + m_r * r_r**2 + m_b * z_b**2
            + m_h * z_h**2 + m_f * r_f**2)  # fmt: skip
    t_xz = p["IBxz"] + p["IHxz"] - m_b * x_b * z_b - m_h * x_h * z_h + m_f * w * r_f
    t_zz = (p["IRxx"] + p["IBzz"] + p["IHzz"] + p["IFxx"] + m_b * x_b**2 + m_h * x_h**2
            + m_f * w**2)  # fmt: skip
    m_a = m_h + m_f
    x_a, z_a = (x_h * m_h + w * m_f) / m_a, (z_h * m_h - r_f * m_f) / m_a
    a_xx = p["IHxx"] + p["IFxx"] + m_h * (z_h - z_a) ** 2 + m_f * (r_f + z_a) ** 2
    a_xz = p["IHxz"] - m_h * (x_h - x_a) * (z_h - z_a) + m_f * (w - x_a) * (r_f + z_a)
    a_zz = p["IHzz"] + p["IFxx"] + m_h * (x_h - x_a) ** 2 + m_f * (w - x_a) ** 2
    sin, cos = np.sin(lam), np.cos(lam)
    u_a = (x_a - w - c) * cos - z_a * sin
    a_ll = m_a * u_a**2 + a_xx * sin**2 + 2 * a_xz * sin * cos + a_zz * cos**2
    a_lx = -m_a * u_a * z_a + a_xx * sin + a_xz * cos
    a_lz = m_a * u_a * x_a + a_xz * sin + a_zz * cos
    mu = c / w * cos
    s_r, s_f = p["IRyy"] / r_r, p["IFyy"] / r_f
    s_t, s_a = s_r + s_f, m_a * u_a + mu * m_t * x_t
    return Linear(
        mass=np.array([
            [t_xx, a_lx + mu * t_xz],
            [a_lx + mu * t_xz, a_ll + 2 * mu * a_lz + mu**2 * t_zz]]),
        damping=np.array([
            [0.0, mu * s_t + s_f * cos + t_xz / w * cos - mu * m_t * z_t],
            [-(mu * s_t + s_f * cos),
             a_lz / w * cos + mu * (s_a + t_zz / w * cos)]]),
        gravity=np.array([[m_t * z_t, -s_a], [-s_a, -s_a * sin]]),
        speed=np.array([[0.0, (s_t - m_t * z_t) / w * cos], [0.0, (s_a + s_f * sin) / w * cos]]),
        total=m_t,
    )  # fmt: skip


Slope = Callable[[Linear, float], tuple[Array, Array, Array]]
"""Function that returns mass, damping and stiffness at a speed."""


def _right(k: Linear, v: float) -> tuple[Array, Array, Array]:
    return k.mass, v * k.damping, TABLE_1["g"] * k.gravity + v**2 * k.speed


def _with_energies(k: Linear, v: float, y: Array) -> Columns:
    """Energies of a linear program: to second order in roll and steer."""
    q, u = y[:2], y[2:]
    potential = np.einsum("it,ij,jt->t", q, TABLE_1["g"] * k.gravity, q) / 2
    kinetic = np.einsum("it,ij,jt->t", u, k.mass, u) / 2
    spin = (TABLE_1["IRyy"] / TABLE_1["rR"] ** 2 + TABLE_1["IFyy"] / TABLE_1["rF"] ** 2) / 2
    height = sum(
        TABLE_1[mass] * up for mass, up in
        (("mR", TABLE_1["rR"]), ("mB", -TABLE_1["zB"]), ("mH", -TABLE_1["zH"]),
         ("mF", TABLE_1["rF"]))
    )  # fmt: skip
    return _columns(v, y, TABLE_1["g"] * height + potential, (k.total / 2 + spin) * v**2 + kinetic)


def _lateral_energies(k: Linear, v: float, y: Array) -> Columns:
    """Energies of roll and steer only."""
    return {
        name: column - (column[0] if name == "potential" else 0)
        for name, column in _with_energies(k, v, y).items()
    } | {"kinetic": np.einsum("it,ij,jt->t", y[2:], k.mass, y[2:]) / 2}


def _without_energies(_: Linear, v: float, y: Array) -> Columns:
    return _columns(v, y, 0.0, 0.0)


def _columns(v: float, y: Array, potential: Array | float, kinetic: Array | float) -> Columns:
    rows = y.shape[1]
    return {
        "roll": y[0], "roll_rate": y[2], "speed": np.full(rows, v),
        "potential": np.broadcast_to(potential, rows), "kinetic": np.broadcast_to(kinetic, rows),
        "steer": y[1], "steer_rate": y[3],
    }  # fmt: skip


def _no_fall(_: Array) -> float:
    """A linear program continues at any roll angle."""
    return 0.0


def _exact(slope: Callable[[float, Array], Array], start: Array, _: Lean) -> Array:
    """Multiply by the matrix exponential from row to row."""
    matrix = np.column_stack([slope(0.0, unit) for unit in np.eye(4)])
    step, states = expm(matrix * 0.01), [start]
    for _ in by.TIMES[:-1]:
        states.append(step @ states[-1])
    return np.array(states).T


def _compute(
    method: Method, matrices: Slope, output: Callable[[Linear, float, Array], Columns],
    p: Mapping[str, float] = TABLE_1,
) -> Callable[[int], Columns]:  # fmt: skip
    def run(maneuver: int) -> Columns:
        v, roll_rate = MANEUVERS[maneuver]
        k = linear(p)
        mass, damping, stiffness = matrices(k, v)

        def slope(_: float, y: Array) -> Array:
            return np.concatenate(
                [y[2:], -np.linalg.solve(mass, damping @ y[2:] + stiffness @ y[:2])]
            )

        return output(k, v, method(slope, np.array([0.0, 0.0, roll_rate, 0.0]), _no_fall))

    return run


_CORRECT: tuple[tuple[str, str, Method, Callable[[Linear, float, Array], Columns]], ...] = (
    ("rk45-defaults", "solve_ivp, RK45, defaults; energies to second order",
     by.scipy_method("RK45", 1e-3, 1e-6), _with_energies),
    ("rk45-1e-10", "solve_ivp, RK45, rtol = atol = 1e-10; energies to second order",
     by.scipy_method("RK45", 1e-10), _with_energies),
    ("odeint", "odeint, defaults; energies to second order", by.odeint_as_it_comes,
     _with_energies),
    ("rk4", "Runge-Kutta 4, h = 0.01; energies to second order", by.fixed(by.runge_kutta_4, 1),
     _with_energies),
    ("euler", "Euler, h = 0.001; energies to second order", by.fixed(by.euler, 10),
     _with_energies),
    ("expm", "matrix exponential; energies to second order", _exact, _with_energies),
    ("expm-no-energies", "matrix exponential; energies left zero", _exact, _without_energies),
    ("rk45-no-energies", "solve_ivp, RK45, rtol = atol = 1e-8; energies left zero",
     by.scipy_method("RK45", 1e-8), _without_energies),
    ("expm-lateral", "matrix exponential; energies of the lateral motion alone", _exact,
     _lateral_energies),
)  # fmt: skip


def _mistake(name: str, expected: str, did: str, matrices: Slope = _right, **values: float) -> Run:
    run = _compute(_exact, matrices, _with_energies, {**TABLE_1, **values})
    return Run(f"linear-{name}", "linearised equations, matrix exponential", did, expected, run)


RUNS = (
    *(
        Run(f"linear-{name}", f"linearised equations, {words}", "", "linearised",
            _compute(method, _right, output))
        for name, words, method, output in _CORRECT
    ),
    _mistake("product-sign", "linearised, rear frame product of inertia with the other sign",
             "linearised equations with I_Bxz = -2.4", IBxz=-TABLE_1["IBxz"]),
    _mistake("no-damping-speed", "linearised, another mistake in the equations",
             "C1 not multiplied by the speed",
             lambda k, v: (k.mass, k.damping, TABLE_1["g"] * k.gravity + v**2 * k.speed)),
    _mistake("no-gyroscopic", "linearised, wheel spin inertia missing",
             "linearised equations with I_Ryy = I_Fyy = 0", IRyy=0.0, IFyy=0.0),
    _mistake("speed-not-squared", "linearised, another mistake in the equations",
             "K2 multiplied by v instead of its square",
             lambda k, v: (k.mass, v * k.damping, TABLE_1["g"] * k.gravity + v * k.speed)),
)  # fmt: skip

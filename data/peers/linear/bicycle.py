"""The linearised bicycle with SciPy: M q'' + v C1 q' + (g K0 + v^2 K2) q = 0 for roll and steer.

``simulate`` is what `../field.py` calls. The matrices are those of Meijaard, Papadopoulos, Ruina
and Schwab 2007, doi:10.1098/rspa.2007.1857, appendix A, with its names. Inertia entries are matrix
elements, z is down. The speed is constant; the energies are those to second order.
"""

import time

import numpy as np
from scipy.linalg import expm


def matrices(p):
    """M, C1, K0, K2 of the paper, for roll and steer; and the total mass."""
    w, c, lam, r_r, r_f = p["w"], p["c"], p["lam"], p["rR"], p["rF"]
    m_r, m_b, m_h, m_f = p["mR"], p["mB"], p["mH"], p["mF"]
    x_b, z_b, x_h, z_h = p["xB"], p["zB"], p["xH"], p["zH"]
    m_t, m_a = m_r + m_b + m_h + m_f, m_h + m_f
    x_t = (x_b * m_b + x_h * m_h + w * m_f) / m_t
    z_t = (-r_r * m_r + z_b * m_b + z_h * m_h - r_f * m_f) / m_t
    t_xx = p["IRxx"] + p["IBxx"] + p["IHxx"] + p["IFxx"]
    t_xx += m_r * r_r**2 + m_b * z_b**2 + m_h * z_h**2 + m_f * r_f**2
    t_xz = p["IBxz"] + p["IHxz"] - m_b * x_b * z_b - m_h * x_h * z_h + m_f * w * r_f
    t_zz = p["IRxx"] + p["IBzz"] + p["IHzz"] + p["IFxx"]
    t_zz += m_b * x_b**2 + m_h * x_h**2 + m_f * w**2
    x_a, z_a = (x_h * m_h + w * m_f) / m_a, (z_h * m_h - r_f * m_f) / m_a
    a_xx = p["IHxx"] + p["IFxx"] + m_h * (z_h - z_a) ** 2 + m_f * (r_f + z_a) ** 2
    a_xz = p["IHxz"] - m_h * (x_h - x_a) * (z_h - z_a) + m_f * (w - x_a) * (r_f + z_a)
    a_zz = p["IHzz"] + p["IFxx"] + m_h * (x_h - x_a) ** 2 + m_f * (w - x_a) ** 2
    sin, cos = np.sin(lam), np.cos(lam)
    u_a = (x_a - w - c) * cos - z_a * sin
    a_ll = m_a * u_a**2 + a_xx * sin**2 + 2 * a_xz * sin * cos + a_zz * cos**2
    a_lx = -m_a * u_a * z_a + a_xx * sin + a_xz * cos
    a_lz = m_a * u_a * x_a + a_xz * sin + a_zz * cos
    mu, s_r, s_f = c / w * cos, p["IRyy"] / r_r, p["IFyy"] / r_f
    s_t, s_a = s_r + s_f, m_a * u_a + mu * m_t * x_t
    m_rs = a_lx + mu * t_xz
    mass = np.array([[t_xx, m_rs], [m_rs, a_ll + 2 * mu * a_lz + mu**2 * t_zz]])
    turn = mu * s_t + s_f * cos
    c_1 = np.array([
        [0, turn + t_xz / w * cos - mu * m_t * z_t],
        [-turn, a_lz / w * cos + mu * (s_a + t_zz / w * cos)],
    ])  # fmt: skip
    k_0 = np.array([[m_t * z_t, -s_a], [-s_a, -s_a * sin]])
    k_2 = np.array([[0, (s_t - m_t * z_t) / w * cos], [0, (s_a + s_f * sin) / w * cos]])
    return mass, c_1, k_0, k_2, m_t


def simulate(p, speed, roll_rate, step):
    """Rows of the eight columns every ``step``, which is 0.01 s, and the processor time [s]."""
    mass, c_1, k_0, k_2, total = matrices(p)
    begin = time.process_time()
    stiffness = p["g"] * k_0 + speed**2 * k_2
    slope = np.block([
        [np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, np.hstack([stiffness, speed * c_1]))]
    ])  # fmt: skip
    forward, states = expm(step * slope), [np.array([0, 0, roll_rate, 0])]
    for _ in range(1000):
        states.append(forward @ states[-1])
    cpu = time.process_time() - begin
    states = np.array(states)
    q, u = states[:, :2], states[:, 2:]
    height = p["mR"] * p["rR"] - p["mB"] * p["zB"] - p["mH"] * p["zH"] + p["mF"] * p["rF"]
    potential = p["g"] * height + np.einsum("ti,ij,tj->t", q, p["g"] * k_0, q) / 2
    spin = total + p["IRyy"] / p["rR"] ** 2 + p["IFyy"] / p["rF"] ** 2
    kinetic = spin * speed**2 / 2 + np.einsum("ti,ij,tj->t", u, mass, u) / 2
    constant = np.full(1001, speed)
    return np.column_stack([
        q[:, 0], u[:, 0], constant, potential, kinetic, potential + kinetic, q[:, 1], u[:, 1]
    ]), cpu  # fmt: skip

"""M, C1, K0, K2 in closed form, over any number type.

Typed from Meijaard, Papadopoulos, Ruina and Schwab (2007), doi:10.1098/rspa.2007.1857, Appendix A,
in its symbols. `linear` takes the same matrices from the nonlinear model; these need fewer
operations, which is what intervals and affine numbers ask for. The tests compare the two.
"""

from collections.abc import Mapping
from typing import NamedTuple

from heyoka_bike.numbers.arithmetic import Arithmetic, Number

Matrix = tuple[tuple[Number, Number], tuple[Number, Number]]


class Matrices(NamedTuple):
    """Coefficients of M q'' + v C1 q' + (g K0 + v^2 K2) q = 0, q = (roll, steer).

    Attributes
    ----------
    M, C1, K0, K2 : Matrix
        First row: roll equation; second row: steer equation [kg m^2, kg m, kg m, kg].
    """

    M: Matrix
    C1: Matrix
    K0: Matrix
    K2: Matrix


def closed_form(p: Mapping[str, Number], a: Arithmetic) -> Matrices:
    """The matrices from the parameters by symbol (see `parameters.PARAMETERS`)."""
    w, c = p["w"], p["c"]
    sin, cos = a.sin(p["lam"]), a.cos(p["lam"])

    # Total: m_T x_T and m_T z_T, and the inertia about the rear contact point.
    front_x = p["mH"] * p["xH"] + p["mF"] * w
    front_z = p["mH"] * p["zH"] - p["mF"] * p["rF"]
    total_x = p["mB"] * p["xB"] + front_x
    total_z = p["mB"] * p["zB"] - p["mR"] * p["rR"] + front_z
    t_xx = (
        (p["IRxx"] + p["IBxx"] + p["IHxx"] + p["IFxx"])
        + (p["mR"] * p["rR"] * p["rR"] + p["mB"] * p["zB"] * p["zB"])
        + (p["mH"] * p["zH"] * p["zH"] + p["mF"] * p["rF"] * p["rF"])
    )
    t_xz = (
        (p["IBxz"] + p["IHxz"])
        - (p["mB"] * p["xB"] * p["zB"] + p["mH"] * p["xH"] * p["zH"])
        + p["mF"] * w * p["rF"]
    )
    t_zz = (
        (p["IRxx"] + p["IBzz"] + p["IHzz"] + p["IFxx"])
        + p["mB"] * p["xB"] * p["xB"]
        + (p["mH"] * p["xH"] * p["xH"] + p["mF"] * w * w)
    )

    # Front assembly A: its inertia about the steer axis, from each body's distance u to it, ahead.
    u_h = (p["xH"] - w - c) * cos - p["zH"] * sin
    u_f = p["rF"] * sin - c * cos
    moment = p["mH"] * u_h + p["mF"] * u_f
    own_x = (p["IHxx"] + p["IFxx"]) * sin + p["IHxz"] * cos
    own_z = p["IHxz"] * sin + (p["IHzz"] + p["IFxx"]) * cos
    a_ll = p["mH"] * u_h * u_h + p["mF"] * u_f * u_f + own_x * sin + own_z * cos
    a_lx = own_x - p["mH"] * u_h * p["zH"] + p["mF"] * u_f * p["rF"]
    a_lz = own_z + p["mH"] * u_h * p["xH"] + p["mF"] * u_f * w

    mu = c / w * cos
    s_f = p["IFyy"] / p["rF"]
    s_t = p["IRyy"] / p["rR"] + s_f
    s_a = moment + mu * total_x
    m12 = a_lx + mu * t_xz
    swing = cos / w
    gyro = mu * s_t + s_f * cos
    zero = 0 * w
    return Matrices(
        M=((t_xx, m12), (m12, a_ll + 2 * mu * a_lz + mu * mu * t_zz)),
        C1=(
            (zero, gyro + t_xz * swing - mu * total_z),
            (-gyro, a_lz * swing + mu * (s_a + t_zz * swing)),
        ),
        K0=((total_z, -s_a), (-s_a, -s_a * sin)),
        K2=((zero, (s_t - total_z) * swing), (zero, (s_a + s_f * sin) * swing)),
    )

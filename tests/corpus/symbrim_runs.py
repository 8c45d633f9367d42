"""Runs with SymBRiM: correct ones with many methods, and mistakes that users make."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from corpus import methods as by
from corpus.benchmark import MANEUVERS, TABLE_1, Array, Columns, Run, changed
from corpus.methods import EXACT, Method
from corpus.symbrim_model import Bicycle, symbrim_parameters, turned

ROLL_RATE, REAR_WHEEL, STEER_RATE, FRONT_WHEEL = 3, 5, 6, 7
"""Indices of the speeds that a user specifies; yaw, pitch and the contact point follow."""

_PROGRAM = "SymBRiM 0.1.0"
Speeds = Callable[[Bicycle, Array, float, float], Array]


def _start(bike: Bicycle, q: Array, v: float, roll_rate: float) -> Array:
    known = {ROLL_RATE: roll_rate, REAR_WHEEL: -v / TABLE_1["rR"], STEER_RATE: 0.0}
    return bike.speeds(q, known)


@dataclass(frozen=True)
class Setup:
    """A setup as a user of SymBRiM writes it; the defaults are correct.

    Attributes
    ----------
    values
        SymBRiM's parameters.
    speeds
        Function that returns all initial speeds from the bicycle, its coordinates, forward speed
        and roll rate.
    method
    """

    values: Mapping[str, float] = field(default_factory=lambda: symbrim_parameters(TABLE_1))
    speeds: Speeds = _start
    method: Method = EXACT

    def compute(self, maneuver: int) -> Columns:
        bike = Bicycle(self.values)
        q = bike.upright(TABLE_1["lam"])
        u = self.speeds(bike, q, *MANEUVERS[maneuver])
        return bike.output(self.method(bike.slope, np.concatenate([q, u]), lambda y: y[3]))


def _also(**values: float) -> Setup:
    """SymBRiM's parameters with some of them changed."""
    right = symbrim_parameters(TABLE_1)
    unknown = values.keys() - right.keys()
    if unknown:
        raise KeyError(*unknown)
    return Setup({**right, **values})


def _table(**values: float) -> Setup:
    """Some values of Table 1 changed, then converted correctly."""
    return Setup(symbrim_parameters(changed(**values)))


def _inertia(letters: str, angle: float, xz: float = 1.0) -> Setup:
    """Inertia of the frames B or H rotated by a wrong angle, with xz multiplied by a factor."""
    entries = {}
    for letter in letters:
        body = {"B": "rear", "H": "front"}[letter]
        given = (TABLE_1[f"I{letter}{axes}"] for axes in ("xx", "zz", "xz"))
        xx, zz, izx = turned(*given, angle)
        entries |= {f"{body}_ixx": xx, f"{body}_izz": zz, f"{body}_izx": xz * izx}
    return _also(**entries)


def _start_with(**changes: Callable[[float, float], float]) -> Setup:
    """Change the initial roll rate or rear wheel rate; each rule is a function of speed and roll
    rate."""

    def speeds(bike: Bicycle, q: Array, v: float, roll_rate: float) -> Array:
        given = {"roll": roll_rate, "rear": -v / TABLE_1["rR"], "steer": 0.0}
        given |= {name: rule(v, roll_rate) for name, rule in changes.items()}
        known = {ROLL_RATE: given["roll"], REAR_WHEEL: given["rear"], STEER_RATE: given["steer"]}
        return bike.speeds(q, known)

    return Setup(speeds=speeds)


def _without_rotation(wheel: int) -> Setup:
    """One wheel does not turn at the start although the bicycle moves."""

    def speeds(bike: Bicycle, q: Array, v: float, roll_rate: float) -> Array:
        u = _start(bike, q, v, roll_rate)
        u[wheel] = 0.0
        return u

    return Setup(speeds=speeds)


def _front_wheel_by_its_description() -> Setup:
    """SymBRiM describes u8 as the rear wheel's and u6 as the front wheel's; it is the reverse."""

    def speeds(bike: Bicycle, q: Array, v: float, roll_rate: float) -> Array:
        known = {ROLL_RATE: roll_rate, FRONT_WHEEL: -v / TABLE_1["rR"], STEER_RATE: 0.0}
        return bike.speeds(q, known)

    return Setup(speeds=speeds)


def _fork_about(x: float, z: float) -> tuple[float, float, float]:
    """Inertia xx, zz, xz of the fork about another point (x, z), by the parallel axis theorem."""
    p = TABLE_1
    a, b = x - p["xH"], z - p["zH"]
    return p["IHxx"] + p["mH"] * b * b, p["IHzz"] + p["mH"] * a * a, p["IHxz"] - p["mH"] * a * b


def _about_the_axle() -> Setup:
    x, z = TABLE_1["w"], -TABLE_1["rF"]
    xx, zz, xz = _fork_about(x, z)
    far = (x - TABLE_1["xH"]) ** 2 + (z - TABLE_1["zH"]) ** 2
    return _table(IHxx=xx, IHzz=zz, IHxz=xz, IHyy=TABLE_1["IHyy"] + TABLE_1["mH"] * far)


def _lengths(**radii: float) -> Mapping[str, float]:
    """Lengths d1, d2, d3 that follow from another wheel radius."""
    found = symbrim_parameters(changed(**radii))
    return {name: found[name] for name in ("rear_d1", "front_d2", "front_d3")}


_P, _V = TABLE_1, symbrim_parameters(TABLE_1)
_SWAPPED = {
    "radii": {"rR": _P["rF"], "rF": _P["rR"]},
    "masses": {"mR": _P["mF"], "mF": _P["mR"]},
    "inertia": {"IRxx": _P["IFxx"], "IFxx": _P["IRxx"], "IRyy": _P["IFyy"], "IFyy": _P["IRyy"]},
}


def _axes_of_wheels(letters: str) -> Setup:
    values = {}
    for letter in letters:
        values |= {f"I{letter}xx": _P[f"I{letter}yy"], f"I{letter}yy": _P[f"I{letter}xx"]}
    return _table(**values)


_MISTAKES: tuple[tuple[str, str, str, Setup], ...] = (
    ("rear-not-rotated", "rear frame inertia not rotated",
     "Table 1's inertia of the rear frame put into its tilted axes as it stands",
     _inertia("B", 0.0)),
    ("fork-not-rotated", "fork inertia not rotated",
     "Table 1's inertia of the fork put into its tilted axes as it stands", _inertia("H", 0.0)),
    ("both-not-rotated", "rear frame and fork inertia not rotated",
     "Table 1's inertia of both frames put into their tilted axes as it stands",
     _inertia("BH", 0.0)),
    ("rear-rotated-back", "rear frame inertia rotated the wrong way",
     "inertia of the rear frame rotated by the tilt the wrong way", _inertia("B", -_P["lam"])),
    ("fork-rotated-back", "fork inertia rotated the wrong way",
     "inertia of the fork rotated by the tilt the wrong way", _inertia("H", -_P["lam"])),
    ("both-rotated-back", "rear frame and fork inertia rotated the wrong way",
     "inertia of both frames rotated by the tilt the wrong way", _inertia("BH", -_P["lam"])),
    ("both-rotated-by-72-degrees", "rear frame and fork inertia rotated by the head angle",
     "inertia of both frames rotated by the head angle, 72 degrees, instead of the tilt",
     _inertia("BH", np.pi / 2 - _P["lam"])),
    ("rear-product-sign", "rear frame product of inertia with the other sign",
     "I_Bxz taken as minus the matrix element, then rotated", _table(IBxz=-_P["IBxz"])),
    ("fork-product-sign", "fork product of inertia with the other sign",
     "I_Hxz taken as minus the matrix element, then rotated", _table(IHxz=-_P["IHxz"])),
    ("both-product-signs", "rear frame and fork product of inertia with the other sign",
     "I_Bxz and I_Hxz taken as minus the matrix elements, then rotated",
     _table(IBxz=-_P["IBxz"], IHxz=-_P["IHxz"])),
    ("rear-own-product-sign", "rear frame product of inertia with the other sign in its own axes",
     "inertia of the rear frame rotated rightly, then izx entered with the other sign",
     _inertia("B", _P["lam"], -1.0)),
    ("fork-own-product-sign", "fork product of inertia with the other sign in its own axes",
     "inertia of the fork rotated rightly, then izx entered with the other sign",
     _inertia("H", _P["lam"], -1.0)),
    ("both-own-product-signs",
     "rear frame and fork product of inertia with the other sign in their own axes",
     "inertia of both frames rotated rightly, then izx entered with the other sign",
     _inertia("BH", _P["lam"], -1.0)),
    ("rear-product-missing", "rear frame product of inertia missing",
     "I_Bxz left out", _table(IBxz=0.0)),
    ("fork-product-missing", "fork product of inertia missing",
     "I_Hxz left out", _table(IHxz=0.0)),
    ("rider-point-mass", "rear frame is a point mass",
     "rear frame with rider without moments of inertia",
     _also(rear_ixx=0.0, rear_iyy=0.0, rear_izz=0.0, rear_izx=0.0)),
    ("wheels-swapped", "front and rear wheel exchanged",
     "radius, mass and inertia of the wheels exchanged before all is converted; the start is right "
     "for the radius of Table 1",
     _table(**_SWAPPED["radii"], **_SWAPPED["masses"], **_SWAPPED["inertia"])),
    ("wheel-radii-swapped", "wheel radii exchanged",
     "radii of the wheels exchanged", _table(**_SWAPPED["radii"])),
    ("wheel-masses-swapped", "wheel masses exchanged",
     "masses of the wheels exchanged", _table(**_SWAPPED["masses"])),
    ("wheel-inertia-swapped", "wheel inertias exchanged",
     "inertia of the wheels exchanged", _table(**_SWAPPED["inertia"])),
    ("wheel-bodies-swapped", "wheel masses and inertias exchanged",
     "mass and inertia of the wheels exchanged, radii right",
     _table(**_SWAPPED["masses"], **_SWAPPED["inertia"])),
    ("start-by-front-radius", "start 6/7 too slow: speed divided by the front radius",
     "rear wheel started with v over the front wheel's radius",
     _start_with(rear=lambda v, _: -v / _P["rF"])),
    ("start-of-front-wheel", "start 7/6 too fast: the front wheel was given the rear wheel's rate",
     "u8, which SymBRiM describes as the rear wheel's, started with v over the rear radius",
     _front_wheel_by_its_description()),
    ("d1-by-front-radius", "steer axis offset from the wrong wheel's radius",
     "d1 computed with the front wheel's radius", _also(rear_d1=_lengths(rR=_P["rF"])["rear_d1"])),
    ("offset-by-rear-radius", "fork offset from the wrong wheel's radius",
     "d3 computed with the rear wheel's radius: cos(tilt) times trail, c - rR tan(tilt)",
     _also(front_d3=-np.cos(_P["lam"]) * (_P["c"] - _P["rR"] * np.tan(_P["lam"])))),
    ("no-fork-offset", "no fork offset", "d3 = 0: the steer axis through the front hub",
     _also(front_d3=0.0)),
    ("fork-offset-sign", "fork offset with the other sign", "d3 with the other sign",
     _also(front_d3=-_V["front_d3"])),
    ("trail-sign", "trail with the other sign", "c = -0.08", _table(c=-_P["c"])),
    ("trail-zero", "no trail", "c = 0", _table(c=0.0)),
    ("tilt-of-17-degrees", "another steer axis tilt",
     "tilt of 17 degrees instead of 18", _table(lam=np.deg2rad(17.0))),
    ("gravity-9.8", "gravity 9.8", "g = 9.8", _table(g=9.8)),
    ("gravity-9.80665", "gravity 9.80665", "g = 9.80665", _table(g=9.80665)),
    ("gravity-9.82", "gravity 9.82", "g = 9.82", _table(g=9.82)),
    ("no-spin-inertia", "wheel spin inertia missing", "Iyy of both wheels zero",
     _table(IRyy=0.0, IFyy=0.0)),
    ("no-rear-spin-inertia", "rear wheel spin inertia missing", "Iyy of the rear wheel zero",
     _table(IRyy=0.0)),
    ("rear-wheel-axes", "rear wheel Ixx and Iyy exchanged",
     "Ixx and Iyy of the rear wheel exchanged", _axes_of_wheels("R")),
    ("front-wheel-axes", "front wheel Ixx and Iyy exchanged",
     "Ixx and Iyy of the front wheel exchanged", _axes_of_wheels("F")),
    ("both-wheel-axes", "wheels' Ixx and Iyy exchanged",
     "Ixx and Iyy of both wheels exchanged", _axes_of_wheels("RF")),
    ("wheels-as-discs", "wheels taken as solid discs",
     "inertia of the wheels from mass and radius of a solid disc", _table(
         IRyy=_P["mR"] * _P["rR"] ** 2 / 2, IRxx=_P["mR"] * _P["rR"] ** 2 / 4,
         IFyy=_P["mF"] * _P["rF"] ** 2 / 2, IFxx=_P["mF"] * _P["rF"] ** 2 / 4)),
    ("wheels-as-rings", "wheels taken as rings",
     "inertia of the wheels from mass and radius of a ring", _table(
         IRyy=_P["mR"] * _P["rR"] ** 2, IRxx=_P["mR"] * _P["rR"] ** 2 / 2,
         IFyy=_P["mF"] * _P["rF"] ** 2, IFxx=_P["mF"] * _P["rF"] ** 2 / 2)),
    ("fork-about-axle", "fork inertia about the front axle",
     "inertia of the fork about the front axle taken as that about its centre of mass",
     _about_the_axle()),
    ("rider-height-from-hub", "rear frame centre of mass measured from the hub",
     "l2 from z_B without the height of the hub", _also(
         rear_l1=np.cos(_P["lam"]) * _P["xB"] - np.sin(_P["lam"]) * _P["zB"],
         rear_l2=np.sin(_P["lam"]) * _P["xB"] + np.cos(_P["lam"]) * _P["zB"])),
    ("rider-not-tilted", "rear frame centre of mass not rotated",
     "l1, l2 as the horizontal and vertical distance from the hub",
     _also(rear_l1=_P["xB"], rear_l2=_P["zB"] + _P["rR"])),
    ("fork-centre-not-tilted", "fork centre of mass not rotated",
     "l3, l4 as the horizontal and vertical distance from the hub",
     _also(front_l3=_P["xH"] - _P["w"], front_l4=_P["zH"] + _P["rF"])),
    ("roll-rate-tilted", "roll rate given along the tilted axis",
     "roll rate times the cosine of the tilt, as the frame's own x axis would have it",
     _start_with(roll=lambda _, r: r * np.cos(_P["lam"]))),
    ("roll-rate-from-degrees", "roll rate taken as degrees",
     "roll rate converted from degrees although it is in radians",
     _start_with(roll=lambda _, r: np.deg2rad(r))),
    # The motion is the mirror image of the correct motion. No file can distinguish this mistake
    # from the convention of axes that point to the left.
    ("roll-rate-sign", "convention",
     "roll rate to the left", _start_with(roll=lambda _, r: -r)),
    ("steer-rate-at-start", "steer rate at the start",
     "the steer turns into the fall at the start: steer rate equal to the roll rate",
     _start_with(steer=lambda _, r: r)),
    ("front-wheel-at-rest", "front wheel not turning at the start",
     "u of the front wheel left zero: it slips for the whole run",
     _without_rotation(FRONT_WHEEL)),
    ("rider-58-kg", "another mass of the rear frame", "m_B = 58 instead of 85", _table(mB=58.0)),
    ("wheelbase-1.2", "another wheel base", "w = 1.2 instead of 1.02", _table(w=1.2)),
    ("rider-inertia-typed", "another inertia of the rear frame", "I_Bxx = 2.9 instead of 9.2",
     _table(IBxx=2.9)),
)  # fmt: skip

_CORRECT: tuple[tuple[str, str, Method], ...] = (
    ("dop853-1e-12", "DOP853, rtol = atol = 1e-12", EXACT),
    ("dop853-1e-10", "DOP853, rtol = atol = 1e-10", by.scipy_method("DOP853", 1e-10)),
    ("dop853-1e-8", "DOP853, rtol = atol = 1e-8", by.scipy_method("DOP853", 1e-8)),
    ("dop853-1e-6", "DOP853, rtol = atol = 1e-6", by.scipy_method("DOP853", 1e-6)),
    ("dop853-1e-13", "DOP853, rtol = 1e-13, atol = 1e-15", by.scipy_method("DOP853", 1e-13, 1e-15)),
    ("rk45-1e-6", "RK45, rtol = atol = 1e-6", by.scipy_method("RK45", 1e-6)),
    ("rk45-1e-9", "RK45, rtol = atol = 1e-9", by.scipy_method("RK45", 1e-9)),
    ("rk45-defaults", "RK45, defaults: rtol = 1e-3, atol = 1e-6",
     by.scipy_method("RK45", 1e-3, 1e-6)),
    ("rk23-1e-6", "RK23, rtol = atol = 1e-6", by.scipy_method("RK23", 1e-6)),
    ("lsoda-1e-6", "LSODA, rtol = atol = 1e-6", by.scipy_method("LSODA", 1e-6)),
    ("lsoda-1e-9", "LSODA, rtol = atol = 1e-9", by.scipy_method("LSODA", 1e-9)),
    ("lsoda-1e-12", "LSODA, rtol = atol = 1e-12", by.scipy_method("LSODA", 1e-12)),
    ("radau-1e-6", "Radau, rtol = atol = 1e-6", by.scipy_method("Radau", 1e-6)),
    ("radau-1e-9", "Radau, rtol = atol = 1e-9", by.scipy_method("Radau", 1e-9)),
    ("bdf-1e-7", "BDF, rtol = atol = 1e-7", by.scipy_method("BDF", 1e-7)),
    ("odeint", "odeint, defaults", by.odeint_as_it_comes),
    ("euler-0.001", "Euler, h = 0.001", by.fixed(by.euler, 10)),
    ("euler-0.0005", "Euler, h = 0.0005", by.fixed(by.euler, 20)),
    ("semi-implicit-0.001", "semi-implicit Euler, h = 0.001", by.fixed(by.semi_implicit_euler, 10)),
    ("midpoint-0.005", "midpoint rule, h = 0.005", by.fixed(by.midpoint, 2)),
    ("heun-0.002", "Heun, h = 0.002", by.fixed(by.heun, 5)),
    ("rk4-0.01", "Runge-Kutta 4, h = 0.01", by.fixed(by.runge_kutta_4, 1)),
    ("rk4-0.005", "Runge-Kutta 4, h = 0.005", by.fixed(by.runge_kutta_4, 2)),
    ("ab2-0.002", "Adams-Bashforth 2, h = 0.002", by.adams_bashforth_2(5)),
)  # fmt: skip

RUNS = (
    *(
        Run(f"symbrim-{name}", f"{_PROGRAM}, {words}", "", "correct",
            replace(Setup(), method=method).compute)
        for name, words, method in _CORRECT
    ),
    *(
        Run(f"symbrim-{name}", f"{_PROGRAM}, DOP853, rtol = atol = 1e-12", did, expected,
            setup.compute)
        for name, expected, did, setup in _MISTAKES
    ),
)  # fmt: skip

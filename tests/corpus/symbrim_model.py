"""SymBRiM's Whipple bicycle, with its equations as numerical functions.

SymBRiM follows Moore's convention: rear and front frame have axes whose z is along the steer axis.
Lengths and inertias of Table 1 are therefore converted before they are used.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import sympy as sm
import sympy.physics.mechanics as me
from symbrim.bicycle import (
    FlatGround,
    KnifeEdgeWheel,
    NonHolonomicTire,
    RigidFrontFrame,
    RigidRearFrame,
    WhippleBicycle,
)

from corpus.benchmark import Array


@dataclass(frozen=True)
class Functions:
    """SymBRiM's bicycle as numerical functions; coordinates and speeds are in SymBRiM's order,
    q1..q8 and u1..u8.

    The coordinates are: position of the rear contact point along x and y, yaw, roll, pitch (the
    tilt of the steer axis when upright), rotation of the rear wheel, steer, rotation of the front
    wheel.

    Attributes
    ----------
    symbols
        Names of the parameters, in the order in which the functions take them.
    order
        Index of the speed to which each row of the mass matrix belongs.
    mass_and_forcing
        Mass matrix by rows, then the right-hand side of the equations for the accelerations.
    height
        Height of the front wheel above the floor, which must be zero.
    rolling
        Coefficients of the speeds in the five rolling constraints.
    output
        Kinetic and potential energy, velocity of the rear hub (3) in the global axes, angular
        velocity (3) of the rear frame in its own, its attitude (9).
    """

    symbols: tuple[str, ...]
    order: tuple[int, ...]
    mass_and_forcing: Callable[..., list[float]]
    height: Callable[..., float]
    rolling: Callable[..., Any]
    output: Callable[..., Any]


@cache
def functions() -> Functions:
    """Derive the equations, which takes some ten seconds."""
    bike = WhippleBicycle("bike")
    bike.ground = FlatGround("ground")
    bike.rear_frame, bike.front_frame = RigidRearFrame("rear"), RigidFrontFrame("front")
    bike.rear_wheel, bike.front_wheel = KnifeEdgeWheel("rear_wheel"), KnifeEdgeWheel("front_wheel")
    bike.rear_tire, bike.front_tire = NonHolonomicTire("rear_tire"), NonHolonomicTire("front_tire")
    bike.define_all()
    system = bike.to_system()
    ground, g = bike.ground, sm.Symbol("g")
    system.apply_uniform_gravity(-g * ground.get_normal(ground.origin))
    q, u = list(bike.q), list(bike.u)
    system.q_ind, system.q_dep = [*q[:4], *q[5:]], [q[4]]
    system.u_ind, system.u_dep = [u[3], u[5], u[6]], [*u[:3], u[4], u[7]]
    system.form_eoms(constraint_solver="CRAMER")
    kane = system.eom_method

    t = me.dynamicsymbols._t
    names = [sm.Symbol(f"{letter}{i}") for letter in "qu" for i in range(1, 9)]
    plain = dict(zip([*q, *u], names, strict=True))
    rates = dict(zip([x.diff(t) for x in q], u, strict=True))
    mass, forcing = kane.mass_matrix.xreplace(plain), kane.forcing.xreplace(plain)
    height = system.holonomic_constraints[0]
    conditions = sm.Matrix([height.diff(t), *system.nonholonomic_constraints]).xreplace(rates)
    rolling = conditions.jacobian(sm.Matrix(u)).xreplace(plain)

    frame, bodies = bike.rear_frame.body.frame, system.bodies
    hub = bike.rear_wheel.center.vel(ground.frame).to_matrix(ground.frame)
    spin = frame.ang_vel_in(ground.frame).to_matrix(frame)
    energies = [
        sum(me.kinetic_energy(ground.frame, body) for body in bodies if body is not ground.body),
        # The axis z points down.
        -sum(g * body.mass * body.masscenter.pos_from(ground.origin).dot(ground.frame.z)
             for body in bodies if body is not ground.body),
    ]  # fmt: skip
    wanted = [*energies, *hub, *spin, *ground.frame.dcm(frame)]
    wanted = [sm.sympify(x).xreplace(rates).xreplace(plain) for x in wanted]

    values = (mass.free_symbols | forcing.free_symbols) - set(names)
    values = sorted(values, key=str)
    arguments = (names, values)
    return Functions(
        symbols=tuple(map(str, values)),
        order=tuple(u.index(x) for x in kane.u),
        mass_and_forcing=sm.lambdify(arguments, [*mass, *forcing], "math", cse=True),
        height=sm.lambdify(arguments, height.xreplace(plain), "math", cse=True),
        rolling=sm.lambdify(arguments, rolling.tolist(), "math", cse=True),
        output=sm.lambdify(arguments, wanted, "numpy", cse=True),
    )


def turned(xx: float, zz: float, xz: float, angle: float) -> tuple[float, float, float]:
    """Entries xx, zz and xz of a tensor in axes that are rotated about y by an angle."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    (a, b), (_, d) = turn @ np.array([[xx, xz], [xz, zz]]) @ turn.T
    return float(a), float(d), float(b)


def symbrim_parameters(p: Mapping[str, float]) -> dict[str, float]:
    """SymBRiM's parameters for the values of Table 1.

    The axes of both frames are the global ones, rotated about y by the tilt. The lengths d1, d2, d3
    lead from the rear hub to the steer axis, along it, and to the front hub. The lengths l1 to l4
    lead to the centres of mass.
    """
    c, s = np.cos(p["lam"]), np.sin(p["lam"])

    def own(x: float, z: float) -> tuple[float, float]:
        return float(c * x - s * z), float(s * x + c * z)

    found = {"g": p["g"]}
    # The steer axis meets the floor at x = w + c.
    found["rear_d1"] = own(p["w"] + p["c"], p["rR"])[0]
    across, along = own(p["w"], p["rR"] - p["rF"])
    found["front_d2"], found["front_d3"] = along, across - found["rear_d1"]
    found["rear_l1"], found["rear_l2"] = own(p["xB"], p["zB"] + p["rR"])
    found["front_l3"], found["front_l4"] = own(p["xH"] - p["w"], p["zH"] + p["rF"])
    for letter, body in (("B", "rear"), ("H", "front")):
        entries = turned(p[f"I{letter}xx"], p[f"I{letter}zz"], p[f"I{letter}xz"], p["lam"])
        for name, value in zip(("ixx", "izz", "izx"), entries, strict=True):
            found[f"{body}_{name}"] = value
        found[f"{body}_iyy"], found[f"{body}_body_mass"] = p[f"I{letter}yy"], p[f"m{letter}"]
    for letter, wheel in (("R", "rear_wheel"), ("F", "front_wheel")):
        found[f"{wheel}_mass"], found[f"{wheel}_r"] = p[f"m{letter}"], p[f"r{letter}"]
        found[f"{wheel}_ixx"], found[f"{wheel}_iyy"] = p[f"I{letter}xx"], p[f"I{letter}yy"]
    return found


class Bicycle:
    """The bicycle with the given values of SymBRiM's parameters."""

    def __init__(self, values: Mapping[str, float]) -> None:
        self.f = functions()
        self.values = [values[name] for name in self.f.symbols]

    def upright(self, tilt: float) -> Array:
        """Coordinates of the upright, straight bicycle; the pitch puts the front wheel on the
        floor."""
        q = np.zeros(8)
        q[4] = tilt
        for _ in range(20):
            # Newton's method, with a finite difference as the slope
            here, beside = self._height(q, 0.0), self._height(q, 1e-7)
            q[4] -= here * 1e-7 / (beside - here)
        return q

    def _height(self, q: Array, further: float) -> float:
        at = [*q, *np.zeros(8)]
        at[4] += further
        return self.f.height(at, self.values)

    def speeds(self, q: Array, known: Mapping[int, float]) -> Array:
        """All speeds, computed from three known ones (by index) so that both wheels roll."""
        rolling = np.array(self.f.rolling([*q, *np.zeros(8)], self.values))
        rest = [i for i in range(8) if i not in known]
        u = np.zeros(8)
        u[list(known)] = list(known.values())
        u[rest] = np.linalg.solve(rolling[:, rest], -rolling @ u)
        return u

    def slope(self, _: float, state: Array) -> Array:
        """Rates of the coordinates and of the speeds."""
        found = np.array(self.f.mass_and_forcing(state.tolist(), self.values))
        rates = np.empty(16)
        rates[:8] = state[8:]
        rates[[8 + i for i in self.f.order]] = np.linalg.solve(found[:64].reshape(8, 8), found[64:])
        return rates

    def output(self, states: Array) -> dict[str, Array]:
        """Columns that a user would output, from states of shape (16, rows)."""
        found = [np.broadcast_to(x, states.shape[1:]) for x in self.f.output(states, self.values)]
        q, u, r = states[:8], states[8:], self.values[self.f.symbols.index("rear_wheel_r")]
        front_r = self.values[self.f.symbols.index("front_wheel_r")]
        hub = np.array(found[2:5])
        return {
            "roll": q[3],
            "roll_rate": u[3],
            "speed": hub[0] * np.cos(q[2]) + hub[1] * np.sin(q[2]),
            "potential": found[1],
            "kinetic": found[0],
            "steer": q[6],
            "steer_rate": u[6],
            "pitch": q[4],
            "yaw": q[2],
            "yaw_rate": u[2],
            "speed_contact_global_x": u[0],
            "speed_hub_global_x": hub[0],
            "speed_hub_norm": np.linalg.norm(hub, axis=0),
            "speed_rear_spin": -r * u[5],
            "speed_front_spin": -front_r * u[7],
            "rate_own_x": found[5],
            # These are the Euler angles that SciPy's Rotation.as_euler returns.
            "roll_intrinsic_xyz": np.arctan2(-_steered(found[8:], q[4][0])[5],
                                             _steered(found[8:], q[4][0])[8]),
        }  # fmt: skip


def _steered(attitude: list[Array], tilt: float) -> list[Array]:
    """Attitude matrix (by rows) of axes that are level when the bicycle is upright."""
    c, s = np.cos(tilt), np.sin(tilt)
    back = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    turned_back = np.einsum("ijt,jk->ikt", np.array(attitude).reshape(3, 3, -1), back)
    return list(turned_back.reshape(9, -1))

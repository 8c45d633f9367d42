"""Everything that a program can compute for one state of a bicycle, in any number type.

The module `columns` lists the meaning and the level of each quantity.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import flint

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import (
    Configuration,
    motion_columns,
    named,
    wheel_rates,
    whole_rates,
)
from heyoka_bike.bicycle.instant_columns import ANGLES, LEVELS, MASS_MATRIX, MATRICES
from heyoka_bike.numbers.arithmetic import Number, exact_ball
from heyoka_bike.numbers.dual import Dual, Duals
from heyoka_bike.numbers.vectors import Vector, cross, minus, plus, scaled

Quantities = Mapping[str, Number]

_ROOTS = 1e-50  # maximum width of the enclosures of the eigenvalues


@dataclass(frozen=True, slots=True)
class Instant:
    """A bicycle in a state of motion.

    Attributes
    ----------
    equations : Equations
        Equations of the regular form.
    state, rates
        State variables with the yaw and `whole_motion.INTEGRALS`, and their time derivatives.
    """

    equations: Equations
    state: Sequence[Number]
    rates: Sequence[Number]

    @classmethod
    def of(cls, equations: Equations, state: Sequence[Number]) -> Instant:
        """Return the instant of a state, with rates from the equations."""
        return cls(equations, state, whole_rates(equations, state))

    def columns(self) -> Quantities:
        """Return the columns of the benchmark and of the whole motion, by name."""
        return {
            **self.equations.columns(self.state[:7]),
            **motion_columns(self.equations, self.state),
        }

    def moving(self) -> tuple[Equations, list[Dual]]:
        """Return equations and state as dual numbers, which carry their rates of change."""
        pairs = zip(self.state, self.rates, strict=True)
        return self.equations.over(Duals(self.equations.a)), [Dual(x, (r,)) for x, r in pairs]

    @property
    def speed(self) -> Number:
        """Forward speed [m/s]."""
        return self.equations.k.length * self.state[5]


def quantities(instant: Instant) -> dict[str, Number]:
    """Return the quantities of all `LEVELS` except the last one, by name, in SI units."""
    velocities = _place_velocities(instant)
    masses = instant.equations.masses(instant.state[:3])
    found = {
        **instant.columns(),
        **_geometry(instant.equations),
        "mass": _mass(instant.equations),
        **_velocities(instant, velocities),
        **dict(zip(MASS_MATRIX, masses.values(), strict=True)),
        **_momenta(instant, velocities),
        **_accelerations(instant),
    }
    return {c.name: found[c.name] for level in LEVELS[:-1] for c in level.columns}


def _geometry(equations: Equations) -> Quantities:
    k, b = equations.k, equations.b
    return {
        "steer_axis_down_x": b.sin_tilt,
        "steer_axis_down_z": b.cos_tilt,
        "steer_axis_floor_x": b.rear.pivot_x,
        "rear_hub_to_axis": k.length * k.d1,
        "hubs_along_axis": k.length * k.d2,
        "axis_to_front_hub": k.length * k.d3,
        "mechanical_trail": k.length * (k.front.r * b.sin_tilt - k.d3),
    }


def _mass(equations: Equations) -> Number:
    return equations.a.sum(
        [half.m + half.wheel_m for half in (equations.b.rear, equations.b.front)]
    )


def _velocities(instant: Instant, velocities: Mapping[str, Vector]) -> Quantities:
    found = {
        "pitch_rate": instant.rates[1],
        "rear_wheel_rate": instant.rates[9],
        "front_wheel_rate": instant.rates[10],
    }
    for name, v in velocities.items():
        found |= named(f"{name}_velocity", v)
    return found


def _place_velocities(instant: Instant) -> dict[str, Vector]:
    equations, state = instant.moving()
    places = Configuration.of(equations, state).places()
    found: dict[str, Vector] = {"rear_contact": (instant.rates[7], instant.rates[8], 0)}
    return found | {name: (_slope(x), _slope(y), _slope(z)) for name, (x, y, z) in places.items()}


def _slope(x: Number) -> Number:
    return x.slopes[0] if isinstance(x, Dual) else 0


def _momenta(instant: Instant, velocities: Mapping[str, Vector]) -> Quantities:
    equations, state = instant.equations, instant.state
    b = equations.b
    momentum = scaled(_mass(equations), velocities["com"])
    c = Configuration.of(equations, state)
    places, turning, spins, axes = c.places(), c.turning(), c.spins(), c.attitudes()
    total: Vector = (0, 0, 0)
    for end, half in (("rear", b.rear), ("front", b.front)):
        omega = turning[f"{end}_frame"]
        spinning = (omega[0], spins[f"{end}_wheel"], omega[2])
        own = plus(half.inertia_times(omega), half.wheel_inertia_times(spinning))
        for x, axis in zip(own, axes[f"{end}_frame"], strict=True):
            total = plus(total, scaled(x, axis))
        for name, m in ((f"{end}_frame_com", half.m), (f"{end}_hub", half.wheel_m)):
            arm = minus(places[name], places["com"])
            moving = minus(velocities[name], velocities["com"])
            total = plus(total, scaled(m, cross(arm, moving)))
    return {**named("momentum", momentum), **named("angular_momentum", total)}


def _accelerations(instant: Instant) -> Quantities:
    equations, state = instant.moving()
    o, u = equations.unfold(state)
    rear, front = wheel_rates(equations.k, u)
    return {
        "roll_acceleration": instant.rates[3],
        "steer_acceleration": instant.rates[4],
        "forward_acceleration": equations.k.length * instant.rates[5],
        "pitch_acceleration": _slope(u.q - u.nu),
        "yaw_acceleration": _slope(u.n / o.cos_roll),
        "rear_wheel_acceleration": _slope(rear),
        "front_wheel_acceleration": _slope(front),
    }


def linear_quantities(
    matrices: Mapping[str, Number], g: flint.arb, speed: Fraction
) -> dict[str, flint.arb]:
    """Return the quantities of the last level, at a forward speed [m/s]; see `linear.matrices`.

    The eigenvalues are ordered by real, then by imaginary part. They are NaN if they cannot be
    separated.
    """
    found = {
        f"{name}_{row}_{by}": matrices[name][i][j]
        for name in MATRICES
        for (i, row), (j, by) in product(enumerate(ANGLES), repeat=2)
    }
    v = exact_ball(speed)
    (m, c1, k0, k2) = (matrices[name] for name in MATRICES)
    entries = [
        [flint.acb_poly([g * k0[i][j] + v * v * k2[i][j], v * c1[i][j], m[i][j]]) for j in (0, 1)]
        for i in (0, 1)
    ]
    quartic = entries[0][0] * entries[1][1] - entries[0][1] * entries[1][0]
    try:
        roots = quartic.roots(_ROOTS)
    except ValueError:
        # If roots cannot be separated, set all of them to NaN. An example is a bicycle at rest
        # without gravity.
        roots = [flint.acb("nan")] * 4
    # If a box about the real axis contains exactly one root of a real polynomial, the root is real:
    # its imaginary part is exactly zero.
    parts = [
        (z.real, flint.arb(0) if z.is_finite() and z.imag.contains(0) else z.imag) for z in roots
    ]
    parts.sort(key=lambda z: (round(float(z[0]), 9), float(z[1])))
    for n, (real, imaginary) in enumerate(parts, start=1):
        found |= {f"eigenvalue_{n}_re": real, f"eigenvalue_{n}_im": imaginary}
    return found

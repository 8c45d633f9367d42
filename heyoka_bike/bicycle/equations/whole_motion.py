"""The columns of motion.h5 from the state, in any number type.

What each column means is in `columns`.
"""

from collections.abc import Sequence

import flint

from heyoka_bike.bicycle.equations.configuration import INTEGRALS, Configuration
from heyoka_bike.bicycle.equations.forces import Forces, forces
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.motion_columns import DENSE_COLUMNS, MOTION_COLUMNS
from heyoka_bike.numbers.arithmetic import Balls, Number
from heyoka_bike.numbers.vectors import Vector


class NonnegativeRoots(Balls):
    """Ball arithmetic in which no radicand is negative, even where its ball reaches below zero.

    The only root of `motion_columns` is that of the squares of a tangential force.
    """

    def sqrt(self, x: flint.arb) -> flint.arb:
        root: flint.arb = super().sqrt(x)
        if root.is_finite():
            return root
        half = x.upper().sqrt() / 2
        return flint.arb(half, half.upper())


def motion_columns(equations: Equations, state: Sequence[Number]) -> dict[str, Number]:
    """Every column of `MOTION_COLUMNS` by name, SI units.

    Parameters
    ----------
    equations : Equations
    state
        Of their form, with the yaw, and then `configuration.INTEGRALS`.
    """
    f, a = forces(equations, state), equations.a
    found = _dense(Configuration.of(equations, state), f, state)
    found |= {"rear_friction": f.rear.friction(a), "front_friction": f.front.friction(a)}
    return {c.name: found[c.name] for c in MOTION_COLUMNS}


def dense_columns(equations: Equations, state: Sequence[Number]) -> list[Number]:
    """`motion_columns` of `DENSE_COLUMNS` only: analytic functions, with no root of a force."""
    found = _dense(Configuration.of(equations, state), forces(equations, state), state)
    return [found[name] for name in DENSE_COLUMNS]


def _dense(c: Configuration, f: Forces, state: Sequence[Number]) -> dict[str, Number]:
    found = dict(zip(INTEGRALS, state[7:], strict=True))
    for name, v in c.places().items():
        found |= _named(name, v)
    for name, v in c.turning().items():
        found |= _named(f"{name}_omega", v)
    for name, q in c.quaternions().items():
        found |= {f"{name}_q{i}": x for i, x in enumerate(q)}
    for name, columns in c.attitudes().items():
        for j, axis in enumerate(columns, start=1):
            found |= {f"{name}_r{i}{j}": x for i, x in enumerate(axis, start=1)}
    found |= {f"{name}_omega_y": x for name, x in c.spins().items()}
    for end, contact in (("rear", f.rear), ("front", f.front)):
        found |= {
            f"{end}_normal_force": contact.normal,
            f"{end}_longitudinal_force": contact.longitudinal,
            f"{end}_lateral_force": contact.lateral,
        }
    for name, joint in (
        ("rear_axle", f.rear_axle), ("front_axle", f.front_axle), ("steer_joint", f.steer)
    ):  # fmt: skip
        found |= _named(f"{name}_force", joint.force) | _named(f"{name}_moment", joint.moment)
    return found


def _named(name: str, v: Vector) -> dict[str, Number]:
    return {f"{name}_{axis}": x for axis, x in zip("xyz", v, strict=True)}

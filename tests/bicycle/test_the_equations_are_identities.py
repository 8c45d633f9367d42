"""The equations of the package are those of Newton and Euler, identically.

They agree as rational functions of the 26 parameters, of the angles (by tangents) and of the
speeds, not only at sample states. Each run draws a new prime of 512 bits and a new point (see
`oracles.random_field`). An equation that passes is an identity, except with a probability below
`OVERLOOKED`, which follows from counted degrees.

States have both wheels on the floor. Roll, pitch, steer and tilt are free; kappa, which makes the
cosine of the front lean, is an adjoined root; the wheel base is what puts the front wheel on the
floor then,

    rF kappa = rR + d1 sin(beta) - d2 cos(beta) + d3 y        (see `kinematics`),

in which it has the factor sin(pitch). States with zero pitch are limits of others, and there the
identities hold by continuity.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import chain
from types import ModuleType
from typing import Any

import pytest

from generators.sign_flips import Flip, changed, flips
from heyoka_bike.bicycle.equations import (
    bodies,
    constants,
    forces,
    kinematics,
    model,
    outputs,
    whole_motion,
)
from heyoka_bike.bicycle.equations.kinematics import front_contact_height
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS
from heyoka_bike.numbers import vectors
from heyoka_bike.numbers.dual import Dual, Duals
from oracles.random_field import Element, RandomField, UnknownRootError, differences
from support.two_models import (
    Both,
    from_the_columns,
    from_the_few_product_form,
    from_the_integrals,
    from_the_regular_form,
    from_the_whole_motion,
)

OVERLOOKED = Fraction(1, 10**140)
"""Probability of missing a false equation: the degrees are below 3 million, and the prime has 154
digits."""

Zero = tuple[str, Element]
"""Name of a comparison, and its difference."""


@dataclass(frozen=True)
class Unknown:
    """A substitute for an exact parameter."""

    rational: Any
    is_zero: bool = False


@dataclass(frozen=True)
class AnyBicycle:
    """A substitute for a bicycle, with unknown parameters."""

    values: dict[str, Unknown]

    def __getitem__(self, symbol: str) -> Unknown:
        return self.values[symbol]


def any_bicycle(field: RandomField, **known: Any) -> AnyBicycle:
    values = {symbol: field.unknown() for symbol in PARAMETERS} | {"lam": field.angle()} | known
    return AnyBicycle({symbol: Unknown(x) for symbol, x in values.items()})


@pytest.fixture(scope="module")
def field() -> RandomField:
    return RandomField()


@pytest.fixture(scope="module")
def both(field: RandomField) -> Both:
    """Return any state on the floor of any bicycle."""
    roll, pitch, steer, yaw, tilt = (field.angle() for _ in range(5))
    beta = pitch + tilt
    y = steer.cos * beta.sin - steer.sin * (roll.sin / roll.cos)
    kappa = field.adjoin_root(y * y + beta.cos * beta.cos)
    field.roots += [roll.cos, roll.cos * kappa]
    r, r_f, c = (field.unknown() for _ in range(3))
    d3 = r_f * tilt.sin - c * tilt.cos
    rest_of_d1 = c * tilt.cos - r * tilt.sin
    rest_of_d2 = (r - r_f) * tilt.cos
    w = r_f * kappa - r - rest_of_d1 * beta.sin + rest_of_d2 * beta.cos - d3 * y
    bicycle: Any = any_bicycle(field, rR=r, rF=r_f, c=c, lam=tilt, w=w / pitch.sin)
    roll_rate, steer_rate, speed = (field.unknown() for _ in range(3))
    return Both.of(
        bicycle, field, field, yaw, roll=roll, pitch=pitch, steer=steer,
        roll_rate=roll_rate, steer_rate=steer_rate, speed=speed,
    )  # fmt: skip


def newton_and_euler(both: Both) -> Iterator[Zero]:
    """Yield differences of both forms, every column, integrand and force from the oracle's."""
    for name, part in {
        "regular": from_the_regular_form,
        "few products": from_the_few_product_form,
        "columns": from_the_columns,
        "integrals": from_the_integrals,
        "whole motion, regular": partial(from_the_whole_motion, is_regular=True),
        "whole motion, few products": partial(from_the_whole_motion, is_regular=False),
    }.items():
        for what, (found, expected) in part(both).items():
            for x in differences(found, expected):
                yield f"{name}: {what}", x


def conserved(both: Both) -> Iterator[Zero]:
    """Yield rates of the energy and of the front wheel's height, and that height."""
    duals = Duals(both.a)
    for form, state in (("regular", both.regular_state), ("few products", both.few_product_state)):
        equations = Equations.of(both.bicycle, both.a, is_regular=form == "regular")
        rates = equations.rates(state)
        moving = [Dual(x, (rate,)) for x, rate in zip(state, rates, strict=True)]
        e = equations.over(duals).energies(moving)
        height = front_contact_height(equations.k, duals, *moving[:3])
        yield f"{form}: energy's rate", e.total.slopes[0]
        yield f"{form}: height", height.value
        yield f"{form}: height's rate", height.slopes[0]


def mirrored(both: Both) -> Iterator[Zero]:
    """Yield rates at a mirrored state, less the mirrored rates, in both forms."""
    signs = (-1, 1, -1, -1, -1, 1)  # order: roll, pitch, steer, the two rates of either form, spin
    for form, state in (("regular", both.regular_state), ("few products", both.few_product_state)):
        equations = Equations.of(both.bicycle, both.a, is_regular=form == "regular")
        image = [x if sign > 0 else -x for sign, x in zip(signs, state, strict=True)]
        pairs = zip(signs, equations.rates(state), equations.rates(image), strict=True)
        for name, (sign, rate, there) in zip(equations.states, pairs, strict=False):
            yield f"{form}: {name}", there - sign * rate


def straight_running(field: RandomField) -> Iterator[Zero]:
    """Yield rates of upright straight running at any speed, and the front wheel's height."""
    bicycle: Any = any_bicycle(field)
    zero, nought = field.zero_angle(), field.number(0)
    state = [zero, zero, zero, nought, nought, field.unknown()]
    for is_regular in (True, False):
        equations = Equations.of(bicycle, field, is_regular=is_regular)
        yield from zip(equations.states, equations.rates_with_yaw(state), strict=True)
        yield "height", front_contact_height(equations.k, field, zero, zero, zero)


def false(found: Iterable[Zero]) -> list[str]:
    """Return names of the equations that are false."""
    return [name for name, x in found if not x.is_zero]


def check(field: RandomField, zeros: Iterable[Zero]) -> None:
    found = list(zeros)
    assert false(found) == [], f"modulo {field.prime}"
    roots = sum(map(field.missed, field.assumed))
    assert max(field.missed(x) for _, x in found) + roots < OVERLOOKED


def test_everything_is_what_newton_and_euler_say(field: RandomField, both: Both) -> None:
    check(field, newton_and_euler(both))


def test_energy_is_constant_and_both_wheels_stay_on_the_floor(
    field: RandomField, both: Both
) -> None:
    check(field, conserved(both))


def test_the_mirror_image_of_a_motion_is_a_motion(field: RandomField, both: Both) -> None:
    check(field, mirrored(both))


def test_straight_running_is_a_solution() -> None:
    field = RandomField()
    field.roots.append(field.number(1))  # the cosine of the front lean
    check(field, straight_running(field))


WRONG = [
    (model, "w1 * h2 - q * h1", "w1 * h2 + q * h1"),
    (model, "h1 = b.i11 * w1 + b.i13 * w3", "h1 = b.i11 * w1"),
    (model, "push = b.m * side_speed", "push = b.m * side_speed + v / 10**60"),
    (outputs, "+ b.i22 * q * q", "+ b.i22 * q * q + w1 * q / 10**60"),
    (constants, "xz -= part_mass * dx * dz", "xz += part_mass * dx * dz"),
]
"""A sign, a missing inertia product, two tiny terms, and an inertia of another body."""


@pytest.mark.parametrize(("module", "old", "new"), WRONG, ids=[old for _, old, _ in WRONG])
def test_a_wrong_term_is_no_identity(both: Both, module: ModuleType, old: str, new: str) -> None:
    with changed(module, old, new).applied():
        assert false(newton_and_euler(renewed(both)))


@pytest.mark.parametrize(("module", "old", "new"), [WRONG[i] for i in (0, 2, 3)])
def test_a_wrong_term_costs_energy(both: Both, module: ModuleType, old: str, new: str) -> None:
    """The other changes give bicycles with workless forces, or with other bodies."""
    with changed(module, old, new).applied():
        assert any("energy" in name for name in false(conserved(both)))


@pytest.mark.parametrize(
    ("name", "old"),
    [("regular", "beta_rate = u.q - u.nu"), ("few products", "return [u.p, u.q - u.nu")],
)
def test_a_pitch_that_drifts_lifts_the_front_wheel(both: Both, name: str, old: str) -> None:
    with changed(model, old, f"{old} + u.p / 10**60").applied():
        assert f"{name}: height's rate" in false(conserved(both))


EQUIVALENT = "p['mB'] + p['mR']"
"""A change of the unit of mass only: the motion does not depend on it."""


@pytest.mark.proof
@pytest.mark.parametrize(
    "module",
    [bodies, constants, forces, kinematics, model, outputs, vectors, whole_motion],
    ids=lambda module: module.__name__.rpartition(".")[2],
)
def test_every_plus_and_minus_matters(both: Both, module: ModuleType) -> None:
    unnoticed = [flip.text for flip in flips(module) if not noticed(both, flip)]
    assert [text for text in unnoticed if not text.endswith(EQUIVALENT)] == []


def renewed(both: Both) -> Both:
    """Return both with constants computed again, after the package's code has changed."""
    return replace(both, k=constants.constants(both.bicycle, both.a))


def noticed(both: Both, flip: Flip) -> bool:
    with flip.applied():
        wrong = renewed(both)
        try:
            return any(not x.is_zero for _, x in chain(newton_and_euler(wrong), conserved(wrong)))
        except (UnknownRootError, TypeError):  # a wrench cannot be subtracted
            return True

"""Phrases about causes and the values that explain a file, for the sentences of `conclusions`."""

import re
from collections.abc import Mapping, Sequence
from math import floor, log10

from heyoka_bike.bicycle.parameters import PARAMETERS
from heyoka_bike.reference.structure import UNKNOWNS
from heyoka_bike.scoring.diagnosis.programs.forces import FORCES
from heyoka_bike.scoring.diagnosis.programs.program import Cause, FittedValue
from heyoka_bike.scoring.evidence.words import short_number, unit_text
from heyoka_bike.scoring.findings import together
from heyoka_bike.scoring.grades import TOLERANCE

UNIT_OF_VALUE = {**UNKNOWNS, **{name: force.unit for name, force in FORCES.items()}}
"""Unit of each parameter, initial value and force."""

# An uncertainty below this fraction of the value is not shown.
_LEAST_UNCERTAINTY_SHOWN = 1e-6
# A term counts as wholly missing if the fitted missing fraction differs from 1 by at most this
# much.
_NEARLY_ALL = 0.02
_INERTIA = re.compile(r"I([BH])(xx|yy|zz|xz)")
_BODIES = {"B": "rear frame", "H": "fork"}
_COUNTS = {1: "one", 2: "two", 3: "three"}


def mistakes_words(mistakes: Sequence[Cause]) -> str:
    """Describe some causes, each by its fitted values or by what the program does."""
    return _listed([_values_words(m.found) if m.found else m.says for m in mistakes])


def count_words(found: Sequence[FittedValue]) -> str:
    """Say how many parameters, forces or terms explain an error, as "two forces explain"."""
    if len(found) not in _COUNTS:
        return "these explain"
    nouns = {_noun(x) for x in found}
    noun = nouns.pop() if len(nouns) == 1 else "cause"
    return f"{_COUNTS[len(found)]} {noun}" + (" explains" if len(found) == 1 else "s explain")


def share_words(share: float) -> str:
    """Format a relative error, as "0.3 %"."""
    return f"{short_number(100 * share)} %"


def with_words(mistakes: Sequence[Cause]) -> str:
    """Refer to some causes that a sentence has described, as "this mistake" or "these values"."""
    found = [x for m in mistakes for x in m.found if not _is_part(x)]
    is_of_values = all(m.found and not any(map(_is_part, m.found)) for m in mistakes)
    if is_of_values:
        return "this value" if len(found) == 1 else "these values"
    count = sum(max(len(m.found), 1) for m in mistakes)
    return "this mistake" if count == 1 else "these mistakes"


def relief_words(mistakes: Sequence[Cause], relief: float) -> str:
    """Say by which factor a simulation with causes is nearer to a file than the exact motion."""
    return (
        f"A simulation with {with_words(mistakes)} agrees with the file "
        f"{short_number(relief, 1)} times better than the exact motion does"
    )


def equation_words(name: str) -> str:
    """Name an equation of motion: "the roll equation"."""
    return "the equation of the forward speed" if name == "speed" else f"the {name} equation"


def accelerations_words(shares: Mapping[str, float]) -> str:
    """List relative errors of accelerations, as "0.3 % (roll) and 2.1 % (steer)"."""
    return together(
        [
            f"{share_words(share)} ({'forward speed' if name == 'speed' else name})"
            for name, share in shares.items()
        ]
    )


def inertia_words(found: Sequence[FittedValue]) -> str:
    """Describe the pattern in several wrong inertias of one body; empty string if there is none."""
    by_axes = {m[2]: x for x in found if (m := _INERTIA.fullmatch(x.name))}
    if len(by_axes) < len(found) or not {"xx", "zz"} <= by_axes.keys():
        return ""
    bodies = {x.name[1] for x in found}
    if len(bodies) > 1:
        return ""
    body = _BODIES[bodies.pop()]
    xx, zz = by_axes["xx"], by_axes["zz"]
    right = xx.right + zz.right
    if abs(xx.value + zz.value - right) < TOLERANCE * right:
        return (
            f". The sum of Ixx and Izz is right, as if the inertia of the {body}, or of a part of "
            "it, were rotated"
        )
    if _are_of_masses_moved(by_axes):
        return (
            f". All these inertias are too small, as if those of the {body}'s parts were added "
            "without moving them to the common centre of mass"
        )
    return ""


def _are_of_masses_moved(by_axes: Mapping[str, FittedValue]) -> bool:
    """True if inertias of one body are too small as if masses in its plane lay nearer together.

    The entries of the tensor that are missing then are sums of m dz^2, m dx^2 and m dx dz. So xz is
    limited by the other two (the inequality of Cauchy and Schwarz), and yy falls, too.
    """
    lost = {axes: x.right - x.value for axes, x in by_axes.items()}
    xx, zz = lost["xx"], lost["zz"]
    is_of_plane = lost.get("yy", xx + zz) > 0.0
    most = (1.0 + TOLERANCE) * xx * zz
    return xx > 0.0 and zz > 0.0 and is_of_plane and lost.get("xz", 0.0) ** 2 <= most


def _noun(x: FittedValue) -> str:
    """Say if a value is a parameter, an initial value, a force or a term of the equations."""
    force = FORCES.get(x.name)
    if force is None or force.is_property:
        return "parameter" if x.maneuver is None else "initial value"
    return "term" if force.is_part else "force"


def _is_part(x: FittedValue) -> bool:
    """True if a value is the missing fraction of a term of the equations."""
    return x.name in FORCES and FORCES[x.name].is_part


def _values_words(found: Sequence[FittedValue]) -> str:
    return _listed([_part_words(x) if _is_part(x) else _value_words(x) for x in found])


def _listed(clauses: Sequence[str]) -> str:
    """Join clauses, as "a, and b" or "a, b, and c"."""
    *first, last = clauses
    return f"{', '.join(first)}, and {last}" if first else last


def _part_words(x: FittedValue) -> str:
    """Describe the fraction of a term of the equations that a program contains."""
    says = FORCES[x.name].says
    is_missing = abs(x.value - 1.0) < _NEARLY_ALL
    times = "is missing" if is_missing else f"is {1.0 - x.value:.4g} times what it should be"
    return f"the {says} {times}"


def _value_words(x: FittedValue) -> str:
    """Format a value with the digits that its uncertainty allows, and the correct value."""
    size = max(abs(x.value), abs(x.right), abs(x.value - x.right))
    least = max(x.uncertain, _LEAST_UNCERTAINTY_SHOWN * size)
    decimals = max(1, -floor(log10(least))) if least else 1
    after = f"{round(x.value, decimals) + 0.0:.{decimals}f}".rstrip("0").rstrip(".")
    # Show no uncertainty if it is as small as roundoff, or if the value hardly affects the error.
    is_known = _LEAST_UNCERTAINTY_SHOWN * size < x.uncertain < abs(x.right) + abs(x.value - x.right)
    within = f" (+- {x.uncertain:.1g})" if is_known else ""
    right = f"{round(x.right, 12) + 0.0:.10g}"
    if after == right:
        # With the digits that its uncertainty allows, the value equals the correct one. So show
        # more digits.
        after = f"{x.value:.10g}"
    return f"{_name_words(x)} is {after} {_unit_words(x.name)}{within} instead of {right}"


def _unit_words(name: str) -> str:
    """Return the unit of a value; a torsional stiffness includes the radian, which is 1 in SI."""
    unit = unit_text(UNIT_OF_VALUE[name])
    return f"{unit}/rad" if name in ("steer_stiffness", "roll_stiffness") else unit


def _name_words(x: FittedValue) -> str:
    if x.name in FORCES:
        return f"the {FORCES[x.name].says}"
    if x.maneuver is None:
        return f"the {PARAMETERS[x.name].description} ({x.name})"
    return f"the {x.name.replace('_', ' ')} of maneuver {x.maneuver}"

"""Units as people write them, ``kg mm^2`` or ``deg/s``, and their exact size in SI units."""

import re
from collections.abc import Mapping
from fractions import Fraction

from heyoka_bike.numbers.exact import Exact

_Size = tuple[Fraction, int, tuple[int, int, int]]
"""A fraction times a power of pi, and the powers of m, kg and s."""

_ONE: _Size = (Fraction(1), 0, (0, 0, 0))


def _size(factor: str, *powers: int, pi: int = 0) -> _Size:
    return Fraction(factor), pi, (powers[0], powers[1], powers[2])


_LENGTH, _MASS, _TIME, _FORCE, _ENERGY = (
    (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, -2), (2, 1, -2)
)  # fmt: skip
_UNITS: Mapping[str, _Size] = {
    "1": _ONE,
    "rad": _ONE,
    **dict.fromkeys(("deg", "degree", "degrees", "\u00b0"), _size("1/180", 0, 0, 0, pi=1)),
    "mrad": _size("1/1000", 0, 0, 0),
    **{f"{p}m": _size(x, *_LENGTH) for p, x in (("", "1"), ("m", "1/1000"), ("c", "1/100"))},
    "km": _size("1000", *_LENGTH),
    "in": _size("0.0254", *_LENGTH),
    "kg": _size("1", *_MASS),
    "g": _size("1/1000", *_MASS),
    "t": _size("1000", *_MASS),
    "s": _size("1", *_TIME),
    "ms": _size("1/1000", *_TIME),
    "min": _size("60", *_TIME),
    "h": _size("3600", *_TIME),
    "N": _size("1", *_FORCE),
    "kN": _size("1000", *_FORCE),
    "J": _size("1", *_ENERGY),
    "kJ": _size("1000", *_ENERGY),
    "mJ": _size("1/1000", *_ENERGY),
}
_FACTOR = re.compile(r"\s*([*\u00b7./]?)\s*([A-Za-z\u00b0]+|1)(?:\*\*|\^)?([-+]?[0-9]+)?")
_SUPERSCRIPTS = str.maketrans("\u00b2\u00b3\u207b\u00b9", "23-1")


def size(unit: str) -> _Size | None:
    """The size of a unit and its dimension; None if it is not understood.

    An angle has no dimension, and rad is 1.
    """
    text, at = unit.strip().translate(_SUPERSCRIPTS), 0
    factor, pi, powers = _ONE
    while at < len(text):
        match = _FACTOR.match(text, at)
        if match is None or match[2] not in _UNITS:
            return None
        power = int(match[3] or 1) * (-1 if match[1] == "/" else 1)
        if abs(power) > 9:
            return None
        one, half_turns, dimension = _UNITS[match[2]]
        factor, pi, at = factor * one**power, pi + half_turns * power, match.end()
        powers = tuple(p + q * power for p, q in zip(powers, dimension, strict=True))  # type: ignore[assignment]
    return (factor, pi, powers) if text else None


def factor(unit: str, si: str) -> Exact | None:
    """What a value in a unit is multiplied by to be in the SI unit.

    None if the unit is not understood, or measures something else.
    """
    own, wanted = size(unit), size(si)
    if own is None or wanted is None or own[2] != wanted[2] or own[1] not in (0, 1):
        return None
    zero = Fraction(0)
    return Exact(zero, own[0]) if own[1] else Exact(own[0] / wanted[0])

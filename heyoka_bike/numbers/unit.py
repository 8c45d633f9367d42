"""Units as people write them (``kg mm^2``, ``deg/s``) and their exact size in SI units."""

import re
from collections.abc import Mapping
from fractions import Fraction

from heyoka_bike.numbers.exact import Exact

_Size = tuple[Fraction, int, tuple[int, int, int]]
"""A fraction times a power of pi, and the powers of m, kg and s."""

_SIZE_OF_ONE: _Size = (Fraction(1), 0, (0, 0, 0))


def _size(factor: str, *powers: int, pi: int = 0) -> _Size:
    return Fraction(factor), pi, (powers[0], powers[1], powers[2])


_OF_ANGLE, _OF_LENGTH, _OF_MASS, _OF_TIME, _OF_SPEED, _OF_FORCE, _OF_ENERGY, _OF_POWER = (
    (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, -1), (1, 1, -2), (2, 1, -2), (2, 1, -3)
)  # fmt: skip
_PREFIXES = {"": "1", "u": "1e-6", "m": "1e-3", "c": "1e-2", "k": "1e3", "M": "1e6"}
_UNITS_WITH_PREFIXES = {
    "rad": _OF_ANGLE,
    "m": _OF_LENGTH,
    "s": _OF_TIME,
    "N": _OF_FORCE,
    "J": _OF_ENERGY,
    "W": _OF_POWER,
}
UNITS: Mapping[str, _Size] = {
    "1": _SIZE_OF_ONE,
    **{
        f"{p}{name}": _size(x, *of)
        for name, of in _UNITS_WITH_PREFIXES.items()
        for p, x in _PREFIXES.items()
    },
    **dict.fromkeys(("deg", "degree", "degrees", "\u00b0"), _size("1/180", *_OF_ANGLE, pi=1)),
    "arcminute": _size("1/10800", *_OF_ANGLE, pi=1),
    "arcsecond": _size("1/648000", *_OF_ANGLE, pi=1),
    "grade": _size("1/200", *_OF_ANGLE, pi=1),
    "revolution": _size("2", *_OF_ANGLE, pi=1),
    **dict.fromkeys(("in", "inch"), _size("0.0254", *_OF_LENGTH)),
    "foot": _size("0.3048", *_OF_LENGTH),
    "mile": _size("1609.344", *_OF_LENGTH),
    "kg": _size("1", *_OF_MASS),
    "g": _size("1/1000", *_OF_MASS),
    "t": _size("1000", *_OF_MASS),
    "ns": _size("1e-9", *_OF_TIME),
    "min": _size("60", *_OF_TIME),
    "h": _size("3600", *_OF_TIME),
    "knot": _size("1852/3600", *_OF_SPEED),
    "kgf": _size("9.80665", *_OF_FORCE),
    "lbf": _size("4.4482216152605", *_OF_FORCE),
    # The thermochemical calorie, as in UDUNITS. The calorie of the steam tables is 0.07 % larger.
    "cal": _size("4.184", *_OF_ENERGY),
    "kcal": _size("4184", *_OF_ENERGY),
    # The International Table value of the British thermal unit (ISO 80000-5).
    "BTU": _size("1055.05585262", *_OF_ENERGY),
    "erg": _size("1e-7", *_OF_ENERGY),
    "eV": _size("1.602176634e-19", *_OF_ENERGY),
}
_FACTOR = re.compile(r"\s*([*\u00b7./]?)\s*([A-Za-z\u00b0]+|1(?![0-9]))(?:\*\*|\^)?([-+]?[0-9]+)?")
_SUPERSCRIPTS = str.maketrans("\u00b2\u00b3\u207b\u00b9", "23-1")


def size(unit: str) -> _Size | None:
    """Return the size of a unit and its dimension; None if the unit is not known.

    Angles are dimensionless, and rad is 1.
    """
    text, at = unit.strip().translate(_SUPERSCRIPTS), 0
    factor, pi, powers = _SIZE_OF_ONE
    while at < len(text):
        match = _FACTOR.match(text, at)
        if match is None or match[2] not in UNITS:
            return None
        power = int(match[3] or 1) * (-1 if match[1] == "/" else 1)
        if abs(power) > 9:
            return None
        one, half_turns, dimension = UNITS[match[2]]
        factor, pi, at = factor * one**power, pi + half_turns * power, match.end()
        powers = tuple(p + q * power for p, q in zip(powers, dimension, strict=True))  # type: ignore[assignment]
    return (factor, pi, powers) if text else None


def factor(unit: str, si: str) -> Exact | None:
    """Return the factor from a unit to the SI unit.

    None if the unit is not understood, or measures something else.
    """
    own, wanted = size(unit), size(si)
    if own is None or wanted is None or own[2] != wanted[2] or own[1] not in (0, 1):
        return None
    zero = Fraction(0)
    return Exact(zero, own[0]) if own[1] else Exact(own[0] / wanted[0])

"""Parse the units in the names of columns, in the many forms in which people write them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache

from heyoka_bike.numbers.unit import UNITS as WORDS
from heyoka_bike.numbers.unit import factor, size
from heyoka_bike.scoring.units import UNITS

UNITS_OF_TIME = ("s", "ms", "us", "ns", "min", "h")
"""Units in which times are read."""

_QUANTITIES = {"s": UNITS_OF_TIME, **{si: units for si, units in UNITS.items() if si != "1"}}
"""Usual units of each quantity, by its SI unit."""

_SPELLINGS: Mapping[str, tuple[str, ...]] = {
    "rad": ("radian",),
    "degree": ("deg", "\u00b0"),
    "revolution": ("rev", "turn"),
    "arcminute": ("arcmin",),
    "arcsecond": ("arcsec",),
    "grade": ("gon", "grad", "gradian"),
    "m": ("meter", "metre"),
    "inch": ("in", "inches"),
    "foot": ("ft", "feet"),
    "mile": ("mi",),
    "s": ("sec", "second"),
    "min": ("minute",),
    "h": ("hr", "hour"),
    "N": ("newton",),
    "lbf": ("lb",),
    "J": ("joule",),
    "W": ("watt",),
    "cal": ("calorie",),
    "kcal": ("kilocalorie",),
    "eV": ("electronvolt",),
    "knot": ("kt",),
    "m/s": ("mps",),
    "km/h": ("kmh", "kph"),
    "foot/s": ("fps",),
    "inch/s": ("ips",),
    "mile/h": ("mph",),
    "rad/s": ("rads",),
    "degree/s": ("dps", "degs"),
    "revolution/s": ("rps",),
    "revolution/min": ("rpm", "r/min"),
}
"""Other spellings of units, in small letters, without the s of a plural."""

_PRODUCTS = ("W h", "kW h", "MN m", "N m", "kN m", "mN m", "N mm", "N cm", "kg m")
"""Units that some people write without the blank."""

_WORDS: Mapping[str, str] = {
    # Some programs write units only in capitals, or only in small letters. MJ means megajoule if it
    # is written with these capitals.
    **{unit.lower(): unit for unit in reversed([*WORDS])},
    **{unit: unit for unit in WORDS},
    **{spelling: unit for unit, spellings in _SPELLINGS.items() for spelling in spellings},
    **{unit.replace(" ", "").lower(): unit for unit in _PRODUCTS},
    "MNm": "MN m",
    **{
        f"{prefix}{spelling}": f"{short}{unit}"
        for prefix, short in (("kilo", "k"), ("milli", "m"), ("micro", "u"), ("mega", "M"))
        for unit in ("rad", "s", "N", "J")
        for spelling in _SPELLINGS[unit]
    },
}
BRACKETS = re.compile(r"\[[^][]*\]|\([^()]*\)|(?<!\\dot)\{[^{}]*\}")
"""Brackets in a name, with their content, but not the braces of TeX's ``\\dot{\\phi}``."""

_OPEN_BRACKET, _CLOSING_BRACKET = re.compile(r"[\[({]"), re.compile(r"[\])}]")
_NO_UNITS = ("si", "none", "n/a")
_ANY_LETTER = re.compile(r"[^\W\d_]")
# A bare number in brackets is the number of a maneuver or an index, not the exponent of a unit.
_NUMBER_ALONE = re.compile(r"^\W*(?:m|man|maneuver|manoeuvre)?[\s_-]*[0-9]+\W*$", re.IGNORECASE)
_ONE_WORD = re.compile(r"r/min|[A-Za-z\u00b0]+")
# Characters that stand in place of the degree sign: the ordinal indicator, the ring, the
# replacement of an invalid byte, and UTF-8 that was read as Latin-1.
_UNIT_MARKS = str.maketrans(dict.fromkeys("[](){}") | {
    "\u00ba": "\u00b0", "\u02da": "\u00b0", "\ufffd": "\u00b0", "\u00c2": None,
    "\u00b5": "u", "\u03bc": "u", "\u2212": "-", "\u22c5": "*", "_": " ",
})  # fmt: skip
_DIVIDED = re.compile(r"\s*/\s*(\w+)")
_PER = re.compile(r"\bper\b")
_HYPHEN = re.compile(r"(?<=[A-Za-z])-(?=[A-Za-z])")
# A letter with a number, such as m1 or s2, is an index and not a power of a metre or a second.
_INDEXED = re.compile(r"[A-Za-z]+[0-9]+")
# End of the unit s^-1 with underscores in place of ^ and -.
_POWER = re.compile(r"_+1$")
_BEFORE_POWER = re.compile(r" +(?=-[0-9])")


@lru_cache(1 << 12)
def quantities(unit: str) -> Mapping[str, str]:
    """Return the usual spelling of a unit, by the SI unit of each quantity that it may measure.

    The signs of the unit may be replaced with underscores, as MATLAB does: ``m_s``, ``N_m``,
    ``rad_s__1``.
    """
    if "_" in unit:
        ways = (quantities(way) for way in _without_underscores(unit.strip("_")))
        return next((found for found in ways if found), {})
    text = _PER.sub("/", unit.translate(_UNIT_MARKS)).strip(" .*")
    text = _BEFORE_POWER.sub("", _HYPHEN.sub(" ", text))
    if _INDEXED.fullmatch(text) or not _ONE_WORD.search(text):
        return {}
    name = _ONE_WORD.sub(_word, text)
    product = _DIVIDED.sub(r" \1-1", name)
    meant = {}
    for si, usual in _QUANTITIES.items():
        if factor(name, si) is not None:
            # For times, only the usual units are converted. For all other quantities, the unit as
            # written is converted, too.
            units = usual if si == "s" else (*usual, product)
            if same := [u for u in units if size(u) == size(name)]:
                meant[si] = same[0]
    return meant


def _without_underscores(unit: str) -> tuple[str, ...]:
    """Return the units that a text with underscores in place of signs may mean, likeliest first."""
    if (power := _POWER.sub("^-1", unit)) != unit:
        return (power.replace("_", " "),)
    return unit.replace("_per_", "/").replace("_", "/"), unit.replace("_", " ")


def is_si(unit: str | None) -> bool:
    """True if the unit is an SI unit, or None."""
    return unit is None or any(si == usual for si, usual in quantities(unit).items())


def unknown_unit(name: str) -> str | None:
    """Return the text in brackets that is probably a unit, but an unknown one; else None."""
    for match in BRACKETS.finditer(name):
        unit = match[0][1:-1].strip()
        # Round brackets may contain anything, as in phi(t), so their content counts as a unit only
        # if it contains a slash.
        is_unit = match[0][0] != "(" or "/" in unit
        is_unit &= unit.lower() not in _NO_UNITS
        if (
            is_unit
            and _ANY_LETTER.search(unit)
            and not _NUMBER_ALONE.search(unit)
            and not quantities(unit)
        ):
            return unit
    return None


def split_unit(name: str) -> tuple[str, str | None]:
    """Return a name without its unit in brackets, after a slash or after ``in``, and the unit.

    Text that is not a unit remains in the name.
    """
    for match in BRACKETS.finditer(name):
        if quantities(unit := match[0][1:-1]):
            return name[: match.start()].rstrip(" /") + name[match.end() :], unit
    for mark in (" in ", " / ", "/"):
        stem, found, unit = name.partition(mark)
        is_open = len(_OPEN_BRACKET.findall(stem)) != len(_CLOSING_BRACKET.findall(stem))
        if found and stem.strip() and not is_open and quantities(unit):
            return stem.strip(), unit.strip()
    return name, None


def _word(match: re.Match[str]) -> str:
    """Return a word of a unit in the spelling of `numbers.unit`, or unchanged if it is unknown."""
    word = match[0]
    plain = word.lower()
    return next((_WORDS[x] for x in (word, plain, plain.removesuffix("s")) if x in _WORDS), word)

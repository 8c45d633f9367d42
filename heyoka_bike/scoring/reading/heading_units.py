"""Units in headings: which quantity a column may be, and what its times count."""

import re
from collections.abc import Mapping

_NEWTON_METRE = (
    "nm", "n m", "n-m", "newton meter", "newton metre", "newton-meter", "newton-metre",
    "newton meters", "newton metres",
)  # fmt: skip
_IN_BASE_UNITS = (
    "kg m^2/s^2", "kg m2/s2", "kg m^2 s^-2", "kg m2 s-2", "kgm^2/s^2", "kgm2/s2",
)  # fmt: skip
_SI: Mapping[str, tuple[str, ...]] = {
    "s": ("s", "sec", "secs", "second", "seconds"),
    "rad": ("rad", "radian", "radians"),
    "rad s-1": ("rad/s", "radian/s", "radians/s", "/s", "1/s", "rads"),
    "m s-1": ("m/s", "mps", "meter/s", "metre/s", "meters/s", "metres/s"),
    "J": ("j", "joule", "joules", *_NEWTON_METRE, *_IN_BASE_UNITS),
    "m": ("m", "meter", "meters", "metre", "metres"),
    "N": ("n", "newton", "newtons"),
    "N m": _NEWTON_METRE,
}
_OTHERS: Mapping[str, tuple[str, ...]] = {
    "s": ("ms", "msec", "millisecond", "milliseconds"),
    "rad": ("deg", "degree", "degrees", "\u00b0"),
    "rad s-1": ("deg/s", "degree/s", "degrees/s", "\u00b0/s", "dps", "degs"),
    "m s-1": ("km/h", "kmh", "kph", "mm/s", "cm/s"),
    "J": ("kj", "mj", "knm", "kn m", "nmm", "n mm"),
    "m": ("mm", "cm", "km"),
    "N": ("kn", "mn"),
    "N m": ("knm", "kn m", "nmm", "n mm"),
}

_BRACKETS = re.compile(r"\[([^\[\]]*)\]|\(([^()]*)\)|\{([^{}]*)\}")
_DIVIDED = re.compile(r"\s*(?:/|\bper\b)\s*")
_INVERSE = re.compile(r"[ _]?(s|sec|h)(?:\*\*|\^)?\s*[({]?\s*[-\u2212\u207b][1\u00b9][)}]?$")
_SECONDS = re.compile(r"/(?:second|sec)s?$")
_PRODUCT = re.compile(r"[\s*.\u00b7\u22c5]+")
# time_s, steer_rate_deg_s, speed_m_per_s
_ENDING = re.compile(r"(.+?)_([a-z\u00b0]+(?:_(?:per_)?(?:s|h))?)")


def quantities(unit: str) -> frozenset[str]:
    """SI units, UDUNITS spelling, of the quantities that are written in a unit; none if unknown."""
    plain = _plain(unit)
    return frozenset(si for si in _SI if plain in _SI[si] or plain in _OTHERS[si])


def is_si(unit: str | None) -> bool:
    """Whether the unit is an SI unit, or not told."""
    return unit is None or any(_plain(unit) in spellings for spellings in _SI.values())


def is_millisecond(unit: str | None) -> bool:
    """Whether times in this unit count milliseconds."""
    return unit is not None and _plain(unit) in _OTHERS["s"]


def split_unit(name: str) -> tuple[str, str | None]:
    """Name of a column without the unit in brackets or behind a slash, and the unit.

    What is no unit is left where it is.
    """
    for match in _BRACKETS.finditer(name):
        unit = next(part for part in match.groups() if part is not None)
        if quantities(unit):
            rest = name[: match.start()].rstrip(" /") + name[match.end() :]
            return rest, unit
    for mark in ("/", " in "):
        stem, found, unit = name.partition(mark)
        if found and stem.strip() and quantities(unit):
            return stem.strip(), unit.strip()
    return name, None


def split_ending(name: str) -> tuple[str, str] | None:
    """Name and unit of ``roll_angle_rad``; None if it does not end in a unit."""
    match = _ENDING.fullmatch(name.strip().lower())
    if match is None:
        return None
    unit = match[2].replace("_per_", "/").replace("_", "/")
    return (match[1], unit) if quantities(unit) else None


def _plain(unit: str) -> str:
    text = _DIVIDED.sub("/", unit.strip().strip("[](){}").strip().lower())
    text = _INVERSE.sub(r"/\1", text.replace("^(-1)", "^-1"))
    return _PRODUCT.sub(" ", _SECONDS.sub("/s", text)).strip().replace(" /", "/")

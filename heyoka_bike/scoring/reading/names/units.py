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
_MILLISECOND = "ms"
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
_OTHERS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "s": {_MILLISECOND: ("ms", "msec", "millisecond", "milliseconds")},
    "rad": {
        "degree": ("deg", "degree", "degrees", "\u00b0"),
        "mrad": ("mrad", "milliradian", "milliradians"),
        "urad": ("urad", "\u03bcrad", "microradian", "microradians"),
        "arcminute": ("arcmin", "arcminute", "arcminutes"),
        "arcsecond": ("arcsec", "arcsecond", "arcseconds"),
        "grade": ("gon", "grad", "gradian", "gradians"),
        "revolution": ("rev", "revolution", "revolutions", "turn", "turns"),
    },
    "rad s-1": {
        "degree s-1": ("deg/s", "degree/s", "degrees/s", "\u00b0/s", "dps", "degs"),
        "degree min-1": ("deg/min", "degree/min", "degrees/min", "\u00b0/min"),
        "mrad s-1": ("mrad/s", "milliradian/s", "milliradians/s"),
        "revolution s-1": ("rev/s", "rps", "turn/s", "turns/s", "revolutions/s"),
        "revolution min-1": ("rev/min", "rpm", "r/min", "revolutions/min"),
    },
    "m s-1": {
        "km h-1": ("km/h", "kmh", "kph", "km/hr", "km/hour"),
        "mm s-1": ("mm/s",),
        "cm s-1": ("cm/s",),
        "km s-1": ("km/s",),
        "m min-1": ("m/min",),
        "foot s-1": ("ft/s", "fps", "foot/s", "feet/s"),
        "inch s-1": ("in/s", "ips", "inch/s", "inches/s"),
        "mile h-1": ("mph", "mi/h", "mile/h", "miles/h", "miles/hour"),
        "knot": ("kt", "kts", "knot", "knots"),
    },
    "J": {
        "kJ": ("kj", "knm", "kn m", "kilojoule", "kilojoules"),
        "mJ": ("mj", "nmm", "n mm", "millijoule", "millijoules"),
        "uJ": ("uj", "\u03bcj", "microjoule", "microjoules"),
        "MJ": ("Mj", "mnm", "mn m", "megajoule", "megajoules"),
        "W h": ("wh", "w h", "watt hour", "watt hours"),
        "foot lbf": ("ft lbf", "ft lb", "ft-lbf", "ft-lb", "lbf ft"),
    },
    "m": {
        "mm": ("mm",),
        "cm": ("cm",),
        "km": ("km",),
        "um": ("um", "\u03bcm"),
        "inch": ("inch", "inches"),
        "foot": ("ft", "foot", "feet"),
    },
    "N": {"kN": ("kn",), "mN": ("mn",), "MN": ("Mn",), "kgf": ("kgf",), "lbf": ("lbf",)},
    "N m": {
        "kN m": ("knm", "kn m"),
        "N mm": ("nmm", "n mm"),
        "N cm": ("ncm", "n cm"),
        "MN m": ("Mnm", "Mn m"),
        "foot lbf": ("ft lbf", "ft lb", "ft-lbf", "ft-lb", "lbf ft"),
    },
}
"""By SI unit, the others as `units` has them; all in small letters but a mega that is no milli."""

BRACKETS = re.compile(r"\[([^\[\]]*)\]|\(([^()]*)\)|(?<!\\dot)\{([^{}]*)\}")
"""What stands in brackets in a name; the braces of TeX's ``\\dot{\\phi}`` hold no unit."""
# A capital of a program that shouts its units is no mega.
_MEGA = re.compile(r"\W*M(?:J|N|N ?m)\W*$")
_NO_UNITS = ("si", "none", "n/a")
_WORD = re.compile(r"[^\W\d_]")
# That of a maneuver, or an index; not an exponent.
_NUMBER = re.compile(r"^\W*(?:m|man|maneuver|manoeuvre)?[\s_-]*[0-9]+\W*$", re.IGNORECASE)
_DIVIDED = re.compile(r"\s*(?:/|\bper\b)\s*")
_INVERSE = re.compile(r"[ _]?(s|sec|h)(?:\*\*|\^)?\s*[({]?\s*[-\u2212\u207b][1\u00b9][)}]?$")
_SECONDS = re.compile(r"/(?:second|sec)s?$")
_PRODUCT = re.compile(r"[\s*.\u00b7\u22c5]+")
# time_s, steer_rate_deg_s, speed_m_per_s
_ENDING = re.compile(r"(.+?)_([a-z\u00b0]+(?:_(?:per_)?(?:s|h))?)")


def quantities(unit: str) -> frozenset[str]:
    """SI units, UDUNITS spelling, of the quantities that are written in a unit; none if unknown."""
    return frozenset(si for si in _SI if unit_of(unit, si) is not None)


def unit_of(unit: str, si: str) -> str | None:
    """The unit of a quantity, of which the SI unit is given, as `scoring.units` has it."""
    plain = _plain(unit)
    if plain in _SI.get(si, ()):
        return si
    others = _OTHERS.get(si, {})
    mega = "M" + plain[1:] if _MEGA.match(unit) else plain
    found = (name for x in (mega, plain) for name, spellings in others.items() if x in spellings)
    return next(found, None)


def is_si(unit: str | None) -> bool:
    """Whether the unit is an SI unit, or not told."""
    return unit is None or any(_plain(unit) in spellings for spellings in _SI.values())


def is_millisecond(unit: str | None) -> bool:
    """Whether times in this unit count milliseconds."""
    return unit is not None and unit_of(unit, "s") == _MILLISECOND


def unknown_unit(name: str) -> str | None:
    """What stands in brackets in a name as a unit does, and is none that is known."""
    for match in BRACKETS.finditer(name):
        unit = next(part for part in match.groups() if part is not None).strip()
        # In round brackets there may be anything, such as phi(t).
        is_unit = match[0][0] != "(" or "/" in unit
        is_unit &= unit.lower() not in _NO_UNITS
        if is_unit and _WORD.search(unit) and not _NUMBER.search(unit) and not quantities(unit):
            return unit
    return None


def split_unit(name: str) -> tuple[str, str | None]:
    """Name of a column without the unit in brackets or behind a slash, and the unit.

    What is no unit is left where it is.
    """
    for match in BRACKETS.finditer(name):
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
    # MATLAB makes underscores of brackets.
    match = _ENDING.fullmatch(name.strip().lower().rstrip("_"))
    if match is None:
        return None
    unit = match[2].replace("_per_", "/").replace("_", "/")
    return (match[1], unit) if quantities(unit) else None


def _plain(unit: str) -> str:
    text = _DIVIDED.sub(
        "/", unit.replace("\u00b5", "\u03bc").strip().strip("[](){}").strip().lower()
    )
    text = _INVERSE.sub(r"/\1", text.replace("^(-1)", "^-1"))
    return _PRODUCT.sub(" ", _SECONDS.sub("/s", text)).strip().replace(" /", "/")

"""The meaning of a column's name: aliases, units in it, the number of its maneuver.

A name may be the way to a joint in a model, as ``bike.steer.phi`` and ``der(bike.steer.phi)`` of
Modelica, ``Roll_Joint.Rz.w`` of Simscape and ``/jointset/fork/steer_angle/value`` of OpenSim. Only
joints are read so: the speed or the energy of some part is not that of the bicycle.
"""

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.findings import Finding, info, warning
from heyoka_bike.scoring.reading.names.units import (
    BRACKETS,
    quantities,
    split_ending,
    split_unit,
    unknown_unit,
)
from heyoka_bike.scoring.reading.request import LEFT_OUT, NAMES, Request

TIME = "time"
_SECONDS = "s"

_ALIASES: Mapping[str, tuple[str, ...]] = {
    TIME: ("t", "times", "timestamp", "sec", "seconds", "simulationtime", "tout"),
    "roll_angle": ("roll", "phi", "varphi", "\u03c6", "\u03d5", "lean", "leanangle"),
    "roll_rate": (
        "rollangularvelocity", "rollvelocity", "angularrollvelocity", "phidot", "dphi", "phid", "p",
        "leanrate", "leanangularvelocity", "rolldot", "rolld", "leand", "dotphi", "dotvarphi",
        "\u03c6\u0307", "\u03d5\u0307",
    ),
    "forward_speed": (
        "speed", "velocity", "v", "vx", "forwardvelocity", "longitudinalspeed",
        "longitudinalvelocity",
    ),
    "potential_energy": ("potential", "epot", "ep", "pe", "u"),
    "kinetic_energy": ("kinetic", "ekin", "ek", "ke"),
    "mechanical_energy": ("mechanical", "energy", "total", "totalenergy", "emech", "etot", "e"),
    "steer_angle": ("steer", "steering", "steeringangle", "delta", "\u03b4"),
    "steer_rate": (
        "steerangularvelocity", "steeringangularvelocity", "steervelocity", "steeringvelocity",
        "steeringrate", "angularsteervelocity", "deltadot", "ddelta", "deltad", "steerdot",
        "steerd", "dotdelta", "\u03b4\u0307",
    ),
    "pitch": ("pitchangle", "theta", "\u03b8"),
    "yaw": ("yawangle", "heading", "headingangle", "psi", "\u03c8"),
    "yaw_rate": ("yawangularvelocity", "yawvelocity", "headingrate", "psidot", "dpsi", "yawdot"),
}  # fmt: skip
_KEYS: Mapping[str, str] = {
    **{key.replace("_", ""): key for key in (TIME, *COMPARED)},
    **{alias: key for key, aliases in _ALIASES.items() for alias in aliases},
}
# What a name means in another unit than that of its usual meaning.
_BY_UNIT: Mapping[tuple[str, str], str] = {
    ("t", "J"): "kinetic_energy",
    ("v", "J"): "potential_energy",
    ("u", "m s-1"): "forward_speed",
    # A wheel's.
    **{(name, "rad s-1"): "forward_speed" for name in ("v", "u", "vx", "speed", "velocity")},
    **{(name, "rad s-1"): "roll_rate" for name in ("roll", "phi", "lean")},
    **{(name, "rad s-1"): "steer_rate" for name in ("steer", "steering", "delta")},
    **{(name, "rad s-1"): "yaw_rate" for name in ("yaw", "heading", "psi")},
}
# For values to decide, where the other names (see `numbers`) do not.
_ALSO: Mapping[str, tuple[str, ...]] = {
    "V": ("forward_speed", "potential_energy"),
    "u": ("potential_energy", "forward_speed"),
    "v": ("forward_speed", "potential_energy"),
    "p": ("roll_rate", "potential_energy"),
    **dict.fromkeys(("theta", "\u03b8"), ("pitch", "roll_angle", "steer_angle")),
}
_MANEUVERS = frozenset(
    {"man", "maneuver", "manoeuvre", "maneuvernumber", "maneuverno", "maneuverid", "maneuverindex"}
)

_MANEUVER = r"(?:m|man|maneuver|manoeuvre)"
_ONE = re.compile(r"[\[({]\s*1\s*[\])}]")
_NUMBERED = re.compile(rf"[\s_-]*{_MANEUVER}?[\s_-]*([0-9]{{1,3}})\s*")
_BREAKS = re.compile(r"[\s_.:/\\${}-]+")
_PREFIX = re.compile(rf"{_MANEUVER}_?([0-9]{{1,3}})_(.+)")
_SUFFIX = re.compile(rf"(.+?)_?(?:{_MANEUVER}_?)?([0-9]{{1,3}})")
_GROUP = re.compile(rf"{_MANEUVER}_?([0-9]{{1,3}})")
# Joints by their names, and how often the angle is differentiated.
_JOINTS: Mapping[str, tuple[str, int]] = {
    **dict.fromkeys(("roll", "rollangle", "lean", "leanangle"), ("roll", 0)),
    **dict.fromkeys(("steer", "steerangle", "steering", "steeringangle"), ("steer", 0)),
    **dict.fromkeys(("rollrate", "leanrate"), ("roll", 1)),
    **dict.fromkeys(("steerrate", "steeringrate"), ("steer", 1)),
}
_IS_ANGLE = frozenset({"phi", "q", "angle", "value"})
_IS_RATE = frozenset({"w", "qd", "omega", "speed", "rate"})

_STEPS = re.compile(r"[./|]")
_DERIVATIVE = re.compile(r"der\((.+)\)")
# What kind of joint it is, beside which one it is.
_KIND = re.compile(r"revolute|rev|joint|hinge|pin|_")
# An axis of a joint that could have several.
_AXIS = re.compile(r"r[xyz]")
# The names of a message; more would not be read.
_SHOWN = 8
# Shorter names are like too many others.
_SHORTEST = 5
LIKE = 0.63
"""Names so much alike may mean the same: `Rollwinkel` and `roll_angle` are just so."""
# So much alike are names that were misspelt.
_ALMOST = 0.85


# The names of a file are asked for many times.
@lru_cache(1 << 17)
def recognise(name: str, *, one_is_a_unit: bool = True) -> tuple[str, int | None] | None:
    """Key of the column that a name means, and number of the maneuver if it has one.

    Case, blanks, hyphens and underscores do not matter. A unit, in brackets or at the end, decides
    where a name alone would mean another column (``V [J]``); there 1 is that of a column without
    dimension, or the first maneuver.
    """
    if one_is_a_unit and _ONE.search(name):
        found = recognise(_ONE.sub("", name))
        if found and found[0] != TIME and COMPARED[found[0]][0].unit == "1":
            return found
    stem, unit, is_ending = unit_in(name)
    word, key, number = _by_words(stem)
    if key is None:
        key, number = _of_joint(stem), group_number(stem.partition(".")[0])
    if key is not None and unit is not None:
        key = _in_unit(word, key, unit, is_ending)
    if key is None or (key == TIME and number is not None):
        return None
    return key, number


def is_time(name: str) -> bool:
    """True if the name is that of the times."""
    return recognise(name) == (TIME, None)


def time_among(names: Sequence[str]) -> int:
    """Place of the times among the columns of these names: the first if none is theirs."""
    return next((i for i, name in enumerate(names) if is_time(name)), 0)


def unit_in(name: str) -> tuple[str, str | None, bool]:
    """The name without its unit, that unit, and whether it is an ending such as ``_rad``."""
    stem, unit = split_unit(name)
    if unit is None and _by_words(name)[1] is None and (ending := split_ending(name)):
        return *ending, True
    return stem, unit, False


def named_unit(name: str, key: str) -> str | None:
    """The unit that the name of a column tells, if the column can have it, as `units` has it."""
    unit = unit_in(name)[1]
    return None if unit is None else quantities(unit).get(COMPARED[key][0].unit)


def _by_words(name: str) -> tuple[str, str | None, int | None]:
    """The word for the column, its key if it is known, and the number of the maneuver."""
    plain = _BREAKS.sub("_", BRACKETS.sub(_number_in_brackets, name.lower())).strip("_\"'")
    number = None
    if match := _PREFIX.fullmatch(plain):
        number, plain = int(match[1]), match[2]
    elif plain.replace("_", "") not in _KEYS and (match := _SUFFIX.fullmatch(plain)):
        plain, number = match[1], int(match[2])
    word = plain.replace("_", "")
    return word, _KEYS.get(word), number


def _in_unit(word: str, key: str, unit: str, is_strict: bool) -> str | None:
    """Return the key that a word means with a unit; None if no column of that name has it."""
    possible = quantities(unit)
    if not possible or (_SECONDS if key == TIME else COMPARED[key][0].unit) in possible:
        return key
    other = next((k for (w, q), k in _BY_UNIT.items() if w == word and q in possible), None)
    # Of a full name and its unit, the unit is more likely to be the one that is wrong.
    is_full = word == key.replace("_", "")
    return other or (key if is_full and not is_strict else None)


def _of_joint(name: str) -> str | None:
    """The column that the name of a joint's angle or rate means; None if it is no such name."""
    path = name.lower().strip(" \"'")
    if derived := _DERIVATIVE.fullmatch(path):
        path = derived[1]
    steps = [step for step in _STEPS.split(path) if step and not _AXIS.fullmatch(step)]
    if not steps or (len(steps) == 1 and not derived):
        return None
    *way, last = steps
    is_part = way and last in _IS_ANGLE | _IS_RATE
    joint, order = _JOINTS.get(_KIND.sub("", way[-1] if is_part else last), ("", 2))
    order += (derived is not None) + (last in _IS_RATE)
    # The second derivative is an acceleration.
    return f"{joint}_{('angle', 'rate')[order]}" if order < 2 else None


def may_mean(name: str) -> tuple[str, ...]:
    """Return all keys that a name may mean, for values to decide; none if it means one thing."""
    return _ALSO.get(name.strip(" \"'"), ())


def told(columns: Sequence[str], option: str) -> tuple[str, ...]:
    """The names that columns were said to have.

    Raises
    ------
    InputError
        A name that is not known, or no time.
    """
    names = tuple(name.strip() for name in columns)
    where = option.rstrip("=")
    found = []
    for name in names:
        known = recognise(name)
        if known is None and name not in LEFT_OUT and not is_maneuver(name):
            raise InputError(
                f"{where}: found {quoted(name)}, expected {NAMES}, a column of motion.h5, a short "
                f"name such as t, phi, v or delta, or - for one that is left out"
                f"{did_you_mean(name)}"
            )
        if known is not None:
            found.append(known[0])
    if TIME not in found or len(found) < 2:
        raise InputError(f"{where}: found no time and another column, expected both among them")
    return names


def is_maneuver(name: str) -> bool:
    """True if a column of this name tells the maneuver of each row."""
    return _BREAKS.sub("", name.lower()).strip("\"'[]()#") in _MANEUVERS


def nearest(name: str, like: float = LIKE) -> str | None:
    """The known column whose name is most like another one; None if none is."""
    from difflib import get_close_matches

    word = _by_words(split_unit(name)[0])[0]
    if len(word) < _SHORTEST:
        return None
    close = get_close_matches(word, [k for k in _KEYS if len(k) >= _SHORTEST], 1, like)
    return _KEYS[close[0]] if close else None


def did_you_mean(name: str) -> str:
    """Return the end of a message about a name; nothing if no known column has one like it."""
    like = nearest(name)
    return f"; did you mean {like}?" if like else ""


def group_number(name: str) -> int | None:
    """Number in the name of a group of columns (``maneuver_2``), if it is one."""
    match = _GROUP.fullmatch(_BREAKS.sub("_", name.lower()))
    return int(match[1]) if match else None


def are_names(names: Sequence[str], request: Request) -> bool:
    """True if the names have the time and another column that is known, or what is asked for."""
    if request.known is not None:
        return any(map(request.known, names))
    known = {found[0] for name in names if (found := recognise(name))}
    return TIME in known and len(known) > 1


def left_out(names: Sequence[str]) -> Finding:
    """Return the finding that columns of unknown names are not used."""
    said = f"Columns of other names are left out: {listed(names, _ALMOST)}."
    return info("columns_left_out", said, **_evidence(names))


def set_aside(names: Sequence[str], request: Request) -> Finding:
    """Return the finding that columns are not used although their names are known."""
    said = (
        f"Columns that are known by name are left out: {listed(names)}. A number in a name is that "
        "of a maneuver only if the other names have one, and if the reference has that maneuver; "
        f"{request.how_to_tell}."
    )
    return warning("known_columns_left_out", said, **_evidence(names))


def _evidence(names: Sequence[str]) -> dict[str, Any]:
    return {"names": [quoted(name)[1:-1] for name in names[:100]], "count": len(names)}


def unknown_units(names: Mapping[str, str]) -> list[Finding]:
    """Return a finding for each unknown unit in the names of columns, here with their keys."""
    findings = []
    for name, key in names.items():
        taken = "it is taken for seconds" if key == TIME else "only the usual units are tried"
        if (unit := unknown_unit(name)) is None:
            continue
        said = f"The unit {quoted(unit)} of the column {quoted(name)} is not known, so {taken}."
        evidence = {"name": quoted(name)[1:-1], "unit": quoted(unit)[1:-1], "column": key}
        findings.append(warning("unit_unknown", said, **evidence))
    return findings[:_SHOWN]


def listed(names: Sequence[str], like: float | None = None) -> str:
    """List some of the names in quotes, each with a known name that is so much like it."""
    found = [
        None if like is None or recognise(name) else nearest(name, like) for name in names[:_SHOWN]
    ]
    shown = ", ".join(
        f"{quoted(name)} ({near}?)" if near else quoted(name)
        for name, near in zip(names, found, strict=False)
    )
    more = len(names) - _SHOWN
    return f"{shown} and {more} more" if more > 0 else shown


def names_found(names: Sequence[str], found: Sequence[object] | None = None) -> str:
    """Return words that say that too few of the names are known, or mean what is found."""
    known = [recognise(name) for name in names] if found is None else found
    unknown = [name for name, k in zip(names, known, strict=True) if not k]
    if unknown:
        return f"column names {listed(unknown, LIKE)} not understood"
    if not names:
        return "no column whose name is known"
    has_time = any(k and k[0] == TIME for k in map(recognise, names))
    return f"column names {listed(names)}{'' if has_time else ' without their times'}"


def _number_in_brackets(match: re.Match[str]) -> str:
    number = _NUMBERED.fullmatch(match[0][1:-1])
    return f"_{number[1]}" if number else ""

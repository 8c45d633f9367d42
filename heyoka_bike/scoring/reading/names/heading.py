"""Find the meaning of a single heading: the column, its unit and the maneuver."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import PurePath
from typing import Any

from heyoka_bike.bicycle.aliases import KEYS_BY_WORD
from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.scoring.reading.names.heading_units import BRACKETS, is_si, quantities, split_unit
from heyoka_bike.scoring.reading.names.joints import of_joint
from heyoka_bike.scoring.reading.request import Request

# Underscores between the words of a name, as in time_s, steer_rate_deg_s, speed_in_m_s__1.
_UNDERSCORES = re.compile(r"_+(?=[^_])")
# Endings that are not units: a number is the number of the maneuver, and "in" is a preposition, not
# the inch.
_NO_UNIT_BEGINS = re.compile(r"[0-9]|in_", re.IGNORECASE)
# Maximum number of words in a unit. The name speed_m_per_s_1 contains a unit of four words.
_MOST_WORDS_OF_UNIT = 4
# Maximum length of a name whose ending may be a unit [characters]. A longer name is a whole line,
# not the name of a column.
_LONGEST_OF_R = 1000
_OF_R = re.compile(r"(.+?)\.\.([A-Za-z.]+)\.")
Meaning = tuple[str, int | None]
"""Key of a column, and the number of its maneuver if it is known."""

TIME = "time"
_NAMES_OF_TIME = (
    "t", "times", "timestamp", "timestamps", "datetime", "sec", "secs", "seconds", "simulationtime",
    "tout",
)  # fmt: skip
# Names of the components of a quaternion that end in a letter, such as rear_frame_qw or
# rear_frame_quaternion_x.
_PARTS_OF_QUATERNIONS = {
    f"{end}frame{word}{letter}": f"{end}_frame_q{i}"
    for end in ("rear", "front")
    for word in ("q", "quat", "quaternion", "orientation")
    for i, letter in enumerate("wxyz")
}
KEYS: Mapping[str, str] = {
    **dict.fromkeys((TIME, *_NAMES_OF_TIME), TIME), **_PARTS_OF_QUATERNIONS, **KEYS_BY_WORD
}  # fmt: skip
# Meaning of a name with a unit that is not the unit of its usual meaning.
_BY_UNIT: Mapping[tuple[str, str], str] = {
    ("t", "J"): "kinetic_energy",
    ("v", "J"): "potential_energy",
    ("u", "m s-1"): "forward_speed",
    # The rate of a wheel [rad/s] may be written in place of the speed.
    **{(name, "rad s-1"): "forward_speed" for name in ("v", "u", "vx", "speed", "velocity")},
    **{(name, "rad s-1"): "roll_rate" for name in ("roll", "phi", "lean")},
    **{(name, "rad s-1"): "steer_rate" for name in ("steer", "steering", "delta")},
    **{(name, "rad s-1"): "yaw_rate" for name in ("yaw", "heading", "psi")},
}
# Ambiguous names and their possible meanings. If the other names of the file do not determine the
# meaning (see `meanings`), the values do.
_ALSO: Mapping[str, tuple[str, ...]] = {
    "V": ("forward_speed", "potential_energy"),
    "u": ("potential_energy", "forward_speed"),
    "v": ("forward_speed", "potential_energy"),
    "p": ("roll_rate", "potential_energy"),
    **dict.fromkeys(("theta", "\u03b8"), ("pitch", "roll_angle", "steer_angle")),
}
_IN_DEGREES = {"rad": "deg", "rad s-1": "deg/s"}
_MANEUVERS = frozenset(
    {"man", "maneuver", "manoeuvre", "maneuvernumber", "maneuverno", "maneuverid", "maneuverindex"}
)
_WORDS_OF_MANEUVER = "man|maneuver|manoeuvre"
_PATTERN_OF_MANEUVER = rf"(?:m|{_WORDS_OF_MANEUVER})"
_ONE_IN_BRACKETS = re.compile(r"[\[({]\s*1\s*[\])}]")
_NUMBERED = re.compile(rf"[\s_-]*{_PATTERN_OF_MANEUVER}?[\s_-]*([0-9]{{1,3}})\s*")
_WHOLE_SECONDS = re.compile(r"(.*?)secs?", re.IGNORECASE)
_NANOSECONDS = re.compile(r"(.*?)n(?:ano)?secs?", re.IGNORECASE)
WORD_BREAKS = re.compile(r"[\s_.:/\\${}-]+")
_MANEUVER_BEFORE = re.compile(rf"{_PATTERN_OF_MANEUVER}_?([0-9]{{1,3}})_(.+)")
_MANEUVER_BEHIND = re.compile(rf"(.+?)_?(?:{_PATTERN_OF_MANEUVER}_?)?([0-9]{{1,3}})")
# The patterns below match the name as written. The two patterns above match the name in small
# letters, with underscores as its only punctuation.
_FIRST = re.compile(rf"{_PATTERN_OF_MANEUVER}[\s_.-]?([0-9]{{1,3}})[\s_./:-]+(.+)", re.IGNORECASE)
_LAST = re.compile(
    rf"(.+?)(?:[\s_.-]*[\[({{]\s*(?:{_PATTERN_OF_MANEUVER}[\s_-]*)?([0-9]{{1,3}})\s*[\])}}]"
    rf"|[\s_.-]+{_PATTERN_OF_MANEUVER}[\s_-]*([0-9]{{1,3}}))",
    re.IGNORECASE,
)
# Number at the end of a joint's angle such as q_3. Without the underscore, q3 is a coordinate.
_NUMBER_OF_JOINT = re.compile(r"(.+?)_([0-9]{1,3})")
_NUMBER_BEHIND = re.compile(r"[\s_.]*[0-9]{1,3}$")
# Patterns of parts of a name, in this order: the number of a maneuver anywhere in the name; numbers
# and marks without a meaning; characters of a formula, which mean that the name is not that of a
# quantity.
_MANEUVER_ANYWHERE = re.compile(
    rf"(?<![a-z]){_PATTERN_OF_MANEUVER}[\s_.:-]*[0-9]{{1,3}}(?![0-9])", re.IGNORECASE
)
_NUMBER_OR_MARKS = re.compile(
    r"[0-9]+(?:st|nd|rd|th)?(?![a-zA-Z0-9])|[0-9]+|[\s_.:#*?~+()\[\]{}-]+"
)
_FORMULA = re.compile(r"[\^|=<>\u00b2\u00b3\u0394]|\w\s*[*/]\s*[a-zA-Z]")
OF_NO_QUANTITY = frozenset({"data", "value", "values"})
"""Last components of a path that do not name a quantity, such as the data of a ROS message."""

_STEPS_OF_PATH = re.compile(r"[./|:\\]+")
_IN_WORDS = re.compile(r"\bman(?:eu|oeu)v(?:er|re)[\s_.:#=-]*([0-9]{1,3})\b", re.IGNORECASE)
_GROUP_NAME = re.compile(rf"{_PATTERN_OF_MANEUVER}_?([0-9]{{1,3}})")
# The name of a file, with underscores as its only punctuation. After other words, m_2 may be a
# length in metres, and kg_m2 is a unit.
_FILE_NAME = re.compile(
    rf"m_([0-9]{{1,3}})|(?:.*_)?(?<!kg_)(?:m|(?:{_WORDS_OF_MANEUVER})_?)([0-9]{{1,3}})"
)
_SUFFIXES = re.compile(r"(?:\.[a-z][a-z0-9]*)+\Z", re.IGNORECASE)
# A word of letters with a number behind, such as T1 or run 1.
_LABEL = re.compile(r"[^\d]*[^\W\d_][\W_]*([0-9]{1,3})")


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading, and the properties of its column that it states.

    Attributes
    ----------
    text
        The heading itself.
    key
        Key of the column that it means, or ``time``; None if it is not known.
    maneuver
        Number of the maneuver; None if it has none.
    unit
        The unit that it names, as it is written there; None if it names no unit that is known.
    is_ending
        True if the unit is an ending such as ``_rad``.
    """

    text: str
    key: str | None = None
    maneuver: int | None = None
    unit: str | None = None
    is_ending: bool = False

    @property
    def meaning(self) -> Meaning | None:
        """The key and the number of the maneuver; None if the key is not known."""
        return None if self.key is None else (self.key, self.maneuver)

    @property
    def is_time(self) -> bool:
        """True if the heading names the column of times."""
        return self.key == TIME

    @property
    def is_maneuver(self) -> bool:
        """True if the column contains the number of the maneuver of each row."""
        return is_maneuver(self.text)

    @property
    def known_unit(self) -> str | None:
        """The unit in the spelling of `units`; None if the quantity cannot have the named unit."""
        if self.unit is None or self.key is None:
            return None
        return quantities(self.unit).get("s" if self.is_time else COMPARED[self.key][0].unit)

    @property
    def may_be(self) -> tuple[str, ...]:
        """All keys that an ambiguous heading may mean; empty if its meaning is clear."""
        keys = may_mean(self.text)
        return keys if self.key in keys else ()


# The results are cached, because the names in a file are parsed many times.
@lru_cache(1 << 17)
def parse_heading(text: str, *, one_is_a_unit: bool = True) -> Heading:
    """Return the meaning of a heading, without regard to the other headings of the file.

    Case, blanks, hyphens and underscores do not matter. A unit in brackets or at the end determines
    the column if the name with this unit means another column (``V [J]``). The number 1 in brackets
    is the unit of a dimensionless column, or else the number of a maneuver.
    """
    stem, unit, is_ending = unit_in(text)
    unknown = Heading(text, unit=unit, is_ending=is_ending)
    if one_is_a_unit and _ONE_IN_BRACKETS.search(text):
        key, number = parse_heading(_ONE_IN_BRACKETS.sub("", text)).meaning or (TIME, None)
        if key != TIME and COMPARED[key][0].unit == "1":
            return replace(unknown, key=key, maneuver=number)
    word, known, number = by_words(stem)
    if known is None:
        plain, number = without_maneuver(stem)
        known = of_joint(plain)
        if known is None and number is None and (match := _NUMBER_OF_JOINT.fullmatch(plain)):
            known = of_joint(match[1])
            number = None if known is None else int(match[2])
        # One component of the path may be the name of a maneuver.
        each = (group_number(step) for step in _STEPS_OF_PATH.split(plain))
        number = number or next((n for n in each if n), None)
    if known is not None and unit is not None:
        known = _in_unit(word, known, unit, is_ending)
    if known is None or (known == TIME and number is not None):
        return unknown
    return replace(unknown, key=known, maneuver=number)


@lru_cache(1 << 17)
def quantity_of(name: str) -> str | None:
    """Return the key of the quantity that a name means, without regard to numbers and marks in it.

    pandas writes a second ``m1_roll_angle`` as ``m1_roll_angle.1``; other programs write
    ``2:roll_angle`` or ``roll_angle*``. None for a name with another word or a sign of a formula,
    because it means something else.
    """
    heading = parse_heading(name)
    if heading.key is not None:
        return heading.key
    # A text in brackets does not name a different quantity.
    stem = BRACKETS.sub(" ", unit_in(name.strip(" \"'"))[0])
    if _FORMULA.search(stem):
        return None
    plain = " ".join(_NUMBER_OR_MARKS.sub(" ", _MANEUVER_ANYWHERE.sub(" ", stem)).split())
    # Accept only words for columns, because the number after the angle of a joint may be an index.
    # Do not accept a time either, because T means the time, but T2 does not.
    is_word = by_words(plain)[1] is not None
    key = parse_heading(plain).key if is_word else None
    return None if key == TIME else key


def is_known(name: str) -> bool:
    """True if a name is that of a column, or of the times."""
    return parse_heading(name).key is not None


def is_time(name: str) -> bool:
    """True if a name is that of the times."""
    return parse_heading(name).is_time


def time_among(names: Sequence[str]) -> int:
    """Return the index of the name of the times among column names; 0 if it is not there."""
    return next((i for i, name in enumerate(names) if is_time(name)), 0)


def nanoseconds_beside(names: Sequence[str], time: str) -> int | None:
    """Return the index of the nanoseconds that ROS writes with whole seconds; None without them."""
    if not (match := _WHOLE_SECONDS.fullmatch(time.strip(" \"'"))):
        return None
    beside = (_NANOSECONDS.fullmatch(name.strip(" \"'")) for name in names)
    return next((i for i, m in enumerate(beside) if m and m[1] == match[1]), None)


def unit_in(name: str) -> tuple[str, str | None, bool]:
    """Return the name without its unit, the unit, and whether it is an ending such as ``_rad``."""
    stem, unit = split_unit(name)
    if unit is not None or by_words(name)[1] is not None:
        return stem, unit, False
    # MATLAB replaces brackets with underscores, and R replaces them with points.
    plain = name.strip().rstrip("_")
    if ".." in plain and len(plain) < _LONGEST_OF_R:
        plain = _OF_R.sub(lambda m: f"{m[1]}_{m[2].replace('.', '_')}", plain)
    if len(plain) < _LONGEST_OF_R:
        # Find the longest ending of the name that is a unit.
        for match in [*_UNDERSCORES.finditer(plain)][-_MOST_WORDS_OF_UNIT:]:
            ending = plain[match.end() :]
            is_unit = not _NO_UNIT_BEGINS.match(ending) and bool(quantities(ending))
            if match.start() and is_unit:
                return plain[: match.start()].removesuffix("_in"), ending, True
    plain, number = without_maneuver(plain)
    found, unit, is_ending = (name, None, False) if number is None else unit_in(plain)
    return (name, None, False) if unit is None else (f"m{number}_{found}", unit, is_ending)


def with_unit(name: str, attributes: Mapping[str, Any]) -> str:
    """Return the name of a column with the unit from its attributes, unless that is an SI unit."""
    told = next((attributes[x] for x in ("units", "unit") if x in attributes), "")
    unit = told.decode("utf-8", "replace") if isinstance(told, bytes) else str(told)
    steps = [x for x in _STEPS_OF_PATH.split(name) if x.lower() not in OF_NO_QUANTITY]
    is_column = any(map(is_known, (name, *steps[-1:])))
    is_told = is_column and bool(quantities(unit)) and parse_heading(name).unit is None
    return f"{name} [{unit}]" if is_told and not is_si(unit) else name


def with_degrees(names: Sequence[str]) -> list[str]:
    """Add degrees as the unit to the names of angles and rates that name no unit."""
    keys = [parse_heading(name).key or TIME for name in names]
    units = ["" if key == TIME else COMPARED[key][0].unit for key in keys]
    told = (_IN_DEGREES.get(unit, "") for unit in units)
    return [with_unit(name, {"unit": unit}) for name, unit in zip(names, told, strict=True)]


def by_words(name: str) -> tuple[str, str | None, int | None]:
    """Return the word for the column, its key (None if unknown), and the number of the maneuver."""
    plain = WORD_BREAKS.sub("_", BRACKETS.sub(_number_in_brackets, name.lower())).strip("_\"'")
    number = None
    if match := _MANEUVER_BEFORE.fullmatch(plain):
        number, plain = int(match[1]), match[2]
    elif plain.replace("_", "") not in KEYS and (match := _MANEUVER_BEHIND.fullmatch(plain)):
        plain, number = match[1], int(match[2])
    word = plain.replace("_", "")
    return word, KEYS.get(word), number


def _in_unit(word: str, key: str, unit: str, is_strict: bool) -> str | None:
    """Return the key for a name with a unit; None if no column of that name has this unit."""
    possible = quantities(unit)
    if not possible or ("s" if key == TIME else COMPARED[key][0].unit) in possible:
        return key
    other = next((k for (w, q), k in _BY_UNIT.items() if w == word and q in possible), None)
    # If a full name contradicts its unit, the unit is more likely to be wrong.
    is_full = word == key.replace("_", "")
    return other or (key if is_full and not is_strict else None)


def may_mean(name: str) -> tuple[str, ...]:
    """Return all keys that an ambiguous name may mean; empty if the meaning is clear."""
    plain, _ = without_maneuver(name.strip(" \"'"))
    return _ALSO.get(_NUMBER_BEHIND.sub("", plain), ())


def without_maneuver(name: str) -> tuple[str, int | None]:
    """Return a name without the maneuver that it contains, and the number of this maneuver."""
    if match := _FIRST.fullmatch(name):
        return match[2], int(match[1])
    if match := _LAST.fullmatch(name):
        return match[1], int(match[2] or match[3])
    return name, None


def maneuvers_in(text: str) -> list[int]:
    """Return the numbers of the maneuvers that a text mentions, as in ``maneuver 2``."""
    return [int(x) for x in _IN_WORDS.findall(text)]


def is_maneuver(name: str) -> bool:
    """True if a column of this name contains the maneuver number of each row."""
    return WORD_BREAKS.sub("", name.lower()).strip("\"'[]()#") in _MANEUVERS


def group_number(name: str) -> int | None:
    """Return the number in the name of a group, such as ``maneuver_2``; None for other names."""
    match = _GROUP_NAME.fullmatch(WORD_BREAKS.sub("_", name.lower()))
    return int(match[1]) if match else None


def number_of_file(path: str) -> int | None:
    """Return the number of the maneuver that ends the name of a file, such as ``run-m2.csv.gz``.

    Return None for other names, and for names that mention several maneuvers.
    """
    stem = _SUFFIXES.sub("", PurePath(path).name)
    match = _FILE_NAME.fullmatch(WORD_BREAKS.sub("_", stem.lower()))
    if match is None or len(_MANEUVER_ANYWHERE.findall(stem)) > 1:
        return None
    return int(match[1] or match[2])


def labelled_number(text: str) -> int | None:
    """Return the number in the label of a maneuver, such as ``T1``; None if it has none."""
    match = _LABEL.fullmatch(text.strip())
    return int(match[1]) if match else None


def are_names(names: Sequence[str], request: Request) -> bool:
    """True if the names include the time and a known column, or a column that is requested."""
    if request.known is not None:
        return any(map(request.known, names))
    known = {parse_heading(name).key for name in names} - {None}
    return TIME in known and len(known) > 1


def _number_in_brackets(match: re.Match[str]) -> str:
    number = _NUMBERED.fullmatch(match[0][1:-1])
    return f"_{number[1]}" if number else ""

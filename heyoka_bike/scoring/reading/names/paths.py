"""Paths: names whose last component names the column, in models, messages and data frames.

``bike.forward_speed``, ``field.forward_speed``, ``/bike/state/forward_speed`` and pandas'
``('bike', 'forward_speed')`` are the forward speed of something. But the speed of a wheel is not
that of the bicycle, and a set point has the name of its quantity. So a path means its last
component only if at least two quantities of the bicycle, named in full, have the same components
before the last one, and if no other column of the file has one of these names.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.reading.names.heading import (
    OF_NO_QUANTITY,
    TIME,
    by_words,
    group_number,
    parse_heading,
    unit_in,
)
from heyoka_bike.scoring.reading.names.heading_units import split_unit

_STEPS = re.compile(r"[./|\\]+|(?<!:):(?!:)|::")
_LEVELS = re.compile(r"\(\s*('[^']*'|\"[^\"]*\")(?:\s*,\s*('[^']*'|\"[^\"]*\"))+\s*,?\s*\)")
_ONE_LEVEL = re.compile(r"'([^']*)'|\"([^\"]*)\"")
_QUOTED = re.compile(r"\s*([\"'])([^\"']*)\1\s*")
# The path before the seconds and nanoseconds of the time of a ROS message.
_STAMP = re.compile(r"^.*(?<![a-z])stamp[./:|\\_]+(?=n?(?:ano)?secs?$)")
_WHOLE_NAMES = frozenset({*(key.replace("_", "") for key in COMPARED), TIME})
# Minimum number of full column names in a part of the file that is read as the bicycle.
_FEWEST_KEYS = 2


def without_paths(names: Sequence[str]) -> list[str]:
    """Return the names; paths to columns of the bicycle are reduced to their last component."""
    names = [_STAMP.sub("", _with_points(_unquoted(name))) for name in names]
    split = [_split(name) for name in names]
    if not any(part for part, _ in split):
        return list(names)
    # The last component of a name that is not a path is the name itself.
    headings = [parse_heading(last) for _, last in split]
    plain = {
        h.meaning for (part, _), h in zip(split, headings, strict=True) if not part and h.meaning
    }
    time = {(TIME, None)}
    parts = grouped((part, last) for part, last in split if part)
    meant = {
        part: {meaning for last in lasts if (meaning := parse_heading(last).meaning)}
        for part, lasts in parts.items()
    }
    whole = {
        part for part, lasts in parts.items() if len({*filter(_is_whole, lasts)}) >= _FEWEST_KEYS
    }
    alone = {
        part
        for part in whole
        if not meant[part] & plain - time
        and not any(meant[part] & meant[other] - time for other in whole - {part})
    }
    # If the file has times outside of all parts, the times of a part keep their path, so that the
    # file does not seem to have two columns of times.
    others = plain & time
    return [
        last if part in alone and h.meaning and h.meaning not in others else name
        for name, (part, last), h in zip(names, split, headings, strict=True)
    ]


def _unquoted(name: str) -> str:
    """Return a name without the quotes around it."""
    match = _QUOTED.fullmatch(name)
    return match[2] if match else name


def _with_points(name: str) -> str:
    """Return the levels of a pandas name with points between them; other names are unchanged."""
    plain = name.strip(' "')
    if not _LEVELS.fullmatch(plain):
        return name
    levels = [a or b for a, b in _ONE_LEVEL.findall(plain)]
    return ".".join(x for x in levels if x)


def _split(name: str) -> tuple[str, str]:
    """Return the components of a path before the last one, and the last one with its unit.

    The first text is empty for a name that is not a path. A component that is the name of a
    maneuver becomes part of the last one.
    """
    stem, unit = split_unit(name.strip(" \"'"))
    steps = [x for x in _STEPS.split(stem) if x]
    if len(steps) > 1 and steps[-1].lower() in OF_NO_QUANTITY:
        steps.pop()
    *before, last = steps or [""]
    maneuvers = [x for x in before if group_number(x) is not None]
    before = [x for x in before if x not in maneuvers]
    if not before or len(maneuvers) > 1:
        return "", name
    last = "_".join((*maneuvers, last))
    return "/".join(before), last if unit is None else f"{last} [{unit}]"


def _is_whole(name: str) -> bool:
    """True if a name is the full name of a quantity, not a letter or another word for it."""
    return by_words(unit_in(name)[0])[0] in _WHOLE_NAMES

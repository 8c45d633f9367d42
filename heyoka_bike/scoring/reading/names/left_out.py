"""Evidence of columns that are not compared, with the quantities that their names resemble."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from heyoka_bike.bicycle.columns import RATE_OF
from heyoka_bike.scoring.evidence.as_read import NotCompared, Reason, UnknownUnit
from heyoka_bike.scoring.evidence.base import LostColumn
from heyoka_bike.scoring.reading.names.heading import (
    KEYS,
    TIME,
    by_words,
    parse_heading,
    quantity_of,
    unit_in,
)
from heyoka_bike.scoring.reading.names.heading_units import unknown_unit
from heyoka_bike.scoring.reading.names.joints import column_of_joint
from heyoka_bike.scoring.reading.names.meanings import IN_WORDS
from heyoka_bike.scoring.reading.names.suggestions import ALMOST, NAMES_SHOWN, NAMES_SPELT, nearest
from heyoka_bike.scoring.reading.request import Request


def left_out(names: Sequence[str], request: Request) -> NotCompared:
    """Return the evidence that columns of unknown names are not used."""
    # Only the first names are compared letter by letter. This takes a millisecond for each name,
    # and a file may contain thousands of names.
    keys = [
        resembled(name, request) if i < NAMES_SPELT else column_within(name, request)[0]
        for i, name in enumerate(names)
    ]
    columns = tuple(
        LostColumn(name, key, _maneuver_in_words(name, request) if key else None)
        for name, key in zip(names, keys, strict=True)
    )
    return NotCompared(Reason.UNKNOWN_NAME, columns, request.columns_hint)


def resembled(name: str, request: Request) -> str | None:
    """Return the key of the quantity that an unknown name may mean; None if it resembles no name.

    Only messages use the key. The name may be misspelt, a path, a derivative, or several words.
    """
    if match := _DERIVATIVE.fullmatch(name.strip(" \"'")):
        angle = parse_heading(next(filter(None, match.groups()))).key
        if angle is not None and angle in RATE_OF:
            return RATE_OF[angle]
    if key := nearest(name, ALMOST) or column_within(name, request)[0]:
        return key
    plain = _UNIT_BEGINS.split(name, maxsplit=1)[0]
    steps = [step for step in _PATH_BREAKS.split(plain) if step.strip()]
    # The last component of a path may be a detail of the quantity, as in speed.Q. So also try the
    # component before it.
    words = [by_words(step)[1] for step in steps[:-3:-1] if len(steps) > 1]
    words += [KEYS.get(x.lower()) for x in _TOKENS.findall(plain) if len(x) >= _SHORTEST_WORD]
    return next((key for key in words if key is not None and key != TIME), None)


def set_aside(
    names: Sequence[str], request: Request, reason: Reason = Reason.SET_ASIDE
) -> NotCompared:
    """Return the evidence that columns are not used although their names are known."""
    columns = (
        LostColumn(name, quantity_of(name), _maneuver_in_words(name, request)) for name in names
    )
    return NotCompared(reason, tuple(columns), request.columns_hint)


def _maneuver_in_words(name: str, request: Request) -> int | None:
    """Return the maneuver that a column name states, or else that of its part of the file."""
    match = IN_WORDS.search(name.lower())
    return request.group if match is None else int(match[1])


def column_within(name: str, request: Request) -> tuple[str | None, int | None]:
    """Return the key of the quantity whose name an unknown name contains, and its maneuver.

    ``field.forward_speed``, ``roll_rate [\u00ba/s]`` and ``roll_angle_setpoint`` contain one.
    A name of one word counts only if it is the last component of a path (``bike.speed``), because
    ``wheel_speed`` is another quantity.

    Returns
    -------
    key, maneuver
        None if the name contains no known name, or if the maneuver is not stated.
    """
    # Remove a unit in brackets, or in the characters that MATLAB and R put in place of brackets.
    plain = _UNIT_BEGINS.split(name, maxsplit=1)[0] or name
    steps = [step for step in _PATH_BREAKS.split(plain) if step.strip()] or [""]
    word, key, number = by_words(unit_in(steps[-1])[0])
    if len(word) < _SHORTEST_WORD and number is None:
        key = None
    words = [word.lower() for step in steps for word in _TOKENS.findall(step)]
    runs = ("".join(words[i:j]) for i in range(len(words)) for j in range(i + 1, i + 5))
    key = key or column_of_joint(plain)
    key = key or next((KEYS[run] for run in runs if run in KEYS and _COMPOUND.search(run)), None)
    if key is None or key == TIME:
        return None, None
    return key, _maneuver_in_words(name, request)


def unknown_units(names: Mapping[str, str]) -> list[UnknownUnit]:
    """Return the first few unknown units in the column names; `names` maps these to their keys."""
    found = ((name, unknown_unit(name), key) for name, key in names.items())
    return [UnknownUnit(name, unit, key) for name, unit, key in found if unit is not None][
        :NAMES_SHOWN
    ]


# Names of derivatives: D(roll), der(roll), Differential(t)(roll(t)), Derivative(roll(t), t),
# d(roll)/dt, roll_t(t).
_DERIVATIVE = re.compile(
    r"(?:d|der|diff|ddt|derivative|differential\(\w+\))\((\w+)(?:\(\w+\))?(?:, *\w+)?\)(?:/ *dt)?"
    r"|d *(\w+) */ *dt|(\w+?)(?:_|\u02cd)t(?:\(\w+\))?",
    re.IGNORECASE,
)
_UNIT_BEGINS = re.compile(r"[\[(]|\s+in\s+|(?<=\w)(?:__|\.\.)(?=\w)")
# Minimum length of a word that names a quantity [letters]. A single letter has many meanings,
# unless the name contains the number of a maneuver.
_SHORTEST_WORD = 2
# Characters between the components of a path, and pattern of the words in a component such as
# roll_angle or rollAngle.
_PATH_BREAKS = re.compile(r"[./|:\\]+")
_TOKENS = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")
# A name that ends in the kind of its quantity, after at least one letter that states which quantity
# of this kind it is.
_COMPOUND = re.compile(r".(?:angle|rate|velocity|speed|energy|dot)$")

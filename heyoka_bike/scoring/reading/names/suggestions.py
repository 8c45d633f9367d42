"""Similar names, lists of names for messages, and the column names that a user gives."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.reading.names.heading import (
    KEYS,
    TIME,
    by_words,
    is_known,
    is_maneuver,
    is_time,
    parse_heading,
)
from heyoka_bike.scoring.reading.names.heading_units import split_unit
from heyoka_bike.scoring.reading.request import LEFT_OUT, NAMES

# Maximum number of names in a message. Nobody would read a longer list.
NAMES_SHOWN = 8
NAMES_SPELT = 100
"""Maximum number of unknown names of a file that are compared letter by letter."""

# Minimum length of a name that is compared by its letters. Shorter names resemble too many other
# names.
_SHORTEST_ALIKE = 5
# Minimum number of equal letters at the beginning of two similar names. The beginning determines
# the quantity, but endings such as angle and rate do not.
_LETTERS_ALIKE = 3
LIKE = 0.63
"""Similarity of names that begin alike and may mean the same: `Rollwinkel` and `roll_angle`."""

ALMOST = 0.85
"""Similarity of a misspelt name and the correct one."""


def parse_column_names(columns: Sequence[str], option: str) -> tuple[str, ...]:
    """Return the column names that a user gave; raise an error if one of them is not known.

    Raises
    ------
    InputError
        A name is not known, or the names do not include the time and another column.
    """
    names = tuple(name.strip() for name in columns)
    where = option.rstrip("=")
    found = []
    for name in names:
        key = parse_heading(name).key
        if key is None and name not in LEFT_OUT and not is_maneuver(name):
            raise InputError(
                f"{where}: found {quoted(name)}, expected {NAMES}, a column of motion.h5, a short "
                f"name such as t, phi, v or delta, or - to skip a column"
                f"{did_you_mean(name)}"
            )
        if key is not None:
            found.append(key)
    if TIME not in found or len(found) < 2:
        raise InputError(f"{where}: expected the time and at least one more column")
    return names


@lru_cache(1 << 10)
def nearest(name: str, like: float = LIKE) -> str | None:
    """Return the known column whose name is most similar to a name; None if no name is similar."""
    from difflib import get_close_matches

    word = by_words(split_unit(name)[0])[0]
    if len(word) < _SHORTEST_ALIKE:
        return None
    known = [k for k in KEYS if len(k) >= _SHORTEST_ALIKE]
    begin_alike = [k for k in known if k[:_LETTERS_ALIKE] == word[:_LETTERS_ALIKE]]
    close = get_close_matches(word, begin_alike, 1, like)
    close = close or get_close_matches(word, known, 1, max(like, ALMOST))
    return KEYS[close[0]] if close else None


def did_you_mean(name: str) -> str:
    """Return the end of a message that suggests a known name; empty if no known name is similar."""
    like = nearest(name)
    return f"; did you mean {like}?" if like else ""


def listed(names: Sequence[str], like: float | None = None) -> str:
    """List some of the names in quotes, each with the known name that it resembles, if any."""
    found = [
        None if like is None or is_known(name) else nearest(name, like)
        for name in names[:NAMES_SHOWN]
    ]
    shown = ", ".join(
        f"{quoted(name)} ({near}?)" if near else quoted(name)
        for name, near in zip(names, found, strict=False)
    )
    more = len(names) - NAMES_SHOWN
    return f"{shown} and {more} more" if more > 0 else shown


def names_found(names: Sequence[str], found: Sequence[object] | None = None) -> str:
    """Return words for a message: the unknown names, or the known names if they do not suffice."""
    known = [is_known(name) for name in names] if found is None else found
    unknown = [name for name, k in zip(names, known, strict=True) if not k]
    if unknown:
        return f"column names {listed(unknown, LIKE)} not understood"
    if not names:
        return "no column whose name is known"
    has_time = any(map(is_time, names))
    return f"column names {listed(names)}{'' if has_time else ' without their times'}"

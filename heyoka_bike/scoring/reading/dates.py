"""Convert times of day, with or without a date, to seconds from the first row.

A run takes far less than a day, so the date is not needed. A time of day that is more than half a
day earlier than the one before belongs to the next day.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime
from decimal import Decimal
from typing import Any

import numpy as np

_TIME_OF_DAY = re.compile(
    r"(?:\S.*[\sT_])?(?:([0-9]{1,2}):)?([0-9]{1,2}):([0-9]{1,2}(?:[.,][0-9]*)?)"
    r"\s*([AaPp][Mm])?\s*(?:Z|UTC|GMT|[+-][0-9]{2}:?[0-9]{2})?"
)
_SECONDS_OF_DAY = 86_400
# Maximum length of a text that is parsed as a time of day [characters].
_LONGEST = 60


def first_date(source: Any) -> str | None:
    """Return the first time of day as written; None if the times are not times of day."""
    numbers = seconds_from_first(source)
    return None if numbers is None else " ".join(str(np.ravel(source[()])[0]).split())


def seconds_from_first(source: Any) -> list[str] | None:
    """Convert times of day to decimals, in seconds from the first; None for other times.

    Parameters
    ----------
    source
        An array-like object with dates of NumPy or Python, or with words.
    """
    kind = getattr(source, "dtype", np.dtype("f8")).kind
    if kind not in "MOU":
        return None
    array = np.ravel(source[()])
    if not array.size:
        return None
    if kind == "O" and all(isinstance(x, datetime) for x in array):
        array, kind = np.array([x.replace(tzinfo=None) for x in array], "M8[us]"), "M"
    if kind == "M":
        if np.isnat(array).any():
            return None
        counts = array.astype("M8[ns]").astype(np.int64)
        return [_plain(Decimal(x).scaleb(-9)) for x in (counts - counts[0]).tolist()]
    if not isinstance(array[0], str) or _since_midnight(array[0]) is None:
        return None
    times = [_since_midnight(x) if isinstance(x, str) else None for x in array.tolist()]
    return None if None in times else _from_first([x for x in times if x is not None])


def _since_midnight(word: str) -> Decimal | None:
    """Return the seconds since midnight; None if the word is not a time of day."""
    match = _TIME_OF_DAY.fullmatch(word.strip()) if len(word) <= _LONGEST else None
    if match is None:
        return None
    hours, half = int(match[1] or 0), (match[4] or "").lower()
    if half:
        hours = hours % 12 + 12 * (half == "pm")
    return 3600 * hours + 60 * int(match[2]) + Decimal(match[3].replace(",", "."))


def _from_first(times: Sequence[Decimal]) -> list[str]:
    days, found = 0, []
    for before, time in zip([times[0], *times], times, strict=False):
        # Rows may be out of order, so only a step back by more than half a day means that the next
        # day has begun.
        days += before - time > _SECONDS_OF_DAY / 2
        found.append(_plain(time + _SECONDS_OF_DAY * days - times[0]))
    return found


def _plain(x: Decimal) -> str:
    return f"{x:f}"

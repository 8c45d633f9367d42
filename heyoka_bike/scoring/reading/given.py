"""Results as a user passes them: files, arrays, columns by name, or several of these."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from numbers import Integral
from os import PathLike
from typing import Any

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.findings import maneuvers
from heyoka_bike.scoring.reading.names.heading import TIME, is_known, is_time
from heyoka_bike.scoring.reading.names.suggestions import did_you_mean
from heyoka_bike.scoring.reading.request import NAMES, maneuver_number
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.scored import Scored

_KINDS_OF_FILES = (Results, str, PathLike)


def results_of(
    given: Any,
    count: int,
    *,
    maneuver: int | None = None,
    columns: str | Sequence[str] | None = None,
    named: Mapping[str, Any] | None = None,
    is_only: bool = True,
) -> list[Results]:
    """Read the results of one run from any object that contains them.

    Parameters
    ----------
    given
        Anything that `read_results` accepts or returns; a list of such files or results; or a
        mapping from maneuver numbers to any of these. With named columns, the times [s] or None.
    count
        Number of maneuvers of the reference.
    maneuver, columns
        As in `read_results`; the columns may also be one text, separated by commas.
    named
        Columns by name.
    is_only
        True if results that contain other maneuvers than `maneuver` are refused.

    Raises
    ------
    InputError
        The object does not contain such results.
    """
    names = None if columns is None else words(columns, "columns")
    number = None if maneuver is None else maneuver_number(maneuver, count)
    if isinstance(given, Scored):
        raise InputError(
            f"found a {type(given).__name__}, which is a score already; expected the results "
            "themselves"
        )
    if named:
        given = _with_time(given, named)
    parts = [(number, given)]
    if isinstance(given, list | tuple) and all(isinstance(x, _KINDS_OF_FILES) for x in given):
        parts = [(number, x) for x in given]
    elif isinstance(given, Mapping) and given and all(isinstance(k, Integral) for k in given):
        if number is not None:
            raise InputError(
                f"found maneuver={maneuver} and results by maneuver number, expected only one of "
                "them"
            )
        numbers = [maneuver_number(key, count) for key in given]
        if any(isinstance(x, _KINDS_OF_FILES) for x in given.values()):
            parts = list(zip(numbers, given.values(), strict=True))
    found = []
    for n, part in parts:
        if not isinstance(part, Results):
            part = read_results(part, maneuver=n, count=count, columns=names)
        found.append(_of_maneuver(part, n, is_only))
    return found


def words(given: str | Sequence[str], what: str) -> list[str]:
    """Return a list of words from one text with commas, or from a list of texts.

    Raises
    ------
    InputError
        `given` is anything else.
    """
    if isinstance(given, str):
        return given.split(",")
    if isinstance(given, list | tuple) and all(isinstance(x, str) for x in given):
        return list(given)
    raise InputError(f"{what}: found {given!r:.40}, expected a string, or a list of strings")


def several(given: Any) -> list[Any]:
    """Check that results are a list for several runs or programs, and return the list.

    Raises
    ------
    InputError
        `given` is not a list, or is empty.
    """
    if not isinstance(given, Sequence) or isinstance(given, str) or not given:
        found = "no results" if isinstance(given, list | tuple) else f"a {type(given).__name__}"
        raise InputError(f"found {found}, expected a list of results")
    return list(given)


def _with_time(time: Any, named: Mapping[str, Any]) -> dict[str, Any]:
    """Return named columns with the times; raise an error for a name that is not of a column."""
    for name in named:
        if not any(map(is_known, (name, name.removesuffix("_lo")))):
            raise InputError(
                f"found a column {quoted(name)}, expected {NAMES}, or a column of motion.h5"
                f"{did_you_mean(name)}"
            )
    has_time = any(map(is_time, named))
    if has_time == (time is not None):
        found = "times twice" if has_time else "columns without their times"
        raise InputError(f"found {found}, expected score(t, roll_angle=...) or score(time=t, ...)")
    return dict(named) if has_time else {TIME: time, **named}


def _of_maneuver(results: Results, number: int | None, is_only: bool) -> Results:
    """Return results with this maneuver number; raise an error if they have another number.

    Results without a number get this number. If the number is None, the results are unchanged.
    """
    held = [rows.maneuver for rows in results.maneuvers]
    if number is None or held == [number] or (number in held and not is_only):
        return results
    if held == [None]:
        return replace(results, maneuvers=(replace(results.maneuvers[0], maneuver=number),))
    raise InputError(
        f"found the number of maneuver {number} for results of {_held_words(held)}; leave out the "
        "number",
        file=results.path,
    )


def _held_words(held: Sequence[int | None]) -> str:
    """Return a list in words of the maneuvers in results, or the number of unnamed maneuvers."""
    numbers = [n for n in held if n is not None]
    return maneuvers(numbers) if numbers else f"{len(held)} maneuvers without numbers"

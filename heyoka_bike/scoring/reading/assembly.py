"""Assemble the results of a file from its tables: one block per maneuver, sorted by time."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain

import numpy as np

from heyoka_bike.errors import quoted
from heyoka_bike.scoring.evidence.as_read import NotCompared, NotFinite, Reason
from heyoka_bike.scoring.evidence.base import Evidence, LostColumn
from heyoka_bike.scoring.reading.layout import ColumnLayout, layout_of
from heyoka_bike.scoring.reading.names.heading import TIME
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.results import Results, Rows
from heyoka_bike.scoring.reading.table import ReadTable
from heyoka_bike.scoring.reading.times import Times, settle, with_nanoseconds

_BadPlace = tuple[int, int, str, int]
"""Number of the line or row, column, the word "line" or "row", and count of values not finite."""

_log = logging.getLogger(__name__)


def assemble(tables: Sequence[ReadTable], kind: str, request: Request) -> Results:
    """Assemble the results of a file from its tables.

    Parameters
    ----------
    tables
        The tables of the file.
    kind
        Format of the file.
    request
        The request to read it.

    Raises
    ------
    InputError
        Columns cannot be identified, a maneuver is not in the reference, or a time is not finite.
    """
    known, seen = _of_the_reference(tables, request)
    for table in known:
        _refuse_unfilled(table, request)
    maneuvers: list[Rows] = []
    digits: list[int] = []
    bad: list[_BadPlace] = []
    every = [*chain.from_iterable(_one_by_one(x, request) for x in known)]
    # If the file contains several tables, a maneuver in the comments may belong to any of them.
    is_alone = len(every) == 1
    for table, places in every:
        if places.nanoseconds is not None:
            table = with_nanoseconds(table, places.time, places.nanoseconds)
        times = settle(table, places.time, request, places.unit)
        found = (*table.seen, *places.seen, *times.seen)
        seen += [x for x in found if x not in seen]
        for named, columns in places.maneuvers.items():
            number = table.commented if named is None and is_alone else named
            _log.info(
                "%s: %s, %d rows, maneuver %s: time is column %d, %s", request.path, kind,
                len(times.hi), number or "unknown", places.time + 1,
                ", ".join(f"{key} {j + 1}" for key, j in columns.items()),
            )  # fmt: skip
            maneuvers.append(_rows(table, times, number, places, columns, bad))
            used = [table.columns[j].digits for j in columns.values()]
            digits += [d for d in used if d is not None]
    seen += [_not_finite(bad)] if bad else []
    maneuvers.sort(key=lambda rows: rows.maneuver or 0)
    return Results(request.path, kind, tuple(maneuvers), min(digits, default=None), tuple(seen))


def _refuse_unfilled(table: ReadTable, request: Request) -> None:
    """Raise an error if the last rows contain only zeros, because the array was not filled."""
    count = len(table.columns[0].values)
    is_zero = np.logical_and.reduce([column.values == 0 for column in table.columns])
    first = count - int(np.argmin(is_zero[::-1])) if not is_zero.all() else 0
    if 0 < first < count - 1:
        said = f"found {count - first} rows of zeros at the end, expected values in every row"
        raise table.error(request, first, said)


def _of_the_reference(
    tables: Sequence[ReadTable], request: Request
) -> tuple[list[ReadTable], list[Evidence]]:
    """Return the tables of maneuvers in the reference, and evidence of tables left out.

    Tables without a maneuver number are kept, too.
    """
    numbers, asked = {None, *range(1, request.count + 1)}, request.maneuver
    parts = [part for table in tables for part in _by_maneuver(table, request)]
    known = [part for part in parts if part.maneuver in numbers]
    others = [part.maneuver for part in parts if part.maneuver not in numbers]
    if not known:
        raise request.error(f"found maneuver {others[0]}, expected 1 to {request.count}")
    if len(known) == 1 and asked is not None and known[0].maneuver not in (None, asked):
        raise request.error(f"found maneuver {known[0].maneuver}, expected maneuver {asked}")
    lost = tuple(LostColumn(f"maneuver {number}", maneuver=number) for number in others)
    return known, [NotCompared(Reason.NO_SUCH_MANEUVER, lost)] if lost else []


def _by_maneuver(table: ReadTable, request: Request) -> list[ReadTable]:
    """Split a table by its column of maneuver numbers; without one, return the table alone."""
    headings, count = table.headings(request), request.count
    at = next((j for j, heading in enumerate(headings) if heading.is_maneuver), None)
    if at is None or at >= len(table.columns) or table.maneuver is not None:
        return [table]
    numbers = table.columns[at].values
    first = 0 if count > 1 and (numbers == 0).any() else 1
    fits = (numbers == np.rint(numbers)) & (numbers >= first) & (numbers < first + count)
    if not fits.all():
        i = int(np.argmin(fits))
        found = f"{numbers[i]:.6g}" if np.isfinite(numbers[i]) else "no number"
        name, last = quoted(headings[at].text), first + count - 1
        said = f"found {found} in the column {name}, expected {first} to {last}"
        raise table.error(request, i, said)
    return [table.of_rows(numbers == n, int(n) + 1 - first) for n in np.unique(numbers)]


def _one_by_one(table: ReadTable, request: Request) -> Iterator[tuple[ReadTable, ColumnLayout]]:
    """Yield a table and its layout, or each part of a table with several maneuvers in sequence.

    Each maneuver begins where the times return to the first time.
    """
    places = layout_of(table, request)
    times = table.columns[places.time].values
    starts = np.flatnonzero(np.r_[True, times[1:] < times[:-1]])
    is_again = len(starts) > 1 and bool((times[starts] == times[0]).all())
    if not is_again or len(starts) > request.count or len(places.maneuvers) > 1:
        yield table, places
    elif None not in places.maneuvers:
        said = f"found times that begin {len(starts)} times at {times[0]:g}, expected one maneuver"
        raise request.error(f"{said}; for several maneuvers, add a column named maneuver")
    else:
        number = np.cumsum(np.isin(np.arange(len(times)), starts))
        for n in range(1, len(starts) + 1):
            yield table.of_rows(number == n, None), places


def _rows(
    table: ReadTable, times: Times, number: int | None, places: ColumnLayout,
    columns: Mapping[str, int], bad: list[_BadPlace],
) -> Rows:  # fmt: skip
    meant = {key: places.headings[j] for key, j in columns.items() if places.headings}
    used = {key: table.columns[j] for key, j in columns.items()}
    order = slice(None) if times.order is None else times.order
    values = {}
    for key, column in used.items():
        is_bad = ~np.isfinite(column.values)
        if is_bad.any() and not is_bad.all():
            counted_by, line = table.place(int(np.argmax(is_bad)))
            bad.append((line, columns[key] + 1, counted_by, int(is_bad.sum())))
        finite = np.where(is_bad, np.nan, column.values) if is_bad.any() else column.values
        values[key] = finite[order]
    lo = {key: column.lo[order] for key, column in used.items() if column.lo is not None}
    units = {key: unit for key, heading in meant.items() if (unit := heading.known_unit)}
    if places.unit != "s":
        units[TIME] = places.unit
    may_be = {key: keys for key, heading in meant.items() if (keys := heading.may_be)}
    quantum = {key: table.columns[j].quantum for key, j in {TIME: places.time, **columns}.items()}
    return Rows(number, times.hi, times.lo, values, lo, quantum, units, may_be)


def _not_finite(bad: Sequence[_BadPlace]) -> NotFinite:
    """Return evidence of values that are not finite: how many they are, and where the first is."""
    line, column, counted_by, _ = min(bad)
    return NotFinite(sum(n for *_, n in bad), counted_by, line, column)

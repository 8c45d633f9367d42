"""Find the layout of a table: the meaning of each column, by its name or its place."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED
from heyoka_bike.errors import quoted
from heyoka_bike.scoring.evidence.as_read import NamesNotUsed, Reason
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.reading.names.heading import (
    TIME,
    Heading,
    Meaning,
    nanoseconds_beside,
    quantity_of,
)
from heyoka_bike.scoring.reading.names.heading_units import is_si, split_unit
from heyoka_bike.scoring.reading.names.left_out import (
    column_within,
    left_out,
    set_aside,
    unknown_units,
)
from heyoka_bike.scoring.reading.names.meanings import letter_of, meant_together, with_meaning
from heyoka_bike.scoring.reading.names.suggestions import names_found
from heyoka_bike.scoring.reading.request import LEFT_OUT, Request
from heyoka_bike.scoring.reading.table import ReadColumn, ReadTable
from heyoka_bike.scoring.units import factor

# Rounding error of the conversion of a unit, such as degrees, relative to the largest value of the
# column.
_ROUNDING = 1e-14


@dataclass(frozen=True, slots=True)
class ColumnLayout:
    """The meaning of each column of a table.

    Attributes
    ----------
    time
        Index of the column of times.
    maneuvers
        Index of each other column, by number of the maneuver (None if unknown) and key.
    headings : tuple of Heading
        Heading of each column with its meaning; empty if the table has no headings.
    seen : tuple of Evidence
    unit
        Unit of the times, one of `UNITS_OF_TIME`.
    nanoseconds
        Index of a column of nanoseconds to add to times in whole seconds; None without one.
    """

    time: int
    maneuvers: Mapping[int | None, Mapping[str, int]]
    headings: tuple[Heading, ...]
    seen: tuple[Evidence, ...]
    unit: str
    nanoseconds: int | None = None


def layout_of(vectors: ReadTable, request: Request) -> ColumnLayout:
    """Return the layout of a table: the meaning of each column.

    The names determine the columns if all names are known, or if a known name contradicts the
    benchmark's order. Otherwise, the places determine them if there are 9 or 1 + 8 count columns.
    Otherwise, the known names do, and the other columns are left out.

    Raises
    ------
    InputError
        The columns cannot be identified, or one of them occurs twice.
    """
    headings = meant_together(vectors.headings(request), request.count)
    names = [h.text for h in headings]
    width = len(vectors.columns)
    found = [h.meaning for h in headings]
    known = [h.key for h in headings if h.key is not None]
    is_named = TIME in known and len(known) > 1
    # A file with columns beyond those of the benchmark is not in the benchmark's order.
    is_beyond = not {*known} <= {TIME, *BENCHMARK_COLUMNS}
    is_beyond |= any(h.is_maneuver for h in headings)
    places = _meanings_by_place(width, request.count) if vectors.is_ordered else None
    unused = _names_unused(headings, places or ())
    names_decide = places is None or None not in found or is_beyond or bool(unused)
    if request.names or (is_named and names_decide):
        return _assigned(headings, vectors, request)
    if places is not None and not _contradict_places(headings, places, request):
        by_place = _assigned([Heading("", *place) for place in places], vectors, request)
        # A heading may contain a unit even if the name in it is unknown.
        both = zip(headings, places, strict=False)
        meant = tuple(with_meaning(h, place) for h, place in both)
        return replace(by_place, headings=meant, seen=unused)
    raise request.not_columns(names_found(names, found), vectors.heading)


def _contradict_places(
    headings: Sequence[Heading], places: Sequence[Meaning], request: Request
) -> bool:
    """True if a name contradicts the place of its column in the benchmark's order.

    A name contradicts it if it is, or contains, the name of another quantity, but not if it is a
    single letter.
    """
    for h, (key, _) in zip(headings, places, strict=False):
        is_letter = bool(letter_of(split_unit(h.text)[0]))
        is_usable = h.key is not None and not h.is_time and not is_letter
        held = h.key if is_usable else column_within(h.text, request)[0]
        if held is not None and held != key:
            return True
    return False


def _meanings_by_place(width: int, count: int) -> Sequence[Meaning] | None:
    """Return the meanings of columns by their places; None for an unexpected number of columns."""
    # If there is only one maneuver, its columns need no number.
    by_width: Mapping[int, Sequence[int | None]] = {1 + 8 * count: range(1, count + 1), 9: [None]}
    if (numbers := by_width.get(width)) is None:
        return None
    columns = ((key, number) for number in numbers for key in BENCHMARK_COLUMNS)
    return [(TIME, None), *columns]


def _assigned(headings: Sequence[Heading], vectors: ReadTable, request: Request) -> ColumnLayout:
    """Return the layout with one column for each meaning."""
    meant: dict[Meaning, int] = {}
    contradicting: set[int] = set()
    every = ((meaning, i) for i, h in enumerate(headings) if (meaning := h.meaning) is not None)
    for meaning, places in grouped(every).items():
        # If several columns have the same meaning, use the one with the plainest name.
        best, *others = sorted(places, key=lambda i: _oddity(headings[i]))
        if others and _oddity(headings[others[0]]) == _oddity(headings[best]):
            key, number = meaning
            of_which = "" if number is None else f" for maneuver {number}"
            raise request.error(
                f"found {quoted(headings[best].text)} and {quoted(headings[others[0]].text)}, "
                f"expected one column of {key.replace('_', ' ')}{of_which}; {request.columns_hint}",
                vectors.heading,
            )
        meant[meaning] = best
        if meaning[0] != TIME:
            first = vectors.columns[best], headings[best]
            contradicting |= {
                i for i in others if not _are_the_same(first, (vectors.columns[i], headings[i]))
            }
    time = meant[TIME, None]
    alone = request.maneuver if vectors.maneuver is None else vectors.maneuver
    alone = 1 if alone is None and request.count == 1 else alone
    maneuvers: dict[int | None, dict[str, int]] = {}
    for (key, number), i in meant.items():
        if key != TIME:
            maneuvers.setdefault(alone if number is None else number, {})[key] = i
    if alone is not None and alone not in maneuvers and len(maneuvers) == 1:
        said = f"found columns of maneuver {next(iter(maneuvers))}, expected maneuver {alone}"
        raise request.error(said, vectors.heading)
    nanoseconds = nanoseconds_beside([h.text for h in headings], headings[time].text)
    used = {*meant.values(), *([] if nanoseconds is None else [nanoseconds])}
    seen = _not_used(headings, used, contradicting, request)
    seen += unknown_units({headings[i].text: key for (key, _), i in meant.items()})
    unit = headings[time].known_unit or "s"
    return ColumnLayout(time, maneuvers, tuple(headings), tuple(seen), unit, nanoseconds)


def _are_the_same(first: tuple[ReadColumn, Heading], second: tuple[ReadColumn, Heading]) -> bool:
    """True if two columns contain the same values after conversion from their named units."""
    values, bounds = [], []
    for column, heading in (first, second):
        assert heading.key is not None
        to_si = factor(heading.known_unit or COMPARED[heading.key][0].unit)[0]
        values.append(to_si * column.values)
        bounds.append(to_si * column.quantum.at(column.values))
    one, other = values
    are_finite = np.isfinite(one) & np.isfinite(other)
    if not np.array_equal(one[~are_finite], other[~are_finite], equal_nan=True):
        return False
    one, other = one[are_finite], other[are_finite]
    # Each column may be rounded when it is converted, and again when it is written.
    bound = (bounds[0] + bounds[1])[are_finite] + _ROUNDING * np.max(np.abs(one), initial=0.0)
    return bool(np.all(np.abs(other - one) <= bound))


def _not_used(
    headings: Sequence[Heading], used: Collection[int], contradicting: Collection[int],
    request: Request,
) -> list[Evidence]:  # fmt: skip
    """Return evidence of the columns that are not used, except those that the user left out."""
    left = [i for i, h in enumerate(headings) if i not in used and h.text not in LEFT_OUT]
    left = [i for i in left if not headings[i].is_maneuver]
    known = [i for i in left if headings[i].key is None and quantity_of(headings[i].text)]
    others = [i for i in left if i in contradicting]
    explained = {*known, *others}
    unknown = [i for i in left if i not in explained]

    def named(places: Sequence[int]) -> list[str]:
        return [headings[i].text for i in places]

    seen = [set_aside(named(known), request)] if known else []
    seen += [set_aside(named(others), request, Reason.CONTRADICTS)] if others else []
    return [*seen, left_out(named(unknown), request)] if unknown else [*seen]


def _oddity(heading: Heading) -> tuple[bool, bool]:
    """Return a sort key of headings: SI units come first; of these, unit endings come last."""
    return not is_si(heading.unit), heading.is_ending


def _names_unused(
    headings: Sequence[Heading], places: Sequence[Meaning]
) -> tuple[NamesNotUsed, ...]:
    """Return evidence of known names that are not used: they contradict the places of columns."""
    both = enumerate(zip(headings, places, strict=False))
    wrong = [i for i, (h, (key, _)) in both if h.key not in (None, key)]
    if not wrong:
        return ()
    unknown = tuple(h.text for h in headings if h.key is None)
    return (NamesNotUsed(tuple(i + 1 for i in wrong), headings[wrong[0]].text, unknown),)

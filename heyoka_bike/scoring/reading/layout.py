"""The layout of a table: which column is what, by its name or its place."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED
from heyoka_bike.errors import quoted
from heyoka_bike.scoring.evidence.as_read import NamesNotUsed, Reason
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.reading.names.columns import (
    TIME,
    is_maneuver,
    named_unit,
    nanoseconds_beside,
    quantity_of,
    unit_in,
)
from heyoka_bike.scoring.reading.names.left_out import left_out, name_held, set_aside, unknown_units
from heyoka_bike.scoring.reading.names.meanings import Found, letter_of, meanings
from heyoka_bike.scoring.reading.names.units import is_si, quantities, split_unit
from heyoka_bike.scoring.reading.names.words import names_found
from heyoka_bike.scoring.reading.request import LEFT_OUT, Request
from heyoka_bike.scoring.reading.table import ReadColumn, ReadTable
from heyoka_bike.scoring.units import factor

# Of the largest value: what an angle that is written in degrees is off by in radians.
_ROUNDING = 1e-14


@dataclass(frozen=True, slots=True)
class ColumnLayout:
    """Which column is what.

    Attributes
    ----------
    time
        Index of the column of times.
    maneuvers
        Index of each other column, by number of the maneuver (None if that is not told) and key.
    seen : tuple of Evidence
    unit
        Of the times, one of `UNITS_OF_TIME`.
    nanoseconds
        Index of the column of what the times are more than whole seconds; None without one.
    """

    time: int
    maneuvers: Mapping[int | None, Mapping[str, int]]
    seen: tuple[Evidence, ...]
    unit: str
    nanoseconds: int | None = None


def layout_of(vectors: ReadTable, request: Request) -> ColumnLayout:
    """Find out which column is what.

    Names decide if they are all known, or if one that is known has another place than in the
    benchmark; else the place does, if there are 9 or 1 + 8 count columns; else those names that are
    known.

    Raises
    ------
    InputError
        The columns cannot be told, or one is there twice.
    """
    names = list(request.names or vectors.names or ())
    width = len(vectors.columns)
    found = meanings(names, request.count)
    known = [f[0] for f in found if f]
    is_named = TIME in known and len(known) > 1
    # The benchmark's order has no place for what is not of the benchmark.
    is_beyond = not {*known} <= {TIME, *BENCHMARK_COLUMNS}
    is_beyond |= any(map(is_maneuver, names))
    places = _meanings_by_place(width, request.count) if vectors.is_ordered else None
    unused = _names_unused(names, found, places or ())
    names_decide = places is None or None not in found or is_beyond or bool(unused)
    if request.names or (is_named and names_decide):
        return _settled(names, found, vectors, request)
    if places is not None and not _are_held_elsewhere(names, found, places, request):
        return replace(_settled([""] * width, places, vectors, request), seen=unused)
    raise request.not_columns(names_found(names, found), vectors.heading)


def _are_held_elsewhere(
    names: Sequence[str], found: Sequence[Found], places: Sequence[Found], request: Request
) -> bool:
    """True if a name is, or holds, that of a quantity that has another place; no mere letter."""
    for name, f, place in zip(names, found, places, strict=False):
        is_letter = bool(letter_of(split_unit(name)[0]))
        held = f[0] if f and f[0] != TIME and not is_letter else name_held(name, request)[0]
        if held is not None and place is not None and held != place[0]:
            return True
    return False


def _meanings_by_place(width: int, count: int) -> Sequence[Found] | None:
    """Return the meanings of columns without names; None if there are too many or too few."""
    # One maneuver needs no number.
    by_width: Mapping[int, Sequence[int | None]] = {1 + 8 * count: range(1, count + 1), 9: [None]}
    if (numbers := by_width.get(width)) is None:
        return None
    columns = ((key, number) for number in numbers for key in BENCHMARK_COLUMNS)
    return [(TIME, None), *columns]


def _settled(
    names: Sequence[str], found: Sequence[Found], vectors: ReadTable, request: Request
) -> ColumnLayout:
    """Each meaning with the one column that has it."""
    meant: dict[tuple[str, int | None], int] = {}
    contradicting: set[int] = set()
    for meaning, places in grouped((f, i) for i, f in enumerate(found) if f is not None).items():
        # Of several columns of one meaning the plainest name is meant.
        best, *others = sorted(places, key=lambda i: _oddity(names[i]))
        if others and _oddity(names[others[0]]) == _oddity(names[best]):
            key, number = meaning
            of_which = "" if number is None else f" for maneuver {number}"
            raise request.error(
                f"found {quoted(names[best])} and {quoted(names[others[0]])}, expected one column "
                f"of {key.replace('_', ' ')}{of_which}; {request.how_to_tell}",
                vectors.heading,
            )
        meant[meaning] = best
        if meaning[0] != TIME:
            first = vectors.columns[best], names[best]
            contradicting |= {
                i
                for i in others
                if not _are_the_same(meaning[0], first, (vectors.columns[i], names[i]))
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
    nanoseconds = nanoseconds_beside(names, names[time])
    used = {*meant.values(), *([] if nanoseconds is None else [nanoseconds])}
    seen = _not_used(names, found, used, contradicting, request)
    seen += unknown_units({names[i]: key for (key, _), i in meant.items()})
    unit = quantities(unit_in(names[time])[1] or "").get("s", "s")
    return ColumnLayout(time, maneuvers, tuple(seen), unit, nanoseconds)


def _are_the_same(key: str, first: tuple[ReadColumn, str], second: tuple[ReadColumn, str]) -> bool:
    """True if two columns of a quantity hold the same values, each in the unit that it is named."""
    si, values, bounds = COMPARED[key][0].unit, [], []
    for column, name in (first, second):
        to_si = factor(named_unit(name, key) or si)[0]
        values.append(to_si * column.values)
        bounds.append(to_si * column.quantum.at(column.values))
    one, other = values
    are_finite = np.isfinite(one) & np.isfinite(other)
    if not np.array_equal(one[~are_finite], other[~are_finite], equal_nan=True):
        return False
    one, other = one[are_finite], other[are_finite]
    # Each is rounded as it is written, and when it was converted.
    bound = (bounds[0] + bounds[1])[are_finite] + _ROUNDING * np.max(np.abs(one), initial=0.0)
    return bool(np.all(np.abs(other - one) <= bound))


def _not_used(
    names: Sequence[str], found: Sequence[Found], used: Collection[int],
    contradicting: Collection[int], request: Request,
) -> list[Evidence]:  # fmt: skip
    """Return evidence of columns that are not used, unless the user left them out."""
    left = [i for i in range(len(names)) if i not in used and names[i] not in LEFT_OUT]
    left = [i for i in left if not is_maneuver(names[i])]
    known = [i for i in left if found[i] is None and quantity_of(names[i])]
    others = [i for i in left if i in contradicting]
    told = {*known, *others}
    unknown = [i for i in left if i not in told]

    def named(places: Sequence[int]) -> list[str]:
        return [names[i] for i in places]

    seen = [set_aside(named(known), request)] if known else []
    seen += [set_aside(named(others), request, Reason.CONTRADICTS)] if others else []
    return [*seen, left_out(named(unknown), request)] if unknown else [*seen]


def _oddity(name: str) -> tuple[bool, bool]:
    """True if a name has a unit other than SI, and true if it has its unit as an ending."""
    _, unit, is_ending = unit_in(name)
    return not is_si(unit), is_ending


def _names_unused(
    names: Sequence[str], found: Sequence[Found], places: Sequence[Found]
) -> tuple[NamesNotUsed, ...]:
    """Tell whether a name that is known contradicts the place of its column."""
    both = enumerate(zip(found, places, strict=False))
    wrong = [i for i, (f, place) in both if f and place and f[0] != place[0]]
    if not wrong:
        return ()
    unknown = tuple(name for name, f in zip(names, found, strict=True) if f is None)
    return (NamesNotUsed(tuple(i + 1 for i in wrong), names[wrong[0]], unknown),)

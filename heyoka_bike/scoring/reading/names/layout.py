"""What the columns of a result file are: by their names, or by their place."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.findings import Finding, warning
from heyoka_bike.scoring.reading.names.columns import (
    TIME,
    did_you_mean,
    is_maneuver,
    left_out,
    listed,
    names_found,
    recognise,
    set_aside,
    unit_in,
    unknown_units,
)
from heyoka_bike.scoring.reading.names.numbers import Found, meanings
from heyoka_bike.scoring.reading.names.units import is_millisecond, is_si
from heyoka_bike.scoring.reading.request import LEFT_OUT, Request
from heyoka_bike.scoring.reading.vectors import Vectors


@dataclass(frozen=True, slots=True)
class Layout:
    """Which column is what.

    Attributes
    ----------
    time : int
        Index of the column of times.
    maneuvers : mapping of (int or None) to mapping of str to int
        Index of each column, by number of the maneuver (None if that is not told) and key.
    findings : tuple of Finding
    in_milliseconds : bool
        Whether the times are, as their heading says.
    """

    time: int
    maneuvers: Mapping[int | None, Mapping[str, int]]
    findings: tuple[Finding, ...] = ()
    in_milliseconds: bool = False


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
                f"{where}: found {quoted(name)}, expected time, {', '.join(BENCHMARK_COLUMNS)}, "
                "a column of motion.h5, a short name such as t, phi, v or delta, or - for one that "
                f"is left out{did_you_mean(name)}"
            )
        if known is not None:
            found.append(known[0])
    if TIME not in found or len(found) < 2:
        raise InputError(f"{where}: found no time and another column, expected both among them")
    return names


def layout(vectors: Vectors, request: Request) -> Layout:
    """Find out which column is what.

    Names decide if they are all known; else the place does, if there are 9 or 1 + 8 count columns;
    else those names that are known.

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
    is_beyond = not {*known} <= {TIME, *BENCHMARK_COLUMNS} or any(map(is_maneuver, names))
    places = _by_place(width, request.count) if vectors.is_ordered else None
    if request.names or (is_named and (places is None or None not in found or is_beyond)):
        return _settled(names, found, vectors, request)
    if places is not None:
        settled = _settled([""] * width, places, vectors, request)
        return replace(settled, findings=_names_unused(names, found, places))
    raise request.not_columns(names_found(names, found), vectors.heading)


def _by_place(width: int, count: int) -> Sequence[Found] | None:
    """What columns without names mean; None if there are too many or too few."""
    # One maneuver needs no number.
    by_width: Mapping[int, Sequence[int | None]] = {1 + 8 * count: range(1, count + 1), 9: [None]}
    if (numbers := by_width.get(width)) is None:
        return None
    return [(TIME, None), *((key, number) for number in numbers for key in BENCHMARK_COLUMNS)]


def _settled(
    names: Sequence[str], found: Sequence[Found], vectors: Vectors, request: Request
) -> Layout:
    """Each meaning with the one column that has it."""
    candidates: dict[tuple[str, int | None], list[int]] = {}
    for i, f in enumerate(found):
        if f is not None:
            candidates.setdefault(f, []).append(i)
    meant = {}
    for meaning, places in candidates.items():
        # Of several columns of one meaning the plainest name is meant.
        best, *others = sorted(places, key=lambda i: _oddity(names[i]))
        if others and _oddity(names[others[0]]) == _oddity(names[best]):
            said = _twice(names[best], names[others[0]], *meaning)
            raise request.error(f"{said}; {request.how_to_tell}", vectors.heading)
        meant[meaning] = best
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
    findings = _left_out(names, found, {*meant.values()}, request)
    findings += unknown_units({names[i]: key for (key, _), i in meant.items()})
    return Layout(time, maneuvers, tuple(findings), is_millisecond(unit_in(names[time])[1]))


def _left_out(
    names: Sequence[str], found: Sequence[Found], used: Collection[int], request: Request
) -> list[Finding]:
    """That columns are not used, unless that is what was told of them."""
    left = [i for i in range(len(names)) if i not in used and names[i] not in LEFT_OUT]
    left = [i for i in left if not is_maneuver(names[i])]
    known = [names[i] for i in left if found[i] is None and recognise(names[i])]
    unknown = [names[i] for i in left if names[i] not in known]
    findings = [set_aside(known, request)] if known else []
    return [*findings, left_out(unknown)] if unknown else findings


def _twice(name: str, other: str, key: str, number: int | None) -> str:
    of_which = "" if number is None else f" for maneuver {number}"
    one = f"expected one column of {key.replace('_', ' ')}{of_which}"
    return f"found {quoted(name)} and {quoted(other)}, {one}"


def _oddity(name: str) -> tuple[bool, bool]:
    """Whether a name has another unit than those of SI, and whether it has its unit in words."""
    _, unit, is_ending = unit_in(name)
    return not is_si(unit), is_ending


def _names_unused(
    names: Sequence[str], found: Sequence[Found], places: Sequence[Found]
) -> tuple[Finding, ...]:
    """What is to be said if a name that is known contradicts the place of its column."""
    both = enumerate(zip(found, places, strict=False))
    wrong = [i for i, (f, place) in both if f and place and f[0] != place[0]]
    if not wrong:
        return ()
    unknown = [name for name, f in zip(names, found, strict=True) if f is None]
    said = (
        f"Not all column names are known ({listed(unknown)}), so the columns are taken in the "
        f"benchmark's order, although column {wrong[0] + 1} is named {quoted(names[wrong[0]])}."
    )
    shown = [quoted(name)[1:-1] for name in unknown[:100]]
    return (warning("names_not_used", said, columns=[i + 1 for i in wrong], unknown=shown),)

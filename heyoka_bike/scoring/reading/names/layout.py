"""What the columns of a result file are: by their names, or by their place."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.reading.names.columns import (
    TIME,
    arrays_not_understood,
    is_maneuver,
    left_out,
    listed,
    nearest,
    not_understood,
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
            like = nearest(name)
            hint = f"; did you mean {like}?" if like else ""
            raise InputError(
                f"{where}: found {quoted(name)}, expected time, {', '.join(BENCHMARK_COLUMNS)}, "
                "a column of motion.h5, a short name such as t, phi, v or delta, or - for one that "
                f"is left out{hint}"
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
    count, names = request.count, vectors.names
    width, rows = len(vectors.columns), len(vectors.columns[0].values)
    alone = request.maneuver if vectors.maneuver is None else vectors.maneuver
    alone = 1 if alone is None and count == 1 else alone

    def fail(message: str) -> InputError:
        return request.error(message, vectors.heading)

    if request.names is not None:
        if len(request.names) != width:
            raise fail(request.wrong_width(width, rows))
        return _by_name(request.names, alone, request, fail)
    found = [] if names is None else meanings(names, count)
    # The benchmark's order has no place for what is not of the benchmark.
    is_beyond = any(f and f[0] not in (TIME, *BENCHMARK_COLUMNS) for f in found)
    is_beyond = is_beyond or any(map(is_maneuver, names or ()))
    is_named = any(f and f[0] == TIME for f in found) and sum(f is not None for f in found) > 1
    places = _by_place(width, count, alone) if vectors.is_ordered else None
    if names is not None and is_named and (places is None or None not in found or is_beyond):
        return _by_name(names, alone, request, fail)
    if places is not None:
        return places if names is None else _with_names_unused(places, names, found)
    if not vectors.is_ordered:
        raise fail(arrays_not_understood(names or (), request, request.widths))
    raise fail(not_understood(names, request, found) if names else request.wrong_width(width, rows))


def _by_place(width: int, count: int, alone: int | None) -> Layout | None:
    if width == 1 + 8 * count and count > 1:
        numbers: list[int | None] = list(range(1, count + 1))
    elif width == 9:
        numbers = [alone]
    else:
        return None
    return Layout(
        0,
        {
            number: {key: 1 + 8 * i + k for k, key in enumerate(BENCHMARK_COLUMNS)}
            for i, number in enumerate(numbers)
        },
    )


def _by_name(
    names: Sequence[str], alone: int | None, request: Request, fail: Callable[[str], InputError]
) -> Layout:
    meant: dict[tuple[str, int | None], list[int]] = {}
    unknown, known = [], []
    for i, f in enumerate(meanings(names, request.count)):
        if f is not None:
            meant.setdefault(f, []).append(i)
        elif recognise(names[i]):
            known.append(names[i])
        elif names[i] not in LEFT_OUT and not is_maneuver(names[i]):
            unknown.append(names[i])
    first = {}
    for (key, number), candidates in meant.items():
        # Of several columns of one meaning the plainest name is meant.
        best, *others = sorted(candidates, key=lambda i: _oddity(names[i]))
        if others and _oddity(names[others[0]]) == _oddity(names[best]):
            of_which = "" if number is None else f" for maneuver {number}"
            raise fail(
                f"found {quoted(names[best])} and {quoted(names[others[0]])}, expected one column "
                f"of {key.replace('_', ' ')}{of_which}; {request.how_to_tell}"
            )
        first[key, number] = best
        unknown += [names[i] for i in others]
    maneuvers: dict[int | None, dict[str, int]] = {}
    for (key, number), i in first.items():
        if key != TIME:
            maneuvers.setdefault(alone if number is None else number, {})[key] = i
    if alone is not None and alone not in maneuvers and len(maneuvers) == 1:
        raise fail(f"found columns of maneuver {next(iter(maneuvers))}, expected maneuver {alone}")
    findings = [set_aside(known, request)] if known else []
    findings += [left_out(unknown)] if unknown else []
    findings += unknown_units({names[i]: key for (key, _), i in first.items()})
    time = first[TIME, None]
    return Layout(time, maneuvers, tuple(findings), is_millisecond(unit_in(names[time])[1]))


def _oddity(name: str) -> tuple[bool, bool]:
    """Whether a name has another unit than those of SI, and whether it has its unit in words."""
    _, unit, is_ending = unit_in(name)
    return not is_si(unit), is_ending


def _with_names_unused(places: Layout, names: Sequence[str], found: Sequence[Found]) -> Layout:
    """Say so if a name that is known contradicts the place of its column."""
    meant = {places.time: TIME}
    for columns in places.maneuvers.values():
        meant |= {i: key for key, i in columns.items()}
    wrong = [i for i, f in enumerate(found) if f is not None and f[0] != meant.get(i)]
    unknown = [names[i] for i, f in enumerate(found) if f is None]
    if not wrong:
        return places
    finding = Finding(
        "names_not_used",
        f"Not all column names are known ({listed(unknown)}), so the columns are taken in the "
        f"benchmark's order, although column {wrong[0] + 1} is named {quoted(names[wrong[0]])}.",
        Severity.WARNING,
        {"columns": [i + 1 for i in wrong], "unknown": [quoted(n)[1:-1] for n in unknown[:100]]},
    )
    return Layout(places.time, places.maneuvers, (finding,))

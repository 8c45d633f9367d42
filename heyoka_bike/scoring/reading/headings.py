"""What the columns of a result file are: by their names, or by their place."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.reading.column_names import (
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
)
from heyoka_bike.scoring.reading.expected import (
    LEFT_OUT,
    OPTION,
    Expected,
    how_to_tell,
    wrong_width,
)
from heyoka_bike.scoring.reading.heading_units import is_millisecond, is_si
from heyoka_bike.scoring.reading.numbered_names import Found, meanings

Fail = Callable[[str], InputError]
"""Makes the error for a message, with the file and the line of the names."""


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


def told(columns: Sequence[str], count: int, option: str = OPTION) -> Expected:
    """What columns of these names are.

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
                f"a column of motion.h5, or - for one that is left out{hint}"
            )
        if known is not None:
            found.append(known[0])
    if TIME not in found or len(found) < 2:
        raise InputError(f"{where}: found no time and another column, expected both among them")
    return Expected(count, names, option)


def layout(
    names: Sequence[str] | None, width: int, expected: Expected, maneuver: int | None, fail: Fail,
    *, ordered: bool = True, rows: int = 0,
) -> Layout:  # fmt: skip
    """Find out which column is what.

    Names decide if they are all known; else the place does, if there are 9 or 1 + 8 count columns;
    else those names that are known.

    Parameters
    ----------
    names
        Names of the columns, None if there are none.
    width
        Number of columns.
    expected
        What columns there may be.
    maneuver
        Number of the maneuver of columns that do not tell.
    fail
        Makes the error for a message.
    ordered
        Whether the place of a column means anything.
    rows
        Number of rows.

    Raises
    ------
    InputError
        The columns cannot be told, or one is there twice.
    """
    count = expected.count
    alone = 1 if maneuver is None and count == 1 else maneuver
    if expected.names is not None:
        if len(expected.names) != width:
            raise fail(wrong_width(width, rows, expected))
        found = meanings(expected.names, count)
        return _by_name(expected.names, found, alone, fail, expected.option)
    found = [] if names is None else meanings(names, count)
    # The benchmark's order has no place for what is not of the benchmark.
    is_beyond = any(f and f[0] not in (TIME, *BENCHMARK_COLUMNS) for f in found)
    is_beyond = is_beyond or any(map(is_maneuver, names or ()))
    is_named = any(f and f[0] == TIME for f in found) and sum(f is not None for f in found) > 1
    places = _by_place(width, count, alone) if ordered else None
    if names is not None and is_named and (places is None or None not in found or is_beyond):
        return _by_name(names, found, alone, fail, expected.option)
    if places is not None:
        return places if names is None else _with_names_unused(places, names, found)
    if not ordered:
        raise fail(arrays_not_understood(names or (), expected.widths, expected.option))
    if names:
        raise fail(not_understood(names, found))
    raise fail(wrong_width(width, rows, expected))


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
    names: Sequence[str], found: Sequence[Found], alone: int | None,
    fail: Fail, option: str,
) -> Layout:  # fmt: skip
    first: dict[tuple[str, int | None], int] = {}
    unknown, known = [], []
    for i, f in enumerate(found):
        if f is None and recognise(names[i]):
            known.append(names[i])
        elif f is None:
            unknown += [] if names[i] in LEFT_OUT or is_maneuver(names[i]) else [names[i]]
        elif f in first and (plainer := _plainer(names, first[f], i)) is not None:
            unknown.append(names[first[f] if plainer == i else i])
            first[f] = plainer
        elif f in first:
            raise fail(
                f"found {quoted(names[first[f]])} and {quoted(names[i])}, expected one column of "
                f"{f[0].replace('_', ' ')}{'' if f[1] is None else f' for maneuver {f[1]}'}; "
                f"{how_to_tell(option)}"
            )
        else:
            first[f] = i
    maneuvers: dict[int | None, dict[str, int]] = {}
    for (key, number), i in first.items():
        if key != TIME:
            maneuvers.setdefault(alone if number is None else number, {})[key] = i
    if alone is not None and (others := set(maneuvers) - {alone}) and len(maneuvers) == 1:
        raise fail(f"found columns of maneuver {others.pop()}, expected maneuver {alone}")
    findings = [set_aside(known, option)] if known else []
    findings += [left_out(unknown)] if unknown else []
    time = first[TIME, None]
    return Layout(time, maneuvers, tuple(findings), is_millisecond(unit_in(names[time])[1]))


def _plainer(names: Sequence[str], *twice: int) -> int | None:
    """Which of two columns of one meaning has SI units, and no unit in its name; None if both."""
    ranks = []
    for i in twice:
        _, unit, is_ending = unit_in(names[i])
        ranks.append((not is_si(unit), is_ending))
    return None if ranks[0] == ranks[1] else twice[ranks.index(min(ranks))]


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

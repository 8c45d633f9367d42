"""Reading of another program's results: files, whose content tells the format, and objects.

Objects of Python may be arrays, columns by name, data frames, or several results of one run.

Every column is put where it belongs, which its name or its place tells, and rows in the order of
time.
"""

import logging
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass, replace
from itertools import chain
from numbers import Integral
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.parameters import benchmark
from heyoka_bike.errors import InputError, MissingPackageError, printable, quoted
from heyoka_bike.scoring.evidence import (
    Evidence,
    LostColumn,
    NamesNotUsed,
    NotCompared,
    NotFinite,
    Reason,
)
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.reading import headings
from heyoka_bike.scoring.reading.arrays import tables
from heyoka_bike.scoring.reading.formats import FORMATS, why_not_read
from heyoka_bike.scoring.reading.quanta import Times, settle
from heyoka_bike.scoring.reading.request import (
    ARGUMENT,
    LEFT_OUT,
    NAMES,
    OPTION,
    Request,
    ResultFile,
)
from heyoka_bike.scoring.reading.results import Results, Rows, Vectors
from heyoka_bike.scoring.scored import Scored

ARRAY = "array"
"""Name and format of results that are no file."""

_FILES = (Results, str, PathLike)


def read_results(
    source: Any, *, maneuver: int | None = None, count: int | None = None,
    columns: Sequence[str] | None = None,
) -> Results:  # fmt: skip
    """Read the results of a program, from a file or from its arrays.

    Parameters
    ----------
    source : path, "-", array-like, mapping or data frame
        A file of one of the `formats`, compressed with gzip or not; ``-`` is standard input. Or an
        array of shape (n, 9), (n, 1 + 8 count) or (count, n, 9), one with named fields, a mapping,
        a data frame of pandas, polars or pyarrow, a dataset of xarray, what `simulate` returns, or
        a mapping of maneuvers' numbers to any of these. Columns are the time [s], which may be the
        index of a frame, and the benchmark's eight, in its order or named.
    maneuver
        Number of the maneuver, from 1, that columns belong to which do not tell.
    count
        Number of maneuvers of the reference; by default of the benchmark.
    columns
        What the columns are, in the order of the file, whatever their names in it: ``time``,
        ``roll_angle``, ``m2_steer_angle`` and so on, ``-`` for one that is left out.

    Returns
    -------
    Results
        Columns as written. Times [s] are exact decimals where the file means these.

    Raises
    ------
    InputError
        A file that cannot be read or that holds no such rows: where, what was found, and what was
        expected.
    MissingPackageError
        A package that is needed for its format is not installed.
    """
    count = len(benchmark()[1]) if count is None else count
    if maneuver is not None:
        maneuver = _number(maneuver, count)
    is_file = isinstance(source, str | PathLike)
    option = OPTION if is_file else ARGUMENT
    path = printable(str(source)) if is_file else ARRAY
    names = None if columns is None else headings.told(columns, option)
    request = Request(path, count, maneuver, names, option)
    return assemble(*_read_tables(source, request), request)


def read_columns(source: Any, known: Callable[[str], bool]) -> Vectors:
    """Read named columns without times, from what `read_results` takes.

    Parameters
    ----------
    source
    known
        True for the names of columns that are looked for.

    Raises
    ------
    InputError, MissingPackageError
        As of `read_results`.
    """
    path = printable(str(source)) if isinstance(source, str | PathLike) else ARRAY
    found, _ = _read_tables(source, Request(path, 1, known=known))
    return found[0]


def results_of(
    given: Any,
    count: int,
    *,
    maneuver: int | None = None,
    columns: str | Sequence[str] | None = None,
    named: Mapping[str, Any] | None = None,
    is_only: bool = True,
) -> list[Results]:
    """Results of one run, of anything that holds them.

    Parameters
    ----------
    given
        What `read_results` takes, or what it returned; a list of such files or results; a
        mapping of maneuvers' numbers to any of these. With named columns the times [s], or nothing.
    count
        Number of maneuvers of the reference.
    maneuver, columns
        As in `read_results`; the columns also as one text, separated by commas.
    named
        Columns by name.
    is_only
        True if results that hold other maneuvers than the one told are refused.

    Raises
    ------
    InputError
        It is none of that: what was found, and what was expected.
    """
    names = None if columns is None else words(columns, "columns")
    number = None if maneuver is None else _number(maneuver, count)
    if isinstance(given, Scored):
        raise InputError(
            f"found a {type(given).__name__}, which is a score already; expected the results, as "
            "they were given to score"
        )
    if named:
        given = _with_time(given, named)
    parts = [(number, given)]
    if isinstance(given, list | tuple) and all(isinstance(x, _FILES) for x in given):
        parts = [(number, x) for x in given]
    elif isinstance(given, Mapping) and given and all(isinstance(k, Integral) for k in given):
        if number is not None:
            raise InputError(f"found maneuver={maneuver} beside results by maneuver")
        numbers = [_number(key, count) for key in given]
        if any(isinstance(x, _FILES) for x in given.values()):
            parts = list(zip(numbers, given.values(), strict=True))
    found = []
    for n, part in parts:
        if not isinstance(part, Results):
            part = read_results(part, maneuver=n, count=count, columns=names)
        found.append(_of_maneuver(part, n, is_only))
    return found


def words(given: str | Sequence[str], what: str) -> list[str]:
    """Words that are given as one text, separated by commas, or as several.

    Raises
    ------
    InputError
        Anything else.
    """
    if isinstance(given, str):
        return given.split(",")
    if isinstance(given, list | tuple) and all(isinstance(x, str) for x in given):
        return list(given)
    raise InputError(f"{what}: found {given!r:.40}, expected a text, or a list of texts")


def several(given: Any) -> list[Any]:
    """Results of several runs or programs.

    Raises
    ------
    InputError
        Not a list of them.
    """
    if not isinstance(given, Sequence) or isinstance(given, str) or not given:
        found = "none" if isinstance(given, list | tuple) else f"a {type(given).__name__}"
        raise InputError(f"found {found}, expected a list of results")
    return list(given)


def _read_tables(source: Any, request: Request) -> tuple[list[Vectors], str]:
    """Read the tables of a file or of arrays, and tell the format."""
    if not isinstance(source, str | PathLike):
        return tables(source, request), ARRAY
    suffix = Path(source).suffix.lower()
    with ExitStack() as stack:
        file = ResultFile(source, request, stack)
        for format_ in FORMATS:
            if not format_.sniff(file.signature, suffix):
                continue
            file.request = replace(request, is_ordered=format_.is_ordered)
            damage = file.request.damage(format_.expected) if format_.expected else nullcontext()
            try:
                with damage:
                    found = format_.reader()(file)
            except ImportError:
                if format_.package is None:
                    raise
                raise MissingPackageError(
                    f"{request.path}: {format_.package}, which reads {format_.label} (or save it "
                    f"as text), is not installed: pip install {format_.package}"
                ) from None
            if found is not None:
                is_read = isinstance(found, list)
                return found if is_read else tables(found, file.request), format_.name
    raise request.error(why_not_read(file.signature, suffix))


def _number(maneuver: Any, count: int) -> int:
    is_number = isinstance(maneuver, Integral) and not isinstance(maneuver, bool)
    if not (is_number and 1 <= maneuver <= count):
        raise InputError(f"found maneuver {maneuver!r:.40}, expected 1 to {count}")
    return int(maneuver)


def _with_time(time: Any, named: Mapping[str, Any]) -> dict[str, Any]:
    """Columns by name with their time; a word that is no column is not left out in silence."""
    for name in named:
        if not any(map(headings.recognise, (name, name.removesuffix("_lo")))):
            raise InputError(
                f"found a column {quoted(name)}, expected {NAMES}, or a column of motion.h5"
                f"{headings.did_you_mean(name)}"
            )
    has_time = any(map(headings.is_time, named))
    if has_time == (time is not None):
        found = "times twice" if has_time else "columns without their times"
        raise InputError(f"found {found}, expected score(t, roll_angle=...) or score(time=t, ...)")
    return dict(named) if has_time else {headings.TIME: time, **named}


def _of_maneuver(results: Results, number: int | None, is_only: bool) -> Results:
    """The results, which are of this maneuver if one is told."""
    held = [rows.maneuver for rows in results.maneuvers]
    if number is None or held == [number] or (number in held and not is_only):
        return results
    if held == [None]:
        return replace(results, maneuvers=(replace(results.maneuvers[0], maneuver=number),))
    raise InputError(
        f"found maneuver {number} for results that hold maneuver {', '.join(map(str, held))}, "
        "expected it for those of one maneuver",
        file=results.path,
    )


@dataclass(frozen=True, slots=True)
class _ColumnLayout:
    """The index of each column, by number of the maneuver (None if that is not told) and key.

    Times are in `unit`, s or ms.
    """

    time: int
    maneuvers: Mapping[int | None, Mapping[str, int]]
    seen: tuple[Evidence, ...]
    unit: str


_Bad = tuple[int, int, str, int]
"""Line or row, column, which of both it is, and how many values there are not finite."""

_log = logging.getLogger(__name__)


def assemble(tables: Sequence[Vectors], kind: str, request: Request) -> Results:
    """Put the columns of a file where they belong.

    Parameters
    ----------
    tables
        What the file has.
    kind
        Its format.
    request
        The request to read it.

    Raises
    ------
    InputError
        Columns that cannot be told, a maneuver that is not in the reference, or a time that is not
        finite.
    """
    known, seen = _of_the_reference(tables, request)
    maneuvers: list[Rows] = []
    digits: list[int] = []
    bad: list[_Bad] = []
    for table, places in chain.from_iterable(_one_by_one(x, request) for x in known):
        times = settle(table, places.time, request, places.unit)
        found = (*table.seen, *places.seen, *times.seen)
        seen += [x for x in found if x not in seen]
        for number, columns in places.maneuvers.items():
            _log.info(
                "%s: %s, %d rows, maneuver %s: time is column %d, %s", request.path, kind,
                len(times.hi), number or "not told", places.time + 1,
                ", ".join(f"{key} {j + 1}" for key, j in columns.items()),
            )  # fmt: skip
            names = request.names or table.names or ()
            maneuvers.append(_rows(table, names, times, number, places.time, columns, bad))
            used = [table.columns[j].digits for j in columns.values()]
            digits += [d for d in used if d is not None]
    seen += [_not_finite(bad)] if bad else []
    maneuvers.sort(key=lambda rows: rows.maneuver or 0)
    return Results(request.path, kind, tuple(maneuvers), min(digits, default=None), tuple(seen))


def _of_the_reference(
    tables: Sequence[Vectors], request: Request
) -> tuple[list[Vectors], list[Evidence]]:
    """The tables of maneuvers that the reference has, or of none that is told."""
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


def _by_maneuver(table: Vectors, request: Request) -> list[Vectors]:
    """The rows of each maneuver, if a column tells of which they are; else the table alone."""
    names, count = request.names or table.names or (), request.count
    at = next((j for j, name in enumerate(names) if headings.is_maneuver(name)), None)
    if at is None or at >= len(table.columns) or table.maneuver is not None:
        return [table]
    numbers = table.columns[at].values
    first = 0 if count > 1 and (numbers == 0).any() else 1
    fits = (numbers == np.rint(numbers)) & (numbers >= first) & (numbers < first + count)
    if not fits.all():
        i = int(np.argmin(fits))
        found = f"{numbers[i]:.6g}" if np.isfinite(numbers[i]) else "no number"
        said = f"found {found} as {quoted(names[at])}, expected {first} to {first + count - 1}"
        raise table.error(request, i, said)
    return [table.of_rows(numbers == n, int(n) + 1 - first) for n in np.unique(numbers)]


def _one_by_one(table: Vectors, request: Request) -> Iterator[tuple[Vectors, _ColumnLayout]]:
    """A table and what its columns are; of maneuvers below each other, for each of these.

    The times then begin again where they began.
    """
    places = _layout(table, request)
    times = table.columns[places.time].values
    starts = np.flatnonzero(np.r_[True, times[1:] < times[:-1]])
    is_again = len(starts) > 1 and bool((times[starts] == times[0]).all())
    if not is_again or len(starts) > request.count or len(places.maneuvers) > 1:
        yield table, places
    elif None not in places.maneuvers:
        said = f"found {len(starts)} times that begin at {times[0]:g}, expected one maneuver"
        raise request.error(f"{said}; a column maneuver tells the rows of several apart")
    else:
        number = np.cumsum(np.isin(np.arange(len(times)), starts))
        for n in range(1, len(starts) + 1):
            yield table.of_rows(number == n, None), places


def _rows(
    table: Vectors, names: Sequence[str], times: Times, number: int | None, time: int,
    columns: Mapping[str, int], bad: list[_Bad],
) -> Rows:  # fmt: skip
    named = {key: names[j] if names else "" for key, j in columns.items()}
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
    units = {key: unit for key, name in named.items() if (unit := headings.named_unit(name, key))}
    may_be = {key: keys for key, name in named.items() if key in (keys := headings.may_mean(name))}
    quantum = {key: table.columns[j].quantum for key, j in {headings.TIME: time, **columns}.items()}
    return Rows(number, times.hi, times.lo, values, lo, quantum, units, may_be)


def _not_finite(bad: Sequence[_Bad]) -> NotFinite:
    """Return the evidence that values are not finite: how many, and the first one."""
    line, column, counted_by, _ = min(bad)
    return NotFinite(sum(n for *_, n in bad), counted_by, line, column)


def _layout(vectors: Vectors, request: Request) -> _ColumnLayout:
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
    found = headings.meanings(names, request.count)
    known = [f[0] for f in found if f]
    is_named = headings.TIME in known and len(known) > 1
    # The benchmark's order has no place for what is not of the benchmark.
    is_beyond = not {*known} <= {headings.TIME, *BENCHMARK_COLUMNS}
    is_beyond |= any(map(headings.is_maneuver, names))
    places = _by_place(width, request.count) if vectors.is_ordered else None
    if request.names or (is_named and (places is None or None not in found or is_beyond)):
        return _settled(names, found, vectors, request)
    if places is not None:
        settled = _settled([""] * width, places, vectors, request)
        return replace(settled, seen=_names_unused(names, found, places))
    raise request.not_columns(headings.names_found(names, found), vectors.heading)


def _by_place(width: int, count: int) -> Sequence[headings.Found] | None:
    """Return the meanings of columns without names; None if there are too many or too few."""
    # One maneuver needs no number.
    by_width: Mapping[int, Sequence[int | None]] = {1 + 8 * count: range(1, count + 1), 9: [None]}
    if (numbers := by_width.get(width)) is None:
        return None
    columns = ((key, number) for number in numbers for key in BENCHMARK_COLUMNS)
    return [(headings.TIME, None), *columns]


def _settled(
    names: Sequence[str], found: Sequence[headings.Found], vectors: Vectors, request: Request
) -> _ColumnLayout:
    """Each meaning with the one column that has it."""
    meant = {}
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
    time = meant[headings.TIME, None]
    alone = request.maneuver if vectors.maneuver is None else vectors.maneuver
    alone = 1 if alone is None and request.count == 1 else alone
    maneuvers: dict[int | None, dict[str, int]] = {}
    for (key, number), i in meant.items():
        if key != headings.TIME:
            maneuvers.setdefault(alone if number is None else number, {})[key] = i
    if alone is not None and alone not in maneuvers and len(maneuvers) == 1:
        said = f"found columns of maneuver {next(iter(maneuvers))}, expected maneuver {alone}"
        raise request.error(said, vectors.heading)
    seen = _left_out(names, found, {*meant.values()}, request)
    seen += headings.unknown_units({names[i]: key for (key, _), i in meant.items()})
    unit = headings.quantities(headings.unit_in(names[time])[1] or "").get("s", "s")
    return _ColumnLayout(time, maneuvers, tuple(seen), unit)


def _left_out(
    names: Sequence[str], found: Sequence[headings.Found], used: Collection[int], request: Request
) -> list[Evidence]:
    """Return evidence of columns that are not used, unless the user left them out."""
    left = [i for i in range(len(names)) if i not in used and names[i] not in LEFT_OUT]
    left = [i for i in left if not headings.is_maneuver(names[i])]
    known = [names[i] for i in left if found[i] is None and headings.recognise(names[i])]
    unknown = [names[i] for i in left if names[i] not in known]
    found_known = [headings.set_aside(known, request)] if known else []
    return [*found_known, headings.left_out(unknown, request)] if unknown else [*found_known]


def _oddity(name: str) -> tuple[bool, bool]:
    """True if a name has a unit other than SI, and true if it has its unit as an ending."""
    _, unit, is_ending = headings.unit_in(name)
    return not headings.is_si(unit), is_ending


def _names_unused(
    names: Sequence[str], found: Sequence[headings.Found], places: Sequence[headings.Found]
) -> tuple[NamesNotUsed, ...]:
    """Tell whether a name that is known contradicts the place of its column."""
    both = enumerate(zip(found, places, strict=False))
    wrong = [i for i, (f, place) in both if f and place and f[0] != place[0]]
    if not wrong:
        return ()
    unknown = tuple(name for name, f in zip(names, found, strict=True) if f is None)
    return (NamesNotUsed(tuple(i + 1 for i in wrong), names[wrong[0]], unknown),)

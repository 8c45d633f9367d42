"""Reading of another program's results: files, whose content tells the format, and objects.

Objects of Python may be arrays, columns by name, data frames, or several results of one run.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, nullcontext
from dataclasses import replace
from numbers import Integral
from os import PathLike
from pathlib import Path
from typing import Any

from heyoka_bike.errors import InputError, MissingPackageError, printable, quoted
from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.assembly import assemble
from heyoka_bike.scoring.reading.formats import FORMATS, why_not_read
from heyoka_bike.scoring.reading.names import headings
from heyoka_bike.scoring.reading.request import ARGUMENT, NAMES, OPTION, Request
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.reading.vectors import Vectors
from heyoka_bike.scoring.scored import Scored

ARRAY = "array"
"""Name and format of results that are no file."""

_FILES = (Results, str, PathLike)


def read_results(
    source: Any, *, maneuver: int | None = None, count: int = 3,
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
        Number of maneuvers of the reference.
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
    if maneuver is not None and not 1 <= maneuver <= count:
        raise InputError(f"found maneuver {maneuver}, expected 1 to {count}")
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

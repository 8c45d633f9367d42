"""Reading of results from files, whose content shows the format, and from Python objects."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack, nullcontext
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

from heyoka_bike.bicycle.parameters import benchmark
from heyoka_bike.errors import MissingPackageError, printable
from heyoka_bike.numbers.double import with_usual_errors
from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.assembly import assemble
from heyoka_bike.scoring.reading.formats import FORMATS, why_not_read
from heyoka_bike.scoring.reading.names.suggestions import parse_column_names
from heyoka_bike.scoring.reading.request import (
    ARGUMENT,
    MOST_UNPACKED,
    OPTION,
    Request,
    maneuver_number,
)
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.reading.table import ReadTable

ARRAY = "array"
"""Name and format of results that are not from a file."""


@with_usual_errors
def read_results(
    source: Any, *, maneuver: int | None = None, count: int | None = None,
    columns: Sequence[str] | None = None, max_bytes: int = MOST_UNPACKED,
) -> Results:  # fmt: skip
    """Read the results of a program, from a file or from its arrays.

    Parameters
    ----------
    source : path, "-", array-like, mapping or data frame
        A file of one of the `formats`, compressed with gzip or not; ``-`` is standard input. Or an
        array of shape (n, 9), (n, 1 + 8 count) or (count, n, 9), an array with named fields, a
        mapping, a data frame of pandas, polars or pyarrow, a dataset of xarray, the result of
        `simulate`, or a mapping from maneuver numbers to any of these. The columns are the time
        [s], which may be the index of a data frame, and the benchmark's eight columns, in its order
        or with names.
    maneuver
        Number, from 1, of the maneuver of columns that do not name one.
    count
        Number of maneuvers of the reference; by default that of the benchmark.
    columns
        Names of the columns in the order of the file; they override those in the file: ``time``,
        ``roll_angle``, ``m2_steer_angle`` and so on, ``-`` to skip a column.
    max_bytes
        Largest size of an unpacked file [bytes].

    Returns
    -------
    Results
        Columns as written. Times [s] are exact decimals if the file means decimals.

    Raises
    ------
    InputError
        A file cannot be read, or contains no such rows.
    MissingPackageError
        A package that is needed for the format is not installed.
    """
    count = len(benchmark()[1]) if count is None else count
    if maneuver is not None:
        maneuver = maneuver_number(maneuver, count)
    is_file = isinstance(source, str | PathLike)
    option = OPTION if is_file else ARGUMENT
    path = printable(str(source)) if is_file else ARRAY
    names = None if columns is None else parse_column_names(columns, option)
    request = Request(path, count, maneuver, names, option, most_bytes=max_bytes)
    return assemble(*_read_tables(source, request), request)


def read_columns(source: Any, known: Callable[[str], bool]) -> ReadTable:
    """Read named columns without times, from the same sources as `read_results`.

    Parameters
    ----------
    source
        The file or the arrays.
    known
        Function that returns True for the name of a wanted column.

    Raises
    ------
    InputError, MissingPackageError
        As in `read_results`.
    """
    path = printable(str(source)) if isinstance(source, str | PathLike) else ARRAY
    found, _ = _read_tables(source, Request(path, 1, known=known))
    return found[0]


def _read_tables(source: Any, request: Request) -> tuple[list[ReadTable], str]:
    """Return the tables of a file or of arrays, and the name of the format."""
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

"""Reading of another program's results: files, whose content tells the format, and objects."""

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
"""Name and format of results that are no file."""


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
    max_bytes
        What a packed file may unpack to.

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
        maneuver = maneuver_number(maneuver, count)
    is_file = isinstance(source, str | PathLike)
    option = OPTION if is_file else ARGUMENT
    path = printable(str(source)) if is_file else ARRAY
    names = None if columns is None else parse_column_names(columns, option)
    request = Request(path, count, maneuver, names, option, most_bytes=max_bytes)
    return assemble(*_read_tables(source, request), request)


def read_columns(source: Any, known: Callable[[str], bool]) -> ReadTable:
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


def _read_tables(source: Any, request: Request) -> tuple[list[ReadTable], str]:
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

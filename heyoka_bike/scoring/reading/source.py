"""Reading of another program's results, whatever their format: the content tells it."""

import sys
import zlib
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, suppress
from io import BytesIO
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO, cast

from heyoka_bike.errors import InputError, printable
from heyoka_bike.scoring.reading.assembly import assemble
from heyoka_bike.scoring.reading.expected import ARGUMENT, OPTION, Expected
from heyoka_bike.scoring.reading.frames import plain
from heyoka_bike.scoring.reading.headings import told
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.reading.text_lines import encoding_of
from heyoka_bike.scoring.reading.text_table import read_text
from heyoka_bike.scoring.reading.written import WrittenTable

# Whole lines of so much text are read at once; the processor's cache holds what they become.
_CHUNK = 1 << 21
# The first of them shows how rows are written: it must hold any heading, and some rows.
_HEAD = 1 << 21
# Of that so much tells text from other files.
_SIGNATURE = 4096

_GZIP = b"\x1f\x8b"
_HDF5 = b"\x89HDF\r\n\x1a\n"
# MATLAB puts a text of this length before HDF5.
_MATLAB_TEXT = 512
_ARRAYS = (
    (b"\x93NUMPY", "npy"),
    (b"PK\x03\x04", "zip"),
    (b"PK\x05\x06", "zip"),
    (_HDF5, "hdf5"),
    (b"PAR1", "parquet"),
    (b"ARROW1", "arrow"),
    (b"CDF\1", "netcdf"),
    (b"CDF\2", "netcdf"),
)
ARRAY = "array"
"""Name and format of results that are no file."""

_FORMATS = "text, JSON, .npy, .npz, .mat, netCDF, HDF5, Parquet or xlsx"
_SPREADSHEETS = (".xls", ".xlsx", ".xlsm", ".xlsb", ".ods")
_BRACKETS = ("{", "[")
_OTHERS = (
    (b"\xd0\xcf\x11\xe0", "a spreadsheet"),
    (b"\x89PNG", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
    (b"GIF8", "a picture"),
    (b"%PDF", "a PDF document"),
    (b"SQLite format 3", "a database"),
    (b"BZh", "a bzip2 file"),
    (b"\xfd7zXZ", "an xz file"),
    (b"\x28\xb5\x2f\xfd", "a zstd file"),
    (b"7z\xbc\xaf", "a 7z file"),
    (b"\x80\x02", "a pickle"),
    (b"\x80\x03", "a pickle"),
    (b"\x80\x04", "a pickle"),
    (b"\x80\x05", "a pickle"),
)


def read_results(
    source: Any, *, maneuver: int | None = None, count: int = 3,
    columns: Sequence[str] | None = None,
) -> Results:  # fmt: skip
    """Read the results of a program, from a file or from its arrays.

    Parameters
    ----------
    source : path, "-", array-like, mapping or data frame
        A text of rows of numbers, JSON, a NumPy, MATLAB, netCDF, HDF5, Parquet or Arrow file or a
        spreadsheet, any of them compressed with gzip; ``-`` is standard input. Or an array of shape
        (n, 9), (n, 1 + 8 count) or (count, n, 9), an array with named fields, a mapping of columns,
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
    expected = Expected(count, None, option) if columns is None else told(columns, count, option)
    if is_file:
        path = printable(str(source))
        found, kind = _read_file(source, path, expected)
    else:
        from heyoka_bike.scoring.reading.array_tables import tables

        path, kind = ARRAY, ARRAY
        found = tables(plain(source), path, expected)
    return assemble(found, kind, path, maneuver, expected)


def _read_file(
    source: str | PathLike[str], path: str, expected: Expected
) -> tuple[list[WrittenTable], str]:
    with ExitStack() as stack:
        file = _open(source, path, stack)
        head = _read(file, _HEAD, path)
        plain: Path | None = None if source == "-" else Path(source)
        if head.startswith(_GZIP):
            from gzip import GzipFile

            # Standard input cannot go back to its beginning.
            ahead = cast(BinaryIO, _Ahead(head, file))
            file, plain = cast(BinaryIO, stack.enter_context(GzipFile(fileobj=ahead))), None
            head = _read(file, _HEAD, path)
        encoding = encoding_of(head[:_SIGNATURE])
        is_old = encoding is None and Path(path).suffix.lower() == ".mat"
        if kind := _kind(head) or ("mat" if is_old else None):
            if kind == "hdf5" and plain is not None and plain.is_file():
                return _read_arrays(plain, kind, path, expected)
            return _read_arrays(_seekable(head, file, plain, path), kind, path, expected)
        _refuse_others(head, path, encoding is not None)
        assert encoding is not None
        name, mark = encoding
        if _begins_with_bracket(head[mark : mark + _SIGNATURE], name):
            return _read_json(head[mark:] + _read(file, -1, path), name, path, expected)
        chunks = chain((head[mark:],), _chunks(file, path))
        return [read_text(chunks, name, path, expected)], "text"


def _kind(head: bytes) -> str | None:
    """What a file of arrays is that starts like this; None if it is none."""
    if head[_MATLAB_TEXT:].startswith(_HDF5):
        return "hdf5"
    if head[126:128] in (b"IM", b"MI"):
        return "mat"
    return next((kind for start, kind in _ARRAYS if head.startswith(start)), None)


def _read_arrays(
    source: BinaryIO | Path, kind: str, path: str, expected: Expected
) -> tuple[list[WrittenTable], str]:
    # Texts do without all of these.
    from heyoka_bike.scoring.reading import array_files, matlab_files, table_files

    if kind == "hdf5":
        return array_files.read_hdf5(source, path, expected)
    assert not isinstance(source, Path)
    if kind == "zip":
        return array_files.read_archive(source, path, expected)
    read = {
        "npy": array_files.read_npy,
        "netcdf": array_files.read_netcdf,
        "mat": matlab_files.read_mat,
        "parquet": table_files.read_columns,
        "arrow": table_files.read_columns,
    }[kind]
    return read(source, path, expected), kind


def _begins_with_bracket(head: bytes, encoding: str) -> bool:
    return head.decode(encoding, "replace").lstrip()[:1] in _BRACKETS


def _read_json(
    text: bytes, encoding: str, path: str, expected: Expected
) -> tuple[list[WrittenTable], str]:
    from heyoka_bike.scoring.reading.json_files import parse_json, read_json

    try:
        document = parse_json(text, encoding, path)
    except InputError as error:
        # A heading may begin with a bracket, too.
        with suppress(InputError):
            return [read_text((text,), encoding, path, expected)], "text"
        raise error from None
    return read_json(document, path, expected), "json"


def _open(source: str | PathLike[str], path: str, stack: ExitStack) -> BinaryIO:
    if source == "-":
        if sys.stdin is None:
            raise InputError("cannot be read (closed), expected a result file", file=path)
        return cast(BinaryIO, sys.stdin.buffer)
    try:
        if Path(source).is_dir():
            raise InputError("found a directory, expected a result file", file=path)
        return stack.enter_context(Path(source).open("rb"))
    except (OSError, ValueError) as e:
        if isinstance(e, InputError):
            raise
        reason = e.strerror if isinstance(e, OSError) and e.strerror else str(e)
        raise InputError(f"cannot be read ({reason}), expected a result file", file=path) from None


def _read(file: BinaryIO, size: int, path: str) -> bytes:
    """Bytes of a file; all that are left if the size is -1."""
    try:
        return file.read(size)
    except (OSError, EOFError, zlib.error) as e:
        reason = printable(" ".join(str(e).split()))[:100]
        raise InputError(f"cannot be read ({reason}), expected {_FORMATS}", file=path) from None


def _chunks(file: BinaryIO, path: str) -> Iterator[bytes]:
    while chunk := _read(file, _CHUNK, path):
        yield chunk


def _seekable(head: bytes, file: BinaryIO, plain: Path | None, path: str) -> BinaryIO:
    """The file at its beginning, which must be in memory if it cannot seek."""
    if plain is None or not file.seekable():
        return BytesIO(head + _read(file, -1, path))
    file.seek(0)
    return file


def _refuse_others(head: bytes, path: str, is_text: bool) -> None:
    name = next((name for start, name in _OTHERS if head.startswith(start)), None)
    if name is None and not is_text:
        is_sheet = Path(path).suffix.lower() in _SPREADSHEETS
        name = "a spreadsheet" if is_sheet else "bytes that are no text"
    if name == "a spreadsheet":
        raise InputError("is a spreadsheet; save it as xlsx or CSV", file=path)
    if name is not None:
        raise InputError(f"found {name}, expected {_FORMATS}", file=path)


class _Ahead:
    """A file of which the beginning has been read already."""

    def __init__(self, head: bytes, file: BinaryIO) -> None:
        self._head = BytesIO(head)
        self._file = file

    def read(self, size: int = -1) -> bytes:
        return self._head.read(size) or self._file.read(size)

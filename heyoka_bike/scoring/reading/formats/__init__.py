"""The formats of result files: how each file begins, the function that reads it, a description.

From `FORMATS` follow what reads a file, what is said of one that nothing reads, the help of
``heyoka-bike score``, its page in the browser and the table of docs/files.md. A format has an entry
there, and a function of a `ResultFile` in a module here: it returns what `arrays.tables`
takes, or the vectors of a text, or None if the file is of another format that begins alike. What
libraries raise for a damaged file becomes one line.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from struct import unpack_from
from typing import Any

from heyoka_bike.scoring.reading.encodings import encoding_of
from heyoka_bike.scoring.reading.not_read import NOT_READ, is_called_spreadsheet, not_read

# Limits that distinguish files of MATLAB's version 4 from other files: the minimum size, which is a
# header and a name of one letter [bytes]; the maximum length of a name; and the codes of the types
# of numbers, with 1 added for text.
_LEAST_OF_MATLAB_4 = 22
_LONGEST_NAME = 64
_KINDS_OF_4 = {10 * number + text for number in range(6) for text in (0, 1)}
# Length of the text that MATLAB writes before the HDF5 part of a file [bytes].
_MATLAB_TEXT = 512
_SIGNATURE_OF_HDF5 = b"\x89HDF\r\n\x1a\n"
STREAM_OF_ARROW = b"\xff\xff\xff\xff"
"""First bytes of a stream of Arrow, with which no text begins."""

_ZIP = (b"PK\x03\x04", b"PK\x05\x06")
_BRACKETS = ("{", "[")


@dataclass(frozen=True, slots=True)
class Format:
    """A format of result files.

    Attributes
    ----------
    name
        Name of the format in `Results.format`.
    label
        Name of the format in messages and on pages.
    about
        The contents that are read from such a file, in Markdown.
    sniff : callable
        True for the first bytes and the suffix of a file that may be of the format.
    reads
        The function that reads the format, as module of this package and name.
    package
        The required package other than NumPy and h5py, as pip names it; None without one.
    expected
        End of the message about a damaged file; empty if the module writes its own message.
    is_ordered
        True if the order of the arrays in a file is meaningful.
    """

    name: str
    label: str
    about: str
    sniff: Callable[[bytes, str], bool]
    reads: str
    package: str | None = None
    expected: str = ""
    is_ordered: bool = True

    def reader(self) -> Callable[..., Any]:
        """Return the function that reads the format; its module is imported only now."""
        module, _, function = self.reads.partition(".")
        read: Callable[..., Any] = getattr(import_module(f"{__name__}.{module}"), function)
        return read


def _begins(*starts: bytes) -> Callable[[bytes, str], bool]:
    return lambda head, _: head.startswith(starts)


def is_hdf5_of_matlab(head: bytes) -> bool:
    """True if a file that begins like this was written by MATLAB in version 7.3."""
    return head[_MATLAB_TEXT:].startswith(_SIGNATURE_OF_HDF5)


def _is_matlab_4(head: bytes) -> bool:
    """True if a file begins as a matrix of MATLAB's version 4: five integers and a name."""
    if len(head) < _LEAST_OF_MATLAB_4:
        return False
    for order in "<>":
        kind, rows, columns, is_complex, letters = unpack_from(f"{order}5i", head)
        name = head[20 : 20 + letters] if 0 < letters <= _LONGEST_NAME else b""
        is_kind = kind == (1000 if order == ">" else 0) + kind % 1000 and kind % 1000 in _KINDS_OF_4
        if (
            is_kind and rows >= 0 and columns >= 0 and is_complex in (0, 1)
            and name.endswith(b"\0") and name[:-1].decode("latin-1").isidentifier()
        ):  # fmt: skip
            return True
    return False


def _is_matlab(head: bytes, suffix: str) -> bool:
    # A file of MATLAB's version 4 begins with a number, so it is not a text.
    is_version_4 = (suffix == ".mat" and encoding_of(head) is None) or _is_matlab_4(head)
    # The two letters IM are not enough, because a text may contain them in this place, as in TIME.
    return is_version_4 or head[124:128] in (b"\0\1IM", b"\1\0MI") or is_hdf5_of_matlab(head)


def _is_text(head: bytes, _: str) -> bool:
    return encoding_of(head) is not None and not_read(head) is None


def _is_json(head: bytes, _: str) -> bool:
    encoding, mark = encoding_of(head) or ("utf-8", len(head))
    begins = head[mark:].decode(encoding, "replace").lstrip().startswith(_BRACKETS)
    return begins and not_read(head) is None


FORMATS = (
    Format(
        "json", "JSON",
        "an object of columns; rows as arrays, with or without names, or as objects; what pandas "
        "(every `orient`), polars, MATLAB's `jsonencode` and `heyoka-bike export` write; a "
        "document in each line. Decimals are exact, as in a text",
        _is_json, "json_files.read",
    ),
    Format(
        "npy", ".npy", "an array of rows or of columns", _begins(b"\x93NUMPY"),
        "libraries.read_npy", expected="a NumPy array",
    ),
    Format(
        "npz", ".npz", "such arrays, or columns by name", _begins(*_ZIP), "libraries.read_npz",
        expected="NumPy arrays",
    ),
    Format(
        "hdf5", "HDF5 (netCDF 4)",
        "arrays and groups, packed or not; columns over `maneuver` and `time` as xarray writes "
        "them; data frames of pandas' `to_hdf`",
        _begins(_SIGNATURE_OF_HDF5), "hdf5.read", expected="HDF5", is_ordered=False,
    ),
    Format(
        "netcdf", "netCDF 3", "the same", _begins(b"CDF\1", b"CDF\2"), "libraries.read_netcdf",
        "scipy", "a netCDF file",
    ),
    Format(
        "xlsx", ".xlsx",
        "a sheet of rows, or sheets `maneuver_1` and so on. Older spreadsheets and `.ods` are "
        "refused: save them as CSV",
        _begins(*_ZIP), "xlsx.read", "openpyxl", "a spreadsheet",
    ),
    Format(
        "parquet", "Parquet", "a table", _begins(b"PAR1"), "libraries.read_parquet", "pyarrow",
        "a Parquet file",
    ),
    Format(
        "arrow", "Arrow", "a table, as a file, a stream or Feather",
        _begins(b"ARROW1", STREAM_OF_ARROW), "libraries.read_arrow", "pyarrow", "an Arrow file",
    ),
    # If a file has none of the formats above, the suffix .mat shows that it is of MATLAB's version
    # 4.
    Format(
        "mat", ".mat",
        "variables, structures, cell arrays, the solution of `ode45`, and what Simulink logs: "
        "`tout` and `yout`, structures with time, arrays (not `timeseries`, `table` and other "
        "objects), trajectories of Dymola and OpenModelica. Versions 4 to 7.3 (7.3 needs no SciPy)",
        _is_matlab, "matlab.read", "scipy", "a MATLAB file", is_ordered=False,
    ),
    # A file that has none of the formats above may be a text.
    Format(
        "text", "text",
        "rows of numbers, with or without a heading; tables with words in some columns; of "
        "Octave's `save -text` one matrix, variables by `save -v7`",
        _is_text, "text_files.read",
    ),
)  # fmt: skip


def why_not_read(head: bytes, suffix: str) -> str:
    """Return the end of a message that a file has no supported format, and how to convert it."""
    found = not_read(head)
    if found is None and is_called_spreadsheet(suffix):
        found = NOT_READ[0]
    if found == NOT_READ[0]:
        return f"is {found.found}; {found.instead}"
    said = f"found {found.found if found else 'bytes that are not text'}, expected {listed()}"
    return f"{said}; {found.instead}" if found and found.instead else said


TEXT_FIRST = (FORMATS[-1], *FORMATS[:-1])
"""The formats in the order in which messages list them: text first."""


def listed(last: str = "or", *, with_packages: bool = False) -> str:
    """Return the names of the formats as a list in words, perhaps with the packages they need."""
    labels = [
        f"{f.label} (with {f.package})" if with_packages and f.package else f.label
        for f in TEXT_FIRST
    ]
    return f"{', '.join(labels[:-1])} {last} {labels[-1]}"

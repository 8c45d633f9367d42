"""Files of arrays: NumPy's, MATLAB's and HDF5."""

import zlib
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, BinaryIO
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError, MissingPackageError, printable
from heyoka_bike.scoring.reading.array_columns import MOST_BYTES
from heyoka_bike.scoring.reading.array_tables import DEEPEST, tables
from heyoka_bike.scoring.reading.expected import Expected
from heyoka_bike.scoring.reading.written import WrittenTable


def read_npy(stream: BinaryIO, path: str, expected: Expected) -> list[WrittenTable]:
    """The table in a file of one NumPy array.

    Parameters
    ----------
    stream
        The file, which can seek.
    path
        Name of the file, for errors.
    expected
        What columns there may be.

    Raises
    ------
    InputError
        Not such a file, or not columns of real numbers.
    """
    with _damage("a NumPy array", path):
        array = _npy(stream)
    return tables(array, path, expected)


def read_npz(stream: BinaryIO, path: str, expected: Expected) -> list[WrittenTable]:
    """The tables in an archive of NumPy arrays; see `read_npy`."""
    from zipfile import ZipFile

    with _damage("NumPy arrays", path), ZipFile(stream) as archive:
        names = archive.namelist()
        arrays = {}
        if sum(member.file_size for member in archive.infolist()) > MOST_BYTES:
            raise InputError(f"found more than {MOST_BYTES} bytes, expected fewer", file=path)
        if "mimetype" in names or any(name.startswith(("xl/", "[Content")) for name in names):
            raise InputError("is a spreadsheet or document; save it as CSV", file=path)
        for name in names:
            if name.endswith(".npy"):
                with archive.open(name) as member:
                    arrays[name.removesuffix(".npy")] = _npy(member)
        if not arrays:
            raise InputError(
                "found an archive without NumPy arrays, expected text, .npy, .npz, .mat or HDF5",
                file=path,
            )
    return tables(arrays, path, expected)


def read_mat(stream: BinaryIO, path: str, expected: Expected) -> list[WrittenTable]:
    """The tables in a MATLAB file before version 7.3; see `read_npy`.

    Raises
    ------
    MissingPackageError
        SciPy is not installed.
    """
    try:
        from scipy.io import loadmat
    except ImportError:
        raise MissingPackageError(
            f"{path}: scipy, which reads MATLAB files, is not installed: pip install scipy"
        ) from None
    try:
        with catch_warnings():
            simplefilter("ignore")
            found = loadmat(stream)
    # There is no end to what SciPy raises for damaged bytes; nothing but its reader runs here.
    except Exception as e:
        raise _damaged("a MATLAB file", path, e) from None
    return tables(_structures(found), path, expected, is_ordered=False)


def read_hdf5(source: BinaryIO | Path, path: str, expected: Expected) -> list[WrittenTable]:
    """The tables in an HDF5 file, MATLAB's from version 7.3 among them; see `read_npy`."""
    import h5py

    with ExitStack() as stack:
        with _damage("HDF5", path):
            f = stack.enter_context(h5py.File(source, "r"))
            members = _datasets(f, path)
            # MATLAB's arrays have their axes the other way round.
            is_transposed = f.userblock_size > 0
        return tables(members, path, expected, is_ordered=False, is_transposed=is_transposed)


class _Dataset:
    """An array in an HDF5 file, read when it is wanted."""

    def __init__(self, dataset: Any, path: str) -> None:
        self.dtype = dataset.dtype
        self.shape = dataset.shape
        self._dataset = dataset
        self._path = path

    def __getitem__(self, index: tuple[()]) -> Any:
        with _damage("HDF5", self._path):
            return self._dataset[index]


def _datasets(group: Any, path: str, depth: int = 0) -> dict[str, Any]:
    """The arrays of a group and of those in it; links to other files are not followed."""
    import h5py

    found: dict[str, Any] = {}
    for name in group:
        if isinstance(group.get(name, getlink=True), h5py.ExternalLink):
            continue
        x = group.get(name)
        if isinstance(x, h5py.Dataset) and x.shape is not None:
            found[name] = _Dataset(x, path)
        elif isinstance(x, h5py.Group) and depth < DEEPEST:
            found[name] = _datasets(x, path, depth + 1)
    return found


def _npy(stream: Any) -> NDArray[Any]:
    with catch_warnings():
        # About headers that Python 2 wrote.
        simplefilter("ignore")
        array: NDArray[Any] = np.lib.format.read_array(stream, allow_pickle=False)
    return array


def _structures(found: Mapping[str, Any]) -> dict[str, Any]:
    """MATLAB's variables; structures as mappings."""
    plain: dict[str, Any] = {}
    for name, x in found.items():
        if isinstance(x, np.ndarray):
            fields = x.dtype.names
            if fields and x.size == 1:
                plain[name] = _structures({n: x[n].flat[0] for n in fields})
            else:
                plain[name] = x
    return plain


@contextmanager
def _damage(expected: str, path: str) -> Iterator[None]:
    """Turn what libraries raise for damaged files into an `InputError`."""
    from struct import error as StructError  # noqa: N812
    from tokenize import TokenError
    from zipfile import BadZipFile

    try:
        yield
    except InputError:
        raise
    except (
        OSError, ValueError, KeyError, EOFError, TypeError, SyntaxError, OverflowError, MemoryError,
        RuntimeError, zlib.error, StructError, TokenError, BadZipFile,
    ) as e:  # fmt: skip
        raise _damaged(expected, path, e) from None


def _damaged(expected: str, path: str, error: BaseException) -> InputError:
    reason = printable(" ".join(str(error).split()))[:100] or type(error).__name__
    return InputError(f"found a damaged file ({reason}), expected {expected}", file=path)

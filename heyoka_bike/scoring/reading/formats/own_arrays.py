"""What an HDF5 file holds itself. It may name other files, which that of a stranger must not open.

Three things of the format open others: external links, arrays whose bytes are stored elsewhere, and
virtual ones. None of them is opened, wherever it stands and whatever leads to it.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from heyoka_bike.errors import printable
from heyoka_bike.scoring.reading.arrays.packed import StoredArray
from heyoka_bike.scoring.reading.arrays.tables import MOST_MEMBERS
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.result_file import ResultFile


class OwnFile:
    """The groups and arrays that an HDF5 file holds itself.

    Parameters
    ----------
    file
        The file, as h5py opens it.
    request
        What is to be read.
    is_turned
        Whether arrays are stored with their axes the other way round, as MATLAB does it.
    """

    def __init__(self, file: Any, request: Request, is_turned: bool = False) -> None:
        self.file = file
        self.request = request
        self._is_turned = is_turned
        self._count = 0

    @classmethod
    @contextmanager
    def opened(cls, file: ResultFile, is_turned: bool = False) -> "Iterator[OwnFile]":
        """What h5py opens, until it is closed.

        Raises
        ------
        InputError
            It is damaged.
        """
        import h5py

        with file.request.damage("HDF5"):
            opened = h5py.File(file.path_or_stream(), "r")
        with opened:
            yield cls(opened, file.request, is_turned)

    def members(self, group: Any) -> Iterator[tuple[str, Any]]:
        """Names and objects of a group.

        Links by name are left out: those within the file may lead to another by way of one that
        leads there.

        Raises
        ------
        InputError
            There are too many.
        """
        import h5py

        for name in group:
            # A name with a slash in it is looked up as a place, whatever is on the way.
            if "/" not in name and isinstance(group.get(name, getlink=True), h5py.HardLink):
                self._claim()
                yield name, group[name]

    def array(self, dataset: Any) -> StoredArray:
        """An array, which is read when it is wanted.

        Raises
        ------
        InputError
            It is kept in another file, or there are too many.
        """
        self._claim()
        if dataset.is_virtual or dataset.external:
            raise self.request.error(
                f"found {printable(dataset.name)} kept in another file, expected it in this one"
            )
        shape = dataset.shape[::-1] if self._is_turned else dataset.shape
        return StoredArray(dataset.dtype, shape, lambda: self._read(dataset))

    def _claim(self) -> None:
        self._count += 1
        if self._count > MOST_MEMBERS:
            raise self.request.error(
                f"found more than {MOST_MEMBERS} arrays and groups, expected fewer"
            )

    def _read(self, dataset: Any) -> Any:
        with self.request.damage("HDF5"):
            try:
                found = dataset[()]
            except OSError:
                self._check_filters(dataset)
                raise
            return found.T if self._is_turned else found

    def _check_filters(self, dataset: Any) -> None:
        """Say it if the array was compressed by what is not here."""
        import h5py

        made = dataset.id.get_create_plist()
        for i in range(made.get_nfilters()):
            code, _, _, name = made.get_filter(i)
            if not h5py.h5z.filter_avail(code):
                raise self.request.error(
                    f"found {printable(dataset.name)} compressed by "
                    f"{printable(name.decode(errors='replace')) or f'filter {code}'}, which is not "
                    "installed here, expected gzip or none (h5repack -f GZIP=6 changes it)"
                )

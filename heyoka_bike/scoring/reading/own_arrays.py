"""What an HDF5 file holds itself. It may name other files, which that of a stranger must not open.

Three things of the format open others: external links, arrays whose bytes are stored elsewhere, and
virtual ones. None of them is opened, wherever it stands and whatever leads to it.
"""

from collections.abc import Iterator
from typing import Any

from heyoka_bike.errors import InputError, printable
from heyoka_bike.scoring.reading.damage import damage

# A group may be in itself, many times.
_MOST = 100_000


class OwnFile:
    """The groups and arrays that an HDF5 file holds itself.

    Parameters
    ----------
    path
        Name of the file, for errors.
    """

    def __init__(self, path: str) -> None:
        self._path = path
        self._count = 0

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

    def array(self, dataset: Any) -> "OwnArray":
        """An array, which is read when it is wanted.

        Raises
        ------
        InputError
            It is kept in another file, or there are too many.
        """
        self._claim()
        return OwnArray(dataset, self._path)

    def _claim(self) -> None:
        self._count += 1
        if self._count > _MOST:
            raise InputError(
                f"found more than {_MOST} arrays and groups, expected fewer", file=self._path
            )


class OwnArray:
    """An array in an HDF5 file, read when it is wanted; see `OwnFile.array`."""

    def __init__(self, dataset: Any, path: str) -> None:
        if dataset.is_virtual or dataset.external:
            raise InputError(
                f"found {printable(dataset.name)} kept in another file, expected it in this one",
                file=path,
            )
        self.dtype = dataset.dtype
        self.shape = dataset.shape
        self._dataset = dataset
        self._path = path

    def __getitem__(self, index: tuple[()]) -> Any:
        with damage("HDF5", self._path):
            try:
                return self._dataset[index]
            except OSError:
                self._check_filters()
                raise

    def _check_filters(self) -> None:
        """Say it if the array was compressed by what is not here."""
        import h5py

        made = self._dataset.id.get_create_plist()
        for i in range(made.get_nfilters()):
            code, _, _, name = made.get_filter(i)
            if not h5py.h5z.filter_avail(code):
                raise InputError(
                    f"found {printable(self._dataset.name)} compressed by "
                    f"{printable(name.decode(errors='replace')) or f'filter {code}'}, which is not "
                    "installed here, expected gzip or none (h5repack -f GZIP=6 changes it)",
                    file=self._path,
                )

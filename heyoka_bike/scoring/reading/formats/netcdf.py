"""netCDF 3; files of version 4 are HDF5."""

import numpy as np

from heyoka_bike.scoring.reading.arrays.packed import unpacked
from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.vectors import Vectors


def read(file: ResultFile) -> list[Vectors]:
    """The tables in its variables.

    Raises
    ------
    InputError
        Damaged, or not columns of real numbers.
    ImportError
        SciPy is not installed.
    """
    from scipy.io import netcdf_file

    with file.request.damage("a netCDF file"), netcdf_file(file.stream(), mmap=False) as f:
        arrays = {name: unpacked(np.array(x[()]), x._attributes) for name, x in f.variables.items()}
    return tables(arrays, file.request)

"""netCDF 3; files of version 4 are HDF5."""

from typing import Any

import numpy as np

from heyoka_bike.scoring.reading.arrays.packed import unpacked
from heyoka_bike.scoring.reading.result_file import ResultFile


def read(file: ResultFile) -> dict[str, Any]:
    """Its variables.

    Raises
    ------
    ImportError
        SciPy is not installed.
    """
    from scipy.io import netcdf_file

    with netcdf_file(file.stream(), mmap=False) as f:
        return {name: unpacked(np.array(x[()]), x._attributes) for name, x in f.variables.items()}

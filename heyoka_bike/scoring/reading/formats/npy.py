"""A NumPy array alone in a file."""

import numpy as np

from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.vectors import Vectors


def read(file: ResultFile) -> list[Vectors]:
    """The table in the array.

    Raises
    ------
    InputError
        Damaged, or not columns of real numbers.
    """
    with file.request.damage("a NumPy array"):
        array = np.lib.format.read_array(file.stream(), allow_pickle=False)
    return tables(array, file.request)

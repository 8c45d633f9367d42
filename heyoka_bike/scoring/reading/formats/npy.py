"""A NumPy array."""

from typing import Any

import numpy as np

from heyoka_bike.scoring.reading.result_file import ResultFile


def read(file: ResultFile) -> Any:
    """The array in the file."""
    return np.lib.format.read_array(file.stream(), allow_pickle=False)

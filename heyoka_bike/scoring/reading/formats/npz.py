"""An archive of NumPy arrays."""

from typing import Any
from zipfile import ZipFile

import numpy as np

from heyoka_bike.scoring.reading.arrays.columns import MOST_BYTES
from heyoka_bike.scoring.reading.result_file import ResultFile

_SUFFIX = ".npy"


def read(file: ResultFile) -> dict[str, Any] | None:
    """Its arrays; None if the archive is a workbook.

    Raises
    ------
    InputError
        Too large, or without arrays.
    """
    request, arrays = file.request, {}
    with ZipFile(file.stream()) as archive:
        names = archive.namelist()
        if sum(member.file_size for member in archive.infolist()) > MOST_BYTES:
            raise request.error(f"found more than {MOST_BYTES} bytes, expected fewer")
        if "mimetype" in names:
            raise request.error("is a spreadsheet or document; save it as xlsx or CSV")
        for name in names:
            if name.endswith(_SUFFIX):
                with archive.open(name) as member:
                    array = np.lib.format.read_array(member, allow_pickle=False)
                    arrays[name.removesuffix(_SUFFIX)] = array
    if not arrays and not any(name.startswith(("xl/", "[Content")) for name in names):
        raise request.error("found an archive without NumPy arrays, expected .npz or .xlsx")
    return arrays or None

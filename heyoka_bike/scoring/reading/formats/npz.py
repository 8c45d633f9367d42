"""An archive of NumPy arrays."""

from zipfile import ZipFile

import numpy as np

from heyoka_bike.scoring.reading.arrays.columns import MOST_BYTES
from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.vectors import Vectors

_SUFFIX = ".npy"


def read(file: ResultFile) -> list[Vectors] | None:
    """The tables in the arrays; None if the archive is a workbook.

    Raises
    ------
    InputError
        Damaged, too large, without arrays, or not columns of real numbers.
    """
    request, arrays = file.request, {}
    with request.damage("NumPy arrays"), ZipFile(file.stream()) as archive:
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
    if arrays:
        return tables(arrays, request)
    if any(name.startswith(("xl/", "[Content")) for name in names):
        return None
    raise request.error("found an archive without NumPy arrays, expected .npz or .xlsx")

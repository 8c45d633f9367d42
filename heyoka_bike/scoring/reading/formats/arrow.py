"""Parquet and Arrow files (Feather), through pyarrow."""

from typing import Any

from heyoka_bike.scoring.reading.arrays.columns import MOST_BYTES
from heyoka_bike.scoring.reading.result_file import ResultFile


def read(file: ResultFile) -> dict[str, Any]:
    """The columns of the table in the file.

    Raises
    ------
    InputError
        Too large.
    ImportError
        pyarrow is not installed.
    """
    import pyarrow
    from pyarrow import parquet

    if file.head.startswith(b"PAR1"):
        content = parquet.ParquetFile(file.stream())
        size = 8 * content.metadata.num_rows * content.metadata.num_columns
        if size > MOST_BYTES:
            raise file.request.error(f"found {size} bytes, expected at most {MOST_BYTES}")
        table = content.read()
    else:
        table = pyarrow.ipc.open_file(file.stream()).read_all()
    return {name: table[name].to_numpy() for name in table.column_names}

"""Parquet and Arrow files (Feather), through pyarrow."""

from heyoka_bike.scoring.reading.arrays.columns import MOST_BYTES
from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.vectors import Vectors


def read(file: ResultFile) -> list[Vectors]:
    """The table in the file.

    Raises
    ------
    InputError
        Damaged, too large, or not columns of real numbers.
    ImportError
        pyarrow is not installed.
    """
    import pyarrow
    from pyarrow import parquet

    request, is_parquet = file.request, file.head.startswith(b"PAR1")
    with request.damage("a Parquet file" if is_parquet else "an Arrow file"):
        if is_parquet:
            content = parquet.ParquetFile(file.stream())
            size = 8 * content.metadata.num_rows * content.metadata.num_columns
            if size > MOST_BYTES:
                raise request.error(f"found {size} bytes, expected at most {MOST_BYTES}")
            table = content.read()
        else:
            table = pyarrow.ipc.open_file(file.stream()).read_all()
        columns = {name: table[name].to_numpy() for name in table.column_names}
    return tables(columns, request)

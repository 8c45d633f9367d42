"""Rows of numbers in a text."""

from heyoka_bike.scoring.reading.formats.words import read_table
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.vectors import Vectors

# One matrix alone is rows of numbers, and these begin early.
_OCTAVE, _VARIABLE, _SHORT = b"# Created by Octave", b"\n# name:", 400


def read(file: ResultFile) -> list[Vectors]:
    """The rows of a text; see `words.read_table`.

    Raises
    ------
    InputError
        No rows of numbers, or the variables that Octave writes with ``save -text``.
    """
    is_column = any(mark in file.head[:_SHORT] for mark in (b"_range\n", b"# columns: 1\n"))
    if file.head.startswith(_OCTAVE) and (is_column or file.head.count(_VARIABLE) > 1):
        raise file.request.error(
            "found variables of Octave's save -text, expected rows of numbers; save -v7 writes "
            "variables that are read"
        )
    return read_table(file.text(), file.encoding, file.request)

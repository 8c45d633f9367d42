"""Tables of several maneuvers, one below the other, with a column that tells which."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.reading.column_names import is_maneuver
from heyoka_bike.scoring.reading.expected import Expected
from heyoka_bike.scoring.reading.written import Written, WrittenTable


def by_maneuver(table: WrittenTable, expected: Expected, path: str) -> list[WrittenTable]:
    """A table for each maneuver, of a table with a column of their numbers; else the table alone.

    Raises
    ------
    InputError
        A number of a maneuver that is not in the reference, or no number.
    """
    names = expected.names or table.names or ()
    at = next((j for j, name in enumerate(names) if is_maneuver(name)), None)
    if at is None or at >= len(table.columns) or table.maneuver is not None:
        return [table]
    numbers = table.columns[at].values
    first = 0 if expected.count > 1 and (numbers == 0).any() else 1
    fits = (numbers == np.rint(numbers)) & (numbers >= first)
    fits &= numbers < first + expected.count
    if not fits.all():
        i = int(np.argmin(fits))
        found = f"{numbers[i]:.6g}" if np.isfinite(numbers[i]) else "no number"
        raise InputError(
            f"{'' if table.lines is not None else f'row {i + 1}: '}found {found} as "
            f"{quoted(names[at])}, expected {first} to {first + expected.count - 1}",
            file=path,
            line=None if table.lines is None else int(table.lines[i]),
        )
    return [
        _rows_of(table, numbers == number, at, int(number) + 1 - first)
        for number in np.unique(numbers)
    ]


def _rows_of(table: WrittenTable, rows: NDArray[np.bool_], at: int, number: int) -> WrittenTable:
    def part(column: Written) -> Written:
        lo = None if column.lo is None else column.lo[rows]
        return replace(column, values=column.values[rows], lo=lo)

    return replace(
        table,
        columns=[part(c) for c in table.columns],
        lines=None if table.lines is None else table.lines[rows],
        maneuver=number,
    )

"""Results from tables: every column where it belongs, rows in the order of time."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.reading.column_names import TIME, left_out, named_unit
from heyoka_bike.scoring.reading.expected import Expected
from heyoka_bike.scoring.reading.headings import Layout, layout
from heyoka_bike.scoring.reading.long_tables import by_maneuver
from heyoka_bike.scoring.reading.results import Results, Rows
from heyoka_bike.scoring.reading.times import Times, settle
from heyoka_bike.scoring.reading.written import WrittenTable

_log = logging.getLogger(__name__)


def assemble(
    tables: Sequence[WrittenTable], kind: str, path: str, maneuver: int | None, expected: Expected
) -> Results:
    """Put the columns of a file where they belong.

    Parameters
    ----------
    tables
        What the file has.
    kind
        Its format.
    path
        Its name.
    maneuver
        Number of the maneuver of columns that do not tell; None if that is not known.
    expected
        What columns there may be.

    Raises
    ------
    InputError
        Columns that cannot be told, a maneuver that is not in the reference, or a time that is not
        finite.
    """
    numbers = {None, *range(1, expected.count + 1)}
    tables = [part for table in tables for part in by_maneuver(table, expected, path)]
    known = [t for t in tables if t.maneuver in numbers]
    others = [f"maneuver {t.maneuver}" for t in tables if t.maneuver not in numbers]
    if not known:
        raise InputError(f"found {others[0]}, expected 1 to {expected.count}", file=path)
    findings = [left_out(others)] if others else []
    if len(known) == 1 and maneuver is not None and known[0].maneuver not in (None, maneuver):
        raise InputError(
            f"found maneuver {known[0].maneuver}, expected maneuver {maneuver}", file=path
        )
    maneuvers: dict[int | None, Rows] = {}
    digits: list[int] = []
    bad = _NotFinite()
    for table in known:

        def fail(message: str, line: int | None = table.heading) -> InputError:
            return InputError(message, file=path, line=line)

        alone = maneuver if table.maneuver is None else table.maneuver
        size = len(table.columns[0].values)
        places = layout(
            table.names, len(table.columns), expected, alone, fail, ordered=table.ordered, rows=size
        )
        for number, columns in places.maneuvers.items():
            _log.info(
                "%s: %s, %d rows, maneuver %s: time is column %d, %s", path, kind, size,
                number or "not told", places.time + 1,
                ", ".join(f"{key} {j + 1}" for key, j in columns.items()),
            )  # fmt: skip
        times = _times(table, places, path)
        names = expected.names or table.names or ()
        said = (*table.findings, *places.findings, *times.findings)
        findings += [f for f in said if f not in findings]
        for number, columns in places.maneuvers.items():
            maneuvers[number] = _rows(table, names, times, number, places.time, columns, bad)
            used = [table.columns[j].digits for j in columns.values()]
            digits += [d for d in used if d is not None]
    findings += bad.findings()
    rows = tuple(maneuvers[n] for n in sorted(maneuvers, key=lambda n: n or 0))
    return Results(path, kind, rows, min(digits, default=None), tuple(findings))


def _times(table: WrittenTable, places: Layout, path: str) -> Times:
    column = table.columns[places.time]
    bad = np.flatnonzero(~np.isfinite(column.values))
    if len(bad):
        found = "found a time that is not finite, expected seconds"
        i = int(bad[0])
        if table.lines is None:
            raise InputError(f"row {i + 1}: {found}", file=path)
        raise InputError(found, file=path, line=int(table.lines[i]), column=places.time + 1)
    unit = "ms" if places.in_milliseconds else "s"
    return settle(column.values, column.lo, column.significant, table.lines, unit)


def _rows(
    table: WrittenTable, names: Sequence[str], times: Times, number: int | None, time: int,
    columns: Mapping[str, int], bad: _NotFinite,
) -> Rows:  # fmt: skip
    values: dict[str, Array] = {}
    lo: dict[str, Array] = {}
    units: dict[str, str] = {}
    for key, j in columns.items():
        v, rest = table.columns[j].values, table.columns[j].lo
        is_bad = ~np.isfinite(v)
        if is_bad.any():
            bad.add(table, j, is_bad)
            v = np.where(is_bad, np.nan, v)
        if times.order is not None:
            v = v[times.order]
            rest = None if rest is None else rest[times.order]
        values[key] = v
        if j < len(names) and (unit := named_unit(names[j], key)):
            units[key] = unit
        if rest is not None:
            lo[key] = rest
    quantum = {TIME: table.columns[time].quantum}
    quantum |= {key: table.columns[j].quantum for key, j in columns.items()}
    return Rows(number, times.hi, times.lo, values, lo, quantum, units)


class _NotFinite:
    """Values that are not finite: how many, and the first one."""

    def __init__(self) -> None:
        self.total = 0
        self.first: tuple[int, int, str] | None = None

    def add(self, table: WrittenTable, j: int, is_bad: NDArray[np.bool_]) -> None:
        """Count those of a column."""
        self.total += int(is_bad.sum())
        i = int(np.argmax(is_bad))
        unit = "row" if table.lines is None else "line"
        first = (i + 1 if table.lines is None else int(table.lines[i])), j + 1, unit
        self.first = first if self.first is None else min(self.first, first)

    def findings(self) -> list[Finding]:
        """What is to be said, if anything."""
        if self.first is None:
            return []
        line, column, unit = self.first
        return [
            Finding(
                "not_finite",
                f"{self.total} values are not finite and not used (first in {unit} {line}, "
                f"column {column}).",
                Severity.WARNING,
                {"count": self.total, "line": line, "column": column},
            )
        ]

"""Scores as CSV (RFC 4180) and as a data frame: a row for each maneuver and column, SI units."""

import csv
import io
from collections.abc import Mapping, Sequence
from typing import Any

from heyoka_bike.errors import required
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.runs import Series
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore
from heyoka_bike.showing.formats.json import clean

_MEASURES = (
    "max_abs_error", "time_of_max", "rms_error", "max_rel_error", "scd", "mescd",
    "time_to_tolerance",
)  # fmt: skip

FIELDS = (
    "file", "maneuver", "name", "column", "unit", "definition", "sign", "written_unit", "offset",
    *_MEASURES, "floor", "as_written_max_abs_error", "values", "missing", "rows", "t_start",
    "t_end", "coverage", "step", "performance", "between", "column_count",
)  # fmt: skip
"""Fields of a row; rows of a series also have `RUN_FIELDS` before and `NAME_FIELD` after these."""

RUN_FIELDS = ("run", "run_step", "run_cpu")
"""Number of the run (from 1), its nominal step [s] and its processor time [s]."""

NAME_FIELD = "run_name"
"""Name of the run, or of the program if several programs are compared."""


# Spreadsheets execute a text that begins with one of these characters as a formula. An apostrophe
# before the text prevents this (https://owasp.org/www-community/attacks/CSV_Injection). Numbers get
# no apostrophe.
_BEGINNINGS_OF_FORMULAS = ("=", "+", "-", "@", "\t", "\r")


def render(scored: Report | Series) -> str:
    """Render the scores of a file or of a series as CSV; unknown values are empty."""
    text = io.StringIO()
    writer = csv.writer(text)
    is_one = isinstance(scored, Report)
    writer.writerow(FIELDS if is_one else (*RUN_FIELDS, *FIELDS, NAME_FIELD))
    writer.writerows(map(_cell, row) for row in _rows(scored))
    return text.getvalue()


def _rows(scored: Report | Series) -> list[tuple[Any, ...]]:
    """Return a row for each column of each maneuver (and run); None marks unknown values."""
    if isinstance(scored, Series):
        return [
            (i, run.step, run.cpu, *row, run.name)
            for i, run in enumerate(scored.runs, start=1)
            for row in _rows(run.report)
        ]
    path = clean(scored.file.path)
    return [(path, *_values(m, c)) for m in scored.maneuvers for c in m.columns]


def _values(m: ManeuverScore, c: ColumnScore) -> tuple[Any, ...]:
    """Return the fields of the row of a column, except the file."""
    r = c.as_understood
    measures = (getattr(r.measures, name) for name in _MEASURES)
    return (
        m.maneuver, m.name, c.key, c.unit, r.definition, r.sign, r.unit, r.offset,
        *measures, c.floor, c.as_written.measures.max_abs_error, c.values, c.missing, m.rows,
        m.t_start, m.t_end, m.coverage, m.step, m.performance, 0,
        m.column_count,
    )  # fmt: skip


def _cell(x: Any) -> str:
    found = clean(x)
    if isinstance(found, str) and found.startswith(_BEGINNINGS_OF_FORMULAS):
        return f"'{found}"
    return "" if found is None else repr(found) if isinstance(found, float) else str(found)


def frame(scored: Report | Series) -> Any:
    """Return the fields of the CSV as a pandas data frame.

    The index is the maneuver and the column, preceded by the run for a series.

    Raises
    ------
    MissingPackageError
        pandas is not installed.
    """
    index, rows = ["maneuver", "column"], _rows(scored)
    fields: Sequence[str] = FIELDS
    if isinstance(scored, Series):
        index, fields = [RUN_FIELDS[0], *index], (*RUN_FIELDS, *FIELDS)
        rows = [(clean(name or "") or i, *row) for i, *row, name in rows]
    return _pandas().DataFrame(rows, columns=fields).set_index(index)


def of_columns(time: Array | None, columns: Mapping[str, Array]) -> Any:
    """Return columns as a pandas data frame; the times [s], if given, are its index.

    Errors are raised as by `frame`.
    """
    index = None if time is None else _pandas().Index(time.ravel(), name="time")
    return _pandas().DataFrame({k: x.ravel() for k, x in columns.items()}, index=index)


def _pandas() -> Any:
    said = "pandas is not installed; to_pandas needs it (pip install pandas)"
    return required("pandas", said)

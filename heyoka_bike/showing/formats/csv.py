"""The scores as CSV (RFC 4180) and as data frame: a line for each maneuver and column, SI units."""

import csv
import io
import math
from collections.abc import Mapping
from typing import Any

from heyoka_bike.errors import required
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.report import ColumnScore, ManeuverScore, Report, Series

_MEASURES = (
    "max_abs_error", "time_of_max", "rms_error", "max_rel_error", "scd", "mescd",
    "time_to_tolerance",
)  # fmt: skip

FIELDS = (
    "file", "maneuver", "name", "column", "unit", "definition", "sign", "written_unit", "offset",
    *_MEASURES, "floor", "as_written_max_abs_error", "values", "missing", "rows", "t_start",
    "t_end", "coverage", "step", "performance", "between",
)  # fmt: skip
"""Fields of a line; those of a series begin with `RUN_FIELDS` and end with `NAME_FIELD`."""

RUN_FIELDS = ("run", "run_step", "run_cpu")
"""Number of the run from 1, its nominal step [s] and its processor time [s]."""

NAME_FIELD = "run_name"
"""Name of the run, or of the program where several are side by side."""


def render(scored: Report | Series) -> str:
    """The scores of a file or of a series as CSV; what is unknown is empty."""
    text = io.StringIO()
    writer = csv.writer(text)
    if isinstance(scored, Report):
        writer.writerow(FIELDS)
        writer.writerows(_lines(scored))
    else:
        writer.writerow((*RUN_FIELDS, *FIELDS, NAME_FIELD))
        for i, run in enumerate(scored.runs, start=1):
            start = (str(i), _cell(run.step), _cell(run.cpu))
            writer.writerows((*start, *line, _cell(run.name)) for line in _lines(run.report))
    return text.getvalue()


def values(report: Report) -> list[tuple[Any, ...]]:
    """The `FIELDS` of each maneuver and column; None where one is unknown."""
    return [_values(report.file.path, m, c) for m in report.maneuvers for c in m.columns]


def _lines(report: Report) -> list[tuple[str, ...]]:
    return [tuple(map(_cell, line)) for line in values(report)]


def _values(path: str, m: ManeuverScore, c: ColumnScore) -> tuple[Any, ...]:
    r = c.as_understood
    measures = (getattr(r.measures, name) for name in _MEASURES)
    return (
        _encodable(path), m.maneuver, m.name, c.key, c.unit, r.definition, r.sign, r.unit, r.offset,
        *measures, c.floor, c.as_written.measures.max_abs_error, c.values, c.missing, m.rows,
        m.t_start, m.t_end, m.coverage, m.step, m.performance, 0,
    )  # fmt: skip


def _cell(x: Any) -> str:
    if x is None:
        return ""
    if isinstance(x, str):
        return _encodable(x)
    if isinstance(x, float):
        return repr(float(x)) if math.isfinite(x) else ""
    return str(x)


def _encodable(text: str) -> str:
    """The text with escapes for bytes of a file's name that are no text."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def frame(scored: Report | Series) -> Any:
    """The fields of the CSV, with maneuver and column as index, of a series the run before them.

    Raises
    ------
    MissingPackageError
        pandas is not installed.
    """
    pandas = _pandas()
    index = ["maneuver", "column"]
    if isinstance(scored, Report):
        return pandas.DataFrame(values(scored), columns=FIELDS).set_index(index)
    rows = [
        (_encodable(run.name or "") or i, run.step, run.cpu, *line)
        for i, run in enumerate(scored.runs, start=1)
        for line in values(run.report)
    ]
    return pandas.DataFrame(rows, columns=[*RUN_FIELDS, *FIELDS]).set_index([RUN_FIELDS[0], *index])


def of_columns(time: Array | None, columns: Mapping[str, Array]) -> Any:
    """Columns with the times [s], if there are any, as index; see `frame`."""
    index = None if time is None else _pandas().Index(time.ravel(), name="time")
    return _pandas().DataFrame({k: x.ravel() for k, x in columns.items()}, index=index)


def _pandas() -> Any:
    said = "pandas is not installed; to_pandas needs it (pip install pandas)"
    return required("pandas", said)

"""Scores and columns as data frames of pandas, SI units."""

from collections.abc import Mapping
from typing import Any

from heyoka_bike.errors import required
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.report import Report, Series
from heyoka_bike.showing.formats.csv import FIELDS, RUN_FIELDS, values


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
        (run.name or i, run.step, run.cpu, *line)
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

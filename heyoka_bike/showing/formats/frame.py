"""The scores as a data frame of pandas: a row for each maneuver and column, SI units."""

from typing import Any

from heyoka_bike.errors import MissingPackageError
from heyoka_bike.scoring.report import Report, Series
from heyoka_bike.showing.formats.csv import FIELDS, RUN_FIELDS, values


def frame(scored: Report | Series) -> Any:
    """The fields of the CSV, with maneuver and column as index, of a series the run before them.

    Raises
    ------
    MissingPackageError
        pandas is not installed.
    """
    try:
        import pandas
    except ImportError:
        raise MissingPackageError(
            "pandas is not installed; to_pandas needs it (pip install pandas)"
        ) from None
    index = ["maneuver", "column"]
    if isinstance(scored, Report):
        return pandas.DataFrame(values(scored), columns=FIELDS).set_index(index)
    rows = [
        (run.name or i, run.step, run.cpu, *line)
        for i, run in enumerate(scored.runs, start=1)
        for line in values(run.report)
    ]
    return pandas.DataFrame(rows, columns=[*RUN_FIELDS, *FIELDS]).set_index([RUN_FIELDS[0], *index])

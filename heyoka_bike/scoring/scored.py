"""Output of a report or a series: a verdict, a file, a dictionary, a data frame."""

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from heyoka_bike.display import Displayed

if TYPE_CHECKING:
    import pandas


class Scored(Displayed):
    """A report or a series, in every format that the command ``score`` writes."""

    # The functions of `showing` accept only the two subclasses of this class, hence the casts
    # below.
    __slots__ = ()
    _view = "report"

    @property
    def verdict(self) -> str:
        """The verdict on the results in one line."""
        from heyoka_bike.showing.wording import verdict_text

        return verdict_text.verdict(cast(Any, self))

    def save(self, path: str | PathLike[str], format: str | None = None) -> Path:
        """Write the report to a file, completely or not at all; missing folders are created.

        Parameters
        ----------
        path
            The file. Its suffix sets the format: .html, .json, .csv, .xml (JUnit) or .txt (the
            table).
        format
            The format, if not that of the suffix: html, json, csv, junit, badge or table.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InputError
            The format is unknown, or the file cannot be written or is a result file itself.
        """
        from heyoka_bike.showing.formats import output

        return output.save(cast(Any, self), path, format)

    def to_html(self) -> str:
        """Return a self-contained HTML page, as ``save("report.html")`` writes it."""
        from heyoka_bike.showing.formats import output

        return output.render(cast(Any, self), "html")

    def to_json(self) -> str:
        """Return the whole report as JSON; the package contains the schema."""
        from heyoka_bike.showing.formats import output

        return output.render(cast(Any, self), "json")

    def to_dict(self) -> dict[str, Any]:
        """Return the content of the JSON as lists and dictionaries."""
        from heyoka_bike.showing.formats import json

        return json.document(cast(Any, self))

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a row for each maneuver and column (and run), with the fields of the CSV.

        Raises
        ------
        MissingPackageError
            pandas is not installed.
        """
        from heyoka_bike.showing.formats import csv

        return csv.frame(cast(Any, self))

    def __str__(self) -> str:
        from heyoka_bike.showing.formats import output

        return output.render(cast(Any, self), "table")

"""Forms of a report and a series: a verdict, a file, a dictionary, a data frame."""

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from heyoka_bike.display import Displayed

if TYPE_CHECKING:
    import pandas


class Scored(Displayed):
    """A report or a series, in every format that the command ``score`` writes."""

    # The functions of `showing` accept only these two subclasses, hence the casts below.
    __slots__ = ()
    _view = "report"

    @property
    def verdict(self) -> str:
        """One line that says what the results are worth."""
        from heyoka_bike.showing.wording import verdict_text

        return verdict_text.verdict(cast(Any, self))

    def save(self, path: str | PathLike[str], format: str | None = None) -> Path:
        """Write it to a file, whole or not at all; folders on the way are made.

        Parameters
        ----------
        path
            Its suffix tells the format: .html, .json, .csv, .xml (JUnit) or .txt (the table).
        format
            Another one than that of the suffix: html, json, csv, junit, badge or table.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InputError
            No such format, a file that cannot be written, or one of the results themselves.
        """
        from heyoka_bike.showing.formats import output

        return output.save(cast(Any, self), path, format)

    def to_html(self) -> str:
        """A page that needs nothing else, as ``save("report.html")`` writes it."""
        from heyoka_bike.showing.formats import output

        return output.render(cast(Any, self), "html")

    def to_json(self) -> str:
        """All of it as JSON, by the schema that is shipped."""
        from heyoka_bike.showing.formats import output

        return output.render(cast(Any, self), "json")

    def to_dict(self) -> dict[str, Any]:
        """The score as lists and dictionaries."""
        from heyoka_bike.showing.formats import json

        return json.document(cast(Any, self))

    def to_pandas(self) -> "pandas.DataFrame":
        """A row for each maneuver and column (and run), with the fields of the CSV.

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

"""Forms of a report and a series: a verdict, a file, a dictionary, a data frame."""

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heyoka_bike.display import Displayed, shown_by

if TYPE_CHECKING:
    import pandas


class Scored(Displayed):
    """A report or a series, in every format that the command ``score`` writes."""

    __slots__ = ()
    _view = "report"

    @property
    def verdict(self) -> str:
        """One line that says what the results are worth."""
        return str(shown_by("wording").verdict(self))

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
        found: Path = shown_by("formats.output").save(self, path, format)
        return found

    def to_html(self) -> str:
        """A page that needs nothing else, as ``save("report.html")`` writes it."""
        return str(shown_by("formats.output").render(self, "html"))

    def to_json(self) -> str:
        """All of it as JSON, by the schema that is shipped."""
        return str(shown_by("formats.output").render(self, "json"))

    def to_dict(self) -> dict[str, Any]:
        """The score as lists and dictionaries."""
        found: dict[str, Any] = shown_by("formats.json").document(self)
        return found

    def to_pandas(self) -> "pandas.DataFrame":
        """A row for each maneuver and column (and run), with the fields of the CSV.

        Raises
        ------
        MissingPackageError
            pandas is not installed.
        """
        return shown_by("formats.csv").frame(self)

    def __str__(self) -> str:
        return str(shown_by("formats.output").render(self, "table"))

"""Evidence about reading a file: names, lines, units and times as they are written."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

from heyoka_bike.errors import quoted, quoted_names, shortened
from heyoka_bike.scoring.evidence.base import Evidence, LostColumn
from heyoka_bike.scoring.evidence.words import counted
from heyoka_bike.scoring.findings import Finding, Severity, info, named, warning

_NAMES_OF_EVIDENCE = 100
"""Maximum number of names in the JSON of a finding."""


class Reason(Enum):
    """Why a column was not compared."""

    UNKNOWN_NAME = "its name is unknown"
    SET_ASIDE = "its name is known, but the number in it is not that of a maneuver"
    CONTRADICTS = "another column of this quantity, with different values, is compared"
    BESIDE_A_TABLE = "its name is known, but a separate table contains all columns"
    NO_COLUMN = "its name is known, but it does not have one value for each time"
    NO_SUCH_MANEUVER = "the reference does not contain its maneuver"
    NOT_UNDERSTOOD = "its name is unknown, but similar to that of a quantity"


@dataclass(frozen=True, slots=True)
class NotCompared(Evidence):
    """Columns were left out because of their names.

    Attributes
    ----------
    reason : Reason
    columns : tuple of LostColumn
        A column with an unknown name has the key of the quantity with the most similar name.
    columns_hint
        Hint on the option that names the columns.
    """

    reason: Reason
    columns: tuple[LostColumn, ...]
    columns_hint: str = ""

    def lost(self, compared: Collection[str]) -> Iterable[LostColumn]:
        if self.reason in (Reason.UNKNOWN_NAME, Reason.NOT_UNDERSTOOD):
            return ()
        # Do not list a column whose quantity has no compared column: the number of compared columns
        # shows that it is missing.
        return (x for x in self.columns if x.key is None or x.key in compared)

    def _finding(self) -> Finding:
        names = [column.name for column in self.columns]
        evidence: dict[str, Any] = {"names": _names(names), "count": len(names)}
        if self.reason == Reason.SET_ASIDE:
            return warning(
                "known_columns_left_out",
                f"Columns with known names are left out: {quoted_names(names)}. A number in a name "
                "is read as a maneuver only if the other names have one too, and the reference has "
                f"that maneuver; {self.columns_hint}",
                **evidence,
            )
        if self.reason == Reason.CONTRADICTS:
            return warning(
                "known_columns_left_out",
                f"Columns with known names are left out: {quoted_names(names)}. Another column of "
                "the same quantity has different values and is compared. Write each quantity once, "
                "or rename the column",
                **evidence,
            )
        if self.reason in _WHY_LEFT_OUT:
            return warning(
                "known_columns_left_out",
                f"Columns with known names are left out: {quoted_names(names)}. "
                f"{_WHY_LEFT_OUT[self.reason]}",
                **evidence,
            )
        if self.reason == Reason.NOT_UNDERSTOOD:
            keys = list(dict.fromkeys(column.key for column in self.columns if column.key))
            were = "was" if len(names) == 1 else "were"
            return warning(
                "columns_not_understood",
                f"{quoted_names(names)} {were} not understood; did you mean {named(keys)}? "
                f"{self.columns_hint[:1].upper()}{self.columns_hint[1:]}",
                **evidence,
                columns=keys,
            )
        like = [f" ({x.key}?)" if x.key else "" for x in self.columns]
        message = f"Columns with unknown names are left out: {quoted_names(names, like)}"
        return info("columns_left_out", message, **evidence)


@dataclass(frozen=True, slots=True)
class LastRowIncomplete(Evidence):
    """The last row of a text file is incomplete, because writing was interrupted; it is left out.

    Attributes
    ----------
    line
        Its line number.
    """

    line: int | None

    code = "last_row_incomplete"
    severity = Severity.WARNING

    def message(self) -> str:
        return f"The last row (line {self.line}) is incomplete, so it is left out"

    def numbers(self) -> Mapping[str, Any]:
        return {"line": self.line}


@dataclass(frozen=True, slots=True)
class CommonFactor(Evidence):
    """A line above the rows contains their common factor, a power of ten; it was applied."""

    power: int

    code = "common_factor"

    def message(self) -> str:
        return (
            f"All numbers were multiplied by 1e{self.power}, the common factor that MATLAB "
            "displays above them. To write all digits, use writematrix"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"factor": 10.0**self.power}


@dataclass(frozen=True, slots=True)
class LinesNotRead(Evidence):
    """Lines of a text file look like rows of numbers but were not read.

    Attributes
    ----------
    count
    first : tuple of (int, str)
        Number and text of each of the first few lines.
    """

    count: int
    first: tuple[tuple[int, str], ...]

    code = "lines_not_read"
    severity = Severity.WARNING

    def message(self) -> str:
        lines = ", ".join(f"line {number}: {quoted(text)}" for number, text in self.first)
        more = self.count - len(self.first)
        said = (
            "A line with numbers was"
            if self.count == 1
            else f"{self.count} lines with numbers were"
        )
        return f"{said} not read: {lines}{f', and {more} more' if more else ''}"

    def numbers(self) -> Mapping[str, Any]:
        return {
            "count": self.count,
            "lines": [{"line": number, "text": shortened(text)} for number, text in self.first],
        }


@dataclass(frozen=True, slots=True)
class NotFinite(Evidence):
    """Values are not finite; they are left out.

    Attributes
    ----------
    count
    counted_by, line, column
        Place of the first of these values: the word ``line`` or ``row``, its number, and the number
        of the column, from 1.
    """

    count: int
    counted_by: str
    line: int
    column: int

    code = "not_finite"
    severity = Severity.WARNING

    def message(self) -> str:
        first = "first in " if self.count > 1 else ""
        where = f"{first}{self.counted_by} {self.line}, column {self.column}"
        were = "was" if self.count == 1 else "were"
        values = counted(self.count, "value is", "values are")
        return f"{values} not finite and {were} left out ({where})"

    def numbers(self) -> Mapping[str, Any]:
        return {"count": self.count, "line": self.line, "column": self.column}


@dataclass(frozen=True, slots=True)
class NamesNotUsed(Evidence):
    """Columns were read in the benchmark's order, although a known name contradicts it.

    Attributes
    ----------
    columns
        Numbers of the columns whose names contradict their place, from 1.
    name
        Name of the first of these columns.
    unknown
        The unknown names: because of them, no name is used.
    """

    columns: tuple[int, ...]
    name: str
    unknown: tuple[str, ...]

    code = "names_not_used"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"Some column names are unknown ({quoted_names(self.unknown)}), so the columns are "
            f"read in the benchmark's order, although column {self.columns[0]} is named "
            f"{quoted(self.name)}"
        )

    def numbers(self) -> Mapping[str, Any]:
        unknown = _names(self.unknown)
        return {"columns": list(self.columns), "unknown": unknown}


@dataclass(frozen=True, slots=True)
class UnknownUnit(Evidence):
    """The name of a column contains an unknown unit."""

    name: str
    unit: str
    key: str

    code = "unit_unknown"
    severity = Severity.WARNING

    def message(self) -> str:
        taken = "it is read as seconds" if self.key == "time" else "only the usual units are tried"
        return (
            f"The unit {quoted(self.unit)} of the column {quoted(self.name)} is unknown, so {taken}"
        )

    def numbers(self) -> Mapping[str, Any]:
        (name,), (unit,) = _names([self.name]), _names([self.unit])
        return {"name": name, "unit": unit, "column": self.key}


@dataclass(frozen=True, slots=True)
class Transposed(Evidence):
    """The rows of an array were read as columns."""

    rows: int
    columns: int

    code = "transposed"

    def message(self) -> str:
        return (
            f"The table has {counted(self.rows, 'row')} and {counted(self.columns, 'column')}, so "
            "its rows are read as columns"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"shape": [self.rows, self.columns]}


@dataclass(frozen=True, slots=True)
class TimesAsDecimals(Evidence):
    """Binary times that are within rounding of decimal numbers were read as the decimal numbers.

    Attributes
    ----------
    places
        Number of decimals after the point.
    unit
        ``s`` or ``ms``.
    changed
        Number of times that differ from their decimal number.
    example
        The first of these times.
    """

    places: int
    unit: str
    changed: int
    example: float

    code = "times_read_as_multiples"

    def message(self) -> str:
        return (
            f"The times differ from multiples of {10.0**-self.places:g} {self.unit} only by binary "
            "rounding, and are read as these multiples (for example "
            f"{self.example:.{self.places}f} {self.unit})"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"places": self.places, "changed": self.changed}


@dataclass(frozen=True, slots=True)
class TimeUnitContradicted(Evidence):
    """The heading of the times names another unit, but their span is that of the run in seconds.

    Attributes
    ----------
    named
        The unit that the heading names.
    span
        Span of the times as they are written.
    """

    named: str
    span: float

    code = "time_unit_contradicted"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"time: the heading names the unit {self.named}, but the times span {self.span:.6g}, "
            "as the run does in seconds. They are read as seconds"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"named": self.named, "span": self.span}


@dataclass(frozen=True, slots=True)
class TimesFromFirst(Evidence):
    """The times are those of a computer clock; they were counted from the first row.

    Attributes
    ----------
    first
        The first time.
    unit
        Its unit.
    """

    first: float
    unit: str

    code = "times_from_first"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"The times begin at {self.first:.17g} {self.unit}, like those of a clock. They are "
            "counted from the first row, which is assumed to be the start of the run"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"first": self.first, "unit": self.unit}


@dataclass(frozen=True, slots=True)
class TimesOfDay(Evidence):
    """The times are times of day, perhaps with a date; they were counted from the first row."""

    first: str

    code = "times_of_day"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            "The times are times of day. Seconds are counted from the first row, "
            f"{quoted(self.first)}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"first": shortened(self.first)}


@dataclass(frozen=True, slots=True)
class TimesUnsorted(Evidence):
    """Some times are smaller than the time before; the rows were sorted.

    Attributes
    ----------
    counted_by, line
        Place of the first such time: the word ``line`` or ``row``, and its number.
    count
        Number of such times.
    """

    counted_by: str
    line: int
    count: int

    code = "times_unsorted"
    severity = Severity.WARNING

    def message(self) -> str:
        where = f"first in {self.counted_by} {self.line}"
        return f"Times decrease ({where}), so the rows were sorted by time"

    def numbers(self) -> Mapping[str, Any]:
        return {"line": self.line, "count": self.count}


@dataclass(frozen=True, slots=True)
class TimesRepeated(Evidence):
    """Rows repeat the time of another row.

    Attributes
    ----------
    count
        Number of rows that repeat a time.
    are_identical
        True if rows with the same time also have the same values in every column.
    """

    count: int
    are_identical: bool

    def _finding(self) -> Finding:
        repeat = counted(self.count, "row repeats", "rows repeat")
        if self.are_identical:
            said = f"{repeat} another row: the time and all values are equal"
            return info("times_repeated", said, count=self.count, identical=True)
        said = f"{repeat} the time of another row: the time column has too few digits"
        return warning("times_repeated", said, count=self.count, identical=False)


def _names(names: Sequence[str]) -> list[str]:
    return [shortened(name) for name in names[:_NAMES_OF_EVIDENCE]]


_WHY_LEFT_OUT = {
    Reason.BESIDE_A_TABLE: "Another table in the file contains all columns",
    Reason.NO_COLUMN: "They have more than one axis: write one value for each time",
}

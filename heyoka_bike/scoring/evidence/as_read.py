"""Evidence about how a file was read: names, lines, units and times as they are written."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

from heyoka_bike.errors import quoted, quoted_names, shortened
from heyoka_bike.scoring.evidence.base import Evidence, LostColumn
from heyoka_bike.scoring.evidence.words import counted
from heyoka_bike.scoring.findings import Finding, Severity, info, named, warning

_NAMES_OF_EVIDENCE = 100
"""Maximum number of names in the JSON of a finding; each is shortened as in a message."""


class Reason(Enum):
    """Why a column was not compared."""

    UNKNOWN_NAME = "its name means nothing that is known"
    SET_ASIDE = "its name is known, and its number is not that of a maneuver"
    CONTRADICTS = "another column of this quantity is compared, and its values are others"
    BESIDE_A_TABLE = "its name is known, and a table beside it has all columns"
    NO_COLUMN = "its name is known, and it has not one value for each time"
    NO_SUCH_MANEUVER = "the reference has no such maneuver"
    NOT_UNDERSTOOD = "its name is like that of a quantity"


@dataclass(frozen=True, slots=True)
class NotCompared(Evidence):
    """Columns whose names decide that they are not compared.

    Attributes
    ----------
    reason : Reason
    columns : tuple of LostColumn
        A column of unknown name has the key of the quantity whose name resembles its own.
    columns_hint
        Words on the option that names the columns.
    """

    reason: Reason
    columns: tuple[LostColumn, ...]
    columns_hint: str = ""

    def lost(self, compared: Collection[str]) -> Iterable[LostColumn]:
        if self.reason in (Reason.UNKNOWN_NAME, Reason.NOT_UNDERSTOOD):
            return ()
        # A quantity that no column gives is already missing from the count of compared columns.
        return (x for x in self.columns if x.key is None or x.key in compared)

    def _finding(self) -> Finding:
        names = [column.name for column in self.columns]
        evidence: dict[str, Any] = {"names": _names(names), "count": len(names)}
        if self.reason == Reason.SET_ASIDE:
            return warning(
                "known_columns_left_out",
                f"Columns that are known by name are left out: {quoted_names(names)}. A number in "
                "a name is that of a maneuver only if the other names have one, and if the "
                f"reference has that maneuver; {self.columns_hint}.",
                **evidence,
            )
        if self.reason == Reason.CONTRADICTS:
            return warning(
                "known_columns_left_out",
                f"{quoted_names(names)}: other values than those of the column of the same "
                "quantity that is compared. Write each quantity once, or name the column by what "
                "else it is.",
                **evidence,
            )
        if self.reason in _WHY_LEFT_OUT:
            return warning(
                "known_columns_left_out",
                f"Columns that are known by name are left out: {quoted_names(names)}. "
                f"{_WHY_LEFT_OUT[self.reason]}",
                **evidence,
            )
        if self.reason == Reason.NOT_UNDERSTOOD:
            keys = list(dict.fromkeys(column.key for column in self.columns if column.key))
            were = "was" if len(names) == 1 else "were"
            return warning(
                "columns_not_understood",
                f"{quoted_names(names)} {were} not understood; did you mean {named(keys)}? "
                f"{self.columns_hint[:1].upper()}{self.columns_hint[1:]}.",
                **evidence,
                columns=keys,
            )
        like = [f" ({x.key}?)" if x.key else "" for x in self.columns]
        message = f"Columns of other names are left out: {quoted_names(names, like)}."
        return info("columns_left_out", message, **evidence)


@dataclass(frozen=True, slots=True)
class LastRowIncomplete(Evidence):
    """The last row of a text was cut while it was written; it is left out."""

    line: int | None

    code = "last_row_incomplete"
    severity = Severity.WARNING

    def message(self) -> str:
        return f"The last row (line {self.line}) is not complete and left out."

    def numbers(self) -> Mapping[str, Any]:
        return {"line": self.line}


@dataclass(frozen=True, slots=True)
class CommonFactor(Evidence):
    """A line above the rows holds their common factor, 10 to this power; it was applied."""

    power: int

    code = "common_factor"

    def message(self) -> str:
        return (
            f"All numbers were multiplied by 1e{self.power}, the common factor that MATLAB "
            "displays above them; writematrix writes all digits"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"factor": 10.0**self.power}


@dataclass(frozen=True, slots=True)
class LinesNotRead(Evidence):
    """Lines of a text look like rows of numbers and were not read.

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
        return f"{said} not read: {lines}{f', and {more} more' if more else ''}."

    def numbers(self) -> Mapping[str, Any]:
        return {
            "count": self.count,
            "lines": [{"line": number, "text": shortened(text)} for number, text in self.first],
        }


@dataclass(frozen=True, slots=True)
class NotFinite(Evidence):
    """Values that are not finite.

    Attributes
    ----------
    count
    counted_by, line, column
        The first of them: ``line`` or ``row``, its number, and the number of its column, from 1.
    """

    count: int
    counted_by: str
    line: int
    column: int

    code = "not_finite"
    severity = Severity.WARNING

    def message(self) -> str:
        where = f"first in {self.counted_by} {self.line}, column {self.column}"
        return f"{counted(self.count, 'value is', 'values are')} not finite and not used ({where})."

    def numbers(self) -> Mapping[str, Any]:
        return {"count": self.count, "line": self.line, "column": self.column}


@dataclass(frozen=True, slots=True)
class NamesNotUsed(Evidence):
    """Columns taken by their place although a known name contradicts it.

    Attributes
    ----------
    columns
        Numbers of the columns whose names contradict their place, from 1.
    name
        Name of the first of these columns.
    unknown
        The unknown names: because of them no name is used.
    """

    columns: tuple[int, ...]
    name: str
    unknown: tuple[str, ...]

    code = "names_not_used"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"Not all column names are known ({quoted_names(self.unknown)}), so the columns are "
            f"taken in the benchmark's order, although column {self.columns[0]} is named "
            f"{quoted(self.name)}."
        )

    def numbers(self) -> Mapping[str, Any]:
        unknown = _names(self.unknown)
        return {"columns": list(self.columns), "unknown": unknown}


@dataclass(frozen=True, slots=True)
class UnknownUnit(Evidence):
    """The name of a column has something in the place of a unit that is none."""

    name: str
    unit: str
    key: str

    code = "unit_unknown"
    severity = Severity.WARNING

    def message(self) -> str:
        taken = (
            "it is taken for seconds" if self.key == "time" else "only the usual units are tried"
        )
        return (
            f"The unit {quoted(self.unit)} of the column {quoted(self.name)} is not known, so "
            f"{taken}."
        )

    def numbers(self) -> Mapping[str, Any]:
        (name,), (unit,) = _names([self.name]), _names([self.unit])
        return {"name": name, "unit": unit, "column": self.key}


@dataclass(frozen=True, slots=True)
class Transposed(Evidence):
    """The rows of an array are taken as columns."""

    rows: int
    columns: int

    code = "transposed"

    def message(self) -> str:
        return (
            f"The table has {counted(self.rows, 'row')} and {counted(self.columns, 'column')}; its "
            "rows are taken as columns."
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"shape": [self.rows, self.columns]}


@dataclass(frozen=True, slots=True)
class TimesAsDecimals(Evidence):
    """Binary times that are next to decimals are read as these.

    Attributes
    ----------
    places
        Digits of the decimals after the point.
    unit
        ``s`` or ``ms``.
    changed
        Number of times whose decimal differs from the binary number.
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
            f"the times are binary numbers next to multiples of 1e-{self.places} {self.unit}, and "
            f"are read as these decimals ({self.example:.{self.places}f} {self.unit} is exactly "
            "that)"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"places": self.places, "changed": self.changed}


@dataclass(frozen=True, slots=True)
class TimeUnitContradicted(Evidence):
    """The heading of the times names one unit, and their span is the run in seconds.

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
            f"time: its heading says {self.named}, but the times span {self.span:.6g}, as the run "
            "does in seconds. They are taken as seconds"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"named": self.named, "span": self.span}


@dataclass(frozen=True, slots=True)
class TimesFromFirst(Evidence):
    """Times that count from long ago, as clocks of computers do, are taken from the first one.

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
            f"the times begin at {self.first:.17g} {self.unit}, as those of a clock do; they are "
            "counted from the first row, which is taken for the start"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"first": self.first, "unit": self.unit}


@dataclass(frozen=True, slots=True)
class TimesOfDay(Evidence):
    """Times of day, perhaps with a date, are counted from the first of them."""

    first: str

    code = "times_of_day"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            "The times are those of a day: seconds are counted from the first row, "
            f"{quoted(self.first)}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"first": shortened(self.first)}


@dataclass(frozen=True, slots=True)
class TimesUnsorted(Evidence):
    """Times go back, first in this line or row, so many times."""

    counted_by: str
    line: int
    count: int

    code = "times_unsorted"
    severity = Severity.WARNING

    def message(self) -> str:
        where = f"first in {self.counted_by} {self.line}"
        return f"Times go back ({where}); the rows are sorted by time."

    def numbers(self) -> Mapping[str, Any]:
        return {"line": self.line, "count": self.count}


@dataclass(frozen=True, slots=True)
class TimesRepeated(Evidence):
    """Rows that repeat the time of another row.

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
            said = f"{repeat} another row, with the same time and the same values"
            return info("times_repeated", said, count=self.count, identical=True)
        said = f"{repeat} the time of another row: the time column has too few digits"
        return warning("times_repeated", said, count=self.count, identical=False)


def _names(names: Sequence[str]) -> list[str]:
    return [shortened(name) for name in names[:_NAMES_OF_EVIDENCE]]


_WHY_LEFT_OUT = {
    Reason.BESIDE_A_TABLE: "A table beside them has all columns.",
    Reason.NO_COLUMN: "They have more than one axis: write one value for each time.",
}

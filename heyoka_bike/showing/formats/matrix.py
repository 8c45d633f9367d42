"""The first thing a report shows: correct digits of every column in every maneuver."""

from collections.abc import Sequence
from dataclasses import dataclass

from heyoka_bike.errors import printable
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.report import Report
from heyoka_bike.showing.formats.grades import Grade, grade
from heyoka_bike.showing.formats.wording import is_default, one_decimal, plain, unit_text

_MOST_ROWS = 12  # the benchmark has eight columns, a file of the whole motion up to a hundred


@dataclass(frozen=True, slots=True)
class Cell:
    """A column in one maneuver, or of one program.

    Attributes
    ----------
    digits
        Correct digits, ``-`` if unknown.
    grade : Grade
    """

    digits: str
    grade: Grade


@dataclass(frozen=True, slots=True)
class Row:
    """A column of the file.

    Attributes
    ----------
    key
    cells : tuple of Cell
        One for each maneuver.
    taken
        How the file's values were taken, in words.
    """

    key: str
    cells: tuple[Cell, ...]
    taken: str


@dataclass(frozen=True, slots=True)
class Matrix:
    """Correct digits, columns by maneuvers.

    Attributes
    ----------
    maneuvers : tuple of int
    rows : tuple of Row
        Of a file with very many columns those with the fewest digits.
    left_out
        How many others there are.
    """

    maneuvers: tuple[int, ...]
    rows: tuple[Row, ...]
    left_out: int

    @property
    def grades(self) -> set[Grade]:
        """Those that occur."""
        return {cell.grade for row in self.rows for cell in row.cells}


def cell(column: ColumnScore | None) -> Cell:
    """What is shown of a column; None where there is none."""
    if column is None:
        return Cell("-", Grade.UNKNOWN)
    return Cell(one_decimal(column.as_understood.measures.scd), grade(column))


def worst_cell(columns: Sequence[ColumnScore]) -> Cell:
    """The fewest digits of some columns, and the worst grade."""
    known = [c for c in columns if c.as_understood.measures.scd is not None]
    if not known:
        return cell(None)
    return Cell(one_decimal(_fewest(known)), max(map(grade, known)))


def matrix(report: Report) -> Matrix:
    """Correct digits of a report."""
    columns = by_key(report)
    worst = sorted(columns, key=lambda key: _fewest(columns[key]))[:_MOST_ROWS]
    rows = []
    for key, found in columns.items():
        if key in worst:
            cells = (next((c for c in m.columns if c.key == key), None) for m in report.maneuvers)
            rows.append(Row(key, tuple(map(cell, cells)), taken(found)))
    numbers = tuple(m.maneuver for m in report.maneuvers)
    return Matrix(numbers, tuple(rows), len(columns) - len(rows))


def _fewest(columns: Sequence[ColumnScore]) -> float:
    digits = (c.as_understood.measures.scd for c in columns)
    return min((x for x in digits if x is not None), default=0.0)


def taken(columns: Sequence[ColumnScore]) -> str:
    """How a column was taken, in words: its definition where there is a choice, and `unusual`."""
    c = _compared(columns)[0]
    said = [printable(c.as_understood.definition)] if c.alternatives else []
    return ", ".join([*said, *unusual(columns)])


def unusual(columns: Sequence[ColumnScore]) -> list[str]:
    """In what a column, over all maneuvers, is not taken as by default, and what is left open."""
    found = _compared(columns)
    c = found[0]
    r = c.as_understood
    said = []
    if not c.is_known:
        said.append("the nearest, but its definition is unknown")
    elif not is_default(c):
        said.append(f"not the default {printable(c.as_written.definition)}")
    others = {name: None for x in found for name in x.indistinguishable if name != r.definition}
    if others:
        said.append(f"may also be {' or '.join(map(printable, others))}")
    if r.sign != c.as_written.sign:
        said.append("other sign")
    if r.unit != c.as_written.unit:
        said.append(f"in {unit_text(r.unit)}")
    if r.offset != c.as_written.offset:
        said.append(f"zero at {plain(r.offset, 5)} {unit_text(c.unit)}")
    return said


def conventions(report: Report) -> str:
    """What the file means otherwise than by default, in one line; none of it is an error."""
    said = [
        f"{printable(key)} {taken(columns)}"
        for key, columns in by_key(report).items()
        if unusual(columns)
    ]
    return "; ".join(said) or "all columns as by default"


def by_key(report: Report) -> dict[str, list[ColumnScore]]:
    """Each column of a file, in all maneuvers."""
    found: dict[str, list[ColumnScore]] = {}
    for m in report.maneuvers:
        for c in m.columns:
            found.setdefault(c.key, []).append(c)
    return found


def _compared(columns: Sequence[ColumnScore]) -> Sequence[ColumnScore]:
    return [c for c in columns if c.values] or columns

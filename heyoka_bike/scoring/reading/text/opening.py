"""Find the beginning of a table: the dialect of its lines, its heading, and its first row.

The lines are those of a text, or the rows of a sheet.
"""

from __future__ import annotations

import logging
import re
from bisect import bisect_left
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, islice, pairwise
from typing import Any

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.evidence.as_read import LinesNotRead
from heyoka_bike.scoring.reading.digits import are_beyond_binary64
from heyoka_bike.scoring.reading.names.heading import (
    is_known,
    is_maneuver,
    maneuvers_in,
    time_among,
)
from heyoka_bike.scoring.reading.names.left_out import column_within
from heyoka_bike.scoring.reading.names.suggestions import names_found
from heyoka_bike.scoring.reading.not_read import PRINT_ALL, SHORTENED
from heyoka_bike.scoring.reading.request import LEFT_OUT, Request
from heyoka_bike.scoring.reading.text.dialects import (
    DIALECTS,
    Dialect,
    best_dialect,
    looks_like_number,
    without_comment,
)
from heyoka_bike.scoring.reading.text.headings import (
    COMMENT_SIGNS,
    Headings,
    are_units,
    heading_among,
    headings_in,
    is_heading,
    of_width,
)

_log = logging.getLogger(__name__)
# Number of lines from which the dialect is determined by majority. A small number makes this fast.
_SAMPLE_LINES = 300
# Number of rows that are checked for digits beyond binary64.
_SAMPLE_ROWS = 40
MOST_COLUMNS = 20_000
"""Maximum number of columns of a text, because names and digits are examined for each column."""

MOST_ABOVE = 10_000
"""Maximum number of lines in which the first row of numbers is searched for, apart from blank lines
and comments, so that the effort does not grow with the text."""

# Maximum number of names, in all lines together, among which the heading is searched for.
_MOST_NAMES = 2 * MOST_COLUMNS
# Maximum number of characters of a name that are examined.
_LONGEST_NAME = 10_000
# Number of lines in which the heading is searched for, because it is near the top of the file.
_HEADING_LINES = 100
# Minimum number of columns for a row 0 1 2 ... to be read as the numbers of the columns. With fewer
# columns, such a row may well be the first row of values.
_FEWEST_COUNTED = 9
# Minimum number of numbers in a line above the rows that is reported as a damaged row. In addition,
# more than half of its fields must be numbers.
_FEWEST_OF_A_ROW = 3
_DIGIT = re.compile(r"\d")
# Minimum number of numbers in a skipped line for it to be reported. A title may contain one number,
# such as the year.
_FEWEST_SKIPPED = 2
# Minimum number of rows, each wrapped over several lines with the same numbers of values, that show
# that rows are wrapped. Fewer rows may agree by chance.
_FEWEST_RECORDS = 3
# Maximum number of skipped lines that are quoted in a message, and maximum number of characters
# kept of each of them.
_MOST_SHOWN, _LONGEST_SHOWN = 3, 200
FACTOR = re.compile(r"\s*1\.?0*[eE]([+-]?[0-9]{1,2})\s*\*\s*")
"""The common factor that MATLAB displays above a matrix, on a separate line."""
Line = tuple[int, Any]
"""Index and content of a line."""


@dataclass(frozen=True, slots=True)
class Notation:
    """How the lines of a table are split and searched for names.

    Attributes
    ----------
    dialects : tuple of Dialect
        The possible dialects.
    without_comment : callable
        Returns a line up to its comment; empty if the line contains only a comment.
    headings_in : callable
        Returns a list of names for each way to split a line, see `headings`.
    is_blank : callable
        True if a line is blank.
    """

    dialects: tuple[Dialect, ...]
    without_comment: Callable[[Any], Any]
    headings_in: Callable[[Any], Iterable[list[str]]]
    is_blank: Callable[[Any], bool]


TEXT = Notation(DIALECTS, without_comment, headings_in, lambda line: not line.strip())
"""The notation of the lines of a text."""


@dataclass(slots=True)
class Skipped:
    """Lines that look like rows of numbers but are not read.

    Attributes
    ----------
    count : int
        Number of these lines.
    first : list of (int, str)
        The line number and the text of the first few of these lines.
    """

    count: int = 0
    first: list[tuple[int, str]] = field(default_factory=list)

    def add(self, number: int, line: Any) -> None:
        """Add a line of a text, or a row of a sheet, with its number."""
        self.count += 1
        if self.count <= _MOST_SHOWN:
            text = line if isinstance(line, str) else ", ".join(map(str, line))
            self.first.append((number, " ".join(text[:_LONGEST_SHOWN].split())))

    def evidence(self) -> tuple[LinesNotRead, ...]:
        """Return the evidence of these lines; empty if there are none."""
        return (LinesNotRead(self.count, tuple(self.first)),) if self.count else ()


@dataclass(frozen=True, slots=True)
class Opening:
    """The form of rows of numbers, and where they begin.

    Attributes
    ----------
    notation : Notation
    dialect : Dialect
    width
        Numbers in a row.
    line
        Number of lines before the first row.
    names : list of str or None
        Column names; None without a heading.
    heading
        Number of the line with the column names.
    time
        Index of the column of times.
    exact : tuple of int
        Columns with more digits than binary64 has.
    maneuver : int or None
        The only maneuver that comments above the rows mention; None without one.
    power
        Exponent of MATLAB's common factor: the values are 10 to this power times the numbers in the
        rows.
    skipped : Skipped
        The lines that look like rows but are not read. At first it contains lines above the first
        row; the reader of the rows adds those below it.
    """

    notation: Notation
    dialect: Dialect
    width: int
    line: int
    names: list[str] | None
    heading: int | None
    time: int
    exact: tuple[int, ...]
    maneuver: int | None = None
    power: int = 0
    skipped: Skipped = field(default_factory=Skipped)


def opened(lines: Sequence[Any], notation: Notation, request: Request) -> Opening:
    """Determine how the rows of numbers are written, and where they begin.

    Parameters
    ----------
    lines
        The first lines of the text or the sheet.
    notation
        How the lines are split.
    request
        The request to read them.

    Raises
    ------
    InputError
        There are no rows, they have an unexpected number of columns, or the first row is damaged.
    """
    widths = {*request.widths}
    # Keep only the indices of lines that are not blank, because millions of lines may be blank.
    written = [i for i, line in enumerate(lines) if line and not notation.is_blank(line)]
    if request.names is None:
        headings = _headings(lines, written[:_HEADING_LINES], notation)
        every = chain.from_iterable(headings.values())
        widths |= {len(x) for x in every if is_heading(x, request)}
    if not widths:
        raise request.not_columns("no line of column names that are known")
    if not written:
        raise request.error("found an empty file, expected rows of numbers")
    sample, dialect, width, rows = _first_rows(lines, written, notation, widths)
    if not rows:
        raise _no_row(lines, written[:MOST_ABOVE], notation, request)
    _refuse_wrapped(sample, dialect, widths, request)
    first = rows[0][0]
    if width > MOST_COLUMNS:
        said = f"found {width} columns, expected at most {MOST_COLUMNS}"
        raise request.error(said, first + 1)
    before = written[: bisect_left(written, first)][-MOST_ABOVE:]
    above = _headings(lines, reversed(before), notation)
    names, at = heading_among(above, width, request)
    if _count_up(rows, dialect):
        # pandas and R write no name for the index of the rows, so the heading may have one name
        # less than a row has numbers. If names contain blanks, a heading with one name more may
        # also seem to fit. The heading with fewer unknown names is right.
        others, above_others = heading_among(above, width - 1, request)
        if others and (names is None or _unknown(others) < _unknown(names)):
            names, at = [LEFT_OUT[0], *others], above_others
    if names is None and width in widths:
        names, at = _heading_with_similar_names(above, width, request)
    if width not in widths and (names is None or request.names):
        raise _wrong_width(above, width, len(rows), first + 1, request)
    _refuse_damaged_row(sample, first, dialect, width, request)
    heading = None if at is None else at + 1
    if request.names:
        names, heading = [*request.names], None
    time = time_among(names or ())
    _log.debug(
        "%s: rows of %d numbers from line %d, separator %r, decimal %r; names %s", request.path,
        width, first + 1, dialect.separator, dialect.decimal,
        f"in line {heading}" if heading else "told" if names else "none",
    )  # fmt: skip
    spread = (dialect.split(content) for _, content in rows[:: max(1, len(rows) // _SAMPLE_ROWS)])
    numbers = [[dialect.number(field) or "" for field in fields] for fields in spread]
    exact = tuple(
        j for j in range(width) if are_beyond_binary64([row[j] for row in numbers], j == time)
    )
    told = _maneuver_in_comments([lines[i] for i in before], notation)
    found = Opening(notation, dialect, width, first, names, heading, time, exact, told)
    skipped = Skipped()
    powers = {}
    for i in before:
        line = lines[i]
        if i == at or any(len(x) == width and are_units(x) for x in above.get(i, ())):
            continue
        if isinstance(line, str) and (match := FACTOR.fullmatch(line)):
            powers[i] = int(match[1])
        elif looks_like_row(line, found):
            skipped.add(i + 1, line)
    for i in [*powers][:-1]:
        skipped.add(i + 1, lines[i])
    power = next(reversed(powers.values()), 0)
    return replace(found, power=power, skipped=skipped)


def looks_like_row(line: Any, opening: Opening) -> bool:
    """True if a line that is not read looks like a row of numbers.

    At least two of its fields, and more than half of them, look like numbers; or as many fields as
    the rows have columns. Only the latter holds for a comment, which may list a few parameters.
    Integers after a word, such as ``maneuver 1 1 2 2``, are labels.
    """
    if isinstance(line, str) and not _DIGIT.search(line):
        return False
    content = opening.notation.without_comment(line)
    is_comment = not content and isinstance(line, str)
    text = COMMENT_SIGNS.sub("", line, count=1) if is_comment else content
    # The separator of the line may differ from that of the rows. Every second dialect has a new
    # separator.
    for dialect in opening.notation.dialects[::2]:
        fields = dialect.split(text)
        numbers = [field for field in fields if looks_like_number(field)]
        count = len(numbers)
        if numbers and fields[0] is not numbers[0] and all(str(x).isdigit() for x in numbers):
            return False
        if not is_comment and _counts_columns(content, dialect, opening.width):
            return False
        is_mostly = not is_comment and count >= _FEWEST_SKIPPED and 2 * count > len(fields)
        if is_mostly or count >= opening.width:
            return True
    return False


def _headings(
    lines: Sequence[Any], indices: Iterable[int], notation: Notation
) -> dict[int, list[list[str]]]:
    """Return, by line index in ascending order, the names in each line for each way to split it.

    A line with more words than `MOST_COLUMNS` is not a heading. If the lines have too many names in
    total, only the first of the given lines are returned.
    """
    found: dict[int, list[list[str]]] = {}
    count = 0
    for i in indices:
        every = (x for x in notation.headings_in(lines[i]) if len(x) <= MOST_COLUMNS)
        names = [[word[:_LONGEST_NAME] for word in words] for words in every]
        count += sum(map(len, names))
        if found and count > _MOST_NAMES:
            break
        if names:
            found[i] = names
    return dict(sorted(found.items()))


def _maneuver_in_comments(above: Sequence[Any], notation: Notation) -> int | None:
    """Return the only maneuver that lines with nothing but comments mention; None otherwise.

    A commented line of column names does not count, because each name may have a number of its own.
    """
    comments = [x for x in above if isinstance(x, str) and not notation.without_comment(x)]
    numbers = {n for comment in comments for n in maneuvers_in(comment)}
    return numbers.pop() if len(numbers) == 1 else None


def _heading_with_similar_names(
    above: Headings, width: int, request: Request
) -> tuple[list[str] | None, int | None]:
    """Return the last line of names in which a name contains a known name, and its index.

    The names themselves may all be unknown, but they may show that the columns are not in their
    usual places.
    """
    for i, names in of_width(above, width):
        plain = [name.strip(" \"'") for name in names]
        if any(column_within(name, request)[0] for name in plain):
            return plain, i
    return None, None


def _first_rows(
    lines: Sequence[Any], written: Sequence[int], notation: Notation, widths: Collection[int]
) -> tuple[list[Line], Dialect, int, list[Line]]:
    """Return the first lines with rows, their dialect, the number of columns, and the rows."""
    every = ((i, x) for i in written if (x := notation.without_comment(lines[i])))
    contents = islice(every, MOST_ABOVE)
    while sample := list(islice(contents, _SAMPLE_LINES)):
        found = best_dialect([content for _, content in sample], widths, notation.dialects)
        if found:
            dialect, width, at = found
            is_count = _counts_columns(sample[at[0]][1], dialect, width)
            return sample, dialect, width, [sample[i] for i in at[is_count:]]
    return [], notation.dialects[0], 0, []


def _refuse_wrapped(
    sample: Sequence[Line], dialect: Dialect, widths: Collection[int], request: Request
) -> None:
    """Raise an error if each row is wrapped over the same number of lines."""
    counts = [dialect.count(content) for _, content in sample]
    begin = next((i for i, count in enumerate(counts) if count is not None), 0)
    counts, lines = counts[begin:], sample[begin:]
    starts = [float(dialect.number(dialect.split(x)[0]) or "nan") for _, x in lines]
    if all(a < b for a, b in pairwise(starts)):
        # If every line begins with a later time than the line before, each line is a row.
        return
    for width in sorted(widths):
        found = _counts_of_lines(counts, width)
        records = len(counts) // len(found) if len(found) > 1 else 0
        if records < _FEWEST_RECORDS or counts[: records * len(found)] != [*found] * records:
            continue
        # If names consist of several words, the heading seems to have a multiple of the true number
        # of columns. So lines with equally many values count as parts of a row only if the width of
        # the row is expected.
        if len({*found}) == 1 and width not in request.widths:
            continue
        times = starts[: records * len(found) : len(found)]
        if all(a < b for a, b in pairwise(times)):
            *some, last = map(str, found)
            instead = (
                "in Fortran: write (unit, '(*(g0, 1x))') row"
                if dialect.separator
                else "in NumPy: np.savetxt('results.txt', np.fromfile(FILE, sep=' ').reshape(-1, "
                f"{width}))"
            )
            raise request.error(
                f"found each row of {width} values on {len(found)} lines ({', '.join(some)} and "
                f"{last} values), expected one line; {instead}",
                lines[0][0] + 1,
            )


def _counts_of_lines(counts: Sequence[int | None], width: int) -> list[int]:
    """Return how many numbers each line of the first row has; empty if the lines form no row."""
    found: list[int] = []
    for count in counts:
        if count is None or sum(found) >= width:
            break
        found.append(count)
    return found if sum(found) == width else []


def _unknown(names: Sequence[str]) -> int:
    """Return how many of the names are unknown."""
    return sum(not (is_known(name) or is_maneuver(name)) for name in names)


def _count_up(rows: Sequence[Line], dialect: Dialect) -> bool:
    """True if the rows begin with consecutive integers."""
    first = [str(dialect.split(content)[0]).strip("\"'") for _, content in rows]
    counted = [int(x) for x in first if x.isascii() and x.isdigit()]
    return len(counted) == len(rows) > 1 and counted == [*range(counted[0], counted[0] + len(rows))]


def _no_row(
    lines: Sequence[Any], written: Sequence[int], notation: Notation, request: Request
) -> InputError:
    """Return the error that there is no row of numbers; it names the first field that is no number.

    The field is in the first line that is not a heading, and that has a digit or does not begin
    with a letter.
    """
    for i in written:
        line = lines[i]
        content = notation.without_comment(line)
        first = str(content[0]).strip("\"' ")[:1] if content else ""
        has_digit = any(
            _DIGIT.search(str(x)) for x in ([content] if isinstance(content, str) else content)
        )
        if not content or (first.isalpha() and not has_digit):
            continue
        headings = _headings(lines, [i], notation).get(i, ())
        if any(is_heading(names, request) for names in headings):
            continue
        # Choose the dialect in which the largest number of fields are numbers.
        dialect = max(notation.dialects, key=lambda d: _count_of(content, d))
        numbers = dialect.numbers(dialect.split(content))
        if None in numbers:
            at = numbers.index(None)
            field = dialect.split(content)[at]
            if field in SHORTENED:
                return _shortened(field, request, i + 1, at + 1)
            said = dialect.empty if field == "" else f"{quoted(field)} as value {at + 1}"
            return request.not_columns(f"{said} and no row of numbers", i + 1, at + 1)
    where = f" in the first {MOST_ABOVE} lines" if len(written) == MOST_ABOVE else ""
    return request.not_columns(f"no row of numbers{where}")


def _count_of(content: Any, dialect: Dialect) -> tuple[int, int]:
    """Return how many fields of a line are numbers, and how many fields it has."""
    numbers = dialect.numbers(dialect.split(content))
    return len(numbers) - numbers.count(None), len(numbers)


def _shortened(field: str, request: Request, line: int, column: int) -> InputError:
    said = f"found {quoted(field)}, expected a number: {PRINT_ALL}"
    return request.error(said, line, column)


def row_error(
    content: Any, dialect: Dialect, width: int, request: Request, number: int
) -> InputError:
    """Return the error of the first wrong field in a line; the column counts the fields from 1."""
    fields = dialect.split(content)
    row = dialect.numbers(fields)
    if None in row[:width]:
        at = row.index(None)
        if fields[at] in SHORTENED:
            return _shortened(fields[at], request, number, at + 1)
        found = dialect.empty if fields[at] == "" else quoted(fields[at])
        message = f"found {found} as value {at + 1}, expected a number"
    else:
        at = min(len(fields), width)
        message = f"found {len(fields)} values, expected {width}"
    return request.error(message, number, at + 1)


def _wrong_width(above: Headings, width: int, rows: int, line: int, request: Request) -> InputError:
    """Return the error for rows with an unexpected number of columns, with their heading if any.

    Parameters
    ----------
    above
        Names that the lines above the rows may have.
    width, rows
        Number of columns and of rows.
    line
        Line number of the first row.
    request
        The request to read them.
    """
    for i, names in of_width(above, width):
        if request.names is None and not are_units(names):
            return request.not_columns(names_found(names), i + 1)
    return request.wrong_width(width, rows, line)


def _counts_columns(content: Any, dialect: Dialect, width: int) -> bool:
    """True if the row is 1 2 3 ... or 0 1 2 ..., which counts the columns."""
    if width < _FEWEST_COUNTED:
        return False
    numbers = dialect.numbers(dialect.split(content))
    return any(numbers == [str(i + start) for i in range(width)] for start in (0, 1))


def _refuse_damaged_row(
    sample: Sequence[Line], first: int, dialect: Dialect, width: int, request: Request
) -> None:
    """Raise an error if a line before the first row looks like a row and not like a heading."""
    for i, content in sample:
        if i >= first:
            return
        row = dialect.numbers(dialect.split(content))
        numbers = len(row) - row.count(None)
        is_row = (
            bool(row)
            and looks_like_number(dialect.split(content)[0])
            and numbers >= _FEWEST_OF_A_ROW
            and 2 * numbers > len(row)
        )
        if is_row and not _counts_columns(content, dialect, width):
            raise row_error(content, dialect, width, request, i + 1)

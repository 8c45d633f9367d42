"""Dialects: how a text separates and writes numbers, and how the cells of a sheet contain them.

Separators are commas, semicolons, tabs or blanks; the decimal sign is a point or a comma. The
letter of an exponent may be E, D or Q. Fortran omits it before three digits (ISO/IEC 1539-1,
section 13.7.2.3.3), and Mathematica writes ``*^``. Fortran's ``3*0.5`` stands for three values
(section 13.11.3.2). The dialect in which most lines are rows of numbers is used.

A row of a sheet is a line that is already split into fields. A field is a number, or a word that
contains a number with a decimal point or comma.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any, ClassVar

# Mathematica writes a backtick and the precision after a number.
_DECIMAL_NUMBER = re.compile(
    r"([+-]?)([0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:`{1,2}[0-9.]*)?"
    r"(?:(?:[eEdDqQ]|\*\^)([+-]?[0-9]+)|([+-][0-9]{3}))?"
)
# Plain form of a number. Most rows contain only such numbers. Matching all numbers of a row
# together is seven times as fast as matching them one by one.
_PLAIN_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_MANY_NUMBERS = re.compile(rf"{_PLAIN_NUMBER}(?:\n{_PLAIN_NUMBER})*")
# The pattern includes the forms that Microsoft's C library used to write, such as 1.#INF.
_NOT_FINITE = re.compile(
    r"[+-]?(?:nan(?:\([a-z0-9_]*\))?|inf(?:inity)?|[0-9]+\.?#(?:ind|inf|qnan|snan)[0-9]*)",
    re.IGNORECASE,
)
# The character # begins a comment, but in 1.#IND it is part of the number.
_COMMENT = re.compile(r"(?:(?<![0-9]\.)#|#(?!IND|INF|QNAN|SNAN))|[%!]|//", re.IGNORECASE)
_CUT_NUMBER = re.compile(r"[+-]?[0-9]*[.,]?[0-9]*(?:[eEdDqQ][+-]?)?")
# A repeat count and a value, as in Fortran's list-directed output.
_REPEATED = re.compile(r"([1-9][0-9]{0,2})\*([^*^].*)")
# Maximum number of values that the repeat counts of a row may produce, because a few bytes must not
# become many rows.
_MOST_REPEATED = 100
# A field that begins like a number, and contains no letters except those of an exponent. Dates and
# words do not match.
_LIKE_A_NUMBER = re.compile(
    r"[\"'(\[{]*[+-]?\.?[0-9][0-9.,+*^-]*(?:[eEdDqQ][0-9.,+*^-]*)*[)\]}\"']*"
)
_QUOTED = re.compile(r"\"[^\"]*\"|'[^']*'")


@dataclass(frozen=True)
class Dialect:
    """A decimal sign, and a way to separate numbers.

    Attributes
    ----------
    separator
        A comma, a semicolon or a tab, with any blanks around it; empty if blanks separate numbers.
    decimal
        The decimal point or comma.
    """

    separator: str
    decimal: str
    # Words for an empty field in messages.
    empty: ClassVar[str] = "no value between two separators"

    def may_read(self, lines: Sequence[Any]) -> bool:
        """True if the lines contain the signs of this dialect, as a quick first test."""
        text = "".join(lines)
        return self.separator in text and (self.decimal == "." or "," in text)

    def split(self, line: Any) -> list[Any]:
        """Return the fields of a line without blanks around them.

        A separator at the end of the line adds no field.
        """
        held = _QUOTED.findall(line) if '"' in line or "'" in line else []
        if held:
            # Separators inside of quotes do not separate fields.
            line = _QUOTED.sub("\0", line)
        if self.separator:
            fields = [field.strip(" \t") for field in line.split(self.separator)]
            if not fields[-1]:
                fields.pop()
        else:
            fields = [field for field in line.replace("\t", " ").split(" ") if field]
        if "*" in line:
            fields = self._expanded(fields)
        if not held:
            return fields
        back = iter(held)
        return [re.sub("\0", lambda _: next(back, "\0"), field) for field in fields]

    def _expanded(self, fields: list[str]) -> list[str]:
        """Return the fields with repeated values written out; unchanged if there are too many."""
        each = [_REPEATED.fullmatch(field) for field in fields]
        found = [x if x and self.number(x[2]) is not None else None for x in each]
        if sum(int(x[1]) for x in found if x) > _MOST_REPEATED:
            return fields
        parts = ([x[2]] * int(x[1]) if x else [f] for x, f in zip(found, fields, strict=True))
        return [field for part in parts for field in part]

    def number(self, field: Any) -> str | None:
        """Return a field as `float` reads it; ``nan`` if it is not finite, None if not a number."""
        if len(field) > 1 and field[0] == field[-1] and field[0] in "\"'":
            field = field[1:-1].strip(" \t")
        if self.decimal == ",":
            if "." in field:
                return None
            field = field.replace(",", ".")
        match = _DECIMAL_NUMBER.fullmatch(field)
        if match is None:
            return "nan" if _NOT_FINITE.fullmatch(field) else None
        sign, mantissa, power, bare = match.groups()
        if power is None and bare is None:
            return f"{sign}{mantissa}"
        # Fortran omits the letter of the exponent if the exponent needs three digits.
        if bare is not None and "." not in mantissa:
            return None
        return f"{sign}{mantissa}e{power or bare}"

    def numbers(self, fields: Sequence[Any]) -> list[str | None]:
        """Return the `number` of each field."""
        if self.decimal == "." and _MANY_NUMBERS.fullmatch("\n".join(fields)):
            return list(fields)
        return [self.number(field) for field in fields]

    def count(self, line: Any) -> int | None:
        """Return how many numbers a line has; None if it is empty or has any other field."""
        fields = self.split(line)
        return len(fields) if fields and None not in self.numbers(fields) else None

    def is_cut(self, fields: Sequence[Any], columns: int, at_end: bool) -> bool:
        """True if a row may be incomplete because the program was still writing it.

        The row consists of numbers, and the last field may be part of a number. The row has fewer
        fields than the table has columns, or as many if the text ends with this row (`at_end`).
        """
        if not 0 < len(fields) < columns + at_end:
            return False
        complete = all(self.number(field) is not None for field in fields[:-1])
        return complete and bool(self.number(fields[-1]) or _CUT_NUMBER.fullmatch(fields[-1]))


def looks_like_number(field: Any) -> bool:
    """True if a field is a number, or is written like one, such as ``2*`` or ``1.2.3``."""
    return is_number(field) or (isinstance(field, str) and bool(_LIKE_A_NUMBER.fullmatch(field)))


class DialectOfCells(Dialect):
    """The dialect of a sheet, whose cells are the fields; words may contain decimal commas."""

    empty: ClassVar[str] = "an empty cell"

    def may_read(self, lines: Sequence[Any]) -> bool:
        """True if the decimal sign is a point, or if any word contains a comma."""
        words = (x for row in lines for x in row if isinstance(x, str))
        return self.decimal == "." or any("," in word for word in words)

    def split(self, line: Any) -> list[Any]:
        """Return the cells of a row; an empty cell becomes an empty word."""
        return ["" if x is None else x if is_number(x) else str(x).strip() for x in line]

    def number(self, field: Any) -> str | None:
        """Return a number as text, and a word as in `Dialect.number`."""
        return repr(field) if is_number(field) else super().number(field)

    def numbers(self, fields: Sequence[Any]) -> list[str | None]:
        """Return the `number` of each field."""
        return [self.number(field) for field in fields]


def is_number(cell: Any) -> bool:
    """True if a cell contains a number, not a word or a truth value, and is not empty."""
    return isinstance(cell, Real) and not isinstance(cell, bool)


DIALECTS = tuple(
    Dialect(separator, decimal) for separator in ("\t", ";", ",", "") for decimal in (".", ",")
)
"""All dialects of texts. If several read a text equally well, the first of them is used."""

DIALECTS_OF_CELLS = (DialectOfCells("", "."), DialectOfCells("", ","))
"""The dialects of words in sheets."""


def without_comment(line: str) -> str:
    """Return the line up to the first comment sign: ``#``, ``%``, ``!`` or ``//``."""
    may_have = "#" in line or "%" in line or "!" in line or "//" in line
    match = _COMMENT.search(line) if may_have else None
    return (line if match is None else line[: match.start()]).strip()


def best_dialect(
    lines: Sequence[Any], fitting: Collection[int], dialects: Sequence[Dialect] = DIALECTS
) -> tuple[Dialect, int, list[int]] | None:
    """Return the dialect in which most lines are rows with the same number of numbers.

    Parameters
    ----------
    lines
        Lines without comments and without empty lines.
    fitting
        Expected numbers of columns; another number is chosen if over twice as many rows have it.
    dialects
        The possible dialects.

    Returns
    -------
    (Dialect, int, list of int) or None
        The dialect, the number of columns, and the indices of the lines that are rows; None if no
        line is a row of at least two numbers.
    """
    best: tuple[int, bool] = (0, False)
    found = None
    for dialect in dialects:
        if not dialect.may_read(lines):
            continue
        counts = [dialect.count(line) for line in lines]
        for count, times in Counter(counts).items():
            if count is None or count < 2:
                continue
            # Rows with an expected number of columns count twice. Nevertheless, many rows with
            # another number of columns outweigh a few such rows.
            fits = count in fitting
            if (times * (1 + fits), fits) > best:
                best = (times * (1 + fits), fits)
                found = dialect, count, [i for i, n in enumerate(counts) if n == count]
    return found

"""Dialects: how a text separates and writes numbers, and how the cells of a sheet hold them.

Separators are commas, semicolons, tabs or blanks; the decimal sign is a point or a comma. Exponents
may be written with the letters E, D or Q, or none, as Fortran writes three digits (ISO/IEC 1539-1,
section 13.7.2.3.3), or with Mathematica's ``*^``. Fortran's ``3*0.5`` is three values
(section 13.11.3.2). Of all dialects that is taken under which most lines are rows of numbers.

A row of a sheet is a line whose fields are apart already: a number is one, and a word may be one
with a decimal point or comma.
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
# Most rows contain only numbers of this plain form. Matching all numbers of a row together is seven
# times as fast as matching them one by one.
_PLAIN_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_MANY_NUMBERS = re.compile(rf"{_PLAIN_NUMBER}(?:\n{_PLAIN_NUMBER})*")
# The pattern includes the forms that Microsoft's C library used to write, such as 1.#INF.
_NOT_FINITE = re.compile(
    r"[+-]?(?:nan(?:\([a-z0-9_]*\))?|inf(?:inity)?|[0-9]+\.?#(?:ind|inf|qnan|snan)[0-9]*)",
    re.IGNORECASE,
)
# The sign # begins a comment, but in 1.#IND it is part of the number.
_COMMENT = re.compile(r"(?:(?<![0-9]\.)#|#(?!IND|INF|QNAN|SNAN))|[%!]|//", re.IGNORECASE)
_CUT_NUMBER = re.compile(r"[+-]?[0-9]*[.,]?[0-9]*(?:[eEdDqQ][+-]?)?")
# A repeat count and a value, as in Fortran's list-directed output.
_REPEATED = re.compile(r"([1-9][0-9]{0,2})\*([^*^].*)")
# Maximum number of values that the repeat counts of a row may produce, because a few bytes must not
# become many rows.
_MOST_REPEATED = 100
# A field that begins like a number, and contains no letters except those of an exponent. A date or
# a word does not match.
_LIKE_A_NUMBER = re.compile(
    r"[\"'(\[{]*[+-]?\.?[0-9][0-9.,+*^-]*(?:[eEdDqQ][0-9.,+*^-]*)*[)\]}\"']*"
)
_QUOTED = re.compile(r"\"[^\"]*\"|'[^']*'")


@dataclass(frozen=True)
class Dialect:
    """A way to separate and to write numbers.

    Attributes
    ----------
    separator
        A comma, a semicolon or a tab, with any blanks around it; nothing if blanks separate.
    decimal
        The decimal point or comma.
    """

    separator: str
    decimal: str
    # Words for an empty field in messages.
    empty: ClassVar[str] = "no value between two separators"

    def may_read(self, lines: Sequence[Any]) -> bool:
        """True if the signs of this dialect are in the lines, which is quickly seen."""
        text = "".join(lines)
        return self.separator in text and (self.decimal == "." or "," in text)

    def split(self, line: Any) -> list[Any]:
        """Fields of a line, without blanks around them; a separator at the end adds none."""
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
        """The number in the form that `float` reads, ``nan`` if it is not finite; None if none."""
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
        """`number` of each of the fields."""
        if self.decimal == "." and _MANY_NUMBERS.fullmatch("\n".join(fields)):
            return list(fields)
        return [self.number(field) for field in fields]

    def count(self, line: Any) -> int | None:
        """Count the numbers in the line; None if it has anything else or nothing."""
        fields = self.split(line)
        return len(fields) if fields and None not in self.numbers(fields) else None

    def is_cut(self, fields: Sequence[Any], columns: int, at_end: bool) -> bool:
        """True if a row may have been cut while it was being written.

        That is, numbers, then one that may be unfinished, fewer than the columns; as many if the
        text ends right there (`at_end`).
        """
        if not 0 < len(fields) < columns + at_end:
            return False
        complete = all(self.number(field) is not None for field in fields[:-1])
        return complete and bool(self.number(fields[-1]) or _CUT_NUMBER.fullmatch(fields[-1]))


def looks_like_number(field: Any) -> bool:
    """True if a field is a number, or is written like one, such as ``2*`` or ``1.2.3``."""
    return is_number(field) or (isinstance(field, str) and bool(_LIKE_A_NUMBER.fullmatch(field)))


class DialectOfCells(Dialect):
    """How words stand for numbers in a sheet, whose cells are the fields of its rows."""

    empty: ClassVar[str] = "an empty cell"

    def may_read(self, lines: Sequence[Any]) -> bool:
        """True unless decimal commas are looked for where no word has one."""
        words = (x for row in lines for x in row if isinstance(x, str))
        return self.decimal == "." or any("," in word for word in words)

    def split(self, line: Any) -> list[Any]:
        """The cells of a row; an empty one is an empty word."""
        return ["" if x is None else x if is_number(x) else str(x).strip() for x in line]

    def number(self, field: Any) -> str | None:
        """A number as it is, whatever the decimal sign of words."""
        return repr(field) if is_number(field) else super().number(field)

    def numbers(self, fields: Sequence[Any]) -> list[str | None]:
        """`number` of each of the fields."""
        return [self.number(field) for field in fields]


def is_number(cell: Any) -> bool:
    """True if a cell holds a number: no word, no truth value, and not nothing."""
    return isinstance(cell, Real) and not isinstance(cell, bool)


DIALECTS = tuple(
    Dialect(separator, decimal) for separator in ("\t", ";", ",", "") for decimal in (".", ",")
)
"""All dialects of texts; of two that read a text alike the first one is meant."""

DIALECTS_OF_CELLS = (DialectOfCells("", "."), DialectOfCells("", ","))
"""Those of the words in sheets."""


def without_comment(line: str) -> str:
    """The line up to the first of ``# % ! //``."""
    may_have = "#" in line or "%" in line or "!" in line or "//" in line
    match = _COMMENT.search(line) if may_have else None
    return (line if match is None else line[: match.start()]).strip()


def best_dialect(
    lines: Sequence[Any], fitting: Collection[int], dialects: Sequence[Dialect] = DIALECTS
) -> tuple[Dialect, int, list[int]] | None:
    """The dialect under which most lines are rows of numbers.

    Parameters
    ----------
    lines
        Without comments, none of them empty.
    fitting
        Numbers of columns that are expected; another one is taken if twice as many rows have it.
    dialects
        Those that are possible.

    Returns
    -------
    (Dialect, int, list of int) or None
        With the numbers in a row, and the indices of the lines that are rows; None if no line is
        a row of at least two numbers.
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
            # Rows with an expected number of columns count twice. So a few such rows among many
            # with a different number are not chosen.
            fits = count in fitting
            if (times * (1 + fits), fits) > best:
                best = (times * (1 + fits), fits)
                found = dialect, count, [i for i, n in enumerate(counts) if n == count]
    return found

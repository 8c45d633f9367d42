"""CSV: the rows, exact times and a heading line, after lines of comment."""

import csv
import io
from decimal import Context, Decimal
from fractions import Fraction

from heyoka_bike.numbers.exact import shortest_decimal
from heyoka_bike.reference.exports.selection import (
    Selection,
    about,
    commented,
    row_times,
    sharing_times,
)
from heyoka_bike.reference.load import ReferenceManeuver

SUFFIXES = (".csv",)

DIGITS = {
    17: "Values read back as the correctly rounded binary64",
    32: "Values are hi + lo of the reference, to 32 digits",
}
"""Meaning of the values, by the number of their digits."""

# Of a time that is no decimal, as in the reference's text.
_TIME_DIGITS = 50


def render(selection: Selection, stem: str, digits: int = 17) -> dict[str, bytes]:
    """A table of all maneuvers, or one for each if their times differ."""
    parts = sharing_times(selection)
    return {f"{tag}.csv": _table(part, digits).encode("ascii") for tag, part in parts.items()}


def _table(selection: Selection, digits: int) -> str:
    use = (
        "Read: lines that begin with # are comments, as for pandas.read_csv(..., comment='#') and "
        f"heyoka-bike score. {DIGITS[digits]}; times are exact."
    )
    first = selection.reference[selection.numbers[0]]
    times = [shortest_decimal(t, _TIME_DIGITS) for t in row_times(first)]
    names, columns = ["time [s]"], [times]
    for number, m in selection.maneuvers:
        for column in selection.columns:
            names.append(f"maneuver_{number}_{column.name} [{column.unit}]")
            columns.append(_values(m, column.name, digits))
    text = io.StringIO()
    text.write(commented(about(selection, "the rows", use), "#"))
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows(zip(*columns, strict=True))
    return text.getvalue()


def _values(m: ReferenceManeuver, name: str, digits: int) -> list[str]:
    hi = m.rows[name].tolist()
    if digits == 17:
        return [f"{x:.17g}" for x in hi]
    return [
        _decimal(Fraction(x) + Fraction(rest), digits)
        for x, rest in zip(hi, m.rows.lo[name].tolist(), strict=True)
    ]


def _decimal(x: Fraction, digits: int) -> str:
    quotient = Context(prec=digits).divide(Decimal(x.numerator), Decimal(x.denominator))
    return f"{quotient:.{digits - 1}e}" if x else "0"

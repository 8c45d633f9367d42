"""Conventions: interpretations of a file's columns that differ from the default without error.

The benchmark prescribes neither axes nor units nor the zero of the energy, and does not define roll
angle, roll rate and forward speed. A file's differences from the default are reported in one
sentence, and for each column with the errors that remain under each choice.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from heyoka_bike.scoring.evidence.base import Errors
from heyoka_bike.scoring.evidence.column_meaning import (
    Convention,
    Conventions,
    OtherDefinition,
    OtherSign,
    OtherUnit,
    OtherZero,
    TakenDefinition,
)
from heyoka_bike.scoring.judge.signs import odd_signs
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import Alternative, ColumnScore, also_open, odds_of


def conventions(report: Report) -> Iterator[Conventions]:
    """Yield one piece of evidence for all conventions of a file; nothing if all are the default."""
    columns = {key: places[0][1] for key, places in report.by_column().items()}
    # A sign that may be an error is not a convention.
    contradicted = {key for odd in odd_signs(report) for key in odd.keys}
    turned = [k for k, c in columns.items() if c.as_understood.sign < 0 and k not in contradicted]
    taken = {key: c.as_understood for key, c in columns.items()}
    units = {k: x.unit for k, x in taken.items() if x.unit != columns[k].as_written.unit}
    zeros = {k: x.offset for k, x in taken.items() if x.offset}
    meant = tuple(_taken(k, [c]) for k, c in columns.items() if _is_another(c))
    if turned or units or zeros or meant:
        has_others = len(columns) > 1
        yield Conventions(tuple(turned), units, zeros, meant, bool(contradicted), has_others)


def each_convention(report: Report) -> Iterator[Convention]:
    """Yield evidence of each column's convention, with the errors under each choice."""
    for key, places in report.by_column().items():
        columns = [c for _, c in places]
        taken, written = columns[0].as_understood, columns[0].as_written
        both = _errors(columns), tuple(c.as_written.measures.max_abs_error for c in columns)
        if _is_another(columns[0]):
            default = written.definition
            far = [a for c in columns for a in c.alternatives if a.definition == default]
            yield OtherDefinition(key, *both, _taken(key, columns), default, _errors(far))
        if taken.sign < 0:
            yield OtherSign(key, *both)
        if taken.unit != written.unit:
            yield OtherUnit(key, *both, taken.unit, written.unit)
        if taken.offset:
            yield OtherZero(key, *both, taken.offset)


def _is_another(c: ColumnScore) -> bool:
    """True if a column certainly has a definition other than the default."""
    return c.definition != c.as_written.definition and c.is_known


def _taken(key: str, columns: list[ColumnScore]) -> TakenDefinition:
    return TakenDefinition(key, columns[0].definition, odds_of(columns[0]), also_open(columns))


def _errors(found: Iterable[ColumnScore | Alternative]) -> Errors:
    return tuple(x.max_abs_error for x in found)

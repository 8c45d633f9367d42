"""Requirements on a report: ``[maneuver.][column.]metric op number``.

A requirement that names no maneuver or no column refers to all of them, and their worst value
counts: the largest for ``<`` and ``<=``, the smallest for ``>`` and ``>=``. A requirement fails,
whatever the values are, if one of its columns has values that are not finite, was not compared, or
contradicts another column by its sign, or if the file does not have the maneuver or the column.

Every requirement refers to all eight columns over the whole run, in each maneuver that it is about,
even if it names one column: what was not compared may be wrong. ``columns >= 5`` and
``coverage >= 0.3`` accept less, for themselves and for all other requirements.
"""

import operator
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import floor, isfinite

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED
from heyoka_bike.errors import InputError, did_you_mean, unknown_word
from heyoka_bike.scoring.evidence.as_compared import ConstantColumns, NoReference
from heyoka_bike.scoring.evidence.base import LostColumn
from heyoka_bike.scoring.evidence.column_meaning import SignContradiction
from heyoka_bike.scoring.outcomes import (
    EnergyDoesNotCount,
    InPart,
    LeftOut,
    NeverFilledIn,
    NoSuchColumn,
    NoSuchManeuver,
    NothingCompared,
    Outcome,
    Requirement,
    SignContradicted,
    ValuesMissing,
    WorstValue,
)
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore
from heyoka_bike.scoring.verdict import ALL_COLUMNS, MIN_COVERAGE, claim

OF_COLUMN = (
    "scd", "mescd", "max_abs_error", "rms_error", "max_rel_error", "time_to_tolerance",
)  # fmt: skip
"""Metrics of a column, in its best interpretation, see `scores.Measures`."""

OF_MANEUVER = ("performance", "columns", "coverage", "gap")
"""Metrics of a maneuver, see `scores.ManeuverScore`; ``columns`` is its `column_count`."""

ENOUGH = ("columns", "coverage")
"""Metrics whose requirements set how much has to be compared, for all requirements."""

# Attributes of `ManeuverScore` whose names differ from those of their metrics.
_ATTRIBUTES = {"columns": "column_count"}
_COMPARISONS: Mapping[str, Callable[[float, float], bool]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "<": operator.lt,
    ">": operator.gt,
}
_FORM_OF_REQUIREMENT = re.compile(
    r"\s*(?:(?:maneuver_|m)?(?P<maneuver>[0-9]{1,4})\s*\.\s*)?"
    r"(?:(?P<column>[A-Za-z_][A-Za-z_0-9]*)\s*\.\s*)?(?P<metric>[A-Za-z_]+)\s*"
    r"(?P<op><=|>=|<|>)\s*(?P<number>[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]{1,4})?)\s*",
    re.ASCII,
)
_EXPECTED_FORM = 'expected [maneuver.][column.]metric op number, such as "2.roll_angle.scd >= 6"'


@dataclass(frozen=True, slots=True)
class Parsed:
    """A requirement after parsing.

    Attributes
    ----------
    maneuver, column
        Number of the maneuver from 1, and key of the column; None for all of them.
    metric, op, number
        As in ``scd >= 6``.
    """

    maneuver: int | None
    column: str | None
    metric: str
    op: str
    number: float

    @property
    def text(self) -> str:
        """The requirement as text that `parse` reads."""
        place = "".join(f"{x}." for x in (self.maneuver, self.column) if x is not None)
        return f"{place}{self.metric} {self.op} {repr(self.number).removesuffix('.0')}"


def parse(text: str) -> Parsed:
    """Parse a requirement.

    Raises
    ------
    InputError
        The text has another form, or names an unknown column or metric.
    """
    match = _FORM_OF_REQUIREMENT.fullmatch(text)
    if match is None:
        raise InputError(f"require: found {text!r:.60}, {_EXPECTED_FORM}")
    column, metric = match["column"], match["metric"]
    if metric not in OF_COLUMN + OF_MANEUVER:
        found = unknown_word(metric, OF_COLUMN + OF_MANEUVER, "metric ")
        raise InputError(f"require: {found}")
    if column is not None and column not in COMPARED:
        raise InputError(
            f"require: found column '{column:.40}', expected one of "
            f"{', '.join(BENCHMARK_COLUMNS)}, pitch, yaw, yaw_rate, or a column of motion.h5"
            f"{did_you_mean(column, COMPARED)}"
        )
    if column is not None and metric in OF_MANEUVER:
        raise InputError(
            f"require: found column '{column}' with '{metric}', a metric of a whole maneuver; "
            "leave out the column"
        )
    number = float(match["number"])
    if not isfinite(number):
        raise InputError(f"require: found {match['number']}, expected a finite number")
    maneuver = None if match["maneuver"] is None else int(match["maneuver"])
    return Parsed(maneuver, column, metric, match["op"], number)


def check(texts: Sequence[str], report: Report) -> tuple[Requirement, ...]:
    """Return the outcome of each requirement on a report.

    Requirements on ``columns`` and ``coverage`` set how much has to be compared, for all
    requirements.

    Raises
    ------
    InputError
        See `parse`.
    """
    every = [parse(text) for text in texts]
    limits = [r for r in every if r.metric in ENOUGH and r.op in (">", ">=")]

    def checked(text: str, r: Parsed) -> Requirement:
        parts = (_checked(part.text, part, report, limits) for part in _parts(r, report))
        return replace(_checked(text, r, report, limits), parts=tuple(parts))

    return tuple(map(checked, texts, every))


def _checked(text: str, r: Parsed, report: Report, limits: Sequence[Parsed]) -> Requirement:
    found = _outcome(r, report, limits)
    if not isinstance(found, WorstValue):
        return Requirement(text, False, None, found)
    is_met = _COMPARISONS[r.op](found.value, r.number)
    if is_met and (short := _shortfall(r, report, limits)):
        return Requirement(text, False, None, short)
    return Requirement(text, is_met, found.value if isfinite(found.value) else None, found)


def _shortfall(r: Parsed, report: Report, limits: Sequence[Parsed]) -> InPart | None:
    """Return how much was compared, if a requirement refers to more than that; else None."""
    about = [m for m in report.maneuvers if r.maneuver in (None, m.maneuver)]
    columns = [
        m for m in about if m.column_count < ALL_COLUMNS and not _is_limited("columns", m, limits)
    ]
    covered = [
        m for m in about if m.coverage < MIN_COVERAGE and not _is_limited("coverage", m, limits)
    ]
    if not columns and not covered:
        return None
    return InPart(
        tuple(m.maneuver for m in about if m in columns or m in covered),
        min((m.column_count for m in columns), default=None),
        min((floor(1000 * m.coverage) / 1000 for m in covered), default=None),
    )


def _is_limited(metric: str, m: ManeuverScore, limits: Sequence[Parsed]) -> bool:
    """True if any requirement limits this metric, ``columns`` or ``coverage``, for a maneuver."""
    return any(x.metric == metric and x.maneuver in (None, m.maneuver) for x in limits)


def _parts(r: Parsed, report: Report) -> Iterator[Parsed]:
    """Yield the requirement for each single column of each maneuver, or for each maneuver."""
    for m in report.maneuvers:
        if r.maneuver not in (None, m.maneuver):
            continue
        if r.metric in OF_MANEUVER:
            yield replace(r, maneuver=m.maneuver)
            continue
        for c in m.columns:
            if r.column in (None, c.key):
                yield replace(r, maneuver=m.maneuver, column=c.key)


def _outcome(r: Parsed, report: Report, limits: Sequence[Parsed]) -> Outcome:
    """Return the worst value of a requirement, or why the requirement fails whatever its values."""
    if lost := _columns_not_compared(r, report, limits):
        return lost
    maneuvers = [m for m in report.maneuvers if r.maneuver in (None, m.maneuver)]
    if not maneuvers and r.maneuver is not None:
        return NoSuchManeuver(r.maneuver)
    found: list[Outcome] = []
    if r.metric in OF_MANEUVER:
        found += [_of_maneuver(m, r) for m in maneuvers]
    else:
        found += [
            _of_column(m.maneuver, c, r, report)
            for m in maneuvers
            for c in m.columns
            if r.column in (None, c.key)
        ]
    if not found:
        without = (x for x in report.seen if isinstance(x, NoReference))
        return NoSuchColumn(r.column, has_reference=all(r.column not in x.keys for x in without))
    values = [x for x in found if isinstance(x, WorstValue)]
    if len(values) < len(found):
        return next(x for x in found if not isinstance(x, WorstValue))
    # Equal values are ordered by maneuver and column.
    worst = max if r.op in ("<", "<=") else min
    return worst(values, key=lambda x: (x.value, x.maneuver, x.key or ""))


def _of_column(number: int, c: ColumnScore, r: Parsed, report: Report) -> Outcome:
    if c.missing:
        return ValuesMissing(number, c.key, c.missing, c.missing + c.values)
    if c.is_contradicted:
        odd = (x for x in report.seen if isinstance(x, SignContradiction))
        return SignContradicted(number, next(x for x in odd if c.key in x.keys))
    value = c.shown(r.metric) if c.values else None
    if value is None:
        return NothingCompared(number, c.key, r.metric)
    measured = getattr(c.as_understood.measures, r.metric)
    return WorstValue(value, number, c.key, measured is not None and value != measured)


def _of_maneuver(m: ManeuverScore, r: Parsed) -> Outcome:
    for c in m.columns:
        if c.missing and (r.metric != "performance" or c.key.endswith("energy")):
            return ValuesMissing(m.maneuver, c.key, c.missing, c.missing + c.values)
    if r.metric != "performance":
        return WorstValue(getattr(m, _ATTRIBUTES.get(r.metric, r.metric)), m.maneuver)
    claimed = claim(m, r.number)
    if claimed.reason is not None:
        return EnergyDoesNotCount(m.maneuver, claimed.reason)
    return WorstValue(claimed.value, m.maneuver)


def _columns_not_compared(
    r: Parsed, report: Report, limits: Sequence[Parsed]
) -> LeftOut | NeverFilledIn | None:
    """Return the columns to which a requirement refers but that were not compared, if any.

    Columns that were never filled in are ignored in maneuvers for which a requirement sets how many
    columns are enough, unless this requirement names one of them.
    """
    enough = {m.maneuver for m in report.maneuvers if _is_limited("columns", m, limits)}

    def is_meant(x: LostColumn) -> bool:
        if None not in (r.maneuver, x.maneuver) and r.maneuver != x.maneuver:
            return False
        if r.metric == "performance":
            return x.key is None or x.key.endswith("energy")
        return None in (r.column, x.key) or r.column == x.key

    lost = tuple(filter(is_meant, report.not_compared))
    unfilled = {x for e in report.seen if isinstance(e, ConstantColumns) for x in e.lost(())}
    if never := tuple(x for x in lost if x in unfilled and (r.column or x.maneuver not in enough)):
        return NeverFilledIn(never)
    lost = tuple(x for x in lost if x not in unfilled)
    without = {x for e in report.seen if isinstance(e, NoReference) for x in e.lost(())}
    # If the reference lacks the column of a requirement, `NoSuchColumn` reports this.
    lost = tuple(x for x in lost if r.column is None or x not in without)
    return LeftOut(lost) if lost else None

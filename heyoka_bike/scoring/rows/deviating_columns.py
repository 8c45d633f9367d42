"""Find columns with one of the `column_faults`, and undo the fault.

A fault is reported if the column is explained or right in every maneuver, and the other columns are
right.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Severity
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, RIGHT, TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.measures import ROUNDING, rms
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.averages import SmoothedColumns
from heyoka_bike.scoring.rows.column_faults import COLUMN_FAULTS
from heyoka_bike.scoring.rows.filters import FilteredColumns
from heyoka_bike.scoring.rows.other_columns import OtherColumn, another, pairs_exchanged
from heyoka_bike.scoring.rows.other_maneuvers import of_other_maneuvers
from heyoka_bike.scoring.rows.scaled_columns import ColumnRatio, scaled
from heyoka_bike.scoring.rows.table import (
    Deviation,
    Undone,
    floor_of,
    is_right_column,
    places,
    to_si,
)
from heyoka_bike.scoring.scores import ManeuverScore

# Fields of evidence that state in which maneuvers or columns a fault is.
_WHERE = {"maneuvers", "places"}

_Deviations = Mapping[tuple[int, str], Deviation]
"""Deviations by maneuver number and column key."""


@dataclass(frozen=True, slots=True)
class MisplacedManeuver(Evidence):
    """The columns of a maneuver contain the values of another maneuver.

    Attributes
    ----------
    maneuver
        Number under which the values are written.
    of_maneuver
        Number of the maneuver whose values they are.
    """

    maneuver: int
    of_maneuver: int

    code = "other_maneuver"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"Maneuver {self.maneuver} has the values of maneuver {self.of_maneuver}. Check the "
            "initial speed and roll rate of each maneuver, and the order in which they are written"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuver": self.maneuver, "of_maneuver": self.of_maneuver}


def deviating_columns(report: Report) -> Undone | None:
    """Look for columns with one of the `COLUMN_FAULTS`.

    For each column the deviation that explains its error best is undone.
    """
    found: dict[tuple[int, str], Deviation] = {}
    # Skip columns with the values of a different maneuver: they are not a function of the exact
    # values.
    others = {(x.maneuver, key) for x in of_other_maneuvers(report.maneuvers) for key in x.keys}
    for m, c in places(report):
        has_enough = c.values >= MIN_ROWS_FOR_SHAPE and c.scale
        # A column that is constant, apart from roundoff, cannot be compared as a function of exact
        # values that vary. But it may have been written in place of a different column.
        least = floor_of(c) if np.ptp(c.trace.reference) > floor_of(c) else 0.0
        faults = COLUMN_FAULTS if np.ptp(c.trace.value) > least else (another,)
        if is_right_column(c) or not has_enough or (m.maneuver, c.key) in others:
            continue
        best = BY_FAR
        for describe in faults:
            if (deviation := describe(m, c, report)) is None:
                continue
            rows = np.isfinite(deviation.values)
            left = rms((c.trace.error - deviation.values)[rows])
            # The relief is the factor by which the fault reduces the error of the column.
            relief = rms(c.trace.error[rows]) / max(left, (c.floor or 0.0) / 2, ROUNDING * c.scale)
            # Simpler deviations are tried first. A deviation that is tried later must explain
            # clearly more of the error.
            if relief > best and left < TOLERANCE * c.scale:
                found[m.maneuver, c.key], best = deviation, AS_GOOD * relief
    found = _without_exchanged_everywhere(
        report, _of_one_ratio(report, _alike_everywhere(report, found, others))
    )
    if not found or not _is_beside_right(report, found):
        return None
    corrected = ((n, (key, _corrected(report[n], key, d))) for (n, key), d in found.items())
    values = grouped(corrected)
    parts = (m.part.rewritten(dict(values.get(m.maneuver, ()))) for m in report.maneuvers)
    return Undone(pairs_exchanged(_evidence(report, found)), tuple(parts), frozenset(found))


def _alike_everywhere(
    report: Report, found: _Deviations, others: set[tuple[int, str]]
) -> _Deviations:
    """Keep only deviations of columns that are explained, or right, in every maneuver.

    One program writes all maneuvers. If a column is wrong in another maneuver without such a simple
    explanation there, it is wrong for another reason.
    """
    errors = grouped((key, report[n][key].error) for n, key in found)
    unexplained = {
        c.key for m, c in places(report)
        if (m.maneuver, c.key) not in found.keys() | others and not is_right_column(c)
        and c.key in errors and not _is_far_better(c.error, min(errors[c.key]))
    }  # fmt: skip
    return {place: d for place, d in found.items() if place[1] not in unexplained}


def _of_one_ratio(report: Report, found: _Deviations) -> _Deviations:
    """Drop deviations whose numbers differ between maneuvers, except ratios that explain all.

    One program writes all maneuvers, so a true factor or delay is the same in all of them. An
    energy that lacks a part is near a different ratio in each maneuver.
    """
    refuted = {
        key
        for key, each in grouped((key, d) for (_, key), d in found.items()).items()
        if any(d.is_of_program for d in each) and not _agree([d.seen for d in each])
    }
    ratios = grouped((key, n) for (n, key), d in found.items() if _is_whole_ratio(d.seen))
    for key, numbers in ratios.items():
        columns = {n: report[n][key] for n in numbers}
        left = {n: c.trace.error - found[n, key].values for n, c in columns.items()}
        is_all = all(
            np.max(np.abs(left[n])) <= max(c.hidden, RIGHT * c.scale) for n, c in columns.items()
        )
        if not is_all and scaled([*columns.values()]) is None:
            refuted.add(key)
    return {place: d for place, d in found.items() if place[1] not in refuted}


def _is_whole_ratio(evidence: Evidence) -> bool:
    """True if evidence is a factor or an offset in all rows."""
    return isinstance(evidence, ColumnRatio) and (evidence.since is None and evidence.until is None)


def _agree(each: Sequence[Evidence]) -> bool:
    """True if all evidence describes the same fault, and its numbers agree to three digits."""
    exact, floats = zip(*map(_fault, each), strict=True)
    if len({*exact}) > 1:
        return False
    numbers = np.array(floats)
    return bool(np.all(np.ptp(numbers, axis=0) <= TOLERANCE * np.max(np.abs(numbers), axis=0)))


def _fault(evidence: Evidence) -> tuple[tuple[object, ...], tuple[float, ...]]:
    """Return the class of evidence with its exact fields, and its floats; both without the place.

    The floats of the same fault differ between maneuvers by rounding.
    """
    named = [(f.name, getattr(evidence, f.name)) for f in fields(evidence) if f.name not in _WHERE]
    exact = ((name, x) for name, x in named if not isinstance(x, float))
    return (type(evidence), *exact), tuple(x for _, x in named if isinstance(x, float))


def _without_exchanged_everywhere(
    report: Report, found: _Deviations
) -> dict[tuple[int, str], Deviation]:
    """Drop columns that are exchanged with another column in every maneuver.

    Simulated programs with this mistake are compared with such a file instead.
    """
    every = {
        key for key, places in report.by_column().items()
        if all((m.maneuver, key) in found
               and isinstance(x := found[m.maneuver, key].seen, OtherColumn)
               and x.of_maneuver is None for m, _ in places)
    }  # fmt: skip
    return {place: d for place, d in found.items() if place[1] not in every}


def _is_beside_right(report: Report, found: _Deviations) -> bool:
    """True if the columns without deviations are right to three digits, and far better."""
    for m in report.maneuvers:
        errors = {c.key: c.error for c in m.columns}
        mine = {key for n, key in found if n == m.maneuver}
        rest = max((x for key, x in errors.items() if key not in mine), default=0.0)
        if not all(_is_far_better(rest, errors[key]) for key in mine):
            return False
    return True


def _is_far_better(error: float, wrong: float) -> bool:
    """True if an error (in scales) is invisible, and far smaller than that of a wrong column."""
    return error <= min(TOLERANCE, wrong / CLEARLY)


def _corrected(m: ManeuverScore, key: str, deviation: Deviation) -> Array:
    """Return the column without a deviation, in the unit and with the sign of the file."""
    written = m.part.values[key]
    meant = np.array(written)
    meant[np.isfinite(written)] -= deviation.values / to_si(m[key])
    return meant


def _evidence(report: Report, found: _Deviations) -> Iterator[Evidence]:
    """Yield the evidence of deviations, joined if it differs only in maneuver or column."""
    exchanged = _other_maneuvers(report, found)
    yield from (MisplacedManeuver(n, of) for n, of in exchanged.items())
    seen = {place: d.seen for place, d in found.items() if place[0] not in exchanged}
    alike = grouped((_rounded(x), place) for place, x in seen.items())
    keys = [*dict.fromkeys(key for _, key in seen)]

    def rank(where: list[tuple[int, str]]) -> tuple[bool, int]:
        """Rank by column, after the faults that name several columns in one sentence."""
        several = isinstance(seen[where[0]], SmoothedColumns | FilteredColumns)
        return not several, keys.index(where[0][1])

    for where in sorted(alike.values(), key=rank):
        yield _joined([seen[place] for place in where])


def _rounded(evidence: Evidence) -> tuple[object, ...]:
    """Return the parts of evidence that are equal in all maneuvers with the same fault."""
    exact, floats = _fault(evidence)
    return *exact, *(float(f"{x:.5g}") for x in floats)


def _joined(each: Sequence[Evidence]) -> Evidence:
    """Join evidence of the same fault in several maneuvers or columns."""
    (where,) = _WHERE & {f.name for f in fields(each[0])}
    joined: dict[str, Any] = {
        where: tuple(x for evidence in each for x in getattr(evidence, where))
    }
    return replace(each[0], **joined)


def _other_maneuvers(report: Report, found: _Deviations) -> dict[int, int]:
    """Find maneuvers whose wrong columns all contain the values of one other maneuver.

    A single column may have been written to the wrong place, so at least half of the columns must.
    """
    exchanged = {}
    for m in report.maneuvers:
        columns = [c for c in m.compared if c.key in BENCHMARK_COLUMNS]
        wrong = [c.key for c in columns if not is_right_column(c)]
        held = {_maneuver_of(key, found.get((m.maneuver, key))) for key in wrong}
        if len(held) == 1 and 2 * len(wrong) > m.column_count > 1:
            (of,) = held
            if of is not None:
                exchanged[m.maneuver] = of
    return exchanged


def _maneuver_of(key: str, deviation: Deviation | None) -> int | None:
    """Return the other maneuver whose values a column has; None if it has other values."""
    x = deviation and deviation.seen
    return x.of_maneuver if isinstance(x, OtherColumn) and x.other == key else None

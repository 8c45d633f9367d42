"""Find wrong columns while the motion is right: columns of the benchmark, and other columns.

For columns that the benchmark does not define, no program is simulated. There the same number in
every row, a factor and an offset are recognised.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.words import number_in_unit, scale_words
from heyoka_bike.scoring.findings import Finding, Severity, maneuvers, named, together, warning
from heyoka_bike.scoring.grades import TOLERANCE
from heyoka_bike.scoring.judge.own_definitions import far_worse, is_far
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.scaled_columns import Scaled, scaled
from heyoka_bike.scoring.rows.table import ENERGY, PARTS_OF_ENERGY
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore


@dataclass(frozen=True, slots=True)
class NotDiagnosed(Evidence):
    """Columns that the benchmark does not define are wrong, and so are the benchmark's."""

    keys: tuple[str, ...]

    only_describes = True
    code = "not_diagnosed"

    def message(self) -> str:
        return (
            f"Also wrong, but not diagnosed: {named(self.keys)}. Only the benchmark's columns are "
            "diagnosed; correct those first"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}


@dataclass(frozen=True, slots=True)
class ColumnsApart(Evidence):
    """A few columns are wrong, while all other columns are right.

    Attributes
    ----------
    columns : mapping of str to tuple of int
        The maneuvers in which each column is wrong, by its key.
    every
        Number of maneuvers in the file.
    error_of_others
        Largest error of the other columns, relative to the scale.
    fits : mapping of str to Scaled
        The columns that a factor or an offset explains, by key.
    units : mapping of str to str
        Unit of each column, by its key.
    is_sum_with_it
        True if the mechanical energy is wrong only because one of its parts is.
    is_rest
        True if other faults of the file are named beside this.
    """

    columns: Mapping[str, tuple[int, ...]]
    every: int
    error_of_others: float
    fits: Mapping[str, Scaled]
    units: Mapping[str, str]
    is_sum_with_it: bool
    is_rest: bool = False

    code = "columns_apart"
    severity = Severity.WARNING

    def message(self) -> str:
        only = together(
            [
                key if len(numbers) == self.every else f"{key} of {maneuvers(numbers)}"
                for key, numbers in self.columns.items()
            ]
        )
        is_one = len(self.columns) == 1
        scales = "; ".join(
            f"{'it' if is_one else key} is {x.words(self.units[key])}"
            for key, x in self.fits.items()
        )
        start = "Otherwise only" if self.is_rest else "Only"
        are, these = ("is", "this column is") if is_one else ("are", "these columns are")
        of_sum = (
            f". mechanical_energy is wrong only because it contains {only if is_one else 'them'}"
            if self.is_sum_with_it
            else ""
        )
        return (
            f"{start} {only} {are} wrong{scales and ': '}{scales}{of_sum}. All other columns agree "
            f"with the exact motion to within {self.error_of_others:.1g} of their largest values, "
            "so the integrator and the equations are correct. Check how "
            f"{these} computed and written"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {
            "columns": {key: list(numbers) for key, numbers in self.columns.items()},
            "max_rel_error_of_others": self.error_of_others,
            "factors": {key: x.factor for key, x in self.fits.items()},
        }


def columns_apart(report: Report) -> ColumnsApart | None:
    """Find wrong columns, if all other columns show that the motion is right."""
    each = {
        m.maneuver: far_worse(m, [c.key for c in m.columns], _whole_error) for m in report.maneuvers
    }
    apart = {key for keys, _ in each.values() for key in keys}
    if not apart or any(not keys and limit > TOLERANCE for keys, limit in each.values()):
        return None
    # If a part of the energy is wrong, the sum is wrong, too, so the sum is not a further fault.
    is_sum_with_it = ENERGY in apart and not apart.isdisjoint(PARTS_OF_ENERGY)
    if is_sum_with_it:
        apart.remove(ENERGY)
    wrong = {key: places for key, places in report.by_column().items() if key in apart}
    found = {
        key: tuple(
            m.maneuver
            for m, c in places
            if key in each[m.maneuver][0] or is_far(c, each[m.maneuver][1], CLEARLY)
        )
        for key, places in wrong.items()
    }
    fits = {key: fit for key, places in wrong.items() if (fit := scaled([c for _, c in places]))}
    units = {key: places[0][1].unit for key, places in wrong.items()}
    rest = max(limit for _, limit in each.values())
    return ColumnsApart(found, len(each), rest, fits, units, is_sum_with_it)


def _whole_error(c: ColumnScore) -> float:
    """Return the RMS error relative to the RMS of the column, so that a few bad rows count."""
    return rms(c.trace.error) / (rms(c.trace.reference) or 1.0)


@dataclass(frozen=True, slots=True)
class ColumnBeside(Evidence):
    """A column that the benchmark does not define is wrong, while the benchmark's are right.

    Attributes
    ----------
    key
    maneuvers
    unit
    max_rel_error
        Largest error relative to the scale.
    constant : tuple of float
        The number in every row of each maneuver, if the exact values vary; otherwise empty.
    fit : Scaled or None
        Factor and offset that explain the error; None if they do not explain it.
    """

    key: str
    maneuvers: tuple[int, ...]
    unit: str
    max_rel_error: float
    constant: tuple[float, ...] = ()
    fit: Scaled | None = None

    def _finding(self) -> Finding:
        alone = "while the benchmark's columns are right"
        advice = "Check how it is computed and written"
        more: dict[str, object] = {}
        if self.constant:
            numbers = " / ".join(number_in_unit(x, self.unit) for x in dict.fromkeys(self.constant))
            said = f"is {numbers} in every row, {alone}. It was not computed, or not written"
            more = {"constant": list(self.constant)}
        elif self.fit is not None:
            said = f"is {self.fit.words(self.unit)}, {alone}. {advice}"
            more = {"factor": self.fit.factor, "offset": self.fit.offset}
        else:
            said = (
                f"is wrong by up to {scale_words(self.max_rel_error)}, {alone}. "
                f"Neither a factor nor an offset explains it. {advice}"
            )
        where = f"{self.key} of {maneuvers(self.maneuvers)}"
        return warning(
            "column_beside",
            f"{where} {said}",
            column=self.key,
            maneuvers=list(self.maneuvers),
            max_rel_error=self.max_rel_error,
            **more,
        )


def faults_in_other_columns(
    report: Report, left_out: Collection[str] = ()
) -> tuple[ColumnBeside | NotDiagnosed, ...]:
    """Return the evidence of wrong columns that the benchmark does not define.

    Parameters
    ----------
    left_out
        Keys of columns with an unknown definition. They are not assumed to be right, and are
        reported only if a factor or an offset explains them.
    """
    found: list[ColumnBeside | NotDiagnosed] = []
    others = []
    for key, places in report.by_column().items():
        wrong = [(m, c) for m, c in places if not (c.is_right or c.is_hidden)]
        if key in BENCHMARK_COLUMNS or not wrong:
            continue
        if all(_is_alone(m, c, left_out) for m, c in wrong):
            columns = {m.maneuver: c for m, c in wrong}
            found += _isolated_wrong_columns(key, columns, is_unknown=key in left_out)
        elif key not in left_out:
            others.append(key)
    if others:
        found.append(NotDiagnosed(tuple(others)))
    return tuple(found)


def _is_alone(m: ManeuverScore, c: ColumnScore, left_out: Collection[str]) -> bool:
    """True if the benchmark's columns of the maneuver are right, and this column is far off."""
    right = {*BENCHMARK_COLUMNS} - {*left_out}
    limit = max((x.error for x in m.compared if x.key in right), default=1.0)
    return limit < TOLERANCE and is_far(c, limit, CLEARLY)


def _isolated_wrong_columns(
    key: str, columns: Mapping[int, ColumnScore], *, is_unknown: bool
) -> Iterator[ColumnBeside]:
    """Yield the evidence of a column that is wrong while the benchmark's columns are right.

    `columns` has the number of the maneuver as key.
    """
    worst = max(c.error for c in columns.values())
    unit = next(iter(columns.values())).unit
    # The constant values of a column, for maneuvers in which the exact values vary.
    held = [float(c.trace.value[0]) for c in columns.values()
            if not np.ptp(c.trace.value) and np.ptp(c.trace.reference)]  # fmt: skip
    fit = scaled([*columns.values()])
    seen = ColumnBeside(key, tuple(columns), unit, worst)
    if len(held) == len(columns):
        yield replace(seen, constant=tuple(held))
    elif fit:
        yield replace(seen, fit=fit)
    elif not is_unknown:
        yield seen

"""Find wrong columns while the motion is right: columns of the benchmark, and other columns.

For columns that the benchmark does not define, no program is simulated. There the same number in
every row, a factor and an offset are recognised.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.evidence.error_shape import NotDiagnosed
from heyoka_bike.scoring.evidence.output_faults import ColumnBeside, ColumnsApart
from heyoka_bike.scoring.grades import TOLERANCE
from heyoka_bike.scoring.judge.own_definitions import far_worse, is_far
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.scaled_columns import scaled
from heyoka_bike.scoring.rows.table import ENERGY, PARTS_OF_ENERGY
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore


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

"""The row checks that a diagnosis runs before it simulates anything, in this order.

Each row check works on the rows that the checks before it have corrected. So an earlier check may
explain a fault that a later one explains better. A fault of one column seldom needs a check of its
own, see `column_faults`. To add a row check, write the class of its evidence in a module of
`scoring.rows`, and a function that returns the evidence and the corrected rows. Add a line here.
"""

from dataclasses import dataclass
from functools import partial

from heyoka_bike.scoring.diagnosis.step_log import Step, logged
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.bounds import bounded
from heyoka_bike.scoring.rows.deviating_columns import deviating_columns
from heyoka_bike.scoring.rows.grids import coarse_grids, few_bits
from heyoka_bike.scoring.rows.maneuvers import mirrored, reversed_rows, stopped
from heyoka_bike.scoring.rows.other_maneuvers import numbers_of_another_maneuver
from heyoka_bike.scoring.rows.rates import exchanged, own_differences, shifted_rate
from heyoka_bike.scoring.rows.single_rows import single_rows
from heyoka_bike.scoring.rows.sums import own_sum
from heyoka_bike.scoring.rows.table import Check, Undone
from heyoka_bike.scoring.rows.wrong_times import (
    counted_rows,
    late_rows,
    other_clocks,
    other_unit,
    own_times,
)


@dataclass(frozen=True, slots=True)
class RowCheck(Step):
    """A step of the diagnosis that runs one row check.

    Attributes
    ----------
    find : Check
        The function that looks for the fault.
    is_of_motion
        True if the check compares the rows with the exact motion. If the motion in the file is
        wrong, the check is repeated with the simulated motion of the cause instead.
    """

    find: Check
    is_of_motion: bool = False


ROW_CHECKS = (
    RowCheck("unit", "are the times in minutes or hours?", other_unit),
    RowCheck("late", "are all times shifted?", late_rows, is_of_motion=True),
    RowCheck("bits", "are the values single-precision or half-precision numbers?", few_bits),
    RowCheck("grid", "are the values multiples of a step coarser than their digits?", coarse_grids),
    RowCheck("reversed", "is the last row the start of the motion?", reversed_rows),
    RowCheck("single rows", "do single rows repeat the row before?", single_rows),
    RowCheck("stopped", "do the last rows repeat one another?", stopped),
    RowCheck(
        "mirrored", "is a maneuver the exact motion to the other side?", mirrored, is_of_motion=True
    ),
    RowCheck(
        "another maneuver",
        "are the numbers of a column those of another maneuver?",
        numbers_of_another_maneuver,
    ),
    RowCheck("exchanged", "are angles or rates of roll and steer exchanged?", exchanged),
    RowCheck("differences", "is a rate a finite difference of its own angle?", own_differences),
    RowCheck("shifted", "is a rate shifted by a row from its own angle?", shifted_rate),
    RowCheck(
        "counted", "are the rows right at multiples of a step?", counted_rows, is_of_motion=True
    ),
    RowCheck(
        "clock", "are the rows right at scaled or shifted times?", other_clocks, is_of_motion=True
    ),
    RowCheck("rows", "is each row right at a time of its own?", own_times, is_of_motion=True),
    RowCheck(
        "columns",
        "is a column a simple function of the exact values, or of another column?",
        deviating_columns,
        is_of_motion=True,
    ),
    RowCheck("sum", "is a part of the mechanical energy of another row, or multiplied?", own_sum),
    RowCheck("bounds", "does a column stay at a bound?", bounded),
)


def run_check(check: RowCheck, report: Report) -> Undone | None:
    """Run a row check on a report, and log what it finds."""
    with logged(check) as log:
        undone = check.find(report)
        if undone is not None:
            log.found = partial("; ".join, map(str, undone.seen))
    return undone

"""The looks at the rows that a diagnosis takes before it simulates anything, in their order.

To add one, write a function in a module of `scoring.rows` that returns the evidence and the
corrected rows. Add a line here, and the class of its evidence in `scoring.evidence`.
"""

from dataclasses import dataclass
from functools import partial

from heyoka_bike.scoring.diagnosis.step_log import Step, logged
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.column_faults import (
    bounded,
    deviating_columns,
    numbers_of_another_maneuver,
    single_rows,
)
from heyoka_bike.scoring.rows.grids import coarse_grids, few_bits
from heyoka_bike.scoring.rows.maneuvers import mirrored, reversed_rows, stopped
from heyoka_bike.scoring.rows.rates import exchanged, own_differences, shifted_rate
from heyoka_bike.scoring.rows.table import RowCheck, Undone
from heyoka_bike.scoring.rows.wrong_times import (
    counted_rows,
    late_rows,
    one_clock,
    other_clocks,
    other_unit,
    own_times,
)


@dataclass(frozen=True, slots=True)
class Source(Step):
    """A step of the diagnosis that looks for one kind of fault in the rows.

    Attributes
    ----------
    look : RowCheck
    is_of_motion
        True if the look compares the rows with the exact motion. If the file has another motion,
        it is asked again with that motion in its place.
    """

    look: RowCheck
    is_of_motion: bool = False


SOURCES = (
    Source("unit", "are the times in minutes or hours?", other_unit),
    Source("late", "are all times shifted?", late_rows, is_of_motion=True),
    Source("bits", "are the values single-precision or half-precision numbers?", few_bits),
    Source("grid", "are the values multiples of a step coarser than their digits?", coarse_grids),
    Source("reversed", "is the last row the start of the motion?", reversed_rows),
    Source("single rows", "do single rows repeat the row before?", single_rows),
    Source("stopped", "do the last rows repeat one another?", stopped),
    Source(
        "mirrored", "is a maneuver the exact motion to the other side?", mirrored, is_of_motion=True
    ),
    Source(
        "another maneuver",
        "are the numbers of a column those of another maneuver?",
        numbers_of_another_maneuver,
    ),
    Source("exchanged", "are angles or rates of roll and steer exchanged?", exchanged),
    Source("differences", "is a rate a finite difference of its own angle?", own_differences),
    Source("shifted", "is a rate shifted by a row from its own angle?", shifted_rate),
    Source(
        "counted", "are the rows right at multiples of a step?", counted_rows, is_of_motion=True
    ),
    Source(
        "one clock", "are the rows right if all times are scaled?", one_clock, is_of_motion=True
    ),
    Source(
        "clock",
        "are the rows of a maneuver right at scaled or shifted times?",
        other_clocks,
        is_of_motion=True,
    ),
    Source("rows", "is each row right at a time of its own?", own_times, is_of_motion=True),
    Source(
        "columns",
        "is a column exchanged, unsigned, multiplied by a factor, offset, clipped or averaged?",
        deviating_columns,
        is_of_motion=True,
    ),
    Source("bounds", "does a column stay at a bound?", bounded),
)


def looked(source: Source, report: Report) -> Undone | None:
    """Let a source look at a report, and log what it finds."""
    with logged(source) as log:
        undone = source.look(report)
        if undone is not None:
            log.found = partial("; ".join, map(str, undone.seen))
    return undone

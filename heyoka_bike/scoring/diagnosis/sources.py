"""The looks at the rows that a diagnosis takes, in this order, before anything is simulated.

To add one, write a function in a module of `scoring.rows` that returns what it sees and the rows
with that undone. Add a line here, and the class of its evidence in `scoring.evidence`.
"""

from dataclasses import dataclass

from heyoka_bike.scoring.diagnosis.step_log import Step
from heyoka_bike.scoring.rows.column_faults import bounded, deviating_columns, single_rows
from heyoka_bike.scoring.rows.grids import coarse_grids, few_bits
from heyoka_bike.scoring.rows.maneuvers import mirrored, reversed_rows, stopped
from heyoka_bike.scoring.rows.rates import exchanged_with_rate, own_differences, shifted_rate
from heyoka_bike.scoring.rows.table import RowCheck
from heyoka_bike.scoring.rows.wrong_times import (
    counted_rows,
    late_rows,
    one_clock,
    other_clocks,
    other_unit,
)


@dataclass(frozen=True, slots=True)
class Source(Step):
    """A step of the diagnosis that looks at the rows.

    Attributes
    ----------
    look : callable
    """

    look: RowCheck


SOURCES = (
    Source("unit", "are times in minutes or hours?", other_unit),
    Source("late", "are all times shifted?", late_rows),
    Source("bits", "are values of single or half precision?", few_bits),
    Source("grid", "are values on a grid far coarser than their digits?", coarse_grids),
    Source("reversed", "is the last row the start of the motion?", reversed_rows),
    Source("single rows", "do single rows repeat the row before?", single_rows),
    Source("stopped", "do the last rows repeat one another?", stopped),
    Source("mirrored", "does a maneuver begin to the other side?", mirrored),
    Source("exchanged", "are an angle and its rate in each other's place?", exchanged_with_rate),
    Source("differences", "is a rate the difference of its own angle?", own_differences),
    Source("shifted", "is a rate that of another row?", shifted_rate),
    Source("counted", "are the rows right at multiples of a step?", counted_rows),
    Source("one clock", "are the rows right at times on another scale?", one_clock),
    Source("clock", "are the rows of a maneuver the right ones of other times?", other_clocks),
    Source(
        "columns",
        "is a column another one, or the right one without its sign, times a ratio, with another "
        "zero, bounded or averaged?",
        deviating_columns,
    ),
    Source("bounds", "does a column stay at a bound?", bounded),
)

"""Names that are like a known one: the message says what they may mean.

Nothing depends on it: a file is whole if it has all eight columns, whatever else it has. A name
that is misspelt is told always. One that only holds a known word is told if no other column of the
maneuver gives this quantity: beside one, ``roll_angle_setpoint`` has a meaning of its own.
"""

from collections.abc import Iterator

from heyoka_bike.scoring.evidence.as_read import NotCompared, Reason
from heyoka_bike.scoring.evidence.base import LostColumn
from heyoka_bike.scoring.reading.names.words import ALMOST, NAMES_SPELT, nearest
from heyoka_bike.scoring.report import Report


def names_not_understood(report: Report) -> Iterator[NotCompared]:
    """Columns of unknown names that are like those of quantities."""
    compared = {(m.maneuver, c.key) for m in report.maneuvers for c in m.columns}

    def is_missing(column: LostColumn) -> bool:
        numbers = [column.maneuver] if column.maneuver in report else report
        return any((number, column.key) not in compared for number in numbers)

    for evidence in report.seen:
        if not isinstance(evidence, NotCompared) or evidence.reason != Reason.UNKNOWN_NAME:
            continue
        columns = tuple(
            column
            for i, column in enumerate(evidence.columns)
            if column.key is not None
            and (is_missing(column) or (i < NAMES_SPELT and nearest(column.name, ALMOST)))
        )
        if columns:
            reason = Reason.NOT_UNDERSTOOD
            how = evidence.how_to_tell
            yield NotCompared(reason, columns, how, file=evidence.file)

"""Unknown names that resemble a known one: the message suggests what they may mean.

The verdict does not depend on these names: a file is whole if it has all eight columns. A misspelt
name is always reported. A name that only contains a known word is reported if no other column of
the maneuver has this quantity. In a file with ``roll_angle``, for example, ``roll_angle_setpoint``
is another quantity.
"""

from collections.abc import Iterator

from heyoka_bike.scoring.evidence.as_read import NotCompared, Reason
from heyoka_bike.scoring.evidence.base import LostColumn
from heyoka_bike.scoring.reading.names.suggestions import ALMOST, NAMES_SPELT, nearest
from heyoka_bike.scoring.report import Report


def names_not_understood(report: Report) -> Iterator[NotCompared]:
    """Yield evidence of columns whose unknown names resemble those of quantities."""
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
            how = evidence.columns_hint
            yield NotCompared(reason, columns, how, file=evidence.file)

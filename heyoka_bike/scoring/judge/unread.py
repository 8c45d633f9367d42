"""Names that hold a known one: columns of the result that were not compared for their names.

A column such as ``field.forward_speed`` or ``roll_rate [\u00ba/s]`` is not understood, and yet its
name holds that of a quantity. If no other column gives this quantity, the file has it, and it was
not compared. Beside a column that is compared, such a name has a meaning of its own: a set point of
the roll angle, the error of the steer angle. Which names hold a known one is told where names are
read, see `reading`.
"""

from collections.abc import Iterator

from heyoka_bike.scoring.evidence import NotCompared, Reason
from heyoka_bike.scoring.report import Report


def names_not_understood(report: Report) -> Iterator[NotCompared]:
    """Columns of unknown names that hold a quantity that no other column of the maneuver gives."""
    compared = {(m.maneuver, c.key) for m in report.maneuvers for c in m.columns}
    for evidence in report.seen:
        if not isinstance(evidence, NotCompared) or evidence.reason != Reason.UNKNOWN_NAME:
            continue
        columns = tuple(
            column
            for column in evidence.columns
            if column.key is not None
            and any(
                (number, column.key) not in compared
                for number in ([column.maneuver] if column.maneuver in report else report)
            )
        )
        if columns:
            reason = Reason.NOT_UNDERSTOOD
            how = evidence.how_to_tell
            yield NotCompared(reason, columns, how, file=evidence.file)

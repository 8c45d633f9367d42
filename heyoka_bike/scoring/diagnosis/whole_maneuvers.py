"""Whole maneuvers that are not as meant: one that ended early, or goes to the other side."""

from __future__ import annotations

from dataclasses import replace

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.diagnosis.as_meant import AsMeant
from heyoka_bike.scoring.diagnosis.plain import standing_still
from heyoka_bike.scoring.evidence.output_faults import Mirrored
from heyoka_bike.scoring.grades import RIGHT
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ManeuverScore


def stopped(report: Report) -> AsMeant | None:
    """Maneuvers whose last rows repeat one another in all columns: the motion ended before them."""
    ended = {x.maneuver: x for x in standing_still(report.maneuvers) if x.are_all}
    if not ended:
        return None
    parts = (
        m.part.at(slice(m.rows - ended[m.maneuver].rows + 1)) if m.maneuver in ended else m.part
        for m in report.maneuvers
    )
    return AsMeant(tuple(ended.values()), tuple(parts))


def mirrored(report: Report) -> AsMeant | None:
    """Maneuvers whose columns of roll and steer are all turned round, beside others that are not.

    That is the right motion of a start to the other side, which has the same speed and energies.
    """
    turned = [m for m in report.maneuvers if _is_mirrored(m)]
    if not turned or len(turned) == len(report.maneuvers):
        return None
    numbers = tuple(m.maneuver for m in turned)
    parts = (_turned(m.part) if m in turned else m.part for m in report.maneuvers)
    return AsMeant((Mirrored(numbers),), tuple(parts))


def _is_mirrored(m: ManeuverScore) -> bool:
    lateral = [c for c in m.columns if c.key in LATERAL and c.values]
    return len(lateral) > 1 and all(
        rms(c.trace.value + c.trace.reference) < RIGHT * rms(c.trace.reference) for c in lateral
    )


def _turned(part: Part) -> Part:
    """The rows with the other sign in the columns of roll and steer."""
    values = {key: -x if key in LATERAL else x for key, x in part.values.items()}
    lo = {key: -x if key in LATERAL else x for key, x in part.lo.items()}
    return replace(part, values=values, lo=lo)

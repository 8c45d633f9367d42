"""Coverage: parts of the run without rows."""

from collections.abc import Iterator

from heyoka_bike.scoring.evidence.contradictions import CoveredInPart
from heyoka_bike.scoring.report import Report


def covered_in_part(report: Report) -> Iterator[CoveredInPart]:
    """Yield evidence of missing rows, once for all maneuvers with the same rows."""
    reported = set()
    for m in report.maneuvers:
        duration = float(m.part.reference.duration)
        slack = 1.5 * (m.step or 0.0) / duration
        ends = (m.t_start, m.t_end, m.gap)
        if ends in reported or (m.coverage and m.coverage + 2 * slack >= 1.0):
            continue
        reported.add(ends)
        which = (n.maneuver for n in report.maneuvers if (n.t_start, n.t_end, n.gap) == ends)
        has_holes = m.coverage < (m.t_end - m.t_start) / duration - slack or not m.coverage
        yield CoveredInPart(tuple(which), *ends, has_holes=has_holes)

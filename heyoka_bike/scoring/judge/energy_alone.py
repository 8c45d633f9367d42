"""Energy alone: a motion that is visibly wrong may meet eq. (1)."""

from collections.abc import Iterator

from heyoka_bike.scoring.evidence.contradictions import VISIBLE, EnergyHidesError
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.verdict import claim


def errors_hidden(report: Report) -> Iterator[EnergyHidesError]:
    """Yield maneuvers that meet the limit of eq. (1), although a column is visibly wrong."""
    # The benchmark judges some maneuvers with eq. (1), each with a limit. For other maneuvers, use
    # the smallest of these limits.
    limits = [m.performance_limit for m in report.maneuvers if m.performance_limit is not None]
    hidden = {}
    for m in report.maneuvers:
        limit = m.performance_limit or min(limits, default=None)
        if m.performance is None or limit is None or claim(m, limit).value >= limit:
            continue
        wrong = {c.key: c.error for c in m.columns if c.is_known and not c.is_hidden}
        key = max(wrong, key=wrong.__getitem__, default="")
        worst = wrong.get(key, 0.0)
        # If the energy is visibly wrong itself, it does not hide the error.
        if worst > VISIBLE and wrong.get("mechanical_energy", 0.0) < VISIBLE:
            hidden[m.maneuver] = worst, key, m.performance
    if hidden:
        # Among equal errors, take the first, as `Report.worst` does.
        number = max(hidden, key=lambda n: hidden[n][0])
        worst, key, performance = hidden[number]
        yield EnergyHidesError(tuple(hidden), number, key, worst, performance)

"""The energy alone: eq. (1) may be met by a motion that is visibly wrong."""

from collections.abc import Iterator

from heyoka_bike.scoring.evidence.contradictions import EnergyHidesError
from heyoka_bike.scoring.grades import FLOORS_OF_ROUNDING
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.verdict import claim

VISIBLE = 1e-2
"""Of the scale: an error that is seen in a plot; the benchmark's measure may miss it."""


def errors_hidden(report: Report) -> Iterator[EnergyHidesError]:
    """Maneuvers within the limit of eq. (1), although something else of them is visibly wrong."""
    # A maneuver that is not judged is held against the limit of one that is.
    limits = [m.performance_limit for m in report.maneuvers if m.performance_limit is not None]
    hidden = {}
    for m in report.maneuvers:
        limit = m.performance_limit or min(limits, default=None)
        if m.performance is None or limit is None or claim(m, limit).value >= limit:
            continue
        wrong = {
            c.key: c.max_rel_error or 0.0
            for c in m.columns
            if c.is_known and not c.is_at_floor(FLOORS_OF_ROUNDING)
        }
        key = max(wrong, key=wrong.__getitem__, default="")
        worst = wrong.get(key, 0.0)
        # Where the energy itself is wrong, it shows the error, but eq. (1) does not ask for it.
        if worst > VISIBLE and wrong.get("mechanical_energy", 0.0) < VISIBLE:
            hidden[m.maneuver] = worst, key, m.performance
    if hidden:
        number = max(hidden, key=hidden.__getitem__)
        worst, key, performance = hidden[number]
        yield EnergyHidesError(tuple(hidden), number, key, worst, performance)

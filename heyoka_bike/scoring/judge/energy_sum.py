"""Sum of the energies: whether potential plus kinetic energy equals the mechanical energy."""

from collections.abc import Iterator, Mapping

import numpy as np

from heyoka_bike.numbers.double import two_sum
from heyoka_bike.scoring.evidence.contradictions import EnergySum
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS
from heyoka_bike.scoring.measures import MAX_EXACT_VALUES
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore


def energies_apart(report: Report) -> Iterator[EnergySum]:
    """Yield maneuvers whose energies do not add up, by more than rounding explains."""
    apart = {
        m.maneuver: (c.energy_sum, c.energy_sum_floor)
        for m in report.maneuvers
        if (c := m.consistency).energy_sum is not None
        and c.energy_sum_floor is not None
        and c.energy_sum > MAX_ROUNDING_FLOORS * c.energy_sum_floor
    }
    if apart:
        yield EnergySum(tuple(apart), *max(apart.values()))


def energy_sum(
    columns: Mapping[str, ColumnScore], *, has_rest: bool
) -> tuple[float | None, float | None]:
    """Return the largest error of the sum, and the part of it that rounding explains [J]."""
    keys = ("potential_energy", "kinetic_energy", "mechanical_energy")
    if not all(key in columns for key in keys):
        return None, None
    traces = [columns[key].trace for key in keys]
    if has_rest:
        # The values have more digits than binary64, so compare their errors. The energies of the
        # reference add up exactly, so the errors must add up, too.
        difference = traces[0].error + traces[1].error - traces[2].error
    else:
        total, rest = two_sum(traces[0].value, traces[1].value)
        difference = (total - traces[2].value) + rest
    floors = [columns[key].floor for key in keys]
    floor = None if None in floors else float(sum(f for f in floors if f is not None))
    if has_rest and floor is not None:
        # The reference is accurate to 1e-31 of its scale, as the bounds of the dense output show.
        floor += 1e-30 * float(np.max(np.abs(traces[2].value)))
        # Errors are accurate to binary64. If there are more than `MAX_EXACT_VALUES` values, errors
        # are accurate only to 1e-15 of the scale.
        floor += sum(1e-15 * float(np.max(np.abs(t.error))) for t in traces)
        if len(traces[0].time) * len(columns) > MAX_EXACT_VALUES:
            floor += sum(2e-15 * float(np.max(np.abs(t.value))) for t in traces)
    return float(np.max(np.abs(difference))), floor

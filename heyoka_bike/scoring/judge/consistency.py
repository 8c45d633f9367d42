"""Agreement of a file with itself, whatever its distance from the reference."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from heyoka_bike.bicycle.columns import RATE_OF
from heyoka_bike.numbers.double import median, two_sum
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.comparison import FEW
from heyoka_bike.scoring.findings import Finding, maneuvers, warning
from heyoka_bike.scoring.measures import TOLERANCE, rms
from heyoka_bike.scoring.report import Consistency, Report
from heyoka_bike.scoring.verdict import SUM_ROUNDING

# The angle's own error must explain less than this part of what its rate is wrong by: an error of
# the integrator moves both alike, differences of a good angle do not.
_MUCH_BETTER = 1 / 3
# Rounding of neighbouring values explains this many times the floors.
_ROUNDED = 3.0
# Rows farther apart than this [s] do not show the derivative: the fastest mode decays in 0.05 s.
_WIDEST = 0.05


def consistency(part: Part, columns: Sequence[ColumnScore]) -> Consistency:
    """Sum of the energies, and rates against the derivatives of their own angles."""
    by_key = {c.key: c for c in columns if c.values and not c.missing}
    total, floor = _energy_sum(by_key, has_rest=any("energy" in key for key in part.lo))
    found = {key: _rate(part.reference, by_key, key) for key in ("roll_rate", "steer_rate")}
    return Consistency(
        energy_sum=total,
        energy_sum_floor=floor,
        roll_rate=found["roll_rate"][0],
        steer_rate=found["steer_rate"][0],
        contradicted=tuple(key for key, (_, is_contradicted) in found.items() if is_contradicted),
    )


def against_itself(report: Report) -> Iterator[Finding]:
    """Energies that do not add up, and rates that are visibly not those of their own angles."""
    apart = {
        m.maneuver: (c.energy_sum, c.energy_sum_floor)
        for m in report.maneuvers
        if (c := m.consistency).energy_sum is not None
        and c.energy_sum_floor is not None
        and c.energy_sum > SUM_ROUNDING * c.energy_sum_floor
    }
    if apart:
        total, floor = max(apart.values())
        said = (
            f"{maneuvers(apart)}: potential plus kinetic energy differs from the mechanical energy "
            f"by up to {total:.2g} J; rounding explains {floor:.2g} J"
        )
        yield warning("energy_sum", said, maneuvers=[*apart], energy_sum=total, floor=floor)
    for key in ("roll_rate", "steer_rate"):
        off = {
            m.maneuver: x
            for m in report.maneuvers
            if key in m.consistency.contradicted
            and (x := getattr(m.consistency, key))
            > TOLERANCE * float(abs(m[key].trace.reference).max())
        }
        if off:
            most = max(off.values())
            said = (
                f"{maneuvers(off)}: {key} is not the derivative of its own angle, which is much "
                f"better than it: up to {most:.2g} rad/s apart (root mean square)"
            )
            evidence = {"maneuvers": [*off], "column": key, "rms_difference": most}
            yield warning("rate_is_not_the_derivative", said, **evidence)


def _energy_sum(
    columns: Mapping[str, ColumnScore], *, has_rest: bool
) -> tuple[float | None, float | None]:
    """Largest difference of the sum, and what rounding explains of it [J]."""
    keys = ("potential_energy", "kinetic_energy", "mechanical_energy")
    if not all(key in columns for key in keys):
        return None, None
    traces = [columns[key].trace for key in keys]
    if has_rest:
        # Values of more digits than binary64: the reference adds up, so their errors have to.
        difference = traces[0].error + traces[1].error - traces[2].error
    else:
        total, rest = two_sum(traces[0].value, traces[1].value)
        difference = (total - traces[2].value) + rest
    floors = [columns[key].floor for key in keys]
    floor = None if None in floors else float(sum(f for f in floors if f is not None))
    if has_rest and floor is not None:
        # The reference itself is known to 1e-31 of its scale, see the dense bounds.
        floor += 1e-30 * float(np.max(np.abs(traces[2].value)))
        # Errors are known to binary64, those of very many rows to 1e-15 of the scale.
        floor += sum(1e-15 * float(np.max(np.abs(t.error))) for t in traces)
        if len(traces[0].time) * len(columns) > FEW:
            floor += sum(2e-15 * float(np.max(np.abs(t.value))) for t in traces)
    return float(np.max(np.abs(difference))), floor


def _rate(
    reference: ReferenceManeuver, columns: Mapping[str, ColumnScore], key: str
) -> tuple[float | None, bool]:
    """Difference of a rate from the derivative of its angle over a step, rms [rad/s].

    Returned with whether the rate is to blame: the difference is more than rounding and much more
    than what the angle's own error amounts to.

    The reference's own rate and angle agree, so it is enough to look at the errors, which are
    small and smooth: over a step, the increase of the angle's error should be the integral of the
    rate's error, taken by the trapezoidal rule.
    """
    if key not in columns:
        return None, False
    rate = columns[key]
    pair = RATE_OF.get((key, rate.as_understood.definition))
    angle = columns.get(pair[0]) if pair else None
    if pair is None or angle is None or angle.as_understood.definition != pair[1]:
        return None, False
    t = rate.trace.time
    step = np.diff(t)
    usual = float(median(step)) if len(step) else 0.0
    if not 0.0 < usual <= _WIDEST:
        return None, False
    # Repeated times and event steps have no step to speak of.
    near = (step > usual / 10) & (step <= _WIDEST)
    with np.errstate(over="ignore"):
        slope = np.diff(angle.trace.error)[near] / step[near]
    if not np.isfinite(slope).all():
        return None, False
    mean = (rate.trace.error[1:] + rate.trace.error[:-1])[near] / 2
    found = rms(slope - mean)
    if _distance_left_open(reference, rate, angle) > found / 2:
        return None, False
    rounding = 2**0.5 * (angle.floor or 0.0) / usual + (rate.floor or 0.0)
    return found, found > _ROUNDED * rounding and rms(slope) < _MUCH_BETTER * found


def _distance_left_open(
    reference: ReferenceManeuver, rate: ColumnScore, angle: ColumnScore
) -> float:
    """Return the distance of the rates that the two columns may honestly mean, rms [rad/s]."""
    names = {c.definition: c.name for c in reference.definitions[rate.key]}
    angles = {(angle.key, other) for other in angle.indistinguishable}
    meant = list(rate.indistinguishable)
    # A set may have an angle and not its rate.
    meant += [d for (_, d), of in RATE_OF.items() if of in angles and d in names]
    own = names[rate.as_understood.definition]
    rows = reference.approximate(reference.time, [own, *(names[d] for d in meant)])
    return max((rms(rows[names[other]] - rows[own]) for other in meant), default=0.0)

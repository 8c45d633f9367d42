"""Numerical causes, where no mistake of the model explains a file: what its error looks like."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR
from heyoka_bike.scoring.diagnosis.beginnings import beginnings
from heyoka_bike.scoring.diagnosis.energies import of_energy
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS
from heyoka_bike.scoring.diagnosis.residual.observed import STATE_KEYS
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.error_shape import (
    BeginsAs,
    BlownUp,
    EnergyKept,
    EnergyVaries,
    ErrorOfRounding,
    IterationNoise,
    RoughError,
    SinglePrecisionBeside,
    SmoothError,
    StepRinging,
    TooFar,
    TooFewRows,
)
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, TOLERANCE, has_right_digits
from heyoka_bike.scoring.judge.precision import single_precision
from heyoka_bike.scoring.measures import ROUNDING
from heyoka_bike.scoring.noise import FEWEST_ROWS, Roughness, roughness
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore

# Parts of the error: what shows at all, and what noise of iterations must be; Exudyn's with tight
# ones is below 2e-4, with loose ones above 5e-3.
_SMALLEST_TOLD = 1e-4
_NOISE = 2e-3
# Correlation one and two rows on, of what alternates.
_ALTERNATING_PART = 0.95
# More than this part of the error is noise where all of it jumps.
_PART_OF_ROWS_ROUGH = 0.3
_FIFTHS = 5


class _Rough(NamedTuple):
    """What jumps in a column's error, in parts of the error and of the column's scale."""

    part: float
    size: float
    shape: Roughness


def causes(report: Report) -> tuple[Evidence, ...]:
    """Return the numerical causes of the error; at least that it is smooth."""
    columns = [(c.error, m, c) for m in report.maneuvers for c in m.columns]
    far = [error > MEANINGLESS_ERROR for error, _, c in columns if c.values]
    if 2 * sum(far) >= len(far):
        return (TooFar(),)
    worst, m, c = max(columns, key=lambda x: x[0])
    if worst * min(c.scale / _size(c), 1.0) > CLEARLY:
        first = np.argmax(np.abs(c.trace.error) > 0.5 * np.max(np.abs(c.trace.reference)))
        return (BlownUp(m.maneuver, c.key, float(c.trace.time[first]), worst),)
    if worst < ROUNDING:
        return (ErrorOfRounding(worst),)
    single = next(single_precision(report), None)
    # Single precision was seen to leave 1e-5 of a run with steps of 0.01 s, 9e-5 with 0.001 s.
    if single is not None and worst < TOLERANCE:
        return (single,)
    if max(m.rows for m in report.maneuvers) < MIN_ROWS_FOR_SHAPE:
        return (TooFewRows(),)
    there = report.by_column()
    missing = tuple(key for key in STATE_KEYS if key not in there)
    # What is left below this part needs no cause.
    rough = tuple(_rough(report)) if worst > THRESHOLDS.negligible_error else ()
    if has_right_digits(worst):
        # A multistep method that changes its order jumps, too, and iterates as it should.
        rough = tuple(x for x in rough if not isinstance(x, IterationNoise))
    found = (*described(report), *rough)
    if all(isinstance(x, BeginsAs | EnergyVaries | EnergyKept) for x in found):
        # As an integrator's error may be, too.
        found = (*found, SmoothError(missing))
    return found if single is None else (*found, SinglePrecisionBeside(single))


def described(report: Report) -> tuple[Evidence, ...]:
    """What the file shows of forces by itself: it rests on no search."""
    return (*beginnings(report), *of_energy(report))


def _size(c: ColumnScore) -> float:
    """What a column of a bicycle that has not fallen stays below, or the scale if that is more.

    An angle or rate of a maneuver that hardly turns may well be off by many times its scale.
    """
    return max(c.scale, 1.0) if c.unit in ("rad", "rad s-1") else c.scale


def _rough(report: Report) -> Iterator[RoughError | StepRinging | IterationNoise]:
    """Yield what an error shows that jumps from row to row: iterations, or noise."""
    found = {(m.maneuver, c.key): _roughness(c) for m in report.maneuvers for c in m.columns}
    jumping = {
        place: r
        for place, r in found.items()
        if r is not None and r.shape.at_one < MEANINGLESS_ERROR and r.part > _SMALLEST_TOLD
    }
    numbers = [m.maneuver for m in report.maneuvers]
    noisy = {place: r for place, r in jumping.items() if r.shape.is_white}
    wholly = [r for r in noisy.values() if r.part > _PART_OF_ROWS_ROUGH]
    in_rates = [n for n in numbers if _in_rates(n, jumping)]
    ringing = [n for n in numbers if _rings(n, jumping)]
    if len(wholly) > len(found) / 2:
        yield RoughError(tuple(f"{number}.{key}" for number, key in jumping), are_all=True)
    elif 2 * len(ringing) > len(numbers):
        yield StepRinging(tuple(ringing))
    elif 2 * len(in_rates) > len(numbers):
        yield IterationNoise(tuple(in_rates))
    # A multistep method that changes its order jumps, too, by less than its error.
    elif large := [place for place, r in noisy.items() if r.size > TOLERANCE]:
        yield RoughError(tuple(f"{number}.{key}" for number, key in large), are_all=False)


def _in_rates(number: int, jumping: Mapping[tuple[int, str], _Rough]) -> bool:
    """True if both rates of a maneuver jump, much more than their angles."""
    for kind in ("roll", "steer"):
        angle, rate = (jumping.get((number, f"{kind}_{x}")) for x in ("angle", "rate"))
        if rate is None or rate.shape.at_one >= 0 or rate.part < _NOISE:
            return False
        # Noise of velocities hardly shows in the angles, their integrals; that of output does.
        if angle is not None and rate.part < CLEARLY * angle.part:
            return False
    return True


def _rings(number: int, jumping: Mapping[tuple[int, str], _Rough]) -> bool:
    """True if the steer rate of a maneuver alternates from row to row."""
    rate = jumping.get((number, "steer_rate"))
    if rate is None:
        return False
    return min(-rate.shape.at_one, rate.shape.at_two) > _ALTERNATING_PART


def _roughness(c: ColumnScore) -> _Rough | None:
    """Return the roughness of a column's error; None if it is not above the digits written."""
    if c.values < FEWEST_ROWS:
        return None
    found = roughness(c.trace.error, _FIFTHS)
    spread = float(np.std(c.trace.error))
    if found.size <= CLEARLY * (c.floor or 0.0) or not spread:
        return None
    return _Rough(found.size / spread, found.size / (c.scale or 1.0), found)
